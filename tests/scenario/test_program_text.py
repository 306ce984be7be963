"""Users' programs are checked by their text where nothing may run, and say the same as when they are loaded."""

from __future__ import annotations

import pytest

import amorsim as am
from amorsim.core.errors import ControllerError
from amorsim.scenario.programs.controller_files import load_controller
from amorsim.scenario.programs.program_text import Program, check_program
from amorsim.scenario.reading.read import check_words

PLAIN = "def drive(readings, estimate, clock, speed=0.3, *, gain: float = 1.0):\n    return None\n"


@pytest.mark.parametrize(
    ("text", "options"),
    [
        (PLAIN, {}),
        (PLAIN, {"speed": 0.2, "gain": 2.0}),
        (PLAIN, {"sped": 0.2}),
        ("def drive(readings, estimate):\n    return None\n", {}),
        ("def drive(readings, estimate, clock, must):\n    return None\n", {}),
        ("def drive(readings, estimate, clock, /, **options):\n    return None\n", {"any": 1}),
        ("def drive(*all) -> None:\n    return None\n", {"any": 1}),
        ("def drove(readings, estimate, clock):\n    return None\n\n\nclass Other:\n    pass\n", {}),
        ("class drive:\n    def __init__(self, speed):\n        pass\n", {"speed": 1}),
        ("class drive:\n    def __init__(self, speed):\n        pass\n", {"sped": 1}),
        ("class drive:\n    pass\n", {"speed": 1}),
        ("class base:\n    def __init__(self, speed):\n        pass\nclass drive(base):\n    pass\n", {"speed": 1}),
        ("import functools\n@functools.cache\ndef drive(a, b, c):\n    return None\n", {}),
        ("drive = lambda readings, estimate, clock: None\n", {}),
        ("if True:\n    def drive(a, b, c):\n        return None\n", {}),
        (
            "try:\n    import nothing as drive\nexcept ImportError:\n    def drive(a, b, c):\n        return None\n",
            {},
        ),
        ("from math import *\ndef drive(a, b, c):\n    return None\n", {}),
        ("globals()['drive'] = lambda a, b, c: None\n", {}),
        ("(drive := lambda a, b, c: None)\n", {}),
        ("def drive(readings, estimate, clock:\n", {}),
        ("x = '\\d'\n\0", {}),
        (None, {}),
    ],
)
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_what_the_text_says_is_what_loading_says(tmp_path, text, options):
    path = tmp_path / "mine.py"
    if text is not None:
        path.write_text(text)
    said = []
    for check in (load_controller, check_program):
        try:
            check(path, "drive", options)
            said.append("")
        except ControllerError as error:
            said.append(str(error))
    assert said[0] == said[1]


def test_nothing_of_it_runs(tmp_path):
    (tmp_path / "room.wld").write_text("width 4000\nheight 3000\n")
    (tmp_path / "mine.py").write_text(
        "raise SystemExit('it ran')\ndef drive(a, b, c):\n    pass\ndef go(o):\n    pass\n"
    )
    path = tmp_path / "some.toml"
    path.write_text(
        'format = 1\n[world]\nmap = "room.wld"\n[[robots]]\nmodel = "pioneer2dx"\npose = { x = 1.0, y = 1.0 }\n'
        'controller = { use = "mine.py:drive" }\n'
        '[[obstacles]]\nshape = { circle = 0.1 }\npose = { x = 3.0, y = 1.0 }\nmotion = { use = "mine.py:go" }\n'
    )
    document = am.open_document(path)
    assert document.faults() == ()
    partial = document.partial()
    assert isinstance(partial.robots[0].controller.function, Program)
    with pytest.raises(ControllerError, match="has not been loaded"):
        partial.robots[0].controller.function()
    check_words(path)
    for scenario in (document.scenario(), am.load(path)):
        with pytest.raises(am.ScenarioError, match="it ran") as caught:
            am.Simulation(scenario)
        assert [(fault.file, fault.line) for fault in caught.value.faults] == [(str(path), 7), (str(path), 11)]
    document.set("robots.0.controller.speed", 1.0)
    (fault,) = document.faults()
    assert (fault.line, "cannot be called as" in fault.message) == (7, True)
