"""``amorsim run``: scenarios, maps alone, and what is said of them."""

from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageDraw

from amorsim.analysis.run_files import RunFiles
from tests.cli.conftest import Command

WLD = Path(__file__).resolve().parents[3] / "shared" / "maps" / "wld"
PIONEER_FITS = ("concentric", "hallway", "serp", "uwa-ee4")


def about(folder: Path) -> dict[str, object]:
    read: dict[str, object] = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    return read


def test_the_demo_runs_and_says_what_happened(amorsim: Command, tmp_path: Path) -> None:
    result = amorsim("run", "demo", "--duration", "1")
    assert (result.status, result.err) == (0, "")
    lines = result.out.splitlines()
    assert lines[-2:] == [
        *re.findall(r"rover: drove 0\.\d\d m in 1 s, no collision; at the end the estimate is off by .* m", result.out),
        f"results: {tmp_path}/amorsim-runs/demo-001, picture: {tmp_path}/amorsim-runs/demo-001/picture.png",
    ]
    assert about(tmp_path / "amorsim-runs" / "demo-001")["status"] == "finished"
    amorsim("run", "demo", "--duration", "0.1")
    assert (tmp_path / "amorsim-runs" / "demo-002" / "picture.png").exists()


def test_without_a_terminal_the_progress_is_plain_lines(amorsim: Command, study: Path) -> None:
    def progress(duration: str) -> list[str]:
        return [line for line in amorsim("run", study, "--duration", duration).out.splitlines() if "%" in line]

    assert progress("2") == ["25 % simulated", "50 % simulated", "75 % simulated"]
    assert progress("0.2") == ["50 % simulated"]
    assert progress("0.1") == []


def test_quiet_prints_nothing(amorsim: Command, study: Path, tmp_path: Path) -> None:
    result = amorsim("run", study, "--duration", "0.5", "--quiet", "--out", "run")
    assert (result.status, result.out, result.err) == (0, "", "")
    assert (tmp_path / "run" / "poses.csv").exists()


def test_options_take_the_place_of_what_the_scenario_says(amorsim: Command, study: Path, tmp_path: Path) -> None:
    options = [
        "--seed",
        5,
        "--duration",
        0.3,
        "--set",
        "simulation.dt=0.05",
        "--set",
        "robots.rover.controller.speed=0.1",
    ]
    assert amorsim("run", study, "--out", "run", *options).status == 0
    record = about(tmp_path / "run")
    assert (record["seed"], record["duration"], record["dt"], record["steps"]) == (5, 0.3, 0.05, 6)
    text = (tmp_path / "run" / "scenario.toml").read_text()
    assert 'controller = {use = "controller.py:drive", speed = 0.1}' in text
    # So it runs again as it is.
    assert amorsim("run", "run/scenario.toml", "--out", "again").status == 0
    assert about(tmp_path / "again")["digests"] == record["digests"]


def test_replicas_by_count_and_by_number(amorsim: Command, study: Path, tmp_path: Path) -> None:
    options = ("--duration", "3", "--set", "robots.rover.errors.drive.wheel_radius_left.scale={normal=[1.0, 0.05]}")
    result = amorsim("run", study, *options, "--replicas", 3, "--out", "three")
    assert "rover (replica 0 of 3): drove" in result.out
    poses = RunFiles(tmp_path / "three").arrays("poses")
    off = np.hypot(*(poses["true_pose"] - poses["estimated_pose"])[-1, :, :2].T)
    assert (
        f"rover (all 3 replicas): no collisions; at the end estimates are off by {np.sqrt(np.mean(off**2)):.3f} m "
        f"(root mean square), in replica {off.argmax()} the most, by {off.max():.3f} m\n"
    ) in result.out
    assert about(tmp_path / "three")["replicas"] == [0, 1, 2]
    assert amorsim("run", study, *options, "--replica", 2, "--replica", 9, "--out", "two").status == 0
    assert about(tmp_path / "two")["replicas"] == [2, 9]
    assert about(tmp_path / "two")["digests"]["2"] == about(tmp_path / "three")["digests"]["2"]  # type: ignore[index]


def test_many_replicas_write_sensors_only_if_asked(amorsim: Command, study: Path, tmp_path: Path) -> None:
    result = amorsim("run", study, "--duration", "0.1", "--replicas", 40, "--out", "many")
    assert "sensors are left out" in result.out
    assert not (tmp_path / "many" / "sensors").exists()
    asked = ["--set", "recording.sensors=all"]
    result = amorsim("run", study, "--duration", "0.1", "--replicas", 40, "--out", "asked", *asked)
    assert "left out" not in result.out
    assert (tmp_path / "asked" / "sensors" / "laser.csv").exists()


@pytest.mark.skipif(not WLD.exists(), reason="the shared maps are not here")
@pytest.mark.parametrize("name", PIONEER_FITS)
def test_a_real_map_alone_runs(amorsim: Command, tmp_path: Path, name: str) -> None:
    result = amorsim("run", WLD / f"{name}.wld", "--duration", "0.5", "--out", "run")
    assert result.status == 0, result.err
    assert "rover: drove" in result.out
    assert (tmp_path / "run" / f"{name}.wld").exists()
    if name == "concentric":
        assert "line 294: left out 'ush 500 0 -5'" in result.err


@pytest.mark.skipif(not WLD.exists(), reason="the shared maps are not here")
def test_a_map_for_smaller_robots_says_that_there_is_no_room(amorsim: Command, tmp_path: Path) -> None:
    result = amorsim("run", WLD / "serp-sm.wld", "--duration", "0.5", "--out", "run")
    assert result.status == 2
    assert "robots.rover.pose: missing, and the map has no place where a footprint" in result.err
    assert not (tmp_path / "run").exists()


@pytest.mark.skipif(not WLD.exists(), reason="the shared maps are not here")
def test_where_the_roomiest_place_is_too_small_another_is_found(amorsim: Command) -> None:
    result = amorsim("run", WLD / "table.wld", "--duration", "0.5", "--out", "run")
    assert result.status == 0
    assert "leaves the robot no room; it starts at (" in result.err


def box(tmp_path: Path, extra: str) -> Path:
    walls = "0 0 4000 0\n4000 0 4000 4000\n4000 4000 0 4000\n0 4000 0 0\n2000 0 2000 4000\n"
    (tmp_path / "box.wld").write_text(f"width 4000\nheight 4000\n{walls}{extra}")
    return tmp_path / "box.wld"


def first_pose(folder: Path) -> list[float]:
    return np.loadtxt(folder / "poses.csv", delimiter=",", skiprows=1, usecols=(2, 3, 4))[0].tolist()


def test_a_map_alone_is_entered_where_it_says(amorsim: Command, tmp_path: Path) -> None:
    result = amorsim("run", box(tmp_path, "position 3000 1000 90\n"), "--duration", "0.1", "--out", "run")
    assert (result.status, result.err) == (0, "")
    assert first_pose(tmp_path / "run") == pytest.approx([3.0, 1.0, np.pi / 2], abs=1e-6)


@pytest.mark.parametrize("position", ["", "position 2000 1000 0\n"])
def test_a_map_alone_is_entered_where_most_room_is(amorsim: Command, tmp_path: Path, position: str) -> None:
    """Where it does not say a place, and where its place is in a wall: that is not a mistake of who runs it."""
    result = amorsim("run", box(tmp_path, position), "--duration", "0.1", "--out", "run")
    assert result.status == 0
    x, y, _ = first_pose(tmp_path / "run")
    assert abs(abs(x - 2.0) - 1.0) < 0.1
    assert abs(y - 2.0) < 0.1
    assert ("the map's start (2.000, 1.000) m leaves the robot no room" in result.err) == bool(position)
    # The folder says where it started, so that it runs again.
    assert amorsim("reproduce", "run").status == 0


def test_a_pose_that_the_user_gave_is_not_replaced(amorsim: Command, tmp_path: Path) -> None:
    given = ["--set", "robots.rover.pose={x=2.0, y=3.0}"]
    result = amorsim("run", box(tmp_path, "position 2000 1000 0\n"), *given, "--out", "run")
    assert result.status == 2
    assert "at (2.000, 3.000) m the footprint overlaps a wall" in result.err
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("kind", ["1", "P", "RGB", "png"])
def test_a_bitmap_alone_runs(amorsim: Command, tmp_path: Path, kind: str) -> None:
    plan = Image.new("1", (120, 100), 1)
    ImageDraw.Draw(plan).rectangle((0, 0, 119, 99), outline=0, width=2)
    name = "plan.png" if kind == "png" else "plan.bmp"
    if kind == "P":
        coloured = Image.new("P", plan.size, 1)
        coloured.putpalette([20, 20, 80, 250, 250, 210])
        ImageDraw.Draw(coloured).rectangle((0, 0, 119, 99), outline=0, width=2)
        coloured.save(tmp_path / name)
    else:
        plan.convert("RGB" if kind == "RGB" else "1").save(tmp_path / name)
    result = amorsim("run", name, "--resolution", "0.05", "--duration", "0.1", "--out", "run")
    assert result.status == 0, result.err
    x, y, _ = first_pose(tmp_path / "run")
    assert (x, y) == pytest.approx((3.0, 2.5), abs=0.1)


def test_the_progress_bar_is_drawn_on_a_terminal(
    amorsim: Command, study: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[Any] = []

    @contextlib.contextmanager
    def bar(what: str) -> Iterator[Any]:
        shown.append(what)
        yield shown.append
        shown.append("gone")

    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    monkeypatch.setattr("amorsim.core.execution.progress._bar_here", lambda: bar)
    monkeypatch.setattr("amorsim.core.execution.progress._AFTER", 0.0)
    monkeypatch.setattr("amorsim.core.execution.progress._EVERY", 0.0)
    result = amorsim("run", study, "--duration", "0.5")
    assert result.status == 0
    assert "% simulated" not in result.out
    assert "rover: drove" in result.out
    assert (shown[0], shown[-1]) == ("simulating", "gone")
    assert shown[1:-1] == pytest.approx([0.2, 0.4, 0.6, 0.8, 1.0])
    shown.clear()
    amorsim("run", study, "--duration", "0.5", "-q", "--out", "quiet")
    assert shown == []


def test_compiling_is_announced(amorsim: Command, study: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compiled: list[bool] = []
    monkeypatch.setattr("amorsim.kernels.cache_folder.is_cold", lambda: True)
    monkeypatch.setattr("amorsim.runs.warm.compile_kernels", lambda *_, more=False: compiled.append(True))
    assert amorsim("run", study, "--duration", "0.1").out.startswith("compiling the kernels, once")
    assert compiled == [True]
    assert amorsim("run", study, "--duration", "0.1", "-q").out == ""


def test_many_robots_are_summed_up(amorsim: Command, tmp_path: Path) -> None:
    changes = ("--set", "robots.0.count=40", "--set", "robots.0.start.clearance=0.3", "--duration", "3")
    result = amorsim("run", "swarm", "--out", "run", *changes)
    about = json.loads((tmp_path / "run" / "run.json").read_text())
    errors = about["final_error"]
    worst = max(errors, key=errors.get)
    mean = sum(about["distance"].values()) / 40
    rms = (sum(error**2 for error in errors.values()) / 40) ** 0.5
    assert result.out.count(": drove ") == 6
    line = next(line for line in result.out.splitlines() if line.startswith("all 40 robots: "))
    assert f"drove {mean:.2f} m on the mean; " in line
    assert f"off by {rms:.3f} m (root mean square), {worst}'s the most, by {errors[worst]:.3f} m" in line


def test_a_robot_that_stands_still_for_want_of_a_controller_is_reported(amorsim: Command, study: Path) -> None:
    study.write_text("".join(line for line in study.read_text().splitlines(True) if "controller =" not in line))
    out = amorsim("run", study, "--duration", "1").out
    assert "rover: drove 0.00 m in 1 s (it has no controller), no collision; at the end the estimate" in out


@pytest.mark.long
def test_a_collision_that_ended_a_controller_is_reported_with_its_time(amorsim: Command, study: Path) -> None:
    result = amorsim("run", study, "--duration", "20", "--out", "run", "--set", "robots.rover.controller.speed=1.2")
    line = (study.parent.parent / "run" / "events.csv").read_text().splitlines()[1]
    time = float(line.split(",")[0])
    assert f"1 collision, which ended its controller at {time:.1f} s; " in result.out


def test_how_a_film_is_needs_a_film(amorsim: Command) -> None:
    result = amorsim("run", "demo", "--gif-speed", "4")
    assert (result.status, result.out) == (2, "")
    assert result.err.startswith(
        "--gif-size, --gif-rate and --gif-speed say how a moving picture is; --gif FILE or --mp4 FILE"
    )
