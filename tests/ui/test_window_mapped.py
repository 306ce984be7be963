"""The map, the matched scan and the graph that a robot makes, in the window."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.ui.windows import SCENARIO, Server, Window, expect, write_scenario

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own

MAPPING = """
[robots.estimators]
dead_reckoning = false

[robots.estimators.slam]
use = "graph_slam"
wheel_variance = 1e-4
range_std = 0.01
resolution = 0.1
width = 20.0
height = 20.0
"""


@pytest.fixture(scope="module")
def mapping(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    folder = tmp_path_factory.mktemp("mapping")
    file = write_scenario(folder, "wander")
    first, second = SCENARIO.replace("CONTROLLER", "wander").split('\n[[robots]]\nname = "second"')
    file.write_text(f'{first}{MAPPING}\n[[robots]]\nname = "second"{second}')
    server = Server(file)
    yield server
    server.close()


def test_the_growing_map_is_drawn_each_part_with_a_switch(
    mapping: Server, browser: Any, open_window: Callable[[Server], Window], tmp_path: Path
) -> None:
    window = open_window(mapping)
    window.do(do="step", steps=40)
    window.until("stage.mapped.found.length === 1 && stage.mapped.maps(stage.theme.estimated).length === 1")
    first = window.see("stage.mapped.found[0].map.extent")
    window.do(do="step", steps=100)
    window.until("stage.mapped.found[0].poses.length >= 3")
    window.page.screenshot(path=str(tmp_path / "mapped.png"))
    now = window.see("stage.mapped.found[0].map.extent")
    assert (now[2] - now[0]) * (now[3] - now[1]) >= (first[2] - first[0]) * (first[3] - first[1])
    window.switch_off("what is drawn of its map", ["map", "matched scan", "graph"])


def test_a_robot_that_maps_nothing_has_no_switches(
    mapping: Server, browser: Any, open_window: Callable[[Server], Window]
) -> None:
    window = open_window(mapping)
    window.do(do="select", robot="second")
    window.until("selected === 1 && stage.mapped.isDone")
    expect(window.page.locator(".panel.control [aria-label='what is drawn of its map'] button")).to_have_count(0)
