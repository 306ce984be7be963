"""What a class must be to be registered: each rule broken by itself, and the words that say so."""

from typing import Any, ClassVar

import attrs
import numpy as np
import pytest

from amorsim.contracts import Drive, Estimator, Joint, MapLoader, Noise, Part, Planner, Recorder, Sensor, parameter
from amorsim.core.shapes import Shape
from amorsim.plugins.checks import check_class


def frozen(cls):
    return attrs.frozen(kw_only=True)(cls)


class GoodMethods:
    def size(self, drive):
        return 1

    def sense(self, view, aim, state, draws):
        return None


@frozen
class Good(GoodMethods, Sensor):
    unit: ClassVar[str] = "m"
    range_max: float = parameter(1.0, unit="m", gt=0, help="longest")
    corners: tuple[float, ...] = parameter((), help="some")
    limit: int | None = parameter(None, help="none for no limit")


def test_a_good_class_passes():
    assert check_class("sensor", Sensor, Good) == ()


def only(problems):
    assert len(problems) == 1, problems
    return problems[0]


@pytest.mark.parametrize("thing", [3, "Good", Good(), lambda: Good])
def test_no_class_at_all(thing):
    assert "expected a subclass of amorsim.contracts.Sensor, got" in only(check_class("sensor", Sensor, thing))


def test_a_class_of_another_kind_names_its_bases():
    problem = only(check_class("noise", Noise, Good))
    assert "amorsim.contracts.Noise" in problem
    assert "GoodMethods, Sensor" in problem


def test_a_missing_method_is_named_and_a_misspelt_one_found():
    @frozen
    class Missing(Sensor):
        unit: ClassVar[str] = "m"

        def size(self, drive):
            return 1

        def sence(self, view, aim, state, draws):
            return None

    problem = only(check_class("sensor", Sensor, Missing))
    assert "expected the methods sense" in problem
    assert "'sence' meant to be sense" in problem


def test_wrong_positional_names_say_found_and_expected():
    @frozen
    class Swapped(Sensor):
        unit: ClassVar[str] = "m"

        def size(self, drive):
            return 1

        def sense(self, aim, view, state, draws):
            return None

    problem = only(check_class("sensor", Sensor, Swapped))
    assert problem == "sense: expected (view, aim, state, draws), found (aim, view, state, draws)"


def test_a_further_argument_needs_a_default():
    @frozen
    class More(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"

        def size(self, drive, extra):
            return 1

    @frozen
    class Optional(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"

        def size(self, drive, extra=1):
            return 1

    @frozen
    class Keyword(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"

        def size(self, drive, *, extra):
            return 1

    assert "size: expected (drive), found (drive, extra)" in only(check_class("sensor", Sensor, More))
    assert check_class("sensor", Sensor, Optional) == ()
    assert "size: expected (drive)" in only(check_class("sensor", Sensor, Keyword))


def test_a_method_in_the_place_of_which_there_is_a_value():
    @frozen
    class Valued(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"
        size = 3

    assert "size: expected a method, found int" in only(check_class("sensor", Sensor, Valued))


def test_a_class_without_attrs_is_refused():
    class Plain(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"

    assert "@attrs.frozen(kw_only=True)" in only(check_class("sensor", Sensor, Plain))


def test_a_subclass_that_lost_its_decorator_is_refused():
    class Derived(Good):
        extra: float = 1.0

    assert "found one without that decorator" in only(check_class("sensor", Sensor, Derived))


@pytest.mark.parametrize("slots", [True, False])
def test_a_class_whose_fields_can_be_set_is_refused(slots):
    @attrs.define(kw_only=True, slots=slots)
    class Mutable(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"
        scale: float = parameter(1.0)

    assert "expected a frozen class" in only(check_class("sensor", Sensor, Mutable))


def test_a_field_is_made_with_parameter_and_has_a_type_that_files_know():
    @frozen
    class Undescribed(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"
        scale: float = 1.0

    @frozen
    class Anything(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"
        scale: Any = parameter(1.0)

    @frozen
    class Listed(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"
        scales: list[float] = parameter(())

    assert "field 'scale': expected it to be made with amorsim.parameter" in only(
        check_class("sensor", Sensor, Undescribed)
    )
    assert "field 'scale': expected float, int" in only(check_class("sensor", Sensor, Anything))
    assert "field 'scales': expected float, int" in only(check_class("sensor", Sensor, Listed))


@pytest.mark.parametrize(
    ("kind", "field", "words"),
    [
        (float, parameter(2.0, le=1), "field 'share': its default: expected a number <= 1, got 2.0"),
        (float, parameter("a"), "field 'share': its default: expected a number, got 'a'"),
        (float, parameter(None), "field 'share': its default: expected a number, got None"),
        (str, parameter("far", choices=("a", "b")), "field 'share': its default: expected a text one of 'a', 'b', got"),
        (tuple[float, ...], parameter([1.0]), "field 'share': its default: expected a list, each a number, got"),
        (float, parameter(1.0, unit=3), "field 'share': unit: expected a text, found 3"),
        (float, parameter(1.0, help=3), "field 'share': help: expected a text, found 3"),
        (float, parameter(1.0, ge="0"), "field 'share': ge: expected a number, found '0'"),
        (float, parameter(1.0, le=True), "field 'share': le: expected a number, found True"),
        (str, parameter("a", choices="ab"), "field 'share': choices: expected a tuple or list of texts, found 'ab'"),
        (
            int,
            parameter(1, choices=(1, 2)),
            "field 'share': choices: expected a tuple or list of texts, found (1, 2)",
        ),
    ],
)
def test_what_a_field_says_of_itself_is_checked(kind, field, words):
    given = {"unit": "m", "share": field, "__annotations__": {"unit": ClassVar[str], "share": kind}}
    cls = frozen(type("Odd", (GoodMethods, Sensor), given))
    assert words in only(check_class("sensor", Sensor, cls))


@pytest.mark.parametrize(
    ("kind", "field"),
    [(str, parameter("a", choices=["a", "b"])), (int, parameter(1, ge=np.int64(0), le=np.float32(3)))],
)
def test_choices_in_a_list_and_bounds_of_numpy_are_fine(kind, field):
    given = {"unit": "m", "share": field, "__annotations__": {"unit": ClassVar[str], "share": kind}}
    assert check_class("sensor", Sensor, frozen(type("Even", (GoodMethods, Sensor), given))) == ()


def test_fields_have_a_key_of_their_own_in_files():
    @frozen
    class Twice(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"
        fov: float = parameter(1.0, unit="rad")
        fov_deg: float = parameter(57.0)

    @frozen
    class Private(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"
        _share: float = parameter(1.0)

    @frozen
    class Whole(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"
        fov: float = parameter(1.0, unit="rad")
        half: float = parameter(attrs.Factory(lambda self: self.fov / 2.0, takes_self=True), unit="rad")

    assert "fields 'fov' and 'fov_deg': both have the key 'fov_deg' in files" in only(
        check_class("sensor", Sensor, Twice)
    )
    assert "field '_share': expected a name that begins with a letter" in only(check_class("sensor", Sensor, Private))
    assert check_class("sensor", Sensor, Whole) == ()


def test_fields_are_keywords_and_leave_the_names_that_stand_beside_them_alone():
    @attrs.frozen
    class Positional(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"
        scale: float = parameter(1.0)

    @frozen
    class Clashing(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"
        latency: float = parameter(1.0)

    assert "expected a keyword-only field" in only(check_class("sensor", Sensor, Positional))
    assert "field 'latency': the name has a meaning of its own" in only(check_class("sensor", Sensor, Clashing))


def test_constants_of_the_class():
    @frozen
    class NoUnit(GoodMethods, Sensor):
        pass

    @frozen
    class BadExtensions(MapLoader):
        extensions: ClassVar = ("MAP",)

        def load(self, path):
            return None

    assert "unit: expected a text" in only(check_class("sensor", Sensor, NoUnit))
    assert "expected lower case with the dot" in only(check_class("map_loader", MapLoader, BadExtensions))


def test_a_drive_needs_joints_and_channels():
    class Methods:
        def advance(self, joints, rates, command, dt, state, draws): ...
        def twist(self, before, after): ...
        def command_for(self, twist, joints): ...
        def rolling_radius(self): ...

    @frozen
    class Bare(Methods, Drive):
        channels: ClassVar = ["left"]

    @frozen
    class Whole(Methods, Drive):
        joints: ClassVar = (Joint(name="wheel"),)
        channels: ClassVar = ("wheel",)

    problems = check_class("drive", Drive, Bare)
    assert [problem.split(":")[0] for problem in problems] == ["channels", "joints"]
    assert check_class("drive", Drive, Whole) == ()


def test_a_drive_that_brings_parts_says_where_they_are_and_how_far_they_go():
    class Cart(Drive):
        joints: ClassVar[tuple[Joint, ...]] = (Joint(name="left"),)
        channels: ClassVar[tuple[str, ...]] = ("left",)

        def advance(self, joints, rates, command, dt, state, draws):
            return joints, rates

        def twist(self, before, after):
            return before

        def command_for(self, twist, joints):
            return twist

        def rolling_radius(self):
            return None

    boom = Part("boom", Shape.circle(0.1))

    @frozen
    class Named(Cart):
        parts = ("boom",)

    @frozen
    class Lost(Cart):
        parts = (boom,)

    @frozen
    class Unbound(Cart):
        @property
        def parts(self):
            return (boom,)

        def part_poses(self, joints):
            return joints

    @frozen
    class Whole(Unbound):
        def part_travel(self, before, after):
            return before

    assert "parts: expected a tuple of Part, found ('boom',)" in only(check_class("drive", Drive, Named))
    assert "expected part_poses and part_travel to be overridden" in only(check_class("drive", Drive, Lost))
    assert "expected part_travel to be overridden" in only(check_class("drive", Drive, Unbound))
    assert check_class("drive", Drive, Whole) == ()


def test_a_noise_does_something():
    @frozen
    class Nothing(Noise):
        pass

    @frozen
    class Bends(Noise):
        def aim(self, aim, elapsed, state, draws):
            return aim

    assert "expected aim, corrupt, slide or delay to be overridden" in only(check_class("noise", Noise, Nothing))
    assert check_class("noise", Noise, Bends) == ()


def test_a_recorder_may_keep_its_files():
    @attrs.define(kw_only=True)
    class Log(Recorder):
        every: int = parameter(1, ge=1)
        _file: Any = attrs.field(init=False, default=None)

        def open(self, run, frames): ...
        def write(self, frames, events): ...
        def close(self): ...

    assert check_class("recorder", Recorder, Log) == ()


def test_all_that_is_wrong_is_said():
    @attrs.define
    class Awful(Sensor):
        def size(self):
            return 1

        def sense(self, view):
            return None

    problems = check_class("sensor", Sensor, Awful)
    assert len(problems) == 3  # two signatures and the unit


def test_points_are_in_a_frame_and_names_refer_to_something_that_is_known():
    @frozen
    class Lost(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"
        x: float = parameter(0.0, frame="wrld", help="somewhere")
        of: str = parameter("", refers="sensor", help="another")

    frame, refers = check_class("sensor", Sensor, Lost)
    assert frame == "field 'x': frame: expected 'world' or 'body', found 'wrld'. Did you mean 'world'?"
    assert refers.startswith("field 'of': refers: expected 'sensors' or")


def test_a_field_that_is_a_component_names_its_kind_and_its_contract():
    @frozen
    class Owner(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"
        way: Planner = parameter(component="planner")
        next_one: Estimator = parameter(component="estimator")
        spare: Planner | None = parameter(None, component="planner")

    assert check_class("sensor", Sensor, Owner) == ()

    @frozen
    class Unknown(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"
        way: Planner = parameter(component="way")

    expected = "component: expected planner or controller or estimator or motion or task, found 'way'"
    assert expected in only(check_class("sensor", Sensor, Unknown))

    @frozen
    class Wrong(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"
        way: Planner = parameter(component="controller")

    assert "expected Controller or a class of it, or one of these | None, found" in only(
        check_class("sensor", Sensor, Wrong)
    )

    @frozen
    class Either(GoodMethods, Sensor):
        unit: ClassVar[str] = "m"
        way: Planner | Estimator | None = parameter(None, component="planner")

    assert "expected Planner or a class of it" in only(check_class("sensor", Sensor, Either))
