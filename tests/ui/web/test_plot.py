"""Plots in the window: what a drag, a double click and the pointer do."""

from __future__ import annotations

import pytest

from tests.ui.windows import Window

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own


@pytest.fixture(autouse=True)
def driven(window: Window) -> None:
    """A past of twenty steps, and the plot of x."""
    window.page.keyboard.press("m")
    window.until("driving.isByHand")
    window.do(do="drive", robot="rover", forward=0.5)
    for tick in range(1, 21):
        window.do(do="step")
        window.until(f"newest.tick === {tick}")
    window.see("plots.choose('x')")
    window.see("plots.first.setMode('values')")
    window.drawn()


def times(window: Window) -> tuple[float, float]:
    """What part of the time is shown [s]."""
    low, high = window.see("plots.first.plot.chart.scales.x.min"), window.see("plots.first.plot.chart.scales.x.max")
    return low, high


def across(window: Window, time: float) -> tuple[float, float]:
    """Where a moment is on the page."""
    box = window.page.locator(".chart .u-over").bounding_box()
    return box["x"] + window.see(f"plots.first.plot.chart.valToPos({time}, 'x')"), box["y"] + box["height"] / 2


def test_all_of_the_time_is_shown_until_a_drag_picks_a_part(window: Window) -> None:
    page = window.page
    assert times(window) == pytest.approx((0.0, 2.0))
    whole = window.see("plots.first.plot.range")
    page.mouse.move(*across(window, 0.5))
    page.mouse.down()
    page.mouse.move(*across(window, 1.0), steps=4)
    page.mouse.up()
    window.until("plots.first.plot.zoom")
    window.drawn()
    # To a pixel.
    assert times(window) == pytest.approx((0.5, 1.0), abs=0.02)
    low, high = window.see("plots.first.plot.range")
    assert high - low < 0.7 * (whole[1] - whole[0])  # the axis of values fits that part
    # It stays while time goes on, and for another quantity; the panes show the paths of that time alone.
    window.do(do="step")
    window.until("newest.tick === 21")
    window.drawn()
    assert times(window) == pytest.approx((0.5, 1.0), abs=0.02)
    window.see("plots.choose('y')")
    window.drawn()
    assert times(window) == pytest.approx((0.5, 1.0), abs=0.02)
    assert window.see("stage.trueTrail.from") == pytest.approx(5.0, abs=0.2)
    assert window.see("stage.trueTrail.to") == pytest.approx(10.0, abs=0.2)


@pytest.mark.parametrize("way", ["double click", "keyboard"])
def test_all_is_shown_again(window: Window, way: str) -> None:
    button = window.page.locator(".plot button", has_text="all")
    assert button.is_hidden()
    window.see("plots.zoomTo([0.5, 1.0])")
    window.drawn()
    assert times(window) == pytest.approx((0.5, 1.0))
    assert button.is_visible()
    if way == "keyboard":
        button.focus()
        window.page.keyboard.press("Enter")
    else:
        window.page.mouse.dblclick(*across(window, 0.7))
    window.until("!plots.first.plot.zoom")
    window.drawn()
    assert times(window) == pytest.approx((0.0, 2.0))
    assert button.is_hidden()


def test_the_pointer_tells_the_values_of_its_moment(window: Window) -> None:
    said = window.page.locator(".plot-values")
    assert said.inner_text() == ""
    window.page.mouse.move(*across(window, 1.01))
    window.page.wait_for_selector(".plot-values:not(:empty)")
    true = window.page.evaluate(
        """() => {
            const { times, values } = document.querySelector(".amorsim").simulator.record.series.get("x");
            return values[0][times.findIndex((time) => time > 0.99)];
        }"""
    )
    assert said.inner_text().startswith(f"1.00 s: true {true:.3f} · measured – · estimated ")
    assert said.inner_text().endswith(" m")
    window.page.mouse.move(5, 5)
    window.page.wait_for_selector(".plot-values:empty", state="attached")


def test_it_is_drawn_in_the_colours_of_the_theme(window: Window) -> None:
    drawn = """() => {
        const { simulator } = document.querySelector(".amorsim");
        const { ctx } = simulator.plots.first.plot.chart;
        const probe = document.createElement("canvas").getContext("2d");
        probe.fillStyle = simulator.stage.theme.true;
        probe.fillRect(0, 0, 1, 1);
        const [r, g, b] = probe.getImageData(0, 0, 1, 1).data;
        const { data } = ctx.getImageData(0, 0, ctx.canvas.width, ctx.canvas.height);
        let count = 0;
        for (let i = 0; i < data.length; i += 4) {
            const apart = Math.abs(data[i] - r) + Math.abs(data[i + 1] - g) + Math.abs(data[i + 2] - b);
            count += data[i + 3] > 200 && apart < 30;
        }
        return count;
    }"""
    for _ in ("one theme", "the other"):
        window.drawn()
        window.page.wait_for_function(f"() => ({drawn})() > 50")
        window.page.keyboard.press("l")
        window.do(do="step")
    window.drawn()
