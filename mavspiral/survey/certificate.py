"""The certificate of a plan: each limit, the worst that was measured against it, when and where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.curve.gaze import GIMBAL_RADPS
from mavspiral.motion.limits import Limits
from mavspiral.motion.sight import Sight
from mavspiral.motion.trajectory import TrajectoryState
from mavspiral.survey.camera import Camera
from mavspiral.survey.clearance import Clearance

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


def motion_figures(state: TrajectoryState, limits: Limits) -> tuple[LimitFigure, ...]:
    """Speed, climb, descent, acceleration, jerk, yaw rate and yaw acceleration of a sampled motion."""
    climb_mps = state.velocity_enu_mps[:, 2]
    measured = (
        ("speed", "m/s", _norms(state.velocity_enu_mps), limits.speed_mps),
        ("climb", "m/s", np.maximum(climb_mps, 0.0), limits.climb_mps),
        ("descent", "m/s", np.maximum(-climb_mps, 0.0), limits.descent_mps),
        (
            "acceleration",
            "m/s²",
            _norms(state.acceleration_enu_mps2),
            limits.acceleration_mps2,
        ),
        ("jerk", "m/s³", _norms(state.jerk_enu_mps3), limits.jerk_mps3),
        ("yaw rate", "rad/s", np.abs(state.yaw_rate_enu_radps), limits.yaw_rate_radps),
        (
            "yaw acceleration",
            "rad/s²",
            np.abs(state.yaw_acceleration_enu_radps2),
            limits.yaw_acceleration_radps2,
        ),
    )
    return tuple(
        _figure(name, unit, values, allowed, state.t_s, state.position_enu_m)
        for name, unit, values, allowed in measured
    )


def clearance_figures(
    clearance: Clearance, *, required_m: float, vehicle_radius_m: float
) -> tuple[LimitFigure, ...]:
    """The distance to anything solid against `required_m`, and straight on against touching it."""
    measured = (
        ("clearance", clearance.distance_m, required_m),
        (STRAIGHT_ON, clearance.straight_on_m, vehicle_radius_m),
    )
    return tuple(
        _figure(name, "m", values, allowed, clearance.t_s, clearance.position_enu_m, at_least=True)
        for name, values, allowed in measured
    )


def blur_figure(sight: Sight, states: TrajectoryState, camera: Camera, allowed_px: float) -> LimitFigure:
    """By how much a picture smears, at its middle and at the distance that the leg keeps, at the worst moment."""
    yaw = np.stack([states.yaw_enu_rad, states.yaw_rate_enu_radps])
    passing_mps = sight.passing(states.velocity_enu_mps, yaw, _pitch(states))
    smeared_px = passing_mps * camera.blur_px(sight.distance_m, 1.0)
    return _figure("blur", "px", smeared_px, allowed_px, states.t_s, states.position_enu_m)


def gimbal_figure(state: TrajectoryState) -> LimitFigure:
    """How fast the gimbal has to tilt the camera, against what every gimbal follows."""
    rate_radps = np.abs(_pitch(state)[1])
    return _figure("gimbal rate", "rad/s", rate_radps, GIMBAL_RADPS, state.t_s, state.position_enu_m)


def ceiling_figure(state: TrajectoryState, ceiling_m: float) -> LimitFigure:
    """The greatest height above ground against the ceiling."""
    return _figure("height", "m", state.position_enu_m[:, 2], ceiling_m, state.t_s, state.position_enu_m)


def _pitch(states: TrajectoryState) -> FloatArray:
    """The camera's pitch in rad and its rate in rad/s, `(2, n)`."""
    pitch = np.zeros((2, len(states.t_s)))
    if states.gimbal_pitch_rad.any():
        pitch[:] = states.gimbal_pitch_rad, np.gradient(states.gimbal_pitch_rad, states.t_s)
    return pitch


def _norms(vectors: FloatArray) -> FloatArray:
    squares = vectors * vectors
    lengths: FloatArray = np.sqrt(squares[:, 0] + squares[:, 1] + squares[:, 2])
    return lengths


def _figure(
    name: str,
    unit: str,
    values: FloatArray,
    allowed: float,
    t_s: FloatArray,
    position_enu_m: FloatArray,
    *,
    at_least: bool = False,
) -> LimitFigure:
    k = int(np.argmin(values) if at_least else np.argmax(values))
    east, north, up = (float(metres) for metres in position_enu_m[k])
    return LimitFigure(name, unit, float(values[k]), allowed, float(t_s[k]), (east, north, up), at_least)
