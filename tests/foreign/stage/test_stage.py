"""Scenarios from Stage worlds: robots with their drives and sensors, obstacles, landmarks, zones, and remarks."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest

import amorsim as am
from amorsim.core.errors import ScenarioError
from amorsim.drives.ackermann import Ackermann
from amorsim.drives.differential import Differential
from amorsim.drives.mecanum import Mecanum
from amorsim.foreign.stage.loader import Stage
from amorsim.testing import check_component

ROOM = "floorplan( size [8 6 1] )\n"


def faults(path) -> list[str]:
    with pytest.raises(ScenarioError) as caught:
        am.load(path)
    return [f"{fault.line}: {fault.message}" for fault in caught.value.faults]


def test_a_robot_of_the_real_world(real) -> None:
    scenario = am.load(real("simple.world"))
    first, second = scenario.robots
    assert (first.name, second.name) == ("r0", "r1")
    assert (first.pose.x, first.pose.y) == (-6.946, -6.947)
    assert first.pose.heading == pytest.approx(math.pi / 4)
    assert scenario.duration == 3600.0
    outline = first.shape.outline
    # 0.44 m x 0.38 m, its middle 0.04 m behind the base point: Stage scales the block to the size.
    assert outline.min(axis=0) == pytest.approx([-0.26, -0.19])
    assert outline.max(axis=0) == pytest.approx([0.18, 0.19])
    assert len(outline) == 8
    sonar, laser = first.sensors["sonar"].sensor, first.sensors["laser"].sensor
    assert len(sonar.elements) == 16
    assert (sonar.elements[0].x, sonar.elements[0].y) == (0.075, 0.13)
    assert sonar.half_angle == pytest.approx(math.radians(7.5))
    assert (laser.beams, laser.range_max) == (180, 8.0)
    assert laser.fov == pytest.approx(math.pi)
    assert type(first.controller).__name__ == "Wander"
    # At most 0.5 m/s, and 0.5 m/s2.
    drive = first.drive
    assert isinstance(drive, Differential)
    assert drive.rate_max * drive.wheel_radius_left == pytest.approx(0.5)
    assert drive.acceleration_max * drive.wheel_radius_left == pytest.approx(0.5)
    assert first.fiducial == 1
    assert first.colour == "#ff0000"


@pytest.mark.long
def test_the_real_benchmarks_have_their_robots(real) -> None:
    cave = am.load(real("benchmark/cave.world"))
    assert len(cave.robots) == 100
    hospital = am.load(real("benchmark/hospital.world"))
    assert len(hospital.robots) == 1000
    assert hospital.robots[17].name == "r17"
    assert (hospital.robots[5].pose.x, hospital.robots[5].pose.y) == (-58.75, -15.0)
    sonar = hospital.robots[5].sensors["sonar"].sensor
    assert len(sonar.elements) == 12
    assert sonar.range_max == 2.0


def test_the_models_of_the_real_includes_load(real) -> None:
    for name in ("pioneer3dx", "pioneer3at", "amigobot", "fancypioneer2dx", "pioneer2dx_front_sonar"):
        path = real("pioneer.inc")
        document = Stage().read(_world(path, f'include "pioneer.inc"\n{name}( )'))
        assert document.tables["robots"][0]["name"] == name
    tables = Stage().read(_world(path, 'include "irobot.inc"\ncreate()')).tables
    assert len(tables["robots"][0]["sensors"]["bumper"]["segments"]) == 2
    tables = Stage().read(_world(path, 'include "objects.inc"\nvisionbeacon() red_puck(pose [2 0 0 0])')).tables
    assert [each["name"] for each in tables["obstacles"]] == ["visionbeacon", "red_puck"]


def _world(beside, text: str):
    """A world in the test's own folder that includes files by their absolute paths."""
    import tempfile
    from pathlib import Path

    path = Path(tempfile.mkdtemp()) / "lab.world"
    path.write_text(text.replace('include "', f'include "{beside.parent}/'))
    return path


def test_drives(write) -> None:
    scenario = am.load(
        write(
            ROOM
            + 'position( name "d" pose [-3 0 0 0] )\n'
            + 'position( name "o" pose [-1 0 0 0] drive "omni" velocity_bounds [-1 1 -2 2 0 0 -90 90] )\n'
            + 'position( name "c" pose [2 0 0 0] drive "car" wheelbase 0.3 velocity_bounds [-1 1 0 0 0 0 -30 30] )\n'
        )
    )
    diff, omni, car = (robot.drive for robot in scenario.robots)
    assert isinstance(diff, Differential)
    assert diff.track == pytest.approx(0.4 * 0.33 / 0.38)
    assert isinstance(omni, Mecanum)
    assert omni.rate_max * omni.wheel_radius_front_left == pytest.approx(2.0)
    assert isinstance(car, Ackermann)
    assert car.wheelbase == 0.3
    assert car.steering_max == pytest.approx(math.radians(30))


def test_sensors_of_every_kind(write) -> None:
    scenario = am.load(
        write(
            ROOM + "position( pose [0 0 0 0]\n"
            "  ranger( pose [0.1 0 0 90]\n"
            "    sensor( pose [0.1 0 0 0] range [0.1 4] fov 20 )\n"
            "    sensor( pose [0 0.1 0 0] range [0.1 4] fov 20 )\n"
            "    sensor( range [0 3] fov 90 samples 31 noise [0.01 0.02 1] ) )\n"
            "  ranger( update_interval 400 sensor( range [0 1] fov 5 ) )\n"
            "  fiducial( range_max 6 range_max_id 2 fov 90 pose [0.2 0 0 0] )\n"
            "  bumper( bcount 1 bpose[0] [0.2 0 0 0] blength 0.4 )\n"
            "  blobfinder() gripper() gripper()\n"
            ")\n"
        )
    )
    sensors = scenario.robots[0].sensors
    assert list(sensors) == ["encoder", "laser", "sonar", "sonar_2", "finder", "bumper"]
    first, second = sensors["sonar"].sensor.elements
    # At (0.1, 0) on the robot, looking left: its own sensors ahead and to the left are at its left and back.
    assert (first.x, first.y) == pytest.approx((0.1, 0.1))
    assert (second.x, second.y) == pytest.approx((0.0, 0.0))
    assert first.heading == pytest.approx(math.pi / 2)
    laser = sensors["laser"]
    assert laser.sensor.beams == 31
    aim, white = (element.noise for element in laser.noise)
    assert aim.std == pytest.approx(math.radians(1 / math.sqrt(3)))
    assert (white.std, white.proportional) == pytest.approx((0.01, 0.02 / math.sqrt(3)))
    assert sensors["sonar_2"].rate == 2.5
    assert sensors["finder"].sensor.range_max_id == 2.0
    (segment,) = sensors["bumper"].sensor.segments
    assert (segment.start, segment.end) == pytest.approx((-math.pi / 4, math.pi / 4))
    remarks = "\n".join(scenario.remarks)
    assert remarks.count("a gripper is left out") == 1
    assert "a blobfinder is left out" in remarks
    assert "robots without a ctrl stand still" in remarks


def test_rangers_as_older_stages_spell_them(write) -> None:
    scenario = am.load(
        write(
            ROOM + "position( pose [0 0 45]\n laser( range_max 4 fov 90 samples 91 )\n"
            " ranger( scount 2 spose[0] [0.1 0 0] spose[1] [0 0.1 90] sview [0.1 3 30] ) )"
        )
    )
    robot = scenario.robots[0]
    assert robot.pose.heading == pytest.approx(math.pi / 4)
    assert (robot.sensors["laser"].sensor.beams, robot.sensors["laser"].sensor.range_max) == (91, 4.0)
    sonar = robot.sensors["sonar"].sensor
    assert sonar.elements[1].heading == pytest.approx(math.pi / 2)
    assert (sonar.range_min, sonar.range_max) == (0.1, 3.0)
    assert sum("three numbers" in remark for remark in scenario.remarks) == 1


def test_what_stage_gets_wrong_is_an_option(write) -> None:
    path = write(ROOM + "position( ranger( sensor( fov 30 noise [0.01 0 0] ) ) )")
    plain = am.load(path).robots[0].sensors["sonar"]
    assert plain.noise[0].noise.std == 0.01
    assert plain.sensor.half_angle == pytest.approx(math.radians(15))
    same = am.load(path, ["loader.noise_as_variance=true", "loader.sonar_as_ray=true"]).robots[0].sensors["sonar"]
    assert same.noise[0].noise.std == pytest.approx(0.1)
    assert same.sensor.half_angle == 0.0


def test_options_are_checked(write) -> None:
    path = write(ROOM + "position()")
    with pytest.raises(ScenarioError, match=r"unknown key.* Did you mean 'sonar_as_ray'"):
        am.load(path, ["loader.sonar_as_rays=true"])
    with pytest.raises(ScenarioError, match=r"loader\.sonar_as_ray: expected true or false"):
        am.load(path, ["loader.sonar_as_ray=1"])


def test_odometry_errs_as_the_world_says(write) -> None:
    scenario = am.load(write(ROOM + 'position( localization "odom" odom_error [0.04 0 0 0.1] )'))
    errors = scenario.robots[0].errors
    ahead, turn = errors["sensors.encoder.counts_per_revolution"].scale, errors["drive.track"].scale
    assert (str(ahead), str(turn)) == ("uniform(0.98, 1.02)", "uniform(0.95, 1.05)")
    assert not am.load(write(ROOM + 'position( localization "gps" odom_error [0.04 0 0 0.1] )')).robots[0].errors


def test_models_become_obstacles_landmarks_and_zones(write) -> None:
    scenario = am.load(
        write(
            ROOM
            + 'model( name "box" size [1 0.5 0.7] pose [2 1 0 90] color "gray50" )\n'
            + "model( pose [-2 0 0 0] size [1 1 1] fiducial_return 7\n"
            + "  model( pose [1 0 0 0] size [0.2 0.2 1] ) )\n"
            + "model( fiducial_return 3 obstacle_return 0 ranger_return -1 pose [3 2 0 0] size [0.2 0.2 0.2] )\n"
            + 'model( name "mud" obstacle_return 0 ranger_return -1 pose [-2 -2 0 0] size [2 1 0] )\n'
            + "position()\n"
        )
    )
    box, marked, child = scenario.obstacles
    assert (box.name, box.colour, box.height) == ("box", "#7f7f7f", 0.7)
    assert box.shape.outline.max(axis=0) == pytest.approx([0.5, 0.25])
    assert (box.pose.x, box.pose.y, box.pose.heading) == pytest.approx((2, 1, math.pi / 2))
    assert marked.fiducial == 7
    assert (child.pose.x, child.pose.y) == (-1.0, 0.0)
    (mark,) = scenario.landmarks
    assert (mark.id, mark.x, mark.y) == (3, 3.0, 2.0)
    (zone,) = scenario.zones
    assert zone.name == "mud"
    assert zone.shape.area == pytest.approx(2.0)


def test_blocks_fill_the_size_and_bodies_of_many_blocks_are_one(write) -> None:
    scenario = am.load(
        write(
            ROOM + "position( size [0.6 0.4 0.2] origin [0.1 0 0 0]\n"
            " block( points 4 point[0] [0 0] point[1] [2 0] point[2] [2 1] point[3] [0 1] )\n"
            " block( points 3 point[0] [2 0] point[1] [3 0.5] point[2] [2 1] ) )\n"
        )
    )
    outline = scenario.robots[0].shape.outline
    assert outline.min(axis=0) == pytest.approx([-0.2, -0.2])
    assert outline.max(axis=0) == pytest.approx([0.4, 0.2])
    assert len(outline) == 5


def test_names_are_made_to_fit_and_to_differ(write) -> None:
    text = ROOM + "".join(f'position( name "{name}" pose [{x} 0 0 0] )\n' for x, name in enumerate(("a b", "a:b", "1")))
    names = [robot.name for robot in am.load(write(text + "position( pose [-1 0 0 0] )")).robots]
    assert names == ["a_b", "a_b_2", "n1", "position"]


def test_a_world_without_robots_gets_one(write) -> None:
    scenario = am.load(write(ROOM))
    (robot,) = scenario.robots
    assert robot.model == "pioneer2dx"
    assert "a Pioneer 2DX wanders in it" in scenario.remarks[-1]


def test_all_faults_are_reported_with_their_lines(write) -> None:
    path = write(
        ROOM
        + "position( size [x 1]\n"
        + " pose [1e30 0 0 0]\n"
        + ' drive "legs"\n'
        + " ranger( sensor( range [3 1] fov 400 samples 1e7 ) )\n"
        + " block( points 4 point[0] [0 0] ) )\n"
    )
    found = faults(path)
    expected = {
        "2: size: expected a number of at most 1e+09, got 'x'",
        "3: pose: expected a number of at most 1e+09, got '1e30'",
        "4: drive: expected diff, omni or car, got 'legs'",
        "5: range: expected [MIN MAX], 0 <= MIN < MAX, got [3 1]",
        "5: fov: expected 0 to 360 degrees, got 400",
        "5: samples: expected a whole number from 0 to 100000, got 1e+07",
        "6: the block has 4 points, and no point[1]",
    }
    assert expected <= set(found)
    assert len(found) == len(set(found))


def test_faults_of_the_scenario_name_the_model_and_its_line(write) -> None:
    path = write(ROOM + '\nposition( name "a" )\nposition( name "b" pose [0.1 0 0 0] )\n')
    with pytest.raises(ScenarioError) as caught:
        am.load(path)
    assert str(caught.value).endswith("lab.world:4: robots.b.pose: overlaps 'a'; expected room between them")


def test_keys_that_are_left_out_are_remarked_on_once(write) -> None:
    scenario = am.load(write(ROOM + "speedup 2\nfoo 1\nposition( bar 1 gui_nose 1 )\nposition( bar 2 pose [1 0 0 0] )"))
    text = "\n".join(scenario.remarks)
    assert text.count("bar of position is left out") == 1
    assert text.count("foo of the world is left out") == 1
    assert "of Stage's window, pace and power, and left out: speedup, gui_nose" in text


def test_settings_change_one_robot_alone(write) -> None:
    path = write(ROOM + 'position( name "a" )\nposition( name "b" pose [1 0 0 0] )\n')
    one, other = am.load(path, ["robots.b.drive.track=0.5", "simulation.dt=0.05"]).robots
    assert (one.drive.track, other.drive.track) == (pytest.approx(0.4 * 0.33 / 0.38), 0.5)


@pytest.mark.long
def test_a_thousand_models_are_read_in_two_seconds(write) -> None:
    sonar = "define s sensor( range [0 5] fov 15 )\ndefine ring ranger(" + "s( pose [0.1 0 0 0] ) " * 16 + ")\n"
    robots = "".join(f'bot( name "r{i}" pose [{i % 40} {i // 40} 0 {i}] )\n' for i in range(500))
    boxes = "".join(f"box( pose [{i % 40} {20 + i // 40} 0 {i}] )\n" for i in range(500))
    defines = "define bot position( ring() )\ndefine box model( size [0.4 0.3 0.5] )\n"
    path = write(f"floorplan( size [100 100 1] )\n{sonar}{defines}{robots}{boxes}")
    am.load(path)
    begin = time.process_time()
    scenario = am.load(path)
    took = time.process_time() - begin
    assert (len(scenario.robots), len(scenario.obstacles)) == (500, 500)
    assert took < 2.0, f"{took:.2f} s of processor time"


@pytest.mark.long
def test_thousands_of_models_upon_one_another_take_no_longer(write) -> None:
    path = write(ROOM + "position( pose [-2 0 0 0] )\n" + "model( size [0.4 0.3 0.5] pose [1 1 0 0] )\n" * 4000)
    begin = time.process_time()
    scenario = am.load(path)
    assert not scenario.obstacles
    assert time.process_time() - begin < 8.0


def test_the_loader_keeps_its_contract(real) -> None:
    check_component(Stage, path=real("simple.world"))


def test_a_world_is_a_document_that_is_saved_as_toml(real, tmp_path) -> None:
    document = am.open_document(real("simple.world"))
    assert not document.faults()
    document.save(tmp_path / "cave.toml", copy=True)
    again, before = am.load(tmp_path / "cave.toml"), am.load(real("simple.world"))
    assert np.array_equal(again.map.to_array(), before.map.to_array())
    assert [robot.name for robot in again.robots] == ["r0", "r1"]
    assert again.resolved["robots"][0]["sensors"] == before.resolved["robots"][0]["sensors"]
    assert "# simple.world:33: the walls of floorplan stop robots" in (tmp_path / "cave.toml").read_text()
