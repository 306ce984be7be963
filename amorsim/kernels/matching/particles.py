"""Particles with paths and maps of their own: moved, matched with their maps, weighed and resampled.

Given its path, a particle's map is known, so only paths are sampled (Rao and Blackwell). All particles of a row have
the same scans; what differs is where they were taken. A particle's map near a place is the scans taken there. Source:
G. Grisetti, C. Stachniss, W. Burgard, "Improved Techniques for Grid Mapping with Rao-Blackwellized Particle Filters"
(2007).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.kinematics.poses import displaced
from amorsim.kernels.matching import icp, priors
from amorsim.kernels.matching.outlines import Outline, new_outline
from amorsim.kernels.matching.symmetric import invert
from amorsim.kernels.matching.tracking import Outlines
from amorsim.kernels.matching.tracks import swing

__all__ = ["Particles", "Weighing", "Workshop", "move_and_match", "resample", "workshop"]


_FLOOR = 1e-3  # [m, rad] least standard deviation of what the wheels say between two scans
_CUT = 9.0  # squared deviations beyond which a point tells nothing more


class Particles(NamedTuple):
    """The P particles of each of N rows, with room for K nodes."""

    pose: Array  # (N, P, 3)
    weight: Array  # (N, P), logarithms
    path: Array  # (N, P, K, 3) where the nodes' scans were taken
    nodes: Ints  # (N,) how many
    drift: Array  # (N, 3, 3) covariance of the heaviest one's pose by errors of scans, which its map does not show
    node_drift: Array  # (N, K, 3, 3) and when the nodes' scans were taken


class Weighing(NamedTuple):
    """How to match and weigh."""

    std: float  # [m] of a point's distance from its line
    points: float  # how many independent points a scan counts as
    references: int  # nodes that a scan is matched with
    reach: float  # [m] how far away they may be
    every: int  # one point of so many is matched
    search: icp.Search


class Workshop(NamedTuple):
    """Room for one particle's match."""

    reference: icp.Reference
    scan: Outline
    chosen: Ints  # (references,)
    work: icp.Work
    result: icp.Result
    prior: priors.Prior
    turned: Array  # (3, 3)
    root: Array  # (3, 3)
    start: Array  # (3,)
    drift: Array  # (3, 3)


def workshop(beams: int, references: int, every: int) -> Workshop:
    """Room for one particle's match of scans of so many beams."""
    few = (beams + every - 1) // every
    return Workshop(
        icp.reference(beams * references),
        new_outline(few),
        np.empty(references, np.int64),
        icp.work(few),
        icp.result(),
        priors.no_prior(),
        np.empty((3, 3)),
        np.empty((3, 3)),
        np.empty(3),
        np.empty((3, 3)),
    )


@part
def _root(matrix: Array, out: Array) -> None:
    """The lower triangle (3, 3) whose square is a covariance; 0 where that has no spread."""
    for i in range(3):
        for j in range(3):
            out[i, j] = 0.0
    for j in range(3):
        left = matrix[j, j]
        for k in range(j):
            left -= out[j, k] * out[j, k]
        out[j, j] = math.sqrt(left) if left > 0.0 else 0.0
        for i in range(j + 1, 3):
            value = matrix[i, j]
            for k in range(j):
                value -= out[i, k] * out[j, k]
            out[i, j] = value / out[j, j] if out[j, j] > 0.0 else 0.0


@part
def _choose(path: Array, count: int, pose: Array, reach: float, chosen: Ints) -> int:
    """The newest node, and those nearest to a pose; returns how many."""
    chosen[0] = count - 1
    found = 1
    while found < chosen.shape[0]:
        best = -1
        least = reach * reach
        for j in range(count - 1):
            is_taken = False
            for k in range(found):
                if chosen[k] == j:
                    is_taken = True
            dx = path[j, 0] - pose[0]
            dy = path[j, 1] - pose[1]
            if not is_taken and dx * dx + dy * dy < least:
                least = dx * dx + dy * dy
                best = j
        if best < 0:
            break
        chosen[found] = best
        found += 1
    return found


@kernel
def move_and_match(
    particles: Particles,
    due: Bools,
    moved: Array,
    spread: Array,
    normals: Array,
    scans: Outlines,
    node_lines: Array,
    weighing: Weighing,
    at: Workshop,
) -> None:
    """Move the particles of rows that are `due` (N, 1), lay their scans onto their maps, and weigh them.

    Parameters
    ----------
    moved, spread
        Motion (N, 3) since the last time, in the frame of the pose then, and its covariance (N, 3, 3).
    normals
        Standard normal draws (N, 3 P).
    node_lines
        Lines of the nodes' scans in their robots' frames, (N, K, k, 4).
    """
    for i in range(due.shape[0]):
        if not due[i, 0]:
            continue
        for k in range(at.scan.points.shape[0]):
            j = k * weighing.every
            at.scan.points[k, 0] = scans.points[i, j, 0]
            at.scan.points[k, 1] = scans.points[i, j, 1]
            for n in range(4):
                at.scan.lines[k, n] = scans.lines[i, j, n]
            at.scan.rays[k, 0] = scans.rays[i, j, 0]
            at.scan.rays[k, 1] = scans.rays[i, j, 1]
        _root(spread[i], at.root)
        count = particles.nodes[i]
        heaviest = -math.inf
        for p in range(particles.pose.shape[1]):
            pose = particles.pose[i, p]
            heading = pose[2]
            step0 = moved[i, 0]
            step1 = moved[i, 1]
            step2 = moved[i, 2]
            for k in range(3):
                draw = normals[i, 3 * p + k]
                step0 += at.root[0, k] * draw
                step1 += at.root[1, k] * draw
                step2 += at.root[2, k] * draw
            pose[0], pose[1], pose[2] = displaced(pose[0], pose[1], heading, step0, step1, step2)
            if count == 0:
                continue
            path = particles.path[i, p]
            found = _choose(path, count, pose, weighing.reach, at.chosen)
            _place_lines(node_lines[i], path, found, at)
            _know(spread[i], heading, pose, at)
            icp.align(at.reference, at.scan, at.start, at.prior, weighing.search, at.work, at.result)
            particles.weight[i, p] += _likelihood(weighing, at)
            for k in range(3):
                pose[k] = at.result.pose[k]
            if particles.weight[i, p] > heaviest:
                heaviest = particles.weight[i, p]
                _sum_up_drift(particles.node_drift[i], path, found, at, particles.drift[i])


@part
def _know(spread: Array, heading: float, pose: Array, at: Workshop) -> None:
    """Set the prior: the sampled pose, as sure as the wheels are."""
    c = math.cos(heading)
    s = math.sin(heading)
    a = spread[0, 0]
    b = spread[0, 1]
    d = spread[1, 1]
    e = spread[0, 2]
    f = spread[1, 2]
    at.turned[0, 0] = c * c * a - 2.0 * c * s * b + s * s * d + _FLOOR * _FLOOR
    at.turned[0, 1] = c * s * (a - d) + (c * c - s * s) * b
    at.turned[1, 1] = s * s * a + 2.0 * c * s * b + c * c * d + _FLOOR * _FLOOR
    at.turned[0, 2] = c * e - s * f
    at.turned[1, 2] = s * e + c * f
    at.turned[2, 2] = spread[2, 2] + _FLOOR * _FLOOR
    at.turned[1, 0] = at.turned[0, 1]
    at.turned[2, 0] = at.turned[0, 2]
    at.turned[2, 1] = at.turned[1, 2]
    invert(at.turned, at.prior.information)
    for k in range(3):
        at.prior.pose[k] = pose[k]
        at.start[k] = pose[k]


@part
def _sum_up_drift(node_drift: Array, path: Array, found: int, at: Workshop, out: Array) -> None:
    """Compute the covariance (3, 3) of a matched pose by errors of scans: of this one, and of those it was laid on.

    What the wheels' errors add is not in it, as the particles have been moved with such errors.
    """
    for i in range(3):
        for j in range(3):
            at.drift[i, j] = at.result.kept[i, j] + at.result.information[i, j]
            out[i, j] = 0.0
    if invert(at.drift, at.turned):
        for i in range(3):
            for j in range(3):
                for k in range(3):
                    for m in range(3):
                        out[i, j] += at.turned[i, k] * at.result.information[k, m] * at.turned[m, j]
    for n in range(found):
        node = at.chosen[n]
        dx = at.result.pose[0] - path[node, 0]
        dy = at.result.pose[1] - path[node, 1]
        swing(node_drift[node], dx, dy, at.drift)
        for i in range(3):
            for j in range(3):
                out[i, j] += at.drift[i, j] / found


@part
def _place_lines(lines: Array, path: Array, found: int, at: Workshop) -> None:
    """Put the lines of the chosen nodes into the world, as one reference."""
    k = lines.shape[1]
    for place in range(at.reference.lines.shape[0]):
        at.reference.lines[place, 0] = math.nan
        at.reference.lines[place, 1] = math.nan
    for m in range(found):
        node = at.chosen[m]
        c = math.cos(path[node, 2])
        s = math.sin(path[node, 2])
        for i in range(k):
            x = lines[node, i, 0]
            y = lines[node, i, 1]
            nx = lines[node, i, 2]
            ny = lines[node, i, 3]
            at.reference.lines[m * k + i, 0] = path[node, 0] + c * x - s * y
            at.reference.lines[m * k + i, 1] = path[node, 1] + s * x + c * y
            at.reference.lines[m * k + i, 2] = c * nx - s * ny
            at.reference.lines[m * k + i, 3] = s * nx + c * ny
    icp.index(at.reference)


@part
def _likelihood(weighing: Weighing, at: Workshop) -> float:
    """The logarithm of how likely the scan is on its map: points by their distance from the nearest line."""
    c = math.cos(at.result.pose[2])
    s = math.sin(at.result.pose[2])
    total = 0.0
    points = 0
    for i in range(at.scan.points.shape[0]):
        if math.isnan(at.scan.points[i, 0]):
            continue
        points += 1
        j = at.work.pairs[i]
        if j < 0:
            total += _CUT
            continue
        x = at.result.pose[0] + c * at.scan.points[i, 0] - s * at.scan.points[i, 1]
        y = at.result.pose[1] + s * at.scan.points[i, 0] + c * at.scan.points[i, 1]
        line = at.reference.lines[j]
        off = ((x - line[0]) * line[2] + (y - line[1]) * line[3]) / weighing.std
        total += min(off * off, _CUT)
    return -0.5 * weighing.points * total / points if points > 0 else 0.0


@kernel
def resample(particles: Particles, due: Bools, share: float, uniforms: Array, at_pose: Array, at_path: Array) -> None:
    """Resample the particles of rows whose effective number is below a share of them (systematic resampling).

    One draw (N, 1) places all P marks, so that few particles are lost. `at_pose` (P, 3) and `at_path` (P, K, 3) are
    room for copies. Source: S. Thrun, W. Burgard, D. Fox, "Probabilistic Robotics" (2005), 4.3.
    """
    for i in range(due.shape[0]):
        if not due[i, 0]:
            continue
        weight = particles.weight[i]
        size = weight.shape[0]
        most = weight[0]
        for p in range(1, size):
            most = max(most, weight[p])
        total = 0.0
        squares = 0.0
        for p in range(size):
            value = math.exp(weight[p] - most)
            total += value
            squares += value * value
        for p in range(size):
            weight[p] -= most + math.log(total)
        if total * total / squares >= share * size:
            continue
        count = particles.nodes[i]
        at_pose[:] = particles.pose[i]
        at_path[:, :count] = particles.path[i, :, :count]
        source = 0
        reached = math.exp(weight[0])
        for p in range(size):
            mark = (p + uniforms[i, 0]) / size
            while reached < mark and source < size - 1:  # rounding may leave the sum short of 1
                source += 1
                reached += math.exp(weight[source])
            particles.pose[i, p] = at_pose[source]
            particles.path[i, p, :count] = at_path[source, :count]
        for p in range(size):
            weight[p] = -math.log(size)
