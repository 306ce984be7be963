"""How the pictures of a run look: one colour and one dash for each channel, and panels below one another."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from amorsim.array_types import AnyArray
from amorsim.core.files.atomic_files import write_bytes

__all__ = [
    "ESTIMATED",
    "MEASURED",
    "OTHERS",
    "TRUE",
    "band",
    "compare",
    "draw_ellipse",
    "legend",
    "new_figure",
    "save_figure",
    "tidy",
    "unwrapped_gaps",
]


# Each line also has a dash pattern of its own, for readers who do not see colours. The true line is below and broad,
# so that it shows on both sides of the lines on top of it.
TRUE = {"color": "#1b7f5c", "linestyle": "-", "linewidth": 2.2, "label": "true"}
MEASURED = {"color": "#d97706", "linestyle": ":", "linewidth": 1.4, "label": "measured"}
ESTIMATED = {"color": "#2f6fde", "linestyle": "--", "linewidth": 1.3, "label": "estimated"}
# Of second estimators, third ones and so on.
OTHERS: tuple[dict[str, Any], ...] = (
    {"color": "#a21caf", "linestyle": "-.", "linewidth": 1.3},
    {"color": "#0e7490", "linestyle": (0, (5, 1, 1, 1, 1, 1)), "linewidth": 1.3},
    {"color": "#854d0e", "linestyle": (0, (1, 1)), "linewidth": 1.5},
)

GRID = {"color": "#e5e7eb", "linewidth": 0.8}


def new_figure(rows: int = 1, *, height: float = 5.0, ratios: list[float] | None = None) -> tuple[Figure, list[Any]]:
    """A figure with panels below one another that share the time axis.

    Without pyplot: no window system is asked for, and nothing is kept open.
    """
    figure = Figure(figsize=(9.0, height), layout="constrained")
    axes = figure.subplots(rows, 1, squeeze=False, sharex=True, height_ratios=ratios)[:, 0]
    for axis in axes:
        tidy(axis)
    return figure, list(axes)


def save_figure(figure: Figure, path: Path, *, dpi: int, within: Path | None = None) -> None:
    """Write a figure as a PNG; `within` is that of `amorsim.core.files.atomic_files.replacing`.

    Raises
    ------
    RunError
        If it cannot be written.
    """
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=dpi)
    write_bytes(path, drawn.getvalue(), within=within)


def tidy(axis: Any) -> None:
    """Remove the frame where nothing is read off, and draw a faint grid below everything."""
    axis.spines[["top", "right"]].set_visible(False)
    axis.grid(**GRID)
    axis.set_axisbelow(True)


def compare(
    figure: Figure,
    main: Any,
    below: Any,
    true: tuple[AnyArray, AnyArray],
    other: tuple[AnyArray, AnyArray],
    style: dict[str, Any],
) -> None:
    """Draw the true and the measured or estimated values in one panel, and their difference below.

    `true` and `other` are times [s] and values each; the difference is drawn where both are of one time.
    """
    main.plot(*true, **TRUE)
    main.plot(*other, **style)
    with np.errstate(invalid="ignore"):  # no return in either
        difference = other[1] - true[1]
    below.plot(true[0], difference, color=style["color"], linewidth=0.9)
    below.set_ylabel(f"{style['label']}\nless true", fontsize=8)
    below.tick_params(labelsize=8)
    if not figure.legends:
        legend(figure, main)


def legend(figure: Figure, *axes: Any) -> None:
    """One legend for all panels, below the figure; equal labels appear once."""
    entries: dict[str, Any] = {}
    for axis in axes:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    if not entries:
        return
    widest = max(map(len, entries))
    columns = max(1, min(len(entries), int(12.0 * figure.get_figwidth()) // (widest + 7)))
    figure.legend(entries.values(), entries, loc="outside lower center", ncols=columns, frameon=False)


def band(axis: Any, time: AnyArray, low: AnyArray, high: AnyArray, style: dict[str, Any], label: str) -> None:
    """A light area between two curves, in the colour of a style."""
    axis.fill_between(time, low, high, color=style["color"], alpha=0.16, linewidth=0.0, zorder=1, label=label)


def draw_ellipse(axis: Any, place: AnyArray, covariance: AnyArray, style: dict[str, Any], **how: Any) -> None:
    """The ellipse of one standard deviation around a place (2,) [m]; none if the covariance (2, 2) has none."""
    if not np.isfinite(covariance).all() or not np.isfinite(place).all():
        return
    sizes, axes = np.linalg.eigh(covariance)
    if not sizes[1] > 0.0:
        return
    angle = np.linspace(0.0, 2.0 * np.pi, 73)
    ring = np.sqrt(np.maximum(sizes, 0.0))[:, None] * np.array([np.cos(angle), np.sin(angle)])
    x, y = place[:, None] + np.sum(axes[:, :, None] * ring[None], axis=1)
    axis.plot(x, y, color=style["color"], linewidth=0.9, **how)


def unwrapped_gaps(angles: AnyArray) -> AnyArray:
    """Angles [degrees], with nan where a line would run from one end of the circle to the other."""
    broken = angles.copy()
    with np.errstate(invalid="ignore"):
        broken[1:][np.abs(np.diff(angles)) > 180.0] = np.nan
    return broken
