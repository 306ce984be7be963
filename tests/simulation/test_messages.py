"""What a simulation says of itself, and of what it cannot do."""

import math

import numpy as np
import pytest

import amorsim as am
from tests import building


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        ("errors.drive.track.scal", 1, "ends with one of scale, add, value.* got 1. Did you mean 'scale'?"),
        ("errors.drive.track", 1.1, "ends with one of scale, add, value, as in errors.drive.track.scale"),
        (
            "errors.drive.track",
            {"scal": 1.0},
            "an error has no key 'scal'; known keys: scale, add, value, per. Did you mean 'scale'",
        ),
        ("errors", 1.0, "ends with one of"),
        ("errors.drive.trak.scale", 1.0, "Did you mean 'track'?"),
    ],
)
def test_an_error_that_cannot_be_set_is_reported_in_words(path, value, says):
    sim = am.Simulation(building.scenario())
    with pytest.raises(am.AmorsimError, match=says.replace("(", r"\(")) as caught:
        sim.set("rover", path, value)
    assert str(caught.value).startswith(f"robot 'rover', {path}: ")
    assert "**" not in str(caught.value)


@pytest.mark.parametrize("path", [None, 3, ("errors", "drive")])
def test_a_path_that_is_no_text_is_reported_in_words(path):
    sim = am.Simulation(building.scenario())
    with pytest.raises(am.AmorsimError, match=r"expected a path, as 'drive\.track', got"):
        sim.set("rover", path, 1.0)


class Nameless:
    def __repr__(self):
        raise RuntimeError("no words")


@pytest.mark.parametrize(
    "value", [10**5000, Nameless(), [10**5000], "x", None, math.nan], ids=lambda value: type(value).__name__
)
def test_odd_values_are_reported_in_words(value):
    sim = am.Simulation(building.scenario())
    rover = sim.robot("rover")
    sim.hand_over("rover")
    whole = () if value is None else ("errors.drive.track",)  # None takes an error away
    for path in ("drive.track", "errors.drive.track.scale", *whole, "controller"):
        with pytest.raises(am.AmorsimError, match="robot 'rover', "):
            sim.set("rover", path, value)
    with pytest.raises(am.AmorsimError, match="expected a pose of three finite numbers"):
        sim.set_pose("rover", value)
    with pytest.raises(am.AmorsimError, match="expected a pose of three finite numbers"):
        sim.set_pose("rover", (1.0, 1.0, value))
    with pytest.raises(am.AmorsimError, match="expected finite numbers for forward, turn and left"):
        rover.drive(value)
    with pytest.raises(am.AmorsimError, match="expected a finite number for each of"):
        rover.command(value, 1.0)


def test_a_velocity_that_is_too_large_to_be_computed_with_is_reported_in_words():
    sim = am.Simulation(building.scenario())
    with pytest.raises(am.AmorsimError, match=r"forward, turn and left, of 1e\+12 at most, got \(1e\+300, 0\.0, 0"):
        sim.robot("rover").drive(forward=1e300)
    sim.robot("rover").drive(forward=1e12, turn=-1e12)  # its drive goes as fast as it can
    sim.step()


@pytest.mark.parametrize("value", [10**5000, Nameless(), "x", math.nan], ids=lambda value: type(value).__name__)
def test_odd_replicas_and_seeds_are_reported_in_words(value):
    sim = am.Simulation(building.scenario())
    with pytest.raises(am.AmorsimError, match=r"^no replica .+; known replicas: 0"):
        sim.robot("rover", value)
    with pytest.raises((am.AmorsimError, am.ParameterError), match=r"expected|memory"):
        am.Simulation(building.scenario(), replicas=value)
    with pytest.raises((am.AmorsimError, am.ParameterError), match="expected"):
        am.Simulation(building.scenario(), seed=value)


@pytest.mark.parametrize("name", [None, 3, ["rover"]])
def test_a_name_that_is_no_text_is_reported_in_words(name):
    sim = am.Simulation(building.scenario())
    with pytest.raises(am.AmorsimError, match=r"no robot .*; (known robots: rover|did you mean 'rover')"):
        sim.set(name, "drive.track", 1.0)
    with pytest.raises(am.AmorsimError, match=r"no obstacle .*; known obstacles: none"):
        sim.obstacle(name)


@pytest.mark.parametrize("duration", [-1, -1e-9, math.nan, math.inf, 1e300, 10**400, "2", True, [1.0]])
def test_it_runs_for_no_time_below_zero_and_none_without_an_end(duration):
    sim = am.Simulation(building.scenario())
    with pytest.raises(am.AmorsimError, match=r"duration: expected a number of seconds >= 0 and <= .*, got"):
        sim.run(duration)
    sim.run(0.0)
    assert sim.tick == 0


@pytest.mark.parametrize("given", ["demo", None, am.Robot, {"robots": []}])
def test_what_is_no_scenario_is_refused_with_a_word_of_how_to_get_one(given):
    with pytest.raises(am.ParameterError, match=r"scenario: expected a Scenario, as am.load\('demo'\), got"):
        am.Simulation(given)


@pytest.mark.parametrize("replicas", ["3", None, 2.5, [0.5]])
def test_replicas_are_a_number_or_numbers(replicas):
    with pytest.raises(am.AmorsimError, match=r"expected a number of replicas > 0, or .* numbers.*, got"):
        am.Simulation(building.scenario(), replicas=replicas)


def test_names_and_paths_that_are_no_texts_are_refused_with_words():
    sim = am.Simulation(building.scenario())
    with pytest.raises(am.AmorsimError, match="no robot 0; known robots: rover"):
        sim.robot(0)
    with pytest.raises(am.AmorsimError, match="no robot None; known robots: rover"):
        sim.set(None, "drive.track", 0.3)


@pytest.mark.parametrize("pose", [am.Pose(x=1.0), 5, None, "abc", (1.0, 2.0), (1.0, 2.0, math.nan), ((1, 2, 3),)])
def test_a_robot_is_put_at_three_finite_numbers_only(pose):
    sim = am.Simulation(building.scenario())
    before = sim.true_pose.tolist()
    with pytest.raises(am.AmorsimError, match="robot 'rover': expected a pose of three finite numbers, got"):
        sim.set_pose("rover", pose)
    assert sim.true_pose.tolist() == before


@pytest.mark.parametrize("given", [None, 5, "yesterday"])
def test_what_is_no_snapshot_is_not_restored(given):
    with pytest.raises(am.SnapshotError, match=r"expected what Simulation.snapshot\(\) gave, or its bytes, got"):
        am.Simulation(building.scenario()).restore(given)


@pytest.mark.parametrize("seed", ["a", -1, 2.5, 2**70])
def test_a_simulation_starts_again_from_a_seed_that_a_scenario_takes(seed):
    sim = am.Simulation(building.scenario())
    with pytest.raises(am.ParameterError, match=r"seed: expected a whole number >= 0"):
        sim.reset(seed=seed)
    assert sim.seed == 3


def test_it_says_what_it_is():
    sim = am.Simulation(building.scenario(dt=0.1))
    assert repr(sim) == "<Simulation: 1 robot, 1 replica, seed 3, at 0 s>"
    sim = am.Simulation(building.scenario(dt=0.1), seed=4, replicas=2)
    sim.run(0.5)
    assert repr(sim) == "<Simulation: 1 robot, 2 replicas, seed 4, at 0.5 s>"
    sim.reset(replicas=[1])
    assert repr(sim) == "<Simulation: 1 robot, 2 replicas, seed 4, at 0 to 0.5 s>"
    assert repr(am.Simulation(am.load("demo"))).startswith("<Simulation of 'demo': 1 robot, 1 replica, seed ")


def test_a_bitmap_without_a_resolution_is_warned_of(tmp_path):
    cells = np.zeros((4, 6), dtype=bool)
    cells[0] = True
    file = tmp_path / "plan.png"
    am.save_map(am.Map.from_array(cells, resolution=0.1), file)
    found = am.load_map(file)
    assert found.resolution == 0.05
    assert "no resolution is given, so a pixel is taken for 0.05 m" in found.warnings[0]
    assert found.source.loader.resolution == 0.05  # what a run's folder says
    assert am.load_map(file, resolution=0.1).warnings == ()
