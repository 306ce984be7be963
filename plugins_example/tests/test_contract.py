"""Every component keeps its contract: the one test that every plugin should have."""

from pathlib import Path

import amorsim_example as example
import pytest
from example_world import tricycle

from amorsim.testing import check_component

MAZE = Path(example.__file__).parent / "scenarios" / "two_rooms.maze"


@pytest.mark.parametrize(
    "component",
    [
        tricycle(),
        tricycle(steering_max=0.8),
        example.Beacon(x=3.0, y=4.0),
        example.Drift(std=0.1),
        example.Tally(),
        example.Detour(),
        example.Bounce(),
        example.Flood(),
        example.Shuttle(speed=0.5),
        example.Posts(posts=50),
        example.Roam(),
    ],
    ids=[
        *("tricycle", "tricycle, narrow", "beacon", "drift", "tally", "detour"),
        *("bounce", "flood", "shuttle", "posts", "roam"),
    ],
)
def test_component(component: object) -> None:
    check_component(component)


def test_map_loader() -> None:
    check_component(example.Maze(), path=MAZE)


def test_scenario_loader(tmp_path: Path) -> None:
    path = tmp_path / "two.course"
    path.write_text("course two_rooms.maze\npioneer2dx 1.0 1.0 90\n")
    check_component(example.Course(), path=path)


@pytest.mark.parametrize("drive", [None, tricycle()], ids=["differential", "tricycle"])
def test_estimator(drive: example.Tricycle | None) -> None:
    estimator = example.CompassOdometry(compass_std=0.02, way_variance=1e-4, heading_variance=1e-3)
    check_component(estimator, drive=drive)
