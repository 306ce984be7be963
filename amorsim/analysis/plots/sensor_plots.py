"""The pictures of a sensor's readings: values over time, tables by column, scans as images."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from amorsim.analysis.plots.figures import MEASURED, TRUE, compare, legend, new_figure, tidy, unwrapped_gaps
from amorsim.analysis.run_files import RunFiles
from amorsim.array_types import AnyArray
from amorsim.contracts import Sensor
from amorsim.core.errors import RunError

__all__ = ["draw_sensor"]


MANY = 24  # values of a sensor from which it is drawn as an image


def draw_sensor(files: RunFiles, robot: str, replica: int | None, name: str) -> Figure | None:
    """The readings of one sensor of a robot, true and measured; None if there is no sample."""
    sensor: Sensor = next(each for each in files.scenario.robots if each.name == robot).sensors[name].sensor
    readings = files.table(f"sensors/{name}", robot=robot, replica=replica)
    if not len(readings["time"]):
        return None
    size = sum(key.startswith("true_") for key in readings)
    true, measured = (np.array([readings[f"{channel}_{i}"] for i in range(size)]) for channel in ("true", "measured"))
    true[~np.isfinite(true)] = np.nan  # no return
    measured[~np.isfinite(measured)] = np.nan
    unit, columns = sensor.unit, sensor.columns()
    if columns:
        if size % len(columns):
            raise RunError(
                f"{files.folder / 'sensors' / name}.csv, line 1: is damaged: expected lines of {len(columns)} values "
                f"({', '.join(columns)}), got {size} values"
            )
        return _columns(columns, readings["stamp"], true, measured)
    if unit.startswith("rad"):
        true, measured, unit = np.degrees(true), np.degrees(measured), unit.replace("rad", "°", 1)
    if size > MANY:
        return _scans(unit, readings["stamp"], true, measured)
    if size <= 2:
        return _values(name, unit, readings["stamp"], true, measured)
    return _elements(name, unit, readings["stamp"], true, measured)


def _values(name: str, unit: str, time: AnyArray, true: AnyArray, measured: AnyArray) -> Figure:
    """A panel for each of one or two values, and panels of their differences."""
    size = len(true)
    figure, axes = new_figure(2 * size, height=1.6 + 3.2 * size, ratios=[3, 1] * size)
    for i in range(size):
        main, below = axes[2 * i : 2 * i + 2]
        one, other = true[i], measured[i]
        if unit == "°":
            with np.errstate(invalid="ignore"):
                nearest = one + (other - one + 180.0) % 360.0 - 180.0
            compare(figure, main, below, (time, unwrapped_gaps(one)), (time, unwrapped_gaps(nearest)), MEASURED)
        else:
            compare(figure, main, below, (time, one), (time, other), MEASURED)
        main.set_ylabel(f"{name} {i} [{unit}]" if size > 1 else f"{name} [{unit}]")
    axes[-1].set_xlabel("time [s]")
    return figure


def _columns(columns: Mapping[str, str], time: AnyArray, true: AnyArray, measured: AnyArray) -> Figure:
    """A panel for each column of a table: values of all its lines as dots, of a single line as a curve."""
    lines = len(true) // len(columns)
    figure = Figure(figsize=(9.0, 1.2 + 1.7 * len(columns)), layout="constrained")
    axes: Any = figure.subplots(len(columns), 1, squeeze=False, sharex=True).ravel()
    for i, (column, unit) in enumerate(columns.items()):
        axis = axes[i]
        tidy(axis)
        of_true, of_measured = true[i :: len(columns)].T, measured[i :: len(columns)].T
        if unit == "id":  # an empty slot is none
            axis.yaxis.set_major_locator(MaxNLocator(integer=True))
            of_true, of_measured = (np.where(values < 0, np.nan, values) for values in (of_true, of_measured))
        if unit.startswith("rad"):
            of_true, of_measured, unit = np.degrees(of_true), np.degrees(of_measured), unit.replace("rad", "°", 1)
        for values, style, size in ((of_true, TRUE, 5.0), (of_measured, MEASURED, 2.5)):
            how = style if lines == 1 else {"color": style["color"], "linestyle": "", "marker": ".", "markersize": size}
            drawn = axis.plot(time, values, **{key: value for key, value in how.items() if key != "label"})
            drawn[0].set_label(style["label"])
        axis.set_ylabel(column if unit in ("", "id") else f"{column} [{unit}]", fontsize=9)
    axes[-1].set_xlabel("time [s]")
    legend(figure, axes[0])
    return figure


def _elements(name: str, unit: str, time: AnyArray, true: AnyArray, measured: AnyArray) -> Figure:
    """A ring of a few elements: a small panel for each."""
    columns = 4
    rows = -(-len(true) // columns)
    figure = Figure(figsize=(11.0, 1.2 + 1.9 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
    for i, axis in enumerate(axes):
        if i >= len(true):
            axis.axis("off")
            continue
        tidy(axis)
        axis.plot(time, true[i], **(TRUE | {"linewidth": 1.6}))
        axis.plot(time, measured[i], **(MEASURED | {"linewidth": 1.0}))
        axis.set_title(str(i), fontsize=9, loc="left")
        axis.tick_params(labelsize=8)
    for axis in axes[-columns:]:
        axis.set_xlabel("time [s]", fontsize=9)
    figure.supylabel(f"{name} [{unit}]", fontsize=10)
    legend(figure, axes[0])
    return figure


def _scans(unit: str, time: AnyArray, true: AnyArray, measured: AnyArray) -> Figure:
    """A ring of many beams as images, beam over time: true, measured, and their difference."""
    figure = Figure(figsize=(9.0, 8.5), layout="constrained")
    axes: Any = figure.subplots(3, 1, sharex=True, sharey=True)
    difference = measured - true
    low, high = _range_of(np.concatenate((true, measured)))
    _, limit = _range_of(np.abs(difference))
    last = float(time[-1]) if time[-1] > time[0] else float(time[0]) + 1.0
    for axis, values, title, how in (
        (axes[0], true, "true", {"cmap": "viridis", "vmin": low, "vmax": high}),
        (axes[1], measured, "measured", {"cmap": "viridis", "vmin": low, "vmax": high}),
        (axes[2], difference, "measured less true", {"cmap": "coolwarm", "vmin": -limit, "vmax": limit}),
    ):
        axis.set_facecolor("white")
        image = axis.imshow(
            np.ma.masked_invalid(values),
            aspect="auto",
            origin="lower",
            extent=(float(time[0]), last, -0.5, len(true) - 0.5),
            interpolation="nearest",
            **how,
        )
        axis.set_ylabel("beam")
        axis.set_title(title, fontsize=10, loc="left")
        figure.colorbar(image, ax=axis, label=f"[{unit}]", pad=0.01)
    axes[2].set_xlabel("time [s]      white: no return")
    return figure


def _range_of(values: AnyArray) -> tuple[float, float]:
    finite = values[np.isfinite(values)]
    if not len(finite):
        return 0.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    return low, high if high > low else low + 1e-9
