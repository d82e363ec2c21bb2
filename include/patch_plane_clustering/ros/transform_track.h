// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/pose_source.h"

#include <tf2/buffer_core.h>
#include <deque>
#include <string>

namespace ppc {

/// @brief One transform over time, as tf2 knows it, but never across a hole in its samples.
///
/// tf2 interpolates between samples however far apart they are. This watches the newest sample grow and remembers where it
/// leapt by more than `max_gap`; it must be asked often enough to see that. Not thread-safe (the buffer is).
class TransformTrack {
 public:
  /// @param buffer must outlive this @param max_gap [s] @param max_wait a time this much ahead of the newest is given up [s]
  TransformTrack(const tf2::BufferCore& buffer, std::string target_frame, std::string source_frame, double max_gap,
                 double max_wait = 5.0);

  /// @brief source_frame in target_frame at `stamp` [s]. kWaitTransform: later than the newest sample, or the frames are not
  /// known yet; kTiltGap: within a hole; kNoTransform: before the oldest sample, or far after the newest.
  PoseStatus at(double stamp, Eigen::Isometry3d& transform);

  /// @brief Time of the newest sample [s]; 0 for a static transform, negative while there is none.
  double newestStamp() const;

  /// @brief Forgets the holes: the buffer has been cleared.
  void reset();

  std::string name() const { return target_ + " <- " + source_; }

 private:
  struct Gap {
    double from, to;
  };
  const tf2::BufferCore& buffer_;
  std::string target_, source_;
  double max_gap_;
  double max_wait_;
  double newest_ = -1.0;
  std::deque<Gap> gaps_;
};

}  // namespace ppc
