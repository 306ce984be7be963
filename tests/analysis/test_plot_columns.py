"""Figures of sensors whose readings are tables: a panel for each column."""

import numpy as np

import amorsim as am
from amorsim.analysis.plots import plot

TEXT = """
format = 1
[world]
map = "room.wld"
[simulation]
duration = 0.5
[recording]
picture = false
[[robots]]
name = "rover"
model = "pioneer2dx"
[robots.sensors.finder]
use = "fiducial"
slots = 3
[robots.sensors.gps]
use = "gps"
heading = true
[[landmarks]]
id = 4
x = 3.0
y = 1.5
"""


PANELS = {
    "finder": {"range [m]": 2.0, "bearing [°]": 0.0, "id": 4.0},
    "gps": {"x [m]": 1.0, "y [m]": 1.5, "heading [°]": 0.0},
}


def test_each_column_has_a_panel_in_its_unit(tmp_path, monkeypatch):
    (tmp_path / "room.wld").write_text(
        "0 0 4000 0\n4000 0 4000 3000\n4000 3000 0 3000\n0 3000 0 0\nposition 1000 1500 0\n"
    )
    (tmp_path / "scenario.toml").write_text(TEXT)
    am.run(am.load(tmp_path / "scenario.toml"), tmp_path / "run")
    made = {}
    draw = plot.draw_sensor
    monkeypatch.setattr(plot, "draw_sensor", lambda *which: made.setdefault(which[-1], draw(*which)))
    monkeypatch.setattr(plot, "save_figure", lambda *_, **__: None)
    for other in ("draw_path", "draw_speed", "draw_wheels", "draw_heading", "draw_error"):
        monkeypatch.setattr(plot, other, lambda *_: None)
    plot.plot_run(tmp_path / "run")
    for sensor, panels in PANELS.items():
        axes = made[sensor].axes
        assert [axis.get_ylabel() for axis in axes] == list(panels)
        for axis, wanted in zip(axes, panels.values(), strict=True):
            shown = np.concatenate([line.get_ydata() for line in axis.get_lines()])
            np.testing.assert_allclose(shown[np.isfinite(shown)], wanted, atol=1e-5)  # of empty slots nothing
