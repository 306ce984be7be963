"""Numbers that mean nothing for a robot are refused; what is left ends, with a result or with a message."""

from __future__ import annotations

import time
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.controllers.pursuit import Pursuit
from amorsim.core.parameters import LARGEST, SMALLEST, ParameterError
from amorsim.core.shapes import Shape
from amorsim.drives.differential import Differential
from amorsim.drives.tractor import Tractor
from amorsim.noise.diffusion import Diffusion
from amorsim.noise.gaussian import Gaussian
from amorsim.noise.latency_jitter import LatencyJitter
from amorsim.noise.slip import Slip
from amorsim.sensors.laser import Laser
from amorsim.sensors.sonar import Sonar
from tests import building

TRAILER = {"trailer_length": 1.0, "trailer_width": 0.5, "trailer_front": 0.5, "trailer_rear": 0.3}
WHEELS = {"wheel_radius_left": 0.1, "wheel_radius_right": 0.1, "track": 0.4, "rate_max": 10.0}


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: building.drive(wheel_radius_left=8250.0), "wheel_radius_left"),
        (lambda: building.drive(wheel_radius_right=1e-9), "wheel_radius_right"),
        (lambda: building.drive(track=1e-9), "track"),
        (lambda: building.drive(rate_max=1e7), "rate_max"),
        (lambda: building.drive(lag=1e300), "lag"),
        (lambda: Tractor(**WHEELS, **TRAILER | {"trailer_width": 1e-20}), "trailer_width"),
        (lambda: Tractor(**WHEELS, **TRAILER | {"trailer_rear": -0.5 + 1e-12}), "trailer_rear"),
        (lambda: Pursuit(waypoints=((1.0, 0.0),), lookahead=1e300), "lookahead"),
        (lambda: Pursuit(waypoints=((1e13, 0.0),)), "waypoints"),
        (lambda: Laser(range_max=1e-13), "range_max"),
        (lambda: Gaussian(std=1e13), "std"),
        (lambda: am.Mount(x=-1e13), "x"),
        (lambda: am.controllers.Square(laps=10**30), "laps"),
        (lambda: building.scenario(dt=1e-7), "dt"),
        (lambda: building.scenario(duration=1e10), "duration"),
    ],
)
def test_what_no_robot_has_is_refused(make: Any, name: str) -> None:
    with pytest.raises(ParameterError, match=rf"^{name}: expected .*"):
        make()


def test_the_widest_bounds_are_said() -> None:
    with pytest.raises(ParameterError, match=r"expected a number \[m\] > 0, of 1e\+12 at most, got 1000"):
        Laser(range_max=1e13)
    with pytest.raises(ParameterError, match=r"expected a number \[m\] > 0, of 1e-12 at least, got 1e-13"):
        Laser(range_max=1e-13)
    Laser(range_max=LARGEST)
    Laser(range_max=SMALLEST)


@pytest.mark.parametrize("size", [1e-7, 1e7])
def test_shapes_have_the_size_of_things(size: float) -> None:
    with pytest.raises(ValueError, match=r"1e\+06 m"):
        Shape.circle(size)
    with pytest.raises(ValueError, match=r"1e\+06 m"):
        Shape.polygon([(0, 0), (size, 0), (0, size)])


def test_a_rounding_is_none_or_one_that_can_be_seen() -> None:
    with pytest.raises(ValueError, match="the rounding of a polygon is 0 m, or 1e-06 m at least, not 1e-320"):
        Shape.polygon([(0, 0), (1, 0), (0, 1)], rounding=1e-320)


def test_an_error_may_not_make_the_true_value_meaningless() -> None:
    robot = building.robot(errors={"drive.wheel_radius_left": am.Deviation(scale=1e5)})
    with pytest.raises(am.ScenarioError, match=r"wheel_radius_left.* <= 10, got 8250"):
        am.Simulation(building.scenario(robot))


@pytest.mark.parametrize("noise", [Diffusion(variance_per_length=1e-4), Slip(at=0.0, duration=1.0, factor=0.0)])
@pytest.mark.parametrize("sensor", [Laser(), Sonar(), building.encoder()])
def test_what_acts_between_wheels_and_ground_is_refused_on_sensors(noise: am.Noise, sensor: am.Sensor) -> None:
    with pytest.raises(ParameterError, match=r"noise: n: .* acts between wheels and ground, .* expected it in the rob"):
        am.MountedSensor(sensor=sensor, noise=(am.NoiseElement(name="n", noise=noise),))


# -------------------------------------------------------------------------------------------------------------- memory


def late(latency: float, *noise: am.Noise) -> am.Robot:
    unit = am.MountedSensor(sensor=Laser(beams=1000), latency=latency, noise=building.chain(*noise))
    return building.robot(sensors={"encoder": building.encoder(), "laser": unit})


def test_readings_that_wait_are_reckoned_before_they_are_made(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("amorsim.core.execution.memory.memory_of_machine", lambda: 4_000_000_000)
    with pytest.raises(
        am.AmorsimError, match=r"this scenario would take 1.92e.03 GB of memory .*latency of 60 s wait for"
    ):
        am.Simulation(building.scenario(late(60.0), dt=1e-6))
    with pytest.raises(am.AmorsimError, match=r"this scenario would take 1.6e.03 GB"):
        am.Simulation(building.scenario(late(0.0, LatencyJitter(spread=10.0, distribution="normal")), dt=1e-6))
    am.Simulation(building.scenario(late(0.001), dt=1e-6)).step()  # a thousand samples of a thousand values


# ------------------------------------------------------------------------------------------------- what takes for ever


def test_pursuit_looks_once_round_a_loop_however_far_it_looks_ahead() -> None:
    places = ((2.0, 0.0), (2.0, 1e-3), (1.999, 0.0))
    ways = []
    for lookahead in (1e3, 1e12):
        controller = Pursuit(waypoints=places, loop=True, lookahead=lookahead)
        robot = building.robot(controller=controller, pose=am.Pose(), shape=Shape.circle(0.2))
        sim = am.Simulation(building.scenario(robot, map=building.empty()))
        sim.step()
        begin = time.perf_counter()
        sim.run(1.0)
        assert time.perf_counter() - begin < 2.0
        ways.append(sim.true_pose[0])
    assert np.isfinite(ways).all()


class Other(Differential):
    """The same drive, but one whose paths no kernel knows."""

    def displacement(self, before: Any, after: Any, fraction: Any) -> Any:
        return am.Drive.displacement(self, before, after, fraction)


@pytest.mark.parametrize("drive", [Differential, Other])
@pytest.mark.parametrize("has_company", [False, pytest.param(True, marks=pytest.mark.long)])
def test_a_step_that_looks_for_contacts_without_end_says_who_goes_too_far(
    has_company: bool, drive: type[Differential], monkeypatch: pytest.MonkeyPatch
) -> None:
    if drive is Other:
        # In NumPy each look takes a hundred times as long.
        monkeypatch.setattr("amorsim.simulation.contact.resolve.MOST_LOOKS", 200)
    # Along a wall at 3e-9 m from it, it has to be looked at every 0.25 mm of 8 km.
    made = drive(**attrs.asdict(building.drive(), recurse=False))
    robot = building.robot(drive=made, shape=Shape.circle(0.2), pose=am.Pose(x=0.5, y=0.001 / 2 + 0.2 + 5.1e-4))
    obstacles = [am.Obstacle(name="post", shape=Shape.circle(0.1), pose=am.Pose(x=3.0, y=4.0))] if has_company else []
    world = am.Map.from_segments([[0, 0, 9000, 0], [0, 5, 9000, 5]], resolution=0.001)
    sim = am.Simulation(building.scenario(robot, obstacles=obstacles, map=world))
    sim.robot("rover").drive(forward=80_000.0)
    begin = time.perf_counter()
    with pytest.raises(am.ContactError, match=r"'rover', of 0\.4 m, moves points of its outline by up to .* m in one"):
        sim.step()
    assert time.perf_counter() - begin < 30.0
