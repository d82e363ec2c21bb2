// SPDX-License-Identifier: BSD-3-Clause
// A nodelet manager that is killed comes back, and polygons with it.
#include "nodelet_manager.h"
#include "patch_plane_clustering/ros/messages.h"
#include "ros_test_main.h"
#include "wait_for.h"

#include <gtest/gtest.h>
#include <signal.h>

namespace ppc {
namespace {

TEST(Respawn, aKilledManagerComesBackAndSweepsGoOn) {
  ros::NodeHandle nh;
  int sweeps = 0;
  const auto subscriber =
      nh.subscribe<PlanarPolygonArray>("polygons", 10, [&](const auto& m) { sweeps += !m->polygons.empty(); });
  const NodeletManager manager("/manager");
  ASSERT_TRUE(waitFor([&] { return sweeps >= 2; }, 40.0));
  for (int i = 0; i < 2; ++i) {
    // nodelet's loaders notice the death of a manager only once their bond with it is formed.
    waitFor([] { return false; }, 6.0);
    const int process = manager.process();
    ASSERT_GT(process, 1);
    ASSERT_EQ(kill(process, SIGKILL), 0);
    ASSERT_TRUE(waitFor([&] { return manager.process() > 1 && manager.process() != process; }, 30.0));
    sweeps = 0;
    ASSERT_TRUE(waitFor([&] { return sweeps >= 2; }, 30.0)) << "after kill " << i;
  }
}

}  // namespace
}  // namespace ppc

int main(int argc, char** argv) { return ppc::runRosTests(argc, argv, "test_respawn"); }
