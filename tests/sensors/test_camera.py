"""Blobs of a camera against outlines that shapely projects, and a head that follows commands."""

import math

import attrs
import numpy as np
import pytest
import shapely

import amorsim as am
from amorsim.core.parameters import ParameterError
from amorsim.core.poses import wrap_angle
from amorsim.core.shapes import Shape
from amorsim.scenario.spec import Landmark, Obstacle, Pose
from amorsim.sensors import Camera
from tests.building import empty, robot, room, scenario
from tests.sensors.crowd import bearings_of, first_met, in_the_open, random_crowd
from tests.sensors.sight import random_scene

COLOURS = ("red", "orange", "yellow", "green", "cyan", "blue", "magenta", "white")
FULL = 2 * math.pi


def look(*things, camera=None, world=None, pose=Pose(), **changes):  # noqa: B008 - frozen
    marks = [thing for thing in things if isinstance(thing, Landmark)]
    bodies = [thing for thing in things if isinstance(thing, Obstacle)]
    eye = camera or Camera(**({"width": 400, "height": 300, "fov": 1.6} | changes))
    one = robot(shape=Shape.circle(0.2), pose=pose, sensors={"eye": eye}, estimators={})
    return am.Simulation(scenario(one, map=world or empty(50.0), obstacles=bodies, landmarks=marks))


def blobs(sim):
    return sim.robot("rover").readings["eye"].true.reshape(-1, 7)


def post(x, y, colour, radius=0.2, name="", height=1.0):
    return Obstacle(
        name=name or f"{colour.lstrip('#')}_post",
        shape=Shape.circle(radius),
        pose=Pose(x=x, y=y),
        colour=colour,
        height=height,
    )


def columns_of(bearings, fov, width):
    """The columns, as real numbers, at bearings from the camera's axis: 0 at the image's left edge."""
    return width / 2 - np.asarray(bearings) / (fov / width)


def test_a_post_is_as_wide_and_as_high_as_it_looks():
    sim = look(post(2.0, 0.5, "green", height=0.8), eye=0.3)
    colour, left, right, top, bottom, away, bearing = blobs(sim)[0]
    distance = math.hypot(2.0, 0.5)
    half, middle = math.asin(0.2 / distance), math.atan2(0.5, 2.0)
    expected = columns_of([middle + half, middle - half], 1.6, 400)
    assert colour == 1.0
    assert abs(left - expected[0]) <= 1.0
    assert abs(right + 1 - expected[1]) <= 1.0
    assert away == pytest.approx(distance - 0.2, abs=1e-4)  # the column nearest to the middle
    assert bearing == pytest.approx(middle, abs=1.6 / 400)
    pixel = 1.6 / 400
    assert abs(top - (150 - math.atan2(0.5, away) / pixel)) <= 1.0
    assert abs(bottom + 1 - (150 + math.atan2(0.3, away) / pixel)) <= 1.0
    assert (blobs(sim)[1:, 0] == -1.0).all()
    assert np.isinf(blobs(sim)[1:, 1:]).all()


def test_of_one_colour_side_by_side_is_one_blob_and_of_two_is_two():
    touching = [post(2.0, 0.2, "red", name="a"), post(2.4, -0.1, "red", name="b")]
    assert (blobs(look(*touching))[:, 0] == 0.0).sum() == 1
    apart = [post(2.0, 0.5, "red", name="a"), post(2.0, -0.5, "red", name="b")]
    assert (blobs(look(*apart))[:, 0] == 0.0).sum() == 2
    mixed = [attrs.evolve(touching[0], colour="blue"), touching[1]]
    assert sorted(blobs(look(*mixed))[:2, 0].tolist()) == [0.0, 2.0]


def test_walls_and_colourless_bodies_hide_and_landmarks_are_seen():
    world = room()
    at = Pose(x=1.0, y=2.5)
    assert blobs(look(Landmark(id=1, x=5.9, y=2.5, colour="red"), world=world, pose=at))[0, 0] == 0.0
    assert blobs(look(Landmark(id=1, x=6.3, y=2.5, colour="red"), world=world, pose=at))[0, 0] == -1.0
    assert blobs(look(Landmark(id=1, x=5.9, y=2.5), world=world, pose=at))[0, 0] == -1.0
    grey = attrs.evolve(post(3.0, 0.0, "grey"), colour=None)
    assert blobs(look(grey, post(4.0, 0.0, "red", radius=0.1)))[0, 0] == -1.0
    assert blobs(look(post(4.0, 0.0, "#ff0000", name="p")))[0, 0] == 0.0  # as red as red
    assert blobs(look(post(4.0, 0.0, "pink")))[0, 0] == -1.0  # none of the colours it looks for
    assert blobs(look(post(9.0, 0.0, "red")))[0, 0] == -1.0  # too far off


def test_a_landmark_is_as_wide_as_its_disc():
    sim = look(Landmark(id=3, x=3.0, y=-0.4, radius=0.1, colour="yellow"))
    half, middle = math.asin(0.1 / math.hypot(3.0, 0.4)), math.atan2(-0.4, 3.0)
    expected = columns_of([middle + half, middle - half], 1.6, 400)
    assert np.abs(blobs(sim)[0, 1:3] + [0, 1] - expected).max() <= 1.0


def test_the_nearest_are_reported_first_and_slots_are_few():
    posts = [post(2.0 + i, 1.2 - 0.6 * i, "red", name=f"p{i}") for i in range(5)]
    sim = look(*posts, slots=3)
    assert len(blobs(sim)) == 3
    assert (np.diff(blobs(sim)[:, 5]) > 0).all()


def test_the_head_follows_its_channels_at_its_rates_and_the_image_with_it():
    camera = Camera(width=400, height=300, fov=1.0, fov_min=0.2, pan_rate=0.5, zoom_rate=0.5)
    sim = look(post(3.0, 0.0, "red"), camera=camera)
    assert sim._fleet.groups[0].channels[2:] == ("eye.pan", "eye.tilt", "eye.zoom")
    still = blobs(sim)[0]
    sim.robot("rover").command(0.0, 0.0, 0.3, 0.0, 0.0)
    sim.step()  # 0.05 rad on its way
    moved = blobs(sim)[0]
    np.testing.assert_allclose(moved[1:3] - still[1:3], 0.05 / (1.0 / 400), atol=1.0)
    assert moved[6] == pytest.approx(still[6], abs=1.0 / 400)  # the bearing is from the mount's heading
    for _ in range(9):
        sim.step()
    assert blobs(sim)[0, 6] == pytest.approx(0.0, abs=1.0 / 400)
    sim.robot("rover").command(0.0, 0.0, 0.0, 0.1, 1.0)
    for _ in range(30):
        sim.step()
    _, left, right, top, bottom, away, _ = blobs(sim)[0]
    pixel = 0.2 / 400
    assert abs(right + 1 - left - 2 * math.asin(0.2 / 3.0) / pixel) <= 2.0
    assert abs(bottom + 1 - min(300, 150 + (math.atan2(0.3, away) + 0.1) / pixel)) <= 1.0
    assert abs(top - max(0, 150 - (math.atan2(0.7, away) - 0.1) / pixel)) <= 1.0


def test_tilted_away_it_sees_nothing():
    sim = look(post(3.0, 0.0, "red", height=0.4), fov=0.5, pan_rate=10.0)  # 300 rows are 0.375 rad
    assert blobs(sim)[0, 0] == 0.0
    sim.robot("rover").command(0.0, 0.0, 0.0, 0.5, 0.0)
    sim.step()
    assert blobs(sim)[0, 0] == -1.0


def test_a_controller_commands_it_by_channel(tmp_path):
    """Through a file: a camera in a scenario, driven by a function that names the channels."""
    seen = []

    def chase(readings, estimate, clock):
        seen.append(readings["eye"].measured.reshape(-1, 7)[0, 6])
        return (0.0, 0.0, 0.4, 0.0, 0.0)

    eye = Camera(pan_rate=1.0)
    one = robot(shape=Shape.circle(0.2), pose=Pose(), sensors={"eye": eye}, estimators={}, controller=chase)
    sim = am.Simulation(scenario(one, map=empty(50.0), obstacles=[post(3.0, 0.8, "red")]))
    for _ in range(6):
        sim.step()
    assert sim._fleet.groups[0].sensors["eye"].state["head"][0].tolist() == [pytest.approx(0.4), 0.0, 0.0]
    assert seen[-1] == pytest.approx(math.atan2(0.8, 3.0), abs=0.01)


def shapely_columns(scene, fov, width, range_max):
    """Which body each column sees by shapely, at its left edge, in its middle and at its right edge; -1 for none."""
    x, y, heading = scene.pose
    angle = heading + fov / 2 - 0.5 * np.arange(2 * width + 1) * fov / width
    ends = np.stack((x + range_max * np.cos(angle), y + range_max * np.sin(angle)), axis=1)
    rays = shapely.linestrings(np.stack((np.broadcast_to([x, y], ends.shape), ends), axis=1))
    distances = np.array(
        [
            shapely.distance(shapely.intersection(other, rays), shapely.Point(x, y))
            for other in (scene.walls, *scene.bodies.values())
        ]
    )
    distances = np.where(np.isnan(distances), np.inf, distances)
    sees = np.where(np.isfinite(distances.min(axis=0)), distances.argmin(axis=0) - 1, -1)
    return list(scene.bodies), np.stack((sees[:-1:2], sees[1::2], sees[2::2]))


def check_scene(seed, width=360):
    """A scene of bodies of different colours: each blob's columns are those that shapely says, to one pixel."""
    fov, range_max = 1.5 * math.pi, 6.0
    camera = Camera(width=width, height=400, colours=COLOURS, fov=fov, fov_min=0.1, range_max=range_max, slots=40)
    scene = random_scene(seed, camera, marks=0, quad_segs=32)  # 1e-4 m from a circle, and pixels are 8 mm a metre
    obstacles = tuple(attrs.evolve(o, colour=COLOURS[i]) for i, o in enumerate(scene.obstacles))
    sim = am.Simulation(attrs.evolve(scene.sim.scenario, obstacles=obstacles))
    names, sees = shapely_columns(scene, fov, width, range_max)
    x, y, heading = scene.pose
    start = shapely.Point(x, y)
    found = blobs(sim)
    count = 0
    for i, name in enumerate(names):
        colour = COLOURS.index(next(o.colour for o in obstacles if o.name == name))
        mine = found[found[:, 0] == colour]
        # Every column that shapely sees it in from edge to edge is in a blob, every column of a blob but for those at
        # its ends is seen so by shapely.
        in_blob = np.zeros(width, dtype=bool)
        for _, left, right, *_ in mine:
            in_blob[int(left) : int(right) + 1] = True
            inner = sees[1, int(left) + 1 : int(right)]
            assert (inner == i).all(), (seed, name)
        whole = (sees == i).all(axis=0)
        assert in_blob[whole].all(), (seed, name)
        anywhere = (sees == i).any(axis=0)
        grown = anywhere | np.roll(anywhere, 1) | np.roll(anywhere, -1)
        assert grown[in_blob].all(), (seed, name)
        count += len(mine)
        # In the open, a blob is the body's whole outline.
        body = scene.bodies[name]
        corners = np.array(body.exterior.coords) - [x, y]
        to = math.atan2(body.centroid.y - y, body.centroid.x - x)
        spread = wrap_angle(np.arctan2(corners[:, 1], corners[:, 0]) - to)
        bearing = float(wrap_angle(np.array([to - heading]))[0])
        others = shapely.union_all([scene.walls, *(b for n, b in scene.bodies.items() if n != name)])
        is_open = not shapely.convex_hull(shapely.union(start, body)).intersects(others)
        inside = abs(bearing) + np.abs(spread).max() < fov / 2 and shapely.hausdorff_distance(start, body) < range_max
        if is_open and inside:
            expected = columns_of([bearing + spread.max(), bearing + spread.min()], fov, width)
            assert len(mine) == 1, (seed, name)
            assert np.abs(mine[0, 1:3] + [0, 1] - expected).max() <= 1.0, (seed, name)
            assert mine[0, 5] == pytest.approx(start.distance(body), rel=2e-2)
    return count


@pytest.mark.long
def test_blobs_of_six_random_scenes_are_the_projected_outlines():
    assert sum(check_scene(seed) for seed in range(6)) > 15


def check_crowd(seed, width=240):
    """All cameras in one room against shapely; how many things were seen or not, seen, and seen whole in the open."""
    fov, range_max = 1.5 * math.pi, 9.0
    colours = tuple(f"#{20 + i:02x}40{200 - i:02x}" for i in range(100))
    camera = Camera(width=width, height=400, colours=colours, fov=fov, fov_min=0.1, range_max=range_max, slots=150)
    crowd = random_crowd(seed, camera, colours=colours, disc=(0.05, 0.2))
    things = len(crowd.outlines)
    aside = fov / 2 - 0.5 * np.arange(2 * width + 1) * fov / width
    judged = seen = 0
    runs = {}
    for v, reading in enumerate(crowd.tables(7)):
        sees = first_met(crowd, v, crowd.poses[v, 2] + aside, range_max)
        sees = np.stack((sees[:-1:2], sees[1::2], sees[2::2]))  # at the left edge, in the middle, at the right edge
        found = reading[reading[:, 0] >= 0]
        thing, left, right = found[:, :3].T.astype(int)
        in_blob = np.zeros((things, width), dtype=bool)
        inner = np.zeros_like(in_blob)
        for t, a, b in zip(thing, left, right, strict=True):
            in_blob[t, a : b + 1] = True
            inner[t, a + 1 : b] = True
            runs.setdefault((v, int(t)), []).append((a, b))
        # Every column in which shapely sees it from edge to edge is in a blob; every column of a blob, but for those at
        # its ends, is one in whose middle shapely sees it; and those at its ends are next to one where it is seen.
        here = sees == np.arange(things)[:, None, None]
        assert in_blob[here.all(axis=1)].all(), (seed, v)
        assert here[:, 1][inner].all(), (seed, v)
        anywhere = here.any(axis=1)
        grown = anywhere.copy()
        grown[:, 1:] |= anywhere[:, :-1]
        grown[:, :-1] |= anywhere[:, 1:]
        assert grown[in_blob].all(), (seed, v)
        assert not in_blob[v].any()
        away = np.hypot(*(np.delete(crowd.places, v, axis=0) - crowd.poses[v, :2]).T)
        judged += (away < range_max).sum()
        seen += in_blob.any(axis=1).sum()
    pairs = np.array(sorted(runs))
    viewer, thing = pairs[in_the_open(crowd, *pairs.T)].T
    whole = 0
    for v, t in zip(viewer.tolist(), thing.tolist(), strict=True):
        corners = shapely.get_coordinates(crowd.outlines[t])
        to = shapely.get_coordinates(shapely.centroid(crowd.outlines[t]))
        middle = bearings_of(crowd, [v], to)[0]
        spread = wrap_angle(bearings_of(crowd, [v] * len(corners), corners) - middle)
        far = np.hypot(*(corners - crowd.poses[v, :2]).T).max()
        if abs(middle) + np.abs(spread).max() < fov / 2 and far < range_max:
            expected = columns_of([middle + spread.max(), middle + spread.min()], fov, width)
            assert len(runs[v, t]) == 1, (seed, v, t)
            assert np.abs(runs[v, t][0] + np.array([0, 1]) - expected).max() <= 1.0, (seed, v, t)
            whole += 1
    return judged, seen, whole


@pytest.mark.long
def test_blobs_in_one_crowded_room_are_the_projected_outlines():
    judged, seen, whole = check_crowd(0)
    assert judged > 2000
    assert seen > 400
    assert whole > 100


@pytest.mark.nightly
def test_a_hundred_thousand_blobs_are_seen_or_not_as_shapely_says_to_one_pixel():
    judged, seen, whole = np.sum([check_crowd(seed) for seed in range(1000, 1031)], axis=0)
    assert judged >= 100_000
    assert seen > 15_000
    assert whole > 4_000


def test_results_do_not_depend_on_replicas_or_threads():
    eye = Camera(width=90, slots=4)
    robots = [
        robot(
            name=f"r{i}",
            pose=Pose(x=1.0 + i, y=1.0 + 0.3 * i, heading=i),
            shape=Shape.circle(0.2),
            colour=COLOURS[i],
            sensors={"eye": eye},
            estimators={},
            controller=lambda readings, estimate, clock: (3.0, 2.0, 0.5, 0.0, 0.5),
        )
        for i in range(4)
    ]
    made = scenario(*robots, landmarks=[Landmark(id=i, x=0.7 * i, y=4.0, colour="blue") for i in range(1, 8)])
    sims = [am.Simulation(made, replicas=r, threads=t) for r, t in (((5,), 1), (range(6), 1), (range(6), 3))]
    for _ in range(10):
        for sim in sims:
            sim.step()
    assert len({sim.digest(5) for sim in sims}) == 1


@pytest.mark.parametrize(
    ("change", "name"),
    [({"colours": ("reddish",)}, "colours"), ({"fov_min": 2.0}, "fov_min"), ({"width": 0}, "width")],
)
def test_what_makes_no_sense_is_refused_by_name(change, name):
    with pytest.raises(ParameterError, match=name):
        Camera(**change)
