#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Renders simulated scenes, segments them by several methods, and writes the scores as a table.

Scenes: office, corridor, stairs, curved, creases; seeds from 101 on (1 to 10 are for tuning). Conditions: UTM-30LX at 1, 2 and 4
times the noise of the data sheet, URG-04LX, and the UTM-30LX with all errors of a real sensor. Scores (ppc evaluate): means over
images at 80 % tolerance, true regions of 400 pixels and more, one region for each piece that is connected in the image.
Needs the built package (scripts/build).
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENES = ['office', 'corridor', 'stairs', 'curved', 'creases']
CONDITIONS = {
    'UTM-30LX x1': ['--sensor', 'utm_30lx', '--noise', '1'],
    'UTM-30LX x2': ['--sensor', 'utm_30lx', '--noise', '2'],
    'UTM-30LX x4': ['--sensor', 'utm_30lx', '--noise', '4'],
    'URG-04LX': ['--sensor', 'urg_04lx', '--noise', '1'],
    'UTM-30LX realistic': ['--sensor', 'utm_30lx', '--realistic'],
}


def run(*command):
    done = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f'{" ".join(map(str, command))}: {done.stderr.strip()}')
    return done.stdout


def score(ppc, folder, condition, scene, seed, method):
    cloud, truth, labels = folder / 'cloud.pcd', folder / 'truth.png', folder / 'labels.png'
    run(ppc, 'simulate', '--scene', scene, '--seed', seed, '--truth-pieces', '--pcd', cloud, '--truth', truth,
        *CONDITIONS[condition])
    run(ppc, 'segment', cloud, '--method', method, '--labels', labels)
    return json.loads(run(ppc, 'evaluate', '--truth', truth, '--labels', labels).splitlines()[0])


def mean(scores, key):
    return sum(s[key] for s in scores) / len(scores)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--methods', nargs='+', default=['ppc', 'region_growing', 'pcl_multi_plane', 'ransac'])
    parser.add_argument('--seeds', nargs='+', type=int, default=[101, 102])
    parser.add_argument('--scenes', nargs='+', default=SCENES, choices=SCENES)
    parser.add_argument('--ppc', default=ROOT / 'build/devel/lib/patch_plane_clustering/ppc', help='the built tool')
    options = parser.parse_args()
    print('| condition | method | true | correct | spurious | F1 | mean IoU |')
    print('| --- | --- | --- | --- | --- | --- | --- |')
    with tempfile.TemporaryDirectory() as name:
        for condition in CONDITIONS:
            for method in options.methods:
                scores = [score(options.ppc, pathlib.Path(name), condition, scene, seed, method)
                          for scene in options.scenes for seed in options.seeds]
                print(f'| {condition} | {method} | {mean(scores, "true"):.1f} | {mean(scores, "correct"):.1f} | '
                      f'{mean(scores, "spurious"):.1f} | {mean(scores, "f1"):.2f} | {mean(scores, "mean_iou"):.2f} |', flush=True)


if __name__ == '__main__':
    main()
