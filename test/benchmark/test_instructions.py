#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Catches a slip of two in speed, whatever the machine is busy with: instructions of one frame, counted by callgrind, as a
multiple of those of the floor (ranges to patch moments and a plane a patch). Argument: the program ppc_count.
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM = sys.argv.pop(1)
POINTS = 40000
# One and a half times what was counted when these lines were written: faster code may lower them.
LARGEST_RATIO = {"countedGrid": 5.5, "countedSegmentation": 86.0, "countedNextSegmentation": 86.0}


def count(folder):
    """Instructions of the counted functions with all that they call, and the program's own summary."""
    profile = pathlib.Path(folder) / "callgrind.out"
    run = subprocess.run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={profile}", "--toggle-collect=counted*",
                          PROGRAM, str(POINTS)], capture_output=True, text=True, timeout=300, check=True)
    report = subprocess.run(["callgrind_annotate", "--inclusive=yes", "--threshold=100", profile], capture_output=True,
                            text=True, timeout=60, check=True)
    found = re.findall(r"^ *([\d,]+) .*:(counted\w+)", report.stdout, re.MULTILINE)
    return {name: int(number.replace(",", "")) for number, name in found}, run.stdout


@unittest.skipUnless(shutil.which("valgrind"), "no valgrind")
class Instructions(unittest.TestCase):
    def test_frame_stays_within_its_multiple_of_the_floor(self):
        with tempfile.TemporaryDirectory() as folder:
            counted, summary = count(folder)
        self.assertRegex(summary, r"\d+ patches of the floor, [1-9]\d* regions, [1-9]\d* polygons")
        floor = counted["countedFloor"]
        # A floor that works too little or too much would make every ratio worthless.
        self.assertGreater(floor, 5 * POINTS)
        self.assertLess(floor, 25 * POINTS)
        for name, largest in LARGEST_RATIO.items():
            print(f"{name}: {counted[name] / 1e6:.1f} million instructions, {counted[name] / floor:.1f} x floor")
            self.assertLess(counted[name] / floor, largest, name)


if __name__ == "__main__":
    unittest.main()
