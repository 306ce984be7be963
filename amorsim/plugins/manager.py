"""Finding plugins, letting each register, and notifying them of runs; a plugin that fails is named and left out."""

from __future__ import annotations

import functools
import importlib
import importlib.metadata
import os
import types
import warnings
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import pluggy

from amorsim.core.error_text import RAISED, error_in_words
from amorsim.core.errors import PluginError, did_you_mean
from amorsim.core.version import __version__
from amorsim.plugins.hooks import GROUP, Hooks
from amorsim.plugins.registry import Plugin, Registry

__all__ = ["DISABLE", "PluginWarning", "default_registry", "make_registry", "run_finished", "run_started"]

DISABLE = "AMORSIM_DISABLE_PLUGINS"
"""Environment variable: names of plugins that are not to be loaded, with commas between, or ``all``."""

_BUILTIN = "amorsim.plugins.builtin"
_HOOKS = tuple(name for name in vars(Hooks) if name.startswith(f"{GROUP}_"))


class PluginWarning(UserWarning):
    """Something is wrong with a plugin; the named parts are left out, and the rest works."""


@functools.cache
def default_registry() -> Registry:
    """The registry of this process, with all installed plugins; it warns of their problems once."""
    registry = make_registry()
    for problem in registry.problems:
        warnings.warn(problem, PluginWarning, stacklevel=2)
    return registry


def make_registry(
    modules: Mapping[str, Any] | None = None,
    *,
    entry_points: Iterable[importlib.metadata.EntryPoint] | None = None,
    disabled: str | None = None,
) -> Registry:
    """A fresh registry; its `problems` name plugins that were left out, in whole or in part.

    Parameters
    ----------
    modules
        Further plugins by name: modules, or objects with hooks.
    entry_points
        Entry points that name plugins; by default those that installed distributions declare.
    disabled
        Names of plugins to leave out; replaces ``AMORSIM_DISABLE_PLUGINS``.
    """
    registry = Registry()
    manager = pluggy.PluginManager(GROUP)
    manager.add_hookspecs(Hooks)
    if entry_points is None:
        entry_points = importlib.metadata.entry_points(group=GROUP)
    found: list[tuple[Plugin, Callable[[], Any]]] = [
        (
            Plugin(name="builtin", distribution=GROUP, version=__version__),
            lambda: importlib.import_module(_BUILTIN),
        )
    ]
    found += [(_plugin_of(point), point.load) for point in entry_points]
    found += [(Plugin(name=name), functools.partial(_given, module)) for name, module in (modules or {}).items()]

    wanted = _wanted([plugin.name for plugin, _ in found], disabled, registry)
    loaded = [(plugin, _load(plugin, load, manager, registry)) for plugin, load in found if plugin.name in wanted]
    registry.run_hooks = tuple(
        (plugin, _hooks_of(plugin, module, manager, registry)) for plugin, module in loaded if module is not None
    )
    return registry


def run_started(simulation: Any, registry: Registry) -> None:
    """Notify all plugins that a run begins; `PluginError` names the one that raised."""
    _tell("amorsim_run_started", simulation, registry)


def run_finished(simulation: Any, registry: Registry) -> None:
    """Notify all plugins that a run has ended; `PluginError` names the one that raised."""
    _tell("amorsim_run_finished", simulation, registry)


def _tell(hook: str, simulation: Any, registry: Registry) -> None:
    failures = []
    for plugin, hooks in registry.run_hooks:
        if hook in hooks:
            try:
                hooks[hook](simulation=simulation)
            except RAISED as error:  # the other plugins are still notified
                failures.append((f"{plugin}: {hook} raised {error_in_words(error)}", error))
    if failures:
        raise PluginError("\n".join(message for message, _ in failures)) from failures[0][1]


def _given(module: Any) -> Any:
    return module


def _plugin_of(point: importlib.metadata.EntryPoint) -> Plugin:
    if point.dist is None:
        return Plugin(name=point.name)
    return Plugin(name=point.name, distribution=point.dist.name, version=point.dist.version)


def _wanted(names: list[str], disabled: str | None, registry: Registry) -> set[str]:
    text = os.environ.get(DISABLE, "") if disabled is None else disabled
    unwanted = {name.strip() for name in text.split(",")} - {""}
    if "all" in unwanted:
        return {"builtin"}
    for name in sorted(unwanted - set(names)):
        registry.report(f"{DISABLE}: there is no plugin {name!r} to leave out.{did_you_mean(name, names)}")
    return set(names) - unwanted


def _load(plugin: Plugin, load: Callable[[], Any], manager: pluggy.PluginManager, registry: Registry) -> Any:
    """The plugin's module, registered with the manager; None if that failed."""
    # A plugin is foreign code: anything that it raises, even an attempt to exit, counts as its own failure.
    try:
        module = load()
    except (Exception, SystemExit) as error:
        registry.report(
            f"{plugin} cannot be imported: {type(error).__name__}: {error}. It was left out; "
            f"{DISABLE}={plugin.name} leaves it out without a word."
        )
        return None
    try:
        manager.register(module, name=plugin.name)
    except (ValueError, pluggy.PluginValidationError) as error:
        registry.report(f"{plugin} cannot be taken in: {' '.join(str(error).split())}. It was left out.")
        return None
    return module


def _hooks_of(
    plugin: Plugin, module: Any, manager: pluggy.PluginManager, registry: Registry
) -> Mapping[str, Callable[..., Any]]:
    """The plugin's hooks by name, after it has registered its components."""
    _report_strays(plugin, module, manager, registry)
    others = [other for other in manager.get_plugins() if other is not module]
    callers = manager.get_hookcallers(module) or []
    hooks = {
        caller.name: manager.subset_hook_caller(caller.name, remove_plugins=others)
        for caller in callers
        if caller.name in _HOOKS
    }
    if "amorsim_register" in hooks:
        with registry.registering(plugin):
            try:
                hooks["amorsim_register"](registry=registry)
            except (Exception, SystemExit) as error:
                registry.report(
                    f"{plugin}: amorsim_register raised {type(error).__name__}: {error}. What it had "
                    "registered before stays; the rest was left out."
                )
    return hooks


def _report_strays(plugin: Plugin, module: Any, manager: pluggy.PluginManager, registry: Registry) -> None:
    # pluggy's own check_pending() stops at the first unknown hook of any plugin. Here each unknown hook is
    # named, and the other plugins still load.
    callers = [caller.name for caller in manager.get_hookcallers(module) or []]
    marked = set(callers)
    for name in callers:
        if name not in _HOOKS:
            registry.report(
                f"{plugin}: there is no hook {name!r}; hooks: {', '.join(_HOOKS)}.{did_you_mean(name, _HOOKS)}"
            )
    for name in dir(module):
        if not name.startswith(f"{GROUP}_") or name in marked or isinstance(getattr(module, name), types.ModuleType):
            continue
        if name in _HOOKS:
            registry.report(f"{plugin}: {name} is not marked with @amorsim.hookimpl, so it is never called.")
        elif callable(getattr(module, name)):
            registry.report(f"{plugin}: {name} is not a hook; hooks: {', '.join(_HOOKS)}.{did_you_mean(name, _HOOKS)}")
    if not marked.intersection(_HOOKS):
        registry.report(f"{plugin} has no hook, so it does nothing; hooks: {', '.join(_HOOKS)}.")
