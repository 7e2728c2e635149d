"""What the vehicle is allowed: bounds on the norms of its motion and on its turning."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

__all__ = ["Limits"]


@dataclass(frozen=True, slots=True)
class Limits:
    """Bounds on a trajectory: norms in space, climb and descent apart, and yaw.

    Raises:
        ValueError: a bound is not a positive, finite number.
    """

    speed_mps: float
    climb_mps: float
    descent_mps: float
    acceleration_mps2: float
    jerk_mps3: float
    yaw_rate_radps: float
    yaw_acceleration_radps2: float

    def __post_init__(self) -> None:
        """Checks the fields."""
        for field in fields(self):
            bound = getattr(self, field.name)
            if not (math.isfinite(bound) and bound > 0):
                raise ValueError(f"{field.name} is {bound}, wanted a positive number")
