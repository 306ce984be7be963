"""amorsim plan: a path on a map, its figures and its picture, and what is said where there is none."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import amorsim as am
from amorsim.cli.console import compile_planners_once
from amorsim.runs import warm
from tests.cli.conftest import Command

ENDS = ("--from", "0.55,0.55", "--to", "5.05,1.05,90")


@pytest.fixture
def rooms(tmp_path: Path) -> str:
    """Two rooms, 6 m x 4 m, with a door 1 m wide."""
    walls = np.zeros((40, 60))
    walls[:, 30] = 1
    walls[25:35, 30] = 0
    am.save_map(am.Map.from_array(walls, resolution=0.1), tmp_path / "rooms.yaml")
    return "rooms.yaml"


@pytest.mark.long
def test_a_path_is_printed_and_drawn(amorsim: Command, rooms: str, tmp_path: Path) -> None:
    result = amorsim("plan", rooms, *ENDS, "--planner", "theta_star", "--footprint", "0.2")
    assert (result.status, result.err) == (0, "")
    world = am.load_map(tmp_path / rooms)
    plan = am.planners.ThetaStar().plan(world, (0.55, 0.55), (5.05, 1.05), footprint=am.Shape.circle(0.2))
    first, second = result.out.splitlines()[-2:]  # before them, perhaps, that kernels are compiled
    assert re.match(rf"found: length {plan.length:.3f} m, .*{plan.expanded} expanded, [0-9.]+ m?s", first)
    assert second == "picture: plan.png"
    with Image.open(tmp_path / "plan.png") as opened:
        picture = np.asarray(opened.convert("RGB")).astype(int)
    reds = (picture[..., 0] > 180) & (picture[..., 1] < 90) & (picture[..., 2] < 90)
    blues = picture[..., 2] - picture[..., 0] > 20
    assert reds.sum() > 1000
    assert blues.sum() > 10_000


@pytest.mark.long
def test_no_path_has_a_status_and_a_picture(amorsim: Command, rooms: str, tmp_path: Path) -> None:
    wide = ("--from", "1.05,1.05", "--to", "5.05,1.05", "--footprint", "0.9x0.8", "-o", "wide.png")
    result = amorsim("plan", rooms, *wide)
    assert result.status == 1
    assert "\nunreachable: " in "\n" + result.out
    assert "one that reaches 0.4 m would pass" in result.err
    assert (tmp_path / "wide.png").exists()
    result = amorsim("plan", rooms, *ENDS, "--set", "budget=0", "-o", "none.png")
    assert (result.status, result.out.splitlines()[-2].split(":")[0]) == (1, "budget")
    assert "the budget of 0 cells was used up" in result.err


@pytest.mark.long
def test_what_is_ignored_of_the_map_is_said_once(amorsim: Command, tmp_path: Path) -> None:
    (tmp_path / "valley.map").write_text("type octile\nheight 3\nwidth 4\nmap\n....\n....\n....\n")
    result = amorsim("plan", "valley.map", "--from", "0.5,0.5", "--to", "3.5,2.5", "-o", "valley.png")
    assert result.status == 0, result.err
    assert result.err.count("valley: no resolution is given, so a cell is taken for 1 m") == 1


@pytest.mark.long
def test_generated_worlds_and_scenarios_are_maps(amorsim: Command) -> None:
    ends = ("--from", "2,2", "--to", "4,3")
    result = amorsim("plan", "maze", "--seed", 3, "--set", "world.size=[6.0, 5.0]", *ends, "-o", "maze.png")
    assert (result.status, result.err) == (0, "")
    assert am.planners.AStar().plan(am.worlds.maze(3, size=(6.0, 5.0)), (2, 2), (4, 3)).length == pytest.approx(
        float(result.out.splitlines()[-2].split()[2]), abs=5e-4
    )
    ends = ("--from", "5,4", "--to", "9,4")
    result = amorsim("plan", "landmarks", *ends, "--set", "cell=0.1", "--robot", "pioneer2dx", "-o", "marks.png")
    assert (result.status, result.err) == (0, "")


@pytest.mark.long
def test_on_a_map_of_very_many_cells_it_plans_on_coarse_ones_and_says_so(amorsim: Command, tmp_path: Path) -> None:
    (tmp_path / "hall.wld").write_text("width 5000\nheight 4000\n2500 0 2500 3000\n")
    ends = ("--from", "1,1", "--to", "4,1")
    result = amorsim("plan", "hall.wld", *ends)
    assert result.status == 0
    assert "planned on cells of 0.05 m, as the map has 5000 x 4000; --set cell=SIDE chooses others" in result.err
    coarse = am.planners.AStar(cell=0.05).plan(am.load_map(tmp_path / "hall.wld"), (1.0, 1.0), (4.0, 1.0))
    assert f"length {coarse.length:.3f} m" in result.out
    assert "planned on" not in amorsim("plan", "hall.wld", *ends, "--set", "cell=0.1", "--force").err


def test_kernels_of_planners_are_compiled_once_and_it_is_said(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    compiled: list[object] = []
    monkeypatch.setattr(warm, "_is_compiled", compiled.__contains__)
    monkeypatch.setattr(warm, "compile_planner", compiled.append)
    planners = [am.planners.ThetaStar(), am.planners.HybridAStar(), am.planners.ThetaStar(lazy=True)]
    compile_planners_once(planners)
    names = "theta_star, hybrid_a_star"
    said = f"compiling the kernels of the planner {names}, once after installing (up to a minute) ...\n"
    assert capsys.readouterr().out == said
    compile_planners_once(planners)
    assert capsys.readouterr().out == ""
    assert compiled == [am.planners.ThetaStar, am.planners.HybridAStar]
    compiled.clear()
    compile_planners_once(planners, quiet=True)
    assert capsys.readouterr().out == ""
    assert len(compiled) == 2


@pytest.mark.parametrize("command", ["plan", "run"])
def test_it_is_said_before_the_first_plan(
    amorsim: Command, rooms: str, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    def compile_planner(kind: type) -> None:
        raise am.AmorsimError(f"compiling {kind.__name__}")

    monkeypatch.setattr(warm, "_is_compiled", lambda kind: False)
    monkeypatch.setattr(warm, "compile_planner", compile_planner)
    asked = ("run", "unknown-maze", "--out", "run") if command == "run" else ("plan", rooms, *ENDS)
    result = amorsim(*asked)
    assert result.status == 2
    assert result.err == f"compiling {'DStarLite' if command == 'run' else 'AStar'}\n"
    assert "once after installing" in result.out


@pytest.mark.long
def test_a_picture_that_is_there_is_replaced_by_force_alone(amorsim: Command, rooms: str, tmp_path: Path) -> None:
    (tmp_path / "plan.png").write_text("mine")
    result = amorsim("plan", rooms, *ENDS)
    assert (result.status, result.err) == (2, "plan.png is there already; --force replaces it, -o names another file\n")
    assert (tmp_path / "plan.png").read_text() == "mine"
    assert amorsim("plan", rooms, *ENDS, "--force").status == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--from", "1", "--to", "2,2"), "--from: expected X,Y or X,Y,DEG, finite numbers"),
        (("--from", "1,1", "--to", "nan,2"), "--to: expected X,Y or X,Y,DEG, finite numbers"),
        ((*ENDS, "--planner", "a_sta"), "Did you mean 'a_star'?"),
        ((*ENDS, "--set", "cel=0.1"), "Did you mean 'cell'?"),
        ((*ENDS, "--set", "cell=-1"), "cell: expected"),
        ((*ENDS, "--footprint", "-1"), "--footprint: expected a radius [m] above 0"),
        ((*ENDS, "--footprint", "1x2x3"), "--footprint: expected"),
        ((*ENDS, "--robot", "pioner2dx"), "Did you mean 'pioneer2dx'?"),
        ((*ENDS, "--robot", "pioneer2dx", "--footprint", "1"), "expected one of them"),
        ((*ENDS, "-o", "plan.xyz"), "plan.xyz: expected the name of a picture"),
    ],
)
def test_a_mistake_is_said_in_words(
    amorsim: Command, rooms: str, tmp_path: Path, arguments: tuple[str, ...], words: str
) -> None:
    result = amorsim("plan", rooms, *arguments)
    assert result.status == 2
    assert words in result.err
    assert not list(tmp_path.glob("plan.*"))


def _fail() -> am.Plan:
    raise KeyError("no such key")


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (_fail, "plan() raised KeyError: 'no such key'"),
        (lambda: None, "expected a Plan, got None from plan()"),
        (lambda: [(0.0, 0.0)], "expected a Plan, got [(0.0, 0.0)] from plan()"),
        (lambda: am.Plan(status="lost"), "got 'lost'"),
        (lambda: am.Plan(status="found", length=1.0, cost=1.0), "expected a Plan with `poses`"),
        (
            lambda: am.Plan(status="found", poses=np.full((2, 3), np.nan), length=1.0, cost=1.0),
            "expected a Plan with finite numbers in `poses`, got nan or inf",
        ),
        (lambda: am.Plan(status="found", poses=np.zeros((2, 2)), length=1.0), "`poses` of numbers (M, 3)"),
        (lambda: am.Plan(status="found", poses=np.zeros((2, 3))), "whose `length` is a number >= 0, got inf"),
    ],
)
def test_an_answer_that_is_no_plan_is_said_with_the_planners_name(
    amorsim: Command, rooms: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, answer: Any, words: str
) -> None:
    monkeypatch.setattr(am.planners.AStar, "plan", lambda self, world, start, goal, *, footprint=None: answer())
    result = amorsim("plan", rooms, *ENDS)
    assert result.status == 2
    assert result.err.startswith("planner (AStar): ")
    assert words in result.err
    assert not list(tmp_path.glob("plan.*"))


@pytest.mark.parametrize("name", ["plan.txt", "plan", "plan.xbm"])  # a known ending, that of a black and white picture
def test_a_picture_that_cannot_be_written_is_refused_before_the_search(
    amorsim: Command, rooms: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.setattr("amorsim.cli.scenarios.plan._timed", lambda *_: pytest.fail("it searched"))
    result = amorsim("plan", rooms, *ENDS, "-o", name)
    assert (result.status, result.err) == (2, f"{name}: expected the name of a picture, such as plan.png\n")
    assert not (tmp_path / name).exists()


def test_a_missing_map_is_said_in_words(amorsim: Command) -> None:
    result = amorsim("plan", "nowhere.png", *ENDS)
    assert result.status == 2
    assert "there is no such file" in result.err


def test_a_planner_need_not_say_a_cost(amorsim: Command, rooms: str, monkeypatch: pytest.MonkeyPatch) -> None:
    poses = np.array([[0.55, 0.55, 0.0], [1.55, 0.55, 0.0]])
    found = am.Plan(status="found", poses=poses, length=1.0)
    monkeypatch.setattr(am.planners.AStar, "plan", lambda self, world, start, goal, *, footprint=None: found)
    result = amorsim("plan", rooms, *ENDS)
    assert result.status == 0
    assert "found: length 1.000 m, 0 expanded" in result.out
