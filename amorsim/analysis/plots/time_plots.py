"""The pictures of one robot over time: speeds, joints, heading, and the errors of its estimates."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from amorsim.analysis.plots.figures import ESTIMATED, MEASURED, TRUE, band, compare, legend, new_figure, unwrapped_gaps
from amorsim.analysis.plots.pose_traces import Trace
from amorsim.analysis.run_files import RunFiles, Table
from amorsim.array_types import AnyArray

__all__ = ["ERRORS", "draw_error", "draw_heading", "draw_speed", "draw_wheels", "fit_errors"]


ERRORS = (("x [m]", 1.0), ("y [m]", 1.0), ("heading [°]", float(np.degrees(1.0))))
ROOM = 4.0  # times the largest error that a much larger belief is shown


def draw_speed(velocities: Table) -> Figure:
    """True and estimated speed and turn rate."""
    figure, axes = new_figure(4, height=7.5, ratios=[3, 1, 3, 1])
    time = velocities["time"]
    for row, (key, label) in enumerate((("forward", "forward [m/s]"), ("turn", "turning [rad/s]"))):
        main, below = axes[2 * row : 2 * row + 2]
        compare(
            figure, main, below, (time, velocities[f"true_{key}"]), (time, velocities[f"estimated_{key}"]), ESTIMATED
        )
        main.set_ylabel(label)
    axes[-1].set_xlabel("time [s]")
    return figure


def draw_wheels(velocities: Table) -> Figure | None:
    """The true rates of the joints, and those measured by encoders; None if there are no joints."""
    joints = RunFiles.joints(velocities)
    if not joints:
        return None
    figure, axes = new_figure(2 * len(joints), height=1.0 + 3.2 * len(joints), ratios=[3, 1] * len(joints))
    time = velocities["time"]
    for row, joint in enumerate(joints):
        main, below = axes[2 * row : 2 * row + 2]
        true, measured = velocities[f"true_{joint}"], velocities[f"measured_{joint}"]
        compare(figure, main, below, (time, true), (time, measured), MEASURED)
        main.set_ylabel(f"{joint.replace('_', ' ')} [rad/s]")
    axes[-1].set_xlabel("time [s]")
    return figure


def draw_heading(trace: Trace) -> Figure:
    """True and estimated headings, with turns counted; below, the errors and their estimated deviations."""
    figure, (main, below) = new_figure(2, ratios=[3, 1.4])
    true = np.degrees(np.unwrap(trace.true[:, 0, 2]))
    main.plot(trace.time, true, **TRUE)
    for estimate in trace.estimates:
        error = np.degrees(estimate.error[:, 0, 2])
        # On the same turn as the true heading.
        main.plot(trace.time, true + np.degrees(np.unwrap(estimate.error[:, 0, 2])), **estimate.style)
        below.plot(trace.time, unwrapped_gaps(error), color=estimate.style["color"], linewidth=0.9)
        if estimate.has_sigma:
            sigma = np.degrees(estimate.sigma[:, 0, 2])
            band(below, trace.time, -sigma, sigma, estimate.style, "±σ")
            # Named once, in the legend, by an empty area in the panel above.
            band(main, trace.time[:0], sigma[:0], sigma[:0], estimate.style, f"±σ{_of(trace, estimate.name)}")
    main.set_ylabel("heading [°]")
    below.set_ylabel("estimated\nless true [°]", fontsize=8)
    below.tick_params(labelsize=8)
    below.set_xlabel("time [s]")
    fit_errors(below, *(np.degrees(each.error[:, 0, 2]) for each in trace.estimates))
    legend(figure, main)
    return figure


def draw_error(trace: Trace) -> Figure:
    """How far each estimate is off, and how far it believes to be: ±σ of x, y and heading."""
    figure, axes = new_figure(4, height=8.0, ratios=[1.3, 1, 1, 1])
    position, *others = axes
    for estimate in trace.estimates:
        position.plot(trace.time, estimate.distance[:, 0], **estimate.style)
        sigma = estimate.sigma[:, 0]
        if estimate.has_sigma:
            reach = np.hypot(sigma[:, 0], sigma[:, 1])
            band(position, trace.time, 0.0 * reach, reach, estimate.style, f"±σ{_of(trace, estimate.name)}")
        for axis, (_, scale), error, believed in zip(others, ERRORS, estimate.error[:, 0].T, sigma.T, strict=True):
            gaps = unwrapped_gaps(scale * error) if scale != 1.0 else error
            axis.plot(trace.time, gaps, **{**estimate.style, "label": None})
            if estimate.has_sigma:
                band(axis, trace.time, -scale * believed, scale * believed, estimate.style, "")
    position.set_ylabel("position [m]")
    fit_errors(position, *(each.distance[:, 0] for each in trace.estimates), is_signed=False)
    for axis, (label, scale), place in zip(others, ERRORS, range(3), strict=True):
        axis.axhline(0.0, color="#9ca3af", linewidth=0.8, zorder=0)
        axis.set_ylabel(label)
        fit_errors(axis, *(scale * each.error[:, 0, place] for each in trace.estimates))
    axes[-1].set_xlabel("time [s]")
    legend(figure, position)
    return figure


def fit_errors(axis: Any, *errors: AnyArray, is_signed: bool = True) -> None:
    """Scale a panel to the errors, also if their estimated deviations are much larger."""
    largest = max((float(np.nanmax(np.abs(each))) for each in errors if np.isfinite(each).any()), default=0.0)
    low, high = axis.get_ylim()
    reach = min(max(abs(low), abs(high)), ROOM * largest) if largest > 0.0 else max(abs(low), abs(high))
    if reach > 0.0:
        axis.set_ylim(-1.05 * reach if is_signed else 0.0, 1.05 * reach)


def _of(trace: Trace, name: str) -> str:
    return f" of {name}" if len(trace.estimates) > 1 else ""
