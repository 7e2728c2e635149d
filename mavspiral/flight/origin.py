"""Where the vehicle's local frame begins: worked out for a vehicle that does not say so itself, and followed when it moves."""

from __future__ import annotations

from mavspiral.flight.messages import GlobalPosition, LocalPosition, Origin, Triple
from mavspiral.frames import GeoPoint, LocalFrame, enu_to_ned, ned_to_enu

__all__ = ["moved_ned_m", "origin_at", "origin_from_pair"]

_SIMULTANEOUS_MS = 50


def origin_from_pair(here: GlobalPosition, local: LocalPosition) -> Origin | None:
    """The origin that puts `local` at the place `here`; None where the two are not of the same moment.

    The tangent plane at the place itself gives it to first order; one correction by the plane at that guess
    leaves less than a millimetre at a kilometre.
    """
    if abs(here.time_boot_ms - local.time_boot_ms) > _SIMULTANEOUS_MS:
        return None
    place = GeoPoint(here.lat_deg, here.lon_deg, here.alt_amsl_m)
    local_enu_m = ned_to_enu([local.north_m, local.east_m, local.down_m])
    guess = LocalFrame(place).geo_point(-local_enu_m)
    missed_enu_m = LocalFrame(guess).point_enu_m(place) - local_enu_m
    better = LocalFrame(guess).geo_point(missed_enu_m)
    return Origin(better.lat_deg, better.lon_deg, better.alt_amsl_m)


def moved_ned_m(then: Origin, now: Origin) -> Triple:
    """Where the origin `now` lies in the frame that begins at `then`."""
    north_m, east_m, down_m = enu_to_ned(LocalFrame(GeoPoint(*then)).point_enu_m(GeoPoint(*now))).tolist()
    return north_m, east_m, down_m


def origin_at(origin: Origin, place_ned_m: Triple) -> Origin:
    """The origin that lies at `place_ned_m` of the frame that begins at `origin`."""
    place = LocalFrame(GeoPoint(*origin)).geo_point(ned_to_enu(place_ned_m))
    return Origin(place.lat_deg, place.lon_deg, place.alt_amsl_m)
