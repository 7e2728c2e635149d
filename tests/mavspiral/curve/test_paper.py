"""The paper's own recipe: its slices, its rings, its series, and what closes its seams."""

from __future__ import annotations

import numpy as np
import pytest

from mavspiral.curve.paper import SAMPLES, largest_contour, plan_paper, ring_heights_m, slice_at
from mavspiral.errors import InputError


def voxel_slices(height, levels, starts_m):
    """The paper's own way, equations 4 and 5: a grid of voxels M, and M[i, j, index(l)] for each ring."""
    voxel_m = height.max() / levels
    grid = height[:, :, None] > np.arange(levels) * voxel_m  # solid where the building rises above its floor
    index = np.floor(starts_m / height.max() * levels).astype(int) + 1
    return [grid[:, :, k - 1] for k in index]


@pytest.mark.parametrize("seed", range(8))
def test_superlevel_slices_are_the_voxel_slices_of_the_paper(seed):
    rng = np.random.default_rng(seed)
    levels = int(rng.integers(5, 60))
    whole = rng.integers(0, levels + 1, (30, 40))
    whole[0, 0] = levels
    voxel_m = float(rng.choice([0.25, 0.5, 1.0, 2.0]))  # exact in binary, so that floors are floors
    starts_m = ring_heights_m(0.0, levels * voxel_m, float(rng.uniform(1.0, 9.0)))
    # Roofs at the floors of voxels: exactly the same sets.
    for cut, start_m in zip(voxel_slices(whole * voxel_m, levels, starts_m), starts_m, strict=True):
        assert np.array_equal(cut, slice_at(whole * voxel_m, start_m))
    # Any roof: the voxels are the superlevel sets, and of more only roofs within one voxel above the ring's start.
    height = np.where(whole > 0, whole - rng.uniform(0.0, 0.999, whole.shape), 0.0) * voxel_m
    height[0, 0] = levels * voxel_m
    for cut, start_m in zip(voxel_slices(height, levels, starts_m), starts_m, strict=True):
        above = slice_at(height, start_m)
        assert np.all(cut[above])
        assert np.all(np.abs(height[cut & ~above] - start_m) <= voxel_m)


def test_rings_begin_where_the_paper_says():
    starts_m = ring_heights_m(4.0, 34.0, 7.0)
    assert len(starts_m) == 5  # ceil(30 / 7)
    assert starts_m == pytest.approx([4.0, 10.0, 16.0, 22.0, 28.0])


def test_the_largest_contour_keeps_the_stand_off_to_half_a_cells_diagonal_and_runs_counter_clockwise():
    occupied = np.zeros((120, 160), dtype=bool)
    occupied[50:70, 40:80] = True  # 10 × 5 m
    occupied[60:64, 140:144] = True
    cells, others = largest_contour(occupied, 0.25, 5.0)
    assert others == 1
    x, y = ((cells + 0.5) * 0.25).T
    dx, dy = np.maximum(0, np.maximum(10.0 - x, x - 20.0)), np.maximum(0, np.maximum(12.5 - y, y - 17.5))
    assert np.abs(np.hypot(dx, dy) - 5.0).max() <= 0.25 * np.sqrt(0.5)
    assert np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) > 0.0


def planned(site, **kwargs):
    return plan_paper(
        site, **{"standoff_m": 6.0, "rise_m": 6.0, "bottom_m": 4.0, "top_m": 21.0, "terms": 12, **kwargs}
    )


def test_away_from_its_seams_each_ring_is_its_own_series(blocks):
    path = planned(blocks((20.0, 20.0, 40.0, 32.0, 25.0))).path
    assert (path.rings, path.harmonics) == (3, 12)
    u = np.linspace(0.8, 2 * np.pi - 0.8, 50)
    k = np.arange(13)
    for ring in range(3):
        series = np.real(np.exp(1j * u[:, None] * k) @ path.coefficients_m[ring])
        assert np.abs(path(u + 2 * np.pi * ring) - series).max() < 1e-9
    # z: the ramp of 6 m from h(l), but for what twelve harmonics leave of it.
    middle = path(2 * np.pi * np.arange(3) + np.pi)[:, 2]
    assert middle == pytest.approx([7.0, 7.0 + 17 / 3, 7.0 + 34 / 3], abs=0.1)


def test_the_whole_is_c3_though_the_rings_jump(blocks):
    path = planned(blocks((10.0, 10.0, 50.0, 50.0, 12.0), (12.0, 12.0, 26.0, 30.0, 25.0))).path
    assert path.seams_m.max() > 3.0
    assert len(path.seams_m) == 2
    step = 1e-4
    u = np.arange(0.0, path.u_end_rad, step)
    jet = path.jet(u)
    for order in range(3):
        change = np.diff(jet[order], axis=0) / step
        mean = 0.5 * (jet[order + 1, 1:] + jet[order + 1, :-1])
        assert np.abs(change - mean).max() < 2e-3 * (1.0 + np.abs(jet[order + 1]).max())


def test_more_harmonics_come_nearer_to_the_hundred_samples(blocks):
    site = blocks((20.0, 20.0, 40.0, 32.0, 25.0))
    full = planned(site, terms=SAMPLES // 2 - 1).path
    u = np.linspace(0.8, 5.4, 400)
    errors = [np.abs(planned(site, terms=n).path(u) - full(u))[:, :2].max() for n in (1, 2, 5, 12, 30)]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 0.1 < 1.0 < errors[0]


def test_a_ring_above_the_building_is_refused(blocks):
    with pytest.raises(InputError, match=r"ring 3 begins at 28\.0 m"):
        planned(blocks((20.0, 20.0, 40.0, 32.0, 25.0)), top_m=40.0, rise_m=12.0)
