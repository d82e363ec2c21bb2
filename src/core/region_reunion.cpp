// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_reunion.h"

#include "patch_plane_clustering/core/near_fit.h"
#include "patch_plane_clustering/core/plane_distance.h"

namespace ppc {
namespace {

constexpr double kMostExcess = 20.0;  // of chi-square
// The same where planes are as good as one along the border: its points went to the nearer one, which tells them apart.
constexpr double kSame = 0.15, kMostExcessOfSame = 60.0;
constexpr int kFewestMeetings = 5;
// Of planes that may be one, at a glance: least cosine between them, and largest mean distance where regions meet, in
// standard deviations.
constexpr double kParallel = 0.985, kApart = 0.4;

double excessOf(const Moments& a, const Moments& b) { return fitPlane(a + b).chi2 - fitPlane(a).chi2 - fitPlane(b).chi2; }

// Excess up to which planes of a pair are one; 0 if they are not near each other where its regions meet.
double mostExcess(const JudgedImage& image, const CreaseMeetings& meetings, const CreaseMeetings::Pair& pair,
                  const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  if (a.dot(b) < kParallel * a.norm() * b.norm()) return 0.0;
  const PlaneDistance distance = distanceAt(image, meetings, pair, a, b);
  if (distance.meetings < kFewestMeetings || distance.in_sigmas > kApart) return 0.0;
  return distance.in_sigmas < kSame ? kMostExcessOfSame : kMostExcess;
}

}  // namespace

bool reuniteRegions(const JudgedImage& image, const CreaseMeetings& meetings, const std::vector<LabelRun>& runs,
                    RegionReunionMemory& memory, std::vector<Eigen::Vector3d>& planes, LabelImage& labels) {
  if (!image.tolerance.isWhite()) return false;
  memory.alike.clear();
  memory.wanted.assign(planes.size(), 0);
  for (const CreaseMeetings::Pair& pair : meetings.pairs) {
    const double most = mostExcess(image, meetings, pair, planes[pair.first], planes[pair.second]);
    if (most == 0.0) continue;
    memory.alike.emplace_back(most, LabelPair(pair.first, pair.second));
    memory.wanted[pair.first] = memory.wanted[pair.second] = 1;
  }
  if (memory.alike.empty()) return false;
  sumNear(image, runs, memory.wanted, planes, memory.sums);
  memory.candidates.clear();
  for (const auto& [most, pair] : memory.alike) {
    const double excess = excessOf(memory.sums[pair.first], memory.sums[pair.second]);
    if (excess <= most) memory.candidates.emplace_back(excess, pair);
  }
  if (memory.candidates.empty()) return false;
  joinLabels(kMostExcessOfSame, excessOf, memory.candidates, memory.sums, memory.names, planes);
  renameLabels(memory.names, runs, labels);
  return true;
}

}  // namespace ppc
