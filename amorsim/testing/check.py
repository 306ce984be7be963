"""The check of a component against its contract, for plugin authors and for our own registry."""

from __future__ import annotations

import functools
import pickle
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from amorsim.contracts import (
    Controller,
    Drive,
    Estimator,
    MapLoader,
    Metric,
    Motion,
    Noise,
    Planner,
    Recorder,
    ScenarioLoader,
    Sensor,
    Task,
    WorldGenerator,
)
from amorsim.core.error_text import RAISED, error_in_words
from amorsim.core.errors import ComponentError
from amorsim.core.parameters import describe
from amorsim.core.rows import stack
from amorsim.plugins.checks import check_class
from amorsim.scenario.named_places import first_place, goals_of
from amorsim.scenario.spec import Scenario
from amorsim.testing.bound import check_bound
from amorsim.testing.drive import DriveTrial
from amorsim.testing.failure import Who
from amorsim.testing.kinds import ControllerTrial, EstimatorTrial, MotionTrial, NoiseTrial, SensorTrial
from amorsim.testing.map_loaders import check_map_loader
from amorsim.testing.metrics import check_metric
from amorsim.testing.planners import check_planner
from amorsim.testing.recorders import check_recorder
from amorsim.testing.rig import ROWS, Rig
from amorsim.testing.scenario_loaders import check_scenario_loader
from amorsim.testing.tasks import check_task
from amorsim.testing.trial import Record, Trial, try_rows
from amorsim.testing.variants import example, variants
from amorsim.testing.world_generators import check_world_generator

__all__ = ["check_component"]

_KINDS: dict[str, type] = {
    "drive": Drive,
    "sensor": Sensor,
    "noise": Noise,
    "estimator": Estimator,
    "controller": Controller,
    "motion": Motion,
    "planner": Planner,
    "map_loader": MapLoader,
    "scenario_loader": ScenarioLoader,
    "world_generator": WorldGenerator,
    "recorder": Recorder,
    "metric": Metric,
    "task": Task,
}

# Units that are not the International System's, or that files alone spell.
_NOT_SI = {"deg", "degree", "degrees", "°", "mm", "cm", "km", "inch", "in", "ft", "ms", "us", "min", "h", "rpm", "kHz"}


def check_component(
    component: Any,
    *,
    drive: Drive | None = None,
    sensors: Mapping[str, Sensor] | None = None,
    values_of: str | None = None,
    side: Mapping[str, float] | None = None,
    inf: str = "kept",
    path: str | Path | None = None,
    scene: Scenario | None = None,
) -> None:
    """Try whether a component keeps its contract.

    It is run in a small world for a few steps as 64 rows with slightly different parameters: shapes, types, units;
    the same bits a second time, for each row alone, for as many rows as there are values, and when going on from a
    copy of its state in the middle; nothing kept on itself, nothing written into what it was given or has given; it
    can be pickled. Each kind is also asked for what it promises beyond that: see `amorsim.contracts`.

    Parameters
    ----------
    component
        A drive, sensor, noise element, estimator, controller, planner, motion, map loader, scenario loader, world
        generator, recorder, metric or task; or its class: one is made with its defaults, and with some value where
        it has none.
    drive
        Drive on which a sensor, estimator or controller is tried; a differential drive by default.
    sensors
        Further sensors, by name, for an estimator or controller. There are an ``encoder``, a ``laser``, a ``sonar``,
        a ``compass`` and a ``gyro``.
    values_of
        The name of the sensor whose values a noise element gets; without it, numbers of no meaning, 5 a row.
    side
        What a noise element looks for in `side`, by name, with a value for it.
    inf
        What a noise element does with inf, which means that nothing returned: ``"kept"``; ``"changed"`` for one that
        makes up returns; ``"absent"`` for one whose values are never inf, such as the travel of a wheel.
    path
        A file that a map loader or a scenario loader is to read.
    scene
        Where a sensor, estimator, controller, motion or task is tried, in place of a hall with a post, a box, marks and
        lamps, for a task also with a line on the floor and somebody called ``leader`` who walks: the map, obstacles,
        landmarks and lights of a scenario. Its robots set where those that are tried start, and drive about by some
        centimetres a step.

    Warns
    -----
    UserWarning
        If a sensor's reading never changed in any trial, or a generator gave one world for several seeds: the check
        then proves nothing about the reading, or the draws.

    Raises
    ------
    ComponentError
        If the component fails a check; it names the component, the check, what was expected and what was found.
    """
    cls = component if isinstance(component, type) else type(component)
    who = _who(cls)
    _check_class(who, cls)
    if isinstance(component, type):
        component = example(component)
    if isinstance(component, Recorder):  # it has files open, so it is neither pickled nor put in rows
        check_recorder(who, component)
        return
    _check_pickling(who, component)
    if isinstance(component, MapLoader):
        check_map_loader(who, component, None if path is None else Path(path))
        return
    if isinstance(component, ScenarioLoader):
        check_scenario_loader(who, component, None if path is None else Path(path))
        return
    if isinstance(component, Planner):
        check_planner(who, component)
        return
    if isinstance(component, Metric):
        check_metric(who, component)
        return
    if isinstance(component, WorldGenerator):
        check_world_generator(who, component)
        return
    if isinstance(component, Task):
        check_task(who, component, scene)
        return
    kin = variants(component, ROWS)
    if isinstance(component, Drive):
        trial = DriveTrial(who, _plain_rig(), component, kin)
        try_rows(trial, kin)
        check_bound(who, trial.rig, kin)
        trial.check_paths(kin)
        trial.check_jacobian(kin)
        trial.check_inverse(kin)
        return
    is_plain = drive is None and sensors is None and scene is None
    rig = _plain_rig() if is_plain else Rig(drive, sensors, scene)
    others: Trial[Any]
    if isinstance(component, Sensor):
        others = SensorTrial(who, rig, component, kin)
        _check_unit(who, "unit", "unit", component.unit)
        for name, unit in component.columns().items():
            _check_unit(who, "columns", f"the unit of column {name!r}", unit)
    elif isinstance(component, Noise):
        others = NoiseTrial(who, rig, side or {}, values_of, inf)
    elif isinstance(component, Estimator):
        others = EstimatorTrial(who, rig, component)
    elif isinstance(component, Controller):
        others = ControllerTrial(who, rig)
    else:
        others = MotionTrial(who, rig)
    if isinstance(component, (Controller, Motion)):
        _check_places(who, component)
    record = try_rows(others, kin)
    fire = others.fire if isinstance(others, SensorTrial) and component.medium else None
    check_bound(who, rig, kin, others.size, fire)
    if isinstance(component, Sensor):
        _check_change(who, record)


def _check_places(who: Who, component: Controller | Motion) -> None:
    """Check that the places where a body starts, and to which it goes, are places."""
    try:
        if isinstance(component, Motion):
            first_place(component)
        goals_of(component)
    except ComponentError as error:
        who.fail("places", str(error).replace(", got ", ", found ", 1))


def _check_change(who: Who, record: Record) -> None:
    """Warn of a sensor whose reading never changed: no trial can then show that it reads the right quantity."""
    values = [outputs["values"] for outputs in record.outputs]
    if all(array.tobytes() == values[0].tobytes() for array in values):
        warnings.warn(
            f"{who}: its reading never changed in the trials ({values[0].ravel()[:3].tolist()} from first to last), so "
            "nothing was proven of what it reads; give check_component a scene in which it changes",
            stacklevel=3,
        )


@functools.cache
def _plain_rig() -> Rig:
    return Rig()


def _who(cls: type) -> Who:
    for kind, contract in _KINDS.items():
        if issubclass(cls, contract):
            return Who(kind, cls)
    known = ", ".join(contract.__name__ for contract in _KINDS.values())
    raise ComponentError(f"{cls.__name__} cannot be checked: expected a subclass of one of {known}")


def _check_class(who: Who, cls: type) -> None:
    contract = _KINDS[who.kind]
    problems = check_class(who.kind, contract, cls)
    if problems:
        who.fail("class", "; ".join(problems))
    _check_fields(who, cls, "")


def _check_fields(who: Who, cls: type, within: str) -> None:
    for name, parameter in describe(cls).items():
        where = f"field {within + name!r}"
        who.require(parameter.help.strip(), "fields", where, "a line of help", "none")
        _check_unit(who, "fields", where, parameter.unit)
        for kind in (parameter.type, *getattr(parameter.type, "__args__", ())):
            if isinstance(kind, type) and attrs.has(kind):
                _check_fields(who, kind, f"{within}{name}.")


def _check_unit(who: Who, check: str, where: str, unit: str) -> None:
    words = unit.replace("^", " ").replace("/", " ").replace("*", " ").split()
    wrong = [word for word in words if word in _NOT_SI]
    who.require(not wrong, check, where, "an SI unit, angles in rad", repr(unit))


def _check_pickling(who: Who, component: Any) -> None:
    for what, thing in (("one row", component), ("rows", stack([component, component]))):
        try:
            again = pickle.loads(pickle.dumps(thing))
        except RAISED as error:
            who.fail("pickling", f"{what}: expected it to be pickled, found {error_in_words(error)}")
        for field in attrs.fields(type(component)):
            if field.init:
                same = _same(getattr(thing, field.name), getattr(again, field.name))
                who.require(same, "pickling", f"field {field.name!r} of {what}", "the same value again", "another")


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and a.tobytes() == b.tobytes() and a.shape == b.shape
    if attrs.has(type(a)):
        return type(a) is type(b) and all(
            _same(getattr(a, field.name), getattr(b, field.name)) for field in attrs.fields(type(a))
        )
    return bool(a == b)
