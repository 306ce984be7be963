"""Submaps: the points of several scans in the frame of one of them, to match a later scan with.

A single old scan shows little of what a robot sees that comes back from another side. Matching with submaps follows
W. Hess et al., "Real-time loop closure in 2D LIDAR SLAM" (2016).
"""

from __future__ import annotations

import math

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel
from amorsim.kernels.kinematics.poses import displaced
from amorsim.kernels.matching import correlative, icp, tracking
from amorsim.kernels.matching.outlines import Outline

__all__ = ["align_with_submap", "draw_submap"]


@kernel
def draw_submap(
    scans: tracking.Outlines,
    poses: Array,
    mount: Array,
    reach: float,
    points: Array,
    out: icp.Reference,
    on: correlative.Picture,
) -> None:
    """Put the points of n scans, taken at `poses` (n, 3), into a reference, and draw its picture with the free space.

    Points farther from the origin than `reach` [m] are left out. `out` has room for the points of all scans; `points`
    (n, k, 2) is room for them where they lie.
    """
    count = 0
    out.points[:] = math.nan
    out.lines[:] = math.nan
    for q in range(poses.shape[0]):
        x = poses[q, 0]
        y = poses[q, 1]
        c = math.cos(poses[q, 2])
        s = math.sin(poses[q, 2])
        for j in range(scans.points.shape[1]):
            u = x + c * scans.points[q, j, 0] - s * scans.points[q, j, 1]
            v = y + s * scans.points[q, j, 0] + c * scans.points[q, j, 1]
            points[q, j, 0] = u
            points[q, j, 1] = v
            if not u * u + v * v <= reach * reach:  # nan as well
                continue
            out.points[count, 0] = u
            out.points[count, 1] = v
            out.lines[count, 0] = x + c * scans.lines[q, j, 0] - s * scans.lines[q, j, 1]
            out.lines[count, 1] = y + s * scans.lines[q, j, 0] + c * scans.lines[q, j, 1]
            out.lines[count, 2] = c * scans.lines[q, j, 2] - s * scans.lines[q, j, 3]
            out.lines[count, 3] = s * scans.lines[q, j, 2] + c * scans.lines[q, j, 3]
            count += 1
    icp.index(out)
    correlative.draw(out.points, on)
    for q in range(poses.shape[0]):
        x, y, _ = displaced(poses[q, 0], poses[q, 1], poses[q, 2], mount[0], mount[1], mount[2])
        correlative.clear(points[q], x, y, on)


@kernel
def align_with_submap(
    scans: tracking.Outlines,
    poses: Array,
    mount: Array,
    reach: float,
    points: Array,
    reference: icp.Reference,
    rules: tracking.Rules,
    at: tracking.Room,
) -> float:
    """Match the last of n + 1 scans with a submap of the n before it from ``at.start``; returns how well it fits.

    `poses` (n, 3) are those of the scans of the submap, in whose frame the result is.
    """
    draw_submap(scans, poses, mount, reach, points, reference, at.picture)
    last = poses.shape[0]
    scan = Outline(scans.points[last], scans.lines[last], scans.rays[last])
    return tracking.align_outline(reference, scan, rules.window, at.free, rules, at)
