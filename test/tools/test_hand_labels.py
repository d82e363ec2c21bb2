#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""PPC on real recordings: against planes drawn by hand (test/data/hand_labels.json), and each sweep against the next, which runs
the other way. Floors are what was measured at best, less .02. Usage: test_hand_labels.py PPC_EXECUTABLE"""
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

PPC = sys.argv.pop(1)
ROOT = pathlib.Path(__file__).resolve().parents[2]
REAL_DATA = ROOT.parent / "shared" / "data"
FRAMES = json.loads((ROOT / "test/data/hand_labels.json").read_text())["frames"]
F1_FLOOR = {"cardboard_box.bag": 1.0 - 0.02, "bottle.bag": 0.889 - 0.02, "room_scan1.pcd": 0.571 - 0.02}
IOU_FLOOR = {"cardboard_box.bag": 0.964 - 0.02, "bottle.bag": 0.971 - 0.02, "room_scan1.pcd": 0.787 - 0.02}
STILL = {"cardboard_box.bag": 0.85, "bottle.bag": 0.85}  # label IoU of one sweep against the other


def ppc(*arguments):
    run = subprocess.run([PPC, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=300)
    if run.returncode != 0:
        raise RuntimeError(run.stderr)
    return [json.loads(line) for line in run.stdout.splitlines()]


def render(frame):
    """Rows of labels: each polygon filled by even-odd runs along the rows, in order."""
    image = [[0] * frame["cols"] for _ in range(frame["rows"])]
    for region in frame["regions"]:
        ring = region["polygon"]
        for r, row in enumerate(image):
            crossings = sorted(x0 + (r - y0) / (y1 - y0) * (x1 - x0)
                               for (x0, y0), (x1, y1) in zip(ring, ring[1:] + ring[:1]) if (y0 <= r) != (y1 <= r))
            for begin, end in zip(crossings[::2], crossings[1::2]):
                for c in range(max(0, math.ceil(begin)), min(frame["cols"], math.ceil(end))):
                    row[c] = region["id"]
    return image


def write_png(path, image):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + struct.pack(f">{len(row)}H", *row) for row in image)
    header = struct.pack(">IIBBBBB", len(image[0]), len(image), 16, 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b""))


def read_png(path):
    """Rows of a 16-bit grey picture."""
    data = path.read_bytes()
    at, packed, size = 8, b"", None
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        size = struct.unpack(">II", body[:8]) if kind == b"IHDR" else size
        packed += body if kind == b"IDAT" else b""
        at += 12 + length
    width, height = size
    raw, line, rows = zlib.decompress(packed), bytearray(2 * width), []
    for r in range(height):
        start = r * (2 * width + 1)
        kind, row = raw[start], bytearray(raw[start + 1:start + 1 + 2 * width])
        for i in range(2 * width):
            left, up, corner = (row[i - 2] if i > 1 else 0), line[i], (line[i - 2] if i > 1 else 0)
            if kind == 4:
                guess = left + up - corner
                near = min((abs(guess - left), 0, left), (abs(guess - up), 1, up), (abs(guess - corner), 2, corner))[2]
            else:
                near = (0, left, up, (left + up) // 2)[kind]
            row[i] = (row[i] + near) & 255
        rows.append(list(struct.unpack(f">{width}H", row)))
        line = row
    return rows


class Rendering(unittest.TestCase):
    def test_fills_what_is_inside_and_later_ones_lie_over_earlier_ones(self):
        frame = {"rows": 4, "cols": 6, "regions": [{"id": 1, "polygon": [[-1, -1], [4, -1], [4, 4], [-1, 4]]},
                                                   {"id": 0, "polygon": [[1, 1], [3, 1], [3, 3], [1, 3]]}]}
        self.assertEqual(render(frame), [[1, 1, 1, 1, 0, 0], [1, 0, 0, 1, 0, 0], [1, 0, 0, 1, 0, 0], [1, 1, 1, 1, 0, 0]])

    def test_pictures_survive_being_written(self):
        with tempfile.TemporaryDirectory() as name:
            path = pathlib.Path(name) / "p.png"
            image = [[1, 2, 300], [65535, 0, 7]]
            write_png(path, image)
            self.assertEqual(read_png(path), image)


@unittest.skipUnless(REAL_DATA.is_dir(), "no real recordings beside the package")
class RealRecordings(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        for frame in FRAMES:
            stem = pathlib.Path(frame["input"]).stem
            ppc("segment", REAL_DATA / frame["input"], "--labels", cls.folder / f"{stem}.png", "--polygons",
                cls.folder / f"{stem}.json")

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_planes_drawn_by_hand_are_found(self):
        for frame in FRAMES:
            with self.subTest(frame["input"]):
                truth = self.folder / "truth.png"
                write_png(truth, render(frame))
                stem = pathlib.Path(frame["input"]).stem
                labels = self.folder / (f"{stem}-{frame['image']:04d}.png" if frame["input"].endswith(".bag") else f"{stem}.png")
                scores = ppc("evaluate", "--truth", truth, "--labels", labels, "--min-region", frame.get("min_region", 400))[0]
                print(f"{frame['input']}: {scores['true']} planes, F1 {scores['f1']:.3f}, IoU {scores['mean_iou']:.3f}")
                self.assertEqual(scores["true"], len({region["id"] for region in frame["regions"]} - {0}))
                self.assertGreaterEqual(scores["f1"], F1_FLOOR[frame["input"]] - 1e-9)
                self.assertGreaterEqual(scores["mean_iou"], IOU_FLOOR[frame["input"]] - 1e-9)

    def test_a_sweep_up_agrees_with_the_sweep_down(self):
        for name, floor in STILL.items():
            with self.subTest(name):
                self.compare_sweeps(name, floor)

    def compare_sweeps(self, name, floor):
        stem = pathlib.Path(name).stem
        up, down = (read_png(self.folder / f"{stem}-000{i}.png") for i in (0, 1))
        planes = [{p["id"]: p for p in json.loads((self.folder / f"{stem}-000{i}.json").read_text())["planes"]} for i in (0, 1)]
        # Both have rows in ascending tilt over the same span; the numbers of rows differ by one or two.
        common, sizes = {}, [{}, {}]
        for r, row in enumerate(up):
            other = down[min(len(down) - 1, round(r * (len(down) - 1) / (len(up) - 1)))]
            for a, b in zip(row, other):
                common[a, b] = common.get((a, b), 0) + 1
                sizes[0][a] = sizes[0].get(a, 0) + 1
                sizes[1][b] = sizes[1].get(b, 0) + 1
        matched, ious = 0, []
        for a, size in sizes[0].items():
            if a == 0 or size < 5000:  # pieces of clutter come and go
                continue
            iou, b = max((n / (size + sizes[1][b] - n), b) for (x, b), n in common.items() if x == a and b != 0)
            ious.append(iou)
            if iou < 0.5:
                continue
            matched += 1
            first, second = planes[0][a], planes[1][b]
            cosine = sum(x * y for x, y in zip(first["normal"], second["normal"]))
            angle = math.degrees(math.acos(min(1.0, cosine)))
            centre = [sum(p[k] for p in first["outer"]) / len(first["outer"]) for k in range(3)]
            offset = abs(sum(x * y for x, y in zip(second["normal"], centre)) - second["d"])
            print(f"{name} plane {a}: {size} pixels, IoU {iou:.3f}, {angle:.2f} deg, {1000 * offset:.1f} mm")
            self.assertLess(angle, 1.0)
            self.assertLess(offset, 0.01)
        self.assertGreaterEqual(matched, 4)
        self.assertGreaterEqual(sum(ious) / len(ious), floor)


if __name__ == "__main__":
    unittest.main()
