"""Maps written into files, and read again with the same cells."""

from pathlib import Path

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import amorsim as am
from amorsim.core.maps.same_cells import have_same_cells
from tests.disks import small_disk
from tests.examples import settings

WALLS = [(0, 0, 6, 0), (6, 0, 6, 4), (6, 4, 0, 4), (0, 4, 0, 0), (1.0, 1.0, 2.5, 3.25)]


def test_lines_come_back_as_the_same_map(tmp_path: Path) -> None:
    room = am.Map.from_segments(WALLS, start=(1.0, 2.0, 0.5))
    again = am.save_map(room, tmp_path / "room.wld")
    assert have_same_cells(room, again)
    assert np.array_equal(again.segments, room.segments)
    assert again.start == pytest.approx(room.start, abs=1e-15)
    assert again.source.path == tmp_path / "room.wld"
    assert "1000 1000 2500 3250" in (tmp_path / "room.wld").read_text().splitlines()


@settings(max_examples=60, deadline=None)
@given(
    walls=hnp.arrays(np.float64, st.tuples(st.integers(1, 6), st.just(4)), elements=st.floats(-1, 1, width=64)),
    resolution=st.sampled_from([0.003, 0.01, 0.25]),
)
def test_any_lines_come_back_with_the_same_cells_or_are_refused(tmp_path_factory, walls, resolution) -> None:
    path = tmp_path_factory.mktemp("maps") / "any.wld"
    room = am.Map.from_segments(walls, resolution=resolution, extent=(-1, -1, 1, 1))
    try:
        again = am.save_map(room, path)
    except am.MapError:  # a wall nearer to a border of cells than a double in mm can tell
        assert not path.exists()
        assert np.min(np.abs(walls / resolution - np.round(walls / resolution))) < 1e-9
        return
    assert np.array_equal(again.to_array(), room.to_array())
    assert again.origin == room.origin
    assert np.max(np.abs(again.segments - room.segments)) < 1e-14


@settings(max_examples=60, deadline=None)
@given(
    cells=hnp.arrays(np.bool_, st.tuples(st.integers(1, 9), st.integers(1, 9))),
    origin=st.tuples(*[st.floats(-50, 50)] * 3),
    ending=st.sampled_from(["png", "bmp"]),
)
def test_any_cells_come_back(tmp_path_factory, cells, origin, ending) -> None:
    path = tmp_path_factory.mktemp("maps") / f"any.{ending}"
    plan = am.Map.from_array(cells, resolution=0.05, origin=origin)
    again = am.save_map(plan, path)
    assert np.array_equal(again.to_array(), plan.to_array())
    assert (again.origin, again.resolution) == (plan.origin, plan.resolution)


@settings(max_examples=60, deadline=None)
@given(
    cells=hnp.arrays(np.bool_, st.tuples(st.integers(1, 9), st.integers(1, 9))),
    corner=st.tuples(*[st.integers(-50, 50)] * 2),
    resolution=st.sampled_from([0.001, 0.05, 0.25, 1 / 3]),
)
def test_any_cells_come_back_as_lines(tmp_path_factory, cells, corner, resolution) -> None:
    path = tmp_path_factory.mktemp("maps") / "any.wld"
    origin = (corner[0] * resolution, corner[1] * resolution, 0.0)
    plan = am.Map.from_array(cells, resolution=resolution, origin=origin)
    again = am.save_map(plan, path)
    assert np.array_equal(again.to_array(), plan.to_array())


def test_a_straight_wall_of_cells_is_one_line(tmp_path: Path) -> None:
    cells = np.zeros((20, 30))
    cells[[0, -1], :] = cells[:, [0, -1]] = 1
    am.save_map(am.Map.from_array(cells, resolution=0.1), tmp_path / "room.wld")
    lines = (tmp_path / "room.wld").read_text().splitlines()[3:]
    found = sorted([round(float(word)) for word in line.split()] for line in lines)
    assert found == [[50, 50, 2950, 50], [50, 150, 50, 1850], [50, 1950, 2950, 1950], [2950, 150, 2950, 1850]]


@settings(max_examples=30, deadline=None)
@given(
    classes=hnp.arrays(np.uint8, st.tuples(st.integers(1, 9), st.integers(1, 9)), elements=st.integers(0, 2)),
    as_what=st.sampled_from([0, 1]),
    ending=st.sampled_from(["png", "tif"]),
)
def test_unknown_cells_come_back(tmp_path_factory, classes, as_what, ending) -> None:
    path = tmp_path_factory.mktemp("maps") / f"any.{ending}"
    unknown = classes == 2
    plan = am.Map.from_array(np.where(unknown, as_what, classes), unknown=unknown, resolution=0.05)
    again = am.save_map(plan, path)
    assert np.array_equal(again.to_array(), plan.to_array())
    assert np.array_equal(again.unknown_array(), unknown)


def test_unknown_cells_are_not_lost_silently(tmp_path: Path) -> None:
    plan = am.Map.from_array([[0, 1]], unknown=[[1, 0]], resolution=0.05)
    with pytest.raises(am.MapError, match="has other cells"):
        am.save_map(plan, tmp_path / "plan.bmp")


def test_lines_can_be_written_as_pixels_too(tmp_path: Path) -> None:
    room = am.Map.from_segments(WALLS, resolution=0.01)
    again = am.save_map(room, tmp_path / "room.png")
    assert have_same_cells(room, again)
    assert again.segments is None


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("plan.jpg", "a JPEG blurs the cells"),
        ("plan.xyz", r"no map can be written with this extension; those that can: \.bmp, .*\.png, .*\.wld"),
        ("plan", "no map can be written with this extension"),
        ("none/plan.png", "No such file"),
    ],
)
def test_what_cannot_be_written_is_refused_and_leaves_nothing(tmp_path: Path, name: str, words: str) -> None:
    plan = am.Map.from_array([[0, 1]], resolution=0.05)
    with pytest.raises(am.MapError, match=words):
        am.save_map(plan, tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_a_loader_that_writes_other_cells_is_found_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from amorsim.maps.bmp import Bitmap

    save = Bitmap.save.__func__
    monkeypatch.setattr(
        Bitmap, "save", classmethod(lambda cls, world, path: attrs.evolve(save(cls, world, path), origin_x=1.0))
    )
    with pytest.raises(am.MapError, match="has other cells"):
        am.save_map(am.Map.from_array([[0, 1]], resolution=0.05), tmp_path / "plan.png")


def test_maps_differ_by_one_cell_or_by_their_place() -> None:
    cells = np.zeros((70, 130))
    one = am.Map.from_array(cells, resolution=0.1)
    cells[69, 129] = 1
    assert not have_same_cells(one, am.Map.from_array(cells, resolution=0.1))
    assert not have_same_cells(one, am.Map.from_array(np.zeros((70, 130)), resolution=0.1, origin=(0, 0, 1e-9)))
    assert not have_same_cells(one, am.Map.from_array(np.zeros((70, 129)), resolution=0.1))


@pytest.mark.parametrize("is_link", [False, True])
def test_a_map_that_cannot_be_written_leaves_the_file_that_was_there(tmp_path: Path, is_link: bool) -> None:
    file = tmp_path / "room.wld"
    if is_link:
        (tmp_path / "real.wld").write_text("0 0 1000 0\n")
        file.symlink_to("real.wld")
    else:
        file.write_text("0 0 1000 0\n")
    before = sorted(tmp_path.iterdir())
    with pytest.raises(am.MapError, match=r"room\.wld: cannot be written: read again, it has other cells"):
        am.save_map(am.Map.from_array([[0, 1]], resolution=0.05, origin=(0.0, 0.0, 0.5)), file)
    assert sorted(tmp_path.iterdir()) == before
    assert file.is_symlink() == is_link
    assert file.read_text() == "0 0 1000 0\n"


def test_a_map_too_large_for_pixels_leaves_the_file_that_was_there(tmp_path: Path) -> None:
    (tmp_path / "room.png").write_bytes(b"old")
    with pytest.raises(am.MapError, match="would be a picture of 40000 x 40000 pixels"):
        am.save_map(am.Map.from_segments([(0, 0, 40, 0), (0, 0, 0, 40)]), tmp_path / "room.png")
    assert (tmp_path / "room.png").read_bytes() == b"old"


def test_a_full_disk_leaves_the_map_that_was_there(tmp_path: Path) -> None:
    (tmp_path / "room.wld").write_text("0 0 1000 0\n")
    room = am.Map.from_segments([(0, 0.01 * i, 1, 0.01 * i) for i in range(200)])
    with small_disk(), pytest.raises(am.MapError, match=r"room\.wld: cannot be written \(File too large\)"):
        am.save_map(room, tmp_path / "room.wld")
    assert [path.name for path in tmp_path.iterdir()] == ["room.wld"]
    assert (tmp_path / "room.wld").read_text() == "0 0 1000 0\n"


def test_a_full_disk_leaves_the_picture_that_was_there(tmp_path: Path) -> None:
    (tmp_path / "plan.png").write_bytes(b"old")
    plan = am.Map.from_array(np.random.default_rng(1).integers(0, 2, (200, 200)), resolution=0.05)
    with small_disk(), pytest.raises(am.MapError, match=r"plan\.png: cannot be written \(File too large\)"):
        am.save_map(plan, tmp_path / "plan.png")
    assert (tmp_path / "plan.png").read_bytes() == b"old"


def test_a_loader_that_fails_is_named_and_leaves_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from amorsim.maps.wld import Wld

    def save(cls: type, world: am.Map, path: Path) -> None:
        path.write_text("half")
        raise KeyError("colour")

    (tmp_path / "room.wld").write_text("old")
    monkeypatch.setattr(Wld, "save", classmethod(save))
    with pytest.raises(am.MapError, match=r"room\.wld: cannot be written: Wld failed with KeyError: 'colour'"):
        am.save_map(am.Map.from_segments(WALLS), tmp_path / "room.wld")
    assert (tmp_path / "room.wld").read_text() == "old"


def test_a_map_is_called_after_the_file_that_it_was_written_into(tmp_path: Path) -> None:
    again = am.save_map(am.Map.from_segments(WALLS), tmp_path / "room.wld")
    assert (again.name, again.source.path) == ("room", tmp_path / "room.wld")
    assert again == am.load_map(tmp_path / "room.wld")
