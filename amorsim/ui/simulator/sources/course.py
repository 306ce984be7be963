"""A course of events that was left by going on from its past, kept so that it can be taken up again."""

from __future__ import annotations

from typing import Any

import attrs

from amorsim.ui.simulator.sources.inputs import Inputs
from amorsim.ui.simulator.sources.parameter_changes import Changes
from amorsim.ui.simulator.sources.past import Pasts
from amorsim.ui.simulator.sources.story import Story
from amorsim.ui.simulator.sources.timeline import Paths, Snapshots

__all__ = ["Course"]


@attrs.frozen(kw_only=True)
class Course:
    """All that a player keeps of a simulation's past, and the snapshot of its end, `present`."""

    newest: int  # the last tick that was simulated
    present: Any
    inputs: Inputs
    changes: Changes
    paths: Paths
    snapshots: Snapshots
    pasts: Pasts
    story: Story
