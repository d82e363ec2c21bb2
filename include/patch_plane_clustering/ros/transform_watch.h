// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/Transform.h>
#include <tf2/buffer_core.h>
#include <Eigen/Geometry>
#include <boost/signals2/connection.hpp>
#include <memory>
#include <string>
#include <vector>

namespace ppc {

struct StampedTransform {
  double stamp;  ///< [s]
  Eigen::Isometry3d transform;
};

/// @brief With its rotation normalised; not finite if its numbers are not.
Eigen::Isometry3d toIsometry(const geometry_msgs::Transform& transform);

/// @brief Sees every sample of a transform that a buffer takes in, as tf2 itself tells only what lies between samples.
///
/// A sample of a chain of transforms is the newest time at which all of them are known. Static transforms have none. Samples
/// come in by whichever thread fills the buffer; one thread at a time may take them.
class TransformWatch {
 public:
  /// @param buffer must outlive this. What it knows already counts as one sample, the newest.
  TransformWatch(tf2::BufferCore& buffer, const std::string& target_frame, const std::string& source_frame);

  /// @brief Samples since the last call, in order of arrival, of source_frame in target_frame; the oldest are forgotten if
  /// there are more than 8192.
  std::vector<StampedTransform> take();

  /// @brief Forgets what was not taken, and which sample was the last.
  void reset();

 private:
  class Samples;
  std::shared_ptr<Samples> samples_;  // shared with a call that may be under way when this ends
  boost::signals2::scoped_connection connection_;
};

}  // namespace ppc
