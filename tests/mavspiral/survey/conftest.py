"""Small sites and one camera that several survey tests share."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.survey.camera import Camera
from mavspiral.survey.shots import Shots


def site_of(building, obstacles=(), *, cell_m=1.0, size_m=64.0):
    """Boxes `(west, south, east, north, height)` on a square map whose south-west corner is the origin."""
    n = round(size_m / cell_m)
    heights, mask = np.zeros((n, n)), np.zeros((n, n), dtype=bool)
    for boxes, own in ((building, True), (obstacles, False)):
        for west, south, east, north, height in boxes:
            rows = slice(round(south / cell_m), round(north / cell_m))
            cols = slice(round(west / cell_m), round(east / cell_m))
            heights[rows, cols], mask[rows, cols] = height, own
    frame = LocalFrame(GeoPoint(19.4, -99.1, 2240.0))
    return Site(HeightMap(heights, cell_m, frame, np.zeros(2)), mask)


def shots_at(*poses):
    """Shots at `(x, y, z, yaw_deg, pitch_deg)`, a second apart."""
    rows = np.array(poses, dtype=float).reshape(-1, 5)
    return Shots(np.arange(len(rows)), rows[:, :3], np.radians(rows[:, 3]), np.radians(rows[:, 4]))


@pytest.fixture
def camera():
    """Half its picture is 3/4 of the distance wide and 1/2 high; a pixel is 1/4000 of the distance."""
    return Camera(0.010, (0.015, 0.010), (6000, 4000), 0.0005, 0.7, True)


@pytest.fixture
def trial():
    return SimpleNamespace(site_of=site_of, shots_at=shots_at)
