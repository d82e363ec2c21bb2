// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/moments.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <algorithm>
#include <vector>

namespace ppc {

/// @brief A block of pixels of the grid and the plane fitted to it.
struct Patch {
  int row_begin = 0, row_end = 0;  ///< rows [begin, end)
  int col_begin = 0, col_end = 0;  ///< columns [begin, end)
  Moments moments;                 ///< of the valid points, about the sensor centre
  PlaneFit fit;                    ///< least-squares plane of the moments
  double range = 0.0;              ///< mean range of the valid points [m]
  double noise_factor = 1.0;       ///< noise of its ranges over what is typical at that range
  bool planar = false;             ///< passed the gate: enough points, residuals as small as the noise allows

  /// Pixels of the block, measured or not.
  int pixels() const { return (row_end - row_begin) * (col_end - col_begin); }
  /// Divides the weights by a variance.
  void weigh(double variance) {
    moments.scale(1.0 / variance);
    fit.chi2 /= variance;
  }
};

/// @brief Mutually exclusive patches that cover the image: strips of k columns, each cut into blocks of rows.
///
/// The blocks of a strip are as high as its columns are wide *in angle* (times `aspect`), whatever the ratio of tilt and
/// beam steps. So patches have about equal solid angle also towards the pole of a nodding scan, where the lines crowd
/// together. Incomplete patches at the right and bottom edges are kept.
struct PatchGrid {
  int rows = 0, cols = 0;            ///< of the image
  int strip_cols = 0;                ///< k
  std::vector<int> strip_rows;       ///< rows of a patch in each strip
  std::vector<int> strip_begin;      ///< number of each strip's first block, and one past the last
  std::vector<int> patch_of_block;   ///< index of each block's patch, or -1 if it is left out
  std::vector<Patch> patches;        ///< by bands of rows, strip by strip in each
  std::vector<char> truncated;       ///< patches of which points are missing where the range ends; empty if there are none
  std::vector<int> neighbour_begin;  ///< index into `neighbours` of each patch's first one, and one past the last
  std::vector<int> neighbours;       ///< patches that share an edge, patch by patch; may be longer than there are
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< mean sensor position: origin of all moments [m]

  int strips() const { return static_cast<int>(strip_rows.size()); }
  /// Index of the patch at a pixel; -1 if it is left out.
  int patchAt(int row, int col) const {
    const int strip = col / strip_cols;
    return patch_of_block[strip_begin[strip] + row / strip_rows[strip]];
  }
  /// Calls f(i) for the patches i that share an edge with patch `index`; a patch without points is given none.
  template <typename F>
  void forEachNeighbour(int index, F&& f) const {
    const int* const end = neighbours.data() + neighbour_begin[index + 1];  // not read again after each f
    for (const int* at = neighbours.data() + neighbour_begin[index]; at != end; ++at) f(*at);
  }
};

/// @brief Median angles between neighbouring beams of an image; both empty or 0: patches are to be square, as in the paper.
struct AngularSteps {
  double column = 0.0;       ///< from column to column
  std::vector<double> rows;  ///< from row to row, at columns some pixels apart; 0 where there is none to go by
};

/// @brief Working memory of measureSteps() and makePatchGrid(), which one image after the other may use.
struct PatchGridMemory {
  std::vector<std::vector<double>> angles;  ///< of one column, or all; one list a thread
  std::vector<int> patches_before;          ///< each part of the bands, and in all
  std::vector<std::vector<int>> links;      ///< neighbours of each part of the bands but the first one
  std::vector<int> link_counts;             ///< of each part
};

void measureSteps(const BeamGrid& grid, PatchGridMemory& memory, AngularSteps& steps, int threads = 1);

/// @brief Cuts the grid into patches, sums their moments with unit noise, w = r^2, and fits their planes.
/// @param equal_angle false: square k x k patches, as in the paper.
/// @param done if given, pixels with a label there are left out of the moments, and patches without any other are left out.
PatchGrid makePatchGrid(const BeamGrid& grid, int patch_size, bool equal_angle, const LabelImage* done = nullptr,
                        int threads = 1);

/// @brief The same with steps that are known, into patches that are there, whose memory is used again.
void makePatchGrid(const BeamGrid& grid, int patch_size, const AngularSteps& steps, const LabelImage* done, int threads,
                   PatchGridMemory& memory, PatchGrid& out);

}  // namespace ppc
