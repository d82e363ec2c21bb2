// SPDX-License-Identifier: BSD-3-Clause
#include "picture.h"

#include "patch_plane_clustering/core/quantile.h"
#include "patch_plane_clustering/evaluation/polygon_score.h"
#include "patch_plane_clustering/ros/region_color.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace ppc {
namespace {

constexpr int kWide = 1200;  // a panel is enlarged or reduced to about this many pixels on its longer side [pixels]

// Columns of a laser run counter-clockwise, from right to left: such an image is a mirror image.
bool mirrored(const BeamGrid& grid) {
  if (grid.rows < 2 || grid.cols < 2) return false;
  const int r = grid.rows / 2, c = grid.cols / 2;
  const Eigen::Vector3f forward = grid.direction(grid.index(r, c));
  const Eigen::Vector3f right = forward - grid.direction(grid.index(r, c - 1));
  const Eigen::Vector3f down = forward - grid.direction(grid.index(r - 1, c));
  return right.cross(down).dot(forward) < 0.0F;
}

// Sides in the ratio of the angles that they see: tilt steps are often finer than beam steps.
cv::Size panelSize(const BeamGrid& grid) {
  double across = 0.0, along = 0.0;
  const auto angle = [&](int i, int j) { return static_cast<double>((grid.direction(i) - grid.direction(j)).norm()); };
  for (int c = 1; c < grid.cols; ++c) across += angle(grid.index(grid.rows / 2, c), grid.index(grid.rows / 2, c - 1));
  for (int r = 1; r < grid.rows; ++r) along += angle(grid.index(r, grid.cols / 2), grid.index(r - 1, grid.cols / 2));
  const double ratio = across > 0.0 && along > 0.0 ? std::clamp(along / across, 0.25, 4.0) : 1.0;
  const int shorter = static_cast<int>(std::lround(kWide * std::min(ratio, 1.0 / ratio)));
  return ratio < 1.0 ? cv::Size(kWide, shorter) : cv::Size(shorter, kWide);
}

cv::Mat rangePanel(const BeamGrid& grid) {
  std::vector<float> ranges;
  for (const float range : grid.range) {
    if (range > 0.0F) ranges.push_back(range);
  }
  float near = 0.0F, far = 1.0F;
  if (!ranges.empty()) {  // a few stray points must not set the scale
    near = quantile(ranges, 0.01);
    far = std::max(quantile(ranges, 0.99), near + 0.01F);
  }
  cv::Mat depth(grid.rows, grid.cols, CV_8UC1), coloured;
  for (int i = 0; i < grid.size(); ++i) {
    const float t = grid.valid(i) ? std::log(grid.range[i] / near) / std::log(far / near) : 0.0F;
    depth.data[i] = static_cast<std::uint8_t>(std::lround(235.0F - 215.0F * std::clamp(t, 0.0F, 1.0F)));
  }
  cv::applyColorMap(depth, coloured, cv::COLORMAP_TURBO);
  for (int i = 0; i < grid.size(); ++i) {
    if (!grid.valid(i)) coloured.at<cv::Vec3b>(i / grid.cols, i % grid.cols) = {0, 0, 0};
  }
  return coloured;
}

cv::Vec3b colourOf(std::int32_t id) {
  const RegionColor colour = regionColor(id);
  return id > 0 ? cv::Vec3b(colour.b, colour.g, colour.r) : cv::Vec3b(60, 60, 60);
}

cv::Mat labelPanel(const BeamGrid& grid, const LabelImage& labels) {
  cv::Mat panel(grid.rows, grid.cols, CV_8UC3, cv::Scalar(0, 0, 0));
  for (int i = 0; i < grid.size(); ++i) {
    auto& pixel = panel.at<cv::Vec3b>(i / grid.cols, i % grid.cols);
    if (grid.valid(i)) pixel = colourOf(labels.labels[i]);
  }
  return panel;
}

// The beams of the enlarged picture: between the centres of the image's pixels, linearly.
BeamGrid enlargedBeams(const BeamGrid& grid, const cv::Size& size) {
  BeamGrid beams;
  beams.rows = size.height;
  beams.cols = size.width;
  const auto enlarge = [&](const std::vector<float>& from, std::vector<float>& to) {
    if (from.empty()) return;
    const cv::Mat small(grid.rows, grid.cols, CV_32FC1, const_cast<float*>(from.data()));
    cv::Mat large;
    cv::resize(small, large, size, 0, 0, cv::INTER_LINEAR);
    to.assign(large.begin<float>(), large.end<float>());
  };
  enlarge(grid.dir_x, beams.dir_x);
  enlarge(grid.dir_y, beams.dir_y);
  enlarge(grid.dir_z, beams.dir_z);
  enlarge(grid.origin_x, beams.origin_x);
  enlarge(grid.origin_y, beams.origin_y);
  enlarge(grid.origin_z, beams.origin_z);
  beams.range.assign(static_cast<std::size_t>(beams.size()), 1.0F);
  return beams;
}

void drawOutlines(const BeamGrid& grid, const Segmentation& result, cv::Mat& panel) {
  const LabelImage rendered = renderPolygons(enlargedBeams(grid, panel.size()), result.regions, result.polygons);
  const auto label = [&](int r, int c) { return rendered.labels[static_cast<std::size_t>(r) * panel.cols + c]; };
  for (int r = 0; r + 1 < panel.rows; ++r) {
    for (int c = 0; c + 1 < panel.cols; ++c) {
      if (label(r, c) == label(r, c + 1) && label(r, c) == label(r + 1, c)) continue;
      panel.at<cv::Vec3b>(r, c) = {255, 255, 255};
    }
  }
}

}  // namespace

cv::Mat drawSegmentation(const BeamGrid& grid, const Segmentation& result) {
  const cv::Size size = panelSize(grid);
  cv::Mat range, labels;
  cv::resize(rangePanel(grid), range, size, 0, 0, cv::INTER_NEAREST);
  cv::resize(labelPanel(grid, result.labels), labels, size, 0, 0, cv::INTER_NEAREST);
  drawOutlines(grid, result, labels);
  if (mirrored(grid)) {
    cv::flip(range, range, 1);
    cv::flip(labels, labels, 1);
  }
  const bool stacked = size.width > size.height;
  const cv::Mat gap(stacked ? 6 : size.height, stacked ? size.width : 6, CV_8UC3, cv::Scalar(255, 255, 255));
  cv::Mat picture;
  if (stacked) {
    cv::vconcat(std::vector<cv::Mat>{range, gap, labels}, picture);
  } else {
    cv::hconcat(std::vector<cv::Mat>{range, gap, labels}, picture);
  }
  return picture;
}

}  // namespace ppc
