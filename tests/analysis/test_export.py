"""What is exported is read back by the formats' own readers."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from amorsim.analysis import ape, read_csv, read_kitti, read_tum, run_trajectories
from amorsim.analysis.export import export_run


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("exports") / "run"
    am.run(am.load("demo"), folder, duration=1.0, replicas=2)
    return folder


def test_trajectories_are_read_back(run: Path, tmp_path: Path) -> None:
    true, estimated = run_trajectories(run, replica=1)
    for kind, read in (("tum", read_tum), ("csv", read_csv)):
        made = export_run(run, kind, tmp_path / kind)
        names = {path.name for path in made}
        assert f"rover-1-true.{kind}" in names
        assert f"rover-0-dead_reckoning.{kind}" in names
        assert ape(true, read(tmp_path / kind / f"rover-1-true.{kind}")).statistics.max < 1e-12
        assert ape(estimated, read(tmp_path / kind / f"rover-1-dead_reckoning.{kind}")).statistics.max < 1e-12
    export_run(run, "kitti", tmp_path / "kitti")
    assert np.abs(read_kitti(tmp_path / "kitti" / "rover-1-true.kitti").poses - true.poses).max() < 1e-12


def test_a_robot_without_an_estimator_has_its_true_trajectory(tmp_path: Path) -> None:
    am.run(am.load("demo", ["robots.rover.estimators.dead_reckoning=false"]), tmp_path / "run", duration=1.0)
    (path,) = export_run(tmp_path / "run", "csv", tmp_path)
    assert path.name == "rover-true.csv"
    assert read_csv(path).poses.tolist() == run_trajectories(tmp_path / "run")[0].poses.tolist()


def test_an_estimate_does_not_take_the_name_of_the_truth(tmp_path: Path) -> None:
    change = ["robots.rover.estimators.true={ use = 'dead_reckoning' }"]
    am.run(am.load("demo", change), tmp_path / "run", duration=1.0)
    with pytest.raises(am.AnalysisError, match=r"rover-true\.csv: two trajectories would have this name"):
        export_run(tmp_path / "run", "csv", tmp_path)


def test_tables_are_read_back(run: Path, tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    made = export_run(run, "parquet", tmp_path)
    frame = pandas.read_parquet(tmp_path / "poses.parquet")
    table = am.analysis.RunFiles(run).table("poses", replica="all")
    assert list(frame) == list(table)
    assert frame["true_x"].tolist() == table["true_x"].tolist()
    assert tmp_path / "sensors" / "laser.parquet" in made


def test_tables_of_runs_with_and_without_events_have_the_same_columns(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    schemas = []
    for name, kidnappings in (("quiet", "[]"), ("kidnapped", "[{ time = 0.5, x = 1.4, y = 8.0 }]")):
        scenario = am.load("demo", [f"robots.rover.kidnappings={kidnappings}"])
        am.run(scenario, tmp_path / name, duration=1.0)
        export_run(tmp_path / name, "parquet", tmp_path / f"{name}-tables")
        schemas.append(parquet.read_schema(tmp_path / f"{name}-tables" / "events.parquet"))
    assert schemas[0].equals(schemas[1])


def test_tables_are_read_back_by_polars(run: Path, tmp_path: Path) -> None:
    polars = pytest.importorskip("polars")
    pytest.importorskip("pyarrow")
    export_run(run, "parquet", tmp_path)
    frame = polars.read_parquet(tmp_path / "poses.parquet")
    table = am.analysis.RunFiles(run).table("poses", replica="all")
    assert {name: frame[name].to_list() for name in frame.columns} == {name: table[name].tolist() for name in table}


def test_an_mcap_file_is_read_back(run: Path, tmp_path: Path) -> None:
    reader = pytest.importorskip("mcap.reader")
    (path,) = export_run(run, "mcap", tmp_path)
    poses, scans = [], []
    with path.open("rb") as stream:
        for schema, channel, message in reader.make_reader(stream).iter_messages():
            content = json.loads(message.data)
            if channel.topic == "/rover/true_pose":
                assert schema.name == "foxglove.PoseInFrame"
                stamp = content["timestamp"]
                poses.append((stamp["sec"] + 1e-9 * stamp["nsec"], content["pose"]["position"]["x"]))
            if channel.topic == "/rover/laser":
                scans.append(content["ranges"])
    true, _ = run_trajectories(run, replica=0)
    assert np.array(poses) == pytest.approx(np.column_stack((true.time, true.poses[:, 0])))
    read = am.analysis.RunFiles(run).table("sensors/laser", replica=0)
    assert len(scans) == len(read["time"])
    assert scans[0][3] == pytest.approx(read["measured_3"][0])


def test_each_field_of_an_mcap_file_has_one_type_as_foxglove_needs(run: Path, tmp_path: Path) -> None:
    reader = pytest.importorskip("mcap.reader")
    (path,) = export_run(run, "mcap", tmp_path)
    with path.open("rb") as stream:
        schemas = {
            each.name: json.loads(each.data) for each in reader.make_reader(stream).get_summary().schemas.values()
        }
    fields = [field for schema in schemas.values() for field in schema["properties"].values()]
    items = [field["items"] for field in fields if field["type"] == "array"]
    assert len(items) >= 2
    assert {each["type"] for each in fields + items} <= {"object", "array", "string", "number", "integer"}
    assert "Infinity" in schemas["amorsim.Values"]["properties"]["values"]["description"]


def test_what_is_missing_is_reported(run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(
        am.AnalysisError, match=r"no format 'bag'; expected one of tum, kitti, csv, parquet, mcap, rosbag$"
    ):
        export_run(run, "bag")
    for kind, module in (("parquet", "pyarrow"), ("mcap", "mcap.writer")):
        monkeypatch.setitem(sys.modules, module, None)
        with pytest.raises(am.AnalysisError, match=r"pip install \"amorsim\[(sweep|mcap)\]\""):
            export_run(run, kind, tmp_path)
