#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The nodelets and the offline tool make the same bytes of the same recording, with one thread and with four."""
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

import dynamic_reconfigure.client
import roslib.packages
import rosbag
import rospy
import rostest
from rospy.msg import AnyMsg

PACKAGE = "patch_plane_clustering"
TOPICS = ("range_image", "polygons", "segmented_points")  # the last holds every point's label
LINES, SWEEPS = 60, 3
MOUNT = ("--lever-arm", "0", "0.02", "0.08", "--mount-rpy", "0", "0", "0")


def without_seq(message):
    return message[4:]  # header.seq comes first, and counts differently


class SameResults(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.bag = self.folder / "scans.bag"
        # One pass more than is compared: a sweep ends at the turn that follows it.
        self.ppc("simulate", "--scene", "corridor", "--sensor", "urg_04lx", "--lines", LINES, "--sweeps", SWEEPS + 1,
                 "--lever-arm", "0", "0.02", "0.08", "--bag", self.bag)

    def ppc(self, *arguments):
        tool = roslib.packages.find_node(PACKAGE, "ppc")[0]
        subprocess.run([tool, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL, timeout=120)

    def offline(self, threads):
        """Messages of the tool by topic, in order."""
        out = self.folder / f"{threads}.bag"
        self.ppc("bag", self.bag, out, "--only-new", "--clouds", "--base-frame", "tilt_base", "--set",
                 f"threads={threads}", *MOUNT)
        results = {topic: [] for topic in TOPICS}
        with rosbag.Bag(str(out)) as bag:
            for topic, raw, _ in bag.read_messages(topics=["/" + topic for topic in TOPICS], raw=True):
                results[topic[1:]].append(without_seq(raw[1]))
        return {topic: messages[:SWEEPS] for topic, messages in results.items()}

    def online(self, threads):
        """The same from the nodelets, played by rosbag at four times the speed."""
        client = dynamic_reconfigure.client.Client("/ppc", timeout=30)
        self.assertEqual(client.update_configuration({"threads": threads})["threads"], threads)
        client.close()
        results = {topic: [] for topic in TOPICS}
        subscribers = [rospy.Subscriber(topic, AnyMsg, lambda m, t=topic: results[t].append(without_seq(m._buff)))
                       for topic in TOPICS]
        self.wait_for(lambda: all(each.get_num_connections() for each in subscribers))
        player = roslib.packages.find_node("rosbag", "play")[0]
        subprocess.run([player, "--quiet", "--wait-for-subscribers", "--rate", "4", "--topics", "/scan", "/joint_states",
                        "--bags", str(self.bag)], check=True, stdin=subprocess.DEVNULL, timeout=60)
        self.wait_for(lambda: all(len(r) >= SWEEPS for r in results.values()))
        for each in subscribers:
            each.unregister()
        return results

    def wait_for(self, done, seconds=30.0):
        end = time.monotonic() + seconds
        while not done() and time.monotonic() < end:
            time.sleep(0.05)
        self.assertTrue(done(), "waited in vain")

    def test_nodelets_and_tool_agree(self):
        offline = self.offline(1)
        self.assertEqual([len(offline[topic]) for topic in TOPICS], [SWEEPS] * len(TOPICS))
        self.assertGreater(min(map(len, offline["polygons"])), 500)  # bytes: it holds polygons
        self.assert_same(self.offline(4), offline, "the tool with 4 threads and with 1")
        self.assert_same(self.online(4), offline, "the nodelets with 4 threads and the tool with 1")

    def assert_same(self, some, others, which):
        for topic in TOPICS:
            self.assertEqual(len(some[topic]), SWEEPS, topic)
            for sweep, (a, b) in enumerate(zip(some[topic], others[topic])):
                if a != b:
                    first = next((i for i, (x, y) in enumerate(zip(a, b)) if x != y), min(len(a), len(b)))
                    self.fail(f"{which}: {topic} of sweep {sweep} differs at byte {first + 4} of {len(a) + 4}")


if __name__ == "__main__":
    rospy.init_node("test_same_results")
    rostest.rosrun(PACKAGE, "same_results", SameResults, sys.argv)
