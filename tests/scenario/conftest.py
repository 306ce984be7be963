"""A folder with a small map, and a short way to read documents in it."""

import tomllib

import pytest

from amorsim.core.errors import ScenarioError
from amorsim.plugins.manager import make_registry
from amorsim.scenario.reading.read import loads
from amorsim.scenario.toml.angles import parse_float

ROOM = "width 4000\nheight 3000\n0 0 4000 0\n4000 0 4000 3000\n4000 3000 0 3000\n0 3000 0 0\nposition 1000 1500 90\n"


@pytest.fixture(scope="session")
def registry():
    return make_registry(entry_points=(), disabled="")


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """Holds ``room.wld``, 4 m x 3 m; the robot starts at (1, 1.5), looking up."""
    path = tmp_path_factory.mktemp("scenarios")
    (path / "room.wld").write_text(ROOM)
    return path


@pytest.fixture(scope="session")
def read(registry, folder):
    """Reads TOML text; what stands before the first robot may be left out."""

    def read_text(text, *overrides, folder=folder):
        if "format" not in text:
            text = f'format = 1\n[world]\nmap = "room.wld"\n{text}'
        document = tomllib.loads(text, parse_float=parse_float)
        return loads(document, folder, overrides, name="test.toml", registry=registry)

    return read_text


@pytest.fixture(scope="session")
def faults(read):
    """The faults of TOML text as ``{path: message}``; none is an error of the test."""

    def faults_of(text, *overrides, **options):
        with pytest.raises(ScenarioError) as caught:
            read(text, *overrides, **options)
        return {fault.path: fault.message for fault in caught.value.faults}

    return faults_of
