// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_statistics.h"

#include "patch_plane_clustering/core/across_fit.h"
#include "patch_plane_clustering/core/beam_fit.h"
#include "patch_plane_clustering/core/beam_start.h"
#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace ppc {
namespace {

constexpr int kBlock = 256;  // pixels
constexpr int kChunkBlocks = 32;
constexpr int kMaxPasses = 3;
// Of a step: what is linear near the start no longer is. Gain as a share of the squares, and change of the incidence.
constexpr double kFarStep = 0.02, kFarTurn = 0.05;

using Blocks = std::vector<PixelBlock>;

// Some blocks of one region: what a thread takes at a time, as one region may have most of the image.
struct Chunk {
  std::size_t id;
  const PixelBlock *begin, *end;
};

// How far the fit of a region is.
enum class Stage { kAlong, kAcross, kDone };

std::vector<Blocks> blocksOf(const std::vector<LabelRun>& runs) {
  std::vector<Blocks> blocks(static_cast<std::size_t>(highestLabel(runs)) + 1);
  std::vector<std::size_t> count(blocks.size(), 0);
  for (const LabelRun& run : runs) count[run.label] += static_cast<std::size_t>((run.end - run.begin + kBlock - 1) / kBlock);
  for (std::size_t id = 0; id < blocks.size(); ++id) blocks[id].reserve(count[id]);
  for (const LabelRun& run : runs) {
    for (int at = run.begin; at < run.end; at += kBlock) blocks[run.label].push_back({at, std::min(at + kBlock, run.end)});
  }
  return blocks;
}

class RegionFitter {
 public:
  RegionFitter(const BeamGrid& grid, const std::vector<Blocks>& blocks, int threads)
      : grid_(grid),
        blocks_(blocks),
        threads_(threads),
        stages_(blocks.size(), Stage::kAcross),
        starts_(blocks.size()),
        regions_(blocks.size()) {
    forEachPart(threads, static_cast<int>(blocks.size()), [&](int id) {
      starts_[id] = startOf(grid, blocks[id]);
      regions_[id].id = id;
    });
    for (std::size_t id = 0; id < blocks.size(); ++id) {
      if (starts_[id].along) stages_[id] = Stage::kAlong;
    }
  }

  // Noise runs along the beams: the likeliest plane minimises errors in range, not across the plane. One pass, unless the
  // sample told little of the plane.
  void fitAlongBeams() {
    for (int pass = 1; pass <= kMaxPasses; ++pass) {
      const std::vector<BeamSums> sums = sumAlong(Stage::kAlong);
      for (std::size_t id = 0; id < sums.size(); ++id) {
        if (stages_[id] == Stage::kAlong) step(id, sums[id], pass == kMaxPasses);
      }
    }
  }

  // Regions whose beams did not tell the plane.
  void fitAcrossBeams() {
    std::vector<Eigen::Vector3d> origins(blocks_.size(), Eigen::Vector3d::Zero());
    for (std::size_t id = 0; id < blocks_.size(); ++id) {
      if (stages_[id] == Stage::kAcross) origins[id] = originOf(blocks_[id]);
    }
    const std::vector<PointSums> points = sumChunks<PointSums>(Stage::kAcross, [&](const Chunk& chunk) {
      PointSums sums;
      for (const PixelBlock* at = chunk.begin; at != chunk.end; ++at) {
        addPoints(grid_, at->begin, at->end, origins[chunk.id], sums);
      }
      return sums;
    });
    for (std::size_t id = 0; id < blocks_.size(); ++id) {
      if (stages_[id] != Stage::kAcross || points[id].n < 3) continue;
      regions_[id] = fitAcross(static_cast<std::int32_t>(id), origins[id], points[id]);
      starts_[id].frame = BeamFrame(regions_[id].plane, regions_[id].centroid);
    }
    const std::vector<BeamSums> beams = sumAlong(Stage::kAcross);  // distances have more digits than eigenvalues
    for (std::size_t id = 0; id < blocks_.size(); ++id) {
      PlanarRegion& region = regions_[id];
      if (stages_[id] != Stage::kAcross || region.points < 3) continue;
      region.rms = std::sqrt(beams[id].hh / region.points);
      region.covariance *= beams[id].hh / std::max(1, region.points - 3);
    }
  }

  std::vector<PlanarRegion> take() {
    regions_.erase(std::remove_if(regions_.begin(), regions_.end(), [](const PlanarRegion& r) { return r.points < 3; }),
                   regions_.end());
    return std::move(regions_);
  }

 private:
  // Sums over the chunks of every region at a stage, sum(chunk), added up in their order, however many threads there are.
  template <typename Sums, typename F>
  std::vector<Sums> sumChunks(Stage stage, F&& sum) const {
    std::vector<Chunk> chunks;
    for (std::size_t id = 0; id < blocks_.size(); ++id) {
      if (stages_[id] != stage) continue;
      const PixelBlock* const end = blocks_[id].data() + blocks_[id].size();
      for (const PixelBlock* at = blocks_[id].data(); at != end;) {
        const PixelBlock* const next = at + std::min<std::ptrdiff_t>(kChunkBlocks, end - at);
        chunks.push_back({id, at, next});
        at = next;
      }
    }
    std::vector<Sums> parts(chunks.size()), sums(blocks_.size());
    forEachPart(threads_, static_cast<int>(chunks.size()), [&](int k) { parts[k] = sum(chunks[k]); });
    for (std::size_t k = 0; k < chunks.size(); ++k) sums[chunks[k].id] += parts[k];
    return sums;
  }

  std::vector<BeamSums> sumAlong(Stage stage) const {
    return sumChunks<BeamSums>(stage, [&](const Chunk& chunk) {
      const BeamStart& start = starts_[chunk.id];
      return sumBeams(grid_, chunk.begin, chunk.end, start.frame, BeamWeights::kTrimmed, start.scale);
    });
  }

  void step(std::size_t id, const BeamSums& sums, bool last) {
    BeamStart& start = starts_[id];
    const double scale = newtonScale(sums, start.scale.limit);
    const std::optional<BeamStep> step = stepOf(sums, scale);
    if (!step || sums.used < std::max(4, sums.valid / 2)) {
      stages_[id] = Stage::kAcross;
      return;
    }
    const Plane plane = movedBy(*step, start.frame, start.origin);
    const Eigen::Vector3d beam = start.frame.meanOf(sums) - start.origin;
    const double incidence = plane.normal.dot(beam) / start.frame.plane().normal.dot(beam);
    if ((step->gain > kFarStep * sums.whh || std::abs(incidence - 1.0) > kFarTurn) && !last) {
      start.frame = BeamFrame(plane, start.frame.centre());
      return;
    }
    PlanarRegion& region = regions_[id];
    region.plane = plane;
    region.centroid = start.frame.meanOf(sums);
    region.points = sums.valid;
    // The step brings all points nearer, at the kept ones' mean incidence, and changes that.
    region.rms = std::abs(incidence) * std::sqrt(std::max(0.0, sums.hh - step->gain * sums.kept / sums.w) / sums.valid);
    const double variance = std::max(0.0, sums.whh - step->gain) / std::max(1, sums.kept - 3);
    region.covariance = planeCovariance(*step, start.frame, plane, scale * scale * variance);
    stages_[id] = Stage::kDone;
  }

  // The first point of a region; the frame's origin if it has none.
  Eigen::Vector3d originOf(const Blocks& blocks) const {
    for (const PixelBlock& block : blocks) {
      for (int i = block.begin; i < block.end; ++i) {
        if (grid_.valid(i)) return grid_.point(i).cast<double>();
      }
    }
    return Eigen::Vector3d::Zero();
  }

  const BeamGrid& grid_;
  const std::vector<Blocks>& blocks_;
  int threads_;
  std::vector<Stage> stages_;
  std::vector<BeamStart> starts_;
  std::vector<PlanarRegion> regions_;
};

}  // namespace

std::vector<PlanarRegion> describeRegions(const BeamGrid& grid, const LabelImage& labels, int threads) {
  return describeRegions(grid, labelRuns(labels), threads);
}

std::vector<PlanarRegion> describeRegions(const BeamGrid& grid, const std::vector<LabelRun>& runs, int threads) {
  const std::vector<Blocks> blocks = blocksOf(runs);
  RegionFitter fitter(grid, blocks, threads);
  fitter.fitAlongBeams();
  fitter.fitAcrossBeams();
  return fitter.take();
}

}  // namespace ppc
