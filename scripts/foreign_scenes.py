#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Scores segmentation on images of a second simulator, for tilting lasers and other sensors: prints a table.

Boxes, balls and columns, cast by a few lines of numpy that share nothing with the package's own simulator. A tool that is good on
its own scenes alone would show here. Sensors: the tilting lasers that the package is made for (also in rooms of thin faces and
of shallow creases, with errors of all kinds, with lines lost, and with surfaces of more noise than others), small time-of-flight
cameras, structured light at a desk, range cameras, laser scanners of one millimetre, a spinning laser of 32 rings. Each image is
an organised cloud as `ppc segment` reads it. All parameters are the defaults, but where scripts/baselines.yaml has better ones of
other methods for the sensor.
Needs the built package (scripts/build) and what scripts/setup --lint installs.
"""
import argparse
import json
import pathlib
import tempfile

import cv2
import numpy
import yaml

from accuracy import PPC, ROOT, run, segment


def pinhole(rows, cols, width_deg):
    """Unit beams of a camera, rows x cols x 3: x right, y down, z forward."""
    focal = cols / 2 / numpy.tan(numpy.radians(width_deg) / 2)
    u, v = numpy.meshgrid(numpy.arange(cols) - cols / 2 + 0.5, numpy.arange(rows) - rows / 2 + 0.5)
    beams = numpy.stack([u / focal, v / focal, numpy.ones_like(u)], -1)
    return beams / numpy.linalg.norm(beams, axis=-1, keepdims=True)


def spherical(rows, cols, width_deg, height_deg):
    """Unit beams of a scanner with equal steps of bearing and elevation."""
    bearing, elevation = numpy.meshgrid(numpy.radians(numpy.linspace(-width_deg / 2, width_deg / 2, cols)),
                                        numpy.radians(numpy.linspace(-height_deg / 2, height_deg / 2, rows)))
    return numpy.stack([numpy.sin(bearing) * numpy.cos(elevation), numpy.sin(elevation),
                        numpy.cos(bearing) * numpy.cos(elevation)], -1)


def tilting(cols, width_deg, lines=300, tilt_deg=60):
    """Unit beams of a laser whose scan plane tilts up and down about an axis across."""
    bearing, tilt = numpy.meshgrid(numpy.radians(numpy.linspace(-width_deg / 2, width_deg / 2, cols)),
                                   numpy.radians(numpy.linspace(-tilt_deg, tilt_deg, lines)))
    return numpy.stack([numpy.sin(bearing), numpy.cos(bearing) * numpy.sin(tilt), numpy.cos(bearing) * numpy.cos(tilt)], -1)


def lose_lines(share, beams, rng):
    """The beams of those lines that are left if others get lost, as on a busy bus."""
    return beams[rng.random(len(beams)) >= share]


def turn(axis, angle):
    return cv2.Rodrigues(numpy.asarray(axis, float) / numpy.linalg.norm(axis) * angle)[0]


class Scene:
    """Nearest ranges, and labels that count every face of every box; curved things have label 0."""

    def __init__(self, beams):
        self.beams = beams
        self.ranges = numpy.full(beams.shape[:2], numpy.inf)
        self.labels = numpy.zeros(beams.shape[:2], int)
        self.cosines = numpy.ones(beams.shape[:2])  # of incidence
        self.faces = 0

    def _put(self, seen, ranges, labels, cosines):
        seen = seen & (ranges > 1e-3) & (ranges < self.ranges)
        for target, values in ((self.ranges, ranges), (self.labels, labels), (self.cosines, cosines)):
            target[seen] = numpy.broadcast_to(values, seen.shape)[seen]

    def box(self, center, half, rotation, seen_from_inside=False):
        origin, along = -rotation.T @ numpy.asarray(center), self.beams @ rotation
        with numpy.errstate(divide='ignore', invalid='ignore'):
            one, other = (-half - origin) / along, (half - origin) / along
        near, far = numpy.minimum(one, other), numpy.maximum(one, other)
        enters, leaves = near.max(-1), far.min(-1)
        axis = far.argmin(-1) if seen_from_inside else near.argmax(-1)
        direction = numpy.take_along_axis(along, axis[..., None], -1)[..., 0]
        self._put(leaves >= enters, leaves if seen_from_inside else enters,
                  self.faces + 1 + 2 * axis + (direction > 0), abs(direction))
        self.faces += 6

    def ball(self, center, radius):
        middle = (self.beams * center).sum(-1)
        square = middle ** 2 - (numpy.dot(center, center) - radius ** 2)
        self._put(square > 0, middle - numpy.sqrt(numpy.maximum(square, 0)), 0, 0.7)

    def column(self, center, radius, half_height):
        x, z = self.beams[..., 0], self.beams[..., 2]
        a, b = x ** 2 + z ** 2, x * center[0] + z * center[2]
        square = b ** 2 - a * (center[0] ** 2 + center[2] ** 2 - radius ** 2)
        ranges = (b - numpy.sqrt(numpy.maximum(square, 0))) / a
        inside = abs(ranges * self.beams[..., 1] - center[1]) < half_height
        self._put((square > 0) & inside, ranges, 0, 0.7)


UP = (0, 1, 0)


def desk(beams, rng):
    """Blocks of 4 to 18 cm on a table 1.2 m away."""
    scene, tilt, middle = Scene(beams), turn((1, 0, 0), 0.9), numpy.array([0, 0, 1.2])
    scene.box(middle + tilt @ numpy.array([0, 1.0, 0]), numpy.array([3, 1.0, 3]), tilt)
    for _ in range(rng.integers(4, 8)):
        half = rng.uniform(0.02, 0.09, 3)
        rotation = tilt @ turn(UP, rng.uniform(0, 3))
        if rng.random() < 0.4:
            rotation = rotation @ turn(rng.normal(size=3), rng.uniform(0, 0.6))
        scene.box(middle + tilt @ numpy.array([rng.uniform(-0.3, 0.3), -0.9 * half[1], rng.uniform(-0.25, 0.3)]), half, rotation)
    return scene


def room(beams, rng, boxes=10):
    """A room of up to 8 x 10 m with boxes, three balls and two columns."""
    scene, floor = Scene(beams), 1.2
    scene.box((0, -0.1, 1), numpy.array([rng.uniform(2, 4), 1.3, rng.uniform(2.5, 5)]), turn(UP, rng.uniform(-0.4, 0.4)), True)
    for _ in range(boxes):
        half = rng.uniform(0.08, 0.5, 3)
        scene.box((rng.uniform(-2, 2), floor - half[1], rng.uniform(1.2, 4)), half, turn(UP, rng.uniform(0, 3)))
    for _ in range(3):
        radius = rng.uniform(0.1, 0.3)
        scene.ball((rng.uniform(-1.5, 1.5), floor - radius, rng.uniform(1.2, 3)), radius)
    for _ in range(2):
        scene.column((rng.uniform(-2, 2), 0.2, rng.uniform(1.5, 4)), rng.uniform(0.1, 0.3), 1.0)
    return scene


def ramps(beams, rng):
    """Shallow creases: a room with a ramp of 3 to 8 degrees on its floor, doors ajar by 2 to 7 degrees, a few boxes."""
    scene, floor, here = Scene(beams), rng.uniform(0.6, 1.3), turn(UP, rng.uniform(-0.4, 0.4))
    width, depth = rng.uniform(1.8, 3.5), rng.uniform(5, 8)
    scene.box(here @ numpy.array([0, floor - 1.4, depth - 2]), numpy.array([width, 1.4, depth]), here, True)
    foot, length = here @ numpy.array([rng.uniform(-0.4, 0.4) * width, floor, rng.uniform(1.2, 2.5)]), rng.uniform(2.5, 4.5)
    slope, thick = here @ turn((1, 0, 0), numpy.radians(rng.uniform(3, 8))), 0.2 * length
    scene.box(foot + slope @ numpy.array([0, thick, length / 2]), numpy.array([rng.uniform(0.6, 1), thick, length / 2]), slope)
    for side in (-1, 1):
        hinge, ajar = here @ numpy.array([side * width, floor - 1.05, rng.uniform(1, 4)]), numpy.radians(rng.uniform(2, 7))
        leaf = here @ turn(UP, -side * ajar)
        scene.box(hinge + leaf @ numpy.array([side * 0.02, 0, 0.45]), numpy.array([0.02, 1.04, 0.45]), leaf)
    for _ in range(4):
        half = rng.uniform(0.15, 0.4, 3)
        scene.box(here @ numpy.array([rng.choice([-1, 1]) * rng.uniform(0.5, 0.9) * width, floor - half[1], rng.uniform(2, 6)]), half,
                  turn(UP, rng.uniform(0, 3)))
    return scene


def furnished(beams, rng):
    """Thin faces: a room with pillars, a beam below the ceiling, a cupboard, a table on legs, a door ajar, boxes upright and tilted."""
    scene, floor, height, here = Scene(beams), 1.1, 1.3, turn(UP, rng.uniform(-0.5, 0.5))
    width, depth = rng.uniform(2, 4), rng.uniform(2.5, 5)

    def at(x, y, z):
        return numpy.array([0, -0.2, 1]) + here @ numpy.array([x, y + 0.2, z])

    scene.box(at(0, -0.2, 0), numpy.array([width, height, depth]), here, True)
    for _ in range(3):
        half = rng.uniform(0.1, 0.3)
        scene.box(at(rng.choice([-1, 1]) * (width - half), -0.2, rng.uniform(-0.6, 0.9) * depth),
                  numpy.array([half, height, rng.uniform(0.1, 0.5)]), here)
    scene.box(at(0, -1.4, rng.uniform(0.1, 0.8) * depth), numpy.array([width, 0.12, 0.12]), here)
    scene.box(at(rng.uniform(-0.5, 0.5) * width, floor - 0.4, 0.9 * depth), numpy.array([0.5, 0.4, 0.3]), here)
    table = at(rng.uniform(-0.4, 0.4) * width, floor - 0.75, rng.uniform(0.3, 0.6) * depth)
    turned = here @ turn(UP, rng.uniform(0, 3))
    scene.box(table, numpy.array([0.7, 0.02, 0.4]), turned)
    for x, z in ((-0.65, -0.35), (-0.65, 0.35), (0.65, -0.35), (0.65, 0.35)):
        scene.box(table + turned @ numpy.array([x, 0.38, z]), numpy.array([0.03, 0.36, 0.03]), turned)
    scene.box(at(0.3 - width, 0, rng.uniform(-0.2, 0.5) * depth), numpy.array([0.45, 1.1, 0.02]),
              here @ turn(UP, rng.uniform(-0.6, 0.6)))
    for _ in range(14):
        half, rotation = rng.uniform(0.06, 0.5, 3), here @ turn(UP, rng.uniform(0, 3))
        if rng.random() < 0.3:
            rotation = rotation @ turn(rng.normal(size=3), rng.uniform(0, 0.5))
        center = at(rng.uniform(-0.8, 0.8) * width, floor - half[1] * rng.uniform(0.5, 1.5), rng.uniform(0.2, 0.95) * depth)
        if numpy.linalg.norm(center) > 0.9 + numpy.linalg.norm(half):  # does not hide all the rest
            scene.box(center, half, rotation)
    for _ in range(3):
        radius = rng.uniform(0.1, 0.3)
        scene.ball(at(rng.uniform(-0.6, 0.6) * width, floor - radius, rng.uniform(0.3, 0.8) * depth), radius)
    for _ in range(2):
        scene.column(at(rng.uniform(-0.6, 0.6) * width, 0.2, rng.uniform(0.4, 0.8) * depth), rng.uniform(0.08, 0.25), 1.0)
    return scene


def white(sigma, grid=0.0):
    def spoil(scene, rng):
        ranges = scene.ranges + rng.normal(size=scene.ranges.shape) * sigma
        return numpy.round(ranges / grid) * grid if grid else ranges
    return spoil


def urg(scene, rng):
    """Noise of 10 mm up to 1 m, then 1 % of the range; none beyond 4.095 m, as the sensor's driver has it."""
    ranges = scene.ranges + rng.normal(size=scene.ranges.shape) * numpy.maximum(0.01, 0.01 * scene.ranges)
    return numpy.where(ranges > 4.095, numpy.nan, numpy.round(ranges, 3))


def all_errors(scene, rng):
    """10 mm of noise that beams side by side share, steps of 10 mm, faces off by up to 6 mm and by as much at grazing beams,
    points between two surfaces at edges, a beam in 30 lost, one in 500 anywhere, no grazing return."""
    ranges, beside = scene.ranges.copy(), numpy.roll(scene.ranges, -1, 1)
    mixed = (abs(beside - ranges) > 0.05) & (rng.random(ranges.shape) < 0.5)
    share = rng.random(ranges.shape)[mixed]
    ranges[mixed] = share * ranges[mixed] + (1 - share) * beside[mixed]
    smooth = cv2.GaussianBlur(rng.normal(size=ranges.shape), (0, 0), sigmaX=0.8, sigmaY=1e-6)
    ranges += rng.uniform(-0.006, 0.006, scene.faces + 1)[scene.labels] + 0.006 * (1 - scene.cosines)
    ranges = numpy.round(ranges + 0.01 * smooth / smooth.std(), 2)
    ranges[(scene.cosines < 0.08) | (rng.random(ranges.shape) < 0.03)] = numpy.nan
    stray = rng.random(ranges.shape) < 0.002
    ranges[stray] = rng.uniform(0.2, 8, stray.sum())
    return ranges


def structured_light(scene, rng):
    """Noise of 1.4 mm at 1 m that grows with the square of the depth, smooth over some pixels; depth in steps; no grazing return."""
    depth = scene.ranges * scene.beams[..., 2]
    smooth = cv2.GaussianBlur(rng.normal(size=depth.shape), (0, 0), 1.2)
    depth = depth + 0.0014 * depth ** 2 * smooth / smooth.std()
    step = 0.0028 * depth ** 2
    depth = numpy.round(depth / step) * step
    return numpy.where((scene.cosines < 0.12) | (depth > 6), numpy.nan, depth / scene.beams[..., 2])


def stereo(scene, rng):
    """Disparities of a stereo camera off by 0.06 pixels, alike over a window of some ten pixels, in steps of 1/32: ranges by 26 mm
    at 3 m; no grazing return, none beyond 10 m of depth."""
    product = 425 * 0.05  # focal length [pixels] by the distance of the cameras [m]
    disparity = product / (scene.ranges * scene.beams[..., 2])
    smooth = cv2.GaussianBlur(rng.normal(size=disparity.shape), (0, 0), 3)
    disparity = numpy.round(32 * (disparity + 0.06 * smooth / smooth.std())) / 32
    far = disparity < product / 10  # also those below 0
    return numpy.where((scene.cosines < 0.14) | far, numpy.nan, product / numpy.where(far, 1, disparity) / scene.beams[..., 2])


def dark(factor, spoil):
    """One face of four has so many times the noise."""
    def spoil_more(scene, rng):
        ranges = spoil(scene, rng)
        factors = numpy.where(rng.random(scene.faces + 1) < 0.25, factor, 1.0)
        return numpy.round(scene.ranges + (ranges - scene.ranges) * factors[scene.labels], 3)
    return spoil_more


def strays(share, spoil):
    """So many points lie anywhere up to 8 m. They are on no face, but the truth counts them: no region can have more of a face."""
    def spoil_more(scene, rng):
        ranges = spoil(scene, rng)
        stray = rng.random(ranges.shape) < share
        ranges[stray] = numpy.round(rng.uniform(0.2, 8, stray.sum()), 3)
        return ranges
    return spoil_more


def lines(sigma, spoil):
    """All ranges of a line are off by the same."""
    def spoil_more(scene, rng):
        return numpy.round(spoil(scene, rng) + sigma * rng.normal(size=(scene.ranges.shape[0], 1)), 3)
    return spoil_more


UTM, URG = tilting(1081, 270), tilting(682, 239.8)

# What the sensor sees, how it errs, the smallest true region that counts, and what baselines.yaml calls it.
SENSORS = {
    'tilting UTM-30LX, 10 mm': (lambda rng: room(UTM, rng), white(0.01, 0.001), 400, 'UTM-30LX x1'),
    'tilting UTM-30LX, 20 mm': (lambda rng: room(UTM, rng), white(0.02, 0.001), 400, 'UTM-30LX x2'),
    'tilting UTM-30LX, 40 mm': (lambda rng: room(UTM, rng), white(0.04, 0.001), 400, 'UTM-30LX x4'),
    'tilting URG-04LX, 1 %': (lambda rng: room(URG, rng), urg, 400, 'URG-04LX'),
    'furnished room, tilting UTM-30LX, 10 mm': (lambda rng: furnished(UTM, rng), white(0.01, 0.001), 400, 'UTM-30LX x1'),
    'furnished room, tilting UTM-30LX, all errors': (lambda rng: furnished(UTM, rng), all_errors, 400, 'UTM-30LX realistic'),
    'furnished room, tilting URG-04LX, 1 %': (lambda rng: furnished(URG, rng), urg, 400, 'URG-04LX'),
    'furnished room, tilting UTM-30LX, 10 and 30 mm': (lambda rng: furnished(UTM, rng), dark(3.0, white(0.01)), 400,
                                                       'UTM-30LX x1'),
    'furnished room, tilting URG-04LX, 1 and 2.5 %': (lambda rng: furnished(URG, rng), dark(2.5, urg), 400, 'URG-04LX'),
    'furnished room, tilting UTM-30LX, 10 mm, 5 % strays': (lambda rng: furnished(UTM, rng), strays(0.05, white(0.01, 0.001)), 400,
                                                            'UTM-30LX x1'),
    'furnished room, tilting URG-04LX, 1 %, 5 % strays': (lambda rng: furnished(URG, rng), strays(0.05, urg), 400, 'URG-04LX'),
    'furnished room, tilting UTM-30LX, 10 mm, 20 mm a line': (lambda rng: furnished(UTM, rng), lines(0.02, white(0.01, 0.001)), 400,
                                                              'UTM-30LX x1'),
    'furnished room, tilting URG-04LX, 1 %, 20 mm a line': (lambda rng: furnished(URG, rng), lines(0.02, urg), 400, 'URG-04LX'),
    'furnished room, tilting LMS-200, 10 mm, half of 90 lines lost': (
        lambda rng: furnished(lose_lines(0.5, tilting(541, 180, 90, 45), rng), rng), white(0.01, 0.001), 120, 'UTM-30LX x1'),
    'furnished room, time of flight, 60 x 80 pixels, 10 mm': (lambda rng: furnished(pinhole(60, 80, 60), rng), white(0.01, 0.001),
                                                              60, None),
    'furnished room, time of flight, 144 x 176 pixels, 8 mm': (lambda rng: furnished(pinhole(144, 176, 60), rng), white(0.008, 0.001),
                                                               60, None),
    'structured light at a desk, 1.2 mm': (lambda rng: desk(pinhole(512, 512, 38), rng), white(0.0012, 0.0005), 400, None),
    'range camera, 0.5 mm': (lambda rng: room(pinhole(480, 640, 57), rng), white(0.0005), 400, None),
    'range camera, structured light': (lambda rng: room(pinhole(480, 640, 57), rng), structured_light, 400, None),
    'laser scanner, 1 mm': (lambda rng: room(spherical(300, 720, 180, 110), rng, 14), white(0.001, 0.001), 400, None),
    'spinning laser, 32 rings, 20 mm': (lambda rng: room(spherical(32, 1440, 360, 40), rng, 8), white(0.02), 100, None),
    'ramps and doors ajar, tilting UTM-30LX, 10 mm': (lambda rng: ramps(UTM, rng), white(0.01, 0.001), 400, 'UTM-30LX x1'),
    'ramps and doors ajar, tilting URG-04LX, 1 %': (lambda rng: ramps(URG, rng), urg, 400, 'URG-04LX'),
    'furnished room, stereo camera': (lambda rng: furnished(pinhole(480, 848, 90), rng), stereo, 400, None),
}


def write(stem, scene, ranges):
    """The cloud, and a truth with a label for each connected piece of a face, small ones too: what is found there is not wrong."""
    points = (ranges[..., None] * scene.beams).astype(numpy.float32)
    rows, cols = ranges.shape
    header = ('VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n'
              f'WIDTH {cols}\nHEIGHT {rows}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {rows * cols}\nDATA binary\n')
    stem.with_suffix('.pcd').write_bytes(header.encode() + points.tobytes())
    truth, count = numpy.zeros(ranges.shape, numpy.uint16), 0
    for label in numpy.unique(scene.labels[scene.labels > 0]):
        parts, pieces = cv2.connectedComponents(((scene.labels == label) & numpy.isfinite(ranges)).astype(numpy.uint8),
                                                connectivity=4)
        truth[pieces > 0] = count + pieces[pieces > 0]
        count += parts - 1
    assert count < 65536  # else numbers have come round
    cv2.imwrite(str(stem.with_suffix('.truth.png')), truth)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--seeds', type=int, nargs='+', default=list(range(1000, 1005)))
    parser.add_argument('--methods', nargs='+', default=['ppc', 'region_growing', 'pcl_multi_plane', 'ransac'])
    parser.add_argument('--keep', type=pathlib.Path, help='folder in which clouds, truths and labels are left')
    parser.add_argument('--ppc', default=PPC, type=pathlib.Path, help='the built tool')
    parser.add_argument('--sensors', nargs='+', choices=SENSORS, metavar='SENSOR', help='only these, by their names in the table')
    options = parser.parse_args()
    tuned = yaml.safe_load((ROOT / 'scripts/baselines.yaml').read_text())
    print('| sensor | method | F1 | correct | spurious | IoU | points |\n| --- | --- | --- | --- | --- | --- | --- |')
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for number, (sensor, (look, spoil, smallest, tuned_as)) in enumerate(SENSORS.items()):
            if options.sensors and sensor not in options.sensors:
                continue
            scores = {method: [] for method in options.methods}
            for seed in options.seeds:
                rng = numpy.random.default_rng(seed)
                scene, stem = look(rng), folder / f'{number}_{seed}'
                write(stem, scene, spoil(scene, rng))
                for method in options.methods:
                    labels = stem.with_suffix(f'.{method}.png')
                    values = {k: v for k, v in tuned.get(method, {}).get(tuned_as, {}).items() if k != 'f1'}
                    image = {'cloud.pcd': stem.with_suffix('.pcd'), 'labels.png': labels}
                    found = segment(options.ppc, image, method, values, polygons=False)
                    score = json.loads(run(options.ppc, 'evaluate', '--truth', stem.with_suffix('.truth.png'), '--labels', labels,
                                '--min-region', smallest).splitlines()[0])
                    scores[method].append((score['f1'], score['correct'], score['true'], score['spurious'], score['mean_iou'],
                                           found['coverage']))
            for method, rows in scores.items():
                f1, correct, true, spurious, iou, coverage = numpy.mean(rows, axis=0)
                print(f'| {sensor} | {method} | {f1:.2f} | {100 * correct / true:.0f} % | {spurious:.1f} | {iou:.2f} | '
                      f'{100 * coverage:.0f} % |', flush=True)


if __name__ == '__main__':
    main()
