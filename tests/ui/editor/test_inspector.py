"""What the inspector offers for settings and zones, set by its forms."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from amorsim.plugins.manager import default_registry
from amorsim.scenario.reading.read import loads
from amorsim.ui.editor.session import EditSession
from tests.ui.editor.talking import do, drawn, talk


async def sections_of(session: EditSession, path: str) -> dict[str, Any]:
    return {one["path"]: one for one in (await do(session, do="inspect", path=path))["sections"]}


async def change(session: EditSession, **what: Any) -> None:
    await do(session, do="edit", label="change", changes=[what])


def test_recorders_have_forms_and_can_be_added(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        text = session.work.text
        assert "recording" not in session.work.document.values
        assert "recording" in [thing["path"] for thing in (await drawn(session))["things"]]
        sections = await sections_of(session, "recording")
        assert [field["path"] for field in sections["recording"]["fields"]] == [
            "recording.sensors",
            "recording.picture",
        ]
        (adding,) = sections["recording.also"]["adding"]
        assert "arrays" in adding["choices"]
        await change(session, op="set", path="recording.sensors", value="all")
        await change(session, op="add", path="recording.also", value={"use": "arrays"})
        assert "recording.also.0" in await sections_of(session, "recording")
        assert (await drawn(session))["faults"] == []
        assert session.work.document.get("recording") == {"sensors": "all", "also": [{"use": "arrays"}]}
        for _ in range(2):
            await do(session, do="undo")
        assert session.work.text == text

    talk("doors", tmp_path, say)


def test_errors_bound_to_a_zone_are_added_and_changed_by_forms(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        zone = {"name": "oil", "shape": {"circle": 0.8}, "pose": {"x": 3.0, "y": 2.0}}
        await change(session, op="add", path="zones", value=zone)
        (adding,) = (await sections_of(session, "zones.0"))["zones.0.ground"]["adding"]
        assert {"scale", "diffusion", "bump"} <= set(adding["choices"])
        assert adding["choices"][1] == "diffusion"  # what is made for the ground comes first
        (others,) = (await sections_of(session, "robots.0"))["robots.0.sensors.laser.noise"]["adding"]
        assert "scale" in others["choices"]
        assert "diffusion" not in others["choices"]
        await change(session, op="add", path="zones.0.ground", value={"use": "scale"})
        await change(session, op="add", path="zones.0.ground", value={"use": "diffusion"})
        fields = (await sections_of(session, "zones.0"))["zones.0.ground.0"]["fields"]
        assert "zones.0.ground.0.factor" in [field["path"] for field in fields]
        await change(session, op="set", path="zones.0.ground.0.factor", value=0.7)
        await change(session, op="set", path="zones.0.ground.1.variance_per_length", value=1e-4)
        await change(session, op="move", path="zones.0.ground.1", index=0)
        assert (await drawn(session))["faults"] == []
        ground = [element.noise for element in session.work.document.scenario().zones[0].ground]
        assert [type(one).__name__ for one in ground] == ["Diffusion", "Scale"]
        assert ground[1].factor == 0.7

    talk("demo", tmp_path, say)


@pytest.mark.parametrize("path", ["robots.0", "zones.0"])
def test_the_sides_of_a_rectangle_are_numbers(path: str, tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        zone = {"name": "oil", "shape": {"circle": 0.8}, "pose": {"x": 3.0, "y": 2.0}}
        await change(session, op="add", path="zones", value=zone)
        await change(session, op="shape", path=f"{path}.shape", value="rectangle")
        shape = (await sections_of(session, path))[f"{path}.shape"]
        assert shape["toml"] is None
        assert [(field["label"], field["value"]) for field in shape["fields"]] == [("length", 0.6), ("width", 0.4)]
        await change(session, op="set", path=shape["fields"][1]["path"], value=0.5)
        assert session.work.document.get(f"{path}.shape") == {"rectangle": [0.6, 0.5]}

    talk("demo", tmp_path, say)


def test_the_list_says_how_many_there_are_and_who_places_them(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        fleet = {
            "name": "f",
            "model": "pioneer2dx",
            "count": 4,
            "start": {"grid": [1.0, 1.0], "spacing": 1.0, "columns": 2},
        }
        await change(session, op="add", path="robots", value=fleet)
        posts = {"name": "p", "shape": {"circle": 0.1}, "count": 3, "start": {"random": "anywhere"}}
        await change(session, op="add", path="obstacles", value=posts)
        notes = {thing["name"]: thing["note"] for thing in (await drawn(session))["things"]}
        assert notes["f"] == "pioneer2dx, 4 of them"
        assert notes["p"] == "stands still, 3 of them, placed by the run"

    talk("demo", tmp_path, say)


def test_kidnappings_are_added_changed_moved_and_taken_out(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        text = session.work.text
        (adding,) = (await sections_of(session, "robots.0"))["robots.0.kidnappings"]["adding"]
        for _ in range(2):
            await change(session, op="add", path=adding["path"], value=adding["value"])
        sections = await sections_of(session, "robots.0")
        labels = [field["label"] for field in sections["robots.0.kidnappings.1"]["fields"]]
        assert labels == ["time", "x", "y", "heading"]
        await change(session, op="set", path="robots.0.kidnappings.1.time", value=5.0)
        places = next(one for one in (await drawn(session))["things"] if one["path"] == "robots.0")["places"]
        assert "robots.0.kidnappings.1" in [place["path"] for place in places]
        await change(session, op="point", path="robots.0.kidnappings.1", number=0, value=[4.0, 3.0])
        await change(session, op="remove", path="robots.0.kidnappings.0")
        assert (await drawn(session))["faults"] == []
        (one,) = session.work.document.scenario().robots[0].kidnappings
        assert (one.time, one.x, one.y) == (5.0, 4.0, 3.0)
        for _ in range(5):
            await do(session, do="undo")
        assert session.work.text == text

    talk("demo", tmp_path, say)


def test_the_map_that_a_robot_knows_is_chosen(tmp_path: Path) -> None:
    am.open_document("demo").save(tmp_path / "demo.toml", copy=True)

    async def say(session: EditSession) -> None:
        async def known() -> dict[str, Any]:
            sections: dict[str, Any] = (await sections_of(session, "robots.0"))["robots.0.knowledge"]
            return sections

        async def choose(value: str) -> None:
            await change(session, op="know_map", path="robots.0.knowledge", value=value)

        use = (await known())["use"]
        assert use["value"] == "the world's"
        assert {"office.wld", "generated: maze"} <= set(use["choices"])
        await choose("")
        assert (await known())["use"]["value"] == ""
        assert session.work.document.scenario().robots[0].knowledge.map is None
        await choose("the world's")
        scenario = session.work.document.scenario()
        assert scenario.robots[0].knowledge.map is scenario.map
        await choose("generated: maze")
        fields = [field["path"] for field in (await known())["fields"]]
        assert fields[0] == "robots.0.knowledge.map.seed"
        assert len(fields) > 1
        await change(session, op="set", path=fields[0], value=4)
        assert (await drawn(session))["faults"] == []
        assert session.work.document.scenario().robots[0].knowledge.map is not None
        refused = await session.request(
            {"do": "edit", "label": "x", "changes": [{"op": "know_map", "path": "robots.9.knowledge", "value": ""}]}
        )
        assert "a robot's knowledge" in refused["error"]

    talk(str(tmp_path / "demo.toml"), tmp_path, say)


def test_the_landmarks_that_a_robot_knows_are_chosen_and_moved(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        text = session.work.text
        at = "robots.0.knowledge.landmarks"
        there = [(mark.x, mark.y) for mark in session.work.document.scenario().landmarks]
        section = (await sections_of(session, "robots.0"))[at]
        assert (section["use"]["value"], section["fields"]) == ("the world's", [])
        await change(session, op="know_landmarks", path=at, value="places of its own")
        assert session.work.document.scenario().robots[0].knowledge.landmarks == tuple(there)
        await change(session, op="point", path=f"{at}.1", number=0, value=[1.0, 2.0])
        await change(session, op="know_landmarks", path=at, value="numbered places of its own")
        (field,) = (await sections_of(session, "robots.0"))[at]["fields"]
        assert [one["path"] for one in field["widget"]["fields"]] == ["id", "x", "y"]
        await change(session, op="set", path=f"{at}.0.id", value=7)
        await change(session, op="point", path=f"{at}.0", number=0, value=[3.0, 4.0])
        places = next(one for one in (await drawn(session))["things"] if one["path"] == "robots.0")["places"]
        assert [3.0, 4.0] in [place["points"][0] for place in places]
        knowledge = session.work.document.scenario().robots[0].knowledge
        assert knowledge.landmarks == ((3.0, 4.0), (1.0, 2.0), *there[2:])
        assert knowledge.landmark_ids[0] == 7
        await change(session, op="know_landmarks", path=at, value="")
        assert session.work.document.scenario().robots[0].knowledge.landmarks == ()
        for _ in range(6):
            await do(session, do="undo")
        assert session.work.text == text

    talk("landmarks", tmp_path, say)


def test_lines_areas_and_drops_of_the_floor_have_forms(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        text = session.work.text
        steps = 0
        for adding in (await sections_of(session, "floor"))["floor"]["adding"]:
            await change(session, op="add", path=adding["path"], value=adding["value"])
            steps += 1
        sections = await sections_of(session, "floor")
        assert [one["title"] for one in sections.values()] == [
            "Floor",
            "line 1",
            *("area 2", "Shape of area 2", "Place of area 2"),
            *("drop 1", "Shape of drop 1", "Place of drop 1"),
        ]
        assert [field["label"] for field in sections["floor.markings.0"]["fields"]][:3] == ["points", "closed", "width"]
        assert [field["label"] for field in sections["floor.drops.0"]["fields"]] == ["depth"]
        for what in (
            {"op": "set", "path": "floor.reflectance", "value": 0.6},
            {"op": "set", "path": "floor.markings.0.width", "value": 0.05},
            {"op": "shape", "path": "floor.markings.1.shape", "value": "circle"},
            {"op": "point", "path": "floor.drops.0.pose", "number": 0, "value": [2.0, 3.0]},
            {"op": "remove", "path": "floor.markings.1"},
        ):
            await change(session, **what)
            steps += 1
        seen = await drawn(session)
        assert seen["faults"] == []
        (thing,) = (one for one in seen["things"] if one["path"] == "floor")
        assert [place["path"] for place in thing["places"]] == ["floor.markings.0.points", "floor.drops.0.pose"]
        floor = session.work.document.scenario().floor
        assert (floor.reflectance, floor.markings[0].width, floor.drops[0].pose.y) == (0.6, 0.05, 3.0)
        for _ in range(steps):
            await do(session, do="undo")
        assert session.work.text == text

    talk("demo", tmp_path, say)


def test_the_description_is_set(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        (field,) = (await sections_of(session, "simulation"))["description"]["fields"]
        assert field["value"] is None
        await change(session, op="set", path="description", value="a walk")
        assert session.work.document.get("description") == "a walk"
        assert (await drawn(session))["faults"] == []

    talk("demo", tmp_path, say)


def test_a_task_is_chosen_and_set_by_forms(tmp_path: Path) -> None:
    async def say(session: EditSession) -> None:
        text = session.work.text
        (section,) = (await sections_of(session, "task")).values()
        assert section["use"] == {
            "kind": "task",
            "value": "",
            "choices": sorted(default_registry().names("task")),
            "is_optional": True,
        }
        await change(session, op="set", path="task.use", value="point_goal")
        (section,) = (await sections_of(session, "task")).values()
        assert "task.horizon" in [field["path"] for field in section["fields"]]
        await change(session, op="set", path="task.horizon", value=20.0)
        assert (await drawn(session))["faults"] == []
        (thing,) = [thing for thing in (await drawn(session))["things"] if thing["path"] == "task"]
        assert thing["note"] == "point_goal"
        read = loads(tomllib.loads(session.work.text), session.work.path.parent)
        assert read.task == am.tasks.PointGoal(horizon=20.0)
        await change(session, op="remove", path="task")
        assert session.work.document.values.get("task") is None
        for _ in range(3):
            await do(session, do="undo")
        assert session.work.text == text

    talk("doors", tmp_path, say)
