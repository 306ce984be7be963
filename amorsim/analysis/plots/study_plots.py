"""The pictures of experiments: end points of UMBmark, and the effect of each error on odometry and readings."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from amorsim.analysis.plots.figures import TRUE, save_figure, tidy
from amorsim.array_types import Array
from amorsim.render.words import NOTHING, percent

if TYPE_CHECKING:
    from amorsim.studies.attribution import Attribution
    from amorsim.studies.reading_attribution import ReadingAttribution
    from amorsim.studies.umbmark import Umbmark

__all__ = ["plot_attribution", "plot_readings", "plot_umbmark"]


_CLOCKWISE = {"color": "#2f6fde", "marker": "o"}
_ANTICLOCKWISE = {"color": "#d97706", "marker": "s"}
# The palette of Okabe and Ito, made for all kinds of colour vision; black is for all errors together.
_COLOURS = ("#e69f00", "#56b4e9", "#cc79a7", "#0072b2", "#d55e00", "#009e73", "#b8a800", "#7f7f7f")
_DASHES: tuple[Any, ...] = ("--", "-.", (0, (5, 1, 1, 1, 1, 1)), (0, (2, 1)))


def plot_umbmark(found: Umbmark, path: Path) -> None:
    """Write the method's own picture: end points and cluster centres of both directions, before and after [m].

    Raises
    ------
    RunError
        If it cannot be written.
    """
    figure = Figure(figsize=(10.5, 5.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    _ends(left, found.clockwise, found.anticlockwise)
    left.set_title(f"nominal parameters: E_max,syst = {1000.0 * found.error_before:.1f} mm", loc="left", fontsize=10)
    _ends(right, *found.after)
    right.set_title(f"corrected: E_max,syst = {1000.0 * found.error_after:.1f} mm", loc="left", fontsize=10)
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
    figure.suptitle(f"UMBmark of {found.robot}: squares of {found.side:g} m at {found.speed:g} m/s", x=0.01, ha="left")
    save_figure(figure, path, dpi=110)


def _ends(axis: Any, clockwise: Array, anticlockwise: Array) -> None:
    tidy(axis)
    axis.axhline(0.0, color="#9ca3af", linewidth=0.8)
    axis.axvline(0.0, color="#9ca3af", linewidth=0.8)
    for ends, style, label in (
        (clockwise, _CLOCKWISE, "clockwise"),
        (anticlockwise, _ANTICLOCKWISE, "anticlockwise"),
    ):
        axis.plot(*ends.T, linestyle="", mfc="none", markersize=7, label=label, **style)
        x, y = ends.mean(axis=0)
        axis.plot([0.0, x], [0.0, y], color=style["color"], linewidth=0.8)
        axis.plot(x, y, "+", color=style["color"], markersize=13, mew=2.2, zorder=1.5, label=f"centre, {label}")
    both = np.concatenate((clockwise, anticlockwise, np.zeros((1, 2))))
    half = 0.62 * max(float(np.ptp(both, axis=0).max()), 1e-6)
    middle = 0.5 * (both.min(axis=0) + both.max(axis=0))
    axis.set_xlim(middle[0] - half, middle[0] + half)
    axis.set_ylim(middle[1] - half, middle[1] + half)
    axis.set_aspect("equal")
    # Numbers of a tenth of a millimetre are as wide as the distance between them.
    axis.locator_params(nbins=5)
    if half < 0.02:
        for each in (axis.xaxis, axis.yaxis):
            each.set_major_formatter(lambda metres, _: f"{1000.0 * metres:g}")
    unit = "mm" if half < 0.02 else "m"
    axis.set_xlabel(f"x: absolute less odometric [{unit}]")
    axis.set_ylabel(f"y: absolute less odometric [{unit}]")


def _magnification(reference: Array, believed: list[Array]) -> int:
    """1, 2, 5, 10 ...: how many times as large errors are drawn, for the largest to be seen next to the path."""
    size = float(np.ptp(reference[:, :2], axis=0).max())
    largest = max(float(np.hypot(*(path - reference)[:, :2].T).max()) for path in believed)
    times = 1
    for more in (2, 5, 10, 20, 50, 100, 200, 500, 1000):
        if more * largest <= 0.2 * size:
            times = more
    return times


def plot_attribution(found: Attribution, path: Path) -> None:
    """Draw the effect of each error: estimated paths next to the true one, and shares of the final error.

    Raises
    ------
    RunError
        If it cannot be written.
    """
    figure = Figure(figsize=(12.0, 6.2), layout="constrained")
    paths, sizes, shares = figure.subplots(1, 3, width_ratios=[2.4, 1.0, 1.0], squeeze=False)[0]
    tidy(paths)
    reference = found.reference
    paths.plot(reference[:, 0], reference[:, 1], **(TRUE | {"linewidth": 3.0}))
    paths.plot(*reference[0, :2], "o", mfc="white", mec="#111827", markersize=8, zorder=4)
    cases = [*found.cases, found.together]
    colours = [_COLOURS[i % len(_COLOURS)] for i in range(len(found.cases))] + ["#111827"]
    times = _magnification(reference, [case.believed for case in cases])
    for i, (case, colour) in enumerate(zip(cases, colours, strict=True)):
        dash = "-" if case is found.together else _DASHES[i % len(_DASHES)]
        x, y = (reference + times * (case.believed - reference))[:, :2].T
        paths.plot(x, y, color=colour, linestyle=dash, linewidth=1.4)
        paths.plot(x[-1], y[-1], "D", color=colour, markersize=5)
    paths.set_aspect("equal", adjustable="datalim")
    paths.set_xlabel("x [m]")
    paths.set_ylabel("y [m]")
    scaled = "" if times == 1 else f"; errors drawn {times} times as large"
    paths.set_title(
        f"true path (broad), and where it would be\nbelieved to be by each error alone{scaled}", loc="left", fontsize=10
    )

    names, errors = [case.name for case in cases], [case.error for case in cases]
    _draw_bars(sizes, shares, names, errors, [case.share for case in cases], colours)
    sizes.set_title("final error alone [m]", loc="left", fontsize=10)
    shares.set_title("share of the error of all [%]", loc="left", fontsize=10)
    figure.suptitle(f"what each error does to the odometry of {found.robot}", x=0.01, ha="left")
    save_figure(figure, path, dpi=110)


def plot_readings(found: ReadingAttribution, path: Path) -> None:
    """Draw the effect of each error on a sensor's readings: its size over time, and its share.

    Raises
    ------
    RunError
        If it cannot be written.
    """
    # What a user reads of angles is in degrees.
    scale = math.degrees(1.0) if found.unit.startswith("rad") else 1.0
    unit = found.unit.replace("rad", "deg")
    figure = Figure(figsize=(12.0, 5.0), layout="constrained")
    times, sizes, shares = figure.subplots(1, 3, width_ratios=[2.0, 1.0, 1.0], squeeze=False)[0]
    tidy(times)
    cases = [*found.cases, found.together]
    colours = [_COLOURS[i % len(_COLOURS)] for i in range(len(found.cases))] + ["#111827"]
    for i, (case, colour) in enumerate(zip(cases, colours, strict=True)):
        dash = "-" if case is found.together else _DASHES[i % len(_DASHES)]
        times.plot(found.time, scale * case.by_step, color=colour, linestyle=dash, linewidth=1.2)
    times.set_xlabel("time [s]")
    times.set_ylabel(f"error of a value [{unit}]")
    times.set_ylim(bottom=0.0)
    times.set_title("root mean square of all values and replicas, by step", loc="left", fontsize=10)
    names, errors = [case.name for case in cases], [scale * case.error for case in cases]
    _draw_bars(sizes, shares, names, errors, [case.share for case in cases], colours)
    sizes.set_title(f"alone [{unit}]", loc="left", fontsize=10)
    shares.set_title("share of the error of all [%]", loc="left", fontsize=10)
    figure.suptitle(f"what each error does to the readings of {found.robot}'s {found.sensor}", x=0.01, ha="left")
    save_figure(figure, path, dpi=110)


def _draw_bars(
    sizes: Any, shares: Any, names: list[str], errors: list[float], parts: list[float], colours: list[str]
) -> None:
    """The sizes of errors on one axis, and on another their shares, as bars with numbers."""
    places = np.arange(len(names))
    for axis, values in ((sizes, errors), (shares, [100.0 * part for part in parts])):
        tidy(axis)
        axis.grid(visible=False, axis="y")
        axis.barh(places, values, color=colours)
        axis.set_yticks(places)
        axis.invert_yaxis()
        axis.axvline(0.0, color="#9ca3af", linewidth=0.8)
        low, high = min(0.0, *values), max(0.0, *values)
        room = 0.45 * ((high - low) or 1.0)  # for the numbers
        axis.set_xlim(low - room if low < 0.0 else 0.0, high + room)
    sizes.set_yticklabels(names, fontsize=8)
    shares.set_yticklabels([])
    for place, error, part in zip(places.tolist(), errors, parts, strict=True):
        sizes.annotate(f" {0.0 if error < NOTHING else error:.3g}", (error, place), va="center", fontsize=8)
        text = percent(part)
        ahead = part >= 0.0
        shares.annotate(
            f" {text}" if ahead else f"{text} ",
            (100.0 * part, place),
            va="center",
            ha="left" if ahead else "right",
            fontsize=8,
        )
