"""Worlds of the Khepera Simulator, written here as it writes them: picture, bricks, corks, lamps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import amorsim as am
from amorsim.core.errors import ScenarioError
from amorsim.foreign.khepera import Khepera, KheperaMap, read_playground
from amorsim.testing import check_component
from tests.examples import settings


def world(folder: Path, pixels=None, objects=(), name: str = "maze.world") -> Path:
    """A world with a picture (500, 500), row 0 at the top, as the simulator packs it: bit x % 32 of word x // 32, y."""
    picture = np.zeros((500, 512), dtype=np.uint64)
    if pixels is not None:
        picture[:, :500] = pixels
    words = (picture.reshape(500, 16, 32) << np.arange(32, dtype=np.uint64)).sum(axis=2, dtype=np.uint64)
    text = f"{int(bool(objects))},0\nbrick\n0\nlamp\n0\ncork\n0\n"
    text += "".join(f"{int(word):x}," for word in words.T.reshape(-1))
    for number, item in enumerate(objects):
        text += ",".join(map(str, (*item, int(number + 1 < len(objects))))) + "\n"
    path = folder / name
    path.write_text(text)
    return path


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=5)
def test_the_picture_is_read_bit_by_bit(tmp_path_factory, seed: int) -> None:
    pixels = np.random.default_rng(seed).random((500, 500)) < 0.3
    ground = read_playground(world(tmp_path_factory.mktemp("worlds"), pixels))
    assert np.array_equal(ground.pixels[::-1], pixels)


def test_bricks_corks_and_lamps(tmp_path) -> None:
    pixels = np.zeros((500, 500), dtype=bool)
    pixels[450:460, 100:110] = True  # something drawn, 0.2 m from the left, 0.09 m from the bottom
    pixels[100:110, 300:310] = True  # a cork that was drawn, at (610, 210)
    pixels[250:260, 250:260] = True  # a lamp that was drawn, at (510, 510)
    objects = [(1, 510, 510, 0), (0, 500, 200, 90), (2, 610, 210, 0), (2, 800, 800, 0), (3, 100, 100, 0)]
    scenario = am.load(world(tmp_path, pixels, objects))
    assert scenario.map.size == (1.0, 1.0)
    occupied = scenario.map.occupied(
        [[0.21, 0.09], [0.5, 0.822], [0.508, 0.8], [0.5, 0.828], [0.512, 0.8], [0.61, 0.79], [0.51, 0.49]]
    )
    # A brick that is turned by 90 degrees is 20 mm wide and 50 mm high; lamps block nothing.
    assert occupied.tolist() == [True, True, True, False, False, True, False]
    (cork,) = scenario.obstacles
    assert (cork.pose.x, cork.pose.y) == pytest.approx((0.8, 0.2))
    assert cork.shape.reach == pytest.approx(0.008)
    (lamp,) = scenario.lights
    assert (lamp.x, lamp.y) == pytest.approx((0.51, 0.49))
    (robot,) = scenario.robots
    assert robot.model == "khepera"
    assert robot.pose is not None
    assert scenario.remarks == ("1 lamps that are off are left out",)


def test_a_khepera_drives_in_it(tmp_path) -> None:
    pixels = np.ones((500, 500), dtype=bool)
    pixels[20:480, 20:480] = False
    simulation = am.Simulation(am.load(world(tmp_path, pixels, [(0, 300, 300, 30)])))
    before = simulation.true_pose.copy()
    for _ in range(40):
        simulation.step()
    assert np.hypot(*(simulation.true_pose - before)[0, :2]) > 0.05


def test_what_is_wrong_is_reported_with_its_line(tmp_path) -> None:
    def messages(path: Path) -> list[str]:
        with pytest.raises(ScenarioError) as caught:
            read_playground(path)
        return [f"{fault.line}: {fault.message}" for fault in caught.value.faults]

    path = world(tmp_path, objects=[(0, 1, 1, 0), (7, 1, 1, 0), (0, -1, 1, 0), (0, "x", 1, 0)])
    assert messages(path) == [
        "9: expected an object of type 0 (brick), 1 or 3 (lamp) or 2 (cork), got 7",
        "10: expected an object at 0 to 1000 mm, got (-1, 1)",
        "11: expected an object of 5 whole numbers, TYPE,X,Y,ANGLE,MORE, got '0,x,1,0,0'",
    ]
    text = path.read_text()
    path.write_text(text.partition("cork")[0])
    assert messages(path) == ["1: expected ANY,TYPE and three times a name and an angle in the first seven lines"]
    path.write_text(text.partition("cork")[0] + "cork\n0\n1,2,3,\n")
    assert messages(path) == ["8: expected a picture of 8000 hexadecimal words, got 3"]
    path.write_text(text.replace("0,0,0,", "0,zz,0,", 1))
    assert messages(path)[0] == "8: expected a hexadecimal word, number 2 of the picture's 8000, got 'zz'"


def test_the_loaders_keep_their_contracts_and_know_their_files(tmp_path) -> None:
    path = world(tmp_path, objects=[(0, 100, 100, 0)])
    check_component(Khepera, path=path)
    check_component(KheperaMap, path=path)
    assert Khepera.sniff(path.read_bytes()[:4096])
    assert not Khepera.sniff(b"# simple.world\n")
