"""The first difference between the files of two runs."""

from __future__ import annotations

from pathlib import Path

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
