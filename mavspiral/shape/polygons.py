"""Polygons in plan: judged, and laid onto a grid of cells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray

__all__ = ["contains", "cover", "crossing", "signed_area_m2"]


def signed_area_m2(ring_m: FloatArray) -> float:
    """The area inside a ring `(n, 2)`, positive when it runs counter-clockwise."""
    x, y = ring_m[:, 0], ring_m[:, 1]
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def crossing(ring_m: FloatArray, *, touching: bool = True) -> FloatArray | None:
    """The place `(2,)` where two sides of the ring `(n, 2)` that are not neighbours meet, if they do.

    Without `touching` only sides that go through each other count.
    """
    inner = 0.0 if touching else 1e-6
    start, side = ring_m, np.roll(ring_m, -1, axis=0) - ring_m
    n = len(ring_m)
    for i in range(n - 2):
        others = np.arange(i + 2, n - 1 if i == 0 else n)
        offset = start[others] - start[i]
        denominator = side[i, 0] * side[others, 1] - side[i, 1] * side[others, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            along = (offset[:, 0] * side[others, 1] - offset[:, 1] * side[others, 0]) / denominator
            across = (offset[:, 0] * side[i, 1] - offset[:, 1] * side[i, 0]) / denominator
        hit = (along >= inner) & (along <= 1 - inner) & (across >= inner) & (across <= 1 - inner)
        if hit.any():
            place: FloatArray = start[i] + along[hit][0] * side[i]
            return place
    return None


def contains(rings_m: tuple[FloatArray, ...], x_m: float, y_m: float) -> bool:
    """Whether the polygon (its outline, then its holes; even-odd) contains the point."""
    inside = False
    for ring in rings_m:
        x, y = ring[:, 0], ring[:, 1]
        x_next, y_next = np.roll(x, -1), np.roll(y, -1)
        straddles = (y > y_m) != (y_next > y_m)
        with np.errstate(divide="ignore", invalid="ignore"):
            x_side = x + (y_m - y) * (x_next - x) / (y_next - y)
        inside ^= bool(np.count_nonzero(straddles & (x_m < x_side)) % 2)
    return inside


def cover(
    rings_m: tuple[FloatArray, ...], west_m: float, south_m: float, cell_m: float, shape: tuple[int, int]
) -> NDArray[np.bool_]:
    """Every cell `(rows, cols)` that the polygon touches, row 0 in the south.

    Cells are solid, so a wall is laid down up to one cell too far outwards and never too far inwards:
    clearances that are measured to the cells are never flattering, and nothing thin is lost.
    """
    rows, cols = shape
    parity = np.zeros((rows, cols + 1), dtype=np.int32)
    edge = np.zeros(shape, dtype=np.bool_)
    for ring in rings_m:
        cells = (ring - (west_m, south_m)) / cell_m
        for (x0, y0), (x1, y1) in zip(cells, np.roll(cells, -1, axis=0), strict=True):
            low, high = (y0, y1) if y0 < y1 else (y1, y0)
            centre_rows = np.arange(max(0, int(np.ceil(low - 0.5))), min(rows, int(np.ceil(high - 0.5))))
            if len(centre_rows):
                x = x0 + (centre_rows + 0.5 - y0) * (x1 - x0) / (y1 - y0)
                first = np.clip(np.ceil(x - 0.5), 0, cols).astype(np.int64)
                np.add.at(parity, (centre_rows, first), 1)
            enter, leave = _share_within((x0, y0), (x1, y1), (cols, rows))
            if enter > leave:
                continue
            length = np.hypot(x1 - x0, y1 - y0) * (leave - enter)
            steps = np.linspace(enter, leave, 8 * int(length + 1) + 1)
            col = np.floor(x0 + steps * (x1 - x0)).astype(np.int64)
            row = np.floor(y0 + steps * (y1 - y0)).astype(np.int64)
            on_map = (row >= 0) & (row < rows) & (col >= 0) & (col < cols)
            edge[row[on_map], col[on_map]] = True
    inside: NDArray[np.bool_] = (np.cumsum(parity, axis=1)[:, :cols] % 2).astype(np.bool_)
    return inside | edge


def _share_within(
    start: tuple[float, float], end: tuple[float, float], size: tuple[int, int]
) -> tuple[float, float]:
    """From where to where the side, 0 at its start and 1 at its end, runs over the map; a far end costs nothing."""
    enter, leave = 0.0, 1.0
    for a, b, most in zip(start, end, size, strict=True):
        if a == b:
            if not -1 <= a <= most + 1:
                return 1.0, 0.0
            continue
        first, second = sorted(((-1 - a) / (b - a), (most + 1 - a) / (b - a)))
        enter, leave = max(enter, first), min(leave, second)
    return enter, leave
