"""How the absolute heights of a survey become heights above the mission's ground.

The rule is one for every format with absolute heights (CityJSON, DSM, point cloud):

    height_agl_m = z · (metres per unit of z) − ground_amsl_m

What the file itself shows as the building's ground is only compared with `ground_amsl_m`: a few metres apart is
said, far apart is refused, unless the file's ground lies at 0, so that its heights are above ground already.
"""

from __future__ import annotations

from mavspiral.errors import InputError
from mavspiral.shape.site_map import MapRequest

__all__ = ["datum_of"]

SAID_M = 2.0
REFUSED_M = 15.0
FOOT_M = 0.3048


def datum_of(request: MapRequest, base_m: float, what: str) -> tuple[float, tuple[str, ...]]:
    """The height of the file, in metres, that is the mission's ground; and what to say about it.

    Args:
        request: its `ground_amsl_m` is the datum.
        base_m: where the building meets the ground, by the file.
        what: how a message calls that base.

    Raises:
        InputError: the two grounds cannot be the same place.
    """
    ground_m = request.ground_amsl_m
    off_m = base_m - ground_m
    if abs(off_m) <= SAID_M:
        return ground_m, ()
    facts = f"{what} is at {base_m:.2f} m, [building] ground_amsl_m = {ground_m:g}"
    if abs(off_m) <= REFUSED_M:
        side = "above" if off_m > 0 else "below"
        return ground_m, (
            f"{facts}: the building's foot is {abs(off_m):.1f} m {side} the mission's ground; heights are z − ground_amsl_m",
        )
    if abs(base_m) <= SAID_M:
        return 0.0, (f"{facts}: the map's heights are taken to be above ground already",)
    feet = abs(base_m * FOOT_M - ground_m) <= REFUSED_M
    raise InputError(
        f"{request.path}: {facts}: they cannot be the same ground. "
        + (
            f"{base_m:.0f} ft would be {base_m * FOOT_M:.0f} m. Fix: convert the map's heights from feet to metres"
            if feet
            else f"Fix: set ground_amsl_m = {base_m:.1f}, or shift the map's heights (ellipsoidal ones?) to mean sea level"
        )
    )
