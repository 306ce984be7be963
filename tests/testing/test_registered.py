"""Every component that amorsim registers keeps its contract."""

from __future__ import annotations

from typing import Any

import pytest

from amorsim.plugins.manager import make_registry
from amorsim.sensors.sonar import Sonar
from amorsim.testing import check_component

REGISTRY = make_registry(entry_points=[])
KINDS = ("drive", "sensor", "noise", "map_loader", "motion", "estimator", "controller", "recorder")
CASES = [(kind, name) for kind in KINDS for name in REGISTRY.names(kind)]

# What a check is told beside the class: the travel of wheels is never inf, and comes in pairs; beams may be
# made up, and what is stuck holds a return that is no more.
_WHEELS: dict[str, Any] = {"inf": "absent", "values_of": "encoder"}
SETTINGS: dict[tuple[str, str], dict[str, Any]] = {
    ("noise", "beam_model"): {"inf": "changed"},
    ("noise", "diffusion"): {"inf": "absent"},
    ("noise", "odometry_model"): _WHEELS,
    ("noise", "slip"): _WHEELS,
    ("noise", "specular_loss"): {"side": {"incidence": 0.5}},
    ("noise", "stuck"): {"inf": "changed"},
    ("noise", "velocity_model"): _WHEELS,
}


@pytest.mark.parametrize(("kind", "name"), CASES, ids=[f"{kind}-{name}" for kind, name in CASES])
def test_registered_component(kind: str, name: str) -> None:
    component: Any = REGISTRY.get(kind, name)
    if component is Sonar:
        component = Sonar(half_angle=0.03)  # a narrow cone has fewer rays, and is tried as well
    check_component(component, **SETTINGS.get((kind, name), {}))


def test_nothing_is_left_out() -> None:
    others = {entry.kind for entry in REGISTRY.entries()} - set(KINDS)
    assert others <= {"robot", "scenario"}
    assert not REGISTRY.problems
