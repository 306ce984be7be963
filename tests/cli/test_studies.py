"""The commands that make experiments, as a user types them."""

from __future__ import annotations

import builtins
import csv
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

import amorsim as am
from tests.first_hour.conftest import amorsim

ERRORS = (
    "--set robots.rover.errors.drive.wheel_radius_left.scale=1.003 --set robots.rover.errors.drive.track.scale=1.02"
)


@pytest.fixture(autouse=True)
def _somewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def _rows(path: str) -> list[dict[str, str]]:
    with Path(path).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def _figure(output: str, line: str, column: int) -> float:
    """A number of the line of a table that begins so."""
    (found,) = re.findall(rf"^{re.escape(line)} +(.*)$", output, re.MULTILINE)
    return float(found.split()[column])


@pytest.mark.long
def test_umbmark_corrects_a_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    status, output = amorsim(f"amorsim umbmark demo --out u --runs 2 {ERRORS}", monkeypatch)
    assert status == 0, output
    # The left wheel is larger: the right one's diameter over the left one's is 1 / 1.003.
    assert _figure(output, "exact least squares", 0) == pytest.approx(1.0 / 1.003, abs=2e-5)
    # The size of a square does not show, so that the mean diameter's 0.15 % are found in the track.
    assert _figure(output, "exact least squares", 1) == pytest.approx(1.02 / 1.0015, abs=1e-4)
    before, after = _figure(output, "nominal", 3), _figure(output, "corrected, exact", 3)
    assert after < 0.01 * before
    assert "all runs are alike" in output
    ends = _rows("u/ends.csv")
    assert len(ends) == 8
    assert {row["direction"] for row in ends} == {"clockwise", "anticlockwise"}
    with Image.open("u/umbmark.png") as picture:
        assert min(picture.size) > 400


@pytest.mark.long
def test_the_files_of_umbmark_can_be_used_as_it_says(monkeypatch: pytest.MonkeyPatch) -> None:
    assert amorsim(f"amorsim umbmark demo --out u --runs 2 {ERRORS}", monkeypatch)[0] == 0
    # The scenario with the same robot: little is left to be corrected.
    status, output = amorsim("amorsim umbmark u/corrected-scenario.toml --out again --runs 2", monkeypatch)
    assert status == 0, output
    assert _figure(output, "nominal", 3) < 2.0
    assert _figure(output, "exact least squares", 0) == pytest.approx(1.0, abs=2e-5)
    assert amorsim("amorsim run u/corrected-scenario.toml --duration 1 --out ran -q", monkeypatch) == (0, "")
    # The model, in a scenario of the user's own, where nothing is said of errors.
    model = tomllib.loads(Path("u/corrected.toml").read_text(encoding="utf-8"))
    Path("own.toml").write_text(
        'format = 1\n[world]\nmap = "u/office.wld"\n[[robots]]\nname = "mine"\nmodel = "u/corrected.toml"\n'
        "pose = { x = 1.4, y = 8.2 }\n",
        encoding="utf-8",
    )
    mine = am.load("own.toml").robots[0]
    demo = am.load("demo").robots[0]
    drive: Any = mine.drive
    assert drive.track == model["drive"]["track"] != demo.drive.track  # type: ignore[attr-defined]
    assert mine.errors == {}
    assert list(mine.sensors) == list(demo.sensors)
    assert mine.sensors["sonar"] == demo.sensors["sonar"]
    assert mine.shape == demo.shape


def test_umbmark_refuses_what_it_is_not_for(monkeypatch: pytest.MonkeyPatch) -> None:
    for options, words in (
        ("--speed 0.5", "speed: expected a number > 0 and <= 0.2 m/s"),
        ("--runs 1", "runs: expected 2 at least"),
        ("--robot nobody", "no robot 'nobody'"),
        ("--seed -1", "--seed: expected a whole number"),
        ("--in-its-world", "robot 'rover' met 'wall'"),
    ):
        status, output = amorsim(f"amorsim umbmark demo --out u {options}", monkeypatch)
        assert (status, words in output) == (2, True), output
        assert not Path("u").exists()
    Path("full").mkdir()
    Path("full/file").touch()
    status, output = amorsim("amorsim umbmark demo --out full", monkeypatch)
    words = "full: the folder holds files already, such as file; name another one, or one that is not there\n"
    assert (status, output) == (2, words)
    status, output = amorsim("amorsim umbmark demo --out full/file", monkeypatch)
    assert (status, output) == (2, "full/file: is a file; name a folder, new or empty\n")


def test_without_matplotlib_the_picture_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *args: Any, **kwargs: Any) -> Any:
        if name == "amorsim.analysis.plots" and "study_plots" in (args[2] or ()):
            raise ModuleNotFoundError("No module named 'matplotlib.figure'", name="matplotlib.figure")
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without)
    status, output = amorsim(f"amorsim umbmark demo --out u --runs 2 --side 1 {ERRORS}", monkeypatch)
    assert status == 0
    assert 'umbmark.png is left out: plots need matplotlib: python -m pip install "amorsim[plot]"' in output
    assert "picture:" not in output
    assert sorted(path.name for path in Path("u").iterdir()) == [
        "corrected-scenario.toml",
        "corrected.toml",
        "ends.csv",
        "office.wld",
    ]


@pytest.mark.long
def test_a_seed_gives_the_same_files_again(monkeypatch: pytest.MonkeyPatch) -> None:
    noise = """--set 'robots.rover.ground=[{use="diffusion", variance_per_length=1e-7}]'"""
    for out, seed in (("a", 5), ("b", 5), ("c", 6)):
        assert amorsim(f"amorsim umbmark demo --out {out} --runs 2 --side 1 --seed {seed} {noise}", monkeypatch)[0] == 0
    texts = [Path(out, "ends.csv").read_text(encoding="utf-8") for out in "abc"]
    assert texts[0] == texts[1] != texts[2]


def test_calibrate_finds_what_was_put_in(monkeypatch: pytest.MonkeyPatch) -> None:
    gyro = """--set 'robots.rover.sensors.gyro.noise=[{use="scale", factor=1.02}, {use="bias", value_deg=0.3}]'"""
    status, output = amorsim(f"amorsim calibrate demo --what gyro --out g --runs 2 {gyro}", monkeypatch)
    assert status == 0, output
    assert {row["quantity"]: float(row["value"]) for row in _rows("g/calibration.csv")} == pytest.approx(
        {"bias": 0.3, "scale": 1.02}, abs=1e-6
    )
    compass = """--set 'robots.rover.sensors.compass.noise=[{use="bias", value_deg=1.5}]'"""
    status, output = amorsim(f"amorsim calibrate demo --what compass --out c --runs 2 {compass}", monkeypatch)
    assert status == 0, output
    found = {row["quantity"]: float(row["value"]) for row in _rows("c/calibration.csv")}
    assert found == pytest.approx({"a": 1.5, "b": 0.0, "c": 0.0, "d": 0.0, "e": 0.0}, abs=1e-6)
    laser = """--set 'robots.rover.sensors.laser.noise=[{use="bias", value=0.25}]'"""
    status, output = amorsim(f"amorsim calibrate demo --what range --out l --runs 2 {laser}", monkeypatch)
    assert status == 0, output
    rows = _rows("l/calibration.csv")
    assert [float(row["value"]) for row in rows] == pytest.approx([0.25, 0.0] * 3, abs=1e-9)
    assert output.splitlines()[0] == "laser, element 90, squarely before a wall; 2 runs"
    assert float(rows[0]["low"]) <= float(rows[0]["value"]) <= float(rows[0]["high"])


def test_calibrate_refuses_what_is_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    for options, words in (
        ("--what gyro --element 3", "--element is for --what range"),
        ("--what gyro --sensor laser", "expected a gyro, and 'laser' is none; it has: gyro"),
        ("--what range --element 500", "expected an element from 0 to 180, got 500"),
    ):
        status, output = amorsim(f"amorsim calibrate demo --out x {options}", monkeypatch)
        assert (status, words in output) == (2, True), output
    assert not Path("x").exists()


def test_explain_errors_shows_the_share_of_each(monkeypatch: pytest.MonkeyPatch) -> None:
    status, output = amorsim(
        f"amorsim explain-errors demo --out e --replicas 2 {ERRORS} --set simulation.duration=15", monkeypatch
    )
    assert status == 0, output
    assert "errors.drive.wheel_radius_left" in output
    assert re.search(r"^all together +\S+ +100\.0 %$", output, re.MULTILINE)
    shares = [float(text) for text in re.findall(r"(-?[\d.]+) %$", output, re.MULTILINE)]
    assert sum(shares[:-1]) == pytest.approx(100.0, abs=0.05 * len(shares))  # rounded to a tenth each
    rows = _rows("e/final-errors.csv")
    assert {row["error"] for row in rows} >= {"all together", "errors.drive.track", "sensors.encoder.noise.quantize"}
    assert len(rows) == 2 * len({row["error"] for row in rows})
    with Image.open("e/errors.png") as picture:
        assert min(picture.size) > 400


def test_explain_errors_shows_what_a_sensors_errors_do(monkeypatch: pytest.MonkeyPatch) -> None:
    status, output = amorsim(
        "amorsim explain-errors demo --sensor compass --out s --replicas 2 --set simulation.duration=3", monkeypatch
    )
    assert status == 0, output
    assert re.search(r"^sensors\.compass\.noise\.gaussian +\S+ +", output, re.MULTILINE)
    assert "alone [deg]" in output
    assert re.search(r"^all together +\S+ +100\.0 % +0\.0 %$", output, re.MULTILINE)
    rows = _rows("s/reading-errors.csv")
    assert len(rows) == 30
    assert float(rows[-1]["time"]) == pytest.approx(3.0)
    with Image.open("s/errors.png") as picture:
        assert min(picture.size) > 400
    status, output = amorsim("amorsim explain-errors demo --sensor campass", monkeypatch)
    assert status == 2
    assert "Did you mean 'compass'?" in output


def test_without_a_name_there_is_a_folder_for_each(monkeypatch: pytest.MonkeyPatch) -> None:
    for _ in range(2):
        assert amorsim("amorsim calibrate demo --what compass --runs 2", monkeypatch)[0] == 0
    found = sorted(str(path) for path in Path("amorsim-runs").iterdir())
    assert found == ["amorsim-runs/demo-compass-001", "amorsim-runs/demo-compass-002"]
