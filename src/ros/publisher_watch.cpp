// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/publisher_watch.h"

namespace ppc {
namespace {

constexpr double kSilence = 2.0;  // [s]

}  // namespace

bool PublisherWatch::accepts(const std::string& publisher, double now, int publishers) {
  const bool gone = !any_ || publishers <= 1 || now - last_ > kSilence;
  if (publisher != kept_ && !gone) return false;
  kept_ = publisher;
  last_ = now;
  any_ = true;
  return true;
}

std::string PublisherWatch::faultOf(const std::string& publisher, double now, int publishers) {
  if (accepts(publisher, now, publishers)) return {};
  return "published by " + publisher + " too, but that of " + kept_ + " is used";
}

}  // namespace ppc
