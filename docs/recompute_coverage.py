#!/usr/bin/env python3
"""Counts a run's coverage again from its folder alone: python3 docs/recompute_coverage.py runs/helicopter/1

Own nearest neighbours (a hash of cells of one radius), nothing of the program's. Compare with summary.json."""
import json, re, sys
import numpy as np

def ply(path):
    head, data = open(path, 'rb').read().split(b'end_header\n', 1)
    kinds = {'float': '<f4', 'uchar': 'u1'}
    return np.frombuffer(data, [(n, kinds[t]) for t, n in re.findall(r'property (\w+) (\w+)', head.decode())])

run = sys.argv[1]
radius = float(re.search(r'coverage_radius_m: ([\d.e-]+)', open(run + '/config.yaml').read()).group(1))
xyz = lambda a, *names: np.stack([a[n] for n in names], 1).astype(float)
truth, cloud, T = ply(run + '/ground_truth.ply'), ply(run + '/cloud.ply'), np.loadtxt(run + '/alignment.txt')
q, n = xyz(truth, 'x', 'y', 'z'), xyz(truth, 'nx', 'ny', 'nz')
p, o = (xyz(cloud, *names) @ T[:3, :3].T + T[:3, 3] for names in (('x', 'y', 'z'), ('vp_x', 'vp_y', 'vp_z')))

lowest = np.minimum(p.min(0), q.min(0)) - 2 * radius
key = lambda a: ((a - lowest) // radius).astype(np.int64) @ np.array([1, 1 << 20, 1 << 40])
keys = key(p); order = np.argsort(keys, kind='stable'); keys = keys[order]
covered, outer = np.zeros(len(q), bool), np.zeros(len(q), bool)
for step in np.ndindex(3, 3, 3):  # the cells about each truth point's own
    at = key(q + (np.array(step) - 1) * radius)
    i, end = np.searchsorted(keys, at), np.searchsorted(keys, at, 'right')
    k = np.flatnonzero(i < end)
    while len(k):  # the cell's next return, for all truth points that have one
        r = order[i[k]]
        near = ((q[k] - p[r]) ** 2).sum(1) <= radius ** 2
        front = (n[k] * (o[r] - q[k])).sum(1) > 0
        covered[k] |= near
        outer[k] |= near & (front | (truth['two_sided'][k] == 1))
        i[k] += 1
        k = k[(i[k] < end[k]) & ~outer[k]]
found = dict(coverage=covered.mean(), coverage_outer=outer.mean())
if 'attainable' in truth.dtype.names:  # not with mission.attainable=false
    can = truth['attainable'] == 1
    found.update(coverage_attainable=can.mean(), coverage_of_attainable=(outer & can).sum() / can.sum())
summary = json.load(open(run + '/summary.json'))
for name, value in found.items():
    print(f'{name:24s} {100 * value:8.4f} %  summary.json {100 * summary[name]:8.4f} %')
sys.exit(any(abs(value - summary[name]) > 1e-4 for name, value in found.items()))
