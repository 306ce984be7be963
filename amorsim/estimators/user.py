"""A user's own estimator: a plain class of one robot, as `amorsim grade` takes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import attrs
import numpy as np

from amorsim.array_types import AnyArray, Array
from amorsim.contracts import Beliefs, Context, Draws, Estimate, Estimator, Measurement, RobotModel, State
from amorsim.core.error_text import RAISED, in_words
from amorsim.core.errors import ComponentError
from amorsim.core.one_robot import PoseVector, RobotReadings
from amorsim.core.user_code import UserCode

__all__ = ["UserEstimator"]


@attrs.frozen(kw_only=True)
class UserEstimator(UserCode, Estimator):
    """Runs objects of a user's class, one for each robot.

    An object is made as ``Class(start=pose, **options)``: `pose` is where the robot believes that it starts, an array
    `(3,)` with `x`, `y` [m] and `heading` [rad]; nan if it knows nothing. Its method is called as
    ``update(readings, command, elapsed)`` with

    - ``readings[name]``: a `RobotReading` with `measured` `(k,)`, `stamp`, `age` [s], `fresh`;
    - ``command``: the command of this step `(c,)`;
    - ``elapsed``: the time since the previous update [s], 0 at the first.

    These are copies and may be kept. The return value is the estimated pose `(3,)`, or that and a covariance `(3, 3)`.

    A class may also have ``beliefs(self)``, which returns arrays by name: what else it believes, such as the particles
    or the map that the window draws. It is called where somebody looks.
    """

    kind: ClassVar[str] = "estimator"
    signature: ClassVar[str] = "update(self, readings, command, elapsed)"

    def failure(self, message: str, name: str) -> ComponentError:
        """A `ComponentError`."""
        return ComponentError(message)

    def idle(self) -> Any:
        """A class that keeps the pose of the start."""
        return _Standing

    def try_out(self) -> None:
        """Make an object that starts at the origin."""
        self.make_objects(1, lambda _: "a try", lambda _: {"start": np.zeros(3).view(PoseVector)})

    def start(self, context: Context) -> State:
        """An object of the class for each row, ``state["objects"]`` `(N,)`.

        Raises
        ------
        ComponentError
            If it is not a class, an object cannot be made, or has no method `update`.
        """
        starts = context.pose.copy().view(PoseVector)
        state = self.make_objects(context.rows, context.robot.who, lambda row: {"start": starts[row]})
        if not state:
            raise ComponentError(f"{self.title}: expected a class with {self.signature}, got a function")
        return dict(state)

    def update(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        command: Array,
        elapsed: Array,
        state: State,
        draws: Draws,
    ) -> Estimate:
        """The estimates of all rows.

        Raises
        ------
        ComponentError
            If the user's code raises, or returns no pose.
        """
        method_of = self.asker(state)
        now = dict(readings)
        commands = command.copy()
        pose, covariance = np.empty((robot.rows, 3)), np.empty((robot.rows, 3, 3))
        for row in range(robot.rows):
            try:
                answer = method_of(row)(RobotReadings(now, row), commands[row], elapsed.item(row))
            except RAISED as error:
                raise self.raised(error, robot.who(row), None, "") from error
            pose[row], covariance[row] = self._checked(answer, robot.who(row))
        return Estimate(pose, covariance)

    def beliefs(self, state: State) -> Beliefs:
        """The objects' beliefs besides the pose, stacked over the rows; empty if the class has no such method.

        Where an object has fewer numbers than another, as particles, the rest is nan.

        Raises
        ------
        ComponentError
            If the user's code raises, or returns something else than arrays by name.
        """
        found: list[dict[str, Array]] = []
        for row, made in enumerate(state.get("objects", ())):
            if not hasattr(made, "beliefs"):
                return {}
            try:
                given = made.beliefs()
                found.append({str(name): _as_belief(values) for name, values in dict(given).items()})
            except RAISED as error:
                raise self.raised(error, f"row {row}, its beliefs,", None, "") from error
        return {name: _stacked([each.get(name, np.empty(0)) for each in found]) for name in found[0]} if found else {}

    def _checked(self, answer: Any, who: str) -> tuple[Array, Array]:
        """The pose and the covariance of an answer."""
        try:
            given = answer if isinstance(answer, tuple) and len(answer) == 2 else (answer, np.zeros((3, 3)))
            pose, covariance = (np.asarray(part, dtype=np.float64) for part in given)
        except RAISED:
            pose = covariance = np.empty(0)
        if pose.shape != (3,) or covariance.shape != (3, 3) or not np.isfinite(pose).all():
            raise ComponentError(
                f"{self.title} of {who} returned {in_words(answer)}; expected a pose (x, y, heading) of finite numbers "
                "[m, m, rad], or that and its covariance (3, 3)"
            )
        return pose, covariance


def _as_belief(values: Any) -> AnyArray:
    """A belief of one robot, of a type that beliefs may have."""
    array = np.asarray(values)
    return array.copy() if array.dtype in (np.bool_, np.int64) else array.astype(np.float64)


def _stacked(parts: Sequence[AnyArray]) -> AnyArray:
    """Arrays as the rows of one array; smaller ones are filled up with nan."""
    if len({part.shape for part in parts}) == 1:
        return np.stack(parts)
    whole = np.full((len(parts), *(max(sizes) for sizes in zip(*(part.shape for part in parts), strict=True))), np.nan)
    for row, part in enumerate(parts):
        place: tuple[Any, ...] = (row, *map(slice, part.shape))
        whole[place] = part
    return whole


class _Standing:
    """Believes that the robot stays where it starts."""

    def __init__(self, start: Array, **_: Any) -> None:
        self.pose = np.nan_to_num(start)

    def update(self, *_: Any) -> Array:
        return self.pose
