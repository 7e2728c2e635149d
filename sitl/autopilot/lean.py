"""Flying by lean: how steep is told from outside, and how fast to climb; where to is nobody's concern."""

from __future__ import annotations

import math

from sitl.autopilot.glide import Glide
from sitl.geo import GRAVITY_MPS2
from sitl.kernels import Quaternion, Triple
from sitl.signals import Setpoint

__all__ = ["leaning", "push_of", "turned"]

_STEEPEST = math.cos(math.radians(80.0))


def push_of(q_ned_frd: Quaternion) -> complex:
    """The acceleration, north + i·east, of a multicopter that leans so and keeps its height."""
    w, x, y, z = q_ned_frd
    north, east, down = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)
    return complex(north, east) * (-GRAVITY_MPS2 / max(down, _STEEPEST))


def turned(q_ned_frd: Quaternion, rate_frd_radps: Triple, dt_s: float) -> Quaternion:
    """The attitude `dt_s` later, when it turns at those rates about its own axes: q + ½·q·ω·dt, at unit length."""
    w, x, y, z = q_ned_frd
    p, q, r = (0.5 * dt_s * rate for rate in rate_frd_radps)
    moved = (
        w - x * p - y * q - z * r,
        x + w * p + y * r - z * q,
        y + w * q - x * r + z * p,
        z + w * r + x * q - y * p,
    )
    size = math.hypot(*moved)
    return moved[0] / size, moved[1] / size, moved[2] / size, moved[3] / size


def leaning(glide: Glide, push_mps2: complex) -> Setpoint:
    """The glide's height and heading, and that acceleration instead of a place and a speed."""
    nan = math.nan
    return Setpoint(
        (nan, nan, glide.down_m),
        (nan, nan, glide.down_speed_mps),
        (push_mps2.real, push_mps2.imag, glide.down_acceleration_mps2),
        glide.yaw_ned_rad,
        glide.yaw_rate_ned_radps,
    )
