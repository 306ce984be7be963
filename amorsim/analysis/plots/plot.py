"""The pictures of a run, drawn from its files: true, measured and estimated values."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from amorsim.analysis.plots.figures import save_figure
from amorsim.analysis.plots.path_plots import draw_all_paths, draw_path
from amorsim.analysis.plots.pose_traces import read_trace
from amorsim.analysis.plots.replica_plots import draw_all_errors, draw_all_speeds, draw_ends, in_words
from amorsim.analysis.plots.sensor_plots import draw_sensor
from amorsim.analysis.plots.time_plots import draw_error, draw_heading, draw_speed, draw_wheels
from amorsim.analysis.run_files import RunFiles
from amorsim.core.arguments import path_of

__all__ = ["pictures_of", "plot_run", "unfinished"]

Drawn = dict[str, tuple[str, Callable[[], Figure | None]]]

_LONGEST = 60  # of a name within a file's name


def plot_run(
    folder: str | os.PathLike[str],
    *,
    out: str | os.PathLike[str] | None = None,
    robot: str | None = None,
    replica: int | None = None,
) -> list[Path]:
    """Draw a run's pictures of one robot; returns their paths.

    Of one replica ``path``, ``speed``, ``wheels``, ``heading``, ``error``, and ``sensor-<name>`` for each sensor that
    was written; of all replicas together ``path``, ``speed``, ``error`` and ``ends``. Files and titles name the run,
    robot, seed and replica it is: ``<run>-<robot>-seed<seed>-path.png``.

    Parameters
    ----------
    out
        The folder for the pictures; without it, ``plots`` in the run's.
    robot
        Whose; without it, the first's.
    replica
        Which; without it, all of them together, if there are several.

    Raises
    ------
    RunError
        If the folder is not a run's, a file in it is damaged, there is no such robot or replica, or a picture
        cannot be written.
    """
    files = RunFiles(folder)
    name = robot or files.robots[0]
    drawn = pictures_of(files, name, replica)
    within = path_of(folder if out is None else out, "out")
    target = within / "plots" if out is None else within
    stem, who = _file_name(files, name, replica), _who(files, name, replica)
    made = []
    for kind, (what, draw) in drawn.items():
        figure = draw()
        if figure is not None:
            figure.suptitle(_literal(f"{what}\n{who}"), x=0.02, ha="left", fontsize=11)
            path = target / f"{stem}-{_plain(kind)}.png"
            save_figure(figure, path, dpi=120, within=within)
            made.append(path)
    return made


def pictures_of(files: RunFiles, robot: str, replica: int | None) -> Drawn:
    """The pictures of a robot in one replica, or in all together: the name of each, and what draws it.

    What draws returns None where there is nothing to draw.
    """
    return _of_all(files, robot) if replica is None and len(files.replicas) > 1 else _of_one(files, robot, replica)


def unfinished(files: RunFiles) -> str:
    """How far a run came that did not end, in words; empty if it ended."""
    status = files.about["status"]
    if status == "finished":
        return ""
    time = files.table("poses", replica="all")["time"]
    how = "did not end in order" if status == "running" else f"was {status}"
    return f"{how}; its files end at {time.max() if len(time) else 0.0:g} s"


def _of_one(files: RunFiles, name: str, replica: int | None) -> Drawn:
    """The pictures of one replica: the name of each, and what draws it."""
    velocities = files.table("velocities", robot=name, replica=replica)
    trace = read_trace(files, name, files.replicas[0] if replica is None else replica)
    drawn: Drawn = {
        "path": ("path", lambda: draw_path(files, name, replica, trace)),
        "speed": ("translational and rotational speed", lambda: draw_speed(velocities)),
        "wheels": ("joints: mean rate over a step, true and by the encoders", lambda: draw_wheels(velocities)),
        "heading": ("heading, turns counted", lambda: draw_heading(trace)),
        "error": ("estimated less true", lambda: draw_error(trace)),
    }
    own = next(each for each in files.scenario.robots if each.name == name).sensors
    for sensor in files.sensors:
        if sensor in own:
            drawn[f"sensor-{sensor}"] = (sensor, partial(draw_sensor, files, name, replica, sensor))
    return drawn


def _of_all(files: RunFiles, name: str) -> Drawn:
    """The pictures of all replicas together."""
    files.table("events", robot=name, replica="all")  # complains of the robot
    trace = read_trace(files, name, None)
    return {
        "path": ("paths of all replicas", lambda: draw_all_paths(files, name, trace)),
        "speed": ("translational and rotational speed, all replicas", lambda: draw_all_speeds(files, name)),
        "error": (f"estimated less true, all replicas\n{in_words(files, trace)}", lambda: draw_all_errors(trace)),
        "ends": ("where the estimates end, less the true ends, all replicas", lambda: draw_ends(trace)),
    }


def _file_name(files: RunFiles, name: str, replica: int | None) -> str:
    of = (
        "" if len(files.replicas) == 1 else f"{len(files.replicas)}replicas" if replica is None else f"replica{replica}"
    )
    parts = (files.folder.resolve().name, name, f"seed{files.about['seed']}", of)
    return "-".join(_plain(part) for part in parts if part)


def _who(files: RunFiles, name: str, replica: int | None) -> str:
    many = len(files.replicas)
    of = [] if many == 1 else [f"{many} replicas" if replica is None else f"replica {replica} of {many}"]
    ending = unfinished(files)
    parts = (files.folder.resolve().name, name, f"seed {files.about['seed']}", *of)
    return " · ".join([*(part[:_LONGEST] for part in parts), *([f"this run {ending}"] if ending else [])])


def _plain(text: str) -> str:
    """A text as a part of a file's name."""
    return re.sub(r"[^\w.+-]+", "_", text)[:_LONGEST]


def _literal(text: str) -> str:
    """A text that matplotlib shows as it is: without formulas, and in characters that can be shown."""
    return "".join(c if c.isprintable() or c == "\n" else "?" for c in text).replace("$", r"\$")
