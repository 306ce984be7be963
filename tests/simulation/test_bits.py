"""The same bits: however many replicas, threads or simulations there are, and after going back to a snapshot."""

from __future__ import annotations

import re
import threading
from pathlib import Path

import attrs
import numpy as np
import pytest

import amorsim as am
from tests import building


def robots(count: int = 2) -> list[am.Robot]:
    """Robots with every sensor, drawn errors, ground noise, that drive at random and meet."""
    errors = {
        "drive.track": am.Deviation(scale=am.Distribution(kind="normal", values=(1.0, 0.02))),
        "sensors.laser.mount.heading": am.Deviation(
            add=am.Distribution(kind="uniform", values=(-0.1, 0.1)), per="study"
        ),
    }
    return [
        building.robot(
            name=f"r{i}",
            sensors=building.all_sensors(),
            ground=building.chain(am.noise.Gaussian(std=1e-4)),
            controller=building.Roam(),
            on_collision="continue",
            errors=errors,
            pose=am.Pose(x=1.5 + 1.5 * i, y=2.0 + 0.4 * i, heading=0.5 * i),
        )
        for i in range(count)
    ]


def crowd(count: int = 2) -> am.Scenario:
    return building.scenario(*robots(count), dt=0.1, seed=11)


def run(sim: am.Simulation, steps: int = 60) -> am.Simulation:
    for _ in range(steps):
        sim.step()
    return sim


def test_a_replica_alone_is_the_one_among_many() -> None:
    many = run(am.Simulation(crowd(), replicas=64))
    alone = run(am.Simulation(crowd(), replicas=[37]))
    assert many.digest(37) == alone.digest(37) == alone.digest(37)
    assert many.digest(36) != many.digest(37)
    row = 37 * 2
    assert (many.true_pose[row : row + 2] == alone.true_pose).all()
    for name in many.readings:
        np.testing.assert_array_equal(many.readings[name].measured[row : row + 2], alone.readings[name].measured)


def test_drawn_errors_differ_by_replica_unless_drawn_once_per_study() -> None:
    sim = am.Simulation(crowd(), replicas=5)
    tracks = [sim._fleet.groups[0].true[2 * i].drive.track for i in range(5)]
    headings = [sim._fleet.groups[0].true[2 * i].sensors["laser"].mount.heading for i in range(5)]
    assert len(set(tracks)) == 5
    assert len(set(headings)) == 1
    assert headings[0] != 0.1


def test_interleaved_runs_equal_runs_apart() -> None:
    first, second = am.Simulation(crowd(), seed=1), am.Simulation(crowd(3), seed=2)
    for _ in range(40):
        first.step()
        second.step()
    assert first.digest() == run(am.Simulation(crowd(), seed=1), 40).digest()
    assert second.digest() == run(am.Simulation(crowd(3), seed=2), 40).digest()


def test_runs_in_two_threads_equal_runs_apart() -> None:
    sims = [am.Simulation(crowd(), seed=seed) for seed in (1, 2)]
    threads = [threading.Thread(target=run, args=(sim,)) for sim in sims]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [sim.digest() for sim in sims] == [run(am.Simulation(crowd(), seed=s)).digest() for s in (1, 2)]


def test_restore_goes_back_to_the_bit() -> None:
    sim = run(am.Simulation(crowd(), replicas=3), 33)
    snapshot = sim.snapshot()
    wanted = run(sim, 30)
    digests, events, poses = [wanted.digest(i) for i in range(3)], list(wanted.events), wanted.true_pose.copy()
    for _ in range(2):  # any number of times
        sim.restore(snapshot)
        assert sim.tick == 33
        run(sim, 30)
        assert [sim.digest(i) for i in range(3)] == digests
        assert sim.events == events
        assert (sim.true_pose == poses).all()


def test_a_snapshot_can_be_restored_into_another_simulation() -> None:
    sim = run(am.Simulation(crowd(), seed=5), 20)
    other = run(am.Simulation(crowd(), seed=6), 7)
    other.restore(sim.snapshot())
    assert run(other, 20).digest() == run(sim, 20).digest()


def test_parameters_that_were_set_go_back_too() -> None:
    sim = run(am.Simulation(crowd()), 5)
    before = sim.snapshot()
    sim.set("r0", "errors.drive.wheel_radius_left.scale", 1.1)
    changed = run(sim, 20).digest()
    sim.restore(before)
    untouched = run(sim, 20).digest()
    assert untouched == run(am.Simulation(crowd()), 25).digest()
    assert changed != untouched


def test_reset_of_one_replica_leaves_the_others() -> None:
    sim = run(am.Simulation(crowd(), replicas=3), 20)
    sim.reset(replicas=[1])
    assert sim.ticks.tolist() == [20, 0, 20]
    run(sim, 20)
    undisturbed = run(am.Simulation(crowd(), replicas=3), 40)
    assert sim.digest(0) == undisturbed.digest(0)
    assert sim.digest(2) == undisturbed.digest(2)
    assert sim.digest(1) != run(am.Simulation(crowd(), replicas=3), 20).digest(1)  # another episode, other draws


def test_reset_with_a_seed_is_a_new_simulation() -> None:
    sim = run(am.Simulation(crowd(), seed=1))
    sim.reset(seed=9)
    assert run(sim).digest() == run(am.Simulation(crowd(), seed=9)).digest()


def test_another_sensor_changes_no_draw_and_no_path() -> None:
    plain = crowd()
    sensors = {**building.all_sensors(), "second": am.MountedSensor(
        sensor=am.sensors.Laser(beams=5), noise=building.chain(am.noise.Gaussian(std=0.1)))}  # fmt: skip
    more = attrs.evolve(plain, robots=tuple(attrs.evolve(r, sensors=sensors) for r in plain.robots))
    a, b = run(am.Simulation(plain)), run(am.Simulation(more))
    assert (a.true_pose == b.true_pose).all()
    for name in a.readings:
        np.testing.assert_array_equal(a.readings[name].measured, b.readings[name].measured)


def test_another_robot_far_off_changes_nobody() -> None:
    plain = building.scenario(*robots(1), map=building.room(40.0, 40.0, 0.01))
    far = attrs.evolve(robots(2)[1], pose=am.Pose(x=30.0, y=30.0), name="a_stranger")
    both = building.scenario(*robots(1), far, map=building.room(40.0, 40.0, 0.01))
    a, b = run(am.Simulation(plain)), run(am.Simulation(both))
    assert a.robot("r0").true_pose.tolist() == b.robot("r0").true_pose.tolist()
    for name, reading in a.robot("r0").readings.items():
        np.testing.assert_array_equal(reading.measured, b.robot("r0").readings[name].measured)


def test_the_order_of_robots_in_the_file_does_not_matter() -> None:
    there, back = crowd(3), crowd(3)
    back = attrs.evolve(back, robots=back.robots[::-1])
    assert run(am.Simulation(there)).digest() == run(am.Simulation(back)).digest()


def test_grouping_does_not_matter() -> None:
    """Robots of two kinds, in two groups, do as each does beside one of its own kind far away."""
    first, second = robots(2)
    errors = {"drive.track": second.errors["drive.track"]}
    other = attrs.evolve(second, sensors={"encoder": second.sensors["encoder"]}, errors=errors)
    mixed = run(am.Simulation(building.scenario(first, other, seed=11)))
    alike = run(am.Simulation(building.scenario(first, second, seed=11)))
    assert (mixed.true_pose == alike.true_pose).all()
    with pytest.raises(am.AmorsimError, match="several kinds"):
        _ = mixed.readings
    assert mixed.robot("r0").readings["laser"].measured.shape == (19,)


def test_the_counter_of_replicas_is_used_and_not_their_place() -> None:
    a = run(am.Simulation(crowd(), replicas=[4, 9]))
    b = run(am.Simulation(crowd(), replicas=[9, 4, 100_000]))
    assert a.digest(4) == b.digest(4)
    assert a.digest(9) == b.digest(9)


@pytest.mark.parametrize("threads", [2, 3])
def test_threads_share_the_work_and_give_the_same_bits(threads: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("amorsim.core.execution.workers.LEAST_WORK", 50)  # part even what would not pay
    monkeypatch.setattr("amorsim.core.execution.workers.cores", lambda: threads)
    alone = run(am.Simulation(crowd(3), replicas=4), 25)
    shared = run(am.Simulation(crowd(3), replicas=4, threads=threads), 25)
    assert shared._fleet.world.workers._pool is not None
    assert shared.digest() == alone.digest()


def test_a_number_of_threads_is_checked() -> None:
    with pytest.raises(am.AmorsimError, match="expected a number of threads >= 1, got 0"):
        am.Simulation(crowd(), threads=0)


@pytest.mark.parametrize("name", ["find-yourself", "find-the-way"])
def test_a_snapshot_is_of_every_simulation_of_its_scenario(name: str) -> None:
    """Where the robot knows a map, too, which each time is another object with the same content."""
    one, other = am.Simulation(am.load(name)), am.Simulation(am.load(name))
    one.run(0.3)
    other.restore(one.snapshot())
    assert run(other, 2).digest() == run(one, 2).digest()


def test_robots_that_know_equal_maps_share_a_group() -> None:
    maps = (building.room(), building.room.__wrapped__())
    assert maps[0] is not maps[1]
    robots = [attrs.evolve(knowing(one), name=f"r{i}", pose=am.Pose(x=2.0 + i, y=2.0)) for i, one in enumerate(maps)]
    (group,) = am.Simulation(building.scenario(*robots))._fleet.groups
    assert group.robot.map == maps[0]
    assert not group.robot.maps


def knowing(map_: am.Map) -> am.Robot:
    return building.robot(name="rover", knowledge=am.Knowledge(map=map_))


@pytest.mark.parametrize("other", ["name", "sensor", "map", "replicas"])
def test_a_snapshot_of_something_else_is_refused_and_nothing_changes(other: str) -> None:
    simulation = am.Simulation(building.scenario(knowing(building.room())), replicas=2)
    changed = {
        "name": building.robot(name="scout"),
        "sensor": building.robot(name="rover", sensors={}, estimators={}),
        "map": knowing(building.room(6.0, 4.9)),
        "replicas": knowing(building.room()),
    }[other]
    stranger = am.Simulation(building.scenario(changed), replicas=3 if other == "replicas" else 2)
    simulation.run(0.5)
    stranger.run(1.0)
    before = simulation.digest(), simulation.tick, len(simulation.events)
    with pytest.raises(am.SnapshotError, match="another simulation"):
        simulation.restore(stranger.snapshot())
    assert (simulation.digest(), simulation.tick, len(simulation.events)) == before
    simulation.step()


def test_a_true_value_out_of_bounds_says_where_from_and_that_it_was_drawn(tmp_path: Path) -> None:
    wide = am.Deviation(scale=am.Distribution(kind="normal", values=(1.0, 3.0)))
    robot = building.robot(errors={"drive.track": wide})
    made = attrs.evolve(building.scenario(robot), source=tmp_path / "wide.toml")
    with pytest.raises(am.ScenarioError) as caught:
        am.Simulation(made, replicas=20)
    fault = caught.value.faults[0]
    assert (fault.file, fault.path) == (str(tmp_path / "wide.toml"), "robots.rover.errors.drive.track")
    assert re.search(
        r"expected a number \[m\] >= 0.001 and <= 100, got -\d.*, drawn for replica \d+; take a narrower", fault.message
    )


def test_random_starts_are_drawn_for_each_episode_and_are_those_of_the_replica_alone() -> None:
    start = am.RandomStart(clearance=0.2)
    robots = [attrs.evolve(robot, pose=None, start=start) for robot in crowd().robots]
    scenario = attrs.evolve(crowd(), robots=robots)
    sim = am.Simulation(scenario, replicas=[3, 7, 8])
    alone = am.Simulation(scenario, replicas=[7])
    seen = []
    for episode in range(4):
        if episode:
            sim.reset(replicas=[7])
            alone.reset()
        handle = sim.robot("r0", 7)
        seen.append(tuple(handle.true_pose.tolist()))
        assert (handle.true_pose == alone.robot("r0").true_pose).all()
        assert (handle.estimated_pose == handle.true_pose).all()
        run(sim, 7)
        run(alone, 7)
        assert sim.digest(7) == alone.digest(7)
    assert len(set(seen)) == 4


def test_replicas_that_begin_again_one_by_one_are_those_that_begin_together() -> None:
    """Next episodes are begun ahead for all replicas; what is set meanwhile counts all the same."""
    sims = [am.Simulation(crowd(), replicas=4) for _ in range(2)]
    together, apart = (run(sim, 9) for sim in sims)
    apart.reset(replicas=[2])
    run(apart, 5)
    for sim in sims:
        sim.set("r0", "errors.drive.track.scale", 1.05)
    for replica in (0, 1, 3):
        apart.reset(replicas=[replica])
    apart.reset(replicas=[2])
    together.reset()
    together.reset(replicas=[2])
    assert [apart.digest(replica) for replica in range(4)] == [together.digest(replica) for replica in range(4)]
    assert apart.ticks.tolist() == [0, 0, 0, 0]
    run(apart, 20)
    run(together, 20)
    assert [apart.digest(replica) for replica in range(4)] == [together.digest(replica) for replica in range(4)]
