#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Bad input to the ppc tool: one line that names file and cause, exit status 1, and no output half written.
Usage: test_bad_input.py PPC_EXECUTABLE"""
import json
import math
import os
import random
import resource
import signal
import struct
import subprocess
import unittest
import zlib

import rosbag
import rospy
from std_msgs.msg import String

from test_ppc import COLS, PPC, ROWS, WithFolder, ppc, wall, write_pcd


def ppc_on_a_full_disk(limit, *arguments):
    """As if the disk were full after so many bytes of each file."""
    def limited():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    return subprocess.run([PPC, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=300,
                          preexec_fn=limited)


class Clouds(WithFolder):
    def setUp(self):
        super().setUp()
        self.cloud = self.folder / "wall.pcd"
        write_pcd(self.cloud, wall(), ROWS, COLS)

    def refused(self, name, content, *words):
        path = self.folder / name
        path.write_bytes(content)
        with self.subTest(name):
            self.assert_fails(ppc("segment", path), name, *words)

    def test_headers_that_lie(self):
        whole = self.cloud.read_bytes()
        self.refused("no_width.pcd", whole.replace(b"WIDTH 80\n", b""), "PCD")
        self.refused("zero.pcd", whole.replace(b"WIDTH 80", b"WIDTH 0"), "no points")
        self.refused("negative.pcd", whole.replace(b"HEIGHT 60", b"HEIGHT -60"))
        self.refused("points.pcd", whole.replace(b"POINTS 4800", b"POINTS 4700"))
        self.refused("size.pcd", whole.replace(b"SIZE 4 4 4", b"SIZE 4 -4 4"))
        self.refused("count.pcd", whole.replace(b"COUNT 1 1 1", b"COUNT 1 99999999 1"), "truncated")
        self.refused("nothing_after.pcd", whole.split(b"DATA")[0])
        self.refused("other_data.pcd", whole.replace(b"DATA binary", b"DATA zipped"))

    def test_images_too_large_for_any_scanner(self):
        huge = self.folder / "huge.pcd"
        huge.write_bytes(self.cloud.read_bytes().replace(b"WIDTH 80", b"WIDTH 11000").replace(b"HEIGHT 60", b"HEIGHT 11000")
                         .replace(b"POINTS 4800", b"POINTS 121000000"))
        os.truncate(huge, 1500000000)  # of holes
        self.assert_fails(ppc("segment", huge), "huge.pcd", "more than 100000000 points")

        def part(kind, data):
            return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        labels, picture = self.folder / "l.png", self.folder / "huge.png"
        self.assertEqual(ppc("segment", self.cloud, "--labels", labels).returncode, 0)
        picture.write_bytes(b"\x89PNG\r\n\x1a\n" + part(b"IHDR", struct.pack(">IIBBBBB", 10000, 10001, 8, 0, 0, 0, 0)) +
                            part(b"IDAT", zlib.compress(bytes(10001 * 10001), 1)) + part(b"IEND", b""))
        self.assert_fails(ppc("evaluate", "--truth", picture, "--labels", labels), "huge.png", "larger than any range image")

    def test_what_is_no_file(self):
        os.mkfifo(self.folder / "pipe.pcd")
        self.assert_fails(ppc("segment", self.folder / "pipe.pcd"), "pipe.pcd", "not a regular file")
        self.assert_fails(ppc("segment", "/dev/null"), "/dev/null", "not a regular file")

    def test_unreadable(self):
        self.cloud.chmod(0)
        if os.geteuid() != 0:
            return self.assert_fails(ppc("segment", self.cloud), "wall.pcd", "permission")
        # Root may read everything: the program runs as somebody else, if that somebody may run it.
        self.folder.chmod(0o755)
        nobody = {"user": 65534, "group": 65534, "extra_groups": []}
        try:
            subprocess.run([PPC, "--help"], stdout=subprocess.DEVNULL, check=True, **nobody)
        except (OSError, subprocess.SubprocessError):
            self.skipTest("only root may run the program")
        run = subprocess.run([PPC, "segment", str(self.cloud)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **nobody)
        self.assert_fails(run, "wall.pcd", "permission")

    def test_outputs_with_one_name(self):
        before = self.cloud.read_bytes()
        (self.folder / "link.pcd").symlink_to(self.cloud)
        (self.folder / "hard.pcd").hardlink_to(self.cloud)
        for name in ("wall.pcd", "link.pcd", "hard.pcd", "../" + self.folder.name + "/wall.pcd"):
            with self.subTest(name):
                self.assert_fails(ppc("segment", self.cloud, "--polygons", self.folder / name), name, "is the input")
        config, picture = self.folder / "c.yaml", self.folder / "p.png"
        config.write_text("patch_size: 4\n")
        self.assert_fails(ppc("segment", self.cloud, "--config", config, "--mesh", config), "c.yaml", "is the input")
        self.assert_fails(ppc("segment", self.cloud, "--labels", picture, "--picture", picture), "p.png", "two outputs")
        self.assert_fails(ppc("simulate", "--pcd", picture, "--truth", picture), "p.png", "two outputs")
        self.assertEqual(self.cloud.read_bytes(), before)
        self.assertEqual(config.read_text(), "patch_size: 4\n")
        self.assertFalse(picture.exists())

    def test_standard_output_that_is_full_or_closed(self):
        command = [PPC, "segment", str(self.cloud), "--polygons", str(self.folder / "p.json")]
        with open("/dev/full", "w", encoding="ascii") as full:
            run = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True)
        self.assert_fails(run, "standard output", "disk full")
        # Nobody listens, and the statistics go nowhere: not into the first file that is opened.
        closed = subprocess.run(["sh", "-c", 'exec "$@" <&- >&- 2>&-', "sh"] + command)
        self.assertEqual(closed.returncode, 0)
        self.assertEqual(len(json.loads((self.folder / "p.json").read_text())["planes"]), 1)

    def test_usage_errors_are_one_line(self):
        self.assert_fails(ppc("segmen", self.cloud), "unknown subcommand 'segmen'")
        self.assert_fails(ppc(), "subcommand")
        self.assert_fails(ppc("segment"), "input")
        self.assert_fails(ppc("segment", self.cloud, self.cloud), "wall.pcd")
        self.assert_fails(ppc("segment", self.cloud, "--repeat", "0"), "--repeat", "0", "1 to 100000")
        self.assert_fails(ppc("segment", self.cloud, "--set", "p\u00e4tch_size=4"), "'p\u00e4tch_size'", "patch_size")
        self.assert_fails(ppc("segment", self.cloud, "--set", "patch_size=\uff14"), "'\uff14' is not a whole number in [2, 64]")

    def test_a_viewpoint_is_left_out_and_told(self):
        whole = self.cloud.read_bytes()
        results = []
        for pose in (b"0 0 0 1 0 0 0", b"1 2 3 0.7071 0.7071 0 0", b"nan 0 0 1 0 0 0"):
            self.cloud.write_bytes(whole.replace(b"0 0 0 1 0 0 0", pose))
            run = ppc("segment", self.cloud, "--polygons", self.folder / "p.json")
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertEqual("VIEWPOINT" in run.stderr, bool(results), run.stderr)
            results.append((self.folder / "p.json").read_text())
        self.assertEqual(len(set(results)), 1)

    def test_outputs_that_cannot_be(self):
        os.mkfifo(self.folder / "pipe.json")
        (self.folder / "folder.png").mkdir()
        self.assert_fails(ppc("segment", self.cloud, "--labels", self.folder / "folder.png"), "folder.png", "is a directory")
        self.assert_fails(ppc("segment", self.cloud, "--polygons", self.folder / "pipe.json"), "pipe.json", "not a regular file")
        self.assert_fails(ppc("segment", self.cloud, "--mesh", self.folder / "none" / "m.ply"), "m.ply", "missing")
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["folder.png", "pipe.json", "wall.pcd"])

    def test_a_full_disk_leaves_the_old_output(self):
        for option, name in (("--labels", "l.png"), ("--polygons", "p.json"), ("--mesh", "m.ply"), ("--picture", "p.png")):
            with self.subTest(name):
                path = self.folder / name
                path.write_text("from before")
                self.assert_fails(ppc_on_a_full_disk(40, "segment", self.cloud, option, path), name)
                self.assertEqual(path.read_text(), "from before")
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["l.png", "m.ply", "p.json", "p.png", "wall.pcd"])

    def test_labels_and_polygons_to_evaluate(self):
        labels, polygons = self.folder / "l.png", self.folder / "p.json"
        self.assertEqual(ppc("segment", self.cloud, "--labels", labels, "--polygons", polygons).returncode, 0)
        broken = self.folder / "broken.png"
        broken.write_bytes(labels.read_bytes()[:60])
        self.assert_fails(ppc("evaluate", "--truth", broken, "--labels", labels), "broken.png")
        self.assert_fails(ppc("evaluate", "--truth", labels, "--labels", self.folder), "directory")
        whole = polygons.read_text()
        arguments = ("evaluate", "--truth", labels, "--labels", labels, "--cloud", self.cloud, "--polygons")
        for name, text in (("cut.json", whole[: len(whole) // 2]), ("list.json", "[1, 2]"), ("text.json", "planes"),
                           ("type.json", whole.replace('"rms": ', '"rms": "a", "x": ')),
                           ("number.json", json.dumps({"planes": 3})), ("deep.json", "[" * 100000)):
            with self.subTest(name):
                (self.folder / name).write_text(text)
                self.assert_fails(ppc(*arguments, self.folder / name), name, "not a polygons file")
        small = self.folder / "small.pcd"
        write_pcd(small, wall(10, 10), 10, 10)
        self.assert_fails(ppc("evaluate", "--truth", labels, "--labels", labels, "--cloud", small), "l.png")

    def test_numbers_of_planes_to_evaluate(self):
        labels, polygons = self.folder / "l.png", self.folder / "p.json"
        self.assertEqual(ppc("segment", self.cloud, "--labels", labels, "--polygons", polygons).returncode, 0)
        whole = json.loads(polygons.read_text())["planes"][0]
        ring = whole["outer"]
        far = [[1e300, 0, 0]] + ring[1:]
        both = [("id", 2**31), ("normal", [0, 0, 0]), ("d", 1e300)]
        only_polygons = [("id", 2**64), ("id", 0), ("id", 1.5), ("id", True), ("id", [1]), ("normal", [1e300, 0, 0]),
                         ("normal", [0, 1]), ("normal", ["a", 0, 0]), ("points", 2**31), ("points", -5), ("rms", -1), ("area", -1),
                         ("outer", {"a": 1}), ("outer", far), ("outer", [p[:2] for p in ring]), ("holes", [far])]
        arguments = ("evaluate", "--truth", labels, "--labels", labels, "--cloud", self.cloud)
        bad = self.folder / "bad.json"
        for option, faults, kind in (("--polygons", both + only_polygons, "not a polygons file"),
                                     ("--truth-planes", both, "not a file of planes")):
            for name, value in faults:
                with self.subTest(option=option, name=name, value=str(value)[:40]):
                    bad.write_text(json.dumps({"planes": [whole, {**whole, "id": 2, name: value}]}))
                    self.assert_fails(ppc(*arguments, option, bad), "bad.json", kind, "plane 2: ", name)
            bad.write_text(json.dumps({"planes": [whole, dict(whole, d=whole["d"] - 1.0)]}))
            self.assert_fails(ppc(*arguments, option, bad), "bad.json", kind, "plane 2: id 1")
            bad.write_text('{"planes":' + "[" * 300000 + "]" * 300000 + "}")
            self.assert_fails(ppc(*arguments, option, bad), "bad.json", kind)
        # A region may have several polygons, and a polygon that is none is scored as such.
        bad.write_text(json.dumps({"planes": [whole, dict(whole, outer=ring[:2], holes=[])]}))
        score = json.loads(ppc(*arguments, "--polygons", bad).stdout)["from_polygons"]
        self.assertEqual((score["polygons"], score["invalid"]), (2, 1))

    def test_numbers_of_options(self):
        simulate, segment = ("simulate", "--pcd", self.folder / "s.pcd"), ("segment", self.cloud)
        evaluate = ("evaluate", "--truth", self.cloud, "--labels", self.cloud)
        for arguments, option, values in (
                (simulate, "--noise", ("nan", "1x")), (simulate, "--amplitude", ("1e400",)), (simulate, "--lines", ("99999999999",)),
                (simulate, "--seed", ("-1", "99999999999999999999")), (simulate, "--lever-arm", ("0 0 1e300",)),
                (simulate, "--mount-rpy", ("90 0 0",)), (segment, "--turn-hysteresis", ("nan",)), (segment, "--time-offset", ("inf",)),
                (segment, "--lever-arm", ("0 nan 0",)), (segment, "--mount-rpy", ("0 0 180",)), (evaluate, "--tolerance", ("nan",)),
                (evaluate, "--min-region", ("-5", "99999999999"))):
            for value in values:
                with self.subTest(option=option, value=value):
                    self.assert_fails(ppc(*arguments, option, *value.split()), option)
        self.assertFalse((self.folder / "s.pcd").exists())

    def test_configuration_files(self):
        for name, content in (("empty.yaml", b""), ("binary.yaml", bytes(range(256))), ("list.yaml", b"- 1\n"),
                              ("nested.yaml", b"patch_size: {a: 1}\n"), ("deep.yaml", b"[" * 100000),
                              ("map_as_name.yaml", b"? {a: b}\n: 4\n"), ("loop.yaml", b"a: &a [*a]\n"), ("tab.yaml", b"\tmerge: 1\n")):
            with self.subTest(name):
                (self.folder / name).write_bytes(content)
                self.assert_fails(ppc("segment", self.cloud, "--config", self.folder / name), name)
        for content, words in (("min_size: -5", ("'min_size' = -5", ", 1000000]")), ("refine: maybe", ("'refine' = 'maybe'", "true or false")),
                               ("patch_size: [4]", ("'patch_size' = '[4]'", "[2, 64]")), ("patch_size: ~", ("'patch_size' = '~'", "[2, 64]")),
                               ("sigma_angle: wide", ("'sigma_angle' = 'wide' is not a number in [0.001, 1]",)),
                               ("merge: on\nmerge: off", ("'merge' twice",)), ("ppc: {merge: on}", ("unknown parameter 'ppc'",))):
            with self.subTest(content):
                (self.folder / "c.yaml").write_text(content + "\n")
                self.assert_fails(ppc("segment", self.cloud, "--config", self.folder / "c.yaml"), "c.yaml", *words)
        # What `rosparam load` understands.
        (self.folder / "c.yaml").write_text("# a comment\npatch_size: &k 5\nmin_hole_size: *k\nrefine: Yes\nmerge: TRUE\n'second_pass': off\r\n")
        run = ppc("segment", self.cloud, "--config", self.folder / "c.yaml")
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assert_fails(ppc("segment", self.cloud, "--config", self.folder), "directory")
        self.assert_fails(ppc("segment", self.cloud, "--config", self.folder / "none.yaml"), "none.yaml", "no such file")


class Bags(WithFolder):

    def setUp(self):
        super().setUp()
        self.bag = self.folder / "s.bag"
        run = ppc("simulate", "--scene", "corridor", "--sensor", "urg_04lx", "--lines", 30, "--seed", 5, "--bag", self.bag)
        self.assertEqual(run.returncode, 0, run.stderr)

    def test_what_is_no_bag(self):
        for name, content in (("empty.bag", b""), ("text.bag", b"not a bag\n" * 100), ("head.bag", b"#ROSBAG V2.0\n"),
                              ("old.bag", b"#ROSBAG V1.1\n" + bytes(100)), ("cut.bag", self.bag.read_bytes()[:-3000])):
            with self.subTest(name):
                (self.folder / name).write_bytes(content)
                self.assert_fails(ppc("segment", self.folder / name), name)
                self.assert_fails(ppc("bag", self.folder / name, self.folder / "out.bag"), name)
        self.assert_fails(ppc("bag", self.folder, self.folder / "out.bag"), "directory")
        self.assert_fails(ppc("bag", self.folder / "none.bag", self.folder / "out.bag"), "none.bag", "no such file")
        self.assertFalse((self.folder / "out.bag").exists())

    def packed(self, compression):
        """The bag with its messages in chunks of some kilobytes."""
        path = self.folder / (compression + ".bag")
        with rosbag.Bag(str(self.bag)) as source, rosbag.Bag(str(path), "w", compression=compression, chunk_threshold=20000) as out:
            for topic, message, stamp in source.read_messages():
                out.write(topic, message, stamp)
        return path

    def test_recordings_that_were_not_closed(self):
        running = rosbag.Bag(str(self.folder / "run.bag.active"), "w", chunk_threshold=20000)
        with rosbag.Bag(str(self.bag)) as source:
            for topic, message, stamp in source.read_messages():
                running.write(topic, message, stamp)
        running.flush()
        crashed = self.folder / "run.bag"
        crashed.write_bytes((self.folder / "run.bag.active").read_bytes())
        for name in ("run.bag.active", "run.bag"):
            self.assert_fails(ppc("segment", self.folder / name), name, "not closed by its recorder")
            self.assert_fails(ppc("bag", self.folder / name, self.folder / "out.bag"), name, "not closed by its recorder")
        running.close()
        run = ppc("segment", self.folder / "run.bag.active")  # whatever its name
        self.assertEqual((run.returncode, run.stdout.count('"image":')), (0, 1), run.stderr)

    def test_chunks_that_are_cut_or_damaged(self):
        for compression in ("none", "bz2", "lz4"):
            path = self.packed(compression)
            whole = path.read_bytes()
            self.assertEqual(ppc("segment", path).returncode, 0)
            with rosbag.Bag(str(path)) as bag:
                chunks = [chunk.pos for chunk in bag._chunks]
                entry = bag._connection_indexes[0][len(bag._connection_indexes[0]) // 2]
            self.assertGreater(len(chunks), 3)
            middle = (chunks[1] + chunks[2]) // 2
            damages = [("cut", whole[:middle]), ("zeros", whole[:middle] + bytes(300) + whole[middle + 300:])]
            # Where a message is, by the index behind its chunk.
            stamp = struct.pack("<II", entry.time.secs, entry.time.nsecs)
            at = whole.index(stamp + struct.pack("<I", entry.offset), entry.chunk_pos) + len(stamp)
            for offset in (0xffffffff, 0xfffffff0, 0x7fffffff, 100000, entry.offset + 1):
                damages.append((f"offset {offset}", whole[:at] + struct.pack("<I", offset) + whole[at + 4:]))
            at = whole.index(b"chunk_pos=", chunks[-1]) + 10
            damages.append(("chunk_pos", whole[:at] + struct.pack("<Q", chunks[1] + 1) + whole[at + 8:]))
            for name, content in damages:
                with self.subTest(compression + " " + name):
                    damaged = self.folder / "damaged.bag"
                    damaged.write_bytes(content)
                    self.assert_fails(ppc("bag", damaged, self.folder / "out.bag"), "damaged.bag", "is damaged: the record at byte")
        self.assertFalse((self.folder / "out.bag").exists())

    def test_bag_without_scans(self):
        only_new = self.folder / "new.bag"
        self.assertEqual(ppc("bag", self.bag, only_new, "--only-new").returncode, 0)
        self.assert_fails(ppc("segment", only_new), "new.bag", "sensor_msgs/LaserScan")

    def spoilt(self, name, spoil):
        """The bag with `spoil(n, message)` done to the n-th scan or joint message; it returns the messages to write."""
        path, count = self.folder / name, {}
        with rosbag.Bag(str(self.bag)) as source, rosbag.Bag(str(path), "w") as out:
            for topic, message, stamp in source.read_messages():
                count[topic] = count.get(topic, -1) + 1
                for each in spoil(topic, count[topic], message):
                    out.write(topic, each, stamp)
        return path

    def test_tilt_from_tf_after_the_last_line_judges_a_gap_before_it(self):
        with rosbag.Bag(str(self.bag)) as source:
            end = max(message.header.stamp.to_sec() for _, message, _ in source.read_messages("/scan")) - 0.6

        def cut_off(topic, n, message):
            header = message.transforms[0].header if topic == "/tf" else message.header
            after = header.stamp.to_sec() - end  # of the last line that is kept
            return [] if (after > 0 if topic == "/scan" else abs(after) < 0.06) else [message]
        path = self.spoilt("gap.bag", cut_off)
        rows = []
        for options in ((), ("--tilt-from-tf",)):
            run = ppc("segment", path, *options)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertNotIn("without tilt", run.stderr)
            rows.append([json.loads(line)["rows"] for line in run.stdout.splitlines()])
        self.assertEqual(rows[0], rows[1])

    def test_lines_that_are_left_out_are_told_with_the_cause(self):
        def no_increment(topic, n, message):
            if topic == "/scan" and n % 3 == 0:
                message.angle_increment = math.nan
            return [message]

        def no_limit(topic, n, message):
            if topic == "/scan":
                message.range_max = 0.0
            return [message]

        def incomplete(topic, _, message):
            if topic == "/joint_states":
                message.name = list(message.name) + ["other_joint"]
            return [message]

        def in_words(topic, _, message):
            return [String("a scan")] if topic == "/scan" else [message]

        run = ppc("bag", self.spoilt("increment.bag", no_increment), self.folder / "out.bag", "--only-new", "--min-lines", 5)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("10 bad scan (angle_increment is not finite (nan))", run.stderr)
        self.assert_fails(ppc("segment", self.spoilt("limit.bag", no_limit)), "limit.bag", "no sweep in 30 lines",
                          "30 bad scan (range_max does not exceed range_min, or is NaN (0))")
        self.assert_fails(ppc("segment", self.spoilt("joint.bag", incomplete)), "joint.bag", "no sweep in 30 lines",
                          "as many joint positions as names expected (1 and 2)")
        words = self.spoilt("words.bag", in_words)
        self.assert_fails(ppc("segment", words), "words.bag", "has no sensor_msgs/LaserScan topic")
        self.assert_fails(ppc("segment", words, "--scan", "/scan"), "/scan is of type std_msgs/String")

    def test_sweeps_of_odd_recordings(self):
        def wrapped(topic, _, message):
            if topic == "/joint_states":
                message.position = [math.remainder(message.position[0] + math.pi, 2.0 * math.pi)]
            return [message]

        def fewer_beams(topic, n, message):
            if topic == "/scan" and n >= 15:
                message.ranges = message.ranges[:300]
                message.intensities = message.intensities[:300]
                message.angle_max = message.angle_min + 299 * message.angle_increment
            return [message]

        def far_future(topic, n, message):
            if topic == "/scan" and n % 10 == 5:
                message.header.stamp = rospy.Time(4294967295, 999999999)
            return [message]

        for spoil, sizes in ((wrapped, [(30, 682)]), (fewer_beams, [(15, 682), (15, 300)]), (far_future, [(27, 682)])):
            with self.subTest(spoil.__name__):
                run = ppc("segment", self.spoilt(spoil.__name__ + ".bag", spoil))
                self.assertEqual(run.returncode, 0, run.stderr)
                images = [json.loads(line) for line in run.stdout.splitlines()]
                self.assertEqual([image["cols"] for image in images], [cols for _, cols in sizes])
                for image, (rows, _) in zip(images, sizes):
                    self.assertAlmostEqual(image["rows"], rows, delta=1)

    def test_limits_that_no_sweep_can_keep(self):
        self.assert_fails(ppc("segment", self.bag, "--min-lines", 50, "--max-lines", 30), "--min-lines 50 exceeds --max-lines 30")

    def test_outputs_that_cannot_be(self):
        (self.folder / "folder.bag").mkdir()
        self.assert_fails(ppc("bag", self.bag, self.folder / "folder.bag"), "folder.bag", "is a directory")
        self.assert_fails(ppc("bag", self.bag, self.folder / "none" / "out.bag"), "out.bag", "missing")
        for option, name in (("--bag", "b.bag"), ("--pcd", "c.pcd"), ("--truth", "t.png")):
            self.assert_fails(ppc("simulate", "--lines", 30, option, self.folder / "none" / name), name, "missing")

    def test_a_full_disk_leaves_nothing(self):
        self.assert_fails(ppc_on_a_full_disk(4000, "bag", self.bag, self.folder / "out.bag"), "out.bag", "written")
        for option, name in (("--bag", "b.bag"), ("--pcd", "c.pcd"), ("--truth", "t.png")):
            with self.subTest(name):
                self.assert_fails(ppc_on_a_full_disk(40, "simulate", "--lines", 30, option, self.folder / name), name)
        self.assertEqual([p.name for p in self.folder.iterdir()], ["s.bag"])

    def test_interrupted_it_leaves_nothing(self):
        long = self.folder / "long.bag"
        self.assertEqual(ppc("simulate", "--scene", "box", "--sensor", "urg_04lx", "--lines", 60, "--sweeps", 100, "--bag", long).returncode, 0)
        for end in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            with self.subTest(end):
                run = subprocess.Popen([PPC, "bag", str(long), str(self.folder / "out.bag")], stdout=subprocess.PIPE)
                run.stdout.readline()  # it is at work
                self.assertTrue(list(self.folder.glob(".out.*.tmp.bag")))
                run.send_signal(end)
                run.stdout.close()
                self.assertEqual(run.wait(60), -end)
                self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["long.bag", "s.bag"])

    def test_damaged_bags_end_in_one_line_or_a_whole_result(self):
        whole, chance = self.bag.read_bytes(), random.Random(1)
        out = self.folder / "out.bag"
        refused = 0
        for i in range(20):
            content = bytearray(whole)
            for _ in range(chance.choice((1, 3, 30))):
                # Half of the damage where it hurts: in the headers at the beginning and in the index at the end.
                at = chance.choice((chance.randrange(len(content)), chance.randrange(9000), len(content) - 1 - chance.randrange(9000)))
                content[max(0, at)] = chance.randrange(256)
            damaged = self.folder / "damaged.bag"
            damaged.write_bytes(content)
            run = ppc("bag", damaged, out)
            with self.subTest(i):
                if run.returncode == 0:
                    out.unlink()
                    continue
                refused += 1
                self.assert_fails(run, "damaged.bag")
                self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["damaged.bag", "s.bag"])
        self.assertGreater(refused, 3)


if __name__ == "__main__":
    unittest.main(verbosity=2)
