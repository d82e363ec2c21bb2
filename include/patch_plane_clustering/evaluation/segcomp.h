// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/segmentation.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ppc {

/// @brief Pixels shared by the regions of a true and a found label image.
///
/// True regions below a minimum size are ignored: they are not counted as true, and a found region that lies on them with
/// more than half of its pixels is not counted as found. Otherwise a found region counts with all its pixels, also those
/// where the truth has no plane (0: curved, unlabelled, no measurement): what is found there is wrong.
struct RegionOverlap {
  std::vector<std::int32_t> true_ids, found_ids;  ///< the regions that count, ascending
  std::vector<int> true_sizes, found_sizes;       ///< their pixels
  std::vector<std::vector<int>> common;           ///< [true][found]: pixels of both
  int ignored_true = 0;                           ///< true regions below the minimum size
  int ignored_found = 0;                          ///< found regions on those
  long planar_both = 0;   ///< pixels with a label in both images, those of ignored true regions aside
  long planar_true = 0;   ///< pixels of the true regions that count
  long planar_found = 0;  ///< pixels with a found label, those on ignored true regions aside
};

/// @brief Counts the overlap. @throws std::invalid_argument if the sizes of the images differ.
RegionOverlap overlapOf(const LabelImage& truth, const LabelImage& found, int min_region = 400);

/// @brief Classes of regions at one tolerance, after Hoover et al., An Experimental Comparison of Range Image Segmentation
/// Algorithms, PAMI 18(7), 1996.
struct SegcompScore {
  double tolerance = 0.8;
  int correct = 0;                           ///< pairs that overlap by at least the tolerance of both regions
  int over_segmented = 0;                    ///< true regions covered by several found ones, each within it
  int under_segmented = 0;                   ///< found regions that cover several true ones
  int missed = 0;                            ///< true regions in none of these classes
  int noise = 0;                             ///< found regions in none of these classes
  std::vector<std::pair<int, int>> matches;  ///< correct pairs, as indices into RegionOverlap
};

/// @brief Classifies at a tolerance in (0.5, 1]. Where a region fits several classes, a correct detection comes first, so
/// that the number of correct ones depends on the pair alone; then the instance of higher mean overlap.
SegcompScore segcomp(const RegionOverlap& overlap, double tolerance);

/// @brief Scores of one image that do not depend on a class.
struct OverlapScore {
  double mean_iou = 0.0;      ///< mean over the true regions of the best intersection over union with a found one
  double weighted_iou = 0.0;  ///< the same, weighted with the size of the true region
  double precision = 0.0;     ///< share of the labelled pixels that are on a true plane
  double recall = 0.0;        ///< share of the pixels on true planes that are labelled
};

/// @brief An image without a true region has IoU and recall 1; one without a found region has precision 1.
OverlapScore overlapScore(const RegionOverlap& overlap);

/// @brief F1 = 2 correct / (true + found); 1 if there is nothing to find and nothing was found.
double f1(const RegionOverlap& overlap, const SegcompScore& score);

}  // namespace ppc
