// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/image_accounts.h"

#include <algorithm>

namespace ppc {
namespace {

constexpr double kSilence = 60.0;  // [s]

using diagnostic_msgs::DiagnosticStatus;

}  // namespace

void ImageAccounts::receive(const std::string& publisher, std::uint32_t sequence) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++counts_.received;
  sequence_.see(publisher, sequence);
  counts_.lost = sequence_.lost();
}

void ImageAccounts::segment(double milliseconds, bool foreseen) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++counts_.segmented;
  if (foreseen) ++counts_.foreseen;
  worst_milliseconds_ = std::max(worst_milliseconds_, milliseconds);
}

void ImageAccounts::refuse(const std::string& why) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++counts_.refused;
  last_fault_ = why;
}

void ImageAccounts::overtake() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++counts_.overtaken;
}

ImageCounts ImageAccounts::counts() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return counts_;
}

void ImageAccounts::write(double elapsed, diagnostic_updater::DiagnosticStatusWrapper& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  silence_ = counts_.received == reported_.received ? silence_ + elapsed : 0.0;
  status.summary(DiagnosticStatus::OK, counts_.received == 0 ? "no image yet" : "segmenting");
  if (silence_ > kSilence) status.mergeSummaryf(DiagnosticStatus::WARN, "no image for %.0f s", silence_);
  if (counts_.refused > reported_.refused) {
    status.mergeSummaryf(DiagnosticStatus::WARN, "%u images refused: %s", counts_.refused - reported_.refused,
                         last_fault_.c_str());
  }
  if (counts_.overtaken > reported_.overtaken) {
    status.mergeSummaryf(DiagnosticStatus::WARN, "%u images overtaken: they come faster than they can be segmented",
                         counts_.overtaken - reported_.overtaken);
  }
  if (counts_.lost > reported_.lost) {
    status.mergeSummaryf(DiagnosticStatus::WARN, "%u images lost on the way", counts_.lost - reported_.lost);
  }
  status.add("Images received", counts_.received);
  status.add("Images segmented", counts_.segmented);
  status.add("Images segmented before their sweep's end was certain", counts_.foreseen);
  status.add("Images refused", counts_.refused);
  status.add("Images overtaken", counts_.overtaken);
  status.add("Images lost on the way", counts_.lost);
  status.add("Longest time from message to polygons [ms]", worst_milliseconds_);
  worst_milliseconds_ = 0.0;
  reported_ = counts_;
}

}  // namespace ppc
