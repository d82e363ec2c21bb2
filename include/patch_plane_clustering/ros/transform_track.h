// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/pose_source.h"
#include "patch_plane_clustering/ros/transform_watch.h"

#include <deque>
#include <string>
#include <vector>

namespace ppc {

/// @brief One transform over time, as tf2 knows it, but never across a hole in its samples.
///
/// tf2 interpolates between samples however far apart they are; this has watched them come, and gives nothing between two
/// that are further apart than `max_gap`. Holes before it began to watch are not known. Not thread-safe (the buffer is).
class TransformTrack {
 public:
  /// @param buffer must outlive this @param max_gap [s] @param max_wait a time this much ahead of the newest is given up [s]
  TransformTrack(tf2::BufferCore& buffer, std::string target_frame, std::string source_frame, double max_gap,
                 double max_wait = 5.0);

  /// @brief source_frame in target_frame at `stamp` [s]. kWaitTransform: later than the newest sample, or the frames are not
  /// known yet; kTiltGap: within a hole; kNoTransform: before the oldest sample, or far after the newest.
  PoseStatus at(double stamp, Eigen::Isometry3d& transform);

  /// @brief The samples that the last call of at() found to have come since the call before.
  const std::vector<StampedTransform>& fresh() const { return fresh_; }

  /// @brief Time of the newest sample [s]; 0 for a static transform, negative while there is none.
  double newestStamp() const;

  /// @brief Forgets all: the buffer has been cleared.
  void reset();

 private:
  struct Gap {
    double from, to;
  };
  void look();

  const tf2::BufferCore& buffer_;
  std::string target_, source_;
  double max_gap_;
  double max_wait_;
  TransformWatch watch_;
  std::vector<StampedTransform> fresh_;
  double newest_ = -1.0;  // of the samples that have been looked at
  std::deque<Gap> gaps_;
};

}  // namespace ppc
