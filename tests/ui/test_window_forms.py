"""The forms of the Simulator's window in a real Chromium: what is typed, dragged and given back."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.ui.windows import Server, Window, axe_violations, expect, write_scenario

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own

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
    expect(number).to_have_value("1.1")
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
    assert 1.03 < float(said) < 1.07  # it is shown while it moves
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
    expect(field.locator("input[type=text]")).to_have_attribute("placeholder", f"{drawn_value:.6g}")
    assert float(field.locator("input[type=range]").input_value()) == pytest.approx(drawn_value)
    expect(field).to_have_attribute("data-state", "drawn")
    expect(field.locator(".help")).to_contain_text("drawn from normal(1, 0.01): ")
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
    expect(field).to_have_attribute("data-state", "changed")
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
    expect(scale.locator(".error")).to_contain_text("standard deviation >= 0")
    field.get_by_text("remove this error").click()
    window.until(f"{value}.true === 0.33 && {value}.drawn === ''")
    assert changes(window)[-1] == "errors.drive.track = None"
    # It can be run again, and saved.
    window.do(do="step", steps=2)
    assert window.do(do="save_run", name="drawn")["same"]


def test_fields_of_each_kind_are_there_and_say_where_their_values_come_from(window: Window) -> None:
    page = window.page
    beams = window.field("sensors.laser.beams")
    expect(beams).to_have_attribute("data-state", "fixed")
    expect(beams.locator("input")).to_be_disabled()
    expect(beams.locator(".help")).to_contain_text("fixes the size")
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
    about = window.see("form.fields.get('sensors.sonar.elements').help.textContent")
    assert about.startswith("where each element sits on the mount, and looks")
    assert "object" not in about  # what the list holds stands in its rows, not in the words about it
    # A number of an element of a ring.
    page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
    x = window.field("sensors.sonar.elements.2.x").locator("input[type=text]")
    x.fill("0.2")
    x.press("Tab")
    window.until("form.fields.get('sensors.sonar.elements').parameter.value[2].x === 0.2")
    expect(window.field("sensors.sonar.elements")).to_have_attribute("data-state", "changed")
    window.page.click("text=as in file")
    window.until("form.fields.get('sensors.sonar.elements').parameter.is_changed === false")


LASER = "sensors.laser.noise"


def elements(window: Window) -> list[str]:
    """The elements of the laser's chain, as the window shows them."""
    heads = window.page.locator(f"[data-element^='{LASER}.']")
    return [str(head.get_attribute("data-element")).removeprefix(f"{LASER}.") for head in heads.all()]


def add_noise(window: Window, use: str, **values: str) -> None:
    window.page.evaluate("document.querySelectorAll('details.group').forEach(one => one.open = true)")
    window.page.get_by_label("laser: add noise").click()
    window.page.locator(".draft > .line select").select_option(use)
    for path, value in values.items():
        number = window.page.locator(f".draft [data-path={path}] input[type=text]")
        number.fill(value)
        number.press("Tab")
    window.page.locator(".draft button.main").click()


def test_noise_is_added_tuned_and_removed(window: Window) -> None:
    page = window.page
    until = f"state && [...document.querySelectorAll('[data-element^=\"{LASER}.\"]')].length"
    window.do(do="step", steps=5)
    add_noise(window, "bias", value="0.25")
    window.until(f"{until} === 3")
    assert elements(window) == ["gaussian", "quantize", "bias"]
    expect(page.locator(".draft")).to_have_count(0)
    window.do(do="step", steps=1)
    window.until("newest.tick === 6")
    true, measured = (window.see(f"newest.{kind}Values[2]") for kind in ("true", "measured"))  # after the encoder's
    assert measured - true == pytest.approx(0.25, abs=0.05)
    bias = window.field(f"{LASER}.bias.value").locator("input[type=text]")
    expect(bias).to_have_value("0.25")
    bias.fill("0.5")
    bias.press("Enter")
    window.until(f"form.fields.get('{LASER}.bias.value').parameter.value === 0.5")
    page.get_by_label("laser: remove gaussian", exact=True).click()
    window.until(f"{until} === 2")
    assert elements(window) == ["quantize", "bias"]
    expect(page.locator("[data-group='noise sensors.laser'] .note")).to_have_text("taken out: gaussian")
    window.do(do="step", steps=4)
    # The past is as it was, and the present as it is.
    window.do(do="scrub", tick=3)
    window.until("newest.tick === 3")
    window.do(do="scrub", tick=None)
    window.until("newest.tick === 10 && !(newest.states & 2)")
    assert window.do(do="save_run", name="noisy")["same"]
    assert changes(window) == [
        f"{LASER} = gaussian, quantize, bias",
        f"{LASER}.bias.value = 0.5",
        f"{LASER} = quantize, bias",
    ]
    # A reset keeps what was changed; the scenario's chain comes back when it is asked for.
    window.do(do="reset")
    window.until("newest.tick === 0")
    assert [one["name"] for one in laser_chain(window)] == ["quantize", "bias"]
    page.click("text=as in file")
    window.until(f"{until} === 2 && form.fields.has('{LASER}.gaussian.std')")
    assert elements(window) == ["gaussian", "quantize"]
    window.do(do="step", steps=2)


def laser_chain(window: Window) -> list[dict[str, Any]]:
    chains = window.do(do="parameters", robot="rover")["chains"]
    return next(list(chain["elements"]) for chain in chains if chain["path"] == LASER)


def test_what_is_wrong_with_a_draft_is_said_and_the_draft_stays(window: Window) -> None:
    page = window.page
    add_noise(window, "outliers", probability="7")
    page.wait_for_selector(".draft > .error:not(:empty)")
    expect(page.locator(".draft > .error")).to_contain_text("probability")
    assert len(laser_chain(window)) == 2
    page.locator(".draft").get_by_text("cancel").click()
    expect(page.locator(".draft")).to_have_count(0)
    # On the ground are the noises that act there.
    offered = {one["name"] for one in window.do(do="noises", robot="rover", path="ground")["choices"]}
    assert {"slip", "bump", "gaussian"} <= offered
    assert "slip" not in {one["name"] for one in window.do(do="noises", robot="rover", path=LASER)["choices"]}


def test_an_element_of_a_ring_gets_an_error(window: Window) -> None:
    page = window.page
    page.get_by_label("number that is to have an error").select_option("sensors.sonar.elements.2.heading")
    page.click("text=add an error")
    path = "errors.sensors.sonar.elements.2.heading.add"
    window.until(f"form.fields.has('{path}')")
    page.wait_for_selector(f"[data-path='{path}']", state="attached")
    page.evaluate("document.querySelectorAll('details.group').forEach(one => one.open = true)")
    number = window.field(path).locator("input[type=text]")
    number.fill("5")
    number.press("Enter")
    window.until(f"form.fields.get('{path}')?.parameter.value > 0.08")
    window.field(path).get_by_label("fixed or drawn at random").click()
    window.field(path).get_by_text("remove this error").click()
    window.until(f"!form.fields.has('{path}')")


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing_in_the_forms(window: Window, theme: str) -> None:
    page = window.page
    if page.evaluate("document.documentElement.dataset.theme") != theme:
        page.keyboard.press("l")
    page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
    window.field(TRACK).get_by_label("fixed or drawn at random").click()
    page.get_by_label("laser: add noise").click()
    page.wait_for_selector(".draft")
    assert axe_violations(page) == []
