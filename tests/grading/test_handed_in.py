"""What is handed in is read without following links, and nothing of others is with it."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import amorsim as am
from amorsim.grading.grade import grade
from amorsim.grading.handed_in import hand_in
from tests.grading.courses import GOOD, RUBRIC, make_course


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """A submission in a folder of its own, and a file of the lecturer beside that."""
    folder = tmp_path / "ben"
    (folder / "data").mkdir(parents=True)
    (tmp_path / "letter.txt").write_text("of the lecturer")
    (folder / "ben.py").write_text(GOOD)
    (folder / "data" / "gains.txt").write_text("0.4")
    return folder / "ben.py"


def test_a_submission_with_a_folder_of_its_own_has_all_files_in_it(own: Path) -> None:
    (own.parent / "__pycache__").mkdir()
    (own.parent / "__pycache__" / "ben.pyc").touch()
    (own.parent / ".git").mkdir()
    (own.parent / ".git" / "HEAD").touch()
    found = hand_in(own, [own.parent.parent / "rubric.toml"])
    assert found.files == {"ben.py": GOOD.encode(), "data/gains.txt": b"0.4"}
    assert found.left_out == ()


@pytest.mark.parametrize("other", ["rubric.toml", "data/ann.py", "."])
def test_a_submission_that_lies_with_others_has_its_file_alone(own: Path, other: str) -> None:
    assert list(hand_in(own, [own.parent / other]).files) == ["ben.py"]


def test_files_beside_a_submission_go_with_it(own: Path) -> None:
    (own.parent / "policy.onnx").write_bytes(b"weights")
    (own.parent / "notes.txt").write_bytes(b"private")
    found = hand_in(own, [own.parent / "rubric.toml"], beside=["policy.onnx", "missing.onnx"])
    assert found.files == {"ben.py": own.read_bytes(), "policy.onnx": b"weights"}
    # A link leads to another's file, and stays out.
    (own.parent / "policy.onnx").unlink()
    (own.parent / "policy.onnx").symlink_to(own.parent / "notes.txt")
    found = hand_in(own, [own.parent / "rubric.toml"], beside=["policy.onnx"])
    assert (list(found.files), found.left_out) == (["ben.py"], ("policy.onnx",))


def test_files_of_the_rubric_replace_those_of_the_same_name(own: Path) -> None:
    given = own.parent.parent / "ben.py"
    given.write_text("of the rubric")
    assert hand_in(own, (), [given]).files["ben.py"] == b"of the rubric"


def test_links_are_left_out(own: Path) -> None:
    folder, letter = own.parent, own.parent.parent / "letter.txt"
    (folder / "link.txt").symlink_to(letter)
    (folder / "folder").symlink_to(folder.parent)
    (folder / "hard.txt").hardlink_to(letter)
    (folder / "nowhere").symlink_to("none")
    os.mkfifo(folder / "pipe")  # reading it would wait for a writer
    found = hand_in(own)
    assert sorted(found.files) == ["ben.py", "data/gains.txt"]
    assert sorted(found.left_out) == ["folder", "hard.txt", "link.txt", "nowhere", "pipe"]


def test_too_much_is_refused_before_it_is_read(own: Path) -> None:
    with (own.parent / "large.bin").open("wb") as file:
        file.truncate(10**12)
    with pytest.raises(am.ControllerError, match="its folder holds more than 100 MB"):
        hand_in(own)
    (own.parent / "large.bin").unlink()
    for number in range(2001):
        (own.parent / f"{number}").touch()
    with pytest.raises(am.ControllerError, match="its folder holds more than 2000 files"):
        hand_in(own)


@pytest.mark.long
def test_links_to_others_work_earn_nothing_and_cost_the_others_nothing(tmp_path: Path) -> None:
    course = make_course(tmp_path / "course", RUBRIC)
    ann = tmp_path / "handed-in" / "ann"
    ann.mkdir(parents=True)
    (ann / "main.py").write_text("raise ValueError('ann')")
    (ann / "data.txt").write_text("of ann")
    for name in ("file", "folder", "deep", "hard", "gone"):
        (ann.parent / name).mkdir()
    (ann.parent / "file" / "main.py").symlink_to(ann / "main.py")
    (ann.parent / "folder" / "inner").symlink_to(ann)
    (ann.parent / "deep" / "inner").symlink_to(ann.parent)
    (ann.parent / "hard" / "main.py").hardlink_to(course)
    (ann.parent / "gone" / "main.py").symlink_to("none.py")
    paths = [
        *(ann / "main.py", ann.parent / "file" / "main.py", ann.parent / "folder" / "inner" / "main.py"),
        *(ann.parent / "deep" / "inner" / "ann" / "main.py", ann.parent / "hard" / "main.py"),
        ann.parent / "gone" / "main.py",
    ]
    own, *linked = grade(course, paths, tmp_path / "grades", fence=False)
    assert "ValueError: ann" in own.cases[0].problem
    for each in linked:
        assert each.total == 0.0
        assert "link" in each.cases[0].problem
    table = (tmp_path / "grades" / "grades.csv").read_text()
    assert table.count("link") == len(linked)


@pytest.mark.parametrize(
    ("stems", "labels"),
    [
        (["ann", "ben"], ["ann", "ben"]),
        (["a b", "a_b", "a_b-2"], ["a_b", "a_b-2", "a_b-2-2"]),
        (["Ann", "ann"], ["Ann", "ann-2"]),
        (["x" * 250], ["x" * 100]),
        (["half \udcff"], ["half_"]),
    ],
)
def test_each_submission_has_a_page_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stems: list[str], labels: list[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for stem in stems:
        Path(f"{stem}.py").write_text("raise ValueError")
    course = make_course(tmp_path / "course", RUBRIC)
    monkeypatch.setattr("amorsim.grading.grade.hand_in", lambda *_: (_ for _ in ()).throw(OSError("not read")))
    found = grade(course, [f"{stem}.py" for stem in stems], "grades", fence=False)
    assert [each.label for each in found] == labels
    assert len(list(Path("grades").glob("*.html"))) == len(stems)
