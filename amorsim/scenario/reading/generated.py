"""Generated worlds in documents: ``map = { generate = "office", seed = 7, size = [40, 25] }``.

With ``per = "replica"`` each replica has a world of its own, as with ``density = { uniform = [0.05, 0.2] }``.
"""

from __future__ import annotations

from typing import Any

from amorsim.core.distributions import Distribution
from amorsim.core.errors import PluginError
from amorsim.core.parameters import Parameter, ParameterError
from amorsim.plugins.registry import Registry
from amorsim.scenario.reading.deviations import KINDS, read_number, write_number
from amorsim.scenario.reading.faults import Node, shown
from amorsim.scenario.reading.fields import file_fields, read_component, write_fields
from amorsim.scenario.toml.angles import to_degrees
from amorsim.worlds.drawn import DrawnParameter, DrawnWorld, can_be_drawn, middle_of
from amorsim.worlds.made import MadeWorld

__all__ = ["read_generated", "write_generated"]

_BESIDE = ("generate", "seed", "per")
_MOST = 2**63 - 1


def read_generated(node: Node, registry: Registry) -> MadeWorld | DrawnWorld | None:
    """The generator, the seed and what is drawn in a table, or None after faults; nothing is generated."""
    if "generate" not in node:
        node.child("generate").fault(
            f"missing; expected the name of a world generator: {', '.join(registry.names('world_generator'))}"
        )
        return None
    name = node.child("generate").text("the name of a world generator")
    seed, per = node.value.get("seed", 0), node.value.get("per", "study")
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed <= _MOST:
        node.child("seed").fault(
            f'expected a whole number from 0 to {_MOST}, got {shown(seed)}; per = "replica" gives each replica a '
            "world of its own"
        )
        return None
    if per not in ("study", "replica"):
        node.child("per").fault(f"expected 'study' or 'replica', got {shown(per)}")
        return None
    if name is None:
        return None
    try:
        cls = registry.get("world_generator", name)
    except PluginError as error:
        node.child("generate").fault(str(error))
        return None
    before = node.book.count
    values, drawn = dict(node.value), []
    for key, field in file_fields(cls).items():
        if isinstance(node.value.get(key), dict) and set(node.value[key]) & set(KINDS):
            found = _read_drawn(node.child(key), field)
            if found is not None:
                drawn.append(found)
                # Until it is drawn, and for messages, the parameter has the middle.
                middle = middle_of(field, found.distribution)
                values[key] = to_degrees(middle) if field.is_angle else middle
    if node.book.count > before:
        return None
    generator = read_component(cls, Node(values, node.path, node.book), beside=_BESIDE)
    if generator is None:
        return None
    if not drawn and per == "study":
        return MadeWorld(generator=generator, seed=int(seed))
    return DrawnWorld(generator=generator, seed=int(seed), per=per, drawn=tuple(drawn))


def _read_drawn(node: Node, field: Parameter) -> DrawnParameter | None:
    """A parameter that is drawn, ``{ uniform = [LOW, HIGH], per = "study" }``; None after faults."""
    table = {key: value for key, value in node.value.items() if key != "per"}
    distribution = read_number(Node(table, node.path, node.book), field.is_angle)
    if not isinstance(distribution, Distribution):
        return None
    problem = can_be_drawn(field, distribution)
    if problem:
        node.fault(problem)
        return None
    try:
        return DrawnParameter(name=field.name, distribution=distribution, per=node.value.get("per", "replica"))
    except ParameterError as error:
        node.child(error.name).fault(error.problem)
        return None


def write_generated(made: MadeWorld | DrawnWorld, name: str) -> dict[str, Any]:
    """The table that `read_generated` reads, for a generator that is registered under `name`."""
    table: dict[str, Any] = {"generate": name, "seed": made.seed}
    if not isinstance(made, DrawnWorld):
        return {**table, **write_fields(made.generator)}
    table = {**table, "per": made.per, **write_fields(made.generator)}
    keys = {field.name: (key, field.is_angle) for key, field in file_fields(type(made.generator)).items()}
    for one in made.drawn:
        key, is_angle = keys[one.name]
        table[key] = {**write_number(one.distribution, is_angle), "per": one.per}
    return table
