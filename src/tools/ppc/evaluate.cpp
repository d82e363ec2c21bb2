// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_file.h"
#include "number_check.h"
#include "patch_plane_clustering/core/region_statistics.h"
#include "patch_plane_clustering/evaluation/boundary_score.h"
#include "patch_plane_clustering/evaluation/hole_score.h"
#include "patch_plane_clustering/evaluation/plane_score.h"
#include "patch_plane_clustering/evaluation/polygon_score.h"
#include "patch_plane_clustering/evaluation/segcomp.h"
#include "plane_files.h"
#include "result_files.h"
#include "subcommands.h"

#include <CLI/CLI.hpp>

#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>

namespace ppc {
namespace {

using Json = nlohmann::ordered_json;

struct EvaluateOptions {
  std::vector<std::string> truth;
  std::vector<std::string> labels;
  std::vector<std::string> clouds;
  std::vector<std::string> polygons;
  std::vector<std::string> truth_planes;
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

Json planeJson(const std::vector<PlanarRegion>& truth, const std::vector<PlanarRegion>& found, const RegionOverlap& overlap,
               double tolerance) {
  const PlaneScore score = planeScore(truth, found, overlap, segcomp(overlap, tolerance));
  return {{"matched", score.matched},
          {"normal_error_deg", score.mean_normal_error * 180.0 / M_PI},
          {"offset_error_mm", score.mean_offset_error * 1e3},
          {"worst_normal_error_deg", score.worst_normal_error * 180.0 / M_PI},
          {"worst_offset_error_mm", score.worst_offset_error * 1e3}};
}

// Against the planes themselves, not a fit: errors of the found ones, and those that a fit to the true pixels has.
void addTrueErrors(std::vector<PlanarRegion> ideal, const std::vector<PlanarRegion>& refits,
                   const std::vector<PlanarRegion>& found, const RegionOverlap& overlap, double tolerance, Json& json) {
  for (PlanarRegion& plane : ideal) {
    for (const PlanarRegion& refit : refits) {
      if (refit.id == plane.id)
        plane.centroid = refit.centroid - plane.plane.signedDistance(refit.centroid) * plane.plane.normal;
    }
  }
  const SegcompScore matches = segcomp(overlap, tolerance);
  const PlaneScore score = planeScore(ideal, found, overlap, matches);
  const PlaneScore refit = refitScore(ideal, refits, overlap, matches);
  json["true_normal_error_deg"] = score.mean_normal_error * 180.0 / M_PI;
  json["true_offset_error_mm"] = score.mean_offset_error * 1e3;
  json["refit_normal_error_deg"] = refit.mean_normal_error * 180.0 / M_PI;
  json["refit_offset_error_mm"] = refit.mean_offset_error * 1e3;
  for (const auto& [name, planes] : {std::pair("", score), std::pair("refit_", refit)}) {
    json[std::string(name) + "median_normalised_error"] = planes.median_normalised_error;
    json[std::string(name) + "within_95"] = planes.within_95;
  }
}

// What needs the points: planes against a fit to the true pixels, and polygons rendered back along every beam.
void scoreWithCloud(const EvaluateOptions& options, const BeamGrid& grid, const LabelImage& truth, const LabelImage& found,
                    const std::string& polygons_file, const std::string& planes_file, Json& line) {
  const std::vector<PlanarRegion> refits = describeRegions(grid, truth);
  const std::vector<PlanarRegion> found_planes = describeRegions(grid, found);
  const RegionOverlap overlap = overlapOf(truth, found, options.min_region);
  line["planes"] = planeJson(refits, found_planes, overlap, options.tolerance);
  if (!planes_file.empty()) {
    addTrueErrors(readPlanes(planes_file), refits, found_planes, overlap, options.tolerance, line["planes"]);
  }
  if (polygons_file.empty()) return;
  const Segmentation polygons = readPolygons(polygons_file);
  const PolygonQuality quality = polygonQuality(polygons.regions, polygons.polygons);
  const LabelImage all = renderPolygons(grid, polygons.regions, polygons.polygons);
  const LabelImage rendered = withoutUnmeasured(grid, all);
  Json json = score(truth, rendered, options);
  const RegionOverlap rendered_overlap = overlapOf(truth, rendered, options.min_region);
  json["planes"] = planeJson(refits, polygons.regions, rendered_overlap, options.tolerance);
  json["polygons"] = quality.polygons;
  json["holes"] = quality.holes;
  const HoleScore holes = holeScore(truth, all, rendered_overlap);
  json["true_holes"] = holes.true_holes;
  json["holes_found"] = holes.found_holes;
  json["hole_recall"] = holes.true_holes > 0 ? Json(static_cast<double>(holes.found_holes) / holes.true_holes) : Json();
  json["openings_found"] = holes.found_openings;
  json["opening_recall"] =
      holes.true_holes > 0 ? Json(static_cast<double>(holes.found_openings) / holes.true_holes) : Json();
  const BoundaryScore boundary =
      boundaryScore(grid, truth, refits, polygons.polygons, rendered_overlap, segcomp(rendered_overlap, options.tolerance));
  json["boundary_error"] = boundary.regions > 0 ? Json(boundary.mean_error) : Json();
  json["vertices"] = quality.vertices;
  json["vertices_per_polygon"] =
      quality.polygons > 0 ? Json(static_cast<double>(quality.vertices) / quality.polygons) : Json();
  int points = 0;
  for (int i = 0; i < grid.size(); ++i) points += grid.valid(i) ? 1 : 0;
  json["compression"] = quality.polygons > 0 ? Json(compression(points, quality)) : Json();
  json["invalid"] = quality.invalid;
  if (quality.invalid > 0) json["first_fault"] = quality.first_fault;
  json["largest_off_plane"] = quality.largest_off_plane;
  line["from_polygons"] = json;
}

void printHead() {
  std::fprintf(stderr, "%-32s", "image");
  for (const auto& column : columns()) std::fprintf(stderr, " %9s", column.c_str());
  std::fprintf(stderr, "\n");
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

void requireCount(const std::vector<std::string>& files, std::size_t labels, const std::string& option) {
  if (files.size() == 1 || files.size() == labels) return;
  throw std::runtime_error(std::to_string(files.size()) + " " + option + " files for " + std::to_string(labels) +
                           " --labels files; give one for all or one for each");
}

void run(const EvaluateOptions& options) {
  const std::size_t n = options.labels.size();
  requireCount(options.truth, n, "--truth");
  if (!options.clouds.empty()) requireCount(options.clouds, n, "--cloud");
  if (!options.polygons.empty() && (options.polygons.size() != n || options.clouds.empty())) {
    throw std::runtime_error("--polygons needs one file for each --labels file, and --cloud for the beams");
  }
  if (!options.truth_planes.empty()) {
    if (options.clouds.empty()) throw std::runtime_error("--truth-planes needs --cloud for the points");
    requireCount(options.truth_planes, n, "--truth-planes");
  }
  std::vector<Json> all;
  for (std::size_t i = 0; i < options.labels.size(); ++i) {
    const std::string& truth = options.truth.size() == 1 ? options.truth[0] : options.truth[i];
    Json line = {{"truth", truth}, {"labels", options.labels[i]}};
    try {
      LabelImage true_labels = readLabels(truth);
      LabelImage labels = readLabels(options.labels[i]);
      if (options.clouds.empty()) {
        line.update(score(true_labels, labels, options));
      } else {
        const BeamGrid grid = readCloud(options.clouds.size() == 1 ? options.clouds[0] : options.clouds[i]);
        true_labels = withoutUnmeasured(grid, std::move(true_labels));
        labels = withoutUnmeasured(grid, std::move(labels));
        line.update(score(true_labels, labels, options));
        const std::string polygons = options.polygons.empty() ? "" : options.polygons[i];
        const std::string planes = options.truth_planes.empty()       ? ""
                                   : options.truth_planes.size() == 1 ? options.truth_planes[0]
                                                                      : options.truth_planes[i];
        scoreWithCloud(options, grid, true_labels, labels, polygons, planes, line);
      }
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(options.labels[i] + ": " + error.what());
    }
    if (all.empty()) printHead();
    std::cout << line.dump() << std::endl;
    printRow(options.labels[i], line);
    if (line.contains("from_polygons")) printRow("  from polygons", line["from_polygons"]);
    all.push_back(line);
  }
  if (all.size() > 1) {
    Json mean = meanOf(all);
    if (all.front().contains("from_polygons")) {
      std::vector<Json> rendered;
      rendered.reserve(all.size());
      for (const Json& line : all) rendered.push_back(line["from_polygons"]);
      mean["from_polygons"] = meanOf(rendered);
    }
    std::cout << mean.dump() << std::endl;
    printRow("mean", mean);
    if (mean.contains("from_polygons")) printRow("  from polygons", mean["from_polygons"]);
  }
}

}  // namespace

void addEvaluate(CLI::App& app) {
  auto* command = app.add_subcommand("evaluate", "Scores label images against the truth (JSON on stdout, table on stderr)");
  auto options = std::make_shared<EvaluateOptions>();
  command->add_option("--truth", options->truth, "True label images; one for all or one for each")->required();
  command->add_option("--labels", options->labels, "Found label images")->required();
  command->add_option("--cloud", options->clouds,
                      "Organised clouds (PCD): adds errors of planes against a fit to the true "
                      "pixels; pixels without a measurement are then left out of all scores");
  command->add_option("--polygons", options->polygons,
                      "Polygons (JSON), rendered back along every beam of the cloud and "
                      "scored as labels are; with their boundary errors, holes, validity, vertices and compression");
  command->add_option("--truth-planes", options->truth_planes,
                      "True planes (JSON, by ppc simulate --truth-planes): adds errors against these, and those of a fit to "
                      "the true pixels");
  command->add_option("--min-region", options->min_region, "True regions of fewer pixels are ignored")
      ->check(CLI::Range(0, 100000000))
      ->capture_default_str();
  command->add_option("--tolerance", options->tolerance, "Overlap of a correct detection")
      ->check(numberIn(0.51, 1.0))
      ->capture_default_str();
  command->callback([options] { run(*options); });
}

}  // namespace ppc
