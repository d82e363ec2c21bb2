// SPDX-License-Identifier: BSD-3-Clause
// The nodelet from outside: what is published for what comes in.
#include "patch_plane_clustering/ros/messages.h"
#include "ros_test_main.h"
#include "test_scenes.h"
#include "wait_for.h"

#include <dynamic_reconfigure/Reconfigure.h>
#include <gtest/gtest.h>
#include <nodelet/NodeletLoad.h>
#include <nodelet/NodeletUnload.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Log.h>
#include <visualization_msgs/MarkerArray.h>
#include <atomic>
#include <cstdlib>
#include <functional>
#include <limits>
#include <string>
#include <thread>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;  // NOLINT: one scene header for these tests

class PatchPlaneClusteringTest : public testing::Test {
 protected:
  void SetUp() override {
    image_publisher_ = nh_.advertise<RangeImageMsg>("range_image", 10);
    cloud_publisher_ = nh_.advertise<sensor_msgs::PointCloud2>("points_in", 10);
    polygons_subscriber_ =
        nh_.subscribe<PlanarPolygonArray>("polygons", 1000, [this](const auto& m) { polygons_.push_back(*m); });
    statistics_subscriber_ =
        nh_.subscribe<SegmentationStatistics>("statistics", 1000, [this](const auto& m) { statistics_.push_back(*m); });
    log_subscriber_ = nh_.subscribe<rosgraph_msgs::Log>("/rosout", 1000, [this](const auto& m) { log_ += m->msg + "\n"; });
    ASSERT_TRUE(waitFor([this] { return connected() && log_subscriber_.getNumPublishers() > 0; }, 30.0));
    statistics_.clear();
    polygons_.clear();
  }

  bool connected() const {
    return image_publisher_.getNumSubscribers() > 0 && cloud_publisher_.getNumSubscribers() > 0 &&
           polygons_subscriber_.getNumPublishers() > 0 && statistics_subscriber_.getNumPublishers() > 0;
  }

  /// The result for a message of this stamp; publishes the message again if it came before the nodelet was there.
  template <typename Message>
  PlanarPolygonArray answerTo(const ros::Publisher& publisher, const Message& message) {
    const auto answered = [&] {
      return !polygons_.empty() && polygons_.back().header.stamp == message.header.stamp && !statistics_.empty() &&
             statistics_.back().header.stamp == message.header.stamp;
    };
    for (int attempt = 0; attempt < 3; ++attempt) {
      publisher.publish(message);
      if (waitFor(answered, 10.0)) return polygons_.back();
    }
    ADD_FAILURE() << "no polygons came";
    return {};
  }

  bool logged(const std::string& part) {
    return waitFor([&] { return log_.find(part) != std::string::npos; });
  }

  ros::NodeHandle nh_;
  ros::Publisher image_publisher_, cloud_publisher_;
  ros::Subscriber polygons_subscriber_, statistics_subscriber_, log_subscriber_;
  std::vector<PlanarPolygonArray> polygons_;
  std::vector<SegmentationStatistics> statistics_;
  std::string log_;
};

TEST_F(PatchPlaneClusteringTest, RangeImageGivesThePlateWithItsWindow) {
  const PlanarPolygonArray array = answerTo(image_publisher_, scanMessage({plate()}, 100.0));
  EXPECT_EQ(array.header.frame_id, "tilt_base");
  ASSERT_EQ(array.polygons.size(), 1U);
  const PlanarPolygonMsg& polygon = array.polygons[0];
  EXPECT_EQ(polygon.id, 1);
  EXPECT_NEAR(polygon.plane.coef[0], -1.0, 1e-4);
  EXPECT_NEAR(polygon.plane.coef[3], 2.0, 1e-3);
  EXPECT_NEAR(polygon.area, kPlateArea, 0.02 * kPlateArea);
  ASSERT_EQ(polygon.holes.size(), 1U);
  EXPECT_LT(polygon.outer.points.size(), 30U);
  EXPECT_LT(polygon.rms, 1e-4);
}

TEST_F(PatchPlaneClusteringTest, OrganisedCloudGivesWallAndBox) {
  const PlanarPolygonArray array = answerTo(cloud_publisher_, cameraCloud(110.0));
  EXPECT_EQ(array.header.frame_id, "camera_optical");
  ASSERT_EQ(array.polygons.size(), 2U);
  // z forward: the planes are at z = 2 (the larger region) and z = 1, facing the camera.
  EXPECT_NEAR(array.polygons[0].plane.coef[2], -1.0, 1e-4);
  EXPECT_NEAR(array.polygons[0].plane.coef[3], 2.0, 1e-3);
  EXPECT_NEAR(array.polygons[1].plane.coef[3], 1.0, 1e-3);
  // The box is 48 x 48 pixels of 1/120 m; a pixel at the jump may belong to nothing.
  EXPECT_GE(array.polygons[1].point_count, 46U * 46U);
  EXPECT_LE(array.polygons[1].point_count, 48U * 48U);
  EXPECT_NEAR(array.polygons[1].area, array.polygons[1].point_count / (120.0 * 120.0), 0.02 * 0.16);
  EXPECT_EQ(array.polygons[0].holes.size(), 1U);
}

TEST_F(PatchPlaneClusteringTest, ImageWithoutPlanesGivesAnEmptyArray) {
  const PlanarPolygonArray array = answerTo(image_publisher_, scanMessage({}, 120.0));  // +Inf everywhere
  EXPECT_TRUE(array.polygons.empty());
  EXPECT_EQ(array.header.frame_id, "tilt_base");
  EXPECT_EQ(statistics_.back().valid_points, 0U);
  EXPECT_EQ(statistics_.back().polygons, 0U);
}

TEST_F(PatchPlaneClusteringTest, AllOutputsBelongTogether) {
  visualization_msgs::MarkerArray markers;
  sensor_msgs::Image labels;
  sensor_msgs::PointCloud2 points;
  const auto a = nh_.subscribe<visualization_msgs::MarkerArray>("polygons/markers", 5, [&](const auto& m) { markers = *m; });
  const auto b = nh_.subscribe<sensor_msgs::Image>("labels", 5, [&](const auto& m) { labels = *m; });
  const auto c = nh_.subscribe<sensor_msgs::PointCloud2>("segmented_points", 5, [&](const auto& m) { points = *m; });
  ASSERT_TRUE(waitFor([&] { return a.getNumPublishers() > 0 && b.getNumPublishers() > 0 && c.getNumPublishers() > 0; }));
  const ros::Time stamp(130.0);
  const auto complete = [&] {
    return labels.header.stamp == stamp && points.header.stamp == stamp && !markers.markers.empty() && !polygons_.empty() &&
           !statistics_.empty();
  };
  for (int attempt = 0; attempt < 3 && !complete(); ++attempt) {  // the nodelet learns of subscribers when it may
    image_publisher_.publish(scanMessage({plate()}, stamp.toSec()));
    waitFor(complete, 5.0);
  }
  ASSERT_TRUE(complete());
  EXPECT_EQ(labels.height, 91U);
  EXPECT_EQ(labels.width, 121U);
  std::uint32_t labelled = 0;
  for (std::size_t i = 0; i < labels.data.size(); i += 4) labelled += labels.data[i] == 1;
  EXPECT_EQ(labelled, polygons_.back().polygons.at(0).point_count);
  EXPECT_EQ(labelled, statistics_.back().planar_points);
  EXPECT_EQ(points.height, 91U);
  EXPECT_EQ(points.header.frame_id, "tilt_base");
  ASSERT_EQ(markers.markers.size(), 4U);
  EXPECT_EQ(markers.markers[0].action, visualization_msgs::Marker::DELETEALL);
  EXPECT_EQ(markers.markers[1].header.stamp, stamp);
  EXPECT_EQ(statistics_.back().method, "ppc");
  EXPECT_GT(statistics_.back().processor_milliseconds, 0.0F);
  EXPECT_GT(statistics_.back().total_milliseconds, statistics_.back().processor_milliseconds);
  EXPECT_GE(statistics_.back().stage_names.size(), 3U);
}

TEST_F(PatchPlaneClusteringTest, BadInputIsSkippedCountedAndNamed) {
  answerTo(image_publisher_, scanMessage({plate()}, 140.0));
  const std::uint32_t received = statistics_.back().images_received, skipped = statistics_.back().images_skipped;
  RangeImageMsg good = scanMessage({plate()}, 141.0);
  const std::vector<std::pair<std::string, std::function<void(RangeImageMsg&)>>> spoilers = {
      {"ranges has", [](auto& m) { m.ranges.resize(17); }},
      {"bearings are not finite", [](auto& m) { m.bearing_increment = std::numeric_limits<float>::quiet_NaN(); }},
      {"is empty", [](auto& m) { m = RangeImageMsg(); }},
      {"line_poses has", [](auto& m) { m.poses_per_row = 3; }},
      {"no unit quaternion", [](auto& m) { m.line_poses[7].orientation.w = std::numeric_limits<double>::quiet_NaN(); }},
      {"is too large", [](auto& m) { m.height = 0xFFFFFFFFU; }},
      {"patch_size = 4 is larger than the image (1 x 121)", [](auto& m) {
         m.height = 1;
         m.ranges.resize(121);
         m.tilts.resize(1);
         m.row_stamps.resize(m.row_stamps.empty() ? 0 : 1);
         m.line_poses.resize(m.poses_per_row);
       }}};
  for (const auto& [expected, spoil] : spoilers) {
    RangeImageMsg bad = good;
    spoil(bad);
    log_.clear();
    ros::WallDuration(2.1).sleep();  // the messages are throttled to one in two seconds
    image_publisher_.publish(bad);
    EXPECT_TRUE(logged(expected)) << "for '" << expected << "' the log says: " << log_;
  }
  sensor_msgs::PointCloud2 flat = cameraCloud(142.0);
  flat.width *= flat.height;
  flat.height = 1;
  log_.clear();
  ros::WallDuration(2.1).sleep();
  cloud_publisher_.publish(flat);
  EXPECT_TRUE(logged("not organised (height 1")) << log_;

  // The node lives on, and the accounts close.
  EXPECT_EQ(answerTo(image_publisher_, scanMessage({plate()}, 143.0)).polygons.size(), 1U);
  const auto bad_inputs = static_cast<std::uint32_t>(spoilers.size()) + 1U;
  EXPECT_EQ(statistics_.back().images_skipped, skipped + bad_inputs);
  EXPECT_EQ(statistics_.back().images_received, received + bad_inputs + 1U);
}

TEST_F(PatchPlaneClusteringTest, NewestWinsUnderOverload) {
  answerTo(image_publisher_, scanMessage({plate()}, 150.0));
  const std::uint32_t received = statistics_.back().images_received, skipped = statistics_.back().images_skipped;
  const std::size_t answers = statistics_.size();
  for (int i = 1; i <= 200; ++i) {
    image_publisher_.publish(scanMessage({plate()}, 150.0 + i));
    ros::spinOnce();
  }
  ASSERT_TRUE(waitFor([&] { return !polygons_.empty() && polygons_.back().header.stamp == ros::Time(350.0); }));
  ASSERT_TRUE(waitFor([&] { return statistics_.back().header.stamp == ros::Time(350.0); }));
  const auto segmented = static_cast<std::uint32_t>(statistics_.size() - answers);
  // Every image that the nodelet received was segmented or counted as skipped (its own queue may have dropped some before).
  EXPECT_EQ(statistics_.back().images_received - received, segmented + statistics_.back().images_skipped - skipped);
  for (std::size_t i = 1; i < polygons_.size(); ++i) EXPECT_LT(polygons_[i - 1].header.stamp, polygons_[i].header.stamp);
}

dynamic_reconfigure::Config setting(const std::string& name, int value) {
  dynamic_reconfigure::Config config;
  config.ints.resize(1);
  config.ints[0].name = name;
  config.ints[0].value = value;
  return config;
}

int intOf(const dynamic_reconfigure::Config& config, const std::string& name) {
  for (const auto& parameter : config.ints) {
    if (parameter.name == name) return parameter.value;
  }
  return -1;
}

TEST_F(PatchPlaneClusteringTest, ReconfigurationChangesTheNextResult) {
  EXPECT_EQ(answerTo(image_publisher_, scanMessage({plate()}, 400.0)).polygons.size(), 1U);
  dynamic_reconfigure::Reconfigure call;
  call.request.config = setting("min_size", 1000000);  // more than the image has
  ASSERT_TRUE(ros::service::call("/ppc/set_parameters", call));
  EXPECT_EQ(intOf(call.response.config, "min_size"), 1000000);
  EXPECT_TRUE(answerTo(image_publisher_, scanMessage({plate()}, 401.0)).polygons.empty());
  call.request.config = setting("min_size", 0);
  ASSERT_TRUE(ros::service::call("/ppc/set_parameters", call));
  EXPECT_EQ(answerTo(image_publisher_, scanMessage({plate()}, 402.0)).polygons.size(), 1U);
}

TEST_F(PatchPlaneClusteringTest, InvalidUpdatesAreClampedOrRefused) {
  dynamic_reconfigure::Reconfigure call;
  call.request.config = setting("patch_size", -5);
  ASSERT_TRUE(ros::service::call("/ppc/set_parameters", call));
  EXPECT_EQ(intOf(call.response.config, "patch_size"), 2);
  call.request.config = setting("patch_size", 4);
  call.request.config.doubles.resize(1);
  call.request.config.doubles[0].name = "sigma_distance";
  call.request.config.doubles[0].value = std::numeric_limits<double>::quiet_NaN();
  log_.clear();
  ASSERT_TRUE(ros::service::call("/ppc/set_parameters", call));
  EXPECT_TRUE(logged("'sigma_distance' = nan")) << log_;
  EXPECT_EQ(intOf(call.response.config, "patch_size"), 2);  // an update is taken as a whole or not at all
  call.request.config = setting("patch_size", 4);
  ASSERT_TRUE(ros::service::call("/ppc/set_parameters", call));
  EXPECT_EQ(answerTo(image_publisher_, scanMessage({plate()}, 410.0)).polygons.size(), 1U);
}

TEST_F(PatchPlaneClusteringTest, ReconfigurationStormUnderTraffic) {
  ros::ServiceClient client = nh_.serviceClient<dynamic_reconfigure::Reconfigure>("/ppc/set_parameters", true);
  ASSERT_TRUE(client.waitForExistence(ros::Duration(10.0)));
  const RangeImageMsg image = scanMessage({plate()}, 420.0);
  for (int i = 0; i < 100; ++i) {
    RangeImageMsg message = image;
    message.header.stamp = ros::Time(420.0 + 0.01 * i);
    image_publisher_.publish(message);
    dynamic_reconfigure::Reconfigure call;
    call.request.config = setting("patch_size", i % 100 - 20);  // many are out of range
    ASSERT_TRUE(client.call(call)) << i;
    ASSERT_EQ(intOf(call.response.config, "patch_size"), std::min(std::max(i % 100 - 20, 2), 64));
    ros::spinOnce();
  }
  dynamic_reconfigure::Reconfigure call;
  call.request.config = setting("patch_size", 4);
  ASSERT_TRUE(client.call(call));
  EXPECT_EQ(answerTo(image_publisher_, scanMessage({plate()}, 430.0)).polygons.size(), 1U);
}

TEST_F(PatchPlaneClusteringTest, BadParametersAreNamedAndDefaultsUsed) {
  ros::Publisher publisher = nh_.advertise<RangeImageMsg>("/bad/range_image", 2);
  PlanarPolygonArray answer;
  const auto subscriber = nh_.subscribe<PlanarPolygonArray>("/bad/polygons", 2, [&](const auto& m) { answer = *m; });
  ASSERT_TRUE(waitFor([&] { return publisher.getNumSubscribers() > 0 && subscriber.getNumPublishers() > 0; }));
  publisher.publish(scanMessage({plate()}, 440.0));
  ASSERT_TRUE(waitFor([&] { return answer.header.stamp == ros::Time(440.0); }));
  EXPECT_EQ(answer.polygons.size(), 1U);
  int patch_size = 0;
  ASSERT_TRUE(nh_.getParam("/bad/ppc_bad/patch_size", patch_size));
  EXPECT_EQ(patch_size, 4);  // neither 1000 nor what it would be clamped to

  // Its messages went out before this test began; a second one with the same parameters is listened to.
  nh_.setParam("/bad/second/patch_size", 1000);
  nh_.setParam("/bad/second/similarity_treshold", 0.2);
  nh_.setParam("/bad/second/method", "magic");
  nodelet::NodeletLoad load;
  load.request.name = "/bad/second";
  load.request.type = "patch_plane_clustering/PatchPlaneClustering";
  log_.clear();
  ASSERT_TRUE(ros::service::call("/manager/load_nodelet", load));
  EXPECT_TRUE(logged("'/bad/second/patch_size' = 1000 is not a whole number in [2, 64]")) << log_;
  EXPECT_TRUE(logged("'/bad/second/method' = magic is not one of ppc")) << log_;
  EXPECT_TRUE(logged("'/bad/second/similarity_treshold'; did you mean 'similarity_threshold'?")) << log_;
  nodelet::NodeletUnload unload;
  unload.request.name = "/bad/second";
  EXPECT_TRUE(ros::service::call("/manager/unload_nodelet", unload));
}

/// Set PPC_RELOADS to a larger number for a long run.
TEST_F(PatchPlaneClusteringTest, UnloadAndLoadUnderTraffic) {
  const char* wanted = std::getenv("PPC_RELOADS");
  const int reloads = wanted ? std::atoi(wanted) : 10;
  const RangeImageMsg image = scanMessage({plate()}, 500.0);
  std::atomic<bool> running{true};
  std::thread traffic([&] {
    for (int i = 0; running; ++i) {
      RangeImageMsg message = image;
      message.header.stamp = ros::Time(500.0 + 0.001 * i);
      image_publisher_.publish(message);
      ros::WallDuration(0.002).sleep();
    }
  });
  int loaded = 0, unloaded = 0;
  for (int i = 0; i < reloads; ++i) {
    nodelet::NodeletLoad load;
    load.request.name = "/reloaded";
    load.request.type = "patch_plane_clustering/PatchPlaneClustering";
    loaded += ros::service::call("/manager/load_nodelet", load) && load.response.success;
    ros::spinOnce();
    ros::WallDuration(0.02 * (i % 5)).sleep();
    nodelet::NodeletUnload unload;
    unload.request.name = "/reloaded";
    unloaded += ros::service::call("/manager/unload_nodelet", unload) && unload.response.success;
  }
  running = false;
  traffic.join();
  EXPECT_EQ(loaded, reloads);
  EXPECT_EQ(unloaded, reloads);
  // The manager and the other nodelet in it are well.
  EXPECT_EQ(answerTo(image_publisher_, scanMessage({plate()}, 1e6)).polygons.size(), 1U);
}

}  // namespace
}  // namespace ppc

int main(int argc, char** argv) { return ppc::runRosTests(argc, argv, "test_patch_plane_clustering"); }
