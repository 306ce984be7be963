"""The hard cases' components keep the contracts by the public check as well."""

from __future__ import annotations

from typing import Any

import pytest

from amorsim.sensors.encoder import Encoder
from amorsim.testing import check_component
from tests.hard_cases.common import Hold, Weave
from tests.hard_cases.test_ackermann import Ackermann
from tests.hard_cases.test_door import Swing
from tests.hard_cases.test_ekf import MapEkf
from tests.hard_cases.test_pan_tilt import DepthCamera
from tests.hard_cases.test_particles import Particles
from tests.hard_cases.test_pedestrian import Pedestrian
from tests.hard_cases.test_synchro import Synchro
from tests.hard_cases.test_trailer import NOMINAL, Tractor
from tests.some_cases import one_in

COMPONENTS: dict[str, tuple[Any, dict[str, Any]]] = {
    "ackermann": (Ackermann, {}),
    "synchro": (Synchro, {}),
    "trailer": (Tractor(trailer_length=0.5, **NOMINAL), {}),
    "camera": (DepthCamera, {}),
    "ekf": (MapEkf, {}),
    "ekf_on_a_car": (MapEkf, {"drive": Ackermann(), "sensors": {"encoder": Encoder(counts_per_revolution=500.0)}}),
    "particles": (Particles(count=20), {}),
    "door": (Swing, {}),
    "pedestrian": (Pedestrian, {}),
    "hold": (Hold(channels=(1.0, 2.0)), {}),
    "weave": (Weave(middle=(1.0, 2.0), swing=(0.5, 0.5)), {}),
}


@pytest.mark.parametrize("name", one_in(3, COMPONENTS))
def test_keeps_its_contract(name: str) -> None:
    component, settings = COMPONENTS[name]
    check_component(component, **settings)
