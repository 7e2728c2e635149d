"""What the estimator believes of the world: strapdown equations, their error model, the measurements.

Nominal state: position and velocity (NED), attitude, gyro and accelerometer bias (16 numbers). Error state,
15: δp, δv, δθ in the body (q = q̂ ⊗ exp δθ), δω_b, δa_b; Solà, "Quaternion kinematics for the error-state
Kalman filter" (2017), sections 5.3 and 6. The filter lives at a horizon HORIZON_FRAMES ago, where every
measurement has arrived; the output is the nominal state at the horizon carried through the IMU samples
since then.
"""

from __future__ import annotations

import numpy as np

from sitl.geo import GRAVITY_MPS2
from sitl.kernels import FloatArray, Quaternion, Triple, kernel
from sitl.rotation import exponential, matrix, multiply, normalized, rotate, unrotate

__all__ = [
    "EKF2_HORIZON_FRAMES",
    "HAS_BARO",
    "HAS_FIX",
    "HAS_MAG",
    "HORIZON_FRAMES",
    "IMU_S",
    "NAV",
    "OUTPUT_S",
    "PREDICT_S",
    "RING",
    "STATES",
    "advance_horizon",
    "catch_up",
    "inject",
    "mag_expected",
    "mag_jacobian",
    "new_nav",
    "predict_covariance",
    "process_noise",
    "propagate",
    "report",
    "tick",
    "transition",
    "vibration",
]

STATES = 15
IMU_S = 0.005
PREDICT_S = 0.01
HORIZON_FRAMES = 12
EKF2_HORIZON_FRAMES = 20
"""PX4's: its IMU buffer holds EKF2_DELAY_MAX, 200 ms, whatever comes so late."""
OUTPUT_S = (HORIZON_FRAMES - 1) * PREDICT_S
"""How far the output lies ahead of our horizon."""
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


@kernel
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


@kernel
def report(navs: np.ndarray, P: FloatArray, wander_variance_m2: FloatArray, told: FloatArray) -> None:
    """Fill `told` with what an Estimate says.

    Position's variance is carried from the horizon to the output. Position, velocity, q, rate, acceleration, gyro and accelerometer bias; then NED variances of position,
    velocity and attitude.
    """
    nav = navs[0]
    q, ahead_s = nav.out_q_ned_frd, (nav.horizon_frames - 1) * PREDICT_S
    for i in range(4):
        told[6 + i] = q[i]
    r = matrix((q[0], q[1], q[2], q[3]))
    for i in range(3):
        told[i] = nav.out_position_ned_m[i]
        told[3 + i] = nav.out_velocity_ned_mps[i]
        told[10 + i] = nav.out_rate_frd_radps[i]
        told[13 + i] = nav.out_acceleration_ned_mps2[i]
        told[16 + i] = nav.gyro_bias[i]
        told[19 + i] = nav.accel_bias[i]
        told[22 + i] = P[i, i] + ahead_s * (2.0 * P[i, 3 + i] + ahead_s * P[3 + i, 3 + i])
        told[22 + i] += wander_variance_m2[i]
        told[25 + i] = P[3 + i, 3 + i]
        told[28 + i] = 0.0
        for j in range(3):
            for k in range(3):
                told[28 + i] += r[i][j] * P[6 + j, 6 + k] * r[i][k]


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


@kernel
def _blocks(q: Quaternion, force: Triple, rate: Triple, dt: float) -> tuple:
    """dt·∂v̇/∂θ = -R [f]× dt, dt·∂v̇/∂a_b = -R dt, and exp(-[ω]× dt); each 3×3 by rows."""
    r = matrix(q)
    fx, fy, fz = dt * force[0], dt * force[1], dt * force[2]
    t = matrix(exponential((-dt * rate[0], -dt * rate[1], -dt * rate[2])))
    a = (
        (r[0][2] * fy - r[0][1] * fz, r[0][0] * fz - r[0][2] * fx, r[0][1] * fx - r[0][0] * fy),
        (r[1][2] * fy - r[1][1] * fz, r[1][0] * fz - r[1][2] * fx, r[1][1] * fx - r[1][0] * fy),
        (r[2][2] * fy - r[2][1] * fz, r[2][0] * fz - r[2][2] * fx, r[2][1] * fx - r[2][0] * fy),
    )
    return a, r, t


@kernel
def transition(q: FloatArray, force: FloatArray, rate: FloatArray, dt: float) -> FloatArray:
    """The error state's 15×15 transition over `dt`, first order in dt but for the turn; `q` is mid-way."""
    q_tuple, f, w = (q[0], q[1], q[2], q[3]), (force[0], force[1], force[2]), (rate[0], rate[1], rate[2])
    a, r, t = _blocks(q_tuple, f, w, dt)
    F = np.eye(STATES)
    for i in range(3):
        F[i, 3 + i] = dt
        F[6 + i, 9 + i] = -dt
        for j in range(3):
            F[3 + i, 6 + j] = a[i][j]
            F[3 + i, 12 + j] = -dt * r[i][j]
            F[6 + i, 6 + j] = t[i][j]
    return F


@kernel
def _sweep(P: FloatArray, out: FloatArray, a: tuple, r: tuple, t: tuple, dt: float) -> None:
    """`out` = (F P)ᵀ, with only F's blocks touched."""
    for j in range(STATES):
        p6, p7, p8 = P[6, j], P[7, j], P[8, j]
        b0, b1, b2 = dt * P[12, j], dt * P[13, j], dt * P[14, j]
        for i in range(3):
            out[j, i] = P[i, j] + dt * P[3 + i, j]
            turn = a[i][0] * p6 + a[i][1] * p7 + a[i][2] * p8
            out[j, 3 + i] = P[3 + i, j] + turn - (r[i][0] * b0 + r[i][1] * b1 + r[i][2] * b2)
            out[j, 6 + i] = t[i][0] * p6 + t[i][1] * p7 + t[i][2] * p8 - dt * P[9 + i, j]
            out[j, 9 + i] = P[9 + i, j]
            out[j, 12 + i] = P[12 + i, j]


@kernel
def predict_covariance(
    P: FloatArray, work: FloatArray, navs: np.ndarray, noise: FloatArray, dt: float
) -> None:
    """P := F P Fᵀ + diag(noise) at the horizon's frame, in place, exactly symmetric; `work` is (15, 15).

    A turn adds what the gyro's error of scale may have turned too far.
    """
    nav = navs[0]
    q, f, w = nav.mean_q, nav.mean_force, nav.mean_rate
    a, r, t = _blocks((q[0], q[1], q[2], q[3]), (f[0], f[1], f[2]), (w[0], w[1], w[2]), dt)
    _sweep(P, work, a, r, t, dt)
    _sweep(work, P, a, r, t, dt)
    for i in range(STATES):
        P[i, i] += noise[i]
        for j in range(i):
            P[i, j] = P[j, i]
    for i in range(3):
        P[6 + i, 6 + i] += nav.scale_noise_s * w[i] * w[i] * dt


def process_noise(
    accel_mps2_rthz: float, gyro_radps_rthz: float, accel_walk: float, gyro_walk: float, dt: float
) -> FloatArray:
    """Q's diagonal over `dt` from the IMU's noise densities and bias walks."""
    noise = np.zeros(STATES)
    noise[3:6] = accel_mps2_rthz**2 * dt
    noise[6:9] = gyro_radps_rthz**2 * dt
    noise[9:12] = gyro_walk**2 * dt
    noise[12:15] = accel_walk**2 * dt
    return noise


@kernel
def inject(navs: np.ndarray, error: FloatArray, P: FloatArray) -> None:
    """Move the nominal state by the error, and P to the new body axes by I - [δθ/2]× (Solà, equation 287)."""
    nav = navs[0]
    theta = (error[6], error[7], error[8])
    for i in range(3):
        nav.pose[i] += error[i]
        nav.pose[3 + i] += error[3 + i]
        nav.gyro_bias[i] += error[9 + i]
        nav.accel_bias[i] += error[12 + i]
    q = nav.q_ned_frd
    turned = normalized(multiply((q[0], q[1], q[2], q[3]), exponential(theta)))
    for i in range(4):
        q[i] = turned[i]
    x, y, z = 0.5 * theta[0], 0.5 * theta[1], 0.5 * theta[2]
    for j in range(STATES):
        a, b, c = P[6, j], P[7, j], P[8, j]
        P[6, j], P[7, j], P[8, j] = a + z * b - y * c, b + x * c - z * a, c + y * a - x * b
    for j in range(STATES):
        a, b, c = P[j, 6], P[j, 7], P[j, 8]
        P[j, 6], P[j, 7], P[j, 8] = a + z * b - y * c, b + x * c - z * a, c + y * a - x * b


@kernel
def _field_frd(q: FloatArray, field_ned: FloatArray) -> Triple:
    return unrotate((q[0], q[1], q[2], q[3]), (field_ned[0], field_ned[1], field_ned[2]))


@kernel
def mag_expected(q: FloatArray, field_ned: FloatArray) -> FloatArray:
    """The field along the body axes."""
    expected = np.empty(3)
    expected[0], expected[1], expected[2] = _field_frd(q, field_ned)
    return expected


@kernel
def mag_jacobian(q: FloatArray, field_ned: FloatArray) -> FloatArray:
    """∂(Rᵀ m)/∂δθ = [Rᵀ m]×, in a 3×15."""
    x, y, z = _field_frd(q, field_ned)
    H = np.zeros((3, STATES))
    H[0, 7], H[0, 8] = -z, y
    H[1, 6], H[1, 8] = z, -x
    H[2, 6], H[2, 7] = -y, x
    return H
