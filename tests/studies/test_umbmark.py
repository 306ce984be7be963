"""UMBmark driven in the simulator: what was put into the drive comes out, and no more is claimed than is known."""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.algorithms.umbmark import WheelGeometry, published_figures, systematic_error
from amorsim.noise.diffusion import Diffusion
from amorsim.scenario.spec import Deviation, Distribution, Scenario
from amorsim.simulation.truth import true_robot
from amorsim.studies.umbmark import corrected_scenario, drive_squares, fit_squares, umbmark
from tests import building
from tests.algorithms.squares import ends

NOMINAL = WheelGeometry(building.RADIUS, building.RADIUS, building.TRACK)
# The square turns within 2 mm of a corner, with a heading within 2 mrad: its sides differ by 4 mm of 4 m at most, and
# so do the figures, by a thousandth of their deviation; twice that for both coordinates.
ED_EXACT, EB_EXACT = 0.002 * 0.005, 0.002 * 0.02


def _errors(ed: float, eb: float) -> dict[str, Deviation]:
    true = NOMINAL.corrected(ed, eb)
    return {
        "drive.wheel_radius_left": Deviation(value=true.radius_left),
        "drive.wheel_radius_right": Deviation(value=true.radius_right),
        "drive.track": Deviation(value=true.track),
    }


def _scenario(ed: float = 1.0, eb: float = 1.0, variance: float = 0.0, **changes: Any) -> Scenario:
    ground = [Diffusion(variance_per_length=variance)] if variance else []
    robot = building.robot(errors=_errors(ed, eb), ground=ground)
    return building.scenario(robot, **({"dt": 0.5} | changes))


@pytest.mark.parametrize(("ed", "eb"), [(1.005, 1.02), (0.995, 0.98), (1.002, 0.99), (1.0, 1.0)])
def test_without_random_errors_what_was_put_in_comes_out(ed: float, eb: float) -> None:
    found = umbmark(_scenario(ed, eb), runs=2)
    assert found.exact.ed.value == pytest.approx(ed, abs=1e-9)
    assert found.exact.eb.value == pytest.approx(eb, abs=1e-9)
    assert found.exact.scatter == 0.0
    true = NOMINAL.corrected(ed, eb)
    assert found.corrected == pytest.approx(true, abs=1e-9)
    if ed != 1.0:
        assert found.error_after < 1e-3 * found.error_before
        assert found.error_after_published < 0.1 * found.error_before
    else:
        assert found.error_before < 1e-9


def test_a_tractor_is_calibrated_as_its_wheels_are() -> None:
    drive = am.drives.Tractor(
        wheel_radius_left=building.RADIUS,
        wheel_radius_right=building.RADIUS,
        track=building.TRACK,
        rate_max=50.0,
        trailer_length=0.5,
        trailer_width=0.3,
        trailer_front=0.1,
        trailer_rear=0.1,
    )
    robot = building.robot(drive=drive, errors=_errors(1.002, 1.01))
    found = umbmark(building.scenario(robot, dt=0.5), runs=2)
    assert found.exact.ed.value == pytest.approx(1.002, abs=1e-9)
    assert found.exact.eb.value == pytest.approx(1.01, abs=1e-9)


@pytest.mark.parametrize(("ed", "eb"), [(1.005, 1.02), (0.995, 0.98), (1.002, 0.99)])
def test_the_published_figures_have_their_known_bias_and_no_other(ed: float, eb: float) -> None:
    """They are those of an exact square, to what the corners' tolerances make of it."""
    found = umbmark(_scenario(ed, eb), runs=2).published
    wanted = published_figures(*ends(ed, eb, track=building.TRACK), 4.0, building.TRACK)
    for form in ("x", "y", "mean"):
        assert getattr(found, form).ed == pytest.approx(getattr(wanted, form).ed, abs=ED_EXACT)
        assert getattr(found, form).eb == pytest.approx(getattr(wanted, form).eb, abs=EB_EXACT)


def test_noise_of_the_ground_does_not_shift_the_published_figures() -> None:
    """Over many runs their mean is that of a robot without noise, to four standard errors."""
    runs = 400
    scenario = _scenario(1.003, 1.01, 3e-7)
    squares = drive_squares(scenario, scenario.robots[0], side=4.0, speed=0.2, runs=runs)
    quiet = drive_squares(_scenario(1.003, 1.01), _scenario(1.003, 1.01).robots[0], side=4.0, speed=0.2, runs=2)
    for found, wanted in zip(squares, quiet, strict=True):
        error = found.ends.std(axis=0, ddof=1) / math.sqrt(runs)
        # The heading's variance q S = 2 k S / b^2 after the 16 m shortens a side by half of that, at most.
        shift = 4.0 * 3e-7 * 16.0 / building.TRACK**2
        assert (np.abs(found.ends.mean(axis=0) - wanted.ends[0]) < 4 * error + shift).all()


def _coverage(seeds: int) -> tuple[int, int]:
    """How many of the intervals cover Ed and Eb, both other ones in each seed."""
    draws = np.random.default_rng(8)
    hits = np.zeros(2, dtype=int)
    for seed in range(seeds):
        ed, eb = draws.uniform(0.995, 1.005), draws.uniform(0.98, 1.02)
        scenario = _scenario(ed, eb, 1e-6, seed=seed)
        robot = scenario.robots[0]
        fit = fit_squares(robot.drive, *drive_squares(scenario, robot, side=4.0, speed=0.2, runs=5))
        hits += (fit.ed.covers(ed), fit.eb.covers(eb))
    return int(hits[0]), int(hits[1])


@pytest.mark.long
def test_the_intervals_cover_what_was_put_in() -> None:
    # Fewer than 24 of 30 come with a probability of 0.0005 if each covers with 0.95.
    assert sum(math.comb(30, k) * 0.95**k * 0.05 ** (30 - k) for k in range(24)) < 1e-3
    assert min(_coverage(30)) >= 24


@pytest.mark.long
def test_the_intervals_cover_what_was_put_in_180_times_of_200() -> None:
    # Fewer than 180 of 200 come with a probability of 0.001 if each covers with 0.95.
    assert sum(math.comb(200, k) * 0.95**k * 0.05 ** (200 - k) for k in range(180)) < 2e-3
    assert min(_coverage(200)) >= 180


@pytest.mark.long
def test_encoders_that_round_and_wheels_that_gather_speed_change_little() -> None:
    """The Pioneer as it ships: whole counts, limited acceleration, another step."""
    scenario = am.load("demo")
    robot = attrs.evolve(scenario.robots[0], errors=_errors(1.004, 1.015))
    found = umbmark(attrs.evolve(scenario, robots=[robot]), runs=2)
    # A count is 13 um of travel at the rim: in the worst case two of them at each of eight ends of sides and turns,
    # over the track of 0.33 m and swung along a side: 8 * 2 * 13e-6 / 0.33 * 4 m = 2.5 mm; of ends 0.8 m from 0.
    assert found.exact.ed.value == pytest.approx(1.004, abs=0.004 * 3e-3)
    assert found.exact.eb.value == pytest.approx(1.015, abs=0.015 * 3e-3)
    assert found.error_after < 0.0025
    assert found.error_after < 0.1 * found.error_before


def test_after_correction_only_random_errors_are_left() -> None:
    found = umbmark(_scenario(1.004, 1.015, 1e-7), runs=5)
    assert found.error_after < 0.1 * found.error_before
    # The centres scatter with a fifth of the variance of single runs; the fit is of the very same draws.
    assert found.error_after < 4.0 * found.exact.scatter / math.sqrt(5)


def test_the_runs_are_of_one_robot_with_draws_of_their_own() -> None:
    drawn = {"drive.track": Deviation(scale=Distribution(kind="normal", values=(1.0, 0.02)))}
    scenario = building.scenario(building.robot(errors=drawn), dt=0.5)
    robot = scenario.robots[0]
    for squares in drive_squares(scenario, robot, side=2.0, speed=0.2, runs=3):
        assert (squares.ends == squares.ends[0]).all()
    found = umbmark(scenario, runs=2)
    assert found.exact.eb.value == pytest.approx(true_robot(robot, scenario.seed, 0).drive.track / 0.33, abs=1e-9)  # type: ignore[attr-defined]
    noisy = _scenario(1.0, 1.0, 1e-6)
    first, second = drive_squares(noisy, noisy.robots[0], side=2.0, speed=0.2, runs=3)
    assert len(np.unique(np.concatenate((first.ends, second.ends))[:, 0])) == 6


def test_it_drives_in_its_own_world_if_asked_to() -> None:
    scenario = _scenario(1.003, 1.01, map=building.room(14.0, 14.0))
    robot = attrs.evolve(scenario.robots[0], pose=am.Pose(x=7.0, y=7.0, heading=0.4))
    scenario = attrs.evolve(scenario, robots=[robot])
    there = umbmark(scenario, runs=2, in_its_world=True)
    elsewhere = umbmark(scenario, runs=2)
    assert there.clockwise == pytest.approx(elsewhere.clockwise, abs=1e-9)
    assert there.exact.eb.value == pytest.approx(1.01, abs=1e-9)


def test_walls_in_the_way_are_reported() -> None:
    with pytest.raises(am.AmorsimError, match=r"robot 'rover' met 'wall' at .* take a smaller side"):
        umbmark(_scenario(), in_its_world=True)


def test_what_does_not_fit_the_method_is_refused() -> None:
    scenario = _scenario()
    with pytest.raises(am.AmorsimError, match=r"speed: expected a number > 0 and <= 0.2 m/s.*got 0.3"):
        umbmark(scenario, speed=0.3)
    with pytest.raises(am.AmorsimError, match="side: expected a number > 0"):
        umbmark(scenario, side=0.0)
    with pytest.raises(am.AmorsimError, match="runs: expected 2 at least"):
        umbmark(scenario, runs=1)
    with pytest.raises(am.AmorsimError, match=r"no robot 'rovr'; did you mean 'rover'"):
        umbmark(scenario, robot="rovr")
    blind = building.scenario(building.robot(sensors={}, estimators={}), dt=0.5)
    with pytest.raises(am.AmorsimError, match="robot 'rover' has no odometry"):
        umbmark(blind)


def test_other_drives_are_refused() -> None:
    from amorsim.studies.calibration import _TurnTable

    with pytest.raises(am.AmorsimError, match="UMBmark is for differential drives, and this one's is _TurnTable"):
        umbmark(building.scenario(building.robot(drive=_TurnTable())))


@pytest.mark.long
def test_the_corrected_scenario_has_the_same_robot_in_it() -> None:
    """Its true drive stays to the bit, what its software holds is corrected, and a file says the same."""
    scenario = am.load("demo")
    robot = scenario.robots[0]
    found = umbmark(scenario, runs=2)
    changed = corrected_scenario(scenario, robot.name, found.corrected)
    before, after = (true_robot(r, scenario.seed, 0).drive for r in (robot, changed.robots[0]))
    assert after == before
    drive: Any = changed.robots[0].drive
    assert (drive.wheel_radius_left, drive.wheel_radius_right, drive.track) == tuple(found.corrected)
    again = umbmark(changed, runs=2)
    assert systematic_error(again.clockwise, again.anticlockwise) == found.error_after
    # What whole counts leave to be found, as above, of a deviation of a hundredth.
    assert again.exact.ed.value == pytest.approx(1.0, abs=0.01 * 3e-3)
    assert again.exact.eb.value == pytest.approx(1.0, abs=0.01 * 3e-3)


def test_nothing_depends_on_which_sensors_the_robot_has_besides() -> None:
    bare = _scenario(1.002, 1.01, 1e-6)
    full = attrs.evolve(bare.robots[0], sensors=building.all_sensors() | bare.robots[0].sensors)
    found = umbmark(attrs.evolve(bare, robots=[full]), runs=2, side=2.0)
    assert found.clockwise.tobytes() == umbmark(bare, runs=2, side=2.0).clockwise.tobytes()


def test_motors_that_lag_longer_than_a_step_come_round_and_are_measured() -> None:
    scenario = _scenario(1.002, 1.01, 0.0)
    slow = attrs.evolve(scenario.robots[0], drive=attrs.evolve(scenario.robots[0].drive, lag=0.4))
    found = umbmark(attrs.evolve(scenario, robots=[slow]), side=2.0, runs=2)
    assert found.exact.ed.value == pytest.approx(1.002, abs=1e-4)
    assert found.exact.eb.value == pytest.approx(1.01, abs=1e-3)


def test_it_knows_its_start_and_is_not_carried_away() -> None:
    """Neither says anything of the drive: the same figures as without them."""
    plain = _scenario(1.002, 1.01, 1e-6)
    away = am.Kidnapping(time=10.0, x=1.0, y=1.0)
    for belief in (am.InitialBelief(kind="gaussian", std=0.2, heading_std=0.1), am.InitialBelief(kind="nothing")):
        lost = attrs.evolve(plain.robots[0], initial_belief=belief, kidnappings=[away])
        found = umbmark(attrs.evolve(plain, robots=[lost]), runs=2, side=2.0)
        assert found.clockwise.tobytes() == umbmark(plain, runs=2, side=2.0).clockwise.tobytes()
