// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "nodelet_manager.h"
#include "scan_player.h"

#include <gtest/gtest.h>
#include <sensor_msgs/point_cloud2_iterator.h>
#include <memory>
#include <string>
#include <vector>

namespace ppc {

/// A driver and a plane clustering, loaded into /manager for one test under its name, and a laser in a room to feed them.
/// All numbers begin at zero, so that accounts can be compared exactly.
class FaultRig : public testing::Test {
 protected:
  FaultRig() : ns_(std::string("/") + testing::UnitTest::GetInstance()->current_test_info()->name()), player(ns_) {
    player.mount.translation() = Eigen::Vector3d(0.05, -0.01, 0.08);
    set("driver/joint_name", std::string("tilt_joint"));
    set("driver/base_frame", ns_.substr(1) + "_base");
    set("driver/lever_arm", std::vector<double>{0.05, -0.01, 0.08});
  }

  template <typename Value>
  void set(const std::string& name, const Value& value) {
    ros::param::set(ns_ + "/" + name, value);
  }

  /// Loads both, and connects.
  void start() {
    ASSERT_TRUE(manager_.load(ns_ + "/driver", "TiltScanDriver"));
    ASSERT_TRUE(manager_.load(ns_ + "/ppc", "PatchPlaneClustering"));
    polygons_subscriber_ =
        nh_.subscribe<PlanarPolygonArray>(ns_ + "/polygons", 100, [this](const auto& m) { polygons.push_back(m); });
    statistics_subscriber_ =
        nh_.subscribe<SegmentationStatistics>(ns_ + "/statistics", 100, [this](const auto& m) { statistics.push_back(m); });
    ASSERT_TRUE(player.connect());
    ASSERT_TRUE(waitFor(
        [this] { return polygons_subscriber_.getNumPublishers() > 0 && statistics_subscriber_.getNumPublishers() > 0; }));
  }

  bool waitForImages(std::size_t count) {
    return waitFor([&] { return player.images.size() >= count && player.clouds.size() >= count; });
  }

  /// Lines dropped for this cause, by the diagnostics that settle() has waited for.
  int drops(const std::string& cause) const { return static_cast<int>(player.diagnosed("Lines dropped: " + cause)); }

  /// What must hold whatever the fault: every line is accounted for, every point is on a wall of the room, no image holds
  /// lines of two sweeps, and every polygon is a piece of a wall.
  void expectSound(double off_the_walls = 0.002) {
    expectAccountsClose();
    for (const auto& cloud : player.clouds) {
      EXPECT_LT(worstPoint(*cloud), off_the_walls) << "at " << cloud->header.stamp;
    }
    for (const auto& image : player.images) {
      EXPECT_TRUE(std::is_sorted(image->tilts.begin(), image->tilts.end()));
      expectOneSweep(*image);
    }
    // A polygon message for every image that was not overtaken by a newer one.
    ASSERT_TRUE(waitFor([&] {
      return player.images.empty() ||
             (!polygons.empty() && polygons.back()->header.stamp == player.images.back()->header.stamp &&
              !statistics.empty() && statistics.back()->header.stamp == player.images.back()->header.stamp);
    }));
    for (const auto& array : polygons) {
      for (const PlanarPolygonMsg& polygon : array->polygons) expectWall(polygon, off_the_walls);
    }
    if (statistics.empty()) return;
    const SegmentationStatistics& last = *statistics.back();
    EXPECT_EQ(last.images_received, player.images.size());
    EXPECT_EQ(last.images_refused, 0U);
    EXPECT_EQ(last.images_received, polygons.size() + last.images_overtaken);
    expectSameAccounts(last.lines, player.images.back()->lines);
  }

  void expectAccountsClose() {
    ASSERT_TRUE(settle());
    // An idle sweep may come out between a report and now; the next report knows of it.
    const auto all_rows = [this] {
      double sum = 0.0;
      for (const auto& image : player.images) sum += image->height;
      return sum;
    };
    EXPECT_TRUE(waitFor([&] { return player.diagnosed("Lines in images") == all_rows(); }));
    EXPECT_EQ(player.diagnosed("Lines in"), player.scans_sent);
    EXPECT_EQ(player.diagnosed("Lines in"),
              player.diagnosed("Lines in images") + player.diagnosed("Lines pending") + player.linesDropped());
    EXPECT_EQ(player.diagnosed("Scans lost on the way"), 0.0);
    std::size_t rows = 0;
    for (const auto& image : player.images) {
      rows += image->height;
      std::uint64_t accounted = image->lines.lines_in_images + image->lines.lines_pending;
      for (const auto& dropped : image->lines.dropped) accounted += dropped.lines;
      EXPECT_EQ(image->lines.lines_in, accounted);
      EXPECT_EQ(image->lines.lines_in_images, rows);
    }
  }

  /// Waits for diagnostics that know of all that was sent.
  bool settle() {
    return waitFor([this] { return player.diagnosed("Lines in") >= player.scans_sent; }) && player.freshDiagnostics();
  }

  bool told(const std::string& part, double seconds = 15.0) {
    return waitFor([&] { return player.diagnostics.message.find(part) != std::string::npos; }, seconds);
  }

  int managerProcess() const { return manager_.process(); }

  static double worstPoint(const sensor_msgs::PointCloud2& cloud) {
    double worst = 0.0;
    for (sensor_msgs::PointCloud2ConstIterator<float> p(cloud, "x"); p != p.end(); ++p) {
      if (!std::isnan(p[0])) worst = std::max(worst, offTheWalls(Eigen::Vector3d(p[0], p[1], p[2])));
    }
    return worst;
  }

  std::string ns_;
  ScanPlayer player;
  std::vector<PlanarPolygonArray::ConstPtr> polygons;
  std::vector<SegmentationStatistics::ConstPtr> statistics;
  ros::NodeHandle nh_;

 private:
  /// In ascending tilt, the stamps of one pass ascend or descend; those of two are mixed. Turning points and noise swap a
  /// few.
  static void expectOneSweep(const RangeImageMsg& image) {
    int up = 0, down = 0;
    for (std::size_t r = 1; r < image.height; ++r) ++(image.row_stamps[r] > image.row_stamps[r - 1] ? up : down);
    EXPECT_LE(std::min(up, down), 8) << "of " << image.height << " rows";
  }

  static void expectWall(const PlanarPolygonMsg& polygon, double tolerance) {
    const auto& plane = polygon.plane.coef;
    int axis = 0;
    for (int k = 1; k < 3; ++k) {
      if (std::abs(plane[k]) > std::abs(plane[axis])) axis = k;
    }
    EXPECT_GT(std::abs(plane[axis]), 0.9998);
    EXPECT_NEAR(std::abs(plane[3]), roomSize()[axis], 0.005 + tolerance);
  }

  static void expectSameAccounts(const LineAccountsMsg& a, const LineAccountsMsg& b) {
    EXPECT_EQ(a.lines_in, b.lines_in);
    EXPECT_EQ(a.lines_in_images, b.lines_in_images);
    EXPECT_EQ(a.lines_pending, b.lines_pending);
    ASSERT_EQ(a.dropped.size(), b.dropped.size());
    for (std::size_t i = 0; i < a.dropped.size(); ++i)
      EXPECT_EQ(a.dropped[i].lines, b.dropped[i].lines) << a.dropped[i].cause;
  }

  NodeletManager manager_{"/manager"};
  ros::Subscriber polygons_subscriber_, statistics_subscriber_;
};

}  // namespace ppc
