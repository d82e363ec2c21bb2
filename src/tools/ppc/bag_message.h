// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <rosbag/message_instance.h>

#include <stdexcept>
#include <string>

namespace ppc {

/// @brief A message of a bag that is not what its connection says.
class DamagedMessage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// @brief The message; null if it is of another type. @throws DamagedMessage naming its topic. Never anything else: what a
/// damaged bag makes of a length may be an exception of ROS, of rosbag or of the memory.
template <typename Message>
boost::shared_ptr<Message> messageOf(const rosbag::MessageInstance& instance) {
  try {
    return instance.instantiate<Message>();
  } catch (const std::exception& error) {
    throw DamagedMessage("is damaged: a message on " + instance.getTopic() + " cannot be read (" + error.what() + ")");
  }
}

}  // namespace ppc
