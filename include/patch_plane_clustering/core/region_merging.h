// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/cell_shares.h"
#include "patch_plane_clustering/core/label_meetings.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/run_listing.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/core/similarity.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace ppc {

/// @brief Working memory of mergeLabels() and mergeShares(), which one image after the other may use.
struct MergeMemory {
  struct Whole {  ///< a label as a whole
    Moments moments;
    PlaneFit fit;
  };

  std::vector<std::int32_t> names;  ///< of every label in the end: itself, or a lower one that keeps its name
  std::vector<std::int32_t> now;    ///< the same of one round
  std::vector<Whole> whole;
  std::vector<char> fresh, changed;  ///< labels: pairs of those that have not changed need no second look
  LabelMeetings meetings;
  struct Border {              ///< what a thread knows of cells along a border
    std::vector<int> reached;  ///< the last border that took each cell
    std::vector<int> wave;     ///< cells of one border
    int latest = -1;           ///< border
    std::vector<std::pair<double, LabelPair>> candidates;
  };
  std::vector<Border> borders;             ///< one a thread
  std::vector<std::pair<int, int>> pairs;  ///< groups [first, second) of each pair that is looked at
  std::vector<std::pair<double, LabelPair>> candidates;
  RunListMemory listing;
};

/// @brief Merges labels that touch and lie on one plane, most similar first.
///
/// Two conditions must hold. The joint plane serves both as wholes: with a wider tolerance than from patch to patch, for
/// walls bow, wider still if they are hardly turned against each other; or they are turned a little, but the border itself
/// lies on one plane rather than on the two (a sagging floor, not a crease). To a sensor of less than 2.5 mm of noise, what
/// is turned by more than 8 degrees must not be so for certain: a crease of small faces stays within any tolerance of
/// distance. And where they meet there is no step: the strips on both sides of the border are compared by their offset alone
/// (a plane tilted across a step hides three quarters of it); those of a wide bow, whose joint plane leaves the border, by
/// the nearest of both sides.
/// @param cells blocks of pixels by which "touching" and "where they meet" are measured.
/// @param shares of `labels`; renamed along with them. @param runs set to those of the new labels. @param planes set to
/// those of the new labels, as by labelPlanes(); 0 of names that no label has any more.
void mergeLabels(const PatchGrid& cells, const NoiseModel& noise, const CoplanarityTolerance& tolerance, double threshold,
                 MergeMemory& memory, CellShares& shares, LabelImage& labels, std::vector<LabelRun>& runs,
                 std::vector<Eigen::Vector3d>& planes, int threads = 1);

/// @brief The same where there is no image of the labels yet.
void mergeShares(const PatchGrid& cells, const NoiseModel& noise, const CoplanarityTolerance& tolerance, double threshold,
                 MergeMemory& memory, CellShares& shares, std::vector<Eigen::Vector3d>& planes, int threads = 1);

}  // namespace ppc
