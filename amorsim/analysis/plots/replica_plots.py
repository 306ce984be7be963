"""The pictures of many replicas: how far they spread, and how far the estimators believe that they do."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from amorsim.analysis.plots.figures import ESTIMATED, TRUE, band, draw_ellipse, legend, new_figure, tidy
from amorsim.analysis.plots.pose_traces import Estimates, Trace
from amorsim.analysis.plots.time_plots import ERRORS
from amorsim.analysis.run_files import RunFiles

__all__ = ["draw_all_errors", "draw_all_speeds", "draw_ends", "in_words"]


LOW, HIGH = 5.0, 95.0  # [%] of the replicas that lie within the bands
BELIEVED: dict[str, Any] = {"linestyle": (0, (1, 1.5)), "linewidth": 1.2}


def in_words(files: RunFiles, trace: Trace) -> str:
    """How far off the estimates of all replicas are at the end, a line for each estimator."""
    lines = []
    for estimate in trace.estimates:
        away = estimate.distance[-1] if len(trace.time) else np.full(trace.true.shape[1], np.nan)
        away = np.where(np.isfinite(away), away, -1.0)
        worst = int(np.argmax(away))
        name = f"{estimate.name}: " if len(trace.estimates) > 1 else ""
        lines.append(
            f"{name}at the end off by {np.sqrt(np.mean(away**2)):.3f} m (root mean square), "
            f"{np.median(away):.3f} m (median), {away[worst]:.3f} m (worst, replica {files.replicas[worst]})"
        )
    return "\n".join(lines)


def draw_all_errors(trace: Trace) -> Figure:
    """The errors of all replicas over time: their spread, and what each estimator takes it for."""
    figure, axes = new_figure(4, height=8.2, ratios=[1.3, 1, 1, 1])
    position, *others = axes
    for estimate in trace.estimates:
        _draw_distances(position, trace, estimate)
        named = estimate is trace.estimates[0]  # the panel of positions identifies the others by colour
        believed = np.sqrt(np.nanmean(estimate.sigma**2, axis=1)) if estimate.has_sigma else None
        for place, (axis, (_, scale)) in enumerate(zip(others, ERRORS, strict=True)):
            error = scale * estimate.error[..., place]
            mean, spread = error.mean(axis=1), error.std(axis=1)
            colour = estimate.style["color"]
            axis.plot(trace.time, mean, color=colour, linewidth=1.2, label="mean" if named else None)
            band(axis, trace.time, mean - spread, mean + spread, estimate.style, "mean ± σ" if named else "")
            if believed is not None:
                for sign in (-1.0, 1.0):
                    name = "±σ as believed" if named and sign > 0.0 else None
                    axis.plot(trace.time, sign * scale * believed[:, place], color=colour, label=name, **BELIEVED)
    position.set_ylabel("position [m]")
    position.set_ylim(bottom=0.0)
    for axis, (label, _) in zip(others, ERRORS, strict=True):
        axis.axhline(0.0, color="#9ca3af", linewidth=0.8, zorder=0)
        axis.set_ylabel(label)
    axes[-1].set_xlabel("time [s]")
    legend(figure, position, others[0])
    return figure


def _draw_distances(axis: Any, trace: Trace, estimate: Estimates) -> None:
    distance, style = estimate.distance, estimate.style
    if not len(trace.time):
        return
    low, median, high = np.percentile(distance, [LOW, 50.0, HIGH], axis=1)
    of = _of(trace, estimate)
    band(axis, trace.time, low, high, style, f"{LOW:g} to {HIGH:g} %{of}")
    axis.plot(trace.time, median, color=style["color"], linewidth=1.0, linestyle="--", label=f"median{of}")
    axis.plot(trace.time, np.sqrt(np.mean(distance**2, axis=1)), color=style["color"], label=f"root mean square{of}")


def _of(trace: Trace, estimate: Estimates) -> str:
    return f", {estimate.name}" if len(trace.estimates) > 1 else ""


def draw_all_speeds(files: RunFiles, robot: str) -> Figure:
    """True and estimated speeds and turn rates of all replicas: medians and bands."""
    found = files.arrays("velocities", robot=robot)
    figure, axes = new_figure(2, height=5.5)
    for axis, place, label in ((axes[0], 0, "forward [m/s]"), (axes[1], 2, "turning [rad/s]")):
        for key, style in (("true", TRUE), ("estimated", ESTIMATED)):
            values = found[f"{key}_twist"][..., place]
            if len(values):
                low, median, high = np.percentile(values, [LOW, 50.0, HIGH], axis=1)
                axis.plot(found["time"], median, **(style | {"label": f"{style['label']}, median"}))
                band(axis, found["time"], low, high, style, f"{style['label']}, {LOW:g} to {HIGH:g} %")
        axis.set_ylabel(label)
    axes[-1].set_xlabel("time [s]")
    legend(figure, axes[0])
    return figure


def draw_ends(trace: Trace) -> Figure | None:
    """Where the estimates of all replicas end, less the true end; with their spread and the believed one."""
    if not len(trace.time):
        return None
    figure = Figure(figsize=(7.5, 7.5), layout="constrained")
    axis: Any = figure.subplots()
    tidy(axis)
    axis.axhline(0.0, color="#9ca3af", linewidth=0.8, zorder=0)
    axis.axvline(0.0, color="#9ca3af", linewidth=0.8, zorder=0)
    for estimate in trace.estimates:
        ends, style = estimate.error[-1, :, :2], estimate.style
        axis.plot(*ends.T, "o", mfc="none", color=style["color"], markersize=5, alpha=0.7, label=style["label"])
        mean = ends.mean(axis=0)
        axis.plot(*mean, "+", color=style["color"], markersize=14, mew=2.2)
        draw_ellipse(axis, mean, np.cov(ends.T), style, label=f"1σ of the replicas{_of(trace, estimate)}")
        believed = np.nanmean(estimate.covariance[-1, :, :2, :2], axis=0) if estimate.has_sigma else np.zeros((2, 2))
        label = f"1σ as believed{_of(trace, estimate)}"
        draw_ellipse(axis, mean, believed, style, linestyle=BELIEVED["linestyle"], label=label)
    axis.set_aspect("equal", adjustable="datalim")
    axis.set_xlabel("x: estimated less true [m]")
    axis.set_ylabel("y: estimated less true [m]")
    legend(figure, axis)
    return figure
