"""The Editor's commands about the project: worlds and models as files, programs, other scenarios, what was changed."""

from __future__ import annotations

import base64
import io
import json
import os
import signal
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import amorsim as am
from amorsim.ui.editor.session import EditSession
from amorsim.ui.editor.work import Work
from tests.ui.editor.talking import do, drawn, own_copy, talk


def thing_of(seen: dict[str, Any], path: str) -> dict[str, Any]:
    (found,) = [thing for thing in seen["things"] if thing["path"] == path]
    return dict(found)


def test_points_in_the_world_are_shown_moved_added_and_undone(tmp_path: Path) -> None:
    text = """format = 1
[world]
map = { generate = "office", seed = 3 }
[[robots]]
name = "one"
model = "pioneer2dx"
pose = { x = 1.0, y = 1.0 }
controller = { use = "pursuit", waypoints = [[1.0, 1.0], [2.0, 1.0]] }
[[robots]]
name = "many"
model = "pioneer2dx"
count = 3
start = { random = [0.0, 0.0, 4.0, 3.0] }
[[obstacles]]
name = "cart"
shape = { circle = 0.2 }
motion = { use = "loop", waypoints = [[1, 1], [2, 1], [2, 2]] } # round and round
"""
    file = tmp_path / "mine.toml"
    file.write_text(text)

    async def say(session: EditSession) -> None:
        seen = await drawn(session)
        places = {place["path"]: place for thing in seen["things"] for place in thing["places"]}
        assert places["robots.0.controller.waypoints"]["points"] == [[1.0, 1.0], [2.0, 1.0]]
        assert not places["robots.0.controller.waypoints"]["closed"]
        assert places["obstacles.0.motion.waypoints"]["closed"]
        assert places["robots.1.start.random"]["points"] == [[0.0, 0.0], [4.0, 3.0]]
        way = "obstacles.0.motion.waypoints"
        for change in (
            {"op": "point", "path": way, "number": 1, "value": [2.5, 1.0]},
            {"op": "point", "path": way, "number": 3, "value": [1.0, 2.0], "insert": True},
            {"op": "point", "path": "robots.1.start.random", "number": 0, "value": [5.0, 1.0]},
        ):
            await do(session, do="edit", label="move", changes=[change])
        assert session.work.document.get(way) == [[1, 1], [2.5, 1.0], [2, 2], [1.0, 2.0]]
        assert session.work.document.get("robots.1.start.random") == [4.0, 1.0, 5.0, 3.0]
        assert "# round and round" in session.work.text
        refused = await session.request(
            {"do": "edit", "label": "x", "changes": [{"op": "point", "path": way, "number": 9, "value": [0, 0]}]}
        )
        assert "no such point" in refused["error"]
        for _ in range(3):
            await do(session, do="undo")
        assert session.work.text == text

    talk(str(file), tmp_path, say)


def test_a_sensor_is_mounted_elsewhere_and_says_only_what_differs(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        (mount,) = [one for one in thing_of(await drawn(session), "robots.0")["mounts"] if one["sensor"] == "laser"]
        change = {"op": "mount", "path": "robots.0.sensors.laser", "value": [mount["pose"][0], 0.05, None]}
        await do(session, do="edit", label="mount", changes=[change])
        (moved,) = [one for one in thing_of(await drawn(session), "robots.0")["mounts"] if one["sensor"] == "laser"]
        assert moved["pose"] == [mount["pose"][0], 0.05, mount["pose"][2]]
        assert session.work.document.values["robots"][0]["sensors"]["laser"]["mount"] == {"y": 0.05}

    talk("demo", tmp_path, say)


def test_noise_is_reordered_the_model_s_too(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        chain = "robots.0.sensors.laser.noise"
        before = [one["use"] for one in session.work.document.get(chain)]
        for start, index in ((0, 1), (1, 0), (0, 1)):  # the model's at first, then the file's own
            change = {"op": "move", "path": f"{chain}.{start}", "index": index}
            await do(session, do="edit", label="reorder", changes=[change])
        assert [one["use"] for one in session.work.document.get(chain)] == before[::-1]
        assert (await drawn(session))["faults"] == []
        for index in (-1, 2, "x"):
            change = {"op": "move", "path": f"{chain}.0", "index": index}
            assert not (await session.request({"do": "edit", "label": "x", "changes": [change]}))["ok"]

    talk("demo", tmp_path, say)


def test_a_robot_and_a_sensor_are_saved_with_what_differs_alone(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        changes = [
            {"op": "set", "path": "robots.0.drive.track", "value": 0.4},
            {"op": "set", "path": "robots.0.sensors.laser.beams", "value": 91},
        ]
        await do(session, do="edit", label="change", changes=changes)
        said = await do(session, do="save_model", path="robots.0", name="wide")
        assert said["file"] == "wide.toml"
        assert (
            "there already"
            in (await session.request({"do": "save_model", "path": "robots.0", "name": "wide"}))["error"]
        )
        said = await do(session, do="save_model", path="robots.0", sensor="laser", name="eye")
        assert "beams = 91" in said["text"]

    talk("demo", tmp_path, say)
    text = (tmp_path / "wide.toml").read_text()
    assert 'model = "pioneer2dx' in text
    assert "track = 0.4" in text
    assert text.count("[drive]") == 1
    assert "rate_max" not in text
    assert am.load_robot(str(tmp_path / "wide.toml")).drive.track == 0.4
    assert am.load_device(tmp_path / "eye.toml").sensor.beams == 91


def test_what_is_pasted_from_another_folder_names_the_same_files(tmp_path: Path) -> None:
    old, new = tmp_path / "old", tmp_path / "new" / "deep"
    (old / "parts").mkdir(parents=True)
    new.mkdir(parents=True)
    for folder in (old, new):
        (folder / "room.wld").write_text("0 0 5000 0\n5000 0 5000 5000\n5000 5000 0 5000\n0 5000 0 0\n")
    (old / "drive.py").write_text("def drive(readings, estimate, clock):\n    return 0.0\n")
    (old / "base.toml").write_text('format = 1\nmodel = "pioneer2dx"\nsensors.eye = { model = "parts/eye.toml" }\n')
    (old / "parts" / "eye.toml").write_text('format = 1\nuse = "laser"\nbeams = 7\n')
    (old / "mine.toml").write_text('format = 1\nmodel = "base.toml"\n')
    (old / "way.csv").write_text("time,x,y,heading_deg\n0,1,1,0\n5,2,2,0\n")
    (old / "first.toml").write_text(
        'format = 1\nworld.map = "room.wld"\n'
        '[[robots]]\nname = "a"\nmodel = "mine.toml"\npose = { x = 2.0, y = 2.0 }\n'
        'controller = { use = "drive.py:drive" }\nsensors.other = { model = "parts/eye.toml" }\n'
        '[[obstacles]]\nname = "b"\nshape = { circle = 0.2 }\nmotion = { use = "track", file = "way.csv" }\n'
    )
    (new / "second.toml").write_text('format = 1\nworld.map = "room.wld"\n')
    copied: dict[str, Any] = {}

    async def copy(session: EditSession) -> None:
        copied.update(await do(session, do="tables", paths=["robots.0", "obstacles.0"]))

    async def paste(session: EditSession) -> None:
        robot, obstacle = copied["tables"]
        changes = [
            {"op": "add", "path": "robots", "value": robot, "folder": copied["folder"]},
            {"op": "add", "path": "obstacles", "value": obstacle, "folder": copied["folder"]},
        ]
        await do(session, do="edit", label="paste", changes=changes)
        assert session.work.document.faults() == ()
        await do(session, do="save")
        archive = zipfile.ZipFile(io.BytesIO(base64.b64decode((await do(session, do="zip"))["zip"])))
        archive.extractall(tmp_path / "elsewhere")

    async def paste_here(session: EditSession) -> None:
        change = {"op": "add", "path": "robots", "value": copied["tables"][0], "folder": copied["folder"]}
        await do(session, do="edit", label="paste", changes=[change | {"value": change["value"] | {"name": "c"}}])
        assert session.work.document.values["robots"][1]["model"] == "mine.toml"

    talk(str(old / "first.toml"), tmp_path, copy)
    work = talk(str(new / "second.toml"), tmp_path, paste)
    talk(str(old / "first.toml"), tmp_path, paste_here)
    robot = work.document.values["robots"][0]
    assert robot["model"] == "../../old/mine.toml"
    assert robot["sensors"]["other"]["model"] == "../../old/parts/eye.toml"
    assert robot["controller"]["use"] == "../../old/drive.py:drive"
    assert work.document.values["obstacles"][0]["motion"]["file"] == "../../old/way.csv"
    assert am.load(new / "second.toml").robots[0].sensors["eye"].sensor.beams == 7
    old.rename(tmp_path / "gone")
    assert am.load(tmp_path / "elsewhere" / "second" / "second.toml").robots[0].sensors["eye"].sensor.beams == 7


@pytest.mark.long
def test_the_world_is_written_after_it_is_said_what_is_lost(tmp_path: Path) -> None:
    file = own_copy("doors", tmp_path)

    async def say(session: EditSession) -> None:
        tried = await do(session, do="write_world", name="world.png", is_trial=True)
        assert not (tmp_path / "world.png").exists()
        assert any("cells" in words for words in tried["words"])
        assert any("comments of rooms.wld" in words for words in tried["words"])
        assert any("single walls" in words for words in tried["words"])
        said = await do(session, do="write_world", name="world.png", is_trial=False, use=True)
        assert said["file"] == "world.png"
        assert session.work.document.get("world.map") == "world.png"
        assert (await drawn(session))["faults"] == []
        refused = await session.request({"do": "write_world", "name": "world.png", "is_trial": True})
        assert "there already" in refused["error"]
        refused = await session.request({"do": "write_world", "name": "world.dxf", "is_trial": True})
        assert refused["error"] == "world.dxf: cannot be written: maps cannot be written as .dxf"
        writers = (await do(session, do="menu"))["writers"]
        assert {".wld", ".png", ".svg", ".geojson", ".map", ".yaml"} <= set(writers)
        assert not {".dxf", ".maz"} & set(writers)
        await do(session, do="undo")
        assert session.work.text == file.read_text()

    talk(str(file), tmp_path, say)


@pytest.mark.long
def test_a_generated_world_is_made_into_walls_that_can_be_drawn(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        world = {"map": {"generate": "office", "seed": 3}}
        await do(session, do="edit", label="office", changes=[{"op": "set", "path": "world", "value": world}])
        seen = await drawn(session)
        assert thing_of(seen, "world")["note"] == "generated: office"
        assert session.state()["walls_fixed"]
        sections = (await do(session, do="inspect", path="world"))["sections"]
        paths = [field["path"] for section in sections for field in section["fields"]]
        assert "world.map.seed" in paths
        assert any(path.startswith("world.map.") and path != "world.map.seed" for path in paths)
        await do(session, do="write_world", name="office.wld", is_trial=False, use=True)
        assert not session.state()["walls_fixed"]
        await do(session, do="edit", label="wall", changes=[{"op": "walls", "add": [[1, 1, 2, 1]]}])

    talk("", tmp_path, say)


@pytest.mark.long  # starts a process of its own
def test_a_generated_world_becomes_a_file_in_one_step_and_is_written_by_a_save(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        world = {"map": {"generate": "office", "seed": 3}}
        await do(session, do="edit", label="office", changes=[{"op": "set", "path": "world", "value": world}])
        text = session.work.text
        tried = await do(session, do="make_lines", is_trial=True)
        assert any("cells" in words for words in tried["words"])
        assert session.work.text == text
        generated = await drawn(session)
        said = await do(session, do="make_lines", is_trial=False)
        assert said["file"] == session.work.document.get("world.map") == "untitled.wld"
        assert (await drawn(session))["still"]["extent"] == generated["still"]["extent"]
        await do(session, do="edit", label="wall", changes=[{"op": "walls", "add": [[1, 1, 2, 1]]}])
        assert list(tmp_path.iterdir()) == []
        await do(session, do="save_as", name="mine")
        assert len(am.load_map(tmp_path / "mine.wld").segments) > 10
        for _ in range(3):  # the name that its walls were saved under, the wall, the file
            await do(session, do="undo")
        assert session.work.document.get("world.map") == world["map"]
        refused = await session.request({"do": "make_lines", "is_trial": True})
        assert refused["ok"]
        for _ in range(3):
            await do(session, do="redo")
        refused = await session.request({"do": "make_lines", "is_trial": True})
        assert "as it is" in refused["error"]

    talk("", tmp_path, say)


@pytest.mark.long
def test_pictures_and_a_zip_have_what_is_drawn_now(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        await do(session, do="edit", label="wall", changes=[{"op": "walls", "add": [[1.0, 9.0, 2.0, 9.0]]}])
        png = base64.b64decode((await do(session, do="picture", kind="png"))["data"])
        assert png.startswith(b"\x89PNG")
        assert b"<svg" in base64.b64decode((await do(session, do="picture", kind="svg"))["data"])
        packed = base64.b64decode((await do(session, do="zip"))["zip"])
        with zipfile.ZipFile(io.BytesIO(packed)) as archive:
            assert sorted(archive.namelist()) == ["demo/demo.toml", "demo/office.wld"]
            archive.extractall(tmp_path)
        assert session.work.document.path.name == "demo.toml"

    talk("demo", tmp_path, say)
    world = am.load(tmp_path / "demo" / "demo.toml").map
    assert world.segments is not None
    assert world.segments[-1].tolist() == [1.0, 9.0, 2.0, 9.0]


def test_what_differs_from_a_file_that_was_changed_is_reported(tmp_path: Path) -> None:
    file = own_copy("demo", tmp_path)

    async def say(session: EditSession) -> None:
        await do(session, do="edit", label="seed", changes=[{"op": "set", "path": "simulation.seed", "value": 5}])
        file.write_text(file.read_text().replace("duration = 300.0", "duration = 30.0"))
        lines = (await do(session, do="difference"))["text"].splitlines()
        assert "-duration = 30.0" in lines
        assert "+duration = 300.0" in lines
        assert "+seed = 5" in lines

    talk(str(file), tmp_path, say)


def test_what_differs_from_a_bitmap_that_was_changed_is_said_in_numbers(tmp_path: Path) -> None:
    levels = np.full((60, 80), 255, dtype=np.uint8)
    picture, file = tmp_path / "room.png", tmp_path / "mine.toml"
    Image.fromarray(levels).save(picture)
    file.write_text('format = 1\n[world]\nmap = "room.png"\nresolution = 0.1\n')

    async def say(session: EditSession) -> None:
        assert (await do(session, do="difference"))["text"] == ""
        change = {"op": "paint", "spans": [[4, 10, 30], [6, 20, 21]], "occupied": True}
        await do(session, do="edit", label="paint", changes=[change])
        words = ["--- room.png, the file", "+++ room.png, here"]
        pixels = "21 pixels differ, in rows 5 to 7 and columns 11 to 30, from the upper left"
        assert (await do(session, do="difference"))["text"].splitlines() == [*words, pixels]
        Image.fromarray(levels[:50]).save(picture)
        sizes = ["-50 rows, 80 columns", "+60 rows, 80 columns"]
        assert (await do(session, do="difference"))["text"].splitlines() == [*words, *sizes]
        picture.write_bytes(b"no picture")
        (*_, last) = (await do(session, do="difference"))["text"].splitlines()
        assert last.startswith("-room.png: cannot be read")

    talk(str(file), tmp_path, say)


def test_the_files_of_before_are_remembered(tmp_path: Path) -> None:
    state = tmp_path / ".state"
    one, other = own_copy("demo", tmp_path), own_copy("doors", tmp_path)
    said: list[dict[str, Any]] = []

    async def say(session: EditSession) -> None:
        said.append(await do(session, do="others"))

    talk(str(one), tmp_path, say, state=state)
    talk(str(other), tmp_path, say, state=state)
    assert said[-1]["recent"] == [str(other), str(one)]
    assert "doors.toml" in said[-1]["files"]
    assert "demo" in said[-1]["bundled"]
    one.unlink()
    (state / "recent.json").write_text(json.dumps([3, str(one), str(other)]))
    talk(str(other), tmp_path, say, state=state)
    assert said[-1]["recent"] == [str(other)]


def test_only_the_project_the_bundled_and_what_was_open_before_can_be_opened(tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    file = own_copy("demo", elsewhere)
    project = tmp_path / "project"
    project.mkdir()
    opened: list[str] = []

    async def open_other(name: str) -> str:
        opened.append(name)
        return "/edit/x"

    async def say(session: EditSession) -> None:
        session.open_other = open_other
        for name in (str(file), "../elsewhere/demo.toml", "/etc/hosts.toml"):
            assert not (await session.request({"do": "open", "name": name}))["ok"]
        await do(session, do="open", name="")
        await do(session, do="open", name="demo")
        await do(session, do="open", name="mine.toml")

    talk("demo", project, say, state=tmp_path / ".state")
    assert opened == ["", "demo", str(project / "mine.toml")]


def write_controller(session: EditSession, body: str) -> Any:
    text = f"import amorsim as am\n\n\ndef drive(readings, estimate, clock):\n    return am.Twist(0.1, 0.0)\n{body}"
    return do(session, do="save_code", file="mine.py", text=text)


@pytest.mark.long
def test_a_program_is_tried_in_a_process_of_its_own_and_its_fault_has_a_line(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        template = (await do(session, do="code", file="mine.py"))["text"]
        assert "def drive" in template
        assert not (tmp_path / "mine.py").exists()
        await write_controller(session, "")
        change = {"op": "set", "path": "robots.0.controller", "value": {"use": "mine.py:drive"}}
        await do(session, do="edit", label="controller", changes=[change])
        assert (await drawn(session))["faults"] == []
        await write_controller(session, "raise RuntimeError('so not')\n")
        (fault,) = (await drawn(session))["faults"]
        assert "so not" in fault["message"]
        assert "mine.py" in fault["message"]
        assert "line 6" in fault["message"]
        assert fault["at"].startswith("robots.0.controller")
        # What is typed and not saved is not run.
        await do(session, do="write_code", file="mine.py", text=DRIVE + f"open({str(tmp_path / 'ran')!r}, 'w')\n")
        assert (await drawn(session))["faults"] == []
        assert not (tmp_path / "ran").exists()
        # One that never ends does not hold anybody up: the next change is read at once.
        await write_controller(session, "while True:\n    pass\n")
        await do(session, do="edit", label="seed", changes=[{"op": "set", "path": "simulation.seed", "value": 5}])
        await write_controller(session, "")
        assert (await drawn(session))["faults"] == []

    talk("demo", tmp_path, say, may_run_code=True)


def test_no_program_is_taken_or_tried_where_others_can_reach_the_window(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w')\ndef drive(*_):\n    return None\n")

    async def say(session: EditSession) -> None:
        for command in ({"do": "code", "file": "mine.py"}, {"do": "save_code", "file": "mine.py", "text": ""}):
            assert "--allow-code" in (await session.request(command))["error"]
        change = {"op": "set", "path": "robots.0.controller", "value": {"use": str(tmp_path / "mine.py") + ":drive"}}
        await do(session, do="edit", label="controller", changes=[change])
        await drawn(session)

    talk("demo", tmp_path, say)
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("file", ["../mine.py", "/tmp/mine.py", "mine.toml", "", 3])
def test_programs_lie_in_the_project(file: Any, tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        assert not (await session.request({"do": "save_code", "file": file, "text": ""}))["ok"]

    talk("demo", tmp_path, say, may_run_code=True)
    assert list(tmp_path.iterdir()) == []


DRIVE = "import amorsim as am\n\n\ndef drive(readings, estimate, clock):\n    return am.Twist(0.1, 0.0)\n"


def test_a_program_is_part_of_the_steps_and_of_the_journal(tmp_path: Path) -> None:
    state, file = tmp_path / ".state", tmp_path / "mine.py"
    at = "robots.0.controller"

    async def write(session: EditSession) -> None:
        robot = {"name": "r", "model": "pioneer2dx", "pose": {"x": 1.0, "y": 1.0}}
        await do(session, do="edit", label="robot", changes=[{"op": "add", "path": "robots", "value": robot}])
        await do(session, do="write_code", file="mine.py", text=DRIVE, controller=at)
        await do(session, do="write_code", file="mine.py", text=DRIVE + "# more\n")
        await do(session, do="write_code", file="mine.py", text=DRIVE + "# more\n")  # which is not a step
        assert len(session.work.steps.history.done) == 3
        assert session.work.document.get(f"{at}.use") == "mine.py:drive"
        said = await session.request({"do": "write_code", "file": "mine.py", "text": "", "controller": at})
        assert "is there already" in said["error"]
        assert (await do(session, do="undo"))["label"] == "write mine.py"
        assert (await do(session, do="code", file="mine.py"))["text"] == DRIVE

    talk("", tmp_path, write, state=state, may_run_code=True)
    assert not file.exists()

    async def go_on(session: EditSession) -> None:
        """As after the end of the server: nothing was saved."""
        work = session.work
        assert (await do(session, do="redo"))["label"] == "write mine.py"
        assert await do(session, do="code", file="mine.py") == {
            "ok": True,
            "text": DRIVE + "# more\n",
            "is_saved": False,
        }
        for _ in range(2):
            await do(session, do="undo")
        assert work.document.get("robots.0").get("controller") is None
        for _ in range(2):
            await do(session, do="redo")
        assert not work.is_saved
        await do(session, do="save_as", name="room")
        assert work.is_saved
        assert file.read_text() == DRIVE + "# more\n"
        await do(session, do="undo")
        assert not work.is_saved
        await do(session, do="save")
        assert file.read_text() == DRIVE
        file.write_text("# by hand\n")
        assert work.files_changed == [file]

    talk("", tmp_path, go_on, state=state, may_run_code=True)


def test_a_program_that_is_not_saved_is_seen_with_what_it_imports(tmp_path: Path) -> None:
    (tmp_path / "turns.py").write_text("TURN = 0.25\n")
    room = 'format = 1\n[world]\nmap = "room.wld"\n[[robots]]\nname = "r"\nmodel = "pioneer2dx"\n'
    (tmp_path / "room.wld").write_text("0 0 5000 0\n5000 0 5000 5000\n")
    (tmp_path / "room.toml").write_text(room + 'pose = { x = 1.0, y = 1.0 }\ncontroller = { use = "mine.py:drive" }\n')
    (tmp_path / "mine.py").write_text(DRIVE)
    text = DRIVE.replace("import amorsim as am\n", "import amorsim as am\nfrom turns import TURN\n").replace(
        "0.0", "TURN"
    )
    work = Work(str(tmp_path / "room.toml"), tmp_path)
    assert work.view(tmp_path / "unsaved").get("robots.0.controller.use") == "mine.py:drive"
    work.edit("write", lambda work: work.set_program("mine.py", text))
    view = work.view(tmp_path / "unsaved")
    program = Path(view.get("robots.0.controller.use").removesuffix(":drive"))
    assert program.read_text() == text
    assert (program.parent / "turns.py").read_text() == "TURN = 0.25\n"
    view.scenario()  # which loads the program
    assert (tmp_path / "mine.py").read_text() == DRIVE
    # What it imports is edited, too.
    work.edit("write", lambda work: work.set_program("turns.py", "TURN = 0.5\n"))
    program = Path(work.view(tmp_path / "unsaved").get("robots.0.controller.use").removesuffix(":drive"))
    assert (program.parent / "turns.py").read_text() == "TURN = 0.5\n"


def test_a_program_for_a_bundled_scenario_is_saved_with_its_copy(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        await do(session, do="write_code", file="mine.py", text=DRIVE, controller="robots.0.controller")
        assert not (await do(session, do="save_code", file="mine.py", text=DRIVE))["is_saved"]
        assert not (session.work.here / "mine.py").exists()
        await do(session, do="save_as", name="own")
        assert (tmp_path / "mine.py").read_text() == DRIVE
        assert session.work.is_saved
        assert len(session.work.steps.history.done) == 1
        await do(session, do="undo")
        await do(session, do="redo")
        assert session.work.is_saved

    talk("demo", tmp_path, say, may_run_code=True)
    assert am.load(tmp_path / "own.toml").robots[0].name


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="there is no SIGKILL")
def test_a_reading_process_that_is_killed_is_replaced(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        await drawn(session)
        assert session.reader._process is not None
        os.kill(session.reader._process.pid, signal.SIGKILL)
        await do(session, do="edit", label="seed", changes=[{"op": "set", "path": "simulation.seed", "value": 5}])
        assert (await drawn(session))["still"]["scene"]["seed"] == 5

    talk("demo", tmp_path, say)


@pytest.mark.long
def test_errors_and_noise_are_previewed(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        square = await do(session, do="preview", robot="rover")
        assert len(square["estimated"]) == len(square["true"]) == 20
        assert 0.0 < square["mean"] <= square["most"]
        width = max(x for path in square["estimated"] for x, _ in path)
        assert width == pytest.approx(10.0, abs=0.2)
        bars = await do(session, do="histogram", robot="rover", sensor="laser")
        assert sum(bars["counts"]) == bars["of"] > 500
        assert bars["unit"] == "m"
        assert 0.001 < bars["std"] < 0.1

    talk("demo", tmp_path, say)


@pytest.mark.long  # starts a process of its own
def test_starts_at_random_are_drawn_as_a_run_draws_them(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        fleet = {"name": "f", "model": "pioneer2dx", "count": 4, "start": {"random": [1.0, 1.0, 5.0, 5.0]}}
        await do(session, do="edit", label="add", changes=[{"op": "add", "path": "robots", "value": fleet}])
        starts = (await do(session, do="starts"))["starts"]
        simulation = am.Simulation(session.work.document.scenario())
        assert starts == {f"f{n}": list(simulation.robot(f"f{n}").true_pose) for n in range(4)}
        await do(session, do="edit", label="break", changes=[{"op": "set", "path": "robots.0.model", "value": "x"}])
        assert "faults" in (await session.request({"do": "starts"}))["error"]

    talk("demo", tmp_path, say)
