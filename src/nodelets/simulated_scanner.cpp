// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/simulated_messages.h"
#include "patch_plane_clustering/ros/simulated_scanner_parameters.h"
#include "patch_plane_clustering/sim/random.h"
#include "patch_plane_clustering/sim/scan_stream.h"

#include <nodelet/nodelet.h>
#include <rosgraph_msgs/Clock.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/image_encodings.h>
#include <algorithm>
#include <boost/algorithm/string/join.hpp>
#include <deque>
#include <numeric>
#include <pluginlib/class_list_macros.hpp>

namespace ppc {

/// @brief Publishes what a tilting laser would, from a simulated scene.
///
/// Topics: `scan` (sensor_msgs/LaserScan, at each line's last beam, stamped with its first), `joint_states`
/// (sensor_msgs/JointState), `ground_truth/labels` (sensor_msgs/Image 32SC1, one a pass, rows in ascending tilt, 0 = no
/// plane, stamped with the last line), `/tf` if publish_tf, `/clock` if publish_clock. Without publish_clock stamps follow
/// the node's clock from the start. Private parameters: SimulatedScannerParameters. A wrong one keeps the nodelet from
/// loading, with a message that names it.
class SimulatedScanner : public nodelet::Nodelet {
 public:
  ~SimulatedScanner() override { timer_.stop(); }  // waits for a tick in flight, which uses all the rest

 private:
  void onInit() override {
    try {
      readParameters();
    } catch (const std::exception& e) {
      NODELET_FATAL("simulated scanner: %s", e.what());
      throw;
    }
    faults_ = sim::Random(parameters_.seed, kFaultStream);
    ros::NodeHandle& nh = getNodeHandle();
    scan_pub_ = nh.advertise<sensor_msgs::LaserScan>("scan", 100);
    joint_pub_ = nh.advertise<sensor_msgs::JointState>("joint_states", 1000);
    truth_pub_ = nh.advertise<sensor_msgs::Image>("ground_truth/labels", 2);
    if (parameters_.publish_tf) tf_pub_ = nh.advertise<tf2_msgs::TFMessage>("/tf", 1000);
    if (parameters_.publish_clock) clock_pub_ = nh.advertise<rosgraph_msgs::Clock>("/clock", 1000);
    start_ = parameters_.publish_clock ? ros::Time(kClockStart) : ros::Time::now();
    last_tick_ = ros::SteadyTime::now();
    const double period = 0.5 / (parameters_.scanner.joint_rate * parameters_.real_time_factor);
    timer_ = nh.createSteadyTimer(ros::WallDuration(std::clamp(period, 0.001, 0.01)), &SimulatedScanner::tick, this);
  }

  void readParameters() {
    ParameterReader reader(getPrivateNodeHandle());
    parameters_ = readSimulatedScannerParameters(reader);
    if (!reader.errors().empty()) throw std::invalid_argument(boost::algorithm::join(reader.errors(), "; "));
    for (const std::string& unknown : reader.unknown()) NODELET_WARN("simulated scanner: %s", unknown.c_str());
    scanner_ = std::make_unique<sim::Scanner>(sim::makeScene(parameters_.scene, parameters_.seed), parameters_.scanner,
                                              parameters_.seed);
    stream_ = std::make_unique<sim::ScanStream>(*scanner_, parameters_.replay_passes);
  }

  void tick(const ros::SteadyTimerEvent& /*event*/) {
    const ros::SteadyTime now = ros::SteadyTime::now();
    time_ += std::clamp((now - last_tick_).toSec(), 0.0, kLongestTick) * parameters_.real_time_factor;
    last_tick_ = now;
    const ros::SteadyTime give_up = now + ros::WallDuration(kLongestTick);
    while (stream_->nextTime() <= time_) {
      publish(stream_->next());
      // Rendering may be slower than asked for: simulated time then waits rather than let a backlog grow.
      if (ros::SteadyTime::now() > give_up) time_ = std::min(time_, stream_->nextTime());
    }
  }

  void publish(const sim::ScanEvent& event) {
    if (parameters_.publish_clock) {
      rosgraph_msgs::Clock clock;
      clock.clock = start_ + ros::Duration(event.time);
      clock_pub_.publish(clock);
    }
    if (event.is_line) {
      if (!faults_.chance(parameters_.scan_drop_rate)) {
        scan_pub_.publish(
            boost::make_shared<sensor_msgs::LaserScan>(toLaserScan(*scanner_, event.line, start_, parameters_.names)));
      }
      collectTruth(event.line);
    } else if (!faults_.chance(parameters_.joint_drop_rate)) {
      late_.push_back(event.joint);
    }
    while (!late_.empty() && late_.front().stamp + parameters_.joint_delay <= event.time) {
      joint_pub_.publish(toJointState(late_.front(), start_, parameters_.names));
      if (parameters_.publish_tf) tf_pub_.publish(toTransforms(*scanner_, late_.front(), start_, parameters_.names));
      late_.pop_front();
    }
  }

  void collectTruth(const sim::ScanLine& line) {
    pass_.push_back({line.true_tilts[line.true_tilts.size() / 2], line.labels});
    const int lines = parameters_.scanner.motion.lines_per_pass;
    if (static_cast<int>(pass_.size()) < lines) return;
    std::stable_sort(pass_.begin(), pass_.end(), [](const TruthRow& a, const TruthRow& b) { return a.tilt < b.tilt; });
    auto image = boost::make_shared<sensor_msgs::Image>();
    image->header.stamp = start_ + ros::Duration(line.stamp);
    image->header.frame_id = parameters_.names.base_frame;
    image->height = static_cast<std::uint32_t>(lines);
    image->width = static_cast<std::uint32_t>(line.labels.size());
    image->encoding = sensor_msgs::image_encodings::TYPE_32SC1;
    image->step = image->width * sizeof(std::int32_t);
    for (const TruthRow& row : pass_) {
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(row.labels.data());
      image->data.insert(image->data.end(), bytes, bytes + image->step);
    }
    truth_pub_.publish(image);
    pass_.clear();
  }

  struct TruthRow {
    double tilt;
    std::vector<std::int32_t> labels;
  };
  static constexpr double kClockStart = 1000.0;  // [s]
  static constexpr double kLongestTick = 0.1;    // [s]
  static constexpr std::uint64_t kFaultStream = 1ULL << 33;

  SimulatedScannerParameters parameters_;
  std::unique_ptr<sim::Scanner> scanner_;
  std::unique_ptr<sim::ScanStream> stream_;
  sim::Random faults_{0};
  ros::Publisher scan_pub_, joint_pub_, truth_pub_, tf_pub_, clock_pub_;
  ros::SteadyTimer timer_;
  ros::Time start_;
  ros::SteadyTime last_tick_;
  double time_ = 0.0;  // simulated, since the start [s]
  std::deque<sim::JointSample> late_;
  std::vector<TruthRow> pass_;
};

}  // namespace ppc

PLUGINLIB_EXPORT_CLASS(ppc::SimulatedScanner, nodelet::Nodelet)
