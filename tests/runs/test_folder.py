"""Which files in the folder of a run are its results."""

from __future__ import annotations

from pathlib import Path

import attrs
import pytest

import amorsim as am
from amorsim.analysis import export_run
from amorsim.runs.folder import last_time, tables_of


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of a scenario with a track, in a file that ends before the run."""
    folder = tmp_path_factory.mktemp("tracks")
    track = folder / "track.csv"
    track.write_text("time,x,y,heading_deg\n0.0,1.4,7.5,0.0\n\n0.5,1.4,7.4,0.0\n")
    cart = am.Obstacle(
        name="cart", shape=am.Shape.circle(0.1), pose=am.Pose(x=1.4, y=7.5), motion=am.motions.Track(file=str(track))
    )
    am.run(attrs.evolve(am.load("demo"), obstacles=[cart]), folder / "run", duration=1.0)
    assert (folder / "run" / "track.csv").is_file()
    return folder / "run"


def test_a_track_is_no_table_of_a_run(run: Path) -> None:
    names = {path.relative_to(run).as_posix() for path in tables_of(run)}
    assert {"poses.csv", "events.csv", "obstacles.csv", "sensors/laser.csv", "estimates/dead_reckoning.csv"} <= names
    assert "track.csv" not in names
    assert last_time(run) == 1.0


def test_a_run_with_a_track_is_exported(run: Path, tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    made = export_run(run, "parquet", tmp_path)
    assert tmp_path / "poses.parquet" in made
    assert tmp_path / "track.parquet" not in made
