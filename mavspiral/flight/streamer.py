"""The setpoints of a flight, each of its moment, and the log of where all things were."""

from __future__ import annotations

import math
from bisect import bisect_right

from mavspiral.flight.flight_log import NO_LEG, Recorder
from mavspiral.flight.follower import Follower
from mavspiral.flight.schedule import Schedule
from mavspiral.flight.situation import Situation

__all__ = ["Streamer"]

_FRESH_US = 300_000  # older telemetry does not tell where the vehicle is: path time stands
_LONGEST_ADVANCE_S = 0.1
_STALL_S = 0.3
_GOING_AGAIN = 0.5
_NO_PACE = (math.nan, math.nan)


class Streamer:
    """Makes the setpoint that is due, counts it and writes its row of the log."""

    def __init__(self, situation: Situation) -> None:
        self.schedule = Schedule(round(1e6 / situation.config.rate_hz))
        self.recorder = Recorder()
        self._s = situation
        self._leg = NO_LEG
        self._stands = False

    def tick(self, *, streams: bool, moves: bool) -> bytes:
        """The setpoint of this moment; nothing unless something `streams`. Path time runs if it `moves`."""
        s = self._s
        now_us, follower, schedule = s.now_us, s.follower, self.schedule
        vehicle_us = s.clock.at(now_us)
        if follower is None or not streams:
            schedule.paused()
            self.recorder.row(now_us, vehicle_us, NO_LEG, _NO_PACE, None, s.vehicle)
            return b""
        holds = not moves or now_us - s.local_us >= _FRESH_US
        longest_s = _LONGEST_ADVANCE_S * max(1.0, s.clock.rate)
        setpoint = follower.advance(vehicle_us, longest_s=longest_s, hold=holds)
        path_t_s, rate, _ = follower.pace
        if follower.reference is not s.reference:
            path_t_s = math.nan
        elif (leg := bisect_right(s.leg_begins_s, path_t_s) - 1) != self._leg:
            self._tell_leg(leg)
        if moves and (rate == 0.0 or self._stands):
            self._tell_pace(follower)
        self.recorder.row(now_us, vehicle_us, self._leg, (path_t_s, rate), follower.due, s.vehicle)
        if (gap_s := schedule.sent(now_us)) > _STALL_S:
            s.tell("warning", f"no setpoint went out for {gap_s:.2f} s")
        profile, offset_ned_m = s.profile, s.vehicle.offset_ned_m
        if offset_ned_m is not None:
            north_m, east_m, down_m, *rest = setpoint
            n, e, d = offset_ned_m
            setpoint = (north_m + n, east_m + e, down_m + d, *rest)  # type: ignore[assignment]
        return s.link.setpoint(
            int(vehicle_us / 1000),
            setpoint,
            type_mask=profile.type_mask,
            coordinate_frame=profile.coordinate_frame,
        )

    def _tell_leg(self, leg: int) -> None:
        assert self._s.trajectory is not None
        self._leg = leg
        self._s.tell("info", f"leg {self._s.trajectory.legs[leg].name}")

    def _tell_pace(self, follower: Follower) -> None:
        if not self._stands and follower.pace.rate == 0.0:
            self._stands = True
            self._s.tell("warning", f"waiting: the vehicle is {follower.error_m:.1f} m off, or is not heard")
        elif self._stands and follower.pace.rate > _GOING_AGAIN:
            self._stands = False
            self._s.tell("info", "going on")
