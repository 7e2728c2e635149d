"""The body: six degrees of freedom, four lagging rotors, drag against the air, feet on the ground.

Rotor i pulls with k ω² along -z, drags with c ω v across its shaft and twists with ±κ k ω²; the airframe
drags with ½ ρ A |v| v on each axis. At a height z over the ground a rotor of radius R pulls 1 / (1 - (R/4z)²)
as much (Cheeseman and Bennett, "The effect of the ground on a helicopter rotor in forward flight", ARC R&M
3021, 1957, in hover; theirs is at equal power, taken here at equal rotor speed). Integrated by the classic
Runge–Kutta method; the rotors' first-order lag, which nothing feeds back into, is taken exactly.
"""

from __future__ import annotations

import math

import numpy as np

from sitl.airframe import Airframe
from sitl.geo import GRAVITY_MPS2
from sitl.kernels import FloatArray, Quaternion, Triple, inlined_kernel, kernel
from sitl.physics.ground import ground_holds, ground_load
from sitl.rotation import multiply, normalized, rotate, unrotate

__all__ = ["BODY", "PLANT", "STEP_S", "cushion", "new_body", "new_plant", "step"]

STEP_S = 0.0025

BODY = np.dtype(
    [
        ("position_ned_m", "f8", 3),
        ("velocity_ned_mps", "f8", 3),
        ("q_ned_frd", "f8", 4),
        ("rate_frd_radps", "f8", 3),
        ("rotor_speed_radps", "f8", 4),
        ("specific_force_frd_mps2", "f8", 3),  # mean over the last step, as is the next
        ("mean_rate_frd_radps", "f8", 3),
    ]
)
"""The state, and what an accelerometer and a gyro averaged over the last step."""

PLANT = np.dtype(
    [
        ("mass_kg", "f8"),
        ("inertia_kgm2", "f8", 3),
        ("drag_ns2pm2", "f8", 3),
        ("rotor_frd_m", "f8", (4, 3)),
        ("spin", "f8", 4),
        ("rotor_radius_m", "f8"),
        ("cushion", "f8", 4),  # each rotor's gain of thrust by the ground
        ("thrust_n_per_radps2", "f8", 4),
        ("torque_per_thrust_m", "f8"),
        ("rotor_drag_n_per_radps_mps", "f8"),
        ("decay_up", "f8"),  # what half a step leaves of a rotor's speed error
        ("decay_down", "f8"),
        ("contact_frd_m", "f8", (8, 3)),  # the feet, then the rotors' hubs
        ("foot_spring_npm", "f8"),
        ("foot_damper_nspm", "f8"),
        ("foot_grip_nspm", "f8"),
        ("friction", "f8"),
        ("ground_down_m", "f8"),
        ("wind_ned_mps", "f8", 3),
    ]
)
"""What the body is and what surrounds it. Faults and wind write into it between steps."""

AIR_DENSITY_KGPM3 = 1.225
_FOOT_DAMPING_RATIO = 0.7
_CUSHION_RADII = 10.0  # higher up the ground adds less than 1/1600
_GRIP_PER_S = 20.0  # a sliding foot's viscous limit: stiff, yet slow enough for the step


def new_plant(airframe: Airframe, ground_down_m: float) -> np.ndarray:
    """One PLANT: the airframe in calm air over level ground on which it stands at `ground_down_m`."""
    plant = np.zeros(1, PLANT)
    p = plant[0]
    body, rotors, ground = airframe.body, airframe.rotors, airframe.ground
    p["mass_kg"] = body.mass_kg
    p["inertia_kgm2"] = body.inertia_kgm2
    p["drag_ns2pm2"] = 0.5 * AIR_DENSITY_KGPM3 * body.drag_area_m2
    p["rotor_frd_m"] = rotors.position_frd_m
    p["rotor_radius_m"], p["cushion"] = rotors.radius_m, 1.0
    p["spin"] = rotors.spin
    p["thrust_n_per_radps2"] = rotors.thrust_n_per_radps2
    p["torque_per_thrust_m"] = rotors.torque_per_thrust_m
    p["rotor_drag_n_per_radps_mps"] = rotors.drag_n_per_radps_mps
    p["decay_up"] = math.exp(-0.5 * STEP_S / rotors.time_constant_up_s)
    p["decay_down"] = math.exp(-0.5 * STEP_S / rotors.time_constant_down_s)
    p["contact_frd_m"][:4, :2] = ground.feet_frd_m
    p["contact_frd_m"][:4, 2] = ground.leg_height_m
    p["contact_frd_m"][4:] = rotors.position_frd_m
    spring = body.mass_kg * GRAVITY_MPS2 / ground.sink_m / 4.0
    p["foot_spring_npm"] = spring
    p["foot_damper_nspm"] = _FOOT_DAMPING_RATIO * math.sqrt(spring * body.mass_kg)
    p["foot_grip_nspm"] = _GRIP_PER_S * body.mass_kg
    p["friction"] = ground.friction
    p["ground_down_m"] = ground_down_m + ground.leg_height_m - ground.sink_m
    return plant


def new_body(q_ned_frd: Quaternion, position_ned_m: Triple) -> np.ndarray:
    """One BODY at rest with its rotors still."""
    body = np.zeros(1, BODY)
    body["q_ned_frd"] = q_ned_frd
    body["position_ned_m"] = position_ned_m
    return body


@inlined_kernel
def _air_load(velocity: Triple, q: Quaternion, rotor: Quaternion, plant: np.record) -> tuple[Triple, Triple]:
    """Force and torque of the air, FRD."""
    wind = plant.wind_ned_mps
    vx, vy, vz = unrotate(q, (velocity[0] - wind[0], velocity[1] - wind[1], velocity[2] - wind[2]))
    speed = math.sqrt(vx * vx + vy * vy + vz * vz)
    fx = -plant.drag_ns2pm2[0] * speed * vx
    fy = -plant.drag_ns2pm2[1] * speed * vy
    fz = -plant.drag_ns2pm2[2] * speed * vz
    tx = ty = tz = 0.0
    for i in range(4):
        shaft = plant.thrust_n_per_radps2[i] * rotor[i] * rotor[i]
        thrust = plant.cushion[i] * shaft
        drag = plant.rotor_drag_n_per_radps_mps * rotor[i]
        x, y, z = plant.rotor_frd_m[i, 0], plant.rotor_frd_m[i, 1], plant.rotor_frd_m[i, 2]
        dx, dy = -drag * vx, -drag * vy
        fx += dx
        fy += dy
        fz -= thrust
        tx += -y * thrust - z * dy
        ty += x * thrust + z * dx
        tz += x * dy - y * dx + plant.spin[i] * plant.torque_per_thrust_m * shaft
    return (fx, fy, fz), (tx, ty, tz)


@kernel
def cushion(position: Triple, q: Quaternion, plant: np.record) -> None:
    """Set `plant.cushion` for where the rotors are; a rotor lower than half its radius gains no more."""
    radius = plant.rotor_radius_m
    centre = plant.ground_down_m - position[2]
    if centre > _CUSHION_RADII * radius + 1.0:
        for i in range(4):
            plant.cushion[i] = 1.0
        return
    for i in range(4):
        rotor = (plant.rotor_frd_m[i, 0], plant.rotor_frd_m[i, 1], plant.rotor_frd_m[i, 2])
        ratio = 0.25 * radius / max(centre - rotate(q, rotor)[2], 0.5 * radius)
        plant.cushion[i] = 1.0 / (1.0 - ratio * ratio)


@inlined_kernel
def _slope(
    position: Triple,
    velocity: Triple,
    q: Quaternion,
    rate: Triple,
    rotor: Quaternion,
    near: bool,
    plant: np.record,
) -> tuple[Triple, Triple, Triple]:
    """Acceleration (NED), specific force (FRD) and angular acceleration (FRD): Newton and Euler."""
    force, torque = _air_load(velocity, q, rotor, plant)
    fx, fy, fz = force
    tx, ty, tz = torque
    if near:
        force, torque = ground_load(position, velocity, q, rate, plant)
        fx, fy, fz = fx + force[0], fy + force[1], fz + force[2]
        tx, ty, tz = tx + torque[0], ty + torque[1], tz + torque[2]
    sx, sy, sz = fx / plant.mass_kg, fy / plant.mass_kg, fz / plant.mass_kg
    an, ae, ad = rotate(q, (sx, sy, sz))
    jx, jy, jz = plant.inertia_kgm2[0], plant.inertia_kgm2[1], plant.inertia_kgm2[2]
    turn = (
        (tx - (jz - jy) * rate[1] * rate[2]) / jx,
        (ty - (jx - jz) * rate[2] * rate[0]) / jy,
        (tz - (jy - jx) * rate[0] * rate[1]) / jz,
    )
    return (an, ae, ad + GRAVITY_MPS2), (sx, sy, sz), turn


@kernel
def _moved(a: Triple, b: Triple, h: float) -> Triple:
    return a[0] + h * b[0], a[1] + h * b[1], a[2] + h * b[2]


@kernel
def _turning(q: Quaternion, rate: Triple) -> Quaternion:
    a, b, c, d = multiply(q, (0.0, rate[0], rate[1], rate[2]))
    return 0.5 * a, 0.5 * b, 0.5 * c, 0.5 * d


@kernel
def _turned(q: Quaternion, dq: Quaternion, h: float) -> Quaternion:
    return q[0] + h * dq[0], q[1] + h * dq[1], q[2] + h * dq[2], q[3] + h * dq[3]


@kernel
def _simpson(a: Triple, b: Triple, c: Triple, d: Triple) -> Triple:
    return (
        (a[0] + 2.0 * (b[0] + c[0]) + d[0]) / 6.0,
        (a[1] + 2.0 * (b[1] + c[1]) + d[1]) / 6.0,
        (a[2] + 2.0 * (b[2] + c[2]) + d[2]) / 6.0,
    )


@kernel
def _spin(speed: FloatArray, plant: np.record, target: FloatArray) -> None:
    """Half a step of the rotors' lag. Below 1e-6 rad/s they stand, lest the floats denormalise."""
    for i in range(4):
        decay = plant.decay_up if target[i] > speed[i] else plant.decay_down
        speed[i] = target[i] + (speed[i] - target[i]) * decay
        if speed[i] < 1e-6:
            speed[i] = 0.0


@kernel
def _stall(position: Triple, q: Quaternion, plant: np.record, speed: FloatArray) -> None:
    """Stop the rotors whose disc touches the ground."""
    level = rotate(q, (0.0, 0.0, 1.0))[2]
    drop = plant.rotor_radius_m * math.sqrt(max(0.0, 1.0 - level * level))
    for i in range(4):
        hub = (plant.rotor_frd_m[i, 0], plant.rotor_frd_m[i, 1], plant.rotor_frd_m[i, 2])
        if position[2] + rotate(q, hub)[2] + drop >= plant.ground_down_m:
            speed[i] = 0.0


@kernel
def step(body: np.record, plant: np.record, target_speed_radps: FloatArray) -> None:
    """Move `body` on by STEP_S with its rotors running towards `target_speed_radps`."""
    h = STEP_S
    p, v, q, w = body.position_ned_m, body.velocity_ned_mps, body.q_ned_frd, body.rate_frd_radps
    p0, v0, w0 = (p[0], p[1], p[2]), (v[0], v[1], v[2]), (w[0], w[1], w[2])
    q0 = (q[0], q[1], q[2], q[3])
    near = p0[2] > plant.ground_down_m - 1.0
    s = body.rotor_speed_radps
    if near:
        _stall(p0, q0, plant, s)
    rotor0 = (s[0], s[1], s[2], s[3])
    _spin(s, plant, target_speed_radps)
    rotor1 = (s[0], s[1], s[2], s[3])
    _spin(s, plant, target_speed_radps)
    rotor2 = (s[0], s[1], s[2], s[3])

    cushion(p0, q0, plant)
    if near and ground_holds(p0, v0, q0, w0, *_air_load(v0, q0, rotor1, plant), plant):
        # What stops it is felt: an accelerometer's integral has to stay the velocity.
        f = unrotate(q0, (-v0[0] / h, -v0[1] / h, -v0[2] / h - GRAVITY_MPS2))
        for i in range(3):
            v[i] = w[i] = 0.0
            body.specific_force_frd_mps2[i] = f[i]
            body.mean_rate_frd_radps[i] = 0.0
        return

    half = 0.5 * h
    a0, f0, t0 = _slope(p0, v0, q0, w0, rotor0, near, plant)
    dq0 = _turning(q0, w0)
    v1, q1, w1 = _moved(v0, a0, half), _turned(q0, dq0, half), _moved(w0, t0, half)
    a1, f1, t1 = _slope(_moved(p0, v0, half), v1, q1, w1, rotor1, near, plant)
    dq1 = _turning(q1, w1)
    v2, q2, w2 = _moved(v0, a1, half), _turned(q0, dq1, half), _moved(w0, t1, half)
    a2, f2, t2 = _slope(_moved(p0, v1, half), v2, q2, w2, rotor1, near, plant)
    dq2 = _turning(q2, w2)
    v3, q3, w3 = _moved(v0, a2, h), _turned(q0, dq2, h), _moved(w0, t2, h)
    a3, f3, t3 = _slope(_moved(p0, v2, h), v3, q3, w3, rotor2, near, plant)
    dq3 = _turning(q3, w3)
    pm, vm, wm = _simpson(v0, v1, v2, v3), _simpson(a0, a1, a2, a3), _simpson(t0, t1, t2, t3)
    fm, rm = _simpson(f0, f1, f2, f3), _simpson(w0, w1, w2, w3)
    qe = _turned(_turned(_turned(_turned(q0, dq0, h / 6.0), dq1, h / 3.0), dq2, h / 3.0), dq3, h / 6.0)
    qe = normalized(qe)
    for i in range(3):
        p[i] += h * pm[i]
        v[i] += h * vm[i]
        w[i] += h * wm[i]
        body.specific_force_frd_mps2[i] = fm[i]
        body.mean_rate_frd_radps[i] = rm[i]
    for i in range(4):
        q[i] = qe[i]
