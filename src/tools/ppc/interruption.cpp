// SPDX-License-Identifier: BSD-3-Clause
#include "interruption.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>

namespace ppc {
namespace {

// All that a signal handler may look at. A longer path stays behind.
std::array<char, 4096> doomed{};
volatile std::sig_atomic_t armed = 0;

extern "C" void removeAndDie(int signal) {
  if (armed != 0) unlink(doomed.data());
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

RemovedWhenInterrupted::RemovedWhenInterrupted(const std::string& path) {
  if (path.size() >= doomed.size()) return;
  *std::copy(path.begin(), path.end(), doomed.begin()) = '\0';
  armed = 1;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) {
    if (std::signal(signal, removeAndDie) == SIG_IGN) std::signal(signal, SIG_IGN);  // under nohup, say
  }
}

RemovedWhenInterrupted::~RemovedWhenInterrupted() { armed = 0; }

}  // namespace ppc
