import numpy as np
from matplotlib.figure import Figure

from amorsim.analysis.plots.path_plots import _draw_events


def test_where_a_robot_was_put_or_carried_to_is_marked():
    axis = Figure().subplots()
    events = {
        "kind": np.array(["collision", "kidnapped", "parameter_set", "pose_set", "pose_set"]),
        "x": np.array([1.0, np.nan, np.nan, np.nan, np.nan]),
        "y": np.array([2.0, np.nan, np.nan, np.nan, np.nan]),
        "value": np.array(["", "[3.0, 4.0, 0.5]", "[9.0, 9.0, 9.0]", "[5.0, 6.0, 0.0]", "nothing"]),
    }
    _draw_events(axis, events)
    marked = {line.get_label(): np.transpose(line.get_data()).tolist() for line in axis.lines}
    assert marked == {"collision": [[1.0, 2.0]], "put elsewhere": [[3.0, 4.0], [5.0, 6.0]]}
