"""The strapdown equations: the nominal state at a horizon in the past, and the output that runs ahead of it.

Nominal state: position and velocity (NED), attitude, gyro and accelerometer bias (16 numbers); Solà, "Quaternion
kinematics for the error-state Kalman filter" (2017), section 5.3. The filter lives at a horizon HORIZON_FRAMES ago,
where every measurement has arrived; the output is the nominal state at the horizon carried through the IMU samples
since then.
"""

from __future__ import annotations

import numpy as np

from sitl.geo import GRAVITY_MPS2
from sitl.kernels import FloatArray, Triple, inlined_kernel, kernel
from sitl.rotation import exponential, multiply, normalized, rotate

__all__ = [
    "EKF2_HORIZON_FRAMES",
    "HAS_BARO",
    "HAS_FIX",
    "HAS_MAG",
    "HORIZON_FRAMES",
    "IMU_S",
    "NAV",
    "PREDICT_S",
    "RING",
    "advance_horizon",
    "catch_up",
    "new_nav",
    "propagate",
    "tick",
    "vibration",
]

IMU_S = 0.005
PREDICT_S = 0.01
HORIZON_FRAMES = 12
EKF2_HORIZON_FRAMES = 20
"""PX4's: its IMU buffer holds EKF2_DELAY_MAX, 200 ms, whatever comes so late."""
RING = 32
_VIBRATION_FRAMES = 16
HAS_FIX, HAS_BARO, HAS_MAG = 1, 2, 4

NAV = np.dtype(
    [
        ("pose", "f8", 6),  # at the horizon: position, velocity
        ("q_ned_frd", "f8", 4),
        ("gyro_bias", "f8", 3),
        ("accel_bias", "f8", 3),
        ("out_position_ned_m", "f8", 3),
        ("out_velocity_ned_mps", "f8", 3),
        ("out_q_ned_frd", "f8", 4),
        ("out_acceleration_ned_mps2", "f8", 3),
        ("out_rate_frd_radps", "f8", 3),
        ("running", "i8"),
        ("frame", "i8"),
        ("horizon_frames", "i8"),
        ("mean_force", "f8", 3),  # bias-free, over the horizon's frame: what the error model is taken at
        ("mean_rate", "f8", 3),
        ("scale_noise_s", "f8"),  # attitude noise density by the rate squared: the gyro's scale is not exact
        ("mean_q", "f8", 4),
        ("imu", "f8", (RING, 2, 6)),
        ("fix", "f8", (RING, 6)),
        ("baro_alt_m", "f8", RING),
        ("mag", "f8", (RING, 3)),
        ("has", "i8", RING),
        ("follows", "i8"),  # EKF2's observer: whether the output has one, and whether that has begun
        ("following", "i8"),
        ("outputs", "f8", (RING, 10)),  # position, velocity, attitude
        ("output_error", "f8", 6),  # summed
        ("turn_rad", "f8", 3),  # what each sample's turn takes of the attitude's error
    ]
)
"""Nominal state, output, and the samples of the last RING frames by frame number."""


def new_nav() -> np.ndarray:
    """One NAV that knows nothing yet."""
    nav = np.zeros(1, NAV)
    nav["q_ned_frd"] = nav["out_q_ned_frd"] = 1.0, 0.0, 0.0, 0.0
    nav["horizon_frames"] = HORIZON_FRAMES
    return nav


@inlined_kernel
def propagate(p: FloatArray, v: FloatArray, q: FloatArray, force: Triple, rate: Triple, dt: float) -> Triple:
    """Move p, v, q by bias-free means of specific force and rate; the NED acceleration meant by them.

    The force is turned at the middle of the interval, position takes the trapezoid.
    """
    q0 = (q[0], q[1], q[2], q[3])
    half = exponential((0.5 * dt * rate[0], 0.5 * dt * rate[1], 0.5 * dt * rate[2]))
    middle = multiply(q0, half)
    a = rotate(middle, force)
    a = (a[0], a[1], a[2] + GRAVITY_MPS2)
    for i in range(3):
        p[i] += dt * (v[i] + 0.5 * dt * a[i])
        v[i] += dt * a[i]
    end = normalized(multiply(middle, half))
    for i in range(4):
        q[i] = end[i]
    return a


def vibration(nav: np.record) -> tuple[float, float, float]:
    """Means over the last frames' samples: length of Δθ × Δθ before (coning), of ω - ω before, of f - f before.

    PX4's VehicleIMU takes them by a low-pass over about as many.
    """
    samples = np.roll(nav["imu"], -int(nav["frame"]), axis=0)[-_VIBRATION_FRAMES:].reshape(-1, 6)
    turns = IMU_S * samples[:, 3:]
    coning = np.cross(turns[1:], turns[:-1])
    jumps = np.diff(samples, axis=0)
    lengths = [float(np.linalg.norm(part, axis=1).mean()) for part in (coning, jumps[:, 3:], jumps[:, :3])]
    return lengths[0], lengths[1], lengths[2]


@kernel
def _corrected(nav: np.record, slot: int, k: int) -> tuple[Triple, Triple]:
    s, a, g = nav.imu, nav.accel_bias, nav.gyro_bias
    force = (s[slot, k, 0] - a[0], s[slot, k, 1] - a[1], s[slot, k, 2] - a[2])
    rate = (s[slot, k, 3] - g[0], s[slot, k, 4] - g[1], s[slot, k, 5] - g[2])
    return force, rate


@kernel
def tick(nav: np.record, k: int) -> None:
    """Carry the output through sample `k` of the newest frame."""
    force, rate = _corrected(nav, nav.frame % RING, k)
    if nav.running:
        turn = rate
        if nav.follows:
            c = nav.turn_rad
            turn = (rate[0] + c[0] / IMU_S, rate[1] + c[1] / IMU_S, rate[2] + c[2] / IMU_S)
        # Slices, as the horizon's are: one signature.
        p, v = nav.out_position_ned_m[:], nav.out_velocity_ned_mps[:]
        a = propagate(p, v, nav.out_q_ned_frd, force, turn, IMU_S)
        for i in range(3):
            nav.out_acceleration_ned_mps2[i] = a[i]
    for i in range(3):
        nav.out_rate_frd_radps[i] = rate[i]


@kernel
def advance_horizon(nav: np.record) -> int:
    """End the newest frame and carry the nominal state through the horizon's; what was measured then."""
    frame = nav.frame + 1
    nav.frame = frame
    slot = (frame - nav.horizon_frames) % RING
    if not nav.running:
        return int(nav.has[slot])
    p, v = nav.pose[:3], nav.pose[3:]
    for i in range(3):
        nav.mean_force[i] = nav.mean_rate[i] = 0.0
    for k in range(2):
        force, rate = _corrected(nav, slot, k)
        propagate(p, v, nav.q_ned_frd, force, rate, IMU_S)
        for i in range(3):
            nav.mean_force[i] += 0.5 * force[i]
            nav.mean_rate[i] += 0.5 * rate[i]
        if k == 0:
            for i in range(4):
                nav.mean_q[i] = nav.q_ned_frd[i]
    return int(nav.has[slot])


@kernel
def catch_up(navs: np.ndarray) -> None:
    """Make the output anew: the nominal state carried through every sample since the horizon."""
    nav = navs[0]
    p, v, q = nav.out_position_ned_m[:], nav.out_velocity_ned_mps[:], nav.out_q_ned_frd
    for i in range(3):
        p[i], v[i] = nav.pose[i], nav.pose[3 + i]
    for i in range(4):
        q[i] = nav.q_ned_frd[i]
    for frame in range(nav.frame - nav.horizon_frames + 1, nav.frame):
        for k in range(2):
            force, rate = _corrected(nav, frame % RING, k)
            propagate(p, v, q, force, rate, IMU_S)
