"""More of the Editor in a real Chromium: all bundled scenarios, robots from parts, a killed server, who gets in."""

from __future__ import annotations

import contextlib
import http.client
import math
import random
import re
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest
from PIL import Image

import amorsim as am
from amorsim.plugins.manager import default_registry
from amorsim.ui.editor.work import Work
from tests.ui.test_window_editor import PAGE, Editor
from tests.ui.windows import SIMULATOR, Server, eventually, expect, new_user

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own


@pytest.fixture
def open_editor(browser: Any, tmp_path: Path) -> Iterator[Any]:
    opened: list[Editor] = []

    def open_one(*words: str) -> Editor:
        opened.append(Editor(browser, tmp_path, *words))
        return opened[-1]

    yield open_one
    for editor in opened:
        editor.close()


@pytest.mark.parametrize("name", default_registry().names("scenario"))
def test_a_bundled_scenario_opens_and_one_thing_in_it_is_moved_and_undone(open_editor: Any, name: str) -> None:
    editor = open_editor(name)
    expect(editor.page.locator(".status")).to_contain_text("no faults")
    things = [thing for thing in editor.see("stage.things") if thing["pose"] and thing["moves"]]
    if not things:  # a swarm starts at random: its seed
        editor.step(lambda: editor.see("edit('seed', [{op: 'set', path: 'simulation.seed', value: 77}])"))
    else:
        x, y, _ = things[0]["pose"]
        editor.look_near(x, y, 100.0)
        editor.step(lambda: editor.drag((x, y), (x + 0.1, y)))
        (moved,) = [thing for thing in editor.see("stage.things") if thing["path"] == things[0]["path"]]
        on_grid = math.floor(10.0 * (x + 0.1) + 0.5) / 10.0  # as JavaScript rounds halves
        assert moved["pose"][0] == pytest.approx(on_grid, abs=1e-3)
        assert moved["pose"][1] == pytest.approx(y, abs=1e-4)
    editor.step(lambda: editor.page.keyboard.press("Control+z"))
    said = editor.page.evaluate(f"{PAGE}.connection.ask({{do: 'text'}})")
    assert said["text"] == am.open_document(name).text


def test_a_robot_gets_a_sensor_with_noise_and_an_error_and_runs(open_editor: Any, tmp_path: Path) -> None:
    editor = open_editor("demo")
    page = editor.page
    page.click('[data-key="robots.0"]')
    page.wait_for_selector('[data-section="robots.0.sensors"]')
    page.click('[data-section="robots.0.sensors"] > summary')
    page.select_option("[id='add-robots.0.sensors']", "gyro")
    editor.step(lambda: page.click("[aria-label='add to Sensors']"))
    page.wait_for_selector('[data-section="robots.0.sensors.gyro2"]')
    page.click('[data-section="robots.0.sensors.gyro2.noise"] > summary')
    page.select_option("[id='add-robots.0.sensors.gyro2.noise']", "gaussian")
    editor.step(lambda: page.click("[aria-label='add to Noise of gyro2']"))
    page.wait_for_selector('[data-section="robots.0.sensors.gyro2.noise.0"]')
    page.click('[data-section="robots.0.sensors.gyro2.noise.0"] > summary')
    std = page.locator('[data-path^="robots.0.sensors.gyro2.noise.0.std"] input').first
    std.fill("2")
    editor.step(lambda: std.press("Enter"))
    page.click('[data-section="robots.0.errors"] > summary')
    area = page.locator('textarea[data-path="robots.0.errors"]')
    area.fill("drive = { track = { scale = 1.1 } }\n")
    editor.step(lambda: area.press("Control+Enter"))
    expect(page.locator(".status")).to_contain_text("no faults")
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("Control+s")
    page.fill("#asked-name", "mine")
    editor.step(lambda: page.click("dialog .main"))
    robot = am.load(tmp_path / "mine.toml").robots[0]
    assert robot.sensors["gyro2"].noise[0].noise.std == pytest.approx(0.0349, abs=1e-3)
    text = (tmp_path / "mine.toml").read_text()
    assert "track = { scale = 1.1 }" in text
    assert "wheel_radius_left" not in text
    page.click(".run")
    page.wait_for_url("**/run/mine**", timeout=120_000)
    page.wait_for_function(f"() => {SIMULATOR}?.stage.frame", timeout=60_000)
    names = page.evaluate(f"{SIMULATOR}.stage.scene.robots[0].sensors.map((sensor) => sensor.name)")
    assert "gyro2" in names


def test_a_killed_server_and_a_page_loaded_again_lose_nothing(open_editor: Any) -> None:
    editor = open_editor("demo")
    editor.step(lambda: editor.see("edit('seed', [{op: 'set', path: 'simulation.seed', value: 77}])"))
    editor.step(lambda: editor.see("edit('wall', [{op: 'walls', add: [[1, 1, 2, 1]]}])"))
    editor.page.reload()
    editor.until("state && !state.is_behind && isHolder")
    assert editor.see("state.steps") == 2
    editor.server.process.send_signal(signal.SIGKILL)
    editor.server.process.wait()
    again = open_editor("demo")
    assert again.see("state.steps") == 2
    expect(again.page.locator(".banner")).to_contain_text("not saved")
    walls = len(again.see("stage.walls.walls"))
    again.step(lambda: again.page.keyboard.press("Control+z"))
    assert len(again.see("stage.walls.walls")) == walls - 1
    again.step(lambda: again.page.click("text=begin without them"))
    said = again.page.evaluate(f"{PAGE}.connection.ask({{do: 'text'}})")
    assert said["text"] == am.open_document("demo").text


CHANGING = f"""(first) => {{
    window.reached = first;
    (async () => {{
        for (let n = first + 1; ; n++) {{
            const changes = [{{ op: "set", path: "simulation.seed", value: n }}];
            const said = await {PAGE}.connection.ask({{ do: "edit", label: "seed", changes }});
            if (!said.ok) return;
            window.reached = n;
        }}
    }})();
}}"""


def seed_of(editor: Any) -> int:
    text = editor.page.evaluate(f"{PAGE}.connection.ask({{do: 'text'}})")["text"]
    return int(re.findall(r"seed = (\d+)", text)[0])


def test_a_page_and_a_server_killed_while_things_are_changed_lose_nothing_that_was_answered(
    open_editor: Any, browser: Any, tmp_path: Path
) -> None:
    chance = random.Random(4)
    for _ in range(3):
        editor = open_editor("demo")
        for _ in range(2):
            before = seed_of(editor)
            editor.page.evaluate(CHANGING, before)
            editor.page.wait_for_timeout(chance.uniform(50.0, 500.0))
            reached = editor.page.evaluate("window.reached")
            with contextlib.suppress(Exception):  # which is what it does
                editor.page.goto("chrome://crash")
            editor.page.context.close()
            editor.page = new_user(browser).new_page()
            editor.page.goto(editor.server.address)
            editor.until("state && !state.is_behind && stage.still && isHolder", seconds=60.0)
            assert seed_of(editor) >= reached > before
        before = seed_of(editor)
        editor.page.evaluate(CHANGING, before)
        editor.page.wait_for_timeout(chance.uniform(50.0, 500.0))
        reached = editor.page.evaluate("window.reached")
        editor.server.process.send_signal(signal.SIGKILL)
        editor.server.process.wait()
        work = Work("demo", tmp_path, state=tmp_path / ".state")
        assert work.document.get("simulation.seed") >= reached > before
        work.close()


def test_a_file_that_is_changed_by_hand_is_reported_and_read_again(open_editor: Any, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    am.open_document("demo").save(file, copy=True)
    editor = open_editor("mine.toml")
    editor.step(lambda: editor.see("edit('seed', [{op: 'set', path: 'simulation.seed', value: 77}])"))
    file.write_text(file.read_text().replace('name = "rover"', 'name = "scout"'))
    expect(editor.page.locator(".banner")).to_contain_text("mine.toml was changed")
    editor.step(lambda: editor.page.click("text=reload the file"))
    editor.page.wait_for_selector('[data-key="robots.0"]:has-text("scout")')
    expect(editor.page.locator(".banner")).to_be_hidden()


def test_a_faulty_file_opens_and_is_mended_as_text(open_editor: Any, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    am.open_document("demo").save(file, copy=True)
    file.write_text(file.read_text().replace("[simulation]", "[simulation").replace("wander", "wonder"))
    editor = open_editor("mine.toml")
    page = editor.page
    shown = page.inner_text(".drawing .faults")
    for fault in am.open_document(file).faults():
        assert fault.message in shown
    page.click("text=text")
    page.wait_for_selector(".beside .cm-content")
    editor.rewrite("""(text) => text.replace("[simulation\\n", "[simulation]\\n").replaceAll("wonder", "wander")""")
    editor.step(lambda: page.click(".beside .main"))
    expect(page.locator(".status")).to_contain_text("no faults")
    page.keyboard.press("Control+s")
    assert eventually(lambda: am.open_document(file).faults() == ())


def test_thousands_of_walls_are_moved_in_one_step(open_editor: Any, tmp_path: Path) -> None:
    am.open_document("doors").save(tmp_path / "mine.toml", copy=True)
    walls = tmp_path / "rooms.wld"
    walls.write_text(walls.read_text() + "".join(f"{x} {y} {x + 1} {y}\n" for x in range(50) for y in range(100)))
    editor = open_editor("mine.toml")
    before = editor.see("stage.walls.walls")
    assert len(before) > 5000
    editor.page.keyboard.press("Control+a")
    editor.page.focus("#pane")
    editor.step(lambda: editor.page.keyboard.press("ArrowRight"))
    after = editor.see("stage.walls.walls")
    assert max(abs(wall[0] + 0.1 - moved[0]) for wall, moved in zip(before, after, strict=True)) < 1e-6
    editor.step(lambda: editor.page.keyboard.press("Control+z"))
    assert editor.see("stage.walls.walls") == before


def asked(address: str, path: str, **headers: str) -> int:
    parts = urlsplit(address)
    connection = http.client.HTTPConnection(parts.hostname or "", parts.port or 0, timeout=60.0)
    connection.request("GET", path, headers=headers)
    status = connection.getresponse().status
    connection.close()
    return status


LOOK = """
    const { pane } = editor.stage;
    const frame = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
    const drawings = () => pane.bitmaps.reduce((sum, one) => sum + one.drawings, 0);
    const look = () => pane.context.getImageData(0, 0, pane.canvas.width, pane.canvas.height).data;
    const apart = () => { // from what is drawn without bitmaps
        pane.draw();
        const cached = look();
        pane.bitmaps = [];
        pane.draw();
        const plain = look();
        return cached.reduce((most, value, n) => Math.max(most, Math.abs(value - plain[n])), 0);
    };
"""


def test_what_stands_still_is_drawn_once_while_the_view_is_panned_or_things_are_dragged(
    open_editor: Any, tmp_path: Path
) -> None:
    lines = [f"{500 * (n % 20)} {500 * (n // 20)} {500 * (n % 20) + 300} {500 * (n // 20)}" for n in range(400)]
    (tmp_path / "w.wld").write_text("\n".join(lines))
    posts = [
        f'[[obstacles]]\nname = "o{n}"\nshape = {{ circle = 0.1 }}\npose = {{ x = {n % 8}, y = {n // 8 + 0.3} }}\n'
        for n in range(40)
    ]
    (tmp_path / "w.toml").write_text('format = 1\n[world]\nmap = "w.wld"\n' + "".join(posts))
    editor = open_editor("w.toml")
    panned = editor.page.evaluate(
        f"""async () => {{
            const editor = {PAGE}; {LOOK}
            await frame();
            pane.draw();
            const before = drawings();
            for (let n = 0; n < 60; n++) {{
                editor.stage.camera.pan(3.3, 1.6);
                await frame();
            }}
            return [drawings() - before, apart()];
        }}"""
    )
    assert panned[0] <= 2  # 200 pixels to the side: at most once out of the margin
    assert panned[1] < 40  # of 255: edges are smoothed by another path through the browser
    dragged = editor.page.evaluate(
        f"""async () => {{
            const editor = {PAGE}; {LOOK}
            const {{ stage, connection }} = editor;
            const tool = editor.tools.select;
            const said = [];
            const ask = connection.ask.bind(connection);
            connection.ask = (command) => (command.do !== "document" && said.push(command), ask(command));
            stage.selection.set(stage.things.filter(({{ pose }}) => pose).map((one) => stage.chosenOf(one)));
            await frame();
            tool.shift(0.1, 0.1, true);
            await frame();
            pane.draw();
            const before = drawings();
            for (let n = 0; n < 30; n++) {{
                tool.shift(0.02 * n, 0.01 * n, true);
                await frame();
            }}
            const found = [drawings() - before, said.length, apart()];
            tool.commit("move");
            await frame();
            connection.ask = ask;
            return [...found, said.length, said[0].changes.length];
        }}"""
    )
    assert dragged[:2] == [0, 0]
    assert dragged[2] < 40
    assert dragged[3:] == [1, 40]
    editor.until("!state.is_behind && stage.things.some(({pose}) => pose && Math.abs(pose[0] - 7.58) < 1e-9)")


def test_a_stroke_and_the_map_stay_in_sight_while_the_new_picture_is_made(open_editor: Any, tmp_path: Path) -> None:
    levels = np.full((60, 80), 255, dtype=np.uint8)
    levels[20] = 0
    Image.fromarray(levels).save(tmp_path / "room.png")
    (tmp_path / "mine.toml").write_text('format = 1\n[world]\nmap = "room.png"\nresolution = 0.1\n')
    editor = open_editor("mine.toml")
    editor.until("stage.pictures.of(stage.scene.map, stage.theme.wall)")
    seen = editor.page.evaluate(
        f"""async () => {{
            const editor = {PAGE}; {LOOK}
            const {{ stage }} = editor;
            const dark = (x, y) => {{
                const [left, top] = stage.camera.toScreen(x, y);
                const [r, g, b] = pane.context.getImageData(left * pane.ratio, top * pane.ratio, 1, 1).data;
                return r + g + b < 300;
            }};
            editor.brush = 0.5;
            editor.take("brush");
            const brush = editor.tools.brush;
            await frame();
            const number = editor.state.number;
            const began = stage.pictures.version;
            brush.down({{ x: 2, y: 1 }}, {{ button: 0 }});
            brush.move({{ x: 5, y: 1 }});
            brush.up();
            const found = [];
            for (let n = 0; n < 2000 && !(stage.pictures.version > began + 1 && !editor.state.is_behind); n++) {{
                brush.move({{ x: 7, y: 2.5 }}); // the pointer goes on
                await frame();
                found.push([dark(3.5, 1), dark(4, 3.95), dark(7, 5)]);
            }}
            await frame();
            found.push([dark(3.5, 1), dark(4, 3.95), dark(7, 5)], stage.strokes.length);
            return found;
        }}"""
    )
    assert seen.pop() == 0
    assert all(one == [True, True, False] for one in seen), seen


def test_nobody_gets_in_without_the_cookie_or_from_elsewhere(tmp_path: Path) -> None:
    server = Server(tmp_path / "x", words=("edit", "demo"), env={"AMORSIM_STATE": str(tmp_path / ".state")})
    try:
        for path in ("/edit/demo", "/edit", "/amorsim/web/editor/editor.js", "/run/demo"):
            assert asked(server.address, path) == 401
            assert asked(server.address, path, Host="elsewhere.example") == 403
            assert asked(server.address, path, Origin="http://elsewhere.example") == 403
    finally:
        server.close()
