"""Where the vehicle's local frame begins, for a vehicle that does not say so itself."""

from __future__ import annotations

from mavspiral.flight.messages import GlobalPosition, LocalPosition, Origin
from mavspiral.frames import GeoPoint, LocalFrame, ned_to_enu

__all__ = ["origin_from_pair"]

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
