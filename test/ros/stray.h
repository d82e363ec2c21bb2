// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>
#include <string>

namespace ppc {

/// Another node, `rostopic pub`, that publishes the same message fifty times a second, stamped with the time of the day.
class Stray {
 public:
  Stray(const std::string& topic, const char* type, const char* message) {
    const char* const arguments[] = {"rostopic", "pub", "-s", "-r", "50", topic.c_str(), type, message, nullptr};
    if (posix_spawnp(&process_, "rostopic", nullptr, nullptr, const_cast<char**>(arguments), environ) != 0) process_ = 0;
  }
  ~Stray() {
    if (process_ == 0) return;
    kill(process_, SIGTERM);
    for (int k = 0; k < 50; ++k) {  // now and then rospy does not end, however often it is told to
      if (waitpid(process_, nullptr, WNOHANG) != 0) return;
      usleep(100000);
    }
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  Stray(const Stray&) = delete;
  Stray& operator=(const Stray&) = delete;
  bool runs() const { return process_ != 0; }

 private:
  pid_t process_ = 0;
};

}  // namespace ppc
