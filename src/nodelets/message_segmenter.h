// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/baselines/plane_segmenter.h"
#include "patch_plane_clustering/ros/messages.h"
#include "patch_plane_clustering/ros/segmentation_conversions.h"

#include <sensor_msgs/PointCloud2.h>
#include <chrono>
#include <memory>
#include <string>

namespace ppc {

/// @brief What came in: a range image or a cloud, and when.
struct Arrival {
  using Clock = std::chrono::steady_clock;

  RangeImageMsg::ConstPtr image;
  sensor_msgs::PointCloud2::ConstPtr cloud;
  bool foreseen = false;  ///< an image of a sweep that seems to have ended: it may come again, or another in its place
  Clock::time_point time = Clock::now();

  const std_msgs::Header& header() const { return image ? image->header : cloud->header; }
};

/// @brief Segments messages, one after the other, in memory that is kept. What it made of an image that was foreseen is kept
/// too, until the next message: if that is the same image, nothing is left to do. Not thread-safe.
class MessageSegmenter {
 public:
  /// @param method one of segmenterNames()
  explicit MessageSegmenter(const std::string& method);

  /// @throws std::invalid_argument if the message contradicts itself or is too small for the configuration.
  void segment(const Arrival& arrival, const std::shared_ptr<const Config>& config);

  // Of the message last segmented:
  const BeamGrid& grid() const { return grid_; }
  const Segmentation& segmentation() const { return segmentation_; }
  bool wasForeseen() const { return was_foreseen_; }                        ///< segmented before it came
  double processorMilliseconds() const { return processor_milliseconds_; }  ///< spent by this thread, also before it came

 private:
  void start(const Arrival& arrival, const Config& config);
  void readGrid(const Arrival& arrival, int threads);

  std::string method_name_;
  std::unique_ptr<PlaneSegmenter> method_;
  RangeImage image_;
  BeamColumns columns_;
  CloudCoordinates coordinates_;
  BeamGrid grid_;
  Segmentation segmentation_;
  RangeImageMsg::ConstPtr foreseen_;  // null: nothing is foreseen
  std::shared_ptr<const Config> foreseen_with_;
  bool was_foreseen_ = false;
  double processor_milliseconds_ = 0.0;
};

}  // namespace ppc
