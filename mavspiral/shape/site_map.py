"""What a reader is asked, what it answers, and what every reader refuses."""

from __future__ import annotations

import importlib
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.shape.heightmap import Site

__all__ = [
    "SURROUNDINGS_M",
    "MapRequest",
    "SiteMap",
    "grid_about",
    "judge_bytes",
    "judge_size",
    "judge_top",
    "need",
]

CELLS_MAX = 16_000_000
TOP_MAX_M = 1500.0
SURROUNDINGS_M = 150.0
"""Other buildings are obstacles out to this distance from the building's bounding box."""


@dataclass(frozen=True, slots=True)
class MapRequest:
    """Which building of which map, on what grid. `at` is latitude and longitude in degrees."""

    path: Path
    cell_m: float
    ground_amsl_m: float
    at: tuple[float, float] | None = None
    id: str | None = None
    dtm: Path | None = None
    units: Literal["m", "mm", "ft"] | None = None
    up: Literal["z", "y"] | None = None
    heading_deg: float | None = None
    crs: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class SiteMap:
    """A site, what the building is called, and what the reader had to assume."""

    site: Site
    name: str
    warnings: tuple[str, ...]


def judge_size(request: MapRequest, rows: float, cols: float) -> None:
    """Refuses a grid that would not fit into memory, and says which cell size would."""
    # A long strip costs as much as the square around half of it.
    cells = max(rows * cols, max(rows, cols) ** 2 / 4)
    if not cells <= CELLS_MAX:
        fits = request.cell_m * math.sqrt(cells / CELLS_MAX)
        raise InputError(
            f"{request.path}: {rows:.0f} × {cols:.0f} cells of {request.cell_m:g} m are more than {CELLS_MAX:,}. "
            + (
                f"Fix: set [building] cell_m = {math.ceil(fits * 100) / 100}"
                if fits <= 10
                else "Fix: cut the building's neighbourhood out of the map"
            )
        )


def judge_bytes(path: Path, most_mb: int, fix: str) -> None:
    """Refuses a file that would not fit into memory once it is read."""
    size_mb = path.stat().st_size / 1e6
    if size_mb > most_mb:
        raise InputError(f"{path}: {size_mb:.0f} MB are more than the {most_mb} MB that are read. Fix: {fix}")


def judge_top(path: Path, top_m: float) -> None:
    """Refuses heights that no building has."""
    if not top_m <= TOP_MAX_M:
        raise InputError(
            f"{path}: its top is {top_m:.6g} m above the ground, no building is higher than {TOP_MAX_M:g} m. "
            "Fix: give heights in metres (not feet or millimetres) above ground_amsl_m"
        )


def grid_about(request: MapRequest, half_extent_m: FloatArray) -> tuple[tuple[int, int], tuple[float, float]]:
    """Rows and columns of a grid about the origin that holds the half extents, and its south-west corner."""
    judge_size(request, *(2 * float(h) / request.cell_m + 2 for h in half_extent_m[::-1]))
    cols, rows = (2 * math.ceil(h / request.cell_m) + 2 for h in half_extent_m)
    judge_size(request, rows, cols)
    return (rows, cols), (-cols / 2 * request.cell_m, -rows / 2 * request.cell_m)


def need(module: str, extra: str, path: Path) -> Any:
    """The module of an extra, imported now.

    Raises:
        InputError: it is not installed; the extra is named.
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        raise InputError(
            f"{path}: reading it needs {module.split('.')[0]}, which is not installed. "
            f"Fix: pip install 'mavspiral[{extra}]'"
        ) from None
