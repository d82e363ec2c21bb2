// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_samples.h"

#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/point_lanes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ppc {
namespace {

constexpr int kMaxSamples = 1500;
constexpr int kBlock = 64;             // samples summed in single precision
constexpr float kMinCosine = 0.1F;     // of incidence, in the noise across a plane
constexpr float kFarFromPlane = 4.0F;  // in standard deviations: such samples are left out

struct SampleSums {
  Eigen::Vector3d points = Eigen::Vector3d::Zero(), beams = Eigen::Vector3d::Zero();
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();  // of the points; the lower triangle

  void add(const PointLanes& sums, Lanes ux, Lanes uy, Lanes uz) {
    points += Eigen::Vector3d(sumLanes(sums.x), sumLanes(sums.y), sumLanes(sums.z));
    beams += Eigen::Vector3d(sumLanes(ux), sumLanes(uy), sumLanes(uz));
    products(0, 0) += sumLanes(sums.xx);
    products(1, 0) += sumLanes(sums.xy);
    products(2, 0) += sumLanes(sums.xz);
    products(1, 1) += sumLanes(sums.yy);
    products(2, 1) += sumLanes(sums.yz);
    products(2, 2) += sumLanes(sums.zz);
  }
};

// Reads pixels into samples about the first of them; those that fill up the last lanes are that again.
SampleSums readSamples(const BeamGrid& grid, const int* pixels, int n, const NoiseModel& noise, SurfaceSamples& samples,
                       SampledBeams& beams) {
  for (auto* numbers : {&beams.ux, &beams.uy, &beams.uz, &beams.sigma}) {
    if (numbers->size() < samples.size) numbers->resize(samples.size);
  }
  const Eigen::Vector3f first = grid.point(pixels[0]);
  samples.center = first.cast<double>();
  SampleSums total;
  for (int begin = 0; begin < n; begin += kBlock) {
    PointLanes sums;
    Lanes ux = {}, uy = {}, uz = {};
    for (int k = begin; k < std::min(begin + kBlock, n); k += kLanes) {
      int four[kLanes];
      for (int lane = 0; lane < kLanes; ++lane) four[lane] = pixels[std::min(k + lane, n - 1)];
      const LaneMask inside = firstLanes(n - k);
      BeamLanes beam(grid, four, inside);
      const Lanes x = inside ? beam.origin_x + beam.range * beam.dir_x - first.x() : Lanes{};
      const Lanes y = inside ? beam.origin_y + beam.range * beam.dir_y - first.y() : Lanes{};
      const Lanes z = inside ? beam.origin_z + beam.range * beam.dir_z - first.z() : Lanes{};
      Lanes sigma;
      for (int lane = 0; lane < kLanes; ++lane)
        sigma[lane] = static_cast<float>(noise.sigmaAt(four[lane], beam.range[lane]));
      beam.dir_x = inside ? beam.dir_x : Lanes{};
      beam.dir_y = inside ? beam.dir_y : Lanes{};
      beam.dir_z = inside ? beam.dir_z : Lanes{};
      storeLanes(x, samples.x + k);
      storeLanes(y, samples.y + k);
      storeLanes(z, samples.z + k);
      storeLanes(beam.dir_x, beams.ux.data() + k);
      storeLanes(beam.dir_y, beams.uy.data() + k);
      storeLanes(beam.dir_z, beams.uz.data() + k);
      storeLanes(sigma, beams.sigma.data() + k);
      sums.add(x, y, z);
      ux += beam.dir_x;
      uy += beam.dir_y;
      uz += beam.dir_z;
    }
    total.add(sums, ux, uy, uz);
  }
  return total;
}

// Moves samples to a center on their plane and along their beams onto it, and weighs those near it. Noise runs along the
// beams: where it is large, points as measured would lie off their place by an amount that goes with their height, by more
// the flatter the beam, and a flat surface would seem to bend.
void weighSamples(const Eigen::Vector3f& move, const Eigen::Vector3f& normal, float rms, int n, float stride,
                  const SampledBeams& beams, SurfaceSamples& samples) {
  LaneMask used = {};
  for (int i = 0; i < n; i += kLanes) {
    const Lanes x = loadLanes<Lanes>(samples.x + i) - move.x(), y = loadLanes<Lanes>(samples.y + i) - move.y();
    const Lanes z = loadLanes<Lanes>(samples.z + i) - move.z();
    const auto ux = loadLanes<Lanes>(&beams.ux[i]), uy = loadLanes<Lanes>(&beams.uy[i]), uz = loadLanes<Lanes>(&beams.uz[i]);
    const Lanes height = normal.x() * x + normal.y() * y + normal.z() * z;
    const Lanes towards = -(normal.x() * ux + normal.y() * uy + normal.z() * uz);
    const Lanes cosine = towards > fill(kMinCosine) ? towards : fill(kMinCosine);
    const Lanes sigma = loadLanes<Lanes>(&beams.sigma[i]) * cosine;
    const Lanes limit = kFarFromPlane * (sigma > fill(rms) ? sigma : fill(rms));
    const LaneMask near = (height <= limit) & (height >= -limit) & firstLanes(n - i);
    used += near;
    const Lanes ahead = height / cosine, rest = height - ahead * towards;  // 0 but for beams that graze the plane
    storeLanes(x + ahead * ux - rest * normal.x(), samples.x + i);
    storeLanes(y + ahead * uy - rest * normal.y(), samples.y + i);
    storeLanes(z + ahead * uz - rest * normal.z(), samples.z + i);
    storeLanes(height, samples.height + i);
    storeLanes(near ? stride / (sigma * sigma) : Lanes{}, samples.weight + i);
  }
  samples.used = countLanes(used);
}

// Lays out columns for the samples of each label.
void placeSamples(SampleMemory& memory) {
  const auto length_of = [&](std::size_t label) {
    const auto n = static_cast<std::size_t>(memory.end[label] - memory.begin[label]);
    return n < 3 ? 0 : (n + kLanes - 1) / kLanes * kLanes;
  };
  std::size_t room = 0;
  for (std::size_t label = 0; label < memory.regions.size(); ++label) room += SurfaceSamples::kColumns * length_of(label);
  if (memory.columns.size() < room) memory.columns.resize(room);
  float* columns = memory.columns.data();
  for (std::size_t label = 0; label < memory.regions.size(); ++label) {
    const std::size_t length = length_of(label);
    if (length == 0) continue;
    memory.regions[label].points = memory.count[label];
    memory.regions[label].samples.place(columns, length);
    columns += SurfaceSamples::kColumns * length;
  }
}

}  // namespace

void chooseSamples(const BeamGrid& grid, const std::vector<LabelRun>& runs, SampleMemory& memory) {
  std::vector<int>&count = memory.count, &begin = memory.begin, &end = memory.end, &next = memory.next;
  countPoints(runs, static_cast<std::size_t>(highestLabel(runs)) + 1, count);
  std::vector<RegionSamples>& regions = memory.regions;
  regions.assign(count.size(), RegionSamples());
  begin.assign(count.size() + 1, 0);
  for (std::size_t label = 0; label < count.size(); ++label) {
    regions[label].stride = std::max(1, count[label] / kMaxSamples);
    begin[label + 1] = begin[label] + (count[label] + regions[label].stride - 1) / regions[label].stride;
  }
  const auto room = static_cast<std::size_t>(begin.back());
  if (memory.pixels.size() < room) memory.pixels.resize(room);
  end = begin;
  next.assign(count.size(), 0);
  int* const pixels = memory.pixels.data();
  for (const LabelRun& run : runs) {
    const int stride = regions[run.label].stride;
    int i = run.begin + next[run.label], at = end[run.label];
    for (; i < run.end; i += stride) {
      pixels[at] = i;
      at += grid.valid(i) ? 1 : 0;
    }
    end[run.label] = at;
    next[run.label] = i - run.end;
  }
  placeSamples(memory);
}

void sampleRegion(const BeamGrid& grid, const NoiseModel& noise, int label, SampledBeams& beams, SampleMemory& memory) {
  RegionSamples& region = memory.regions[label];
  SurfaceSamples& samples = region.samples;
  const int begin = memory.begin[label], n = memory.end[label] - begin;
  const SampleSums sums = readSamples(grid, memory.pixels.data() + begin, n, noise, samples, beams);
  const Eigen::Vector3d mean = sums.points / n;
  const Eigen::Matrix3d scatter = sums.products - n * mean * mean.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  samples.normal = eigen.eigenvectors().col(0);
  if (samples.normal.dot(sums.beams) > 0.0) samples.normal = -samples.normal;
  samples.center += mean;
  region.sigma = noise.sigma(samples.center.norm());
  region.plane = {samples.normal, samples.normal.dot(samples.center)};
  const double rms = std::sqrt(std::max(0.0, eigen.eigenvalues()[0]) / n);
  weighSamples(mean.cast<float>(), samples.normal.cast<float>(), static_cast<float>(rms), n,
               static_cast<float>(region.stride), beams, samples);
}

}  // namespace ppc
