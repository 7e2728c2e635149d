"""Buildings at random, and the slow truth about distances."""

from collections.abc import Callable

import numpy as np
import pytest
from numba import njit

from mavspiral.curve.spiral import Spiral, plan_spiral
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.shape.parts import parts_of
from mavspiral.shape.slicing import solid_distance

FRAME = LocalFrame(GeoPoint(19.4339, -99.1406, 2240.0))


def site_of(heights, cell_m=0.25, origin=(0.0, 0.0)) -> Site:
    heights = np.asarray(heights, dtype=float)
    return Site(HeightMap(heights, cell_m, FRAME, np.array(origin)), heights > 0.0)


def blocks(*boxes, size=(60.0, 60.0), cell_m=0.25) -> Site:
    """A site from boxes (west, south, east, north, height); later ones replace earlier ones."""
    heights = np.zeros((round(size[1] / cell_m), round(size[0] / cell_m)))
    for west, south, east, north, height in boxes:
        rows = slice(round(south / cell_m), round(north / cell_m))
        heights[rows, round(west / cell_m) : round(east / cell_m)] = height
    return site_of(heights, cell_m)


def random_site(rng: np.random.Generator) -> Site:
    """Podium, set-backs, towers, wings, notches, courtyards, masts and roof steps, turned by any angle."""
    cell_m = float(rng.choice([0.25, 0.5, 1.0]))
    size_m = float(rng.uniform(20.0, 70.0))
    count = int(size_m / cell_m)
    centre = (np.arange(count) + 0.5) * cell_m - 0.5 * size_m
    x, y = np.meshgrid(centre, centre)
    angle = rng.choice([0.0, np.pi / 4, rng.uniform(0.0, np.pi / 2)])
    u, v = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
    half = 0.5 * size_m * (1.0 if angle == 0.0 else 0.7)
    heights = np.zeros((count, count))

    def box(low, high):
        a, b = np.sort(rng.uniform(-half, half, 2)), np.sort(rng.uniform(-half, half, 2))
        least = max(2.0 * cell_m, rng.choice([2.0, 6.0, 12.0]))
        a[1], b[1] = max(a[1], a[0] + least), max(b[1], b[0] + least)
        return (u >= a[0]) & (u <= a[1]) & (v >= b[0]) & (v <= b[1]), float(rng.uniform(low, high))

    for _ in range(rng.integers(1, 4)):  # wings: L, U, T and loose pieces
        where, height = box(3.0, 25.0)
        heights[where] = np.maximum(heights[where], height)
    for _ in range(rng.integers(0, 4)):  # towers, set-backs, masts
        where, height = box(5.0, 60.0)
        where &= (heights > 0.0) | (rng.uniform() < 0.3)
        heights[where] = np.maximum(heights[where], height)
    for _ in range(rng.integers(0, 3)):  # notches, courtyards, lower roofs
        where, height = box(0.0, 12.0)
        heights[where] = np.where(rng.uniform() < 0.5, 0.0, np.minimum(heights[where], height))
    if rng.uniform() < 0.15:  # a sloping roof: very many levels
        heights = np.where(heights > 0.0, heights + 0.15 * (u + half), 0.0)
    if not (heights > 0.0).any():
        heights[count // 2, count // 2] = 8.0
    return site_of(heights, cell_m, tuple(rng.uniform(-50.0, 50.0, 2)))


@njit  # not cached: pytest imports this file by a name that numba cannot find again
def _box_distance(points, west, south, cell, heights, out):
    for i in range(points.shape[0]):
        best = np.inf
        for r in range(heights.shape[0]):
            y0 = south + r * cell
            dy = max(0.0, y0 - points[i, 1], points[i, 1] - y0 - cell)
            if dy * dy >= best:
                continue
            for c in range(heights.shape[1]):
                if heights[r, c] <= 0.0:
                    continue
                x0 = west + c * cell
                dx = max(0.0, x0 - points[i, 0], points[i, 0] - x0 - cell)
                dz = max(0.0, points[i, 2] - heights[r, c])
                best = min(best, dx * dx + dy * dy + dz * dz)
        out[i] = np.sqrt(best)


def box_distance(site: Site, points) -> np.ndarray:
    """Distance of points (M, 3) to the boxes of the building, one by one."""
    points = np.ascontiguousarray(points, dtype=float)
    out = np.empty(len(points))
    west, south = site.heights.origin_enu_m
    _box_distance(points, west, south, site.heights.cell_m, site.building_height_m, out)
    return out


def spiral_round(site: Site, **numbers) -> Spiral:
    """The spiral around the largest part, up to as far above its roof as `top_m` is above the building's."""
    reach_m = 2.0 * numbers["standoff_m"] + numbers["corner_radius_m"]
    solid = solid_distance(site, reach_m=reach_m)
    (part,) = parts_of(solid, standoff_m=numbers["standoff_m"], worth=lambda base_m, top_m: False)
    lower_m = float(solid.levels_m[-1]) - part.top_m
    top_m = max(numbers["bottom_m"], numbers["top_m"] - lower_m) if lower_m > 0.0 else numbers["top_m"]
    return plan_spiral(solid, part, **{**numbers, "top_m": top_m})


@pytest.fixture(name="spiral_round")
def spiral_round_fixture() -> Callable[..., Spiral]:
    return spiral_round


@pytest.fixture(name="blocks")
def blocks_fixture() -> Callable[..., Site]:
    return blocks


@pytest.fixture(name="random_site")
def random_site_fixture() -> Callable[[np.random.Generator], Site]:
    return random_site


@pytest.fixture(name="box_distance")
def box_distance_fixture() -> Callable[..., np.ndarray]:
    return box_distance
