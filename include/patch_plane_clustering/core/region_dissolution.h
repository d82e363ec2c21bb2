// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/judged_image.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/region_stretches.h"
#include "patch_plane_clustering/core/run_listing.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace ppc {

/// @brief A region that is dissolved, and whether for being lines of pixels.
struct DissolvedRegion {
  RegionStretches::Region region;
  bool lines;
};

/// @brief Working memory of dissolveRegions(), which one image after the other may use.
struct DissolutionMemory {
  std::vector<int> points;  ///< of each label
  std::vector<int> inside;  ///< of each label that is small enough: points that touch no other one
  RunListMemory listing;
  std::vector<int> run_inside;             ///< of each run, points that touch nothing else for sure
  RegionStretches judged;                  ///< regions that may be thin, lines, or bumps of noise
  std::vector<DissolvedRegion> dissolved;  ///< those of them that are dissolved
  std::vector<int> pixels;                 ///< with a measurement, of the region that is looked at
  std::vector<int> touches;                ///< of each label: how often that region touches it
  std::vector<int> in_line;                ///< points of that region in each row, or column
  std::vector<std::int32_t> around;        ///< labels that it touches
  std::vector<float> mean_costs;           ///< of each label's plane for its own points, -1 until it is asked for
  std::vector<float> costs;                ///< of each pixel for its own plane and for each of those around
  std::vector<int> place;                  ///< of a pixel of the image in `pixels`
  std::vector<std::int32_t> given;         ///< of each pixel: its new label
};

/// @brief Dissolves regions that the planes around them explain better than their own plane does.
///
/// Where two faces meet in a low step, patches that lie across it have a plane of their own between the two, which passes
/// for a face while the step is not much higher than the noise. Its points, though, are one by one nearer to either face
/// than to it. So a region is dissolved if the mean square of its points' distances from the nearest of the planes around
/// is less than nine tenths of that of their distances from its own. Only thin ones are judged, of which many points touch
/// what is around, and of less than 16 times the smallest size: in a wide face between two others the nearest plane would
/// change from point to point. Distances are along beams, squared, in variances of noise and tolerance, and 25 at most. A
/// point goes to that region around whose plane fits best over the region's pixels among the nine about it, or to none if
/// that is 3 standard deviations off. Of two that explain only each other, neither is dissolved. Thread-safe with memory of
/// one's own.
///
/// Two parallel lines lie on a plane whatever faces they are of, and one line on many. So regions of less than 16 times the
/// smallest size, of any shape, are dissolved too if seven eighths of their points are in one row or column of the image;
/// likewise if they are in two, and the region has less than five thirds of the smallest size and 100 points, or the planes
/// around cost its points one and a half variances each at most; each of these points goes to the plane nearest to it.
/// Sweeps that have lost lines, and sensors of few, show such.
///
/// Where noise is smooth (CoplanarityTolerance::inflation_growth), a bump of it passes for a region on the plane about it,
/// and no number of its points tells more. There, regions of any shape are dissolved too if beside them is one four times as
/// large, and too large to be judged, whose plane costs them at most three times what it costs its own points (two
/// variances at most): a face within 1.4 standard deviations of what that region shows.
/// Regions of fewer points than JudgedImage::smallest are neither judged nor given any.
/// @param planes a (see moments.h) of every label. @param runs of the labels, see listRuns(); likewise brought up to date.
void dissolveRegions(const JudgedImage& image, const std::vector<Eigen::Vector3d>& planes, DissolutionMemory& memory,
                     LabelImage& labels, std::vector<LabelRun>& runs, int threads = 1);

}  // namespace ppc
