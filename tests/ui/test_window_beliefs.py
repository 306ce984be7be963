"""What an estimator believes, drawn in the Control pane: particles and hypotheses, each with a switch."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from tests.ui.windows import SIMULATOR, Server, Window, expect

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own

SCENARIO = """
format = 1
[world]
map = "room.wld"
[[robots]]
name = "rover"
model = "pioneer2dx"
pose = { x = 2.0, y = 2.0 }
initial_belief = { kind = "nothing" }
knowledge = { map = "room.wld" }
controller = { use = "wander", speed = 0.4 }
[robots.sensors]
sonar = false
[robots.estimators]
dead_reckoning = false
[robots.estimators.monte_carlo]
use = "monte_carlo"
wheel_variance = 1e-3
tempering = 0.05
particles_min = 1000
particles_max = 4000
"""


@pytest.fixture(scope="module")
def lost(browser: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    folder = tmp_path_factory.mktemp("lost")
    (folder / "room.wld").write_text(
        "width 8000\nheight 6000\n0 0 8000 0\n8000 0 8000 6000\n8000 6000 0 6000\n0 6000 0 0\n3000 0 3000 2500\n"
    )
    (folder / "lost.toml").write_text(SCENARIO)
    server = Server(folder / "lost.toml")
    yield server
    server.close()


def inked(window: Window, pane: str) -> int:
    """How many pixels of a pane are of the colour of what is estimated, or a paler one."""
    window.drawn()
    return int(
        window.page.evaluate(
            f"""(name) => {{
                const pane = {SIMULATOR}.stage[name];
                const {{ data }} = pane.context.getImageData(0, 0, pane.canvas.width, pane.canvas.height);
                let count = 0;
                for (let i = 0; i < data.length; i += 4) {{
                    const rgb = data.slice(i, i + 3);
                    if (Math.max(...rgb) - Math.min(...rgb) > 40) count += 1;
                }}
                return count;
            }}""",
            pane,
        )
    )


def test_particles_and_hypotheses_are_drawn_each_with_a_switch(
    lost: Server, open_window: Callable[[Server], Window]
) -> None:
    window = open_window(lost)
    window.until("newest.particleCount > 500 && newest.hypothesisCount > 0")
    window.hide_readings()  # switches of sensors and beliefs off
    before = inked(window, "control")
    truth = inked(window, "robot")
    for name in ("particles", "hypotheses"):
        button = window.page.locator(f'.panel.control button[data-tool="{name}"]')
        expect(button).to_have_attribute("aria-pressed", "false")
        button.click()
        expect(button).to_have_attribute("aria-pressed", "true")
        shown = inked(window, "control")
        assert shown > before + 100
        button.click()
        assert inked(window, "control") == before
    assert inked(window, "robot") == truth  # what is true shows nothing of it


@pytest.mark.long
def test_the_cloud_gathers(lost: Server, open_window: Callable[[Server], Window]) -> None:
    window = open_window(lost)
    window.until("newest.particleCount > 500")
    weights = window.see("newest.particles.filter((_, k) => k % 4 === 3).reduce((a, b) => a + b, 0)")
    assert 0.2 < weights <= 1.0 + 1e-9  # of 4,000 particles every second is sent
    wide = "newest.particles.reduce((most, x, k) => (k % 4 ? most : Math.max(most, x)), 0)"
    first = window.see(wide)
    window.do(do="speed", factor=20.0)
    window.do(do="run")
    window.until("newest.time > 10", seconds=60.0)
    window.do(do="pause")
    assert window.see(wide) < first - 1.0
    assert window.see("newest.hypotheses.length") % 10 == 0


def test_a_robot_that_believes_nothing_more_has_no_switches(window: Window) -> None:
    window.do(do="select", robot="rover")
    expect(window.page.locator('.panel.control button[data-tool="particles"]')).to_have_count(0)
