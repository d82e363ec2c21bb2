#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The nodelets and the offline tool make the same bytes of the same recording; so do two runs of either."""
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

import roslib.packages
import rosbag
import rospy
import rostest
from rospy.msg import AnyMsg

PACKAGE = "patch_plane_clustering"
TOPICS = ("range_image", "polygons", "segmented_points")
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
        self.ppc("simulate", "--scene", "corridor", "--sensor", "urg_04lx", "--lines", LINES, "--sweeps", SWEEPS,
                 "--lever-arm", "0", "0.02", "0.08", "--bag", self.bag)

    def ppc(self, *arguments):
        tool = roslib.packages.find_node(PACKAGE, "ppc")[0]
        subprocess.run([tool, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL, timeout=120)

    def offline(self, name):
        """Messages of the tool by topic, in order."""
        out = self.folder / name
        self.ppc("bag", self.bag, out, "--only-new", "--clouds", "--base-frame", "tilt_base", *MOUNT)
        results = {topic: [] for topic in TOPICS}
        with rosbag.Bag(str(out)) as bag:
            for topic, raw, _ in bag.read_messages(topics=["/" + topic for topic in TOPICS], raw=True):
                results[topic[1:]].append(without_seq(raw[1]))
        return results

    def online(self):
        """The same from the nodelets. A sweep is awaited before the next begins: the newest would overtake it."""
        results = {topic: [] for topic in TOPICS}
        subscribers = [rospy.Subscriber(topic, AnyMsg, lambda m, t=topic: results[t].append(without_seq(m._buff)))
                       for topic in TOPICS]
        publishers = {}
        with rosbag.Bag(str(self.bag)) as bag:
            messages = [(t[1:], m) for t, m, _ in bag.read_messages(topics=["/scan", "/joint_states"])]
        for topic, message in messages:
            if topic not in publishers:
                publishers[topic] = rospy.Publisher(topic, type(message), queue_size=1000)
        self.wait_for(lambda: all(p.get_num_connections() for p in list(publishers.values()) + subscribers))
        lines = 0
        for topic, message in messages:
            publishers[topic].publish(message)
            time.sleep(0.004)
            lines += topic == "scan"
            if topic == "scan" and lines % LINES == 0:
                time.sleep(0.5)
        self.wait_for(lambda: all(len(r) >= SWEEPS for r in results.values()))
        for each in subscribers + list(publishers.values()):
            each.unregister()
        return results

    def wait_for(self, done, seconds=30.0):
        end = time.monotonic() + seconds
        while not done() and time.monotonic() < end:
            time.sleep(0.05)
        self.assertTrue(done(), "waited in vain")

    def test_nodelets_and_tool_agree(self):
        offline = self.offline("a.bag")
        self.assertEqual([len(offline[topic]) for topic in TOPICS], [SWEEPS] * len(TOPICS))
        self.assertGreater(min(map(len, offline["polygons"])), 500)  # bytes: it holds polygons
        self.assertEqual(offline, self.offline("b.bag"))
        online = self.online()
        for topic in TOPICS:
            self.assertEqual(len(online[topic]), SWEEPS, topic)
            for sweep, (a, b) in enumerate(zip(online[topic], offline[topic])):
                self.assertEqual(a, b, f"{topic} of sweep {sweep}")


if __name__ == "__main__":
    rospy.init_node("test_same_results")
    rostest.rosrun(PACKAGE, "same_results", SameResults, sys.argv)
