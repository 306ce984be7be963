"""Events with their time: collisions, ends of controllers, changes from outside."""

from __future__ import annotations

from collections.abc import Mapping

import attrs

__all__ = ["Event"]


@attrs.frozen(kw_only=True)
class Event:
    """Something that happened to a robot or an obstacle.

    `kind` is ``"collision"`` (with `other`, the wall or a body's name; `point` in the world; `speed` [m/s] of the
    robot's or obstacle's base point just before, or of a part's point of contact; and `part` and `other_part` if
    parts of robots met: `amorsim.Part`, empty for the bodies themselves), ``"controller_ended"``,
    ``"report"`` (of its controller: `path` is the word, as ``"goal_reached"``, `value` a number or text),
    ``"pose_set"`` (by `Simulation.set_pose`, to the pose `value`), ``"kidnapped"`` (by its scenario, likewise),
    ``"estimator_failed"`` (`path` is which), ``"handed_over"`` (to `value`), or ``"parameter_set"`` (with `path` and
    `value`).
    `tick` counts the complete steps before it; `time` [s] may lie between two ticks.
    """

    tick: int
    time: float
    replica: int
    kind: str
    name: str
    other: str = ""
    part: str = ""
    other_part: str = ""
    point: tuple[float, float] | None = None
    speed: float | None = None
    path: str = ""
    value: object = None

    def __str__(self) -> str:
        head = f"{self.time:.3f} s: {_of(self.name, self.part)}"
        if self.kind == "collision":
            assert self.point is not None
            assert self.speed is not None
            x, y = self.point
            return f"{head} met {_of(self.other, self.other_part)} at ({x:.3f}, {y:.3f}) m, going {self.speed:.3f} m/s"
        if self.kind == "controller_ended":
            return f"{head}: its controller ended"
        if self.kind == "report":
            words = self.path.replace("_", " ")
            return f"{head} reports: {words}" + ("" if self.value == "" else f", {self.value}")
        if self.kind == "pose_set":
            return f"{head} was put elsewhere"
        if self.kind == "estimator_failed":
            return f"{head}: the numbers of {self.path} exploded; it continues from its last valid state"
        if self.kind == "kidnapped":
            return f"{head} was kidnapped"
        if self.kind == "handed_over":
            return f"{head} was handed over to {'a hand' if self.value == 'hand' else 'its controller'}"
        if isinstance(self.value, list):  # a chain of noise, as tables
            names = ", ".join(str(one.get("name", one.get("use"))) for one in self.value) or "none"
            return f"{head}: {self.path} = {names}"
        if isinstance(self.value, Mapping):  # an error
            return f"{head}: {self.path}: " + ", ".join(f"{key} = {one}" for key, one in self.value.items())
        return f"{head}: {self.path} = {self.value}"


def _of(name: str, part: str) -> str:
    return f"{name}.{part}" if part else name
