"""Pose graphs in files."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import amorsim as am
from amorsim.algorithms.pose_graph import PoseGraph, read_g2o, write_g2o

NUMBER = st.floats(-1e9, 1e9)


def written(folder, text):
    path = folder / "graph.g2o"
    path.write_text(text)
    return path


def test_a_file_is_read(tmp_path):
    text = """# a comment
VERTEX_SE2 7 1.5 2.0 0.1
VERTEX_SE2 3 0 0 0
FIX 3
EDGE_SE2 3 7 1.5 2.0 0.1 1 0.1 0.2 2 0.3 3
EDGE_SE2 7 9 1 0 0 1 0 0 1 0 1
"""
    graph = read_g2o(written(tmp_path, text))
    np.testing.assert_array_equal(graph.ids, [3, 7, 9])
    np.testing.assert_array_equal(graph.poses, [[0, 0, 0], [1.5, 2.0, 0.1], [0, 0, 0]])
    np.testing.assert_array_equal(graph.edges, [[0, 1], [1, 2]])
    np.testing.assert_array_equal(graph.information[0], [[1, 0.1, 0.2], [0.1, 2, 0.3], [0.2, 0.3, 3]])


@given(st.lists(st.tuples(NUMBER, NUMBER, NUMBER), min_size=2, max_size=5), st.data())
def test_what_is_written_is_read_with_the_same_bits(tmp_path_factory, poses, data):
    path = tmp_path_factory.mktemp("g2o") / "graph.g2o"
    count = len(poses)
    edges = [(i, (i + 1) % count) for i in range(count)]
    measured = [data.draw(st.tuples(NUMBER, NUMBER, NUMBER)) for _ in edges]
    graph = PoseGraph.of(poses, edges, measured, [np.diag((1.0, 2.0, 1.0 / 3.0))] * count, ids=range(5, 5 + count))
    write_g2o(graph, path)
    again = read_g2o(path)
    for name in ("poses", "edges", "measurements", "information", "ids"):
        assert getattr(again, name).tobytes() == getattr(graph, name).tobytes()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("VERTEX_SE3 0 1 2 3\n", "line 1: 'VERTEX_SE3' is not a line of a graph in the plane"),
        ("VERTEX_SE2 0 1 2\n", "line 1: expected 4 numbers after VERTEX_SE2, got 3"),
        ("VERTEX_SE2 0 1 2 x\n", "line 1: .*'x'"),
        ("VERTEX_SE2 0 1 2 3\nVERTEX_SE2 0 1 2 3\n", "line 2: vertex 0 is there already"),
        ("VERTEX_SE2 0 1 2 nan\n", "poses: number 0"),
        ("", "at least one pose"),
    ],
)
def test_a_damaged_file_is_refused(tmp_path, text, message):
    with pytest.raises(am.GraphError, match=message) as caught:
        read_g2o(written(tmp_path, text))
    assert "graph.g2o" in str(caught.value)


def test_a_file_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(am.GraphError, match=r"none\.g2o: cannot be read"):
        read_g2o(tmp_path / "none.g2o")
