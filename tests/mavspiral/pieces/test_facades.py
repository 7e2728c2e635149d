"""Façades to and fro: no way from a row to the next one leads past what stands there."""

import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from mavspiral import load_mission, plan
from mavspiral.curve.meander import Row, meander
from mavspiral.errors import LimitError
from mavspiral.pieces.facades import _parted, _row_heights_m
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


def heights_m(low_m, high_m, rise_m, roofs_m=()):
    """Of the rows of a part 12 m high, with 3.7 m of room above each neighbour's roof."""
    asked = SimpleNamespace(inspection=SimpleNamespace(top_m=None), limits=SimpleNamespace(ceiling_m=120.0))
    others = SimpleNamespace(levels_m=np.array(roofs_m))
    setting = SimpleNamespace(mission=asked, joinable_m=3.35)
    return _row_heights_m(setting, others, SimpleNamespace(top_m=12.0), low_m, high_m, rise_m)


@pytest.mark.parametrize(
    ("low_m", "roofs_m"), [(6.199, ()), (2.0, (2.499,)), (2.0, (-1.699,)), (2.0, (0.8, 1.0))]
)
def test_no_row_comes_back_on_the_line_of_the_row_below(low_m, roofs_m):
    """A band of a millimetre, or a neighbour's roof just below a row: a curve to and fro there would stand still at its end."""
    heights = heights_m(low_m, 6.2, 4.2, roofs_m)
    path, _ = meander([row(0.0, height_m) for height_m in heights], smoothing_m=3.0)
    along_m = np.linalg.norm(path.jet(np.linspace(0.0, path.u_end_rad, 5_000))[1], axis=1)
    assert along_m.min() > 0.05
    assert heights[-1] == 6.2


def test_rows_that_are_asked_for_close_together_are_all_flown():
    assert np.allclose(heights_m(2.0, 4.0, 0.2), np.linspace(2.0, 4.0, 11))


def test_a_standoff_too_small_for_facades_is_told_so_and_the_one_that_is_asked_for_plans(tmp_path):
    """Not that all around stands too near: beside the keep-out there is nothing."""
    missions = Path(__file__).parents[3] / "missions"
    text = (
        (missions / "kiosk.toml").read_text(encoding="utf-8").replace("maps/", f"{missions.as_posix()}/maps/")
    )
    text += "\n[[keepout]]\ncircle = [23.96058, 32.8675, 2.0]\nheight_m = [0, 40]\n"
    path = tmp_path / "mission.toml"
    path.write_text(text.replace("standoff_m = 6.0", "standoff_m = 3.4"), encoding="utf-8")
    with pytest.raises(LimitError, match=r"^\[inspection\] standoff_m = 3.4") as refusal:
        plan(load_mission(path))
    asked_m = re.search(r"Fix: standoff_m ≥ ([\d.]+)$", str(refusal.value))[1]
    path.write_text(text.replace("standoff_m = 6.0", f"standoff_m = {asked_m}"), encoding="utf-8")
    assert "facade" in [flown.name for flown in plan(load_mission(path)).passes]
