"""Files are replaced whole, or stay as they were."""

from __future__ import annotations

import ast
import errno
import os
import stat
from pathlib import Path

import pytest

import amorsim
import amorsim as am
from amorsim.core.errors import MapError, RunError
from amorsim.core.files.atomic_files import check_place, copy_file, create_text, replacing, write_bytes, write_text
from tests.disks import small_disk


def test_a_file_is_made_or_replaced_and_nothing_else_is_left(tmp_path: Path) -> None:
    file = tmp_path / "a.txt"
    write_text(file, "one\r\nµ")
    assert file.read_bytes() == "one\r\nµ".encode()
    write_bytes(file, b"two")
    assert file.read_bytes() == b"two"
    copy_file(file, tmp_path / "b.txt")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.txt", "b.txt"]
    assert (tmp_path / "b.txt").read_bytes() == b"two"


@small_disk()
def test_a_full_disk_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    file = tmp_path / "a.txt"
    file.write_text("old")
    with pytest.raises(RunError, match=r"a\.txt: cannot be written \(File too large\)"):
        write_bytes(file, bytes(1001))
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]
    assert file.read_text() == "old"


def test_the_new_file_is_on_the_disk_before_it_replaces(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "a.txt"
    file.write_text("old")
    seen = []

    def fail(descriptor: int) -> None:
        seen.append((os.fstat(descriptor).st_size, file.read_text()))
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(RunError, match="No space left on device"):
        write_text(file, "newer")
    assert seen == [(5, "old")]
    assert file.read_text() == "old"


def _write_half(file: Path) -> None:
    with replacing(file) as new:
        new.write_text("half")
        raise ValueError("only half of it")


def _write_nothing(file: Path) -> None:
    with replacing(file, MapError):
        pass


def test_an_error_of_the_writer_leaves_everything_as_it_was(tmp_path: Path) -> None:
    file = tmp_path / "a.txt"
    file.write_text("old")
    with pytest.raises(ValueError, match="half"):
        _write_half(file)
    with pytest.raises(MapError, match=r"a\.txt: cannot be written \(No such file or directory\)"):
        _write_nothing(file)
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]
    assert file.read_text() == "old"


def test_a_link_stays_and_its_file_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "real.txt").write_text("old")
    (tmp_path / "link.txt").symlink_to("data/real.txt")
    with replacing(tmp_path / "link.txt") as new:
        assert new.name == "link.txt"
        new.write_text("new")
    assert (tmp_path / "link.txt").is_symlink()
    assert (tmp_path / "data" / "real.txt").read_text() == "new"


def test_files_beside_it_come_too(tmp_path: Path) -> None:
    (tmp_path / "b.png").write_text("old")
    with replacing(tmp_path / "a.yaml") as new:
        (new.parent / "tiles").mkdir()
        for name in ("a.yaml", "b.png", "tiles/c.png"):
            (new.parent / name).write_text(name)
    assert (tmp_path / "b.png").read_text() == "b.png"
    assert (tmp_path / "tiles" / "c.png").read_text() == "tiles/c.png"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.yaml", "b.png", "tiles"]


def test_permissions_are_those_of_the_old_file_or_of_any_new_one(tmp_path: Path) -> None:
    (tmp_path / "plain.txt").write_text("")
    write_text(tmp_path / "new.txt", "")
    assert (tmp_path / "new.txt").stat().st_mode == (tmp_path / "plain.txt").stat().st_mode
    (tmp_path / "new.txt").chmod(0o640)
    write_text(tmp_path / "new.txt", "again")
    assert stat.S_IMODE((tmp_path / "new.txt").stat().st_mode) == 0o640


def test_what_is_no_file_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(RunError, match=r"folder: cannot be written \(Is a directory\)"):
        write_text(tmp_path / "folder", "")
    with pytest.raises(RunError, match=r"pipe: cannot be written \(it is a device or a pipe"):
        write_text(tmp_path / "pipe", "")
    with pytest.raises(RunError, match=r"none/a: cannot be written \(No such file or directory\)"):
        write_text(tmp_path / "none" / "a", "")
    with pytest.raises(RunError, match=r"none: cannot be copied into .* \(No such file or directory\)"):
        copy_file(tmp_path / "none", tmp_path / "copy")


def test_a_name_that_no_file_has_is_refused_in_words(tmp_path: Path) -> None:
    with pytest.raises(am.ParameterError, match=r"path: expected .*, without null characters"):
        write_text(tmp_path / "a\0.txt", "new")


def test_a_file_that_may_not_be_written_is_not_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.txt").write_text("old")
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # for root may write everything
    with pytest.raises(RunError, match=r"a\.txt: cannot be written \(Permission denied\)"):
        write_text(tmp_path / "a.txt", "new")


# What is written by its own means: atomic_files itself, what is written within `replacing`, lines that a run appends
# to, what is set aside for them, and a page for the browser in the temporary folder.
OWN_MEANS = {
    "algorithms/pose_graph/g2o.py",
    "analysis/logs/mcap_file.py",
    "core/files/atomic_files.py",
    "foreign/mobilesim.py",
    "foreign/stage/map.py",
    "grading/child.py",  # into a folder that is gone after the run
    "maps/bmp.py",
    "maps/geojson.py",
    "maps/movingai.py",
    "maps/ros.py",
    "maps/svg.py",
    "maps/wld.py",
    "runs/folder.py",
    "sweeps/table.py",
    "testing/map_loaders.py",
    "testing/scenario_loaders.py",
    "ui/serve/opening.py",
}
WRITES = {"write_text", "write_bytes"}


def test_all_that_replaces_files_goes_through_one_way():
    package = Path(amorsim.__file__).parent
    for file in package.rglob("*.py"):
        name = file.relative_to(package).as_posix()
        if name in OWN_MEANS or name.startswith("cli/template/"):  # which users own
            continue
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.Call):
                continue
            is_method = isinstance(node.func, ast.Attribute) and node.func.attr in WRITES
            modes = [arg.value for arg in node.args if isinstance(arg, ast.Constant) and isinstance(arg.value, str)]
            is_open = getattr(node.func, "attr", getattr(node.func, "id", "")) == "open"
            assert not is_method, f"{name}:{node.lineno} writes a file by its own means; use core.files.atomic_files"
            assert not (is_open and {"w", "wb", "w+"} & set(modes)), f"{name}:{node.lineno} opens a file for writing"


def test_a_place_where_no_file_can_be_written_is_known_beforehand(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for place in (tmp_path, tmp_path / "none" / "x", tmp_path / "file" / "x"):
        with pytest.raises(RunError, match="cannot be written"):
            check_place(place)
    check_place(tmp_path / "new")
    check_place(tmp_path / "file")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_within_a_folder_links_are_replaced_and_never_followed(tmp_path: Path) -> None:
    other = tmp_path / "other"
    other.mkdir()
    (other / "a.txt").write_text("precious")
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "a.txt").symlink_to(other / "a.txt")
    (folder / "dangling.txt").symlink_to(other / "none.txt")
    (folder / "device.txt").symlink_to("/dev/full")
    (folder / "folder.txt").symlink_to(other)
    (folder / "plots").symlink_to(other)
    names = ("a.txt", "dangling.txt", "device.txt", "folder.txt", "plots/a.txt", "plots/more/b.txt")
    for name in names:
        write_text(folder / name, "new", within=folder)
    assert not [path for path in folder.rglob("*") if path.is_symlink()]
    assert all((folder / name).read_text() == "new" for name in names)
    assert [path.name for path in other.iterdir()] == ["a.txt"]
    assert (other / "a.txt").read_text() == "precious"


def test_files_beside_it_stay_within_the_folder_too(tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "tiles").symlink_to(tmp_path / "other")
    with replacing(tmp_path / "run" / "a.yaml", within=tmp_path / "run") as new:
        new.write_text("a")
        (new.parent / "tiles").mkdir()
        (new.parent / "tiles" / "c.png").write_text("c")
    assert (tmp_path / "run" / "tiles" / "c.png").read_text() == "c"
    assert list((tmp_path / "other").iterdir()) == []


def test_a_file_is_created_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    create_text(tmp_path / "a.txt", "first")
    with pytest.raises(FileExistsError):
        create_text(tmp_path / "a.txt", "second")

    def no_links(*_: object) -> None:
        raise OSError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(os, "link", no_links)  # as on FAT
    create_text(tmp_path / "b.txt", "first")
    with pytest.raises(FileExistsError):
        create_text(tmp_path / "b.txt", "second")
    with pytest.raises(RunError, match=r"none/a: cannot be written \(No such file or directory\)"):
        create_text(tmp_path / "none" / "a", "first")
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a.txt": "first", "b.txt": "first"}
