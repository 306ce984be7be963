"""How the pictures of a run look: one colour and one dash for each channel, and panels below one another."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from amorsim.core.whole_files import write_bytes

__all__ = ["ESTIMATED", "MEASURED", "TRUE", "compare", "legend", "new_figure", "save_figure", "tidy", "unwrapped_gaps"]

Array = npt.NDArray[Any]

# A dash of its own as well, for those who do not see colours; what is true lies below, broad, so that it shows
# beside what is drawn on top of it.
TRUE = {"color": "#1b7f5c", "linestyle": "-", "linewidth": 2.2, "label": "true"}
MEASURED = {"color": "#d97706", "linestyle": ":", "linewidth": 1.4, "label": "measured"}
ESTIMATED = {"color": "#2f6fde", "linestyle": "--", "linewidth": 1.3, "label": "estimated"}

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


def save_figure(figure: Figure, path: Path, *, dpi: int) -> None:
    """Write a figure as a PNG.

    Raises
    ------
    RunError
        If it cannot be written.
    """
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=dpi)
    write_bytes(path, drawn.getvalue())


def tidy(axis: Any) -> None:
    """No frame where nothing is read off, and a faint grid below everything."""
    axis.spines[["top", "right"]].set_visible(False)
    axis.grid(**GRID)
    axis.set_axisbelow(True)


def compare(
    figure: Figure,
    main: Any,
    below: Any,
    true: tuple[Array, Array],
    other: tuple[Array, Array],
    style: dict[str, Any],
) -> None:
    """Draw what is true and what is measured or estimated in one panel, and the second less the first below it.

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


def legend(figure: Figure, axis: Any) -> None:
    """One legend for the whole figure, beside nothing that it could hide."""
    handles, labels = axis.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=len(labels), frameon=False)


def unwrapped_gaps(angles: Array) -> Array:
    """Angles [degrees] in which a line is broken where it would run from one end of the circle to the other."""
    broken = angles.copy()
    with np.errstate(invalid="ignore"):
        broken[1:][np.abs(np.diff(angles)) > 180.0] = np.nan
    return broken
