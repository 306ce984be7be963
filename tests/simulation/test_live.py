"""Every field of every component, changed in mid-run: what may be is, and is repeated; what may not says why."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.contracts import Context, Draws, Noise, State, parameter
from amorsim.core.parameters import Parameter, describe
from amorsim.noise import Bump
from amorsim.plugins.manager import make_registry
from amorsim.scenario.spec import MountedSensor
from amorsim.testing import example
from tests import building
from tests.drives.fleet import MAKERS, make

REGISTRY = make_registry(entry_points=[])
_GIVEN: dict[str, dict[str, Any]] = {
    "beam_model": {"hit": 0.5, "short": 0.2, "max": 0.1, "random": 0.2, "range_max": 8.0},
    "bump": {"height": 0.004, "rate": 1.0},
    "dropout": {"probability": 0.1, "report": "value", "value": 0.5},
    "quantize": {"step": 0.01},
    "saturate": {"minimum": -5.0, "maximum": 5.0},
    "scale": {"factor": 1.01},
    "slip": {"at": 0.1, "duration": 0.5, "factor": 0.9},
    "stuck": {"rate": 0.5, "duration": 0.5},
}
GROUND = ("bump", "diffusion", "odometry_model", "slip", "velocity_model")
RANGES = ("beam_model", "cross_talk", "specular_loss", "aim_gaussian", "motion_distortion")


def element(name: str) -> am.NoiseElement:
    return am.NoiseElement(name=name, noise=example(REGISTRY.get("noise", name), **_GIVEN.get(name, {})))


def everything(drive: str = "differential") -> am.Robot:
    """A robot with every element of noise that fits somewhere, a sonar, a laser, a gyro and a compass."""
    others = [n for n in REGISTRY.names("noise") if n not in (*GROUND, *RANGES, "latency_jitter", "missed")]
    ring = tuple(am.Mount(x=0.1, heading=heading) for heading in (-0.5, 0.5))
    sonar = am.sensors.Sonar(elements=ring, medium="ultrasound", firing=(0, 1))
    return building.robot(
        drive=make(drive),
        controller=am.controllers.Manual(),
        shape=am.Shape.circle(0.2),
        ground=[element(name) for name in GROUND],
        sensors={
            "encoder": am.MountedSensor(sensor=building.encoder(), rate=8.0),
            "sonar": am.MountedSensor(sensor=sonar, mount=am.Mount(x=0.05), noise=[element(name) for name in RANGES]),
            "laser": am.MountedSensor(sensor=am.sensors.Laser(beams=9), rate=5.0, latency=0.1),
            "gyro": am.MountedSensor(sensor=am.sensors.Gyro(), noise=[element(name) for name in others]),
            "finder": am.MountedSensor(sensor=am.sensors.Fiducial(), noise=[element("missed")]),
            "compass": am.MountedSensor(sensor=am.sensors.Compass(), noise=[element("latency_jitter")]),
        },
    )


def fields(robot: am.Robot) -> list[tuple[str, Parameter, Any]]:
    """The path, description and value of every field of the robot's parts, as `set` names it."""
    found: list[tuple[str, Parameter, Any]] = []

    def add(path: str, thing: Any, names: Any = None) -> None:
        for name, described in describe(type(thing)).items():
            if names is None or name in names:
                found.append((f"{path}.{name}", described, getattr(thing, name)))

    add("drive", robot.drive)
    for part in robot.ground:
        add(f"ground.{part.name}", part.noise)
    for name, unit in robot.sensors.items():
        add(f"sensors.{name}", unit.sensor)
        add(f"sensors.{name}", unit, ("rate", "latency"))
        add(f"sensors.{name}.mount", unit.mount)
        for part in unit.noise:
            add(f"sensors.{name}.noise.{part.name}", part.noise)
    for name, estimator in robot.estimators.items():
        add(f"estimators.{name}", estimator)
    return found


def is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


# Weights that sum to one are changed by changing two of them, which one call cannot.
APART = ("sensors.sonar.noise.beam_model.hit", "sensors.sonar.noise.beam_model.short")
APART += ("sensors.sonar.noise.beam_model.max", "sensors.sonar.noise.beam_model.random")


def near(described: Parameter, value: float) -> float:
    """Another value, a little off, within bounds."""
    for candidate in (value * 0.99, value * 1.01, value + 0.01, value - 0.01):
        low = (described.gt is None or candidate > described.gt) and (described.ge is None or candidate >= described.ge)
        high = (described.lt is None or candidate < described.lt) and (
            described.le is None or candidate <= described.le
        )
        if low and high and candidate != value:
            return candidate if not isinstance(value, int) else value
    raise AssertionError(described)


def live_fields(robot: am.Robot) -> list[tuple[str, float]]:
    return [
        (path, near(described, value))
        for path, described, value in fields(robot)
        if described.live and is_number(value) and path not in APART
    ]


@pytest.mark.long
@pytest.mark.parametrize(
    "drive", [pytest.param(name, marks=() if name == "differential" else pytest.mark.long) for name in MAKERS]
)
def test_every_live_field_is_changed_and_the_run_repeated(drive: str, tmp_path: Path) -> None:
    robot = everything(drive)
    (tmp_path / "room.wld").write_text(
        "width 6000\nheight 5000\n0 0 6000 0\n6000 0 6000 5000\n6000 5000 0 5000\n0 5000 0 0\n", encoding="utf-8"
    )
    scenario = building.scenario(robot, map=am.load_map(tmp_path / "room.wld"))
    sim = am.Simulation(scenario, replicas=2)
    changes = live_fields(robot)
    assert len(changes) > (60 if drive == "differential" else 50)
    sim.robot("rover", 0).drive(forward=0.1)
    with am.record(sim, tmp_path / "run", duration=len(changes) * sim.dt) as session:
        for i, (path, value) in enumerate(changes):
            sim.set("rover", path, value, replica=None if i % 2 else 1)
            event = sim.events[-1]
            assert (event.kind, event.path, event.value) == ("parameter_set", path, value)
            sim.step()
            session.keep()
    plain = am.Simulation(scenario, replicas=2)
    plain.robot("rover", 0).drive(forward=0.1)
    plain.run(len(changes) * plain.dt)
    assert plain.digest(1) != sim.digest(1)
    assert am.reproduce(tmp_path / "run").is_exact


@pytest.mark.long
def test_each_change_holds_for_its_robot_alone_and_from_the_next_step_on() -> None:
    robot = everything()
    for path, value in live_fields(robot):
        sim = am.Simulation(building.scenario(robot), replicas=2)
        (group,) = sim._fleet.groups
        sim.set("rover", path, value, replica=1)
        before, after = group.specified
        assert before is robot
        changed = {p: v for p, _, v in fields(after)}
        assert changed.pop(path) == value
        assert changed == {p: v for p, _, v in fields(robot) if p != path}


def test_what_fixes_shapes_or_is_no_number_refuses_and_says_why() -> None:
    robot = everything()
    sim = am.Simulation(building.scenario(robot))
    digest = sim.digest()
    refused = [(p, d, v) for p, d, v in fields(robot) if not d.live or not is_number(v)]
    assert {path.rpartition(".")[2] for path, _, _ in refused} >= {
        *("latency", "spread", "beams", "traversal", "medium", "elements", "report", "per", "scope", "joint"),
    }
    for path, described, value in refused:
        with pytest.raises(am.AmorsimError) as caught:
            sim.set("rover", path, value if is_number(value) else 1.0)
        wanted = "is fixed once a simulation is made" if not described.live else "only a number can be changed"
        assert wanted in str(caught.value), path
        assert path.rpartition(".")[2] in str(caught.value)
    assert sim.digest() == digest
    assert not sim.events


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("fiducial", 7),
        ("height", 0.9),
        ("kidnappings.0.time", 0.5),
        ("initial_belief.std", 0.2),
        ("knowledge.landmarks.0.0", 1.0),
    ],
)
def test_what_a_robot_is_made_with_is_fixed(path: str, value: float) -> None:
    robot = building.robot(
        kidnappings=[am.Kidnapping(time=1.0, x=4.0, y=3.0)],
        initial_belief=am.InitialBelief(kind="gaussian", std=0.1),
        knowledge=am.Knowledge(landmarks=[(1.0, 2.0)]),
    )
    sim = am.Simulation(building.scenario(robot))
    words = f"'{path.partition('.')[0]}' of a robot is fixed once a simulation is made"
    with pytest.raises(am.AmorsimError, match=words):
        sim.set("rover", path, value)
    assert not sim.events


def test_a_value_of_an_error_takes_the_place_of_its_scale_which_is_refused_then() -> None:
    sim = am.Simulation(building.scenario(building.robot(errors={"drive.track": am.Deviation(scale=1.1)})))
    sim.set("rover", "errors.drive.track.value", 0.4)
    assert sim.robot("rover").true.drive.track == 0.4
    with pytest.raises(am.AmorsimError, match="expected either value, or scale and add"):
        sim.set("rover", "errors.drive.track.scale", 1.2)
    with pytest.raises(am.AmorsimError, match="expected either value, or scale and add"):
        sim.set("rover", "errors.drive.track", {"scale": 1.2, "value": 0.4})
    assert sim.robot("rover").true.drive.track == 0.4
    sim.set("rover", "errors.drive.track.value", None)
    sim.set("rover", "errors.drive.track.scale", 1.2)
    assert sim.robot("rover").true.drive.track == building.TRACK * 1.2


def test_a_value_out_of_bounds_is_refused_and_nothing_changes() -> None:
    robot = everything()
    sim = am.Simulation(building.scenario(robot))
    tried = 0
    for path, described, value in fields(robot):
        bound = described.ge if described.ge is not None else described.gt
        if described.live and is_number(value) and bound is not None:
            tried += 1
            with pytest.raises(am.AmorsimError, match=r"expected .* got "):
                sim.set("rover", path, bound - 1)
    assert tried > 40
    (group,) = sim._fleet.groups
    assert {p: v for p, _, v in fields(group.specified[0])} == {p: v for p, _, v in fields(robot)}


# --------------------------------------------------------------------------------------------- common random numbers


@attrs.frozen(kw_only=True)
class Ear(Noise):
    """Changes nothing, and keeps what it drew."""

    size: int = parameter(3, ge=1, static=True, help="how much it draws")

    def start(self, context: Context) -> State:
        return {"drawn": np.zeros((context.rows, self.size))}

    def corrupt(self, values: Any, side: Any, elapsed: Any, state: State, draws: Draws) -> Any:
        state["drawn"] = draws.normal(self.size)
        return values


def test_whatever_is_switched_off_leaves_the_draws_of_all_others() -> None:
    """Each random error, ground element, element of a chain, sensor and zone taken away, one after the other."""
    spread = am.Distribution(kind="normal", values=(1.0, 0.01))
    errors = {
        path: am.Deviation(scale=spread)
        for path in ("drive.track", "drive.wheel_radius_left", "sensors.gyro.mount.x", "sensors.laser.range_max")
    }

    def chain(*names: str) -> list[am.NoiseElement]:
        return [am.NoiseElement(name=name, noise=Ear()) for name in names]

    robot = building.robot(
        errors=errors,
        ground=[*chain("first", "second"), am.NoiseElement(name="bump", noise=Bump(height=0.001, rate=5.0))],
        sensors={
            name: MountedSensor(sensor=sensor, mount=am.Mount(x=0.1), noise=chain("first", "second"))
            for name, sensor in (("gyro", am.sensors.Gyro()), ("laser", am.sensors.Laser(beams=5)))
        },
        estimators={},
    )
    zones = [
        am.Zone(name=name, shape=am.Shape.circle(9.0), ground=chain("first", "second")) for name in ("wet", "rough")
    ]
    base = building.scenario(robot, zones=zones)

    def drawn(scenario: am.Scenario) -> dict[str, Any]:
        sim = am.Simulation(scenario, replicas=3)
        sim.run(0.5)
        (group,) = sim._fleet.groups
        found = {where: state["drawn"].tobytes() for where, state in group.states().items() if "drawn" in state}
        for path in scenario.robots[0].errors:
            things = list(group.true)
            for part in path.split("."):
                things = [_part(thing, part) for thing in things]
            found[path] = things
        return found

    everything_ = drawn(base)
    assert len(everything_) == 14
    assert len({value for value in everything_.values() if isinstance(value, bytes)}) == 10

    def check(name: str, **changes: Any) -> None:
        scenario = attrs.evolve(base, robots=[attrs.evolve(robot, **changes)])
        left = drawn(scenario)
        assert left == {where: value for where, value in everything_.items() if where in left}, name
        assert len(left) < len(everything_), name

    for path in errors:
        check(path, errors={p: e for p, e in errors.items() if p != path})
    for part in robot.ground[:2]:
        check(part.name, ground=[other for other in robot.ground if other is not part])
    for name, unit in robot.sensors.items():
        rest = {p: e for p, e in errors.items() if not p.startswith(f"sensors.{name}.")}
        check(name, sensors={n: u for n, u in robot.sensors.items() if n != name}, errors=rest)
        for part in unit.noise:
            thinner = attrs.evolve(unit, noise=[other for other in unit.noise if other is not part])
            check(f"{name} {part.name}", sensors={**robot.sensors, name: thinner})
    for zone in zones:
        left = drawn(attrs.evolve(base, zones=[other for other in zones if other is not zone]))
        assert left == {where: value for where, value in everything_.items() if where in left}
    other = building.robot(name="other", pose=am.Pose(x=4.5, y=4.0))
    sim = am.Simulation(attrs.evolve(base, robots=[robot, other]), replicas=3)
    sim.run(0.5)
    found = {
        w: s["drawn"].tobytes()
        for g in sim._fleet.groups
        for w, s in g.states().items()
        if "rover" in g.names and "drawn" in s
    }
    assert found == {where: value for where, value in everything_.items() if isinstance(value, bytes)}


def _part(thing: Any, name: str) -> Any:
    if isinstance(thing, dict):
        return thing[name]
    if isinstance(thing, MountedSensor) and not hasattr(thing, name):
        return getattr(thing.sensor, name)
    return getattr(thing, name)
