"""The files of a first plugin: a package with a component of each kind asked for, its tests and a scenario."""

from __future__ import annotations

import ast
import importlib.util
import keyword
import re
from collections.abc import Iterator, Sequence
from importlib import resources
from pathlib import Path
from typing import NamedTuple

from amorsim.core.errors import PluginError, did_you_mean

__all__ = ["KINDS", "package_files"]

KINDS = (
    *("drive", "sensor", "noise", "controller", "estimator", "motion", "planner", "metric", "recorder"),
    *("task", "world_generator", "map_loader"),
)
"""The kinds for which there is a template; a scenario loader begins better from the guide."""

# A distribution's name, of which letters, digits and underscores make a package's.
_NAME = re.compile(r"[A-Za-z]([A-Za-z0-9._-]*[A-Za-z0-9])?")
_ROOM = "width 8000\nheight 6000\n0 0 8000 0\n8000 0 8000 6000\n8000 6000 0 6000\n0 6000 0 0\n"
_LETTERS = "\n".join(["#" * 20, *["#" + " " * 18 + "#"] * 10, "#" * 20]) + "\n"


class Component(NamedTuple):
    """A component of the package."""

    kind: str
    cls: str  # name of its class
    name: str  # in scenarios
    first_line: str  # of its docstring
    text: str  # of its module


def package_files(folder: Path, kinds: Sequence[str]) -> dict[str, str]:
    """The texts of the package's files, by path in its folder.

    Raises
    ------
    PluginError
        If there is no template for a kind, or no package can have the folder's name.
    """
    for kind in kinds:
        if kind not in KINDS:
            raise PluginError(
                f"--plugin {kind}: there is no template of this kind.{did_you_mean(kind, KINDS)} There are: "
                f"{', '.join(KINDS)}"
            )
    distribution = folder.resolve().name
    package = re.sub(r"[-.]+", "_", distribution).lower()
    if not _NAME.fullmatch(distribution) or keyword.iskeyword(package):
        raise PluginError(
            f"{folder}: expected a folder whose name can be a package's, such as my-sensors, got {distribution!r}"
        )
    found = importlib.util.find_spec(package)
    if found is not None and found.origin is not None:  # not a mere folder
        raise PluginError(f"{folder}: there is a package {package!r} already; name another folder")
    components = [_component(kind) for kind in dict.fromkeys(kinds)]
    files = {f"src/{package}/{each.kind}.py": each.text for each in components}
    files[f"src/{package}/py.typed"] = ""
    files[f"src/{package}/__init__.py"] = _init(package, components)
    files[f"src/{package}/plugin.py"] = _plugin(package, components)
    files["pyproject.toml"] = _project(distribution, package, components)
    files["README.md"] = _readme(distribution, package, components)
    files["tests/test_plugin.py"] = _tests(distribution, package, components)
    files["try.toml"] = _scenario(components)
    if "map_loader" in kinds:
        files["room.letters"] = _LETTERS
    elif "world_generator" not in kinds:
        files["room.wld"] = _ROOM
    return files


def _component(kind: str) -> Component:
    text = (resources.files("amorsim.cli") / "template" / "plugin" / f"{kind}.py").read_text(encoding="utf-8")
    (node,) = (node for node in ast.parse(text).body if isinstance(node, ast.ClassDef))
    name = re.sub(r"(?<!^)(?=[A-Z])", "_", node.name).lower()
    return Component(kind, node.name, name, (ast.get_docstring(node) or "").split("\n")[0], text)


def _init(package: str, components: Sequence[Component]) -> str:
    imports = "\n".join(f"from {package}.{each.kind} import {each.cls}" for each in components)
    names = ", ".join(f'"{each.cls}"' for each in sorted(components, key=lambda each: each.cls))
    return f'"""Components for amorsim."""\n\n{imports}\n\n__all__ = [{names}]\n'


def _plugin(package: str, components: Sequence[Component]) -> str:
    lines = "\n".join(
        f'    registry.{each.kind}("{each.name}", "{package}.{each.kind}:{each.cls}")' for each in components
    )
    return f'''"""The module that the entry point in pyproject.toml names, with the hook that registers components."""

from __future__ import annotations

import amorsim as am

__all__ = ["amorsim_register"]


@am.hookimpl
def amorsim_register(registry: am.Registry) -> None:
    """Register the components under the names that scenarios use; each is imported when it is first asked for."""
{lines}
'''


def _project(distribution: str, package: str, components: Sequence[Component]) -> str:
    kinds = ", ".join(each.kind.replace("_", " ") for each in components)
    return f'''[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"

[project]
name = "{distribution}"
version = "0.1.0"
description = "A plugin for amorsim: {kinds}."
readme = "README.md"
requires-python = ">=3.11"
dependencies = ["amorsim", "attrs>=23.2", "numpy>=1.26"]

[project.optional-dependencies]
test = ["pytest>=8.0"]

# What makes it a plugin: amorsim looks in the group "amorsim" of every installed distribution.
[project.entry-points.amorsim]
{package} = "{package}.plugin"

[tool.hatch.build.targets.wheel]
packages = ["src/{package}"]

[tool.pytest.ini_options]
testpaths = ["tests"]
'''


def _readme(distribution: str, package: str, components: Sequence[Component]) -> str:
    rows = "\n".join(
        f"| `{each.name}` | {each.kind.replace('_', ' ')} | `src/{package}/{each.kind}.py` | {each.first_line} |"
        for each in components
    )
    return f"""# {distribution}

Components for amorsim.

| name | kind | file | |
|---|---|---|---|
{rows}

Install it and test it:

```sh
python -m pip install -e ".[test]" && python -m pytest
```

`try.toml` is a scenario with all that a scenario can have of it. Run it, and look at `tried/picture.png`:

```sh
amorsim run try.toml --out tried
```

`amorsim plugins` lists the components, `amorsim plugins show {components[0].name}` prints the manual of one, and
`amorsim plugins check {components[0].name}` checks that it keeps its contract: the same bits alone and in company, for
instance. What a contract asks for stands in amorsim's docs, a guide for each kind.
"""


def _tests(distribution: str, package: str, components: Sequence[Component]) -> str:
    plain = [each for each in components if each.kind != "map_loader"]
    made = ", ".join(f"{package}.{each.cls}" for each in plain)
    names = ", ".join(f'("{each.kind}", "{each.name}")' for each in components)
    tests = []
    if plain:
        tests.append(f"""@pytest.mark.parametrize("component", [{made}])
def test_it_keeps_its_contract(component: type) -> None:
    check_component(component)
""")
    if len(plain) < len(components):
        tests.append(f"""def test_the_map_loader_keeps_its_contract() -> None:
    check_component({package}.Letters(), path=HERE / "room.letters")
""")
    tests.append(f'''@pytest.mark.parametrize(("kind", "name"), [{names}])
def test_it_is_found_where_it_is_installed(kind: str, name: str) -> None:
    assert default_registry().entry(kind, name).plugin.distribution == "{distribution}"
''')
    tests.append("""def test_the_scenario_runs_and_repeats(tmp_path: Path) -> None:
    summary = am.run(HERE / "try.toml", tmp_path / "run", duration=2.0)
    assert summary.is_complete
    assert am.reproduce(tmp_path / "run").is_exact
""")
    head = f'''"""What every plugin should test: contracts, the entry point, and a scenario."""

from pathlib import Path

import pytest
import {package}

import amorsim as am
from amorsim.plugins.manager import default_registry
from amorsim.testing import check_component

HERE = Path(__file__).resolve().parents[1]


'''
    return head + "\n\n".join(tests)


def _scenario(components: Sequence[Component]) -> str:
    """A scenario with all the components that a scenario can have."""
    names = {each.kind: each.name for each in components}
    return "\n".join(_tables(names)) + "\n"


def _tables(names: dict[str, str]) -> Iterator[str]:
    map_ = '"room.letters"' if "map_loader" in names else '"room.wld"'
    if "world_generator" in names and "map_loader" not in names:
        # Without posts there is room for whatever else the scenario has.
        map_ = f'{{ generate = "{names["world_generator"]}", posts = 0 }}'
    yield f"# Run it with: amorsim run try.toml\nformat = 1\n\n[world]\nmap = {map_}\n"
    yield "[simulation]\nduration = 30.0\nseed = 1\n"
    if recorder := names.get("recorder"):
        yield f'[recording]\nalso = [{{ use = "{recorder}" }}]\n'
    if task := names.get("task"):
        yield f'[task]\nuse = "{task}"\n'
    yield f'[[robots]]\nname = "rover"\ncontroller = {{ use = "{names.get("controller", "wander")}" }}'
    if drive := names.get("drive"):
        yield f'shape = {{ circle = 0.25 }}\n\n[robots.drive]\nuse = "{drive}"\n'
        yield '[robots.sensors.encoder]\nuse = "encoder"\ncounts_per_revolution = 1000.0\n'
        yield '[robots.sensors.laser]\nuse = "laser"'
    else:
        yield 'model = "pioneer2dx"\n\n[robots.sensors.laser]'
    if noise := names.get("noise"):
        yield f'noise = [{{ use = "{noise}" }}]'
    yield ""
    if sensor := names.get("sensor"):
        yield f'[robots.sensors.{sensor}]\nuse = "{sensor}"\n'
    estimator = names.get("estimator", "dead_reckoning")
    yield f'[robots.estimators.{estimator}]\nuse = "{estimator}"\n'
    if motion := names.get("motion"):
        yield '[[obstacles]]\nname = "thing"\nshape = { circle = 0.2 }\npose = { x = 6.5, y = 1.5 }'
        yield f'motion = {{ use = "{motion}" }}'
