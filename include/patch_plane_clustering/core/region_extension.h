// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/judged_image.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Working memory of extendRegions(), which one image after the other may use.
struct ExtensionMemory {
  struct Step {  ///< from a region to a pixel beside it that has none
    std::int32_t label;
    int pixel;
  };
  std::vector<int> points;              ///< of each label
  std::vector<char> loose;              ///< labels, and none, that are not those of a region
  std::vector<Step> found;              ///< in scan order
  std::vector<std::vector<Step>> rest;  ///< the same of each part of the image but the first one
  std::vector<Step> steps;              ///< region by region
  std::vector<std::size_t> next;        ///< of each label: where its next step goes
  std::vector<std::int32_t> order;      ///< labels that have steps
  std::vector<std::int32_t> tried;      ///< of each pixel: the last region that has reached it; 0 between two images
  std::vector<int> reached;             ///< pixels that any has
};

/// @brief Lets regions go on along their planes into points that have none.
///
/// Patches fit into the wide part of a strip and not into its ends, nor into what is seen of a wall between leaves. From
/// every border of a region, points that have no region (no label, or one of too few points) and are linked to it by others
/// like them are reached as long as they are within three standard deviations of its plane, along beams, of noise and
/// tolerance. They become part of it if there are at least 16 whose distances scatter no more than noise and have none for
/// mean: those of a surface that crosses the plane, or leaves it, scatter evenly or lie on one side. Larger regions come
/// first; those of fewer points than JudgedImage::smallest are not extended. Deterministic; thread-safe with memory of one's
/// own.
/// @param planes a (see moments.h) of every label. @param runs of the labels, see listRuns().
/// @return whether any region was extended, so that the runs are no longer those of the labels.
bool extendRegions(const JudgedImage& image, const std::vector<Eigen::Vector3d>& planes, ExtensionMemory& memory,
                   LabelImage& labels, const std::vector<LabelRun>& runs, int threads = 1);

}  // namespace ppc
