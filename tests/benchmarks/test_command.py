"""The command: what it refuses, and that it leaves a table, the same as JSON, and a picture."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from benchmarks import command, memory, rays, table
from benchmarks.results import Row
from benchmarks.worlds import line_room


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["--only", "rays,spped"], "no section 'spped'"),
        (["--rounds", "0"], "whole number > 0, got '0'"),
        (["--threads", "0"], "whole number > 0, got '0'"),
        (["--threads", "2", "--clock", "cpu"], "expected --clock wall"),
        (["--rounds", "x"], "got 'x'"),
    ],
)
def test_mistakes_are_refused(arguments: list[str], why: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        command.main(arguments)
    assert stopped.value.code == 2
    assert why in capsys.readouterr().err


def test_every_section_is_in_the_table() -> None:
    assert list(table.TITLES) == list(command.SECTIONS)


def test_a_table_is_left_in_three_forms(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def little(rounds: int, quick: bool, clock: Any, say: object) -> tuple[list[Row], tuple[float, ...]]:
        return rays._by_size(line_room(0.05), rounds, quick, clock, lambda _: None)

    monkeypatch.setattr(rays, "measure", little)
    assert command.main(["--only", "rays", "--rounds", "2", "--quick", "--out", str(tmp_path / "out")]) == 0
    text = (tmp_path / "out" / "table.txt").read_text(encoding="utf-8")
    document = json.loads((tmp_path / "out" / "table.json").read_text(encoding="utf-8"))
    assert text in capsys.readouterr().out
    assert "room of 40 lines, 50 mm" in text
    ours, plain = document["rows"]
    assert (ours["side"], plain["side"]) == ("amorsim", "plain traversal")
    assert len(ours["rounds"]) == len(plain["rounds"]) == 2
    assert plain["ratio"]["counts"] is True
    assert plain["ratio"]["spread"]["low"] <= plain["ratio"]["spread"]["median"] <= plain["ratio"]["spread"]["high"]
    with Image.open(tmp_path / "out" / "table.png") as picture:
        colours = picture.convert("RGB").getcolors(1 << 20)
        assert colours is not None
        assert {(27, 120, 55), (69, 117, 180)} <= {colour for _, colour in colours}


def test_memory_of_a_world_is_that_of_its_cells(tmp_path: Path) -> None:
    """A process of its own loads the file; what it holds more is about what the cells take."""
    from benchmarks import worlds

    worlds.write_wld(worlds.city_walls(50.0), 50.0, tmp_path / "city.wld")
    answer = memory._child(tmp_path / "city.wld")
    assert 1e6 < answer["grid"] < 30e6
    assert answer["resident"] < answer["grid"] + 20e6
    assert answer["peak"] >= answer["resident"]
    assert answer["seconds"] > 0.0
