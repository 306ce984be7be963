"""A course of events that was left by going on from its past, kept so that it can be taken up again."""

from __future__ import annotations

from typing import Any

import attrs

from amorsim.ui.simulator.frames.protocol import ChangedParameter
from amorsim.ui.simulator.sources.inputs import Inputs
from amorsim.ui.simulator.sources.parameter_changes import Changes
from amorsim.ui.simulator.sources.past import Pasts
from amorsim.ui.simulator.sources.source import Track
from amorsim.ui.simulator.sources.story import Story
from amorsim.ui.simulator.sources.timeline import Paths, Snapshots

__all__ = ["Course"]


@attrs.frozen(kw_only=True)
class Course:
    """All that a player keeps of a simulation's past, and the snapshot of its end, `present`."""

    number: int  # of all courses of a simulation, from 1
    since: int  # the last tick that it shares with the course that is played now
    newest: int  # the last tick that was simulated
    present: Any
    inputs: Inputs
    changes: Changes
    paths: Paths
    snapshots: Snapshots
    pasts: Pasts
    story: Story

    def track(self, robot: int, most: int) -> Track:
        """The past of a robot in this course, at most `most` moments of it."""
        return Track(*self.paths.track(robot, most), self.pasts.of(robot, most))

    def changes_of(self, robot: str) -> list[ChangedParameter]:
        """A robot's parameters that were set after the two courses parted."""
        later = (one for one in self.inputs if one.tick >= self.since and one.do == "set" and one.robot == robot)
        return [{"path": path, "value": value} for path, value in {one.path: one.value for one in later}.items()]
