"""What the setpoint follows: the way to the first point, the trajectory, or the way back."""

from __future__ import annotations

import math
from dataclasses import replace

from mavspiral.errors import LimitError
from mavspiral.flight.checks import parameter
from mavspiral.flight.follower import Follower
from mavspiral.flight.governor import GovernorLimits, Pace
from mavspiral.flight.messages import Target
from mavspiral.flight.reference import Reference, braking_s
from mavspiral.flight.situation import Situation
from mavspiral.frames import GeoPoint, yaw_ned_to_enu
from mavspiral.motion.trajectory import Trajectory, belongs

__all__ = ["prepare_join", "prepare_leave", "prepare_return", "prepare_stream"]

_JOIN_MPS = 1.0
_JOIN_RADPS = 0.5
_SINKS_M = 50.0


def prepare_join(s: Situation) -> None:
    """From where it hovers, as it looks, to the first point and its yaw."""
    assert s.reference is not None
    still = (0.0, 0.0, 0.0)
    first = s.reference.at(0.0)
    yaw = s.vehicle.yaw_ned_rad
    yaw = yaw if math.isfinite(yaw) else first.yaw_ned_rad
    here = Target(s.vehicle.position_ned_m, still, still, yaw, 0.0)
    join = Reference.move(here, first, speed_mps=_JOIN_MPS, yaw_rate_radps=_JOIN_RADPS)
    s.follower = Follower(
        join,
        s.config.governor,
        s.clock.at(s.now_us),
        feels_drag=s.profile.feels_drag,
        pace=Pace(0.0, 0.0, 0.0),
    )


def prepare_stream(s: Situation) -> None:
    """Begin the trajectory."""
    assert s.reference is not None
    s.follower = Follower(
        s.reference,
        s.config.governor,
        s.clock.at(s.now_us),
        lead_s=s.profile.lead_s,
        tilt_lead_s=s.profile.tilt_lead_s,
        turn_lead_s=s.profile.turn_lead_s,
        damping=_damping(s),
        feels_drag=s.profile.feels_drag,
    )


def _damping(s: Situation) -> float:
    name = s.profile.damping
    return (parameter(s.vehicle, s.profile, name) or 0.0) if name is not None else 0.0


def prepare_return(s: Situation) -> None:
    """Begin the way back to above home from where it can stop; refuses with a MavspiralError where there is none."""
    _begin_way(s, _way_home(s), s.config.governor)


def prepare_leave(s: Situation) -> None:
    """Begin only what of the way back leads away from the walls; refuses where that is nothing.

    Who sinks is not waited for.
    """
    leaving = tuple(leg for leg in _way_home(s).legs if belongs(leg.name, "leave"))
    if not leaving:
        raise LimitError("it is as far away from everything as it can be")
    _begin_way(s, Trajectory(leaving), replace(s.config.governor, reserve_m=_SINKS_M))


def _way_home(s: Situation) -> Trajectory:
    assert s.origin is not None and s.trajectory is not None
    if s.way_home is None:
        raise LimitError("no way home is known")
    s.to_vehicle = s.frame.to_vehicle(GeoPoint(*s.origin))
    velocity_ned_mps = s.vehicle.velocity_ned_mps
    stops_s = braking_s(velocity_ned_mps) / 2.0
    stop_ned_m = [p + stops_s * v for p, v in zip(s.vehicle.position_ned_m, velocity_ned_mps, strict=True)]
    here_enu_m = s.to_vehicle.position_enu_m(stop_ned_m)
    end = s.trajectory(s.trajectory.duration_s)
    yaw_ned_rad = s.vehicle.yaw_ned_rad
    if not math.isfinite(yaw_ned_rad) and s.follower is not None:
        yaw_ned_rad = s.follower.yaw_ned_rad  # it tells no attitude, so it looks where it was told to
    return s.way_home(here_enu_m, end.position_enu_m, float(yaw_ned_to_enu(yaw_ned_rad)))


def _begin_way(s: Situation, way: Trajectory, governor: GovernorLimits) -> None:
    assert s.to_vehicle is not None
    s.follower = Follower(
        Reference.of(way, s.to_vehicle).begun_in_flight(s.vehicle.velocity_ned_mps),
        governor,
        s.clock.at(s.now_us),
        feels_drag=s.profile.feels_drag,
    )
