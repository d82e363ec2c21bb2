// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/curvature.h"

#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/parallel.h"
#include "patch_plane_clustering/core/point_lanes.h"
#include "patch_plane_clustering/core/quadratic_fit.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace ppc {
namespace {

constexpr int kMaxSamples = 1500;
constexpr std::size_t kBlock = 64;      // samples summed in single precision
constexpr float kMinCosine = 0.1F;      // of incidence, in the noise across a plane
constexpr float kFarFromPlane = 4.0F;   // in standard deviations: such samples are left out
constexpr double kSignificance = 25.0;  // far beyond chi-square with 3 degrees of freedom
constexpr double kMinAmplitude = 0.5;   // of a bend, in tolerances of distance
constexpr int kStripSizes = 2;          // largest size of such a strip over its neighbour's
constexpr double kWeakTurn = 0.31;      // of a strip beside a curved one, in max_turn
constexpr double kWeakAmplitude = 0.2;  // likewise, in tolerances of distance
constexpr double kFanAngle = 0.54;      // smallest angle between two strips of a fan, in max_turn
constexpr double kNarrowAngle = 0.22;   // likewise, if they bend as they are turned against each other
constexpr double kNarrowRadius = 4.0;   // largest radius of such strips: wider bows are those of ceilings and walls [m]
constexpr double kNarrowTurn = 0.6;     // turn of each over the angle between them that makes it so
constexpr int kFanSizes = 6;            // largest ratio of their sizes
constexpr double kFanRatio = 0.15;      // misfit of one quadratic surface over that of one plane, for two strips of a fan
constexpr double kFanMisfit = 0.1;      // the same misfit per point, in units of the noise variance
constexpr double kWideFan = 0.93;   // angle between two strips from which on the sides of an edge must be ruled out [rad]
constexpr double kWidestFan = 2.0;  // largest angle between two strips of a fan [rad]
constexpr double kWideFanRatio = 0.05;  // as kFanRatio, beyond kWideFan: an evenly sampled edge of two planes has 1/16
constexpr double kLimbAngle = 0.31;     // smallest angle of a strip at the limb of a curved surface to its neighbour [rad]
constexpr double kLimbRatio = 0.65;     // as kFanRatio, for such a strip
constexpr double kLimbMisfit = 0.6;     // as kFanMisfit, likewise
constexpr double kEdgeTolerance = 3.0;  // of a bent edge of a plane, in tolerances of distance
constexpr double kUniformWidth = 3.46;  // width of a uniform distribution over its standard deviation

// Reads pixels into samples about the first of them; those that fill up the last lanes are that again.
void readSamples(const BeamGrid& grid, const int* pixels, std::size_t n, const NoiseModel& noise, SurfaceSamples& samples,
                 SampledBeams& beams) {
  for (float* numbers : {samples.x, samples.y, samples.z}) std::fill(numbers + n, numbers + samples.size, 0.0F);
  for (auto* numbers : {&beams.ux, &beams.uy, &beams.uz, &beams.sigma}) {
    if (numbers->size() < samples.size) numbers->resize(samples.size);
    std::fill(numbers->data() + n, numbers->data() + samples.size, 0.0F);
  }
  const Eigen::Vector3f first = grid.point(pixels[0]);
  samples.center = first.cast<double>();
  for (std::size_t k = 0; k < n; ++k) {
    const Eigen::Vector3f point = grid.point(pixels[k]) - first, beam = grid.direction(pixels[k]);
    samples.x[k] = point.x();
    samples.y[k] = point.y();
    samples.z[k] = point.z();
    beams.ux[k] = beam.x();
    beams.uy[k] = beam.y();
    beams.uz[k] = beam.z();
    beams.sigma[k] = static_cast<float>(noise.sigma(grid.range[pixels[k]]));
  }
}

// Mean and scatter (the lower triangle) of samples, and the sum of their beams.
void sumSamples(const SurfaceSamples& samples, const SampledBeams& beams, double n, Eigen::Vector3d& mean,
                Eigen::Matrix3d& scatter, Eigen::Vector3d& beam) {
  mean.setZero();
  scatter.setZero();
  beam.setZero();
  for (std::size_t begin = 0; begin < samples.size; begin += kBlock) {
    PointLanes sums;
    Lanes ux = {}, uy = {}, uz = {};
    for (std::size_t i = begin; i < std::min(begin + kBlock, samples.size); i += kLanes) {
      const auto px = loadLanes<Lanes>(samples.x + i), py = loadLanes<Lanes>(samples.y + i);
      const auto pz = loadLanes<Lanes>(samples.z + i);
      sums.add(px, py, pz);
      ux += loadLanes<Lanes>(&beams.ux[i]);
      uy += loadLanes<Lanes>(&beams.uy[i]);
      uz += loadLanes<Lanes>(&beams.uz[i]);
    }
    mean += Eigen::Vector3d(sumLanes(sums.x), sumLanes(sums.y), sumLanes(sums.z));
    beam += Eigen::Vector3d(sumLanes(ux), sumLanes(uy), sumLanes(uz));
    scatter(0, 0) += sumLanes(sums.xx);
    scatter(1, 0) += sumLanes(sums.xy);
    scatter(2, 0) += sumLanes(sums.xz);
    scatter(1, 1) += sumLanes(sums.yy);
    scatter(2, 1) += sumLanes(sums.yz);
    scatter(2, 2) += sumLanes(sums.zz);
  }
  mean /= n;
  scatter -= n * mean * mean.transpose();
}

// Moves samples to a center on their plane, and weighs those near it.
void weighSamples(const Eigen::Vector3f& move, const Eigen::Vector3f& normal, float rms, int n, float stride,
                  const SampledBeams& beams, SurfaceSamples& samples) {
  LaneMask used = {};
  for (int i = 0; i < n; i += kLanes) {
    const Lanes x = loadLanes<Lanes>(samples.x + i) - move.x(), y = loadLanes<Lanes>(samples.y + i) - move.y();
    const Lanes z = loadLanes<Lanes>(samples.z + i) - move.z();
    const Lanes height = normal.x() * x + normal.y() * y + normal.z() * z;
    const Lanes cosine = -(normal.x() * loadLanes<Lanes>(&beams.ux[i]) + normal.y() * loadLanes<Lanes>(&beams.uy[i]) +
                           normal.z() * loadLanes<Lanes>(&beams.uz[i]));
    const Lanes sigma = loadLanes<Lanes>(&beams.sigma[i]) * (cosine > fill(kMinCosine) ? cosine : fill(kMinCosine));
    const Lanes limit = kFarFromPlane * (sigma > fill(rms) ? sigma : fill(rms));
    const LaneMask near = (height <= limit) & (height >= -limit) & firstLanes(n - i);
    used += near;
    storeLanes(x, samples.x + i);
    storeLanes(y, samples.y + i);
    storeLanes(z, samples.z + i);
    storeLanes(height, samples.height + i);
    storeLanes(near ? stride / (sigma * sigma) : Lanes{}, samples.weight + i);
  }
  samples.used = countLanes(used);
}

// Reads `n` pixels into the region's samples, and fits its plane.
void sampleRegion(const BeamGrid& grid, const int* pixels, int n, const NoiseModel& noise, SampledBeams& beams,
                  SampledRegion& region) {
  SurfaceSamples& samples = region.samples;
  readSamples(grid, pixels, static_cast<std::size_t>(n), noise, samples, beams);
  Eigen::Vector3d mean, beam;
  Eigen::Matrix3d scatter;
  sumSamples(samples, beams, n, mean, scatter, beam);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  samples.normal = eigen.eigenvectors().col(0);
  if (samples.normal.dot(beam) > 0.0) samples.normal = -samples.normal;
  samples.center += mean;
  region.plane = {samples.normal, samples.normal.dot(samples.center)};
  const double rms = std::sqrt(std::max(0.0, eigen.eigenvalues()[0]) / n);
  weighSamples(mean.cast<float>(), samples.normal.cast<float>(), static_cast<float>(rms), n,
               static_cast<float>(region.stride), beams, samples);
}

Bend bendOf(const QuadraticFit& fit) {
  Bend bend;
  if (!(fit.weight > 0.0)) return bend;
  bend.excess = std::max(0.0, fit.plane_chi2 - fit.quadratic_chi2);
  bend.amplitude = std::sqrt(bend.excess / fit.weight);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(fit.hessian);
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector2d axis = eigen.eigenvectors().col(k);
    const double width = kUniformWidth * std::sqrt(std::max(0.0, axis.dot(fit.scatter * axis)));
    bend.turn = std::max(bend.turn, std::abs(eigen.eigenvalues()[k]) * width);
  }
  return bend;
}

// Radius of an evenly sampled strip of a cylinder [m]: its parabola of height h = w^2 / 8 R over the width w = turn R has
// the root mean square 2 h / (3 sqrt 5).
double radiusOf(const Bend& bend) { return 12.0 * std::sqrt(5.0) * bend.amplitude / (bend.turn * bend.turn); }

using LabelPairs = std::vector<std::pair<std::int32_t, std::int32_t>>;

// Pairs of labels that are 4-neighbours in the image, or parted by up to `gap` pixels; ascending.
void findTouching(const LabelImage& labels, int gap, LabelPairs& pairs) {
  pairs.clear();
  std::pair<std::int32_t, std::int32_t> last;  // borders are long: most meetings repeat the one before
  const auto meet = [&](std::int32_t a, std::int32_t b) {
    const std::pair<std::int32_t, std::int32_t> pair(std::min(a, b), std::max(a, b));
    if (b == 0 || pair == last) return;
    last = pair;
    const auto at = std::lower_bound(pairs.begin(), pairs.end(), pair);
    if (at == pairs.end() || *at != pair) pairs.insert(at, pair);
  };
  for (int r = 0; r < labels.rows; ++r) {
    // Rows of a region are long: eight pixels at a time that differ neither from the next nor from those below.
    const std::int32_t* const row = labels.labels.data() + static_cast<std::size_t>(r) * labels.cols;
    const std::int32_t* const below = r + 1 < labels.rows ? row + labels.cols : row;
    for (int c = 0; c < labels.cols; ++c) {
      for (; c + 2 * kLanes < labels.cols; c += 2 * kLanes) {
        const auto a = loadLanes<LaneMask>(row + c), b = loadLanes<LaneMask>(row + c + kLanes);
        const LaneMask right = (a != loadLanes<LaneMask>(row + c + 1)) | (b != loadLanes<LaneMask>(row + c + 1 + kLanes));
        const LaneMask down = (a != loadLanes<LaneMask>(below + c)) | (b != loadLanes<LaneMask>(below + c + kLanes));
        if (anyLane(right | down)) break;
      }
      const std::int32_t* const at = row + c;
      const auto i = static_cast<std::size_t>(at - labels.labels.data());
      const std::int32_t label = *at;
      if (label == 0) continue;
      // Where the next pixel has the same label, it finds what lies beyond.
      if (c + 1 < labels.cols && labels.labels[i + 1] != label) {
        for (int g = 1; g <= gap + 1 && c + g < labels.cols; ++g) {
          if (labels.labels[i + g] != label) meet(label, labels.labels[i + g]);
        }
      }
      const auto down = static_cast<std::size_t>(labels.cols);
      if (r + 1 < labels.rows && labels.labels[i + down] != label) {
        for (int g = 1; g <= gap + 1 && r + g < labels.rows; ++g) {
          if (labels.labels[i + g * down] != label) meet(label, labels.labels[i + g * down]);
        }
      }
    }
  }
}

// How much worse one surface serves two regions than two of their own do, in chi-square.
struct CommonSurface {
  double plane = 0.0;      // of one plane
  double quadratic = 0.0;  // of one quadratic surface
  double allowed = 0.0;    // what noise and tolerance are worth in all of the points

  bool isSmooth(double ratio, double misfit) const { return quadratic < ratio * plane && quadratic < misfit * allowed; }
};

CommonSurface fitCommonSurface(const SampledRegion& a, const SampledRegion& b, const CoplanarityTolerance& tolerance) {
  const Eigen::Vector3d n = (a.points * a.plane.normal + b.points * b.plane.normal).normalized();
  const Eigen::Vector3d s = n.unitOrthogonal(), t = n.cross(s);
  const Eigen::Vector3d origin = (a.points * a.samples.center + b.points * b.samples.center) / (a.points + b.points);
  QuadraticSums sums = sumQuadraticAbout(origin, a.samples, s, t);
  const QuadraticSums sums_b = sumQuadraticAbout(origin, b.samples, s, t);
  const QuadraticFit fit_a = fitQuadratic(sums), fit_b = fitQuadratic(sums_b);
  const QuadraticFit both = fitQuadratic(sums += sums_b);
  const double points = a.stride * a.samples.used + b.stride * b.samples.used;
  return {both.plane_chi2 - fit_a.plane_chi2 - fit_b.plane_chi2,
          both.quadratic_chi2 - fit_a.quadratic_chi2 - fit_b.quadratic_chi2,
          tolerance.inflation * points + tolerance.sigma_distance * tolerance.sigma_distance * both.weight};
}

double angleBetween(const SampledRegion& a, const SampledRegion& b) {
  return std::acos(std::clamp(a.plane.normal.dot(b.plane.normal), -1.0, 1.0));
}

// Two strips of a fan: well turned against each other, or each bent by about as much as they are; one quadratic surface
// serves both.
bool isFan(const SampledRegion& a, const SampledRegion& b, const CoplanarityTolerance& tolerance, double max_turn) {
  // A scrap beside a large plane proves nothing about the plane.
  if (a.points > kFanSizes * b.points || b.points > kFanSizes * a.points) return false;
  const double angle = angleBetween(a, b);
  if (angle < kNarrowAngle * max_turn || angle > kWidestFan) return false;
  const auto bends = [&](const Bend& bend) {
    return bend.turn > kNarrowTurn * angle && radiusOf(bend) < kNarrowRadius &&
           bend.excess > kSignificance * tolerance.inflation;
  };
  if (angle < kFanAngle * max_turn && !(bends(a.bend) && bends(b.bend))) return false;
  const CommonSurface common = fitCommonSurface(a, b, tolerance);
  return common.plane > kSignificance * tolerance.inflation &&
         common.isSmooth(angle < kWideFan ? kFanRatio : kWideFanRatio, kFanMisfit);
}

// A strip beside a curved one: turned against it, and part of one smooth surface with it; at the limb of a cylinder, where
// beams graze it, less exactly.
bool isMoreOfFan(const SampledRegion& strip, const SampledRegion& beside, const CoplanarityTolerance& tolerance,
                 double max_turn) {
  const double angle = angleBetween(strip, beside);
  if (angle < kNarrowAngle * max_turn || angle > kWidestFan) return false;
  const CommonSurface common = fitCommonSurface(strip, beside, tolerance);
  if (common.plane < kSignificance * tolerance.inflation) return false;
  if (angle < kWideFan && common.isSmooth(kFanRatio, kFanMisfit)) return true;
  return angle > kLimbAngle && strip.points < beside.points && common.isSmooth(kLimbRatio, kLimbMisfit);
}

// Root mean square distance of samples from a plane, their noise taken out [m].
double misfit(const Plane& plane, const SampledRegion& region) {
  const SurfaceSamples& samples = region.samples;
  const double offset = plane.signedDistance(samples.center);
  double sum = 0.0;
  for (std::size_t i = 0; i < samples.size; ++i) {
    if (samples.weight[i] == 0.0F) continue;
    const double distance = offset + plane.normal.dot(Eigen::Vector3d(samples.x[i], samples.y[i], samples.z[i]));
    sum += distance * distance - region.stride / double{samples.weight[i]};
  }
  return std::sqrt(std::max(0.0, sum / std::max(1, samples.used)));
}

// Chooses pixels of every label, and makes room for the samples of those that have at least three of them.
void chooseSamples(const BeamGrid& grid, const std::vector<LabelRun>& runs, CurvatureMemory& memory) {
  std::vector<int>&count = memory.count, &begin = memory.begin, &end = memory.end, &next = memory.next;
  count.assign(static_cast<std::size_t>(highestLabel(runs)) + 1, 0);
  for (const LabelRun& run : runs) count[run.label] += run.end - run.begin;
  std::vector<SampledRegion>& regions = memory.regions;
  regions.assign(count.size(), SampledRegion());
  begin.assign(count.size() + 1, 0);
  for (std::size_t label = 0; label < count.size(); ++label) {
    regions[label].stride = std::max(1, count[label] / kMaxSamples);
    begin[label + 1] = begin[label] + (count[label] + regions[label].stride - 1) / regions[label].stride;
  }
  if (memory.pixels.size() < static_cast<std::size_t>(begin.back())) memory.pixels.resize(begin.back());
  end = begin;
  next.assign(count.size(), 0);
  for (const LabelRun& run : runs) {
    const int stride = regions[run.label].stride;
    int i = run.begin + next[run.label];
    for (; i < run.end; i += stride) {
      if (grid.valid(i)) memory.pixels[end[run.label]++] = i;
    }
    next[run.label] = i - run.end;
  }
  std::size_t room = 0;
  const auto lengthOf = [&](std::size_t label) {
    const auto n = static_cast<std::size_t>(end[label] - begin[label]);
    return n < 3 ? 0 : (n + kLanes - 1) / kLanes * kLanes;
  };
  for (std::size_t label = 0; label < count.size(); ++label) room += SurfaceSamples::kColumns * lengthOf(label);
  if (memory.columns.size() < room) memory.columns.resize(room);
  float* columns = memory.columns.data();
  for (std::size_t label = 0; label < count.size(); ++label) {
    const std::size_t length = lengthOf(label);
    if (length == 0) continue;
    regions[label].points = count[label];
    regions[label].samples.place(columns, length);
    columns += SurfaceSamples::kColumns * length;
  }
}

// Samples labels [first, last) of at least three points.
void sampleRegions(const BeamGrid& grid, const NoiseModel& noise, int first, int last, SampledBeams& beams,
                   CurvatureMemory& memory) {
  for (int label = first; label < last; ++label) {
    SampledRegion& region = memory.regions[label];
    if (region.points == 0) continue;
    const int begin = memory.begin[label];
    sampleRegion(grid, memory.pixels.data() + begin, memory.end[label] - begin, noise, beams, region);
    const Eigen::Vector3d s = region.plane.normal.unitOrthogonal();
    region.bend = bendOf(fitQuadratic(sumQuadratic(region.samples, s, region.plane.normal.cross(s))));
  }
}

}  // namespace

std::vector<Bend> measureBends(const BeamGrid& grid, const LabelImage& labels, const NoiseModel& noise) {
  CurvatureMemory memory;
  chooseSamples(grid, labelRuns(labels), memory);
  SampledBeams beams;
  sampleRegions(grid, noise, 0, static_cast<int>(memory.regions.size()), beams, memory);
  std::vector<Bend> bends;
  for (const SampledRegion& region : memory.regions) bends.push_back(region.bend);
  return bends;
}

std::vector<std::int32_t> planarNames(const BeamGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                                      double max_turn, const LabelImage& labels, const std::vector<LabelRun>& runs,
                                      int threads) {
  CurvatureMemory memory;
  std::vector<std::int32_t> names;
  planarNames(grid, noise, tolerance, max_turn, labels, runs, memory, names, threads);
  return names;
}

void planarNames(const BeamGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance, double max_turn,
                 const LabelImage& labels, const std::vector<LabelRun>& runs, CurvatureMemory& memory,
                 std::vector<std::int32_t>& names, int threads) {
  chooseSamples(grid, runs, memory);
  const std::vector<SampledRegion>& regions = memory.regions;
  const int count = static_cast<int>(regions.size()), ranges = rangeCount(threads, count);
  forEachPart(threads, 1 + ranges, memory.beams, [&](int part, SampledBeams& beams) {
    if (part == 0) return findTouching(labels, 2, memory.touching);  // needs no samples
    sampleRegions(grid, noise, partBegin(count, ranges, part - 1), partBegin(count, ranges, part), beams, memory);
  });
  const LabelPairs& touching = memory.touching;
  std::vector<char>&curved = memory.curved, &weak = memory.weak;
  curved.assign(regions.size(), 0);
  weak.assign(regions.size(), 0);
  for (std::size_t label = 1; label < regions.size(); ++label) {
    const Bend& bend = regions[label].bend;
    const bool bent = bend.turn > kWeakTurn * max_turn && bend.amplitude > kWeakAmplitude * tolerance.sigma_distance &&
                      bend.excess > kSignificance * tolerance.inflation;
    weak[label] = bent ? 1 : 0;
    curved[label] = bent && bend.turn > max_turn && bend.amplitude > kMinAmplitude * tolerance.sigma_distance ? 1 : 0;
  }
  std::vector<char>& alone = memory.alone;
  alone = curved;
  for (const auto& [a, b] : touching) {
    if ((alone[a] & alone[b]) == 0 && isFan(regions[a], regions[b], tolerance, max_turn)) curved[a] = curved[b] = 1;
  }
  // A strip that bends less, but beside a curved one of about its size, is more of the same surface.
  std::vector<char>& certain = memory.certain;
  certain = curved;
  for (const auto& [first, second] : touching) {
    if (certain[first] == certain[second]) continue;
    const bool of_first = certain[first] != 0;
    const std::int32_t strip = of_first ? second : first, beside = of_first ? first : second;
    if (regions[strip].points >= kStripSizes * regions[beside].points) continue;
    const SampledRegion &a = regions[strip], &b = regions[beside];
    if (weak[strip] != 0 || isMoreOfFan(a, b, tolerance, max_turn)) curved[strip] = 1;
  }
  // A bent strip along a larger plane that it hardly leaves is the soft edge of that plane.
  names.resize(regions.size());
  for (std::size_t label = 0; label < regions.size(); ++label) {
    names[label] = curved[label] != 0 ? 0 : static_cast<std::int32_t>(label);
  }
  std::vector<int>& host_points = memory.host_points;
  host_points.assign(regions.size(), 0);
  for (const auto& [a, b] : touching) {
    for (const auto& [strip, host] : {std::pair(a, b), std::pair(b, a)}) {
      if (alone[strip] == 0 || curved[host] != 0) continue;
      const SampledRegion& plane = regions[host];
      if (plane.points <= std::max(host_points[strip], regions[strip].points)) continue;
      if (misfit(plane.plane, regions[strip]) > kEdgeTolerance * tolerance.sigma_distance) continue;
      host_points[strip] = plane.points;
      names[strip] = host;
    }
  }
}

}  // namespace ppc
