// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/ros/sequence_watch.h"

#include <diagnostic_updater/DiagnosticStatusWrapper.h>
#include <cstdint>
#include <mutex>
#include <string>

namespace ppc {

/// @brief Where every image went: received = segmented + refused + overtaken + at most two that wait or are in work.
struct ImageCounts {
  std::uint32_t received = 0;
  std::uint32_t segmented = 0;
  std::uint32_t foreseen = 0;   ///< of these, before the end of their sweep was certain
  std::uint32_t refused = 0;    ///< contradict themselves, or too small for the configuration
  std::uint32_t overtaken = 0;  ///< a newer one came before their turn
  std::uint32_t lost = 0;       ///< never received, see SequenceWatch
  std::uint32_t skipped() const { return refused + overtaken; }
};

/// @brief Counts the images of the plane clustering and tells of them in diagnostics. Thread-safe.
class ImageAccounts {
 public:
  /// @param publisher node that sent it @param sequence header.seq
  void receive(const std::string& publisher, std::uint32_t sequence);
  /// @param milliseconds from message to polygons @param foreseen segmented before it came
  void segment(double milliseconds, bool foreseen);
  void refuse(const std::string& why);
  void overtake();
  ImageCounts counts() const;

  /// @brief Compares with the report before. @param elapsed wall time since that [s]
  void write(double elapsed, diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  mutable std::mutex mutex_;
  ImageCounts counts_;
  ImageCounts reported_;
  SequenceWatch sequence_;
  std::string last_fault_;
  double worst_milliseconds_ = 0.0;  // since the last report
  double silence_ = 0.0;             // wall time without an image [s]
};

}  // namespace ppc
