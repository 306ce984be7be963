"""What windows may send: every command's shape, the limits of what is in it, and that nothing else gets through."""

from __future__ import annotations

import contextlib
import functools
import json
import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from amorsim.ui.serve.wire import LONGEST_MESSAGE, MessageError, decode, number_of
from amorsim.ui.simulator.frames.messages import COMMANDS, check
from amorsim.ui.simulator.project import place_for

WEB = Path(__file__).parents[3] / "amorsim" / "ui" / "web"

GOOD: list[dict[str, Any]] = [
    *({"do": name} for name, shape in COMMANDS.items() if not shape.needs),
    {"do": "select", "robot": 3},
    {"do": "select", "robot": "rover"},
    {"do": "history", "robot": "rover", "max_points": 3000},
    {"do": "events", "after": 12},
    {"do": "image", "name": "map-0"},
    {"do": "manual", "kind": "drive", "name": "differential"},
    {"do": "controls", "want": "give", "to": "window"},
    {"do": "step", "steps": 1000},
    {"do": "speed", "factor": None},
    {"do": "speed", "factor": 0.25},
    {"do": "scrub", "tick": None},
    {"do": "continue", "tick": 40},
    {"do": "go_back", "number": 2},
    {"do": "futures", "robot": "rover", "max_points": 3000},
    {"do": "forget", "number": 1},
    {"do": "replica", "number": 3},
    {"do": "hand_over", "robot": "rover", "to": "hand"},
    {"do": "drive", "forward": 0.5, "left": 0, "turn": -1.2},
    {"do": "command", "robot": "rover", "channels": [1, 2.5]},
    {"do": "stop", "robot": None},
    {"do": "set", "robot": "rover", "path": "errors.drive.track.scale", "value": 1.05},
    {"do": "set", "path": "errors.drive.track", "value": {"scale": {"normal": [1.0, 0.1]}, "per": "study"}},
    {"do": "set", "path": "errors.drive.track", "value": None},
    {"do": "noises", "path": "ground"},
    {"do": "add", "path": "ground", "value": {"use": "slip", "joint": "left", "at": 1.5}, "index": 0},
    {"do": "remove", "robot": "rover", "path": "sensors.laser.noise.gaussian"},
    {"do": "restore", "path": None},
    {"do": "save_scenario", "name": "folder/changed", "overwrite": True},
    {"do": "save_run", "name": None},
    {"do": "restart", "without": ["rover", "other"]},
]

WRONG: list[tuple[dict[str, Any], str]] = [
    ({}, "there is no command None"),
    ({"do": ["run"]}, "there is no command"),
    ({"do": "rn"}, "Did you mean 'run'?"),
    ({"do": "job"}, "there is no command 'job'"),
    ({"do": "run", "now": True}, "run takes no 'now'"),
    ({"do": "step", "stps": 1}, "Did you mean 'steps'?"),
    ({"do": "step", "steps": 1001}, "a whole number from 0 to 1000, got 1001"),
    ({"do": "step", "steps": -1}, "steps: expected"),
    ({"do": "step", "steps": 1.0}, "steps: expected"),
    ({"do": "step", "steps": True}, "steps: expected"),
    ({"do": "step", "steps": "9" * 400}, "steps: expected"),
    ({"do": "scrub", "tick": 10**400}, "tick: expected"),
    ({"do": "speed", "factor": 1e7}, "factor: expected a number from 0.001 to 1e"),
    ({"do": "set", "path": "x", "value": 10**400}, "value: expected a number"),
    ({"do": "set", "path": "x", "value": float("inf")}, "value: expected a number"),
    ({"do": "set", "path": "x", "value": float("nan")}, "value: expected a number"),
    (
        {"do": "set", "path": "x", "value": functools.reduce(lambda inner, _: [inner], range(17), 1.0)},
        "value: expected a number",
    ),
    ({"do": "set", "path": "x", "value": [1.0] * 1001}, "value: expected a number"),
    ({"do": "set", "path": "x", "value": {"y": 10**400}}, "value: expected a number"),
    ({"do": "add", "path": "ground"}, "value: expected"),
    ({"do": "set", "path": "x" * 201, "value": 1.0}, "path: expected a text of at most 200 letters"),
    ({"do": "set", "path": ["x"], "value": 1.0}, "path: expected"),
    ({"do": "set", "value": 1.0}, "path: expected a text of at most 200 letters, got nothing"),
    ({"do": "select", "robot": "\ud800"}, "robot: expected"),
    ({"do": "select", "robot": {}}, "robot: expected"),
    ({"do": "controls", "want": "give", "to": ["x"]}, "to: expected"),
    ({"do": "controls", "want": ["give"]}, "want: expected 'take' or 'ask' or 'give'"),
    ({"do": "hand_over", "to": ["hand"]}, "to: expected 'hand' or 'controller'"),
    ({"do": "command", "channels": [1.0] * 65}, "channels: expected a list of at most 64"),
    ({"do": "command", "channels": [10**400]}, "channels: expected"),
    ({"do": "command", "channels": {"0": 1.0}}, "channels: expected"),
    ({"do": "restart", "without": "rover"}, "without: expected"),
    ({"do": "save_scenario", "name": "x", "overwrite": 1}, "overwrite: expected true or false"),
]


@pytest.mark.parametrize("command", GOOD, ids=str)
def test_what_the_window_sends_is_taken(command: dict[str, Any]) -> None:
    assert check(decode(json.dumps({"id": 1, **command}))) is COMMANDS[command["do"]]


@pytest.mark.parametrize(("command", "says"), WRONG, ids=lambda value: str(value)[:60])
def test_what_it_does_not_is_refused_with_what_is_wrong(command: dict[str, Any], says: str) -> None:
    with pytest.raises(MessageError) as caught:
        check(command)
    assert says in str(caught.value)
    assert len(str(caught.value)) < 300


def test_every_command_is_tried() -> None:
    assert {command["do"] for command in GOOD} == set(COMMANDS)


def test_the_scripts_send_no_other_command_and_no_other_key() -> None:
    found = 0
    for script in (*WEB.glob("simulator/*.js"), *WEB.glob("shared/*.js")):
        for table in re.findall(r"\{\s*do:[^{}]*\}", script.read_text(encoding="utf-8")):
            found += 1
            names = re.findall(r'"([a-z_]+)"', table.partition(",")[0])
            assert names, table
            keys = set(re.findall(r"[,{]\s*([a-z_]+)\s*(?=[:,}])", table)) - {"do"}
            for name in names:
                shape = COMMANDS[name]
                assert set(shape.needs) <= keys <= {*shape.needs, *shape.may}, table
    assert found > 20


ODD = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5) | st.sampled_from(["rover", "hand"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=5,
)
KEYS = sorted({key for shape in COMMANDS.values() for key in (*shape.needs, *shape.may)} | {"do", "id", "drawn"})


@given(st.dictionaries(st.sampled_from(KEYS), ODD, max_size=5), st.sampled_from([*COMMANDS, None]))
def test_any_table_is_a_command_or_a_message_error(table: dict[str, Any], name: str | None) -> None:
    if name is not None:
        table["do"] = name
    with contextlib.suppress(MessageError):  # and nothing else is raised
        message = decode(json.dumps(table))
        number_of(message)
        check(message)


@given(st.text(max_size=200))
def test_any_text_is_a_message_or_a_message_error(text: str) -> None:
    with contextlib.suppress(MessageError):
        decode(text)


@pytest.mark.parametrize("text", ["[" * LONGEST_MESSAGE, '{"do":' * 9000, "9" * LONGEST_MESSAGE, '{"a": NaN}', None])
def test_the_deepest_and_longest_are_refused(text: str | None) -> None:
    with pytest.raises(MessageError):
        decode(text)


def test_the_longest_name_of_a_file_is_taken(tmp_path: Any) -> None:
    name = "/".join(["x" * 100] * 5)
    check({"do": "save_scenario", "name": name})
    assert place_for(tmp_path, name, ".toml").suffix == ".toml"
