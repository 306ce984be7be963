"""The page of the faults of another program's file, or of a map."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest

from amorsim.core.errors import AmorsimError
from amorsim.runs.scenario_argument import read_scenario
from amorsim.ui.faults.changed_files import stamps_of_scenario
from amorsim.ui.faults.mending import Mending
from amorsim.ui.faults.shown_faults import lines_of
from tests.ui.aside import aside

GOOD = {
    "lab.world": "define bot position ( size [0.4 0.3 0.2] )\nfloorplan( size [6 4 1] )\nbot( pose [0 0 0 0] )\n",
    "valley.map": "type octile\nheight 3\nwidth 4\nmap\n....\n....\n....\n",
}
BAD = {
    "lab.world": (GOOD["lab.world"].replace("[0 0 0 0]", "[0 0 0 x]"), "lab.world", 3, "pose: expected a number"),
    "valley.map": (GOOD["valley.map"].replace("....", "...", 1), "", None, "valley.map: line 5: the row has 3 cells"),
}


@pytest.fixture(params=sorted(GOOD))
def file(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = Path(request.param)
    path.write_text(BAD[path.name][0])
    return path


def test_its_faults_are_shown_until_it_is_mended(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, name, line, message = BAD[file.name]
    with pytest.raises(AmorsimError) as caught:
        read_scenario(str(file))

    async def opened() -> str:
        return "/run/it"

    async def run() -> None:
        mending = Mending(str(file), lines_of(caught.value), open_page=opened)
        mending.start()
        said: dict[str, Any] = {"number": 0, "status": ""}

        async def until(status: str) -> None:
            while said["status"] != status:
                command = {"do": "document", "after": said["number"]}
                said.update(await asyncio.wait_for(mending.ask("w", command), 60.0))

        try:
            await until("faulty")
            (fault,) = said["faults"]
            assert (fault["file"], fault["line"]) == (name, line)
            assert message in fault["message"]
            file.write_text(GOOD[file.name])
            await until("open")
        finally:
            await mending.close()

    aside(run())
    assert capsys.readouterr().err == ""


def test_its_stamp_is_taken_whatever_is_wrong_with_it(file: Path) -> None:
    assert file.absolute() in stamps_of_scenario(str(file))
