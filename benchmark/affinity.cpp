// SPDX-License-Identifier: BSD-3-Clause
#include "affinity.h"

#include <sched.h>

namespace ppc::bench {
namespace {

const cpu_set_t& processorsAtStart() {
  static const cpu_set_t set = [] {
    cpu_set_t found;
    CPU_ZERO(&found);
    sched_getaffinity(0, sizeof found, &found);
    return found;
  }();
  return set;
}

}  // namespace

int pinToOneProcessor() {
  const cpu_set_t& all = processorsAtStart();
  int last = CPU_SETSIZE - 1;
  while (last >= 0 && !CPU_ISSET(last, &all)) --last;
  if (last < 0) return -1;
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(last, &one);
  return sched_setaffinity(0, sizeof one, &one) == 0 ? last : -1;
}

void unpin() { sched_setaffinity(0, sizeof(cpu_set_t), &processorsAtStart()); }

}  // namespace ppc::bench
