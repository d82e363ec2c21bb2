#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The README's tables against the code: every parameter, topic, launch file and subcommand is named, and none that is not there."""
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text()


def section(title):
    return README.split(f"\n### patch_plane_clustering/{title}\n")[1].split("\n## ")[0].split("\n### ")[0]


def documented(title, header):
    """Names in the first column of the tables of a section whose first column is headed so."""
    names = set()
    for table in re.findall(r"(?:^\|.*\n)+", section(title), re.MULTILINE):
        rows = table.splitlines()
        if rows[0].split("|")[1].strip().startswith(header):
            for row in rows[2:]:
                names |= set(re.findall(r"`([^`]+)`", row.split("|")[1]))
    return names


def named_in_code(pattern, *files):
    return {name for file in files for name in re.findall(pattern, (ROOT / file).read_text())}


READS = r'(?:\.get\w+|\.expect|readVector)\((?:reader, )?"(\w+)"'


class Readme(unittest.TestCase):
    maxDiff = None

    def test_driver_parameters(self):
        self.assertEqual(documented("TiltScanDriver", "parameter"), named_in_code(READS, "src/ros/driver_options.cpp"))

    def test_plane_clustering_parameters(self):
        code = named_in_code(r'gen\.add\("(\w+)"', "config/PatchPlaneClustering.cfg")
        code |= named_in_code(READS, "src/nodelets/patch_plane_clustering.cpp")
        code.remove("diagnostic_period")  # diagnostic_updater's own
        self.assertEqual(documented("PatchPlaneClustering", "parameter"), code)

    def test_simulated_scanner_parameters(self):
        code = named_in_code(READS, "src/ros/simulated_scanner_parameters.cpp")
        code |= named_in_code(r'\{"(\w+)", [\d.]+, &ErrorModel', "src/sim/error_model.cpp")
        self.assertEqual(documented("SimulatedScanner", "parameter"), code)

    def test_topics_and_services(self):
        for title, file in (("TiltScanDriver", "tilt_scan_driver"), ("PatchPlaneClustering", "patch_plane_clustering"),
                            ("SimulatedScanner", "simulated_scanner")):
            code = named_in_code(r'(?:advertise(?:Service)?|subscribe)(?:<[^;]*?>)?\("([\w/]+)"', f"src/nodelets/{file}.cpp")
            self.assertEqual(documented(title, "topic") - {"/diagnostics"}, code, title)

    def test_defaults_of_the_plane_clustering(self):
        rows = re.findall(r"^\| `(\w+)` \| (\S+) \| yes ", section("PatchPlaneClustering"), re.MULTILINE)
        cfg = re.findall(r'gen\.add\("(\w+)",\s*\w+,\s*\d+,\s*"[^"]*",\s*([^\s,)]+)',
                         (ROOT / "config/PatchPlaneClustering.cfg").read_text())
        self.assertEqual({name: value.lower() for name, value in cfg}, dict(rows))

    def test_accuracy_is_what_was_measured(self):
        def rows(text):
            lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if line.startswith("|")]
            return [dict(zip(lines[0], cells)) for cells in lines[2:]]
        measured = {(row["condition"], row["method"]): row
                    for row in rows((ROOT / "doc/accuracy.md").read_text().split("\n## ")[0])}
        shown = rows(README.split("\n## Accuracy\n")[1].split("\n## ")[0])
        self.assertGreaterEqual(len(shown), 5)
        for row in shown:
            self.assertEqual(row, {name: measured[row["condition"], row["method"]][name] for name in row})

    def test_launch_files(self):
        self.assertEqual(set(re.findall(r"^\| `(\w+\.launch)`", README, re.MULTILINE)),
                         {path.name for path in (ROOT / "launch").glob("*.launch")})

    def test_what_it_links_to_is_there(self):
        for target in re.findall(r"\]\((?!http)([^)#]+)\)", README):
            self.assertTrue((ROOT / target).exists(), target)


if __name__ == "__main__":
    unittest.main()
