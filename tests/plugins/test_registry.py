"""Registering by name: what is taken, what is refused and in which words, and what is imported when."""

import subprocess
import sys
from typing import ClassVar

import attrs
import numpy as np
import pytest

from amorsim.contracts import Controller, Noise, Sensor, parameter
from amorsim.core.errors import PluginError
from amorsim.plugins.manager import make_registry
from amorsim.plugins.registry import KINDS, Plugin, Registry


@attrs.frozen(kw_only=True)
class Thermometer(Sensor):
    unit: ClassVar[str] = "K"

    offset: float = parameter(0.0, unit="K", help="added")

    def size(self, drive):
        return 1

    def sense(self, view, aim, state, draws):
        return np.full((view.rows, 1), 293.0) + self.offset, {}


@attrs.frozen(kw_only=True)
class Doubled(Noise):
    def corrupt(self, values, side, elapsed, state, draws):
        return values * 2.0


@attrs.frozen(kw_only=True)
class WrongSignature(Noise):
    def corrupt(self, values, draws):
        return values


@pytest.fixture
def registry():
    return Registry()


def test_a_class_is_found_by_its_name_and_its_name_by_the_class(registry):
    registry.sensor("thermometer", Thermometer)
    assert registry.get("sensor", "thermometer") is Thermometer
    assert registry.name_of("sensor", Thermometer) == "thermometer"
    assert registry.name_of("sensor", Doubled) is None
    assert registry.names("sensor") == ("thermometer",)


def test_a_reference_is_imported_when_first_asked_for(registry):
    registry.noise("doubled", f"{__name__}:Doubled")
    registry.noise("broken", "no_such_module_anywhere:Thing")
    registry.noise("missing", f"{__name__}:Dubbled")
    assert registry.get("noise", "doubled") is Doubled
    assert registry.name_of("noise", Doubled) == "doubled"
    with pytest.raises(PluginError, match=r"noise 'broken': 'no_such_module_anywhere' cannot be imported"):
        registry.get("noise", "broken")
    with pytest.raises(PluginError, match=r"no 'Dubbled' in .*Did you mean 'Doubled'\?"):
        registry.get("noise", "missing")


def test_a_reference_to_a_module_that_exits_is_refused_by_name(registry, tmp_path, monkeypatch):
    (tmp_path / "module_that_exits.py").write_text("import sys\nsys.exit(3)\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    registry.noise("leaves", "module_that_exits:Leaves")
    with pytest.raises(PluginError, match=r"noise 'leaves': 'module_that_exits' cannot be imported: SystemExit: 3"):
        registry.get("noise", "leaves")


def test_a_reference_is_checked_against_the_contract_when_it_is_imported(registry):
    registry.noise("wrong", f"{__name__}:WrongSignature")
    with pytest.raises(PluginError, match=r"expected \(values, side, elapsed, state, draws\), found \(values, draws\)"):
        registry.get("noise", "wrong")


def test_an_unknown_name_says_what_is_known_and_what_may_have_been_meant(registry):
    registry.sensor("thermometer", Thermometer)
    with pytest.raises(PluginError, match=r"no sensor 'thermometre'; did you mean"):
        registry.get("sensor", "thermometre")
    with pytest.raises(PluginError, match=r"no map loader 'x'; known map loaders: none"):
        registry.get("map_loader", "x")


def test_a_duplicate_names_both_and_the_first_stays(registry):
    with registry.registering(Plugin(name="one", distribution="dist-one", version="1.2")):
        registry.noise("doubled", Doubled)
    with registry.registering(Plugin(name="two", distribution="dist-two", version="3.4")):
        registry.noise("doubled", f"{__name__}:WrongSignature")
        registry.sensor("thermometer", Thermometer)
    (problem,) = registry.problems
    assert "plugin 'two' (dist-two 3.4), noise 'doubled'" in problem
    assert "plugin 'one' (dist-one 1.2)" in problem
    assert registry.get("noise", "doubled") is Doubled
    assert registry.get("sensor", "thermometer") is Thermometer, "the rest of the second plugin works"


@pytest.mark.parametrize("name", ["", "2nd", "a b", "a.b", "x" * 65, 3, None])
def test_a_name_that_no_file_could_say_is_refused(registry, name):
    with pytest.raises(PluginError, match=r"expected a name of letters"):
        registry.noise(name, Doubled)


@pytest.mark.parametrize("target", ["module", "a:b:c", 3, None])
def test_a_target_is_a_class_or_a_reference(registry, target):
    with pytest.raises(PluginError, match=r"expected a class or 'module:Class'"):
        registry.noise("thing", target)


def test_robots_and_scenarios_are_files_that_are_there(registry, tmp_path):
    path = tmp_path / "robot.toml"
    with pytest.raises(PluginError, match=r"robot 'mine': expected a TOML file"):
        registry.robot("mine", path)
    path.write_text("format = 1\n")
    registry.robot("mine", path)
    registry.scenario("mine", str(path))
    assert registry.file("robot", "mine") == path == registry.file("scenario", "mine")


def test_what_a_script_registers_wrongly_raises_rather_than_being_collected(registry):
    with pytest.raises(PluginError, match="plugin 'script'"):
        registry.noise("wrong", WrongSignature)
    assert registry.problems == ()
    assert registry.names("noise") == ()


BUILTIN = make_registry(entry_points=())


@pytest.mark.parametrize(
    ("kind", "name"), [(entry.kind, entry.name) for entry in BUILTIN.entries() if entry.kind in KINDS]
)
def test_every_builtin_component_keeps_its_contract(kind, name):
    cls = BUILTIN.get(kind, name)
    assert issubclass(cls, KINDS[kind])
    assert BUILTIN.name_of(kind, cls) == name


def test_what_the_mission_names_is_built_in():
    assert BUILTIN.problems == ()
    assert {"ackermann", "differential", "mecanum", "synchro", "tractor", "tricycle"} <= set(BUILTIN.names("drive"))
    assert {"encoder", "laser", "sonar", "compass", "gyro", "infrared", "fiducial"} <= set(BUILTIN.names("sensor"))
    assert {"gaussian", "bias", "scale", "quantize", "saturate", "diffusion"} <= set(BUILTIN.names("noise"))
    assert {"wld", "bmp"} <= set(BUILTIN.names("map_loader"))
    assert "dead_reckoning" in BUILTIN.names("estimator")
    assert {"wander", "goto", "square", "manual"} <= set(BUILTIN.names("controller"))
    assert "text" in BUILTIN.names("recorder")


@pytest.mark.parametrize("kind", ["robot", "scenario"])
def test_every_built_in_file_is_there(kind):
    assert BUILTIN.names(kind)
    for name in BUILTIN.names(kind):
        assert BUILTIN.file(kind, name).is_file()


def test_loading_the_plugins_imports_no_component():
    code = (
        "import sys\n"
        "from amorsim.plugins.manager import make_registry\n"
        "make_registry(entry_points=())\n"
        "parts = ('drives', 'sensors', 'noise', 'maps', 'estimators', 'controllers', 'recorders', 'render')\n"
        "print([name for name in sys.modules if name.split('.')[1:2] and name.split('.')[1] in parts\n"
        "       and name.startswith('amorsim.')])\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_entries_say_where_a_thing_comes_from(registry):
    registry.controller("late", "some.module:Late")
    registry.noise("doubled", Doubled)
    late, doubled = registry.entries()
    assert late.reference == "some.module:Late"
    assert doubled.reference == f"{__name__}:Doubled"
    assert registry.entries("noise") == (doubled,)
    assert issubclass(KINDS["controller"], Controller)
