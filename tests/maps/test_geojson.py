"""GeoJSON: polygons, lines, longitude and latitude; faults name their place."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import amorsim as am
from amorsim.core.errors import MapError
from amorsim.maps.geojson import GeoJson
from tests.examples import settings


def written(folder: Path, document: object) -> Path:
    path = folder / "a.geojson"
    path.write_text(document if isinstance(document, str) else json.dumps(document))
    return path


def geometry(kind: str, coordinates: object) -> dict[str, object]:
    return {"type": "Feature", "properties": None, "geometry": {"type": kind, "coordinates": coordinates}}


SQUARE = [[1, 1], [4, 1], [4, 4], [1, 4], [1, 1]]
HOLE = [[2, 2], [2, 3], [3, 3], [3, 2], [2, 2]]
ROOM = geometry("LineString", [[0, 0], [5, 0], [5, 5], [0, 5], [0, 0]])


def test_polygons_are_full_but_for_their_holes(tmp_path: Path) -> None:
    path = written(tmp_path, {"type": "FeatureCollection", "features": [ROOM, geometry("Polygon", [SQUARE, HOLE])]})
    world = GeoJson(resolution=0.1).load(path)
    inside, hole, around = (1.55, 2.55), (2.55, 2.55), (0.55, 2.55)
    assert world.occupied([inside, hole, around]).tolist() == [True, False, False]
    outlines = GeoJson(resolution=0.1, fill=False).load(path)
    assert outlines.occupied([inside, hole, around, (1.0, 2.5)]).tolist() == [False, False, False, True]


@settings(max_examples=80, deadline=None)
@given(points=hnp.arrays(np.int64, (5, 2), elements=st.integers(0, 3000)).map(lambda mm: mm / 1000))
def test_what_is_inside_is_what_shapely_says(tmp_path_factory, points: np.ndarray) -> None:
    import shapely

    hull = shapely.convex_hull(shapely.multipoints(points))
    if hull.geom_type != "Polygon":
        return
    path = written(
        tmp_path_factory.mktemp("geo"), {"type": "Polygon", "coordinates": [[*map(list, hull.exterior.coords)]]}
    )
    world = GeoJson(resolution=0.125).load(path)
    rows, cols = world.shape
    middles = np.stack(np.meshgrid(np.arange(cols) + 0.5, np.arange(rows) + 0.5), axis=-1) * 0.125 + world.origin[:2]
    inside = shapely.contains_xy(hull, middles[..., 0], middles[..., 1])
    near = shapely.distance(hull, shapely.points(middles)) < 0.125
    cells = world.to_array() != 0
    assert cells[inside].all()
    assert not cells[~near].any()


def test_longitude_and_latitude_are_projected(tmp_path: Path) -> None:
    # A hundredth of a degree each way from 50 north, 8 east, by the series for the length of a degree.
    path = written(tmp_path, {"type": "LineString", "coordinates": [[7.99, 49.99], [8.01, 50.01]]})
    world = GeoJson(coordinates="degrees", resolution=0.5).load(path)
    phi = math.radians(50)
    north = 111132.954 - 559.822 * math.cos(2 * phi) + 1.175 * math.cos(4 * phi)
    east = 111412.84 * math.cos(phi) - 93.5 * math.cos(3 * phi) + 0.118 * math.cos(5 * phi)
    x0, y0, x1, y1 = world.segments[0]
    assert (x1 - x0, y1 - y0) == pytest.approx((0.02 * east, 0.02 * north), rel=2e-5)
    assert (x0 + x1, y0 + y1) == pytest.approx((0, 0), abs=1e-6)
    assert "longitude 8.0000000, latitude 50.0000000" in world.warnings[0]
    moved = GeoJson(coordinates="degrees", resolution=0.5, latitude=49.99, longitude=7.99).load(path)
    assert moved.segments[0, :2].tolist() == [0.0, 0.0]
    assert moved.warnings == ()


def test_what_looks_like_degrees_is_remarked_on(tmp_path: Path) -> None:
    path = written(tmp_path, {"type": "LineString", "coordinates": [[8.0, 50.0], [8.001, 50.001]]})
    assert "coordinates = 'degrees'" in GeoJson().load(path).warnings[0]


def test_what_is_left_out_is_remarked_on_once(tmp_path: Path) -> None:
    features = [ROOM, geometry("Point", [1, 1]), geometry("Point", [1, 2]), geometry("Polygon", [SQUARE[:-1]])]
    features.append({"type": "Feature", "geometry": None})
    world = GeoJson(resolution=0.1).load(written(tmp_path, {"type": "FeatureCollection", "features": features}))
    assert world.warnings == (
        "1 rings of polygons end elsewhere than they begin; they are closed",
        "left out: 2 points",
    )


@pytest.mark.parametrize(
    ("document", "words"),
    [
        ('{"type":\n"Feature"', "line 2: this is not JSON"),
        ([1], "the file: expected an object with a 'type', got a list of 1"),
        ({"type": "Line"}, "the file: type is 'Line'; expected one of Point"),
        ({"type": "FeatureCollection"}, "features: expected a list, got None"),
        ({"type": "FeatureCollection", "features": []}, "neither a line nor a polygon"),
        (
            {"type": "FeatureCollection", "features": [ROOM, geometry("Polygon", [[[0, 0], [1, "x"]]])]},
            r"features\[1\]\.geometry\.coordinates\[0\]\[1\]: expected \[x, y\], two numbers .* got \[1.0, 'x'\]$",
        ),
        ({"type": "LineString", "coordinates": []}, "coordinates: expected positions, got none"),
        ({"type": "LineString", "coordinates": [[0, 0], [1e300, 0]]}, r"coordinates\[1\]: .*, got \[1e\+300, 0.0\]"),
        ("[" * 100_000, "nested too deeply"),
        ({"type": "LineString", "coordinates": [[0, 0], [1e11, 1]]}, "too large for cells"),
        ({"type": "Polygon", "coordinates": [[[0, 0], [1e8, 0], [1e8, 1e8], [0, 0]]]}, "more than 2000000 lines"),
    ],
)
def test_what_is_wrong_is_said(tmp_path: Path, document: object, words: str) -> None:
    path = written(tmp_path, document)
    with pytest.raises(MapError, match=words) as caught:
        GeoJson().load(path)
    assert str(caught.value).startswith(f"{path}: ")


ACROSS = [(-0.001, 0.0), (0.001, 0.0), (0.001, 0.001), (-0.001, 0.001), (-0.001, 0.0)]


@pytest.mark.parametrize(
    "longitudes",
    [
        lambda x: (x + 180.0 + 180.0) % 360.0 - 180.0,  # from 179.999 to -179.999
        lambda x: x + 180.0,  # on to 180.001
        lambda x: x - 180.0,
    ],
)
@pytest.mark.parametrize("longitude", [None, 180.0, -180.0, 179.9])
def test_a_ring_over_the_date_line_is_in_one_piece(tmp_path: Path, longitudes, longitude: float | None) -> None:
    def load(ring: list[list[float]], middle: float | None) -> am.Map:
        path = written(tmp_path, geometry("Polygon", [ring]))
        return GeoJson(coordinates="degrees", resolution=1.0, longitude=middle, latitude=10.0).load(path)

    there = load([[longitudes(x), 10.0 + y] for x, y in ACROSS], longitude)
    here = load([[x, 10.0 + y] for x, y in ACROSS], None if longitude is None else longitude % 360.0 - 180.0)
    np.testing.assert_allclose(there.segments[:4], here.segments[:4], atol=1e-6)
    assert there.shape == here.shape


def test_a_number_of_thousands_of_digits_is_refused_with_its_place(tmp_path: Path) -> None:
    path = written(tmp_path, '{"type": "LineString", "coordinates": [[1' + 5000 * "0" + ", 0], [1, 1]]}")
    with pytest.raises(MapError, match=r"coordinates\[0\]: expected .*, got \[inf, 0.0\]"):
        GeoJson().load(path)


@settings(max_examples=60, deadline=None)
@given(
    walls=hnp.arrays(np.float64, st.tuples(st.integers(0, 6), st.just(4)), elements=st.floats(-1, 1, width=64)),
    resolution=st.sampled_from([0.003, 0.01, 0.25]),
)
def test_any_lines_come_back(tmp_path_factory, walls, resolution) -> None:
    room = am.Map.from_segments(walls, resolution=resolution, extent=(-1, -1, 1, 1), start=(0.1, 0.2, 0.3))
    again = am.save_map(room, tmp_path_factory.mktemp("maps") / "any.geojson")
    assert np.array_equal(again.to_array(), room.to_array())
    assert np.array_equal(again.segments, room.segments)
    assert again.start == pytest.approx(room.start)


@settings(max_examples=60, deadline=None)
@given(cells=hnp.arrays(np.bool_, st.tuples(st.integers(1, 9), st.integers(1, 9))), corner=st.integers(-50, 50))
def test_any_cells_come_back(tmp_path_factory, cells, corner) -> None:
    plan = am.Map.from_array(cells, resolution=0.05, origin=(corner * 0.05, 0.0, 0.0))
    again = am.save_map(plan, tmp_path_factory.mktemp("maps") / "any.geojson")
    assert np.array_equal(again.to_array(), plan.to_array())
