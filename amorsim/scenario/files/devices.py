"""Devices for scripts: sensors with the figures of real ones, from files."""

from __future__ import annotations

from pathlib import Path

from amorsim.core.arguments import checked
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry
from amorsim.scenario.files.models import read_layers
from amorsim.scenario.reading.components import read_sensor
from amorsim.scenario.reading.faults import Node
from amorsim.scenario.spec import MountedSensor

__all__ = ["load_device"]


@checked
def load_device(source: str | Path, *, registry: Registry | None = None) -> MountedSensor:
    """A sensor with the figures and the noise of a device: its registered name, or the path of its ``.toml`` file.

    What differs on a robot is changed as of any other: ``attrs.evolve(am.load_device("tcm2"), mount=...)``.

    Raises
    ------
    ScenarioError
        With all the faults that were found.
    """
    registry = registry or default_registry()
    book, values = read_layers(str(source), "device", registry)
    book.raise_if_any()
    assert values is not None
    sensor = read_sensor(Node(values, (), book), registry)
    book.raise_if_any()
    assert sensor is not None
    return sensor
