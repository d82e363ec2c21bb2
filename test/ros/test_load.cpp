// SPDX-License-Identifier: BSD-3-Clause
// More than the nodelets can do, and for longer: queues stay bounded, the newest sweep wins, memory stays flat. Longer runs
// by hand: PPC_SOAK_LINES=100000 and PPC_RELOADS=500 in the environment. Figures are printed, and are in the test's log.
#include "nodelet_manager.h"
#include "patch_plane_clustering/ros/messages.h"
#include "patch_plane_clustering/ros/reconfiguration.h"
#include "ros_test_main.h"
#include "wait_for.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <dynamic_reconfigure/config_tools.h>
#include <gtest/gtest.h>
#include <ros/callback_queue.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <map>
#include <random>

namespace ppc {
namespace {

int wanted(const char* variable, int otherwise) {
  const char* text = std::getenv(variable);
  return text ? std::atoi(text) : otherwise;
}

class Load : public testing::Test {
 protected:
  Load() : ns_(std::string("/") + testing::UnitTest::GetInstance()->current_test_info()->name()), nh_(ns_) {}

  template <typename Value>
  void set(const std::string& name, const Value& value) {
    ros::param::set(ns_ + "/" + name, value);
  }

  /// A scanner of so many lines a second in an office; a sweep is of 300 lines.
  void start(double lines_a_second, const std::string& sensor = "utm_30lx") {
    set("scanner/sensor", sensor);
    set("scanner/real_time_factor", lines_a_second / (sensor == "utm_30lx" ? 40.0 : 10.0));
    set("driver/joint_name", std::string("tilt_joint"));
    set("driver/lever_arm", std::vector<double>{0.0, 0.0, 0.0});
    ASSERT_TRUE(manager_.load(ns_ + "/driver", "TiltScanDriver"));
    ASSERT_TRUE(manager_.load(ns_ + "/ppc", "PatchPlaneClustering"));
    polygons_subscriber_ =
        nh_.subscribe<PlanarPolygonArray>("polygons", 1000, [this](const auto& m) { polygons_.push_back(m); });
    statistics_subscriber_ =
        nh_.subscribe<SegmentationStatistics>("statistics", 1000, [this](const auto& m) { statistics_.push_back(m); });
    diagnostics_subscriber_ =
        nh_.subscribe<diagnostic_msgs::DiagnosticArray>("/diagnostics", 100, [this](const auto& array) {
          for (const auto& status : array->status) {
            if (status.name.rfind(ns_.substr(1) + "/", 0) != 0) continue;
            for (const auto& value : status.values) numbers_[value.key] = std::atof(value.value.c_str());
            if (!status.message.empty()) messages_ += status.message + "\n";
          }
        });
    ASSERT_TRUE(waitFor([this] {
      return polygons_subscriber_.getNumPublishers() > 0 && statistics_subscriber_.getNumPublishers() > 0 &&
             diagnostics_subscriber_.getNumPublishers() > 0;
    }));
    ASSERT_TRUE(manager_.load(ns_ + "/scanner", "SimulatedScanner"));  // last: it makes traffic
  }

  bool waitForPolygons(std::size_t more) {
    const std::size_t until = polygons_.size() + more;
    return waitFor([&] { return polygons_.size() >= until && statistics_.size() >= polygons_.size(); });
  }

  /// Waits for numbers that were reported after this call.
  bool freshNumbers() {
    const auto reported = [this] { return numbers_.count("Lines in") + numbers_.count("Images received") == 2; };
    numbers_.clear();
    if (!waitFor(reported)) return false;
    numbers_.clear();
    return waitFor(reported);
  }

  void expectAccountsClose() {
    ASSERT_TRUE(freshNumbers());
    double lines = numbers_["Lines in images"] + numbers_["Lines pending"];
    for (const auto& [key, value] : numbers_) {
      if (key.rfind("Lines dropped: ", 0) == 0) lines += value;
    }
    EXPECT_EQ(numbers_["Lines in"], lines);
    const double images = numbers_["Images segmented"] + numbers_["Images refused"] + numbers_["Images overtaken"];
    EXPECT_GE(numbers_["Images received"], images);
    EXPECT_LE(numbers_["Images received"], images + 2.0);  // one in work, one that waits
    EXPECT_LE(numbers_["Lines pending"], 300.0 + 200.0);   // the open sweep and the queue
    for (std::size_t i = 1; i < polygons_.size(); ++i) {
      EXPECT_LT(polygons_[i - 1]->header.stamp, polygons_[i]->header.stamp);
    }
  }

  double longestLatency() const {  // [ms], from a sweep's message to its polygons
    double longest = 0.0;
    for (const auto& each : statistics_) longest = std::max(longest, static_cast<double>(each->total_milliseconds));
    return longest;
  }

  double longestWork() const {  // [ms], the stages alone
    double longest = 0.0;
    for (const auto& each : statistics_) {
      double sum = 0.0;
      for (const float stage : each->stage_milliseconds) sum += static_cast<double>(stage);
      longest = std::max(longest, sum);
    }
    return longest;
  }

  std::string ns_;
  ros::NodeHandle nh_;
  NodeletManager manager_{"/manager"};
  std::vector<PlanarPolygonArray::ConstPtr> polygons_;
  std::vector<SegmentationStatistics::ConstPtr> statistics_;
  std::map<std::string, double> numbers_;  // of the diagnostics
  std::string messages_;

 private:
  ros::Subscriber polygons_subscriber_, statistics_subscriber_, diagnostics_subscriber_;
};

TEST_F(Load, theNewestSweepWinsWhenSegmentationIsSlowerThanTheLaser) {
  set("ppc/method", std::string("pcl_region_growing"));  // seconds an image
  start(2000.0);
  ASSERT_TRUE(waitForPolygons(3));
  const double before = manager_.memory();
  ASSERT_TRUE(waitForPolygons(3));
  expectAccountsClose();
  EXPECT_GT(numbers_["Images overtaken"], 5.0);
  EXPECT_NE(messages_.find("images overtaken"), std::string::npos) << messages_;
  // A sweep waits at most for the one in work: latency is bounded by two of them, however long this goes on.
  EXPECT_LT(longestLatency(), 2.5 * longestWork() + 200.0);
  EXPECT_LT(manager_.memory(), before + 100.0);
  std::cout << "overload: " << numbers_["Lines in"] << " lines, " << numbers_["Images received"] << " sweeps, "
            << numbers_["Images overtaken"] << " overtaken, segmentation up to " << longestWork() << " ms, latency up to "
            << longestLatency() << " ms, " << manager_.memory() << " MB\n";
}

TEST_F(Load, twoThousandLinesASecondLoseNoLineUncounted) {
  start(2000.0);
  ASSERT_TRUE(waitForPolygons(10));
  expectAccountsClose();
  EXPECT_GT(numbers_["Lines in images"], 3000.0);
  EXPECT_LT(longestLatency(), 2.5 * longestWork() + 200.0);
  // The scanner counts its lines in header.seq: those that the driver's queue had no room for are known as well.
  std::cout << "2000 lines/s: " << numbers_["Lines in"] << " lines in, " << numbers_["Lines in images"] << " in images, "
            << numbers_["Scans lost on the way"] << " lost on the way, " << numbers_["Images overtaken"] << " of "
            << numbers_["Images received"] << " sweeps overtaken, latency up to " << longestLatency() << " ms\n";
}

TEST_F(Load, aSlowSubscriberHoldsNobodyUp) {
  start(800.0);
  ASSERT_TRUE(waitForPolygons(5));
  const double before = manager_.memory();
  ros::CallbackQueue queue;
  ros::NodeHandle slow(ns_);
  slow.setCallbackQueue(&queue);
  int clouds = 0, images = 0;
  const auto a = slow.subscribe<sensor_msgs::PointCloud2>("segmented_points", 1, [&](const auto&) {
    ++clouds;
    ros::WallDuration(0.5).sleep();
  });
  const auto b = slow.subscribe<RangeImageMsg>("range_image", 1, [&](const auto&) {
    ++images;
    ros::WallDuration(0.5).sleep();
  });
  ros::AsyncSpinner spinner(1, &queue);
  spinner.start();
  ASSERT_TRUE(waitForPolygons(20));
  spinner.stop();
  EXPECT_GT(clouds + images, 2);
  expectAccountsClose();
  EXPECT_LT(longestLatency(), 2.5 * longestWork() + 500.0);
  EXPECT_LT(manager_.memory(), before + 100.0);  // two clouds of 6.5 MB wait in the publisher, two images, and their copies
  std::cout << "slow subscriber: " << clouds << " clouds and " << images << " images taken, memory " << before << " -> "
            << manager_.memory() << " MB\n";
}

/// Any value for any parameter: one in four is out of its range, and some are of no kind at all.
dynamic_reconfigure::Config anyUpdate(std::mt19937& random) {
  std::uniform_real_distribution<double> chance(0.0, 1.0);
  dynamic_reconfigure::Config update;
  using dynamic_reconfigure::ConfigTools;
  for (const ConfigField& field : configFields()) {
    if (chance(random) < 0.5) continue;
    const double span = field.max - field.min;
    const double value = field.min + span * (chance(random) < 0.25 ? 4.0 * chance(random) - 2.0 : chance(random));
    const bool other_type = chance(random) < 0.02;
    if (field.type == ConfigField::Type::kDouble && !other_type) {
      const double odd = chance(random) < 0.5 ? std::numeric_limits<double>::quiet_NaN() : -1e300;
      ConfigTools::appendParameter(update, field.name, chance(random) < 0.02 ? odd : value);
    } else if (field.type == ConfigField::Type::kInt && !other_type) {
      ConfigTools::appendParameter(update, field.name, static_cast<int>(value));
    } else {
      ConfigTools::appendParameter(update, field.name, value > 0.0);
    }
  }
  if (chance(random) < 0.05) ConfigTools::appendParameter(update, "no_such_parameter", 3);
  return update;
}

TEST_F(Load, aStormOfReconfigurationsBreaksNothing) {
  start(800.0, "urg_04lx");
  ASSERT_TRUE(waitForPolygons(4));
  const auto usual = static_cast<double>(polygons_.back()->polygons.size());
  EXPECT_GT(usual, 3.0);
  ros::ServiceClient client = nh_.serviceClient<dynamic_reconfigure::Reconfigure>("ppc/set_parameters", true);
  ASSERT_TRUE(client.waitForExistence(ros::Duration(10.0)));
  std::mt19937 random(1);
  const int updates = wanted("PPC_UPDATES", 300);
  const double before = manager_.memory();
  const std::size_t sweeps = polygons_.size();
  ros::WallRate rate(50.0);
  for (int i = 0; i < updates; ++i, rate.sleep()) {
    dynamic_reconfigure::Reconfigure call;
    call.request.config = anyUpdate(random);
    ASSERT_TRUE(client.call(call)) << i;
    // Whatever was asked for, what is in force is valid.
    for (const auto& parameter : call.response.config.doubles) {
      for (const ConfigField& field : configFields()) {
        if (field.name != parameter.name) continue;
        EXPECT_LE(field.min, parameter.value) << parameter.name;
        EXPECT_GE(field.max, parameter.value) << parameter.name;
      }
    }
    ros::spinOnce();
  }
  dynamic_reconfigure::Reconfigure call;
  toReconfigurable(Config()).__toMessage__(call.request.config);
  ASSERT_TRUE(client.call(call));
  ASSERT_TRUE(waitForPolygons(6));
  EXPECT_GT(polygons_.size(), sweeps + 6);
  EXPECT_NEAR(static_cast<double>(polygons_.back()->polygons.size()), usual, 0.4 * usual);  // up and down differ
  expectAccountsClose();
  std::cout << "reconfiguration: " << updates << " updates at 50 a second, " << polygons_.size() - sweeps
            << " sweeps meanwhile, memory " << before << " -> " << manager_.memory() << " MB\n";
}

TEST_F(Load, nodeletsComeAndGoUnderTraffic) {
  start(800.0, "urg_04lx");
  ASSERT_TRUE(waitForPolygons(2));
  const int reloads = wanted("PPC_RELOADS", 15);
  const std::string driver = ns_ + "/second_driver", ppc = ns_ + "/second_ppc";
  set("second_driver/joint_name", std::string("tilt_joint"));
  double before = 0.0;
  for (int i = 0; i < reloads; ++i) {
    ASSERT_TRUE(manager_.load(driver, "TiltScanDriver")) << i;
    ASSERT_TRUE(manager_.load(ppc, "PatchPlaneClustering")) << i;
    waitFor([] { return false; }, 0.03 * (i % 4));
    ASSERT_TRUE(manager_.unload(i % 2 == 0 ? driver : ppc)) << i;
    ASSERT_TRUE(manager_.unload(i % 2 == 0 ? ppc : driver)) << i;
    if (i == std::min(reloads / 3, 30)) before = manager_.memory();
  }
  statistics_.clear();
  polygons_.clear();  // both drivers wrote to the same topics
  ASSERT_TRUE(waitForPolygons(3));
  EXPECT_GT(polygons_.back()->polygons.size(), 3U);
  EXPECT_LT(manager_.memory(), before + 60.0);
  std::cout << "reloads: " << reloads << " of each, memory " << before << " -> " << manager_.memory() << " MB\n";
}

TEST_F(Load, memoryStaysFlatOverManyLines) {
  start(1200.0, "urg_04lx");
  const double lines = wanted("PPC_SOAK_LINES", 12000);
  ASSERT_TRUE(waitForPolygons(8));
  const auto linesUntil = [&](double count) {
    return waitFor([&] { return numbers_["Lines in"] >= count; }, 60.0 + lines / 100.0);
  };
  ASSERT_TRUE(linesUntil(0.4 * lines));
  const double middle = manager_.memory();
  ASSERT_TRUE(linesUntil(lines));
  const double end = manager_.memory();
  EXPECT_LT(end, middle + 15.0);
  EXPECT_LT(end, 400.0);
  expectAccountsClose();
  std::cout << "soak: " << numbers_["Lines in"] << " lines, " << numbers_["Images segmented"] << " sweeps segmented, "
            << numbers_["Images overtaken"] << " overtaken, memory " << middle << " MB at 40 %, " << end
            << " MB at the end\n";
}

}  // namespace
}  // namespace ppc

int main(int argc, char** argv) { return ppc::runRosTests(argc, argv, "test_load"); }
