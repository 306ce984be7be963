"""A tractor with a trailer: a joint that nobody drives, and that follows what the body really did."""

from __future__ import annotations

from typing import ClassVar

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Draws, Joint, State, parameter
from amorsim.core.poses import logarithm
from amorsim.core.shapes import Shape
from amorsim.drives.differential import Differential
from amorsim.estimators.dead_reckoning import DeadReckoning
from amorsim.scenario.spec import Pose, Robot, Scenario
from amorsim.sensors.encoder import Encoder
from amorsim.simulation.simulation import Simulation
from tests.hard_cases.common import SLIP, Hold, Weave, advance, check_bits, room

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Tractor(Differential):
    """A trailer on one axle, hitched above the tractor's; `hitch` is the tractor's heading less the trailer's."""

    joints: ClassVar[tuple[Joint, ...]] = (*Differential.joints, Joint(name="hitch", rolls=False))

    trailer_length: float = parameter(0.6, unit="m", gt=0, help="from the hitch to the trailer's axle")

    def advance(
        self, joints: Array, rates: Array, command: Array, dt: float, state: State, draws: Draws
    ) -> tuple[Array, Array]:
        wheels, wheel_rates = super().advance(_wheels(joints), _wheels(rates), command, dt, state, draws)
        hitch = joints[:, 2:]
        return np.concatenate((wheels, hitch), axis=1), np.concatenate((wheel_rates, np.zeros_like(hitch)), axis=1)

    def twist(self, before: Array, after: Array) -> Array:
        return super().twist(_wheels(before), _wheels(after))

    def follow(self, joints: Array, displacement: Array) -> Array:
        # b' = turn - (way / length) sin b is linear in (sin b/2, cos b/2): its solution is a matrix exponential,
        # of a matrix whose square is a number times the identity.
        twist = logarithm(displacement)
        pull = -0.5 * twist[:, :1] / self.trailer_length
        turn = 0.5 * twist[:, 2:]
        square = pull * pull - turn * turn
        root = np.sqrt(np.abs(square))
        even = np.where(square >= 0.0, np.cosh(root), np.cos(root))
        odd = np.where(square >= 0.0, np.sinh(root), np.sin(root)) / np.where(root == 0.0, 1.0, root)
        odd = np.where(root == 0.0, 1.0, odd)
        s, c = np.sin(0.5 * joints[:, 2:]), np.cos(0.5 * joints[:, 2:])
        hitch = 2.0 * np.arctan2(even * s + odd * (pull * s + turn * c), even * c + odd * (-turn * s - pull * c))
        return np.concatenate((joints[:, :2], hitch), axis=1)


def _wheels(joints: Array) -> Array:
    return np.ascontiguousarray(joints[:, :2])


NOMINAL = {"wheel_radius_left": 0.1, "wheel_radius_right": 0.1, "track": 0.4, "rate_max": 50.0}


def robot(name: str, x: float, y: float, length: float, controller: Hold | Weave, **others: object) -> Robot:
    return Robot(
        name=name,
        shape=Shape.circle(0.3),
        drive=Tractor(trailer_length=length, **NOMINAL),
        sensors={"encoder": Encoder(counts_per_revolution=4096.0)},
        estimators={"odometry": DeadReckoning()},
        controller=controller,
        pose=Pose(x=x, y=y),
        **others,
    )


def test_hitch_settles_where_the_trailer_runs_on_the_inner_circle() -> None:
    # Turning with 0.5 rad/s at 0.5 m/s: a circle of 1 m, the trailer's axle on one of sqrt(1 - length^2).
    controller = Hold(channels=(4.0, 6.0))
    robots = [robot("a", 3.0, 3.0, 0.6, controller), robot("b", 8.0, 3.0, 0.3, controller)]
    sim = Simulation(Scenario(map=room(), robots=robots))
    advance(sim, 250)
    for name, length in (("a", 0.6), ("b", 0.3)):
        assert abs(sim.robot(name).joints[2] - np.arcsin(length / 1.0)) < 1e-6
    # Encoders read the hitch too, and dead reckoning is not put off by it.
    np.testing.assert_allclose(sim.estimated_pose, sim.true_pose, rtol=0, atol=1e-9)


def test_hitch_does_not_depend_on_the_step_and_stops_with_the_body() -> None:
    def run(dt: float) -> tuple[float, Array]:
        r = robot("r", 9.0, 6.0, 0.5, Hold(channels=(7.0, 7.3)))
        sim = Simulation(Scenario(map=room(), robots=[r], dt=dt))
        angles = []
        for _ in range(round(6.0 / dt)):
            sim.step()
            angles.append(sim.robot("r").joints[2])
        assert [event.kind for event in sim.events] == ["collision", "controller_ended"]
        assert angles[-1] != 0.0
        return angles[-1], np.array(sim.true_pose)

    coarse, pose_coarse = run(0.5)
    fine, pose_fine = run(0.05)
    np.testing.assert_allclose(pose_coarse, pose_fine, rtol=0, atol=1e-9)
    assert abs(coarse - fine) < 1e-9


def test_follow_is_the_solution_of_the_hitch_equation() -> None:
    from amorsim.core.poses import exponential
    from amorsim.core.rows import stack

    drive = stack([Tractor(trailer_length=0.5, **NOMINAL)])
    for way, turn, start in ((0.4, 0.2, 0.3), (0.1, 2.0, -0.5), (-0.3, 0.1, 0.2), (0.25, 0.5, 0.1), (0.0, 0.0, 0.4)):
        twist = np.array([[way, 0.0, turn]])
        found = drive.follow(np.array([[0.0, 0.0, start]]), exponential(twist, np.ones((1, 1))))[0, 2]
        hitch, n = start, 20_000
        for _ in range(n):  # midpoint rule
            half = hitch + 0.5 / n * (turn - way / 0.5 * np.sin(hitch))
            hitch += 1.0 / n * (turn - way / 0.5 * np.sin(half))
        assert abs(found - hitch) < 1e-7


def test_bits() -> None:
    weave = Weave(middle=(5.0, 6.0), swing=(2.0, 3.0))
    robots = [robot(name, x, 3.0, length, weave, ground=SLIP) for name, x, length in (("a", 3.0, 0.6), ("b", 8.0, 0.4))]
    check_bits(Scenario(map=room(), robots=robots))
