#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Plays bags once somebody listens: rosbag play, for launch files.

A relative path counts from where roslaunch was started (roslaunch starts its nodes elsewhere), and ~ is the home folder.
Other options go to rosbag play.
"""
import argparse
import os
import subprocess
import sys
import time

import rosgraph
import roslib.packages


def find_bag(path):
    """The file that is meant; ends with a message that names it if it cannot be read."""
    folders = [os.getcwd(), os.environ.get("PWD", "")]
    try:
        folders.insert(0, os.readlink(f"/proc/{os.getppid()}/cwd"))  # roslaunch's
    except OSError:
        pass
    for folder in folders:
        candidate = os.path.normpath(os.path.join(folder, os.path.expanduser(path)))
        if os.path.isfile(candidate) and os.access(candidate, os.R_OK):
            return candidate
    sys.exit(f"play_bag: cannot read {path} (looked in {folders[0]})")


def wait_for_subscribers(topics, timeout):
    """Returns when every topic has a subscriber, or after `timeout` seconds of wall time with a warning."""
    master = rosgraph.Master("/play_bag")
    namespace = rosgraph.names.get_ros_namespace() + "play_bag"
    missing = {rosgraph.names.resolve_name(topic, namespace) for topic in topics}
    deadline = time.monotonic() + timeout
    while missing and time.monotonic() < deadline:
        subscribed = master.getSystemState()[1]
        missing -= {topic for topic, nodes in subscribed if nodes}
        time.sleep(0.1)
    if missing:
        print(f"play_bag: nobody listens to {', '.join(sorted(missing))} after {timeout:.0f} s; playing all the same",
              file=sys.stderr)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], allow_abbrev=False)
    parser.add_argument("--wait", metavar="TOPIC", action="append", default=[], help="play when it has a subscriber")
    parser.add_argument("--timeout", type=float, default=60.0, help="longest time to wait [s]")
    parser.add_argument("--repeat", choices=("true", "false"), default="false", help="begin again at the end")
    parser.add_argument("--linger", type=float, default=3.0,
                        help="wait so long after the end: the driver closes an open sweep when it has been idle for a while [s]")
    parser.add_argument("bag", help="bag to play")
    options, rest = parser.parse_known_args()
    bag = find_bag(options.bag)
    players = roslib.packages.find_node("rosbag", "play")
    if not players:
        sys.exit("play_bag: rosbag's play is not installed")
    wait_for_subscribers(options.wait, options.timeout)
    # The delay lets the subscribers connect. roslaunch's own arguments (__name, __log, remappings) are among the rest.
    try:
        status = subprocess.call([players[0], "--delay=1", bag] + rest)
        if status == 0:
            time.sleep(options.linger)
    except KeyboardInterrupt:  # the player has been told as well
        status = 0
    return status


if __name__ == "__main__":
    sys.exit(main())
