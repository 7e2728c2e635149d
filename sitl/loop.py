"""Life, frame by frame of 10 ms: the rooms in the order in which a sample runs through them, as one kernel.

Truth stays in WORLD, which only physics reads; what the brain learns passes through `sensed` alone.
"""

from __future__ import annotations

import math

import numpy as np

from sitl.autopilot.cascade import DEMAND, GAINS, MIND, control, detect_ground
from sitl.autopilot.rate import filter_gyro
from sitl.clock import FRAME_S
from sitl.estimator.belief import believe, knows_place
from sitl.estimator.fusion import fuse_frame
from sitl.estimator.strapdown import HAS_BARO, HAS_FIX, HAS_MAG, IMU_S, NAV, RING, advance_horizon, tick
from sitl.geo import GRAVITY_MPS2
from sitl.kernels import FloatArray, kernel
from sitl.physics.battery import PACK, drain
from sitl.physics.dynamics import BODY, PLANT, step
from sitl.physics.environment import AIR, GUST_NORMALS, blow
from sitl.physics.sensors import (
    BARO_NORMALS,
    GPS_DELAY_FRAMES,
    GPS_NORMALS,
    IMU_NORMALS,
    MAG_NORMALS,
    SENSED,
    measure_baro,
    measure_fix,
    measure_imu,
    measure_mag,
)

__all__ = ["BLOCK_FRAMES", "BRAIN", "NOISE", "WORLD", "live"]

BLOCK_FRAMES = 200
"""Noise is drawn ahead for this many frames."""

WORLD = np.dtype(
    [
        ("body", BODY),
        ("plant", PLANT),
        ("air", AIR),
        ("pack", PACK),
        ("sensed", SENSED),
        ("received", "i8"),  # whether fixes are
        ("speed_max_radps", "f8"),
        ("target_speed_radps", "f8", 4),
        ("mean_force", "f8", 3),
        ("mean_rate", "f8", 3),
    ]
)
BRAIN = np.dtype([("nav", NAV), ("mind", MIND), ("gains", GAINS), ("demand", DEMAND)])
NOISE = np.dtype(
    [
        ("imu", "f8", (BLOCK_FRAMES, 2, IMU_NORMALS)),
        ("gust", "f8", (BLOCK_FRAMES, GUST_NORMALS)),
        ("baro", "f8", (BLOCK_FRAMES // 4, BARO_NORMALS)),
        ("mag", "f8", (BLOCK_FRAMES // 4, MAG_NORMALS)),
        ("gps", "f8", (BLOCK_FRAMES // 10, GPS_NORMALS)),
    ]
)


@kernel
def _move(world: np.record, brain: np.record, noise: np.record, at: int) -> None:
    """Four steps of cascade and body, and the two IMU samples that fall in them."""
    body, plant, pack, sensed = world.body, world.plant, world.pack, world.sensed
    nav, mind, gains = brain.nav, brain.mind, brain.gains
    strength = world.speed_max_radps * min(1.0, pack.voltage_v / pack.full_v)
    slot = nav.frame % RING
    shaft_power_w = 0.0
    for k in range(4):
        control(
            mind, gains, brain.demand, nav.out_position_ned_m, nav.out_velocity_ned_mps, nav.out_q_ned_frd
        )
        for i in range(4):
            world.target_speed_radps[i] = mind.signals[i] * strength
        step(body, plant, world.target_speed_radps)
        for i in range(3):
            before_force = world.mean_force[i] if k % 2 else 0.0
            before_rate = world.mean_rate[i] if k % 2 else 0.0
            world.mean_force[i] = before_force + 0.5 * body.specific_force_frd_mps2[i]
            world.mean_rate[i] = before_rate + 0.5 * body.mean_rate_frd_radps[i]
        for i in range(4):
            speed = body.rotor_speed_radps[i]
            shaft_power_w += 0.25 * plant.torque_per_thrust_m * plant.thrust_n_per_radps2[i] * speed**3
        if k % 2:
            measure_imu(sensed, k // 2, world.mean_force, world.mean_rate, noise.imu[at, k // 2])
            for i in range(6):
                nav.imu[slot, k // 2, i] = sensed.imu[k // 2, i]
            tick(nav, k // 2)
            filter_gyro(mind, gains, nav.out_rate_frd_radps, IMU_S)
    drain(pack, shaft_power_w, FRAME_S)


@kernel
def _sense(world: np.record, nav: np.record, noise: np.record, frame: int, at: int) -> None:
    """What the slower senses take at the end of this frame, and the fix that arrives."""
    body, plant, sensed = world.body, world.plant, world.sensed
    slot = frame % RING
    nav.has[slot] = 0
    if (frame + 1) % 4 == 0:
        v, wind, load = body.velocity_ned_mps, plant.wind_ned_mps, 0.0
        for i in range(4):
            load += plant.thrust_n_per_radps2[i] * body.rotor_speed_radps[i] ** 2
        airspeed = math.sqrt((v[0] - wind[0]) ** 2 + (v[1] - wind[1]) ** 2 + (v[2] - wind[2]) ** 2)
        load /= plant.mass_kg * GRAVITY_MPS2
        measure_baro(sensed, body.position_ned_m[2], load, airspeed, noise.baro[at // 4])
        measure_mag(sensed, body.q_ned_frd, noise.mag[at // 4])
        nav.baro_alt_m[slot] = sensed.baro_alt_m
        for i in range(3):
            nav.mag[slot, i] = sensed.mag_frd_gauss[i]
        nav.has[slot] = HAS_BARO | HAS_MAG
    if (frame + 1) % 10 == 0:
        place, velocity, received = body.position_ned_m, body.velocity_ned_mps, world.received != 0
        measure_fix(sensed, frame, place, velocity, noise.gps[at // 10], received)
    taken = frame - GPS_DELAY_FRAMES
    if taken >= 0 and (taken + 1) % 10 == 0 and sensed.fix_valid[taken % 16]:
        for i in range(6):
            nav.fix[taken % RING, i] = sensed.fix[taken % 16, i]
        nav.has[taken % RING] |= HAS_FIX


@kernel
def _live_frame(worlds: np.ndarray, brains: np.ndarray, noises: np.ndarray) -> int:
    """All but the estimator's part of a frame; what was measured at its horizon."""
    world, brain, noise = worlds[0], brains[0], noises[0]
    body, plant, nav = world.body, world.plant, brain.nav
    frame = nav.frame
    at = frame % BLOCK_FRAMES
    height = plant.ground_down_m - body.position_ned_m[2]
    blow(world.air, height, body.velocity_ned_mps, noise.gust[at], FRAME_S, plant.wind_ned_mps)
    _move(world, brain, noise, at)
    _sense(world, nav, noise, frame, at)
    has = advance_horizon(nav)
    detect_ground(brain.mind, brain.gains, nav.out_velocity_ned_mps, FRAME_S)
    return int(has)


@kernel
def live(
    worlds: np.ndarray,
    brains: np.ndarray,
    noises: np.ndarray,
    navs: np.ndarray,
    books: np.ndarray,
    sheets: np.ndarray,
    works: np.ndarray,
    x: FloatArray,
    P: FloatArray,
    belief: FloatArray,
    until: int,
    alert: bool,
    fuses: bool,
) -> tuple[int, bool, bool]:
    """Live until frame `until`; the frame that has come, whether the place is known, whether it is on the ground.

    Alert, it stops as soon as one of both has changed. What an estimator that does not `fuse` does in a frame is left to it,
    and so is its `belief`.
    """
    nav, mind = brains[0].nav, brains[0].mind
    knew, stood = knows_place(navs, books, sheets, P), mind.on_ground != 0
    knows, stands = knew, stood
    while nav.frame < until:
        has = _live_frame(worlds, brains, noises)
        if fuses:
            fuse_frame(navs, books, sheets, works, x, P, nav.frame, has)
        knows, stands = knows_place(navs, books, sheets, P), mind.on_ground != 0
        if alert and (knows != knew or stands != stood):
            break
    if fuses:
        believe(navs, books, sheets, P, belief)
    return nav.frame, knows, stands
