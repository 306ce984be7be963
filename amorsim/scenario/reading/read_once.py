"""Robots and obstacles that differ in name and pose alone: where a book shares them, one of them is read."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import attrs

from amorsim.core.parameters import ParameterError
from amorsim.plugins.checks import check_name
from amorsim.scenario.reading.bodies import read_pose
from amorsim.scenario.reading.faults import Node
from amorsim.scenario.spec import Obstacle, Robot

__all__ = ["read_alike"]

Body = TypeVar("Body", Robot, Obstacle)


def read_alike(node: Node, read: Callable[[Node], Body | None]) -> Body | None:
    """The body in a table, by `read` if its book knows none like it yet."""
    known = node.book.alike
    key = _key(node)
    if key not in known:
        found = read(node)
        if found is not None and key is not None:
            known[key] = found
        return found
    pose = read_pose(node.child("pose"))
    if pose is None:
        return None
    body: Body = known[key]
    try:
        return attrs.evolve(body, name=node.value["name"], pose=pose)
    except ParameterError:  # of something that the pose has to suit
        return read(node)


def _key(node: Node) -> str | None:
    """A key shared by tables that differ in name and pose only; None if this one is to be read by itself."""
    book, own = node.book, node.value
    if not (node.is_table and book.shares_alike and node.path not in book.incomplete):
        return None
    if not ({"name", "pose"} <= set(own) and isinstance(own["pose"], dict) and not check_name(own["name"])):
        return None
    errors = own.get("errors")
    if "motion" in own or (isinstance(errors, dict) and "pose" in errors):
        return None
    rest = {key: value for key, value in own.items() if key not in ("name", "pose")}
    branch = book.branch(node.path)  # the same words mean other files in a model of another folder
    below = sorted((key, repr(one)) for key, one in branch.below.items() if key in rest)
    return repr((node.path[0], rest, branch.source, below))
