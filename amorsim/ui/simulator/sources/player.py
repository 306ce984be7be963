"""A simulation that is played: forward, back, and on from there; its inputs are kept, to be given again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.errors import AmorsimError
from amorsim.simulation.simulation import Simulation
from amorsim.ui.simulator.frames.frames import look_back
from amorsim.ui.simulator.process.step_faults import Fault, fault_of
from amorsim.ui.simulator.sources.carried import Carried, Carrier
from amorsim.ui.simulator.sources.course import Course
from amorsim.ui.simulator.sources.inputs import Input, Inputs
from amorsim.ui.simulator.sources.parameter_changes import Changes
from amorsim.ui.simulator.sources.past import Pasts
from amorsim.ui.simulator.sources.simulated import Simulated
from amorsim.ui.simulator.sources.story import Story
from amorsim.ui.simulator.sources.timeline import MOST_BYTES_OF_SNAPSHOTS, Paths, Snapshots
from amorsim.ui.simulator.sources.writing import Writing

__all__ = ["MOST_OTHERS", "Player"]

Notice = Callable[[int], None]

MOST_OTHERS = 4  # courses of events that are kept beside the one that is played


class Player(Simulated):
    """A simulation with its past.

    Parameters
    ----------
    simulation
        Of one replica. Its past begins where it is.
    out
        The folder that it is written into as it goes; with a number after it when it begins again, or goes on from an
        earlier moment.
    epoch
        To count on from.
    notice
        Called with the tick while the past is simulated again, which may take long.
    """

    def __init__(
        self, simulation: Simulation, *, out: Path | None = None, notice: Notice | None = None, epoch: int = 0
    ) -> None:
        super().__init__(simulation, epoch)
        self.inputs = Inputs()
        self._notice = notice or (lambda _: None)
        self._changes = Changes()
        self._writing = Writing(out)
        self._begin(simulation)

    # ------------------------------------------------------------------------------------------------------ beginnings

    def _begin(self, simulation: Simulation) -> None:
        """Take a simulation, as it is, for the present, and for the beginning of its past."""
        self._end_writing()
        self.simulation = simulation
        self._first = simulation.tick
        self.paths = Paths(len(simulation.names), first=self._first)
        self.snapshots = Snapshots(first=self._first)
        self.pasts = Pasts(simulation)
        self._newest = self._first
        self._is_past = False
        self._present = self._before = self.poses_only = self.fault = None
        self._story = Story()
        self._number = 1
        self._others: list[Course] = []  # that were left by going on from the past, the last one last
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
        """Begin again, with the parameters that were set, and the robots in their controllers' hands."""
        self._begin(self._new())
        self.inputs = Inputs()
        for one in self._changes.inputs():
            self.give(one)

    # ------------------------------------------------------------------------------------------------------------ time

    def begin_playing(self) -> None:
        """Go to the present, from which steps are made."""
        if self._is_past:
            self._to_present()

    def step(self, *, watched: bool = True) -> bool:
        """Make a step; returns whether it was made. If not, `fault` is the reason.

        Without `watched` frames lack the velocities that follow from two steps together.
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
        self._stepped(watched=watched)
        return True

    def _stepped(self, *, watched: bool) -> None:
        self._newest += 1
        self._write()
        self._keep()
        if watched:
            self.pasts.keep(self.simulation, self.watched, self._before)

    def _look_back(self) -> None:
        self._before = look_back(self.simulation, self.pasts.of_whom(self.watched))

    def _write(self) -> None:
        """Write the step into the run's folder; if that fails, the simulation goes on."""
        if reason := self._writing.keep():
            self.remark("fault", f"the run is no longer written: {reason}")

    def fail(self, fault: Fault) -> None:
        """Pause at the state before the step that failed, since the step may be half done.

        Where no states can be kept, the robots stay as they are in the middle of the step.
        """
        self.fault = fault
        if not self.snapshots.reason:
            self._go_to(self._newest, lambda _: None)  # to be finished, also where all is about to end
        self.simulation._began = None
        self.remark("fault", fault.text, robot=", ".join(fault.robots), stack=fault.stack)

    def forgive(self) -> None:
        """Try the failed step once more when the simulation goes on."""
        self.fault = None

    def _expect_present(self) -> None:
        if self._is_past:
            raise AmorsimError("this is the past; continue from here, or go back to the end first")

    def scrub(self, tick: int | None) -> int:
        """Show a moment of the past, or the present again; returns the tick that is shown.

        It is simulated again from the nearest snapshot. Where there are none, only poses are known.
        """
        wanted = self._newest if tick is None else min(max(self._first, tick), self._newest)
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
        assert nearest is not None  # the first is never let go
        self.simulation.restore(nearest[1])
        self._before = None
        for now in self.inputs.replay(self.simulation, tick):
            if now == tick - 1:
                self._before = look_back(self.simulation, self.watched)
            (notice or self._notice)(now)

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
        others = [attrs.evolve(other, since=min(other.since, tick)) for other in self._others]
        others = [*others, self._course(tick)][-MOST_OTHERS:]
        while len(others) > 1 and sum(other.snapshots.nbytes for other in others) > MOST_BYTES_OF_SNAPSHOTS:
            del others[0]
        number = 1 + max(self._number, *(other.number for other in others))
        self.inputs = Inputs(self.inputs)
        self.inputs.cut(tick)
        if self._writing.folder is not None:
            until += f" in {self._writing.folder}"
            self.resume(tick)
        else:
            self._newest = tick
            self.paths, self.snapshots, self.pasts = self.paths.copy(), self.snapshots.copy(), self.pasts.copy()
            self.paths.cut(tick)
            self.snapshots.cut(tick)
            self.pasts.cut(tick)
            self._story = self._story.copy()
            self._story.cut(tick, len(self.simulation.events))
            self.epoch += 1
        self._is_past, self._present, self.fault = False, None, None
        self._number, self._others = number, others
        self._changes = Changes.of(self.inputs)
        self.remark("continued", f"continued from here; {until}")
        return tick

    def _course(self, since: int) -> Course:
        return Course(
            number=self._number,
            since=since,
            newest=self._newest,
            present=self._present,
            inputs=self.inputs,
            changes=self._changes,
            paths=self.paths,
            snapshots=self.snapshots,
            pasts=self.pasts,
            story=self._story,
        )

    @property
    def number(self) -> int:
        """Of the course of events that is played."""
        return self._number

    @property
    def others(self) -> Sequence[Course]:
        """The courses of events that were left by going on from the past, at most `MOST_OTHERS`, the last one last."""
        return tuple(self._others)

    @property
    def can_go_back(self) -> bool:
        """Whether one of the `others` can be taken up: not where the run is written as it goes."""
        return self._writing.folder is None

    def forget(self, number: int) -> None:
        """Forget one of the `others`; raises an `AmorsimError` if there is none of this number."""
        self._others.remove(self._other(number))

    def _other(self, number: int) -> Course:
        for other in self._others:
            if other.number == number:
                return other
        raise AmorsimError(f"there is no other future of number {number}")

    def go_back(self, number: int | None = None) -> int:
        """Take up one of the `others` again at its end, by default the one left last; returns its tick.

        The one that is left now is kept in its place.

        Raises
        ------
        AmorsimError
            If it is not kept, or the run is written as it goes.
        """
        if not self.can_go_back:
            raise AmorsimError("there is no later history to go back to: the run is written as it goes")
        if not self._others:
            raise AmorsimError("there is no later history to go back to")
        left = self._others[-1] if number is None else self._other(number)
        if self._present is None:
            self._present = self.simulation.snapshot(), self._before
        others = [attrs.evolve(one, since=min(one.since, left.since)) for one in self._others if one is not left]
        self._others = [*others, self._course(left.since)]
        self._number = left.number
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
        """Simulate the inputs up to a tick, as though it had been watched; returns from where, in words.

        From the start, or from a snapshot that another process has taken.
        """
        story = self._story
        story.cut(tick, len(self.simulation.events))
        self._begin(self._new())
        self._story = story
        self._changes = Changes.of(self.inputs)
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
        """The present state, before any new input, for another process to go on from; None where that cannot be."""
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
        self._changes.note(new)
        if new.do == "hand_over" and self.fault is not None:
            robots = tuple(name for name in self.fault.robots if not self.simulation.robot(name).is_by_hand)
            if not robots:
                self.fault = None

    def forget_change(self, robot: str, path: str) -> None:
        """Take a parameter for unchanged: it was set to the scenario's value."""
        self._changes.forget(robot, path)

    @property
    def changes(self) -> dict[tuple[str, str], Any]:
        """The values set while it ran, by robot and path."""
        return self._changes.values

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
