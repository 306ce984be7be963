"""The forms of the Simulator's window in a real Chromium: what is typed, dragged and given back."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.ui.windows import Server, Window, write_scenario

LEFT_WHEEL = "errors.drive.wheel_radius_left.scale"
TRACK = "errors.drive.track.scale"
SONAR = "sensors.sonar.noise.quantize.step"


def changes(window: Window) -> list[str]:
    """What the events tell of parameters."""
    lines = window.do(do="events", after=0)["events"]
    return [line["text"].removeprefix("rover: ") for line in lines if line["kind"] == "parameter_set"]


@pytest.fixture(autouse=True)
def as_in_file(request: pytest.FixtureRequest) -> None:
    if "window" in request.fixturenames:
        window = request.getfixturevalue("window")
        window.do(do="restore", robot="rover")
        window.begin()


def has_keyboard(window: Window) -> bool:
    return bool(window.page.evaluate("document.activeElement === document.body"))


def test_enter_and_escape_give_the_keyboard_back(window: Window) -> None:
    page, number = window.page, window.field(LEFT_WHEEL).locator("input[type=text]")
    number.fill("1.1")
    number.press("Enter")
    window.until(f"form.fields.get('{LEFT_WHEEL}').parameter.value === 1.1")
    page.wait_for_function("document.activeElement === document.body")
    page.keyboard.press("Space")
    window.until("newest.states & 1")
    page.keyboard.press("Space")
    number.fill("1.2")
    number.press("Escape")
    assert has_keyboard(window)
    assert number.input_value() == "1.1"
    # What is wrong keeps it, to be corrected.
    number.fill("-3")
    number.press("Enter")
    page.wait_for_selector(f"[data-path='{LEFT_WHEEL}'] .error:not(:empty)")
    assert not has_keyboard(window)
    number.press("Escape")
    assert has_keyboard(window)
    page.wait_for_timeout(200)
    assert changes(window) == [f"{LEFT_WHEEL} = 1.1"]
    # So do a slider and a list.
    for place in ("#speed", "select.robots"):
        page.locator(place).focus()
        page.keyboard.press("Escape")
        assert has_keyboard(window), place
    window.field(LEFT_WHEEL).get_by_label("as in the scenario").click()
    window.until(f"form.fields.get('{LEFT_WHEEL}').parameter.value === 1")
    assert has_keyboard(window)


def test_a_drag_of_a_slider_is_one_event(window: Window) -> None:
    slider = window.field(LEFT_WHEEL).locator("input[type=range]")
    box = slider.bounding_box()
    middle = box["y"] + box["height"] / 2
    window.page.mouse.move(box["x"] + box["width"] / 2, middle)
    window.page.mouse.down()
    for part in range(1, 13):
        window.page.mouse.move(box["x"] + box["width"] * (0.5 + 0.02 * part), middle)
        window.page.wait_for_timeout(60)
    said = window.field(LEFT_WHEEL).locator("input[type=text]").input_value()
    assert 1.03 < float(said) < 1.07  # it is told while it moves
    window.page.mouse.up()
    window.until(f"form.fields.get('{LEFT_WHEEL}').parameter.value === {said}")
    window.page.wait_for_timeout(300)
    assert changes(window) == [f"{LEFT_WHEEL} = {said}"]
    window.page.click("text=as in file")
    window.until(f"form.fields.get('{LEFT_WHEEL}').parameter.value === 1")


def test_keys_on_a_slider_that_follow_one_another_are_one_event(window: Window) -> None:
    window.field(LEFT_WHEEL).locator("input[type=range]").focus()
    for _ in range(6):
        window.page.keyboard.press("ArrowRight")
    window.until(f"form.fields.get('{LEFT_WHEEL}').parameter.value > 1")
    window.page.wait_for_timeout(500)
    assert len(changes(window)) == 1
    window.page.click("text=as in file")
    window.until(f"form.fields.get('{LEFT_WHEEL}').parameter.value === 1")


def test_each_slider_holds_the_value_of_its_number(window: Window) -> None:
    apart = window.page.evaluate(
        """() => [...document.querySelector(".amorsim").simulator.form.fields.values()]
            .map(({ path, parameter, slider, factor }) => [path, parameter.value * factor, Number(slider.value)])
            .filter(([, value, shown]) => Math.abs(value - shown) > 1e-9 * Math.max(1, Math.abs(value)))"""
    )
    assert window.see(f"form.fields.get('{SONAR}').parameter.value") == 0.000268
    assert apart == []


@pytest.fixture
def drawn(browser: Any, tmp_path: Path) -> Iterator[Server]:
    """A scenario whose track is drawn."""
    file = write_scenario(tmp_path)
    pose = "pose = { x = 2.0, y = 4.0, heading_deg = 0.0 }\n"
    error = "errors.drive = { track = { scale = { normal = [1.0, 0.01] } } }\n"
    file.write_text(file.read_text().replace(pose, pose + error))
    server = Server(file)
    yield server
    server.close()


def test_one_click_on_the_slider_of_a_drawn_error_sets_nothing_absurd(
    drawn: Server, open_window: Callable[[Server], Window]
) -> None:
    window = open_window(drawn)
    field = window.field(TRACK)
    field.wait_for()
    assert field.locator("input[type=text]").get_attribute("placeholder") == "drawn"
    assert float(field.locator("input[type=range]").input_value()) == 1.0
    box = field.locator("input[type=range]").bounding_box()
    window.page.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 0.5 * box["height"])
    window.until(f"form.fields.get('{TRACK}').parameter.value !== null")
    value = window.see(f"form.fields.get('{TRACK}').parameter.value")
    assert 1.015 < value < 1.03
    window.page.click("text=as in file")
    window.until(f"form.fields.get('{TRACK}').parameter.value === null")
    assert changes(window) == [f"{TRACK} = {value}", f"{TRACK} = normal(1, 0.01)"]
    # And what was given back can be saved, for it is given again then.
    window.do(do="step", steps=3)
    assert window.do(do="save_run", name="again")["same"]
