import attrs
import pytest

import amorsim as am
from amorsim.simulation.sources import source_lines


def test_an_estimator_that_names_sources_gets_a_table():
    assert source_lines(am.load("landmarks")) == [
        "estimator ekf of rover:",
        "  sensor 'encoder'   predicts x, y, heading  1e-05 m² of travel per m",
        "  sensor 'fiducial'  corrects x, y, heading  range 0.05 m, bearing 1°",
        "  gates              pass                    99.9 % of good readings",
    ]
    assert source_lines(am.load("demo")) == []


def test_estimators_that_map_name_what_gives_the_poses_and_what_draws_the_map():
    assert source_lines(am.load("map-the-office")) == [
        "estimator slam of rover:",
        "  sensor 'encoder'  predicts x, y, heading  0.0001 m² of travel per m",
        "  sensor 'laser'    corrects x, y, heading  matched with key scans, range 0.01 m",
        "  loops             correct all poses       of 10 nodes and more, fit 0.6, share 0.5",
        "estimator exact of rover:",
        "  sensor 'tracking'  gives x, y, heading  as exact",
        "  sensor 'laser'     draws the map        hit 0.97, miss 0.4",
    ]
    fed = am.estimators.GridMapping(estimator="slam", model="counting").sources()
    assert fed[0] == ("estimator 'slam'", "gives x, y, heading", "as exact")
    assert fed[1][2] == "hits and misses are counted"
    assert am.estimators.GridMapping().sources()[0][0] == "sensor 'encoder'"
    assert am.estimators.GridSlam(wheel_variance=1e-4, range_std=0.02).sources()[1] == (
        "sensor 'laser'",
        "weighs them, draws maps",
        "30 particles, range 0.02 m",
    )


def test_robots_that_use_the_same_share_a_table():
    scenario = am.load("landmarks")
    rover = scenario.robots[0]
    many = [attrs.evolve(rover, name=f"r{i}") for i in range(6)]
    other = attrs.evolve(rover.estimators["ekf"], range_std=0.1)
    many.append(attrs.evolve(rover, name="last", estimators={"ekf": other}))
    lines = source_lines(attrs.evolve(scenario, robots=many))
    assert lines[0] == "estimator ekf of r0, r1, r2, r3 and 2 more:"
    assert lines[4] == "estimator ekf of last:"


def test_an_error_names_robot_and_estimator():
    @attrs.frozen(kw_only=True)
    class Wrong(am.estimators.DeadReckoning):
        def sources(self):
            return [("a", "b")]

    scenario = am.load("landmarks")
    robots = [attrs.evolve(scenario.robots[0], estimators={"odd": Wrong()})]
    with pytest.raises(am.ComponentError, match=r"'odd' \(Wrong\) of robot 'rover': sources\(\) raised"):
        source_lines(attrs.evolve(scenario, robots=robots))
