"""Whether the estimator errs as it says: NEES and NIS over flights of a circle, seed by seed.

Bar-Shalom, Li and Kirubarajan, "Estimation with Applications to Tracking and Navigation" (2001), section
5.4.2: over N runs the sum of the normalised squares is chi-square with N times the degrees of freedom.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

from sitl.airframe import RECEIVERS, Airframe
from sitl.estimator.belief import wander_m2
from sitl.estimator.error_state import transition
from sitl.estimator.strapdown import HORIZON_FRAMES, PREDICT_S
from sitl.geo import ned_of_geodetic
from sitl.params import Params
from sitl.rotation import multiply
from sitl.signals import Demand, GeoPoint, Setpoint
from sitl.vehicle import Vehicle, VehicleConfig

STATES = 15
DOF = {"position": 3, "velocity": 3, "baro": 1, "mag": 3}
_NOTHING = (math.nan,) * 3
_AHEAD_S = (HORIZON_FRAMES - 1) * PREDICT_S
"""How far the output lies ahead of the horizon."""


class Flown(NamedTuple):
    """One flight: NEES at each look, and of each sense the NIS of the measurement that came last."""

    nees: list[float]
    nis: dict[str, list[float]]


def as_modelled(airframe: Airframe) -> dict:
    """A config whose senses err as the filter supposes: white noise and walking biases, nothing else."""
    plain = {
        "baro_drift_m": 0.0,
        "baro_wash_m": 0.0,
        "baro_speed_share": 0.0,
        "accel_scale": 0.0,
        "gyro_scale": 0.0,
    }
    senses = dataclasses.replace(airframe.senses, **plain)
    white = RECEIVERS["rtk"]._replace(wander_h_m=0.0, wander_v_m=0.0)
    # A gate cuts the tails off what it lets through.
    wide = dict.fromkeys(("EKF2_MAG_GATE", "EKF2_BARO_GATE", "EKF2_GPS_P_GATE", "EKF2_GPS_V_GATE"), 30.0)
    return {"airframe": dataclasses.replace(airframe, senses=senses), "gps": white, "params": wide}


def bounds(dof: int, runs: int) -> tuple[float, float]:
    """Between which the mean over so many runs lies 95 times of 100, by its degrees of freedom."""
    low, high = chi2.ppf([0.025, 0.975], dof * runs) / (dof * runs)
    return float(low), float(high)


def error(one: Vehicle) -> tuple[np.ndarray, np.ndarray]:
    """Truth less estimate in the filter's 15 error states, at the output, and their covariance there.

    An accelerometer's bias is what it adds to a steady force: its scale's error is part of it.
    """
    truth, told, sensed = one.truth, one.estimate, one._world["sensed"][0]
    home, origin = one.config.home, one.origin
    there = (home.lat_deg, home.lon_deg, home.alt_amsl_m)
    anchor = np.array(ned_of_geodetic(there, (origin.lat_deg, origin.lon_deg, origin.alt_amsl_m)))
    q = told.q_ned_frd
    dq = multiply((q[0], -q[1], -q[2], -q[3]), truth.q_ned_frd)
    force = one._world["body"]["specific_force_frd_mps2"][0]
    bias = sensed["imu_bias"]
    e = np.concatenate(
        [
            truth.position_ned_m - told.position_ned_m - anchor,
            truth.velocity_ned_mps - told.velocity_ned_mps,
            2.0 * np.array(dq[1:]) * np.sign(dq[0]),
            bias[3:] - told.gyro_bias_frd_radps,
            bias[:3] + (sensed["imu_scale"][:3] - 1.0) * force - told.accel_bias_frd_mps2,
        ]
    )
    nav = one._ekf.nav[0]
    F = transition(q, nav["mean_force"], nav["mean_rate"], _AHEAD_S)
    P = F @ one._ekf.filter.P @ F.T
    P[range(3), range(3)] += wander_m2(one._ekf.nav, one._ekf.book, one._ekf.sheet)
    return e, P


def demand(p=_NOTHING, v=_NOTHING, a=_NOTHING, armed=True) -> Demand:
    """What to fly, nose north."""
    return Demand(armed, False, Setpoint(p, v, a, 0.0, math.nan))


DISARMED = demand(armed=False)


def circle(seconds: float) -> Iterator[tuple[int, Demand]]:
    """10 m at 3 m/s by 50 Hz setpoints, after 15 s of climb: until when, and what."""
    yield 3_000_000, DISARMED
    yield 18_000_000, demand((10.0, 0.0, -10.0))
    for k in range(round(50 * seconds)):
        c, s = math.cos(0.006 * k), math.sin(0.006 * k)
        order = demand((10 * c, 10 * s, -10.0), (-3 * s, 3 * c, 0.0), (-0.9 * c, -0.9 * s, 0.0))
        yield 18_020_000 + 20_000 * k, order


def fly(airframe: Airframe, seed: int, seconds: float = 40.0, params: dict | None = None, **config) -> Flown:
    """One flight, looked at every five seconds on the circle."""
    home = GeoPoint(19.4332, -99.1412, 2240.0)
    chosen = Params(airframe.params).replace(**(params or {}))
    one = Vehicle(
        VehicleConfig(airframe, chosen, home, seed=seed, heading_ned_rad=0.3 * seed % 6.0, **config)
    )
    latest: dict[str, float] = {}
    fuse, filt = one._ekf.filter.fuse, one._ekf.filter

    def noted(z, expected, H, R, gate) -> bool:
        y = z - expected
        place, speed = H[0, 0] == 1.0, H[0, 3] == 1.0
        name = "position" if place else "velocity" if speed else "baro" if len(y) == 1 else "mag"
        latest[name] = float(y @ np.linalg.solve(H @ filt.P @ H.T + R, y)) / len(y)
        return fuse(z, expected, H, R, gate)

    filt.fuse, one._ekf.stepwise = noted, True
    flown = Flown([], {name: [] for name in DOF})
    for until_us, order in circle(seconds):
        one.advance(until_us, order)
        if until_us > 18_020_000 and (until_us - 18_000_000) % 5_000_000 == 0:
            e, P = error(one)
            flown.nees.append(float(e @ np.linalg.solve(P, e)) / STATES)
            for name, seen in flown.nis.items():
                seen.append(latest[name])
    return flown
