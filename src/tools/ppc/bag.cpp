// SPDX-License-Identifier: BSD-3-Clause
// `ppc bag`: a bag of scans in, a bag with range images and polygons out.
#include "bag_sweeps.h"
#include "files.h"
#include "method_options.h"
#include "output_bag.h"
#include "patch_plane_clustering/baselines/plane_segmenter.h"
#include "patch_plane_clustering/ros/processor_time.h"
#include "patch_plane_clustering/ros/range_image_conversions.h"
#include "patch_plane_clustering/ros/segmentation_conversions.h"
#include "result_files.h"
#include "subcommands.h"

#include <rosbag/bag.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <iostream>
#include <memory>

namespace ppc {
namespace {

struct Options {
  std::string input, output;
  std::string prefix = "/";
  bool only_new = false, clouds = false;
  MethodOptions method;
  BagOptions bag;
};

// rosbag's exceptions do not tell which file they are about.
template <typename Write>
void writing(const std::string& suspects, const Write& write) {
  try {
    write();
  } catch (const rosbag::BagException& error) {
    throw std::runtime_error(suspects + " cannot be written (" + error.what() + ")");
  }
}

class Writer {
 public:
  Writer(const Options& options, rosbag::Bag& out)
      : options_(options), config_(options.method.config()), method_(options.method.segmenter()), out_(out) {}

  void copy(const rosbag::MessageInstance& message) {
    if (options_.only_new) return;
    writing(options_.input + " is damaged, or " + options_.output,
            [&] { out_.write(message.getTopic(), message.getTime(), message, message.getConnectionHeader()); });
  }

  void add(BagSweep&& bag) {
    std_msgs::Header header;
    header.seq = static_cast<std::uint32_t>(index_);
    header.stamp = toTime(bag.sweep.stamp);
    header.frame_id = bag.frame_id;
    const auto start = std::chrono::steady_clock::now();
    const double processor_start = threadProcessorMilliseconds();
    // As the nodelet gets it: poses are rounded on their way through a message, and results shall be the same to the bit.
    const RangeImageMsg image = toMessage(bag.sweep, header);
    const BeamGrid grid = toBeamGrid(fromMessage(image));
    const Segmentation result = segmentWith(*method_, grid, config_);
    SegmentationStatistics statistics = toStatistics(result, header);
    statistics.method = options_.method.method;
    statistics.total_milliseconds =
        static_cast<float>(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    statistics.processor_milliseconds = static_cast<float>(threadProcessorMilliseconds() - processor_start);
    statistics.images_received = static_cast<std::uint32_t>(index_ + 1);
    statistics.lines = image.lines;

    write("range_image", bag.written, image);
    write("polygons", bag.written, toPolygonArray(result, header));
    write("statistics", bag.written, statistics);
    if (options_.clouds) {
      write("points", bag.written, toPointCloud(bag.sweep.image, header));
      write("segmented_points", bag.written, toSegmentedCloud(grid, result.labels, header));
    }
    nlohmann::ordered_json line = {{"input", options_.input}, {"image", index_++}, {"stamp", bag.sweep.stamp}};
    line.update(statisticsJson(grid, result));
    std::cout << line.dump() << std::endl;
  }

 private:
  template <typename Message>
  void write(const std::string& name, const ros::Time& time, const Message& message) {
    writing(options_.output, [&] { out_.write(options_.prefix + name, time, message); });
  }

  const Options& options_;
  Config config_;
  std::unique_ptr<PlaneSegmenter> method_;
  rosbag::Bag& out_;
  int index_ = 0;
};

void run(Options options) {
  if (options.prefix.empty() || options.prefix.back() != '/') options.prefix += '/';
  requireReadableFile(options.input);
  requireDistinct({options.input, options.method.config_file}, {options.output});
  requireWritable(options.output);
  writeBag(options.output, [&](rosbag::Bag& out) {
    Writer writer(options, out);
    readSweeps(
        options.input, options.bag, [&](const rosbag::MessageInstance& message) { writer.copy(message); },
        [&](BagSweep&& sweep) { writer.add(std::move(sweep)); }, showProgress);
  });
}

}  // namespace

void addBag(CLI::App& app) {
  auto* command = app.add_subcommand("bag", "Adds range images, polygons and statistics to recorded scans");
  auto options = std::make_shared<Options>();
  command->add_option("input", options->input, "Bag to read")->required();
  command->add_option("output", options->output, "Bag to write")->required();
  command->add_option("--prefix", options->prefix, "Namespace of range_image, polygons and statistics")
      ->capture_default_str();
  command->add_flag("--only-new", options->only_new, "Do not copy the messages of the input");
  command->add_flag("--clouds", options->clouds, "Add points and segmented_points too");
  options->method.addTo(*command);
  options->bag.addTo(*command);
  command->callback([options] { run(*options); });
}

}  // namespace ppc
