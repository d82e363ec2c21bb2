#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds PPC's accuracy on a few simulated images: no condition may lose more than .02 of what was measured, find two regions
more on them that are none, or turn its planes by a tenth more. (All scores: doc/accuracy.md.) Usage: test_accuracy_floor.py
PPC_EXECUTABLE"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

PPC = sys.argv.pop(1)
IMAGES = [("office", 201), ("curved", 202)]
NAMES = ("F1", "correct", "IoU", "pixel IoU", "F1 of polygons", "IoU of polygons")
# Condition: options of ppc simulate, and what was measured: means of NAMES, spurious regions, error of normals to a refit's.
CONDITIONS = {
    "UTM-30LX x1": (["--noise", 1], (0.989, 0.978, 0.970, 0.996, 0.989, 0.961), 0, 1.11),
    "UTM-30LX x2": (["--noise", 2], (0.989, 0.978, 0.964, 0.994, 0.989, 0.954), 0, 1.09),
    "UTM-30LX x4": (["--noise", 4], (0.948, 0.957, 0.936, 0.986, 0.948, 0.928), 3, 1.10),
    "URG-04LX": (["--sensor", "urg_04lx"], (0.972, 0.972, 0.956, 0.989, 0.972, 0.945), 1, 0.85),
    "UTM-30LX realistic": (["--realistic"], (0.958, 0.940, 0.943, 0.985, 0.958, 0.927), 1, 0.99),
}
SLACK = 0.02


def ppc(*arguments):
    run = subprocess.run([PPC, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=300)
    if run.returncode != 0:
        raise RuntimeError(run.stderr)
    return run.stdout


class AccuracyFloor(unittest.TestCase):
    def scores(self, options):
        found, spurious, normal, refit = [], 0, 0.0, 0.0
        with tempfile.TemporaryDirectory() as name:
            cloud, truth, planes, labels, polygons = (
                pathlib.Path(name) / n for n in ("c.pcd", "t.png", "t.json", "l.png", "p.json"))
            for scene, seed in IMAGES:
                ppc("simulate", "--scene", scene, "--seed", seed, "--truth-pieces", "--pcd", cloud, "--truth", truth,
                    "--truth-planes", planes, *options)
                ppc("segment", cloud, "--labels", labels, "--polygons", polygons)
                line = json.loads(ppc("evaluate", "--truth", truth, "--labels", labels, "--cloud", cloud, "--polygons",
                                      polygons, "--truth-planes", planes))
                rendered = line["from_polygons"]
                self.assertEqual(rendered["invalid"], 0)
                found.append((line["f1"], line["correct"] / line["true"], line["mean_iou"], line["pixel_iou"],
                              rendered["f1"], rendered["mean_iou"]))
                spurious += line["spurious"]
                normal += line["planes"]["true_normal_error_deg"]
                refit += line["planes"]["refit_normal_error_deg"]
        return [sum(values) / len(found) for values in zip(*found)], spurious, normal / refit

    def test_no_condition_loses_more_than_two_points(self):
        for condition, (options, measured, of_none, ratio) in CONDITIONS.items():
            with self.subTest(condition):
                scores, spurious, turned = self.scores(options)
                print(condition, ", ".join(f"{score:.3f}" for score in scores), f"; {spurious}, {turned:.2f}")
                for name, score, floor in zip(NAMES, scores, measured):
                    self.assertGreaterEqual(score, floor - SLACK, f"{name}: was {floor}")
                self.assertLessEqual(spurious, of_none + 1, f"regions that are none: were {of_none}")
                self.assertLessEqual(turned, 1.1 * ratio, f"normals to refit: was {ratio}")


if __name__ == "__main__":
    unittest.main()
