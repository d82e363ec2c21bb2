// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_statistics.h"

#include "patch_plane_clustering/core/parallel.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace ppc {
namespace {

constexpr int kBlock = 256;  // pixels, of one row
constexpr int kChunks = 48;  // of a region, about, unless it has fewer rows
constexpr int kMaxPasses = 3;
constexpr double kLeastTold = 1e-12;  // eigenvalue over the largest, of what points tell
// Of a step: what is linear near the start no longer is. Gain as a share of the squares, and change of the incidence.
constexpr double kFarStep = 0.02, kFarTurn = 0.05;
constexpr double kWorseRms = 1.25;   // of all points
constexpr int kFringePoints = 8192;  // of a larger region, a fringe of one pixel turns the plane little
constexpr int kInsidePoints = 2048;  // likewise so little that it cannot hide
// Of a fringe that is off the plane of the inside: standard deviations, and that of what walls bow [m]. Where noise is
// below 5 mm, no errors that are not capped are so large, and the inside is not asked.
constexpr double kInsideSignificance = 2.5, kInsideTolerance = 0.005;

using Chunk = RegionMemory::Chunk;
using Stage = RegionMemory::Stage;

// R with R R^T = A^-1, in coordinates of L^T x for A = L L^T. Of points that do not tell one turn, as a level line's, in its
// own coordinates, without that turn.
Eigen::Matrix3d inverseRoot(const Eigen::Matrix3d& equations) {
  const Eigen::LLT<Eigen::Matrix3d> root(equations);
  if (root.info() == Eigen::Success) return root.matrixU().solve(Eigen::Matrix3d::Identity());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(equations);
  const Eigen::Vector3d told = eigen.eigenvalues();
  const double least = kLeastTold * told.maxCoeff();
  return eigen.eigenvectors() * (told.array() > least).select(told.array().max(least).rsqrt(), 0.0).matrix().asDiagonal();
}

// Lists the blocks, label by label.
void listBlocks(const std::vector<LabelRun>& runs, int cols, RegionMemory& memory) {
  const auto forEachBlock = [&runs, cols](auto&& take) {
    for (const LabelRun& run : runs) {
      for (int at = run.begin, end = at; at < run.end; at = end) {
        end = std::min({at + kBlock, run.end, (at / cols + 1) * cols});
        take(run.label, PixelStretch{at, end});
      }
    }
  };
  std::vector<std::size_t>& begin = memory.blocks_begin;
  begin.assign(static_cast<std::size_t>(highestLabel(runs)) + 2, 0);
  forEachBlock([&](std::int32_t label, const PixelStretch&) { ++begin[label + 1]; });
  for (std::size_t label = 1; label < begin.size(); ++label) begin[label] += begin[label - 1];
  memory.blocks.resize(begin.back());
  // begin[label] moves to the label's end, which is the next one's begin
  forEachBlock([&](std::int32_t label, const PixelStretch& block) { memory.blocks[begin[label]++] = block; });
  std::rotate(begin.begin(), begin.end() - 1, begin.end());
  begin.front() = 0;
}

class RegionFitter {
 public:
  RegionFitter(const BeamGrid& grid, RegionMemory& memory, std::vector<PlanarRegion>& regions, int threads)
      : grid_(grid), memory_(memory), stages_(memory.stages), starts_(memory.starts), regions_(regions), threads_(threads) {
    const std::size_t labels = memory.blocks_begin.size() - 1;
    stages_.assign(labels, Stage::kAcross);
    starts_.resize(labels);
    regions_.assign(labels, PlanarRegion());
    memory.scatters.assign(labels, ScoreScatter());
    memory.roots.resize(labels);
    forEachPart(threads, static_cast<int>(labels), memory.threads, [&](int id, BeamStartMemory& start) {
      starts_[id] = startOf(grid, blocksBegin(id), blocksEnd(id), start);
      regions_[id].id = id;
    });
    for (std::size_t id = 0; id < labels; ++id) {
      if (starts_[id].along) stages_[id] = Stage::kAlong;
    }
  }

  // Noise runs along the beams: the likeliest plane minimises errors in range, not across the plane. One pass, unless the
  // sample told little of the plane.
  void fitAlongBeams() {
    for (int pass = 1; pass <= kMaxPasses; ++pass) {
      if (!sumAlong(Stage::kAlong)) return;
      forEachPart(threads_, static_cast<int>(stages_.size()), memory_.fringes, [&](int id, FringeMemory& fringe) {
        if (stages_[id] == Stage::kAlong) step(id, memory_.beam_sums[id], pass == kMaxPasses, fringe);
      });
    }
  }

  // Regions whose beams did not tell the plane.
  void fitAcrossBeams() {
    std::vector<Eigen::Vector3d>& origins = memory_.origins;
    origins.assign(stages_.size(), Eigen::Vector3d::Zero());
    for (std::size_t id = 0; id < stages_.size(); ++id) {
      if (stages_[id] == Stage::kAcross) origins[id] = originOf(id);
    }
    const std::vector<PointSums>& points = memory_.point_sums;
    if (!sumChunks(Stage::kAcross, memory_.point_parts, memory_.point_sums, [&](const Chunk& chunk) {
          PointSums sums;
          for (const PixelStretch* at = chunk.begin; at != chunk.end; ++at) {
            addPoints(grid_, at->begin, at->end, origins[chunk.id], sums);
          }
          return sums;
        })) {
      return;
    }
    for (std::size_t id = 0; id < stages_.size(); ++id) {
      if (stages_[id] != Stage::kAcross || points[id].n < 3) continue;
      regions_[id] = fitAcross(static_cast<std::int32_t>(id), origins[id], points[id]);
      starts_[id].frame = BeamFrame(regions_[id].plane, regions_[id].centroid);
    }
    sumAlong(Stage::kAcross);  // distances have more digits than eigenvalues
    for (std::size_t id = 0; id < stages_.size(); ++id) {
      PlanarRegion& region = regions_[id];
      if (stages_[id] != Stage::kAcross || region.points < 3) continue;
      const double squares = memory_.beam_sums[id].hh;
      region.rms = std::sqrt(squares / region.points);
      region.covariance *= squares / std::max(1, region.points - 3);
    }
  }

  // Once all regions have told how far errors go together.
  void findCovariances() {
    const CommonScatter common = commonScatter(memory_.scatters, memory_.order);
    for (std::size_t id = 0; id < stages_.size(); ++id) {
      PlanarRegion& region = regions_[id];
      if (stages_[id] == Stage::kDone) {
        const Eigen::Matrix<double, 4, 3>& root = memory_.roots[id];
        region.covariance = root * inflationOf(memory_.scatters[id], common) * root.transpose();
      } else {
        region.covariance *= common.whole();
      }
      const Eigen::Matrix4d rounded = region.covariance;
      region.covariance = rounded.selfadjointView<Eigen::Lower>();
    }
  }

  void dropSmall() {
    regions_.erase(std::remove_if(regions_.begin(), regions_.end(), [](const PlanarRegion& r) { return r.points < 3; }),
                   regions_.end());
  }

 private:
  const PixelStretch* blocksBegin(std::size_t id) const { return memory_.blocks.data() + memory_.blocks_begin[id]; }
  const PixelStretch* blocksEnd(std::size_t id) const { return blocksBegin(id + 1); }

  // Sums over the chunks of every region at a stage, sum(chunk), added up in their order, however many threads there are.
  // Returns whether there is any.
  template <typename Sums, typename F>
  bool sumChunks(Stage stage, std::vector<Sums>& parts, std::vector<Sums>& sums, F&& sum) const {
    std::vector<Chunk>& chunks = memory_.chunks;
    chunks.clear();
    memory_.chunks_begin.assign(stages_.size() + 1, 0);
    for (std::size_t id = 0; id < stages_.size(); ++id) {
      if (stages_[id] == stage) listChunks(id, chunks);
      memory_.chunks_begin[id + 1] = chunks.size();
    }
    parts.resize(chunks.size());
    forEachPart(threads_, static_cast<int>(chunks.size()), [&](int k) { parts[k] = sum(chunks[k]); });
    sums.assign(stages_.size(), Sums());
    for (std::size_t k = 0; k < chunks.size(); ++k) sums[chunks[k].id] += parts[k];
    return !chunks.empty();
  }

  // Chunks of one region, of as many blocks each if rows let them: a chunk has all of a row, whose errors may go together.
  void listChunks(std::size_t id, std::vector<Chunk>& chunks) const {
    const PixelStretch* const end = blocksEnd(id);
    const std::ptrdiff_t blocks = std::max<std::ptrdiff_t>(1, (end - blocksBegin(id)) / kChunks);
    for (const PixelStretch* at = blocksBegin(id); at != end;) {
      const PixelStretch* next = at + std::min(blocks, end - at);
      while (next != end && next->begin / grid_.cols == (next - 1)->begin / grid_.cols) ++next;
      chunks.push_back({id, at, next});
      at = next;
    }
  }

  bool sumAlong(Stage stage) const {
    return sumChunks(stage, memory_.beam_parts, memory_.beam_sums, [&](const Chunk& chunk) {
      const BeamStart& start = starts_[chunk.id];
      return sumBeams(grid_, chunk.begin, chunk.end, start.frame, BeamWeights::kTrimmed, start.scale);
    });
  }

  struct MovedPlane {
    Plane plane;
    double incidence;  // how much less obliquely the beams meet it than the plane of the start
  };

  struct NextStep {
    BeamSums sums;  // that it was found from
    BeamStep step;
    MovedPlane moved;
  };

  void step(std::size_t id, const BeamSums& sums, bool last, FringeMemory& fringe) {
    BeamStart& start = starts_[id];
    const double scale = newtonScale(sums, start.scale.limit);
    const std::optional<BeamStep> step = stepOf(sums, scale);
    if (!step || sums.used < std::max(4, sums.valid / 2)) {
      stages_[id] = Stage::kAcross;
      return;
    }
    if (sums.kept < sums.used / 2) {  // the sample told too little of the errors
      start.scale.limit = kNoLimit;
      if (last) stages_[id] = Stage::kAcross;
      return;
    }
    const std::optional<MovedPlane> moved = planeAfter(*step, start, sums);
    if (!moved) {
      stages_[id] = Stage::kAcross;
      return;
    }
    if ((step->gain > kFarStep * sums.whh || std::abs(moved->incidence - 1.0) > kFarTurn) && !last) {
      start.frame = BeamFrame(moved->plane, start.frame.centre());
      return;
    }
    describe(id, sums, *step, *moved);
    stages_[id] = Stage::kDone;
    std::optional<NextStep> rest;
    if (sums.valid <= kFringePoints && start.scale.limit < kNoLimit) {
      rest = leaveOutFringe(id, sums, scale, std::sqrt(scale * varianceOf(sums, step->gain)), fringe);
    }
    findSpread(id, rest ? *rest : NextStep{sums, *step, *moved}, scale);
  }

  // One more step, without the parts of the fringe that are off the plane or that of the inside: of a narrow region, the
  // fringe turns the plane so that it looks less off. None if nothing was left out.
  std::optional<NextStep> leaveOutFringe(std::size_t id, const BeamSums& sums, double scale, double sigma,
                                         FringeMemory& memory) {
    const BeamStart& start = starts_[id];
    Fringe fringe(grid_, blocksBegin(id), blocksEnd(id), memory);
    const FringeJudge whole{regions_[id].plane, sigma};
    std::optional<NextStep> inside;
    const bool may_tell = sums.valid <= kInsidePoints && kInsideSignificance * kInsideTolerance < start.scale.limit;
    if (may_tell) inside = stepWithout(fringe.all(), start, sums, scale);
    const std::vector<PixelStretch>& off =
        inside ? fringe.off({whole, judgeOf(*inside, start, scale)}, start.scale) : fringe.off({whole}, start.scale);
    if (off.empty()) return std::nullopt;
    const std::optional<NextStep> next = stepWithout(off, start, sums, scale);
    if (!next) return std::nullopt;
    const PlanarRegion before = regions_[id];
    describe(id, sums, next->step, next->moved);
    if (regions_[id].rms > kWorseRms * before.rms) {  // the region, not what is beside it, was left out
      regions_[id] = before;
      return std::nullopt;
    }
    takeFromParts(id, off);
    return next;
  }

  // What the covariance comes from: root and scatter, of the points that the last step was found from.
  void findSpread(std::size_t id, const NextStep& last, double scale) {
    const double variance = varianceOf(last.sums, last.step.gain);
    memory_.roots[id] = scale * std::sqrt(variance) * planeJacobian(starts_[id].frame, last.moved.plane) *
                        inverseRoot(equationsOf(last.sums));
    const BeamSums* const parts = memory_.beam_parts.data();
    memory_.scatters[id] = scatterOf(parts + memory_.chunks_begin[id], parts + memory_.chunks_begin[id + 1], last.sums,
                                     last.step.x / scale, variance);
  }

  // Takes pixels, which are in the order of the image, from the sums of the region's chunks.
  void takeFromParts(std::size_t id, const std::vector<PixelStretch>& pixels) {
    const BeamStart& start = starts_[id];
    std::size_t k = memory_.chunks_begin[id];
    for (PixelStretch rest : pixels) {
      while (rest.begin != rest.end) {
        while ((memory_.chunks[k].end - 1)->end <= rest.begin) ++k;
        const PixelStretch here{rest.begin, std::min(rest.end, (memory_.chunks[k].end - 1)->end)};
        memory_.beam_parts[k] -= sumBeams(grid_, &here, &here + 1, start.frame, BeamWeights::kTrimmed, start.scale);
        rest.begin = here.end;
      }
    }
  }

  // The plane after a step; none if the beams do not meet it from the side they met the start's.
  static std::optional<MovedPlane> planeAfter(const BeamStep& step, const BeamStart& start, const BeamSums& sums) {
    const Plane plane = movedBy(step, start.frame, start.origin);
    const Eigen::Vector3d beam = start.frame.meanOf(sums) - start.origin;
    const double incidence = plane.normal.dot(beam) / start.frame.plane().normal.dot(beam);
    if (!plane.normal.allFinite() || !std::isfinite(plane.d) || !(incidence > 0.0)) return std::nullopt;
    return MovedPlane{plane, incidence};
  }

  // The step without some pixels; none if it is without half of the points or tells no plane.
  std::optional<NextStep> stepWithout(const std::vector<PixelStretch>& pixels, const BeamStart& start, const BeamSums& sums,
                                      double scale) const {
    BeamSums rest = sums;
    rest -= sumBeams(grid_, pixels.data(), pixels.data() + pixels.size(), start.frame, BeamWeights::kTrimmed, start.scale);
    if (rest.kept < std::max(4, sums.kept / 2)) return std::nullopt;
    const std::optional<BeamStep> step = stepOf(rest, scale);
    if (!step) return std::nullopt;
    const std::optional<MovedPlane> moved = planeAfter(*step, start, sums);
    if (!moved) return std::nullopt;
    return NextStep{rest, *step, *moved};
  }

  static FringeJudge judgeOf(const NextStep& inside, const BeamStart& start, double scale) {
    const double variance = varianceOf(inside.sums, inside.step.gain);
    return {inside.moved.plane, std::sqrt(scale * variance), kInsideSignificance, kInsideTolerance,
            planeCovariance(inside.step, start.frame, inside.moved.plane, scale * scale * variance)};
  }

  static double varianceOf(const BeamSums& sums, double gain) {
    return std::max(0.0, sums.whh - gain) / std::max(1, sums.kept - 3);
  }

  // @param all sums of all points, not only of those that the step was found from.
  void describe(std::size_t id, const BeamSums& all, const BeamStep& step, const MovedPlane& moved) {
    const BeamStart& start = starts_[id];
    PlanarRegion& region = regions_[id];
    region.plane = moved.plane;
    region.centroid = start.frame.meanOf(all);
    region.points = all.valid;
    // The step brings all points nearer, at the kept ones' mean incidence, and changes that.
    const double squares = all.hh - gainOf(all, step.x) * all.kept / all.w;
    region.rms = moved.incidence * std::sqrt(std::max(0.0, squares) / all.valid);
  }

  // The first point of a region; the frame's origin if it has none.
  Eigen::Vector3d originOf(std::size_t id) const {
    const int first = firstValid(grid_, blocksBegin(id), blocksEnd(id));
    if (first < 0) return Eigen::Vector3d::Zero();
    return grid_.point(first).cast<double>();
  }

  const BeamGrid& grid_;
  RegionMemory& memory_;
  std::vector<Stage>& stages_;
  std::vector<BeamStart>& starts_;
  std::vector<PlanarRegion>& regions_;
  int threads_;
};

}  // namespace

std::vector<PlanarRegion> describeRegions(const BeamGrid& grid, const LabelImage& labels, int threads) {
  RegionMemory memory;
  std::vector<PlanarRegion> regions;
  describeRegions(grid, labelRuns(labels), memory, regions, threads);
  return regions;
}

void describeRegions(const BeamGrid& grid, const std::vector<LabelRun>& runs, RegionMemory& memory,
                     std::vector<PlanarRegion>& regions, int threads) {
  listBlocks(runs, grid.cols, memory);
  RegionFitter fitter(grid, memory, regions, threads);
  fitter.fitAlongBeams();
  fitter.fitAcrossBeams();
  fitter.findCovariances();
  fitter.dropSmall();
}

}  // namespace ppc
