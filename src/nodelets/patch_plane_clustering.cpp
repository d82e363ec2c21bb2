// SPDX-License-Identifier: BSD-3-Clause
#include "message_segmenter.h"

#include "patch_plane_clustering/ros/image_accounts.h"
#include "patch_plane_clustering/ros/markers.h"
#include "patch_plane_clustering/ros/newest_worker.h"
#include "patch_plane_clustering/ros/parameters.h"
#include "patch_plane_clustering/ros/processor_time.h"
#include "patch_plane_clustering/ros/reconfiguration.h"
#include "patch_plane_clustering/ros/segmentation_conversions.h"

#include <diagnostic_updater/diagnostic_updater.h>
#include <dynamic_reconfigure/server.h>
#include <nodelet/nodelet.h>
#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <stdexcept>
#include <string>
#include <utility>

namespace ppc {
namespace {

using Clock = Arrival::Clock;

double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace

/// @brief Turns range images or organised clouds into planar polygons. Callbacks only hand messages over; a worker thread
/// segments the newest. A message keeps the configuration that it started with.
class PatchPlaneClustering : public nodelet::Nodelet {
 public:
  ~PatchPlaneClustering() override {
    foreseen_subscriber_.shutdown();
    image_subscriber_.shutdown();  // returns when no callback runs any more
    cloud_subscriber_.shutdown();
    diagnostics_timer_.stop();
    server_.reset();
    worker_.reset();
  }

 private:
  using Server = dynamic_reconfigure::Server<PatchPlaneClusteringConfig>;

  void onInit() override {
    ros::NodeHandle& nh = getNodeHandle();
    ros::NodeHandle& private_nh = getPrivateNodeHandle();
    readParameters(private_nh);

    polygons_publisher_ = nh.advertise<PlanarPolygonArray>("polygons", 2);
    markers_publisher_ = nh.advertise<visualization_msgs::MarkerArray>("polygons/markers", 2);
    labels_publisher_ = nh.advertise<sensor_msgs::Image>("labels", 2);
    points_publisher_ = nh.advertise<sensor_msgs::PointCloud2>("segmented_points", 2);
    statistics_publisher_ = nh.advertise<SegmentationStatistics>("statistics", 2);
    worker_ = std::make_unique<NewestWorker<Arrival>>([this](const Arrival& arrival) { process(arrival); });

    server_ = std::make_unique<Server>(server_mutex_, private_nh);
    server_->updateConfig(toReconfigurable(*config()));  // it has clamped bad parameters; these are as reported
    server_->setCallback([this](PatchPlaneClusteringConfig& update, std::uint32_t) { reconfigure(update); });

    updater_ = std::make_unique<diagnostic_updater::Updater>(nh, private_nh, getName());
    updater_->setHardwareID("none");
    updater_->add("plane clustering", this, &PatchPlaneClustering::diagnose);
    // Steady time, and forced: it reports while simulated time stands, and when the system's clock is set.
    diagnostics_timer_ = nh.createSteadyTimer(ros::WallDuration(1.0), [this](const auto&) { updater_->force_update(); });

    image_subscriber_ = nh.subscribe("range_image", 2, &PatchPlaneClustering::onImage, this);
    foreseen_subscriber_ = nh.subscribe("range_image/foreseen", 1, &PatchPlaneClustering::onForeseen, this);
    cloud_subscriber_ = nh.subscribe("points_in", 2, &PatchPlaneClustering::onCloud, this);
    if (cloud_subscriber_.getTopic() != points_publisher_.getTopic()) return;
    cloud_subscriber_.shutdown();  // or it would segment its own clouds without end
    misled_ = "points_in and segmented_points are both " + points_publisher_.getTopic() + "; clouds are not listened to";
    NODELET_ERROR_STREAM(misled_);
  }

  void readParameters(const ros::NodeHandle& private_nh) {
    ParameterReader reader(private_nh);
    config_ = std::make_shared<const Config>(readConfig(reader));
    method_name_ = reader.getChoice("method", "ppc", segmenterNames());
    segmenter_ = std::make_unique<MessageSegmenter>(method_name_);
    reader.expect("diagnostic_period");
    for (const std::string& error : reader.errors()) NODELET_ERROR("%s; the default is used", error.c_str());
    for (const std::string& unknown : reader.unknown()) {
      NODELET_WARN("%s", unknown.c_str());
      unknown_ += (unknown_.empty() ? "" : "; ") + unknown;
    }
  }

  void onImage(const ros::MessageEvent<const RangeImageMsg>& event) {
    receive({event.getConstMessage(), nullptr}, event.getPublisherName());
  }

  void onCloud(const ros::MessageEvent<const sensor_msgs::PointCloud2>& event) {
    receive({nullptr, event.getConstMessage()}, event.getPublisherName());
  }

  // Only in time that nobody else needs.
  void onForeseen(const RangeImageMsg::ConstPtr& image) { worker_->pushIfIdle({image, nullptr, true}); }

  void receive(Arrival arrival, const std::string& publisher) {
    accounts_.receive(publisher, arrival.header().seq);
    const std::optional<Arrival> overtaken = worker_->push(std::move(arrival));
    if (!overtaken || overtaken->foreseen) return;  // nothing is lost with what was foreseen
    accounts_.overtake();
    NODELET_WARN_THROTTLE(10.0, "images arrive faster than they can be segmented; the newest wins (%u overtaken so far)",
                          accounts_.counts().overtaken);
  }

  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
    const auto now = Clock::now();
    if (!unknown_.empty()) status.add("Unknown parameters", unknown_);
    accounts_.write(std::chrono::duration<double>(now - last_report_).count(), status);
    last_report_ = now;
    if (!misled_.empty()) status.mergeSummary(diagnostic_msgs::DiagnosticStatus::ERROR, misled_);
  }

  void reconfigure(PatchPlaneClusteringConfig& update) {
    try {
      const auto next = std::make_shared<const Config>(fromReconfigurable(update, *config()));
      const std::lock_guard<std::mutex> lock(config_mutex_);
      config_ = next;
    } catch (const std::invalid_argument& error) {
      NODELET_ERROR("update refused: %s", error.what());
      update = toReconfigurable(*config());
    }
  }

  std::shared_ptr<const Config> config() const {
    const std::lock_guard<std::mutex> lock(config_mutex_);
    return config_;
  }

  void process(const Arrival& arrival) {
    try {
      segmenter_->segment(arrival, config());
      if (!arrival.foreseen) publish(arrival);
    } catch (const std::exception& error) {
      if (!arrival.foreseen) skip(arrival, error.what());  // else it will come again
    }
  }

  /// Only the polygons are always made; the rest if somebody listens.
  void publish(const Arrival& arrival) {
    const double processor_start = threadProcessorMilliseconds();
    const Segmentation& segmentation = segmenter_->segmentation();
    const std_msgs::Header& header = arrival.header();
    publishAs(polygons_publisher_, toPolygonArray(segmentation, header));
    const double total = millisecondsSince(arrival.time);
    const double processor = segmenter_->processorMilliseconds() + threadProcessorMilliseconds() - processor_start;
    accounts_.segment(total, segmenter_->wasForeseen());
    if (statistics_publisher_.getNumSubscribers() > 0) {
      SegmentationStatistics statistics = toStatistics(segmentation, header);
      statistics.method = method_name_;
      statistics.total_milliseconds = static_cast<float>(total);
      statistics.processor_milliseconds = static_cast<float>(processor);
      const ImageCounts counts = accounts_.counts();
      statistics.images_received = counts.received;
      statistics.images_skipped = counts.skipped();
      statistics.images_refused = counts.refused;
      statistics.images_overtaken = counts.overtaken;
      statistics.images_lost = counts.lost;
      if (arrival.image) statistics.lines = arrival.image->lines;
      publishAs(statistics_publisher_, std::move(statistics));
    }
    if (labels_publisher_.getNumSubscribers() > 0) publishAs(labels_publisher_, toLabelImage(segmentation.labels, header));
    if (markers_publisher_.getNumSubscribers() > 0) publishAs(markers_publisher_, toMarkers(segmentation, header));
    if (points_publisher_.getNumSubscribers() > 0) {
      publishAs(points_publisher_, toSegmentedCloud(segmenter_->grid(), segmentation.labels, header));
    }
  }

  /// As a shared pointer, which nodelets of the same manager receive without a copy.
  template <typename Message>
  static void publishAs(const ros::Publisher& publisher, Message message) {
    publisher.publish(boost::make_shared<Message>(std::move(message)));
  }

  void skip(const Arrival& arrival, const std::string& why) {
    accounts_.refuse(why);
    const auto now = Clock::now();  // not ROS time, which stands still when there is no /clock
    if (reported_ && now - *reported_ < std::chrono::seconds(2)) return;
    reported_ = now;
    NODELET_ERROR("%s of frame '%s' skipped: %s (%u refused so far)", arrival.image ? "range image" : "cloud",
                  arrival.header().frame_id.c_str(), why.c_str(), accounts_.counts().refused);
  }

  std::string method_name_;
  std::string unknown_;                          // parameters that nobody knows
  std::string misled_;                           // why clouds are not listened to
  std::unique_ptr<MessageSegmenter> segmenter_;  // of the worker's thread
  mutable std::mutex config_mutex_;
  std::shared_ptr<const Config> config_;
  boost::recursive_mutex server_mutex_;
  std::unique_ptr<Server> server_;
  ImageAccounts accounts_;
  std::unique_ptr<diagnostic_updater::Updater> updater_;
  Clock::time_point last_report_ = Clock::now();
  ros::SteadyTimer diagnostics_timer_;
  std::optional<Clock::time_point> reported_;  // of the worker's thread
  ros::Publisher polygons_publisher_, markers_publisher_, labels_publisher_, points_publisher_, statistics_publisher_;
  ros::Subscriber image_subscriber_, foreseen_subscriber_, cloud_subscriber_;
  std::unique_ptr<NewestWorker<Arrival>> worker_;
};

}  // namespace ppc

PLUGINLIB_EXPORT_CLASS(ppc::PatchPlaneClustering, nodelet::Nodelet)
