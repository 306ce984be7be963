"""Errors reach another process as they were raised: with text, class, and all that they carry."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import pytest

import amorsim as am
from amorsim.core.errors import DocumentError, Fault, ScenarioError
from amorsim.core.parameters import ParameterError
from amorsim.simulation.estimation.feeding import FeedingError
from amorsim.testing.failure import CheckError

FAULT = Fault(file="a.toml", path="robots.0.pose", message="expected a table, got 3", line=4, value=3)
ERRORS: list[Exception] = [
    am.MapError("no map"),
    ParameterError("radius", "expected a number, got 'x'"),
    DocumentError("there is nothing", "robots.0"),
    DocumentError("there is nothing"),
    am.ControllerError("it raised", robot="rover"),
    ScenarioError([FAULT, FAULT], ["the map is small"]),
    FeedingError("a", "b"),
    CheckError("estimator Ekf", "shapes", "expected (N, 3)"),
]


@pytest.mark.parametrize("again", [lambda error: pickle.loads(pickle.dumps(error)), copy.copy, copy.deepcopy])
@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
def test_an_error_is_the_same_elsewhere(error: Exception, again: Callable[[Any], Any]) -> None:
    error.__dict__.setdefault("__notes__", ["and a note"])
    other = again(error)
    assert (type(other), str(other), vars(other)) == (type(error), str(error), vars(error))


def test_an_error_of_the_wild_is_the_same_elsewhere() -> None:
    for make in (lambda: am.load("nosuch"), lambda: am.Simulation(3), lambda: am.load("demo", ["a=1", "b=2"])):
        with pytest.raises(am.AmorsimError) as caught:
            make()  # type: ignore[no-untyped-call]
        assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)
