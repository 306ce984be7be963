"""Without errors and noise, the estimate is the truth, for every drive and every robot that ships."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import amorsim as am
from amorsim.plugins.manager import make_registry
from tests import building
from tests.drives.fleet import MAKERS, make
from tests.drives.wander_about import Anywhere

REGISTRY = make_registry(entry_points=[])
ROBOTS = REGISTRY.names("robot")


def of_drive(name: str, **changes: object) -> am.Robot:
    return building.robot(
        drive=make(name, rate_max=60.0),
        shape=am.Shape.circle(0.2),
        controller=Anywhere(),
        on_collision="continue",
        pose=am.Pose(x=4.0, y=4.0, heading=0.3),
        **changes,
    )


def of_model(name: str, tmp_path, size: float) -> am.Robot:
    path = tmp_path / "scenario.toml"
    middle = size / 2
    path.write_text(
        f'format = 1\n[world]\nmap = "room.wld"\n[[robots]]\nname = "rover"\nmodel = "{name}"\n'
        f'on_collision = "continue"\npose = {{ x = {middle}, y = {middle} }}\n'
    )
    mm = round(size * 1000)
    corners = [(0, 0), (mm, 0), (mm, mm), (0, mm), (0, 0)]
    lines = [f"{a} {b} {c} {d}" for (a, b), (c, d) in itertools.pairwise(corners)]
    (tmp_path / "room.wld").write_text(f"width {mm}\nheight {mm}\n" + "\n".join(lines) + "\n")
    robot = am.load(path).robots[0]
    quiet = {"encoder": robot.sensors["encoder"].sensor}  # no quantisation, and nothing else that it could go by
    return am.Robot(
        name="rover",
        shape=robot.shape,
        drive=robot.drive,
        sensors=quiet,
        estimators={"dead_reckoning": am.estimators.DeadReckoning()},
        controller=Anywhere(),
        on_collision="continue",
        pose=robot.pose,
    )


def roam(robot: am.Robot, seconds: float, size: float, seed: int = 1, dt: float = 0.1) -> tuple[am.Simulation, float]:
    """Drive about; the simulation, and the way that the body made [m]."""
    sim = am.Simulation(building.scenario(robot, map=building.room(size, size, resolution=0.005), dt=dt), seed=seed)
    way, before = 0.0, sim.true_pose[0].copy()
    for _ in range(round(seconds / dt)):
        sim.step()
        now = sim.true_pose[0].copy()
        way, before = way + float(np.hypot(*(now - before)[:2])), now
    return sim, way


def check(sim: am.Simulation) -> None:
    off = sim.true_pose - sim.estimated_pose
    assert np.abs(off[:, :2]).max() < 1e-7
    assert np.abs(np.sin(0.5 * off[:, 2])).max() < 0.5e-9


@pytest.mark.parametrize("name", sorted(MAKERS))
def test_of_every_drive(name: str) -> None:
    sim, way = roam(of_drive(name), 40.0, 8.0)
    assert way > 10.0
    check(sim)


@pytest.mark.parametrize("name", ROBOTS)
def test_of_every_robot(name: str, tmp_path) -> None:
    size = 50.0 if name == "car" else 8.0
    sim, way = roam(of_model(name, tmp_path, size), 20.0, size)
    assert way > 1.0
    check(sim)


@pytest.mark.long
@pytest.mark.parametrize("name", sorted(MAKERS))
def test_of_every_drive_over_a_hundred_metres(name: str) -> None:
    sim, way = roam(of_drive(name), 250.0, 25.0, seed=2, dt=0.2)
    assert way > 100.0
    check(sim)


@pytest.mark.nightly
@pytest.mark.parametrize("name", sorted(MAKERS))
def test_of_every_drive_over_a_kilometre(name: str) -> None:
    sim, way = roam(of_drive(name), 2500.0, 25.0, seed=2, dt=0.2)
    assert way > 1000.0
    assert any(event.kind == "collision" for event in sim.events)
    check(sim)


@pytest.mark.nightly
@pytest.mark.parametrize("name", ROBOTS)
def test_of_every_robot_over_a_kilometre(name: str, tmp_path) -> None:
    # The slowest one, once flush with a wall, may stay there for ever: any turn takes a corner into it.
    size = 200.0 if name == "turtlebot3_burger" else 60.0
    robot = of_model(name, tmp_path, size)
    seconds = {"turtlebot3_burger": 26_000.0, "nomad200": 7000.0, "youbot": 7000.0}.get(name, 5000.0)
    sim, way = roam(robot, seconds, size, seed=3, dt=0.5)
    assert way > 1000.0
    check(sim)


@pytest.mark.parametrize("name", sorted(MAKERS))
def test_the_ground_has_its_way_where_no_encoder_sees_it(name: str) -> None:
    noise = (am.NoiseElement(name="slip", noise=am.noise.Diffusion(variance_per_length=1e-4)),)
    sim = am.Simulation(building.scenario(of_drive(name, ground=noise), map=building.room(8.0, 8.0, 0.01)), seed=5)
    for _ in range(30):
        sim.step()
    assert 1e-4 < np.hypot(*(sim.true_pose - sim.estimated_pose)[0, :2]) < 0.5
    rover = sim.robot("rover")
    np.testing.assert_allclose(
        rover.readings["encoder"].true / 39400.0 * 2.0 * np.pi, rover.joints, rtol=1e-12, atol=1e-12
    )
