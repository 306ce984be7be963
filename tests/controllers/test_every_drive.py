"""Controllers keep their contract on drives of other kinds too."""

from __future__ import annotations

from typing import Any

import pytest

from amorsim.controllers import FollowWall, GoTo, Pursuit, Wander
from amorsim.testing import check_component
from tests.drives.fleet import make

PURSUIT = Pursuit(waypoints=((4.0, 4.0), (6.0, 5.0)))


@pytest.mark.parametrize(
    ("controller", "drive"),
    [
        (Wander(), "ackermann rear"),
        (PURSUIT, "ackermann front"),
        (PURSUIT, "synchro driven"),
        (GoTo(x=4.0, y=4.0), "synchro fixed"),
        (FollowWall(distance=1.3), "ackermann rear"),
    ],
    ids=["wander car", "pursuit car", "pursuit synchro", "goto synchro", "wall car"],
)
def test_it_keeps_its_contract(controller: Any, drive: str) -> None:
    check_component(controller, drive=make(drive))
