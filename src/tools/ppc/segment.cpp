// SPDX-License-Identifier: BSD-3-Clause
#include "bag_check.h"
#include "bag_sweeps.h"
#include "cloud_file.h"
#include "files.h"
#include "method_options.h"
#include "patch_plane_clustering/baselines/plane_segmenter.h"
#include "patch_plane_clustering/core/quantile.h"
#include "patch_plane_clustering/ros/range_image_conversions.h"
#include "picture.h"
#include "result_files.h"
#include "subcommands.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <iostream>
#include <memory>

namespace ppc {
namespace {

struct SegmentOptions {
  std::string input;
  MethodOptions method;
  std::string labels;
  std::string polygons;
  std::string mesh;
  std::string picture;
  BagOptions bag;
  int repeat = 1;
};

// Median of each stage over several runs; all runs have the same stages, for they do the same work.
std::vector<StageTime> medianStages(const std::vector<std::vector<StageTime>>& runs) {
  std::vector<StageTime> medians = runs.front();
  for (std::size_t stage = 0; stage < medians.size(); ++stage) {
    std::vector<double> times;
    times.reserve(runs.size());
    for (const auto& run : runs) times.push_back(run[stage].second);
    medians[stage].second = median(times);
  }
  return medians;
}

void segmentImage(const SegmentOptions& options, const Config& config, PlaneSegmenter& method, const BeamGrid& grid,
                  const ImageSource& source, int index, bool several) {
  Segmentation result = segmentWith(method, grid, config);
  if (options.repeat > 1) {  // the run above was a warm-up
    std::vector<std::vector<StageTime>> runs;
    runs.reserve(static_cast<std::size_t>(options.repeat));
    Segmentation again;  // in memory that is kept, as by the nodelet
    for (int i = 0; i < options.repeat; ++i) {
      method.segment(grid, config, again);
      runs.push_back(again.stages);
    }
    result.stages = medianStages(runs);
  }
  if (!options.labels.empty()) writeImage(numbered(options.labels, index, several), labelPicture(result.labels));
  if (!options.polygons.empty()) {
    writeText(numbered(options.polygons, index, several), polygonsJson(grid, result, source).dump(1) + "\n");
  }
  if (!options.mesh.empty()) writeText(numbered(options.mesh, index, several), meshPly(result));
  if (!options.picture.empty()) {
    writeImage(numbered(options.picture, index, several), drawSegmentation(grid, result));
  }
  nlohmann::ordered_json line = {{"input", options.input}, {"image", index}, {"method", options.method.method}};
  line.update(statisticsJson(grid, result));
  std::cout << line.dump() << std::endl;
}

void run(const SegmentOptions& options) {
  const std::vector<std::string> outputs = {options.labels, options.polygons, options.mesh, options.picture};
  requireDistinct({options.input, options.method.config_file}, outputs);
  for (const std::string& path : outputs) requireWritable(path);
  const Config config = options.method.config();
  const auto method = options.method.segmenter();
  requireReadableFile(options.input);
  if (!isBag(options.input)) {
    std::string note;
    const BeamGrid grid = readCloud(options.input, &note);
    if (!note.empty()) std::cerr << note << "\n";
    segmentImage(options, config, *method, grid, {}, 0, false);
    return;
  }
  int index = 0;
  const auto on_sweep = [&](BagSweep&& bag) {
    const ImageSource source{bag.frame_id, bag.sweep.stamp};
    // Through a message, as the nodelet gets it, for the same results.
    const BeamGrid grid = toBeamGrid(fromMessage(toMessage(bag.sweep.image, std_msgs::Header())));
    segmentImage(options, config, *method, grid, source, index++, true);
  };
  readSweeps(options.input, options.bag, {}, on_sweep, showProgress);
}

}  // namespace

void addSegment(CLI::App& app) {
  auto* command = app.add_subcommand("segment", "Finds the planar regions of an organised cloud or of the sweeps in a bag");
  auto options = std::make_shared<SegmentOptions>();
  command->add_option("input", options->input, "Organised cloud (.pcd) or recorded scans (.bag)")->required();
  options->method.addTo(*command);
  command->add_option("--labels", options->labels, "Label image to write, 16-bit PNG, 0 = no plane");
  command->add_option("--polygons", options->polygons, "Polygons to write, JSON");
  command->add_option("--mesh", options->mesh, "Polygons as coloured triangles to write, PLY");
  command->add_option("--picture", options->picture, "Picture of ranges, labels and outlines to write, PNG");
  options->bag.addTo(*command);
  command->add_option("--repeat", options->repeat, "Segments N times after a warm-up and reports the median times")
      ->check(CLI::Range(1, 100000));
  command->callback([options] { run(*options); });
}

}  // namespace ppc
