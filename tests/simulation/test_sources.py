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
