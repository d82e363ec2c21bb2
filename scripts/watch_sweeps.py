#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Prints one line a sweep about the running nodelets, and draws the newest sweep: the range image beside its planes.

Listens to range_image, segmented_points and statistics in its own namespace. Ends after --sweeps sweeps, or on
SIGINT or SIGTERM; exit status 1 if nothing came within --timeout seconds.
"""
import argparse
import collections
import os
import signal
import statistics
import sys
import threading
import time
import xmlrpc.client

import cv2
import numpy
import rosgraph
import rospy
from patch_plane_clustering.msg import RangeImage, SegmentationStatistics
from sensor_msgs.msg import PointCloud2


class Process:
    """Memory and processor time of a process of this machine, found by the name of a ROS node in it."""

    def __init__(self, node):
        uri = rosgraph.Master(rospy.get_name()).lookupNode(rospy.resolve_name(node))
        self.pid = xmlrpc.client.ServerProxy(uri).getPid(rospy.get_name())[2]

    def resident_megabytes(self):
        with open(f"/proc/{self.pid}/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6

    def cpu_seconds(self):
        with open(f"/proc/{self.pid}/stat") as file:
            fields = file.read().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def processor_ticks():
    """All that the processors have done so far, and what of it the host of a virtual machine took away, in clock ticks."""
    with open("/proc/stat") as file:
        user, nice, system, _idle, _iowait, irq, softirq, steal = map(int, file.readline().split()[1:9])
    return user + nice + system + irq + softirq + steal, steal


def range_picture(image):
    """Near is bright and far is dark, on a logarithmic scale; no measurement is black. Columns run from left to right."""
    ranges = numpy.array(image.ranges, dtype=numpy.float32).reshape(image.height, image.width)
    valid = numpy.isfinite(ranges) & (ranges > 0)
    picture = numpy.zeros(ranges.shape + (3,), numpy.uint8)
    if valid.any():
        low, high = numpy.log(numpy.percentile(ranges[valid], [1, 99]))
        scaled = 1 - (numpy.log(numpy.where(valid, ranges, 1)) - low) / max(high - low, 1e-6)
        picture = cv2.applyColorMap((255 * scaled.clip(0, 1)).astype(numpy.uint8), cv2.COLORMAP_VIRIDIS)
    picture[~valid] = 0
    return picture[:, ::-1]


def plane_picture(cloud):
    """The colours of the segmented cloud, as rviz shows them; grey is no plane, black no measurement."""
    offsets = {field.name: field.offset for field in cloud.fields}
    points = numpy.frombuffer(cloud.data, numpy.dtype({
        "names": ["x", "bgr"], "formats": ["<f4", ("u1", 3)], "offsets": [offsets["x"], offsets["rgb"]],
        "itemsize": cloud.point_step}))
    picture = points["bgr"].copy()
    picture[numpy.isnan(points["x"])] = 0
    return picture.reshape(cloud.height, cloud.width, 3)[:, ::-1]


def sweep_picture(image, cloud, caption):
    """Both pictures side by side, each row as high as the angle it covers, under a caption."""
    pictures = [range_picture(image), plane_picture(cloud)]
    tilt_span = abs(image.tilts[-1] - image.tilts[0]) if image.height > 1 else 0
    bearing_span = abs(image.bearing_increment) * max(image.width - 1, 1)
    width = 900
    height = max(int(round(width * tilt_span / bearing_span)), 60)
    pictures = [cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA if i == 0 else cv2.INTER_NEAREST)
                for i, picture in enumerate(pictures)]
    gap = numpy.full((height, 12, 3), 255, numpy.uint8)
    body = numpy.hstack([pictures[0], gap, pictures[1]])
    head = numpy.full((40, body.shape[1], 3), 255, numpy.uint8)
    cv2.putText(head, caption, (8, 27), cv2.FONT_HERSHEY_SIMPLEX, 0.6, (0, 0, 0), 1, cv2.LINE_AA)
    return numpy.vstack([head, body])


class Watcher:
    def __init__(self, options):
        self.options = options
        self.lock = threading.Condition()
        self.pending = collections.OrderedDict()  # stamp -> what has arrived of the sweep
        self.done = []  # statistics of the sweeps, in order of arrival
        self.memory = []
        self.manager = None
        self.cpu_start = None
        self.kinds = {"range_image": RangeImage, "segmented_points": PointCloud2, "statistics": SegmentationStatistics}
        self.subscribers = {topic: self.subscribe(topic) for topic in self.kinds}
        self.silent = set()  # topics that had a publisher and no connection when last looked at

    def subscribe(self, topic):
        return rospy.Subscriber(topic, self.kinds[topic], self.receive, callback_args=topic)

    def renew_lost(self):
        """Subscribes anew to what is published but was not connected twice in a row: told of one publisher several times
        while it starts, rospy may drop all of its connections to it, and does not try again."""
        published = {name for name, _ in rospy.get_published_topics()}
        silent = {topic for topic, subscriber in self.subscribers.items()
                  if subscriber.resolved_name in published and subscriber.get_num_connections() == 0}
        for topic in silent & self.silent:
            self.subscribers[topic].unregister()
            self.subscribers[topic] = self.subscribe(topic)
        self.silent = silent

    def receive(self, message, topic):
        with self.lock:
            parts = self.pending.setdefault(message.header.stamp, {})
            parts[topic] = message
            if len(parts) == 3:
                self.report(parts)
                for stamp in [stamp for stamp in self.pending if stamp <= message.header.stamp]:
                    del self.pending[stamp]
                self.lock.notify_all()

    def report(self, parts):
        numbers = parts["statistics"]
        if self.manager is None:
            self.manager = Process(self.options.manager)
        memory = self.manager.resident_megabytes()
        if self.cpu_start is None:
            self.cpu_start = self.manager.cpu_seconds()  # from the first sweep's end on
            self.ticks_start = processor_ticks()
        self.done.append(numbers)
        self.memory.append(memory)
        stages = ", ".join(f"{name} {ms:.1f}" for name, ms in zip(numbers.stage_names, numbers.stage_milliseconds))
        line = (f"sweep {len(self.done)}: {numbers.height} x {numbers.width} beams, {numbers.regions} planes, "
                f"{numbers.polygons} polygons, {numbers.planar_points} points -> {numbers.vertices} vertices "
                f"(compression {numbers.compression:.0f})")
        print(f"{line}, {numbers.processor_milliseconds:.1f} ms of one core, polygons {numbers.total_milliseconds:.1f} ms after the image ({stages}), {memory:.0f} MB", flush=True)
        if self.options.picture:
            number = f"-{len(self.done) - 1:04d}" if self.options.keep else ""
            path = number.join(os.path.splitext(self.options.picture))
            cv2.imwrite(path, sweep_picture(parts["range_image"], parts["segmented_points"], line))

    def run(self, deadline):
        """Waits until enough sweeps have come; False if they did not come by the deadline."""
        look = time.monotonic() + 2
        while not rospy.is_shutdown():
            with self.lock:
                if len(self.done) >= (self.options.sweeps or sys.maxsize):
                    break
                self.lock.wait(0.2)
            now = time.monotonic()
            if now > deadline:
                return False
            if now > look:
                look = now + 2
                try:
                    self.renew_lost()
                except OSError:
                    pass  # the master has ended before us
        return True

    def summary(self):
        if not self.done:
            return
        times = [numbers.total_milliseconds for numbers in self.done]
        work = [numbers.processor_milliseconds for numbers in self.done]
        print(f"plane clustering a sweep: fastest {min(work):.1f} ms of one core, median {statistics.median(work):.1f} ms; by the clock, beside "
              f"all else that runs here, polygons came {statistics.median(times):.1f} ms after the image, {max(times):.1f} ms at most")
        ticks, stolen = (now - then for now, then in zip(processor_ticks(), self.ticks_start))
        if stolen > 0.02 * ticks:
            print(f"the host of this virtual machine took away {stolen / ticks:.0%} of the processors meanwhile: times are too long")
        lines = sum(numbers.height for numbers in self.done[1:])
        try:
            cpu = self.manager.cpu_seconds() - self.cpu_start
            if lines and cpu > 0:
                print(f"processor time of the manager: {1e3 * cpu / lines:.2f} ms a line, "
                      f"enough for {lines / cpu:.0f} lines/s on one core (all nodelets together)")
        except OSError:
            pass  # the manager has ended before us
        print(f"resident memory of the manager: {self.memory[0]:.0f} MB after the first sweep, {max(self.memory):.0f} MB at most")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sweeps", type=int, default=0, help="end after so many sweeps; 0: when told to")
    parser.add_argument("--timeout", type=float, default=120, help="seconds of wall time to wait for them")
    parser.add_argument("--manager", default="manager", help="name of the nodelet manager")
    parser.add_argument("--picture", help="PNG file, written anew each sweep")
    parser.add_argument("--keep", action="store_true", help="a picture for each sweep, numbered before the extension")
    options = parser.parse_args(rospy.myargv()[1:])
    deadline = time.monotonic() + options.timeout
    while not rosgraph.is_master_online():  # init_node would wait for ever
        time.sleep(0.1)
        if time.monotonic() > deadline:
            print(f"no ROS master at {os.environ.get('ROS_MASTER_URI')} within {options.timeout:.0f} s", file=sys.stderr)
            return 1
    rospy.init_node("watch_sweeps", anonymous=True)
    signal.signal(signal.SIGTERM, lambda *_: rospy.signal_shutdown("told to end"))
    watcher = Watcher(options)
    in_time = watcher.run(deadline)
    watcher.summary()
    if not in_time or not watcher.done:
        print(f"{len(watcher.done)} of {options.sweeps or 'any'} sweeps came within {options.timeout:.0f} s", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
