"""Scenario loaders of third parties: what they give is checked before it is read."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.plugins.manager import make_registry
from amorsim.scenario.files.foreign import loaders_of_extension, read_foreign
from amorsim.scenario.files.maps import load_map

GIVEN: list[Any] = []


@attrs.frozen(kw_only=True)
class Crew(am.ScenarioLoader):
    """Gives what the test says."""

    extensions: ClassVar[tuple[str, ...]] = (".crew",)

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """By the first word."""
        return head.startswith(b"crew")

    def read(self, path: Path) -> am.ScenarioDocument:
        """The next thing."""
        return GIVEN.pop()  # type: ignore[no-any-return]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (None, "the scenario loader 'crew' gave None; expected a ScenarioDocument"),
        ({"tables": [1]}, r"'crew' gave tables = \[1\]; expected a table, \{\"format\": 1, \"world\": \.\.\."),
        ({"tables": {1: 2}}, r"'crew' gave tables = \{1: 2\}; expected a table"),
        ({"tables": {}, "remarks": "all"}, "'crew' gave remarks = 'all'; expected a tuple of texts"),
        ({"tables": {}, "remarks": (1,)}, r"'crew' gave remarks = \(1,\); expected a tuple of texts"),
        ({"tables": {}, "lines": {"robots": "x"}}, "'crew' gave lines = .*; expected whole numbers by paths"),
        ({"tables": {}, "lines": 3}, "'crew' gave lines = 3; expected whole numbers by paths"),
    ],
)
def test_what_is_no_document_is_refused(tmp_path: Path, given: Any, words: str) -> None:
    GIVEN.append(given if given is None else am.ScenarioDocument(**given))
    with pytest.raises(am.ScenarioError, match=words) as caught:
        read_foreign(tmp_path / "a.crew", "crew", Crew)
    assert str(caught.value).startswith(str(tmp_path / "a.crew"))


def test_which_loaders_read_files_of_an_extension() -> None:
    registry = make_registry(entry_points=(), disabled="")
    registry.scenario_loader("crew", Crew)
    assert loaders_of_extension(Path("a.CREW"), registry) == ["crew"]
    assert loaders_of_extension(Path("a.wld"), registry) == []


@attrs.frozen(kw_only=True)
class Nameless(am.MapLoader):
    """A map that was given no name."""

    extensions: ClassVar[tuple[str, ...]] = (".nameless",)

    def load(self, path: Path) -> am.Map:
        """A square."""
        return am.Map.from_array(np.eye(3), resolution=1.0, warnings=["oh"])


def test_a_map_without_a_name_is_called_by_its_file(tmp_path: Path) -> None:
    registry = make_registry(entry_points=(), disabled="")
    registry.map_loader("nameless", Nameless)
    (tmp_path / "hall.nameless").write_text("x")
    assert load_map(tmp_path / "hall.nameless", registry=registry).name == "hall"
