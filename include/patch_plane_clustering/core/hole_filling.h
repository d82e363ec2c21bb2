// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/judged_image.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <vector>

namespace ppc {

/// @brief Working memory of fillHoles(), which one image after the other may use.
struct HoleMemory {
  struct Pixel {
    int index, col;
  };
  std::vector<int> points;    ///< of each label
  std::vector<char> loose;    ///< labels, and none, that are not those of a region
  std::vector<char> seen;     ///< pixels of the specks that have been looked at; none between two images
  std::vector<Pixel> specks;  ///< their pixels, speck by speck
};

/// @brief Gives points inside of a region to it which as a whole lie on its plane as well as noise lets them.
///
/// Smooth noise makes bumps that look like faces of their own to patches; they end as specks that are too small for a
/// region. A speck (pixels without a label, or of regions smaller than JudgedImage::smallest) that touches one region only
/// is filled if its points scatter about the plane no more than noise and tolerance let them (mean square 6 + 10 / n
/// variances, 4 standard deviations of a single one), and their mean is within 5.5 of its standard deviations, which tells
/// more where noise is large: specks are where it is largest. True things that small stand off by ten and more, or cannot be
/// told.
/// @param planes a (see moments.h) of every label. @param runs of the labels, see listRuns(), before regions were extended
/// (extendRegions()).
/// @return whether anything was filled.
bool fillHoles(const JudgedImage& image, const std::vector<Eigen::Vector3d>& planes, HoleMemory& memory, LabelImage& labels,
               const std::vector<LabelRun>& runs);

}  // namespace ppc
