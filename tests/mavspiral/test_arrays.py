"""What a value holds nobody can change, and nothing is copied that nobody could."""

import numpy as np
import pytest

from mavspiral.arrays import locked


def lock(values):
    return locked(values, shape=(None,), name="values")


def test_what_somebody_could_write_to_is_copied():
    own = np.arange(3.0)
    view = own[:]
    view.setflags(write=False)
    held = [lock(own), lock(view)]
    own[1] = 7.0
    for array in held:
        np.testing.assert_array_equal(array, [0.0, 1.0, 2.0])
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_what_is_locked_already_is_kept_but_judged():
    once = lock([1, 2, 3])
    assert lock(once) is once
    with pytest.raises(ValueError, match=r"values has shape \(3,\), wanted \(2,\)"):
        locked(once, shape=(2,), name="values")
    torn = np.array([1.0, np.nan])
    torn.setflags(write=False)
    with pytest.raises(ValueError, match=r"not finite at index \(1,\)"):
        lock(torn)


def test_other_numbers_than_floats_become_floats():
    whole = np.arange(3)
    whole.setflags(write=False)
    assert lock(whole).dtype == np.float64
