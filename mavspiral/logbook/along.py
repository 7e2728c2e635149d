"""A flight that followed no clock of ours, laid along the path that was planned: by truth, where it was nearest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.flight.flight_log import FlightLog
from mavspiral.motion.nearest import path_times_s
from mavspiral.motion.trajectory import Trajectory
from mavspiral.survey.shots import Shots, shots_at

__all__ = ["log_along", "pictures_along"]


def log_along(log: FlightLog, trajectory: Trajectory) -> FlightLog:
    """The log of a flight that followed no clock of ours: the reference of each row is the nearest point, by truth."""
    assert log.truth_position_enu_m is not None
    path_t_s = path_times_s(trajectory, log.truth_position_enu_m)
    states = trajectory(path_t_s)
    begins_s = [trajectory.span_s(leg.name)[0] for leg in trajectory.legs]
    return replace(
        log,
        path_t_s=path_t_s,
        leg=np.searchsorted(begins_s, path_t_s, side="right") - 1,
        reference_position_enu_m=states.position_enu_m,
        reference_velocity_enu_mps=states.velocity_enu_mps,
        reference_yaw_enu_rad=states.yaw_enu_rad,
    )


def pictures_along(log: FlightLog, vehicle_s: FloatArray, trajectory: Trajectory) -> Shots:
    """The pictures taken at those times of the vehicle's clock, from where it truly was; pitch as planned for the place."""
    assert log.truth_position_enu_m is not None and log.truth_yaw_enu_rad is not None
    if not len(log.vehicle_s):  # it never left the ground
        return Shots(np.empty(0), np.empty((0, 3)), np.empty(0), np.empty(0))
    logged = (vehicle_s >= log.vehicle_s[0]) & (vehicle_s <= log.vehicle_s[-1])
    path_t_s = np.interp(vehicle_s[logged], log.vehicle_s, log.path_t_s)
    pitch_rad = trajectory(log.path_t_s).gimbal_pitch_rad
    posed = shots_at(
        vehicle_s[logged], log.vehicle_s, log.truth_position_enu_m, log.truth_yaw_enu_rad, pitch_rad
    )
    return replace(posed, t_s=path_t_s)
