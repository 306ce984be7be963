"""The moments of an estimator on a log as a run's folder, which the window plays; nan where truth would be."""

from __future__ import annotations

import math
import os
from types import TracebackType
from typing import Any, Self

import attrs
import numpy as np

from amorsim.contracts import Frame, Recorder, RunInfo
from amorsim.recorders.arrays import Arrays
from amorsim.recorders.text import Text
from amorsim.runs.folder import FORMAT, RunFolder, circumstances
from amorsim.scenario.files.maps import load_map
from amorsim.scenario.files.write import with_copies, write_table
from amorsim.scenario.spec import Recording, Robot, Scenario

__all__ = ["SlamReplay"]

_DT = 0.1  # [s] between two moments, or more in long logs
_MOST_MOMENTS = 20_000
_MAPS = 100  # files of maps and graphs, which are large


class SlamReplay:
    """Writes the moments of an estimator that runs on a log.

    Between two entries of the log the estimate before them holds. As a context manager it removes what it wrote if an
    error ends it, but an interrupt.

    Parameters
    ----------
    folder
        New or empty.
    log
        Name of the log, for ``run.json``.
    duration
        Of the log [s].

    Attributes
    ----------
    folder
        Its path.

    Raises
    ------
    RunError
        If the folder cannot be made or holds something. Each method, too, if a file cannot be written.
    """

    def __init__(self, folder: str | os.PathLike[str], log: str, duration: float) -> None:
        self._dt = _DT * max(1, math.ceil(duration / _DT / _MOST_MOMENTS))
        self._steps = max(1, math.ceil(duration / self._dt))
        self._about: dict[str, Any] = {
            "format": FORMAT,
            "status": "running",
            "log": log,
            "seed": 0,
            "replicas": [0],
            "dt": self._dt,
            "duration": self._steps * self._dt,
            "steps": self._steps,
            "inputs": {},
            **circumstances(),
        }
        self._folder = RunFolder(folder, log, self._about)
        self.folder = self._folder.path
        self._recorders: list[Recorder] = [Text(), Arrays(every=max(1.0, duration / _MAPS))]
        self._frame: Frame | None = None  # of the last update
        self._arrived: set[str] = set()  # sensors with a reading that is not yet written
        self._next = 0  # tick

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for recorder in self._recorders:
            recorder.close()
        if isinstance(error, Exception):  # what an interrupt leaves is kept
            self._folder.give_back()

    def write_until(self, time: float) -> None:
        """Write the moments before a time [s] since the log's first entry, in which the last frame holds."""
        while self._frame is not None and self._next < round(time / self._dt):
            self._write(self._frame)

    def keep(self, frame: Frame) -> None:
        """Take the frame of the update at a time up to which all moments have been written."""
        self._frame = frame
        self._arrived |= {name for name, (_, held) in frame.readings.items() if held.fresh.any()}

    def _write(self, frame: Frame) -> None:
        """Write a frame as the next moment."""
        tick = np.array([[self._next]])
        readings = {
            name: (true, held._replace(stamp=self._stamps(frame, held), fresh=np.array([[name in self._arrived]])))
            for name, (true, held) in frame.readings.items()
        }
        frame = frame._replace(tick=tick[0], time=tick[0] * self._dt, readings=readings)
        for recorder in self._recorders:
            if self._next:
                recorder.write([frame], ())
            else:
                info = RunInfo(folder=self._folder.path, dt=self._dt, replicas=[0], with_sensors=True)
                recorder.open(info, [frame])
        self._arrived.clear()
        self._next += 1

    def _stamps(self, frame: Frame, held: Any) -> Any:
        """The ticks of a reading, in steps of the replay."""
        stamps = np.rint((frame.time[:, None] - held.age) / self._dt).astype(np.int64)
        return np.where(held.stamp < 0, -1, np.maximum(stamps, 0))

    def finish(self, robot: Robot, *, is_whole: bool) -> None:
        """Write the last moment, and what the window draws: the robot, in the world of ``map.yaml`` in the folder.

        Parameters
        ----------
        robot
            That made the log, with the estimator that ran.
        is_whole
            Whether the log was read to its end.
        """
        if self._frame is not None:
            self.write_until(float(self._frame.time[0]) + self._dt)
            robot = attrs.evolve(robot, estimators={name: robot.estimators[name] for name in self._frame.estimates})
        for recorder in self._recorders:
            recorder.close()
        scenario = Scenario(
            map=load_map(self.folder / "map.yaml"),
            robots=(robot,),
            dt=self._dt,
            duration=self._about["duration"],
            recording=Recording(sensors="all"),
        )
        write_table(with_copies(scenario, self.folder), self.folder / "scenario.toml")
        self._about |= {"status": "finished" if is_whole else "interrupted", "steps_done": max(0, self._next - 1)}
        self._folder.write_about(self._about)
