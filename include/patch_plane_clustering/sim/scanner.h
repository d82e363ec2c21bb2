// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/range_image.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/sim/error_model.h"
#include "patch_plane_clustering/sim/motion.h"
#include "patch_plane_clustering/sim/scene.h"
#include "patch_plane_clustering/sim/sensor.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ppc::sim {

/// @brief Everything about the scanner but the scene. The laser's pose in the tilt base is R_axis(tilt) * mount.
struct ScannerOptions {
  Sensor sensor = makeSensor("utm_30lx");
  Motion motion;
  Eigen::Isometry3d mount = Eigen::Isometry3d::Identity();  ///< laser in the tilting frame: lever arm and mounting rotation
  ErrorModel errors;
  double joint_rate = 100.0;  ///< joint samples a second [Hz]
  int poses_per_row = 5;      ///< of assembled range images
};

/// @brief Pose of the laser in the tilting frame from its lever arm [m] and rotation by roll, pitch and yaw [rad] (REP 103).
Eigen::Isometry3d mountFrom(const Eigen::Vector3d& lever_arm, const Eigen::Vector3d& rpy);

/// @brief One line as the hardware gives it, with the truth.
struct ScanLine {
  int index = 0;                     ///< 0, 1, 2, ... since the start
  double stamp = 0.0;                ///< time of the first beam since the start [s]
  std::vector<float> ranges;         ///< [m]; -Inf too close, +Inf no return, NaN bad (REP 117)
  std::vector<float> true_ranges;    ///< distance to the first surface, +Inf if there is none within any distance [m]
  std::vector<double> true_tilts;    ///< [rad]
  std::vector<std::int32_t> labels;  ///< plane id; 0: no plane, no valid reading, or a mixed pixel off every surface
};

/// @brief One joint sample.
struct JointSample {
  double stamp = 0.0;  ///< [s]
  double angle = 0.0;  ///< as reported [rad]
};

/// @brief One pass as an ideal driver would assemble it from the reported angles, with the truth in the same layout.
struct Sweep {
  RangeImage image;   ///< measured ranges at reported poses
  RangeImage truth;   ///< true ranges at true poses: its points are the true ones; +Inf where there is no surface
  LabelImage labels;  ///< as ScanLine::labels
};

/// @brief A tilting laser in a scene. Every line and joint sample is a function of its index and the seed, so they can be
/// asked for in any order, and the same ones come again. All methods are thread-safe.
class Scanner {
 public:
  /// @throws std::invalid_argument naming the option, its value and the allowed range.
  Scanner(Scene scene, ScannerOptions options, std::uint64_t seed);

  const ScannerOptions& options() const { return options_; }
  const Scene& scene() const { return scene_; }

  double lineDuration() const { return 1.0 / options_.sensor.line_rate; }
  double passDuration() const { return options_.motion.lines_per_pass * lineDuration(); }
  /// Time between beams [s]; 0 if the motion within a line is switched off.
  double timeIncrement() const;

  /// The `index`-th line, index >= 0.
  ScanLine line(int index) const;

  /// The `index`-th joint sample, index >= 0.
  JointSample joint(int index) const;

  /// The reported angle at a time >= 0, interpolated linearly between the joint samples around it [rad].
  double reportedTilt(double t) const;

  /// Pose of the laser in the tilt base, as it is said to be for a tilt; and as it really is.
  Eigen::Isometry3d nominalPose(double tilt) const;
  Eigen::Isometry3d truePose(double tilt) const;

  /// Lines pass * lines_per_pass ... as one range image, pass >= 0. Rows in ascending reported tilt.
  Sweep sweep(int pass) const;

 private:
  Hit castBeam(const Eigen::Isometry3d& pose, double bearing, double across, double up) const;

  Scene scene_;
  ScannerOptions options_;
  std::uint64_t seed_;
  Eigen::Isometry3d true_mount_;
};

/// @brief Shorthand for experiments: one pass of a nodding scanner (300 lines over +-60 deg, laser on the axis).
/// @param scene,sensor names known to makeScene() and makeSensor(). The seed determines scene and errors.
Sweep simulateSweep(const std::string& scene, const std::string& sensor, const ErrorModel& errors, std::uint64_t seed,
                    int lines = 300);

}  // namespace ppc::sim
