"""Texts that were changed in a browser keep the line ends of their files."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest

import amorsim as am
from amorsim.ui.editor.session import EditSession
from amorsim.ui.editor.storage.line_ends import with_line_ends
from tests.ui.editor.talking import do, talk


def plain(text: str) -> str:
    """A text as a browser gives it back."""
    return re.sub("\r\n?", "\n", text)


@pytest.mark.parametrize(
    ("before", "typed", "after"),
    [
        ("a\r\nb\r\n", "a\nb\n", "a\r\nb\r\n"),
        ("a\r\nb\r\n", "a\nnew\nb\n", "a\r\nnew\r\nb\r\n"),
        ("a\r\nb", "a\nb\nc", "a\r\nb\r\nc"),
        ("a\r\nb\nc\r\nd", "a\nb\nd", "a\r\nb\nd"),  # ends of two kinds
        ("a\r\nb\r\n", "", ""),
        ("a\nb\n", "a\nc\n", "a\nc\n"),
        ("a\r\n\r\n\r\n", "a\n\n", "a\r\n\r\n"),
        ("a\r\n", "b\r\nc\n", "b\r\nc\n"),  # with ends of its own
    ],
)
def test_lines_keep_their_ends(before: str, typed: str, after: str) -> None:
    assert with_line_ends(typed, before) == after


def test_what_is_typed_is_what_is_there_but_for_its_ends() -> None:
    chance = random.Random(5)
    for _ in range(500):
        before = "".join(chance.choices(["a", "b", "\r\n", "\n"], k=chance.randrange(12)))
        assert with_line_ends(plain(before), before) == before
        letters = list(plain(before))
        start = chance.randrange(len(letters) + 1)
        letters[start : start + chance.randrange(3)] = chance.choices("ab\n", k=2)
        typed = "".join(letters)
        assert plain(with_line_ends(typed, before)) == typed


def test_the_text_and_a_program_with_carriage_returns_keep_them(tmp_path: Path) -> None:
    file, program = tmp_path / "mine.toml", tmp_path / "drive.py"
    am.open_document("demo").save(file, copy=True)
    file.write_bytes(file.read_bytes().replace(b"\n", b"\r\n"))
    program.write_bytes(b"import amorsim as am\r\n\r\n\r\ndef drive(readings):\r\n    return am.Twist(0.1, 0.0)\r\n")
    before, code = file.read_bytes(), program.read_bytes()

    async def say(session: EditSession) -> None:
        shown = plain((await do(session, do="text"))["text"])
        await do(session, do="edit", label="text", changes=[{"op": "text", "text": shown}])
        assert session.state()["steps"] == 0
        changed = shown.replace("[simulation]\n", "[simulation]\n# mine\n")
        await do(session, do="edit", label="text", changes=[{"op": "text", "text": changed}])
        shown = plain((await do(session, do="code", file="drive.py"))["text"])
        said = await do(session, do="save_code", file="drive.py", text=shown.replace("0.1", "0.2"))
        assert said["is_saved"]
        assert session.meant[program] == work_text(session, program)
        await do(session, do="save")

    talk(str(file), tmp_path, say, may_run_code=True)
    assert file.read_bytes() == before.replace(b"[simulation]\r\n", b"[simulation]\r\n# mine\r\n")
    assert program.read_bytes() == code.replace(b"0.1", b"0.2")


def work_text(session: EditSession, program: Path) -> str:
    return session.work.program(program.name).text
