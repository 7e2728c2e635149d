"""What a setpoint's acceleration must say, so that the vehicle does what the reference's acceleration means.

Two things stand between the two. PX4 takes D = MPC_XY_VEL_D_ACC of the acceleration that it measures off again, so
(1 + D)·a makes a. And in air a multirotor is slowed by about k·v, because its rotors' drag grows with its speed
(Faessler et al. 2018). A steady slowing PX4 makes up for by an integral, but around a building its direction turns all the
time: untold of both, PX4 flies 0.25 m behind and 0.2 m outside at 5 m/s. D is read from the vehicle. k is learned in
flight, slowly and from the lag along the way alone, so wind, whose push reverses with every half turn, is not
mistaken for it.
"""

from __future__ import annotations

__all__ = ["DRAG_TYPICAL_PER_S", "damped_gain", "learned_drag"]

LEARN_PER_M_S2 = 0.02
"""PX4 lags about 0.6 m for each m/s² that it is not told of: at 5 m/s this learns in 17 s."""

DRAG_TYPICAL_PER_S = 0.1
"""What is believed before anything is learned."""

DRAG_MAX_PER_S = 0.3
DAMPING_MAX = 0.5
SLOWEST_MPS = 1.0


def learned_drag(drag_per_s: float, lag_m: float, speed_mps: float, dt_s: float) -> float:
    """The k after `dt_s` in which the vehicle was `lag_m` behind on its way at `speed_mps`."""
    if speed_mps < SLOWEST_MPS or not 0.0 < dt_s < 1.0:
        return drag_per_s
    return min(max(drag_per_s + LEARN_PER_M_S2 * lag_m * dt_s, 0.0), DRAG_MAX_PER_S)


def damped_gain(damping: float) -> float:
    """What an acceleration is multiplied by for a vehicle that takes the share `damping` of it off again: 1 + D."""
    return 1.0 + min(max(damping, 0.0), DAMPING_MAX)
