"""The pictures of a run: which there are, and that what they show is what the files say."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import amorsim as am
from amorsim.analysis.plots.figures import save_figure
from amorsim.analysis.plots.plot import plot_run
from amorsim.analysis.run_files import RunFiles
from amorsim.core.files.atomic_files import write_text
from tests.studies import make_study

pytest.importorskip("matplotlib")

COLOURS = {"true": "#1b7f5c", "measured": "#d97706", "estimated": "#2f6fde"}
KINDS = {"path", "speed", "wheels", "heading", "error"} | {
    f"sensor-{name}" for name in ("compass", "encoder", "gyro", "laser", "sonar")
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    base = tmp_path_factory.mktemp("plots")
    return am.run(am.load(make_study(base / "study")), base / "run", duration=20.0).folder


@pytest.fixture(scope="module")
def pictures(folder: Path) -> dict[str, Path]:
    return {kind_of(path): path for path in plot_run(folder)}


def kind_of(path: Path) -> str:
    """The kind of a picture of the rover, from the file's name."""
    run, found, kind = path.stem.partition("-rover-seed1-")
    assert found
    assert run in ("run", "short", "blind")
    return kind


def count(picture: Path, colour: str) -> int:
    """How many pixels have a colour, to three steps of 255."""
    wanted = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)])
    with Image.open(picture) as opened:
        pixels = np.asarray(opened.convert("RGB")).astype(np.int16)
    return int((np.abs(pixels - wanted.astype(np.int16)) <= 3).all(axis=2).sum())


def test_there_is_a_picture_of_each_kind(folder: Path, pictures: dict[str, Path]) -> None:
    assert set(pictures) == KINDS
    assert {path.parent for path in pictures.values()} == {folder / "plots"}


@pytest.mark.parametrize(
    ("kind", "shown"),
    [
        ("path", {"true", "estimated"}),
        ("speed", {"true", "estimated"}),
        ("wheels", {"true", "measured"}),
        ("heading", {"true", "estimated"}),
        ("error", {"estimated"}),
        ("sensor-compass", {"true", "measured"}),
        ("sensor-sonar", {"true", "measured"}),
        ("sensor-laser", set()),  # an image
    ],
)
def test_each_channel_has_its_colour(pictures: dict[str, Path], kind: str, shown: set[str]) -> None:
    seen = {channel for channel, colour in COLOURS.items() if count(pictures[kind], colour) > 20}
    assert seen == shown


@pytest.mark.long
def test_the_figures_say_what_the_files_say(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Lines, labels with units, and differences, before they become pixels."""
    from matplotlib.figure import Figure

    drawn: dict[str, Figure] = {}
    monkeypatch.setattr(
        "amorsim.analysis.plots.plot.save_figure", lambda figure, path, **_: drawn.update({kind_of(path): figure})
    )
    plot_run(folder)
    files = RunFiles(folder)
    velocities, compass = files.table("velocities"), files.table("sensors/compass")
    left, below, right, _ = drawn["wheels"].axes
    assert [left.get_ylabel(), right.get_ylabel()] == ["left wheel [rad/s]", "right wheel [rad/s]"]
    lines = {line.get_label(): line for line in left.get_lines()}
    for channel, dash in (("true", "-"), ("measured", ":")):
        np.testing.assert_array_equal(lines[channel].get_ydata(), velocities[f"{channel}_left_wheel"])
        assert (lines[channel].get_color(), lines[channel].get_linestyle()) == (COLOURS[channel], dash)
    difference = velocities["measured_left_wheel"] - velocities["true_left_wheel"]
    np.testing.assert_allclose(below.get_lines()[0].get_ydata(), difference)
    main = drawn["sensor-compass"].axes[0]
    assert main.get_ylabel() == "compass [°]"
    shown = main.get_lines()[0].get_ydata()
    drawn_at = np.isfinite(shown)  # broken where it goes round from 180 to -180 degrees
    assert drawn_at.sum() > 190
    np.testing.assert_allclose(shown[drawn_at], np.degrees(compass["true_0"])[drawn_at], rtol=1e-12)
    assert drawn["path"].axes[0].get_xlabel() == "x [m]"
    assert len(drawn["sensor-sonar"].axes) == 16
    image = drawn["sensor-laser"].axes[0].get_images()[0].get_array()
    assert image.shape == (181, 201)
    np.testing.assert_allclose(image[90], files.table("sensors/laser")["true_90"])


@pytest.mark.long
def test_a_run_of_one_moment_and_one_that_saw_nothing_can_be_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def save_small(figure: Any, path: Path, *, dpi: int, within: Path) -> None:
        save_figure(figure, path, dpi=20, within=within)

    monkeypatch.setattr("amorsim.analysis.plots.plot.save_figure", save_small)
    study = make_study(tmp_path / "study")
    am.run(am.load(study), tmp_path / "short", duration=0.1)
    assert {kind_of(path) for path in plot_run(tmp_path / "short")} == KINDS
    scenario = am.load(study, ["robots.rover.sensors.laser.range_max=0.1", "robots.rover.sensors.sonar.range_max=0.16"])
    am.run(scenario, tmp_path / "blind", duration=0.3)
    assert np.isinf(RunFiles(tmp_path / "blind").table("sensors/laser")["true_0"]).all()
    assert {kind_of(path) for path in plot_run(tmp_path / "blind")} == KINDS


def test_pictures_of_one_robot_and_replica_go_where_they_are_wanted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def write_nothing(figure: object, path: Path, *, dpi: int, within: Path) -> None:
        write_text(path, "", within=within)

    monkeypatch.setattr("amorsim.analysis.plots.plot.save_figure", write_nothing)
    study = make_study(tmp_path / "study")
    am.run(am.load(study), tmp_path / "run", duration=0.3, replicas=2)
    made = plot_run(tmp_path / "run", out=tmp_path / "mine", robot="rover", replica=1)
    assert {path.parent for path in made} == {tmp_path / "mine"}
    assert sorted(made) == sorted((tmp_path / "mine").iterdir())
    assert {path.name for path in made} == {f"run-rover-seed1-replica1-{kind}.png" for kind in KINDS}
    assert not (tmp_path / "run" / "plots").exists()
    for replica in (0, None):
        with pytest.raises(am.RunError, match="no robot 'rovr'"):
            plot_run(tmp_path / "run", robot="rovr", replica=replica)
    with pytest.raises(am.RunError, match="no replica 2"):
        plot_run(tmp_path / "run", replica=2)
    with pytest.raises(am.RunError, match=r"run.json.*: cannot be written"):
        plot_run(tmp_path / "run", out=tmp_path / "run" / "run.json")


TWO = """
format = 1
[world]
map = "rooms.wld"
[simulation]
duration = 3.0
seed = 8
[recording]
picture = false
[[robots]]
name = "alpha"
model = "pioneer2dx"
pose = { x = 1.0, y = 1.0 }
controller = { use = "square", side = 0.5 }
sensors = { laser = false, sonar = false, gyro = false, compass = false }
[robots.estimators]
first = { use = "dead_reckoning", wheel_variance = 1e-4 }
second = { use = "dead_reckoning", wheel_variance = 4e-4 }
[robots.errors.drive]
track = { scale = { uniform = [0.9, 1.1] } }
[[robots]]
name = "rover"
model = "pioneer2dx"
pose = { x = 3.0, y = 1.0 }
"""


@pytest.fixture(scope="module")
def spread(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of two robots, one with two estimators, in three replicas."""
    base = tmp_path_factory.mktemp("spread")
    make_study(base / "study")
    (base / "study" / "two.toml").write_text(TWO)
    return am.run(am.load(base / "study" / "two.toml"), base / "spread", replicas=[6, 2, 9]).folder


@pytest.fixture
def figures(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """The figures that are drawn, by the names of their files."""
    drawn: dict[str, Any] = {}
    monkeypatch.setattr(
        "amorsim.analysis.plots.plot.save_figure", lambda figure, path, **_: drawn.update({path.name: figure})
    )
    return drawn


def labelled(axis: Any) -> dict[str, Any]:
    """The lines of a panel by their labels."""
    return {line.get_label(): line for line in axis.get_lines()}


@pytest.mark.long
def test_pictures_carry_run_robot_seed_and_replica(spread: Path, figures: dict[str, Any]) -> None:
    for robot in ("alpha", "rover"):
        for replica in (2, None):
            plot_run(spread, robot=robot, replica=replica)
    assert len(figures) == (6 + 4) + (10 + 4)  # nobody writes over another's
    assert {"spread-alpha-seed8-replica2-path.png", "spread-rover-seed8-3replicas-ends.png"} <= set(figures)
    for name, figure in figures.items():
        robot = "alpha" if "alpha" in name else "rover"
        of = "replica 2 of 3" if "replica2" in name else "3 replicas"
        assert figure.get_suptitle().endswith(f"\nspread · {robot} · seed 8 · {of}")


def test_second_estimators_and_what_they_believe_are_drawn(spread: Path, figures: dict[str, Any]) -> None:
    plot_run(spread, robot="alpha", replica=9)
    files = RunFiles(spread)
    poses = files.table("poses", robot="alpha", replica=9)
    names = ["estimated: first", "estimated: second"]
    for kind in ("path", "heading", "error"):
        figure = figures[f"spread-alpha-seed8-replica9-{kind}.png"]
        shown = [text.get_text() for text in figure.legends[0].get_texts()]
        sigmas = [f"{'1σ' if kind == 'path' else '±σ'} of {name}" for name in ("first", "second")]
        assert set(names + sigmas) <= set(shown)
        assert set(names) <= set(labelled(figure.axes[0]))
    _, x, _, heading = figures["spread-alpha-seed8-replica9-error.png"].axes
    np.testing.assert_allclose(x.get_lines()[0].get_ydata(), poses["estimated_x"] - poses["true_x"], atol=1e-12)
    for axis, key, scale in ((x, "xx", 1.0), (heading, "hh", np.degrees(1.0))):
        for area, name in zip(axis.collections, ("first", "second"), strict=True):
            believed = scale * np.sqrt(files.table(f"estimates/{name}", robot="alpha", replica=9)[key])
            low, high = area.get_paths()[0].get_extents().intervaly
            np.testing.assert_allclose((low, high), (-believed.max(), believed.max()))


def test_all_replicas_are_summed_up(spread: Path, figures: dict[str, Any]) -> None:
    plot_run(spread, robot="alpha")
    poses = RunFiles(spread).arrays("poses", robot="alpha")
    error = poses["estimated_pose"] - poses["true_pose"]
    away = np.hypot(error[..., 0], error[..., 1])
    figure = figures["spread-alpha-seed8-3replicas-error.png"]
    position, x, *_ = figure.axes
    rms = np.sqrt((away**2).mean(axis=1))
    np.testing.assert_allclose(labelled(position)["root mean square, first"].get_ydata(), rms)
    np.testing.assert_allclose(labelled(x)["mean"].get_ydata(), error[..., 0].mean(axis=1))
    worst = [6, 2, 9][away[-1].argmax()]
    assert f"off by {rms[-1]:.3f} m (root mean square)" in figure.get_suptitle()
    assert f"{away[-1].max():.3f} m (worst, replica {worst})" in figure.get_suptitle()
    paths = figures["spread-alpha-seed8-3replicas-path.png"].axes[0].collections[0].get_segments()
    assert len(paths) == 3
    np.testing.assert_allclose(paths[1], poses["true_pose"][:, 1, :2])
    ends = figures["spread-alpha-seed8-3replicas-ends.png"].axes[0]
    np.testing.assert_allclose(labelled(ends)["estimated: first"].get_xydata(), error[-1, :, :2])


def test_a_run_that_did_not_end_says_so(
    folder: Path, tmp_path: Path, figures: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    from amorsim.cli.runs.plot import command

    killed = Path(shutil.copytree(folder, tmp_path / "run"))
    about = json.loads((killed / "run.json").read_text())
    (killed / "run.json").write_text(json.dumps(about | {"status": "running"}))
    lines = (killed / "poses.csv").read_text().splitlines(keepends=True)
    (killed / "poses.csv").write_text("".join(lines[:57]) + lines[57][:9])
    command(killed)
    assert "run: this run did not end in order; its files end at 5.5 s" in capsys.readouterr().err
    path = figures["run-rover-seed1-path.png"]
    assert "this run did not end in order" in path.get_suptitle()
    assert len(labelled(path.axes[0])["true"].get_xdata()) == 56


@pytest.mark.parametrize(
    ("file", "old", "new", "problem"),
    [
        ("velocities.csv", "measured_left_wheel", "measured_wheel", r"velocities.csv, line 1: .*'measured_left_wheel'"),
        ("poses.csv", "\n0.100000,rover,1", "\n0.100000,rover,1e999", r"poses.csv, line 3, true_x: expected a "),
        ("events.csv", "kind", "kinds", r"events.csv, line 1: is damaged: no column 'kind'"),
        ("estimates/dead_reckoning.csv", "\n0.100000", "\n0.150000", r"dead_reckoning.csv: its times are not those"),
        ("sensors/sonar.csv", "true_3,", "true_33,", r"sonar.csv, line 1: .* 'measured_33'"),
    ],
)
def test_a_damaged_file_is_named(
    folder: Path, tmp_path: Path, figures: dict[str, Any], file: str, old: str, new: str, problem: str
) -> None:
    damaged = Path(shutil.copytree(folder, tmp_path / "run"))
    text = (damaged / file).read_text()
    assert old in text
    (damaged / file).write_text(text.replace(old, new, 1))
    with pytest.raises(am.RunError, match=problem):
        plot_run(damaged)
