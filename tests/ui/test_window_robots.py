"""Robots in the panes of the window: what Control may show, colours and names, and where one looks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.ui.windows import SIMULATOR, Window, expect

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own

SECOND = (2.0, 6.5)  # where it stands, and believes to


@pytest.fixture(autouse=True)
def rover(window: Window) -> None:
    window.do(do="select", robot="rover")
    window.until("robot?.name === 'rover'")


def colours(window: Window, pane: str, place: tuple[float, float]) -> set[str]:
    """The colours in a pane within 6 pixels of a place [m]."""
    window.drawn()
    found: list[str] = window.page.evaluate(
        f"""([name, x, y]) => {{
            const pane = {SIMULATOR}.stage[name];
            const [left, top] = {SIMULATOR}.stage.camera.toScreen(x, y).map((at) => Math.round(at * pane.ratio));
            const {{ data }} = pane.context.getImageData(left - 6, top - 6, 13, 13);
            const seen = new Set();
            for (let i = 0; i < data.length; i += 4) seen.add(data.slice(i, i + 3).join());
            return [...seen];
        }}""",
        [pane, *place],
    )
    return set(found)


def click(window: Window, pane: str, place: tuple[float, float]) -> None:
    box = window.page.locator(f"#pane-{pane}").bounding_box()
    left, top = window.page.evaluate(f"{SIMULATOR}.stage.camera.toScreen({place[0]}, {place[1]})")
    window.page.mouse.click(box["x"] + left, box["y"] + top)


def test_control_shows_no_robot_that_this_one_cannot_know_of(window: Window) -> None:
    window.hide_readings()
    assert len(colours(window, "robot", SECOND)) > 3
    assert colours(window, "control", SECOND) == {"255,255,255"}
    click(window, "control", SECOND)
    window.page.wait_for_timeout(200)
    assert window.see("robot.name") == "rover"
    expect(window.page.locator(".card")).to_be_hidden()
    click(window, "robot", SECOND)
    window.until("robot.name === 'second'")


def test_each_robot_has_a_colour_and_its_name(window: Window) -> None:
    first, second = window.see("scene.robots.map(robot => robot.colour)")
    assert first != second
    assert {"#"} == {first[0], second[0]}
    for title in ("#errors-title", "#numbers-title", "#plot-title"):
        chip = window.page.locator(f"{title} .chip")
        red, green, blue = (int(first[at : at + 2], 16) for at in (1, 3, 5))
        expect(chip).to_have_css("background-color", f"rgb({red}, {green}, {blue})")
    # Their names stand beside them: in Control that of this robot alone.
    drawn = window.page.evaluate(
        f"""() => {{
            const names = {{}};
            for (const which of ["robot", "control"]) {{
                const pane = {SIMULATOR}.stage[which];
                const fill = pane.context.fillText;
                names[which] = [];
                pane.context.fillText = (text) => names[which].push(text);
                pane.draw();
                pane.context.fillText = fill;
            }}
            return names;
        }}"""
    )
    assert {"rover", "second"} <= set(drawn["robot"])
    assert "rover" in drawn["control"]
    assert "second" not in drawn["control"]


def test_control_says_that_a_robot_has_no_map(window: Window) -> None:
    lack = window.page.locator(".panel.control .lack")
    expect(lack).to_be_hidden()
    window.do(do="select", robot="second")
    window.until("robot?.name === 'second'")
    expect(lack).to_have_text("second has no map (robots.knowledge.map)")


@pytest.fixture
def small(window: Window) -> Iterator[Callable[..., Any]]:
    """Changes the window's size, and back at the end."""
    size = window.page.viewport_size

    def resize(width: int, height: int) -> None:
        before = window.see("stage.camera.width")
        window.page.set_viewport_size({"width": width, "height": height})
        window.until(f"stage.camera.width !== {before}")
        window.drawn()

    yield resize
    window.page.set_viewport_size(size)


def test_the_view_is_fitted_again_when_the_window_changes_its_size(window: Window, small: Callable[..., Any]) -> None:
    window.page.click("text=all")
    window.do(do="step")
    before = window.see("stage.camera.scale")
    small(1920, 1080)
    wide, high = window.see("stage.camera.width"), window.see("stage.camera.height")
    assert window.see("stage.camera.scale") == pytest.approx(min((wide - 48) / 12.0, (high - 48) / 8.0))
    assert window.see("stage.camera.scale") > 1.2 * before
    # Who has looked closer keeps what he looks at.
    window.page.keyboard.press("+")
    scale, x = window.see("stage.camera.scale"), window.see("stage.camera.x")
    small(1366, 768)
    assert (window.see("stage.camera.scale"), window.see("stage.camera.x")) == (scale, x)


@pytest.mark.parametrize("width", [1280, 400])
def test_nothing_of_the_bars_and_the_table_is_cut_in_a_small_window(
    window: Window, small: Callable[..., Any], width: int
) -> None:
    small(width, 800)
    cut = window.page.evaluate(
        """() => [...document.querySelectorAll(".bar, .timebar, .panel.robot .tools, .numbers th, .numbers td")]
            .filter(one => one.clientWidth && one.scrollWidth > one.clientWidth + 1)
            .map(one => one.outerHTML.slice(0, 80))"""
    )
    assert cut == []
    assert window.page.locator(".timebar .speed input").bounding_box()["width"] > 60
    clock = window.page.locator(".timebar .now").bounding_box()
    assert clock["x"] + clock["width"] <= width


def test_no_caption_is_cut_at_1366_by_768(window: Window) -> None:
    assert window.page.viewport_size == {"width": 1366, "height": 768}
    window.page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
    for robot in ("rover", "second"):
        window.do(do="select", robot=robot)
        window.until(f"robot?.name === '{robot}'")
        cut = window.page.evaluate(
            """() => {
                const pen = document.createElement("canvas").getContext("2d");
                const isCut = (one) => {
                    if (one.tagName !== "SELECT") return one.scrollWidth > one.clientWidth + 1;
                    pen.font = getComputedStyle(one).font;
                    return [...one.options].some((option) => pen.measureText(option.text).width > one.clientWidth - 20);
                };
                const all = "h1, h2, h3, th, td, label, summary, button, output, select, "
                    + ".note, .scenario, .unit, .channel span";
                return [...document.querySelectorAll(all)]
                    .filter((one) => one.checkVisibility() && one.clientWidth && isCut(one))
                    .map((one) => one.outerHTML.slice(0, 100));
            }"""
        )
        assert cut == []


def test_a_cross_marks_only_what_has_happened(window: Window) -> None:
    window.page.keyboard.press("m")
    window.until("driving.isByHand")
    window.do(do="drive", robot="rover", forward=-1.5)
    window.do(do="step", steps=30)
    window.page.locator(".events-list button", has_text="wall").first.click()
    window.until("stage.mark && newest.states & 4")
    at = window.see("newest.tick")
    window.page.click("#continue")
    window.until(f"newest.newest === {at} && !(newest.states & 4)")
    assert window.see("stage.mark") is None
    # What came after has not gone for good.
    window.page.locator(".futures button", has_text="take up").click()
    window.until("newest.newest === 30")
    window.page.locator(".events-list button", has_text="wall").first.wait_for()
    window.page.locator(".futures button", has_text="take up").click()
    window.until(f"newest.newest === {at}")


def test_dialogs_say_where_the_folder_is_and_offer_names_that_are_free(window: Window, project: Path) -> None:
    page, offered = window.page, []
    window.do(do="step", steps=2)
    for button in ("save run", "save as…"):
        for _ in range(2):
            window.save(button)
            page.wait_for_selector("#asked-name")
            offered.append(page.input_value("#asked-name"))
            expect(page.locator("dialog .help")).to_contain_text(str(project))
            page.keyboard.press("Enter")
            page.wait_for_selector("dialog", state="detached", timeout=120_000)
    assert all((project / name).exists() for name in offered)
    assert len(set(offered)) == 4
    assert offered[0].startswith("run")
    assert offered[2].startswith("room-changed")
