"""The Simulator's window in a real Chromium: what a user does, and what is then drawn and said."""

from __future__ import annotations

import base64
import http.server
import re
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.ui.windows import SIMULATOR, Server, Window, axe_violations, eventually, expect, new_user, write_scenario

LEFT_WHEEL = "errors.drive.wheel_radius_left.scale"


# ------------------------------------------------------------------------------------------------------------ opening


@pytest.mark.long
def test_a_page_comes_with_all_that_it_needs(window: Window) -> None:
    """One by one, its scripts would be eighty requests; the socket is none of these."""
    window.page.reload()
    window.until("stage.frame")
    assert window.page.evaluate("performance.getEntriesByType('resource').map(({ name }) => name)") == []


# ------------------------------------------------------------------------------------------------------------ driving


@pytest.mark.long
def test_keys_drive_the_robot_and_letting_go_stops_it(window: Window) -> None:
    start = window.true_pose()
    window.page.keyboard.press("m")
    window.until("driving.isByHand")
    window.page.keyboard.press(" ")
    window.page.keyboard.down("ArrowUp")
    window.until(f"newest.truePoses[0] > {start[0] + 0.3}")
    window.page.keyboard.down("a")
    window.until("newest.truePoses[2] > 0.1")
    window.page.keyboard.up("a")
    window.page.keyboard.up("ArrowUp")
    assert eventually(lambda: window.see("newest.command.every(part => part === 0)"))
    window.until("newest.trueTwist.every(part => part === 0)")


@pytest.mark.long
def test_the_robot_stops_when_the_window_loses_the_keyboard(window: Window) -> None:
    window.page.keyboard.press("m")
    window.until("driving.isByHand")
    window.page.keyboard.press(" ")
    window.page.keyboard.down("w")
    window.until("newest.command.some(part => part > 1)")
    window.page.evaluate("window.dispatchEvent(new Event('blur'))")  # no key is let go
    window.until("newest.command.every(part => part === 0)")
    window.page.keyboard.up("w")


@pytest.mark.long
def test_a_window_that_vanishes_stops_what_it_drove(
    window: Window, served: Server, open_window: Callable[[Server], Window]
) -> None:
    watcher = open_window(served)
    # The window that opened last has the focus, and one that loses it lets go of its keys.
    window.page.bring_to_front()
    window.page.wait_for_function("document.hasFocus()")
    window.page.keyboard.press("m")
    window.until("driving.isByHand")
    window.page.keyboard.press(" ")
    window.until("newest.states & 1")

    def drives() -> bool:
        """Hold the key, again if the other window took the focus late; whether the robot drives."""
        window.page.bring_to_front()
        window.page.keyboard.up("w")
        window.page.keyboard.down("w")
        window.page.wait_for_timeout(500)
        return bool(watcher.see("newest.command.some(part => part > 1)"))

    assert eventually(drives)
    window.page.close()
    watcher.until("newest.command.every(part => part === 0)")


@pytest.mark.long
def test_buttons_drive_by_pointer_and_by_keyboard(window: Window) -> None:
    window.page.click("#hand")
    window.until("driving.isByHand")
    window.page.click("#run")
    button = window.page.locator(".drive-left")
    button.hover()
    window.page.mouse.down()
    window.until("newest.truePoses[2] > 0.1")
    window.page.mouse.up()
    window.until("newest.command.every(part => part === 0)")
    window.page.locator(".drive-back").focus()
    window.page.keyboard.down("Enter")
    window.until("newest.command.every(part => part < -1)")
    window.page.keyboard.up("Enter")
    window.until("newest.command.every(part => part === 0)")


@pytest.mark.long
def test_each_channel_of_the_drive_has_a_slider(window: Window) -> None:
    window.page.click("#hand")
    window.until("driving.isByHand")
    window.page.click("text=channel by channel")
    slider = window.page.locator(".channels input").first
    slider.focus()
    for _ in range(5):
        window.page.keyboard.press("ArrowRight")
    wanted = float(slider.input_value())
    assert wanted > 0.5
    window.do(do="step")
    window.until(f"Math.abs(newest.command[0] - {wanted}) < 1e-9 && newest.command[1] === 0")


# ----------------------------------------------------------------------------------------------------- cause and effect


@pytest.mark.long
def test_a_wheel_radius_makes_the_estimate_drift_from_the_truth_in_the_drawn_frame(window: Window) -> None:
    window.hide_readings()
    window.page.keyboard.press("m")
    window.until("driving.isByHand")
    (x, y, _), (u, v, count) = window.middle_of("robot", "true"), window.middle_of("control", "estimated")
    assert count > 20
    assert abs(x - u) < 0.06  # a pixel or two: nothing has moved yet
    assert abs(y - v) < 0.06
    field = window.field(LEFT_WHEEL).locator("input[type=text]")
    field.fill("1.1")
    field.press("Enter")
    window.until(f"form.fields.get('{LEFT_WHEEL}').parameter.value === 1.1")
    window.do(do="drive", robot="rover", forward=0.8)
    window.do(do="step", steps=60)
    window.until("newest.tick === 60")
    window.drawn()
    drawn_truth, drawn_belief = window.middle_of("robot", "true"), window.middle_of("control", "estimated")
    truth, belief = window.see("newest.truePoses.slice(0, 3)"), window.see("newest.estimatedPoses.slice(0, 3)")
    apart = ((belief[0] - truth[0]) ** 2 + (belief[1] - truth[1]) ** 2) ** 0.5
    assert apart > 0.3  # a left wheel a tenth too large bends the path to the right
    assert truth[1] < belief[1] - 0.3
    assert drawn_belief[:2] == pytest.approx(belief[:2], abs=0.08)
    assert drawn_truth[:2] == pytest.approx(truth[:2], abs=0.08)
    # The table follows a few times a second, and so perhaps a moment later.
    window.until(f"document.querySelector('tr.chosen td.difference').innerText.replace('+', '') === '{apart:.3f}'")


@pytest.mark.long
def test_control_tells_the_measured_velocities(window: Window) -> None:
    window.page.keyboard.press("m")
    window.until("driving.isByHand")
    window.do(do="drive", robot="rover", forward=0.4)
    window.do(do="step", steps=2)
    window.until("newest.tick === 2")
    rate = window.see("newest.measuredRates[0]")
    # It speeds up; both are the mean over a step.
    assert 0.1 < rate == pytest.approx(window.see("newest.trueRates[0]"), abs=0.01)
    window.until(f"stage.control.note.innerText.includes('left wheel {rate:.2f} rad/s')")
    assert window.see("stage.robot.note.innerText") == ""


@pytest.mark.long
def test_true_beams_fall_where_the_true_sensor_looks(window: Window) -> None:
    path = "errors.sensors.laser.mount.heading.add"
    window.page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
    number = window.field(path).locator("input[type=text]")
    number.fill("10")  # in degrees
    number.press("Enter")
    laser = window.see("robot.sensors.findIndex(sensor => sensor.name === 'laser')")
    window.until(f"stage.trueSensors[{laser}]?.mounts[0][2] > 0.17")
    assert window.see(f"robot.sensors[{laser}].mounts[0][2]") == 0.0  # from which the readings are drawn
    window.page.click("text=as in file")
    window.until(f"stage.trueSensors[{laser}].mounts[0][2] === 0")


@pytest.mark.long
def test_forms_say_what_is_wrong_and_go_back_to_the_scenario(window: Window) -> None:
    field = window.field(LEFT_WHEEL)
    number = field.locator("input[type=text]")
    number.fill("-3")
    number.press("Enter")
    window.page.wait_for_function(
        "path => document.querySelector(`[data-path='${path}'] .error`).textContent !== ''", arg=LEFT_WHEEL
    )
    expect(field.locator(".error")).to_contain_text(">= 0.0001")
    expect(number).to_have_attribute("aria-invalid", "true")
    number.fill("1.05")
    number.press("Enter")
    window.until(f"form.fields.get('{LEFT_WHEEL}').parameter.value === 1.05")
    expect(field.locator(".help")).to_contain_text("true 0.086625, believed 0.0825")
    field.get_by_label("as in the scenario").click()
    window.until(f"form.fields.get('{LEFT_WHEEL}').parameter.value === 1")
    expect(number).to_have_value("1")
    expect(field.locator(".error")).to_have_text("")
    number.fill("-3")
    number.press("Enter")
    window.page.wait_for_selector(f"[data-path='{LEFT_WHEEL}'] .error:not(:empty)")
    window.page.click("text=as in file")
    window.page.wait_for_selector(f"[data-path='{LEFT_WHEEL}'] .error:empty", state="attached")
    expect(number).to_have_value("1")


def test_the_time_line_is_long_enough_to_point_at_a_moment(window: Window) -> None:
    page = window.page
    page.set_viewport_size({"width": 1280, "height": 720})
    assert page.locator(".timeline").bounding_box()["width"] > 280
    page.set_viewport_size({"width": 1366, "height": 768})


@pytest.mark.long
def test_a_dialog_keeps_the_keyboard_after_a_problem_and_escape_closes_it(window: Window) -> None:
    page = window.page
    window.save("save as…")
    page.fill("dialog input", "nowhere/room.toml")
    page.click("dialog .main")
    page.wait_for_selector("dialog .error:not(:empty)")
    page.wait_for_function("document.activeElement.id === 'asked-name'")  # to be corrected
    page.focus("dialog button")
    page.keyboard.press("t")
    expect(page.locator("dialog")).to_have_count(1)
    assert window.see("stage.options.trails") is True, "keys of the window work behind a dialog"
    page.keyboard.press("Escape")
    page.wait_for_selector("dialog", state="detached")


@pytest.mark.long
def test_parameters_are_saved_as_a_scenario(window: Window, project: Path) -> None:
    number = window.field(LEFT_WHEEL).locator("input[type=text]")
    number.fill("1.07")
    number.press("Enter")
    window.until(f"form.fields.get('{LEFT_WHEEL}').parameter.value === 1.07")
    window.save("save as…")
    window.page.fill("#asked-name", "../outside.toml")
    window.page.keyboard.press("Enter")
    window.page.wait_for_selector("dialog .error:not(:empty)")
    assert not (project.parent / "outside.toml").exists()
    window.page.fill("#asked-name", "bent.toml")
    window.page.keyboard.press("Enter")
    window.page.wait_for_selector("dialog", state="detached")
    assert "1.07" in (project / "bent.toml").read_text()
    window.page.click("text=as in file")
    window.until(f"form.fields.get('{LEFT_WHEEL}').parameter.value === 1")


# ---------------------------------------------------------------------------------------------------------------- time


@pytest.mark.long
def test_pause_step_scrub_and_continue(window: Window) -> None:
    page = window.page
    page.keyboard.press(" ")
    window.until("newest.tick >= 5")
    page.keyboard.press(" ")
    window.until("!(newest.states & 1)")
    tick = window.see("newest.tick")
    page.keyboard.press(".")
    window.until(f"newest.tick === {tick + 1}")
    page.wait_for_timeout(300)
    assert window.see("newest.tick") == tick + 1  # paused is paused
    expect(page.locator("#continue")).to_be_hidden()
    page.locator("#timeline").fill("2")
    window.until("newest.tick === 2 && (newest.states & 4)")
    assert window.see("newest.newest") == tick + 1
    page.click("#continue")
    window.until("newest.newest === 2 && !(newest.states & 4)")
    page.keyboard.press(".")
    window.until("newest.tick === 3")


@pytest.mark.long
def test_reset_and_speed(window: Window) -> None:
    page = window.page
    page.locator("#speed").fill("7")
    window.until("newest.speed === 10")
    page.keyboard.press("Tab")
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press(" ")
    window.until("newest.tick > 40")
    expect(page.locator(".achieved")).to_contain_text("reached")
    page.locator("#speed").fill("11")
    window.until("newest.speed === Infinity")
    page.click("#reset")
    window.until("newest.tick === 0 && !(newest.states & 1)")


ALL = """
Object.fromEntries([...record.series].map(([key, { times, values }]) => [key, times.map((time, n) =>
    [Math.round(time * 10), ...values.map((column) => (Number.isFinite(column[n]) ? column[n] : null))])]))
"""


@pytest.mark.long
def test_plots_have_their_past_after_a_reload(window: Window) -> None:
    window.page.keyboard.press("m")
    window.until("driving.isByHand")
    window.do(do="drive", robot="rover", forward=0.4, turn=0.5)
    for tick in range(1, 25):
        window.do(do="step")
        window.until(f"newest.tick === {tick}")
    before = plotted(window)
    assert {"turn", "apart", "sensor.laser", "joint.left_wheel"} <= before.keys()
    window.page.reload()
    window.until("newest?.tick === 24 && record.series.get('turn')?.times.length > 20")
    after = plotted(window)
    assert after.keys() == before.keys()
    for key, samples in before.items():
        again = {sample[0]: sample[1:] for sample in after[key]}
        assert len(again) == 25, key
        for tick, *values in samples:
            for one, other in zip(values, again[tick], strict=True):
                assert (one is None) == (other is None), (key, tick, values, again[tick])
                assert one is None or abs(one - other) < 1e-4 * max(1.0, abs(one)), (key, tick)


def plotted(window: Window) -> dict[str, Any]:
    found: dict[str, Any] = window.page.evaluate(
        f"() => {{ with (document.querySelector('.amorsim').simulator) return {ALL.strip()}; }}"
    )
    return found


# ---------------------------------------------------------------------------------------------------- events and things


@pytest.mark.long
def test_an_event_leads_to_its_moment_and_place(window: Window) -> None:
    window.page.keyboard.press("m")
    window.until("driving.isByHand")
    window.do(do="drive", robot="rover", forward=-1.5)
    window.do(do="step", steps=30)
    event = window.page.locator(".events-list button", has_text="wall").first
    event.click()
    window.until("newest.states & 4")
    assert window.see("newest.tick") < 30
    x, y = window.see("stage.camera.x"), window.see("stage.camera.y")
    assert x == pytest.approx(0.0, abs=0.1)  # the left wall
    assert y == pytest.approx(4.0, abs=0.5)
    assert window.see("stage.mark.point") == pytest.approx([x, y])


@pytest.mark.long
def test_a_click_says_what_a_robot_or_a_beam_is_and_reads(window: Window) -> None:
    page = window.page
    box = page.locator("#pane-robot").bounding_box()
    left, top = page.evaluate(f"{SIMULATOR}.stage.camera.toScreen(2.0, 4.0)")
    page.mouse.click(box["x"] + left, box["y"] + top)
    expect(page.locator(".card")).to_contain_text("rover")
    # The beam at 45 degrees begins at (2.017, 4.008), and meets the wall at y = 8 after 5.646 m.
    left, top = page.evaluate(f"{SIMULATOR}.stage.camera.toScreen(6.009, 7.99)")
    page.mouse.click(box["x"] + left, box["y"] + top)
    said = page.locator(".card").inner_text()
    assert "laser, beam" in said
    assert re.search(r"looks 4[4-6]\.\d° from ahead", said)
    assert re.search(r"true 5\.[67]\d\d\d m, measured 5\.[67]\d", said)
    left, top = page.evaluate(f"{SIMULATOR}.stage.camera.toScreen(2.0, 6.5)")
    page.mouse.click(box["x"] + left, box["y"] + top)
    window.until("robot.name === 'second'")
    expect(page.locator("#numbers-title")).to_have_text("second")
    window.do(do="select", robot="rover")


@pytest.mark.long
def test_picture_and_gif_of_the_view(window: Window, tmp_path: Path) -> None:
    from PIL import Image

    page = window.page
    with page.expect_download() as saved:
        window.save("picture")
    saved.value.save_as(tmp_path / "view.png")
    with Image.open(tmp_path / "view.png") as picture:
        assert picture.width > 900
        assert len(picture.convert("RGB").getcolors(100_000)) > 20
    window.save("GIF")
    page.keyboard.press("m")
    window.do(do="drive", robot="rover", forward=0.5)
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press(" ")
    window.until("saving.film.frames.length >= 4")
    with page.expect_download() as saved:
        page.click("text=stop GIF")
    saved.value.save_as(tmp_path / "view.gif")
    with Image.open(tmp_path / "view.gif") as film:
        assert film.n_frames >= 2


@pytest.mark.long
def test_a_video_of_the_view(window: Window, tmp_path: Path) -> None:
    """The browser itself makes it; it plays it too, from its beginning to its end."""
    page = window.page
    window.do(do="run")
    window.save("video")
    assert page.is_disabled("button:text-is('GIF')")
    window.until("saving.film.frames.length >= 2")  # a second each
    with page.expect_download() as saved:
        page.click("button:text-is('stop video')")
    assert saved.value.suggested_filename.endswith(".mp4")
    saved.value.save_as(tmp_path / "view.mp4")
    made = (tmp_path / "view.mp4").read_bytes()
    assert made[4:8] == b"ftyp"
    player = page.context.new_page()
    seconds, width, height = player.evaluate(
        """async (data) => {
            const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
            const kind = "video/mp4";
            const video = document.createElement("video");
            const shown = new Promise((done, fail) => {
                video.addEventListener("loadedmetadata", done);
                video.addEventListener("error", () => fail(video.error.message));
            });
            video.src = URL.createObjectURL(new Blob([bytes], { type: kind }));
            await shown;
            video.currentTime = 1e6;
            await new Promise((done) => video.addEventListener("seeked", done));
            return [video.currentTime, video.videoWidth, video.videoHeight];
        }""",
        base64.b64encode(made).decode(),
    )
    player.close()
    assert seconds > 1.0
    assert width > 900
    assert width % 2 == height % 2 == 0
    assert not page.is_disabled("button:text-is('GIF')")


# ------------------------------------------------------------------------------------------------------ several windows


@pytest.mark.long
def test_a_second_window_watches_and_may_ask_for_the_controls(
    window: Window, served: Server, open_window: Callable[[Server], Window]
) -> None:
    watcher = open_window(served)
    window.page.keyboard.press(" ")
    watcher.until("newest.tick >= 3")
    refused = watcher.ask(do="pause")
    assert not refused["ok"]
    assert "controls" in refused["error"]
    watcher.until("isMine === false")
    # It looks at what it likes, and the other window goes on with its own robot.
    watcher.page.locator("select.robots").select_option("1")
    watcher.until("robot.name === 'second' && newest.selected === 1 && newest.sensors.length > 3")
    expect(watcher.page.locator("#numbers-title")).to_have_text("second")
    tick = window.see("newest.tick")
    window.until(f"newest.tick > {tick} && newest.selected === 0 && robot.name === 'rover'")
    expect(watcher.page.locator("#run")).to_be_disabled()
    chip = watcher.page.locator(".controls")
    expect(chip).to_contain_text("ask for the controls")
    chip.click()
    window.page.wait_for_selector(".controls:visible")
    window.page.click(".controls")
    watcher.until("isMine")
    watcher.do(do="pause")
    expect(watcher.page.locator("#run")).to_be_enabled()
    window.until("isMine === false")
    assert not window.ask(do="run")["ok"]


@pytest.mark.long
def test_a_window_that_is_loaded_again_keeps_the_controls(
    window: Window, served: Server, open_window: Callable[[Server], Window]
) -> None:
    watcher = open_window(served)
    watcher.until("isMine === false")
    window.page.reload()
    late = open_window(served)
    window.until("isMine")
    for other in (watcher, late):
        other.until(f"state.holder === '{window.see('window')}' && isMine === false")
        expect(other.page.locator(".controls")).to_contain_text("ask for the controls")
    # Once given away, this is shown.
    late.page.click(".controls")
    window.page.wait_for_selector(".controls:visible")
    window.page.click(".controls")
    late.page.wait_for_selector(".hint:text('You have the controls now.')")
    window.page.wait_for_selector(".hint:text('Another window has the controls now.')")


class Elsewhere(http.server.BaseHTTPRequestHandler):
    """A page of another origin, on this very machine."""

    def do_GET(self) -> None:
        self.send_response(200)
        self.send_header("content-type", "text/html")
        self.end_headers()
        self.wfile.write(b"<!doctype html><title>elsewhere</title>")

    def log_message(self, *_: Any) -> None:
        pass


def test_a_page_of_another_origin_is_refused(window: Window, served: Server) -> None:
    other = http.server.HTTPServer(("127.0.0.1", 0), Elsewhere)
    threading.Thread(target=other.serve_forever, daemon=True).start()
    host = served.address.split("/")[2]
    try:
        page = window.page.context.new_page()  # the same user, so the cookie would be sent
        page.goto(f"http://127.0.0.1:{other.server_port}/")
        opened = page.evaluate(
            """host => Promise.all(["/amorsim/socket/run/room"].map(path =>
                new Promise(done => {
                    const socket = new WebSocket(`ws://${host}${path}`);
                    socket.onopen = () => done("open");
                    socket.onerror = () => done("refused");
                })))""",
            host,
        )
        assert opened == ["refused"]
        statuses: list[int] = []
        page.on("response", lambda response: statuses.append(response.status))
        for path in ("/", "/run/room", "/amorsim/web/simulator/simulator.js"):
            read = page.evaluate(
                "url => fetch(url, {credentials: 'include'}).then(r => r.text(), () => 'refused')",
                f"http://{host}{path}",
            )
            assert read == "refused"
        framed = page.evaluate(
            """url => new Promise(done => {
                const frame = document.createElement("iframe");
                frame.onload = () => {
                    try { done(frame.contentDocument?.title ?? "closed") } catch { done("closed") }
                };
                frame.src = url;
                document.body.append(frame);
            })""",
            f"http://{host}/",
        )
        assert framed == "closed"
        assert 200 not in statuses
    finally:
        other.shutdown()
        other.server_close()


def test_no_text_becomes_a_script_or_a_style(window: Window) -> None:
    said = window.page.evaluate(
        """async () => {
            const [broken, script] = [[], document.createElement("script")];
            document.addEventListener("securitypolicyviolation", (event) => broken.push(event.effectiveDirective));
            script.textContent = "window.wasRun = true";
            document.body.append(script);
            const element = document.createElement("p");
            element.setAttribute("style", "color: red");
            element.setAttribute("onclick", "window.wasRun = true");
            document.body.append(element);
            element.click();
            await new Promise((done) => setTimeout(done, 100));
            return [window.wasRun ?? false, element.style.color, broken.sort()];
        }"""
    )
    window.problems.clear()  # which were meant
    assert said == [False, "", ["script-src-attr", "script-src-elem", "style-src-attr"]]


# ------------------------------------------------------------------------------------------------------ usable by all


@pytest.mark.long
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing(window: Window, theme: str) -> None:
    page = window.page
    if page.evaluate("document.documentElement.dataset.theme") != theme:
        page.keyboard.press("l")

    page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
    window.do(do="step", steps=4)
    window.do(do="scrub", tick=2)
    page.wait_for_selector("#continue:visible")
    assert axe_violations(page) == []
    page.keyboard.press("?")
    page.wait_for_selector("dialog")
    assert axe_violations(page) == []


@pytest.mark.long
@pytest.mark.parametrize("size", [(1280, 720), (3840, 2160), (390, 844)])
def test_a_class_sees_two_panes_and_a_plot_large(window: Window, size: tuple[int, int]) -> None:
    page, before = window.page, window.page.viewport_size
    page.set_viewport_size({"width": size[0], "height": size[1]})
    thin = window.see("stage.robot.ratio")
    page.keyboard.press("c")
    window.until("isLecture")
    assert window.see("stage.robot.ratio") == pytest.approx(1.8 * thin)
    for name in ("robot", "control", "plot"):
        box = page.locator(f".panel.{name}").bounding_box()
        assert box["x"] >= 0.0
        assert box["x"] + box["width"] <= size[0]
        assert box["y"] + box["height"] <= size[1]
    for name in ("errors", "numbers", "events"):
        expect(page.locator(f".panel.{name}")).to_be_hidden()
    sizes = page.evaluate(
        "[...document.querySelectorAll('.head h2, .bar .now')].map(one => getComputedStyle(one).fontSize)"
    )
    assert {float(each.removesuffix("px")) >= 20.0 for each in sizes} == {True}
    # A click still finds what is drawn under it.
    box = page.locator("#pane-robot").bounding_box()
    left, top = window.see("stage.camera.toScreen(2.0, 4.0)")
    page.mouse.click(box["x"] + 1.8 * left, box["y"] + 1.8 * top)
    expect(page.locator(".card")).to_contain_text("rover")
    assert axe_violations(page) == []
    page.keyboard.press("c")
    expect(page.locator(".panel.numbers")).to_be_visible()
    assert window.see("stage.robot.ratio") == thin
    page.set_viewport_size(before)


@pytest.mark.long
def test_an_address_may_open_it_large(window: Window) -> None:
    address = window.page.url
    window.page.goto("about:blank")
    window.page.goto(f"{address}#lecture")
    window.until("isLecture")


@pytest.mark.long
def test_all_is_in_sight_at_1366_by_768(window: Window) -> None:
    for scene in ("plain", "past"):
        outside = window.page.evaluate(
            """() => [...document.querySelectorAll(".bar *, .past *, .head *, .driving > *, .panel")].filter(one => {
                const box = one.getBoundingClientRect();
                return box.width && (box.left < 0 || box.right > innerWidth + 1 || box.bottom > innerHeight + 1);
            }).map(one => one.outerHTML.slice(0, 80))"""
        )
        assert outside == [], scene
        for canvas in ("#pane-robot", "#pane-control"):
            box = window.page.locator(canvas).bounding_box()
            assert box["width"] > 400
            assert box["height"] > 300
        window.do(do="step", steps=2)
        window.do(do="scrub", tick=1)
        window.page.wait_for_selector("#continue:visible")


@pytest.mark.long
def test_the_first_hint_covers_no_words_and_no_plot_and_goes_when_it_is_followed(window: Window) -> None:
    page = window.page
    page.reload()
    # In one look, for it goes by itself too.
    found = page.wait_for_function(
        """() => {
            const hint = document.querySelector(".hint");
            if (!hint?.textContent.includes("Space")) return null;
            const box = hint.getBoundingClientRect();
            const others = [".panel.plot", ".bar", ".panel .head", ".pane .note", ".pane .coordinates", ".pane .lack"];
            const covered = [...document.querySelectorAll(others.join())].filter((one) => {
                const { left, top, right, bottom } = one.getBoundingClientRect();
                return right > left && left < box.right && right > box.left && top < box.bottom && bottom > box.top;
            });
            return { height: box.height, covered: covered.map((one) => one.className) };
        }"""
    ).json_value()
    assert found["height"] > 0
    assert found["covered"] == []
    page.keyboard.press(" ")
    page.wait_for_selector(".hint:empty", state="attached")


@pytest.mark.long
def test_the_keyboard_alone_reaches_everything(window: Window) -> None:
    page = window.page
    wanted = page.evaluate(
        """() => [...document.querySelectorAll("button, input, select, summary, canvas[tabindex]")]
            .filter(one => one.checkVisibility({visibilityProperty: true}) && !one.disabled).length"""
    )
    seen = set()
    for _ in range(wanted + 30):
        page.keyboard.press("Tab")
        seen.add(page.evaluate("(document.activeElement.dataset.nth ??= String(Math.random()))"))
    missed = page.evaluate(
        """() => [...document.querySelectorAll("button, input, select, summary, canvas[tabindex]")]
            .filter(one => one.checkVisibility({visibilityProperty: true}) && !one.disabled && !one.dataset.nth)
            .map(one => one.outerHTML.slice(0, 80))"""
    )
    assert missed == []
    page.locator("#pane-robot").focus()
    before = window.see("stage.camera.x")
    page.keyboard.press("Shift+ArrowRight")
    page.keyboard.press("+")
    assert window.see("stage.camera.x") > before
    page.keyboard.press("f")
    page.keyboard.press("Enter")
    expect(page.locator(".card")).to_contain_text("rover")
    page.keyboard.press("Escape")
    expect(page.locator(".card")).to_be_hidden()


# ------------------------------------------------------------------------------------------------ controllers that fail


CRASH = """
import amorsim as am


def drive(readings, estimate, clock):
    if clock.time > 0.55:
        raise ZeroDivisionError("the lidar was taken for a map")
    return am.Twist(0.3, 0.0)
"""


@pytest.mark.long
def test_a_crash_of_a_controller_is_shown_with_its_stack_and_the_window_lives_on(
    browser: Any, tmp_path: Path, open_window: Callable[[Server], Window]
) -> None:
    (tmp_path / "driver.py").write_text(CRASH)
    server = Server(write_scenario(tmp_path, "driver.py:drive"))
    try:
        window = open_window(server)
        window.page.keyboard.press(" ")
        # On a busy machine another may come before: that kernels are being compiled.
        window.page.wait_for_selector(".banner.fault:visible")
        expect(window.page.locator(".banner.fault")).to_contain_text("ZeroDivisionError")
        window.page.click("text=show the stack")
        stack = window.page.locator("dialog pre").inner_text()
        assert "driver.py" in stack
        assert "the lidar was taken for a map" in stack
        window.page.keyboard.press("Escape")
        window.page.locator(".banner button.main").click()
        window.until("newest.flags[0] & 4")
        window.page.wait_for_selector(".banner", state="hidden")
        window.do(do="drive", robot="rover", forward=0.5)
        tick = window.see("newest.tick")
        window.do(do="step", steps=3)
        window.until(f"newest.tick > {tick}")
    finally:
        server.close()


HELD = """
import threading
import amorsim as am


class Held:
    def __init__(self):
        self.lock = threading.Lock()  # which nothing can copy

    def command(self, readings, estimate, clock):
        return am.Twist(0.3, 0.0)
"""


@pytest.mark.long
def test_where_a_controller_cannot_be_copied_the_window_says_why_one_cannot_go_on(
    browser: Any, tmp_path: Path, open_window: Callable[[Server], Window]
) -> None:
    (tmp_path / "driver.py").write_text(HELD)
    server = Server(write_scenario(tmp_path, "driver.py:Held"))
    try:
        window = open_window(server)
        window.do(do="step", steps=8)
        window.do(do="scrub", tick=3)
        window.page.wait_for_selector(".past:visible >> text=cannot go on")
        expect(window.page.locator(".past")).to_contain_text("rover")
        expect(window.page.locator("#continue")).to_be_disabled()
        poses = window.see("newest.truePoses.slice(0, 3)")
        assert poses[0] > 2.0  # where it was then is known all the same
    finally:
        server.close()


# ------------------------------------------------------------------------------------------------------------ what-if


@pytest.mark.long
def test_the_past_shows_the_values_of_its_moment_and_takes_no_others(window: Window) -> None:
    page = window.page
    window.do(do="step", steps=5)
    window.do(do="set", robot="rover", path=LEFT_WHEEL, value=1.005)
    window.do(do="step", steps=5)
    field = window.field(LEFT_WHEEL).locator("input[type=text]")
    expect(field).to_have_value("1.005")
    window.do(do="scrub", tick=2)
    expect(page.locator(".form-note")).to_have_text("The values at 0.2 s. To change them, continue here.")
    expect(field).to_have_value("1")
    assert page.evaluate("document.querySelector('.form').inert")
    window.do(do="scrub", tick=None)
    expect(page.locator(".form-note")).to_be_hidden()
    expect(field).to_have_value("1.005")
    field.fill("abc")
    field.press("Enter")
    expect(window.field(LEFT_WHEEL).locator(".error")).to_have_text("Expected a number.")
    expect(window.field(LEFT_WHEEL).locator(".help")).to_be_hidden()  # it would lie over the error
    window.do(do="scrub", tick=7)
    expect(field).to_have_value("1.005")
    expect(window.field(LEFT_WHEEL).locator(".error")).to_be_empty()


@pytest.mark.long
def test_the_overlay_keeps_the_switches_of_sensors(window: Window) -> None:
    switch = window.page.get_by_role("button", name="sonar", exact=True)
    expect(switch).to_be_visible()
    window.page.keyboard.press("o")
    expect(switch).to_be_visible()
    switch.click()
    assert window.see("stage.hidden.has('sonar')")
    window.page.keyboard.press("o")
    expect(window.page.locator(".panel.control").get_by_role("button", name="sonar", exact=True)).to_be_visible()
    switch.click()


@pytest.mark.long
def test_a_server_that_is_gone_is_told_with_what_to_do(browser: Any, tmp_path: Path) -> None:
    server = Server(write_scenario(tmp_path))
    page = new_user(browser).new_page()
    window = Window(page).open(server.address)
    server.close()
    expect(page.locator(".banner")).to_contain_text("trying again")
    expect(page.locator(".banner")).to_contain_text("give its command again in the terminal")
    assert window.problems == []
    page.context.close()
