// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/parallel.h"

#include <cstddef>
#include <vector>

namespace ppc {

/// @brief Has things [0, count) listed in rangeCount() parts, on several threads. @param list list(part, begin, end, out):
/// lists those of [begin, end); called as by forEachPart(). @param first what the first part lists into, so that others may
/// be appended. @param rest the same for each of the others; lists are kept from call to call, as they were left.
/// @return how many parts there are.
template <typename T, typename F>
int listInParts(int threads, int count, std::vector<T>& first, std::vector<std::vector<T>>& rest, F&& list) {
  const int parts = rangeCount(threads, count);
  if (rest.size() + 1 < static_cast<std::size_t>(parts)) rest.resize(static_cast<std::size_t>(parts - 1));
  forEachPart(threads, parts, [&](int part) {
    list(part, partBegin(count, parts, part), partBegin(count, parts, part + 1), part == 0 ? first : rest[part - 1]);
  });
  return parts;
}

/// @brief The same into one list: `all` is overwritten with what the parts list, one after the other. @param list as above,
/// but `out` is empty when it is called.
template <typename T, typename F>
void gatherInParts(int threads, int count, std::vector<T>& all, std::vector<std::vector<T>>& rest, F&& list) {
  const int parts = listInParts(threads, count, all, rest, [&](int part, int begin, int end, std::vector<T>& out) {
    out.clear();
    list(part, begin, end, out);
  });
  for (int part = 1; part < parts; ++part) all.insert(all.end(), rest[part - 1].begin(), rest[part - 1].end());
}

}  // namespace ppc
