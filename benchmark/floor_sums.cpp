// SPDX-License-Identifier: BSD-3-Clause
#include "floor.h"
#include "lanes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ppc::bench {
namespace {

constexpr int kPixels = kFloorPatch * kFloorPatch;
static_assert(kFloorPatch % kLanes == 0);

struct Block {
  const float* ranges;
  std::size_t stride;     // from one row to the next
  const float* cos_tilt;  // 8 rows
  const float* minus_sin_tilt;
  const float* cos_bearing;  // 8 columns
  const float* sin_bearing;
};

bool valid(float range, const FloorGeometry& g) { return g.range_min <= range && range <= g.range_max; }

// The pixel that the sums of a patch are about: the middle one or, where that has no measurement, the first that has.
int originPixel(const Block& b, const FloorGeometry& g) {
  constexpr int kMiddle = kFloorPatch / 2 * (kFloorPatch + 1);
  const auto at = [&](int i) { return b.ranges[static_cast<std::size_t>(i / kFloorPatch) * b.stride + i % kFloorPatch]; };
  if (valid(at(kMiddle), g)) return kMiddle;
  for (int i = 0; i < kPixels; ++i) {
    if (valid(at(i), g)) return i;
  }
  return -1;
}

void sumBlock(const Block& b, const FloorGeometry& g, std::size_t patch, FloorSums& sums) {
  const int pixel = originPixel(b, g);
  if (pixel < 0) {
    for (auto* v : {&sums.n, &sums.origin_x, &sums.origin_y, &sums.origin_z, &sums.x, &sums.y, &sums.z, &sums.xx, &sums.xy,
                    &sums.xz, &sums.yy, &sums.yz, &sums.zz}) {
      (*v)[patch] = 0.0F;
    }
    return;
  }
  const int row = pixel / kFloorPatch, col = pixel % kFloorPatch;
  const float range = b.ranges[static_cast<std::size_t>(row) * b.stride + col];
  const float ox = range * b.cos_bearing[col] * b.cos_tilt[row];
  const float oy = range * b.sin_bearing[col];
  const float oz = range * b.cos_bearing[col] * b.minus_sin_tilt[row];

  Lanes n{}, x{}, y{}, z{}, xx{}, xy{}, xz{}, yy{}, yz{}, zz{};
  for (int c = 0; c < kFloorPatch; c += kLanes) {
    const Lanes cos_bearing = load(b.cos_bearing + c), sin_bearing = load(b.sin_bearing + c);
    for (int r = 0; r < kFloorPatch; ++r) {
      const Lanes ranges = load(b.ranges + static_cast<std::size_t>(r) * b.stride + c);
      const LaneMask in = (ranges >= g.range_min) & (ranges <= g.range_max);
      const Lanes level = ranges * cos_bearing;
      const Lanes px = keep(in, level * b.cos_tilt[r] - ox);
      const Lanes py = keep(in, ranges * sin_bearing - oy);
      const Lanes pz = keep(in, level * b.minus_sin_tilt[r] - oz);
      n += keep(in, Lanes{1.0F, 1.0F, 1.0F, 1.0F});
      x += px;
      y += py;
      z += pz;
      xx += px * px;
      xy += px * py;
      xz += px * pz;
      yy += py * py;
      yz += py * pz;
      zz += pz * pz;
    }
  }
  sums.n[patch] = sum(n);
  sums.origin_x[patch] = ox;
  sums.origin_y[patch] = oy;
  sums.origin_z[patch] = oz;
  sums.x[patch] = sum(x);
  sums.y[patch] = sum(y);
  sums.z[patch] = sum(z);
  sums.xx[patch] = sum(xx);
  sums.xy[patch] = sum(xy);
  sums.xz[patch] = sum(xz);
  sums.yy[patch] = sum(yy);
  sums.yz[patch] = sum(yz);
  sums.zz[patch] = sum(zz);
}

// A patch at the right or lower border, filled up with pixels that have no measurement.
void sumBorderBlock(const Block& b, int rows, int cols, const FloorGeometry& g, std::size_t patch, FloorSums& sums) {
  float ranges[kPixels], cos_tilt[kFloorPatch] = {}, minus_sin_tilt[kFloorPatch] = {}, cos_bearing[kFloorPatch] = {},
                         sin_bearing[kFloorPatch] = {};
  std::fill(ranges, ranges + kPixels, std::numeric_limits<float>::quiet_NaN());
  for (int r = 0; r < rows; ++r)
    std::copy_n(b.ranges + static_cast<std::size_t>(r) * b.stride, cols, ranges + r * kFloorPatch);
  std::copy_n(b.cos_tilt, rows, cos_tilt);
  std::copy_n(b.minus_sin_tilt, rows, minus_sin_tilt);
  std::copy_n(b.cos_bearing, cols, cos_bearing);
  std::copy_n(b.sin_bearing, cols, sin_bearing);
  sumBlock({ranges, kFloorPatch, cos_tilt, minus_sin_tilt, cos_bearing, sin_bearing}, g, patch, sums);
}

}  // namespace

FloorGeometry floorGeometry(const RangeImage& image) {
  FloorGeometry g;
  for (const double tilt : image.tilts) {
    g.cos_tilt.push_back(static_cast<float>(std::cos(tilt)));
    g.minus_sin_tilt.push_back(static_cast<float>(-std::sin(tilt)));
  }
  for (int c = 0; c < image.cols; ++c) {
    g.cos_bearing.push_back(static_cast<float>(std::cos(image.bearing(c))));
    g.sin_bearing.push_back(static_cast<float>(std::sin(image.bearing(c))));
  }
  g.range_min = static_cast<float>(image.range_min);
  g.range_max = static_cast<float>(image.range_max);
  return g;
}

void sumPatches(const std::vector<float>& ranges, const FloorGeometry& geometry, FloorSums& sums) {
  const int rows = static_cast<int>(geometry.cos_tilt.size()), cols = static_cast<int>(geometry.cos_bearing.size());
  sums.rows = (rows + kFloorPatch - 1) / kFloorPatch;
  sums.cols = (cols + kFloorPatch - 1) / kFloorPatch;
  const std::size_t patches = static_cast<std::size_t>(sums.rows) * static_cast<std::size_t>(sums.cols);
  for (auto* v : {&sums.n, &sums.origin_x, &sums.origin_y, &sums.origin_z, &sums.x, &sums.y, &sums.z, &sums.xx, &sums.xy,
                  &sums.xz, &sums.yy, &sums.yz, &sums.zz}) {
    v->resize(patches);
  }
  std::size_t patch = 0;
  for (int row = 0; row < rows; row += kFloorPatch) {
    for (int col = 0; col < cols; col += kFloorPatch, ++patch) {
      const auto stride = static_cast<std::size_t>(cols);
      const Block block{&ranges[static_cast<std::size_t>(row) * stride + static_cast<std::size_t>(col)],
                        stride,
                        &geometry.cos_tilt[static_cast<std::size_t>(row)],
                        &geometry.minus_sin_tilt[static_cast<std::size_t>(row)],
                        &geometry.cos_bearing[static_cast<std::size_t>(col)],
                        &geometry.sin_bearing[static_cast<std::size_t>(col)]};
      const int height = std::min(kFloorPatch, rows - row), width = std::min(kFloorPatch, cols - col);
      if (height == kFloorPatch && width == kFloorPatch) {
        sumBlock(block, geometry, patch, sums);
      } else {
        sumBorderBlock(block, height, width, geometry, patch, sums);
      }
    }
  }
}

}  // namespace ppc::bench
