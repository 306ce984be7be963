"""The window's forms of these components: made from their fields, without a line of their own."""

import json

from amorsim.plugins.manager import default_registry
from amorsim.ui.forms.description import FieldForm, choices_of

KINDS = {
    "drive": "example-tricycle",
    "sensor": "beacon",
    "noise": "drift",
    "map_loader": "maze",
    "estimator": "compass_odometry",
    "recorder": "tally",
}


def form(kind: str) -> dict[str, FieldForm]:
    found = {one["name"]: one for one in choices_of(kind, default_registry(), spelling="file", sensor_unit="m")}
    fields = found[KINDS[kind]]["fields"]
    assert json.loads(json.dumps(fields)) == fields
    return {field["path"]: field for field in fields}


def test_numbers_have_units_and_bounds() -> None:
    fields = form("drive")
    assert {path: field["widget"]["unit"] for path, field in fields.items()} == {
        "wheel_radius": "m",
        "wheelbase": "m",
        "steering_max_deg": "deg",
        "steering_rate_deg": "deg/s",
        "rate_max_deg": "deg/s",
    }
    assert fields["wheelbase"]["is_required"]
    assert fields["wheelbase"]["widget"]["low"] == 0
    decimals = form("recorder")["decimals"]["widget"]
    assert (decimals["is_whole"], decimals["low"], decimals["high"]) == (True, 0, 9)
    assert form("noise")["std"]["widget"]["unit"] == "m"
    assert form("map_loader")["resolution"]["value"] == 0.5


def test_names_of_sensors_and_places_in_the_world_are_known_as_such() -> None:
    assert {path: field["widget"].get("refers") for path, field in form("estimator").items()} == {
        "encoder": "sensors",
        "compass": "sensors",
        "compass_std_deg": None,
        "way_variance": None,
        "heading_variance": None,
    }
    assert {path: field["widget"].get("frame") for path, field in form("sensor").items()} == {
        "x": "world",
        "y": "world",
        "range_max": None,
    }
