"""How readers of other programs' scenarios are tried."""

from __future__ import annotations

import tempfile
from pathlib import Path

from amorsim.contracts import ScenarioDocument, ScenarioLoader
from amorsim.core.error_text import RAISED, error_in_words
from amorsim.core.errors import ScenarioError
from amorsim.testing.failure import Who

__all__ = ["check_scenario_loader"]

_JUNK = (b"", b"\x00" * 64, bytes(range(256)) * 16, b"no scenario at all\n", b"((((((((", b'"' * 100)


def check_scenario_loader(who: Who, loader: ScenarioLoader, path: Path | None) -> None:
    """Try a loader with files of other formats, and with one of its own, if there is one."""
    with tempfile.TemporaryDirectory() as folder:
        for number, content in enumerate(_JUNK):
            with who.calling("sniff"):
                answer = loader.sniff(content)
            what = f"sniff() of {content[:8]!r}..."
            who.require(isinstance(answer, bool), "sniff", what, "true or false", repr(answer))
            file = Path(folder) / f"junk{number}{loader.extensions[0]}"
            file.write_bytes(content)
            _read_or_refuse(who, loader, file, f"a file that begins with {content[:8]!r}")
        missing = Path(folder) / f"none{loader.extensions[0]}"
        found = _read_or_refuse(who, loader, missing, "a file that is not there")
        who.require(found is None, "errors", "read() of a file that is not there", "a ScenarioError", "a document")
    if path is not None:
        with who.calling("read"):
            first, second = loader.read(path), loader.read(path)
        is_one = isinstance(first, ScenarioDocument)
        who.require(is_one, "read", f"read({path.name})", "a ScenarioDocument", type(first).__name__)
        who.require(first == second, "determinism", f"a second read({path.name})", "the same document", "another one")


def _read_or_refuse(who: Who, loader: ScenarioLoader, path: Path, what: str) -> ScenarioDocument | None:
    try:
        found = loader.read(path)
    except ScenarioError:
        return None
    except RAISED as error:
        who.fail("errors", f"read() of {what}: expected a ScenarioError, found {error_in_words(error)}")
    is_one = isinstance(found, ScenarioDocument)
    who.require(is_one, "read", f"read() of {what}", "a ScenarioDocument", type(found).__name__)
    return found
