"""Messages for names that are unknown, with the known ones and what may have been meant."""

from __future__ import annotations

from collections.abc import Iterable

from amorsim.core.error_text import in_words
from amorsim.core.errors import did_you_mean

__all__ = ["no_such", "unknown_key"]

_MOST = 50  # names in a message


def no_such(what: str, name: object, known: Iterable[object], *, whose: str = "") -> str:
    """The message for an unknown name: ``no robot 'rovr'; did you mean 'rover'?``.

    Parameters
    ----------
    what
        The kind of thing, in the singular: ``"sensor"``.
    whose
        What should have it: ``"robot 'rover'"``.
    """
    lacks = f"{whose} has no {what}" if whose else f"no {what}"
    return f"{lacks} {in_words(name)}; {_known(what, name, known)}"


def unknown_key(name: str, known: Iterable[str]) -> str:
    """The message for an unknown key of a table."""
    return f"unknown key; {_known('key', name, known)}"


def _known(what: str, name: object, known: Iterable[object]) -> str:
    names = list(dict.fromkeys(map(str, known)))
    hint = did_you_mean(name, names)
    if hint and len(names) == 1:
        return f"d{hint[2:]}"
    more = f" ... ({len(names)} in all)" if len(names) > _MOST else ""
    return f"known {_plural(what)}: {', '.join(names[:_MOST]) or 'none'}{more}.{hint}"


def _plural(what: str) -> str:
    noun, blank, rest = what.partition(" of ")
    if noun == "axis":
        return "axes"
    return (f"{noun[:-1]}ies" if noun.endswith("y") and noun != "key" else f"{noun}s") + blank + rest
