// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/surface_division.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace ppc {
namespace {

constexpr int kRounds = 8;
constexpr double kNeighbour = SurfaceDivision::kEdge;  // chi-square by which a neighbour speaks for its side
constexpr double kPatch = 15.0;                        // that a patch must gain by lying apart
constexpr float kLevel = 3.0F;  // of the misfits around a cell over the root of their weights: 1.9 standard deviations

// A plane over the places of a region, as an offset from the region's own.
struct SurfacePlane {
  double level = 0.0, along_u = 0.0, along_v = 0.0;
  double gain = 0.0;  // chi-square that it takes off

  explicit SurfacePlane(const SurfaceSums& s) {
    constexpr double kRidge = 1e-6;
    const double w = s.places[1], u = s.places[2], v = s.places[3], mean = s.misfits[0] / w;
    const double ridge = kRidge * (s.squares[0] + s.squares[2]);
    const double uu = s.squares[0] - u * u / w + ridge, uv = s.squares[1] - u * v / w, vv = s.squares[2] - v * v / w + ridge;
    const double eu = s.misfits[1] - mean * u, ev = s.misfits[2] - mean * v, determinant = uu * vv - uv * uv;
    if (determinant > 0.0) {
      along_u = (vv * eu - uv * ev) / determinant;
      along_v = (uu * ev - uv * eu) / determinant;
    }
    level = mean - (along_u * u + along_v * v) / w;
    gain = s.misfits[0] * mean + along_u * eu + along_v * ev;
  }

  // Chi-square of a cell on this plane less that on the region's.
  double costOf(const SurfaceSums& s) const {
    return level * (level * s.places[1] + 2.0 * (along_u * s.places[2] + along_v * s.places[3] - s.misfits[0])) +
           along_u * (along_u * s.squares[0] + 2.0 * (along_v * s.squares[1] - s.misfits[1])) +
           along_v * (along_v * s.squares[2] - 2.0 * s.misfits[2]);
  }
};

class Divider {
 public:
  Divider(const std::vector<SurfaceCell>& cells, const SurfaceLinks& links, double fewest, DivisionMemory& memory)
      : cells_(cells), links_(links), fewest_(fewest), memory_(memory), side_(memory.side) {
    side_.resize(cells.size());
  }

  // From a start: whether each cell lies beyond, f(i). Keeps the division if its score is the best so far.
  template <typename F>
  void divide(const F& f, SurfaceDivision& best) {
    for (std::size_t i = 0; i < side_.size(); ++i) side_[i] = f(i) ? 1 : 0;
    bool changes = true;
    for (int round = 0; round < kRounds && changes; ++round) {
      if (!sumSides()) return;
      const SurfacePlane near(near_), beyond(beyond_);
      changes = assignCells(near, beyond);
      if (round + 1 == kRounds) {
        while (joinPatches(near, beyond)) {  // each time fewer are apart
        }
      } else if (!changes) {
        changes = joinPatches(near, beyond);
      }
    }
    if (!sumSides()) return;
    int border = 0;
    for (int i = 0; i < size(); ++i) border += othersAround(i);
    SurfaceDivision found{SurfacePlane(near_).gain + SurfacePlane(beyond_).gain, border / 2, {}};
    if (!best.beyond.empty() && !(found.score() > best.score())) return;
    best.gain = found.gain;
    best.border = found.border;
    best.beyond = side_;
  }

 private:
  int size() const { return static_cast<int>(side_.size()); }
  const int* linksOf(int i) const { return links_.cells.data() + links_.begin[i]; }
  const int* linksEnd(int i) const { return links_.cells.data() + links_.begin[i + 1]; }
  int othersAround(int i) const {
    return static_cast<int>(std::count_if(linksOf(i), linksEnd(i), [&](int j) { return side_[j] != side_[i]; }));
  }

  // Whether both sides have enough points.
  bool sumSides() {
    near_ = beyond_ = SurfaceSums();
    for (std::size_t i = 0; i < side_.size(); ++i) (side_[i] != 0 ? beyond_ : near_) += cells_[i].sums;
    return std::min(near_.points(), beyond_.points()) >= fewest_;
  }

  // What a cell loses by lying beyond.
  double lossOf(int i, const SurfacePlane& near, const SurfacePlane& beyond) const {
    return beyond.costOf(cells_[i].sums) - near.costOf(cells_[i].sums);
  }

  // Whether any goes over.
  bool assignCells(const SurfacePlane& near, const SurfacePlane& beyond) {
    bool changes = false;
    for (int i = 0; i < size(); ++i) {
      int votes = 0;
      for (const int* j = linksOf(i); j != linksEnd(i); ++j) votes += side_[*j] != 0 ? 1 : -1;
      const char side = lossOf(i, near, beyond) < kNeighbour * votes ? 1 : 0;
      changes = changes || side != side_[i];
      side_[i] = side;
    }
    return changes;
  }

  // Whether any patch but the largest of each side goes over.
  bool joinPatches(const SurfacePlane& near, const SurfacePlane& beyond) {
    listPatches();
    const std::vector<int>&begin = memory_.patch_begin, &members = memory_.members;
    const int count = static_cast<int>(begin.size()) - 1;
    std::array<int, 2> largest = {-1, -1};
    std::array<float, 2> most = {-1.0F, -1.0F};
    for (int k = 0; k < count; ++k) {
      float points = 0.0F;
      for (int m = begin[k]; m < begin[k + 1]; ++m) points += cells_[members[m]].sums.points();
      const auto side = static_cast<std::size_t>(side_[members[begin[k]]]);
      if (points > most[side]) {
        most[side] = points;
        largest[side] = k;
      }
    }
    bool changes = false;
    for (int k = 0; k < count; ++k) {
      if (k == largest[0] || k == largest[1]) continue;
      const char side = side_[members[begin[k]]];
      double stays = 0.0;       // what it gains by staying
      int around = 0, own = 0;  // links to others, and to those of its side: what was around it may have gone over
      for (int m = begin[k]; m < begin[k + 1]; ++m) {
        const int i = members[m];
        stays += (side != 0 ? -1.0 : 1.0) * lossOf(i, near, beyond);
        for (const int* j = linksOf(i); j != linksEnd(i); ++j) {
          if (memory_.patch[*j] == k) continue;
          ++around;
          own += side_[*j] == side ? 1 : 0;
        }
      }
      stays -= kNeighbour * around;
      if (around == 0 || own > 0 || stays >= kPatch) continue;
      for (int m = begin[k]; m < begin[k + 1]; ++m) side_[members[m]] = side != 0 ? 0 : 1;
      changes = true;
    }
    return changes;
  }

  // Connected patches of cells on one side.
  void listPatches() {
    std::vector<int>&patch = memory_.patch, &members = memory_.members, &begin = memory_.patch_begin;
    patch.assign(side_.size(), -1);
    members.clear();
    begin.clear();
    for (int first = 0; first < size(); ++first) {
      if (patch[first] >= 0) continue;
      const int k = static_cast<int>(begin.size());
      begin.push_back(static_cast<int>(members.size()));
      patch[first] = k;
      members.push_back(first);
      for (std::size_t m = begin[k]; m < members.size(); ++m) {
        const int i = members[m];
        for (const int* j = linksOf(i); j != linksEnd(i); ++j) {
          if (patch[*j] >= 0 || side_[*j] != side_[first]) continue;
          patch[*j] = k;
          members.push_back(*j);
        }
      }
    }
    begin.push_back(static_cast<int>(members.size()));
  }

  const std::vector<SurfaceCell>& cells_;
  const SurfaceLinks& links_;
  double fewest_;
  DivisionMemory& memory_;
  std::vector<char>& side_;
  SurfaceSums near_, beyond_;
};

// Sums of what each cell and those around it have.
void sumAround(const SurfaceLinks& links, const std::vector<float>& of, std::vector<float>& sums) {
  sums = of;
  for (std::size_t i = 0; i < of.size(); ++i) {
    for (int k = links.begin[i]; k < links.begin[i + 1]; ++k) sums[i] += of[links.cells[k]];
  }
}

}  // namespace

void divideSurface(const std::vector<SurfaceCell>& cells, const SurfaceLinks& links, const SurfaceCut& cut, double fewest,
                   DivisionMemory& memory, SurfaceDivision& division) {
  division.gain = 0.0;
  division.border = 0;
  division.beyond.clear();
  memory.misfits.clear();
  memory.weights.clear();
  for (const SurfaceCell& cell : cells) {
    memory.misfits.push_back(cell.sums.misfits[0]);
    memory.weights.push_back(cell.sums.places[1]);
  }
  for (std::vector<float>* of : {&memory.misfits, &memory.weights}) {  // twice, which reaches two cells about
    sumAround(links, *of, memory.sums);
    sumAround(links, memory.sums, *of);
  }
  Divider divider(cells, links, fewest, memory);
  const auto level = [&](std::size_t i) { return memory.misfits[i] / std::sqrt(std::max(memory.weights[i], 1e-9F)); };
  divider.divide([&](std::size_t i) { return cut.isBeyond(cells[i]); }, division);
  divider.divide([&](std::size_t i) { return level(i) > kLevel; }, division);
  divider.divide([&](std::size_t i) { return level(i) < -kLevel; }, division);
}

}  // namespace ppc
