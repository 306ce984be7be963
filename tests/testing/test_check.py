"""Each check fails for a component that is broken in just that way, and a whole one passes."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import attrs
import numpy as np
import numpy.typing as npt
import pytest

import amorsim as am
from amorsim.contracts import (
    Aim,
    Clock,
    Context,
    Controller,
    Draws,
    Drive,
    Estimate,
    Estimator,
    Frame,
    Joint,
    MapLoader,
    Measurement,
    Motion,
    Noise,
    ObstacleFrame,
    Part,
    Recorder,
    RobotModel,
    RunInfo,
    Sensor,
    SensorBinding,
    State,
    View,
    parameter,
)
from amorsim.core.errors import ComponentError, MapError
from amorsim.core.maps.map import Map
from amorsim.sensors.fiducial import Fiducial
from amorsim.testing import check_component, example, variants
from amorsim.testing.rig import Rig
from tests import building

Array = npt.NDArray[np.float64]

frozen = functools.partial(attrs.frozen, kw_only=True)


# ------------------------------------------------------------------------------------------------ whole components


@frozen
class Drift(Noise):
    """Adds a walk."""

    std: float = parameter(0.1, unit="sensor", ge=0, help="of a step")

    def start(self, context: Context) -> State:
        return {"walk": np.zeros((context.rows, context.size))}

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        state["walk"] = state["walk"] + self.std * draws.normal(values.shape[1])
        return values + state["walk"]


@frozen
class Range(Sensor):
    """Distances straight ahead and astern."""

    unit: ClassVar[str] = "m"

    range_max: float = parameter(5.0, unit="m", gt=0, help="longest range")

    def size(self, drive: Drive) -> int:
        return 2

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        return view.cast(view.pose, np.array([[0.0, np.pi]]), self.range_max), {}


@frozen
class Cart(Drive):
    """Two wheels."""

    joints: ClassVar[tuple[Joint, ...]] = (Joint(name="left"), Joint(name="right"))
    channels: ClassVar[tuple[str, ...]] = ("left", "right")

    radius: float = parameter(0.1, unit="m", gt=0, help="of both wheels")
    track: float = parameter(0.4, unit="m", gt=0, help="between them")

    def advance(
        self, joints: Array, rates: Array, command: Array, dt: float, state: State, draws: Draws
    ) -> tuple[Array, Array]:
        return joints + command * dt, command.copy()

    def twist(self, before: Array, after: Array) -> Array:
        left, right = (after - before)[:, :1] * self.radius, (after - before)[:, 1:] * self.radius
        return np.concatenate((0.5 * (left + right), 0.0 * left, (right - left) / self.track), axis=1)

    def command_for(self, twist: Array, joints: Array) -> Array:
        half = 0.5 * self.track * twist[:, 2:]
        return np.concatenate((twist[:, :1] - half, twist[:, :1] + half), axis=1) / self.radius

    def rolling_radius(self) -> Array:
        return np.concatenate((self.radius, self.radius), axis=1)


@frozen
class Crane(Cart):
    """A boom that turns above its base."""

    joints: ClassVar[tuple[Joint, ...]] = (*Cart.joints, Joint(name="boom", rolls=False))
    channels: ClassVar[tuple[str, ...]] = (*Cart.channels, "boom")
    parts: ClassVar[tuple[Part, ...]] = (Part("boom", am.Shape.rectangle(0.6, 0.1, x=0.3)),)

    ahead: float = parameter(0.1, unit="m", ge=0, help="from the base point to the boom's axis")

    def twist(self, before: Array, after: Array) -> Array:
        return super().twist(before[:, :2], after[:, :2])

    def command_for(self, twist: Array, joints: Array) -> Array:
        return np.concatenate((super().command_for(twist, joints), np.zeros((len(twist), 1))), axis=1)

    def part_poses(self, joints: Array) -> Array:
        poses = np.zeros((len(joints), 1, 3))
        poses[:, :, 0] = self.ahead
        poses[:, 0, 2] = joints[:, 2]
        return poses

    def part_travel(self, before: Array, after: Array) -> Array:
        travel = self.travel(before, after)
        way = travel[:, :1] + self.ahead * travel[:, 1:]
        return np.stack((way, travel[:, 1:] + np.abs(after - before)[:, 2:]), axis=2)


@frozen
class StaysPut(Estimator):
    """Stays at its start, ever less sure."""

    growth: float = parameter(0.1, unit="m^2/s", ge=0, help="of the variances")

    def start(self, context: Context) -> State:
        return {"pose": context.pose.copy(), "age": np.zeros((context.rows, 1))}

    def update(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        command: Array,
        elapsed: Array,
        state: State,
        draws: Draws,
    ) -> Estimate:
        state["age"] = state["age"] + elapsed
        return Estimate(state["pose"].copy(), self.matrix(state["age"] * self.growth))

    def matrix(self, variance: Array) -> Array:
        return variance[:, :, None] * np.eye(3)


@frozen
class Ahead(Controller):
    """Drives on."""

    speed: float = parameter(0.3, unit="m/s", help="forward")

    def command(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        estimate: Estimate,
        clock: Clock,
        state: State,
        draws: Draws,
    ) -> Array:
        twist = np.concatenate((self.speed, 0.0 * self.speed, 0.0 * self.speed), axis=1)
        return robot.drive.command_for(twist, np.zeros((robot.rows, len(robot.drive.joints))))


@frozen
class Slide(Motion):
    """Slides along."""

    speed: float = parameter(0.3, unit="m/s", help="forward")

    def propose(self, view: View, dt: float, state: State, draws: Draws) -> Array:
        return np.concatenate((self.speed * dt, 0.0 * self.speed, 0.0 * self.speed), axis=1)


@frozen
class Text(MapLoader):
    """Walls, one a line."""

    extensions: ClassVar[tuple[str, ...]] = (".walls",)

    resolution: float = parameter(0.1, unit="m", gt=0, help="side of a cell")

    def load(self, path: Path) -> Map:
        try:
            walls = [[float(word) for word in line.split()] for line in path.read_text("ascii").splitlines()]
        except (OSError, ValueError) as error:
            raise MapError(f"{path}: {error}") from error
        return Map.from_segments(np.array(walls).reshape(-1, 4), resolution=self.resolution)


@pytest.mark.parametrize("cls", [Drift, Range, Cart, Crane, StaysPut, Ahead, Slide, Text])
def test_whole_components_pass(cls: type) -> None:
    check_component(cls)
    check_component(cls())


def test_map_loader_is_tried_with_a_file_of_its_own(tmp_path: Path) -> None:
    file = tmp_path / "room.walls"
    file.write_text("0 0 1 0\n1 0 1 1\n")
    check_component(Text, path=file)


# ----------------------------------------------------------------------------------------------- broken components


def _corrupted(self: Any, values: Array, state: State, draws: Draws) -> Array:
    return Drift.corrupt(self, values, {}, np.zeros((len(values), 1)), state, draws)


@attrs.frozen
class Positional(Drift):
    size: float = parameter(0.1, help="a field that need not be named")


@frozen
class Mute(Drift):
    size: float = parameter(0.1)


@frozen
class Degrees(Drift):
    angle: float = parameter(0.1, unit="deg", help="in degrees")


class Sealed(Drift):
    def __reduce__(self) -> Any:
        raise TypeError("no")


Sealed = frozen(Sealed)  # type: ignore[misc]


@frozen
class ListState(Drift):
    def start(self, context: Context) -> State:
        return {"walk": [0.0] * context.rows}  # type: ignore[dict-item]


@frozen
class SharedState(Drift):
    def start(self, context: Context) -> State:
        return {"walk": np.zeros((context.size, context.rows))}


@frozen
class GrowingState(Drift):
    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        state["walk"] = np.concatenate((state["walk"], values), axis=1)
        return values


@frozen
class NewKey(Drift):
    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        state["last"] = values.copy()
        return values


@frozen
class SinglePrecision(Drift):
    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        state["walk"] = np.zeros(values.shape, dtype=np.float32)
        return values


@frozen
class Raises(Drift):
    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        return values + side["incidence"]


@frozen
class Narrow(Drift):
    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        return values[:, :1].copy()


@frozen
class Half(Drift):
    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        return values.astype(np.float32)  # type: ignore[return-value]


@frozen
class WritesValues(Drift):
    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        values += self.std
        return values


@frozen
class WritesFields(Drift):
    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        self.std[:] = 0.0  # type: ignore[index]
        return values


@attrs.frozen(kw_only=True, slots=False)
class KeepsOnItself(Drift):
    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        object.__setattr__(self, "last", values)
        return values


@frozen
class RewritesResult(Drift):
    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        state["walk"][:] = values
        return state["walk"]


COUNT = {"calls": 0}


@frozen
class Forgetful(Drift):
    """Other bits in each run."""

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        COUNT["calls"] += 1
        return values + COUNT["calls"]


@frozen
class HiddenState(Drift):
    """The same bits in each run, but not when it goes on from a copy of the state."""

    def start(self, context: Context) -> State:
        COUNT["calls"] = 0
        return {}

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        COUNT["calls"] += 1
        return values + COUNT["calls"]


@frozen
class LooksAtOthers(Drift):
    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        return values + 1e-12 * len(values)


@frozen
class ConfusesRowsWithValues(Drift):
    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        offset = np.arange(values.shape[1], dtype=float)
        return values + (offset[:, None] if values.shape == (len(offset),) * 2 else offset)


@frozen
class LooksAhead(Drift):
    def aim(self, aim: Aim, elapsed: Array, state: State, draws: Draws) -> Aim:
        later = np.full(state["walk"].shape, 0.01)
        return aim._replace(time=later if aim.time is None else aim.time + later)


@frozen
class SharedTime(Drift):
    def aim(self, aim: Aim, elapsed: Array, state: State, draws: Draws) -> Aim:
        return aim._replace(time=np.zeros((len(elapsed), 1)))


@frozen
class ForgetsTime(Drift):
    def aim(self, aim: Aim, elapsed: Array, state: State, draws: Draws) -> Aim:
        return Aim(bearing=aim.bearing)


@frozen
class WritesTime(Drift):
    def aim(self, aim: Aim, elapsed: Array, state: State, draws: Draws) -> Aim:
        if aim.time is not None:
            aim.time[:] = 0.0
        return aim


@frozen
class LaterThanItSays(Drift):
    def delay(self, elapsed: Array, state: State, draws: Draws) -> Array:
        return np.abs(draws.normal(1))

    def longest_delay(self) -> Array:
        return 0.01 + 0.0 * np.asarray(self.std)


@frozen
class NeverSays(Drift):
    def delay(self, elapsed: Array, state: State, draws: Draws) -> Array:
        return np.abs(draws.normal(1))


@frozen
class MakesUpReturns(Drift):
    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        return np.minimum(values, 100.0)


@frozen
class NotANumber(Drift):
    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        return np.where(values > 1.0, np.nan, values)


@frozen
class Nothing(Noise):
    pass


@frozen
class NoUnit(Range):
    unit: ClassVar[str] = ""


@frozen
class WrongSize(Range):
    def size(self, drive: Drive) -> int:
        return 3


@frozen
class MovingSize(Range):
    count: int = parameter(4, ge=1, help="should have been static")

    def size(self, drive: Drive) -> int:
        return self.count


@frozen
class NoSide(Range):
    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        return super().sense(view, aim, state, draws)[0]  # type: ignore[return-value]


@frozen
class WideSide(Range):
    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        return super().sense(view, aim, state, draws)[0], {"incidence": np.zeros((view.rows, 1))}


@frozen
class WritesView(Range):
    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        view.body_pose[:, 2] += 0.1
        return super().sense(view, aim, state, draws)


@frozen
class SameNames(Cart):
    joints: ClassVar[tuple[Joint, ...]] = (Joint(name="wheel"), Joint(name="wheel"))


@frozen
class NoRadius(Cart):
    def rolling_radius(self) -> Array:
        return np.zeros((len(self.radius), 2))  # type: ignore[arg-type]


@frozen
class Creeps(Cart):
    def displacement(self, before: Array, after: Array, fraction: Array) -> Array:
        return super().displacement(before, after, fraction) + np.array([1e-6, 0.0, 0.0])


@frozen
class Hurries(Cart):
    """Is not at a stop where its path is."""

    def displacement(self, before: Array, after: Array, fraction: Array) -> Array:
        return super().displacement(before, after, fraction * fraction)


@frozen
class Understates(Cart):
    def travel(self, before: Array, after: Array) -> Array:
        return 0.9 * super().travel(before, after)


@frozen
class OtherBoundTwist(Cart):
    def bind_twist(self, before: Array, after: Array, out: Array) -> Callable[[], None]:
        return lambda: np.copyto(out, self.twist(before, after) * (1.0 + 1e-15))


@frozen
class RewindsJoints(Cart):
    """Writes the joints after the step over those before it."""

    def bind_travel(self, before: Array, after: Array, out: Array) -> Callable[[], None]:
        def write() -> None:
            out[:] = self.travel(before, after)
            before[:] = after

        return write


@frozen
class Uneven(Cart):
    """As long as it says, but not evenly: the first half of a step goes farther than half of it."""

    def between(self, before: Array, after: Array, fraction: Array) -> Array:
        return super().between(before, after, fraction * (1.5 - 0.5 * fraction))

    def displacement(self, before: Array, after: Array, fraction: Array) -> Array:
        return super().displacement(before, after, fraction * (1.5 - 0.5 * fraction))


@frozen
class TwinBooms(Crane):
    parts: ClassVar[tuple[Part, ...]] = (*Crane.parts, *Crane.parts)


@frozen
class GrowingBoom(Crane):
    """Its outline depends on a number that is not static."""

    @property
    def parts(self) -> tuple[Part, ...]:  # type: ignore[override]
        return (Part("boom", am.Shape.circle(float(np.min(self.ahead)) + 0.1)),)


@frozen
class LostBoom(Crane):
    def part_poses(self, joints: Array) -> Array:
        return Cart.part_poses(self, joints)


@frozen
class SameBooms(Crane):
    def part_poses(self, joints: Array) -> Array:
        poses = super().part_poses(joints)
        poses[:, :, 2] = poses[:, :, 2].mean()
        return poses


@frozen
class SlowBoom(Crane):
    def part_travel(self, before: Array, after: Array) -> Array:
        return 0.9 * super().part_travel(before, after)


@frozen
class JumpingBoom(Crane):
    """What follows from the step is not there at its beginning."""

    def follow(self, joints: Array, displacement: Array) -> Array:
        return joints + np.array([0.0, 0.0, 1e-3])


@frozen
class WrongInverse(Cart):
    def command_for(self, twist: Array, joints: Array) -> Array:
        return super().command_for(twist, joints)[:, ::-1].copy()


@frozen
class OneRate(Cart):
    def advance(
        self, joints: Array, rates: Array, command: Array, dt: float, state: State, draws: Draws
    ) -> tuple[Array, Array]:
        return joints + command * dt, command[:, :1].copy()


@frozen
class Skewed(StaysPut):
    def matrix(self, variance: Array) -> Array:
        return variance[:, :, None] * np.array([[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])


@frozen
class Negative(StaysPut):
    def matrix(self, variance: Array) -> Array:
        return variance[:, :, None] * np.array([[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]])


@frozen
class Lost(StaysPut):
    def start(self, context: Context) -> State:
        return {"pose": np.full((context.rows, 3), np.nan), "age": np.zeros((context.rows, 1))}


@frozen
class KeepsGiven(StaysPut):
    """Writes into the pose that it was given."""

    def start(self, context: Context) -> State:
        return {"pose": context.pose, "age": np.zeros((context.rows, 1))}

    def update(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        command: Array,
        elapsed: Array,
        state: State,
        draws: Draws,
    ) -> Estimate:
        state["pose"] += 0.1
        return super().update(robot, readings, command, elapsed, state, draws)


@frozen
class Endless(Ahead):
    def command(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        estimate: Estimate,
        clock: Clock,
        state: State,
        draws: Draws,
    ) -> Array:
        return np.full((robot.rows, 2), np.inf)


@frozen
class WritesReading(Ahead):
    def command(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        estimate: Estimate,
        clock: Clock,
        state: State,
        draws: Draws,
    ) -> Array:
        readings["laser"].measured[:, 0] = 0.0
        return super().command(robot, readings, estimate, clock, state, draws)


@frozen
class Nowhere(Slide):
    def propose(self, view: View, dt: float, state: State, draws: Draws) -> Array:
        return np.full((view.rows, 3), np.nan)


@frozen
class Flat(Slide):
    def propose(self, view: View, dt: float, state: State, draws: Draws) -> Array:
        return np.zeros((view.rows, 2))


@frozen
class Unsure(Text):
    @classmethod
    def sniff(cls, head: bytes) -> bool:
        return head[:1]  # type: ignore[return-value]


@frozen
class Crashes(Text):
    def load(self, path: Path) -> Map:
        return Map.from_segments([[float(word) for word in path.read_text("ascii").split()]])


@frozen
class NoMap(Text):
    def load(self, path: Path) -> Map:
        return path.read_bytes() if path.exists() else super().load(path)  # type: ignore[return-value]


@frozen
class NoColumns(Range):
    def columns(self) -> Mapping[str, str]:
        return None  # type: ignore[return-value]


@frozen
class ThreeColumns(Range):
    def columns(self) -> Mapping[str, str]:
        return {"near": "m", "middle": "m", "far": "m"}


@frozen
class MovingColumns(Range):
    def columns(self) -> Mapping[str, str]:
        return {"near": "m", f"up to {self.range_max:g}": "m"}


@frozen
class ListOfChannels(Range):
    channels: ClassVar[list[str]] = ["pan"]  # type: ignore[assignment]

    def actuate(self, command: Array, dt: float, state: State, draws: Draws) -> None:
        pass


@frozen
class TwinChannels(ListOfChannels):
    channels: ClassVar[tuple[str, ...]] = ("pan", "pan")


@frozen
class FollowsNothing(Range):
    channels: ClassVar[tuple[str, ...]] = ("pan",)


@frozen
class NoSideNumber(Range):
    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        return super().sense(view, aim, state, draws)[0], {"incidence": np.full((view.rows, 2), np.nan)}


@frozen
class OneContact(Cart):
    def contacts(self, joints: Array) -> Array:
        return np.zeros((len(joints), 1, 2))


@frozen
class FlatOffset(Cart):
    def heading_offset(self, joints: Array) -> Array:
        return np.zeros(len(joints))


@frozen
class NoCurvature(Cart):
    def curvature_max(self) -> Array:
        return 0.0 * np.asarray(self.track)


@frozen
class Backwards(Cart):
    def top_speeds(self) -> Array:
        return np.full((len(np.asarray(self.track)), 4), -1.0)


@frozen
class TwoSpeeds(Cart):
    def top_speeds(self) -> Array:
        return np.ones((len(np.asarray(self.track)), 2))


@frozen
class LostJacobian(Cart):
    def jacobian(self, before: Array, after: Array) -> Array:
        return np.full((len(before), 3, 2), np.nan)


@frozen
class JacobianByAngle(Cart):
    """Its Jacobian is that of a turn of the wheel, not of a metre of its travel."""

    def jacobian(self, before: Array, after: Array) -> Array:
        out = np.zeros((len(before), 3, 2))
        out[:, 0] = 0.5
        out[:, 2] = np.concatenate((-1.0 / self.track, 1.0 / self.track), axis=1)
        return out * self.radius[:, :, None]


@frozen
class PlainTuple(StaysPut):
    def update(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        command: Array,
        elapsed: Array,
        state: State,
        draws: Draws,
    ) -> Estimate:
        return tuple(super().update(robot, readings, command, elapsed, state, draws))  # type: ignore[return-value]


@frozen
class FailsInNumbers(StaysPut):
    def failed(self, state: State) -> npt.NDArray[np.bool_]:
        return state["age"] > 0.0


@frozen
class CurrentByRow(StaysPut):
    def is_current(self, readings: Mapping[str, Measurement], state: State) -> npt.NDArray[np.bool_]:
        return np.ones(len(state["age"]), dtype=bool)


@frozen
class SourcesInPairs(StaysPut):
    def sources(self) -> Sequence[tuple[str, str, str]]:
        return [("wheels", "motion")]  # type: ignore[list-item]


@frozen
class OneStep(Noise):
    def steps(self) -> Any:
        return am.NoiseStep.add(0.1)


@frozen
class FlatCalls(Range):
    medium: ClassVar[str] = "air"

    def emit(self, view: View, state: State) -> Any:
        return am.Emission(view.pose, np.pi, True)  # type: ignore[arg-type]


@frozen
class WritesNothing(Range):
    """Reads 0, which it leaves to whoever makes the array."""

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        return np.zeros((view.rows, 2)), {}

    def bind(self, at: SensorBinding) -> Callable[[], None]:
        return lambda: None


@frozen
class EmitsElsewhere(Range):
    """Says when bound that it is 1 m to the right."""

    medium: ClassVar[str] = "air"

    def emit(self, view: View, state: State) -> am.Emission:
        shape = view.rows, 1
        return am.Emission(view.pose[:, None].copy(), np.full(shape, 0.5), np.ones(shape, dtype=bool))

    def bind_emit(self, at: SensorBinding) -> Callable[[], am.Emission | None]:
        def emit() -> am.Emission:
            emission = self.emit(at.look(), at.state)
            emission.poses[..., 0] += 1.0
            return emission

        return emit


@frozen
class ReadsDegrees(Range):
    unit: ClassVar[str] = "deg"


@frozen
class ColumnInCentimetres(Range):
    def columns(self) -> Mapping[str, str]:
        return {"range": "cm"}


@frozen
class StartsInPlane(Slide):
    def default_start(self) -> tuple[float, float, float]:
        return 1.0, 2.0  # type: ignore[return-value]


@frozen
class StartsLost(Slide):
    def default_start(self) -> tuple[float, float, float]:
        return 1.0, 2.0, float("nan")


@frozen
class GoesWithoutField(Slide):
    def goal_points(self) -> Sequence[tuple[str, float, float]]:
        return [(1.0, 2.0)]  # type: ignore[list-item]


@frozen
class GoesToWords(Ahead):
    def goal_points(self) -> Sequence[tuple[str, float, float]]:
        return [("x", "y", 0.0)]  # type: ignore[list-item]


@frozen
class NeedsUnknown(am.Metric):
    unit: ClassVar[str] = "m"
    better: ClassVar[str] = "lower"

    def needs(self) -> Sequence[str]:
        return ("true_poses",)

    def measure(self, episode: am.Episode) -> Array:
        return np.zeros(len(episode.replicas))


@frozen
class OneWorld(NeedsUnknown):
    """How far the robot saw ahead at least in the world of replica 0, whatever the world of the row."""

    def needs(self) -> Sequence[str]:
        return ("true_pose",)

    def measure(self, episode: am.Episode) -> Array:
        poses = episode.kept["true_pose"]
        ranges = episode.map.cast_rays(poses.reshape(-1, 3), [0.0], 9.0)
        return ranges.reshape(poses.shape[:2]).min(axis=0)


class Replans(am.Planner):
    """A* with a plan that is changed."""

    changes: ClassVar[dict[str, Any]] = {}

    def plan(
        self, world: Map, start: Sequence[float], goal: Sequence[float], *, footprint: am.Shape | None = None
    ) -> am.Plan:
        found = am.planners.AStar().plan(world, start, goal, footprint=footprint)
        return attrs.evolve(found, **self.changes) if found.status == "found" else found


@frozen
class OnePose(Replans):
    changes: ClassVar[dict[str, Any]] = {"poses": np.array(1.0)}


@frozen
class LengthInWords(Replans):
    changes: ClassVar[dict[str, Any]] = {"length": "long"}


@frozen
class LinksInPairs(Replans):
    changes: ClassVar[dict[str, Any]] = {"links": np.zeros((3, 2))}


@frozen
class OneTrailer(Replans):
    changes: ClassVar[dict[str, Any]] = {"trailer": np.zeros((1, 3))}


@frozen
class NoMessage(Replans):
    changes: ClassVar[dict[str, Any]] = {"message": None}


BROKEN = {
    StartsInPlane: "places",
    StartsLost: "places",
    GoesWithoutField: "places",
    GoesToWords: "places",
    NeedsUnknown: "needs",
    OneWorld: "rows",
    OnePose: "plan",
    LengthInWords: "plan",
    LinksInPairs: "plan",
    OneTrailer: "plan",
    NoMessage: "plan",
    OneStep: "steps",
    FlatCalls: "emit",
    WritesNothing: "bind",
    EmitsElsewhere: "bind",
    ReadsDegrees: "unit",
    ColumnInCentimetres: "columns",
    ListOfChannels: "channels",
    TwinChannels: "channels",
    FollowsNothing: "channels",
    NoSideNumber: "finite",
    OneContact: "shapes",
    FlatOffset: "shapes",
    NoCurvature: "limits",
    Backwards: "limits",
    TwoSpeeds: "shapes",
    LostJacobian: "finite",
    OtherBoundTwist: "bind",
    RewindsJoints: "bind",
    JacobianByAngle: "jacobian",
    PlainTuple: "shapes",
    FailsInNumbers: "failed",
    CurrentByRow: "is_current",
    SourcesInPairs: "sources",
    NoColumns: "columns",
    ThreeColumns: "columns",
    MovingColumns: "columns",
    LooksAhead: "time",
    SharedTime: "shapes",
    ForgetsTime: "aim",
    WritesTime: "inputs",
    LaterThanItSays: "delay",
    NeverSays: "class",
    Positional: "class",
    Nothing: "class",
    Mute: "fields",
    Degrees: "fields",
    Sealed: "pickling",
    ListState: "start",
    SharedState: "start",
    GrowingState: "state",
    NewKey: "state",
    SinglePrecision: "state",
    Raises: "runs",
    Narrow: "shapes",
    Half: "shapes",
    WritesValues: "inputs",
    WritesView: "inputs",
    KeepsGiven: "inputs",
    WritesReading: "inputs",
    WritesFields: "parameters",
    KeepsOnItself: "parameters",
    RewritesResult: "kept",
    Forgetful: "determinism",
    HiddenState: "snapshot",
    LooksAtOthers: "rows",
    ConfusesRowsWithValues: "width",
    MakesUpReturns: "inf",
    NotANumber: "finite",
    NoUnit: "unit",
    WrongSize: "size",
    MovingSize: "size",
    NoSide: "shapes",
    WideSide: "shapes",
    SameNames: "joints",
    NoRadius: "joints",
    OneRate: "shapes",
    Creeps: "standstill",
    Hurries: "between",
    Understates: "travel",
    Uneven: "travel",
    TwinBooms: "parts",
    GrowingBoom: "parts",
    LostBoom: "shapes",
    SameBooms: "rows",
    SlowBoom: "parts",
    JumpingBoom: "parts",
    WrongInverse: "command_for",
    Skewed: "covariance",
    Negative: "covariance",
    Lost: "finite",
    Endless: "finite",
    Nowhere: "finite",
    Flat: "shapes",
    Unsure: "sniff",
    Crashes: "errors",
    NoMap: "load",
}


@pytest.mark.parametrize(("cls", "check"), BROKEN.items(), ids=[cls.__name__ for cls in BROKEN])
def test_broken_components_fail_their_check(cls: type, check: str) -> None:
    with pytest.raises(ComponentError) as caught:
        check_component(cls)
    message = str(caught.value)
    assert f"fails the check {check!r}" in message
    assert cls.__name__ in message
    assert "expected" in message
    assert "found" in message or check == "class"


def test_what_is_no_component_is_refused() -> None:
    with pytest.raises(ComponentError, match=r"int cannot be checked.*Drive, Sensor"):
        check_component(3)


# ------------------------------------------------------------------------------------------------------- settings


def test_noise_may_be_tried_on_side_arrays_and_values_of_a_sensor() -> None:
    check_component(Raises, side={"incidence": 0.2})
    check_component(Drift, values_of="laser")


def test_noise_that_makes_up_returns_passes_if_that_is_said() -> None:
    check_component(MakesUpReturns, inf="changed")


@frozen
class AddsInfinities(Drift):
    """Has no answer to inf: inf - inf is not a number."""

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        return values - np.where(np.isinf(values), values, 0.0)


@pytest.mark.filterwarnings("ignore:invalid value")
def test_noise_on_what_is_never_inf_passes_if_that_is_said() -> None:
    check_component(AddsInfinities, inf="absent")
    with pytest.raises(ComponentError, match="'finite'"):
        check_component(AddsInfinities)


@frozen
class ReadsDistance(Estimator):
    """Uses a sensor of its own."""

    def update(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        command: Array,
        elapsed: Array,
        state: State,
        draws: Draws,
    ) -> Estimate:
        pose = np.zeros((robot.rows, 3))
        pose[:, 0] = np.minimum(readings["distance"].measured[:, 0], 9.0)
        return Estimate(pose, np.zeros((robot.rows, 3, 3)))


def test_estimators_get_the_sensors_that_they_need() -> None:
    check_component(ReadsDistance, sensors={"distance": Range()})
    with pytest.raises(ComponentError, match=r"'runs'.*KeyError.*distance"):
        check_component(ReadsDistance)


def test_controllers_are_tried_on_the_drive_that_is_given() -> None:
    @frozen
    class Third(Cart):
        joints: ClassVar[tuple[Joint, ...]] = (*Cart.joints, Joint(name="tail", rolls=False))
        channels: ClassVar[tuple[str, ...]] = (*Cart.channels, "tail")

        def twist(self, before: Array, after: Array) -> Array:
            return Cart.twist(self, before[:, :2], after[:, :2])

        def command_for(self, twist: Array, joints: Array) -> Array:
            return np.concatenate((Cart.command_for(self, twist, joints), np.zeros((len(twist), 1))), axis=1)

    check_component(Ahead, drive=Third())


# --------------------------------------------------------------------------------------------- examples and variants


@frozen
class Demanding(Noise):
    high: float = parameter(gt=2, help="above two")
    between: float = parameter(ge=1, le=2, help="between one and two")
    low: int = parameter(lt=0, help="below nought")
    kind: str = parameter(choices=("one", "two"), help="of two")
    ring: tuple[float, ...] = parameter(gt=0, help="some")
    pair: tuple[float, float] = parameter(help="two")
    maybe: float | None = parameter(help="or none")
    flag: bool = parameter(help="yes or no")

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        return values


@frozen
class Ordered(Noise):
    low: float = parameter(1.0, help="below high")
    high: float = parameter(1.01, help="above low")

    def __attrs_post_init__(self) -> None:
        if self.low >= self.high:
            raise ValueError("low is not below high")

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        return values


def test_example_fills_in_what_must_be_given() -> None:
    made = example(Demanding, kind="two")
    assert made.kind == "two"
    assert made.maybe is None
    assert len(made.ring) == len(made.pair) == 2
    check_component(Demanding)


def test_variants_differ_within_bounds_and_are_the_same_each_time() -> None:
    component = example(Demanding, between=2.0)
    made = variants(component, 64)
    assert made[0] is component
    assert made == variants(component, 64)
    assert len({one.high for one in made}) > 2
    assert len({one.between for one in made}) > 2
    assert all(1 <= one.between <= 2 for one in made)
    assert all(one.ring[0] > 0 for one in made)
    assert {one.kind for one in made} == {"one"}


def test_variants_are_nearer_where_the_class_refuses_them() -> None:
    made = variants(Ordered(), 64)
    assert len({(one.low, one.high) for one in made}) > 2
    assert all(one.low < one.high for one in made)


# ------------------------------------------------------------------------------------------------------------ recorders


@attrs.define(kw_only=True)
class Whole(Recorder):
    every: int = parameter(1, ge=1, help="steps between two lines")
    _lines: list[str] | None = attrs.field(default=None, init=False)

    def open(self, run: RunInfo, frames: Sequence[Frame]) -> None:
        self._lines = []

    def write(self, frames: Sequence[Frame], events: Sequence[Any]) -> None:
        assert self._lines is not None
        self._lines += [event.kind for event in events]

    def close(self) -> None:
        self._lines = None


@attrs.define(kw_only=True)
class ClosesWhatItOpened(Whole):
    def close(self) -> None:
        assert self._lines is not None
        self._lines.clear()


@attrs.define(kw_only=True)
class Rounds(Whole):
    def write(self, frames: Sequence[Frame], events: Sequence[Any]) -> None:
        for frame in frames:
            frame.true_pose[:] = np.round(frame.true_pose)


@attrs.define(kw_only=True)
class OneRobot(Whole):
    def write(self, frames: Sequence[Frame], events: Sequence[Any]) -> None:
        (frame,) = frames
        float(frame.true_pose[:, 0])


@attrs.define(kw_only=True)
class OneObstacle(Whole):
    def write_obstacles(self, frames: Sequence[ObstacleFrame]) -> None:
        (frame,) = frames
        float(frame.true_pose[:, 0])


@attrs.define(kw_only=True)
class RoundsObstacles(Whole):
    def write_obstacles(self, frames: Sequence[ObstacleFrame]) -> None:
        for frame in frames:
            frame.true_pose[:] = np.round(frame.true_pose)


@pytest.mark.parametrize(
    ("cls", "words"),
    [
        (ClosesWhatItOpened, "close"),
        (OneObstacle, "write_obstacles: expected it to return"),
        (RoundsObstacles, "write_obstacles: .*true_pose|writing"),
        (Rounds, "true_pose|writing"),
        (OneRobot, "write: expected it to return"),
    ],
)
def test_a_broken_recorder(cls: type[Recorder], words: str) -> None:
    with pytest.raises(ComponentError, match=words):
        check_component(cls)


@frozen
class Bare(am.WorldGenerator):
    """An empty hall, whatever the seed."""

    def generate(self, draws: Draws) -> Map:
        return am.Map.from_array(np.zeros((20, 20)), resolution=0.1, start=(1.0, 1.0, 0.0))


def test_a_generator_that_gives_one_world_for_all_seeds_is_said_to_prove_nothing() -> None:
    with pytest.warns(UserWarning, match=r"Bare: seeds 0 to 3 gave the same world"):
        check_component(Bare())


def test_a_whole_recorder() -> None:
    check_component(Whole)
    check_component(Whole(every=3))


@attrs.frozen(kw_only=True)
class Near(Sensor):
    """1 where a wall is near ahead, else 0: in the middle of a hall it never changes."""

    unit: ClassVar[str] = "1"
    range_max: float = parameter(0.3, unit="m", gt=0, help="how near")

    def size(self, drive):
        return 1

    def sense(self, view, aim, state, draws):
        seen = view.cast(view.pose, np.zeros((1, 1)), np.zeros((view.rows, 1)) + self.range_max)
        return np.where(np.isfinite(seen), 1.0, 0.0), {}


@attrs.frozen(kw_only=True)
class Deaf(Near):
    def sense(self, view, aim, state, draws):
        return np.zeros((view.rows, 1)), {}


def test_a_reading_that_never_changed_is_said_to_prove_nothing():
    with pytest.warns(UserWarning, match=r"sensor Deaf: its reading never changed in the trials \(\[0.0, 0.0, 0.0\]"):
        check_component(Deaf)


def test_a_scene_of_the_authors_can_make_it_change():
    facing = building.robot(pose=am.Pose(x=5.6, y=2.0))
    check_component(Near, scene=building.scenario(facing))
    away = building.robot(pose=am.Pose(x=2.0, y=2.0))
    with pytest.warns(UserWarning, match="sensor Near: its reading never changed"):
        check_component(Near, scene=building.scenario(away))


def test_a_scene_brings_its_obstacles_landmarks_and_lights():
    marks = (am.Landmark(id=3, x=4.0, y=2.0),)
    crate = am.Obstacle(name="crate", shape=am.Shape.rectangle(0.4, 0.4), pose=am.Pose(x=3.0, y=4.0))
    robots = [building.robot(name=name, pose=am.Pose(x=2.0, y=y)) for name, y in (("a", 2.0), ("b", 3.0))]
    scene = building.scenario(*robots, obstacles=(crate,), landmarks=marks, lights=(am.Light(x=3.0, y=2.5),))
    check_component(Fiducial, scene=scene)
    rig = Rig(scene=scene)
    view = rig.view(np.arange(2))
    rig.set_view(view, np.arange(2), 0)
    assert np.abs(view.body_pose[:, :2] - [[2.0, 2.0], [2.0, 3.0]]).max() <= 0.05
    assert view.bodies().poses[:, 1].tolist() == [[3.0, 4.0, 0.0]] * 2
    assert view.landmarks(1, np.full((2, 1), 9.0), np.full((2, 1), np.pi)).id.tolist() == [[3], [3]]
    assert len(view.lights().places) == 1


@frozen
class Exits(Drift):
    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        raise SystemExit(3)


def test_a_component_that_exits_fails_its_check():
    with pytest.raises(ComponentError, match=r"'runs': corrupt: expected it to return, found SystemExit: 3"):
        check_component(Exits)


@frozen
class Shouts(Range):
    medium: ClassVar[str] = "ultrasound"

    def emit(self, view: View, state: State) -> am.Emission:
        ahead = np.zeros((view.rows, 1))
        return am.Emission(view.pose[:, None].copy(), ahead + 0.2, ahead)


@frozen
class Single(am.Metric):
    unit: ClassVar[str] = "m"
    better: ClassVar[str] = "lower"

    def needs(self) -> Sequence[str]:
        return ()

    def measure(self, episode: am.Episode) -> Array:
        return np.zeros(len(episode.replicas), np.float32)  # type: ignore[return-value]


@pytest.mark.parametrize(
    ("cls", "words"),
    [
        (Shouts, "expected bool (64, 1), found float64 (64, 1)"),
        (Single, "expected float64 (7,), found float32 (7,)"),
        (FailsInNumbers, "expected None or bool (64,), found bool (64, 1)"),
        (CurrentByRow, "expected None or bool (64, 1), found bool (64,)"),
    ],
)
def test_an_array_of_another_type_is_told_with_its_type(cls, words):
    with pytest.raises(ComponentError) as caught:
        check_component(cls)
    assert words in str(caught.value)
