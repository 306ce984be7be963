"""What is edited survives: its steps are there again, whatever ended the process or has become of the files."""

from __future__ import annotations

import json
import random
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import amorsim as am
from amorsim.ui.editor.history import difference
from amorsim.ui.editor.work import Work


class User:
    """Opens the same again and again, as after each end of a server."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.work: Work | None = None

    def open(self, name: str) -> Work:
        self.close()
        self.work = Work(name, self.folder, state=self.folder / ".state")
        return self.work

    def close(self) -> None:
        if self.work is not None:
            self.work.close()


@pytest.fixture
def user(tmp_path: Path) -> Iterator[User]:
    one = User(tmp_path)
    yield one
    one.close()


def seed(work: Work, value: int) -> None:
    work.edit(f"seed {value}", lambda work: work.document.set("simulation.seed", value))


def wall(work: Work, x: float) -> None:
    work.edit("wall", lambda work: work.world.walls(add=[[x, 1.0, x, 2.0]]))


def test_steps_and_work_that_was_not_saved_are_there_again(user: User) -> None:
    work = user.open("demo")
    seed(work, 5)
    wall(work, 3.0)
    seed(work, 6)
    work.undo()
    texts, done, undone = work.texts, work.steps.history.done, work.steps.history.undone
    again = user.open("demo")
    assert again.texts == texts
    assert again.steps.history.done == done
    assert again.steps.history.undone == undone
    assert "not saved" in again.steps.remark
    assert again.redo() == "seed 6"
    while again.undo():
        pass
    assert again.text == am.open_document("demo").text
    assert again.is_saved


def test_a_saved_scenario_keeps_its_steps_and_says_nothing(user: User, tmp_path: Path) -> None:
    work = user.open("demo")
    seed(work, 5)
    wall(work, 3.0)
    work.save_as(tmp_path / "mine.toml")
    seed(work, 6)
    work.save()
    again = user.open(str(tmp_path / "mine.toml"))
    assert again.steps.remark == ""
    assert again.is_saved
    assert [step.label for step in again.steps.history.done] == ["seed 5", "wall", "seed 6"]
    while again.undo():
        pass
    again.save()
    assert (tmp_path / "mine.toml").read_text() == am.open_document("demo").text
    assert (tmp_path / "office.wld").read_bytes() == am.open_document("demo").path.with_name("office.wld").read_bytes()
    # The bundled one begins afresh.
    assert user.open("demo").steps.history.done == []


def test_a_file_that_was_changed_between_is_taken_as_it_is_and_can_be_undone(user: User, tmp_path: Path) -> None:
    work = user.open("demo")
    seed(work, 5)
    file = work.save_as(tmp_path / "mine.toml")
    user.close()
    other = file.read_text().replace("seed = 5", "seed = 50")
    file.write_text(other)
    again = user.open(str(file))
    assert again.text == other
    assert again.files_changed == []
    assert again.undo() == "changed by hand"
    assert again.document.get("simulation.seed") == 5


def test_work_that_was_not_saved_is_not_lost_to_a_change_by_hand(user: User, tmp_path: Path) -> None:
    file = user.open("demo").save_as(tmp_path / "mine.toml")
    work = user.open(str(file))
    seed(work, 5)
    user.close()
    file.write_text(file.read_text().replace("duration = 300.0", "duration = 3.0"))
    again = user.open(str(file))
    assert again.document.get("simulation.seed") == 5
    assert again.files_changed == [file]
    again.reload()
    assert again.document.get("simulation.duration") == 3.0
    assert again.document.get("simulation.seed") == 1
    again.undo()
    assert again.document.get("simulation.seed") == 5


def test_what_has_no_file_can_begin_again(user: User) -> None:
    work = user.open("")
    wall(work, 3.0)
    again = user.open("")
    assert again.world.file is not None
    again.reload()
    assert again.text == Work("", user.folder).text


def test_two_editors_of_one_scenario_do_not_write_one_journal(user: User, tmp_path: Path) -> None:
    work = user.open("demo")
    other = Work("demo", tmp_path, state=tmp_path / ".state")
    assert "another Editor" in other.steps.remark
    seed(other, 9)
    seed(work, 5)
    assert [step.label for step in user.open("demo").steps.history.done] == ["seed 5"]


def test_a_journal_that_cannot_be_read_is_begun_again(user: User, tmp_path: Path) -> None:
    seed(user.open("demo"), 5)
    user.close()
    (file,) = (tmp_path / ".state" / "edit").glob("*.jsonl")
    for text in ("", "nothing", "[]", json.dumps({"format": 99}), '{"format": 1, "texts": 3, "saved": {}}'):
        file.write_text(text)
        assert user.open("demo").steps.history.done == []
    lines = [
        '{"format": 1, "texts": {"": "format = 1\\n"}, "saved": {}}',
        '{"step": "x", "patches": {"": [11, "", "# one\\n"]}}',
        '{"step": "y", "patch',
    ]
    user.close()
    file.write_text("\n".join(lines))
    work = user.open("demo")
    assert work.text == "format = 1\n# one\n"
    assert len(work.steps.history.done) == 1


def test_a_state_folder_that_cannot_be_written_is_said_and_stops_nothing(tmp_path: Path) -> None:
    (tmp_path / "state").write_text("a file, and no folder")
    work = Work("demo", tmp_path, state=tmp_path / "state")
    assert "steps are not kept" in work.steps.remark
    seed(work, 5)
    assert work.undo() == "seed 5"


def test_five_hundred_steps_can_be_undone_and_the_journal_stays_small(user: User, tmp_path: Path) -> None:
    work = user.open("demo")
    for number in range(510):
        seed(work, number + 2)
    again = user.open("demo")
    assert len(again.steps.history.done) == 500
    (file,) = (tmp_path / ".state" / "edit").glob("*.jsonl")
    assert file.stat().st_size < 100_000
    while again.undo():
        pass
    assert again.document.get("simulation.seed") == 11


def test_a_difference_is_the_shortest_and_leads_both_ways() -> None:
    draw = random.Random(1)
    for _ in range(300):
        old, new = ("".join(draw.choices("ab", k=draw.randrange(12))) for _ in range(2))
        patch = difference(old, new)
        assert patch.apply(old) == new
        assert patch.apply(new, back=True) == old
    assert difference("seed = 1\n", "seed = 12\n") == (8, "", "2")


EDITING = """
import sys
from pathlib import Path
from amorsim.ui.editor.work import Work
work = Work("demo", Path(sys.argv[1]), state=Path(sys.argv[1]) / ".state")
for number in range(len(work.steps.history.done), 100_000):
    work.edit("seed", lambda work: work.document.set("simulation.seed", number + 2))
    print(number + 2, flush=True)
"""


@pytest.mark.long
def test_a_killed_editor_loses_nothing_that_it_has_answered(tmp_path: Path) -> None:
    """Twice; `test_killed` does it 200 times."""
    draw = random.Random(2)
    last = 0
    for _ in range(2):
        process = subprocess.Popen([sys.executable, "-c", EDITING, str(tmp_path)], stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        for _ in range(draw.randrange(1, 30)):
            last = int(process.stdout.readline())
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
        work = Work("demo", tmp_path, state=tmp_path / ".state")
        assert last <= work.document.get("simulation.seed")
        work.close()
