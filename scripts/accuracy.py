#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Scores PPC and the methods that it is compared with on simulated scenes: writes doc/accuracy.md and its pictures.

Scenes: office, corridor, stairs, curved, creases; seeds from 101 on (those below 11 are for tuning). Conditions: UTM-30LX at 1, 2
and 4 times the noise of the data sheet, URG-04LX, and the UTM-30LX with all errors of a real sensor. PPC has one set of
parameters for all; the others have those of scripts/baselines.yaml, the best for each condition (tune_baselines.py). Every image is
rendered once. What is measured is kept in a file, and a run that was interrupted goes on from there.
Needs the built package (scripts/build) and what scripts/setup --lint installs.
"""
import argparse
import json
import pathlib
import resource
import subprocess
import sys
import tempfile

import yaml

ROOT = pathlib.Path(__file__).resolve().parent.parent
PPC = ROOT / 'build/devel/lib/patch_plane_clustering/ppc'
DOC = ROOT / 'doc'
SCENES = ['office', 'corridor', 'stairs', 'curved', 'creases']
CONDITIONS = {
    'UTM-30LX x1': ['--sensor', 'utm_30lx', '--noise', '1'],
    'UTM-30LX x2': ['--sensor', 'utm_30lx', '--noise', '2'],
    'UTM-30LX x4': ['--sensor', 'utm_30lx', '--noise', '4'],
    'URG-04LX': ['--sensor', 'urg_04lx', '--noise', '1'],
    'UTM-30LX realistic': ['--sensor', 'utm_30lx', '--realistic'],
}
RIVALS = ['region_growing', 'pcl_region_growing', 'pcl_multi_plane', 'ransac']
# What is left out, and how: options of ppc segment.
ABLATIONS = {
    'nothing (the default)': [],
    'equal angle: square patches': ['--set', 'equal_angle=false'],
    'running plane: neighbour to neighbour': ['--set', 'running_plane=false'],
    'noise: fixed Gaussians (0.1 rad, 30 mm)': ['--set', 'noise_aware=false', '--set', 'sigma_angle=0.1', '--set',
                                                'sigma_distance=0.03'],
    'noise estimate: the data sheet at x1': ['--set', 'noise_scale=1'],
    'strays': ['--set', 'clear_strays=false'],
    'standing lines': ['--set', 'thin_standing_lines=false'],
    'smooth noise': ['--set', 'thin_smooth_noise=false'],
    'noise of surfaces': ['--set', 'noise_by_surface=false'],
    'the limit of the range': ['--set', 'avoid_range_limit=false'],
    'merging': ['--set', 'merge=false'],
    'refinement and second pass': ['--set', 'refine=false'],
    'second pass': ['--set', 'second_pass=false'],
    'splitting of regions': ['--set', 'split_regions=false'],
    'settlement of borders': ['--set', 'settle_borders=false'],
    'steps lower than noise': ['--set', 'settle_low_steps=false'],
    'planes of small regions fitted anew': ['--set', 'refit_regions=false'],
    'dissolution of regions': ['--set', 'dissolve_regions=false'],
    'trimming of regions': ['--set', 'trim_regions=false'],
    'borders along creases': ['--set', 'align_creases=false'],
    'extension of regions': ['--set', 'extend_regions=false'],
    'filling of holes': ['--set', 'fill_holes=false'],
    'curvature test': ['--set', 'max_turn=10'],
    'everything: config/ppc_2012.yaml': ['--config', ROOT / 'config/ppc_2012.yaml'],
}
TOLERANCES = [percent / 100 for percent in range(51, 96)]


def run(*command):
    done = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f'{" ".join(map(str, command))}: {done.stderr.strip()}')
    return done.stdout


def render(ppc, folder, condition, scene, seed):
    """The files of one image: cloud, true labels, true planes, and where results for it go."""
    stem = f'{list(CONDITIONS).index(condition)}_{scene}_{seed}'
    image = {name: folder / f'{stem}_{name}' for name in ('cloud.pcd', 'truth.png', 'planes.json', 'labels.png', 'found.json')}
    run(ppc, 'simulate', '--scene', scene, '--seed', seed, '--truth-pieces', '--pcd', image['cloud.pcd'],
        '--truth', image['truth.png'], '--truth-planes', image['planes.json'], *CONDITIONS[condition])
    return image


def segment(ppc, image, method, tuning=None, options=(), polygons=True):
    tune = [word for name, value in (tuning or {}).items() for word in ('--tune', f'{name}={value}')]
    written = ['--polygons', image['found.json']] if polygons else []
    return json.loads(run(ppc, 'segment', image['cloud.pcd'], '--method', method, '--labels', image['labels.png'], *written, *tune,
                          *options))


def evaluate(ppc, image, polygons=True):
    full = ['--cloud', image['cloud.pcd'], '--polygons', image['found.json'], '--truth-planes', image['planes.json']]
    return json.loads(run(ppc, 'evaluate', '--truth', image['truth.png'], '--labels', image['labels.png'],
                          *(full if polygons else [])).splitlines()[0])


def summary(scores):
    """What is kept of one image and method."""
    kept = {name: scores[name] for name in ('true', 'found', 'correct', 'spurious', 'f1', 'mean_iou', 'pixel_iou')}
    kept['curve'] = [point['correct'] for point in scores['curve']]
    kept['planes'] = scores['planes']
    kept['rendered'] = {name: value for name, value in scores['from_polygons'].items() if name not in ('curve', 'first_fault')}
    return kept


class Results:
    """Records by (table, condition, scene, seed, method), kept in a file of one JSON record a line."""

    def __init__(self, path, fresh):
        self.path, self.records = path, {}
        if path.exists() and not fresh:
            for line in path.read_text().splitlines():
                key, record = json.loads(line)
                self.records[tuple(key)] = record
        elif path.exists():
            path.unlink()

    def __contains__(self, key):
        return key in self.records

    def add(self, key, record):
        self.records[key] = record
        with self.path.open('a') as out:
            out.write(json.dumps([key, record]) + '\n')

    def of(self, table, method, condition=None, keys=None):
        return [record for key, record in self.records.items()
                if key[0] == table and key[4] == method and condition in (None, key[1]) and (keys is None or key[1:4] in keys)]

    def methods(self, table, known):
        return [m for m in known if self.of(table, m)]


def measure(options, results):
    tuned = yaml.safe_load((ROOT / 'scripts/baselines.yaml').read_text())
    with tempfile.TemporaryDirectory() as name:
        for seed in options.seeds:
            for condition in CONDITIONS:
                for scene in options.scenes:
                    jobs = []
                    for method in options.methods:
                        if method == 'ppc' or seed in options.rival_seeds:
                            tuning = {k: v for k, v in tuned.get(method, {}).get(condition, {}).items() if k != 'f1'}
                            jobs.append((('methods', condition, scene, seed, method), method, tuning, ()))
                    if options.ablation and seed in options.ablation_seeds and scene in options.ablation_scenes:
                        for label, switches in ABLATIONS.items():
                            jobs.append((('ablation', condition, scene, seed, label), 'ppc', {}, switches))
                    jobs = [job for job in jobs if job[0] not in results]
                    if not jobs:
                        continue
                    image = render(options.ppc, pathlib.Path(name), condition, scene, seed)
                    for key, method, tuning, switches in jobs:
                        segment(options.ppc, image, method, tuning, switches)
                        results.add(key, summary(evaluate(options.ppc, image)))
                        print(f'{" ".join(map(str, key[1:]))}: F1 {results.records[key]["f1"]:.3f}', flush=True)
                    for file in image.values():
                        file.unlink(missing_ok=True)


def measure_times(options, results):
    """Processor time of one segmentation [s]: of four less that of one, so that reading and writing do not count."""
    tuned = yaml.safe_load((ROOT / 'scripts/baselines.yaml').read_text())
    with tempfile.TemporaryDirectory() as name:
        image = None
        for method in options.methods:
            key = ('time', 'UTM-30LX x1', 'office', options.seeds[0], method)
            if key in results:
                continue
            image = image or render(options.ppc, pathlib.Path(name), *key[1:4])
            tuning = {k: v for k, v in tuned.get(method, {}).get(key[1], {}).items() if k != 'f1'}
            used, many = [], 60 if method == 'ppc' else 3  # what is quick is lost in the noise of reading and writing files
            for repeat in (many, 1):
                before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
                segment(options.ppc, image, method, tuning, ['--repeat', repeat])
                used.append(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before)
            results.add(key, {'seconds': (used[0] - used[1]) / many})


def mean(records, *path):
    values = []
    for record in records:
        for name in path:
            record = record.get(name) if record is not None else None
        if record is not None:
            values.append(record)
    return sum(values) / len(values) if values else None


def ratio(records, part, whole, *path):
    top, bottom = mean(records, *path, part), mean(records, *path, whole)
    return top / bottom if bottom else None


def plane_mean(records, name):
    planes = [r['planes'] for r in records if r.get('planes') and r['planes']['matched'] > 0]
    count = sum(p['matched'] for p in planes)
    return sum(p[name] * p['matched'] for p in planes) / count if count else None


def shown(value, digits=2, unit=''):
    return '-' if value is None else f'{value:.{digits}f}{unit}'


def score_row(records):
    share = ratio(records, 'correct', 'true')
    normal, refit = plane_mean(records, 'true_normal_error_deg'), plane_mean(records, 'refit_normal_error_deg')
    return [shown(mean(records, 'f1')), shown(100 * share if share is not None else None, 1, ' %'), shown(mean(records, 'spurious'), 1),
            shown(mean(records, 'mean_iou')), shown(mean(records, 'pixel_iou')), shown(mean(records, 'rendered', 'f1')),
            shown(mean(records, 'rendered', 'mean_iou')), shown(mean(records, 'rendered', 'pixel_iou')),
            shown(normal), shown(normal / refit if normal is not None and refit else None),
            shown(plane_mean(records, 'offset_error_mm'), 1), shown(plane_mean(records, 'within_95'))]


HEADINGS = ['F1', 'correct', 'spurious', 'IoU', 'pixel IoU', 'F1 of polygons', 'IoU of polygons', 'pixel IoU of polygons',
            'normal [deg]', 'to refit', 'offset [mm]', 'in covariance']


def table(first, headings, rows):
    lines = ['| ' + ' | '.join(first + headings) + ' |', '|' + ' --- |' * (len(first) + len(headings))]
    return '\n'.join(lines + ['| ' + ' | '.join(row) + ' |' for row in rows]) + '\n'


def method_rows(results, methods):
    for condition in CONDITIONS:
        for method in methods:
            records = results.of('methods', method, condition)
            if records:
                yield [condition, method, str(len(records)), *score_row(records)]


def time_rows(results, methods):
    base = mean(results.of('time', 'ppc'), 'seconds')
    for method in methods:
        seconds = mean(results.of('time', method), 'seconds')
        yield [method, shown(seconds / base if seconds and base else None, 1)]


def polygon_rows(results, methods):
    for condition in CONDITIONS:
        for method in methods:
            records = results.of('methods', method, condition)
            if not records:
                continue
            holes, found = mean(records, 'rendered', 'true_holes'), mean(records, 'rendered', 'holes_found')
            openings = mean(records, 'rendered', 'openings_found')
            boundary = mean(records, 'rendered', 'boundary_error')
            polygons, invalid = mean(records, 'rendered', 'polygons'), mean(records, 'rendered', 'invalid')
            yield [condition, method, shown(1000 * boundary if boundary is not None else None, 0),
                   shown(100 * found / holes if holes else None, 0, ' %'),
                   shown(100 * openings / holes if holes and openings is not None else None, 0, ' %'), shown(polygons, 1),
                   shown(mean(records, 'rendered', 'vertices') / polygons if polygons else None, 1),
                   shown(100 * (1 - invalid / polygons) if polygons else None, 1, ' %'),
                   shown(mean(records, 'rendered', 'compression'), 0)]


def scene_rows(results):
    for scene in SCENES:
        row = [scene]
        for condition in CONDITIONS:
            records = [r for k, r in results.records.items() if k[0] == 'methods' and k[4] == 'ppc' and k[1:3] == (condition, scene)]
            row.append(shown(mean(records, 'f1')))
        yield row


def worst_rows(results, count=10):
    """Where PPC falls short: its images of the lowest F1."""
    ours = [(record['f1'], key, record) for key, record in results.records.items() if key[0] == 'methods' and key[4] == 'ppc']
    for f1, key, record in sorted(ours, key=lambda each: (each[0], each[1]))[:count]:
        yield [key[1], key[2], str(key[3]), shown(f1), str(record['true']), str(record['true'] - record['correct']),
               str(record['spurious'])]


def ablation_images(results):
    """Those that every variant has been run on."""
    return {key[1:4] for key in results.records
            if key[0] == 'ablation' and all(('ablation', *key[1:4], label) in results for label in ABLATIONS)}


def ablation_rows(results):
    images = ablation_images(results)
    for label in ABLATIONS:
        records = results.of('ablation', label, keys=images)
        yield [label, *(shown(mean(results.of('ablation', label, c, images), 'f1')) for c in CONDITIONS),
               shown(mean(records, 'mean_iou')), shown(mean(records, 'spurious'), 1), shown(mean(records, 'rendered', 'mean_iou'))]


def tuning_rows():
    tuned = yaml.safe_load((ROOT / 'scripts/baselines.yaml').read_text())
    for method in RIVALS:
        for condition in CONDITIONS:
            best = tuned.get(method, {}).get(condition)
            if best:
                yield [method, condition, ', '.join(f'{k} {v:g}' for k, v in sorted(best.items()) if k != 'f1')]


def seeds_of(results, methods):
    seeds = {m: ' '.join(str(s) for s in sorted({key[3] for key in results.records if key[0] == 'methods' and key[4] == m}))
             for m in methods}
    return ', '.join(f'{m} {seeds[m]}' for m in methods)


def report(results, methods):
    text = f'''# Accuracy on simulated scenes

Written by `scripts/accuracy.py`; nothing here is from a real sensor (for that see the tests with recordings). Scenes: {', '.join(SCENES)};
300 lines over +-60 deg. Seeds: {seeds_of(results, methods)}; parameters were tuned on others. One truth region for each piece of a plane
that is connected in the image, 400 pixels and more; a region is correct if it overlaps the true one by 80 % of both (Hoover et al. 1996).
PPC: the defaults, the same everywhere; the noise is estimated from each image. The others: the best parameters for each condition,
searched on other seeds (below).

F1 = 2 correct / (true + found); *correct* is the share of true regions; *spurious* regions and what is not said otherwise are means an image. IoU: mean
over true regions of the best intersection over union; *pixel IoU*: the same, weighted with the size of the true region. *Of polygons*: the polygons rendered back along every beam and scored as labels are.
*Normal*, over all planes of correct regions: mean angle to the true planes, and *to refit* its ratio to that of a fit to the true
pixels. *Offset*: distance of the found plane from the centroid of the true region's points. *In covariance*: share of these planes
whose error is within the ellipsoid that should hold 95 % of them; the others' planes are fitted to their labels by the same means. Where
it is realistic, the pose of the sensor is wrong for all points alike, which no covariance of a plane can know.

{table(['condition', 'method', 'images'], HEADINGS, method_rows(results, methods))}
![Correct detections over the tolerance](accuracy_tolerance.png)

![F1 over noise](accuracy_noise.png)

## Time

Processor time of one office at the data sheet's noise, labels and polygons, as a multiple of PPC's:

{table(['method'], ['times PPC'], time_rows(results, methods))}
## Polygons

*Boundary*: mean distance of the true outlines of correct regions from the polygon's [mm]. *Holes*: share of true holes of 50 pixels and more
that the region's polygons leave open (IoU 0.5). *Openings*: the same, whether or not the outline runs into them (-: not
measured). *Valid*: simple, holes inside and apart. *Compression*: bytes of the points (12 each) over bytes
of the polygons (12 a vertex, 32 a plane, 4 a ring).

{table(['condition', 'method'], ['boundary [mm]', 'holes', 'openings', 'polygons', 'vertices a polygon', 'valid', 'compression'], polygon_rows(results, methods))}
## PPC by scene (F1)

{table(['scene'], list(CONDITIONS), scene_rows(results))}
Where it falls short, the images of the lowest F1 (to be seen with `ppc simulate --truth-pieces --seed N` and `ppc segment --picture`):

{table(['condition', 'scene', 'seed'], ['F1', 'true', 'not correct', 'spurious'], worst_rows(results))}
![Truth and result, a colour each](accuracy_scenes.png)
'''
    images = ablation_images(results)
    if images:
        text += f'''
## What each addition buys (F1 with it left out)

{table(['left out'], [*CONDITIONS, 'IoU', 'spurious', 'IoU of polygons'], ablation_rows(results))}
Scenes: {', '.join(s for s in SCENES if any(image[1] == s for image in images))}; {len(images)} images in all. IoU and spurious regions are
means over all conditions.
'''
    text += f'''
## Parameters of the other methods

{table(['method', 'condition', 'parameters'], [], tuning_rows())}
'''
    (DOC / 'accuracy.md').write_text(text)


def draw_curves(results, methods):
    import matplotlib
    matplotlib.use('Agg')
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(1, len(CONDITIONS), figsize=(15, 3.4), sharey=True)
    for axis, condition in zip(axes, CONDITIONS):
        for method in methods:
            records = results.of('methods', method, condition)
            if records:
                true = sum(r['true'] for r in records)
                axis.plot(TOLERANCES, [100 * sum(r['curve'][i] for r in records) / true for i in range(len(TOLERANCES))], label=method)
        axis.set(title=condition, xlabel='tolerance')
        axis.grid(alpha=0.3)
    axes[0].set(ylabel='correct [% of true regions]', ylim=(0, 102))
    axes[0].legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(DOC / 'accuracy_tolerance.png', dpi=80)

    figure, axis = pyplot.subplots(figsize=(5, 3.4))
    noisy = {1: 'UTM-30LX x1', 2: 'UTM-30LX x2', 4: 'UTM-30LX x4'}
    for method in methods:
        points = [(scale, mean(results.of('methods', method, c), 'f1')) for scale, c in noisy.items()]
        axis.plot(*zip(*[p for p in points if p[1] is not None]), 'o-', label=method)
    axis.set(xlabel='noise [multiple of the data sheet]', ylabel='F1', ylim=(0, 1.02), xscale='log', xticks=list(noisy))
    axis.set_xticks(list(noisy), [f'x{n}' for n in noisy])
    axis.grid(alpha=0.3)
    axis.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(DOC / 'accuracy_noise.png', dpi=80)


def draw_scenes(ppc, seed):
    import matplotlib
    matplotlib.use('Agg')
    from matplotlib import colors, pyplot
    palette = pyplot.get_cmap('hsv')([(i * 0.618) % 1.0 for i in range(400)])
    palette[:, :3] *= 0.55 + 0.45 * ((colors.np.arange(400) * 7 % 5) / 4)[:, None]
    palette[0] = (0.08, 0.08, 0.08, 1.0)
    names = colors.ListedColormap(palette)
    figure, axes = pyplot.subplots(len(SCENES), 2, figsize=(12, 1.85 * len(SCENES)))
    with tempfile.TemporaryDirectory() as name:
        for row, scene in zip(axes, SCENES):
            image = render(ppc, pathlib.Path(name), 'UTM-30LX x1', scene, seed)
            segment(ppc, image, 'ppc')
            for axis, file, title in zip(row, ('truth.png', 'labels.png'), ('truth', 'found')):
                labels = (pyplot.imread(image[file]) * 65535).round() % 400
                axis.imshow(labels, cmap=names, vmin=0, vmax=399, interpolation='nearest', aspect='auto')
                axis.set(xticks=[], yticks=[], title=f'{scene}: {title}')
    figure.tight_layout()
    figure.savefig(DOC / 'accuracy_scenes.png', dpi=80)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--methods', nargs='+', default=['ppc', *RIVALS], choices=['ppc', *RIVALS])
    parser.add_argument('--seeds', nargs='+', type=int, default=[101, 102, 103, 104])
    parser.add_argument('--rival-seeds', nargs='+', type=int, default=[101, 102], help='those of the other methods')
    parser.add_argument('--scenes', nargs='+', default=SCENES, choices=SCENES)
    parser.add_argument('--ablation', action='store_true', help='also with each addition switched off')
    parser.add_argument('--ablation-seeds', nargs='+', type=int, default=[101])
    parser.add_argument('--ablation-scenes', nargs='+', default=['office', 'stairs', 'curved'], choices=SCENES)
    parser.add_argument('--ppc', default=PPC, help='the built tool')
    parser.add_argument('--results', type=pathlib.Path, default=ROOT / 'build/accuracy.jsonl', help='where results are kept')
    parser.add_argument('--fresh', action='store_true', help='do not go on from there')
    parser.add_argument('--report-only', action='store_true', help='write the document again from what is kept')
    options = parser.parse_args()
    results = Results(options.results, options.fresh)
    if not options.report_only:
        measure(options, results)
        measure_times(options, results)
    methods = results.methods('methods', ['ppc', *RIVALS])
    report(results, methods)
    draw_curves(results, methods)
    draw_scenes(options.ppc, options.seeds[0])


if __name__ == '__main__':
    main()
