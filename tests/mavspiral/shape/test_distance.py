"""Distances between cells are the square roots of whole numbers, to the last bit."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mavspiral.shape.distance import cells_away


@given(st.integers(1, 12), st.integers(1, 12), st.data())
def test_each_cell_is_as_far_as_the_nearest(rows, cols, data):
    mask = np.zeros((rows, cols), dtype=np.bool_)
    for cell in data.draw(st.sets(st.integers(0, rows * cols - 1), min_size=1)):
        mask.flat[cell] = True
    there = np.argwhere(mask)
    squares = [[((there - (r, c)) ** 2).sum(axis=1).min() for c in range(cols)] for r in range(rows)]
    assert np.array_equal(cells_away(mask), np.sqrt(np.array(squares, dtype=np.float32)))


@pytest.mark.parametrize("col", [0, 500, 999])
def test_a_thousand_cells_away_it_is_still_the_root_of_a_whole_number(col):
    mask = np.zeros((700, 1000), dtype=np.bool_)
    mask[3, col] = True
    row, cols = np.ogrid[:700, :1000]
    squares = (row - 3) ** 2 + (cols - col) ** 2
    near = squares < 1_000_000
    assert np.array_equal(cells_away(mask)[near], np.sqrt(squares.astype(np.float32))[near])


def test_far_from_nothing_is_far():
    assert cells_away(np.zeros((5, 6), dtype=np.bool_)).min() > 1e9
