"""A door: an obstacle that turns about its hinge, opens and closes, and blocks robots and lasers."""

from __future__ import annotations

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Context, Draws, Motion, State, View, parameter
from amorsim.core.maps.map import Map
from amorsim.core.poses import wrap_angle
from amorsim.core.shapes import Shape
from amorsim.drives.differential import Differential
from amorsim.noise.gaussian import Gaussian
from amorsim.scenario.spec import MountedSensor, NoiseElement, Obstacle, Pose, Robot, Scenario
from amorsim.sensors.laser import Laser
from amorsim.simulation.simulation import Simulation
from tests.hard_cases.common import SLIP, Hold, advance, bodies, check_bits

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Swing(Motion):
    """Opens by `angle` and closes again, over and over; what is in the way holds it up."""

    angle: float = parameter(1.5, unit="rad", help="how far it opens, from where it stands at the start")
    rate: float = parameter(1.0, unit="rad/s", gt=0, help="how fast it turns")
    closed: float = parameter(2.0, unit="s", ge=0, help="for how long it wants to be closed")
    opened: float = parameter(3.0, unit="s", gt=0, help="for how long it then wants to be open")

    def start(self, context: Context) -> State:
        return {"closed": context.pose[:, 2:].copy()}

    def propose(self, view: View, dt: float, state: State, draws: Draws) -> Array:
        time = view.tick * dt
        phase = time - np.floor(time / (self.closed + self.opened)) * (self.closed + self.opened)
        target = state["closed"] + np.where(phase >= self.closed - 1e-9, self.angle, 0.0)
        # From where it really is, which is not where it wanted to be if somebody stood in the way.
        turn = wrap_angle(target - view.body_pose[:, 2:])
        wanted = np.zeros((view.rows, 3))
        wanted[:, 2:] = np.clip(turn, -self.rate * dt, self.rate * dt)
        return wanted


WHITE = (NoiseElement(name="white", noise=Gaussian(std=0.01)),)

LEAF = Shape.rectangle(0.98, 0.04, x=0.49 + 0.03)


def two_rooms() -> Map:
    """Two rooms, and between them a wall at x = 4 m with a gap from y = 2 m to 3.05 m."""
    walls = [(0, 0, 8, 0), (8, 0, 8, 5), (8, 5, 0, 5), (0, 5, 0, 0), (4, 0, 4, 2.0), (4, 3.05, 4, 5)]
    return Map.from_segments(np.array(walls, dtype=float), resolution=0.01)


def door(motion: Swing, name: str = "door") -> Obstacle:
    """Hinged at the lower side of the gap; closed, its leaf points up."""
    return Obstacle(name=name, shape=LEAF, pose=Pose(x=4.0, y=2.0, heading=np.pi / 2), motion=motion)


def robot(x: float, speed: float, **others: object) -> Robot:
    return Robot(
        name="rover",
        shape=Shape.circle(0.2),
        drive=Differential(wheel_radius_left=0.1, wheel_radius_right=0.1, track=0.3, rate_max=30.0),
        sensors={"laser": MountedSensor(sensor=Laser(beams=1), noise=WHITE)},
        controller=Hold(channels=(speed / 0.1, speed / 0.1)),
        pose=Pose(x=x, y=2.55),
        **others,
    )


def test_a_closed_door_is_seen_and_stops_the_robot() -> None:
    sim = Simulation(
        Scenario(map=two_rooms(), robots=[robot(1.0, 0.8)], obstacles=[door(Swing(angle=-1.5, closed=50.0))])
    )
    assert abs(sim.robot("rover").readings["laser"].true[0] - (4.0 - 0.02 - 1.0)) < 1e-9
    advance(sim, 60)
    met = [event for event in sim.events if event.kind == "collision" and event.name == "rover"]
    assert met[0].other == "door"
    assert abs(sim.robot("rover").true_pose[0] - (4.0 - 0.02 - 0.2)) < 1e-9


def test_an_open_door_is_seen_through_and_lets_the_robot_pass() -> None:
    sim = Simulation(
        Scenario(
            map=two_rooms(), robots=[robot(1.0, 0.8)], obstacles=[door(Swing(angle=-1.5, closed=0.0, opened=50.0))]
        )
    )
    seen = []
    for _ in range(70):
        sim.step()
        seen.append(sim.robot("rover").readings["laser"].true[0])
    assert not sim.events
    assert sim.robot("rover").true_pose[0] > 6.0
    assert abs(seen[20] - (8.0 - 1.0 - 0.8 * 2.1)) < 0.011


def test_two_doors_open_each_at_its_rate_and_by_its_angle() -> None:
    doors = [
        door(Swing(angle=-1.5, closed=0.0, opened=50.0, rate=0.5)),
        attrs.evolve(
            door(Swing(angle=1.0, closed=1.0, opened=50.0, rate=2.0), "gate"), pose=Pose(x=6.0, y=2.5, heading=0.0)
        ),
    ]
    sim = Simulation(Scenario(map=two_rooms(), robots=[robot(1.0, 0.0)], obstacles=doors))
    advance(sim, 12)
    poses = bodies(sim)  # in the order of names: rover, door, gate
    np.testing.assert_allclose(poses[1], [4.0, 2.0, np.pi / 2 - 0.5 * 1.2], rtol=0, atol=1e-12)
    np.testing.assert_allclose(poses[2], [6.0, 2.5, 2.0 * 0.2], rtol=0, atol=1e-12)


def test_a_door_that_closes_stops_at_who_stands_in_it_and_closes_when_he_left() -> None:
    standing = Swing(angle=1.5, closed=2.0, opened=3.0, rate=1.0)
    # It stands open, and "opens" shut.
    obstacle = attrs.evolve(door(standing), pose=Pose(x=4.0, y=2.0, heading=np.pi / 2 - 1.5))
    sim = Simulation(Scenario(map=two_rooms(), robots=[robot(4.0, 0.0)], obstacles=[obstacle]))
    advance(sim, 40)
    held = bodies(sim)[1]
    assert {event.other for event in sim.events if event.name == "door"} == {"rover"}
    # The leaf's edge lies on the robot's circle: the distance from its centre to the leaf's middle line is 0.2 + 0.02.
    angle = held[2]
    distance = abs(np.cos(angle) * (2.55 - 2.0) - np.sin(angle) * 0.0)
    assert abs(distance - 0.22) < 1e-6
    sim.set_pose("rover", (2.0, 2.55, 0.0))
    advance(sim, 9)
    assert bodies(sim)[1][2] > held[2] + 0.3


def test_bits() -> None:
    doors = [
        door(Swing(angle=-1.5, closed=0.5, opened=2.0)),
        attrs.evolve(door(Swing(angle=1.0, rate=0.4, closed=0.2), "gate"), pose=Pose(x=2.0, y=1.0, heading=0.0)),
    ]
    scenario = Scenario(map=two_rooms(), robots=[robot(2.6, 0.5, ground=SLIP)], obstacles=doors)
    check_bits(scenario, steps=40)
