"""The certificate of a plan: each limit, the worst that was measured against it, when and where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.curve.gaze import GIMBAL_RADPS
from mavspiral.motion.limits import Limits
from mavspiral.survey.camera import Camera
from mavspiral.survey.clearance import Clearance
from mavspiral.survey.peaks import QUANTITIES, Peaks

__all__ = [
    "STRAIGHT_ON",
    "Certificate",
    "LimitFigure",
    "blur_figure",
    "ceiling_figure",
    "clearance_figures",
    "gimbal_figure",
    "motion_figures",
]

ROUNDING = 1e-9
STRAIGHT_ON = "straight-on clearance"


@dataclass(frozen=True, slots=True)
class LimitFigure:
    """One quantity at its worst moment, against what is allowed: a maximum or, `at_least`, a minimum."""

    name: str
    unit: str
    worst: float
    allowed: float
    at_t_s: float
    at_enu_m: tuple[float, float, float]
    at_least: bool = False

    @property
    def ok(self) -> bool:
        """Whether the worst is allowed, to a rounding of 1e-9 of the limit."""
        rounding = ROUNDING * abs(self.allowed)
        if self.at_least:
            return self.worst >= self.allowed - rounding
        return self.worst <= self.allowed + rounding

    def __str__(self) -> str:
        """One line: quantity, value, limit, moment and place."""
        verdict = "holds" if self.ok else "FAILS"
        bound = "at least" if self.at_least else "at most"
        east, north, up = self.at_enu_m
        return (
            f"{self.name} {verdict}: {self.worst:.4g} {self.unit}, "
            f"allowed {bound} {self.allowed:.4g} {self.unit}, "
            f"at {self.at_t_s:.2f} s, {east:.1f} m east, {north:.1f} m north, {up:.1f} m up"
        )


@dataclass(frozen=True, slots=True)
class Certificate:
    """Every limit with its figure. It holds if each of them does."""

    figures: tuple[LimitFigure, ...]

    @property
    def ok(self) -> bool:
        """Whether every limit holds."""
        return all(figure.ok for figure in self.figures)

    @property
    def failures(self) -> tuple[str, ...]:
        """One sentence for each limit that does not hold: value, limit, moment and place."""
        return tuple(str(figure) for figure in self.figures if not figure.ok)

    def __getitem__(self, name: str) -> LimitFigure:
        """The figure called `name`.

        Raises:
            KeyError: there is none.
        """
        for figure in self.figures:
            if figure.name == name:
                return figure
        raise KeyError(f"no figure is called {name!r}; there are {[figure.name for figure in self.figures]}")


def motion_figures(peaks: Sequence[Peaks], limits: Limits) -> tuple[LimitFigure, ...]:
    """Speed, climb, descent, acceleration, jerk, yaw rate and yaw acceleration of a motion."""
    allowed = (
        ("speed", "m/s", limits.speed_mps),
        ("climb", "m/s", limits.climb_mps),
        ("descent", "m/s", limits.descent_mps),
        ("acceleration", "m/s²", limits.acceleration_mps2),
        ("jerk", "m/s³", limits.jerk_mps3),
        ("yaw rate", "rad/s", limits.yaw_rate_radps),
        ("yaw acceleration", "rad/s²", limits.yaw_acceleration_radps2),
    )
    return tuple(_figure(peaks, name, name, unit, bound) for name, unit, bound in allowed)


def clearance_figures(
    clearance: Clearance, *, required_m: float, vehicle_radius_m: float
) -> tuple[LimitFigure, ...]:
    """The distance to anything solid against `required_m`, and straight on against touching it."""
    measured = (
        ("clearance", clearance.nearest, required_m),
        (STRAIGHT_ON, clearance.straight_on, vehicle_radius_m),
    )
    return tuple(
        LimitFigure(name, "m", nearest.distance_m, allowed, nearest.at_t_s, nearest.at_enu_m, at_least=True)
        for name, nearest, allowed in measured
    )


def blur_figure(peaks: Sequence[Peaks], camera: Camera, allowed_px: float) -> LimitFigure:
    """By how much a picture smears, at its middle and at the distance that its leg keeps, at the worst moment."""
    smear_px = [
        0.0 if each.leg.sight is None else camera.blur_px(each.leg.sight.distance_m, 1.0) for each in peaks
    ]
    return _figure(peaks, "passing", "blur", "px", allowed_px, np.array(smear_px))


def gimbal_figure(peaks: Sequence[Peaks]) -> LimitFigure:
    """How fast the gimbal has to tilt the camera, against what every gimbal follows."""
    return _figure(peaks, "gimbal rate", "gimbal rate", "rad/s", GIMBAL_RADPS)


def ceiling_figure(peaks: Sequence[Peaks], ceiling_m: float) -> LimitFigure:
    """The greatest height above ground against the ceiling."""
    return _figure(peaks, "height", "height", "m", ceiling_m)


def _figure(
    peaks: Sequence[Peaks],
    quantity: str,
    name: str,
    unit: str,
    allowed: float,
    scale: FloatArray | float = 1.0,
) -> LimitFigure:
    """The greatest of the peaks of a quantity, each times its scale; the first of equals."""
    k = QUANTITIES.index(quantity)
    values = scale * np.array([each.greatest[k] for each in peaks])
    worst = int(np.argmax(values))
    east, north, up = peaks[worst].at_enu_m[k].tolist()
    return LimitFigure(
        name, unit, float(values[worst]), allowed, float(peaks[worst].at_t_s[k]), (east, north, up)
    )
