// SPDX-License-Identifier: BSD-3-Clause
#include "message_segmenter.h"

#include "patch_plane_clustering/ros/processor_time.h"
#include "patch_plane_clustering/ros/range_image_conversions.h"
#include "patch_plane_clustering/ros/same_image.h"
#include "patch_plane_clustering/ros/segmentation_conversions.h"

#include <algorithm>
#include <stdexcept>

namespace ppc {

MessageSegmenter::MessageSegmenter(const std::string& method) : method_name_(method), method_(makeSegmenter(method)) {}

void MessageSegmenter::segment(const Arrival& arrival, const std::shared_ptr<const Config>& config) {
  const double processor_start = threadProcessorMilliseconds();
  const RangeImageMsg::ConstPtr known = foreseen_;
  foreseen_.reset();
  was_foreseen_ = known && arrival.image && config == foreseen_with_ && isSameImage(*known, *arrival.image);
  if (!was_foreseen_) {
    processor_milliseconds_ = 0.0;
    start(arrival, *config);
  }
  if (arrival.foreseen) {
    foreseen_ = arrival.image;
    foreseen_with_ = config;
  }
  processor_milliseconds_ += threadProcessorMilliseconds() - processor_start;
}

void MessageSegmenter::start(const Arrival& arrival, const Config& config) {
  const auto begin = Arrival::Clock::now();
  readGrid(arrival, config.threads);
  if (method_name_ == "ppc" && std::min(grid_.rows, grid_.cols) < config.patch_size) {
    throw std::invalid_argument("patch_size = " + std::to_string(config.patch_size) + " is larger than the image (" +
                                std::to_string(grid_.rows) + " x " + std::to_string(grid_.cols) + ")");
  }
  const std::chrono::duration<double, std::milli> conversion = Arrival::Clock::now() - begin;
  method_->segment(grid_, config, segmentation_);
  segmentation_.stages.insert(segmentation_.stages.begin(), {"message", conversion.count()});
}

void MessageSegmenter::readGrid(const Arrival& arrival, int threads) {
  if (arrival.image) {
    fromMessage(*arrival.image, image_);
    toBeamGrid(image_, columns_, grid_, threads);
  } else {
    gridFromCloud(*arrival.cloud, coordinates_, grid_);
  }
}

}  // namespace ppc
