"""The ground: level, each foot a spring and damper on it with Coulomb friction; who has tipped over lies on its rotors' hubs."""

from __future__ import annotations

import math

import numpy as np

from sitl.geo import GRAVITY_MPS2
from sitl.kernels import Quaternion, Triple, kernel
from sitl.rotation import rotate, unrotate

__all__ = ["ground_holds", "ground_load"]

_STILL_MPS = 0.02
_STILL_RADPS = 0.05
_SETTLED, _UNSETTLED = 0.1, 0.5


@kernel
def ground_load(
    position: Triple, velocity: Triple, q: Quaternion, rate: Triple, plant: np.record
) -> tuple[Triple, Triple]:
    """Force and torque of the feet and hubs, FRD."""
    fx = fy = fz = tx = ty = tz = 0.0
    for i in range(8):
        x, y, z = plant.contact_frd_m[i, 0], plant.contact_frd_m[i, 1], plant.contact_frd_m[i, 2]
        sink = position[2] + rotate(q, (x, y, z))[2] - plant.ground_down_m
        if sink <= 0.0:
            continue
        swing = rotate(q, (rate[1] * z - rate[2] * y, rate[2] * x - rate[0] * z, rate[0] * y - rate[1] * x))
        un, ue, ud = velocity[0] + swing[0], velocity[1] + swing[1], velocity[2] + swing[2]
        normal = max(0.0, plant.foot_spring_npm * sink + plant.foot_damper_nspm * ud)
        slide = math.sqrt(un * un + ue * ue)
        grip = plant.foot_grip_nspm
        if grip * slide > plant.friction * normal:
            grip = plant.friction * normal / slide
        ax, ay, az = unrotate(q, (-grip * un, -grip * ue, -normal))
        fx += ax
        fy += ay
        fz += az
        tx += y * az - z * ay
        ty += z * ax - x * az
        tz += x * ay - y * ax
    return (fx, fy, fz), (tx, ty, tz)


@kernel
def ground_holds(
    position: Triple,
    velocity: Triple,
    q: Quaternion,
    rate: Triple,
    force: Triple,
    torque: Triple,
    plant: np.record,
) -> bool:
    """Whether the ground holds it: all feet down (or all hubs), hardly moving, the load (FRD) inside the friction cone.

    A standing vehicle is then left exactly where it is; regularised friction alone would let it creep in
    the wind.
    """
    speed = math.sqrt(velocity[0] ** 2 + velocity[1] ** 2 + velocity[2] ** 2)
    if speed > _STILL_MPS:
        return False
    if rate[0] ** 2 + rate[1] ** 2 + rate[2] ** 2 > _STILL_RADPS**2:
        return False
    spring = 0.0
    first = 0 if rotate(q, (0.0, 0.0, 1.0))[2] > 0.0 else 4
    for i in range(first, first + 4):
        foot = (plant.contact_frd_m[i, 0], plant.contact_frd_m[i, 1], plant.contact_frd_m[i, 2])
        sink = position[2] + rotate(q, foot)[2] - plant.ground_down_m
        if sink <= 0.0:
            return False
        spring += plant.foot_spring_npm * sink
    fn, fe, fd = rotate(q, force)
    weight = fd + plant.mass_kg * GRAVITY_MPS2
    # Still, but at the turning point of a bounce? Once held it stays so until the legs are much too bent.
    if abs(spring - weight) > (_SETTLED if speed > 0.0 else _UNSETTLED) * weight:
        return False
    foot = (plant.contact_frd_m[first, 0], plant.contact_frd_m[first, 1], plant.contact_frd_m[first, 2])
    x, y, z = abs(foot[0]), abs(foot[1]), foot[2]
    return bool(
        fn * fn + fe * fe <= (plant.friction * weight) ** 2
        and abs(torque[0] - z * force[1]) <= weight * y
        and abs(torque[1] + z * force[0]) <= weight * x
        and abs(torque[2]) <= plant.friction * weight * min(x, y)
    )
