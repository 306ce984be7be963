"""What can be chosen, explained: cards of a gallery with a picture and a sentence."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import TypedDict

from amorsim.core.errors import AmorsimError
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.document import Document, open_document
from amorsim.ui.scene.still import StillBuilder
from amorsim.ui.scene.wire import Still

__all__ = ["KINDS", "Card", "card_of", "sentence_of"]

# The kinds of what a card shows, each with the text of a scenario that has nothing else.
_ALONE = {
    "robot": '[[robots]]\nname = "robot"\nmodel = "{name}"\npose = {{ x = 0.0, y = 0.0 }}\n',
    "world_generator": '[world]\nmap = {{ generate = "{name}", seed = 1 }}\n',
}
KINDS = ("scenario", *_ALONE)


class Card(TypedDict):
    """The scene at rest, the pictures of its maps by name (base 64), and a sentence; empty where there is none."""

    still: Still
    pictures: dict[str, str]
    sentence: str


def card_of(kind: str, name: str, folder: Path, registry: Registry) -> Card:
    """The card of a scenario (a bundled one, or a file in a folder), of a robot's model or of a generator of worlds.

    No program of a user is run.

    Raises
    ------
    AmorsimError
        If there is nothing of that name.
    """
    if kind == "scenario":
        is_bundled = name in registry.names("scenario")
        document = open_document(name if is_bundled else folder / name, registry=registry)
        sentence = sentence_of(document.text)
    elif kind in _ALONE and name in registry.names(kind):
        document = Document(f"format = 1\n{_ALONE[kind].format(name=name)}", folder / "card.toml", registry=registry)
        sentence = _about(kind, name, registry)
    else:
        raise AmorsimError(f"there is no {kind.replace('_', ' ')} {name!r}")
    builder = StillBuilder(document.partial(), name)
    pictures = {
        shape["image"]["name"]: base64.b64encode(builder.picture(shape["image"]["name"])).decode()
        for shape in builder.still["scene"]["maps"]
        if shape["image"] is not None and shape["segments"] is None
    }
    return {"still": builder.still, "pictures": pictures, "sentence": sentence}


def sentence_of(text: str) -> str:
    """The first sentence of the comment that a file in TOML begins with; empty if it begins with none."""
    words: list[str] = []
    for line in text.splitlines():
        if line.startswith("#:"):  # for editors of text
            continue
        if not line.startswith("# "):
            break
        words.append(line[2:].strip())
    sentence, stop, _ = " ".join(words).partition(". ")
    return sentence + stop.strip()


def _about(kind: str, name: str, registry: Registry) -> str:
    """A sentence about a robot's model, of its file, or about a component, the first line of its docstring."""
    if kind == "robot":
        return sentence_of(registry.file(kind, name).read_text(encoding="utf-8", errors="replace"))
    return (registry.get(kind, name).__doc__ or "").strip().partition("\n")[0]
