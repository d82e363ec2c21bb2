// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/region_polygons.h"
#include "patch_plane_clustering/core/sensor_model.h"

#include <string>
#include <vector>

namespace ppc {

/// @brief All that a user can tune. Each default is given here once; parameter servers, YAML files, `--set` and
/// dynamic_reconfigure know the fields by the names in configFields().
struct Config {
  int patch_size = 4;                 ///< k: columns of a patch; its rows follow from the angular steps [pixels]
  double sigma_angle = 0.005;         ///< model tolerance of the angle between coplanar patches [rad]
  double sigma_distance = 0.005;      ///< model tolerance of the distance between coplanar patches, in proportion less
                                      ///< below 2.5 mm of noise (CoplanarityTolerance::forNoise()) [m]
  double similarity_threshold = 0.1;  ///< patches of at least this Gaussian similarity are coplanar, 0..1
  bool equal_angle = true;            ///< patches of about equal solid angle; false: square in pixels
  bool running_plane = true;          ///< compare patches with the plane of the whole cluster; false: with the neighbour
  bool noise_aware = true;            ///< add the noise to both sigmas; false: Gaussians of the sigmas alone
  bool clear_strays = true;           ///< leave out points nowhere near their neighbours, if more than 1.5 % are
  bool thin_standing_lines = true;    ///< leave out lines of a cloud that are measured while the scanner waits
  bool thin_smooth_noise = true;      ///< leave out rows and columns if errors are alike over many pixels
  bool noise_by_surface = true;       ///< find surfaces with more noise than is typical; only if the noise is estimated
  bool avoid_range_limit = true;      ///< begin no region where the sensor's range ends, and what is measured stands off
  bool merge = true;                  ///< merge clusters that one plane explains
  int min_size = 0;                   ///< smallest region [points]; 0: by the image's size and noise, see smallestRegion()
  bool refine = true;                 ///< assign points one by one along the borders of clusters
  bool second_pass = true;            ///< look for thin regions with smaller patches in what the first pass left over
  bool split_regions = true;          ///< split regions that two planes explain far better than one, in the second pass
  bool settle_borders = true;         ///< let regions that meet compete once more along their borders, after the last merge
  bool settle_low_steps = true;       ///< settle steps lower than white noise by many points, join regions of one plane
  bool refit_regions = true;          ///< fit planes of small regions to their points before borders follow these planes
  bool dissolve_regions = true;       ///< dissolve thin regions that the planes around them explain better than their own
  bool align_creases = true;          ///< draw borders at creases along the line where the planes meet
  bool trim_regions = true;           ///< take off small regions what of others lies along their borders, drop no planes
  bool extend_regions = true;         ///< let regions go on along their planes into points that have no region
  bool fill_holes = true;             ///< give bumps of noise inside of a region, too small for one, to it
  double max_turn = 0.45;             ///< regions whose normal turns by more from end to end are curved [rad]
  double noise_scale = 0.0;           ///< factor on the sensor's noise; 0 = estimate the noise from each image
  int threads = 1;                    ///< worker threads; the result does not depend on them
  SensorModel sensor;
  PolygonOptions polygons;
};

/// @brief Points that a region must have at least: config.min_size (but no less than 3) or, if that is 0, one for every 550
/// pixels of the image, 60 to 350. A fixed number would leave out of a coarse scan what a person calls a wall.
int smallestRegion(const Config& config, int pixels);
/// @brief The same for ranges with so much noise on average [m]: below 5 mm, fewer points make a region, in proportion, down
/// to a third and 60, as they tell a plane as well. For PPC if Config::noise_aware; other methods do not know the noise.
int smallestRegion(const Config& config, int pixels, double noise);

/// @brief One tunable field: its public name, meaning, unit and allowed range. Booleans and integers are carried as doubles.
struct ConfigField {
  enum class Type { kBool, kInt, kDouble };
  std::string name;
  Type type = Type::kDouble;
  double min = 0.0;
  double max = 0.0;
  std::string description;  ///< ends with the unit in brackets
  double (*get)(const Config&) = nullptr;
  void (*set)(Config&, double) = nullptr;
};

/// @brief Every tunable field, in the order in which it is documented. Thread-safe.
const std::vector<ConfigField>& configFields();

/// @brief Sets a field by name. @throws std::invalid_argument naming the field, the value and the allowed range or, for an
/// unknown name, the nearest known one.
void setConfigField(Config& config, const std::string& name, double value);

/// @brief As above, from text ("0.05", "true"), as on a command line.
void setConfigField(Config& config, const std::string& name, const std::string& value);

}  // namespace ppc
