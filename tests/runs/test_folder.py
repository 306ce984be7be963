"""Which files in the folder of a run are its results."""

from __future__ import annotations

from pathlib import Path

import attrs
import pytest

import amorsim as am
from amorsim.analysis import export_run
from amorsim.runs.folder import last_time, tables_of
from amorsim.runs.manifest import read_about


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
    names = {path.relative_to(run).as_posix() for path in tables_of(run, read_about(run)["inputs"])}
    assert {"poses.csv", "events.csv", "obstacles.csv", "sensors/laser.csv", "estimates/dead_reckoning.csv"} <= names
    assert "track.csv" not in names
    assert last_time(run) == 1.0


def test_a_run_with_a_track_is_exported(run: Path, tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    made = export_run(run, "parquet", tmp_path)
    assert tmp_path / "poses.parquet" in made
    assert tmp_path / "track.parquet" not in made


def test_tables_that_recorders_of_plugins_write_are_exported(tmp_path: Path) -> None:
    """One has neither times nor replicas."""
    pytest.importorskip("pyarrow")
    from pyarrow import parquet

    run = tmp_path / "run"
    am.run(am.load("demo"), run, duration=0.3, replicas=2)
    for name in ("weather.csv", "more/weather/there.csv", "export/left.csv", "plots/out.csv"):
        (run / name).parent.mkdir(parents=True, exist_ok=True)
        (run / name).write_text("sky,degrees\nclear,21.5\n")
    made = export_run(run, "parquet", tmp_path / "out")
    names = {path.relative_to(tmp_path / "out").as_posix() for path in made}
    assert {"weather.parquet", "more/weather/there.parquet"} <= names
    assert not {"left.parquet", "out.parquet"} & {path.name for path in made}
    assert parquet.read_table(tmp_path / "out" / "weather.parquet").to_pylist() == [{"sky": "clear", "degrees": 21.5}]
    assert last_time(run) == 0.3
