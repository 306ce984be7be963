"""Each field of each registered component, fed what it does not take: a fault with path, value and expectation.

Never another exception, whatever the value; and the same for everything else that may stand in a document.
"""

import copy
import datetime
import math
import types
import typing

import attrs
import pytest
from hypothesis import HealthCheck, example, given
from hypothesis import strategies as st

from amorsim.core.errors import ScenarioError
from amorsim.core.parameters import Parameter
from amorsim.plugins.manager import make_registry
from amorsim.scenario.files.models import LOOKS
from amorsim.scenario.reading.fields import file_fields
from amorsim.scenario.reading.read import loads
from amorsim.scenario.spec import Landmark, Light, MountedSensor, Obstacle, Pose, Recording, Robot
from tests.examples import settings
from tests.some_cases import one_in

REGISTRY = make_registry(entry_points=(), disabled="")
HUGE = 10**400
_MAPS = {
    "wld": "room.wld",
    "bmp": "room.bmp",
    "stage": "room.world",
    "mobilesim": "room.map",
    "khepera": "khepera.world",
    "ros": "room.yaml",
    "movingai": "grid.map",
    "geojson": "room.geojson",
    "svg": "room.svg",
    "dxf": "room.dxf",
    "maz": "room.maz",
}
EXAMPLES = 250

BASE = {
    "format": 1,
    "world": {"map": "room.wld", "resolution": 0.1},
    "simulation": {},
    "recording": {},
    "robots": [{"name": "rover", "model": "pioneer2dx"}],
    "obstacles": [{"name": "box", "shape": {"circle": 0.1}, "pose": {"x": 3.0, "y": 2.0}}],
    "landmarks": [{"id": 1}],
    "lights": [{}],
}


def options_of(kind):
    """The types that a field admits, None left out."""
    if isinstance(kind, types.UnionType) or typing.get_origin(kind) is typing.Union:
        return [option for option in typing.get_args(kind) if option is not types.NoneType]
    return [kind]


def good_value(parameter: Parameter):
    """A value within bounds, as files have it."""
    (kind, *_) = options_of(parameter.type)
    if parameter.component:
        return {"use": {"planner": "a_star", "controller": "dwa", "task": "point_goal"}[parameter.component]}
    if parameter.choices:
        return parameter.choices[0]
    if parameter.file:
        return "track.csv"
    if kind is str:
        return "encoder"
    if kind is bool:
        return True
    if typing.get_origin(kind) is tuple:
        item = typing.get_args(kind)[0]
        if typing.get_origin(item) is tuple:
            return [[float(i + 1) for i in range(len(typing.get_args(item)))]]
        return (
            [{}]
            if attrs.has(item)
            else [1.0] * max(len(typing.get_args(kind)) - (Ellipsis in typing.get_args(kind)), 1)
        )
    low = next((bound for bound in (parameter.gt, parameter.ge) if bound is not None), 0.0)
    high = next((bound for bound in (parameter.lt, parameter.le) if bound is not None), low + 2.0)
    value = (low + min(high, low + 2.0)) / 2
    return math.ceil(value) if kind is int else math.degrees(value) if parameter.is_angle else value


def bad_values(parameter: Parameter):
    """Values of a wrong type, not finite, or out of bounds, as files have them."""
    kinds = options_of(parameter.type)
    bad = [datetime.date(2026, 1, 1), {"no": "table"}, HUGE, -HUGE, math.nan, math.inf, -math.inf]
    if str not in kinds:
        bad += ["0.1", "", "nan"]
    if bool not in kinds:
        bad += [True, False]
    if float not in kinds:
        bad += [1.5]
        if int not in kinds:
            bad += [3]
    if not any(typing.get_origin(kind) is tuple for kind in kinds):
        bad += [[], [1.0]]
    else:
        bad += [[1.0, [2.0]], [math.nan], [True], [None]]
        if tuple[str, ...] not in kinds:
            bad += [["x"]]
    if parameter.choices:
        bad += ["no such choice"]
    turn = math.degrees if parameter.is_angle else lambda bound: bound
    if {float, int} & set(kinds):
        if parameter.gt is not None:
            bad += [turn(parameter.gt), turn(parameter.gt) - 1]
        if parameter.ge is not None:
            bad += [turn(parameter.ge) - 1]
        if parameter.lt is not None:
            bad += [turn(parameter.lt), turn(parameter.lt) + 1]
        if parameter.le is not None:
            bad += [turn(parameter.le) + (1 if parameter.le < 1e15 else parameter.le)]
    return bad


def place_of(kind, name):
    """A document with a sound component in it, the path of the component, and the unit around it."""
    document = copy.deepcopy(BASE)
    robot = document["robots"][0]
    component = {"use": name}
    if kind == "drive":
        robot["drive"] = component
        return document, ("robots", 0, "drive"), ""
    if kind == "sensor":
        robot["sensors"] = {"extra": component}
        return document, ("robots", 0, "sensors", "extra"), ""
    if kind == "noise" and REGISTRY.get("noise", name).for_ground:
        robot["ground"] = [component]
        return document, ("robots", 0, "ground", 0), "m"
    if kind == "noise":
        robot["sensors"] = {"compass": {"noise": [component]}}
        return document, ("robots", 0, "sensors", "compass", "noise", 0), "rad"
    if kind == "estimator":
        robot["estimators"] = {"extra": component}
        return document, ("robots", 0, "estimators", "extra"), ""
    if kind == "controller":
        robot["controller"] = component
        return document, ("robots", 0, "controller"), ""
    if kind == "map_loader":
        document["world"] = {"map": _MAPS[name], "use": name}
        return document, ("world",), ""
    if kind == "world_generator":
        document["world"] = {"map": {"generate": name}}
        return document, ("world", "map"), ""
    if kind == "motion":
        document["obstacles"][0]["motion"] = component
        return document, ("obstacles", 0, "motion"), ""
    if kind == "task":
        document["task"] = component
        return document, ("task",), ""
    raise AssertionError(f"a kind with no place in a document: {kind}")


def at(document, path):
    for part in path:
        document = document[part]
    return document


def cases():
    for entry in REGISTRY.entries():
        if entry.kind in ("robot", "device", "scenario", "planner", "metric", "recorder", "scenario_loader"):
            continue
        document, path, unit = place_of(entry.kind, entry.name)
        fields = file_fields(REGISTRY.get(entry.kind, entry.name), unit)
        for key, parameter in fields.items():
            if parameter.is_required:
                at(document, path)[key] = good_value(parameter)
        for key, parameter in fields.items():
            yield f"{entry.kind}/{entry.name}/{key}", document, path, key, parameter
    parts = [
        ("simulation", ("simulation",), file_fields_of_simulation()),
        ("recording", ("recording",), file_fields(Recording)),
        ("pose", ("obstacles", 0, "pose"), file_fields(Pose)),
        ("landmark", ("landmarks", 0), file_fields(Landmark)),
        ("light", ("lights", 0), file_fields(Light)),
        ("robot", ("robots", 0), file_fields(Robot, names=LOOKS)),
        ("obstacle", ("obstacles", 0), file_fields(Obstacle, names=LOOKS)),
    ]
    for name, path, fields in parts:
        for key, parameter in fields.items():
            yield f"{name}/{key}", BASE, path, key, parameter
    document, path, _ = place_of("sensor", "gyro")
    for key, parameter in file_fields(MountedSensor, names=("rate", "latency")).items():
        yield f"mounted/{key}", document, path, key, parameter


def file_fields_of_simulation():
    from amorsim.scenario.spec import Scenario

    return file_fields(Scenario, names=("dt", "duration", "seed"))


CASES = list(cases())


@pytest.fixture(scope="module")
def place(folder):
    from PIL import Image

    Image.new("1", (40, 30), 1).save(folder / "room.bmp")
    (folder / "room.world").write_text("floorplan( size [4 3 1] )")
    (folder / "room.map").write_text("2D-Map\nLINES\n0 0 4000 0\n4000 3000 0 3000\nDATA\n")
    words = "0," * 8000
    (folder / "khepera.world").write_text(f"0,0\nbrick\n0\nlamp\n0\ncork\n0\n{words}\n")
    Image.new("L", (40, 30), 255).save(folder / "room.pgm")
    (folder / "room.yaml").write_text(
        "image: room.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n"
    )
    (folder / "grid.map").write_text("type octile\nheight 3\nwidth 4\nmap\n....\n.@..\n....\n")
    (folder / "room.geojson").write_text('{"type": "LineString", "coordinates": [[0, 0], [4, 0], [4, 3]]}')
    (folder / "room.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="4000mm" height="3000mm"><path d="M0 0H15000V9000H0Z"/></svg>'
    )
    line = "0\nLINE\n8\n0\n10\n0\n20\n0\n11\n{}\n21\n{}\n"
    lines = line.format(4000, 0) + line.format(0, 3000)
    (folder / "room.dxf").write_text(f"0\nSECTION\n2\nENTITIES\n{lines}0\nENDSEC\n0\nEOF\n")
    (folder / "room.maz").write_text("._._.\n|   |\n._._.\n")
    (folder / "track.csv").write_text("time,x,y\n0,1,1\n1,2,1\n")
    return folder


def groups():
    """The cases of each component or part of a document, by its name."""
    found = {}
    for name, document, path, key, parameter in CASES:
        _, _, fields = found.setdefault(name.rpartition("/")[0], (document, path, {}))
        fields[key] = parameter
    return found


GROUPS = groups()


@pytest.mark.parametrize("name", one_in(4, GROUPS))
def test_a_field_fed_wrongly_gets_a_fault_with_path_value_and_expectation(place, name):
    """Each alone with one value; then all fields of a component at once with all values: all faults are reported.

    What only the whole component can see is reported once every field is sound by itself: such a value is tried
    alone too.
    """
    document, path, fields = GROUPS[name]
    loads(document, place, registry=REGISTRY)  # the sound document is one

    def faults(wrong):
        broken = copy.deepcopy(document)
        at(broken, path).update(wrong)
        with pytest.raises(ScenarioError) as caught:
            loads(broken, place, registry=REGISTRY)
        return caught.value.faults

    bad = {key: bad_values(parameter) for key, parameter in fields.items()}
    for key, values in bad.items():
        assert_reported(faults({key: values[0]}), (*path, key), values[0])
    for n in range(max(len(values) for values in bad.values())):
        wrong = {key: values[n] for key, values in bad.items() if n < len(values)}
        together = faults(wrong)
        for key, value in wrong.items():
            reported = of(together, (*path, key))
            assert_reported(reported or faults({key: value}), (*path, key), value)


def of(faults, path):
    where = ".".join(str(part) for part in path)
    return [fault for fault in faults if fault.path == where or fault.path.startswith(f"{where}.")]


def assert_reported(faults, path, value):
    found = of(faults, path)
    assert found, (path, value, faults)
    for fault in found:
        assert "expected" in fault.message or "unknown key" in fault.message, (value, fault)
    if not isinstance(value, (list, dict)) and abs(value if isinstance(value, int) else 0) != HUGE:
        assert f"got {value!r}" in found[0].message, (value, found)


def test_faults_of_recorders_are_reported_beside_those_of_what_is_recorded(place):
    broken = copy.deepcopy(BASE) | {"recording": {"picture": 3, "also": 4}}
    assert len(of(faults_of(broken, place), ("recording", "picture"))) == 1
    assert len(of(faults_of(broken, place), ("recording", "also"))) == 1


@pytest.mark.parametrize(
    ("document", "path", "key", "parameter"), [case[1:] for case in CASES], ids=[c[0] for c in CASES]
)
def test_a_required_field_left_out_is_missed(place, document, path, key, parameter):
    if not parameter.is_required:
        return
    broken = copy.deepcopy(document)
    del at(broken, path)[key]
    if path[-1] == "drive":  # the model has all of a drive's fields
        broken["robots"][0] = {**broken["robots"][0], "shape": {"circle": 0.2}}
        del broken["robots"][0]["model"]
    with pytest.raises(ScenarioError) as caught:
        loads(broken, place, registry=REGISTRY)
    where = ".".join(str(part) for part in (*path, key))
    (message,) = [fault.message for fault in caught.value.faults if fault.path == where]
    assert message.startswith("missing; expected")


ANYTHING = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from([HUGE, datetime.date(2026, 1, 1), datetime.time(1, 2)])
    | st.sampled_from(["laser", "wander", "gaussian", "mine.py:f", "room.wld", "pioneer2dx", "none", "x.toml", "\0"]),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(
                ["use", "name", "x", "noise", "mount", "map", "scale", "add", "normal", "circle", "std", "heading_deg"]
            )
            | st.text(max_size=4),
            inner,
            max_size=3,
        )
    ),
    max_leaves=8,
)


def places(value, path=()):
    yield path
    if isinstance(value, dict):
        for key, item in value.items():
            yield from places(item, (*path, key))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from places(item, (*path, index))


RICH = copy.deepcopy(BASE) | {
    "robots": [
        {
            "name": "rover",
            "model": "pioneer2dx",
            "pose": {"x": 1.0, "y": 1.0, "heading_deg": 3.0},
            "shape": {"polygon": [[0.0, 0.0], [0.2, 0.0], [0.0, 0.2]]},
            "controller": {"use": "goto", "x": 1.0, "y": 2.0},
            "ground": [{"use": "diffusion", "variance_per_length": 1e-6}],
            "sensors": {
                "laser": {"mount": {"x": 1.0}, "noise": [{"use": "gaussian", "name": "g", "std": 0.1}]},
                "gyro": False,
                "ring": {"use": "sonar", "elements": [{"x": 0.1}], "rate": 3.0},
            },
            "estimators": {"other": {"use": "dead_reckoning"}},
            "errors": {
                "drive": {"track": {"scale": {"normal": [1.0, 0.1]}, "per": "study"}, "wheel_radius_left": 0.08},
                "sensors": {"laser": {"mount": {"heading_deg": {"add": 1.0}}}},
                "pose": {"x": 0.1},
            },
            "knowledge": {"map": "room.wld", "landmarks": [[1.0, 2.0]]},
            "on_collision": "end",
        }
    ],
}


def faults_of(document, folder, *overrides):
    """The faults of a document, none if it is sound; whatever else is raised is a failure."""
    try:
        loads(document, folder, overrides, registry=REGISTRY)
    except ScenarioError as error:
        return error.faults or pytest.fail("an error without a fault")
    return ()


PLACES = [path for path in places(RICH) if path]


@settings(max_examples=EXAMPLES, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(changes=st.lists(st.tuples(st.sampled_from(PLACES), ANYTHING), min_size=1, max_size=3))
@example(changes=[(("robots", 0, "sensors", "laser", "noise"), [{"use": "gaussian", "name": HUGE}])])
@example(changes=[(("robots", 0, "model"), "x\0.toml")])
@example(changes=[(("world", "map"), "x\0")])
@example(changes=[(("robots", 0, "controller"), {"use": "\0.py:f"})])
@example(changes=[(("robots", 0, "errors"), {"sensors": {"laser": 3}})])
@example(changes=[(("robots", 0, "errors"), {"": {"_deg": 3}})])
def test_whatever_stands_anywhere_a_document_is_read_or_its_faults_are_reported(place, changes):
    document = copy.deepcopy(RICH)
    for path, value in changes:
        try:
            holder = at(document, path[:-1])
            if not (isinstance(holder, dict) and isinstance(path[-1], int)):  # keys of tables are texts
                holder[path[-1]] = value
        except (KeyError, IndexError, TypeError):  # an earlier change took the place away
            continue
    for fault in faults_of(document, place):
        assert fault.message
        assert len(str(fault)) < 2000


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    parts=st.lists(
        st.sampled_from(["robots", "0", "rover", "sensors", "laser", "noise", "g", "x", "errors", "drive", "use"]),
        min_size=1,
    ),
    value=st.sampled_from(["1", "x", "[1, 2]", "{ a = 1 }", "nan", "", "1\n2", "'", "1979-01-01", "true"]),
)
def test_whatever_is_set_is_read_or_its_faults_are_reported(place, parts, value):
    for fault in faults_of(RICH, place, f"{'.'.join(parts)}={value}"):
        assert fault.message
