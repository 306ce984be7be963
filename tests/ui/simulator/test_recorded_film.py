"""Films of recorded runs are those that the runs made."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import amorsim as am
from amorsim.runs.film import Film
from amorsim.scenario.spec import Recording
from amorsim.simulation.simulation import Simulation
from amorsim.ui.simulator.sources.recorded_film import film_recorded
from tests import building
from tests.cli.conftest import Command, amorsim  # noqa: F401 - a fixture
from tests.simulation.rigs import rig, stone, yard


def frames(path: Path) -> list[np.ndarray]:
    with Image.open(path) as gif:
        found = []
        for number in range(gif.n_frames):
            gif.seek(number)
            found.append(np.asarray(gif.convert("RGB")).astype(int))
        return found


def changed(one: np.ndarray, other: np.ndarray) -> float:
    """The share of pixels that differ by more than the palettes of two films do."""
    return float((np.abs(one - other).max(axis=2) > 20).mean())


@pytest.fixture
def recorded(tmp_path: Path) -> Path:
    """A run of two replicas, two seconds long: rigs that drive, one of which has no trailer, and a stone; filmed."""
    robots = rig("b", 5.0, 5.0), rig("a", 5.0, 8.0), rig("c", 2.0, 2.0, drive=building.drive(), colour="#ff0000")
    scenario = yard(*robots, obstacles=(stone("s", 8.0, 2.0),), duration=2.0, recording=Recording(picture=False))
    simulation = Simulation(scenario, replicas=[0, 4])
    film = Film(simulation, tmp_path / "run.gif", 2.0, size=200)
    with am.record(simulation, tmp_path / "run") as session:
        for step in range(round(2.0 / simulation.dt)):
            for name in simulation.names:
                simulation.robot(name, 0).drive(forward=0.5, turn=0.4)
                simulation.robot(name, 4).drive(forward=0.5, turn=-0.2 if step % 2 else 0.0)
            simulation.step()
            session.keep()
            film.keep()
    film.save()
    return tmp_path / "run"


def test_the_film_of_a_recorded_run_is_that_of_the_run(
    recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def step(self: Simulation) -> None:
        raise AssertionError("something was simulated")

    monkeypatch.setattr(Simulation, "step", step)
    film_recorded(recorded, tmp_path / "0.gif", size=200)
    before, after = frames(tmp_path / "run.gif"), frames(tmp_path / "0.gif")
    assert len(before) == len(after) == 21
    for one, other in zip(before, after, strict=True):
        assert changed(one, other) < 1e-3  # files are written to a micrometre, which may move an edge by a pixel
    assert changed(before[0], before[-1]) > 1e-2


def test_another_replica_is_filmed(recorded: Path, tmp_path: Path) -> None:
    film_recorded(recorded, tmp_path / "4.gif", size=200, replica=4)
    first, other = frames(tmp_path / "run.gif"), frames(tmp_path / "4.gif")
    assert changed(first[0], other[0]) < 2e-3  # each film has a palette of its own
    assert changed(first[-1], other[-1]) > 1e-2
    with pytest.raises(am.RunError, match="no replica 7; known replicas: 0, 4"):
        film_recorded(recorded, tmp_path / "7.gif", replica=7)


def test_a_broken_run_is_filmed_up_to_its_end(recorded: Path, tmp_path: Path) -> None:
    lines = (recorded / "poses.csv").read_text().splitlines(keepends=True)
    per_second = (len(lines) - 1) // 2
    place = 1 + per_second // 2
    lines[place] = lines[place].replace("0,", "x,", 3)
    (recorded / "poses.csv").write_text("".join(lines[: 1 + per_second]) + "0,1.1")
    (recorded / "obstacles.csv").unlink()
    noted: list[str] = []
    film_recorded(recorded, tmp_path / "broken.gif", size=200, noted=noted.append)
    assert len(frames(tmp_path / "broken.gif")) == 11
    assert len(noted) == 1
    assert f"poses.csv, line {place + 1}" in noted[0]


def test_a_video_is_made_of_a_recorded_run(amorsim: Command, recorded: Path, tmp_path: Path) -> None:  # noqa: F811
    pytest.importorskip("imageio_ffmpeg")
    result = amorsim("replay", "run", "--mp4", "run.mp4", "--gif-size", 200, "--replica", 4)
    assert (result.status, result.out, result.err) == (0, "moving picture: run.mp4\n", "")
    assert b"ftyp" in (tmp_path / "run.mp4").read_bytes()[:16]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--gif", "a.mp4"), "--gif: expected the name of a file that ends in .gif"),
        (("--gif", "a.gif", "--gif-size", 3), "--gif-size: expected at least 120 pixels"),
        (("--gif-size", 300), "--gif FILE or --mp4 FILE makes one"),
        (("--replica", 4), "--replica: is for --gif and --mp4"),
        (("--gif", "a.gif"), "it: expected the folder of a run, with a run.json in it"),
    ],
)
def test_mistakes_are_told(amorsim: Command, arguments: tuple[str, ...], words: str) -> None:  # noqa: F811
    result = amorsim("replay", "it", *arguments)
    assert result.status == 2
    assert words in result.err
