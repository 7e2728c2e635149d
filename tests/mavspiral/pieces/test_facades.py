"""Façades to and fro: no way from a row to the next one leads past what stands there."""

from types import SimpleNamespace

import numpy as np
import pytest

from mavspiral.curve.meander import Row
from mavspiral.pieces.facades import _parted
from mavspiral.survey.solids import Solids


def row(y_m, height_m):
    x = np.linspace(-20.0, 20.0, 81)
    points = np.column_stack([x, np.full(81, y_m), np.full(81, height_m)])
    return Row(points, np.full(81, 0.5 * np.pi), False)


def setting_with_mast(x_m, top_m):
    """A mast 1 m wide between rows at y = 0 and y = 12."""
    heights = np.zeros((60, 60))
    heights[35, int(x_m) + 30] = top_m
    solids = Solids.of(heights, 1.0, (-30.0, -30.0))
    return SimpleNamespace(pace=SimpleNamespace(speed_mps=3.0), everything=solids, required_m=3.0)


@pytest.mark.parametrize("x_m", [20.0, -20.0])
def test_rows_are_parted_where_the_way_between_them_leads_past_a_mast(x_m):
    """Whichever end the first row is begun at, and nowhere else."""
    rows = [row(0.0, 5.0), row(0.0, 9.0), row(12.0, 13.0), row(12.0, 17.0)]
    assert _parted(setting_with_mast(x_m, 40.0), rows) == [rows[:2], rows[2:]]


@pytest.mark.parametrize(("x_m", "top_m"), [(0.0, 40.0), (20.0, 8.0)])
def test_rows_stay_together_past_a_mast_elsewhere_or_below(x_m, top_m):
    rows = [row(0.0, 5.0), row(0.0, 9.0), row(12.0, 13.0), row(12.0, 17.0)]
    assert _parted(setting_with_mast(x_m, top_m), rows) == [rows]
