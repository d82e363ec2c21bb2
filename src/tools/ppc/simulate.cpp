// SPDX-License-Identifier: BSD-3-Clause
// `ppc simulate`: scans of a simulated scanner as a bag, or as organised clouds with ground-truth labels.
#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/connected_pieces.h"
#include "patch_plane_clustering/sim/scanner.h"

#include "files.h"
#include "number_check.h"
#include "output_bag.h"
#include "simulated_bag.h"
#include "subcommands.h"

#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>
#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

namespace ppc {
namespace {

constexpr int kPieceGap = 2;  // [pixels]

struct Options {
  std::string scene = "office", sensor = "utm_30lx", motion = "nodding", axis = "pitch";
  double noise = 1.0;
  bool realistic = false, exact = false;
  std::uint64_t seed = 1;
  int lines = 300, sweeps = 1;
  double amplitude_deg = 60.0;
  std::vector<double> lever_arm{0.0, 0.0, 0.0}, mount_rpy{0.0, 0.0, 0.0};
  std::vector<std::string> errors;
  std::string bag, pcd, truth, truth_planes;
  bool pieces = false;
};

sim::ErrorModel errorModel(const Options& o) {
  sim::ErrorModel errors = o.exact       ? sim::ErrorModel::none()
                           : o.realistic ? sim::ErrorModel::realistic(o.noise)
                                         : sim::ErrorModel::dataSheet(o.noise);
  for (const std::string& text : o.errors) {
    const std::size_t equals = text.find('=');
    double value = 0.0;
    if (equals == std::string::npos || !CLI::detail::lexical_cast(text.substr(equals + 1), value)) {
      throw std::invalid_argument("--error is '" + text + "', allowed: NAME=NUMBER");
    }
    sim::setErrorField(errors, text.substr(0, equals), value);
  }
  return errors;
}

sim::ScannerOptions scannerOptions(const Options& o) {
  sim::ScannerOptions s;
  s.sensor = sim::makeSensor(o.sensor);
  s.motion.kind = sim::motionFromName(o.motion);
  s.motion.axis = sim::axisFromName(o.axis);
  s.motion.amplitude = o.amplitude_deg * M_PI / 180.0;
  s.motion.lines_per_pass = o.lines;
  s.mount = sim::mountFrom(Eigen::Vector3d(o.lever_arm.data()), Eigen::Vector3d(o.mount_rpy.data()));
  s.errors = errorModel(o);
  return s;
}

void writeCloud(const RangeImage& image, const std::string& path) {
  const BeamGrid grid = toBeamGrid(image);
  pcl::PointCloud<pcl::PointXYZ> cloud(static_cast<std::uint32_t>(grid.cols), static_cast<std::uint32_t>(grid.rows));
  for (int i = 0; i < grid.size(); ++i) cloud[i].getVector3fMap() = grid.point(i);
  cloud.is_dense = false;
  writeAtomically(path, [&](const std::string& file) {
    try {
      const Quiet quiet;
      pcl::io::savePCDFileBinary(file, cloud);
    } catch (const pcl::IOException&) {  // says neither what nor why
      throw std::runtime_error(path + ": cannot be written");
    }
  });
}

void writeLabels(const LabelImage& labels, const std::string& path) {
  cv::Mat_<std::uint16_t> picture(labels.rows, labels.cols);
  std::copy(labels.labels.begin(), labels.labels.end(), picture.begin());
  writeImage(path, picture);
}

// The ideal plane of every label, by the scene's ids of the same pixels.
std::string planesJson(const sim::Scene& scene, const LabelImage& ids, const LabelImage& labels) {
  std::map<std::int32_t, std::int32_t> id_of;
  for (std::size_t i = 0; i < labels.labels.size(); ++i) {
    if (labels.labels[i] > 0) id_of[labels.labels[i]] = ids.labels[i];
  }
  nlohmann::ordered_json planes = nlohmann::ordered_json::array();
  for (const auto& [label, id] : id_of) {
    const Plane plane = scene.planeInBase(id);
    planes.push_back({{"id", label}, {"normal", {plane.normal.x(), plane.normal.y(), plane.normal.z()}}, {"d", plane.d}});
  }
  return nlohmann::ordered_json{{"planes", planes}}.dump(1) + "\n";
}

void run(const Options& o) {
  if (o.bag.empty() && o.pcd.empty() && o.truth.empty() && o.truth_planes.empty()) {
    throw std::invalid_argument("nothing to write: give --bag, --pcd, --truth or --truth-planes");
  }
  const std::vector<std::string> outputs = {o.bag, o.pcd, o.truth, o.truth_planes};
  requireDistinct({}, outputs);
  for (const std::string& path : outputs) requireWritable(path);
  const sim::Scanner scanner(sim::makeScene(o.scene, o.seed), scannerOptions(o), o.seed);
  if (!o.bag.empty()) {
    writeBag(o.bag, [&](rosbag::Bag& bag) { writeSimulatedBag(scanner, o.sweeps, bag); });
  }
  if (o.pcd.empty() && o.truth.empty() && o.truth_planes.empty()) return;
  const std::vector<std::int32_t> coplanar = o.pieces ? scanner.scene().coplanarIds() : std::vector<std::int32_t>();
  for (int i = 0; i < o.sweeps; ++i) {
    sim::Sweep sweep = scanner.sweep(i);
    const LabelImage ids = sweep.labels;
    if (o.pieces) {
      for (std::int32_t& label : sweep.labels.labels) label = coplanar[label];
      splitComponents(kPieceGap, kPieceGap, sweep.labels);
    }
    if (!o.pcd.empty()) writeCloud(sweep.image, numbered(o.pcd, i, o.sweeps > 1));
    if (!o.truth.empty()) writeLabels(sweep.labels, numbered(o.truth, i, o.sweeps > 1));
    if (!o.truth_planes.empty()) {
      writeText(numbered(o.truth_planes, i, o.sweeps > 1), planesJson(scanner.scene(), ids, sweep.labels));
    }
  }
}

}  // namespace

void addSimulate(CLI::App& app) {
  auto o = std::make_shared<Options>();
  CLI::App* sub = app.add_subcommand("simulate", "Scan a simulated scene: bag, organised PCD, ground-truth labels");
  sub->add_option("--scene", o->scene, "Scene")->check(CLI::IsMember(sim::sceneNames()))->capture_default_str();
  sub->add_option("--sensor", o->sensor, "Laser")->check(CLI::IsMember(sim::sensorNames()))->capture_default_str();
  sub->add_option("--noise", o->noise, "Factor on the data sheet's range noise")
      ->check(numberIn(0.0, 1000.0))
      ->capture_default_str();
  auto* realistic = sub->add_flag("--realistic", o->realistic,
                                  "Add correlated noise, 1 cm grid, bias, bowed walls, mount and tilt errors");
  sub->add_flag("--exact", o->exact, "No error of any kind")->excludes(realistic);
  sub->add_option("--error", o->errors,
                  "Change one source of error, NAME=VALUE (metres, radians, shares; switches 0 or 1); can be repeated");
  sub->add_option("--seed", o->seed, "Seed of scene and errors")->check(wholeUnsigned())->capture_default_str();
  sub->add_option("--lines", o->lines, "Lines a sweep")->check(CLI::Range(1, 100000))->capture_default_str();
  sub->add_option("--sweeps,--passes", o->sweeps, "Sweeps")->check(CLI::Range(1, 100000))->capture_default_str();
  sub->add_option("--motion", o->motion, "Motion")->check(CLI::IsMember({"nodding", "spinning"}))->capture_default_str();
  sub->add_option("--axis", o->axis, "Axis of the motor")
      ->check(CLI::IsMember({"roll", "pitch", "yaw"}))
      ->capture_default_str();
  sub->add_option("--amplitude", o->amplitude_deg, "Nodding: from the middle to a turning point [deg]")
      ->check(numberIn(0.0, 180.0))
      ->capture_default_str();
  sub->add_option("--lever-arm", o->lever_arm, "Laser in the tilting frame: x y z [m]")
      ->expected(3)
      ->check(numberIn(-1000.0, 1000.0))
      ->capture_default_str();
  sub->add_option("--mount-rpy", o->mount_rpy, "Rotation of the laser in the tilting frame: roll pitch yaw [rad]")
      ->expected(3)
      ->check(numberIn(-6.3, 6.3))
      ->capture_default_str();
  sub->add_option("--bag", o->bag, "Bag to write: /scan, /joint_states (tilt_joint), /tf (tilt_base -> laser)");
  sub->add_option("--pcd", o->pcd, "Organised cloud to write (x y z, NaN = invalid); numbered if there are several sweeps");
  sub->add_option("--truth", o->truth, "Ground-truth labels to write (16-bit PNG, 0 = no plane); numbered likewise");
  sub->add_option("--truth-planes", o->truth_planes, "Ideal plane of each label to write (JSON); numbered likewise");
  sub->add_flag(
      "--truth-pieces", o->pieces,
      "Label each piece of a plane that is connected in the image (gaps of 2 bridged) apart; coplanar faces are one plane");
  sub->callback([o] { run(*o); });
}

}  // namespace ppc
