"""The names of packages: what type checkers are shown is what can be had, and is looked up when first used."""

from __future__ import annotations

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

import amorsim as am

STUBS = sorted(Path(am.__file__).parent.rglob("__init__.pyi"))
PACKAGES = [".".join(stub.parent.relative_to(Path(am.__file__).parents[1]).parts) for stub in STUBS]


def test_the_packages_of_components_look_names_up() -> None:
    assert {"amorsim", "amorsim.controllers", "amorsim.noise", "amorsim.planners"} <= set(PACKAGES)


@pytest.mark.parametrize(("package", "stub"), list(zip(PACKAGES, STUBS, strict=True)), ids=PACKAGES)
def test_type_checkers_are_shown_what_can_be_had(package: str, stub: Path) -> None:
    module = importlib.import_module(package)
    shown = set()
    for node in ast.walk(ast.parse(stub.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            shown |= {alias.name for alias in node.names}
    assert shown == set(dir(module))
    assert shown == {*module.__all__, *(["__version__"] if package == "amorsim" else [])}
    for name in shown:
        assert getattr(module, name) is not None
    with pytest.raises(AttributeError, match=f"module '{package}' has no attribute 'nothing'"):
        module.nothing  # noqa: B018


def test_a_package_brings_in_nothing_until_a_name_is_used() -> None:
    code = "import sys, amorsim.planners; print([name for name in sys.modules if name.startswith('amorsim.planners.')])"
    used = "from amorsim.planners import Wavefront; print('amorsim.planners.trees' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", f"{code}; {used}"], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\nFalse\n"


def test_the_public_names_are_sorted() -> None:
    assert list(am.__all__) == sorted(am.__all__, key=lambda name: (not name.isupper(), not name[0].isupper(), name))
