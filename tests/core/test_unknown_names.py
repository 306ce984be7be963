"""Messages for unknown names: what is unknown, what is known, and what may have been meant."""

from __future__ import annotations

import pytest

from amorsim.core.errors import Fault
from amorsim.core.unknown_names import no_such, unknown_key


@pytest.mark.parametrize(
    ("message", "says"),
    [
        (no_such("robot", "rovr", ["rover"]), "no robot 'rovr'; did you mean 'rover'?"),
        (no_such("robot", "x", ["rover", "scout"]), "no robot 'x'; known robots: rover, scout."),
        (
            no_such("robot", "rovr", ["rover", "scout"]),
            "no robot 'rovr'; known robots: rover, scout. Did you mean 'rover'?",
        ),
        (no_such("sensor", "lidar", [], whose="the robot"), "the robot has no sensor 'lidar'; known sensors: none."),
        (no_such("replica", 7, [0, 4]), "no replica 7; known replicas: 0, 4."),
        (no_such("quantity", None, ["age"]), "no quantity None; known quantities: age."),
        (no_such("axis", "track", ["speed"]), "no axis 'track'; known axes: speed."),
        (
            no_such("estimator of beliefs", "a", ["ekf"]),
            "no estimator of beliefs 'a'; known estimators of beliefs: ekf.",
        ),
        (unknown_key("sped", ["use", "speed"]), "unknown key; known keys: use, speed. Did you mean 'speed'?"),
    ],
)
def test_the_words(message: str, says: str) -> None:
    assert message == says


def test_a_thousand_names_are_counted() -> None:
    message = no_such("robot", "x", [f"r{i:03d}" for i in range(1000)])
    assert message.endswith("r049 ... (1000 in all).")


@pytest.mark.parametrize(
    ("message", "remedy"),
    [
        (no_such("robot", "rovr", ["rover"]), "Did you mean 'rover'?"),
        (unknown_key("x", ["use", "speed"]), "known keys: use, speed"),
    ],
)
def test_a_fault_offers_them_as_its_remedy(message: str, remedy: str) -> None:
    assert Fault(file="", path="", message=message).remedy == remedy
