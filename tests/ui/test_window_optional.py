"""Fields that are a component or nothing, in a real Chromium: chosen, filled and left out again."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests import optional_components
from tests.building import write_rover
from tests.installed import install_module
from tests.ui.test_window_editor import Editor
from tests.ui.windows import Server, Window, expect

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own

CONTROLLER = "robots.0.controller"
CHAIN = "sensors.sonar.noise"


@pytest.fixture
def path(tmp_path: Path) -> str:
    """Where Python looks, with a plugin whose components have optional components."""
    install_module(optional_components, tmp_path / "site")
    return os.pathsep.join([str(tmp_path / "site"), os.environ.get("PYTHONPATH", "")])


def test_the_editor_chooses_none_or_a_component_and_its_fields(browser: Any, tmp_path: Path, path: str) -> None:
    line = 'controller = { use = "careful" }  # for now'
    file = write_rover(tmp_path, line)
    text = file.read_text()
    editor = Editor(browser, tmp_path, str(file), PYTHONPATH=path)
    page = editor.page

    def choose(place: str, use: str) -> None:
        select = page.locator(f'[data-path="{CONTROLLER}.{place}"] select').first
        editor.step(lambda: select.select_option(use))

    def saved() -> str:
        number = editor.see("state.number")
        page.evaluate("document.activeElement.blur()")
        page.keyboard.press("Control+s")
        editor.until(f"state.number > {number} && state.is_saved")
        return file.read_text()

    try:
        page.click('[data-key="robots.0"]')
        spare = page.locator(f'[data-path="{CONTROLLER}.spare"]')
        spare.wait_for()
        expect(spare.locator("select").first).to_have_value("")
        expect(spare.locator("option").first).to_contain_text("none")
        choose("spare", "careful")
        choose("spare.avoider", "dwa")
        speed = page.locator(f'[data-path="{CONTROLLER}.spare.avoider.speed"] input').first
        speed.fill("0.3")
        editor.step(lambda: speed.press("Enter"))
        page.screenshot(path=str(tmp_path / "optional.png"))
        expect(page.locator(".status")).to_contain_text("no faults")
        inner = 'spare = { use = "careful", avoider = { use = "dwa", speed = 0.3 } }'
        assert saved() == text.replace('"careful" }', f'"careful", {inner} }}')
        choose("spare", "")
        page.locator(f'[data-path="{CONTROLLER}.spare.avoider"]').wait_for(state="detached")
        assert saved() == text
        choose("planner", "")
        assert saved() == text.replace('"careful" }', '"careful", planner = "none" }')
        choose("planner", "theta_star")
        page.locator(f'[data-path="{CONTROLLER}.planner.lazy"]').wait_for()
        editor.step(lambda: page.locator(f'[data-path="{CONTROLLER}.planner"] .back').first.click())
        assert saved() == text

        # An element of noise: what is chosen in it has its fields at once.
        noise = "robots.0.sensors.sonar.noise"
        page.evaluate("document.querySelectorAll('details.section').forEach(one => one.open = true)")
        page.select_option(f'[id="add-{noise}"]', "swayed")
        editor.step(lambda: page.locator(f'[data-section="{noise}"] > .row button.tool').first.click())
        added = page.locator(f'[data-section^="{noise}."]', has=page.locator("> summary", has_text="swayed"))
        element = added.get_attribute("data-section")
        page.evaluate("document.querySelectorAll('details.section').forEach(one => one.open = true)")
        way = page.locator(f'[data-path="{element}.way"] select').first
        expect(page.locator(f'[data-path="{element}.way.lazy"]')).to_have_count(0)
        editor.step(lambda: way.select_option("theta_star"))
        page.locator(f'[data-path="{element}.way.lazy"]').wait_for()
        editor.step(lambda: page.locator(f'[data-path="{element}.guide"] select').first.select_option("dead_reckoning"))
        page.locator(f'[data-path="{element}.guide.encoder"]').wait_for()
        expect(page.locator(".status")).to_contain_text("no faults")
        assert '{ use = "swayed", way = { use = "theta_star" }, guide = { use = "dead_reckoning" } }' in saved()
    finally:
        editor.close()


def test_the_simulator_shows_it_and_a_draft_of_noise_follows_what_is_chosen(
    browser: Any, open_window: Callable[[Server], Window], tmp_path: Path, path: str
) -> None:
    file = write_rover(tmp_path, 'controller = { use = "careful", avoider = { use = "vfh_plus" } }')
    server = Server(file, env={"PYTHONPATH": path})
    try:
        window = open_window(server)
        page = window.page
        window.until("form.fields.has('controller.avoider.speed')")
        page.evaluate("document.querySelectorAll('details.group').forEach(one => one.open = true)")
        for place, use in (("avoider", "vfh_plus"), ("spare", ""), ("planner", "a_star")):
            field = window.field(f"controller.{place}")
            expect(field.locator("select")).to_have_value(use)
            expect(field.locator("select")).to_be_disabled()
            expect(field.locator(".help")).to_contain_text("Whether there is a ")
        speed = window.field("controller.avoider.speed").locator("input[type=text]")
        speed.fill("0.2")
        speed.press("Enter")
        window.until("form.fields.get('controller.avoider.speed').parameter.value === 0.2")

        page.get_by_label("sonar: add noise").click()
        draft = page.locator(".draft")
        draft.locator("select").first.select_option("swayed")
        way, guide = draft.locator('[data-path="way"] select'), draft.locator('[data-path="guide"] select')
        expect(way.first).to_have_value("a_star")
        expect(guide.first).to_have_value("")
        expect(draft.locator('[data-path="way.lazy"]')).to_have_count(0)
        way.first.select_option("theta_star")
        draft.locator('[data-path="way.lazy"] input').check()
        guide.first.select_option("dead_reckoning")
        draft.locator('[data-path="guide.encoder"]').wait_for()
        guide.first.select_option("")
        draft.locator('[data-path="guide.encoder"]').wait_for(state="detached")
        draft.locator('[data-path="way.lazy"]').wait_for()
        page.screenshot(path=str(tmp_path / "draft.png"))
        draft.locator("button.main").click()
        window.until(f"form.fields.has('{CHAIN}.swayed.way.lazy')")
        assert window.see(f"form.fields.get('{CHAIN}.swayed.way').parameter.value.use") == "theta_star"
        assert window.see(f"form.fields.get('{CHAIN}.swayed.way.lazy').parameter.value") is True
        assert window.see(f"form.fields.get('{CHAIN}.swayed.guide').parameter.value") is None
    finally:
        server.close()
