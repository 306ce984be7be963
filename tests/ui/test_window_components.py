"""Fields that are components, in a real Chromium: chosen and changed in the Editor, seen and tuned in the Simulator."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from tests.ui.test_window_editor import Editor
from tests.ui.windows import Server, Window, expect

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own

CONTROLLER = "robots.0.controller"


def test_the_planner_and_the_avoider_of_a_robot_are_chosen_and_changed_in_forms(browser: Any, tmp_path: Path) -> None:
    editor = Editor(browser, tmp_path, "find-the-way")
    try:
        page = editor.page
        page.click('[data-key="robots.0"]')
        planner = page.locator(f'[data-path="{CONTROLLER}.planner"]')
        planner.wait_for()
        expect(planner.locator("select").first).to_have_value("theta_star")
        cell = page.locator(f'[data-path="{CONTROLLER}.planner.cell"] input').first
        cell.fill("0.1")
        editor.step(lambda: cell.press("Enter"))
        speed = page.locator(f'[data-path="{CONTROLLER}.avoider.speed"]')
        speed.locator("input").first.fill("0.45")
        editor.step(lambda: speed.locator("input").first.press("Enter"))
        expect(speed).to_have_attribute("data-state", "changed")
        # Another one has other fields, and nothing of the one before.
        avoider = page.locator(f'[data-path="{CONTROLLER}.avoider"] select').first
        expect(avoider).not_to_contain_text("manual")
        editor.step(lambda: avoider.select_option("vfh_plus"))
        page.wait_for_selector(f'[data-path="{CONTROLLER}.avoider.horizon"]', state="detached")
        page.wait_for_selector(f'[data-path="{CONTROLLER}.avoider.speed"]')
        page.wait_for_selector(".status:has-text('no faults')")
        # What is wrong is said at the field.
        cell = page.locator(f'[data-path="{CONTROLLER}.planner.cell"] input').first
        cell.fill("-1")
        editor.step(lambda: cell.press("Enter"))
        page.wait_for_selector(f'[data-path="{CONTROLLER}.planner.cell"] .error:not(:empty)')
        editor.step(lambda: page.keyboard.press("Control+z"))
        page.evaluate("document.activeElement.blur()")
        page.keyboard.press("Control+s")
        page.fill("#asked-name", "mine")
        editor.step(lambda: page.click("dialog .main"))
        text = (tmp_path / "mine.toml").read_text()
        assert 'planner = { use = "theta_star", cell = 0.1 }\n' in text
        assert 'avoider = { use = "vfh_plus" }\n' in text
    finally:
        editor.close()


@pytest.fixture
def navigating(browser: Any, tmp_path: Path) -> Any:
    am.open_document("find-the-way").save(tmp_path / "way.toml", copy=True)
    server = Server(tmp_path / "way.toml")
    yield server
    server.close()


def test_the_simulator_tunes_the_avoider_and_says_why_the_planner_stays(
    navigating: Server, open_window: Callable[[Server], Window]
) -> None:
    window = open_window(navigating)
    page = window.page
    window.until("form.fields.has('controller.avoider.speed')")
    page.evaluate("document.querySelectorAll('details.group').forEach(one => one.open = true)")
    planner = window.field("controller.planner")
    expect(planner.locator("select")).to_have_value("theta_star")
    expect(planner.locator("select")).to_be_disabled()
    expect(planner.locator(".help")).to_contain_text("Which planner it is, is set when")
    expect(window.field("controller.planner.cell").locator(".help")).to_contain_text("The planner is set when")
    speed = window.field("controller.avoider.speed").locator("input[type=text]")
    speed.fill("0.3")
    speed.press("Enter")
    window.until("form.fields.get('controller.avoider.speed').parameter.value === 0.3")
    window.do(do="save_scenario", name="slower.toml")
    text = (navigating.folder / "slower.toml").read_text()
    assert 'avoider = { use = "dwa", speed = 0.3, turn_rate_deg = 90.0, horizon = 1.0 }\n' in text
