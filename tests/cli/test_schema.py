"""``amorsim schema``, and the schema that ``amorsim new`` writes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from amorsim.schemas import KINDS, make_schema
from tests.cli.conftest import Command


def test_the_command_prints_it(amorsim: Command) -> None:
    for kind in KINDS:
        result = amorsim("schema", kind)
        assert json.loads(result.out)["title"] == f"amorsim {kind}"
    assert amorsim("schema", "study", "--out", "study.schema.json").out == ""
    assert json.loads(Path("study.schema.json").read_text(encoding="utf-8")) == make_schema("study")
    assert "no/where.json" in amorsim("schema", "--out", "no/where.json").err
    wrong = amorsim("schema", "studdy")
    assert wrong.status == 2
    assert "Did you mean 'study'?" in wrong.err


def test_a_new_scenario_names_its_schema(amorsim: Command) -> None:
    assert amorsim("new", "mine").status == 0
    text = Path("mine/scenario.toml").read_text(encoding="utf-8")
    assert text.startswith("#:schema scenario.schema.json\n# A Pioneer")
    assert json.loads(Path("mine/scenario.schema.json").read_text(encoding="utf-8")) == make_schema("scenario")
    assert amorsim("new", "other", "--from", "mine/scenario.toml", "--copy").status == 0
    assert Path("other/scenario.toml").read_text(encoding="utf-8").count("#:schema") == 1


@pytest.mark.long
def test_a_byte_order_mark_and_line_ends_stay(amorsim: Command) -> None:
    assert amorsim("new", "mine").status == 0
    scenario = Path("mine/scenario.toml")
    text = scenario.read_text(encoding="utf-8").split("\n", 1)[1]
    scenario.write_bytes(("\N{BOM}" + text.replace("\n", "\r\n")).encode())
    assert amorsim("new", "other", "--from", scenario, "--copy").status == 0
    made = Path("other/scenario.toml").read_bytes().decode()
    assert "\r\n\r\nformat = 1\r\n" in made
    assert made.count("\N{BOM}") == made.startswith("\N{BOM}")
    assert amorsim("check", "other/scenario.toml").status == 0
