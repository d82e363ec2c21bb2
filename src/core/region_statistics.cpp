// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_statistics.h"

#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/parallel.h"
#include "patch_plane_clustering/core/point_lanes.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

namespace ppc {
namespace {

constexpr float kMinCosine = 0.02F;  // of incidence: the residual along a beam says nothing about a plane seen edge-on

constexpr int kBlock = 64;  // pixels summed in single precision about a point of their own
constexpr int kChunkBlocks = 64;
constexpr int kBeamBlocks = 8;  // blocks whose sums along the beams are kept in single precision

// Sums of the points of a label about one of them, so that they keep their digits far from the sensor.
struct PointSums {
  double ux = 0, uy = 0, uz = 0;  // beams, one for each block
  double x = 0, y = 0, z = 0;
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  int n = 0;

  PointSums& operator+=(const PointSums& o) {
    ux += o.ux;
    uy += o.uy;
    uz += o.uz;
    x += o.x;
    y += o.y;
    z += o.z;
    xx += o.xx;
    xy += o.xy;
    xz += o.xz;
    yy += o.yy;
    yz += o.yz;
    zz += o.zz;
    n += o.n;
    return *this;
  }
};

// Calls f(beams) for pixels [begin, end), four at a time.
template <typename F>
void forEachBeams(const BeamGrid& grid, int begin, int end, const F& f) {
  int i = begin;
  for (; i + kLanes <= end; i += kLanes) f(BeamLanes(grid, i));
  if (i < end) f(BeamLanes(grid, i, end - i));
}

// Adds the valid pixels [begin, end), at most kBlock of them. Four at a time in single precision about the block's own first
// point, which is near enough for the digits to suffice.
void addPoints(const BeamGrid& grid, int begin, int end, const Eigen::Vector3d& origin, PointSums& s) {
  while (begin < end && !grid.valid(begin)) ++begin;
  if (begin == end) return;
  const Eigen::Vector3f first = grid.point(begin);
  PointLanes q;
  LaneMask counted = {};
  forEachBeams(grid, begin, end, [&](const BeamLanes& beam) {
    const Lanes zero = {};
    const Lanes px = beam.valid ? beam.origin_x + beam.range * beam.dir_x - first.x() : zero;
    const Lanes py = beam.valid ? beam.origin_y + beam.range * beam.dir_y - first.y() : zero;
    const Lanes pz = beam.valid ? beam.origin_z + beam.range * beam.dir_z - first.z() : zero;
    q.add(px, py, pz);
    counted += beam.valid;
  });
  // From the block's origin to the label's: p = q + (first - o).
  const double n = countLanes(counted);
  const double dx = first.x() - origin.x(), dy = first.y() - origin.y(), dz = first.z() - origin.z();
  const double qx = sumLanes(q.x), qy = sumLanes(q.y), qz = sumLanes(q.z);
  s.ux += n * grid.dir_x[begin];
  s.uy += n * grid.dir_y[begin];
  s.uz += n * grid.dir_z[begin];
  s.x += qx + n * dx;
  s.y += qy + n * dy;
  s.z += qz + n * dz;
  s.xx += sumLanes(q.xx) + 2.0 * qx * dx + n * dx * dx;
  s.xy += sumLanes(q.xy) + qx * dy + qy * dx + n * dx * dy;
  s.xz += sumLanes(q.xz) + qx * dz + qz * dx + n * dx * dz;
  s.yy += sumLanes(q.yy) + 2.0 * qy * dy + n * dy * dy;
  s.yz += sumLanes(q.yz) + qy * dz + qz * dy + n * dy * dz;
  s.zz += sumLanes(q.zz) + 2.0 * qz * dz + n * dz * dz;
  s.n += static_cast<int>(n);
}

// Total least squares: the start of the fit along the beams, and its substitute where that is ill-posed.
PlanarRegion fitAcross(std::int32_t id, const Eigen::Vector3d& origin, const PointSums& s) {
  PlanarRegion region;
  region.id = id;
  region.points = s.n;
  const double n = s.n;
  const Eigen::Vector3d mean = Eigen::Vector3d(s.x, s.y, s.z) / n;
  region.centroid = origin + mean;
  Eigen::Matrix3d outer;
  outer << s.xx, s.xy, s.xz, s.xy, s.yy, s.yz, s.xz, s.yz, s.zz;
  const Eigen::Matrix3d scatter = outer - n * mean * mean.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  Eigen::Vector3d normal = eigen.eigenvectors().col(0);
  if (normal.dot(Eigen::Vector3d(s.ux, s.uy, s.uz)) > 0.0) normal = -normal;
  region.plane = {normal, normal.dot(region.centroid)};

  // Rotations about the in-plane axes and the offset at the centroid are independent; d follows from both. For residuals of
  // unit variance: theirs follows.
  Eigen::Matrix<double, 4, 3> jacobian = Eigen::Matrix<double, 4, 3>::Zero();
  Eigen::Vector3d variances(0.0, 0.0, 1.0 / n);
  for (int k = 1; k <= 2; ++k) {
    const Eigen::Vector3d axis = eigen.eigenvectors().col(k);
    jacobian.block<3, 1>(0, k - 1) = axis;
    jacobian(3, k - 1) = axis.dot(region.centroid);
    variances[k - 1] = eigen.eigenvalues()[k] > 0.0 ? 1.0 / eigen.eigenvalues()[k] : 0.0;
  }
  jacobian(3, 2) = 1.0;
  region.covariance = jacobian * variances.asDiagonal() * jacobian.transpose();
  return region;
}

// Normal equations of one Gauss-Newton step for residuals along the beams. The step is three numbers: turns of the normal
// about the two tangents, and an offset at the centroid.
struct BeamSums {
  double aa = 0, ab = 0, ac = 0, bb = 0, bc = 0, cc = 0;  // products of the rows of the Jacobian
  double ra = 0, rb = 0, rc = 0;                          // with the residuals
  double squares = 0.0;                                   // of the residuals along the beams
  double across = 0.0;                                    // squares of the distances from the plane, of all points
  int n = 0;

  BeamSums& operator+=(const BeamSums& o) {
    aa += o.aa;
    ab += o.ab;
    ac += o.ac;
    bb += o.bb;
    bc += o.bc;
    cc += o.cc;
    ra += o.ra;
    rb += o.rb;
    rc += o.rc;
    squares += o.squares;
    across += o.across;
    n += o.n;
    return *this;
  }
};

// The same of some hundred pixels, in lanes.
struct BeamLaneSums {
  Lanes aa = {}, ab = {}, ac = {}, bb = {}, bc = {}, cc = {}, ra = {}, rb = {}, rc = {}, squares = {}, across = {};
  LaneMask n = {};

  void addTo(BeamSums& s) const {
    s.aa += sumLanes(aa);
    s.ab += sumLanes(ab);
    s.ac += sumLanes(ac);
    s.bb += sumLanes(bb);
    s.bc += sumLanes(bc);
    s.cc += sumLanes(cc);
    s.ra += sumLanes(ra);
    s.rb += sumLanes(rb);
    s.rc += sumLanes(rc);
    s.squares += sumLanes(squares);
    s.across += sumLanes(across);
    s.n += countLanes(n);
  }
};

struct Block {
  int begin, end;  // at most kBlock pixels of one label
};

// A vector that is the same for all lanes.
struct VectorLanes {
  Lanes x, y, z;

  explicit VectorLanes(const Eigen::Vector3f& v) : x(fill(v.x())), y(fill(v.y())), z(fill(v.z())) {}
  Lanes dot(Lanes ox, Lanes oy, Lanes oz) const { return x * ox + y * oy + z * oz; }
};

// What residuals along the beams are measured from: the plane across, with its tangents.
struct BeamFrame {
  Eigen::Vector3d tangent1, tangent2;
  VectorLanes normal, centroid, lanes1, lanes2;

  explicit BeamFrame(const PlanarRegion& region)
      : tangent1(region.plane.normal.unitOrthogonal()),
        tangent2(region.plane.normal.cross(tangent1)),
        normal(region.plane.normal.cast<float>()),
        centroid(region.centroid.cast<float>()),
        lanes1(tangent1.cast<float>()),
        lanes2(tangent2.cast<float>()) {}
};

// Sums the valid pixels of some blocks.
BeamLaneSums sumBeams(const BeamGrid& grid, const Block* begin, const Block* end, const BeamFrame& frame) {
  const VectorLanes n = frame.normal, center = frame.centroid, u1 = frame.lanes1, u2 = frame.lanes2;
  BeamLaneSums s;
  const auto add = [&](const BeamLanes& beam) {
    const Lanes cosine = n.dot(beam.dir_x, beam.dir_y, beam.dir_z);
    const LaneMask used = beam.valid & (cosine < fill(-kMinCosine));
    const Lanes inverse = used ? 1.0F / cosine : Lanes{};
    // From the centroid, not from the frame's origin: short distances keep their digits.
    const Lanes ox = beam.origin_x - center.x, oy = beam.origin_y - center.y, oz = beam.origin_z - center.z;
    const Lanes height = n.dot(ox, oy, oz);
    const Lanes distance = beam.valid ? height + beam.range * cosine : Lanes{};
    s.across += distance * distance;
    const Lanes range = height * inverse;  // to the plane, less than 0
    const Lanes residual = used ? beam.range + range : Lanes{};
    const Lanes qx = ox - range * beam.dir_x, qy = oy - range * beam.dir_y, qz = oz - range * beam.dir_z;
    // n' = n + alpha t1 + beta t2, offset gamma at the centroid: d range = (gamma - alpha t1.q - beta t2.q) / (n.u)
    const Lanes a = u1.dot(qx, qy, qz) * inverse;  // and b: with the other sign
    const Lanes b = u2.dot(qx, qy, qz) * inverse;
    s.aa += a * a;
    s.ab += a * b;
    s.ac -= a * inverse;
    s.bb += b * b;
    s.bc -= b * inverse;
    s.cc += inverse * inverse;
    s.ra -= a * residual;
    s.rb -= b * residual;
    s.rc += inverse * residual;
    s.squares += residual * residual;
    s.n += used;
  };
  for (const Block* block = begin; block != end; ++block) forEachBeams(grid, block->begin, block->end, add);
  return s;
}

void refineAlongBeams(const BeamFrame& frame, const BeamSums& s, PlanarRegion& region) {
  if (s.n < std::max(4, region.points / 2)) return;  // seen edge-on: the beams say little about the plane
  Eigen::Matrix3d normal_equations;
  normal_equations << s.aa, s.ab, s.ac, s.ab, s.bb, s.bc, s.ac, s.bc, s.cc;
  const Eigen::Vector3d right(s.ra, s.rb, s.rc);
  const Eigen::LDLT<Eigen::Matrix3d> solver(normal_equations);
  if (solver.info() != Eigen::Success || !solver.isPositive() || solver.rcond() < 1e-12) return;
  const Eigen::Vector3d step = solver.solve(right);
  const Eigen::Vector3d turned = region.plane.normal + step[0] * frame.tangent1 + step[1] * frame.tangent2;
  const Eigen::Vector3d normal = turned.normalized();
  const double offset = region.plane.normal.dot(region.centroid) + step[2];
  region.plane = {normal, offset + (normal - region.plane.normal).dot(region.centroid)};
  const double gain = right.dot(step);
  const double variance = std::max(0.0, s.squares - gain) / std::max(1, s.n - 3);
  Eigen::Matrix<double, 4, 3> jacobian = Eigen::Matrix<double, 4, 3>::Zero();
  jacobian.block<3, 1>(0, 0) = frame.tangent1;
  jacobian.block<3, 1>(0, 1) = frame.tangent2;
  jacobian.row(3) << frame.tangent1.dot(region.centroid), frame.tangent2.dot(region.centroid), 1.0;
  region.covariance = variance * jacobian * solver.solve(Eigen::Matrix3d::Identity()) * jacobian.transpose();
}

// Some blocks of one region: what a thread takes at a time, as one region may have most of the image.
struct Chunk {
  std::int32_t id;
  const Block *begin, *end;
};

// Cuts the blocks of the regions into chunks.
std::vector<Chunk> cutChunks(const std::vector<std::vector<Block>>& blocks) {
  std::vector<Chunk> chunks;
  for (std::size_t id = 0; id < blocks.size(); ++id) {
    const Block* const end = blocks[id].data() + blocks[id].size();
    for (const Block* at = blocks[id].data(); at != end;) {
      const Block* const next = at + std::min<std::ptrdiff_t>(kChunkBlocks, end - at);
      chunks.push_back({static_cast<std::int32_t>(id), at, next});
      at = next;
    }
  }
  return chunks;
}

// Sums over the chunks of every region, sum(chunk), added up in their order, however many threads there are.
template <typename Sums, typename F>
std::vector<Sums> sumChunks(const std::vector<Chunk>& chunks, std::size_t regions, int threads, F&& sum) {
  std::vector<Sums> parts(chunks.size()), sums(regions);
  forEachPart(threads, static_cast<int>(chunks.size()), [&](int k) { parts[k] = sum(chunks[k]); });
  for (std::size_t k = 0; k < chunks.size(); ++k) sums[chunks[k].id] += parts[k];
  return sums;
}

// The first point of a region; that of its first pixel if that is not valid.
Eigen::Vector3d originOf(const BeamGrid& grid, const std::vector<Block>& blocks) {
  for (const Block& block : blocks) {
    for (int i = block.begin; i < block.end; ++i) {
      if (grid.valid(i)) return grid.point(i).cast<double>();
    }
  }
  return Eigen::Vector3d::Zero();
}

}  // namespace

std::vector<PlanarRegion> describeRegions(const BeamGrid& grid, const LabelImage& labels, int threads) {
  return describeRegions(grid, labelRuns(labels), threads);
}

std::vector<PlanarRegion> describeRegions(const BeamGrid& grid, const std::vector<LabelRun>& runs, int threads) {
  std::vector<std::vector<Block>> blocks(static_cast<std::size_t>(highestLabel(runs)) + 1);
  std::vector<std::size_t> count(blocks.size(), 0);
  for (const LabelRun& run : runs) count[run.label] += static_cast<std::size_t>((run.end - run.begin + kBlock - 1) / kBlock);
  for (std::size_t id = 0; id < blocks.size(); ++id) blocks[id].reserve(count[id]);
  for (const LabelRun& run : runs) {
    for (int at = run.begin; at < run.end; at += kBlock) blocks[run.label].push_back({at, std::min(at + kBlock, run.end)});
  }
  const std::vector<Chunk> chunks = cutChunks(blocks);
  std::vector<Eigen::Vector3d> origins;
  origins.reserve(blocks.size());
  for (const std::vector<Block>& of_region : blocks) origins.push_back(originOf(grid, of_region));
  const auto sum_points = [&](const Chunk& chunk) {
    PointSums sums;
    for (const Block* at = chunk.begin; at != chunk.end; ++at) addPoints(grid, at->begin, at->end, origins[chunk.id], sums);
    return sums;
  };
  const std::vector<PointSums> points = sumChunks<PointSums>(chunks, blocks.size(), threads, sum_points);
  std::vector<PlanarRegion> regions(blocks.size());
  std::vector<BeamFrame> frames;
  frames.reserve(blocks.size());
  for (std::size_t id = 0; id < blocks.size(); ++id) {
    if (points[id].n >= 3) regions[id] = fitAcross(static_cast<std::int32_t>(id), origins[id], points[id]);
    frames.emplace_back(regions[id]);
  }
  // Noise runs along the beams: the likeliest plane minimises residuals in range, not across the plane.
  const auto sum_beams = [&](const Chunk& chunk) {
    BeamSums sums;
    for (const Block* at = chunk.begin; at != chunk.end;) {
      const Block* const next = at + std::min<std::ptrdiff_t>(kBeamBlocks, chunk.end - at);
      sumBeams(grid, at, next, frames[chunk.id]).addTo(sums);
      at = next;
    }
    return sums;
  };
  const std::vector<BeamSums> beams = sumChunks<BeamSums>(chunks, blocks.size(), threads, sum_beams);
  for (std::size_t id = 0; id < blocks.size(); ++id) {
    PlanarRegion& region = regions[id];
    if (region.points < 3) continue;
    region.rms = std::sqrt(beams[id].across / region.points);
    region.covariance *= beams[id].across / std::max(1, region.points - 3);
    refineAlongBeams(frames[id], beams[id], region);
  }
  regions.erase(std::remove_if(regions.begin(), regions.end(), [](const PlanarRegion& r) { return r.points < 3; }),
                regions.end());
  return regions;
}

int renumberBySize(const BeamGrid& grid, int min_size, LabelImage& labels, std::vector<LabelRun>* runs_out) {
  const float* const ranges = grid.range.data();
  std::int32_t* const pixels = labels.labels.data();
  for (int i = 0, n = grid.size(); i < n; ++i) {  // without branches, so that it becomes vector code
    const std::int32_t label = pixels[i];
    const bool kept = (ranges[i] > 0.0F) & (label > 0);
    pixels[i] = kept ? label : 0;
  }
  std::vector<LabelRun> runs = labelRuns(labels);
  const std::int32_t highest = highestLabel(runs);
  std::vector<int> count(static_cast<std::size_t>(highest) + 1, 0);
  std::vector<int> first(count.size(), grid.size());
  for (const LabelRun& run : runs) {
    count[run.label] += run.end - run.begin;
    first[run.label] = std::min(first[run.label], run.begin);
  }
  std::vector<std::int32_t> order(static_cast<std::size_t>(highest));
  std::iota(order.begin(), order.end(), 1);
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    return count[a] != count[b] ? count[a] > count[b] : first[a] < first[b];
  });
  std::vector<std::int32_t> renamed(count.size(), 0);
  int n = 0;
  for (const std::int32_t label : order) {
    if (count[label] >= std::max(1, min_size)) renamed[label] = ++n;
  }
  renameLabels(renamed, runs, labels);
  if (runs_out != nullptr) {
    for (LabelRun& run : runs) run.label = renamed[run.label];
    runs.erase(std::remove_if(runs.begin(), runs.end(), [](const LabelRun& run) { return run.label == 0; }), runs.end());
    *runs_out = std::move(runs);
  }
  return n;
}

}  // namespace ppc
