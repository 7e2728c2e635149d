"""The trajectory as a table that any tool reads."""

from __future__ import annotations

import numpy as np

from mavspiral.export.geotags import photo_name
from mavspiral.frames import LocalFrame, wrap_rad, yaw_enu_to_ned
from mavspiral.motion.trajectory import Trajectory
from mavspiral.survey.shots import Shots

__all__ = ["photos_csv", "trajectory_csv"]

COLUMNS = (
    "t_s,lat_deg,lon_deg,alt_amsl_m,east_m,north_m,up_m,velocity_east_mps,velocity_north_mps,velocity_up_mps,"
    "acceleration_east_mps2,acceleration_north_mps2,acceleration_up_mps2,yaw_ned_deg,yaw_rate_ned_dps,"
    "gimbal_pitch_deg,leg"
)
PHOTO_COLUMNS = "name,seq,t_s,lat,lon,alt_amsl_m,yaw_ned_deg,pitch_deg"
GRID_S = 0.1


def trajectory_csv(trajectory: Trajectory, frame: LocalFrame) -> str:
    """One row every 0.1 s: time, place, motion, heading, camera, leg; a head line names columns and units."""
    states = trajectory.sampled(GRID_S)
    lat, lon, alt = frame.to_geodetic(states.position_enu_m)
    ends_s = np.cumsum([leg.law.duration_s for leg in trajectory.legs])
    legs = [trajectory.legs[i].name for i in np.minimum(np.searchsorted(ends_s, states.t_s), len(ends_s) - 1)]
    yaw_ned_deg = np.degrees(wrap_rad(yaw_enu_to_ned(states.yaw_enu_rad)))
    rows = [COLUMNS]
    for i, leg in enumerate(legs):
        motion = (*states.position_enu_m[i], *states.velocity_enu_mps[i], *states.acceleration_enu_mps2[i])
        turning = (
            yaw_ned_deg[i],
            -np.degrees(states.yaw_rate_enu_radps[i]),
            np.degrees(states.gimbal_pitch_rad[i]),
        )
        rows.append(
            f"{states.t_s[i]:.2f},{lat[i]:.8f},{lon[i]:.8f},{alt[i]:.3f},"
            + ",".join(f"{value + 0.0:.4f}" for value in (*motion, *turning))
            + f",{leg}"
        )
    return "\n".join(rows) + "\n"


def photos_csv(shots: Shots, frame: LocalFrame, first_photo: str) -> str:
    """One row for each shot: its picture's name if none is missed, its number from 0, path time, place, heading and pitch.

    Pitch is the camera's, positive upwards.
    """
    lat, lon, alt = frame.to_geodetic(shots.position_enu_m)
    yaw_ned_deg = np.degrees(wrap_rad(yaw_enu_to_ned(shots.yaw_enu_rad)))
    pitch_deg = np.degrees(shots.pitch_rad)
    rows = [PHOTO_COLUMNS]
    rows += [
        f"{photo_name(first_photo, seq)},{seq},{shots.t_s[seq]:.3f},{lat[seq]:.8f},{lon[seq]:.8f},{alt[seq]:.3f},"
        f"{yaw_ned_deg[seq] + 0.0:.2f},{pitch_deg[seq] + 0.0:.2f}"
        for seq in range(len(shots))
    ]
    return "\n".join(rows) + "\n"
