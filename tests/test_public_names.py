"""The names of the package: what type checkers are shown is what can be had."""

from __future__ import annotations

import ast
import inspect

import amorsim as am


def _shown_to_type_checkers() -> set[str]:
    found = set()
    for node in ast.parse(inspect.getsource(am)).body:
        if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
            for one in ast.walk(node):
                if isinstance(one, ast.ImportFrom):
                    found |= {name.asname or name.name for name in one.names}
    return found


def test_type_checkers_are_shown_every_public_name() -> None:
    assert _shown_to_type_checkers() == set(am.__all__)


def test_every_public_name_can_be_had() -> None:
    assert list(am.__all__) == sorted(am.__all__, key=lambda name: (not name.isupper(), not name[0].isupper(), name))
    for name in am.__all__:
        assert getattr(am, name) is not None
