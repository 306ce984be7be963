import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from amorsim.kernels.grid.distances import distances


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("share", [0.002, 0.05, 0.9])
def test_distances_are_those_of_scipy(seed, share):
    rng = np.random.default_rng(seed)
    cells = (rng.random((37, 53)) < share).astype(np.uint8)
    cells[rng.integers(37), rng.integers(53)] = 1
    out = np.empty(cells.shape)
    distances(cells, out)
    np.testing.assert_array_equal(out, distance_transform_edt(cells == 0))


def test_without_a_set_cell_all_are_infinitely_far():
    out = np.empty((3, 4))
    distances(np.zeros((3, 4), dtype=np.uint8), out)
    assert np.isinf(out).all()
