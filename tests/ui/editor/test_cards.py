"""Cards of the galleries: pictures and sentences of scenarios, robots and generated worlds."""

from __future__ import annotations

from pathlib import Path

import pytest

import amorsim as am
from amorsim.plugins.manager import default_registry
from amorsim.ui.editor.cards import KINDS, card_of, sentence_of
from amorsim.ui.forms.manuals import components_of, manual_of

REGISTRY = default_registry()
EVERYTHING = [
    (kind, name)
    for kind in KINDS
    for name in REGISTRY.names(kind)
    if (kind, name) != ("scenario", "swarm")  # a thousand robots say nothing that twenty do not
]


@pytest.mark.parametrize(("kind", "name"), EVERYTHING, ids=lambda value: str(value))
def test_everything_that_is_bundled_has_a_picture_and_a_sentence(kind: str, name: str, tmp_path: Path) -> None:
    card = card_of(kind, name, tmp_path, REGISTRY)
    scene = card["still"]["scene"]
    assert card["sentence"].endswith(".")
    assert "\n" not in card["sentence"]
    if kind == "world_generator":
        assert scene["map"] is not None
    else:
        assert scene["robots"]
    for shape in scene["maps"]:
        if shape["segments"] is None and shape["image"] is not None:
            assert card["pictures"][shape["image"]["name"]]


def test_a_file_of_the_folder_is_read_though_it_has_faults(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text('# My own. It is short.\nformat = 1\n[world]\nmap = "missing.wld"\n')
    card = card_of("scenario", "mine.toml", tmp_path, REGISTRY)
    assert card["sentence"] == "My own."
    assert card["still"]["scene"]["map"] is None


@pytest.mark.parametrize(("kind", "name"), [("scenario", "nothing"), ("robot", "nothing"), ("sonar", "demo")])
def test_what_is_not_there_is_refused(kind: str, name: str, tmp_path: Path) -> None:
    with pytest.raises(am.AmorsimError):
        card_of(kind, name, tmp_path, REGISTRY)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", ""),
        ("format = 1\n# later", ""),
        ("# One line", "One line"),
        ("# Two lines\n# make one. And more.\n\n# Not this.", "Two lines make one."),
        ("#:schema scenario.json\n# What it is about.", "What it is about."),
    ],
)
def test_the_first_sentence_of_a_comment(text: str, sentence: str) -> None:
    assert sentence_of(text) == sentence


def test_a_manual_has_what_it_is_and_its_fields_as_in_files() -> None:
    manual = manual_of("controller", "wander", REGISTRY)
    assert manual["text"].startswith("Roams for ever")
    assert ("speed", "a number [m/s], > 0", "0.4", "at which it drives where there is room") in manual["fields"]
    assert "turn_rate_deg" in [field[0] for field in manual["fields"]]
    for kind, name in (("controller", "nothing"), ("robot", "pioneer2dx"), ("colour", "red")):
        with pytest.raises(am.AmorsimError, match="with a manual"):
            manual_of(kind, name, REGISTRY)


def test_the_parts_of_a_robot_have_the_names_that_they_are_registered_by() -> None:
    (robot,) = am.load("demo").robots
    found = components_of(robot, REGISTRY)
    assert found["drive"] == ("drive", "differential")
    assert found["sensors.laser"] == ("sensor", "laser")
    assert found["controller"] == ("controller", "wander")
    assert {kind for path, (kind, _) in found.items() if ".noise." in path} == {"noise"}
    assert "initial_belief" not in found
