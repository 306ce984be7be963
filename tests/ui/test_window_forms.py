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
            .filter((field) => field.hasSlider)
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
    # It stands at what was drawn, and says so.
    drawn_value = window.see(f"form.fields.get('{TRACK}').parameter.drawn_value")
    true = window.see(f"form.fields.get('{TRACK}').parameter.true")
    assert drawn_value == pytest.approx(true / 0.33)
    assert abs(drawn_value - 1.0) > 1e-4
    assert field.locator("input[type=text]").get_attribute("placeholder") == f"{drawn_value:.6g}"
    assert float(field.locator("input[type=range]").input_value()) == pytest.approx(drawn_value)
    assert field.get_attribute("data-state") == "drawn"
    assert "drawn from normal(1, 0.01): " in field.locator(".help").text_content()
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


def test_an_error_is_drawn_or_fixed_and_taken_away_again(window: Window) -> None:
    field = window.field(TRACK)
    value = f"form.fields.get('{TRACK}').parameter"
    field.get_by_label("track: fixed or drawn at random").click()
    scale = field.locator("[data-part=scale]")
    scale.locator("select").select_option("normal")
    window.until(f"{value}.drawn === 'normal(1, 0.01)'")
    assert field.get_attribute("data-state") == "changed"
    scale.get_by_label("scale: standard deviation").fill("0.05")
    scale.get_by_label("scale: standard deviation").press("Tab")
    window.until(f"{value}.drawn === 'normal(1, 0.05)'")
    true = window.see(f"{value}.true")
    assert true != 0.33
    field.locator("[data-part=per] select").select_option("study")
    window.until(f"{value}.deviation[3].value === 'study' && {value}.true !== {true}")
    scale.get_by_label("scale: standard deviation").fill("-1")
    scale.get_by_label("scale: standard deviation").press("Tab")
    window.page.wait_for_selector("[data-part=scale] .error:not(:empty)")
    assert "standard deviation >= 0" in scale.locator(".error").text_content()
    field.get_by_text("remove this error").click()
    window.until(f"{value}.true === 0.33 && {value}.drawn === ''")
    assert changes(window)[-1] == "errors.drive.track = None"
    # It can be run again, and saved.
    window.do(do="step", steps=2)
    assert window.do(do="save_run", name="drawn")["same"]


def test_fields_of_each_kind_are_there_and_say_where_their_values_come_from(window: Window) -> None:
    page = window.page
    beams = window.field("sensors.laser.beams")
    assert beams.get_attribute("data-state") == "fixed"
    assert beams.locator("input").is_disabled()
    assert "fixes the size" in beams.locator(".help").text_content()
    states = page.evaluate(
        """() => Object.fromEntries(
            [...document.querySelectorAll('[data-path]')].map(e => [e.dataset.path, e.dataset.state])
        )"""
    )
    assert states["drive.track"] == "inherited"
    assert states["errors.drive.lag.add"] == "default"
    assert states["estimators.dead_reckoning.encoder"] == "fixed"
    kinds = page.evaluate(
        "() => [...new Set([...document.querySelectorAll('[data-path]')].map(e => e.dataset.kind))].sort()"
    )
    assert kinds == ["choice", "forms", "list", "name", "number", "text"]
    # A number of an element of a ring.
    page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
    x = window.field("sensors.sonar.elements.2.x").locator("input[type=text]")
    x.fill("0.2")
    x.press("Tab")
    window.until("form.fields.get('sensors.sonar.elements').parameter.value[2].x === 0.2")
    assert window.field("sensors.sonar.elements").get_attribute("data-state") == "changed"
    window.page.click("text=as in file")
    window.until("form.fields.get('sensors.sonar.elements').parameter.is_changed === false")
