"""Components in documents: a table with ``use = NAME`` and the fields of the component of that name."""

from __future__ import annotations

from typing import Any

import attrs

from amorsim.contracts import Drive, Estimator, Motion, Mount, Sensor, Task
from amorsim.core.errors import PluginError
from amorsim.core.parameters import ParameterError
from amorsim.plugins.registry import KINDS, Registry
from amorsim.scenario.programs.user_components import USER_CODE, program_in, read_program_in
from amorsim.scenario.reading.columns import column_problem, columns_problem, not_for_sensors
from amorsim.scenario.reading.faults import Node
from amorsim.scenario.reading.fields import file_fields, read_component, read_fields
from amorsim.scenario.spec import MountedSensor, NoiseElement, Recording

__all__ = [
    "read_chain",
    "read_controller",
    "read_drive",
    "read_estimator",
    "read_motion",
    "read_recording",
    "read_sensor",
    "read_task",
]

_SENSOR_KEYS = ("use", "mount", "rate", "latency", "noise")


def read_drive(node: Node, registry: Registry) -> Drive | None:
    """The drive in a table."""
    return _read(node, "drive", registry, ("use",))  # type: ignore[no-any-return]


def read_estimator(node: Node, registry: Registry) -> Estimator | None:
    """The estimator in a table: a registered one, or ``use = "file.py:name"`` with its own options."""
    return _read(node, "estimator", registry, ("use",))  # type: ignore[no-any-return]


def read_motion(node: Node, registry: Registry) -> Motion | None:
    """The motion in a table: a registered one, or ``use = "file.py:name"`` with its own options."""
    return _read(node, "motion", registry, ("use",))  # type: ignore[no-any-return]


def read_sensor(node: Node, registry: Registry) -> MountedSensor | None:
    """The sensor in a table, with its mount, rate, latency and noise in addition to its own fields."""
    before = node.book.count
    sensor: Sensor | None = _read(node, "sensor", registry, _SENSOR_KEYS)
    if not node.is_table:
        return None
    if sensor is not None and (problem := columns_problem(sensor)):
        node.fault(problem)
        sensor = None
    values = read_fields(node, file_fields(MountedSensor, names=("rate", "latency")))
    if "mount" in node:
        values["mount"] = read_component(Mount, node.child("mount"))
    if "noise" in node:
        # Without the sensor it is not known how fields of noise are spelt; other faults can be reported.
        unit = None if sensor is None else sensor.unit
        values["noise"] = read_chain(node.child("noise"), registry, unit, sensor)
    if sensor is None or node.book.count > before:
        return None
    return MountedSensor(sensor=sensor, **values)


def read_chain(
    node: Node, registry: Registry, unit: str | None, sensor: Sensor | None = None
) -> tuple[NoiseElement, ...]:
    """The elements of a noise chain in a list of tables; `unit` is that of the values, None if not known.

    Where a `sensor` has columns, an element's ``column`` names the one that it is for, which gives its unit.

    An element without a name is called after its ``use``, the second of a kind ``<use>_2`` and so on.
    """
    if not node.expect_list("a list of tables, as in [{ use = 'gaussian', std = 0.01 }]"):
        return ()
    given = [item.value.get("name") if item.is_table else None for item in node.items()]
    taken: set[str] = set()
    elements = []
    for item, name in zip(node.items(), given, strict=True):
        if not item.is_table:
            item.expect_table("a table, as in { use = 'gaussian', std = 0.01 }")
            continue
        if name is None:
            name = _free_name(str(item.value.get("use")), taken, given)
        elif isinstance(name, str) and name in taken:
            item.child("name").fault(f"another element of the chain is called {name!r}; names must differ")
        if isinstance(name, str):
            taken.add(name)
        if unit is None:
            _class(item, "noise", registry)
            continue
        column = _column(item, registry, sensor)
        its_unit = unit if not column or sensor is None else sensor.columns().get(column, unit)
        noise = _read(item, "noise", registry, ("use", "name", "column"), its_unit)
        try:
            # A name is looked at even where the rest of the element is at fault.
            element = NoiseElement(name=name, noise=noise, column=column)
        except ParameterError as error:
            item.child("name").fault(error.problem)
        else:
            if noise is not None:
                elements.append(element)
    return tuple(elements)


def _column(item: Node, registry: Registry, sensor: Sensor | None) -> str:
    """The column that an element is for, empty for all; a fault where the sensor has none of that name."""
    child = item.child("column")
    column = child.text("the name of a column", default="") or ""
    use = item.value.get("use")
    if sensor is not None and isinstance(use, str) and use in registry.names("noise"):
        noise = registry.get("noise", use)
        problem = column_problem(sensor, noise, column)
        if noise.for_ground:
            item.child("use").fault(not_for_sensors(noise))
        elif problem:
            child.fault(problem)
    elif column and sensor is None:
        child.fault("this chain has no columns")
    return column


def _free_name(use: str, taken: set[str], given: list[Any]) -> str:
    name, number = use, 1
    while name in taken or name in given:
        number += 1
        name = f"{use}_{number}"
    return name


def read_controller(node: Node, registry: Registry) -> Any:
    """The controller in a table: a registered one, or ``use = "file.py:name"`` with its own options."""
    return _read(node, "controller", registry, ("use",))


def read_recording(node: Node, registry: Registry) -> Recording | None:
    """The recording of a run: the fields of `Recording`, and under ``also`` a list of tables, a recorder each."""
    recording: Recording | None = read_component(Recording, node, beside=("also",))
    if not isinstance(node.value, dict) or "also" not in node:
        return recording
    also = node.child("also")
    if not also.expect_list("a list of tables, as in [{ use = 'NAME' }]"):
        return None
    recorders = [_read(item, "recorder", registry, ("use",)) for item in also.items()]
    if recording is None:
        return None
    return attrs.evolve(recording, also=[recorder for recorder in recorders if recorder is not None])


def read_task(node: Node, registry: Registry) -> Task | None:
    """The task of a learner: a table whose ``use`` names it."""
    task: Task | None = _read(node, "task", registry, ("use",))
    return task


def _class(node: Node, kind: str, registry: Registry) -> type[Any] | None:
    """The class of the component that ``use`` of a table names."""
    if not node.expect_table(f"a table with use = one of: {', '.join(registry.names(kind)) or 'none'}"):
        return None
    use = node.child("use")
    if use.value is None:
        known = ", ".join(registry.names(kind)) or "none"
        use.fault(f"missing; expected the name of a {kind}: {known}")
        return None
    name = use.text(f"the name of a {kind}")
    if name is None:
        return None
    try:
        return registry.get(kind, name)
    except PluginError as error:
        use.fault(str(error))
        return None


def _read(node: Node, kind: str, registry: Registry, beside: tuple[str, ...], sensor_unit: str = "") -> Any:
    assert kind in KINDS
    if kind in USER_CODE and program_in(node):
        return read_program_in(node, kind)
    cls = _class(node, kind, registry)
    return None if cls is None else read_component(cls, node, sensor_unit=sensor_unit, beside=beside)
