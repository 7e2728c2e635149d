"""The frame in which the vehicle lives. A room of its own: whoever only keeps time loads no kernels."""

from __future__ import annotations

__all__ = ["FRAME_S", "FRAME_US"]

FRAME_US = 10_000
"""4 steps of physics and cascade, 2 IMU samples, one word of its commander."""
FRAME_S = 1e-6 * FRAME_US
