"""The pictures of a run: which there are, and that what they show is what the files say."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import amorsim as am
from amorsim.analysis.files import RunFiles
from amorsim.analysis.plot import plot_run
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
    return {path.stem: path for path in plot_run(folder)}


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


def test_the_figures_say_what_the_files_say(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Lines, labels with units, and differences, before they become pixels."""
    from matplotlib.figure import Figure

    drawn: dict[str, Figure] = {}
    monkeypatch.setattr(
        "amorsim.analysis.plot.save_figure", lambda figure, path, **_: drawn.update({Path(path).stem: figure})
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


def test_a_run_of_one_moment_and_one_that_saw_nothing_can_be_drawn(tmp_path: Path) -> None:
    study = make_study(tmp_path / "study")
    am.run(am.load(study), tmp_path / "short", duration=0.1)
    assert {path.stem for path in plot_run(tmp_path / "short")} == KINDS
    scenario = am.load(study, ["robots.rover.sensors.laser.range_max=0.1", "robots.rover.sensors.sonar.range_max=0.16"])
    am.run(scenario, tmp_path / "blind", duration=0.3)
    assert np.isinf(RunFiles(tmp_path / "blind").table("sensors/laser")["true_0"]).all()
    assert {path.stem for path in plot_run(tmp_path / "blind")} == KINDS


def test_pictures_of_one_robot_and_replica_go_where_they_are_wanted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("amorsim.analysis.plot.save_figure", lambda figure, path, **_: path.touch())
    study = make_study(tmp_path / "study")
    am.run(am.load(study), tmp_path / "run", duration=0.3, replicas=2)
    made = plot_run(tmp_path / "run", out=tmp_path / "mine", robot="rover", replica=1)
    assert {path.parent for path in made} == {tmp_path / "mine"}
    assert sorted(made) == sorted((tmp_path / "mine").iterdir())
    assert not (tmp_path / "run" / "plots").exists()
    with pytest.raises(am.RunError, match="no robot 'rovr'"):
        plot_run(tmp_path / "run", robot="rovr")
    with pytest.raises(am.RunError, match="no replica 2"):
        plot_run(tmp_path / "run", replica=2)
    with pytest.raises(am.RunError, match=r"run.json: cannot be written"):
        plot_run(tmp_path / "run", out=tmp_path / "run" / "run.json")
