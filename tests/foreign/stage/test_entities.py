"""The grammar of Stage worlds: includes, macros, nesting, comments; and what is refused, with its line."""

from __future__ import annotations

import time

import pytest

from amorsim.core.errors import ScenarioError
from amorsim.foreign.stage.entities import read_world
from amorsim.foreign.stage.tokens import looks_like_stage


def fault_of(path) -> str:
    with pytest.raises(ScenarioError) as caught:
        read_world(path)
    (fault,) = caught.value.faults
    return f"{fault.file.rpartition('/')[2]}:{fault.line}: {fault.message}"


def test_macros_are_filled_in_and_instances_lie_over_them(write) -> None:
    world = read_world(
        write(
            'include "eyes.inc"  # comes first\n'
            'define bot position ( size [0.4 0.3] color "red" eyes( pose [0.1 0 0 0] ) )\n'
            'define bluebot bot(color "blue")\n'
            'bluebot( name "b#1" pose [1 2 0 90] )\n',
            eyes="define eye sensor ( range [0 2] )\ndefine eyes ranger(eye() eye(range[0 3]))",
        )
    )
    (bot,) = world.models
    assert (bot.kind, bot.called) == ("position", "bluebot")
    assert bot.values["color"].items == ("blue",)
    assert bot.values["name"].items == ("b#1",)
    assert bot.values["size"].items == ("0.4", "0.3")
    (ranger,) = bot.inner
    assert [eye.values["range"].items for eye in ranger.inner] == [("0", "2"), ("0", "3")]
    assert [file.name for file in world.files] == ["lab.world", "eyes.inc"]


def test_a_macro_is_the_one_that_was_defined_last_before_its_use(write) -> None:
    text = "define b model(mass 1)\nb()\ndefine b model(mass 2)\nb()\n"
    assert [model.values["mass"].items for model in read_world(write(text)).models] == [("1",), ("2",)]


def test_keys_with_numbers_and_brackets_in_any_spacing(write) -> None:
    text = "model(block(points 3 point[0][0 0]\npoint[1] [1 0] point[2] [0\n1] z[0 1]))"
    (model,) = read_world(write(text)).models
    (block,) = model.inner
    assert block.values["point[0]"].items == ("0", "0")
    assert block.values["point[2]"].items == ("0", "1")
    assert block.values["z"].items == ("0", "1")


def test_an_include_is_found_beside_its_file_or_beside_the_world(write, tmp_path) -> None:
    (tmp_path / "inc").mkdir()
    (tmp_path / "inc" / "a.inc").write_text('include "b.inc"\ninclude "top.inc"')
    (tmp_path / "inc" / "b.inc").write_text("define b model()")
    path = write('include "inc/a.inc"\nb() top()', top="define top model()")
    assert [model.called for model in read_world(path).models] == ["b", "top"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("\nmodel( pose [0 0 0 0]\n", "lab.world:2: expected ')' for the '(' of line 2 after ']', got the end"),
        ("model()\nmodel( size [1 2 )", "lab.world:2: expected a number or ']' for size, got ')'"),
        ('name "x', "lab.world:1: expected a closing quote"),
        (
            "# x\npositoin()",
            "lab.world:2: there is no type of model called 'positoin', nor a macro. Did you mean 'position'?",
        ),
        ("define a\n", "lab.world:1: expected a type after 'a'"),
        ("define a b c", "lab.world:1: expected define NEW TYPE ( ... )"),
        ("define a b()\ndefine b a()\na()", "lab.world:3: 'a' is defined by itself"),
        ("define a model( a() )\na()", "lab.world:1: a is nested deeper than 60, or holds itself"),
        ('include "none.inc"', "lab.world:1: the included file"),
        ('\ninclude "loop.inc"', "loop.inc:1: loop.inc includes itself, by way of lab.world and loop.inc"),
        ("include none", "lab.world:1: expected include with a file's name in quotes, got 'none'"),
        ("resolution", "lab.world:1: expected a value for resolution after 'resolution', got the end"),
        ("] resolution 1", "lab.world:1: expected a key, a model or define, got ']'"),
    ],
)
def test_what_is_wrong_is_reported_with_its_line(write, text: str, expected: str) -> None:
    assert fault_of(write(text, loop='include "loop.inc"')).startswith(expected)


def test_what_grows_without_end_is_refused_at_once(write) -> None:
    deep = "model(" * 10_000
    bomb = "".join(f"define a{i} model( {f'a{i - 1}() ' * 10})\n" if i else "define a0 model()\n" for i in range(50))
    begin = time.process_time()
    assert "nested deeper than 60" in fault_of(write(deep))
    assert "more than 200000 models" in fault_of(write(bomb + "a49()"))
    assert "include one another more than 1000 times" in fault_of(
        write('include "a.inc" ' * 20, a='include "b.inc" ' * 20, b='include "c.inc" ' * 20, c="")
    )
    assert time.process_time() - begin < 5.0


def test_binary_files_are_refused(write) -> None:
    path = write("model()")
    path.write_bytes(b"model()\x00")
    with pytest.raises(ScenarioError, match="byte 7 is 0x00: this is not a text file"):
        read_world(path)


def test_its_beginning_tells_a_world_from_other_files() -> None:
    assert looks_like_stage(b'# simple.world\n\ninclude "a.inc"\n')
    assert looks_like_stage(b"\xef\xbb\xbfresolution 0.02\n")
    assert looks_like_stage(b"pioneer2dx\n(\n")
    assert looks_like_stage(b"# only a comment\n")
    assert not looks_like_stage(b"1,0\nbrick\n0\n")  # the Khepera Simulator's
    assert not looks_like_stage(b"\x89PNG\r\n")
    assert not looks_like_stage(b"")


@pytest.mark.parametrize("head", [b"abc", b"world:\n  map: rooms.wld\n", b"width 4000\n", b"print(1)\n", b"# text\n"])
def test_other_texts_are_no_worlds_without_the_extension(head: bytes) -> None:
    assert not looks_like_stage(head, is_sure=True)


@pytest.mark.parametrize("head", [b'# x\ninclude "a.inc"', b"define a model\n(", b"resolution 0.02", b"floorplan\n("])
def test_worlds_are_known_without_the_extension(head: bytes) -> None:
    assert looks_like_stage(head, is_sure=True)
