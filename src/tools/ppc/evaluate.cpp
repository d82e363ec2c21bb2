// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/evaluation/segcomp.h"
#include "result_files.h"
#include "subcommands.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <iostream>
#include <memory>

namespace patch_plane_clustering {
namespace {

using Json = nlohmann::ordered_json;

struct EvaluateOptions {
  std::vector<std::string> truth;
  std::vector<std::string> labels;
  int min_region = 400;
  double tolerance = 0.8;
};

// Names of the numbers that are averaged over several images, in the order of the table.
const std::vector<std::string>& columns() {
  static const std::vector<std::string> names = {"true",  "found", "correct",  "spurious",  "over",      "under", "missed",
                                                 "noise", "f1",    "mean_iou", "pixel_iou", "precision", "recall"};
  return names;
}

Json score(const LabelImage& truth, const LabelImage& found, const EvaluateOptions& options) {
  const RegionOverlap overlap = overlapOf(truth, found, options.min_region);
  const SegcompScore at = segcomp(overlap, options.tolerance);
  const OverlapScore pixels = overlapScore(overlap);
  Json json;
  json["true"] = overlap.true_ids.size();
  json["found"] = overlap.found_ids.size();
  json["correct"] = at.correct;
  json["spurious"] = static_cast<int>(overlap.found_ids.size()) - at.correct;
  json["over"] = at.over_segmented;
  json["under"] = at.under_segmented;
  json["missed"] = at.missed;
  json["noise"] = at.noise;
  json["f1"] = f1(overlap, at);
  json["mean_iou"] = pixels.mean_iou;
  json["pixel_iou"] = pixels.weighted_iou;
  json["precision"] = pixels.precision;
  json["recall"] = pixels.recall;
  json["ignored_true"] = overlap.ignored_true;
  json["ignored_found"] = overlap.ignored_found;
  Json curve = Json::array();
  for (int percent = 51; percent <= 95; ++percent) {
    const SegcompScore s = segcomp(overlap, percent / 100.0);
    curve.push_back({{"tolerance", percent / 100.0},
                     {"correct", s.correct},
                     {"over", s.over_segmented},
                     {"under", s.under_segmented},
                     {"missed", s.missed},
                     {"noise", s.noise}});
  }
  json["curve"] = curve;
  return json;
}

void printRow(const std::string& name, const Json& json) {
  const std::string shown = name.size() > 32 ? "..." + name.substr(name.size() - 29) : name;
  std::fprintf(stderr, "%-32s", shown.c_str());
  for (const auto& column : columns()) {
    const Json& value = json[column];
    std::fprintf(stderr, value.is_number_integer() ? " %9.0f" : " %9.3f", value.get<double>());
  }
  std::fprintf(stderr, "\n");
}

// Means over the images; the curve is averaged tolerance by tolerance.
Json meanOf(const std::vector<Json>& all) {
  Json mean;
  const auto n = static_cast<double>(all.size());
  const auto average = [&](const auto& value) {
    double sum = 0.0;
    for (const Json& json : all) sum += value(json).template get<double>();
    return sum / n;
  };
  mean["images"] = all.size();
  for (const auto& column : columns()) mean[column] = average([&](const Json& j) -> const Json& { return j[column]; });
  mean["curve"] = Json::array();
  for (std::size_t i = 0; i < all.front()["curve"].size(); ++i) {
    Json point = {{"tolerance", all.front()["curve"][i]["tolerance"]}};
    for (const char* name : {"correct", "over", "under", "missed", "noise"}) {
      point[name] = average([&](const Json& j) -> const Json& { return j["curve"][i][name]; });
    }
    mean["curve"].push_back(point);
  }
  return mean;
}

void run(const EvaluateOptions& options) {
  if (options.truth.size() != 1 && options.truth.size() != options.labels.size()) {
    throw std::runtime_error(std::to_string(options.truth.size()) + " --truth files for " +
                             std::to_string(options.labels.size()) + " --labels files; give one for all or one for each");
  }
  std::fprintf(stderr, "%-32s", "image");
  for (const auto& column : columns()) std::fprintf(stderr, " %9s", column.c_str());
  std::fprintf(stderr, "\n");
  std::vector<Json> all;
  for (std::size_t i = 0; i < options.labels.size(); ++i) {
    const std::string& truth = options.truth.size() == 1 ? options.truth[0] : options.truth[i];
    Json line = {{"truth", truth}, {"labels", options.labels[i]}};
    try {
      line.update(score(readLabels(truth), readLabels(options.labels[i]), options));
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(options.labels[i] + ": " + error.what());
    }
    std::cout << line.dump() << std::endl;
    printRow(options.labels[i], line);
    all.push_back(line);
  }
  if (all.size() > 1) {
    const Json mean = meanOf(all);
    std::cout << mean.dump() << std::endl;
    printRow("mean", mean);
  }
}

}  // namespace

void addEvaluate(CLI::App& app) {
  auto* command = app.add_subcommand("evaluate", "Scores label images against the truth (JSON on stdout, table on stderr)");
  auto options = std::make_shared<EvaluateOptions>();
  command->add_option("--truth", options->truth, "True label images; one for all or one for each")->required();
  command->add_option("--labels", options->labels, "Found label images")->required();
  command->add_option("--min-region", options->min_region, "True regions of fewer pixels are ignored")
      ->capture_default_str();
  command->add_option("--tolerance", options->tolerance, "Overlap of a correct detection")
      ->check(CLI::Range(0.51, 1.0))
      ->capture_default_str();
  command->callback([options] { run(*options); });
}

}  // namespace patch_plane_clustering
