"""Every fault is found, with its file, its path and what would be right; all of them at once."""

import tomllib

import pytest

import amorsim as am
from amorsim.core.errors import ScenarioError
from amorsim.scenario.reading.read import load, loads

ROVER = '[[robots]]\nname = "rover"\nmodel = "pioneer2dx"\n'


CASES = [
    ("format = 2", "format", "expected 1, the only format that this amorsim reads, got 2"),
    ("format = true", "format", "expected 1"),
    ("format = 1.0", "format", "expected 1"),
    ("format = 1", "world", "missing; expected [world] with map"),
    ("format = 1", "robots", "missing; expected one robot at least"),
    ("format = 1\nworld = 3", "world", "expected a table, got 3"),
    ("format = 1\nwolrd = {}", "wolrd", "Did you mean 'world'?"),
    ("format = 1\n[world]\nresolution = 1", "world.map", "expected the path of a map file, got nothing"),
    ('format = 1\n[world]\nmap = "no.wld"', "world.map", "there is no such file"),
    ('format = 1\n[world]\nmap = "."', "world.map", "this is a folder"),
    ('format = 1\n[world]\nmap = "room.wld"\nresolutoin = 1', "world.resolutoin", "Did you mean 'resolution'?"),
    ('format = 1\n[world]\nmap = "room.wld"\nuse = "wdl"', "world.use", "Did you mean 'wld'?"),
    ('format = 1\n[world]\nmap = "room.wld"\nresolution = 0', "world.resolution", "expected a number [m] > 0, got 0"),
    ('format = 1\n[world]\nmap = "room.wld"\nuse = "bmp"', "world.map", "room.wld"),
    ("[simulation]\ndt = 0", "simulation.dt", "expected a number [s] >= 1e-06 and <= 10, got 0"),
    ("[simulation]\ndt = '0.1'", "simulation.dt", "got '0.1'"),
    ("[simulation]\nseed = 1.7", "simulation.seed", "expected a whole number >= 0"),
    ("[simulation]\nseed = true", "simulation.seed", "got True"),
    ("[simulation]\nseed = 99999999999999999999999", "simulation.seed", "expected a whole number"),
    ("[simulation]\nduration = inf", "simulation.duration", "got inf"),
    ("[simulation]\ndt = 1979-05-27", "simulation.dt", "got datetime.date(1979, 5, 27)"),
    ("[simulation]\nsed = 1", "simulation.sed", "Did you mean 'seed'?"),
    ("[recording]\nsensors = 'some'", "recording.sensors", "one of 'auto', 'all', 'none', got 'some'"),
    ("[recording]\npicture = 1", "recording.picture", "expected true or false, got 1"),
    ("format = 1\nrobots = []", "robots", "missing"),
    ("format = 1\nrobots = {}", "robots", "expected a list of tables"),
    ("format = 1\nrobots = [3]", "robots.0", "expected a table"),
    ("[[robots]]", "robots.0.shape", "missing; expected { circle"),
    ("[[robots]]", "robots.0.drive", "differential, mecanum"),
    ("[[robots]]\nmodel = 'pioner2dx'", "robots.0.model", "Did you mean 'pioneer2dx'?"),
    ("[[robots]]\nmodel = 'none.toml'", "robots.0.model", "none.toml: there is no such file"),
    ("[[robots]]\nmodel = 3", "robots.0.model", "expected the name of a robot model"),
    (f"{ROVER}nmae = 'x'", "robots.0.nmae", "Did you mean 'name'?"),
    (f"{ROVER}on_collision = 'stop'", "robots.0.on_collision", "one of 'end', 'continue'"),
    (f"{ROVER}pose = {{ heading = 1.0 }}", "robots.0.pose.heading", "write heading_deg, in degrees"),
    ("format = 1\ndt = 0.1", "dt", "unknown key; it belongs in [simulation]"),
    ("format = 1\nmap = 'office.wld'", "map", "unknown key; it belongs in [world]"),
    (f"{ROVER}heading_deg = 90.0", "robots.0.heading_deg", "unknown key; it belongs in pose = { ... }"),
    (f"{ROVER}start = {{ x = 1.0, y = 2.0 }}", "robots.0.start", "Of one robot at one place, write pose = { ... }"),
    (f"{ROVER}pose = {{ x_deg = 1.0 }}", "robots.0.pose.x_deg", "this is not an angle: write x"),
    (f"{ROVER}pose = {{ x = nan }}", "robots.0.pose.x", "expected a number [m], got nan"),
    (f"{ROVER}pose = [1, 2]", "robots.0.pose", "expected a table, got [1, 2]"),
    (f"{ROVER}shape = {{ circle = -1 }}", "robots.0.shape.circle", "above 0 m, got -1.0"),
    (f"{ROVER}shape = {{ circle = true }}", "robots.0.shape.circle", "expected a finite number [m], got True"),
    (f"{ROVER}shape = {{ circel = 1 }}", "robots.0.shape.circel", "unknown key"),
    (f"{ROVER}shape = {{ polygon = [[0, 0], [1, 1]] }}", "robots.0.shape.polygon", "three vertices"),
    (f"{ROVER}shape = {{ polygon = [[0, 0], 3] }}", "robots.0.shape.polygon.1", "expected [X, Y]"),
    (f"{ROVER}shape = {{ rectangle = [1] }}", "robots.0.shape.rectangle", "[LENGTH, WIDTH]"),
    (f"{ROVER}controller = {{}}", "robots.0.controller.use", "missing; expected the name of a controller"),
    (f"{ROVER}controller = 'wander'", "robots.0.controller", "expected a table with use"),
    (f"{ROVER}controller = {{ use = 'wandr' }}", "robots.0.controller.use", "Did you mean 'wander'?"),
    (f"{ROVER}controller = {{ use = 'goto', x = 1 }}", "robots.0.controller.y", "missing; expected a number [m]"),
    (f"{ROVER}controller = {{ use = 'wander', sped = 1 }}", "robots.0.controller.sped", "Did you mean 'speed'?"),
    (f"{ROVER}controller = {{ use = 'no.py:f' }}", "robots.0.controller.use", "there is no such file"),
    (f"{ROVER}controller = {{ use = 'no.py' }}", "robots.0.controller.use", "expected 'FILE.py:NAME'"),
    (f"{ROVER}drive = {{ track = -1 }}", "robots.0.drive.track", "expected a number [m] >= 0.001 and <= 100, got -1"),
    (f"{ROVER}drive = {{ trak = 1 }}", "robots.0.drive.trak", "Did you mean 'track'?"),
    (f"{ROVER}drive = {{ rate_max = 1 }}", "robots.0.drive.rate_max", "write rate_max_deg, in degrees"),
    (f"{ROVER}sensors = 3", "robots.0.sensors", "expected tables by name"),
    (f"{ROVER}sensors = {{ '2nd' = {{ use = 'gyro' }} }}", "robots.0.sensors.2nd", "expected a name"),
    (f"{ROVER}sensors.laser = 3", "robots.0.sensors.laser", "expected a table with use"),
    (f"{ROVER}sensors.laser = true", "robots.0.sensors.laser", "expected a table with use"),
    (f"{ROVER}sensors.laser.fov_deg = 400", "robots.0.sensors.laser.fov_deg", "[deg] > 0 and <= 360, got 400"),
    (f"{ROVER}sensors.laser.beams = 1.5", "robots.0.sensors.laser.beams", "expected a whole number"),
    (f"{ROVER}sensors.laser.rate = 0", "robots.0.sensors.laser.rate", "[Hz] > 0, got 0"),
    (f"{ROVER}sensors.laser.noise = {{}}", "robots.0.sensors.laser.noise", "expected a list of tables"),
    (
        f"{ROVER}sensors.laser.noise = [{{ use = 'bias', value = 1 }}, {{ use = 'gaussian', std = 'x' }}]",
        "robots.0.sensors.laser.noise.1.std",
        "expected a number [m] >= 0, got 'x'",
    ),
    (
        f"{ROVER}sensors.compass.noise = [{{ use = 'gaussian', std = 1 }}]",
        "robots.0.sensors.compass.noise.0.std",
        "write std_deg",
    ),
    (
        f"{ROVER}sensors.laser.noise = [{{ use = 'gaussian', name = 'a' }}, {{ use = 'gaussian', name = 'a' }}]",
        "robots.0.sensors.laser.noise.1.name",
        "names must differ",
    ),
    (
        f"{ROVER}sensors.laser.noise = [{{ use = 'gaussian', name = 'a.b' }}]",
        "robots.0.sensors.laser.noise.0.name",
        "expected a name of letters",
    ),
    (
        f"{ROVER}sensors.sonar.elements = [{{ x = 1 }}, {{ x = 1, heading = 3 }}]",
        "robots.0.sensors.sonar.elements.1.heading",
        "write heading_deg",
    ),
    (
        f"{ROVER}sensors.encoder.counts_per_revolution = [1, 2, 3]",
        "robots.0.sensors.encoder.counts_per_revolution",
        "one for each of the drive's 2 joints (left_wheel, right_wheel), got 3",
    ),
    (
        f"{ROVER}sensors.encoder.counts_per_revolution = [1, -2]",
        "robots.0.sensors.encoder.counts_per_revolution",
        "got [1, -2]",
    ),
    (f"{ROVER}sensors.encoder.counts_per_revolution = [4000, 4001]", "", ""),
    (
        f"{ROVER}sensors.encoder.counts_per_revolution = [8, 9]\nerrors.sensors.encoder.counts_per_revolution = 7",
        "robots.0.errors.sensors.encoder.counts_per_revolution",
        "this is a list of 2: end the path with one of 0 to 1",
    ),
    (
        f"{ROVER}sensors.encoder.counts_per_revolution = [8, 9]\nerrors.sensors.encoder.counts_per_revolution.1 = 7",
        "",
        "",
    ),
    (f"{ROVER}sensors.sonar.range_min = 9", "robots.0.sensors.sonar.range_min", "range_max"),
    (f"{ROVER}ground = [{{ use = 'difusion' }}]", "robots.0.ground.0.use", "Did you mean 'diffusion'?"),
    (f"{ROVER}estimators.ekf.use = 'slam'", "robots.0.estimators.ekf.use", "no estimator 'slam'"),
    (f"{ROVER}knowledge.landmarks = [[1, 'a']]", "robots.0.knowledge.landmarks.0", "expected [x, y]"),
    (f"{ROVER}knowledge.map = 'no.wld'", "robots.0.knowledge.map", "there is no such file"),
    (f"{ROVER}knowledge.resolution = 1", "robots.0.knowledge.map", "expected the path of a map file"),
    (f"{ROVER}knowledge.landmark = 'world'", "robots.0.knowledge.landmark", "Did you mean 'landmarks'?"),
    (
        f"{ROVER}sensors.lazer = false",
        "robots.0.sensors.lazer",
        "the model has no sensor 'lazer'; known sensors: encoder, laser",
    ),
    (f"{ROVER}sensors.lazer = false", "robots.0.sensors.lazer", "Did you mean 'laser'?"),
    (
        f"{ROVER}estimators.ekf = false",
        "robots.0.estimators.ekf",
        "known estimators: dead_reckoning.",
    ),
    ("[recording]\nx = 1", "recording.x", "unknown key; known keys: also, sensors, picture."),
    (f"{ROVER}errors = 3", "robots.0.errors", "expected a table of errors"),
    (f"{ROVER}errors.drive.trak = 1.0", "robots.0.errors.drive.trak", "Did you mean 'track'?"),
    (
        f"{ROVER}errors.drve.track.scale = 1.0",
        "robots.0.errors.drve.track",
        "no entry 'drve'; known entries: drive, sensors, pose. Did you mean 'drive'?",
    ),
    (f"{ROVER}errors.drive.track = 'x'", "robots.0.errors.drive.track", "expected a finite number"),
    (f"{ROVER}errors.drive.track.scal = 1", "robots.0.errors.drive.track.scal", "Did you mean 'scale'?"),
    (f"{ROVER}errors.drive.track.scale = nan", "robots.0.errors.drive.track.scale", "expected a finite number"),
    (f"{ROVER}errors.drive.track.scale = -1", "robots.0.errors.drive.track", "the true value is wrong"),
    (f"{ROVER}errors.drive.track = 0", "robots.0.errors.drive.track", "the true value is wrong"),
    (f"{ROVER}errors.drive.track = {{ value = 1, add = 1 }}", "robots.0.errors.drive.track", "either value, or"),
    (f"{ROVER}errors.drive.track = {{ per = 'day' }}", "robots.0.errors.drive.track.per", "one of 'replica'"),
    (f"{ROVER}errors.drive.track = {{ normal = [1] }}", "robots.0.errors.drive.track.normal", "[MEAN, STANDARD"),
    (f"{ROVER}errors.drive.track = {{ normal = [1, -1] }}", "robots.0.errors.drive.track.normal", ">= 0"),
    (f"{ROVER}errors.drive.track.add = {{ gauss = 1 }}", "robots.0.errors.drive.track.add.gauss", "unknown key"),
    (f"{ROVER}errors.drive.acceleration_max_deg = 1", "", ""),
    (f"{ROVER}errors.drive.track_deg = 1", "robots.0.errors.drive.track_deg", "this is not an angle: write track"),
    (f"{ROVER}errors.sensors.laser.mount.heading = 1", "robots.0.errors.sensors.laser.mount.heading", "_deg"),
    (f"{ROVER}errors.sensors.lasr.mount.x = 1", "robots.0.errors.sensors.lasr.mount.x", "Did you mean 'laser'?"),
    (f"{ROVER}errors.sensors.laser.noise.0.std = 1", "robots.0.errors.sensors.laser.noise", "noise chain"),
    (f"{ROVER}errors.sensors.laser.rate = 1", "robots.0.errors.sensors.laser.rate", "has no error"),
    (f"{ROVER}errors.sensors.sonar.elements.16.x = 1", "robots.0.errors.sensors.sonar.elements.16.x", "0 to 15"),
    (f"{ROVER}{ROVER}", "robots.1.name", "robots.0 is called 'rover' too"),
    (f"{ROVER}[[robots]]\nmodel='pioneer2dx'\n[[robots]]\nmodel='pioneer2dx'", "robots.2.name", "called 'robot'"),
    (f"{ROVER}[[obstacles]]\nname='rover'\nshape={{circle=1}}", "obstacles.0.name", "robots.0 is called"),
    (f"{ROVER}[[obstacles]]\nname='box'", "obstacles.0.shape", "missing; expected { circle"),
    (f"{ROVER}[[obstacles]]\nshape={{circle=1}}\nmotion={{use='lop'}}", "obstacles.0.motion.use", "no motion"),
    (f"{ROVER}[obstacles]\nname='box'", "obstacles", "expected a list of tables"),
]


@pytest.mark.parametrize(("text", "path", "words"), CASES)
def test_a_fault_has_its_path_and_says_what_would_be_right(read, faults, text, path, words):
    if not path:
        assert read(text)
        return
    found = faults(text)
    assert path in found, found
    assert words in found[path]


def test_a_model_that_is_not_there_is_one_fault_whatever_is_changed_of_it(faults):
    changes = "sensors.laser.range_max = 4\nestimators.odometry.x = 1\ndrive.track = 0.3\ncontroller.k = 1"
    found = faults(f"[[robots]]\nname = 'a'\nmodel = 'pioneer2dy'\n{changes}\nerrors.drive.track.scale = 1.1")
    assert [path for path in found if path.startswith("robots")] == ["robots.0.model"]


def test_all_faults_are_reported_at_once(faults):
    found = faults(
        """
        format = 3
        [world]
        map = "no.wld"
        [simulation]
        dt = -1
        seed = "x"
        [[robots]]
        model = "nobody"
        sensors.laser = { use = "lazer" }
        [[robots]]
        name = "two"
        model = "pioneer2dx"
        controller = { use = "wander", speed = nan }
        drive = { track = "wide" }
        errors.drive.wheel_radius_left.scale = "x"
        errors.sensors.laser.mount.y.ad = 1.0
        sensors.compass.noise = [{ use = "gaussian", std_deg = -1 }, { use = "quantise" }]
        [[obstacles]]
        shape = { circle = "big" }
        """
    )
    assert set(found) == {
        "format",
        "world.map",
        "simulation.dt",
        "simulation.seed",
        "robots.0.model",
        "robots.0.sensors.laser.use",
        "robots.1.controller.speed",
        "robots.1.drive.track",
        "robots.1.errors.sensors.laser.mount.y.ad",
        "robots.1.sensors.compass.noise.0.std_deg",
        "robots.1.sensors.compass.noise.1.use",
        "obstacles.0.shape.circle",
    }, "what depends on the drive that could not be read is left out, all else is there"


def test_a_fault_in_a_model_names_the_models_file_and_the_path_in_it(read, tmp_path, folder):
    model = tmp_path / "cart.toml"
    model.write_text(
        'format = 2\nshpe = 3\nshape = { circle = 1 }\n[drive]\nuse = "differential"\nwheel_radius_left = 0\n'
        "wheel_radius_right = 0.1\ntrack = 0.4\nrate_max_deg = 900\n"
        '[sensors.laser]\nuse = "laser"\nnoise = [{ use = "gaussian", std = -1 }]\n'
    )
    text = f'[[robots]]\nname = "{{}}"\nmodel = "{model}"\ndrive.track = -4\n'
    with pytest.raises(ScenarioError) as caught:
        read(text.format("a") + text.format("b"))
    found = {(fault.file, fault.path) for fault in caught.value.faults}
    assert found == {
        (str(model), "format"),
        (str(model), "shpe"),
        (str(model), "drive.wheel_radius_left"),
        (str(model), "sensors.laser.noise.0.std"),
        ("test.toml", "robots.0.drive.track"),
        ("test.toml", "robots.1.drive.track"),
    }
    assert len(found) == len(caught.value.faults), "a model's fault is reported once, however many robots it has"


def test_a_model_that_is_no_toml_names_the_line(faults, tmp_path):
    model = tmp_path / "cart.toml"
    model.write_text("format = 1\nshape = {\n")
    message = faults(f'[[robots]]\nmodel = "{model}"\n')["robots.0.model"]
    assert "not valid TOML" in message
    assert "line 2" in message


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"format = 1\n[world\n", "bad.toml:2: not valid TOML"),
        (b"\xff\xfe\x00", "not a text file in UTF-8: byte 0 is 0xff"),
        (b"format = " + b"9" * 5000, "not valid TOML"),
        (b"a = " + b"[" * 100_000, "not valid TOML"),
    ],
)
def test_a_file_that_is_no_toml(registry, tmp_path, data, words):
    path = tmp_path / "bad.toml"
    path.write_bytes(data)
    with pytest.raises(ScenarioError, match=words) as caught:
        load(path, registry=registry)
    assert caught.value.faults[0].file == str(path)


def test_a_file_that_is_not_there(registry, tmp_path):
    with pytest.raises(ScenarioError, match="there is no such file"):
        load(tmp_path / "none.toml", registry=registry)
    with pytest.raises(ScenarioError, match=r"bundled scenarios: .*demo.*Did you mean 'demo'\?"):
        load("dmo", registry=registry)
    with pytest.raises(ScenarioError, match=r"there is no such file; .*the bundled scenario is called demo"):
        load("demo.toml", registry=registry)
    with pytest.raises(ScenarioError, match="a folder"):
        load(tmp_path, registry=registry)


def test_a_file_with_a_byte_order_mark_is_read(registry, folder):
    path = folder / "bom.toml"
    text = '\N{BOM}format = 1\n[world]\nmap = "room.wld"\n[[robots]]\nmodel = "pioneer2dx"\n'
    path.write_text(text, encoding="utf-8")
    assert load(path, registry=registry).robots


def test_a_map_without_a_free_place_is_a_fault_of_the_pose(registry, tmp_path):
    from PIL import Image

    Image.new("1", (20, 20), 0).save(tmp_path / "black.bmp")
    document = {"format": 1, "world": {"map": "black.bmp"}, "robots": [{"model": "pioneer2dx"}]}
    with pytest.raises(ScenarioError) as caught:
        loads(document, tmp_path, registry=registry)
    assert caught.value.faults[0].path == "robots.0.pose"


def test_a_huge_value_does_not_fill_the_screen(faults):
    message = faults(f"[simulation]\ndt = '{'x' * 100_000}'")["simulation.dt"]
    assert len(message) < 300


def test_a_message_calls_robots_obstacles_and_zones_by_name(folder, registry):
    """Where a name is given, and no other has it; `path` counts them, for programs."""
    text = """
    format = 1
    [[robots]]
    name = "rover"
    model = "pioneer2dx"
    nmae = 1
    [[robots]]
    model = "pioneer2dx"
    nmae = 1
    [[obstacles]]
    name = "cat"
    nmae = 1
    [[obstacles]]
    name = "twin"
    nmae = 1
    [[obstacles]]
    name = "twin"
    nmae = 1
    [[zones]]
    name = "odd name"
    nmae = 1
    """
    with pytest.raises(ScenarioError) as caught:
        loads(tomllib.loads(text), folder, registry=registry)
    faults = [fault for fault in caught.value.faults if fault.path.endswith("nmae")]
    paths = ["zones.0", "robots.0", "robots.1", "obstacles.0", "obstacles.1", "obstacles.2"]
    assert [fault.path for fault in faults] == [f"{path}.nmae" for path in paths]
    paths = ["zones.0", "robots.rover", "robots.1", "obstacles.cat", "obstacles.1", "obstacles.2"]
    assert [str(fault).partition(": ")[0] for fault in faults] == [f"{path}.nmae" for path in paths]


def test_a_fault_has_its_line_value_and_remedy(registry, tmp_path):
    path = tmp_path / "faulty.toml"
    path.write_text(
        'format = 1\nworld = 3\n[simulation]\ndt = -1\n\n[[robots]]\nname = "rover"\nmodel = "pioneer2dx"\n'
        "[robots.sensors.laser]\nnoise = [\n    # one\n    { use = 'gaussian', std = -1 },\n]\nbeems = 3\n"
    )
    with pytest.raises(ScenarioError) as caught:
        load(path, registry=registry)
    found = {fault.named or fault.path: (fault.line, fault.value, fault.remedy) for fault in caught.value.faults}
    assert found == {
        "simulation.dt": (4, -1, "expected a number [s] >= 1e-06 and <= 10"),
        "world": (2, 3, "expected a table"),
        "robots.rover.sensors.laser.noise.0.std": (12, -1, "expected a number [m] >= 0"),
        "robots.rover.sensors.laser.beems": (14, 3, "Did you mean 'beams'?"),
    }
    assert str(path) + ":4: simulation.dt: expected" in str(caught.value)


def test_lines_that_are_no_toml_are_faults_with_all_others(registry, tmp_path):
    path = tmp_path / "faulty.toml"
    path.write_text('format = 1\n[world\nmap = "room.wld"\n[simulation]\ndt = 0.1 s\nduration = -1\nduration = 2\n')
    with pytest.raises(ScenarioError) as caught:
        load(path, registry=registry)
    faults = caught.value.faults
    assert [(fault.line, fault.path) for fault in faults] == [(2, ""), (5, ""), (7, ""), (6, "simulation.duration")]
    assert faults[1].value == "dt = 0.1 s"
    assert faults[2].remedy == "leave one of the two out"


def test_a_fault_of_a_model_has_the_line_in_the_models_file(registry, tmp_path, folder):
    (tmp_path / "cart.toml").write_text('format = 1\nmodel = "pioneer2dx"\n\n[drive]\ntrack = "wide"\n')
    path = tmp_path / "one.toml"
    path.write_text(f'format = 1\n[world]\nmap = "{folder / "room.wld"}"\n[[robots]]\nmodel = "cart.toml"\n')
    with pytest.raises(ScenarioError) as caught:
        load(path, registry=registry)
    (fault,) = caught.value.faults
    assert (fault.file, fault.line, fault.path) == (str(tmp_path / "cart.toml"), 5, "drive.track")


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        (lambda self: 1 / 0, "columns() raised ZeroDivisionError"),
        (lambda self: None, "columns(): expected a dict of names and units"),
        (lambda self: {"a": "rad", "b": "rad"}, "columns(): expected columns whose number divides the 1 values"),
    ],
)
@pytest.mark.parametrize("noise", ["[]", '[{ use = "gaussian", std_deg = 1.0 }]'])
def test_wrong_columns_of_a_sensor_are_a_fault_in_its_place(faults, monkeypatch, columns, words, noise):
    monkeypatch.setattr(am.sensors.Compass, "columns", columns)
    robot = (
        f'[[robots]]\nname = "rover"\nmodel = "pioneer2dx"\n[robots.sensors.north]\nuse = "compass"\nnoise = {noise}\n'
    )
    found = faults(robot)
    assert "robots.0.sensors.north" in found
    assert words in found["robots.0.sensors.north"]
