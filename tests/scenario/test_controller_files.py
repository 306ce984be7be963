"""Controllers in the user's own files: what is found in them, and what is said when it is not."""

import pickle
import sys

import pytest

from amorsim.core.errors import ControllerError
from amorsim.scenario.programs.controller_files import load_controller, split_reference


@pytest.fixture
def write(tmp_path):
    def write_file(text, name="mine.py"):
        path = tmp_path / name
        path.write_text(text)
        return path

    return write_file


FUNCTION = "def drive(readings, estimate, clock, speed=0.1, *, side='left'):\n    return speed\n"
CLASS = (
    "class Wander:\n    def __init__(self, speed, side='left'):\n        self.speed = speed\n"
    "    def command(self, readings, estimate, clock):\n        return None\n"
)


def test_functions_and_classes_are_found(write):
    path = write(FUNCTION + CLASS)
    assert load_controller(path, "drive", {"speed": 0.2, "side": "right"})(0, 0, 0) == 0.1
    assert load_controller(path, "Wander", {"speed": 0.2})(speed=3).speed == 3


def test_a_relative_file_is_in_the_folder_given(tmp_path):
    assert split_reference("mine.py:Wander", tmp_path) == ((tmp_path / "mine.py").resolve(), "Wander")
    assert split_reference("/a/b.py:f", tmp_path)[0].as_posix() == "/a/b.py"


@pytest.mark.parametrize("use", ["mine.py", "mine.py:", "mine:drive", "mine.py:a b", "mine.txt:drive"])
def test_a_reference_that_is_none(tmp_path, use):
    with pytest.raises(ControllerError, match="expected"):
        split_reference(use, tmp_path)


@pytest.mark.parametrize(
    ("text", "name", "options", "words"),
    [
        (FUNCTION, "drove", {}, r"mine\.py: no definition 'drove'; did you mean 'drive'\?"),
        ("x = 3\n", "x", {}, r"'x' in .* is neither a function nor a class, but 3"),
        ("x = 1\ndef f(:\n", "f", {}, r"mine\.py, line 2: SyntaxError: "),
        ("x = 1\n\nimport no_such_module_anywhere\n", "f", {}, r"line 3: ModuleNotFoundError: .*no_such_module"),
        ("def g():\n    return 1 / 0\ng()\n", "f", {}, r"line 2: ZeroDivisionError"),
        ("import sys\nsys.exit(3)\n", "f", {}, r"line 2: SystemExit: 3"),
        ("x = '\0'\n", "f", {}, r"mine\.py: (SyntaxError|ValueError)"),
        (FUNCTION, "drive", {"sped": 1}, r"unexpected keyword argument 'sped'\. Did you mean 'speed'\?"),
        (CLASS, "Wander", {}, r"missing a required argument: 'speed'"),
        (CLASS, "Wander", {"speed": 1, "sdie": 1}, r"Did you mean 'side'\?"),
        ("def drive(readings):\n    return None\n", "drive", {}, r"drive\(readings\) cannot be called as"),
    ],
)
def test_what_is_wrong_is_said(write, text, name, options, words):
    path = write(text)
    before = set(sys.modules)
    with pytest.raises(ControllerError, match=words):
        load_controller(path, name, options)
    broken = [module for module in set(sys.modules) - before if module.startswith("amorsim_controller")]
    assert not broken or "def" in text or "x = 3" in text


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(ControllerError, match="there is no such file"):
        load_controller(tmp_path / "none.py", "f", {})


def test_an_edited_file_is_another_module_and_nothing_is_left_beside_it(write, tmp_path):
    first = load_controller(write("def f(a, b, c):\n    return 1\n"), "f", {})
    second = load_controller(write("def f(a, b, c):\n    return 2\n"), "f", {})
    assert (first(0, 0, 0), second(0, 0, 0)) == (1, 2)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.py"]


def test_two_files_of_one_name_do_not_meet(write, tmp_path):
    (tmp_path / "other").mkdir()
    one = load_controller(write("def f(a, b, c):\n    return 1\n"), "f", {})
    two = load_controller(write("def f(a, b, c):\n    return 1\n", "other/mine.py"), "f", {})
    assert one.__module__ != two.__module__


def test_objects_of_a_users_class_can_be_pickled(write):
    made = load_controller(write(CLASS), "Wander", {"speed": 1})(speed=0.5)
    assert pickle.loads(pickle.dumps(made)).speed == 0.5


def test_a_file_that_is_asked_for_twice_is_run_once(write):
    path = write("import itertools\ncount = itertools.count()\ndef f(a, b, c):\n    return next(count)\n")
    assert load_controller(path, "f", {}) is load_controller(path, "f", {})
