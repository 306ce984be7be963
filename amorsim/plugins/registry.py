"""The registry: the names of components, robots and scenarios, and the plugins that registered them."""

from __future__ import annotations

import contextlib
import importlib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import attrs

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
from amorsim.core.arguments import checked
from amorsim.core.error_text import RAISED
from amorsim.core.errors import PluginError, did_you_mean
from amorsim.core.files.reading import is_file
from amorsim.core.unknown_names import no_such
from amorsim.plugins.checks import check_class, check_name

__all__ = ["KINDS", "Entry", "Plugin", "Registry"]

KINDS: Mapping[str, type] = {
    "drive": Drive,
    "sensor": Sensor,
    "noise": Noise,
    "map_loader": MapLoader,
    "scenario_loader": ScenarioLoader,
    "world_generator": WorldGenerator,
    "motion": Motion,
    "estimator": Estimator,
    "controller": Controller,
    "planner": Planner,
    "recorder": Recorder,
    "metric": Metric,
    "task": Task,
}
"""The kinds of component, and the contract of each."""

_FILES = ("robot", "device", "scenario")


@attrs.frozen(kw_only=True)
class Plugin:
    """The origin of a registered thing: a plugin, and its distribution."""

    name: str
    distribution: str = ""
    version: str = ""

    def __str__(self) -> str:
        if not self.distribution:
            return f"plugin {self.name!r}"
        return f"plugin {self.name!r} ({self.distribution} {self.version})"


# The origin of calls outside a plugin's hook: a script or a notebook.
_SCRIPT = Plugin(name="script")


@attrs.frozen(kw_only=True)
class Entry:
    """A registered thing: `target` is a class, ``"module:Class"``, or the file of a robot or scenario."""

    kind: str
    name: str
    target: type | str | Path
    plugin: Plugin

    def __str__(self) -> str:
        return f"{self.plugin}, {self.kind.replace('_', ' ')} {self.name!r}"

    @property
    def reference(self) -> str:
        """The class as ``"module:Class"``, or the path of the file."""
        if isinstance(self.target, type):
            return f"{self.target.__module__}:{self.target.__qualname__}"
        return str(self.target)


class Registry:
    """Everything that can be named in a scenario.

    A plugin's hook gets the registry. It calls the method of a kind with a name and a class, or with
    ``"module:Class"``, which is imported at its first use. A class is checked against its contract once: when it
    is registered, or when it is imported. A class that fails is left out. A plugin's failures are collected in
    `problems`; a script that calls the methods itself gets the `PluginError`.
    """

    def __init__(self) -> None:
        self._entries: dict[tuple[str, str], Entry] = {}
        self._names: dict[str, tuple[str, ...]] = {}  # sorted, by kind
        self._classes: dict[tuple[str, str], type] = {}
        self._problems: list[str] = []
        self._plugins: list[Plugin] = []
        self._current: Plugin | None = None
        self.run_hooks: tuple[tuple[Plugin, Mapping[str, Callable[..., Any]]], ...] = ()

    # ------------------------------------------------------------------------------------------ registering

    def drive(self, name: str, cls: type[Drive] | str) -> None:
        """Register a drive."""
        self._add("drive", name, cls)

    def sensor(self, name: str, cls: type[Sensor] | str) -> None:
        """Register a sensor."""
        self._add("sensor", name, cls)

    def noise(self, name: str, cls: type[Noise] | str) -> None:
        """Register an element of noise chains."""
        self._add("noise", name, cls)

    def map_loader(self, name: str, cls: type[MapLoader] | str) -> None:
        """Register a reader of map files."""
        self._add("map_loader", name, cls)

    def scenario_loader(self, name: str, cls: type[ScenarioLoader] | str) -> None:
        """Register a reader of other programs' scenarios."""
        self._add("scenario_loader", name, cls)

    def world_generator(self, name: str, cls: type[WorldGenerator] | str) -> None:
        """Register a generator of worlds."""
        self._add("world_generator", name, cls)

    def motion(self, name: str, cls: type[Motion] | str) -> None:
        """Register a motion of obstacles."""
        self._add("motion", name, cls)

    def estimator(self, name: str, cls: type[Estimator] | str) -> None:
        """Register an estimator."""
        self._add("estimator", name, cls)

    def controller(self, name: str, cls: type[Controller] | str) -> None:
        """Register a controller."""
        self._add("controller", name, cls)

    def planner(self, name: str, cls: type[Planner] | str) -> None:
        """Register a planner."""
        self._add("planner", name, cls)

    def recorder(self, name: str, cls: type[Recorder] | str) -> None:
        """Register a recorder."""
        self._add("recorder", name, cls)

    def metric(self, name: str, cls: type[Metric] | str) -> None:
        """Register a metric."""
        self._add("metric", name, cls)

    def task(self, name: str, cls: type[Task] | str) -> None:
        """Register a task for learners."""
        self._add("task", name, cls)

    @checked
    def robot(self, name: str, path: str | Path) -> None:
        """Register a robot: the path of its model, a TOML file."""
        self._add("robot", name, Path(path))

    @checked
    def device(self, name: str, path: str | Path) -> None:
        """Register a device, a sensor with its figures and its noise: the path of its TOML file."""
        self._add("device", name, Path(path))

    @checked
    def scenario(self, name: str, path: str | Path) -> None:
        """Register a scenario that can be run by name: the path of its TOML file."""
        self._add("scenario", name, Path(path))

    @contextlib.contextmanager
    def registering(self, plugin: Plugin) -> Iterator[None]:
        """A block in which registrations belong to this plugin, and failures are problems instead of errors."""
        self._plugins.append(plugin)
        self._current = plugin
        try:
            yield
        finally:
            self._current = None

    def report(self, problem: str) -> None:
        """Add to the problems, each of them once."""
        if problem not in self._problems:
            self._problems.append(problem)

    # ----------------------------------------------------------------------------------------------- asking

    @property
    def problems(self) -> tuple[str, ...]:
        """The problems with plugins so far, a sentence or two each."""
        return tuple(self._problems)

    @property
    def plugins(self) -> tuple[Plugin, ...]:
        """The plugins that were loaded, in order."""
        return tuple(self._plugins)

    @checked
    def entries(self, kind: str | None = None) -> tuple[Entry, ...]:
        """The registered entries, of one kind or of all, in the order of registration."""
        return tuple(entry for entry in self._entries.values() if kind in (None, entry.kind))

    @checked
    def names(self, kind: str) -> tuple[str, ...]:
        """The names of a kind, sorted."""
        if kind not in self._names:
            self._names[kind] = tuple(sorted(name for of, name in self._entries if of == kind))
        return self._names[kind]

    @checked
    def entry(self, kind: str, name: str) -> Entry:
        """The entry registered under a name.

        Raises
        ------
        PluginError
            If there is none; the message lists the known names.
        """
        found = self._entries.get((kind, name))
        if found is None:
            raise PluginError(no_such(kind.replace("_", " "), name, self.names(kind)))
        return found

    @checked
    def get(self, kind: str, name: str) -> type[Any]:
        """The class of a component, imported and checked.

        Raises
        ------
        PluginError
            If the name is unknown, or if its class cannot be imported or breaks its contract.
        """
        key = (kind, name)
        if key not in self._classes:
            entry = self.entry(kind, name)
            cls = entry.target if isinstance(entry.target, type) else _import(entry)
            self._check(entry, cls)
            self._classes[key] = cls
        return self._classes[key]

    @checked
    def file(self, kind: str, name: str) -> Path:
        """The file of a registered robot or scenario; errors as for `entry`."""
        return Path(str(self.entry(kind, name).target))

    @checked
    def name_of(self, kind: str, cls: type) -> str | None:
        """The name that a class is registered under, or None."""
        reference = f"{cls.__module__}:{cls.__qualname__}"
        for entry in self.entries(kind):
            if entry.target is cls or self._classes.get((kind, entry.name)) is cls:
                return entry.name
            if entry.target == reference and self.get(kind, entry.name) is cls:
                return entry.name
        return None

    @checked
    def component_of(self, cls: type) -> tuple[str, str] | None:
        """The kind and the name that a component's class is registered under; None if it is not registered."""
        for kind, contract in KINDS.items():
            name = self.name_of(kind, cls) if issubclass(cls, contract) else None
            if name is not None:
                return kind, name
        return None

    # ---------------------------------------------------------------------------------------------- within

    def _add(self, kind: str, name: str, target: type | str | Path) -> None:
        entry = Entry(kind=kind, name=name, target=target, plugin=self._current or _SCRIPT)
        try:
            self._check_new(entry)
        except PluginError as error:
            if self._current is None:
                raise
            self.report(f"{error} It was left out.")
            return
        self._entries[kind, name] = entry
        self._names.pop(kind, None)
        if isinstance(target, type):
            self._classes[kind, name] = target

    def _check_new(self, entry: Entry) -> None:
        problem = check_name(entry.name)
        if problem:
            raise PluginError(f"{entry}: {problem}.")
        other = self._entries.get((entry.kind, entry.name))
        if other is not None:
            raise PluginError(
                f"{entry}: the name is taken by {other.plugin} ({other.reference}); names must differ, "
                f"so give {entry.reference} another one."
            )
        if entry.kind in _FILES:
            if not is_file(str(entry.target)):
                raise PluginError(f"{entry}: expected a TOML file, but there is none at {entry.target}.")
        elif isinstance(entry.target, type):
            self._check(entry, entry.target)
        elif not (isinstance(entry.target, str) and entry.target.count(":") == 1):
            raise PluginError(f"{entry}: expected a class or 'module:Class', got {entry.target!r}.")

    def _check(self, entry: Entry, cls: Any) -> None:
        problems = check_class(entry.kind, KINDS[entry.kind], cls)
        if problems:
            raise PluginError(f"{entry}: {entry.reference}: {'; '.join(problems)}.")


def _import(entry: Entry) -> Any:
    module_name, _, class_name = str(entry.target).partition(":")
    try:
        module = importlib.import_module(module_name)
    except RAISED as error:
        raise PluginError(f"{entry}: {module_name!r} cannot be imported: {type(error).__name__}: {error}.") from error
    try:
        return getattr(module, class_name)
    except AttributeError:
        raise PluginError(
            f"{entry}: there is no {class_name!r} in {module_name!r}.{did_you_mean(class_name, vars(module))}"
        ) from None
