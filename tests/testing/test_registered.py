"""Every component that amorsim registers keeps its contract."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from amorsim.contracts import Mount
from amorsim.controllers import (
    Bug2,
    Dwa,
    Hrvo,
    HumanLike,
    Mppi,
    Navigate,
    NearnessDiagram,
    Orca,
    PathPursuit,
    Policy,
    PotentialField,
    Pursuit,
    SocialForce,
    TangentBug,
    VfhPlus,
)
from amorsim.estimators import GraphSlam, GridMapping, GridSlam, MonteCarlo
from amorsim.motions import Loop, Oscillate, Pedestrian, SlidingDoor, SwingDoor, Track, Waypoints
from amorsim.noise import Bump
from amorsim.planners import AStar
from amorsim.plugins.manager import make_registry
from amorsim.scenario.spec import Pose
from amorsim.sensors.fiducial import Fiducial
from amorsim.sensors.infrared import Infrared
from amorsim.sensors.laser import Laser
from amorsim.sensors.neighbours import Neighbours
from amorsim.sensors.sonar import Sonar
from amorsim.tasks import PointGoal
from amorsim.testing import check_component
from tests import building

REGISTRY = make_registry(entry_points=[])
KINDS = (
    *("drive", "sensor", "noise", "map_loader", "scenario_loader", "world_generator", "motion", "estimator"),
    *("controller", "planner", "recorder", "metric", "task"),
)
CASES = [(kind, name) for kind in KINDS for name in REGISTRY.names(kind)]

# What a check needs to know besides the class: the travel of wheels is never inf, and comes in pairs; beams may be
# made up, and what is stuck holds a return that is no more.
_WHEELS: dict[str, Any] = {"inf": "absent", "values_of": "encoder"}
SETTINGS: dict[tuple[str, str], dict[str, Any]] = {
    ("noise", "beam_model"): {"inf": "changed"},
    ("noise", "bump"): _WHEELS,
    ("noise", "cross_talk"): {"inf": "changed", "side": {"heard": 1.0}},
    ("noise", "diffusion"): {"inf": "absent"},
    ("noise", "missed"): {"side": {"slot": 0.0, "range": 2.0, "empty": np.inf}},
    ("noise", "odometry_model"): _WHEELS,
    ("noise", "slip"): _WHEELS,
    ("noise", "specular_loss"): {"side": {"incidence": 0.5}},
    ("noise", "stuck"): {"inf": "changed"},
    ("noise", "velocity_model"): _WHEELS,
    ("controller", "braitenberg"): {
        "sensors": {"infrared": Infrared(elements=tuple(Mount(heading=0.8 * i) for i in range(8)))}
    },
    **{
        ("controller", name): {"sensors": {"neighbours": Neighbours()}}
        for name in ("orca", "hrvo", "human_like", "social_force")
    },
    ("controller", "policy"): {"sensors": {"laser": Laser(beams=181)}},
    ("controller", "follow"): {"sensors": {"fiducial": Fiducial()}},
    # It sees some centimetres: the wall is so near.
    ("sensor", "infrared"): {"scene": building.scenario(building.robot(pose=Pose(x=5.92, y=2.0)))},
}

# In place of what a class alone would give: a narrow cone has fewer rays, and is tried as well; a route that goes
# somewhere within a few steps, and a door that opens; few particles.
_ROUTE: dict[str, Any] = {"waypoints": ((4.0, 4.0), (4.1, 4.0), (4.1, 4.3)), "pause": 0.05}
_MAP: dict[str, Any] = {"resolution": 0.2, "width": 12.0, "height": 12.0}
_MATCHED: dict[str, Any] = {"wheel_variance": 1e-3, "range_std": 0.01, "match_distance": 0.02, "nodes": 6, **_MAP}
_DOOR: dict[str, Any] = {"timetable": ((0.1, 0.3),), "period": 0.4}
EXAMPLES: dict[type, Any] = {
    Sonar: Sonar(half_angle=0.03),
    Bump: Bump(height=0.01, rate=3.0),  # no higher than a wheel, and somewhere
    Waypoints: Waypoints(**_ROUTE),
    Loop: Loop(**_ROUTE, blocked="skip"),
    Oscillate: Oscillate(**_ROUTE),
    Pursuit: Pursuit(waypoints=((4.0, 4.0), (6.0, 4.0), (6.0, 5.0)), loop=True),
    Navigate: Navigate(goals=((6.0, 4.0), (4.0, 4.0)), planner=AStar(cell=0.1)),
    Policy: Policy(
        file=str(REGISTRY.file("scenario", "learned").with_name("point-goal.onnx")),
        task=PointGoal(),
        goals=((6.0, 4.0), (4.0, 4.0)),
    ),
    Mppi: Mppi(goals=((6.0, 4.0),), samples=20, time_steps=10),
    **{
        kind: kind(goals=((6.0, 4.0), (4.0, 4.0)), loop=True)
        for kind in (
            Bug2,
            Dwa,
            Hrvo,
            HumanLike,
            NearnessDiagram,
            Orca,
            PathPursuit,
            PotentialField,
            SocialForce,
            TangentBug,
            VfhPlus,
        )
    },
    Pedestrian: Pedestrian(goals=((4.0, 4.0), (6.0, 3.0)), order="random", blocked="skip"),
    SwingDoor: SwingDoor(**_DOOR),
    MonteCarlo: MonteCarlo(wheel_variance=1e-4, particles_min=10, particles_max=60),  # as many in each of 1,000 rows
    # Maps of 64 robots.
    GridMapping: GridMapping(**_MAP),
    GridSlam: GridSlam(**_MATCHED, particles=3, node_distance=0.05),
    GraphSlam: GraphSlam(**_MATCHED, key_distance=0.05, loop_gap=2, loop_window=0.1, loop_window_angle=0.1),
    SlidingDoor: SlidingDoor(**_DOOR, blocked="skip"),
}


# Tried with the long tests; of every kind others are tried every day.
SLOW = {
    *("navigate", "orca", "hybrid_a_star", "rrt_star"),
    *("graph_slam", "grid_slam", "monte_carlo", "scan_matching"),
}


@pytest.mark.parametrize(
    ("kind", "name"),
    [pytest.param(*case, marks=[pytest.mark.long] * (case[1] in SLOW)) for case in CASES],
    ids=[f"{kind}-{name}" for kind, name in CASES],
)
def test_registered_component(kind: str, name: str, tmp_path: Path) -> None:
    component: Any = REGISTRY.get(kind, name)
    component = EXAMPLES.get(component, component)
    if component is Track:
        (tmp_path / "track.csv").write_text("time,x,y\n5,4,4\n5.2,4.1,4\n5.5,4.1,4.3\n")
        component = Track(file=str(tmp_path / "track.csv"), repeat=True)
    # There is no other robot where components are tried: tests/sensors/test_neighbours.py tests what this one reads.
    is_alone = component is Neighbours
    with pytest.warns(UserWarning, match="its reading never changed") if is_alone else contextlib.nullcontext():
        check_component(component, **SETTINGS.get((kind, name), {}))


def test_nothing_is_left_out() -> None:
    others = {entry.kind for entry in REGISTRY.entries()} - set(KINDS)
    assert others <= {"device", "robot", "scenario"}
    assert not REGISTRY.problems
