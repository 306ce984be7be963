"""A scenario saved in the window is its author's file, except for what was changed."""

from __future__ import annotations

from pathlib import Path

import pytest

import amorsim as am
from amorsim.core.maps.same_cells import have_same_cells
from amorsim.ui.simulator.saved_scenario import save_scenario

AUTHORED = """\
# A study of drift.
format = 1
description = "as its author wrote it"

[world]
map = "room.wld"   # 8 m by 6 m

[simulation]
seed = 3
duration = 20      # s

[[robots]]
name = "rover"
model = "pioneer2dx"
pose = { x = 1.00, y = 1.0 }
controller = { use = "parts/mine.py:go", speed = 0.25 } # mine

[robots.errors]
drive.track = { scale = 1.02 } # measured on Monday

[robots.sensors.laser]
beams = 31

[[robots]]
name = "pair"
model = "pioneer2dx"
count = 2
start = { poses = [{ x = 3.0, y = 3.0 }, { x = 5.0, y = 3.0 }] }
controller = { use = "wander", speed = 0.2 }
"""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    folder = tmp_path / "study"
    (folder / "parts").mkdir(parents=True)
    (folder / "room.wld").write_text("width 8000\nheight 6000\nposition 1000 1000 0\n")
    (folder / "parts" / "mine.py").write_text("def go(readings, estimate, clock, speed):\n    return None\n")
    (folder / "scenario.toml").write_text(AUTHORED)
    return folder / "scenario.toml"


def changed_lines(text: str) -> list[str]:
    """The lines of a text that its author did not write."""
    return [line for line in text.splitlines() if line not in AUTHORED.splitlines()]


def test_saved_unchanged_beside_its_file_it_is_the_same_to_the_byte(study: Path) -> None:
    copy = study.with_name("copy.toml")
    save_scenario(am.Simulation(am.load(study)), copy)
    assert copy.read_bytes() == study.read_bytes()


def test_only_what_was_changed_differs(study: Path) -> None:
    simulation = am.Simulation(am.load(study))
    simulation.set("rover", "drive.track", 0.34)
    simulation.set("rover", "errors.drive.track.scale", 1.05)
    simulation.set("rover", "errors.drive.wheel_radius_left.scale", 1.01)
    simulation.set("rover", "sensors.laser.mount.heading", 0.5)
    simulation.set("rover", "sensors.laser.noise.gaussian.std", 0.02)
    saved = study.with_name("saved.toml")
    save_scenario(simulation, saved)
    text = saved.read_text()
    assert "# measured on Monday" in text
    kept = [line for line in AUTHORED.splitlines() if line not in text.splitlines()]
    assert kept == ["drive.track = { scale = 1.02 } # measured on Monday"]
    assert len(changed_lines(text)) <= 12
    again = am.Simulation(am.load(saved))
    for name in simulation.names:
        one, other = again.robot(name), simulation.robot(name)
        assert (one.nominal.drive, one.nominal.errors) == (other.nominal.drive, other.nominal.errors)
        assert one.nominal.sensors["laser"] == other.nominal.sensors["laser"]
    assert am.open_document(saved).inherited("robots.rover.drive.track").under is not None


@pytest.mark.parametrize("value", [None, {"scale": 1.0}])
def test_an_error_that_was_removed_or_set_back_is_not_written_any_more(study: Path, value: object) -> None:
    simulation = am.Simulation(am.load(study))
    simulation.set("rover", "errors.drive.track", value)
    simulation.set("rover", "errors.drive.lag.add", 0.1)
    simulation.set("rover", "errors.drive.lag.add", 0.0)
    saved = study.with_name("saved.toml")
    save_scenario(simulation, saved)
    assert saved.read_text() == AUTHORED.replace(
        "[robots.errors]\ndrive.track = { scale = 1.02 } # measured on Monday\n\n", ""
    )


def test_an_error_of_the_model_that_was_removed_is_overridden(study: Path) -> None:
    study.with_name("mine.toml").write_text('format = 1\nmodel = "pioneer2dx"\nerrors.drive.track.scale = 1.1\n')
    text = AUTHORED.replace('model = "pioneer2dx"', 'model = "mine.toml"').replace("drive.track", "drive.lag")
    study.write_text(text.replace("scale = 1.02", "add = 0.02"))
    simulation = am.Simulation(am.load(study))
    simulation.set("rover", "errors.drive.track", None)
    saved = study.with_name("saved.toml")
    save_scenario(simulation, saved)
    assert changed_lines(saved.read_text()) == [
        'model = "mine.toml"',
        "drive.lag = { add = 0.02 } # measured on Monday",
        "drive.track = { scale = 1.0 }",
        'model = "mine.toml"',
    ]


CHAIN = """
[[robots]]
name = "third"
model = "pioneer2dx"
pose = { x = 1.0, y = 5.0 }
[robots.sensors.gps]
use = "gps"
noise = [
    { use = "gaussian", std = 0.10 }, # of its data sheet
    { use = "bias", value = 0.2 },    # by the trees
    { use = "dropout", probability = 0.1 },
]
"""


def test_of_a_chain_what_stays_keeps_its_lines(study: Path) -> None:
    study.write_text(AUTHORED + CHAIN)
    simulation = am.Simulation(am.load(study))
    bias = {"use": "bias", "value": 0.3}
    scale = {"use": "scale", "factor": 1.1}
    simulation.set("third", "sensors.gps.noise", [bias, scale, {"use": "gaussian", "std": 0.1}])
    saved = study.with_name("saved.toml")
    save_scenario(simulation, saved)
    text = saved.read_text()
    assert (
        """noise = [
    { use = "bias", value = 0.3 },    # by the trees
    { use = "scale", factor = 1.1 },
    { use = "gaussian", std = 0.10 }, # of its data sheet
]
"""
        in text
    )
    assert am.load(saved).robots[3].sensors["gps"] == simulation.robot("third").nominal.sensors["gps"]


def test_of_a_chain_that_replaces_the_models_no_default_is_written(study: Path) -> None:
    simulation = am.Simulation(am.load(study))
    simulation.set("rover", "sensors.laser.noise", [{"use": "dropout", "probability": 0.1}])
    saved = study.with_name("saved.toml")
    save_scenario(simulation, saved)
    (line,) = (line for line in saved.read_text().splitlines() if "noise" in line)
    assert line.endswith('noise = [{ use = "dropout", probability = 0.1 }]')
    assert am.load(saved).robots[0].sensors["laser"] == simulation.robot("rover").nominal.sensors["laser"]


def test_settings_of_the_command_line_and_the_seed_are_said(
    study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Files that they name are those that they meant where they were typed."""
    (tmp_path / "typed").mkdir()
    (tmp_path / "typed" / "other.wld").write_text("width 9000\nheight 6000\n")
    monkeypatch.chdir(tmp_path / "typed")
    changes = ("world.map=other.wld", "robots.pair.controller.speed=0.3", "simulation.dt=0.05")
    simulation = am.Simulation(am.load(study, changes), seed=8)
    saved = tmp_path / "elsewhere.toml"
    save_scenario(simulation, saved, changes=changes)
    again = am.load(saved)
    assert (again.map.size[0], again.seed, again.dt, again.duration) == (9.0, 8, 0.05, 20.0)
    assert [robot.controller.speed for robot in again.robots[1:]] == [0.3, 0.3]  # type: ignore[union-attr]
    text = saved.read_text()
    for line in (
        'map = "typed/other.wld"   # 8 m by 6 m',
        "seed = 8",
        'controller = { use = "study/parts/mine.py:go", speed = 0.25 } # mine',
        "duration = 20      # s",
    ):
        assert line in text


def test_what_the_file_cannot_say_is_written_out(study: Path) -> None:
    """Of two robots of one table, one has changed."""
    simulation = am.Simulation(am.load(study))
    simulation.set("pair1", "controller.speed", 0.1)
    saved = study.with_name("saved.toml")
    save_scenario(simulation, saved)
    assert [robot.controller.speed for robot in am.load(saved).robots[1:]] == [0.2, 0.1]  # type: ignore[union-attr]
    assert "# mine" not in saved.read_text()


def test_all_robots_of_a_table_may_change_together(study: Path) -> None:
    simulation = am.Simulation(am.load(study))
    for name in ("pair0", "pair1"):
        simulation.set(name, "controller.speed", 0.1)
    saved = study.with_name("saved.toml")
    save_scenario(simulation, saved)
    assert changed_lines(saved.read_text()) == ['controller = { use = "wander", speed = 0.1 }']


@pytest.mark.parametrize("edit", [("[[robots]]", "[[robots"), ("track = { scale = 1.02", "track = { scale = 1.04")])
def test_a_file_that_was_edited_meanwhile_is_not_taken_for_the_scenario(study: Path, edit: tuple[str, str]) -> None:
    simulation = am.Simulation(am.load(study))
    study.write_text(AUTHORED.replace(*edit))
    saved = study.with_name("saved.toml")
    save_scenario(simulation, saved)
    assert am.load(saved).robots[0].errors["drive.track"].scale == 1.02


def test_over_its_own_file(study: Path) -> None:
    simulation = am.Simulation(am.load(study))
    simulation.set("rover", "errors.drive.track.scale", 1.05)
    save_scenario(simulation, study)
    assert study.read_text() == AUTHORED.replace("1.02", "1.05")


def test_every_bundled_scenario_is_saved_as_its_author_wrote_it(tmp_path: Path) -> None:
    for name in ("demo", "car-park", "doors"):
        scenario = am.load(name)
        saved = tmp_path / f"{name}.toml"
        save_scenario(am.Simulation(scenario), saved)
        assert scenario.source is not None
        said, written = (path.read_text().splitlines() for path in (scenario.source, saved))
        assert len(said) == len(written)
        assert all(one == other or "map" in one for one, other in zip(said, written, strict=True))
        assert have_same_cells(am.load(saved).map, scenario.map)
