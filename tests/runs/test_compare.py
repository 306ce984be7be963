"""The first difference between the files of two runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from amorsim.runs.compare import first_difference

POSES = "time,robot,true_x\n0.000000,rover,1.000000\n0.100000,rover,1.100000\n0.200000,rover,1.200000\n"
COMMANDS = "time,robot,left\n0.000000,rover,0.0\n0.100000,rover,2.5\n0.200000,rover,2.5\n"


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, Path]:
    for name in ("old", "new"):
        (tmp_path / name / "sensors").mkdir(parents=True)
        (tmp_path / name / "poses.csv").write_text(POSES)
        (tmp_path / name / "commands.csv").write_text(COMMANDS)
        (tmp_path / name / "sensors" / "gyro.csv").write_text(POSES)
    return tmp_path / "old", tmp_path / "new"


def test_equal_files_do_not_differ(folders: tuple[Path, Path]) -> None:
    assert first_difference(*folders, dt=0.1) is None


def test_the_earliest_difference_of_all_files_is_named(folders: tuple[Path, Path]) -> None:
    (folders[1] / "commands.csv").write_text(COMMANDS.replace("0.200000,rover,2.5", "0.200000,rover,2.75"))
    (folders[1] / "poses.csv").write_text(POSES.replace("1.100000", "1.300000"))
    found = first_difference(*folders, dt=0.1)
    assert found is not None
    assert (found.file, found.line, found.tick, found.robot, found.column) == ("poses.csv", 3, 1, "rover", "true_x")
    assert (found.old, found.new, found.is_small) == ("1.100000", "1.300000", False)
    assert "tick 1" in str(found)
    assert "'rover'" in str(found)


def test_at_one_time_the_command_comes_before_the_pose_that_it_led_to(folders: tuple[Path, Path]) -> None:
    (folders[1] / "commands.csv").write_text(COMMANDS.replace("0.100000,rover,2.5", "0.100000,rover,2.75"))
    (folders[1] / "poses.csv").write_text(POSES.replace("1.100000", "1.300000"))
    found = first_difference(*folders, dt=0.1)
    assert found is not None
    assert found.file == "commands.csv"


@pytest.mark.parametrize(("number", "is_small"), [("1.100001", True), ("1.100003", False), ("nan", False)])
def test_small_differences_are_distinguished_from_others(
    folders: tuple[Path, Path], number: str, is_small: bool
) -> None:
    (folders[1] / "poses.csv").write_text(POSES.replace("1.100000", number))
    found = first_difference(*folders, dt=0.1)
    assert found is not None
    assert found.is_small is is_small


def test_a_small_difference_does_not_hide_a_large_one_behind_it(folders: tuple[Path, Path]) -> None:
    (folders[1] / "poses.csv").write_text(POSES.replace("1.100000", "1.100001").replace("1.200000", "1.300000"))
    found = first_difference(*folders, dt=0.1)
    assert found is not None
    assert (found.line, found.is_small) == (3, False)


def test_lines_and_files_may_be_missing(folders: tuple[Path, Path]) -> None:
    (folders[1] / "poses.csv").write_text(POSES.rsplit("\n", 2)[0] + "\n")
    found = first_difference(*folders, dt=0.1)
    assert found is not None
    assert (found.tick, found.new) == (2, "not there")
    (folders[0] / "poses.csv").write_text(POSES.rsplit("\n", 2)[0] + "\n")
    (folders[1] / "sensors" / "gyro.csv").unlink()
    found = first_difference(*folders, dt=0.1)
    assert found is not None
    assert (found.file, found.old, found.new) == ("sensors/gyro.csv", "there", "not there")


def test_values_with_commas_are_compared_cell_by_cell(folders: tuple[Path, Path]) -> None:
    header = "time,robot,kind,value,tick\n"
    (folders[0] / "events.csv").write_text(header + '0.100000,rover,pose_set,"[1.0, 2.0]",1\n')
    (folders[1] / "events.csv").write_text(header + '0.100000,rover,pose_set,"[1.0, 2.5]",1\n')
    found = first_difference(*folders, dt=0.1)
    assert found is not None
    assert (found.column, found.old, found.new) == ("value", "[1.0, 2.0]", "[1.0, 2.5]")


def arrays(folder: Path, tick: int = 1, **changes: Any) -> Path:
    """A file of beliefs of two robots, as the recorder `arrays` writes it."""
    path = folder / "beliefs" / "slam" / f"{tick:09d}.npz"
    path.parent.mkdir(parents=True, exist_ok=True)
    whole = {
        "particles": np.array([[[1.0, 2.0]], [[3.0, np.nan]]]),
        "count": np.array([7, 8]),
        "time": np.array([0.1, 0.1]),
        "robot": np.array(["rover", "scout"]),
        "replica": np.array([4, 4]),
    }
    np.savez_compressed(path, **(whole | changes))
    return path


def test_arrays_of_beliefs_are_compared_number_by_number(folders: tuple[Path, Path]) -> None:
    for folder in folders:
        arrays(folder)
    assert first_difference(*folders, dt=0.1) is None
    # Packed in another way, it is the same.
    path = arrays(folders[1])
    with np.load(path) as whole:
        np.savez(path, **dict(whole))
    assert first_difference(*folders, dt=0.1) is None
    arrays(folders[1], particles=np.array([[[1.0, 2.0]], [[3.5, np.nan]]]))
    found = first_difference(*folders, dt=0.1)
    assert found is not None
    assert (found.file, found.tick, found.robot, found.replica) == ("beliefs/slam/000000001.npz", 1, "scout", "4")
    assert (found.column, found.old, found.new, found.is_small) == ("particles_0_0", "3.0", "3.5", False)
    assert str(found).endswith("in beliefs/slam/000000001.npz: particles_0_0 was 3.0 and is 3.5")


@pytest.mark.parametrize(
    ("changes", "is_small"),
    [
        ({"particles": np.array([[[1.0, 2.0000001]], [[3.0, np.nan]]])}, True),
        ({"particles": np.array([[[1.0, 2.0000001]], [[3.0, 1.0]]])}, False),
        ({"particles": np.array([[[1.0, 2.0000001]], [[3.0, np.nan]]]), "count": np.array([7, 9])}, False),
        ({"particles": np.array([[1.0, 2.0], [3.0, np.nan]])}, False),
        ({"particles": np.zeros((2, 10**5))}, False),
        ({"count": np.array([7.0, 8.0])}, False),
    ],
)
def test_small_differences_of_arrays_are_distinguished_from_others(
    folders: tuple[Path, Path], changes: dict[str, Any], is_small: bool
) -> None:
    arrays(folders[0], **changes)
    arrays(folders[1])
    found = first_difference(*folders, dt=0.1)
    assert found is not None
    assert found.is_small is is_small


def test_files_of_arrays_may_be_missing_or_damaged(folders: tuple[Path, Path]) -> None:
    for folder in folders:
        arrays(folder)
        arrays(folder, tick=2)
    path = folders[0] / "beliefs" / "slam" / "000000002.npz"
    for damage in (b"", path.read_bytes()[:-100], path.read_bytes().replace(b"count", b"thing")):
        path.write_bytes(damage)
        found = first_difference(*folders, dt=0.1)
        assert found is not None
        assert (found.file, found.tick, found.is_small) == ("beliefs/slam/000000002.npz", 2, False)
    path.unlink()
    found = first_difference(*folders, dt=0.1)
    assert found is not None
    assert (found.old, found.new) == ("not there", "there")
