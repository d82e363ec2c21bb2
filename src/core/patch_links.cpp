// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/patch_links.h"

#include "patch_plane_clustering/core/part_lists.h"
#include "patch_plane_clustering/core/patch_order.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace ppc {
namespace {

// Writes the neighbours of a block's patch, and returns where they end.
int* linkBlock(const PatchGrid& grid, int strip, int k, int* to) {
  const int* const begin = grid.strip_begin.data() + strip;
  const int* const height = grid.strip_rows.data() + strip;
  const int* const patches = grid.patch_of_block.data();
  const auto add = [&to](int patch) {
    *to = patch;
    to += patch >= 0 ? 1 : 0;  // others are left out
  };
  if (k > 0) add(patches[begin[0] + k - 1]);
  if (begin[0] + k + 1 < begin[1]) add(patches[begin[0] + k + 1]);
  const auto addBeside = [&](int side) {
    if (height[side] == height[0]) return add(patches[begin[side] + k]);  // as nearly everywhere
    const int first_row = k * height[0], last_row = std::min(first_row + height[0], grid.rows) - 1;
    for (int i = first_row / height[side]; i <= last_row / height[side]; ++i) add(patches[begin[side] + i]);
  };
  if (strip > 0) addBeside(-1);
  if (strip + 1 < grid.strips()) addBeside(1);
  return to;
}

// Lists the neighbours of the patches of bands [begin, end), and where each one's begin. Returns how many there are; the
// list may be longer, so that it is not cleared for each image.
int linkBands(int begin, int end, std::vector<int>& neighbours, PatchGrid& grid) {
  int size = 0;
  forEachBlock(grid, begin, end, [&](int strip, int k) {
    const int p = grid.patch_of_block[grid.strip_begin[strip] + k];
    if (p < 0) return;
    grid.neighbour_begin[p] = size;
    if (grid.patches[p].moments.n == 0) return;  // nothing is ever asked from there
    const auto most = static_cast<std::size_t>(size + 4 + 2 * grid.strip_rows[strip]);
    if (most > neighbours.size()) neighbours.resize(2 * most);
    size = static_cast<int>(linkBlock(grid, strip, k, neighbours.data() + size) - neighbours.data());
  });
  return size;
}

}  // namespace

void linkPatches(int threads, PatchGridMemory& memory, PatchGrid& grid) {
  const int bands = bandsOf(grid);
  grid.neighbour_begin.resize(grid.patches.size() + 1);
  std::vector<int>& sizes = memory.link_counts;
  sizes.resize(static_cast<std::size_t>(rangeCount(threads, bands)));
  const int parts = listInParts(threads, bands, grid.neighbours, memory.links,
                                [&](int part, int begin, int end, std::vector<int>& neighbours) {
                                  sizes[part] = linkBands(begin, end, neighbours, grid);
                                });
  int links = 0;
  for (int& size : sizes) links += std::exchange(size, links);  // from now on where they begin
  if (grid.neighbours.size() < static_cast<std::size_t>(links)) grid.neighbours.resize(static_cast<std::size_t>(links));
  forEachPart(threads, parts - 1, [&](int k) {
    const int part = k + 1, first = sizes[part], end = part + 1 < parts ? sizes[part + 1] : links;
    forEachBlock(grid, partBegin(bands, parts, part), partBegin(bands, parts, part + 1), [&](int strip, int block) {
      const int p = grid.patch_of_block[grid.strip_begin[strip] + block];
      if (p >= 0) grid.neighbour_begin[p] += first;
    });
    std::copy_n(memory.links[k].begin(), end - first, grid.neighbours.begin() + first);
  });
  grid.neighbour_begin.back() = links;
}

}  // namespace ppc
