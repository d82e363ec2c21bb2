// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/moments.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <Eigen/Core>
#include <vector>

namespace ppc {

/// @brief Working memory of thinSmoothNoise() and labelThinned(), which one image after the other may use.
struct SmoothNoiseMemory {
  /// Residuals of planes of a few points at one place: side by side, and so many pixels apart [m].
  struct Residual {
    int pixel;  ///< the place
    double near;
  };
  /// The plane of a region of the thinned image.
  struct ThinnedRegion {
    Moments moments;  ///< of its points
    Eigen::Vector3f a = Eigen::Vector3f::Zero();
    float farthest = 0.0F;  ///< that a point may be off along its beam [m]
  };
  /// Where a row or column lies among those that were kept.
  struct Place {
    int before, after;  ///< numbers in the thinned image
    float along;        ///< 0..1 between the two
  };

  std::vector<Residual> residuals;
  std::vector<double> bare, tolerated;  ///< ratios of residuals
  std::vector<int> rows, cols;          ///< of the image, that are kept
  std::vector<Place> row_places, col_places;
  BeamGrid grid;      ///< the thinned image
  LabelImage labels;  ///< of `grid`
  std::vector<ThinnedRegion> regions;
};

/// @brief Looks whether the errors of ranges are alike over so many pixels that patches take them for the surface, as those
/// of stereo cameras are, which match windows of some ten pixels; then leaves out all but every s-th row and column.
///
/// Planes of 4 x 4 points leave the same residuals however far apart the points lie, if their errors are independent. Where
/// errors are alike over s pixels, residuals grow with the distance of the points up to s and stay from there on; those of a
/// curved surface would go on growing, by the square. Where what noise does is found over more pixels than a patch has, no
/// statistics of patches helps: walls fall into their bumps. Points that are s pixels apart have independent errors, so an
/// image of them is what the method is made for.
/// @param tolerance of planes [m]: smooth errors that do not stand out from it do no harm, and a finer image tells more.
/// @return whether any are left out; then memory.grid is the thinned image.
bool thinSmoothNoise(const BeamGrid& grid, double tolerance, SmoothNoiseMemory& memory);

/// @brief Labels of the whole image from memory.labels: each pixel has that of the kept ones around it which weighs most,
/// interpolated between them, of those whose planes its range allows.
/// @param grid and memory as thinSmoothNoise() left them. @param center about which beams begin [m].
void labelThinned(const BeamGrid& grid, const Eigen::Vector3d& center, SmoothNoiseMemory& memory, LabelImage& labels);

}  // namespace ppc
