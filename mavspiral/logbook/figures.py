"""The figures of a flight's summary: which of coverage's it has, and what it says of errors measured."""

from __future__ import annotations

import math

import numpy as np

from mavspiral.arrays import FloatArray

__all__ = ["SEEN", "mean", "quantile", "rms", "rounded", "spread"]

SEEN = ("walls", "walls_seeable", "walls_of_seeable", "roof", "roof_seeable", "roof_of_seeable")
"""The figures of coverage that a flight's summary has."""


def spread(errors_m: FloatArray) -> dict[str, float | None]:
    """Root mean square, 95 % quantile and maximum, as a summary has them."""
    return {
        "rms_m": rounded(rms(errors_m)),
        "p95_m": rounded(quantile(errors_m, 0.95)),
        "max_m": rounded(quantile(errors_m, 1.0)),
    }


def rms(values: FloatArray) -> float:
    """The root of the mean square; NaN of nothing, as of the next two."""
    return math.sqrt(float((values**2).mean())) if len(values) else math.nan


def mean(values: FloatArray) -> float:
    """The mean."""
    return float(values.mean()) if len(values) else math.nan


def quantile(values: FloatArray, share: float) -> float:
    """What that share, 0 to 1, of the values do not exceed."""
    return float(np.quantile(values, share)) if len(values) else math.nan


def rounded(value: float) -> float | None:
    """Three decimals; None for what was not measured, because JSON has no NaN."""
    return round(value, 3) if math.isfinite(value) else None
