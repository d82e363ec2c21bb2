// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/patch_sample.h"
#include "patch_plane_clustering/core/similarity.h"

#include <array>
#include <utility>
#include <vector>

namespace ppc {

/// @brief Patches that lie on one plane.
struct Cluster {
  Moments moments;
  PlaneFit fit;
  int begin = 0, end = 0;  ///< its patches are members[begin, end) of all clusters

  int size() const { return end - begin; }
};

/// @brief Clusters of the planar patches of an image.
struct PatchClusters {
  std::vector<Cluster> clusters;
  std::vector<int> members;     ///< patches of all clusters, one cluster after the other, in the order in which they joined
  std::vector<int> cluster_of;  ///< for every patch: index of its cluster, or -1
};

/// @brief A patch and the planar patches around it, if it is too small to tell by itself where it lies and if they are flat.
struct Surroundings {
  Moments moments;
  PlaneFit fit;
  double radius = 0.0;
  double inflation = 1.0;  ///< see CoplanarityTolerance
};

/// @brief Surroundings of some of the patches, and to which patches they belong.
struct FoundSurroundings {
  std::vector<int> of;
  std::vector<Surroundings> around;
  std::vector<int> reached;  ///< for every patch: the last one from which it was
  std::vector<int> wave;     ///< those reached from one patch
};

/// @brief Working memory of growClusters(), which one image after the other may use.
struct GrowthMemory {
  std::vector<FoundSurroundings> found;       ///< part by part of the patches
  std::vector<std::pair<double, int>> seeds;  ///< roughness of the surroundings, index of the patch
  std::vector<double> roughness, radius;      ///< of every patch, where it is planar
  std::vector<double> precision;              ///< misfit(): precision times tau^2 across the surface, of the same
  std::vector<char> kind;                     ///< of every patch: 0, 1 if it is planar, 2 if it may need its surroundings
  std::vector<int> around_of;                 ///< for every patch: index of its surroundings, or -1
  std::vector<Surroundings> around;
};

/// @brief Divides the unit-noise moments of every patch, and the chi-square of its fit, by the variance of a range there.
/// Call once.
void weighPatches(const NoiseModel& noise, PatchGrid& grid, int threads = 1);

/// @brief Marks the patches that are flat within the noise and the tolerance. @param grid with weighed moments.
void gatePatches(const NoiseModel& noise, const CoplanarityTolerance& tolerance, PatchGrid& grid, int threads = 1);

/// @brief Both, one after the other, in one pass over the patches.
void weighAndGatePatches(const NoiseModel& noise, const CoplanarityTolerance& tolerance, PatchGrid& grid, int threads = 1);

/// @brief How much more the planes of neighbouring patches differ than white noise explains: noise that is correlated along
/// a line, or shared by a whole line, does not average out within a patch. From a low quantile over all pairs. At least 1.
double estimateInflation(const PatchGrid& grid);

/// @brief The same in two steps: samples of all parts [0, kSampleParts) of the patches, several at a time if
/// there are threads for them, and what they tell, which uses them up.
struct InflationMemory {
  std::array<std::vector<double>, kSampleParts> excesses;
};
void sampleInflation(const PatchGrid& grid, int part, InflationMemory& memory);
double inflationOf(InflationMemory& memory);

/// @brief With what, and by which measure, a patch is compared before it joins a cluster.
struct PatchComparison {
  bool running_plane = true;  ///< with the plane of the whole cluster; false: with the neighbour that it is reached from
  bool noise_aware = true;    ///< by similarity(); false: by fixedSimilarity()
};

/// @brief Breadth-first clustering: from the flattest patch on, neighbours join a cluster while they are similar to its
/// running plane; the plane is refitted at each. Where noise leaves the distance of a patch less certain than the tolerance,
/// the planar patches around it (one ring, at much noise two), if they are flat together, must be similar to the plane of a
/// large cluster too: else small steps and weak creases would be crossed one patch at a time.
PatchClusters growClusters(const PatchGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                           double threshold, const PatchComparison& comparison = {});

/// @brief The same into clusters that are there, whose memory is used again.
void growClusters(const PatchGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance, double threshold,
                  const PatchComparison& comparison, GrowthMemory& memory, PatchClusters& out, int threads = 1);

}  // namespace ppc
