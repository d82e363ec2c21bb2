// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_splitting.h"

#include "patch_plane_clustering/core/parallel.h"
#include "patch_plane_clustering/core/whole_tolerance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace ppc {
namespace {

constexpr int kFewestCells = 12, kManyCells = 300;
// Of labels of many cells, as nothing but a low step is swallowed by so much, and what bends stays whole: chi-square of a
// point, on average, above which they are looked at, gain of a cut over that of a quadratic surface, and the least cosine
// between both sides.
constexpr double kLargeMisfit = 1.03, kLargeGain = 1.4, kLargeParallel = 0.998;
constexpr double kSignificance = 30.0;  // of a cut, over one plane and one quadratic surface: far beyond chi-square
constexpr double kMinMisfit = 0.5;      // of both sides on one plane
constexpr double kNoise = 3.3;          // standard deviations of chi-square that noise alone may leave
constexpr double kMostLeft = 3.0;       // beyond noise, over what two planes explain, where there may be a third one
constexpr double kMinSide = 0.25;       // points of a side over those of a region, as in the second pass

using Place = LabelSplitMemory::Place;
using Part = LabelSplitMemory::Part;
using Side = LabelSplitMemory::Side;
using Split = LabelSplitMemory::Split;
using Surface = std::vector<SurfaceCell>;

class LabelSplitter {
 public:
  LabelSplitter(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                int smallest, LabelSplitMemory& memory, CellShares& shares, LabelImage& labels)
      : grid_(grid),
        cells_(cells),
        noise_(noise),
        tolerance_(tolerance),
        smallest_(smallest),
        smallest_side_(kMinSide * smallest),
        shares_(shares),
        labels_(labels),
        count_(memory.count),
        begin_(memory.begin),
        next_(memory.next),
        places_(memory.places),
        leaving_(memory.leaving),
        parts_(memory.parts),
        surfaces_(memory.surfaces),
        splits_(memory.splits),
        found_(memory.found) {}

  void splitAll(int threads) {
    listPlaces();
    parts_.clear();
    for (std::size_t label = 1; label + 1 < begin_.size(); ++label) {
      parts_.push_back({static_cast<std::int32_t>(label), begin_[label], begin_[label + 1]});
    }
    const std::size_t whole = parts_.size();
    splits_.resize(whole);
    found_.resize(whole);
    forEachPart(threads, static_cast<int>(whole), surfaces_,
                [&](int k, Surface& surface) { found_[k] = findSplit(parts_[k], surface, splits_[k]) ? 1 : 0; });
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      const Part part = parts_[k];
      Split split;
      if (k < whole ? found_[k] == 0 : !findSplit(part, surfaces_[0], split)) continue;
      if (k < whole) split = splits_[k];
      const int middle = splitAt(split, part);
      parts_.push_back({part.label, part.begin, middle});
      parts_.push_back({static_cast<std::int32_t>(shares_.sums.size()) - 1, middle, part.end});
    }
  }

 private:
  // Lists the shares of labels that may be split, label by label.
  void listPlaces() {
    count_.assign(shares_.sums.size(), 0);
    for (const std::int32_t label : shares_.labels) ++count_[label];
    begin_.assign(1, 0);
    for (std::size_t label = 0; label < count_.size(); ++label) {
      const Moments& sum = shares_.sums[label];
      const bool may_split =
          count_[label] >= kFewestCells && sum.n >= smallest_ &&
          (count_[label] <= kManyCells || (tolerance_.isWhite() && fitPlane(sum).chi2 > kLargeMisfit * sum.n));
      begin_.push_back(begin_.back() + (may_split ? count_[label] : 0));
    }
    next_ = begin_;
    places_.resize(static_cast<std::size_t>(begin_.back()));
    for (int k = 0; k + 1 < static_cast<int>(shares_.begin.size()); ++k) {
      for (int s = shares_.begin[k]; s < shares_.begin[k + 1]; ++s) {
        const std::int32_t label = shares_.labels[s];
        if (begin_[label] != begin_[label + 1]) places_[next_[label]++] = {k, s};
      }
    }
  }

  const Moments& momentsOf(const Place& place) const { return shares_.momentsOf(cells_, place.cell, place.share); }

  // Place of a cell in the image, in columns, along both axes.
  float xOf(const Place& place) const { return static_cast<float>(cells_.patches[place.cell].col_begin); }
  float yOf(const Place& place, float aspect) const {
    return aspect * static_cast<float>(cells_.patches[place.cell].row_begin);
  }

  // Columns of a patch over its rows, in the middle of a part.
  float aspectOf(const Part& part) const {
    const int strip = cells_.patches[places_[(part.begin + part.end) / 2].cell].col_begin / cells_.strip_cols;
    return static_cast<float>(cells_.strip_cols) / static_cast<float>(cells_.strip_rows[strip]);
  }

  bool isBeyond(const SurfaceCut& cut, const Place& place, float aspect) const {
    return cut.isBeyond(xOf(place), yOf(place, aspect));
  }

  // May be called for several parts at a time.
  bool findSplit(const Part& part, Surface& surface, Split& split) const {
    const int count = part.end - part.begin;
    if (count < kFewestCells) return false;
    const Moments& all = shares_.sums[part.label];
    if (all.n < smallest_) return false;
    const PlaneFit fit = fitPlane(all);
    const float aspect = aspectOf(part);
    const SurfaceFrame frame(all, fit);
    surface.clear();
    for (int i = part.begin; i < part.end; ++i) {
      surface.push_back({xOf(places_[i]), yOf(places_[i], aspect), frame.measure(momentsOf(places_[i]))});
    }
    const SurfaceCut cut = bestCut(surface, smallest_side_);
    const double significant = kSignificance * tolerance_.inflationOf(smallest_side_);
    if (!(cut.gain >= significant)) return false;
    const double bow = bowGain(surface);
    const bool large = count > kManyCells;
    if (!(cut.gain >= bow + significant) || (large && !(cut.gain >= kLargeGain * bow))) return false;
    split = {cut, {}, {}};
    for (int i = part.begin; i < part.end; ++i) {
      (isBeyond(cut, places_[i], aspect) ? split.high : split.low).sum += momentsOf(places_[i]);
    }
    // Rounding may put cells that lie on the cut on its other side.
    if (std::min(split.low.sum.n, split.high.sum.n) < smallest_side_) return false;
    split.low.fit = fitPlane(split.low.sum);
    split.high.fit = fitPlane(split.high.sum);
    if (large && split.low.fit.normal().dot(split.high.fit.normal()) < kLargeParallel) return false;
    return isExplained(split.low, split.high, fit) && isBeyondTolerance(split.low, split.high, fit);
  }

  // Whether two planes leave no more than noise, or not much more than what they explain.
  bool isExplained(const Side& low, const Side& high, const PlaneFit& whole) const {
    const double two = low.fit.chi2 + high.fit.chi2, n = low.sum.n + high.sum.n;
    const double left = two - (n - 6.0), noise = kNoise * std::sqrt(2.0 * n * tolerance_.inflationOf(n));
    return left < noise || (tolerance_.isWhite() && left < kMostLeft * (whole.chi2 - two));
  }

  bool isBeyondTolerance(const Side& low, const Side& high, const PlaneFit& whole) const {
    const Moments& small = low.sum.n < high.sum.n ? low.sum : high.sum;
    const double range = small.mean().norm(), sigma = noise_.sigma(range);
    return misfit(whole.chi2 - low.fit.chi2 - high.fit.chi2, small.n / (sigma * sigma),
                  std::min(small.radius(), kMaxWholeRadius), leastSecantSquared(whole, low.fit, high.fit, range),
                  wholeTolerance(tolerance_, sigma, small.n)) > kMinMisfit;
  }

  // Gives the side of fewer points a new label. @return the first of its places.
  int splitAt(const Split& split, const Part& part) {
    const Moments &low = split.low.sum, &high = split.high.sum;
    const bool beyond = high.n < low.n;  // is what leaves
    const float aspect = aspectOf(part);
    leaving_.clear();
    auto middle = places_.begin() + part.begin;
    for (int i = part.begin; i < part.end; ++i) {
      const Place place = places_[i];
      if (isBeyond(split.cut, place, aspect) == beyond) {
        leaving_.push_back(place);
      } else {
        *middle++ = place;
      }
    }
    std::copy(leaving_.begin(), leaving_.end(), middle);
    const auto fresh = static_cast<std::int32_t>(shares_.sums.size());
    shares_.sums[part.label] = beyond ? low : high;
    shares_.sums.push_back(beyond ? high : low);
    for (auto place = middle; place != places_.begin() + part.end; ++place) rename(*place, part.label, fresh);
    return static_cast<int>(middle - places_.begin());
  }

  void rename(const Place& place, std::int32_t label, std::int32_t fresh) {
    shares_.labels[place.share] = fresh;
    if (shares_.only[place.cell] == label) shares_.only[place.cell] = fresh;
    const Patch& cell = cells_.patches[place.cell];
    for (int r = cell.row_begin; r < cell.row_end; ++r) {
      const auto row = labels_.labels.begin() + grid_.index(r, 0);
      std::replace(row + cell.col_begin, row + cell.col_end, label, fresh);
    }
  }

  const BeamGrid& grid_;
  const PatchGrid& cells_;
  const NoiseModel& noise_;
  const CoplanarityTolerance& tolerance_;
  int smallest_;
  double smallest_side_;
  CellShares& shares_;
  LabelImage& labels_;
  std::vector<int>&count_, &begin_, &next_;
  std::vector<Place>&places_, &leaving_;
  std::vector<Part>& parts_;
  std::vector<Surface>& surfaces_;
  std::vector<Split>& splits_;
  std::vector<char>& found_;
};

}  // namespace

bool splitLabels(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise,
                 const CoplanarityTolerance& tolerance, int smallest, LabelSplitMemory& memory, CellShares& shares,
                 LabelImage& labels, int threads) {
  const std::size_t before = shares.sums.size();
  LabelSplitter(grid, cells, noise, tolerance, smallest, memory, shares, labels).splitAll(threads);
  return shares.sums.size() > before;
}

}  // namespace ppc
