"""The folder of a study knows all files that the study depends on, and is refused when one of them was changed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

import amorsim as am
from amorsim.scenario.reading.read import load
from amorsim.sweeps import folder
from amorsim.sweeps.read import read_plan
from tests.sweeps.studies import study_file, tables

MAP = "image: {image}\nresolution: 0.5\norigin: [0.0, 0.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n"
PROGRAM = """\
import amorsim as am
import swept_helper


def drive(readings, estimate, clock):
    return am.Twist(swept_helper.SPEED, 0.0)
"""


def test_a_study_whose_axis_names_a_map_of_two_files_is_refused_when_the_picture_was_changed(tmp_path: Path) -> None:
    given = tables(tmp_path / "s")
    for name in ("hall", "yard"):
        Image.new("L", (20, 12), 255).save(tmp_path / "s" / f"{name}.png")
        (tmp_path / "s" / f"{name}.yaml").write_text(MAP.format(image=f"{name}.png"))
    given["axes"] = {"world.map": [str(tmp_path / "s" / f"{name}.yaml") for name in ("hall", "yard")]}
    am.sweep(given, tmp_path / "out")
    am.sweep(given, tmp_path / "out")
    picture = Image.new("L", (20, 12), 255)
    picture.putpixel((18, 10), 0)
    picture.save(tmp_path / "s" / "yard.png")
    with pytest.raises(am.StudyError, match=r"begun with another yard.yard\.png of world\.map = .*yard\.yaml;"):
        am.sweep(given, tmp_path / "out")


def test_a_study_whose_axis_names_a_program_is_refused_when_a_file_that_it_imports_was_changed(tmp_path: Path) -> None:
    given = tables(tmp_path / "s")
    (tmp_path / "s" / "own.py").write_text(PROGRAM)
    (tmp_path / "s" / "swept_helper.py").write_text("SPEED = 0.2\n")
    variants = {
        "square": {"robots.rover.controller": {"use": "square"}},
        "own": {"robots.rover.controller": {"use": f"{tmp_path / 's' / 'own.py'}:drive"}},
    }
    given["axes"] = {"controller": {"variants": variants}}
    assert not any(am.sweep(given, tmp_path / "out")["error"])
    (tmp_path / "s" / "swept_helper.py").write_text("SPEED = 0.3\n")
    with pytest.raises(am.StudyError, match=r"begun with another swept_helper\.py of controller = own;"):
        am.sweep(given, tmp_path / "out")


def test_a_file_in_the_present_folder_belongs_to_the_study_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    given = tables(tmp_path / "s", axes={"world.map": ["own.wld"]})
    here = tmp_path / "here"
    here.mkdir()
    rooms = (tmp_path / "s" / "rooms.wld").read_text()
    (here / "own.wld").write_text(rooms)
    monkeypatch.chdir(here)
    study = study_file(tmp_path / "s" / "study.toml", given)
    assert not any(am.sweep(study, tmp_path / "out")["error"])
    monkeypatch.chdir(tmp_path)
    with pytest.raises(am.StudyError, match=r"no value of this axis can be set: .*own\.wld"):
        am.sweep(study, tmp_path / "out")
    (tmp_path / "own.wld").write_text(rooms)
    with pytest.raises(am.StudyError, match=r"begun with another .*own\.wld"):
        am.sweep(study, tmp_path / "out")


def test_a_map_that_many_values_of_an_axis_name_is_read_once_to_begin_a_study(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = tables(tmp_path / "s")
    own = str(tmp_path / "s" / "rooms.wld")
    given["axes"] = {"robots.rover.knowledge": [{"map": own, "landmarks": [[0.1 * x, 1.0]]} for x in range(1, 30)]}
    plan = read_plan(given)
    read: list[object] = []

    def counted(*given: Any) -> am.Scenario:
        read.append(given)
        return load(*given)

    monkeypatch.setattr(folder, "load", counted)
    folder.inputs_of(plan, load(plan.scenario))
    assert len(read) == 1


def test_a_study_is_refused_with_another_version_of_a_plugin(tmp_path: Path) -> None:
    given = tables(tmp_path / "s")
    am.sweep(given, tmp_path / "out")
    file = tmp_path / "out" / "study.json"
    about = json.loads(file.read_text())
    file.write_text(json.dumps(about | {"plugins": about["plugins"] | {"amorsim-mine": "0.1"}}))
    with pytest.raises(am.StudyError, match=r"plugins was .*amorsim-mine 0\.1 and is "):
        am.sweep(given, tmp_path / "out")
