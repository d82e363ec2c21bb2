#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The ppc tool as its user meets it: files in, files out, one line for each error. Usage: test_ppc.py PPC_EXECUTABLE"""
import itertools
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

PPC = sys.argv.pop(1)
ROOT = pathlib.Path(__file__).resolve().parents[2]
REAL_DATA = ROOT.parent / "shared" / "data"
ROWS, COLS = 60, 80


def ppc(*arguments):
    command = [PPC, *map(str, arguments)]
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=300)


def wall(rows=ROWS, cols=COLS):
    """Points of a wall 2 m ahead along z, with a window (no measurement) of 10 x 10 pixels in the middle."""
    points = []
    for r in range(rows):
        for c in range(cols):
            hole = abs(r - rows // 2) < 5 and abs(c - cols // 2) < 5
            points.append((math.nan,) * 3 if hole else ((c - cols / 2) * 0.02, (r - rows / 2) * 0.02, 2.0))
    return points


def write_pcd(path, points, rows, cols, data="binary", kind="F", size=4, fields="x y z"):
    header = (f"# .PCD v0.7\nVERSION 0.7\nFIELDS {fields}\n"
              f"SIZE {size} {size} {size}\nTYPE {kind} {kind} {kind}\nCOUNT 1 1 1\n"
              f"WIDTH {cols}\nHEIGHT {rows}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {rows * cols}\nDATA {data}\n")
    if data == "ascii":
        body = "".join("%g %g %g\n" % p for p in points).encode()
    else:
        body = b"".join(struct.pack("<3f" if size == 4 else "<3d", *p) for p in points)
    path.write_bytes(header.encode() + body)


def png_size(path):
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    width, height, depth, colour = struct.unpack(">IIBB", data[16:26])
    return height, width, depth, colour


class WithFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def assert_fails(self, run, *words):
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertEqual(len(run.stderr.splitlines()), 1, run.stderr)
        for word in words:
            self.assertIn(word, run.stderr)


class Segment(WithFolder):
    def setUp(self):
        super().setUp()
        self.cloud = self.folder / "wall.pcd"
        write_pcd(self.cloud, wall(), ROWS, COLS)

    def test_finds_the_wall_and_its_window(self):
        labels, polygons = self.folder / "l.png", self.folder / "p.json"
        run = ppc("segment", self.cloud, "--labels", labels, "--polygons", polygons)
        self.assertEqual(run.returncode, 0, run.stderr)
        statistics = json.loads(run.stdout)
        self.assertEqual((statistics["rows"], statistics["cols"]), (ROWS, COLS))
        self.assertEqual(statistics["valid_points"], ROWS * COLS - 81)
        self.assertEqual(statistics["regions"], 1)
        self.assertEqual(png_size(labels), (ROWS, COLS, 16, 0))

        found = json.loads(polygons.read_text())
        self.assertEqual((found["rows"], found["cols"]), (ROWS, COLS))
        plane = found["planes"][0]
        self.assertEqual(plane["id"], 1)
        for value, expected in zip(plane["normal"] + [plane["d"]], (0, 0, -1, -2)):
            self.assertAlmostEqual(value, expected, delta=1e-3)
        covariance = [plane["covariance"][4 * row:4 * row + 4] for row in range(4)]
        self.assertEqual(len(plane["covariance"]), 16)
        self.assertEqual(covariance, [list(column) for column in zip(*covariance)])
        trace = sum(covariance[k][k] for k in range(4))
        for row in covariance:  # |normal| = 1
            self.assertLess(abs(sum(c * n for c, n in zip(row, plane["normal"]))), 1e-6 * trace)
        for k in range(4):
            self.assertGreaterEqual(covariance[k][k], 0.0)
        self.assertGreater(covariance[3][3], 0.0)
        self.assertEqual(len(plane["holes"]), 1)
        self.assertAlmostEqual(plane["area"], (ROWS * COLS - 81) * 0.02 ** 2, delta=0.04)
        for vertex in plane["outer"] + plane["holes"][0]:
            self.assertAlmostEqual(vertex[2], 2.0, delta=1e-3)
        self.assertNotEqual(plane["outer"][0], plane["outer"][-1])

    def test_reads_ascii_and_double_clouds_alike(self):
        expected = json.loads(ppc("segment", self.cloud).stdout)["planar_points"]
        for name, options in (("ascii.pcd", {"data": "ascii"}), ("double.pcd", {"size": 8})):
            path = self.folder / name
            write_pcd(path, wall(), ROWS, COLS, **options)
            run = ppc("segment", path)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertEqual(json.loads(run.stdout)["planar_points"], expected, name)

    def test_writes_the_same_bytes_twice(self):
        outputs = []
        for name in ("a", "b"):
            files = [self.folder / (name + end) for end in (".png", ".json", ".ply", "-picture.png")]
            run = ppc("segment", self.cloud, "--labels", files[0], "--polygons", files[1], "--mesh", files[2],
                      "--picture", files[3])
            self.assertEqual(run.returncode, 0, run.stderr)
            outputs.append([f.read_bytes() for f in files])
        self.assertEqual(outputs[0], outputs[1])
        self.assertTrue(outputs[0][2].startswith(b"ply\n"))

    def test_mesh_has_the_area_of_the_polygons(self):
        mesh, polygons = self.folder / "m.ply", self.folder / "p.json"
        ppc("segment", self.cloud, "--mesh", mesh, "--polygons", polygons)
        header, body = mesh.read_text().split("end_header\n")
        count = int(header.split("element vertex ")[1].split()[0])
        vertices = [tuple(map(float, line.split()[:3])) for line in body.splitlines()[:count]]
        area = 0.0
        for a, b, c in zip(vertices[::3], vertices[1::3], vertices[2::3]):
            area += abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2
        self.assertAlmostEqual(area, sum(p["area"] for p in json.loads(polygons.read_text())["planes"]), delta=1e-3)

    def test_repeat_reports_the_same_stages(self):
        once = json.loads(ppc("segment", self.cloud).stdout)["stages_ms"]
        median = json.loads(ppc("segment", self.cloud, "--repeat", 3).stdout)["stages_ms"]
        self.assertEqual(list(once), list(median))

    def test_settings_win_over_the_file(self):
        config = self.folder / "c.yaml"
        config.write_text("min_size: 100000\n")
        self.assertEqual(json.loads(ppc("segment", self.cloud, "--config", config).stdout)["regions"], 0)
        run = ppc("segment", self.cloud, "--config", config, "--set", "min_size=100", "--set", "noise_scale=1")
        self.assertEqual(json.loads(run.stdout)["regions"], 1)

    def test_every_file_in_config_is_a_set_of_parameters(self):
        for file in sorted((ROOT / "config").glob("*.yaml")):
            run = ppc("segment", self.cloud, "--config", file)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertEqual(json.loads(run.stdout)["regions"], 1, file.name)

    def test_the_plain_algorithm_has_none_of_the_additions(self):
        stages = json.loads(ppc("segment", self.cloud, "--config", ROOT / "config/ppc_2012.yaml").stdout)["stages_ms"]
        self.assertFalse({"merging", "refinement", "second pass"} & set(stages), stages)

    def test_bad_parameters_are_named(self):
        config = self.folder / "c.yaml"
        self.assert_fails(ppc("segment", self.cloud, "--set", "patch_sise=4"), "patch_sise", "patch_size")
        self.assert_fails(ppc("segment", self.cloud, "--set", "patch_size=1"), "patch_size", "1", "[2, ")
        self.assert_fails(ppc("segment", self.cloud, "--set", "patch_size"), "name=value")
        config.write_text("patch_size: many\n")
        self.assert_fails(ppc("segment", self.cloud, "--config", config), "c.yaml", "patch_size", "many")
        config.write_text("patch_size: [\n")
        self.assert_fails(ppc("segment", self.cloud, "--config", config), "c.yaml")

    def test_bad_files_get_one_line(self):
        whole = self.cloud.read_bytes()
        bad = {name: self.folder / (name + ".pcd") for name in ("empty", "text", "truncated", "huge", "row", "field", "int")}
        bad["empty"].write_bytes(b"")
        bad["text"].write_text("not a cloud\n" * 20)
        bad["truncated"].write_bytes(whole[: len(whole) // 2])
        huge = whole.replace(b"WIDTH 80", b"WIDTH 4000000000").replace(b"POINTS 4800", b"POINTS 240000000000")
        bad["huge"].write_bytes(huge)
        write_pcd(bad["row"], wall(), 1, ROWS * COLS)
        write_pcd(bad["field"], wall(), ROWS, COLS, fields="x y w")
        write_pcd(bad["int"], wall(), ROWS, COLS, kind="I")
        causes = {"empty": "is empty", "text": "PCD", "truncated": "truncated", "huge": "truncated", "row": "not organised",
                  "field": "'z'", "int": "floating-point"}
        for name, path in bad.items():
            with self.subTest(name):
                self.assert_fails(ppc("segment", path, "--labels", self.folder / "l.png"), path.name, causes[name])
        self.assert_fails(ppc("segment", self.folder / "none.pcd"), "none.pcd", "no such file")
        self.assert_fails(ppc("segment", self.folder), "directory")
        self.assertFalse((self.folder / "l.png").exists())

    def test_unwritable_outputs_leave_nothing_behind(self):
        self.assert_fails(ppc("segment", self.cloud, "--labels", self.folder / "none" / "l.png"), "none")
        self.assert_fails(ppc("segment", self.cloud, "--labels", self.folder / "l.nothing"), "l.nothing")
        self.assertEqual([p.name for p in self.folder.iterdir()], ["wall.pcd"])

    def test_every_method_runs(self):
        for method in ("ppc", "region_growing", "pcl_region_growing", "pcl_multi_plane", "ransac"):
            with self.subTest(method):
                run = ppc("segment", self.cloud, "--method", method)
                self.assertEqual(run.returncode, 0, run.stderr)
                self.assertEqual(json.loads(run.stdout)["method"], method)
                self.assertGreater(json.loads(run.stdout)["coverage"], 0.9)


class Simulated(WithFolder):
    """A short simulated recording through every subcommand."""

    def setUp(self):
        super().setUp()
        self.bag, self.cloud, self.truth = (self.folder / n for n in ("s.bag", "s.pcd", "t.png"))
        run = ppc("simulate", "--scene", "corridor", "--sensor", "urg_04lx", "--lines", 80, "--sweeps", 2, "--seed", 5,
                  "--bag", self.bag, "--pcd", self.cloud, "--truth", self.truth, "--truth-planes", self.folder / "tp.json")
        self.assertEqual(run.returncode, 0, run.stderr)

    def test_segments_a_bag_into_numbered_outputs(self):
        run = ppc("segment", self.bag, "--labels", self.folder / "l.png")
        self.assertEqual(run.returncode, 0, run.stderr)
        lines = [json.loads(line) for line in run.stdout.splitlines()]
        self.assertEqual([line["image"] for line in lines], list(range(len(lines))))
        self.assertGreaterEqual(len(lines), 2)
        for line in lines:
            height, width, depth, _ = png_size(self.folder / ("l-%04d.png" % line["image"]))
            self.assertEqual((height, width, depth), (line["rows"], line["cols"], 16))

    def test_bag_adds_its_results_and_keeps_the_rest(self):
        out = self.folder / "out.bag"
        run = ppc("bag", self.bag, out)
        self.assertEqual(run.returncode, 0, run.stderr)
        images = len(run.stdout.splitlines())
        self.assertGreaterEqual(images, 2)
        again = self.folder / "again.bag"
        self.assertEqual(ppc("bag", self.bag, again).returncode, 0)
        only_new = self.folder / "new.bag"
        self.assertEqual(ppc("bag", self.bag, only_new, "--only-new", "--prefix", "/lab").returncode, 0)
        try:
            import rosbag
        except ImportError:
            self.skipTest("no rosbag for Python")
        with rosbag.Bag(str(self.bag)) as before, rosbag.Bag(str(out)) as after, rosbag.Bag(str(only_new)) as new:
            counts = {t: i.message_count for t, i in before.get_type_and_topic_info()[1].items()}
            counts.update({"/range_image": images, "/polygons": images, "/statistics": images})
            self.assertEqual({t: i.message_count for t, i in after.get_type_and_topic_info()[1].items()}, counts)
            with rosbag.Bag(str(again)) as second:  # the same bytes, but for the times in /statistics
                for a, b in itertools.zip_longest(after.read_messages(raw=True), second.read_messages(raw=True)):
                    self.assertEqual((a.topic, a.timestamp), (b.topic, b.timestamp))
                    if a.topic != "/statistics":
                        self.assertEqual(a.message[1], b.message[1], a.topic)
            self.assertEqual(set(new.get_type_and_topic_info()[1]), {"/lab/range_image", "/lab/polygons", "/lab/statistics"})

    def test_bag_errors_get_one_line(self):
        broken = self.folder / "broken.bag"
        broken.write_bytes(self.bag.read_bytes()[:3000])
        out = self.folder / "out.bag"
        self.assert_fails(ppc("bag", broken, out), "broken.bag")
        self.assert_fails(ppc("bag", self.folder / "s-0000.pcd", out), "s-0000.pcd")
        self.assert_fails(ppc("bag", self.bag, out, "--scan", "/nothing"), "/nothing", "/scan")
        self.assert_fails(ppc("bag", self.bag, out, "--joint", "elbow"), "elbow", "tilt_joint")
        self.assert_fails(ppc("bag", self.bag, out, "--scan", "/tf"), "/tf", "TFMessage")
        self.assert_fails(ppc("bag", self.bag, self.bag), "input")
        self.assertFalse([p for p in self.folder.iterdir() if p.name.endswith("out.bag") or p.name.startswith(".")])

    def test_evaluates_labels_and_polygons(self):
        labels, polygons = self.folder / "l.png", self.folder / "p.json"
        cloud, truth = self.folder / "s-0000.pcd", self.folder / "t-0000.png"
        self.assertEqual(ppc("segment", cloud, "--labels", labels, "--polygons", polygons).returncode, 0)
        run = ppc("evaluate", "--truth", truth, "--labels", labels, "--cloud", cloud, "--polygons", polygons)
        self.assertEqual(run.returncode, 0, run.stderr)
        scores = json.loads(run.stdout)
        self.assertEqual(scores["correct"] + scores["spurious"], scores["found"])
        self.assertEqual([point["tolerance"] for point in scores["curve"]], [t / 100 for t in range(51, 96)])
        correct = [point["correct"] for point in scores["curve"]]
        self.assertEqual(correct, sorted(correct, reverse=True))
        self.assertEqual(scores["from_polygons"]["invalid"], 0)
        self.assertGreater(scores["from_polygons"]["mean_iou"], scores["mean_iou"] - 0.1)
        self.assertLess(scores["from_polygons"]["boundary_error"], 0.1)
        self.assertGreater(scores["from_polygons"]["compression"], 50)
        polygon_count = len(json.loads(polygons.read_text())["planes"])
        self.assertEqual(scores["from_polygons"]["polygons"], polygon_count)
        self.assertAlmostEqual(scores["from_polygons"]["vertices_per_polygon"],
                               scores["from_polygons"]["vertices"] / polygon_count)

        perfect = json.loads(ppc("evaluate", "--truth", truth, "--labels", truth).stdout)
        self.assertEqual((perfect["f1"], perfect["mean_iou"], perfect["spurious"]), (1.0, 1.0, 0))

    def test_errors_are_also_against_the_true_planes(self):
        truth, cloud, planes = self.folder / "t-0000.png", self.folder / "s-0000.pcd", self.folder / "tp-0000.json"
        run = ppc("evaluate", "--truth", truth, "--labels", truth, "--cloud", cloud, "--truth-planes", planes)
        errors = json.loads(run.stdout)["planes"]
        # The true labels themselves: what is found is the refit, whose errors are those of the noise.
        self.assertEqual(errors["normal_error_deg"], 0.0)
        self.assertEqual(errors["true_normal_error_deg"], errors["refit_normal_error_deg"])
        self.assertEqual(errors["true_offset_error_mm"], errors["refit_offset_error_mm"])
        self.assertGreater(errors["refit_normal_error_deg"], 0.001)
        self.assertLess(errors["refit_normal_error_deg"], 2.0)
        self.assertLess(errors["refit_offset_error_mm"], 10.0)
        for name in ("median_normalised_error", "within_95"):
            self.assertEqual(errors[name], errors[f"refit_{name}"])
        self.assertGreater(errors["median_normalised_error"], 0.1)
        self.assertLess(errors["median_normalised_error"], 10.0)  # chi-square of three: 2.4
        self.assertGreater(errors["within_95"], 0.5)
        self.assertEqual(ppc("evaluate", "--truth", truth, "--labels", truth, "--truth-planes", planes).returncode, 1)
        self.assertEqual(ppc("evaluate", "--truth", truth, "--labels", truth, "--cloud", cloud, "--truth-planes",
                             cloud).returncode, 1)

    def test_several_images_get_their_mean(self):
        truths = [self.folder / ("t-%04d.png" % i) for i in range(2)]
        run = ppc("evaluate", "--truth", *truths, "--labels", *reversed(truths))
        lines = [json.loads(line) for line in run.stdout.splitlines()]
        self.assertEqual(len(lines), 3)
        self.assertAlmostEqual(lines[2]["f1"], (lines[0]["f1"] + lines[1]["f1"]) / 2)

    def test_evaluate_errors_get_one_line(self):
        other = self.folder / "wall.pcd"
        write_pcd(other, wall(), ROWS, COLS)
        ppc("segment", other, "--labels", self.folder / "small.png")
        truth = self.folder / "t-0000.png"
        run = ppc("evaluate", "--truth", truth, "--labels", self.folder / "small.png")
        self.assertEqual(run.returncode, 1)
        self.assertIn("small.png", run.stderr.splitlines()[-1])
        self.assertEqual(ppc("evaluate", "--truth", truth, "--labels", other).returncode, 1)


@unittest.skipUnless(REAL_DATA.is_dir(), "no real recordings beside the package")
class RealRecordings(WithFolder):
    def test_lever_arm_and_joint_come_from_the_bag(self):
        polygons = self.folder / "p.json"
        run = ppc("segment", REAL_DATA / "cardboard_box.bag", "--polygons", polygons)
        self.assertEqual(run.returncode, 0, run.stderr)
        lines = [json.loads(line) for line in run.stdout.splitlines()]
        self.assertEqual([line["rows"] > 700 for line in lines], [True, True])
        self.assertEqual(json.loads((self.folder / "p-0000.json").read_text())["frame_id"], "tilt_base")
        given = ppc("segment", REAL_DATA / "cardboard_box.bag", "--lever-arm", 0, 0, 0.08)
        for found, expected in zip(lines, map(json.loads, given.stdout.splitlines())):
            self.assertAlmostEqual(found["coverage"], expected["coverage"], delta=0.02)


if __name__ == "__main__":
    unittest.main(verbosity=2)
