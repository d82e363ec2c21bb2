// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/cell_residuals.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/core/similarity.h"

#include <vector>

namespace ppc {

/// @brief Working memory of one CellResolver after the other.
struct ResolverMemory {
  struct Place {                       ///< four pixels of the cell, side by side
    Lanes inverse_count, best;         ///< of the pixels in each one's window; least cost so far
    LaneMask winner, open, undecided;  ///< open: the label may change; undecided: candidates other than its own are near
  };
  struct Candidate {
    std::int32_t label;
    CellResiduals squared;
    bool known;  ///< its residuals in the cell have been computed
  };

  std::vector<Candidate> candidates;
  std::vector<BeamLanes> middle, sides;
  std::vector<Lanes> own;         ///< squared residuals of the middle, candidate by candidate
  std::vector<float> side_costs;  ///< left and right, row by row
  std::vector<Lanes> across;      ///< sums over three columns
  std::vector<Place> places;
};

/// @brief Resolves the pixels of one cell among planes. Each pixel asks its window: three columns, and as many rows as cover
/// about the same angle. Not thread-safe; the arguments must outlive the object.
class CellResolver {
 public:
  /// @param planes by label, see labelPlanes(). @param memory overwritten.
  CellResolver(const BeamGrid& grid, const PatchGrid& cells, const std::vector<Eigen::Vector3d>& planes,
               const NoiseModel& noise, const CoplanarityTolerance& tolerance, ResolverMemory& memory);

  /// Fetches what resolve() will read of a cell into the cache, while something else is done: its rows lie far apart.
  void prefetch(const Patch& cell, const LabelImage& labels) const;

  /// Gives every pixel of a cell without a label, or with one from `first_open` on, the likeliest of the candidates, or 0.
  /// @param candidates in ascending order. @param keep: pixels that no candidate explains keep their label instead.
  /// @return whether labels have changed.
  bool resolve(const Patch& cell, const std::vector<std::int32_t>& candidates, std::int32_t first_open, bool keep,
               LabelImage& out);

 private:
  using Place = ResolverMemory::Place;
  using Candidate = ResolverMemory::Candidate;

  int reachOf(const Patch& cell) const;  // of windows, in rows
  CellNoise noiseOf(int pixel) const { return CellNoise(grid_, noise_, tolerance_, pixel); }
  CellResiduals residuals(const CellNoise& noise, std::int32_t label) const;
  void layOut(const Patch& cell);
  void readRows(int col, int lanes, int begin, int end);
  void openPlaces(const Patch& cell, int col, std::int32_t first_open, bool keep, const LabelImage& labels);
  bool isHeldBy(std::int32_t label) const;
  bool findUndecided(std::int32_t likely);
  void readWindow(const Patch& cell, int col, int lanes);
  void countWindows(LaneMask inside);
  void compete(std::size_t k);
  bool paint(const Patch& cell, int col, LabelImage& out) const;
  template <typename Cost>
  void sumAcross(const Cost& cost);
  template <typename F>
  void forEachSum(const F& f);

  const BeamGrid& grid_;
  const PatchGrid& cells_;
  const std::vector<Eigen::Vector3d>& planes_;
  const NoiseModel& noise_;
  const CoplanarityTolerance& tolerance_;
  Eigen::Vector3f center_;

  std::vector<Candidate>& candidates_;

  // Four columns of a cell with reach_ rows above and below, row by row, and the columns left and right of it: those of two
  // rows in one. Rows are counted from the uppermost of these, which may lie above the image; those of the cell are
  // [reach_, last_).
  int reach_ = 0, top_ = 0, last_ = 0;
  int first_undecided_ = 0, last_undecided_ = 0;  // rows of the cell: [first, last)
  int window_begin_ = 0, window_end_ = 0;         // rows within reach of those, as far as the image goes
  std::vector<BeamLanes>&middle_, &sides_;
  std::vector<Lanes>& own_;
  std::size_t stride_ = 0;  // from one candidate's to the next one's
  std::vector<float>& side_costs_;
  std::vector<Lanes>& across_;
  std::vector<Place>& places_;
};

}  // namespace ppc
