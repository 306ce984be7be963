"""Maps of ROS: occupied, free and unknown by thresholds, in three modes, against a reader of a few plain lines."""

from __future__ import annotations

import math
import re
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image

import amorsim as am
from amorsim.core.errors import MapError
from amorsim.core.maps.same_cells import have_same_cells
from amorsim.maps.ros import Ros
from tests.examples import settings

MAPS = Path(__file__).resolve().parents[3] / "shared" / "maps" / "ros"
FREE, OCCUPIED, UNKNOWN = range(3)


def plain_pgm(path: Path) -> np.ndarray:
    """The pixels of a binary PGM of one byte each, row 0 at the top."""
    data, words, at = path.read_bytes(), [], 0
    while len(words) < 4:
        found = re.compile(rb"\s*(?:#[^\n]*\n\s*)*(\S+)").match(data, at)
        assert found
        words.append(found[1])
        at = found.end()
    assert words[0] == b"P5"
    width, height = int(words[1]), int(words[2])
    return np.frombuffer(data[at + 1 : at + 1 + width * height], np.uint8).reshape(height, width)


def plain_yaml(path: Path) -> dict[str, str]:
    lines = [line.split("#")[0] for line in path.read_text().splitlines()]
    return {key.strip(): value.strip() for key, _, value in (line.partition(":") for line in lines if line.strip())}


def classes(world: am.Map) -> np.ndarray:
    return np.where(world.unknown_array() != 0, UNKNOWN, world.to_array())


def write(folder: Path, pixels: object, name: str = "lab", **keys: object) -> Path:
    Image.fromarray(np.asarray(pixels, np.uint8)).save(folder / f"{name}.png")
    known = {"image": f"{name}.png", "resolution": 0.5, "origin": [0.0, 0.0, 0.0], **keys}
    path = folder / f"{name}.yaml"
    path.write_text("".join(f"{key}: {value}\n" for key, value in known.items() if value is not None))
    return path


# ------------------------------------------------------------------------------------------- real files


@pytest.mark.parametrize("name", ["depot", "empty_room", "turtlebot3_world", "willow-full-0.05"])
@pytest.mark.parametrize("unknown", ["free", "occupied"])
def test_real_maps_cell_by_cell(name: str, unknown: str) -> None:
    path = MAPS / f"{name}.yaml"
    if not path.is_file():
        pytest.skip(f"no {path}")
    keys = plain_yaml(path)
    probability = (255 - plain_pgm(MAPS / keys["image"]).astype(float)) / 255
    expected = np.full(probability.shape, UNKNOWN)
    expected[probability > float(keys["occupied_thresh"])] = OCCUPIED
    expected[probability < float(keys["free_thresh"])] = FREE
    world = am.load_map(path, unknown=unknown)
    assert np.array_equal(classes(world), expected[::-1])
    blocks = (expected == OCCUPIED) | ((expected == UNKNOWN) & (unknown == "occupied"))
    assert np.array_equal(world.to_array(), blocks[::-1])
    assert world.resolution == float(keys["resolution"])
    assert world.origin == tuple(float(word) for word in keys["origin"].strip("[]").split(","))
    assert not world.warnings


@pytest.mark.parametrize("name", ["depot", "turtlebot3_world", "willow-full-0.05"])
def test_a_robot_starts_where_a_real_map_is_known_to_be_free(name: str) -> None:
    from amorsim.scenario.reading.read import scenario_for_map

    path = MAPS / f"{name}.yaml"
    if not path.is_file():
        pytest.skip(f"no {path}")
    scenario = scenario_for_map(path)
    world, pose = scenario.map, scenario.robots[0].pose
    row, col = (
        int((place - origin) / world.resolution)
        for place, origin in zip((pose.y, pose.x), world.origin[1::-1], strict=True)
    )
    assert classes(world)[row - 4 : row + 5, col - 4 : col + 5].max() == FREE


# ------------------------------------------------------------------------------------------------- modes


def expected_class(value: int, mode: str, negate: bool, low: float, high: float) -> int:
    value = 255 - value if negate else value
    share = value / 100 if mode == "raw" else (255 - value) / 255
    if mode == "raw" and value > 100:
        return UNKNOWN
    if mode == "scale":
        return OCCUPIED if share >= (low + high) / 2 else FREE
    return OCCUPIED if share > high else FREE if share < low else UNKNOWN


@pytest.mark.parametrize("mode", ["trinary", "scale", "raw"])
@pytest.mark.parametrize("negate", [0, 1])
@pytest.mark.parametrize("channels", ["L", "RGB"])
def test_every_value_in_every_mode(tmp_path: Path, mode: str, negate: int, channels: str) -> None:
    values = np.arange(256, dtype=np.uint8)[None]
    path = write(tmp_path, values, mode=mode, negate=negate, occupied_thresh=0.7, free_thresh=0.2)
    Image.fromarray(values).convert(channels).save(tmp_path / "lab.png")
    found = classes(Ros().load(path))[0].tolist()
    assert found == [expected_class(value, mode, bool(negate), 0.2, 0.7) for value in range(256)]


def test_the_probability_is_of_the_mean_of_the_channels(tmp_path: Path) -> None:
    path = write(tmp_path, [[[0, 0, 200], [0, 255, 255]]])
    assert classes(Ros().load(path)).tolist() == [[OCCUPIED, UNKNOWN]]


def test_opacity_is_a_channel_in_trinary_and_unknown_in_scale(tmp_path: Path) -> None:
    pixels = [[[255, 255, 255, 255], [255, 255, 255, 0], [0, 0, 0, 255], [0, 0, 0, 0]]]
    assert classes(Ros().load(write(tmp_path, pixels))).tolist() == [[FREE, UNKNOWN, OCCUPIED, OCCUPIED]]
    path = write(tmp_path, pixels, mode="scale")
    assert classes(Ros().load(path)).tolist() == [[FREE, UNKNOWN, OCCUPIED, UNKNOWN]]


def test_the_top_row_is_last_and_the_origin_turns(tmp_path: Path) -> None:
    path = write(tmp_path, [[0, 255], [255, 255]], origin=[1.0, -2.0, math.pi / 2])
    world = Ros().load(path)
    assert world.origin == (1.0, -2.0, math.pi / 2)
    assert world.occupied([(0.25, -1.75), (0.75, -1.75)]).tolist() == [True, False]


# ------------------------------------------------------------------------------------------ forgiving, strict


@pytest.mark.parametrize(
    "text",
    [
        "image: lab.png\nresolution: 5.0e-1\norigin:\n- 0\n- 0.0\n- 0\nnegate: false\n",
        "# made by hand\n---\nresolution: 0.5   # m\nimage: 'lab.png'\norigin: [0, 0]\noccupied_thresh: 0.65\n",
        '{image: "lab.png", resolution: .5, origin: [0., 0., 0.]}',
        "\ufeffimage: lab.png\r\nresolution: 0.5\r\norigin: [0.0, 0.0, 0.0]\r\n",
        "image: /nowhere/else/lab.png\nresolution: 0.5\norigin: [0, 0, 0]\n",
    ],
)
def test_what_real_files_do(tmp_path: Path, text: str) -> None:
    path = write(tmp_path, [[0, 255]])
    path.write_text(text, newline="")
    world = am.load_map(path)
    assert (world.to_array().tolist(), world.resolution, world.origin) == ([[1, 0]], 0.5, (0.0, 0.0, 0.0))
    assert [("next to the file" in warning) for warning in world.warnings] == [True] * ("nowhere" in text)


def test_a_picture_next_to_the_file_goes_before_one_named_by_its_whole_path(tmp_path: Path) -> None:
    # As map_saver writes it: the whole path. A copy of both files elsewhere must read its own picture.
    for folder in ("maps", "copy"):
        (tmp_path / folder).mkdir()
    path = write(tmp_path / "maps", [[0, 255]])
    path.write_text(f"image: {tmp_path / 'maps' / 'lab.png'}\nresolution: 0.5\norigin: [0, 0, 0]\n")
    world = am.load_map(path)
    assert (world.to_array().tolist(), world.warnings) == ([[1, 0]], ())
    assert list(Ros().companions(path)) == [Path("lab.png")]
    copy = write(tmp_path / "copy", [[255, 0]])
    copy.write_text(path.read_text())
    moved = am.load_map(copy)
    assert moved.to_array().tolist() == [[0, 1]]
    assert moved.warnings == (f"lab.png, next to the file, is taken for {tmp_path / 'maps' / 'lab.png'}",)


def test_other_keys_are_remarked_on_once(tmp_path: Path) -> None:
    world = Ros().load(write(tmp_path, [[0, 255]], free_tresh=0.2, author="x", more=[1, 2]))
    (warning,) = world.warnings
    assert warning.startswith("line 4: 'free_tresh' is not a key of a ROS map. Did you mean 'free_thresh'?")
    assert "2 more such keys" in warning


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"image": None}, "'image' is missing"),
        ({"resolution": None}, "'resolution' is missing"),
        ({"resolution": 0}, "line 2: resolution is 0; expected more than 0 m"),
        ({"resolution": "wide"}, "line 2: resolution is 'wide'; expected a finite number"),
        ({"resolution": ".nan"}, "line 2: resolution is '.nan'"),
        ({"origin": "[0, x, 0]"}, "line 3: origin is 'x'"),
        ({"origin": "[0]"}, r"line 3: origin: expected \[x, y, yaw\]"),
        ({"mode": "trinray"}, "line 4: mode is 'trinray'.*Did you mean 'trinary'"),
        ({"negate": 2}, "line 4: negate is '2'; expected 0 or 1"),
        ({"free_thresh": 0.9}, "line 4: free_thresh 0.9 is above occupied_thresh 0.65"),
        ({"occupied_thresh": 65}, "line 4: occupied_thresh is 65; expected 0 to 1, a probability, such as 0.65"),
        ({"free_thresh": -0.1}, "line 4: free_thresh is -0.1; expected 0 to 1, a probability, such as 0.196"),
        (
            {"image": None, "Image": "lab.png"},
            r"'image' is missing \(line 3: 'Image' is not a key of a ROS map\. Did you m",
        ),
        ({"image": "none.pgm"}, r"line 1: image .*none\.pgm: cannot be read: No such file"),
        ({"image": "lab.yaml"}, r"line 1: image .*lab\.yaml: it is not a BMP, PNG"),
        ({"image": "{"}, "line [0-9]+: this is not YAML"),
        ({"image": "a\nimage: b"}, "line 2: a second 'image'; the first is in line 1"),
    ],
)
def test_what_is_wrong_is_said(tmp_path: Path, keys: dict[str, object], words: str) -> None:
    path = write(tmp_path, [[0, 255]], **keys)
    with pytest.raises(MapError, match=words) as caught:
        Ros().load(path)
    assert str(caught.value).startswith(f"{path}: ")


@pytest.mark.long
def test_yaml_that_multiplies_itself_takes_no_memory(tmp_path: Path) -> None:
    path = write(tmp_path, [[0, 255]])
    bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
        f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 12)
    )
    path.write_text(path.read_text() + bomb)
    assert len(Ros().load(path).warnings) == 1
    path.write_text("[" * 100_000)
    with pytest.raises(MapError, match="not YAML"):
        Ros().load(path)


@pytest.mark.parametrize("encoding", ["latin-1", "utf-16", "utf-8-sig"])
def test_other_letters_in_a_comment_do_no_harm(tmp_path: Path, encoding: str) -> None:
    path = write(tmp_path, [[0, 255]])
    path.write_bytes(f"# salle à manger\n{path.read_text()}".encode(encoding))
    assert am.load_map(path).to_array().tolist() == [[1, 0]]


def test_no_code_in_a_file_is_run(tmp_path: Path) -> None:
    path = write(tmp_path, [[0, 255]])
    command = f'!!python/object/apply:os.system ["touch {tmp_path / "ran"}"]'
    path.write_text(f"{path.read_text()}more: {command}\n")
    assert len(Ros().load(path).warnings) == 1
    path.write_text(path.read_text().replace("resolution: 0.5", f"resolution: {command}"))
    with pytest.raises(MapError, match="line 2: resolution is not a number"):
        Ros().load(path)
    assert not (tmp_path / "ran").exists()


@pytest.mark.long
def test_a_large_map_takes_no_more_than_its_layers_and_its_outlines(tmp_path: Path) -> None:
    side = 2000
    path = write(tmp_path, np.full((side, side), 255))
    Ros().load(path)
    tracemalloc.start()
    Ros().load(path)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # Cells and unknown cells, a byte each; the grid and its outlines, 1.3; and 2.4 MB for bands of the picture.
    assert peak < 1.05 * (3.3 * side * side + 2.4e6)


def test_another_yaml_is_no_map(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("- 1\n- 2\n")
    with pytest.raises(MapError, match="not a YAML file of a ROS map"):
        Ros().load(tmp_path / "a.yaml")
    assert Ros.sniff(b"image: a.pgm\nresolution: 0.05\n")
    assert not Ros.sniff(b"image of a map\n")


# --------------------------------------------------------------------------------------------- writing


@settings(max_examples=60, deadline=None)
@given(
    kinds=hnp.arrays(np.uint8, st.tuples(st.integers(1, 9), st.integers(1, 9)), elements=st.integers(0, 2)),
    as_what=st.sampled_from([0, 1]),
    origin=st.tuples(*[st.floats(-50, 50)] * 3),
    resolution=st.sampled_from([0.05, 0.1, 1 / 3]),
)
def test_any_cells_come_back(tmp_path_factory, kinds, as_what, origin, resolution) -> None:
    path = tmp_path_factory.mktemp("ros") / "it's: a #map.yaml"
    unknown = kinds == UNKNOWN
    cells = np.where(unknown, as_what, kinds)
    world = am.Map.from_array(cells, unknown=unknown, resolution=resolution, origin=origin)
    again = am.save_map(world, path)
    assert have_same_cells(world, again)
    assert np.array_equal(classes(again), kinds)
    assert sorted(file.suffix for file in path.parent.iterdir()) == [".pgm", ".yaml"]


def test_the_picture_is_named_relative_to_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from amorsim.scenario.files.maps import companions_of

    (tmp_path / "maps").mkdir()
    write(tmp_path / "maps", [[0, 255]])
    monkeypatch.chdir(tmp_path)
    world = am.load_map("maps/lab.yaml")
    assert companions_of(world.source) == [tmp_path / "maps" / "lab.png"]


@pytest.mark.parametrize("folder", ["run", "{}/run"])
def test_a_copy_takes_the_picture_along(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, folder: str) -> None:
    from amorsim.scenario.files.copied_files import Copies
    from amorsim.testing import check_component

    path = write(tmp_path, np.full((40, 40), 255), resolution=0.1)
    check_component(Ros(), path=path)
    world = am.load_map(path)
    monkeypatch.chdir(tmp_path)
    name = Copies(Path(folder.format(tmp_path))).of_map(world.source)
    again = am.load_map(tmp_path / "run" / name)
    assert have_same_cells(world, again)
    assert sorted(file.name for file in (tmp_path / "run").rglob("*.*")) == ["lab.png", "lab.yaml"]
