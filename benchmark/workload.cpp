// SPDX-License-Identifier: BSD-3-Clause
#include "workload.h"

#include "patch_plane_clustering/sim/scanner.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace ppc::bench {
namespace {

constexpr std::uint64_t kSeed = 1;

RangeImage simulate(int points) {
  sim::ScannerOptions options;
  const double factor = std::sqrt(static_cast<double>(points) / kStandardPoints);
  options.errors = sim::ErrorModel::dataSheet(1.0);
  options.motion.lines_per_pass = static_cast<int>(std::lround(300.0 * factor));
  sim::Sensor& sensor = options.sensor;
  const double field = (sensor.beams - 1) * sensor.bearing_increment;
  sensor.beams = std::max(2, static_cast<int>(std::lround(sensor.beams * factor)));
  sensor.bearing_increment = field / (sensor.beams - 1);
  return sim::Scanner(sim::makeScene("office", kSeed), options, kSeed).sweep(0).image;
}

}  // namespace

const RangeImage& officeImage(int points) {
  static std::map<int, RangeImage> images;
  auto found = images.find(points);
  if (found == images.end()) found = images.emplace(points, simulate(points)).first;
  return found->second;
}

Cloud cloudOf(const BeamGrid& grid) {
  const auto size = static_cast<std::size_t>(grid.size());
  Cloud cloud{grid.rows, grid.cols, std::vector<float>(size), std::vector<float>(size), std::vector<float>(size)};
  for (std::size_t i = 0; i < size; ++i) {
    const Eigen::Vector3f p = grid.point(static_cast<int>(i));
    cloud.x[i] = p.x();
    cloud.y[i] = p.y();
    cloud.z[i] = p.z();
  }
  return cloud;
}

}  // namespace ppc::bench
