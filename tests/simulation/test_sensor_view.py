"""What a sensor of a user's is told that asks its view wrongly: in its words, and not in those of a compiler."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from tests import building


@attrs.frozen(kw_only=True)
class Asks(am.Sensor):
    """Asks its view as a test says."""

    unit = "m"

    ask: Callable[[Any, Any], Any]

    def size(self, drive: am.Drive) -> int:
        return 1

    def sense(self, view: Any, aim: am.Aim, state: am.State, draws: am.Draws) -> Any:
        return np.min(self.ask(view, aim), axis=1, keepdims=True), {}


AHEAD = np.zeros((1, 1))
FAR = np.array([[5.0]])


def look(ask: Callable[[Any, Any], Any]) -> am.Simulation:
    sensors = {"encoder": building.encoder(), "asks": Asks(ask=ask)}
    return am.Simulation(building.scenario(building.robot(sensors=sensors)))


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda view, aim: view.cast(aim, AHEAD, FAR), r"view\.cast: origins: expected poses in the world, an array"),
        (lambda view, aim: view.cast(view.pose[0], AHEAD, FAR), r"such as view\.pose, got an array of shape \(3,\)"),
        (lambda view, aim: view.cast(view.pose[:, :2], AHEAD, FAR), r"got an array of shape \(1, 2\)"),
        (lambda view, aim: view.cast(view.pose, [0.0], FAR), r"view\.cast: bearings: .* \[rad\], got \[0\.0\]"),
        (lambda view, aim: view.cast(view.pose, np.zeros(3), FAR), r"bearings: .* got an array of shape \(3,\)"),
        (lambda view, aim: view.cast(view.pose, np.zeros((2, 3)), FAR), r"bearings: expected an array \(1, k\) or"),
        (lambda view, aim: view.floor(np.zeros((1, 2))), r"view\.floor: places: .* array \(1, k, 2\) \[m\], got an"),
        (lambda view, aim: view.floor(view.pose[:, None]), r"got an array of shape \(1, 1, 3\)"),
        (lambda view, aim: view.cone((0.0, 0.0, 0.0), 0.1, FAR), r"view\.cone: origins: .* got \(0\.0, 0\.0, 0\.0\)"),
    ],
)
def test_a_wrong_question_is_told(ask: Callable[[Any, Any], Any], message: str) -> None:
    with pytest.raises(am.ComponentError, match=message):
        look(ask)


def test_a_right_question_is_answered() -> None:
    sim = look(lambda view, aim: view.cast(view.pose, AHEAD, 50.0))
    assert 0.0 < sim.robot("rover").readings["asks"].true[0] < 50.0
    sim = look(lambda view, aim: view.cone(view.pose, 0.1, 50.0))
    assert 0.0 < sim.robot("rover").readings["asks"].true[0] < 50.0
