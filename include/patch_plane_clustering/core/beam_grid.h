// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/range_image.h"

#include <Eigen/Core>
#include <limits>
#include <vector>

namespace ppc {

/// @brief What every segmenter works on: an organised grid of beams, in structure-of-arrays layout.
///
/// Made from a RangeImage (toBeamGrid), whose geometry gives each beam's direction and origin exactly, or from an organised
/// cloud (beamGridFromPoints), whose directions come from its valid points. Every pixel has a finite unit direction, also
/// where the range is invalid. Coordinates are metres in the frame of the image.
struct BeamGrid {
  int rows = 0;
  int cols = 0;
  std::vector<float> dir_x, dir_y, dir_z;  ///< rows x cols: unit direction of the beam
  std::vector<float> range;                ///< rows x cols: distance along the beam [m]; NaN where there is no measurement
  std::vector<float> origin_x, origin_y,
      origin_z;              ///< rows x cols: start of the beam [m]; all three empty: the frame's origin
  bool beams_exact = false;  ///< directions come from the scan geometry, not from the (noisy) points

  int index(int row, int col) const { return row * cols + col; }
  int size() const { return rows * cols; }
  bool valid(int i) const { return range[i] > 0.0F; }  // false for NaN
  Eigen::Vector3f direction(int i) const { return {dir_x[i], dir_y[i], dir_z[i]}; }
  Eigen::Vector3f origin(int i) const {
    return origin_x.empty() ? Eigen::Vector3f::Zero() : Eigen::Vector3f(origin_x[i], origin_y[i], origin_z[i]);
  }
  /// The measured point [m]; NaN where the range is invalid.
  Eigen::Vector3f point(int i) const { return origin(i) + range[i] * direction(i); }
};

/// @brief Has the processor fetch what is known of the beam at a pixel, and with it of its neighbours in the row, while it
/// does something else: a grid is more arrays than it foresees by itself.
inline void prefetchBeams(const BeamGrid& grid, int i) {
  for (const std::vector<float>* numbers : {&grid.range, &grid.dir_x, &grid.dir_y, &grid.dir_z}) {
    __builtin_prefetch(numbers->data() + i);
  }
  if (grid.origin_x.empty()) return;
  for (const std::vector<float>* numbers : {&grid.origin_x, &grid.origin_y, &grid.origin_z}) {
    __builtin_prefetch(numbers->data() + i);
  }
}

/// @brief Beams of a range image. @throws std::invalid_argument as checkConsistent().
BeamGrid toBeamGrid(const RangeImage& image);

/// @brief What the beams of all rows of a range image share, column by column; three more
/// entries than columns, for vector code.
struct BeamColumns {
  std::vector<float> cosine, sine;  ///< of the bearing
  std::vector<float> along;         ///< 0..1 between the two poses on either side
  std::vector<int> begin;           ///< first column of each stretch between poses, and one past the last column
};

/// @brief The same into a grid that is there, whose memory is used again. It is left in part changed if this throws.
/// @param columns overwritten; its memory is used again, too.
void toBeamGrid(const RangeImage& image, BeamColumns& columns, BeamGrid& grid, int threads = 1);

/// @brief Beams of an organised cloud with the sensor at `viewpoint`.
/// @param x,y,z rows x cols coordinates, row-major [m]; any non-finite coordinate makes the pixel invalid, and so does a
/// point on the viewpoint itself, or 1000 km or more from it. Directions of invalid pixels are interpolated from valid ones.
/// @throws std::invalid_argument if the sizes disagree or a side is not positive.
BeamGrid beamGridFromPoints(int rows, int cols, const std::vector<float>& x, const std::vector<float>& y,
                            const std::vector<float>& z, const Eigen::Vector3f& viewpoint = Eigen::Vector3f::Zero());

/// @brief The same into a grid that is there, whose memory is used again.
void beamGridFromPoints(int rows, int cols, const std::vector<float>& x, const std::vector<float>& y,
                        const std::vector<float>& z, const Eigen::Vector3f& viewpoint, BeamGrid& grid);

}  // namespace ppc
