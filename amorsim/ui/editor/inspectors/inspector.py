"""The inspector of a thing: its tables as forms where their fields are known, else as TOML."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

from amorsim.contracts import Mount
from amorsim.core.errors import PluginError
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.document import Document
from amorsim.scenario.files.models import LOOKS
from amorsim.scenario.initial_belief import InitialBelief
from amorsim.scenario.spec import Landmark, Light, MountedSensor, Obstacle, Pose, Recording, Robot, Scenario
from amorsim.scenario.toml.layout import found_at
from amorsim.ui.editor.inspectors.error_forms import deviations, fields_of, targets
from amorsim.ui.editor.inspectors.ground import described, floor
from amorsim.ui.editor.inspectors.knowing import kidnappings, knowledge
from amorsim.ui.editor.inspectors.sections import Section, toml_of
from amorsim.ui.editor.inspectors.shape_form import shape_sections
from amorsim.ui.editor.inspectors.thing_fields import ThingFields
from amorsim.ui.forms.description import FieldForm

__all__ = ["inspect"]


def inspect(document: Document, path: str, registry: Registry) -> list[Section]:
    """The sections of a thing: of a robot, its own fields, its drive, each sensor with its noise, and so on.

    Raises
    ------
    DocumentError
        If there is nothing at the path, and nothing is known of it.
    """
    return list(_Inspector(document, path, registry).sections())


class _Inspector:
    def __init__(self, document: Document, path: str, registry: Registry) -> None:
        self.registry = registry
        self.fields = ThingFields(document, path, registry)
        self.at, self.table = self.fields.at, self.fields.table

    # -------------------------------------------------------------------------------------------------------- sections

    def sections(self) -> Iterator[Section]:
        match self.at:
            case ("robots", int()):
                yield from self._robot()
            case ("obstacles", int()):
                yield from self._obstacle()
            case ("zones", int()):
                yield self.fields.section("Zone", (), self.fields.name())
                yield from shape_sections(self.fields)
                yield self.fields.section("Place", ("pose",), self.fields.form(Pose, ("pose",)))
                yield from self._chain("Ground", ("ground",), "m")
                yield from self._rest(("name", "shape", "pose", "ground"))
            case ("landmarks", int()):
                yield self.fields.section("Landmark", (), self.fields.form(Landmark, ()))
            case ("lights", int()):
                yield self.fields.section("Light", (), self.fields.form(Light, ()))
            case ("simulation",):
                yield self.fields.section("Simulation", (), self.fields.form(Scenario, (), ("dt", "duration", "seed")))
                yield described(self.fields)
            case ("floor",):
                yield from floor(self.fields)
            case ("world",):
                yield from self._world()
            case ("recording",):
                yield from self._recording()
            case ("task",):
                yield from self._component("Task", (), "task", is_optional=True)
            case _:
                yield self._as_toml(str(self.at[-1]).capitalize(), ())

    def _robot(self) -> Iterator[Section]:
        models = self.fields.choice("model", "model", self.registry.names("robot"), "the kind of robot it is made from")
        yield self.fields.section(
            "Robot", (), [*self.fields.name(), models, *self.fields.form(Robot, (), ("on_collision", *LOOKS))]
        )
        yield from self._places()
        yield from self._component("Drive", ("drive",), "drive")
        sensors = self.table.get("sensors")
        names = [name for name, one in (sensors or {}).items() if one is not False] if isinstance(sensors, dict) else []
        yield self._heading("Sensors", ("sensors",), "sensor", is_list=False)
        for name in names:
            yield from self._sensor(name)
        yield self._heading("Estimators", ("estimators",), "estimator", is_list=False)
        for name, one in (self.table.get("estimators") or {}).items():
            if one is not False:
                yield from self._component(name, ("estimators", name), "estimator", depth=1, can_go=True)
        yield from self._component("Controller", ("controller",), "controller", is_optional=True)
        yield from self._chain("Ground", ("ground",), "m")
        yield from shape_sections(self.fields)
        yield from self._errors(names)
        yield self.fields.section(
            "Initial belief", ("initial_belief",), self.fields.form(InitialBelief, ("initial_belief",))
        )
        yield from kidnappings(self.fields)
        yield from knowledge(self.fields)

    def _sensor(self, name: str) -> Iterator[Section]:
        at = ("sensors", name)
        (section,) = self._component(name, at, "sensor", depth=1, can_go=True)
        if section["use"] and section["use"]["value"]:
            timing = self.fields.form(MountedSensor, at, ("rate", "latency"))
            mount = self.fields.form(Mount, (*at, "mount"))
            for field in mount:
                field["label"] = f"mount {field['label']}"
            section["fields"] += [*mount, *timing]
        yield section
        cls = self.fields.class_at(at)
        unit = getattr(cls, "unit", "")
        yield from self._chain(f"Noise of {name}", (*at, "noise"), unit if isinstance(unit, str) else "", depth=1)

    def _chain(self, title: str, at: tuple[str, ...], unit: str, depth: int = 0) -> Iterator[Section]:
        yield self._heading(title, at, "noise", is_list=True, depth=depth)
        chain = found_at(self.table, at)
        for number, element in enumerate(chain if isinstance(chain, list) else []):
            name = element.get("name", element.get("use", "?")) if isinstance(element, dict) else "?"
            yield from self._component(
                str(name), (*at, number), "noise", depth=depth + 1, can_go=True, unit=unit, beside=("name", "column")
            )

    def _errors(self, sensors: list[str]) -> Iterator[Section]:
        known = targets(
            self.fields.class_at(("drive",)), {name: self.fields.class_at(("sensors", name)) for name in sensors}
        )
        written = list(deviations(self.table.get("errors")))
        section = self._as_toml("Errors", ("errors",))
        choices = [".".join(path) for path in known if path not in dict(written)]
        section["adding"] = [
            {
                "label": "add an error",
                "path": self.fields.path_of(("errors",)),
                "kind": "error",
                "choices": choices,
                "is_list": False,
            }
        ]
        yield section
        for path, value in written:
            at = ("errors", *path)
            unit = known[path].unit if path in known else ""
            section = self.fields.section(".".join(path), at, fields_of(value, self.fields.path_of(at), unit))
            for field in section["fields"]:
                self.fields.mark(field, tuple(field["path"].split(".")[len(self.at) :]))
            section["depth"] = 1
            section["can_go"] = True
            yield section

    def _recording(self) -> Iterator[Section]:
        yield self.fields.section("Recording", (), self.fields.form(Recording, (), ("sensors", "picture")))
        yield self._heading("Other recorders", ("also",), "recorder", is_list=True)
        also = self.table.get("also")
        for number, one in enumerate(also if isinstance(also, list) else []):
            name = one.get("use", "?") if isinstance(one, dict) else "?"
            yield from self._component(str(name), ("also", number), "recorder", depth=1, can_go=True)

    def _obstacle(self) -> Iterator[Section]:
        yield self.fields.section("Obstacle", (), [*self.fields.name(), *self.fields.form(Obstacle, (), LOOKS)])
        yield from self._places()
        yield from shape_sections(self.fields)
        yield from self._component("Motion", ("motion",), "motion", is_optional=True)

    def _places(self) -> Iterator[Section]:
        if "start" in self.table or "count" in self.table:
            yield self._series()
        else:
            yield self.fields.section("Place", ("pose",), self.fields.form(Pose, ("pose",)))

    def _series(self) -> Section:
        """How many there are, and where they start."""
        start = self.table.get("start")
        cls = self.fields.class_at(("start",)) if isinstance(start, dict) and "poses" not in start else None
        fields = [] if cls is None else self.fields.form(cls, ("start",))
        if "count" in self.table:
            count = self.fields.number(("count",), "how many", "", self.table["count"])
            count["widget"]["is_whole"] = True
            fields.insert(0, count)
        section = self.fields.section("Start of all of them", ("start",), fields)
        section["toml"] = None if cls is not None else toml_of(start) if isinstance(start, dict) else ""
        return section

    def _generated(self, made: dict[str, Any]) -> Iterator[Section]:
        cls = self.fields.class_at(("map",))
        name = made.get("generate")
        section = self.fields.section("World", ("map",), [])
        section["use"] = {
            "kind": "world_generator",
            "value": name if isinstance(name, str) else "",
            "choices": list(self.registry.names("world_generator")),
            "is_optional": False,
        }
        seed = self.fields.number(("map", "seed"), "seed", "", made.get("seed", 0))
        seed["help"] = "another number is another world"
        seed["widget"] |= {"is_whole": True, "is_open": [False, True]}
        section["fields"] = [seed, *([] if cls is None else self.fields.form(cls, ("map",)))]
        section["toml"] = toml_of(made) if cls is None else None
        yield section

    def _world(self) -> Iterator[Section]:
        made = self.table.get("map")
        if isinstance(made, dict):
            yield from self._generated(made)
            return
        cls = self.fields.class_at(())
        map_ = self.fields.text("map", "map", "the file of the map, from the scenario's folder", "file")
        fields = [map_] if cls is None else [map_, *self.fields.form(cls, ())]
        yield self.fields.section("World", (), fields)

    # ------------------------------------------------------------------------------------------------ kinds of section

    def _component(
        self,
        title: str,
        at: tuple[str | int, ...],
        kind: str,
        *,
        depth: int = 0,
        can_go: bool = False,
        is_optional: bool = False,
        unit: str = "",
        beside: tuple[str, ...] = (),
    ) -> Iterator[Section]:
        """A table with ``use``, and the form of its component; TOML if the component is not known."""
        table = found_at(self.table, at)
        cls = self.fields.class_at(at)
        use = table.get("use") if isinstance(table, dict) else None
        fields: list[FieldForm] = []
        toml = None
        if cls is not None:
            fields = self.fields.form(cls, at, unit=unit)
        elif isinstance(table, dict):
            toml = toml_of(self.fields.own(at))
        choices = list(self.registry.names(kind))
        value = use if isinstance(use, str) else ""
        section = self.fields.section(title, at, fields)
        section["use"] = {"kind": kind, "value": value, "choices": choices, "is_optional": is_optional}
        section["toml"] = toml
        section["depth"] = depth
        section["can_go"] = can_go
        for key in beside:
            if isinstance(table, dict) and key in table:
                fields.insert(0, self.fields.text((*at, key), key, "", "text"))
        yield section

    def _heading(self, title: str, at: tuple[str, ...], kind: str, *, is_list: bool, depth: int = 0) -> Section:
        section = self.fields.section(title, at, [])
        section["depth"] = depth
        names = self._noises(at) if kind == "noise" else list(self.registry.names(kind))
        section["adding"] = [
            {
                "label": f"add to {title}",
                "path": self.fields.path_of(at),
                "kind": kind,
                "choices": names,
                "is_list": is_list,
            }
        ]
        return section

    def _noises(self, at: tuple[str, ...]) -> list[str]:
        """The noises that a chain can have; in the ground's chain its own come first, which suit no sensor."""
        own: list[str] = []
        others: list[str] = []
        for name in self.registry.names("noise"):
            with contextlib.suppress(PluginError):
                (own if self.registry.get("noise", name).for_ground else others).append(name)
        return own + others if at[-1] == "ground" else others

    def _as_toml(self, title: str, at: tuple[str, ...]) -> Section:
        section = self.fields.section(title, at, [])
        table = found_at(self.table, at) if at else self.table
        section["toml"] = toml_of(table) if isinstance(table, dict) else ""
        return section

    def _rest(self, known: tuple[str, ...]) -> Iterator[Section]:
        if set(self.table) - set(known):
            yield self._as_toml("All of it", ())
