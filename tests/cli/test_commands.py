"""The other commands: check, new, plugins, reproduce, plot, help."""

from __future__ import annotations

import json
import sys
import tomllib
from pathlib import Path

import pytest

import amorsim as am
from tests.cli.conftest import Command

COMMANDS = ("run", "reproduce", "check", "plot", "new", "plugins")


def test_help_names_every_command_and_option(amorsim: Command) -> None:
    result = amorsim("--help")
    assert result.status == 0
    for command in COMMANDS:
        assert f"\n  {command} " in result.out
        shown = amorsim(command, "--help")
        assert shown.status == 0
        assert shown.out.startswith(f"Usage: amorsim {command} ")
        assert "..." not in shown.out.split("Options:")[1].replace("[ARGS]...", "").split("Commands:")[0]
    for option in ("--out", "--seed", "--duration", "--replicas", "--replica", "--resolution", "--set", "--quiet"):
        assert option in amorsim("run", "--help").out


def test_version(amorsim: Command) -> None:
    assert amorsim("--version").out.startswith("amorsim 0.")


@pytest.mark.long
def test_check_prints_a_resolved_scenario_that_runs_as_it_is(amorsim: Command, study: Path, tmp_path: Path) -> None:
    assert amorsim("check", study).out == f"{study}: no faults; 8.00 m x 5.00 m, 1 robot (rover)\n"
    result = amorsim("check", study, "--resolved", "--set", "simulation.seed=77")
    document = tomllib.loads(result.out)
    assert document["simulation"] == {"dt": 0.1, "duration": 60.0, "seed": 77}
    assert len(document["robots"][0]["sensors"]["sonar"]["elements"]) == 16
    (tmp_path / "resolved.toml").write_text(result.out)
    assert amorsim("check", "resolved.toml", "--resolved").out == result.out


def test_new_begins_with_a_scenario_that_is_there(amorsim: Command, tmp_path: Path) -> None:
    result = amorsim("new", "mine", "--from", "demo", "--copy")
    assert result.status == 0, result.err
    assert sorted(path.name for path in Path("mine").iterdir()) == [
        "office.wld",
        "scenario.schema.json",
        "scenario.toml",
    ]
    assert "made office.wld, scenario.toml and scenario.schema.json in mine" in result.out
    assert amorsim("check", "mine/scenario.toml").status == 0
    assert amorsim("new", "near", "--from", "mine/scenario.toml").status == 0
    text = Path("near/scenario.toml").read_text(encoding="utf-8")
    assert text.count('map = "../mine/office.wld"') == 2
    assert "# A Pioneer 2DX" in text
    assert amorsim("check", "near/scenario.toml").status == 0
    assert "--copy is for a scenario" in amorsim("new", "far", "--copy").err
    assert "would be replaced" in amorsim("new", "near", "--from", "demo").err
    assert "Did you mean 'demo'" in amorsim("new", "far", "--from", "dmo").err
    assert not Path("far").exists()


def test_new_makes_what_runs_and_replaces_nothing(amorsim: Command, tmp_path: Path) -> None:
    result = amorsim("new", "deep/mine")
    assert result.out == (
        "made scenario.toml, controller.py, rooms.wld and scenario.schema.json in deep/mine; "
        "now: amorsim run deep/mine/scenario.toml\n"
    )
    assert amorsim("run", "deep/mine/scenario.toml", "--out", "run").status == 0
    result = amorsim("reproduce", "run")
    assert (result.status, result.out) == (0, "the same to the bit, over 600 steps\n")
    (tmp_path / "deep" / "mine" / "controller.py").write_text("# mine")
    result = amorsim("new", "deep/mine")
    assert result.status == 2
    assert "would be replaced" in result.err
    assert (tmp_path / "deep" / "mine" / "controller.py").read_text() == "# mine"


@pytest.mark.long
def test_the_new_controller_keeps_off_the_walls(study: Path, tmp_path: Path) -> None:
    for seed in range(3):
        summary = am.run(am.load(study), tmp_path / str(seed), seed=seed)
        assert summary.collisions == {"rover": 0}
        assert summary.distance["rover"] > 5.0


def test_plugins_lists_and_shows(amorsim: Command) -> None:
    result = amorsim("plugins")
    assert result.status == 0
    for line in ("drive:", "sensor:", "noise:", "map loader:", "estimator:", "controller:", "recorder:", "robot:"):
        assert line in result.out.splitlines()
    assert "  laser " in result.out
    shown = amorsim("plugins", "show", "laser").out
    for part in ("sensor laser", "fov_deg", "a number [degrees]", "range_max", "[m], > 0", "181"):
        assert part in shown
    assert amorsim("plugins", "show", "sensor/laser").out == shown
    assert amorsim("plugins", "laser").out == shown
    assert "wheel_radius_left = 0.0825" in amorsim("plugins", "show", "pioneer2dx").out
    result = amorsim("plugins", "show", "lasr")
    assert result.status == 2
    assert (
        result.err
        == "nothing is registered as 'lasr'. Did you mean 'laser'? `amorsim plugins` lists all, kind by kind\n"
    )


def test_reproduce_tells_a_difference_by_its_exit_status(amorsim: Command, study: Path, tmp_path: Path) -> None:
    amorsim("run", study, "--duration", "1", "--out", "run", "-q")
    poses = tmp_path / "run" / "poses.csv"
    poses.write_text(poses.read_text().replace("0.500000,rover,1.", "0.500000,rover,2."))
    result = amorsim("reproduce", "run")
    assert result.status == 1
    assert result.out.startswith("not the same: ")
    assert "at tick 5 (0.5 s), robot 'rover', in poses.csv, line 7: true_x was 2." in result.out
    assert amorsim("reproduce", "run", "--quiet").out == ""


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"status": "running"}, "this run did not end in order; its files end at 0.3 s"),
        ({"status": "interrupted"}, "this run was interrupted; its files end at 0.3 s"),
        ({}, ""),
    ],
)
def test_plot_says_when_a_run_is_unfinished(
    amorsim: Command, study: Path, monkeypatch: pytest.MonkeyPatch, change: dict[str, str], words: str
) -> None:
    monkeypatch.setattr("amorsim.analysis.plots.plot.save_figure", lambda *_, **__: None)
    assert amorsim("run", study, "--duration", 0.3, "--out", "run", "-q").status == 0
    about = Path("run/run.json")
    about.write_text(json.dumps(json.loads(about.read_text()) | change))
    result = amorsim("plot", "run")
    assert result.status == 0
    assert (words in result.err) if words else (result.err == "")


def test_plot_without_matplotlib_says_how_to_get_it(
    amorsim: Command, study: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    amorsim("run", study, "--duration", "0.1", "--out", "run", "-q")
    for name in ("plot", "figures"):
        monkeypatch.delitem(sys.modules, f"amorsim.analysis.plots.{name}", raising=False)
    for name in ("matplotlib", "matplotlib.figure", "matplotlib.transforms"):
        monkeypatch.setitem(sys.modules, name, None)
    result = amorsim("plot", "run")
    assert result.status == 2
    assert 'python -m pip install "amorsim[plot]"' in result.err


@pytest.mark.long
def test_a_resolved_scenario_tells_of_sensors_without_a_rate(amorsim: Command, study: Path) -> None:
    remark = "# rate: none is given, so it reads in every step"
    whole = amorsim("check", study, "--resolved").out
    some = amorsim("check", study, "--resolved", "--set", "robots.0.sensors.laser.rate=5").out
    assert whole.count(remark) == some.count(remark) + 1 > 1
    assert "rate = 5" in some


@pytest.mark.long
def test_check_tells_the_maps_warnings_also_where_there_are_faults(amorsim: Command, study: Path) -> None:
    world = study.parent / "rooms.wld"
    world.write_text(world.read_text(encoding="utf-8") + "\nnonsense 1 2\n", encoding="utf-8")
    warning = "warning: rooms: line "
    assert warning in amorsim("check", study).err
    for change in ("robots.0.controller.sped=1", "robots.0.pose.x=4.0"):
        result = amorsim("check", study, "--set", change)
        assert warning in result.err
        assert "1 fault found" in result.err


def test_runsim_is_in_the_help(amorsim: Command) -> None:
    assert "runsim" in amorsim("--help").out


def test_edit_and_createsim_are_in_the_help_and_complain_of_what_is_not_there(amorsim: Command) -> None:
    assert "createsim" in amorsim("--help").out
    for name in ("edit", "createsim"):
        done = amorsim(name, "demmo", "--no-open")
        assert done.status == 2
        assert "demmo: there is no such file" in done.err
        assert "'demo'" in done.err


def test_the_manual_of_a_component_names_fields_as_files_do(amorsim: Command) -> None:
    sonar = amorsim("plugins", "show", "sonar").out
    assert "a table of x, y, heading_deg" in sonar
    assert "x 0, y 0, heading_deg 0" in sonar
    assert "Mount(" not in sonar
    assert "std_deg, in degrees, for angles" in amorsim("plugins", "show", "gaussian").out


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("\n[simulation]\nseed = 2\n", "scenario.toml:{line}: the table [simulation] stands in this file already"),
        ("\n[robots.errors]\n", "scenario.toml:{line}: the table [robots.errors] stands in this file already"),
    ],
)
def test_a_table_given_twice_is_reported_in_plain_words(amorsim: Command, study: Path, text: str, says: str) -> None:
    before = study.read_text(encoding="utf-8")
    study.write_text(before + "\n[[robots]]\n[robots.errors]\n" + text, encoding="utf-8")
    found = amorsim("check", study)
    line = before.count("\n") + 5
    assert says.format(line=line) in found.err
    assert "Cannot declare" not in found.err


def test_a_key_given_twice_is_reported_in_plain_words(amorsim: Command, study: Path) -> None:
    text = study.read_text(encoding="utf-8")
    study.write_text(text.replace("format = 1", "format = 1\nformat = 1", 1), encoding="utf-8")
    assert "this key has a value already; leave one of the two out" in amorsim("check", study).err


@pytest.mark.parametrize("command", ["check", "run"])
def test_what_a_component_raises_is_reported_in_a_few_lines(
    amorsim: Command, study: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    def start(self: object, context: object) -> None:
        raise KeyError("laser")

    monkeypatch.setattr("amorsim.estimators.dead_reckoning.DeadReckoning.start", start)
    result = amorsim(command, study)
    assert result.status == 2
    lines = result.err.splitlines()
    assert "estimator 'dead_reckoning' (DeadReckoning) of robot 'rover' at 0 s raised KeyError: 'laser'" in lines
    assert '    raise KeyError("laser")' in result.err
    assert len(lines) < 8
