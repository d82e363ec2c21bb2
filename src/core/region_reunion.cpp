// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_reunion.h"

#include "patch_plane_clustering/core/near_fit.h"
#include "patch_plane_clustering/core/plane_distance.h"

#include <algorithm>
#include <cstdint>

namespace ppc {
namespace {

constexpr double kMostExcess = 20.0;  // of chi-square
// The same where planes are as good as one along the border: its points went to the nearer one, which tells them apart.
constexpr double kSame = 0.15, kMostExcessOfSame = 60.0;
constexpr int kFewestMeetings = 5, kFewestPoints = 6;
constexpr double kApart = 0.4;      // of planes that may be one, where their regions meet, in standard deviations
constexpr double kLeastNear = 0.5;  // of a region's points, that are near its plane

double excessOf(const Moments& a, const Moments& b) { return fitPlane(a + b).chi2 - fitPlane(a).chi2 - fitPlane(b).chi2; }

// Excess up to which planes of a pair are one; 0 if they are not near each other where its regions meet.
double mostExcess(const JudgedImage& image, const CreaseMeetings& meetings, const CreaseMeetings::Pair& pair,
                  const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  if (!areAlmostParallel(a, b)) return 0.0;
  const PlaneDistance distance = distanceAt(image, meetings, pair, a, b);
  if (distance.meetings < kFewestMeetings || distance.in_sigmas > kApart) return 0.0;
  return distance.in_sigmas < kSame ? kMostExcessOfSame : kMostExcess;
}

}  // namespace

bool reuniteRegions(const JudgedImage& image, const CreaseMeetings& meetings, const std::vector<LabelRun>& runs,
                    RegionReunionMemory& memory, std::vector<Eigen::Vector3d>& planes, LabelImage& labels) {
  if (!image.tolerance.isWhite()) return false;
  std::vector<JoinCandidate>& candidates = memory.candidates;
  candidates.clear();
  memory.wanted.assign(planes.size(), 0);
  for (const CreaseMeetings::Pair& pair : meetings.pairs) {
    const double most = mostExcess(image, meetings, pair, planes[pair.first], planes[pair.second]);
    if (most == 0.0) continue;
    candidates.push_back({0.0, most, {pair.first, pair.second}});
    memory.wanted[pair.first] = memory.wanted[pair.second] = 1;
  }
  if (candidates.empty()) return false;
  sumNear(image, runs, memory.wanted, planes, memory.sums);
  const auto isKnown = [&](std::int32_t label) {
    return memory.sums[label].n >= std::max<double>(kFewestPoints, kLeastNear * meetings.points[label]);
  };
  const auto isOther = [&](JoinCandidate& candidate) {
    const auto [a, b] = candidate.pair;
    if (!isKnown(a) || !isKnown(b)) return true;
    candidate.misfit = excessOf(memory.sums[a], memory.sums[b]);
    return candidate.misfit > candidate.most;
  };
  candidates.erase(std::remove_if(candidates.begin(), candidates.end(), isOther), candidates.end());
  if (candidates.empty()) return false;
  joinLabels(excessOf, candidates, memory.sums, memory.names, planes);
  renameLabels(memory.names, runs, labels);
  return true;
}

}  // namespace ppc
