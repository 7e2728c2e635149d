"""Unit quaternions, wxyz, Hamilton's product: kernels on bare triples and quadruples (arrays or tuples).

`q_ned_frd` takes FRD vectors to NED, so `rotate(q, v_frd)` is NED and `unrotate(q, v_ned)` is FRD. `euler_rad` and `tilt_rad` are
Python's own, for who asks now and then.
"""

from __future__ import annotations

import math

from sitl.kernels import Components, FloatArray, Quaternion, Triple, kernel

__all__ = [
    "between",
    "euler_rad",
    "exponential",
    "from_axes",
    "from_euler",
    "matrix",
    "multiply",
    "normalized",
    "rotate",
    "tilt_rad",
    "to_yaw",
    "unrotate",
]


@kernel
def multiply(p: Components, q: Components) -> Quaternion:
    """The rotation that does `q` first, then `p`."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


@kernel
def normalized(q: Components) -> Quaternion:
    """`q` at unit length."""
    s = 1.0 / math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return q[0] * s, q[1] * s, q[2] * s, q[3] * s


@kernel
def rotate(q: Components, v: Components) -> Triple:
    """`q v q*`: v + 2w(u × v) + 2u × (u × v), with u the vector part."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    tx = 2.0 * (y * v[2] - z * v[1])
    ty = 2.0 * (z * v[0] - x * v[2])
    tz = 2.0 * (x * v[1] - y * v[0])
    return (
        v[0] + w * tx + y * tz - z * ty,
        v[1] + w * ty + z * tx - x * tz,
        v[2] + w * tz + x * ty - y * tx,
    )


@kernel
def unrotate(q: Components, v: Components) -> Triple:
    """`q* v q`, the way back."""
    return rotate((q[0], -q[1], -q[2], -q[3]), v)


@kernel
def matrix(q: Components) -> tuple[Triple, Triple, Triple]:
    """The rotation's rows."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


@kernel
def exponential(v: Components) -> Quaternion:
    """The turn by |v| radians about v."""
    square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
    if square < 1e-8:  # series: exact to 1e-17 here, and free of 0/0
        c = 1.0 - square / 8.0
        s = 0.5 - square / 48.0
    else:
        angle = math.sqrt(square)
        c = math.cos(0.5 * angle)
        s = math.sin(0.5 * angle) / angle
    return c, s * v[0], s * v[1], s * v[2]


@kernel
def between(a: Components, b: Components) -> Quaternion:
    """The shortest turn that takes unit vector `a` to unit vector `b`; any where they are opposite."""
    w = 1.0 + a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    if w < 1e-9:
        if abs(a[0]) < 0.9:  # any axis across a: a × x
            return normalized((0.0, 0.0, a[2], -a[1]))
        return normalized((0.0, -a[2], 0.0, a[0]))
    return normalized((w, a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]))


@kernel
def from_axes(x: Components, y: Components, z: Components) -> Quaternion:
    """The rotation whose columns are x, y, z (Shepperd's method)."""
    trace = x[0] + y[1] + z[2]
    if trace > 0.0:
        return normalized((1.0 + trace, y[2] - z[1], z[0] - x[2], x[1] - y[0]))
    if x[0] >= y[1] and x[0] >= z[2]:
        return normalized((y[2] - z[1], 1.0 + x[0] - y[1] - z[2], y[0] + x[1], z[0] + x[2]))
    if y[1] >= z[2]:
        return normalized((z[0] - x[2], y[0] + x[1], 1.0 + y[1] - x[0] - z[2], z[1] + y[2]))
    return normalized((x[1] - y[0], z[0] + x[2], z[1] + y[2], 1.0 + z[2] - x[0] - y[1]))


@kernel
def from_euler(roll_rad: float, pitch_rad: float, yaw_rad: float) -> Quaternion:
    """Yaw, then pitch, then roll (3-2-1)."""
    about_z = (math.cos(0.5 * yaw_rad), 0.0, 0.0, math.sin(0.5 * yaw_rad))
    about_y = (math.cos(0.5 * pitch_rad), 0.0, math.sin(0.5 * pitch_rad), 0.0)
    about_x = (math.cos(0.5 * roll_rad), math.sin(0.5 * roll_rad), 0.0, 0.0)
    return multiply(about_z, multiply(about_y, about_x))


@kernel
def to_yaw(q: Components) -> float:
    """The 3-2-1 yaw."""
    return math.atan2(2.0 * (q[0] * q[3] + q[1] * q[2]), 1.0 - 2.0 * (q[2] * q[2] + q[3] * q[3]))


def euler_rad(q_ned_frd: FloatArray) -> tuple[float, float, float]:
    """Roll, pitch and yaw."""
    w, x, y, z = q_ned_frd.tolist()
    return (
        math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        math.asin(min(1.0, max(-1.0, 2.0 * (w * y - x * z)))),
        math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    )


def tilt_rad(q_ned_frd: FloatArray) -> float:
    """How far it leans, whichever way."""
    _, x, y, _ = q_ned_frd.tolist()
    return math.acos(min(1.0, max(-1.0, 1.0 - 2.0 * (x * x + y * y))))
