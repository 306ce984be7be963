"""A plugin whose components have fields that are a component or nothing; it stands alone, so that tests install it."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

import amorsim as am
from amorsim.contracts import Planner
from amorsim.controllers.avoider import Avoider


@attrs.frozen(kw_only=True)
class Careful(am.Controller):
    """Stands still, with whatever it could use to move."""

    speed: float = am.parameter(0.4, unit="m/s", ge=0, help="how fast it would drive")
    avoider: Avoider | None = am.parameter(None, component="controller", help="what would drive along a path")
    spare: am.Controller | None = am.parameter(None, component="controller", help="what would take over")
    planner: Planner | None = am.parameter(
        am.planners.AStar(cell=0.3), component="planner", static=True, help="what would find a way"
    )

    def command(self, robot: Any, readings: Any, estimate: Any, clock: Any, state: Any, draws: Any) -> Any:
        return np.zeros((robot.rows, 2))


@attrs.frozen(kw_only=True)
class Swayed(am.Noise):
    """Adds nothing, with an estimator within it."""

    add: float = am.parameter(0.0, unit="sensor", help="what is added")
    guide: am.Estimator | None = am.parameter(None, component="estimator", help="what it would listen to")
    way: Planner = am.parameter(am.planners.AStar(), component="planner", help="where it would go")

    def corrupt(self, values: Any, side: Any, elapsed: Any, state: Any, draws: Any) -> Any:
        return np.asarray(values) + self.add


@am.hookimpl
def amorsim_register(registry: Any) -> None:
    registry.controller("careful", Careful)
    registry.noise("swayed", Swayed)
