"""Finding plugins: one that fails is named with distribution and version, and all the others work."""

import importlib.metadata
import types
import warnings

import attrs
import pytest

from amorsim.contracts import Noise
from amorsim.core.errors import PluginError
from amorsim.plugins import manager
from amorsim.plugins.hooks import hookimpl
from amorsim.plugins.manager import PluginWarning, default_registry, make_registry, run_finished, run_started


@attrs.frozen(kw_only=True)
class Doubled(Noise):
    def corrupt(self, values, side, elapsed, state, draws):
        return values * 2.0


def plugin(**hooks):
    module = types.ModuleType("a_plugin")
    for name, function in hooks.items():
        setattr(module, name, function)
    return module


def registering(name="doubled", cls=Doubled):
    @hookimpl
    def amorsim_register(registry):
        registry.noise(name, cls)

    return plugin(amorsim_register=amorsim_register)


def made(**modules):
    return make_registry(modules, entry_points=(), disabled="")


GOOD = registering()


def test_a_plugin_registers_beside_the_builtins():
    registry = made(good=GOOD)
    assert registry.problems == ()
    assert registry.get("noise", "doubled") is Doubled
    assert [one.name for one in registry.plugins] == ["builtin", "good"]


def test_a_plugin_whose_hook_raises_is_named_and_the_rest_works():
    @hookimpl
    def amorsim_register(registry):
        registry.noise("before", Doubled)
        raise RuntimeError("out of milk")

    registry = made(bad=plugin(amorsim_register=amorsim_register), good=GOOD)
    (problem,) = registry.problems
    assert "plugin 'bad': amorsim_register raised RuntimeError: out of milk" in problem
    assert {"before", "doubled"} <= set(registry.names("noise"))


def test_a_misspelt_hook_is_named_with_the_one_that_was_meant():
    @hookimpl
    def amorsim_registr(registry):
        raise AssertionError("never called")

    module = registering()
    module.amorsim_registr = amorsim_registr
    registry = made(bad=module, good=registering("other"))
    (problem,) = registry.problems
    assert "plugin 'bad': there is no hook 'amorsim_registr'" in problem
    assert "Did you mean 'amorsim_register'?" in problem
    assert {"doubled", "other"} <= set(registry.names("noise")), "its right hooks and others' are called"


def test_hooks_that_are_not_marked_are_found():
    def amorsim_register(registry):
        raise AssertionError("never called")

    def amorsim_run_startd(simulation):
        raise AssertionError("never called")

    registry = made(bad=plugin(amorsim_register=amorsim_register, amorsim_run_startd=amorsim_run_startd), good=GOOD)
    text = "\n".join(registry.problems)
    assert "plugin 'bad': amorsim_register is not marked with @amorsim.hookimpl" in text
    assert "plugin 'bad': amorsim_run_startd is not a hook" in text
    assert "plugin 'bad' has no hook" in text
    assert "doubled" in registry.names("noise")


def test_a_hook_with_a_wrong_argument_leaves_its_plugin_out():
    @hookimpl
    def amorsim_register(regitsry):
        raise AssertionError("never called")

    registry = made(bad=plugin(amorsim_register=amorsim_register), good=GOOD)
    (problem,) = registry.problems
    assert "plugin 'bad' cannot be taken in" in problem
    assert "regitsry" in problem
    assert "doubled" in registry.names("noise")


def test_a_duplicate_between_plugins_names_both():
    registry = made(one=GOOD, two=registering("gaussian"), three=registering("doubled", f"{__name__}:Doubled"))
    builtin, first = registry.problems
    assert "plugin 'two', noise 'gaussian'" in builtin
    assert "plugin 'builtin' (amorsim" in builtin
    assert "plugin 'three', noise 'doubled'" in first
    assert "plugin 'one'" in first


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """A distribution, as pip leaves it, with three plugins: one that works and two that do not import."""
    folder = tmp_path / "site"
    info = folder / "weather_station-2.5.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: weather-station\nVersion: 2.5\n")
    (info / "entry_points.txt").write_text(
        "[amorsim]\nbroken = weather_broken\nleaving = weather_leaving\nstation = weather_good\n"
    )
    (folder / "weather_broken.py").write_text("import no_such_module_anywhere\n")
    (folder / "weather_leaving.py").write_text("import sys\nsys.exit(3)\n")
    (folder / "weather_good.py").write_text(
        "from amorsim.plugins.hooks import hookimpl\n"
        "@hookimpl\ndef amorsim_register(registry):\n"
        f"    registry.noise('doubled', '{__name__}:Doubled')\n"
        "    registry.noise('bad', int)\n"
    )
    monkeypatch.syspath_prepend(str(folder))
    return folder


def test_installed_plugins_are_found_and_named_with_distribution_and_version(installed):
    points = [point for point in importlib.metadata.entry_points(group="amorsim") if point.name != "example"]
    registry = make_registry(entry_points=points, disabled="")
    broken, leaving, bad = registry.problems
    assert broken.startswith("plugin 'broken' (weather-station 2.5) cannot be imported: ModuleNotFoundError")
    assert "AMORSIM_DISABLE_PLUGINS=broken" in broken
    assert leaving.startswith("plugin 'leaving' (weather-station 2.5) cannot be imported: SystemExit")
    assert "plugin 'station' (weather-station 2.5), noise 'bad': builtins:int: expected a subclass of" in bad
    assert registry.get("noise", "doubled") is Doubled


def test_disabled_plugins_are_not_even_imported(installed, monkeypatch):
    monkeypatch.setenv("AMORSIM_DISABLE_PLUGINS", "broken, leaving,station")
    registry = make_registry()
    assert registry.problems == ()
    assert "doubled" not in registry.names("noise")
    monkeypatch.setenv("AMORSIM_DISABLE_PLUGINS", "all")
    registry = make_registry()
    assert [one.name for one in registry.plugins] == ["builtin"]
    assert "gaussian" in registry.names("noise")


def test_a_misspelt_plugin_to_disable_is_reported():
    registry = make_registry({"good": GOOD}, entry_points=(), disabled="goot")
    (problem,) = registry.problems
    assert "there is no plugin 'goot' to leave out. Did you mean 'good'?" in problem


def test_the_default_registry_is_one_and_warns_of_each_problem_once(monkeypatch):
    registry = made(bad=plugin(), worse=plugin())
    monkeypatch.setattr(manager, "make_registry", lambda: registry)
    default_registry.cache_clear()
    try:
        with pytest.warns(PluginWarning) as caught:
            assert default_registry() is registry
        assert [str(one.message) for one in caught] == list(registry.problems)
        assert len(caught) == 2
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert default_registry() is registry
    finally:
        default_registry.cache_clear()


def test_plugins_are_reported_runs_in_order_and_a_failure_is_named():
    heard = []

    @hookimpl
    def amorsim_run_started(simulation):
        heard.append(("started", simulation))

    @hookimpl
    def amorsim_run_finished(simulation):
        heard.append(("finished", simulation))

    @hookimpl(specname="amorsim_run_finished")
    def fails(simulation):
        raise ValueError("no disk")

    registry = made(
        watcher=plugin(amorsim_run_started=amorsim_run_started, amorsim_run_finished=amorsim_run_finished),
        bad=plugin(fails=fails),
    )
    assert registry.problems == ()
    run_started("the simulation", registry)
    assert heard == [("started", "the simulation")]
    with pytest.raises(PluginError, match=r"plugin 'bad': amorsim_run_finished raised ValueError: no disk"):
        run_finished("the simulation", registry)
    assert heard[1:] == [("finished", "the simulation")]
