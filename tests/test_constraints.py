"""The set of versions that is offered fits what the package asks for, and neither lets known holes in."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.version import Version

ROOT = Path(__file__).parents[1]
NAME = re.compile(r"[-_.]+")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
ASKED = [
    Requirement(text)
    for text in (*PROJECT["dependencies"], *(text for extra in EXTRAS.values() for text in extra))
    if not text.startswith("amorsim[")
]
# The first versions without holes that were published.
SOUND = {"h11": "0.16.0", "pillow": "10.3.0", "starlette": "0.49.1"}


def pinned() -> dict[str, Version]:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    return {name: Version(version) for name, version in (line.split("==") for line in lines if line[0] != "#")}


def test_the_file_holds_names_and_versions_only() -> None:
    for line in (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines():
        assert line.startswith("# ") or re.fullmatch(r"[a-z0-9-]+==[0-9][a-z0-9.+]*", line)


def test_the_version_to_cite_is_the_packages() -> None:
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert cited["version"] == PROJECT["version"]


def test_each_package_that_developers_need_is_in_it_in_a_version_that_is_asked_for() -> None:
    versions = pinned()
    for asked in ASKED:
        name = NAME.sub("-", asked.name).lower()
        if name in versions:
            assert asked.specifier.contains(versions[name]), asked
    left_out = {NAME.sub("-", Requirement(text).name).lower() for extra in ("bench", "video") for text in EXTRAS[extra]}
    missing = {NAME.sub("-", asked.name).lower() for asked in ASKED} - set(versions) - left_out
    assert not missing


@pytest.mark.parametrize("name", SOUND)
def test_versions_with_known_holes_are_not_asked_for(name: str) -> None:
    (asked,) = (each for each in ASKED if each.name == name)
    assert not asked.specifier.contains("0.0.1")
    assert min(Version(each.version) for each in asked.specifier) >= Version(SOUND[name])
    assert pinned()[name] >= Version(SOUND[name])
