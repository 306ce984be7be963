"""The messages that a window of the Simulator may send: the shape of each command, and its limits.

A command is a message (see `amorsim.ui.serve.wire`) with the keys that `COMMANDS` gives it. What commands are answered
with, see `amorsim.ui.simulator.frames.protocol`.

Angles are radians. Robots are named by name, or by their place in the scene's list; where a window names none, the one
that it looks at is meant.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs

from amorsim.core.errors import did_you_mean
from amorsim.core.numbers import is_number
from amorsim.ui.serve.wire import Kind, MessageError, shown, whole

__all__ = ["COMMANDS", "Command", "check"]

LARGEST = 1e300
LONGEST_NAME = 200  # letters of a robot, a map, a window or a parameter's path
LONGEST_PLACE = 520  # letters of a file or folder: five names of 100 (see `amorsim.ui.simulator.project`)
MOST_ROBOTS = 100_000
MOST_CHANNELS = 64
MOST_POINTS = 10_000
MOST_STEPS = 1000
MOST_ITEMS = 1000  # of a list or table that is a parameter's value
DEEPEST = 16  # of lists and tables in one another


def _number(low: float = -LARGEST, high: float = LARGEST) -> Kind:
    return Kind(f"a number from {low:g} to {high:g}", lambda value: is_number(value) and low <= value <= high)


def _text(longest: int) -> Kind:
    def holds(value: Any) -> bool:
        # Half of a surrogate pair is not a letter, and cannot be written.
        return isinstance(value, str) and len(value) <= longest and not any("\ud800" <= c <= "\udfff" for c in value)

    return Kind(f"a text of at most {longest} letters", holds)


def _one_of(*words: str) -> Kind:
    return Kind(" or ".join(repr(word) for word in words), lambda value: isinstance(value, str) and value in words)


def _list_of(kind: Kind, most: int) -> Kind:
    def holds(value: Any) -> bool:
        return isinstance(value, list) and len(value) <= most and all(kind.holds(one) for one in value)

    return Kind(f"a list of at most {most}, each {kind.expected}", holds)


def _either(*kinds: Kind) -> Kind:
    return Kind(" or ".join(kind.expected for kind in kinds), lambda value: any(kind.holds(value) for kind in kinds))


def _is_value(value: Any, depth: int = DEEPEST) -> bool:
    if isinstance(value, (list, dict)):
        items = value if isinstance(value, list) else [*value.values()]
        names = value if isinstance(value, dict) else ()
        small = depth > 0 and len(items) <= MOST_ITEMS and all(_NAME.holds(name) for name in names)
        return small and all(_is_value(item, depth - 1) for item in items)
    return value is None or isinstance(value, bool) or _number().holds(value) or _text(LONGEST_PLACE).holds(value)


_NAME = _text(LONGEST_NAME)
_VALUE = Kind("a number, true or false, a text, null, or a list or table of these", _is_value)
_YES_OR_NO = Kind("true or false", lambda value: isinstance(value, bool))
_NOTHING = Kind("null", lambda value: value is None)
_ROBOT = _either(_NAME, whole(0, MOST_ROBOTS))
_TICK = whole(0)
_SPEED = _number(-1e6, 1e6)
_OF_ROBOT = {"robot": _ROBOT}


@attrs.frozen(kw_only=True)
class Command:
    """The shape of a command.

    Attributes
    ----------
    needs, may
        The keys that it must have, and those that it may have.
    asks
        Whether it only asks: such commands are answered at once, the others in the order in which they came.
    controls
        Whether only the window that has the controls may give it.
    """

    needs: Mapping[str, Kind] = attrs.field(factory=dict)
    may: Mapping[str, Kind] = attrs.field(factory=dict)
    asks: bool = False
    controls: bool = False


COMMANDS: Mapping[str, Command] = {
    # What there is to see.
    "state": Command(asks=True),
    "scene": Command(asks=True),
    "parameters": Command(may=_OF_ROBOT, asks=True),
    "history": Command(may={**_OF_ROBOT, "max_points": whole(1, MOST_POINTS)}, asks=True),
    "events": Command(may={"after": whole(0)}, asks=True),
    "manual": Command(needs={"kind": _NAME, "name": _NAME}, asks=True),  # of a component
    "image": Command(needs={"name": _NAME}, asks=True),
    "mapped": Command(may=_OF_ROBOT, asks=True),
    "intended": Command(may=_OF_ROBOT, asks=True),
    "folder": Command(asks=True),
    # Of this window alone.
    "select": Command(needs=_OF_ROBOT),
    "controls": Command(needs={"want": _one_of("take", "ask", "give")}, may={"to": _either(_NAME, _NOTHING)}),
    # Time. `speed` without a factor is as fast as possible, `scrub` without a tick leads to the newest.
    "run": Command(controls=True),
    "pause": Command(controls=True),
    "step": Command(may={"steps": whole(0, MOST_STEPS)}, controls=True),
    "speed": Command(may={"factor": _either(_number(0.001, 1e6), _NOTHING)}, controls=True),
    "reset": Command(controls=True),
    "scrub": Command(may={"tick": _either(_TICK, _NOTHING)}, controls=True),
    "continue": Command(may={"tick": _either(_TICK, _NOTHING)}, controls=True),
    "go_back": Command(may={"number": whole(1)}, controls=True),
    "futures": Command(may={**_OF_ROBOT, "max_points": whole(1, MOST_POINTS)}, asks=True),
    "forget": Command(needs={"number": whole(1)}, controls=True),
    # Of a recorded run: which replica is shown.
    "replica": Command(needs={"number": whole(0)}, controls=True),
    # Driving: [m/s], [m/s], [rad/s]. `hand_over` without `to` is to the hand; `stop` without a robot stops all that
    # are driven by hand.
    "hand_over": Command(may={**_OF_ROBOT, "to": _one_of("hand", "controller")}, controls=True),
    "drive": Command(may={**_OF_ROBOT, "forward": _SPEED, "left": _SPEED, "turn": _SPEED}, controls=True),
    "command": Command(needs={"channels": _list_of(_number(), MOST_CHANNELS)}, may=_OF_ROBOT, controls=True),
    "stop": Command(may={"robot": _either(_ROBOT, _NOTHING)}, controls=True),
    # Parameters, by their paths. `restore` without a path restores all.
    "set": Command(needs={"path": _NAME, "value": _VALUE}, may=_OF_ROBOT, controls=True),
    "restore": Command(may={**_OF_ROBOT, "path": _either(_NAME, _NOTHING)}, controls=True),
    # Elements of noise, by the path of their chain; `add` puts one at the end, or before that of an index. `value` is
    # the table of an element, for `noises` that of one that is being made.
    "noises": Command(needs={"path": _NAME}, may={**_OF_ROBOT, "value": _VALUE}, asks=True),
    "add": Command(
        needs={"path": _NAME, "value": _VALUE}, may={**_OF_ROBOT, "index": whole(0, MOST_ITEMS)}, controls=True
    ),
    "remove": Command(needs={"path": _NAME}, may=_OF_ROBOT, controls=True),
    # Files and folders in the project's folder (see `amorsim.ui.simulator.project`); a run without a name gets one.
    "places": Command(controls=True),
    "page": Command(asks=True),  # the run as one HTML file
    "save_scenario": Command(needs={"name": _text(LONGEST_PLACE)}, may={"overwrite": _YES_OR_NO}, controls=True),
    "save_run": Command(may={"name": _either(_text(LONGEST_PLACE), _NOTHING)}, controls=True),
    # A simulation that hangs or has gone; `without` are robots that go over to the hand.
    "restart": Command(may={"without": _either(_list_of(_NAME, MOST_ROBOTS), _NOTHING)}, controls=True),
    # The scenario's file again, once it has changed.
    "reload": Command(controls=True),
}


def check(command: Mapping[str, Any]) -> Command:
    """The shape of a command, which it has.

    Raises
    ------
    MessageError
        If there is no such command, or it has not that shape.
    """
    name = command.get("do")
    found = COMMANDS.get(name) if isinstance(name, str) else None
    if found is None:
        raise MessageError(f"there is no command {shown(name)}.{did_you_mean(str(name)[:LONGEST_NAME], COMMANDS)}")
    known = {**found.needs, **found.may}
    for key, value in command.items():
        if key in ("do", "id"):
            continue
        if key not in known:
            raise MessageError(f"{name} takes no {shown(key)}.{did_you_mean(key[:LONGEST_NAME], known)}")
        if not known[key].holds(value):
            raise MessageError(f"{name}: {key}: expected {known[key].expected}, got {shown(value)}")
    for key, kind in found.needs.items():
        if key not in command:
            raise MessageError(f"{name}: {key}: expected {kind.expected}, got nothing")
    return found
