"""What the tests in a browser build on: a served simulator, and a window on it as its user has it."""

from __future__ import annotations

import os
import re
import select
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = Path("/usr/bin/chromium")
FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
PATIENCE = 120.0  # [s]; all that is waited for comes within a second, but on a machine that does much else
SIMULATOR = "document.querySelector('.amorsim')?.simulator"

ROOM = """0 0 12000 0
12000 0 12000 8000
12000 8000 0 8000
0 8000 0 0
6000 0 6000 3000
"""
SCENARIO = """format = 1

[world]
map = "room.wld"

[simulation]
dt = 0.1
duration = 60.0
seed = 4

[[robots]]
name = "rover"
model = "pioneer2dx"
pose = { x = 2.0, y = 4.0, heading_deg = 0.0 }
controller = { use = "CONTROLLER" }

[robots.knowledge]
map = "room.wld"

[[robots]]
name = "second"
model = "pioneer2dx"
pose = { x = 2.0, y = 6.5, heading_deg = 0.0 }
controller = { use = "manual" }
"""


def write_scenario(folder: Path, controller: str = "manual") -> Path:
    """A room with two robots; the first has this controller."""
    (folder / "room.wld").write_text(ROOM)
    file = folder / "room.toml"
    file.write_text(SCENARIO.replace("CONTROLLER", controller))
    return file


class Server:
    """`amorsim view` of a scenario, in its folder; or another command with a window."""

    def __init__(self, scenario: Path, *, words: Sequence[str] = (), env: Mapping[str, str] | None = None) -> None:
        self.folder = scenario.parent
        command = [sys.executable, "-m", "amorsim", *(words or ["view", scenario.name]), "--no-open"]
        self.process = subprocess.Popen(
            command,
            cwd=self.folder,
            env={**os.environ, **(env or {})},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            bufsize=0,
        )
        assert self.process.stdout is not None
        self._pipe = self.process.stdout.fileno()
        self._said = ""
        while not self._addresses:
            part = os.read(self._pipe, 65536)
            if not part:
                raise AssertionError("no address was printed:\n" + self._said)
            self._said += part.decode()

    @property
    def _addresses(self) -> list[str]:
        whole = self._said[: self._said.rfind("\n") + 1]
        return [word for word in whole.split() if word.startswith("http://") and "token=" in word]

    @property
    def address(self) -> str:
        """The address that was printed last: each works once, and the next is printed before its page is shown."""
        while select.select([self._pipe], [], [], 0.0)[0] and (part := os.read(self._pipe, 65536)):
            self._said += part.decode()
        return self._addresses[-1]

    def close(self) -> None:
        self.process.terminate()
        try:
            self.process.wait(5.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        assert self.process.stdout is not None
        self.process.stdout.close()


class Window:
    """A window in the browser, with what it shows."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.problems: list[str] = []
        page.on("pageerror", self._note)
        page.on("console", self._read)

    def _note(self, error: Any) -> None:
        self.problems.append(str(error))

    def _read(self, message: Any) -> None:
        if "Content Security Policy" in message.text:
            self.problems.append(message.text)

    def open(self, address: str) -> Window:
        self.page.goto(address)
        self.until("stage.frame")
        return self

    def leave(self) -> None:
        """Go elsewhere, as a user who has forgotten all: the page may then be another window's."""
        if not self.page.is_closed():
            self.page.evaluate("localStorage.clear(), sessionStorage.clear()")
            self.page.goto("about:blank")
        self.page.remove_listener("pageerror", self._note)
        self.page.remove_listener("console", self._read)

    def see(self, expression: str) -> Any:
        """The value of an expression of the simulator's window: `newest.tick`."""
        return self.page.evaluate(f"{SIMULATOR}.{expression}")

    def save(self, what: str) -> None:
        """Choose something in the list of what can be saved."""
        self.page.click("button:text-is('save ▾')")
        self.page.locator(".save-list").get_by_role("button", name=what, exact=True).click()

    def until(self, expression: str, *, seconds: float = PATIENCE) -> None:
        """Wait until something holds of the window; names in the expression are the simulator's."""
        self.page.wait_for_function(
            f"() => {{ const one = {SIMULATOR}; if (!one?.state) return false; with (one) return {expression}; }}",
            timeout=1000 * seconds,
        )

    def ask(self, **command: Any) -> dict[str, Any]:
        """A command by the window's own connection."""
        return dict(self.page.evaluate(f"command => {SIMULATOR}.connection.ask(command)", command))

    def do(self, **command: Any) -> dict[str, Any]:
        said = self.ask(**command)
        assert said["ok"], said
        return said

    def true_pose(self) -> list[float]:
        return list(self.see("newest.truePoses.slice(0, 3)"))

    def begin(self) -> None:
        """A paused simulation at its start, and no element with the keyboard."""
        self.do(do="reset")
        self.do(do="speed", factor=1.0)
        self.until("newest.tick === 0 && !(newest.states & 1)")
        self.page.evaluate("document.activeElement?.blur()")

    def field(self, path: str) -> Any:
        return self.page.locator(f'[data-path="{path}"]')

    def hide_readings(self) -> None:
        """Leave the robots alone in the panes: for tests that look for a colour."""
        for name in ("trails", "ellipse", "grid"):
            self.see(f"stage.setOption('{name}', false)")
        for button in self.page.locator(".panel.control .tools button").all():
            if button.get_attribute("aria-pressed") == "true":
                button.click()
        self.drawn()

    def switch_off(self, label: str, names: list[str]) -> None:
        """Take away what each of the switches of a group, with these names, shows in the controller's pane."""
        buttons = self.page.locator(f".panel.control [aria-label='{label}'] button")
        expect(buttons).to_have_text(names)
        before = self.see("stage.control.canvas.toDataURL()")
        for button in buttons.all():
            button.click()
            expect(button).to_have_attribute("aria-pressed", "false")
            assert eventually(lambda shown=before: self.see("stage.control.canvas.toDataURL()") != shown), label
            self.drawn()
            before = self.see("stage.control.canvas.toDataURL()")

    def drawn(self) -> None:
        """Wait until what has come is drawn."""
        self.page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def middle_of(self, pane: str, colour: str) -> tuple[float, float, int]:
        """The middle [m] of the pixels below y = 5.8 m that are near a colour of the theme, and how many they are."""
        found = self.page.evaluate(
            f"""([pane, name]) => {{
                const stage = {SIMULATOR}.stage;
                const canvas = stage[pane].canvas;
                const probe = document.createElement("canvas").getContext("2d");
                probe.fillStyle = stage.theme[name];
                probe.fillRect(0, 0, 1, 1);
                const [r, g, b] = probe.getImageData(0, 0, 1, 1).data;
                const {{ data, width }} = stage[pane].context.getImageData(0, 0, canvas.width, canvas.height);
                let [left, top, count] = [0, 0, 0];
                const first = Math.round(stage.camera.toScreen(0, 5.8)[1] * stage[pane].ratio) * width * 4;
                for (let i = first; i < data.length; i += 4) {{
                    if (Math.abs(data[i] - r) + Math.abs(data[i + 1] - g) + Math.abs(data[i + 2] - b) > 60) continue;
                    left += (i / 4) % width;
                    top += Math.floor(i / 4 / width);
                    count += 1;
                }}
                const ratio = stage[pane].ratio;
                return [...stage.camera.toWorld(left / count / ratio, top / count / ratio), count];
            }}""",
            [pane, colour],
        )
        return found[0], found[1], found[2]


def add_thing(page: Any, name: str) -> None:
    """Choose something in the Editor's gallery, to be placed."""
    page.get_by_role("button", name="add …").click()
    page.get_by_label("search").fill(name)
    exactly = page.locator("strong", has_text=re.compile(f"^{re.escape(name)}$"))
    page.locator("dialog .card-choice:visible", has=exactly).click()
    expect(page.locator("dialog")).to_have_count(0)


def axe_violations(page: Any) -> list[str]:
    """What axe finds wrong with a page, targets that are too small for a finger included; skips where it is missing."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is not installed").Axe()
    found = axe.run(page, options={"rules": {"target-size": {"enabled": True}}}).response["violations"]
    return [f"{one['id']}: {node['html'][:200]}" for one in found for node in one["nodes"]]


def new_user(browser: Any) -> Any:
    """A browser's user, with separate cookies, storage and cache."""
    user = browser.new_context(viewport={"width": 1366, "height": 768}, accept_downloads=True)
    user.set_default_timeout(1000 * PATIENCE)
    return user


def expect(found: Any) -> Any:
    """Playwright's expectations of what is found, which wait until they hold."""
    # Imported here, because tests that need no browser run without Playwright.
    from playwright.sync_api import expect

    expect.set_options(timeout=1000 * PATIENCE)
    return expect(found)


def eventually(holds: Callable[[], bool], seconds: float = PATIENCE) -> bool:
    """Whether something holds within a while."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if holds():
            return True
        time.sleep(0.05)
    return holds()
