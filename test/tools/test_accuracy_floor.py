#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds PPC's accuracy on a few simulated images: no condition may lose more than .02 of what was measured. (All scores:
doc/accuracy.md.) Usage: test_accuracy_floor.py PPC_EXECUTABLE"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

PPC = sys.argv.pop(1)
IMAGES = [("office", 201), ("curved", 202)]
# Condition: options of ppc simulate, and what was measured: mean F1, mean IoU, and both of the labels rendered from the polygons.
CONDITIONS = {
    "UTM-30LX x1": (["--noise", 1], (0.989, 0.968, 0.989, 0.957)),
    "UTM-30LX x4": (["--noise", 4], (0.948, 0.931, 0.948, 0.922)),
    "URG-04LX": (["--sensor", "urg_04lx"], (0.972, 0.952, 0.972, 0.941)),
    "UTM-30LX realistic": (["--realistic"], (0.958, 0.941, 0.958, 0.927)),
}
SLACK = 0.02


def ppc(*arguments):
    run = subprocess.run([PPC, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=300)
    if run.returncode != 0:
        raise RuntimeError(run.stderr)
    return run.stdout


class AccuracyFloor(unittest.TestCase):
    def scores(self, options):
        found = []
        with tempfile.TemporaryDirectory() as name:
            cloud, truth, labels, polygons = (pathlib.Path(name) / n for n in ("c.pcd", "t.png", "l.png", "p.json"))
            for scene, seed in IMAGES:
                ppc("simulate", "--scene", scene, "--seed", seed, "--truth-pieces", "--pcd", cloud, "--truth", truth, *options)
                ppc("segment", cloud, "--labels", labels, "--polygons", polygons)
                line = json.loads(ppc("evaluate", "--truth", truth, "--labels", labels, "--cloud", cloud, "--polygons", polygons))
                rendered = line["from_polygons"]
                self.assertEqual(rendered["invalid"], 0)
                found.append((line["f1"], line["mean_iou"], rendered["f1"], rendered["mean_iou"]))
        return [sum(values) / len(found) for values in zip(*found)]

    def test_no_condition_loses_more_than_two_points(self):
        for condition, (options, measured) in CONDITIONS.items():
            with self.subTest(condition):
                scores = self.scores(options)
                print(condition, ", ".join(f"{score:.3f}" for score in scores))
                for name, score, floor in zip(("F1", "IoU", "F1 of polygons", "IoU of polygons"), scores, measured):
                    self.assertGreaterEqual(score, floor - SLACK, f"{name}: was {floor}")


if __name__ == "__main__":
    unittest.main()
