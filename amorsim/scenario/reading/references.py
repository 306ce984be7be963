"""Names by which a robot's components refer to its sensors, its estimators and its drive's joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs

from amorsim.core.parameters import describe
from amorsim.core.unknown_names import no_such
from amorsim.scenario.reading.faults import Node

__all__ = ["check_references"]


def check_references(node: Node, component: object, known: Mapping[str, Sequence[str]]) -> None:
    """A fault for each name in a component's table that its robot does not have.

    `known` are the robot's names by what a parameter `refers` to; what is not among its keys is not checked. Defaults
    are not checked either: only the component knows whether it needs what they name.
    """
    if not node.is_table or not attrs.has(type(component)):
        return
    for name, parameter in describe(type(component)).items():
        if name not in node:
            continue
        value = getattr(component, name)
        if parameter.component:
            check_references(node.child(name), value, known)
        elif parameter.refers in known and isinstance(value, str) and value != parameter.default:
            names = known[parameter.refers]
            if value not in names:
                kind = parameter.refers.removesuffix("s")
                node.child(name).fault(no_such(kind, value, names, whose="the robot"))
