"""The page of a faulty file without a browser: what its windows show, and when."""

from __future__ import annotations

import asyncio
import base64
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from amorsim.core.errors import AmorsimError, ControllerError, RunError, ScenarioError
from amorsim.ui.faults.mending import Mending
from amorsim.ui.faults.shown_faults import FaultLine, FaultsError, fault_lines, lines_of
from tests.ui.aside import aside

ROOM = "0 0 6000 0\n6000 0 6000 5000\n6000 5000 0 5000\n0 5000 0 0\n"
TEXT = """format = 1
world = { map = "room.wld" }

[[robots]]
name = "rover"
model = "pioneer2dx"
pose = { x = 1.5, y = 2.5 }
controller = { use = "wader" }
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "room.wld").write_text(ROOM)
    file = tmp_path / "some.toml"
    file.write_text(TEXT)
    return file


class Opened:
    """Opens pages at once, or fails once for each error that it has."""

    def __init__(self, *errors: AmorsimError) -> None:
        self.errors = list(errors)

    async def __call__(self) -> str:
        await asyncio.sleep(0.05)  # as a simulation takes its time to start
        if self.errors:
            raise self.errors.pop(0)
        return "/run/some"


Next = Callable[[], Awaitable[dict[str, Any]]]


def watch(
    work: Callable[[Mending, Next], Awaitable[None]], *errors: AmorsimError, changes: tuple[str, ...] = ()
) -> None:
    """Let a page watch ``some.toml``; `work` is given it, and what awaits its next answer."""

    async def run() -> None:
        faults = fault_lines(am.open_document("some.toml").faults()) if Path("some.toml").exists() else []
        mending = Mending("some.toml", faults, changes=changes, open_page=Opened(*errors))
        mending.start()
        number = 0

        async def following() -> dict[str, Any]:
            nonlocal number
            said = await asyncio.wait_for(mending.ask("w", {"do": "document", "after": number}), 60.0)
            number = said["number"]
            return said

        try:
            await work(mending, following)
        finally:
            await mending.close()

    aside(run())


async def drawn(following: Next) -> dict[str, Any]:
    """The first answer that comes after the file was read."""
    said = await following()
    return said if said["still"] is not None else await following()


def places(said: dict[str, Any]) -> list[tuple[int | None, str]]:
    return [(fault["line"], fault["path"]) for fault in said["faults"]]


def test_the_faults_come_first_then_what_can_be_drawn_and_the_simulation_once_they_are_mended(file: Path) -> None:
    async def work(mending: Mending, following: Next) -> None:
        said = await following()
        (fault,) = said["faults"]
        assert (said["status"], said["file"]) == ("reading", "some.toml")
        assert fault["file"] == "some.toml"
        assert (fault["line"], fault["path"], fault["value"]) == (8, "robots.rover.controller.use", "'wader'")
        assert fault["said"] == 'controller = { use = "wader" }'
        assert fault["remedy"] == "Did you mean 'wander'?"
        assert fault["message"].startswith("no controller 'wader'")
        assert said["still"] is None
        said = await following()
        assert (said["status"], said["faults"]) == ("faulty", [fault])
        assert [robot["name"] for robot in said["still"]["scene"]["robots"]] == ["rover"]
        assert said["still"]["robots"] == [[1.5, 2.5, 0.0]]
        file.write_text(TEXT.replace("wader", "wander"))
        said = await following()
        assert (said["status"], said["faults"], said["path"]) == ("starting", [], "")
        said = await following()
        assert (said["status"], said["path"]) == ("open", "/run/some")
        # A window that comes later is led there too.
        assert (await mending.ask("w", {"do": "document", "after": 0}))["path"] == "/run/some"

    watch(work)


WRONG = {
    "empty": ("", "missing; expected format = 1", None),
    "no TOML": (TEXT.replace("world =", "world = ="), "not valid TOML", 2),
    "no map": (TEXT.replace("room.wld", "rom.wld"), "there is no such file", 2),
    "no such component": (TEXT.replace("pioneer2dx", "pioneer9"), "'pioneer9'", 6),
}


@pytest.mark.parametrize("kind", WRONG)
def test_any_fault_that_comes_instead_is_reported_with_its_line(file: Path, kind: str) -> None:
    text, message, line = WRONG[kind]

    async def work(_: Mending, following: Next) -> None:
        await drawn(following)
        file.write_text(text)
        said = await following()
        assert said["status"] == "faulty"
        assert any(message in fault["message"] and fault["line"] == line for fault in said["faults"]), said["faults"]
        assert said["faults"] == fault_lines(am.open_document("some.toml").faults())

    watch(work)


@pytest.mark.long
def test_a_file_that_is_deleted_and_comes_back_is_followed(file: Path) -> None:
    async def work(_: Mending, following: Next) -> None:
        await drawn(following)
        file.unlink()
        said = await following()
        (fault,) = said["faults"]
        assert fault["file"] == "some.toml"
        assert fault["message"].startswith("there is no such file")
        assert said["still"] is None
        assert said["faults"] == [fault]
        file.write_bytes(b"\xff\xfe")
        assert "not a text file in UTF-8" in (await following())["faults"][0]["message"]
        file.write_text(TEXT.replace("wader", "wander"))
        assert (await following())["status"] == "starting"
        assert (await following())["status"] == "open"

    watch(work)


def test_a_map_that_is_put_where_it_was_missed_mends_the_file(file: Path) -> None:
    file.write_text(TEXT.replace("wader", "wander").replace("room.wld", "rooms/new.wld"))

    async def work(_: Mending, following: Next) -> None:
        said = await drawn(following)
        assert places(said) == [(2, "world.map")]
        assert said["still"]["scene"]["map"] is None
        (file.parent / "rooms").mkdir()
        (file.parent / "rooms" / "new.wld").write_text(ROOM)
        assert (await following())["status"] == "starting"
        said = await following()
        assert said["status"] == "open"
        assert said["still"]["scene"]["map"] == 0

    watch(work)


@pytest.mark.long
def test_faults_that_only_a_simulation_finds_are_reported_too(file: Path) -> None:
    found: list[FaultLine] = fault_lines(
        [am.Fault(file="some.toml", path="robots.rover.pose", message="in a wall", line=7)]
    )
    errors = (FaultsError("some.toml:7: in a wall", found), AmorsimError("there is no room on the disk"))

    async def work(_: Mending, following: Next) -> None:
        await drawn(following)
        sound = TEXT.replace("wader", "wander")
        file.write_text(sound)
        assert (await following())["status"] == "starting"
        said = await following()
        assert (said["status"], said["faults"]) == ("faulty", found)
        file.write_text(sound + "\n")
        assert (await following())["status"] == "starting"
        said = await following()
        assert [fault["message"] for fault in said["faults"]] == ["there is no room on the disk"]
        file.write_text(sound)
        assert (await following())["status"] == "starting"
        assert (await following())["status"] == "open"

    watch(work, *errors)


def test_settings_of_the_command_line_count(file: Path) -> None:
    async def work(_: Mending, following: Next) -> None:
        await drawn(following)
        file.write_text(TEXT.replace("1.5", "'left'"))  # and the controller is another one by a setting
        said = await following()
        assert places(said) == [(7, "robots.rover.pose.x")]

    watch(work, changes=("robots.rover.controller.use=wander",))


def test_nothing_of_a_users_runs_while_the_file_is_read(file: Path) -> None:
    Path("own.py").write_text("open('was-run', 'w').close()\ndef go(readings, estimate, clock): ...\n")
    file.write_text(TEXT.replace("wader", "own.py:go").replace("1.5", "'left'"))

    async def work(_: Mending, following: Next) -> None:
        assert places(await drawn(following)) == [(7, "robots.rover.pose.x")]

    watch(work)
    assert not Path("was-run").exists()


def test_pictures_of_maps_are_given_and_other_commands_refused(file: Path) -> None:
    from PIL import Image

    cells = Image.new("L", (40, 40), 255)
    cells.putpixel((3, 3), 0)
    cells.save("cells.png")
    file.write_text(TEXT.replace('"room.wld"', '"cells.png", resolution = 0.1'))

    async def work(mending: Mending, following: Next) -> None:
        said = await drawn(following)
        image = said["still"]["scene"]["maps"][0]["image"]
        answer = await mending.ask("w", {"do": "image", "name": image["name"]})
        assert base64.b64decode(answer["png"]).startswith(b"\x89PNG")
        for command in (
            {"do": "image", "name": "map-9"},
            {"do": "image"},
            {"do": "run"},
            {"do": "document"},
            {"do": "document", "after": -1},
            {"do": "document", "after": "0"},
            {},
        ):
            answer = await mending.ask("w", command)
            assert not answer["ok"]
            assert answer["error"]

    watch(work)


def test_errors_that_a_file_is_to_blame_for_are_distinguished_from_others() -> None:
    fault = am.Fault(file="some.toml", path="dt", message="expected more", value=3)
    assert [line["value"] for line in lines_of(ScenarioError([fault]))] == ["3"]
    assert [line["message"] for line in lines_of(ControllerError("it failed"))] == ["it failed"]
    assert lines_of(AmorsimError("--seed: expected a whole number")) == []
    assert lines_of(RunError("out: the folder holds files already")) == []
