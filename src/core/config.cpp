// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/config.h"

#include "patch_plane_clustering/core/nearest_name.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iomanip>
#include <optional>
#include <sstream>
#include <stdexcept>

namespace ppc {
namespace {

using Type = ConfigField::Type;

#define PPC_FIELD(name, type, min, max, member, description)                                          \
  ConfigField {                                                                                       \
    name, type, min, max, description, [](const Config& c) { return static_cast<double>(c.member); }, \
        [](Config& c, double v) { c.member = static_cast<decltype(c.member)>(v); }                    \
  }

std::vector<ConfigField> makeFields() {
  return {
      PPC_FIELD("patch_size", Type::kInt, 2, 64, patch_size,
                "k: columns of a patch; its rows follow from the angular steps [pixels]"),
      PPC_FIELD("sigma_angle", Type::kDouble, 0.001, 1.0, sigma_angle,
                "model tolerance of the angle between coplanar patches [rad]"),
      PPC_FIELD("sigma_distance", Type::kDouble, 0.0001, 1.0, sigma_distance,
                "model tolerance of the distance between coplanar patches, in proportion less below 2.5 mm of noise [m]"),
      PPC_FIELD("similarity_threshold", Type::kDouble, 0.001, 0.999, similarity_threshold,
                "patches of at least this Gaussian similarity are coplanar [1]"),
      PPC_FIELD("equal_angle", Type::kBool, 0, 1, equal_angle, "patches of about equal solid angle, not square in pixels"),
      PPC_FIELD("running_plane", Type::kBool, 0, 1, running_plane,
                "compare patches with the plane of the whole cluster, not only with the neighbour"),
      PPC_FIELD("noise_aware", Type::kBool, 0, 1, noise_aware,
                "add the noise of the fits to sigma_angle and sigma_distance, not those alone"),
      PPC_FIELD("clear_strays", Type::kBool, 0, 1, clear_strays,
                "leave out points that lie nowhere near their neighbours, if more than 1.5 % do"),
      PPC_FIELD(
          "thin_standing_lines", Type::kBool, 0, 1, thin_standing_lines,
          "leave out lines of a cloud that are measured while the scanner waits, label them by those that stand for them"),
      PPC_FIELD("thin_smooth_noise", Type::kBool, 0, 1, thin_smooth_noise,
                "leave out rows and columns if errors of ranges are alike over many pixels, as those of stereo cameras are"),
      PPC_FIELD(
          "noise_by_surface", Type::kBool, 0, 1, noise_by_surface,
          "find surfaces with more noise than is typical at their range, as dark ones have; if the noise is estimated"),
      PPC_FIELD("avoid_range_limit", Type::kBool, 0, 1, avoid_range_limit,
                "begin no region where the sensor's range ends, and what is still measured stands off its plane"),
      PPC_FIELD("merge", Type::kBool, 0, 1, merge, "merge clusters that one plane explains"),
      PPC_FIELD("min_size", Type::kInt, 0, 1000000, min_size, "smallest region, 0 = by the image's size and noise [points]"),
      PPC_FIELD("refine", Type::kBool, 0, 1, refine, "assign points one by one along the borders of clusters"),
      PPC_FIELD("second_pass", Type::kBool, 0, 1, second_pass,
                "look for thin regions with smaller patches in what the first pass left over"),
      PPC_FIELD("split_regions", Type::kBool, 0, 1, split_regions,
                "split regions that two planes explain far better than one, in the second pass"),
      PPC_FIELD("settle_borders", Type::kBool, 0, 1, settle_borders,
                "let regions that meet compete once more for the points along their borders, after the last merge"),
      PPC_FIELD(
          "settle_low_steps", Type::kBool, 0, 1, settle_low_steps,
          "draw borders at steps that noise hides from single points by many, join regions that touch and have one plane"),
      PPC_FIELD("refit_regions", Type::kBool, 0, 1, refit_regions,
                "fit the planes of small regions to the points that they have, before borders follow these planes"),
      PPC_FIELD("dissolve_regions", Type::kBool, 0, 1, dissolve_regions,
                "dissolve thin regions that the planes around them explain better than their own plane does"),
      PPC_FIELD("align_creases", Type::kBool, 0, 1, align_creases,
                "draw the borders of regions that meet at a crease along the line where their planes meet"),
      PPC_FIELD("trim_regions", Type::kBool, 0, 1, trim_regions,
                "take off small regions what of others lies along their borders, drop those that are no planes"),
      PPC_FIELD("extend_regions", Type::kBool, 0, 1, extend_regions,
                "let regions go on along their planes into points that have no region"),
      PPC_FIELD("fill_holes", Type::kBool, 0, 1, fill_holes,
                "give bumps of noise inside of a region, too small for one of their own, to it"),
      PPC_FIELD("max_turn", Type::kDouble, 0.01, 10.0, max_turn,
                "regions whose normal turns by more from end to end, or beyond doubt by three quarters of it, are curved, "
                "not planar; 10 = keep all [rad]"),
      PPC_FIELD("noise_scale", Type::kDouble, 0, 100, noise_scale,
                "factor on the sensor's noise; 0 = estimate the noise from each image [1]"),
      PPC_FIELD("noise_near", Type::kDouble, 0.0001, 1.0, sensor.noise_near,
                "range noise of the sensor, one standard deviation [m]"),
      PPC_FIELD("noise_far", Type::kDouble, 0.0001, 1.0, sensor.noise_far, "range noise beyond noise_far_from [m]"),
      PPC_FIELD("noise_far_from", Type::kDouble, 0.0, 1000.0, sensor.noise_far_from,
                "range from which noise_far applies [m]"),
      PPC_FIELD("noise_relative", Type::kDouble, 0.0, 0.5, sensor.noise_relative, "range noise as a share of the range [1]"),
      PPC_FIELD("simplification_tolerance", Type::kDouble, 0.0, 1.0, polygons.simplification_tolerance,
                "largest distance between an outline and its simplification; 0 = keep every corner [m]"),
      PPC_FIELD("pixel_tolerance", Type::kDouble, 0.0, 10.0, polygons.pixel_tolerance,
                "the same in pixels across the edge, the larger applies: removes the staircase of the pixels [pixels]"),
      PPC_FIELD("min_hole_size", Type::kInt, 1, 1000000, polygons.min_hole_size,
                "holes of fewer pixels are filled, specks left out [pixels]"),
      PPC_FIELD("snap_creases", Type::kBool, 0, 1, polygons.snap_creases,
                "move vertices along the common line of two neighbouring planes onto it"),
      PPC_FIELD("threads", Type::kInt, 1, 64, threads, "worker threads; the result does not depend on them [1]"),
  };
}

#undef PPC_FIELD

// The words of YAML 1.1, so that a file means the same to `rosparam load` and to the tools.
std::optional<bool> truthOf(std::string word) {
  for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (word == "true" || word == "yes" || word == "on") return true;
  if (word == "false" || word == "no" || word == "off") return false;
  return std::nullopt;
}

std::string rangeOf(const ConfigField& field) {
  std::ostringstream text;
  text << "in [" << std::setprecision(10) << field.min << ", " << field.max << "]";  // 1000000, not 1e+06
  return text.str();
}

const ConfigField& fieldNamed(const std::string& name) {
  const auto& fields = configFields();
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const auto& f) { return f.name == name; });
  if (found != fields.end()) return *found;
  std::vector<std::string> names;
  names.reserve(fields.size());
  for (const ConfigField& field : fields) names.push_back(field.name);
  throw std::invalid_argument("unknown parameter '" + name + "'; did you mean '" + nearestName(names, name) + "'?");
}

constexpr int kLeastSize = 60;  // of a region, if none is given [points]

}  // namespace

int smallestRegion(const Config& config, int pixels) {
  constexpr int kPixelsAPoint = 550, kMost = 350;
  // Three points make a plane.
  return config.min_size > 0 ? std::max(3, config.min_size) : std::clamp(pixels / kPixelsAPoint, kLeastSize, kMost);
}

int smallestRegion(const Config& config, int pixels, double noise) {
  constexpr double kFewerBelow = 0.005, kLeastShare = 1.0 / 3.0;
  const int of_any_noise = smallestRegion(config, pixels);
  if (config.min_size > 0) return of_any_noise;
  return std::max(kLeastSize, static_cast<int>(std::clamp(noise / kFewerBelow, kLeastShare, 1.0) * of_any_noise));
}

const std::vector<ConfigField>& configFields() {
  static const std::vector<ConfigField> fields = makeFields();
  return fields;
}

void setConfigField(Config& config, const std::string& name, double value) {
  const ConfigField& field = fieldNamed(name);
  const bool whole = field.type == Type::kDouble || value == std::round(value);
  if (!whole || !(field.min <= value && value <= field.max)) {
    std::ostringstream message;
    message << "parameter '" << name << "' = " << std::setprecision(10) << value << " is not "
            << (whole ? "" : "a whole number ") << rangeOf(field);
    throw std::invalid_argument(message.str());
  }
  field.set(config, value);
}

void setConfigField(Config& config, const std::string& name, const std::string& value) {
  const ConfigField& field = fieldNamed(name);
  if (field.type == Type::kBool) {
    if (const auto truth = truthOf(value)) return field.set(config, *truth ? 1.0 : 0.0);
  }
  double number = 0.0;
  std::istringstream in(value);
  in.imbue(std::locale::classic());
  if (!(in >> number) || !(in >> std::ws).eof()) {
    const std::string wanted = field.type == Type::kBool  ? "true or false"
                               : field.type == Type::kInt ? "a whole number " + rangeOf(field)
                                                          : "a number " + rangeOf(field);
    throw std::invalid_argument("parameter '" + name + "' = '" + value + "' is not " + wanted);
  }
  setConfigField(config, name, number);
}

}  // namespace ppc
