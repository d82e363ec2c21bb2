#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Searches the parameters of the methods that PPC is compared with, for every condition by itself.

Every combination of the values below is run on simulated scenes of the seeds 1 and 2 (the scores in doc/accuracy.md are from seeds
from 101 on). The best mean F1 wins; the results go to scripts/baselines.yaml, which accuracy.py reads.
Needs the built package (scripts/build).
"""
import argparse
import itertools
import pathlib
import tempfile

import yaml

from accuracy import CONDITIONS, PPC, evaluate, render, segment

OUTPUT = pathlib.Path(__file__).resolve().parent / 'baselines.yaml'
# What is searched, and on which scenes (name, seed).
GRIDS = {
    'region_growing': {'point_distance': [1.5, 2.0, 3.0], 'mean_square_error': [1.2, 2.5]},
    'pcl_multi_plane': {'half_window': [5, 8, 12], 'angle': [0.04, 0.06, 0.1], 'distance': [2.0]},
    'ransac': {'distance': [1.5, 2.0, 2.5, 3.5]},
    'pcl_region_growing': {'half_window': [5, 10], 'smoothness': [0.03, 0.06, 0.1]},
}
SCENES = [('office', 1), ('curved', 2)]


def combinations(grid):
    for values in itertools.product(*grid.values()):
        yield dict(zip(grid, values))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--methods', nargs='+', default=list(GRIDS), choices=list(GRIDS))
    parser.add_argument('--conditions', nargs='+', default=list(CONDITIONS), choices=list(CONDITIONS))
    parser.add_argument('--ppc', default=PPC, help='the built tool')
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for condition in options.conditions:
            images = {scene: render(options.ppc, folder, condition, *scene) for scene in SCENES}
            for method in options.methods:
                scored = []
                for setting in combinations(GRIDS[method]):
                    total = 0.0
                    for scene in SCENES:
                        segment(options.ppc, images[scene], method, setting, polygons=False)
                        total += evaluate(options.ppc, images[scene], polygons=False)['f1']
                    scored.append((total / len(SCENES), setting))
                    print(f'{condition} {method} {setting}: {scored[-1][0]:.3f}', flush=True)
                f1, setting = max(scored, key=lambda each: each[0])
                best = yaml.safe_load(OUTPUT.read_text()) if OUTPUT.exists() else {}
                best.setdefault(method, {})[condition] = {'f1': round(f1, 3), **setting}
                OUTPUT.write_text('# SPDX-License-Identifier: BSD-3-Clause\n# Written by tune_baselines.py: the best parameters of '
                                  'each method for each condition, and their F1 on the tuning scenes.\n' + yaml.safe_dump(best))


if __name__ == '__main__':
    main()
