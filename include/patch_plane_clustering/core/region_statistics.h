// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/across_fit.h"
#include "patch_plane_clustering/core/beam_fit.h"
#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/beam_start.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/region_fringe.h"
#include "patch_plane_clustering/core/run_listing.h"
#include "patch_plane_clustering/core/score_scatter.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace ppc {

/// @brief Working memory of describeRegions(), which one image after the other may use. By label, if nothing else is said.
struct RegionMemory {
  /// How far the fit of a region is.
  enum class Stage { kAlong, kAcross, kDone };
  /// Some blocks of one region: what a thread takes at a time, as one region may have most of the image.
  struct Chunk {
    std::size_t id;
    const PixelStretch *begin, *end;
  };

  std::vector<PixelStretch> blocks;       ///< of all regions, label by label
  std::vector<std::size_t> blocks_begin;  ///< of each label, and one past the last
  std::vector<Stage> stages;
  std::vector<BeamStart> starts;
  std::vector<Chunk> chunks;              ///< of the regions at one stage
  std::vector<std::size_t> chunks_begin;  ///< of each region, and one past the last
  std::vector<ScoreScatter> scatters;
  std::vector<Eigen::Matrix<double, 4, 3>> roots;  ///< R of each plane's covariance R R^T for independent errors
  std::vector<std::pair<float, float>> order;      ///< of regions, by what they tell of the scatter
  std::vector<BeamSums> beam_parts, beam_sums;     ///< of the chunks, of the labels
  std::vector<PointSums> point_parts, point_sums;  ///< the same
  std::vector<Eigen::Vector3d> origins;            ///< which the latter are about
  std::vector<BeamStartMemory> threads;            ///< one a thread
  std::vector<FringeMemory> fringes;               ///< the same
};

/// @brief Working memory of renumberBySize(), by the labels as they were.
struct RenumberingMemory {
  std::vector<int> count, first;  ///< pixels, and where the first one is
  std::vector<std::int32_t> order, renamed;
  RunListMemory listing;
  std::vector<int> valid;  ///< pixels with a measurement in each part of the image
};

/// @brief Plane, centroid, covariance, point count and rms of every region of a label image, whichever method made the
/// labels. The plane minimises errors along the beams, where range noise runs, and small ones across them (BeamStart; total
/// least squares where a region is seen edge-on), without those beyond 2.5 standard deviations: points that got the label
/// from beside the region do not turn it; of regions up to 8192 points, without parts of the fringe (Fringe) that lie off
/// the plane to one side either or, up to 2048 points and where noise is above 5 mm, off the plane of the inside by more
/// than it and walls that bow let them, unless half of the points were left out so or the rms of all became a quarter
/// larger. The covariance takes the errors' own variance, and that errors go together in part, along a line or over a few,
/// as their sums over some rows each show (ScoreScatter); what all rows have in common, as the pose of the sensor or errors
/// of single beams, it cannot know. Centroid, count and rms are those of all points.
/// @param labels values 1..N, 0 = none; same size as the grid.
/// @return one region for each id 1..max that has at least 3 points; in ascending id.
std::vector<PlanarRegion> describeRegions(const BeamGrid& grid, const LabelImage& labels, int threads = 1);
/// @brief The same with memory. @param runs of the labels. @param regions overwritten; its memory is used again, too.
void describeRegions(const BeamGrid& grid, const std::vector<LabelRun>& runs, RegionMemory& memory,
                     std::vector<PlanarRegion>& regions, int threads = 1);

/// @brief Renumbers labels to 1..N in descending number of pixels (ties: first pixel first) and clears regions of fewer than
/// `min_size` valid points. @return N.
int renumberBySize(const BeamGrid& grid, int min_size, LabelImage& labels);
/// @brief The same with memory. @param runs set to those of the new labels, as labelRuns(). @param valid_points set to the
/// number of pixels with a measurement.
int renumberBySize(const BeamGrid& grid, int min_size, RenumberingMemory& memory, LabelImage& labels,
                   std::vector<LabelRun>& runs, int& valid_points, int threads = 1);

}  // namespace ppc
