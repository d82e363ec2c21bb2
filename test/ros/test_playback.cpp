// SPDX-License-Identifier: BSD-3-Clause
// A recording in a loop, as `rosbag play --loop --clock` plays it, tuned from the command line meanwhile.
#include "nodelet_manager.h"
#include "ros_test_main.h"
#include "scan_player.h"

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cstdio>
#include <cstdlib>
#include <set>

namespace ppc {
namespace {

constexpr double kStart = 50000.0;
constexpr double kLength = 7.0;  // [s]: three sweeps and a piece of a fourth

/// A program of ROS, ended with this object.
class Program {
 public:
  explicit Program(const std::vector<std::string>& words) {
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    process_ = fork();
    if (process_ != 0) return;
    execvp(arguments[0], arguments.data());
    _exit(127);
  }
  ~Program() {
    if (process_ <= 0) return;
    kill(process_, SIGINT);
    waitpid(process_, nullptr, 0);
  }
  int wait() {
    int status = -1;
    waitpid(process_, &status, 0);
    process_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t process_;
};

void record(const std::string& file, const ScanPlayer& player) {
  rosbag::Bag bag(file, rosbag::bagmode::Write);
  for (int tick = 0; tick < static_cast<int>(kLength * 200.0); ++tick) {
    const double t = kStart + tick / 200.0;
    if (tick % 2 == 0) {
      bag.write("/joint_states", ros::Time(t), player.jointSample(t));
      const Eigen::Isometry3d pose = player.laserAt(t);
      const Eigen::Quaterniond q(pose.linear());
      tf2_msgs::TFMessage tf;
      tf.transforms.resize(1);
      tf.transforms[0].header.stamp = ros::Time(t);
      tf.transforms[0].header.frame_id = "tilt_base";
      tf.transforms[0].child_frame_id = "playback_laser";
      tf.transforms[0].transform.translation.x = pose.translation().x();
      tf.transforms[0].transform.translation.y = pose.translation().y();
      tf.transforms[0].transform.translation.z = pose.translation().z();
      tf.transforms[0].transform.rotation.x = q.x();
      tf.transforms[0].transform.rotation.y = q.y();
      tf.transforms[0].transform.rotation.z = q.z();
      tf.transforms[0].transform.rotation.w = q.w();
      bag.write("/tf", ros::Time(t), tf);
    }
    if (tick % 5 == 0) bag.write("/tilt_scan", ros::Time(t + 0.02), player.scan(t));
  }
}

TEST(Playback, aLoopingBagGivesTheSameSweepsAgainAndIsTunedMeanwhile) {
  ScanPlayer player("/playback");
  player.mount.translation() = Eigen::Vector3d(0.0, 0.0, 0.08);
  const std::string file = testing::TempDir() + "ppc_playback_" + std::to_string(getpid()) + ".bag";
  record(file, player);

  ros::NodeHandle nh;
  std::vector<RangeImageMsg::ConstPtr> images;
  std::map<std::uint64_t, std::vector<std::size_t>> polygons;  // counts, by stamp
  std::vector<SegmentationStatistics::ConstPtr> statistics;
  int resets = 0;
  const auto a = nh.subscribe<RangeImageMsg>("/range_image", 100, [&](const auto& m) { images.push_back(m); });
  const auto b = nh.subscribe<PlanarPolygonArray>(
      "/polygons", 100, [&](const auto& m) { polygons[m->header.stamp.toNSec()].push_back(m->polygons.size()); });
  const auto c = nh.subscribe<SegmentationStatistics>("/statistics", 100, [&](const auto& m) { statistics.push_back(m); });
  const auto d = nh.subscribe<diagnostic_msgs::DiagnosticArray>("/diagnostics", 100, [&](const auto& array) {
    for (const auto& status : array->status) {
      for (const auto& value : status.values) {
        if (value.key == "Clock resets") resets = std::atoi(value.value.c_str());
      }
    }
  });
  ASSERT_TRUE(waitFor(
      [&] {
        return a.getNumPublishers() > 0 && b.getNumPublishers() > 0 && c.getNumPublishers() > 0 && d.getNumPublishers() > 0;
      },
      30.0));

  const Program play({"rosbag", "play", "--loop", "--clock", "--quiet", "--delay=1", "--rate=4", file});
  ASSERT_TRUE(waitFor([&] { return resets >= 3; }, 60.0));

  // In every loop the same sweeps, each of one pass, none of the end of a loop and the beginning of the next.
  std::set<std::uint64_t> whole;
  for (const auto& image : images) {
    EXPECT_LE(image->height, 83U);
    if (image->height > 76) whole.insert(image->header.stamp.toNSec());
    for (std::size_t r = 0; r < image->height; ++r) {
      EXPECT_NEAR(image->tilts[r], player.tilt(image->row_stamps[r].toSec() + 0.0075), 1e-3);
    }
  }
  EXPECT_EQ(whole.size(), 3U);
  for (const auto& [stamp, counts] : polygons) {
    if (whole.count(stamp) == 0) continue;
    EXPECT_GE(counts.size(), 2U);
    for (const std::size_t count : counts) EXPECT_EQ(count, counts.front());
    EXPECT_GE(counts.front(), 3U);
  }

  // During play: more points than an image has; no region is that large.
  Program tune({"rosrun", "dynamic_reconfigure", "dynparam", "set", "/ppc", "min_size", "900000"});
  EXPECT_EQ(tune.wait(), 0);
  ASSERT_TRUE(waitFor([&] { return !statistics.empty() && statistics.back()->polygons == 0; }, 20.0));
  Program tune_back({"rosrun", "dynamic_reconfigure", "dynparam", "set", "/ppc", "min_size", "0"});
  EXPECT_EQ(tune_back.wait(), 0);
  ASSERT_TRUE(waitFor([&] { return statistics.back()->polygons >= 3; }, 20.0));
  Program patches({"rosrun", "dynamic_reconfigure", "dynparam", "set", "/ppc", "patch_size", "9"});
  EXPECT_EQ(patches.wait(), 0);
  int in_force = 0;
  EXPECT_TRUE(ros::param::get("/ppc/patch_size", in_force));
  EXPECT_EQ(in_force, 9);
  const std::size_t before = statistics.size();
  ASSERT_TRUE(waitFor([&] { return statistics.size() >= before + 4; }, 20.0));
  EXPECT_GE(statistics.back()->polygons, 3U);  // the walls are still there

  // The manager dies at work: it comes back, and finds the recording, which goes on meanwhile.
  const NodeletManager manager("/manager");
  const int process = manager.process();
  ASSERT_GT(process, 1);
  ASSERT_EQ(kill(process, SIGKILL), 0);
  ASSERT_TRUE(waitFor([&] { return manager.process() > 1 && manager.process() != process; }, 40.0));
  images.clear();
  statistics.clear();
  ASSERT_TRUE(waitFor([&] { return images.size() >= 3 && !statistics.empty() && statistics.back()->polygons >= 3; }, 60.0));
  for (const auto& image : images) {
    // A driver that starts shortly before a turning point keeps the lines before it: six are within the hysteresis there.
    EXPECT_LE(image->height, 89U);
    for (std::size_t r = 0; r < image->height; ++r) {
      EXPECT_NEAR(image->tilts[r], player.tilt(image->row_stamps[r].toSec() + 0.0075), 1e-3);
    }
  }
  std::remove(file.c_str());
}

}  // namespace
}  // namespace ppc

int main(int argc, char** argv) { return ppc::runRosTests(argc, argv, "test_playback"); }
