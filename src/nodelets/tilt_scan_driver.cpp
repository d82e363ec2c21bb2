// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/driver_diagnostics.h"
#include "patch_plane_clustering/ros/driver_options.h"
#include "patch_plane_clustering/ros/joint_sample.h"
#include "patch_plane_clustering/ros/laser_poses.h"
#include "patch_plane_clustering/ros/publisher_watch.h"
#include "patch_plane_clustering/ros/range_image_conversions.h"
#include "patch_plane_clustering/ros/sequence_watch.h"

#include <diagnostic_updater/diagnostic_updater.h>
#include <nodelet/nodelet.h>
#include <sensor_msgs/JointState.h>
#include <std_srvs/Trigger.h>
#include <tf2_ros/transform_listener.h>
#include <algorithm>
#include <boost/algorithm/string/join.hpp>
#include <limits>
#include <memory>
#include <pluginlib/class_list_macros.hpp>

namespace ppc {
namespace {

constexpr std::size_t kLongestFault = 300;  // of what is cited: a frame_id may have any length

}  // namespace

/// Line scans and the tilt motor's angle in, organised range images out. All callbacks run in the nodelet's single-threaded
/// queue; only tf has a thread of its own.
class TiltScanDriver : public nodelet::Nodelet {
 public:
  ~TiltScanDriver() override {
    // Each of these waits for its callback in flight.
    scan_sub_.shutdown();
    joint_sub_.shutdown();
    close_service_.shutdown();
    housekeeping_.stop();
    diagnostics_timer_.stop();
  }

 private:
  void onInit() override {
    ros::NodeHandle nh = getNodeHandle();
    ParameterReader reader(getPrivateNodeHandle());
    options_ = readDriverOptions(reader);
    reader.expect("diagnostic_period");
    for (const std::string& sentence : reader.unknown()) {
      NODELET_WARN_STREAM(sentence);
      unknown_ += (unknown_.empty() ? "" : "; ") + sentence;
    }
    for (const std::string& sentence : reader.errors()) NODELET_ERROR_STREAM(sentence);

    last_report_ = last_scan_ = last_row_ = last_joint_ = last_sweep_ = ros::SteadyTime::now();
    updater_ = std::make_unique<diagnostic_updater::Updater>(nh, getPrivateNodeHandle(), getName());
    updater_->setHardwareID("none");
    updater_->add("tilt scan driver", this, &TiltScanDriver::diagnose);
    // Steady time, and forced: the driver reports while simulated time stands, and when the system's clock is set.
    diagnostics_timer_ = nh.createSteadyTimer(ros::WallDuration(1.0), [this](const auto&) { updater_->force_update(); });
    if (!reader.errors().empty()) {
      refusal_ = "not running: " + reader.errors().front();
      NODELET_ERROR("The driver does not run with bad parameters");
      return;
    }

    if (LaserPoses::needsTf(options_)) {
      tf_buffer_ = std::make_unique<tf2_ros::Buffer>();
      tf_listener_ = std::make_unique<tf2_ros::TransformListener>(*tf_buffer_, nh);
    }
    poses_ = std::make_unique<LaserPoses>(options_, tf_buffer_.get());
    if (!options_.laser_frame.empty()) poses_->setLaserFrame(options_.laser_frame);
    assembler_ = std::make_unique<SweepAssembler>(options_.sweep, *poses_, [this](Sweep&& sweep) { publish(sweep); });

    image_pub_ = nh.advertise<RangeImageMsg>("range_image", 2);
    if (options_.foresee) {
      foreseen_pub_ = nh.advertise<RangeImageMsg>("range_image/foreseen", 2);
      assembler_->foresee([this](Sweep&& sweep) { publishForeseen(sweep); });
    }
    points_pub_ = nh.advertise<sensor_msgs::PointCloud2>("points", 2);
    radial_pub_ = nh.advertise<sensor_msgs::Image>("range_image/image", 2);
    close_service_ = nh.advertiseService("close_sweep", &TiltScanDriver::closeSweep, this);
    housekeeping_ = nh.createSteadyTimer(ros::WallDuration(0.05), [this](const auto&) { keepHouse(); });
    const auto no_delay = ros::TransportHints().tcpNoDelay();
    if (poses_->joint()) joint_sub_ = nh.subscribe("joint_states", 500, &TiltScanDriver::onJoint, this, no_delay);
    scan_sub_ = nh.subscribe("scan", 200, &TiltScanDriver::onScan, this, no_delay);
  }

  void onScan(const ros::MessageEvent<const sensor_msgs::LaserScan>& event) {
    const sensor_msgs::LaserScanConstPtr& scan = event.getConstMessage();
    ++health_.scans;
    sequence_.see(event.getPublisherName(), scan->header.seq);
    last_scan_ = ros::SteadyTime::now();
    std::string fault = otherPublisher(scan_publishers_, event, scan_sub_);
    if (fault.empty()) fault = faultOf(*scan, poses_->laserFrame());
    if (fault.empty()) {
      if (poses_->laserFrame().empty()) poses_->setLaserFrame(frameName(scan->header.frame_id));
      if (first_scan_.isZero()) first_scan_ = last_scan_;
      const std::uint64_t layout_changes = assembler_->accounts().layout_changes;
      fault = assembler_->push(toScanLine(*scan, options_.time_offset));
      if (assembler_->accounts().layout_changes > layout_changes) {
        NODELET_WARN_THROTTLE(5.0, "The scan's layout changed: a new sweep begins");
      }
    } else {
      assembler_->countDropped(DropCause::kBadScan);
    }
    if (fault.empty()) return;
    fault.resize(std::min(fault.size(), kLongestFault));
    health_.last_fault = "bad scan: " + fault;
    NODELET_WARN_STREAM_THROTTLE(5.0, "Scan skipped: " << fault);
  }

  void onJoint(const ros::MessageEvent<const sensor_msgs::JointState>& event) {
    JointSample sample = readJointSample(*event.getMessage(), options_.joint_name);
    if (!sample.present) {  // another joint's
      health_.other_joints = boost::algorithm::join(event.getMessage()->name, ", ").substr(0, 200);
      return;
    }
    ++health_.joint_samples;
    last_joint_ = ros::SteadyTime::now();
    const std::string other = otherPublisher(joint_publishers_, event, joint_sub_);
    if (!other.empty()) sample.fault = "joint '" + options_.joint_name + "' is " + other;
    if (!sample.fault.empty()) {
      ++health_.bad_joint_messages;
      health_.last_fault = sample.fault;
      NODELET_WARN_STREAM_THROTTLE(5.0, "Joint message skipped: " << health_.last_fault);
      return;
    }
    poses_->joint()->track().add(sample.stamp, sample.angle);
    placeLines();
  }

  template <typename Event>
  static std::string otherPublisher(PublisherWatch& watch, const Event& event, const ros::Subscriber& subscriber) {
    return watch.faultOf(event.getPublisherName(), ros::SteadyTime::now().toSec(),
                         static_cast<int>(subscriber.getNumPublishers()));
  }

  void placeLines() {
    const bool late = !first_scan_.isZero() && (ros::SteadyTime::now() - first_scan_).toSec() > options_.mount_timeout;
    const std::string settled = poses_->settleMount(late);
    if (!settled.empty()) NODELET_INFO_STREAM("The " << settled);
    assembler_->process();
    if (assembler_->lastPlaced() == last_placed_) return;
    last_placed_ = assembler_->lastPlaced();
    last_row_ = ros::SteadyTime::now();
  }

  void keepHouse() {
    placeLines();
    const bool idle = (ros::SteadyTime::now() - last_row_).toSec() > options_.idle_timeout;
    if (idle && assembler_->openLines() > 0) assembler_->close(SweepEnd::kIdle);
  }

  bool closeSweep(std_srvs::Trigger::Request& /*request*/, std_srvs::Trigger::Response& response) {
    const int open = assembler_->openLines();
    const int rows = assembler_->close(SweepEnd::kRequest);
    response.success = rows > 0;
    response.message = rows > 0   ? "sweep of " + std::to_string(rows) + " lines closed"
                       : open > 0 ? "sweep of " + std::to_string(open) + " lines dropped: too small"
                                  : "no sweep is open";
    return true;
  }

  // No sequence number and no accounts: it is no sweep yet, and may never be one.
  void publishForeseen(const Sweep& sweep) {
    if (foreseen_pub_.getNumSubscribers() == 0) return;
    std_msgs::Header header;
    header.stamp = toTime(sweep.stamp);
    header.frame_id = options_.base_frame;
    foreseen_pub_.publish(boost::make_shared<RangeImageMsg>(toMessage(sweep.image, header)));
  }

  void publish(const Sweep& sweep) {
    last_sweep_ = ros::SteadyTime::now();
    if (assembler_->accounts().sweeps == 1) {
      NODELET_INFO("The first sweep has %d lines of %d beams", sweep.image.rows, sweep.image.cols);
    }
    std_msgs::Header header;
    header.seq = static_cast<std::uint32_t>(assembler_->accounts().sweeps);  // tells nodelets of images they have missed
    header.stamp = toTime(sweep.stamp);
    header.frame_id = options_.base_frame;
    NODELET_DEBUG("Sweep of %d lines, ended by %s", sweep.image.rows, sweepEndName(sweep.end));
    if (image_pub_.getNumSubscribers() > 0) {
      image_pub_.publish(boost::make_shared<RangeImageMsg>(toMessage(sweep, header)));
    }
    if (points_pub_.getNumSubscribers() > 0) {
      points_pub_.publish(boost::make_shared<sensor_msgs::PointCloud2>(toPointCloud(sweep.image, header)));
    }
    if (radial_pub_.getNumSubscribers() > 0) {
      radial_pub_.publish(boost::make_shared<sensor_msgs::Image>(toRadialImage(sweep.image, header)));
    }
  }

  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
    if (!assembler_) return status.summary(diagnostic_msgs::DiagnosticStatus::ERROR, refusal_);
    const ros::SteadyTime now = ros::SteadyTime::now();
    health_.scan_topic = scan_sub_.getTopic();
    health_.joint_topic = joint_sub_.getTopic();
    health_.joint_name = options_.joint_name;
    health_.scan_age = (now - last_scan_).toSec();
    health_.joint_age = (now - last_joint_).toSec();
    health_.sweep_age = (now - last_sweep_).toSec();
    health_.lost = sequence_.lost();
    health_.row_age = (now - last_row_).toSec();
    health_.sweep_timeout = options_.sweep_timeout;
    health_.waits_for = whatLinesWaitFor();
    health_.standing = assembler_->standing();
    health_.lines = assembler_->accounts();
    if (const TiltTrack* tilts = poses_->tilts()) health_.track = tilts->counts();
    const TiltPoseSource* joint = poses_->joint();
    if (joint && joint->mount()) health_.mount = describeMount(*joint->mount());
    if (!unknown_.empty()) status.add("Unknown parameters", unknown_);
    diagnostics_.write(health_, (now - last_report_).toSec(), status);
    const std::string news = diagnostics_.news(status);
    if (!news.empty()) NODELET_WARN_STREAM(news);
    last_report_ = now;
    health_.last_fault.clear();
  }

  std::string whatLinesWaitFor() const {
    switch (assembler_->waitsFor()) {
      case PoseStatus::kWait:
        return "samples of joint '" + options_.joint_name + "'";
      case PoseStatus::kWaitTransform:
        return "tf " + poses_->transforms();
      default:
        return {};
    }
  }

  DriverOptions options_;
  std::string refusal_;  // why the driver does not run
  std::string unknown_;  // parameters that nobody knows

  // Each uses those above it.
  std::unique_ptr<tf2_ros::Buffer> tf_buffer_;
  std::unique_ptr<tf2_ros::TransformListener> tf_listener_;
  std::unique_ptr<LaserPoses> poses_;
  std::unique_ptr<SweepAssembler> assembler_;

  double last_placed_ = -std::numeric_limits<double>::infinity();  // stamp of the newest row [s]
  SequenceWatch sequence_;                                         // of the scans
  PublisherWatch scan_publishers_, joint_publishers_;
  DriverHealth health_;
  DriverDiagnostics diagnostics_;
  std::unique_ptr<diagnostic_updater::Updater> updater_;
  ros::SteadyTime first_scan_, last_scan_, last_row_, last_joint_, last_sweep_, last_report_;

  ros::Publisher image_pub_, foreseen_pub_, points_pub_, radial_pub_;
  ros::ServiceServer close_service_;
  ros::Subscriber scan_sub_, joint_sub_;
  ros::SteadyTimer housekeeping_, diagnostics_timer_;
};

}  // namespace ppc

PLUGINLIB_EXPORT_CLASS(ppc::TiltScanDriver, nodelet::Nodelet)
