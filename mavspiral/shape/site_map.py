"""What a reader is asked, and what it answers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from mavspiral.errors import InputError
from mavspiral.shape.heightmap import Site

__all__ = ["MapRequest", "SiteMap", "judge_size"]

CELLS_MAX = 16_000_000


@dataclass(frozen=True, slots=True)
class MapRequest:
    """Which building of which map, on what grid. `at` is latitude and longitude in degrees."""

    path: Path
    cell_m: float
    ground_amsl_m: float
    at: tuple[float, float] | None = None
    id: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class SiteMap:
    """A site, what the building is called, and what the reader had to assume."""

    site: Site
    name: str
    warnings: tuple[str, ...]


def judge_size(request: MapRequest, rows: int, cols: int) -> None:
    """Refuses a grid that would not fit into memory, and says which cell size would."""
    if rows * cols > CELLS_MAX:
        fits = request.cell_m * math.sqrt(rows * cols / CELLS_MAX)
        raise InputError(
            f"{request.path}: {rows} × {cols} cells of {request.cell_m} m are more than {CELLS_MAX:,}. "
            f"Fix: set [building] cell_m = {math.ceil(fits * 100) / 100}"
        )
