"""How values are shown in a notebook: a method for their classes, and the function that makes its result."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

__all__ = ["in_notebook", "show_by"]

_makers: list[Callable[[Any], dict[str, Any]]] = []


def show_by(maker: Callable[[Any], dict[str, Any]]) -> None:
    """Set the function that makes what notebooks show of values: content by MIME type.

    The package sets it when it is imported. Pictures are drawn by layers above the classes that show them.
    """
    _makers[:] = [maker]


def in_notebook(self: Any, **_: Any) -> dict[str, Any]:
    """The `_repr_mimebundle_` of a class: its picture or table, with plain text beside it.

    A notebook passes which types it would include or exclude, and leaves out the others itself.
    """
    return _makers[0](self) if _makers else {"text/plain": repr(self)}
