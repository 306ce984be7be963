"""What the scripts know of the messages is what Python says."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

TOOL = Path(__file__).parents[3] / "tools" / "make_wire.py"


def tool() -> ModuleType:
    spec = importlib.util.spec_from_file_location("make_wire", TOOL)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_scripts_know_the_messages_as_they_are() -> None:
    made = tool()
    for name, text in made.FILES.items():
        assert (made.FOLDER / name).read_text(encoding="utf-8") == text(), "run: python tools/make_wire.py"
