"""Snapshots as bytes, for another process."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import amorsim as am

CONTROLLER = """
import threading
import amorsim as am

class Swerving:
    def __init__(self):
        self.calls = 0

    def command(self, readings, estimate, clock):
        self.calls += 1
        return am.Twist(0.2, 0.01 * self.calls + 0.001 * readings["laser"].measured.min())

class Held(Swerving):
    def __init__(self):
        super().__init__()
        self.held = lambda: 0  # can be copied, but not pickled
"""
OTHER = """
import sys
from pathlib import Path
import amorsim as am
sim = am.Simulation(am.load("own.toml"))
sim.set("rover", "errors.drive.track.scale", 1.1)
sim.restore(Path("snapshot").read_bytes())
sim.run(2.0)
print(sim.tick, sim.digest(), len(sim.events))
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("room.wld").write_text("0 0 6000 0\n6000 0 6000 5000\n6000 5000 0 5000\n0 5000 0 0\n")
    Path("own.py").write_text(CONTROLLER)
    for name in ("Swerving", "Held"):
        Path(f"{name}.toml").write_text(
            'format = 1\nworld = { map = "room.wld" }\n[[robots]]\nname = "rover"\nmodel = "pioneer2dx"\n'
            f'pose = {{ x = 2.0, y = 2.0 }}\ncontroller = {{ use = "own.py:{name}" }}\n'
        )
    Path("own.toml").write_text(Path("Swerving.toml").read_text())


@pytest.mark.long
def test_another_process_goes_on_to_the_same_bits() -> None:
    sim = am.Simulation(am.load("own.toml"))
    sim.run(1.0)
    sim.set("rover", "errors.drive.track.scale", 1.1)
    sim.run(3.0)
    Path("snapshot").write_bytes(sim.snapshot().to_bytes())
    sim.run(2.0)
    said = subprocess.run([sys.executable, "-c", OTHER], capture_output=True, text=True, check=True).stdout
    assert said.split() == [str(sim.tick), sim.digest(), str(len(sim.events))]


def test_what_cannot_be_carried_is_refused_by_name() -> None:
    sim = am.Simulation(am.load("Held.toml"))
    sim.run(0.5)
    snapshot = sim.snapshot()  # it can be copied
    with pytest.raises(am.AmorsimError, match="a controller cannot be carried to another process"):
        snapshot.to_bytes()


def test_bytes_of_something_else_are_refused_and_change_nothing() -> None:
    sim = am.Simulation(am.load("own.toml"))
    sim.run(0.5)
    before = sim.digest()
    other = am.Simulation(am.load("demo")).snapshot().to_bytes()
    for data, says in ((b"", "cannot be read"), (b"nothing", "cannot be read"), (other, "of another simulation")):
        with pytest.raises(am.AmorsimError, match=says):
            sim.restore(data)
    assert (sim.tick, sim.digest()) == (5, before)
