import numpy as np
import pytest

from mavspiral.curve import Path
from mavspiral.curve.line import LinePath


def test_a_line_goes_from_start_to_end():
    path: Path = LinePath(np.array([1.0, 2.0, 3.0]), np.array([4.0, 6.0, 3.0]))
    np.testing.assert_allclose(path([0.0, 0.5, path.u_end_rad]), [[1, 2, 3], [2.5, 4, 3], [4, 6, 3]])
    np.testing.assert_allclose(path([0.0, 0.5], 1), [[3, 4, 0], [3, 4, 0]])
    np.testing.assert_array_equal(path([[0.0, 0.5]], 3), np.zeros((1, 2, 3)))
    assert path(0.3).shape == (3,)


def test_an_unknown_order_is_refused():
    with pytest.raises(ValueError, match="order is 4"):
        LinePath(np.zeros(3), np.ones(3))(0.0, 4)
