"""Metrics give what a plain computation gives."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.analysis import RunFiles, measure, run_nees, run_nis
from amorsim.analysis.measuring import episode_of
from amorsim.core.maps.footprint_room import wall_gaps
from amorsim.metrics import (
    ArrivalTime,
    Clearance,
    Collisions,
    Coverage,
    HeadingError,
    MapAccuracy,
    MapCompleteness,
    MapIou,
    Nees,
    Nis,
    PathLength,
    PositionError,
    RecoveryTime,
    Spl,
    Success,
    Turning,
)
from tests import building

DT = 0.1


def episode(true: Any, estimated: Any = None, events: Any = (), **kept: Any) -> am.Episode:
    """Of poses `(S, R, 3)`."""
    true = np.asarray(true, float)
    return am.Episode(
        robot="rover",
        replicas=tuple(range(true.shape[1])),
        time=DT * np.arange(len(true)),
        kept={
            "true_pose": true,
            "part_pose": np.empty((*true.shape[:2], 0, 3)),
            "estimated_pose": true if estimated is None else np.asarray(estimated, float),
            **kept,
        },
        events=list(events),
        map=building.room(),
        shape=am.Shape.circle(0.2),
    )


def event(kind: str, time: float, replica: int = 0, value: Any = None) -> am.Event:
    return am.Event(tick=round(time / DT), time=time, replica=replica, kind=kind, name="rover", value=value)


def straight(steps: int = 11, speed: float = 1.0) -> np.ndarray:
    """Two replicas that go along x from (1, 2), the second one twice as fast."""
    way = speed * DT * np.arange(steps)
    poses = np.zeros((steps, 2, 3))
    poses[:, 0, 0], poses[:, 1, 0], poses[..., 1] = 1.0 + way, 1.0 + 2.0 * way, 2.0
    return poses


@pytest.mark.parametrize(
    ("at", "wanted"), [("end", 1.0), ("mean", 0.5), ("rms", math.sqrt(0.35)), ("max", 1.0), ("median", 0.5)]
)
def test_errors_of_the_position(at: str, wanted: float) -> None:
    true = straight()
    estimated = true.copy()
    estimated[:, 0, 1] += np.linspace(0.0, 1.0, 11)
    assert PositionError(at=at).measure(episode(true, estimated)) == pytest.approx([wanted, 0.0])


def test_errors_of_the_heading_go_the_short_way() -> None:
    true, estimated = straight(), straight()
    true[..., 2], estimated[..., 2] = 3.1, -3.1
    assert HeadingError().measure(episode(true, estimated)) == pytest.approx([2.0 * math.pi - 6.2] * 2)


def test_the_path_has_the_length_and_the_turns_that_it_has() -> None:
    poses = straight()
    poses[:, 1, 2] = np.linspace(3.0, 3.5, 11)
    assert PathLength().measure(episode(poses)) == pytest.approx([1.0, 2.0])
    assert Turning().measure(episode(poses)) == pytest.approx([0.0, 0.25])
    assert np.isnan(Turning().measure(episode(straight(speed=0.0)))).all()


@pytest.mark.parametrize("kind", ["pose_set", "kidnapped"])
def test_what_a_robot_is_carried_is_no_way_that_it_drove(kind: str) -> None:
    """Replica 0 is put to (4, 1) after the third step, turned by 2 rad; what it drives in that step counts."""
    poses = straight()
    poses[4:, 0] += [3.0 - 0.3, -1.0, 2.0]
    seen = episode(poses, events=[event(kind, 0.3, 0, (2.0, 4.0, -1.0)), event(kind, 0.3, 0, [4.0, 1.0, 2.0])])
    assert PathLength().measure(seen) == pytest.approx([1.0, 2.0])
    assert Turning().measure(seen) == pytest.approx([0.0, 0.0], abs=1e-12)
    late = episode(straight(), events=[event(kind, 1.0, 0, (4.0, 1.0, 2.0))])
    assert PathLength().measure(late) == pytest.approx([1.0, 2.0])


def test_events_are_counted_for_their_replica() -> None:
    events = [event("collision", 0.3, 1), event("collision", 0.5, 1), event("controller_ended", 0.5, 1)]
    seen = episode(straight(), events=events)
    assert Collisions().measure(seen).tolist() == [0.0, 2.0]


def test_arrival_is_the_first_time_near_the_goal() -> None:
    found = ArrivalTime(goal=(2.5, 2.0), tolerance=0.3001).measure(episode(straight()))
    assert found == pytest.approx([math.nan, 0.6], nan_ok=True)


def test_success_is_to_arrive_without_a_collision() -> None:
    seen = episode(straight(), events=[event("collision", 0.2, 1)])
    assert Success().measure(seen).tolist() == [1.0, 0.0]
    assert Success(goal=(2.0, 2.0), tolerance=0.05).measure(seen).tolist() == [1.0, 0.0]
    assert Success(goal=(3.0, 2.0), tolerance=0.05, collisions=1).measure(seen).tolist() == [0.0, 1.0]


def test_clearance_is_the_least_gap_to_a_wall() -> None:
    # The room is 6 m x 5 m, its walls a millimetre thick.
    found = Clearance().measure(episode(straight(21)))
    assert found == pytest.approx([0.8, 0.8], abs=2e-3)
    assert Clearance(gap_max=0.1).measure(episode(straight())) == pytest.approx([0.1, 0.1])
    assert Clearance().measure(episode(straight() - [0.9, 0.0, 0.0])).tolist() == [0.0, 0.0]


@pytest.mark.long
def test_clearance_is_of_trailers_too(tmp_path: Path) -> None:
    pulled = building.robot(drive=building.tractor(), pose=am.Pose(x=1.2, y=2.0), name="b")
    alone = building.robot(pose=am.Pose(x=4.0, y=2.0), name="a")
    scenario = building.scenario(alone, pulled)
    am.run(scenario, tmp_path / "run", duration=0.2, replicas=2)
    simulation = am.Simulation(scenario, replicas=2)
    (trailer,) = building.tractor().parts
    gaps, _ = wall_gaps(scenario.map, [trailer.shape] * 2, simulation.part_pose, 2.0)
    assert measure(tmp_path / "run", Clearance(), robot="b") == pytest.approx(gaps, abs=1e-5)
    gaps, _ = wall_gaps(scenario.map, [alone.shape], np.array([[4.0, 2.0, 0.0]]), 2.0)
    assert measure(tmp_path / "run", Clearance(), robot="a") == pytest.approx([gaps[0]] * 2, abs=1e-5)


def test_clearance_is_of_each_replicas_own_world(tmp_path: Path) -> None:
    forest = am.load("demo", ['world.map={generate="forest", seed=7, per="replica", size=[12.0, 9.0]}'])
    robot = building.robot(pose=None, controller=None)
    scenario = building.scenario(robot, map=forest.map)
    am.run(scenario, tmp_path / "run", duration=0.2, replicas=3)
    found = measure(tmp_path / "run", Clearance())
    simulation = am.Simulation(scenario, replicas=3)
    simulation.run(0.2)
    for row in range(3):
        pose = simulation.true_pose[row : row + 1]
        gaps, _ = wall_gaps(simulation.map_of(row), [robot.shape], pose, 2.0)
        assert found[row] == pytest.approx(gaps[0], abs=1e-5)
    assert len(set(found.tolist())) == 3


def test_coverage_is_the_area_that_a_disc_sweeps() -> None:
    found = Coverage(radius=0.5, cell=0.02).measure(episode(straight()))
    wanted = [math.pi * 0.25 + 1.0 * 1.0, math.pi * 0.25 + 2.0 * 1.0]
    assert found == pytest.approx(wanted, rel=0.01)


@pytest.mark.parametrize("kind", ["pose_set", "kidnapped"])
def test_recovery_counts_from_the_last_kidnap(kind: str) -> None:
    true, estimated = straight(41), straight(41)
    # At 1 s it still is where it was: the next step is the first elsewhere.
    estimated[11:18, 0, 1] += 5.0
    estimated[:, 1, 1] += 5.0
    events = [event(kind, 0.5, 0, (1.0, 1.0, 0.0)), event(kind, 1.0, 0, (1.0, 2.0, 0.0))]
    seen = episode(true, estimated, events)
    assert RecoveryTime().measure(seen) == pytest.approx([0.8, math.nan], nan_ok=True)
    estimated[20, 0, 1] += 5.0
    again = episode(true, estimated, events)
    assert RecoveryTime(hold_time=1.0).measure(again)[0] == pytest.approx(1.1)


def test_a_jump_late_in_a_long_run_is_found_in_times_of_six_digits() -> None:
    steps, dt = 60_000, 1.0 / 30.0
    true = np.zeros((steps + 1, 1, 3))
    true[57_001:] = (7.0, 0.0, 0.0)
    seen = attrs.evolve(
        episode(true, events=[event("kidnapped", 1900.0, 0, (7.0, 0.0, 0.0))]),
        time=np.round(dt * np.arange(steps + 1), 6),
    )
    assert PathLength().measure(seen).tolist() == [0.0]


def test_nees_and_nis_of_known_covariances() -> None:
    true, estimated = straight(), straight()
    estimated[:, 0] += [0.1, 0.2, 0.3]
    covariance = np.broadcast_to(np.diag([0.01, 0.04, 0.09]), (11, 2, 3, 3)).copy()
    covariance[:5] = 0.0
    seen = episode(true, estimated, covariance=covariance)
    assert Nees().measure(seen) == pytest.approx([3.0, 0.0])
    assert Nees(at="mean").measure(seen) == pytest.approx([3.0, 0.0])
    values = np.full((11, 2, 4), np.nan)
    values[3, 0, :2] = [1.0, 4.0]
    values[7, 0, 1] = 1.0
    nis = episode(true, **{"beliefs.ekf.gps_nis": values})
    assert Nis(source="gps").measure(nis) == pytest.approx([2.0, math.nan], nan_ok=True)


def test_a_kidnapped_robot_drove_as_far_as_the_run_says(tmp_path: Path) -> None:
    away = am.Kidnapping(time=1.0, x=1.5, y=3.5, heading=2.0)
    robot = building.robot(controller=am.controllers.Square(side=1.0, speed=0.4), kidnappings=[away])
    summary = am.run(building.scenario(robot, dt=0.1), tmp_path / "run", duration=3.0)
    assert measure(tmp_path / "run", PathLength())[0] == pytest.approx(summary.distance["rover"], rel=1e-3)
    assert np.isnan(measure(tmp_path / "run", RecoveryTime())[0])


def test_a_robot_without_estimators_has_no_covariance_to_measure(tmp_path: Path) -> None:
    am.run(building.scenario(building.robot(estimators={})), tmp_path / "run", duration=0.2)
    with pytest.raises(am.AnalysisError, match=r"run: robot 'rover' has no estimator, .* no 'covariance'"):
        measure(tmp_path / "run", Nees())


def test_metrics_of_files_are_those_of_the_simulation(tmp_path: Path) -> None:
    scenario = am.load("landmarks")
    am.run(scenario, tmp_path / "run", duration=5.0, replicas=3)
    simulation = am.Simulation(scenario, replicas=3)
    kept = simulation.run(5.0, keep=("true_pose", "estimated_pose"))
    apart = kept["estimated_pose"][-1, :, :2] - kept["true_pose"][-1, :, :2]
    assert measure(tmp_path / "run", PositionError()) == pytest.approx(np.hypot(*apart.T), abs=5e-6)
    steps = np.hypot(*np.moveaxis(np.diff(kept["true_pose"][..., :2], axis=0), 2, 0)).sum(axis=0)
    assert measure(tmp_path / "run", PathLength()) == pytest.approx(steps, abs=0.02)
    assert measure(tmp_path / "run", Collisions()).tolist() == [0.0, 0.0, 0.0]
    ekf = next(name for name, one in scenario.robots[0].estimators.items() if type(one).__name__ == "Ekf")
    nees = run_nees(tmp_path / "run", estimator=ekf)
    assert nees.values.shape == (len(nees.time), 3)
    assert nees.verdict.degrees == 3
    nis = run_nis(tmp_path / "run", estimator=ekf)
    assert nis.degrees == 2
    assert nis.verdict.count > 20
    mean = measure(tmp_path / "run", Nis(estimator=ekf))
    assert np.nanmean(nis.values[:, 0]) == pytest.approx(mean[0])
    assert nis.at(5.0).count <= 3 * nis.values.shape[2]
    with pytest.raises(am.AnalysisError, match=r"do not hold 'beliefs.nobody.gps_nis'"):
        measure(tmp_path / "run", Nis(estimator="nobody", source="gps"))


def test_commands_that_lack_lines_are_refused(tmp_path: Path) -> None:
    am.run(am.load("demo"), tmp_path / "run", replicas=2, duration=1.0)
    path = tmp_path / "run" / "commands.csv"
    lines = path.read_text().splitlines()
    path.write_text("\n".join([line for i, line in enumerate(lines) if i not in (6, 8)]) + "\n")  # of one replica
    with pytest.raises(am.RunError, match=r"commands\.csv: is damaged: expected as many lines"):
        episode_of(RunFiles(tmp_path / "run"), ("command",))


def test_commands_of_a_mixed_fleet_are_the_same_in_files_and_in_a_simulation(tmp_path: Path) -> None:
    scenario = am.load("convoy")
    am.run(scenario, tmp_path / "run", duration=0.5, replicas=2)
    simulation = am.Simulation(scenario, replicas=2)
    kept = simulation.run(0.5, keep=("command",))["command"]
    files = RunFiles(tmp_path / "run")
    for place, name in enumerate(simulation.names):
        found = episode_of(files, ("command",), robot=name).kept["command"]
        assert np.array_equal(found[1:], kept[:, place :: len(simulation.names)], equal_nan=True)


def test_a_table_without_rows_is_said_to_hold_nothing(tmp_path: Path) -> None:
    am.run(building.scenario(building.robot()), tmp_path / "run", duration=0.2)
    table = tmp_path / "run" / "estimates" / "dead_reckoning.csv"
    table.write_text(table.read_text().splitlines(keepends=True)[0])
    assert np.isfinite(measure(tmp_path / "run", PositionError())).all()  # it does not need the table
    for metric in (Nees(at="end"), Nees(at="mean")):
        with pytest.raises(am.AnalysisError, match="hold no moment for"):
            measure(tmp_path / "run", metric)


def test_the_way_counts_as_far_as_it_is_longer_than_the_shortest() -> None:
    """One goes straight, one by a corner, one not at all, and one touches something."""
    corner = np.concatenate((np.linspace((1.0, 1.0), (4.0, 1.0), 31), np.linspace((4.0, 1.1), (4.0, 3.0), 20)))
    line = np.linspace((1.0, 1.0), (4.0, 3.0), len(corner))
    true = np.zeros((len(corner), 4, 3))
    true[:, 0, :2], true[:, 1, :2], true[:, 2, :2], true[:, 3, :2] = line, corner, (1.0, 1.0), line
    found = Spl(goal=(4.0, 3.0), tolerance=0.1).measure(episode(true, events=[event("collision", 1.0, replica=3)]))
    shortest = math.hypot(3.0, 2.0) - 0.1
    assert found == pytest.approx([1.0, shortest / 4.9, 0.0, 0.0], abs=0.03)
    assert np.isnan(Spl(goal=(99.0, 3.0)).measure(episode(true))).all()


def drawn(cells: Any, side: float, origin: tuple[float, float]) -> am.Episode:
    """An episode at whose end two replicas have maps."""
    maps = np.asarray(cells, float)
    kept = {
        "last.beliefs.own.occupancy": maps[None],
        "last.beliefs.own.occupancy_origin": np.tile(origin, (1, 2, 1)),
        "last.beliefs.own.occupancy_resolution": np.full((1, 2), side),
    }
    return episode(straight(), **kept)


@pytest.mark.parametrize("origin", [(0.0, 0.0), (-0.5, -1.0)])
def test_a_perfect_map_is_perfect_and_a_shifted_one_is_off_by_the_shift(origin: tuple[float, float]) -> None:
    world, side = building.room(), 0.1
    wide, high = (round((size + 2.0) / side) for size in world.size)
    perfect = np.zeros((high, wide))
    walls = world.to_array(resolution=side)
    row, column = round(-origin[1] / side), round(-origin[0] / side)
    perfect[row : row + len(walls), column : column + len(walls[0])] = walls
    shifted = np.roll(perfect, 1, axis=0)
    both = drawn([perfect, shifted], side, origin)
    assert MapIou(estimator="own").measure(both)[0] == 1.0
    assert MapIou(estimator="own").measure(both)[1] < 0.8
    accuracy, completeness = (kind(estimator="own").measure(both) for kind in (MapAccuracy, MapCompleteness))
    assert accuracy[0] == completeness[0] == 0.0
    assert 0.0 < accuracy[1] <= side
    assert 0.0 < completeness[1] <= side


def test_a_map_without_walls_is_not_accurate_and_one_of_walls_alone_is_complete() -> None:
    wide, high = (round(size / 0.1) for size in building.room().size)
    both = drawn([np.zeros((high, wide)), np.ones((high, wide))], 0.1, (0.0, 0.0))
    accuracy, completeness = (kind(estimator="own").measure(both) for kind in (MapAccuracy, MapCompleteness))
    assert np.isnan(accuracy[0])
    assert accuracy[1] > 0.3
    assert completeness.tolist() == [np.inf, 0.0]
    assert MapIou(estimator="own").measure(both).max() < 0.2


def test_nees_of_particles_is_that_of_their_mean_and_covariance() -> None:
    random = np.random.default_rng(1)
    particles = random.normal((2.0, 3.0, math.pi), (0.1, 0.2, 0.05), (5, 2, 4000, 3))
    weights = random.uniform(0.5, 1.0, particles.shape[:3])
    weights[:, 1, 2000:] = np.nan  # a cloud that has shrunk
    particles[:, 1, 2000:] = np.nan
    true = np.tile((2.1, 3.0, -math.pi), (5, 2, 1))
    kept = {"beliefs.own.particles": particles, "beliefs.own.weights": weights}
    assert Nees(estimator="own", particles=True).measure(episode(true, **kept)) == pytest.approx([1.0, 1.0], rel=0.2)
    with pytest.raises(am.ParameterError, match="whose particles"):
        Nees(particles=True)
