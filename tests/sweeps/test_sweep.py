"""A study's table holds what the simulations give; it goes on where it stopped, and says what went wrong."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import amorsim as am
from amorsim.core.error_text import explain
from amorsim.sweeps import chunk as chunks
from amorsim.sweeps import executors
from tests.sweeps.studies import METRICS, TRACK, study_file, tables


def same(one: am.Study, other: am.Study) -> bool:
    return list(one) == list(other) and all(
        one[name].tolist() == other[name].tolist()
        or (one[name].dtype == float and one[name].tobytes() == other[name].tobytes())
        for name in one
    )


def test_a_row_is_what_its_simulation_gives(tmp_path: Path) -> None:
    study = am.sweep(tables(tmp_path / "s", seeds=[1, 2]), tmp_path / "out")
    assert list(study) == ["point", TRACK, "seed", "replica", "final_error", "length", "digest", "error"]
    assert len(study["point"]) == 2 * 2 * 3
    assert study.is_complete
    simulation = am.Simulation(am.load(tmp_path / "s" / "small.toml", [f"{TRACK}=1.05"]), seed=2, replicas=[1])
    kept = simulation.run(keep=("true_pose", "estimated_pose"))
    (row,) = np.flatnonzero((study[TRACK] == 1.05) & (study["seed"] == 2) & (study["replica"] == 1))
    assert study["digest"][row] == simulation.digest()
    apart = kept["true_pose"][-1, 0] - kept["estimated_pose"][-1, 0]
    assert study["final_error"][row] == math.sqrt(apart[0] ** 2 + apart[1] ** 2)


def test_clearance_is_measured_in_each_replicas_own_world(tmp_path: Path) -> None:
    file = tmp_path / "forest.toml"
    file.write_text(
        """
format = 1

[world]
map = { generate = "forest", seed = 7, per = "replica", size = [12.0, 9.0] }

[[robots]]
name = "rover"
model = "pioneer2dx"
"""
    )
    given = {"format": 1, "scenario": str(file), "replicas": 3, "duration": 0.2, "metrics": {"c": {"use": "clearance"}}}
    study = am.sweep(given, tmp_path / "out", keep="all")
    (run,) = (tmp_path / "out" / "runs").iterdir()
    assert study["c"] == pytest.approx(am.analysis.measure(run, am.metrics.Clearance()), abs=1e-5)
    assert len(set(study["c"].tolist())) == 3


def test_a_trailer_that_meets_a_wall_has_no_clearance(tmp_path: Path) -> None:
    metrics = {"gap": {"use": "clearance"}, "hits": {"use": "collisions"}}
    given = tables(tmp_path / "s", scenario="back.toml", axes=None, replicas=1, duration=20.0, metrics=metrics)
    (tmp_path / "s" / "back.py").write_text("def drive(readings, estimate, clock):\n    return (-4.0, -4.0)\n")
    (tmp_path / "s" / "back.toml").write_text(
        """
format = 1

[world]
map = "rooms.wld"

[[robots]]
name = "rover"
model = "pioneer2dx"
pose = { x = 2.0, y = 1.0 }
controller = { use = "back.py:drive" }

[robots.drive]
use = "tractor"
wheel_radius_left = 0.1
wheel_radius_right = 0.1
track = 0.4
rate_max_deg = 600.0
trailer_length = 0.6
trailer_width = 0.4
trailer_front = 0.1
trailer_rear = 0.2
"""
    )
    study = am.sweep(study_file(tmp_path / "s" / "study.toml", given), tmp_path / "out")
    assert study.failures == []
    assert study["hits"].tolist() == [1.0]
    assert study["gap"][0] == pytest.approx(0.0, abs=1e-6)


def test_a_study_is_a_dict_of_arrays_and_a_frame(tmp_path: Path) -> None:
    am.sweep(tables(tmp_path / "s"), tmp_path / "out")
    study = am.read_study(tmp_path / "out")
    assert isinstance(study, dict)
    assert study[TRACK].dtype == float
    assert study["replica"].tolist() == [0, 1, 2, 0, 1, 2]
    assert study.axes == [TRACK]
    assert study.metrics == ["final_error", "length"]
    assert study.about["metrics"]["length"] == {
        "unit": "m",
        "better": "lower",
        "robot": "",
        "estimator": "",
        "measure": "path_length",
    }
    assert study.about["metrics"]["final_error"]["estimator"] == "dead_reckoning"
    pandas = pytest.importorskip("pandas")
    frame = study.to_pandas()
    assert isinstance(frame, pandas.DataFrame)
    assert frame["length"].tolist() == study["length"].tolist()
    table = tmp_path / "out" / "table.parquet"
    if table.exists():
        assert pandas.read_parquet(table)["digest"].tolist() == study["digest"].tolist()


def test_a_study_is_a_polars_frame(tmp_path: Path) -> None:
    polars = pytest.importorskip("polars")
    axes = {TRACK: [1.0, 1.05], "robots.rover.on_collision": ["end", "continue"]}
    study = am.sweep(tables(tmp_path / "s", axes=axes, replicas=1, duration=0.2), tmp_path / "out")
    frame = study.to_polars()
    assert isinstance(frame, polars.DataFrame)
    assert frame.columns == list(study)
    kinds = (polars.Int64, polars.Float64, polars.String)
    assert [frame[name].dtype for name in ("point", TRACK, "digest")] == list(kinds)
    for name in study:
        assert frame[name].to_list() == study[name].tolist(), name
    table = tmp_path / "out" / "table.parquet"
    if table.exists():
        assert polars.read_parquet(table).equals(frame)


def test_without_pyarrow_the_table_is_text_and_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    given = tables(tmp_path / "s", axes={TRACK: [1.0, 1.05], "robots.rover.on_collision": ["end", "continue"]})
    first = am.sweep(given, tmp_path / "out")
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    second = am.sweep(given, tmp_path / "text")
    assert (tmp_path / "text" / "table.csv").exists()
    assert same(first, second)


def test_a_study_in_a_file_names_files_beside_it(tmp_path: Path) -> None:
    given = tables(tmp_path / "s", scenario="small.toml", axes={"world.map": ["rooms.wld"]})
    path = study_file(tmp_path / "s" / "study.toml", given)
    assert am.sweep(path, tmp_path / "out").failures == []


@pytest.mark.long
def test_axes_may_be_ranges_draws_variants_and_components(tmp_path: Path) -> None:
    axes: dict[str, Any] = {
        TRACK: {"from": 1.0, "to": 1.1, "count": 2},
        "robots.rover.ground.0.variance_per_length": {"uniform": [1e-5, 1e-4], "count": 2},
        "robots.rover.controller": [{"use": "square", "side": 1.0}, {"use": "manual"}],
        "speed": {
            "variants": {
                "slow": {"simulation.dt": 0.1, "robots.rover.pose.x": 1.0},
                "far": {"simulation.dt": 0.05, "robots.rover.pose.x": 1.2},
            }
        },
    }
    study = am.sweep(tables(tmp_path / "s", axes=axes, replicas=1, duration=0.2), tmp_path / "out")
    assert study.failures == []
    assert len(study["point"]) == 16
    assert set(study["robots.rover.controller"]) == {"square", "manual"}
    assert set(study["speed"]) == {"slow", "far"}
    assert sorted(set(study[TRACK])) == [1.0, 1.1]
    drawn = set(study["robots.rover.ground.0.variance_per_length"])
    assert len(drawn) == 2
    assert all(1e-5 <= value <= 1e-4 for value in drawn)


def test_seeds_may_be_an_axis_and_rows_say_their_own(tmp_path: Path) -> None:
    given = tables(tmp_path / "s", replicas=1, duration=0.2)
    along = am.sweep(given | {"axes": {"simulation.seed": [7, 8]}}, tmp_path / "axis")
    seeds = am.sweep(given | {"axes": {}, "seeds": [7, 8]}, tmp_path / "seeds")
    assert along["seed"].tolist() == along["simulation.seed"].tolist() == [7, 8]
    assert along["digest"].tolist() == seeds["digest"].tolist()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"seeds": [1], "axes": {"simulation.seed": [1, 2]}}, "'simulation.seed' and 'seeds' both set simulation.seed"),
        (
            {"duration": 0.2, "axes": {"simulation.duration": [0.2, 0.3]}},
            "'simulation.duration' and 'duration' both set simulation.duration",
        ),
        (
            {"axes": {TRACK: [1.0, 1.1], "other": {"variants": {"a": {TRACK: 1.2}, "b": {TRACK: 1.3}}}}},
            f"'other' and '{TRACK}' both set {TRACK}; keep one of them",
        ),
    ],
)
def test_what_is_set_twice_is_refused(tmp_path: Path, changes: dict[str, Any], words: str) -> None:
    with pytest.raises(am.StudyError, match=re.escape(words)):
        am.sweep(tables(tmp_path / "s", **changes), tmp_path / "out")


def test_a_finished_study_is_not_computed_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    given = tables(tmp_path / "s")
    first = am.sweep(given, tmp_path / "out")
    monkeypatch.setattr(executors, "run_chunk", None)
    assert same(am.sweep(given, tmp_path / "out"), first)


def test_ctrl_c_keeps_what_is_done_and_the_same_call_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    given = tables(tmp_path / "s", axes={TRACK: [1.0, 1.01, 1.02, 1.03]})
    whole = am.sweep(given, tmp_path / "whole")
    real, seen = chunks.run_chunk, []

    def interrupted(plan: Any, index: int, folder: str = "") -> Any:
        if index == 2 and len(seen) == 2:
            raise KeyboardInterrupt
        seen.append(index)
        return real(plan, index, folder)

    monkeypatch.setattr(executors, "run_chunk", interrupted)
    part = am.sweep(given, tmp_path / "out")
    assert not part.is_complete
    assert part["point"].tolist() == [0, 0, 0, 1, 1, 1]
    monkeypatch.undo()
    reports: list[Any] = []
    assert same(am.sweep(given, tmp_path / "out", progress=reports.append), whole)
    assert [(each.done, each.total) for each in reports] == [(2, 4), (3, 4), (4, 4)]
    assert reports[0].left is None
    assert reports[1].left > 0.0
    assert reports[2].left == 0.0


def test_a_point_that_fails_is_recorded_and_the_others_go_on(tmp_path: Path) -> None:
    given = tables(tmp_path / "s", axes={"robots.rover.pose.x": [1.0, -5.0, 1.1]})
    study = am.sweep(given, tmp_path / "out")
    assert study.is_complete
    ((point, error),) = study.failures
    assert point == 1
    assert "-5" in error
    failed = study["point"] == 1
    assert np.isnan(study["length"][failed]).all()
    assert not np.isnan(study["length"][~failed]).any()
    assert set(study["digest"][failed]) == {""}


def test_replicas_end_when_their_robots_stand_still(tmp_path: Path) -> None:
    controller = {"use": "square", "side": 0.3, "tolerance": 0.05}
    whole = tables(tmp_path / "s", axes={"robots.rover.controller": [controller]}, duration=60.0)
    long = am.sweep(whole, tmp_path / "long")
    short = am.sweep(whole | {"stop": "still"}, tmp_path / "short", keep="all")
    assert np.abs(short["length"] - long["length"]).max() < 1e-3
    (folder,) = (tmp_path / "short" / "runs").iterdir()
    assert json.loads((folder / "run.json").read_text())["steps_done"] < 500
    alone = am.sweep(whole | {"stop": "still", "replicas": 1}, tmp_path / "alone")
    for name in ("length", "final_error", "digest"):
        assert alone[name][0] == short[name][0], name


def test_replicas_end_at_a_collision(tmp_path: Path) -> None:
    goto = {"use": "goto", "x": 50.0, "y": 1.0}
    given = tables(tmp_path / "s", axes={"robots.rover.controller": [goto]}, duration=60.0)
    given["metrics"] = METRICS | {"hits": {"use": "collisions"}}
    short = am.sweep(given | {"stop": "collision"}, tmp_path / "short", keep="all")
    assert short["hits"].tolist() == [1.0, 1.0, 1.0]
    (folder,) = (tmp_path / "short" / "runs").iterdir()
    assert json.loads((folder / "run.json").read_text())["steps_done"] < 500


def test_a_moving_obstacle_that_meets_a_wall_ends_no_replica(tmp_path: Path) -> None:
    given = tables(tmp_path / "s", replicas=1, axes=None, duration=3.0)
    cart = {"shape": {"circle": 0.2}, "motion": {"use": "loop", "waypoints": [[7.0, 4.0], [9.0, 4.0]], "speed": 1.0}}
    with_cart = given | {"axes": {"obstacles": [[cart]]}}
    whole = am.sweep(with_cart, tmp_path / "whole", keep="all")
    (folder,) = (tmp_path / "whole" / "runs").iterdir()
    assert "obstacle1,collision,wall," in (folder / "events.csv").read_text()
    assert am.sweep(with_cart | {"stop": "collision"}, tmp_path / "short")["digest"] == whole["digest"]


def test_kept_runs_leave_folders_that_reproduce(tmp_path: Path) -> None:
    study = am.sweep(tables(tmp_path / "s", replicas=2, seeds=[3]), tmp_path / "out", keep=[1])
    (folder,) = (tmp_path / "out" / "runs").iterdir()
    assert folder.name == "point-000001-seed-3"
    assert am.reproduce(folder).is_exact
    about = json.loads((folder / "run.json").read_text())
    assert list(about["digests"].values()) == study["digest"][study["point"] == 1].tolist()


def test_runs_are_kept_of_what_was_done_without(tmp_path: Path) -> None:
    given = tables(tmp_path / "s", replicas=2, axes={"robots.rover.pose.x": [1.0, -5.0, 1.1]}, duration=0.2)
    runs, counts = tmp_path / "out" / "runs", []
    first = am.sweep(given, tmp_path / "out")
    again = am.sweep(given, tmp_path / "out", keep="all", progress=lambda now: counts.append(now.total - now.done))
    assert same(first, again)
    assert counts == [2, 1, 0]  # the point that fails leaves no folder, and is not tried again
    assert sorted(folder.name for folder in runs.iterdir()) == ["point-000000", "point-000002"]
    counts.clear()
    # A run that was broken off is none.
    (runs / "point-000002" / "run.json").write_text("{")
    am.sweep(given, tmp_path / "out", keep=[0], progress=lambda now: counts.append(now.total - now.done))
    am.sweep(given, tmp_path / "out", keep=[2], progress=lambda now: counts.append(now.total - now.done))
    assert counts == [0, 1, 0]
    assert am.reproduce(runs / "point-000002").is_exact


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"axes": {"robots.rover.errors.drive.trak.scale": [1.0, 1.1]}}, r"no value of this axis can be set: .*trak"),
        (
            {"axes": {"robots.rover.pose.x": [1.0, -5.0]}},
            r"no value of this axis that would change the scenario can be set: .*-5",
        ),
        ({"axes": {"robots.scout.pose.x": [1.0]}}, r"no value of this axis can be set: .*scout"),
        ({"axes": {TRACK: []}}, r"expected one value at least, got none"),
        ({"axes": {TRACK: [1.0, 1.0]}}, r"expected different values"),
        ({"axes": {TRACK: [1, 1.0, 1.1]}}, r"expected different values"),
        ({"axes": {TRACK: {"from": 0.0, "to": 1.0}}}, r"expected count or step"),
        ({"axes": {"seed": [1, 2]}}, r"the table has a column 'seed' of its own"),
        ({"axes": {"length": [1, 2]}}, r"an axis is called 'length' too"),
        ({"metrics": {"a": {"use": "position_eror"}}}, r"Did you mean 'position_error'"),
        ({"metrics": {"a": {"use": "position_error", "when": "end"}}}, r"unknown key"),
        ({"metrics": {"a": {"use": "position_error", "robot": "scout"}}}, r"no robot 'scout'; known robots: rover"),
        ({"metrics": {"a": {"use": "nees", "estimator": "ekf"}}}, r"no estimator 'ekf'"),
        ({"metrics": None}, r"metrics: missing"),
        ({"replicas": 0}, r"replicas: expected a number of replicas > 0, got 0"),
        ({"seeds": [1, 1]}, r"seeds: expected one seed at least, and different ones"),
        ({"seeds": 1}, r"seeds: expected a list of seeds"),
        ({"duration": -1.0}, r"duration: expected a number of seconds > 0"),
        ({"stop": "soon"}, r"stop: expected one of never, still, collision"),
        ({"repeats": 3}, r"repeats: unknown key"),
        ({"scenario": "nowhere.toml"}, r"scenario: .*nowhere.toml"),
        ({"format": 2}, r"format"),
    ],
)
def test_what_is_wrong_with_a_study_is_reported_before_it_begins(
    tmp_path: Path, changes: dict[str, Any], words: str
) -> None:
    with pytest.raises(am.StudyError, match=words):
        am.sweep(tables(tmp_path / "s", **changes), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_two_metrics_of_one_name_are_reported_with_their_line(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text(
        'format = 1\nscenario = "demo"\n[metrics]\na = { use = "collisions" }\na = { use = "path_length" }\n'
    )
    with pytest.raises(am.StudyError, match=r"study.toml:5: "):
        am.sweep(path, tmp_path / "out")


def test_a_study_that_was_changed_is_refused(tmp_path: Path) -> None:
    given = tables(tmp_path / "s")
    am.sweep(given, tmp_path / "out")
    with pytest.raises(am.StudyError, match=r"begun with another study; .* name another folder with --out"):
        am.sweep(given | {"replicas": 4}, tmp_path / "out")
    small = tmp_path / "s" / "small.toml"
    small.write_text(small.read_text().replace("seed = 5", "seed = 6"))
    with pytest.raises(am.StudyError, match=r"begun with another scenario"):
        am.sweep(given, tmp_path / "out")


def test_a_folder_of_another_version_is_refused(tmp_path: Path) -> None:
    given = tables(tmp_path / "s")
    am.sweep(given, tmp_path / "out")
    file = tmp_path / "out" / "study.json"
    about = json.loads(file.read_text())
    file.write_text(json.dumps(about | {"amorsim": "0.0.1"}))
    with pytest.raises(am.StudyError, match=r"amorsim was 0\.0\.1 and is "):
        am.sweep(given, tmp_path / "out")
    file.write_text(json.dumps(about | {"format": 7}))
    for read in (lambda: am.sweep(given, tmp_path / "out"), lambda: am.read_study(tmp_path / "out")):
        with pytest.raises(am.StudyError, match=r"expected a study of format 1, .*, got 7"):
            read()


def test_a_folder_with_other_files_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine.txt").write_text("mine")
    with pytest.raises(am.StudyError, match=r"holds files already, such as mine.txt"):
        am.sweep(tables(tmp_path / "s"), tmp_path / "out")
    with pytest.raises(am.StudyError, match=r"expected the folder of a study"):
        am.read_study(tmp_path / "out")


def test_on_a_full_disk_what_was_done_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from amorsim.sweeps import folder as folders

    given = tables(tmp_path / "s")
    whole = am.sweep(given, tmp_path / "whole")
    real = folders.write_text

    def full(path: Path, text: str, *, within: Path) -> None:
        if path.name == "00000001.json":
            raise am.RunError(f"{path}: cannot be written (No space left on device)")
        real(path, text, within=within)

    monkeypatch.setattr(folders, "write_text", full)
    with pytest.raises(am.StudyError, match=r"No space left on device\); what was done before is in .*out"):
        am.sweep(given, tmp_path / "out")
    assert am.read_study(tmp_path / "out")["point"].tolist() == [0, 0, 0]
    monkeypatch.undo()
    assert same(am.sweep(given, tmp_path / "out"), whole)


def test_on_a_disk_too_full_for_the_table_chunks_stay(tmp_path: Path) -> None:
    resource = pytest.importorskip("resource")
    given = tables(tmp_path / "s", duration=0.2)
    whole = am.sweep(given, tmp_path / "whole")
    size = next((tmp_path / "whole").glob("table.*")).stat().st_size
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size - 1, limits[1]))  # bytes of a file
    try:
        with pytest.raises(am.StudyError, match=r"table.*: cannot be written") as raised:
            am.sweep(given, tmp_path / "out")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert "File too large" in str(raised.value)
    assert "\n" not in explain(raised.value)  # no lines of a library's code
    assert same(am.sweep(given, tmp_path / "out"), whole)


def test_a_damaged_chunk_is_named(tmp_path: Path) -> None:
    given = tables(tmp_path / "s")
    am.sweep(given, tmp_path / "out")
    (tmp_path / "out" / "chunks" / "00000" / "00000001.json").write_text('{"index": 1, "values": {}, "digests": []}')
    with pytest.raises(am.StudyError, match=r"00000001.json: is damaged: expected .* remove it"):
        am.sweep(given, tmp_path / "out")


@pytest.mark.parametrize("keep", ["some", [7], [-1]])
def test_what_to_keep_must_be_there(tmp_path: Path, keep: Any) -> None:
    with pytest.raises(am.StudyError, match=r"keep: expected 'none', 'all', or numbers of points below 2"):
        am.sweep(tables(tmp_path / "s"), tmp_path / "out", keep=keep)
