"""Other futures beside the one that is played, plots of several quantities, and how the panels are arranged."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.ui.windows import Window, axe_violations, eventually, expect

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own

LEFT_WHEEL = "errors.drive.wheel_radius_left.scale"


@pytest.fixture
def parted(window: Window) -> Iterator[Window]:
    """Twenty steps ahead; then ten others, from the tenth on, with a larger wheel; the next test has it as it was."""
    window.page.keyboard.press("m")
    window.until("driving.isByHand")
    window.do(do="drive", robot="rover", forward=0.5)
    window.do(do="step", steps=20)
    window.do(do="scrub", tick=10)
    window.page.wait_for_selector("#continue:visible")
    window.page.locator("#continue").click()
    window.until("futures.list.length === 1")
    window.do(do="set", robot="rover", path=LEFT_WHEEL, value=1.5)
    window.do(do="drive", robot="rover", forward=0.5)
    window.do(do="step", steps=8)
    window.until("newest.tick === 18")
    window.drawn()
    yield window
    window.do(do="reset")
    window.do(do="restore", robot="rover")


def test_two_futures_are_seen_side_by_side_and_in_numbers(parted: Window) -> None:
    page = parted.page
    line = page.locator(".futures li")
    expect(line).to_contain_text("A")
    assert eventually(lambda: "m away" in line.inner_text())
    away = page.evaluate(
        """() => {
            const { futures, newest } = document.querySelector(".amorsim").simulator;
            const [x, y] = futures.list[0].true[18];
            return Math.hypot(x - newest.truePoses[0], y - newest.truePoses[1]);
        }"""
    )
    assert away > 0.01
    assert eventually(lambda: f"{away:.3f} m away" in line.inner_text())
    # Its path lies in both panes: without it they look otherwise.
    for pane in ("robot", "control"):
        with_it = parted.see(f"stage.{pane}.canvas.toDataURL()")
        page.evaluate(
            "const { stage } = document.querySelector('.amorsim').simulator; stage.futures = []; stage.redraw()"
        )
        parted.drawn()
        assert parted.see(f"stage.{pane}.canvas.toDataURL()") != with_it, pane
        parted.see("showFutures()")
        parted.drawn()
    # And in the plot, as one more curve.
    parted.see("plots.choose('x')")
    parted.drawn()
    assert len(parted.see("plots.first.plot.chart.series")) == 5  # time, two edges of what is believed, here, there
    # Before they part it is the same.
    parted.do(do="scrub", tick=5)
    parted.until("newest.tick === 5")
    assert eventually(lambda: "the same up to here" in line.inner_text())
    assert axe_violations(page) == []
    # None can be taken up where the run is written as it goes.
    expect(line.get_by_text("take up")).to_have_count(1)
    page.evaluate(
        "const { futures } = document.querySelector('.amorsim').simulator; futures.canGoBack = false; futures.build()"
    )
    expect(line.get_by_text("take up")).to_have_count(0)


def test_a_future_can_be_taken_up_again_and_forgotten(parted: Window) -> None:
    page = parted.page
    page.locator(".futures button", has_text="take up").click()
    parted.until("newest.tick === 20 && futures.list.length === 1")
    expect(page.locator(".futures li strong")).to_have_text("B")
    expect(page.locator(".futures li")).to_contain_text("wheel radius left, scale 1.5")
    page.get_by_label("forget B").click()
    parted.until("!futures.list.length")
    expect(page.locator(".futures")).to_be_hidden()
    # It stays forgotten, and a reload loses nothing that is kept.
    parted.do(do="scrub", tick=15)
    parted.do(do="continue")
    parted.until("futures.list.length === 1")
    page.reload()
    parted.until("stage.frame && futures.list.length === 1")


def test_several_quantities_are_plotted_and_saved(window: Window, tmp_path: Path) -> None:
    page = window.page
    for tick in range(1, 13):
        window.do(do="step")
        window.until(f"newest.tick === {tick}")
    page.get_by_label("one more plot").click()
    window.until("plots.list.length === 2")
    page.locator(".one-plot").nth(1).get_by_label("quantity that is plotted").select_option("heading")
    page.locator(".row-name", has_text="speed ahead").click(modifiers=["Shift"])
    window.until("plots.list.length === 3")
    assert window.see("plots.list.map((one) => one.key)") == ["apart", "heading", "forward"]
    # A row of the table is dragged into a plot.
    page.locator(".row-name", has_text="turning").drag_to(page.locator(".one-plot").nth(2))
    window.until("plots.list[2].key === 'turn'")
    expect(page.locator(".numbers tr.chosen")).to_have_count(3)
    # All show the same time.
    window.see("plots.zoomTo([0.3, 0.9])")
    window.drawn()
    assert window.see("plots.list.map(({ plot }) => plot.chart.scales.x.min)") == pytest.approx([0.3] * 3)
    saved: dict[str, Any] = {}
    for form in ("csv", "svg", "png"):
        page.locator(".one-plot").nth(1).get_by_label("save this plot").click()
        assert axe_violations(page) == []
        with page.expect_download() as download:
            page.locator("dialog").get_by_role("button", name=form.upper()).click()
        saved[form] = tmp_path / download.value.suggested_filename
        download.value.save_as(saved[form])
        assert saved[form].name == f"room-1.2s-heading.{form}"
    rows = list(csv.DictReader(saved["csv"].read_text().splitlines()))
    assert [row["time [s]"] for row in rows][:3] == ["0", "0.1", "0.2"]
    assert float(rows[-1]["difference [°]"]) == pytest.approx(
        window.see("record.columns('heading', ['difference'])[0].at(-1)"), abs=1e-9
    )
    assert "<path" in saved["svg"].read_text()
    assert saved["png"].read_bytes()[:4] == b"\x89PNG"
    page.locator(".one-plot").nth(2).get_by_label("close this plot").click()
    window.until("plots.list.length === 2")
    assert axe_violations(page) == []


def test_what_the_robot_believes_is_a_band_of_two_sigma(window: Window) -> None:
    window.do(do="set", robot="rover", path="estimators.dead_reckoning.wheel_variance", value=0.01)
    window.page.keyboard.press("m")
    window.until("driving.isByHand")
    window.do(do="drive", robot="rover", forward=0.5)
    window.do(do="step", steps=15)
    window.until("newest.tick === 15")
    window.see("plots.choose('x')")
    window.drawn()
    sigma = window.page.evaluate("Math.sqrt(document.querySelector('.amorsim').simulator.newest.covariances[0])")
    assert sigma > 0.01
    low, high = window.see("plots.first.plot.curves.band")
    assert (low[-1], high[-1]) == pytest.approx((-2.0 * sigma, 2.0 * sigma))  # about no difference
    window.see("plots.first.setMode('values')")
    window.drawn()
    low, high = window.see("plots.first.plot.curves.band")
    x = window.see("newest.estimatedPoses[0]")
    assert (low[-1], high[-1]) == pytest.approx((x - 2.0 * sigma, x + 2.0 * sigma))
    window.see("plots.choose('apart')")
    window.drawn()
    assert window.see("plots.first.plot.curves.band") is None
    window.do(do="reset")
    window.do(do="restore", robot="rover")


def _size(window: Window, selector: str) -> tuple[float, float]:
    box = window.page.locator(selector).bounding_box()
    return box["width"], box["height"]


def _is(window: Window, selector: str, width: float, height: float) -> None:
    """Wait until something has this size, to two pixels."""
    assert eventually(lambda: _size(window, selector) == pytest.approx((width, height), abs=2)), _size(window, selector)


def _drag(window: Window, selector: str, right: float, down: float) -> None:
    box, mouse = window.page.locator(selector).bounding_box(), window.page.mouse
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    mouse.move(x, y)
    mouse.down()
    mouse.move(x + right, y + down, steps=4)
    mouse.up()


def test_panels_are_resized_folded_swapped_and_kept(window: Window) -> None:
    page = window.page
    wide, high = _size(window, ".panel.robot")
    _drag(window, ".divider.row", 0, -60)
    _is(window, ".panel.robot", wide, high - 60)
    _drag(window, ".divider.first", 90, 0)
    _is(window, ".panel.robot", wide + 90, high - 60)
    # Both panes still have the same point in their middle.
    for pane in ("robot", "control"):
        middle = window.see(f"stage.{pane}.keyPlace")
        assert (middle["x"], middle["y"]) == pytest.approx((window.see("stage.camera.x"), window.see("stage.camera.y")))
    # By keys, and folded.
    side = page.get_by_role("separator", name="border beside the panes")
    side.focus()
    page.keyboard.press("ArrowLeft")
    assert eventually(lambda: _size(window, ".panel.errors")[0] == pytest.approx(262 + 24, abs=2))
    _drag(window, ".divider.column", 400, 0)
    expect(page.locator(".panel.errors")).to_be_hidden()
    # Plot and Control change places.
    page.get_by_label("plot alone").drag_to(page.locator(".panel.control .pane"))
    assert page.locator(".slot[data-slot=right] > .panel.plot").count() == 1
    assert axe_violations(page) == []
    # A panel that is dropped on the plot changes places with it, and is not a quantity.
    page.get_by_label("events alone").drag_to(page.locator(".plot-area"))
    assert page.locator(".slot[data-slot=right] > .panel.events").count() == 1
    assert window.see("plots.first.key") == "apart"
    page.get_by_label("plot alone").drag_to(page.locator(".panel.events .scroll"))
    page.reload()
    window.until("stage.frame")
    assert page.locator(".slot[data-slot=right] > .panel.plot").count() == 1
    expect(page.locator(".panel.errors")).to_be_hidden()
    page.get_by_label("panels as at first").click()
    expect(page.locator(".panel.errors")).to_be_visible()
    _is(window, ".panel.robot", wide, high)
    expect(page.get_by_label("panels as at first")).to_be_hidden()


def test_a_panel_is_shown_alone(window: Window) -> None:
    page = window.page
    for name in ("robot", "control", "numbers", "plot", "events", "errors"):
        button = page.get_by_label(f"{name} alone")
        button.click()
        shown = [
            one
            for one in ("robot", "control", "numbers", "plot", "events", "errors")
            if page.locator(f".panel.{one}").is_visible()
        ]
        assert shown == [name]
        assert _size(window, f".panel.{name}")[0] > 1000
        window.drawn()
        button.click()
        expect(page.locator(".panel.robot")).to_be_visible()


def test_a_class_sees_all_whatever_is_folded_or_alone(window: Window) -> None:
    page = window.page
    _drag(window, ".divider.row", 0, 400)
    expect(page.locator(".panel.plot")).to_be_hidden()
    page.get_by_label("control alone").click()
    expect(page.locator(".panel.robot")).to_be_hidden()
    size = page.viewport_size
    page.keyboard.press("c")
    for name in ("robot", "control", "plot"):
        expect(page.locator(f".panel.{name}")).to_be_visible()
        assert _size(window, f".panel.{name}")[1] > 100
    page.keyboard.press("c")
    expect(page.locator(".panel.robot")).to_be_hidden()
    page.set_viewport_size({"width": 800, "height": 700})  # a narrow page has one below the other
    for name in ("robot", "control", "numbers", "plot", "events"):
        expect(page.locator(f".panel.{name}")).to_be_visible()
    page.set_viewport_size(size)
    page.get_by_label("panels as at first").click()
    expect(page.locator(".panel.robot")).to_be_visible()
    expect(page.get_by_label("control alone")).to_have_attribute("aria-pressed", "false")


def test_a_fleet_is_listed_searched_and_picked_by_a_box(window: Window) -> None:
    page = window.page
    page.keyboard.press("b")
    rows = page.locator(".fleet-row")
    expect(rows).to_have_count(2)
    page.get_by_label("search the robots").fill("sec")
    expect(rows).to_have_count(1)
    rows.click()
    window.until("newest.selected === 1")
    window.do(do="hand_over", robot="second", to="hand")
    page.get_by_label("search the robots").fill("by hand")
    expect(rows).to_have_count(1)
    expect(rows).to_contain_text("second")
    page.get_by_label("search the robots").fill("")
    # A box around one of the two.
    box = page.locator("#pane-robot").bounding_box()
    corner, other = (window.see(f"stage.camera.toScreen({x}, {y})") for x, y in ((1.0, 5.5), (3.0, 7.5)))
    page.keyboard.down("Shift")
    page.mouse.move(box["x"] + corner[0], box["y"] + corner[1])
    page.mouse.down()
    page.mouse.move(box["x"] + other[0], box["y"] + other[1], steps=4)
    page.mouse.up()
    page.keyboard.up("Shift")
    expect(rows).to_have_count(1)
    expect(rows).to_contain_text("second")
    assert axe_violations(page) == []
    page.locator(".fleet").get_by_role("button", name="all").click()
    expect(rows).to_have_count(2)
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("b")
    expect(page.locator(".fleet")).to_be_hidden()
    window.do(do="select", robot=0)
