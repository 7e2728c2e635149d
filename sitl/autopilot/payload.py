"""Camera, gimbal and region of interest: what commands make of them, and when the camera shoots."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from sitl.condition import Condition
from sitl.geo import geodetic_of_ned, ned_of_geodetic
from sitl.plans import PlanItem
from sitl.rotation import from_euler, to_yaw
from sitl.signals import GeoPoint, vector
from sitl.status import Home, PayloadStatus, Shot

__all__ = ["Payload"]

_ROI_LOCATION_MODE = 3
_FOREVER = -1
_START_CAPTURE = 2000


@dataclass(frozen=True, slots=True)
class Payload:
    """What camera and gimbal have been told. `paused` triggers wait until the mission goes on.

    A distance of zero is none; an interval counts down `shots_left` pictures, -1 for ever. A distance is
    measured horizontally, as PX4 does it. NaN gimbal angles: it has not been told any.
    """

    distance_m: float = 0.0
    interval_s: float = 0.0
    shots_left: int = 0
    snap: bool = False
    number: float = 0.0
    last_us: int | None = None
    last_m: complex | None = None
    shots: int = 0
    paused: bool = False
    gimbal_pitch_rad: float = math.nan
    gimbal_yaw_rad: float = math.nan
    interest: GeoPoint | None = None
    controller: tuple[int, int] = (0, 0)

    def told(self, item: PlanItem, home: Home | None) -> Payload:
        """The payload after that command."""
        act = _ACTS.get(item.command)
        return self if act is None else act(self, item, home)

    def at_rest(self) -> Payload:
        """The payload without triggers, and without a region of interest."""
        return replace(self, distance_m=0.0, interval_s=0.0, shots_left=0, interest=None)

    def is_busy_for(self, item: PlanItem) -> bool:
        """Whether it cannot take a single picture that is ordered because the one before is not taken yet."""
        interval_s, count, number = item.params[1:4]
        single = item.command == _START_CAPTURE and (count == 1.0 or not interval_s > 0.0)
        return single and self.snap and not (number > 0.0 and number == self.number)

    @property
    def status(self) -> PayloadStatus:
        """What there is to tell of it; a gimbal that was never told looks along the nose."""
        counting = self.shots_left != 0
        pitch_rad, yaw_rad = self.gimbal_pitch_rad, self.gimbal_yaw_rad
        return PayloadStatus(
            self.shots,
            self.interval_s if counting else 0.0,
            pitch_rad if math.isfinite(pitch_rad) else 0.0,
            yaw_rad if math.isfinite(yaw_rad) else 0.0,
            self.controller,
        )

    @property
    def is_waiting(self) -> bool:
        """Whether a picture may be due some time."""
        return self.snap or (not self.paused and (self.distance_m > 0.0 or self.shots_left != 0))

    def look(self, condition: Condition) -> Payload:
        """The payload a frame later: `shots` has grown when it has shot."""
        north_m, east_m, _ = condition.estimate.position_ned_m.tolist()
        place_m, now_us = complex(north_m, east_m), condition.time_us
        counted = not self.paused and self.shots_left != 0
        due = self.snap
        due |= counted and (self.last_us is None or now_us - self.last_us >= 1e6 * self.interval_s)
        if self.distance_m > 0.0 and not self.paused:
            if self.last_m is None:
                return replace(self, last_m=place_m)
            due |= abs(place_m - self.last_m) >= self.distance_m
        if not due:
            return self
        left = self.shots_left - 1 if counted and self.shots_left > 0 else self.shots_left
        return replace(
            self, snap=False, last_us=now_us, last_m=place_m, shots=self.shots + 1, shots_left=left
        )

    def shot(self, condition: Condition, home: Home | None) -> Shot:
        """The picture that was taken just now."""
        origin, estimate = condition.origin, condition.estimate
        q = tuple(estimate.q_ned_frd.tolist())
        anchor = (math.nan,) * 3 if origin is None else (origin.lat_deg, origin.lon_deg, origin.alt_amsl_m)
        north_m, east_m, down_m = estimate.position_ned_m.tolist()
        point = GeoPoint(*geodetic_of_ned(anchor, (north_m, east_m, down_m)))
        if math.isfinite(self.gimbal_pitch_rad):
            pan_rad = self.gimbal_yaw_rad if math.isfinite(self.gimbal_yaw_rad) else 0.0
            q = from_euler(0.0, self.gimbal_pitch_rad, to_yaw(q) + pan_rad)
        height_m = (0.0 if home is None else float(home.position_ned_m[2])) - down_m
        return Shot(condition.time_us, self.shots - 1, point, height_m, vector(q, 4))

    def bearing_rad(self, condition: Condition) -> float:
        """Where the region of interest lies; NaN when there is none."""
        if self.interest is None or condition.origin is None:
            return math.nan
        origin, point = condition.origin, self.interest
        anchor = origin.lat_deg, origin.lon_deg, origin.alt_amsl_m
        north_m, east_m, _ = ned_of_geodetic(anchor, (point.lat_deg, point.lon_deg, origin.alt_amsl_m))
        here_north_m, here_east_m, _ = condition.estimate.position_ned_m.tolist()
        return math.atan2(east_m - here_east_m, north_m - here_north_m)


_Act = Callable[[Payload, PlanItem, Home | None], Payload]


def _mount(payload: Payload, item: PlanItem, _: Home | None) -> Payload:
    """DO_MOUNT_CONTROL: pitch, roll, yaw in degrees."""
    return _aimed(payload, item.params[0], item.params[2])


def _gimbal(payload: Payload, item: PlanItem, _: Home | None) -> Payload:
    """DO_GIMBAL_MANAGER_PITCHYAW: pitch and yaw in degrees, then their rates."""
    return _aimed(payload, item.params[0], item.params[1])


def _controlled(payload: Payload, item: PlanItem, _: Home | None) -> Payload:
    """DO_GIMBAL_MANAGER_CONFIGURE: who has control; -1 leaves it, -3 gives it back, 0 gives it to nobody."""
    system, component = item.params[:2]
    if system in (0.0, -3.0):
        return replace(payload, controller=(0, 0))
    if 0.0 < system < 256.0 and 0.0 <= component < 256.0:
        return replace(payload, controller=(int(system), int(component)))
    return payload


def _aimed(payload: Payload, pitch_deg: float, yaw_deg: float) -> Payload:
    return replace(
        payload, gimbal_pitch_rad=math.radians(pitch_deg), gimbal_yaw_rad=math.radians(yaw_deg), interest=None
    )


def _by_distance(payload: Payload, item: PlanItem, _: Home | None) -> Payload:
    """DO_SET_CAM_TRIGG_DIST: how far apart, shutter time, whether to shoot at once."""
    distance_m = max(0.0, item.params[0]) if math.isfinite(item.params[0]) else 0.0
    return replace(payload, distance_m=distance_m, last_m=None, snap=distance_m > 0.0 < item.params[2])


def _by_interval(payload: Payload, item: PlanItem, _: Home | None) -> Payload:
    """DO_SET_CAM_TRIGG_INTERVAL: milliseconds, here for ever; zero stops."""
    interval_ms = item.params[0]
    if interval_ms > 0.0:
        return replace(payload, interval_s=1e-3 * interval_ms, shots_left=_FOREVER, last_us=None)
    return replace(payload, interval_s=0.0, shots_left=0)


def _start(payload: Payload, item: PlanItem, _: Home | None) -> Payload:
    """IMAGE_START_CAPTURE: param2 seconds apart, param3 pictures; zero of them is no end.

    A single picture may be numbered by param4: told again under the same number, it is not taken again.
    """
    interval_s, count, number = item.params[1:4]
    if count == 1.0 or not interval_s > 0.0:
        if number > 0.0 and number == payload.number:
            return payload
        return replace(payload, snap=True, number=number if number > 0.0 else 0.0)
    shots_left = int(count) if 0.0 < count < math.inf else _FOREVER
    return replace(payload, interval_s=interval_s, shots_left=shots_left, last_us=None)


def _stop(payload: Payload, _item: PlanItem, _: Home | None) -> Payload:
    return replace(payload, interval_s=0.0, shots_left=0)


def _digicam(payload: Payload, item: PlanItem, _: Home | None) -> Payload:
    """DO_DIGICAM_CONTROL: param5 is one to shoot."""
    return replace(payload, snap=payload.snap or item.params[4] == 1.0)


def _interest(payload: Payload, item: PlanItem, home: Home | None) -> Payload:
    lat_deg, lon_deg, alt_m = item.params[4:]
    base_m = home.point.alt_amsl_m if home is not None and item.is_relative else 0.0
    return replace(payload, interest=GeoPoint(lat_deg, lon_deg, base_m + alt_m))


def _any_interest(payload: Payload, item: PlanItem, home: Home | None) -> Payload:
    """DO_SET_ROI: only a location is looked at; the kinds that follow waypoints look at nothing here."""
    if item.has_place and item.params[0] == _ROI_LOCATION_MODE:
        return _interest(payload, item, home)
    return replace(payload, interest=None)


def _no_interest(payload: Payload, _item: PlanItem, _: Home | None) -> Payload:
    return replace(payload, interest=None)


_ACTS: Mapping[int, _Act] = {
    80: _any_interest,  # NAV_ROI
    195: _interest,  # DO_SET_ROI_LOCATION
    197: _no_interest,  # DO_SET_ROI_NONE
    201: _any_interest,  # DO_SET_ROI
    203: _digicam,
    205: _mount,
    206: _by_distance,
    214: _by_interval,
    1000: _gimbal,
    1001: _controlled,
    _START_CAPTURE: _start,
    2001: _stop,
}
