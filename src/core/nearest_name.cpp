// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/nearest_name.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numeric>

namespace ppc {
namespace {

// Levenshtein's, one row of the table at a time.
int editDistance(const std::string& a, const std::string& b) {
  std::vector<int> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row.back();
}

}  // namespace

std::string nearestName(const std::vector<std::string>& names, const std::string& misspelt) {
  std::string nearest;
  int smallest = std::numeric_limits<int>::max();
  for (const std::string& name : names) {
    const int distance = editDistance(name, misspelt);
    if (distance < smallest) {
      smallest = distance;
      nearest = name;
    }
  }
  return nearest;
}

}  // namespace ppc
