"""The frame in which the vehicle lives. A room of its own: whoever only keeps time loads no kernels."""

from __future__ import annotations

__all__ = ["EPOCH_UNIX_US", "FRAME_S", "FRAME_US"]

FRAME_US = 10_000
"""4 steps of physics and cascade, 2 IMU samples, one word of its commander."""
FRAME_S = 1e-6 * FRAME_US
EPOCH_UNIX_US = 1_767_225_600_000_000
"""What the vehicle takes for the date at its start: 2026-01-01. A real clock would make flights differ."""
