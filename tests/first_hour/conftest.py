"""Runs what the documentation shows, as it shows it."""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import sys
import tomllib
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import attrs
import pytest

from amorsim.cli import main
from amorsim.grading.questions import read_questions
from amorsim.grading.rubric import read_rubric
from amorsim.scenario.reading.read import loads
from amorsim.sweeps.read import read_plan

ROOT = Path(__file__).resolve().parents[2]

_BLOCK = re.compile(r"^```(\w*)(?: ([\w./-]+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")
_STATUS = re.compile(r"\[exit status (\d+)\]")
# What a run says while it goes: how much of it, and when, depends on how fast it goes.
_PROGRESS = re.compile(r"compiling the kernels|\d+ % simulated")
# The last bits of sines differ between machines, and a loop that feeds them back makes more of them: a number may
# differ by so much of itself, and one with decimals by one of its last digit.
_TOLERANCE = 0.02

ROVER = '[[robots]]\nname = "rover"\nmodel = "pioneer2dx"\npose = { x = 1.0, y = 1.0 }\n'
ROOMS = ROOT / "amorsim" / "cli" / "template" / "rooms.wld"
WORLD = f"[world]\nmap = '{ROOMS}'\n"


@attrs.frozen
class Block:
    """A fenced block of a page: its language, the file it stands for or nothing, and its text."""

    language: str
    file: str
    text: str


def blocks_of(page: Path) -> list[Block]:
    """The fenced blocks of a page, in order."""
    return [Block(language, file, text) for language, file, text in _BLOCK.findall(page.read_text(encoding="utf-8"))]


def check_output(expected: str, got: str) -> None:
    """Fail unless `got` is what was expected, line by line; numbers may differ a little, and ``...`` is anything."""
    lines = [line.rstrip() for line in got.splitlines() if not _PROGRESS.match(line)]
    pattern = "\n".join(_pattern(line.rstrip()) for line in expected.splitlines())
    found = re.fullmatch(pattern, "\n".join(lines), re.DOTALL)
    assert found, f"expected:\n{expected}\ngot:\n{got}"
    numbers = [text for line in expected.splitlines() for text in _NUMBER.findall(line)]
    for wanted, text in zip(numbers, found.groups(), strict=True):
        assert float(text) == pytest.approx(float(wanted), rel=_TOLERANCE, abs=_last_digit(wanted)), (
            f"expected {wanted}, got {text}, in:\n{expected}\ngot:\n{got}"
        )


def _last_digit(number: str) -> float:
    """What one of the last digit of a written number with decimals is worth; 0 for a whole number."""
    digits, _, exponent = number.partition("e")
    decimals = len(digits.partition(".")[2])
    return 1.001 * 10.0 ** (int(exponent or 0) - decimals) if decimals else 0.0


def _pattern(line: str) -> str:
    if line == "...":
        return ".*?"
    parts = []
    for piece in line.split("..."):
        rest = 0
        escaped = ""
        for number in _NUMBER.finditer(piece):
            escaped += _words(piece[rest : number.start()]) + f"({_NUMBER.pattern})"
            rest = number.end()
        parts.append(escaped + _words(piece[rest:]))
    return r"[^\n]*".join(parts)


def _words(text: str) -> str:
    # The number of blanks before a number depends on its length.
    return re.sub(r"(?:\\ )+", lambda _: r"[ ]+", re.escape(text))


def amorsim(command: str, monkeypatch: pytest.MonkeyPatch) -> tuple[int, str]:
    """Exit status and output (what was complained of too, in order) of a command line that begins with amorsim."""
    out = io.StringIO()
    monkeypatch.setattr("sys.argv", shlex.split(command))
    status = 0
    with warnings.catch_warnings(), contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        try:
            main()
        except SystemExit as leaving:
            status = int(leaving.code or 0)
    return status, out.getvalue()


def run_console(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run each ``$ amorsim ...`` of a console block, and compare the lines after it with what it prints.

    Its exit status is 0, unless its last line says ``[exit status 2]``.
    """
    for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
        command, _, expected = part.partition("\n")
        assert command.startswith("amorsim "), command
        wanted = 0
        if stated := _STATUS.search(expected):
            wanted = int(stated[1])
            expected = expected[: stated.start()]
        status, got = amorsim(command, monkeypatch)
        assert status == wanted, f"{command} ended with {status}:\n{got}"
        check_output(expected, got)


def check_toml(block: Block, sensors: dict[str, Any]) -> None:
    """Read a scenario, or put a part of one into a whole and read that; a file is written, too.

    A part's robot has the `sensors` of the parts before it, and gives its own to those after it.
    """
    if block.file:
        Path(block.file).parent.mkdir(parents=True, exist_ok=True)
        Path(block.file).write_text(block.text, encoding="utf-8")
    given = tomllib.loads(block.text)
    if "metrics" in given:
        read_plan(block.file or given)
        return
    if "criteria" in given:
        read_rubric(block.file)
        return
    if "questions" in given:
        read_questions(block.file)
        return
    text = block.text
    if "drive" in given:
        return  # a robot's model, which is read by the scenario that names it
    is_part = not isinstance(given.get("robots"), list)
    if is_part:
        text = ROVER + text
    if "world" not in given:
        text = WORLD + text
    if "format" not in given:
        text = "format = 1\n" + text
    tables = tomllib.loads(text)
    if is_part:
        sensors |= tables["robots"][0].get("sensors", {})
        tables["robots"][0]["sensors"] = dict(sensors)
    folder = (Path.cwd() / block.file).parent if block.file else Path.cwd()
    loads(tables, folder, name="the page")


@attrs.define
class Page:
    """Runs the blocks of one page, in order, as a reader who follows it would."""

    monkeypatch: pytest.MonkeyPatch
    names: dict[str, Any] = attrs.field(factory=lambda: {"__name__": "__page__"})
    sensors: dict[str, Any] = attrs.field(factory=dict)
    printed: str = ""
    ran: int = 0

    def lend_maps(self) -> None:
        """Put the maps into the folder that pages name which show parts of files and run no command."""
        for name in ("rooms.wld", "room.wld", "hall.wld"):
            Path(name).write_bytes(ROOMS.read_bytes())

    def run(self, block: Block) -> None:
        """Run or read a block; a ``text`` block after Python is what it prints."""
        before, self.printed = self.printed, ""
        if block.language == "console":
            run_console(block.text, self.monkeypatch)
        elif block.language == "python" and not block.file:
            self.printed = self._python(block.text)
        elif block.language == "toml":
            check_toml(block, self.sensors)
        elif block.file:
            Path(block.file).write_text(block.text, encoding="utf-8")
        elif block.language == "text" and before:
            check_output(block.text, before)
        else:
            return
        self.ran += 1

    def _python(self, text: str) -> str:
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(text, "<page>", "exec"), self.names)
        return out.getvalue()


@pytest.fixture
def page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Page]:
    """A page to run in a folder of its own, an empty one; its modules are imported from there, and forgotten."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    yield Page(monkeypatch)
    for name, module in list(sys.modules.items()):
        if (getattr(module, "__file__", None) or "").startswith(str(tmp_path)):
            del sys.modules[name]
