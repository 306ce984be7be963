"""A run's results in the formats of other programs."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path

from amorsim.analysis.run_files import RunFiles
from amorsim.analysis.trajectory import run_trajectories, write_csv, write_kitti, write_tum
from amorsim.core.arguments import checked, path_of
from amorsim.core.errors import AnalysisError
from amorsim.core.files.atomic_files import replacing
from amorsim.runs.folder import tables_of

__all__ = ["FORMATS", "export_run"]

FORMATS = ("tum", "kitti", "csv", "parquet", "mcap", "rosbag")

_WRITERS: Mapping[str, Callable[..., None]] = {"tum": write_tum, "kitti": write_kitti, "csv": write_csv}


@checked
def export_run(
    run: str | os.PathLike[str],
    kind: str,
    out: str | os.PathLike[str] | None = None,
) -> list[Path]:
    """Write a run's results in another format; returns where the files lie.

    =============  ==================================================================================================
    ``"tum"``      true and estimated trajectories of each robot, replica and estimator, as the TUM benchmark has them
    ``"kitti"``    the same as KITTI has them
    ``"csv"``      the same as ``time,x,y,heading``
    ``"parquet"``  every table of the run, those of plugins too, column by column (needs pyarrow, the extra ``sweep``)
    ``"mcap"``     one file for Foxglove: poses, readings, commands and events of the first replica (needs the extra
                   ``mcap``)
    ``"rosbag"``   a rosbag2, for ROS 2, of the first replica: clock, frames, odometry, truth, readings, commands (needs
                   the extra ``rosbag``, and no ROS)
    =============  ==================================================================================================

    Parameters
    ----------
    out
        The folder, made if it is not there; without it, ``export`` in the run's.

    Raises
    ------
    RunError
        If the folder is not a run's, a file in it is damaged, or a file cannot be written.
    AnalysisError
        If there is no such format, or what it needs is not installed.
    """
    if kind not in FORMATS:
        raise AnalysisError(f"there is no format {kind!r}; expected one of {', '.join(FORMATS)}")
    files = RunFiles(run)
    within = files.folder if out is None else path_of(out, "out")
    folder = within / "export" if out is None else within
    if kind == "parquet":
        return _tables(files, folder, within)
    if kind == "mcap":
        from amorsim.analysis.logs.mcap_file import write_mcap

        path = folder / f"{files.folder.resolve().name}.mcap"
        write_mcap(files, path, within)
        return [path]
    if kind == "rosbag":
        from amorsim.analysis.logs.bag_file import write_bag

        path = folder / f"{files.folder.resolve().name}-rosbag2"
        write_bag(files, path, within)
        return [path]
    return _trajectories(files, folder, kind, within)


def _trajectories(files: RunFiles, folder: Path, kind: str, within: Path) -> list[Path]:
    made: dict[Path, None] = {}
    for replica, robot in files.rows:
        stem = f"{robot}-{replica}" if len(files.replicas) > 1 else robot
        parts = [("true", run_trajectories(files, robot=robot, replica=replica)[0])]
        for estimator in next(each for each in files.scenario.robots if each.name == robot).estimators:
            estimated = run_trajectories(files, robot=robot, replica=replica, estimator=estimator)[1]
            parts.append((estimator, estimated))
        for name, trajectory in parts:
            path = folder / f"{stem}-{name}.{kind}"
            if path in made:
                raise AnalysisError(f"{path}: two trajectories would have this name; rename a robot or an estimator")
            _WRITERS[kind](trajectory, path, within=within)
            made[path] = None
    return list(made)


def _tables(files: RunFiles, folder: Path, within: Path) -> list[Path]:
    try:
        import pyarrow
        from pyarrow import parquet
    except ModuleNotFoundError:
        raise AnalysisError('Parquet needs pyarrow: python -m pip install "amorsim[sweep]"') from None
    made = []
    for file in tables_of(files.folder, files.about.get("inputs", ())):
        name = file.relative_to(files.folder).with_suffix("").as_posix()
        path = folder / f"{name}.parquet"
        # Texts are texts in a table without a line too, so that the tables of several runs fit together.
        columns = {
            key: pyarrow.array(values, pyarrow.string() if values.dtype == object else None)
            for key, values in files.table(name, replica="all").items()
        }
        with replacing(path, within=within) as new:
            parquet.write_table(pyarrow.table(columns), new)
        made.append(path)
    return made
