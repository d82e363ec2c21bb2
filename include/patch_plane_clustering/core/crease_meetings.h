// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/label_pairs.h"
#include "patch_plane_clustering/core/row_runs.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Where labels meet in an image, pixel by pixel, and pair by pair.
struct CreaseMeetings {
  struct Place {
    int pixel;
    int columns;  ///< so many pixels from there on meet those above them; 0: it meets the pixel before it in its row
  };
  /// Two labels, first < second, that are next to each other somewhere.
  struct Pair {
    std::int32_t first, second;
    int index;       ///< in the order of their first meetings
    int begin, end;  ///< of theirs in `places`
  };
  std::vector<Pair> pairs;  ///< ascending
  std::vector<Place> places;
  std::vector<int> points;  ///< pixels of each label

  /// Calls f(pixel) for every pixel of a pair that meets the one before it or the one above it, twice for those that meet
  /// both.
  template <typename F>
  void forEachPixel(const Pair& pair, const F& f) const {
    for (int m = pair.begin; m < pair.end; ++m) {
      const Place& place = places[m];
      for (int k = 0; k < std::max(1, place.columns); ++k) f(place.pixel + k);
    }
  }

  struct Meeting {
    int pair;  ///< its index
    Place place;
  };
  std::vector<Meeting> meetings;  ///< scratch: in scan order
  std::vector<int> next;          ///< scratch: of each pair, by index
  RowRuns runs;                   ///< scratch
  LabelPairIndex index;           ///< scratch
};

/// @brief Lists where labels of at least `smallest` points meet. @param runs of an image of `rows` by `cols` pixels, see
/// listRuns(). @param labels one more than the highest label. @param out overwritten.
void findCreaseMeetings(const std::vector<LabelRun>& runs, int rows, int cols, std::size_t labels, int smallest,
                        CreaseMeetings& out);

}  // namespace ppc
