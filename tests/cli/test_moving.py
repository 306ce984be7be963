"""The scenarios that move: each is sound, runs, and can be filmed."""

from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image

import amorsim as am
from tests.cli.conftest import Command


@pytest.mark.long
@pytest.mark.parametrize("name", [pytest.param("crowd", marks=pytest.mark.long), "doors"])
def test_it_runs_reproduces_and_is_filmed(amorsim: Command, tmp_path: Path, name: str) -> None:
    result = amorsim("run", name, "--duration", "0.5", "--out", "run", "--gif", "run.gif", "--gif-size", "240")
    assert (result.status, result.err) == (0, "")
    assert "moving picture: run.gif" in result.out
    with Image.open(tmp_path / "run.gif") as gif:
        assert gif.n_frames == 6
    assert amorsim("reproduce", "run").status == 0
    assert amorsim("plot", "run").status == 0


def test_a_thousand_have_names_and_places_of_their_own() -> None:
    swarm = am.load("swarm")
    sim = am.Simulation(swarm)
    assert len(sim.names) == 1000
    assert sim.names[-1] == "r0999"
    sim.step()
    sim.step()


def test_a_mistake_in_an_option_leaves_nothing(amorsim: Command, tmp_path: Path) -> None:
    result = amorsim("run", "crowd", "--gif", "run.mp4", "--out", "run")
    assert result.status == 2
    assert "--gif: expected the name of a file that ends in .gif, got 'run.mp4'" in result.err
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("command", ["run", "replay"])
def test_a_film_that_is_there_is_replaced_by_force_alone(amorsim: Command, tmp_path: Path, command: str) -> None:
    (tmp_path / "a.gif").write_text("mine")
    if command == "replay":
        assert amorsim("run", "doors", "--duration", "0.2", "--out", "doors").status == 0
    asked = (command, "doors", *(("--duration", "0.2") if command == "run" else ()), "--gif", "a.gif")
    result = amorsim(*asked)
    assert (result.status, result.err) == (2, "a.gif is there already; --force replaces it\n")
    assert (tmp_path / "a.gif").read_text() == "mine"
    assert amorsim(*asked, "--force").status == 0
    assert (tmp_path / "a.gif").read_bytes().startswith(b"GIF")
