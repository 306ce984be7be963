"""A simulation that is played: forward, back, on from there; with what was given to it kept, to be given again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from amorsim.core.errors import AmorsimError
from amorsim.simulation.events import Event
from amorsim.simulation.simulation import Simulation
from amorsim.ui.simulator.carried import Carried, Carrier
from amorsim.ui.simulator.course import Course
from amorsim.ui.simulator.faults import Fault, fault_of
from amorsim.ui.simulator.frames import Before, look_back, moments_of
from amorsim.ui.simulator.inputs import Input, Inputs
from amorsim.ui.simulator.packing import Dynamic, FrameFlag
from amorsim.ui.simulator.past import Pasts
from amorsim.ui.simulator.protocol import EventLine
from amorsim.ui.simulator.story import Story
from amorsim.ui.simulator.timeline import Paths, Snapshots
from amorsim.ui.simulator.writing import Writing

__all__ = ["Player"]

Notice = Callable[[int], None]


class Player:
    """A simulation with its past.

    Parameters
    ----------
    simulation
        At its start, of one replica.
    out
        The folder that it is written into as it goes; one with a number after it where it begins anew, or goes on
        from an earlier moment.
    epoch
        To count on from.
    notice
        Called with the tick while the past is simulated again, which may take long.

    Attributes
    ----------
    epoch
        Rises whenever the recorded past is no longer what it was.
    fault
        Why no step can be made, or None.
    """

    def __init__(
        self, simulation: Simulation, *, out: Path | None = None, notice: Notice | None = None, epoch: int = 0
    ) -> None:
        self.simulation = simulation
        self.epoch = epoch
        self.watched: tuple[int, ...] = (0,)  # robots of which frames tell all
        self.inputs = Inputs()
        self.fault: Fault | None = None
        self._story = Story()
        self.poses_only: int | None = None  # the tick that is shown, where only poses are known of it
        self._notice = notice or (lambda _: None)
        self._present: Any = None  # the snapshot of the present, while the past is shown
        self._newest = 0
        self._is_past = False
        self._before: Before | None = None
        self._changes: dict[tuple[str, str], Any] = {}  # live ones, that outlast a reset
        self._obstacles = sorted(obstacle.name for obstacle in simulation.scenario.obstacles)
        self._writing = Writing(out)
        self._begin(simulation)

    # ------------------------------------------------------------------------------------------------------ beginnings

    def _begin(self, simulation: Simulation) -> None:
        """Take a simulation at its start for the present."""
        self._end_writing()
        self.simulation = simulation
        self.paths = Paths(len(simulation.names))
        self.snapshots = Snapshots()
        self.pasts = Pasts(simulation)
        self._newest = 0
        self._is_past = False
        self._present = self._before = self.poses_only = self.fault = None
        self._story = Story()
        self._left: Course | None = None  # what was left last by going on from the past
        self.epoch += 1
        self._writing.begin(simulation)
        self._keep()
        self.pasts.keep(simulation, self.watched, None)

    def _keep(self) -> None:
        simulation, tick = self.simulation, self._newest
        self.paths.keep(tick, simulation.true_pose, simulation.estimated_pose)
        self.snapshots.keep(simulation, tick)

    def _new(self) -> Simulation:
        return Simulation(self.simulation.scenario, seed=self.simulation.seed)

    def reset(self) -> None:
        """Begin anew, with the parameters that were set, and the robots in their controllers' hands."""
        self._begin(self._new())
        self.inputs = Inputs()
        for (robot, path), value in self._changes.items():
            self.give(Input(tick=0, do="set", robot=robot, path=path, value=value))

    # ------------------------------------------------------------------------------------------------------------ time

    @property
    def tick(self) -> int:
        """The tick that is shown."""
        return self.simulation.tick if self.poses_only is None else self.poses_only

    @property
    def newest(self) -> int:
        """The last tick that was simulated."""
        return self._newest

    @property
    def is_past(self) -> bool:
        """Whether a moment of the past is shown."""
        return self._is_past

    @property
    def last(self) -> int:
        """The tick at which the scenario's duration is over."""
        return self.simulation.steps_of(self.simulation.scenario.duration)

    def step(self, *, watched: bool = True) -> bool:
        """Make a step, and say whether it was made; if not, `fault` tells why.

        Without `watched` no frame can tell the velocities that only two steps together tell.
        """
        if self.fault is not None:
            return False
        self._expect_present()
        simulation = self.simulation
        if watched:
            self._look_back()
        try:
            simulation.step()
        except Exception as error:
            self.fail(fault_of(error))
            return False
        self._newest += 1
        self._write()
        self._keep()
        if watched:
            self.pasts.keep(simulation, self.watched, self._before)
        return True

    def _look_back(self) -> None:
        self._before = look_back(self.simulation, self.pasts.of_whom(self.watched))

    def _write(self) -> None:
        """Write the step down; what can no longer be written does not hold up the simulation."""
        if reason := self._writing.keep():
            self.remark("fault", f"the run is no longer written: {reason}")

    def fail(self, fault: Fault) -> None:
        """Wait for a hand, at the state before the step that failed, for it may have been half made."""
        self.fault = fault
        if not self.snapshots.reason:
            self._go_to(self._newest, lambda _: None)  # to be finished, also where all is about to end
        self.remark("fault", fault.text, robot=", ".join(fault.robots), stack=fault.stack)

    def forgive(self) -> None:
        """Try the step that failed once more when told to go on."""
        self.fault = None

    def _expect_present(self) -> None:
        if self._is_past:
            raise AmorsimError("this is the past; continue from here, or go back to the end first")

    def scrub(self, tick: int | None) -> int:
        """Show a moment of the past, or the present again; returns the tick that is shown.

        It is simulated again from the nearest snapshot. Where there are none, only poses are known.
        """
        wanted = self._newest if tick is None else min(max(0, tick), self._newest)
        if wanted == self._newest:
            self._to_present()
            return wanted
        if not self._is_past:
            if not self.snapshots.reason:
                self._present = self.simulation.snapshot(), self._before
            self._is_past = True
        if self.snapshots.reason:
            self.poses_only = self.paths.at(wanted)[0]
            return self.poses_only
        self._go_to(wanted)
        return wanted

    def _to_present(self) -> None:
        if self._present is not None:
            self.simulation.restore(self._present[0])
            self._before = self._present[1]
        self._present = self.poses_only = None
        self._is_past = False

    def _go_to(self, tick: int, notice: Notice | None = None) -> None:
        nearest = self.snapshots.before(tick)
        assert nearest is not None  # that of tick 0 is never let go
        self.simulation.restore(nearest[1])
        self._before = None
        for now in self.inputs.replay(self.simulation, tick):
            if now == tick - 1:
                self._before = look_back(self.simulation, self.watched)
            (notice or self._notice)(now)

    @property
    def is_exact(self) -> bool:
        """Whether what is shown of the past is where the robots were; not if a controller did otherwise this time."""
        kept_at, kept = self.paths.at(self.tick)
        if not self._is_past or self.poses_only is not None or kept_at != self.tick:
            return True
        now = np.concatenate((self.simulation.true_pose, self.simulation.estimated_pose), axis=1).astype(np.float32)
        return bool(np.array_equal(now, kept))

    @property
    def reason(self) -> str:
        """Why one cannot go on from a moment of the past, or nothing."""
        if self.snapshots.reason:
            return self.snapshots.reason
        if not self.is_exact:
            return "a controller did something else when it was run again (a clock or randomness of its own?)"
        return ""

    def go_on(self) -> int:
        """Take the moment that is shown for the present; returns its tick.

        What came after it is kept for `go_back`, or in its folder where the run is written as it goes.

        Raises
        ------
        AmorsimError
            If one cannot go on from here.
        """
        if not self._is_past:
            return self._newest
        if self.reason:
            raise AmorsimError(f"cannot continue from here: {self.reason}")
        tick, until = self.tick, f"what came after, up to {self._newest * self.simulation.dt:.1f} s, is kept"
        if self._writing.folder is not None:
            until += f" in {self._writing.folder}"
            self.inputs.cut(tick)
            self.resume(tick)
        else:
            self._left = self._course()
            self._newest = tick
            self.inputs = Inputs(self.inputs)
            self.inputs.cut(tick)
            self.paths, self.snapshots, self.pasts = self.paths.copy(), self.snapshots.copy(), self.pasts.copy()
            self.paths.cut(tick)
            self.snapshots.cut(tick)
            self.pasts.cut(tick)
            self._story = self._story.copy()
            self._story.cut(tick, len(self.simulation.events))
            self.epoch += 1
        self._is_past, self._present, self.fault = False, None, None
        self._changes = {}
        for one in self.inputs:
            if one.do == "set":
                self._note_change(one)
        self.remark("continued", f"continued from here; {until}")
        return tick

    def _course(self) -> Course:
        return Course(
            newest=self._newest,
            present=self._present,
            inputs=self.inputs,
            changes=self._changes,
            paths=self.paths,
            snapshots=self.snapshots,
            pasts=self.pasts,
            story=self._story,
        )

    def go_back(self) -> int:
        """Take up the course of events again that `go_on` left last, at its end; returns its tick.

        The one that is left now is kept in its place.

        Raises
        ------
        AmorsimError
            If none is kept.
        """
        left = self._left
        if left is None:
            raise AmorsimError("there is no later history to go back to")
        if self._present is None:
            self._present = self.simulation.snapshot(), self._before
        self._left = self._course()
        until = f"what came instead, up to {self._newest * self.simulation.dt:.1f} s, is kept"
        self._newest, self._present, self._changes = left.newest, left.present, left.changes
        self.inputs = Inputs(left.inputs)
        self.paths, self.snapshots, self.pasts, self._story = left.paths, left.snapshots, left.pasts, left.story
        self.fault = None
        self.epoch += 1
        self._to_present()
        self.remark("continued", f"went back to the later history; {until}")
        return self._newest

    def resume(self, tick: int, carried: Carried | None = None) -> str:
        """Simulate what the inputs say, up to a tick, as though it had been watched; returns from where, in words.

        From the start, or from a snapshot that another process has taken.
        """
        story = self._story
        story.cut(tick, len(self.simulation.events))
        self._begin(self._new())
        self._story = story
        self._changes = {}
        for one in self.inputs:
            if one.do == "set":
                self._note_change(one)
        since = "from the start"
        if carried is not None and self._writing.folder is None:
            try:
                self._take_over(carried)
                since = f"from the snapshot of {carried.tick * self.simulation.dt:.1f} s"
            except AmorsimError as error:
                since += f" ({error})"
                self._begin(self._new())
        self._look_back()
        for now in self.inputs.replay(self.simulation, tick):
            self._newest = now
            self._write()
            self._keep()
            self.pasts.keep(self.simulation, self.watched, self._before)
            self._look_back()
            self._notice(now)
        return since

    def _take_over(self, carried: Carried) -> None:
        """Put a simulation at its start to where another process was; of the past there is the start still."""
        for one in self.inputs:
            if one.do == "set" and one.tick < carried.tick:
                one.give(self.simulation)
        self.simulation.restore(carried.snapshot)
        self._newest = carried.tick
        self.paths.put(carried.paths, carried.stride, carried.tick)

    def carry(self, carrier: Carrier) -> Carried | None:
        """The present for another process to go on from, before anything is given to it; none where that cannot be."""
        if self._writing.folder is not None:
            carrier.reason = "the run is written as it goes"
            return None
        return carrier.take(self.simulation, self._newest, self.paths.stride, self.paths.kept)

    # ---------------------------------------------------------------------------------------------------------- inputs

    def give(self, new: Input) -> None:
        """Give the simulation something before its next step.

        Raises
        ------
        AmorsimError
            If the past is shown, or the simulation does not take it.
        """
        self._expect_present()
        new.give(self.simulation)
        self.inputs.add(new)
        if new.do == "set":
            self._note_change(new)
        elif new.do == "hand_over" and self.fault is not None:
            robots = tuple(name for name in self.fault.robots if not self.simulation.robot(name).is_by_hand)
            if not robots:
                self.fault = None

    def _note_change(self, new: Input) -> None:
        """Keep a change, in place of those that it holds: a chain or an error has all its numbers in it."""
        within = f"{new.path}."
        self._changes = {
            (robot, path): value
            for (robot, path), value in self._changes.items()
            if robot != new.robot or not (path == new.path or path.startswith(within))
        }
        self._changes[new.robot, new.path] = new.value

    def forget_change(self, robot: str, path: str) -> None:
        """Hold a parameter for unchanged: it was set to what the scenario says."""
        self._changes.pop((robot, path), None)

    @property
    def changes(self) -> dict[tuple[str, str], Any]:
        """What was set while it ran, by robot and path."""
        return dict(self._changes)

    # -------------------------------------------------------------------------------------------------------- looking

    def remark(self, kind: str, text: str, *, robot: str = "", stack: str = "") -> None:
        """Keep a line that is no event of the simulation."""
        time = self.tick * self.simulation.dt
        self._story.add(len(self._simulation_events), self.tick, time, kind, text, robot=robot, stack=stack)

    @property
    def remarks(self) -> list[EventLine]:
        """What is no event of the simulation, in order."""
        return self._story.remarks

    @property
    def event_count(self) -> int:
        """How many lines `events` has."""
        return len(self._simulation_events) + len(self._story)

    @property
    def _simulation_events(self) -> Sequence[Event]:
        return self.simulation.events if self._present is None else self._present[0].events

    def events(self) -> list[EventLine]:
        """All that happened up to the present, in the order in which it became known: what is new comes last."""
        return self._story.told(self._simulation_events)

    def frames(self, *, version: int, number: int, speed: float, achieved: float, flags: int) -> list[Dynamic]:
        """The moment that is shown, for each robot that is watched."""
        if self._is_past:
            flags |= FrameFlag.SCRUBBED
        if self.fault is not None:
            flags |= FrameFlag.FAULT
        poses = None
        if self.poses_only is not None:
            flags |= FrameFlag.POSES_ONLY
            poses = self.paths.at(self.poses_only)[1].astype(float)
        moments = moments_of(self.simulation, self.watched, self._before, self._obstacles, poses)
        return [
            moment._replace(
                version=version,
                number=number,
                epoch=self.epoch,
                time=self.tick * self.simulation.dt,
                speed=speed,
                achieved=achieved,
                tick=self.tick,
                newest=self._newest,
                flags=flags,
                events=self.event_count,
            )
            for moment in moments
        ]

    # ---------------------------------------------------------------------------------------------------------- ending

    @property
    def folder(self) -> Path | None:
        """Where it is being written; None where it is not."""
        return self._writing.folder

    def _end_writing(self) -> None:
        if self._writing.folder is not None:
            self._to_present()
            self._writing.end(is_finished=self._newest >= self.last)

    def close(self) -> None:
        """End what is being written, with whole files."""
        self._end_writing()
