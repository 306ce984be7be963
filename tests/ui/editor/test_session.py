"""The Editor's session, by its commands: what changes, what stays, what can be undone, and what is said."""

from __future__ import annotations

import asyncio
import os
import shutil
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from amorsim.plugins.manager import make_registry
from amorsim.ui.editor.session import EditSession
from amorsim.ui.editor.work import Work
from amorsim.ui.simulator import controls
from tests.ui.aside import aside
from tests.ui.editor.talking import READERS, do, drawn, own_copy, talk

BUNDLED = make_registry(entry_points=()).names("scenario")  # whatever else is installed


@pytest.mark.parametrize("name", BUNDLED)
def test_opening_and_saving_changes_no_byte(name: str, tmp_path: Path) -> None:
    file = own_copy(name, tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}

    async def say(session: EditSession) -> None:
        await do(session, do="save")
        await do(session, do="save", force=True)

    talk(str(file), tmp_path, say)
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


@pytest.mark.parametrize("name", BUNDLED)
def test_changing_one_thing_and_undoing_gives_the_same_bytes(name: str, tmp_path: Path) -> None:
    file = own_copy(name, tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}

    async def say(session: EditSession) -> None:
        await do(session, do="edit", label="seed", changes=[{"op": "set", "path": "simulation.seed", "value": 77}])
        wall: dict[str, Any] = {"op": "walls", "add": [[1.0, 1.0, 1.5, 1.0]]}
        lines = (await drawn(session))["still"]["scene"]["maps"][0]["segments"]
        if lines is None:  # a generated world has no file to draw in
            refused = await session.request({"do": "edit", "label": "walls", "changes": [wall]})
            assert "the world is generated" in refused["error"]
            wall = {"op": "set", "path": "world.map.seed", "value": 77}
        elif len(lines) > 1:
            wall |= {"remove": [0], "change": [[1, [0.5, 0.5, 0.75, 0.5]]]}
        await do(session, do="edit", label="walls", changes=[wall])
        robot = {"op": "set", "path": "robots.0.drive.nothing", "value": 1.0}
        await do(session, do="edit", label="robot", changes=[robot, {"op": "remove", "path": "robots.0"}])
        changed = await do(session, do="save")
        assert Path(changed["file"]).read_bytes() != before[file]
        for step in ("robot", "walls", "seed"):
            assert (await do(session, do="undo"))["label"] == step
        assert (await do(session, do="undo"))["label"] == ""
        await do(session, do="save")

    talk(str(file), tmp_path, say)
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_bundled_scenario_is_edited_as_a_copy(tmp_path: Path) -> None:
    shipped = am.open_document("demo").path.with_name("office.wld").read_bytes()

    async def say(session: EditSession) -> None:
        await do(session, do="edit", label="draw", changes=[{"op": "walls", "add": [[1.0, 9.0, 2.0, 9.0]]}])
        refused = await session.request({"do": "save"})
        assert "no file yet" in refused["error"]
        await do(session, do="save_as", name="demo")
        assert session.state()["is_saved"]
        await do(session, do="undo")
        assert not session.state()["is_saved"]
        await do(session, do="save")

    talk("demo", tmp_path, say)
    assert am.open_document("demo").path.with_name("office.wld").read_bytes() == shipped
    assert (tmp_path / "office.wld").read_bytes() == shipped
    assert (tmp_path / "demo.toml").read_text() == am.open_document("demo").text


def test_an_empty_page_becomes_a_scenario_that_runs(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        seen = await drawn(session)
        assert {fault["path"] for fault in seen["faults"]} == {"world", "robots"}
        walls = [[1, 1, 6, 1], [6, 1, 6, 5], [6, 5, 1, 5], [1, 5, 1, 1]]
        await do(session, do="edit", label="draw", changes=[{"op": "walls", "add": walls}])
        robot = {"name": "robot", "model": "pioneer2dx", "pose": {"x": 3.0, "y": 3.0, "heading_deg": 90.0}}
        said = await do(session, do="edit", label="add", changes=[{"op": "add", "path": "robots", "value": robot}])
        assert said["added"] == ["robots.0"]
        seen = await drawn(session)
        assert seen["faults"] == []
        assert len(seen["still"]["scene"]["maps"][0]["segments"]) == 4
        await do(session, do="save_as", name="mine")

    talk("", tmp_path, say)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.toml", "mine.wld"]
    simulation = am.Simulation(am.load(tmp_path / "mine.toml"))
    simulation.step()
    (robot,) = simulation.scenario.robots
    assert (robot.name, robot.pose.x, robot.pose.y) == ("robot", 3.0, 3.0)


def test_what_is_drawn_and_said_is_that_of_the_present_text(tmp_path: Path) -> None:
    file = own_copy("doors", tmp_path)

    async def say(session: EditSession) -> None:
        seen = await drawn(session)
        count = len(seen["still"]["scene"]["maps"][0]["segments"])
        changes = [
            {"op": "walls", "add": [[1.0, 1.0, 2.0, 1.0]]},
            {"op": "pose", "path": "robots.0", "value": [2.5, 4.5, None]},
            {"op": "set", "path": "robots.1.controller.speeed", "value": 1.0},
        ]
        await do(session, do="edit", label="several", changes=changes)
        seen = await drawn(session)
        assert seen["still"]["scene"]["maps"][0]["segments"][count:] == [[1.0, 1.0, 2.0, 1.0]]
        assert seen["still"]["robots"][0][:2] == [2.5, 4.5]
        (fault,) = seen["faults"]
        assert fault["at"] == "robots.1.controller.speeed"
        assert tuple(fault["component"]) == ("controller", "wander")
        assert fault["said"].startswith("controller") or "speeed" in fault["said"]
        assert str(tmp_path) not in fault["message"]
        things = {thing["name"]: thing for thing in seen["things"]}
        assert things["scout"]["faults"] == 1
        assert things["rover"]["faults"] == 0
        assert len(session.work.steps.history.done) == 1

    talk(str(file), tmp_path, say)
    assert file.read_text() == am.open_document("doors").text


def test_a_step_that_fails_in_the_middle_changes_nothing(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        before = session.work.texts
        changes = [{"op": "set", "path": "simulation.seed", "value": 5}, {"op": "remove", "path": "robots.7"}]
        said = await session.request({"do": "edit", "label": "two", "changes": changes})
        assert not said["ok"]
        assert session.work.texts == before
        assert session.work.steps.history.done == []

    talk("demo", tmp_path, say)


@pytest.mark.long
def test_a_file_that_was_changed_by_hand_is_noticed(tmp_path: Path) -> None:
    file = own_copy("demo", tmp_path)

    async def say(session: EditSession) -> None:
        await do(session, do="edit", label="seed", changes=[{"op": "set", "path": "simulation.seed", "value": 5}])
        file.write_text(file.read_text().replace("duration = 300.0", "duration = 30.0"))
        number = 0
        while True:
            said = await asyncio.wait_for(do(session, do="document", after=number), 30.0)
            number = said["number"]
            if said["changed_outside"]:
                break
        assert said["changed_outside"] == ["demo.toml"]
        refused = await session.request({"do": "save"})
        assert refused["changed"]
        assert "changed by something else" in refused["error"]
        await do(session, do="reload")
        assert session.work.document.get("simulation.duration") == 30.0
        assert session.work.document.get("simulation.seed") == 1
        await do(session, do="undo")
        assert session.work.document.get("simulation.seed") == 5
        await do(session, do="save", force=True)

    talk(str(file), tmp_path, say)
    assert am.open_document(file).get("simulation.duration") == 300.0


@pytest.mark.long
def test_a_folder_that_is_deleted_and_made_again_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "project"
    folder.mkdir()
    own_copy("demo", folder)
    monkeypatch.chdir(folder)
    draw = {"do": "edit", "label": "draw", "changes": [{"op": "walls", "add": [[1.0, 9.0, 2.0, 9.0]]}]}

    async def say(session: EditSession) -> None:
        await do(session, **draw)
        shutil.rmtree(folder)
        await do(session, **draw)
        said = session.state()
        while not said["gone_outside"]:
            said = await asyncio.wait_for(do(session, do="document", after=said["number"]), 30.0)
        assert said["gone_outside"] == said["changed_outside"] == ["demo.toml", "office.wld"]
        refused = await session.request({"do": "save"})
        assert refused["error"].startswith(f"demo.toml: its folder {folder} was deleted by something else")
        folder.mkdir()
        await do(session, do="save")
        assert (folder / "office.wld").read_text() == session.work.texts[str(folder / "office.wld")]
        shutil.rmtree(folder)
        await do(session, do="save", force=True)

    talk("demo.toml", tmp_path, say)
    assert (folder / "demo.toml").read_text() == am.open_document("demo").text
    assert (folder / "office.wld").read_text().count("\n") > 2


def test_a_map_that_comes_back_is_not_replaced_unasked(tmp_path: Path) -> None:
    file = own_copy("demo", tmp_path)
    there = (tmp_path / "office.wld").read_bytes()

    async def say(session: EditSession) -> None:
        (tmp_path / "office.wld").unlink()
        await do(session, do="edit", label="draw", changes=[{"op": "walls", "add": [[1.0, 9.0, 2.0, 9.0]]}])
        (tmp_path / "office.wld").write_bytes(there)
        assert (await session.request({"do": "save"}))["changed"]

    talk(str(file), tmp_path, say)
    assert (tmp_path / "office.wld").read_bytes() == there


@pytest.mark.skipif(os.geteuid() == 0, reason="nothing is refused to root")
def test_a_folder_without_permission_is_said_clearly(tmp_path: Path) -> None:
    file = own_copy("demo", tmp_path)
    file.chmod(0o444)

    async def say(session: EditSession) -> None:
        await do(session, do="edit", label="seed", changes=[{"op": "set", "path": "simulation.seed", "value": 5}])
        said = await session.request({"do": "save"})
        assert "Permission denied" in said["error"]

    talk(str(file), tmp_path, say)


def test_save_as_stays_in_the_folder_and_replaces_nothing_unasked(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        for name in ("../demo", "/tmp/demo", ""):
            assert not (await session.request({"do": "save_as", "name": name}))["ok"]
        await do(session, do="save_as", name="demo")
        said = await session.request({"do": "save_as", "name": "demo"})
        assert "is there already" in said["error"]

    talk("demo", tmp_path, say)


def test_the_model_s_sensors_and_noise_can_be_changed_added_to_and_left_out(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        edits: list[dict[str, Any]] = [
            {"op": "set", "path": "robots.0.sensors.gps", "value": {"use": "gps"}},
            {"op": "add", "path": "robots.0.sensors.laser.noise", "value": {"use": "bias", "value": 0.1}},
            {"op": "remove", "path": "robots.0.sensors.sonar"},
            {"op": "set", "path": "robots.0.sensors.laser.beams", "value": 90},
        ]
        for edit in edits:
            await do(session, do="edit", label="robot", changes=[edit])
        noise = session.work.document.get("robots.0.sensors.laser.noise")
        assert [one["use"] for one in noise] == ["gaussian", "quantize", "bias"]
        seen = await drawn(session)
        assert [fault["path"] for fault in seen["faults"] if "gps" not in fault["path"]] == []
        assert "sonar" not in {one["name"] for one in seen["still"]["scene"]["kinds"][0]["sensors"]}
        sections = (await do(session, do="inspect", path="robots.0"))["sections"]
        titles = [section["title"] for section in sections]
        assert "gps" in titles
        assert "sonar" not in titles
        fields = {field["path"]: field for section in sections for field in section["fields"]}
        assert fields["robots.0.sensors.laser.beams"]["value"] == 90
        assert fields["robots.0.sensors.laser.beams"]["is_given"]
        assert fields["robots.0.sensors.laser.range_max"]["origin"] == "model"
        assert not fields["robots.0.sensors.laser.range_max"]["is_given"]
        for _ in edits:
            await do(session, do="undo")
        assert session.work.text == am.open_document("demo").text

    talk("demo", tmp_path, say)


@pytest.mark.parametrize("bundled", BUNDLED)
def test_every_thing_has_an_inspector_whose_forms_can_be_set_as_they_are(bundled: str, tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        text = session.work.text
        for thing in (await drawn(session))["things"]:
            sections = (await do(session, do="inspect", path=thing["path"]))["sections"]
            assert sections
            for section in sections:
                for field in section["fields"]:
                    if field["is_given"] and not isinstance(field["value"], dict):
                        change = {"op": "set", "path": field["path"], "value": field["value"]}
                        await do(session, do="edit", label="same", changes=[change])
                if section["toml"] and session.work.text == text and not section["origin"]:
                    change = {"op": "toml", "path": section["path"], "text": section["toml"]}
                    await do(session, do="edit", label="same", changes=[change])
        assert session.work.text == text

    talk(bundled, tmp_path, say)


def test_errors_have_forms_fixed_or_drawn(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        sections = (await do(session, do="inspect", path="robots.0"))["sections"]
        (errors,) = [section for section in sections if section["path"] == "robots.0.errors"]
        (adding,) = errors["adding"]
        assert "drive.wheel_radius_right" in adding["choices"]
        assert "sensors.laser.mount.heading_deg" in adding["choices"]
        assert "drive.track" not in adding["choices"]  # it has one
        for target in adding["choices"]:
            change = {"op": "set", "path": f"robots.0.errors.{target}", "value": {"scale": 1}}
            await do(session, do="edit", label="error", changes=[change])
        assert (await drawn(session))["faults"] == []
        change = {"op": "set", "path": "robots.0.errors.drive.track.scale", "value": {"normal": [1.0, 0.01]}}
        await do(session, do="edit", label="error", changes=[change])
        assert (await drawn(session))["faults"] == []
        sections = (await do(session, do="inspect", path="robots.0"))["sections"]
        (track,) = [section for section in sections if section["path"] == "robots.0.errors.drive.track"]
        fields = {field["label"]: field for field in track["fields"]}
        assert fields["scale"]["value"] == {"normal": [1.0, 0.01]}
        assert fields["add"]["widget"]["unit"] == "m"
        assert track["can_go"]

    talk("demo", tmp_path, say)


def test_one_window_holds_the_pen_and_another_may_ask_for_it(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        first, second = session.open_window("one"), session.open_window("two")
        edit = {"do": "edit", "label": "x", "changes": [{"op": "set", "path": "simulation.seed", "value": 3}]}
        assert "another window holds the pen" in (await session.ask(second, edit))["error"]
        assert (await session.ask(second, {"do": "inspect", "path": "robots.0"}))["ok"]
        assert (await session.ask(second, {"do": "controls", "want": "ask"}))["ok"]
        assert (await session.ask(first, {"do": "controls", "want": "give"}))["ok"]
        assert (await session.ask(second, edit))["ok"]
        assert not (await session.ask(first, edit))["ok"]

    talk("demo", tmp_path, say)


@pytest.mark.long
def test_the_pen_passes_to_a_window_that_asked_once_its_holder_has_gone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(controls, "GRACE", 0.5)

    async def say(session: EditSession) -> None:
        first, second = session.open_window("one"), session.open_window("two")
        await session.ask(second, {"do": "controls", "want": "ask"})
        session.close_window(first)
        said = session.state()
        assert said["holder"] == ""
        async with asyncio.timeout(10.0):
            while said["holder"] != second:  # told, as a window is: it asks for nothing but news
                said = await do(session, do="document", after=said["number"])

    talk("demo", tmp_path, say)


@pytest.mark.parametrize(
    "command",
    [
        {},
        {"do": "nothing"},
        {"do": "edit"},
        {"do": "edit", "label": "x", "changes": []},
        {"do": "edit", "label": "x", "changes": ["set"]},
        {"do": "edit", "label": "x", "changes": [{"op": "walls", "add": [[0, 0, 1]]}]},
        {"do": "edit", "label": "x", "changes": [{"op": "walls", "remove": [100_000]}]},
        {"do": "edit", "label": "x", "changes": [{"op": "walls", "change": [[0, [0, 0, "a", 1]]]}]},
        {"do": "edit", "label": "x", "changes": [{"op": "pose", "path": "robots.0", "value": [0.0]}]},
        {"do": "edit", "label": "x", "changes": [{"op": "set", "path": "", "value": 1}]},
        {"do": "edit", "label": "x", "changes": [{"op": "set", "path": "robots.9.x", "value": 1}]},
        {"do": "edit", "label": "x", "changes": [{"op": "toml", "path": "robots.0.errors", "text": "a = "}]},
        {"do": "edit", "label": "x", "changes": [{"op": "add", "path": "world", "value": {}}]},
        {"do": "edit", "label": "x", "changes": [{"op": "shape", "path": "robots.0.shape", "value": []}]},
        {"do": "edit", "label": "x", "changes": [{"op": "text", "text": "# \ud800"}]},
        {"do": "inspect", "path": "robots.9"},
        {"do": "inspect", "path": "format"},
        {"do": "tables", "paths": [["robots"]]},
        {"do": "save_as", "name": 3},
        {"do": "document", "after": "x"},
    ],
)
def test_what_makes_no_sense_is_refused_and_changes_nothing(command: dict[str, Any], tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        before = session.work.texts
        said = await session.request(command)
        assert not said["ok"]
        assert said["error"]
        assert {name: text for name, text in session.work.texts.items() if name in before} == before
        assert session.work.steps.history.done == []

    talk("demo", tmp_path, say)


@pytest.mark.parametrize("name", ["demo", "doors", "line"])
def test_a_run_from_the_editor_has_the_digest_of_a_run_of_the_saved_file(name: str, tmp_path: Path) -> None:
    digests: list[str] = []

    def digest(file: Path) -> str:
        simulation = am.Simulation(am.load(file))
        for _ in range(20):
            simulation.step()
        return str(simulation.digest())

    async def run(file: Path) -> str:
        digests.append(await asyncio.to_thread(digest, file))
        return "/run/x"

    work = Work(name, tmp_path)

    async def all_of_it() -> None:
        async with EditSession(work, run=run, reader=READERS[0]) as session:
            changes = [
                {"op": "pose", "path": "robots.0", "value": [*(await where(session)), 30.0]},
                {"op": "walls", "add": [[0.05, 0.05, 0.06, 0.05]]},
            ]
            await do(session, do="edit", label="several", changes=changes)
            await do(session, do="run")
            await do(session, do="save_as", name="mine")

    async def where(session: EditSession) -> list[float]:
        return list((await drawn(session))["still"]["robots"][0][:2])

    aside(all_of_it())
    assert digests == [digest(tmp_path / "mine.toml")]


def test_a_map_stays_as_it_is_and_a_scenario_is_saved_next_to_it(tmp_path: Path) -> None:
    room = tmp_path / "room.wld"
    room.write_text("width 5000\nheight 4000\n0 0 5000 0\nposition 2500 2000 0\n")
    before = room.read_bytes()

    async def say(session: EditSession) -> None:
        assert not (await drawn(session))["faults"]
        assert not session.state()["is_saved"]
        saved = await do(session, do="save")
        assert saved["file"] == str(tmp_path / "room.toml")
        assert (tmp_path / "room.toml").is_file()
        assert session.state()["is_saved"]
        await do(session, do="edit", label="seed", changes=[{"op": "set", "path": "simulation.seed", "value": 77}])
        await do(session, do="save")

    talk(str(room), tmp_path, say)
    assert room.read_bytes() == before
    assert am.load(tmp_path / "room.toml").seed == 77
