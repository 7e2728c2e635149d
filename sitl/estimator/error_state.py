"""How the nominal state may be wrong: the error state's transition, its covariance, what the compass sees of it.

Error state, 15: δp, δv, δθ in the body (q = q̂ ⊗ exp δθ), δω_b, δa_b; Solà, "Quaternion kinematics for the
error-state Kalman filter" (2017), sections 5.3 and 6.
"""

from __future__ import annotations

import numpy as np

from sitl.kernels import FloatArray, Quaternion, Triple, kernel
from sitl.rotation import exponential, matrix, multiply, normalized, unrotate

__all__ = [
    "STATES",
    "field_frd",
    "inject",
    "mag_expected",
    "mag_jacobian",
    "predict_covariance",
    "process_noise",
    "set_cross",
    "transition",
]

STATES = 15


@kernel
def _blocks(q: Quaternion, force: Triple, rate: Triple, dt: float) -> tuple:
    """dt·∂v̇/∂θ = -R [f]× dt, R (of which ∂v̇/∂a_b is the negative), and exp(-[ω]× dt); each 3×3 by rows."""
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
def _half_turned(P: FloatArray, FP: FloatArray, a: tuple, r: tuple, t: tuple, dt: float) -> None:
    """The first nine rows of F P; the biases' are P's own."""
    for i in range(3):
        ai, ri, ti = a[i], r[i], t[i]
        for j in range(STATES):
            FP[i, j] = P[i, j] + dt * P[3 + i, j]
            turn = ai[0] * P[6, j] + ai[1] * P[7, j] + ai[2] * P[8, j]
            push = ri[0] * (dt * P[12, j]) + ri[1] * (dt * P[13, j]) + ri[2] * (dt * P[14, j])
            FP[3 + i, j] = P[3 + i, j] + turn - push
            FP[6 + i, j] = ti[0] * P[6, j] + ti[1] * P[7, j] + ti[2] * P[8, j] - dt * P[9 + i, j]


@kernel
def predict_covariance(P: FloatArray, FP: FloatArray, navs: np.ndarray, noise: FloatArray, dt: float) -> None:
    """P := F P Fᵀ + diag(noise) at the horizon's frame, in place, exactly symmetric; `FP` is (9, 15), to work on.

    A turn adds what the gyro's error of scale may have turned too far.
    """
    nav = navs[0]
    q, f, w = nav.mean_q, nav.mean_force, nav.mean_rate
    a, r, t = _blocks((q[0], q[1], q[2], q[3]), (f[0], f[1], f[2]), (w[0], w[1], w[2]), dt)
    _half_turned(P, FP, a, r, t, dt)
    for j in range(9):  # of the product's upper triangle, row by row: what lies below follows
        row = FP[j]
        b0, b1, b2 = dt * row[12], dt * row[13], dt * row[14]
        for i in range(3):
            if j < 3:
                P[j, i] = row[i] + dt * row[3 + i]
            if j < 6:
                turn = a[i][0] * row[6] + a[i][1] * row[7] + a[i][2] * row[8]
                P[j, 3 + i] = row[3 + i] + turn - (r[i][0] * b0 + r[i][1] * b1 + r[i][2] * b2)
            P[j, 6 + i] = t[i][0] * row[6] + t[i][1] * row[7] + t[i][2] * row[8] - dt * row[9 + i]
            P[j, 9 + i] = row[9 + i]
            P[j, 12 + i] = row[12 + i]
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
def field_frd(q: FloatArray, field_ned: FloatArray) -> Triple:
    """The field along the body axes."""
    return unrotate((q[0], q[1], q[2], q[3]), (field_ned[0], field_ned[1], field_ned[2]))


@kernel
def mag_expected(q: FloatArray, field_ned: FloatArray) -> FloatArray:
    """The field along the body axes."""
    expected = np.empty(3)
    expected[0], expected[1], expected[2] = field_frd(q, field_ned)
    return expected


@kernel
def set_cross(H: FloatArray, v: Triple) -> None:
    """Write [v]× into the attitude's columns of the 3×15 `H`, whose others it leaves alone."""
    x, y, z = v
    H[0, 6], H[0, 7], H[0, 8] = 0.0, -z, y
    H[1, 6], H[1, 7], H[1, 8] = z, 0.0, -x
    H[2, 6], H[2, 7], H[2, 8] = -y, x, 0.0


@kernel
def mag_jacobian(q: FloatArray, field_ned: FloatArray) -> FloatArray:
    """∂(Rᵀ m)/∂δθ = [Rᵀ m]×, in a 3×15."""
    H = np.zeros((3, STATES))
    set_cross(H, field_frd(q, field_ned))
    return H
