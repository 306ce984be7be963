"""A recorded run as a source: its moments are read from its folder, and nothing is simulated."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array
from amorsim.core.errors import RunError
from amorsim.core.files.json_files import parse_json
from amorsim.core.rows import stack
from amorsim.core.unknown_names import no_such
from amorsim.runs.manifest import read_about
from amorsim.runs.tables import Line, read_lines
from amorsim.simulation.events import Event
from amorsim.ui.scene.wire import RobotEntry, Scene
from amorsim.ui.simulator.frames.frames import with_beliefs
from amorsim.ui.simulator.frames.intended import NO_INTENTION, ahead, intended_in
from amorsim.ui.simulator.frames.mapped import mapped_in
from amorsim.ui.simulator.frames.packing import Dynamic, RobotFlag, Selected
from amorsim.ui.simulator.frames.protocol import Intended, Mapped
from amorsim.ui.simulator.sources.past import Places, past_of
from amorsim.ui.simulator.sources.recorded import RecordedFiles
from amorsim.ui.simulator.sources.recorded_scene import RecordedScene
from amorsim.ui.simulator.sources.source import Source, Track

__all__ = ["Recording"]


MOST_EVENTS = 20_000  # of a replica
MOST_OF_PAST = 500  # moments that plots have
MOST_OF_PATH = 2000
MOST_LINES = 400_000  # that are read for a path: runs with many robots or replicas have fewer moments, but 50

_TWIST = ("forward", "left", "turn")


class Recording(Source):
    """The moments of a run's folder, of one replica at a time.

    Parameters
    ----------
    folder
        Of the run.
    epoch
        To count on from.

    Attributes
    ----------
    replica, replicas
        The number of the replica that is shown, and those of all.

    Raises
    ------
    RunError
        If it is not the folder of a run, or ``run.json``, ``scenario.toml`` or ``poses.csv`` cannot be read.
    """

    def __init__(self, folder: Path, *, epoch: int = 0) -> None:
        super().__init__(epoch)
        self._folder = folder
        self._about = read_about(folder, needs_truth=False)
        self.replicas: list[int] = self._about["replicas"]
        self._dt = float(self._about["dt"])
        self._tick = 0
        self._problems: list[str] = []
        self._events: list[Event] = []
        self._files = RecordedFiles(folder, self._dt, self.replicas, self._note)
        try:
            self._newest = self._files.last_tick
            self._scenes = RecordedScene(folder, self._about, self._files)
            self.choose(self.replicas[0])
        except BaseException:
            self._files.close()
            raise

    def _note(self, problem: str) -> None:
        """Keep a problem, for the page to show once."""
        self._problems.append(problem)
        self.remark("fault", problem)

    def choose(self, replica: int) -> None:
        """Show another replica, at the same tick.

        Raises
        ------
        RunError
            If the run has no such replica.
        """
        if replica not in self.replicas:
            raise RunError(f"{self._folder}: {no_such('replica', replica, self.replicas)}")
        self.replica = self._files.replica = replica
        self._events = self._read_events()
        self._scenes.build(replica)
        self._robots: dict[str, RobotEntry] = {robot["name"]: robot for robot in self.scene["robots"]}
        self._resting = self._files.obstacles(0)
        self._tracks: dict[tuple[int, int], Track] = {}
        self.epoch += 1

    @property
    def scene(self) -> Scene:
        """All that stays as it is."""
        return self._scenes.scene

    def picture(self, name: str) -> bytes:
        """The PNG that a map's shape names; raises as `MapShapes.picture`."""
        return self._scenes.picture(name)

    @property
    def damage(self) -> str:
        """The first problem found in its files; empty if there was none."""
        more = len(self._problems) - 1
        return "" if more < 0 else self._problems[0] + (f" (and {more} more, among the events)" if more else "")

    def close(self) -> None:
        """Close the files."""
        self._files.close()

    # ------------------------------------------------------------------------------------------------------------ time

    @property
    def dt(self) -> float:
        """The time step of the run [s]."""
        return self._dt

    @property
    def tick(self) -> int:
        """The tick that is shown."""
        return self._tick

    @property
    def newest(self) -> int:
        """The last tick that was recorded."""
        return self._newest

    @property
    def last(self) -> int:
        """The last tick that was recorded."""
        return self._newest

    def begin_playing(self) -> None:
        """Go to the start, from the end."""
        if self._tick == self._newest:
            self._tick = 0

    def step(self, *, watched: bool = True) -> bool:
        """Go to the next tick; returns whether there is one."""
        if self._tick == self._newest:
            return False
        self._tick += 1
        return True

    def scrub(self, tick: int | None) -> int:
        """Show another moment, or with None the last; returns the tick that is shown."""
        self._tick = self._newest if tick is None else min(max(0, tick), self._newest)
        return self._tick

    # ---------------------------------------------------------------------------------------------------------- events

    @property
    def happened(self) -> Sequence[Event]:
        """The events of the replica."""
        return self._events

    def _read_events(self) -> list[Event]:
        found: list[Event] = []
        path = self._folder / "events.csv"
        if not path.exists():
            return found
        try:
            for line in read_lines(path):
                if len(self.replicas) > 1 and line.whole("replica") != self.replica:
                    continue
                if len(found) == MOST_EVENTS:
                    self._note(f"{path}: only the first {MOST_EVENTS} events are listed")
                    break
                with self._noting():
                    found.append(_event(line, self.replica))
        except RunError as error:
            self._note(f"{error}; what follows it is not listed")
        return found

    @contextlib.contextmanager
    def _noting(self) -> Iterator[None]:
        """A block in which a problem is noted in a line, and work goes on."""
        try:
            yield
        except RunError as error:
            self._note(str(error))

    @property
    def by_hand(self) -> list[str]:
        """The robots that were driven by hand."""
        hands = {one.name: one.value == "hand" for one in self._events_until_now() if one.kind == "handed_over"}
        return [name for name in self.names if hands.get(name)]

    def _events_until_now(self) -> list[Event]:
        return [event for event in self._events if event.tick <= self._tick]

    def _flags(self) -> npt.NDArray[np.uint8]:
        ended = {event.name for event in self._events_until_now() if event.kind == "controller_ended"}
        met = {event.name for event in self._events if event.kind == "collision" and event.tick == self._tick}
        by_hand = set(self.by_hand)
        return np.array(
            [
                (RobotFlag.TOUCHING if name in met else 0)
                | (RobotFlag.ENDED if name in ended else 0)
                | (RobotFlag.BY_HAND if name in by_hand else 0)
                for name in self.names
            ],
            dtype=np.uint8,
        )

    # --------------------------------------------------------------------------------------------------------- looking

    @property
    def names(self) -> Sequence[str]:
        """The robots' names, in the order of the scene."""
        return list(self._robots)

    def _kind(self, robot: str) -> Any:
        return self.scene["kinds"][self._robots[robot]["kind"]]

    def _estimators(self, robot: str) -> list[str]:
        return [*self._kind(robot)["estimators"]]

    def moments(self) -> list[Dynamic]:
        """The moment that is shown, for each robot that is watched."""
        tick, names = self._tick, self.names
        poses = self._stacked(self._files.poses(tick), 6)
        moment = Dynamic(
            version=0,
            number=0,
            epoch=0,
            time=0.0,
            speed=1.0,
            achieved=0.0,
            tick=tick,
            newest=0,
            oldest=0,
            flags=0,
            events=0,
            selected_robot=0,
            true_pose=poses[:, :3],
            estimated_pose=poses[:, 3:],
            covariance=self._covariances(tick),
            obstacle_pose=self._bodies(tick),
            robot_flags=self._flags(),
            selected=Selected(*[np.empty(0)] * 8),
        )
        watched = [robot for robot in self.watched if robot < len(names)] or [0]
        return [
            moment._replace(
                selected_robot=robot,
                selected=with_beliefs(
                    self._selected(names[robot], tick),
                    self._files.beliefs(tick, names[robot], self._estimators(names[robot])),
                    0,
                ),
            )
            for robot in watched
        ]

    def _stacked(self, found: dict[str, Array], width: int) -> Array:
        nothing = np.full(width, np.nan)
        return np.array([found.get(name, nothing) for name in self.names]).reshape(-1, width)

    def _covariances(self, tick: int) -> Array:
        """The covariances of the estimator whose pose each robot's controller was given."""
        first = {name: next(iter(self._estimators(name)), "none") for name in self.names}
        found = {estimator: self._files.covariances(estimator, tick) for estimator in dict.fromkeys(first.values())}
        return self._stacked({name: found[first[name]][name] for name in self.names if name in found[first[name]]}, 6)

    def _bodies(self, tick: int) -> Array:
        """Poses of obstacles and after them of the robots' parts, in the order of the scene."""
        found = self._resting | self._files.obstacles(tick)
        if any("part_of" in body for body in self.scene["obstacles"]):
            found |= self._files.parts(tick)
        nothing = np.full(3, np.nan)
        return np.array([found.get(body["name"], nothing) for body in self.scene["obstacles"]]).reshape(-1, 3)

    def _selected(self, robot: str, tick: int) -> Selected:
        """The recorded values of a robot; nan for what was not recorded."""
        kind = self._kind(robot)
        readings = [self._files.reading(one["name"], tick, robot, one["size"]) for one in kind["sensors"]]
        joints = kind["joints"]
        columns = [*(f"{which}_{part}" for which in ("true", "estimated") for part in _TWIST)]
        columns += [f"{which}_{joint}" for which in ("true", "measured") for joint in joints]
        rates = self._files.values("velocities", tick, robot, columns)
        nothing = np.empty(0)
        return Selected(
            true=np.concatenate([nothing, *(true for true, _, _ in readings)]),
            measured=np.concatenate([nothing, *(measured for _, measured, _ in readings)]),
            age=np.array([age for _, _, age in readings]),
            true_rates=rates[6 : 6 + len(joints)],
            measured_rates=rates[6 + len(joints) :],
            true_twist=rates[:3],
            estimated_twist=rates[3:6],
            command=self._files.values("commands", tick, robot, [channel["name"] for channel in kind["channels"]]),
            parts=np.full(3 * sum(body.get("part_of") == robot for body in self.scene["obstacles"]), np.nan),
        )

    def mapped(self, robot: str) -> list[Mapped]:
        """The beliefs of each estimator of a robot that maps or matches, as they were written last."""
        return mapped_in(self._files.beliefs(self._tick, robot, self._estimators(robot)), 0)

    def intended(self, robot: str) -> Intended:
        """The intentions of a robot's controller when its beliefs were written last, where the robot was then."""
        at, beliefs = self._files.beliefs_of("controller", self._tick, robot)
        spec = next((one for one in self._scenes.partial.robots if one.name == robot), None)
        poses = self._files.poses(at, robot).get(robot)
        if not beliefs or spec is None or poses is None:
            return NO_INTENTION
        kinds = {one["name"]: one for one in self._kind(robot)["sensors"]}
        measured = (
            (stack([mounted.sensor]), self._files.reading(name, at, robot, kinds[name]["size"])[1][None])
            for name, mounted in spec.sensors.items()
            if name in kinds and hasattr(mounted.sensor, "angles")
        )
        pose = ahead(stack([spec.drive]), measured, 1, 0, poses[3:])
        return intended_in(beliefs, 0, pose, spec.controller, is_empty=robot in self.by_hand)

    def track(self, robot: int, most: int) -> Track:
        """The path of a robot through the whole run, and fewer moments of all else."""
        key = robot, most
        if key not in self._tracks:
            rows = len(self.names) * len(self.replicas)
            self._tracks[key] = self._read_track(self.names[robot], min(most, max(50, MOST_LINES // rows)))
        return self._tracks[key]

    def _read_track(self, robot: str, most: int) -> Track:
        nothing = np.full(6, np.nan)
        ticks = _spread(self._newest, min(most, MOST_OF_PATH))
        poses = np.array([self._files.poses(tick, robot).get(robot, nothing) for tick in ticks])
        known = np.isfinite(poses[:, 3:] if "log" in self._about else poses).all(axis=1)
        kind = self._kind(robot)
        places = Places((one["size"], len(one["columns"])) for one in kind["sensors"])
        estimator = next(iter(kind["estimators"]), "none")
        few = _spread(self._newest, min(max(50, most // 4), MOST_OF_PAST))
        lines = [
            places.line(
                np.concatenate(
                    (
                        self._files.poses(tick, robot).get(robot, nothing),
                        self._files.covariances(estimator, tick, robot).get(robot, nothing),
                    )
                ),
                self._selected(robot, tick),
            )
            for tick in few
        ]
        return Track(np.array(ticks)[known].tolist(), poses[known], past_of(few, np.array(lines)))


def _spread(last: int, most: int) -> list[int]:
    """At most `most` ticks from 0 to the last, at equal distances, including the last."""
    every = max(1, math.ceil((last + 1) / max(most, 2)))
    return list(range(last, -1, -every))[::-1]


def _event(line: Line, replica: int) -> Event:
    """The event of a line of ``events.csv``."""
    cells = line.cells
    value: object = cells.get("value", "")
    with contextlib.suppress(ValueError):
        value = parse_json(str(value)) if value else None
    has_point = bool(cells.get("x") and cells.get("y"))
    if cells.get("kind") == "collision" and not (has_point and cells.get("speed")):
        raise line.damaged("x", "expected the point and the speed of a collision")
    return Event(
        tick=line.whole("tick"),
        time=line.real("time"),
        replica=replica,
        kind=line.text("kind"),
        name=line.text("robot"),
        other=cells.get("other", ""),
        part=cells.get("part", ""),
        other_part=cells.get("other_part", ""),
        point=(line.real("x"), line.real("y")) if has_point else None,
        speed=line.real("speed") if cells.get("speed") else None,
        path=cells.get("path", ""),
        value=value,
    )
