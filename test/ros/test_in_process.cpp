// SPDX-License-Identifier: BSD-3-Clause
// All nodelets in the test's own process, so that a sanitizer sees every thread: sweeps in flight, reconfiguration,
// unloading.
#include "patch_plane_clustering/ros/messages.h"
#include "ros_test_main.h"
#include "scan_player.h"
#include "test_scenes.h"
#include "wait_for.h"

#include <dynamic_reconfigure/Reconfigure.h>
#include <gtest/gtest.h>
#include <nodelet/loader.h>
#include <ros/ros.h>
#include <sensor_msgs/point_cloud2_iterator.h>
#include <atomic>
#include <functional>
#include <limits>
#include <random>
#include <set>
#include <thread>

namespace ppc {
namespace {

using namespace testing_tools;

bool reconfigure(const std::string& nodelet, int patch_size, double sigma) {
  dynamic_reconfigure::Reconfigure call;
  call.request.config.ints.resize(1);
  call.request.config.ints[0].name = "patch_size";
  call.request.config.ints[0].value = patch_size;
  call.request.config.doubles.resize(1);
  call.request.config.doubles[0].name = "sigma_distance";
  call.request.config.doubles[0].value = sigma;
  return ros::service::call(nodelet + "/set_parameters", call);
}

// What came out of one plane clustering nodelet.
struct Results {
  std::set<double> stamps;
  std::uint32_t polygons = 0, received = 0, skipped = 0;
  ros::Subscriber polygons_sub, statistics_sub;

  explicit Results(ros::NodeHandle& nh) {
    polygons_sub = nh.subscribe<PlanarPolygonArray>("/polygons", 100, [this](const auto& m) {
      stamps.insert(m->header.stamp.toSec());
      polygons += static_cast<std::uint32_t>(m->polygons.size());
    });
    statistics_sub = nh.subscribe<SegmentationStatistics>("/statistics", 100, [this](const auto& m) {
      received = m->images_received;
      skipped = m->images_skipped;
    });
  }
};

TEST(InProcess, SweepsAndReconfigurationInFlight) {
  constexpr int kImages = 60;
  ros::NodeHandle nh;
  nodelet::Loader loader(false);
  ASSERT_TRUE(loader.load("/ppc", "patch_plane_clustering/PatchPlaneClustering", {}, {}));
  Results results(nh);
  const ros::Publisher publisher = nh.advertise<RangeImageMsg>("/range_image", 5);
  ASSERT_TRUE(waitFor([&] {
    return publisher.getNumSubscribers() == 1 && results.polygons_sub.getNumPublishers() == 1 &&
           results.statistics_sub.getNumPublishers() == 1;
  }));

  std::atomic<bool> going{true};
  std::atomic<int> updates{0}, refused{0};
  std::thread tuner([&] {
    for (int i = 0; going; ++i) {
      if (reconfigure("/ppc", 3 + i % 5, 0.004 + 0.001 * (i % 3))) {
        ++updates;
      } else {
        ++refused;
      }
    }
  });
  const RangeImageMsg scene = scanMessage({plate()}, 1.0);
  for (int i = 0; i < kImages; ++i) {
    auto message = boost::make_shared<RangeImageMsg>(scene);
    message->header.stamp = ros::Time(100.0 + i);
    publisher.publish(RangeImageMsgConstPtr(message));
    // Two at a time: the second arrives while the first is being segmented.
    if (i % 2 == 1) waitFor([&] { return results.stamps.count(100.0 + i) > 0; }, 20.0);
  }
  EXPECT_TRUE(waitFor([&] { return results.received == kImages; }));
  going = false;
  tuner.join();
  EXPECT_EQ(results.stamps.size() + results.skipped, static_cast<std::size_t>(kImages));
  EXPECT_EQ(results.stamps.count(100.0 + kImages - 1), 1U) << "the newest wins";
  EXPECT_EQ(results.polygons, results.stamps.size()) << "one plate, one polygon, whatever the parameters";
  EXPECT_GT(updates, 5);
  EXPECT_EQ(refused, 0);
  EXPECT_TRUE(loader.unload("/ppc"));
}

// Makes of a line what must make no points.
void spoil(sensor_msgs::LaserScan& scan, std::mt19937& random) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const std::vector<std::function<void()>> faults = {
      [&] { scan.ranges.clear(); },
      [&] { scan.ranges.resize(random() % 100); },
      [&] { scan.intensities.resize(7); },
      [&] { scan.angle_increment = random() % 2 == 0 ? nan : -scan.angle_increment; },
      [&] { scan.time_increment = random() % 2 == 0 ? -inf : 1e3F; },
      [&] { scan.range_min = inf; },
      [&] { scan.range_max = random() % 2 == 0 ? nan : -1.0F; },
      [&] { scan.header.stamp = random() % 2 == 0 ? ros::Time() : ros::Time(4294967295U, 999999999U); },
      [&] { scan.header.stamp -= ros::Duration(0.3); },
      [&] { scan.header.frame_id.clear(); },
      [&] { std::fill(scan.ranges.begin(), scan.ranges.end(), random() % 2 == 0 ? nan : inf); },
  };
  faults[random() % faults.size()]();
}

void spoil(sensor_msgs::JointState& sample, std::mt19937& random) {
  const std::vector<std::function<void()>> faults = {
      [&] { sample.position.clear(); },
      [&] { sample.name.clear(); },
      [&] { sample.position[1] = std::numeric_limits<double>::quiet_NaN(); },
      [&] { sample.position[1] = 1e300; },
      [&] { sample.position[1] += 1.0; },
      [&] { sample.header.stamp = ros::Time(); },
      [&] { sample.header.stamp -= ros::Duration(0.2); },
      [&] { sample.header.stamp += ros::Duration(1e6); },
  };
  faults[random() % faults.size()]();
}

TEST(InProcess, FaultsInFlight) {
  nodelet::Loader loader(false);
  ros::param::set("/faults/driver/joint_name", "tilt_joint");
  ros::param::set("/faults/driver/lever_arm", std::vector<double>{0.0, 0.0, 0.0});
  ASSERT_TRUE(loader.load("/faults/driver", "patch_plane_clustering/TiltScanDriver", {}, {}));
  ASSERT_TRUE(loader.load("/faults/ppc", "patch_plane_clustering/PatchPlaneClustering", {}, {}));
  std::mt19937 random(11);
  ScanPlayer player("/faults");
  player.send_scan = [&](sensor_msgs::LaserScan scan) {
    player.publishScan(scan);
    if (random() % 4 != 0) return;
    scan.header.stamp += ros::Duration(0.006);
    spoil(scan, random);
    player.publishScan(scan);
  };
  player.send_joint = [&](sensor_msgs::JointState sample) {
    player.publishJoint(sample);
    if (random() % 8 != 0) return;
    sample.header.stamp += ros::Duration(0.002);
    spoil(sample, random);
    player.publishJoint(sample);
  };
  std::size_t arrays = 0;
  ros::NodeHandle nh;
  const ros::Subscriber polygons = nh.subscribe<PlanarPolygonArray>("/faults/polygons", 100, [&](const auto&) { ++arrays; });
  ASSERT_TRUE(player.connect());
  ASSERT_TRUE(waitFor([&] { return polygons.getNumPublishers() > 0; }));
  player.play(1000.0, 1012.4);
  // A sanitizer slows the nodelets down, so that a queue of ROS may overflow.
  waitFor([&] { return player.diagnosed("Lines in") == player.scans_sent; }, 20.0);
  EXPECT_LE(player.diagnosed("Lines in"), player.scans_sent);
  EXPECT_GT(player.diagnosed("Lines in"), 0.5 * player.scans_sent);
  ASSERT_TRUE(waitFor([&] { return player.clouds.size() >= 3 && arrays >= 2; }));
  for (const auto& cloud : player.clouds) {
    for (sensor_msgs::PointCloud2ConstIterator<float> p(*cloud, "x"); p != p.end(); ++p) {
      if (std::isnan(p[0])) continue;
      ASSERT_LT(offTheWalls(Eigen::Vector3d(p[0], p[1], p[2])), 0.002);
    }
  }
  EXPECT_GT(player.linesDropped(), 50.0);
  EXPECT_GT(player.diagnosed("Lines in images"), 100.0);
  EXPECT_EQ(player.diagnosed("Lines in"),
            player.diagnosed("Lines in images") + player.diagnosed("Lines pending") + player.linesDropped());
  for (const char* name : {"/faults/driver", "/faults/ppc"}) EXPECT_TRUE(loader.unload(name));
}

std::vector<std::function<void(RangeImageMsg&)>> imageSpoilers() {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  return {
      [](auto& m) { std::swap(m.height, m.width); },
      [](auto& m) { m.height = m.width = 65536; },
      [](auto& m) { m.poses_per_row = 0; },
      [](auto& m) { m.poses_per_row = 0xFFFFFFFFU; },
      [](auto& m) { m.line_poses.pop_back(); },
      [](auto& m) { std::reverse(m.line_poses.begin(), m.line_poses.end()); },
      [](auto& m) { std::rotate(m.line_poses.begin(), m.line_poses.begin() + 40, m.line_poses.end()); },
      [](auto& m) { std::fill(m.line_poses.begin(), m.line_poses.end(), m.line_poses.front()); },
      [](auto& m) { m.line_poses[5].position.x = 1e30; },
      [](auto& m) { m.line_poses[5].position.x = 1e300; },
      [](auto& m) { m.line_poses[5].orientation = geometry_msgs::Quaternion(); },
      [](auto& m) { m.bearing_increment = 1e-30F; },
      [](auto& m) { m.bearing_increment = 1e30F; },
      [](auto& m) { m.bearing_increment *= -1.0F; },
      [](auto& m) { m.bearing_min = 1e30F; },
      [](auto& m) { std::swap(m.range_min, m.range_max); },
      [=](auto& m) { m.range_max = nan; },
      [=](auto& m) { m.range_max = inf; },
      [](auto& m) { m.range_min = -1e30F; },
      [=](auto& m) { std::fill(m.tilts.begin(), m.tilts.end(), nan); },
      [](auto& m) { m.row_stamps.assign(3, ros::Time()); },
      [](auto& m) { m.intensities.assign(7, 0.0F); },
      [](auto& m) { std::fill(m.ranges.begin(), m.ranges.end(), 1e38F); },
      [](auto& m) { std::fill(m.ranges.begin(), m.ranges.end(), 1e-38F); },
      [=](auto& m) {
        for (std::size_t i = 0; i < m.ranges.size(); ++i) m.ranges[i] = i % 3 == 0 ? nan : i % 3 == 1 ? -inf : 1e20F;
      },
      [](auto& m) { m.header.frame_id.assign(1000000, '\xff'); },
  };
}

std::vector<std::function<void(sensor_msgs::PointCloud2&)>> cloudSpoilers() {
  const auto fill = [](sensor_msgs::PointCloud2& cloud, float value) {
    for (sensor_msgs::PointCloud2Iterator<float> x(cloud, "x"); x != x.end(); ++x) *x = value;
  };
  return {
      [](auto& c) { c.point_step = 0; },
      [](auto& c) { c.point_step = 0xFFFFFFFFU; },
      [](auto& c) { c.row_step = 0; },
      [](auto& c) { c.row_step = 0xFFFFFFFFU; },
      [](auto& c) { c.height = c.width = 65536; },
      [](auto& c) { c.is_bigendian = !c.is_bigendian; },
      [](auto& c) { c.fields.clear(); },
      [](auto& c) { c.fields[3].name = "X"; },
      [](auto& c) { c.fields[3].offset = 0xFFFFFFFCU; },
      [](auto& c) { c.fields[3].datatype = sensor_msgs::PointField::FLOAT64; },  // of bytes that are none
      [](auto& c) { c.fields[3].datatype = 77; },
      [](auto& c) { c.fields[3].count = 0xFFFFFFFFU; },
      [](auto& c) { c.fields[1].offset = c.fields[2].offset = c.fields[3].offset; },
      [](auto& c) { c.data.resize(c.data.size() / 2); },
      [](auto& c) { c.data.clear(); },
      [](auto& c) { std::fill(c.data.begin(), c.data.end(), std::uint8_t{0}); },
      [](auto& c) { std::fill(c.data.begin(), c.data.end(), std::uint8_t{0xFF}); },
      [=](auto& c) { fill(c, 1e30F); },
      [=](auto& c) { fill(c, std::numeric_limits<float>::denorm_min()); },
      [=](auto& c) { fill(c, -std::numeric_limits<float>::infinity()); },
  };
}

TEST(InProcess, SpoiltImagesAndCloudsMakeNoFalsePolygons) {
  ros::NodeHandle nh;
  nodelet::Loader loader(false);
  ASSERT_TRUE(loader.load("/ppc", "patch_plane_clustering/PatchPlaneClustering", {}, {}));
  Results results(nh);
  std::size_t bad_vertices = 0;
  const auto vertices = nh.subscribe<PlanarPolygonArray>("/polygons", 100, [&](const auto& array) {
    for (const PlanarPolygonMsg& polygon : array->polygons) {
      bad_vertices += polygon.outer.points.size() < 3;
      for (const auto& p : polygon.outer.points)
        bad_vertices += !std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z);
    }
  });
  const ros::Publisher images = nh.advertise<RangeImageMsg>("/range_image", 5);
  const ros::Publisher clouds = nh.advertise<sensor_msgs::PointCloud2>("/points_in", 5);
  ASSERT_TRUE(waitFor([&] {
    return images.getNumSubscribers() == 1 && clouds.getNumSubscribers() == 1 && vertices.getNumPublishers() == 1 &&
           results.polygons_sub.getNumPublishers() == 1 && results.statistics_sub.getNumPublishers() == 1;
  }));
  double stamp = 3000.0;
  std::uint32_t sent = 0;
  const auto check = [&](const ros::Publisher& publisher, const auto& good, const auto& spoilers) {
    for (std::size_t i = 0; i < spoilers.size(); ++i) {
      auto bad = good;
      bad.header.stamp = ros::Time(stamp + 0.5);
      spoilers[i](bad);
      publisher.publish(bad);
      waitFor([] { return false; }, 0.05);  // it is taken up before the next overtakes it
      auto next = good;
      next.header.stamp = ros::Time(++stamp);
      publisher.publish(next);
      ASSERT_TRUE(waitFor([&] { return results.stamps.count(stamp) > 0; })) << "after spoiler " << i;
      sent += 2;
    }
  };
  check(images, scanMessage({plate()}, 1.0), imageSpoilers());
  check(clouds, cameraCloud(1.0), cloudSpoilers());
  EXPECT_TRUE(waitFor([&] { return results.received == sent; }));
  EXPECT_EQ(results.stamps.size() + results.skipped, sent);
  EXPECT_GE(results.skipped, 20U);
  EXPECT_EQ(bad_vertices, 0U);
  EXPECT_TRUE(loader.unload("/ppc"));
}

TEST(InProcess, AllNodeletsUnloadedWhileTheyWork) {
  ros::NodeHandle nh;
  nodelet::Loader loader(false);
  ros::param::set("/scanner/scene", "box");
  ros::param::set("/scanner/sensor", "urg_04lx");
  ros::param::set("/scanner/lines_per_pass", 30);
  ros::param::set("/driver/joint_name", "tilt_joint");
  Results results(nh);
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(loader.load("/ppc", "patch_plane_clustering/PatchPlaneClustering", {}, {}));
    ASSERT_TRUE(loader.load("/driver", "patch_plane_clustering/TiltScanDriver", {}, {}));
    ASSERT_TRUE(loader.load("/scanner", "patch_plane_clustering/SimulatedScanner", {}, {}));
    results.stamps.clear();
    EXPECT_TRUE(waitFor([&] { return !results.stamps.empty(); })) << "round " << round;
    // In the direction of the data, and against it: the next one is always at work.
    for (const char* name : {"/ppc", "/driver", "/scanner"}) EXPECT_TRUE(loader.unload(name));
  }
}

}  // namespace
}  // namespace ppc

int main(int argc, char** argv) { return ppc::runRosTests(argc, argv, "test_in_process"); }
