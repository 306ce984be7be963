"""`amorsim view` of a scenario with faults in a real Chromium: what is said and drawn, until the file is mended."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from tests.ui.views import View
from tests.ui.windows import Server, Window, axe_violations, eventually, expect, new_user, write_scenario

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own

PAGE = "document.querySelector('.amorsim').faults"
FAULTY = """
[robots.sensors.laser]
beems = 3

[[obstacles]]
name = "box"
shape = { circle = 0.4 }
pose = { x = 9.0, y = 6.0 }

[[obstacles]]
name = "cart"
shape = { rectangle = [0.6, 0.4] }
pose = { x = 9.0, y = 4.0 }
motion = { use = "teleport" }

[[lights]]
x = 4.0
y = 1.0
"""


@pytest.fixture(scope="module")
def faulty(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """A view of a file with two faults, for all tests of this file: each writes what it wants to see."""
    file = write_scenario(tmp_path_factory.mktemp("faulty"))
    file.write_text(file.read_text() + FAULTY)
    server = Server(file)
    yield server
    server.close()


class Page:
    """The page of the faults in a browser of its own."""

    def __init__(self, browser: Any, server: Server) -> None:
        self.file = server.folder / "room.toml"
        self.text = self.file.read_text()
        self.page = new_user(browser).new_page()
        self.window = Window(self.page)
        self.page.goto(server.address)
        self.page.wait_for_selector(".fault")
        self.until(".still")

    def until(self, expression: str) -> None:
        self.page.wait_for_function(f"() => {PAGE}?.said{expression}")

    def write(self, text: str | None) -> None:
        """Write another text into the file, or delete it, and wait until the page says so."""
        number = self.page.evaluate(f"{PAGE}.said.number")
        if text is None:
            self.file.unlink()
        else:
            self.file.write_text(text)
        self.until(f".number > {number}")

    def said(self) -> list[str]:
        return [item.inner_text() for item in self.page.locator(".fault").all()]

    def close(self) -> None:
        self.page.context.close()


@pytest.fixture
def page(browser: Any, faulty: Server) -> Iterator[Page]:
    page = Page(browser, faulty)
    yield page
    if not page.file.exists() or page.file.read_text() != page.text:
        page.write(page.text)
    page.close()
    assert page.window.problems == []


def test_it_says_what_check_says_and_draws_the_rest(page: Page) -> None:
    faults = am.open_document(page.file).faults()
    assert len(faults) == 2
    expect(page.page.locator("#faults-title")).to_have_text("2 faults")
    for item, fault in zip(page.said(), faults, strict=True):
        assert f"room.toml, line {fault.line}" in item
        assert fault.named in item
        assert fault.remedy in item
        assert fault.message.split(";")[0].split(". Did")[0] in item
    assert page.page.url.endswith("/faults/room")
    assert page.page.title() == "room.toml · amorsim"
    see = page.page.evaluate
    assert see(f"{PAGE}.stage.scene.robots.map(robot => robot.name)") == ["rover", "second"]
    assert see(f"{PAGE}.stage.scene.obstacles.map(one => one.name)") == ["box", "cart"]
    expect(page.page.locator(".lack")).to_have_text("")


def test_on_a_phone_the_drawing_is_below_the_faults(page: Page) -> None:
    page.page.set_viewport_size({"width": 390, "height": 844})
    faults, drawing = (page.page.locator(name).bounding_box() for name in (".panel.faults", ".panel.drawn"))
    assert min(faults["width"], drawing["width"]) > 350.0
    assert drawing["y"] >= faults["y"] + faults["height"]
    assert drawing["height"] > 250.0


def colour_at(page: Page, x: float, y: float) -> list[int]:
    """The colour that is drawn at a place of the world [m]."""
    return list(
        page.page.evaluate(
            f"""async ([x, y]) => {{
                const {{ stage }} = {PAGE};
                await new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)));
                const {{ pane, camera }} = stage;
                const drawn = camera.onPixels(pane.ratio);
                const [left, top] = drawn.toScreen(x, y).map(part => Math.round(part * pane.ratio));
                return Array.from(pane.context.getImageData(left, top, 1, 1).data.slice(0, 3));
            }}""",
            [x, y],
        )
    )


def test_walls_bodies_and_outlines_are_drawn_where_they_are(page: Page) -> None:
    paper = colour_at(page, 11.03, 1.03)
    for x, y in ((6.0, 1.5), (2.0, 4.0), (2.0, 6.5), (9.0, 6.0)):  # a wall, two robots, an obstacle
        assert colour_at(page, x, y) != paper, (x, y)
    page.write(page.text.replace('name = "second"', 'name = "second"\ndrive = { track = "x" }'))
    (outline,) = page.page.evaluate(f"{PAGE}.stage.still.outlines")
    assert outline["name"] == "second"
    x, y = outline["footprint"]["polygon"][0]
    corner = page.page.evaluate(
        f"""async ([x, y]) => {{
            const {{ pane, camera, theme }} = {PAGE}.stage;
            await new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)));
            const [left, top] = camera.onPixels(pane.ratio).toScreen(x, y).map(part => Math.round(part * pane.ratio));
            const {{ data }} = pane.context.getImageData(left - 12, top - 12, 25, 25);
            let red = 0;
            for (let i = 0; i < data.length; i += 4) red += data[i] > data[i + 1] + 60;
            return red;
        }}""",
        [2.0 + x, 6.5 + y],
    )
    assert corner > 0


def test_a_click_and_enter_tell_what_is_there(page: Page) -> None:
    left, top = page.page.evaluate(
        f"""() => {{
            const {{ pane, camera }} = {PAGE}.stage;
            const box = pane.canvas.getBoundingClientRect();
            const [left, top] = camera.toScreen(9.0, 6.0);
            return [box.left + left, box.top + top];
        }}"""
    )
    page.page.mouse.click(left, top)
    expect(page.page.locator(".card")).to_contain_text("box")
    page.page.keyboard.press("Escape")
    expect(page.page.locator(".card")).to_be_hidden()
    page.page.evaluate(f"{PAGE}.stage.camera.centre(2.0, 4.0)")
    page.page.mouse.move(0, 0)  # else Enter points where the mouse does
    page.page.focus("#pane")
    page.page.keyboard.press("Enter")
    expect(page.page.locator(".card")).to_contain_text("rover")


WRONG = {
    "empty": (lambda text: "", ["missing", "expected format = 1", "no map can be read"]),
    "no TOML": (lambda text: text.replace("[world]", "[world"), ["not valid TOML", "line 3"]),
    "no map": (lambda text: text.replace("room.wld", "rom.wld"), ["world.map", "there is no such file"]),
    "no such component": (lambda text: text.replace("pioneer2dx", "pioneer3"), ["'pioneer3'", "Did you mean"]),
    "deleted": (lambda text: None, ["there is no such file", "nothing of this file can be drawn"]),
}


@pytest.mark.parametrize("kind", WRONG)
def test_whatever_is_wrong_with_the_file_is_said_as_soon_as_it_is_saved(page: Page, kind: str) -> None:
    change, words = WRONG[kind]
    page.write(change(page.text))
    text = page.page.inner_text(".amorsim")
    for word in words:
        assert word in text
    assert page.page.evaluate(f"{PAGE}.said.status") == "faulty"


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing(page: Page, theme: str) -> None:
    if page.page.evaluate("document.documentElement.dataset.theme") != theme:
        page.page.keyboard.press("l")
    for text in (page.text, ""):
        if text != page.text:
            page.write(text)
        assert axe_violations(page.page) == []


def test_all_is_in_sight_at_1366_by_768_and_reached_by_the_keyboard(page: Page) -> None:
    outside = page.page.evaluate(
        """() => [...document.querySelectorAll(".bar *, .head *, .panel")].filter(one => {
            const box = one.getBoundingClientRect();
            return box.width && (box.left < 0 || box.right > innerWidth + 1 || box.bottom > innerHeight + 1);
        }).map(one => one.outerHTML.slice(0, 80))"""
    )
    assert outside == []
    seen = set()
    for _ in range(12):
        page.page.keyboard.press("Tab")
        seen.add(
            page.page.evaluate("document.activeElement.getAttribute('aria-label') ?? document.activeElement.className")
        )
    assert seen >= {"light or dark (L)", "zoom out (−)", "zoom in (+)", "see all (0)", "scroll"}
    assert any(name.startswith("What can be drawn") for name in seen)


def test_the_mended_file_is_simulated_and_that_goes_on_when_the_file_is_broken_again(
    browser: Any, tmp_path: Path
) -> None:
    file = write_scenario(tmp_path)
    sound = file.read_text()
    file.write_text(sound.replace('use = "manual"', 'use = "manul"', 1))
    server = Server(file)
    context = new_user(browser)
    page = context.new_page()
    window = Window(page)

    def ticks(more: int = 10) -> None:
        """Wait until the simulation has gone on."""
        tick = window.see("newest.tick")
        window.until(f"newest.tick > {tick + more}")

    try:
        page.goto(server.address)
        page.wait_for_selector(".fault")
        file.write_text(sound)
        page.wait_for_url("**/run/room", timeout=60_000)
        run = page.url
        window.until("stage.frame")
        window.do(do="run")
        ticks()
        expect(page.locator(".banner")).to_be_hidden()
        file.write_text("")
        page.wait_for_selector(".banner.changed")
        ticks()
        assert page.url == run
        # The page of the faults leads there too, and so does the address alone.
        for path in ("/faults/room", "/"):
            page.goto(run.replace("/run/room", path))
            page.wait_for_url("**/run/room")
        window.until("newest.states & 1")
        # What is loaded again has faults: they are shown, and the simulation goes on.
        page.click(".banner.changed button")
        page.wait_for_url("**/faults/room", timeout=60_000)
        page.wait_for_selector(".fault")
        expect(page.locator("#faults-title")).to_have_text("3 faults")
        page.click("text=back to the simulation")
        page.wait_for_url("**/run/room")
        window.until("newest.tick > 30 && newest.states & 1")
        # Mended while nobody looks at the faults: the simulation is nobody's to end.
        file.write_text(sound.replace("duration = 60.0", "duration = 50.0"))
        ticks()
        assert window.see("scene.duration") == 60.0
        other = Window(context.new_page())
        other.page.goto(run)
        other.until("stage.frame")
        page.click(".banner.changed button")
        for one in (window, other):  # both windows follow to the new simulation
            one.until("scene.duration === 50 && newest.tick === 0", seconds=60.0)
            assert one.page.url == run
            expect(one.page.locator(".banner")).to_be_hidden()
        assert window.problems == other.problems == []
    finally:
        context.close()
        server.close()


@pytest.mark.parametrize("is_mended", [False, True], ids=["as it is", "mended"])
def test_the_terminal_is_informed_and_the_exit_status_is_that_of_a_mistake_unless_mended(
    tmp_path: Path, views: list[View], is_mended: bool
) -> None:
    file = write_scenario(tmp_path)
    sound = file.read_text()
    file.write_text(sound.replace('use = "manual"', 'use = "manul"', 1))
    checked = subprocess.run(
        [sys.executable, "-m", "amorsim", "check", file.name], cwd=tmp_path, capture_output=True, text=True
    )
    assert checked.returncode == 2
    view = View(file.name, cwd=tmp_path)
    views.append(view)
    if is_mended:
        file.write_text(sound)
        assert view.process.stdout is not None
        said = iter(view.process.stdout.readline, "")  # before it, perhaps, that kernels are compiled
        assert "room.toml is mended; the window shows the simulation\n" in said
    view.process.send_signal(signal.SIGINT)
    _, complained = view.process.communicate(timeout=60.0)
    assert complained.splitlines() == checked.stderr.splitlines()[:-1]
    assert eventually(lambda: view.process.poll() is not None)
    assert view.process.returncode == (0 if is_mended else 2)
