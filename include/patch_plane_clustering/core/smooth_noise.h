// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/moments.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <Eigen/Core>
#include <array>
#include <vector>

namespace ppc {

/// @brief Working memory of the functions below, which one image after the other may use, and what thinSmoothNoise() tells
/// labelThinned().
struct SmoothNoiseMemory {
  /// Where planes of 4 x 4 points are fitted.
  struct Place {
    int pixel;        ///< in the middle
    double residual;  ///< of the plane of points side by side [m]
  };
  /// Between which of the rows or columns that were kept one of the image lies.
  struct Between {
    int before, after;  ///< numbers in the thinned image
    float along;        ///< 0..1 between the two
  };
  /// A region of the thinned image.
  struct ThinnedRegion {
    Moments moments;
    Eigen::Vector3d a = Eigen::Vector3d::Zero();  ///< its plane, see moments.h
    double farthest = 0.0;                        ///< that a point may be off along its beam [m]
    double range2 = 1.0;                          ///< mean square of the ranges [m^2]
  };

  std::vector<Place> places;
  std::array<std::vector<double>, 2> values;  ///< of all places
  int stride = 1;                             ///< every so many rows and columns one is kept
  std::vector<int> rows, cols;                ///< of the image, that are kept
  std::vector<Between> row_between, col_between;
  BeamGrid grid;      ///< the thinned image
  LabelImage labels;  ///< of `grid`
  std::vector<ThinnedRegion> regions;
};

/// @brief Looks whether the errors of ranges are alike over so many pixels that patches take them for the surface, as those
/// of stereo cameras are, which match windows of some ten pixels; then leaves out all but one of every 2, 3, 4, 6 or 8 rows
/// and columns.
///
/// Planes of 4 x 4 points (PointSquare) leave the same residuals however far apart the points lie, if their errors are
/// independent. Where errors are alike over s pixels, residuals grow with the distance of the points up to about 2 s and
/// stay from there on; of a surface that bends they would go on growing, by the square. Where what noise does is found over
/// more pixels than a patch has, no statistics of patches helps: walls fall into their bumps. In an image of points so far
/// apart that their residuals are half of what they grow to, patches see enough of it to estimate the rest
/// (NoiseCorrelation), and no more is thrown away. Images that would keep less than 40 rows or columns stay as they are, and
/// so do those whose errors are alike along rows only, or along columns only. A relief of bumps of up to some twenty pixels
/// all over the image looks the same, and is taken for noise.
/// @param tolerance of planes, above 0 [m]: smooth errors that do not stand out from it do no harm, and a finer image tells
/// more.
/// @return whether any are left out; then memory.grid is the thinned image, otherwise what it was.
bool thinSmoothNoise(const BeamGrid& grid, double tolerance, SmoothNoiseMemory& memory);

/// @brief Whether errors of points side by side are alike along rows and along columns both, as those of range cameras are,
/// though over no more pixels than a patch has: in most places PointSquare::alongRows() and alongColumns() are larger than
/// of independent errors. Those of tilting lasers are alike along the lines alone. For images
/// known to have errors that are not white (CoplanarityTolerance::isWhite()): a surface that bends within a square is alike
/// around as well.
/// @param memory of which no result of thinSmoothNoise() is touched.
bool areErrorsAlikeAround(const BeamGrid& grid, SmoothNoiseMemory& memory);

/// @brief Labels of the whole image from memory.labels: each pixel has that of the kept ones around it which weighs most,
/// interpolated between them, of those whose planes its range allows.
/// @param grid and memory as thinSmoothNoise() left them, with labels from 0 on for each pixel of memory.grid.
/// @param center about which beams begin [m]. @param labels overwritten; do not depend on the number of threads.
void labelThinned(const BeamGrid& grid, const Eigen::Vector3d& center, SmoothNoiseMemory& memory, LabelImage& labels,
                  int threads = 1);

}  // namespace ppc
