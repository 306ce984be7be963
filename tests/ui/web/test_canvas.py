"""The parts of the window's canvases: layers, tools, the selection, and what finds things under the pointer."""

from __future__ import annotations

import pytest

from tests.ui.windows import SIMULATOR, Window

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own

INNER_WALL = (6.0, 1.5)  # a point of it


def click(window: Window, pane: str, place: tuple[float, float]) -> None:
    box = window.page.locator(f"#pane-{pane}").bounding_box()
    left, top = window.page.evaluate(f"{SIMULATOR}.stage.camera.toScreen({place[0]}, {place[1]})")
    window.page.mouse.click(box["x"] + left, box["y"] + top)


def drawings(window: Window) -> int:
    window.drawn()
    return int(window.see("stage.robot.bitmaps[0].drawings"))


def test_what_stands_still_is_drawn_once_until_the_camera_or_the_theme_changes(window: Window) -> None:
    window.see("stage.setOption('grid', false)")
    for tick in range(1, 4):
        window.do(do="step")
        window.until(f"newest.tick === {tick}")
        window.drawn()
    first = drawings(window)
    assert first > 0
    for tick in range(4, 10):
        window.do(do="step")
        window.until(f"newest.tick === {tick}")
        window.drawn()
    assert drawings(window) == first
    for key in ("+", "l"):
        window.page.keyboard.press(key)
        for _ in range(3):
            window.do(do="step")
            window.drawn()
        window.until("!stage.asked")
        assert drawings(window) > first, key
        first = drawings(window)
    # It has the colours of the theme: a corner of the pane is paper.
    corner = window.see("stage.robot.context.getImageData(3, 3, 1, 1).data.slice(0, 3).join()")
    paper = window.page.evaluate(
        f"""() => {{
            const probe = document.createElement("canvas").getContext("2d");
            probe.fillStyle = {SIMULATOR}.stage.theme.paper;
            probe.fillRect(0, 0, 1, 1);
            return probe.getImageData(0, 0, 1, 1).data.slice(0, 3).join();
        }}"""
    )
    assert corner == paper
    window.page.keyboard.press("l")
    window.see("stage.setOption('grid', true)")


def test_a_bitmap_shows_what_its_layers_draw(window: Window) -> None:
    """The same pixels whether the layers are drawn as they are, or through their bitmap."""
    window.do(do="step")
    window.drawn()
    apart = window.page.evaluate(
        f"""() => {{
            const pane = {SIMULATOR}.stage.robot;
            const look = () => pane.context.getImageData(0, 0, pane.canvas.width, pane.canvas.height).data;
            pane.bitmaps = [];
            pane.draw();
            const plain = look();
            pane.draw();
            pane.draw();
            const cached = look();
            let apart = 0;
            for (let i = 0; i < plain.length; i++) apart = Math.max(apart, Math.abs(plain[i] - cached[i]));
            return [apart, pane.bitmaps[0].drawings];
        }}"""
    )
    assert apart[0] < 40  # of 255: edges are smoothed by another path through the browser
    assert apart[1] == 1


def test_a_wall_that_is_clicked_is_selected_and_tells_its_ends(window: Window) -> None:
    window.hide_readings()
    for pane, title in (("robot", "wall"), ("control", "wall of its map")):
        click(window, pane, INNER_WALL)
        window.until("stage.selection.only?.kind === 'wall'")
        lines = window.page.locator(".card").inner_text().splitlines()
        assert lines[0] == title
        assert sorted(lines[1:3]) == ["from 6.000, 0.000 m", "to 6.000, 3.000 m"]
        assert lines[3] == "3.000 m long"
        # What is selected in one pane says nothing in the other.
        shown = [
            window.page.evaluate(f"{SIMULATOR}.stage.{one}.layers.filter(l => l.things?.length).length")
            for one in ("robot", "control")
        ]
        assert shown == ([1, 0] if pane == "robot" else [0, 1])
        window.page.keyboard.press("Escape")
        assert window.page.locator(".card").is_hidden()
        assert window.see("stage.selection.things.length") == 0
    click(window, "robot", (9.0, 6.0))  # where nothing is
    assert window.page.locator(".card").is_hidden()


TOOL = f"""async () => {{
    const {{ Tool }} = await import("/amorsim/web/shared/tool.js");
    const pane = {SIMULATOR}.stage.robot;
    window.calls = [];
    class Pencil extends Tool {{
        get cursor() {{ return "crosshair"; }}
        down(place) {{ window.calls.push(["down", place.x, place.y]); }}
        move(place) {{ if (pane.active) window.calls.push(["move"]); }}
        up(place) {{ window.calls.push(["up", place.x, place.y]); }}
        cancel() {{ window.calls.push(["cancel"]); }}
        key(event, middle) {{ window.calls.push(["key", event.key]); return true; }}
    }}
    window.hand = pane.tool;
    pane.take(new Pencil());
}}"""


def test_a_tool_has_the_pointer_and_the_keys_of_its_canvas(window: Window) -> None:
    page = window.page
    page.evaluate(TOOL)
    box = page.locator("#pane-robot").bounding_box()
    x, y = window.see("stage.camera.x"), window.see("stage.camera.y")
    left, top = page.evaluate(f"{SIMULATOR}.stage.camera.toScreen(3.0, 2.0)")
    assert page.locator("#pane-robot").evaluate("one => getComputedStyle(one).cursor") == "crosshair"
    page.mouse.move(box["x"] + left, box["y"] + top)
    page.mouse.down()
    page.mouse.move(box["x"] + left + 30, box["y"] + top)
    page.mouse.up()
    page.keyboard.press("k")
    page.mouse.down()
    page.keyboard.press("Escape")
    page.mouse.up()
    calls = page.evaluate("window.calls")
    assert [one[0] for one in calls] == ["down", "move", "up", "key", "down", "cancel"]
    scale = window.see("stage.camera.scale")
    assert calls[0][1:] == pytest.approx([3.0, 2.0], abs=0.01)
    assert calls[2][1:] == pytest.approx([3.0 + 30 / scale, 2.0], abs=0.01)
    assert (window.see("stage.camera.x"), window.see("stage.camera.y")) == (x, y)  # it has not panned
    page.evaluate(f"{SIMULATOR}.stage.robot.take(window.hand)")
    page.mouse.down()
    page.mouse.move(box["x"] + left + 60, box["y"] + top + 10)
    assert page.locator("#pane-robot").evaluate("one => getComputedStyle(one).cursor") == "grabbing"
    page.mouse.up()
    assert window.see("stage.camera.x") == pytest.approx(x - 30 / scale)


def test_the_spatial_index_finds_all_that_is_near(window: Window) -> None:
    found = window.page.evaluate(
        """async () => {
            const { SpatialIndex } = await import("/amorsim/web/shared/spatial.js");
            const { gapToLine } = await import("/amorsim/web/shared/spatial.js");
            let seed = 7;
            const random = () => (seed = (seed * 48271) % 2147483647) / 2147483647;
            const index = new SpatialIndex(0.7);
            const things = [];
            for (let n = 0; n < 400; n++) {
                const [x, y] = [40 * random() - 20, 40 * random() - 20];
                const kind = n % 4;
                // Slanted, upright and level lines, some of them long, and discs.
                const ends = [[8 * random() - 4, 8 * random() - 4], [0, 30 * random()], [-20 * random(), 0], []];
                const [u, v] = ends[kind];
                const thing = kind === 3 ? { x, y, reach: random() } : { line: [x, y, x + u, y + v] };
                things.push(thing);
                if (thing.line) index.addLine(thing, ...thing.line);
                else index.addDisc(thing, x, y, thing.reach);
            }
            const [missed, sizes] = [[], []];
            for (let n = 0; n < 2000; n++) {
                const [x, y, reach] = [44 * random() - 22, 44 * random() - 22, n % 3 ? random() : 0.01];
                const near = index.near(x, y, reach);
                sizes.push(near.size);
                for (const thing of things) {
                    const gap = thing.line
                        ? gapToLine(x, y, ...thing.line)
                        : Math.max(0, Math.hypot(thing.x - x, thing.y - y) - thing.reach);
                    if (gap <= reach && !near.has(thing)) missed.push([x, y, reach, thing]);
                }
            }
            return { missed, mean: sizes.reduce((a, b) => a + b) / sizes.length, far: index.near(0, 0, 1e6).size };
        }"""
    )
    assert found["missed"] == []
    assert found["mean"] < 40  # of 400
    assert found["far"] == 400
