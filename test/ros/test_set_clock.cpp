// SPDX-License-Identifier: BSD-3-Clause
// The system's clock is set while the driver runs: by hand, or by NTP on a robot that has no clock of its own.
#include "ros_test_main.h"
#include "scan_player.h"

#include <nodelet/loader.h>
#include <sensor_msgs/point_cloud2_iterator.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <atomic>
#include <ctime>

namespace {

std::atomic<long> clock_set_by{0};  // [s]

}  // namespace

// In place of the C library's, for ROS and for the nodelets, which are in this process.
extern "C" int clock_gettime(clockid_t clock, timespec* time) noexcept {
  const long result = syscall(SYS_clock_gettime, clock, time);
  if (clock == CLOCK_REALTIME) time->tv_sec += clock_set_by;
  return static_cast<int>(result);
}

namespace ppc {
namespace {

constexpr double kStart = 10000.0;
constexpr long kHour = 3600;

double worstPoint(const sensor_msgs::PointCloud2& cloud) {
  double worst = 0.0;
  for (sensor_msgs::PointCloud2ConstIterator<float> p(cloud, "x"); p != p.end(); ++p) {
    if (!std::isnan(p[0])) worst = std::max(worst, offTheWalls(Eigen::Vector3d(p[0], p[1], p[2])));
  }
  return worst;
}

TEST(SetClock, neitherGivesUpTheMountNorKeepsTheDriverFromReporting) {
  const double before = ros::WallTime::now().toSec();
  clock_set_by = kHour;
  ASSERT_NEAR(ros::WallTime::now().toSec() - before, kHour, 60.0);  // the clock can be set
  clock_set_by = 0;

  ScanPlayer player("/rig");
  player.mount.translation() = Eigen::Vector3d(0.05, -0.01, 0.08);
  ros::param::set("/rig/driver/joint_name", "tilt_joint");
  ros::param::set("/rig/driver/base_frame", "rig_base");
  ros::param::set("/rig/driver/mount_timeout", 600.0);
  nodelet::Loader loader(false);
  ASSERT_TRUE(loader.load("/rig/driver", "patch_plane_clustering/TiltScanDriver", {}, {}));
  ASSERT_TRUE(player.connect());
  const auto told = [&](const std::string& part) {
    return waitFor([&] { return player.diagnostics.message.find(part) != std::string::npos; }, 30.0);
  };

  // Forward, while the driver waits for tf to tell where the laser sits on the motor.
  player.play(kStart, kStart + 0.4);
  ASSERT_TRUE(told("waiting for the laser's mount"));
  clock_set_by = kHour;
  player.play(kStart + 0.4, kStart + 1.0);
  player.with_tf = true;
  ASSERT_TRUE(player.connect());
  player.play(kStart + 1.0, kStart + 4.6);
  ASSERT_TRUE(waitFor([&] { return player.clouds.size() >= 2; }));
  for (const auto& cloud : player.clouds) EXPECT_LT(worstPoint(*cloud), 0.002);

  // Back, while a sweep is open; then the laser is unplugged.
  const std::size_t sweeps = player.images.size();
  clock_set_by = -kHour;
  ASSERT_TRUE(told("no scans"));
  ASSERT_TRUE(waitFor([&] { return player.images.size() > sweeps; }, 30.0));  // what had been seen of the open sweep
  EXPECT_NEAR(player.images.back()->height, 24, 4);
  player.play(kStart + 14.6, kStart + 19.0);
  ASSERT_TRUE(waitFor([&] { return player.clouds.size() > sweeps + 2; }));
  for (const auto& cloud : player.clouds) EXPECT_LT(worstPoint(*cloud), 0.002);
}

}  // namespace
}  // namespace ppc

int main(int argc, char** argv) { return ppc::runRosTests(argc, argv, "test_set_clock"); }
