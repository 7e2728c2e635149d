"""The estimator: an error-state filter at the delayed horizon, fed with whatever was measured there.

The error state is zero between updates: an update makes one, `inject` moves it into the nominal state, and
it is zero again.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from sitl.airframe import Receiver, Senses
from sitl.estimator.belief import knows_place
from sitl.estimator.error_state import STATES, mag_expected, mag_jacobian, process_noise
from sitl.estimator.filters import KernelFilter
from sitl.estimator.fusion import (
    ALONE_FRAMES,
    BARO,
    BARO_BIAS_TIME_S,
    BOOK,
    DEAD_RECKONING_FRAMES,
    FIX_S,
    MAG,
    PLACE,
    RESET_AFTER,
    SHEET,
    SPEED,
    reset_to,
)
from sitl.estimator.observer import follow
from sitl.estimator.strapdown import HAS_BARO, HAS_FIX, HAS_MAG, PREDICT_S, RING, catch_up
from sitl.geo import GRAVITY_MPS2, geodetic_of_ned, ned_of_geodetic
from sitl.kernels import FloatArray, Triple
from sitl.params import Params
from sitl.rotation import from_euler

if TYPE_CHECKING:
    from sitl.estimator.stock import StockFilter

__all__ = ["BOOK", "Ekf"]

ALIGN_FRAMES = 100
_TURN_TIME_S = 3.0
"""A turn takes about this long: over it an error of scale is no noise but adds up."""
_PLACE_H, _SPEED_H = np.eye(3, STATES), np.eye(3, STATES, 3)
_BARO_H = -np.eye(1, STATES, 2)


def _stock_filter(nav: np.ndarray, noise: FloatArray) -> StockFilter:
    from sitl.estimator.stock import StockFilter  # filterpy brings much of scipy: only who asks pays

    return StockFilter(nav, noise)


class Ekf:
    """The estimator: aligns itself standing still, anchors its origin at the first fix, then fuses.

    `nav` is shared with the kernels that carry the nominal state; `field_ned_gauss` is what its map says of
    the place. Position is tracked in the receiver's frame, which wanders: the wander's speed is process
    noise, its size is added to the position's variance where that is reported. So is the barometer's drift
    while its height is all that there is. Once it runs, `fusion` does what there is to do in a frame, within the kernel that
    lives it; `stepwise` does the same here, by single updates of `filter`, which may be filterpy's own.
    """

    def __init__(
        self,
        nav: np.ndarray,
        senses: Senses,
        params: Params,
        *,
        receiver: Receiver,
        field_ned_gauss: Triple,
        origin_offset_ned_m: Triple,
        stock: bool,
    ) -> None:
        self.nav, self.book, self.sheet = nav, np.zeros(1, BOOK), np.zeros(1, SHEET)
        self.stepwise = stock
        r = receiver
        self._fix_sigma = np.array([r.white_h_m, r.white_h_m, r.white_v_m, *[r.speed_mps] * 3])
        wander_variance_m2 = np.array([r.wander_h_m, r.wander_h_m, r.wander_v_m]) ** 2
        self.sheet["wander_m2"] = wander_variance_m2
        s = senses
        densities = s.accel_noise_mps2_rthz, s.gyro_noise_radps_rthz
        walks = s.accel_walk_mps3_rthz, s.gyro_walk_radps2_rthz
        noise = process_noise(*densities, *walks, PREDICT_S)
        nav["scale_noise_s"] = s.gyro_scale**2 * _TURN_TIME_S
        noise[:3] = 2.0 * wander_variance_m2 / receiver.wander_time_s * PREDICT_S
        own = KernelFilter(nav, noise)
        self.filter = _stock_filter(nav, noise) if stock else own
        self.records = nav, self.book, self.sheet, own.work, own.x, own.P
        """What `fusion` works on."""
        self._senses, self._offset = senses, origin_offset_ned_m
        self._field = np.array(field_ned_gauss)
        self._place_R, self._speed_R = np.diag(self._fix_sigma[:3] ** 2), np.diag(self._fix_sigma[3:] ** 2)
        self._baro_R = np.array([[s.baro_noise_m**2 + s.baro_drift_m**2]])
        self._mag_R = np.eye(3) * s.mag_noise_gauss**2
        self._write_sheet(noise)
        self.params = params
        self._b, self._fix_frame = self.book[0], self.book["fix_frame"]
        n = nav[0]
        self._fix, self._baro, self._mag, self._imu = n["fix"], n["baro_alt_m"], n["mag"], n["imu"]
        self._pose, self._q = n["pose"], n["q_ned_frd"]
        self._horizon_frames = int(nav["horizon_frames"][0])
        self.running = False

    def step(self) -> None:
        """What was measured at the end of the horizon's frame aligns it, or it predicts and fuses that."""
        frame = int(self.nav["frame"][0])
        slot = (frame - self._horizon_frames) % RING
        has = int(self.nav["has"][0, slot])
        if not self.running:
            if frame > self._horizon_frames:
                self._align(frame, slot, has)
            return
        self.filter.predict()
        if has & HAS_FIX:
            self._fuse_fix(frame, slot)
        if has & HAS_BARO:
            self._fuse_baro(slot)
        if has & HAS_MAG:
            expected, H = mag_expected(self._q, self._field), mag_jacobian(self._q, self._field)
            self.filter.fuse(self._mag[slot], expected, H, self._mag_R, self._gate[MAG])
        if self.nav["follows"][0]:
            follow(self.nav)
        elif has:
            catch_up(self.nav)

    @property
    def params(self) -> Params:
        """PX4's parameters that it obeys; assign to change them."""
        return self._params

    @params.setter
    def params(self, params: Params) -> None:
        self._params, gate = params, self._gate
        gate[SPEED], gate[PLACE] = params["EKF2_GPS_V_GATE"], params["EKF2_GPS_P_GATE"]
        gate[BARO], gate[MAG] = params["EKF2_BARO_GATE"], params["EKF2_MAG_GATE"]
        self.sheet["eph_max_m2"] = params["COM_POS_FS_EPH"] ** 2

    def move_origin(self, lat_deg: float, lon_deg: float, alt_amsl_m: float) -> None:
        """Anchor the NED frame there, with all that is given in it; axes stay parallel, as over short ways they are."""
        anchor, old = (lat_deg, lon_deg, alt_amsl_m), self._b["origin"].tolist()
        moved_m = np.array(ned_of_geodetic(anchor, tuple(old)))
        self._b["origin"] = anchor
        self._pose[:3] += moved_m
        self.nav[0]["out_position_ned_m"] += moved_m
        self.nav[0]["outputs"][:, :3] += moved_m

    def _write_sheet(self, noise: FloatArray) -> None:
        sheet, senses = self.sheet[0], self._senses
        sheet["process_noise"], sheet["field_ned_gauss"] = noise, self._field
        sheet["fix_variance"], sheet["baro_variance_m2"] = self._fix_sigma**2, self._baro_R[0, 0]
        sheet["baro_drift_m2"], sheet["mag_variance_gauss2"] = senses.baro_drift_m**2, self._mag_R[0, 0]
        self._gate = sheet["gate"]

    def _fuse_fix(self, frame: int, slot: int) -> None:
        book, gate, fix = self._b, self._gate, self._fix[slot]
        lat, lon, alt = book["origin"].tolist()
        z = np.array([*ned_of_geodetic((lat, lon, alt), tuple(fix[:3].tolist())), *fix[3:].tolist()])
        pose, fuse = self._pose, self.filter.fuse
        if frame - book["fix_frame"] > ALONE_FRAMES:
            self.filter.P[2, 2] += self._senses.baro_drift_m**2
        moved = fuse(z[3:], pose[3:], _SPEED_H, self._speed_R, gate[SPEED])
        placed = fuse(z[:3], pose[:3], _PLACE_H, self._place_R, gate[PLACE])
        book["rejected"] = 0 if placed else book["rejected"] + 1
        if book["rejected"] >= RESET_AFTER:
            reset_to(self.nav, self.filter.P, self._fix_sigma**2, z)
            book["rejected"] = 0
            placed = True
        if placed or moved:
            book["fix_frame"] = frame
        # The barometer's offset is learnt from fixes, never from the filter, which would confirm itself.
        book["heights"] += 1
        share = max(1.0 / book["heights"], FIX_S / BARO_BIAS_TIME_S)
        book["baro_bias_m"] += share * (book["baro_alt_m"] - (alt - z[2]) - book["baro_bias_m"])

    def _fuse_baro(self, slot: int) -> None:
        book = self._b
        book["baro_alt_m"] = self._baro[slot]
        height = self._baro[slot] - book["baro_bias_m"] - book["origin"][2]
        self.filter.fuse(
            np.array([height]),
            np.array([-self._pose[2]]),
            _BARO_H,
            self._baro_R,
            self._gate[BARO],
        )

    def _align(self, frame: int, slot: int, has: int) -> None:
        """Average the standing vehicle's senses; start at the first fix after ALIGN_FRAMES."""
        book, total = self._b, self._b["sum"]
        total[:6] += self._imu[slot].mean(axis=0)
        total[6:] += self._mag[slot]
        book["aligning"] += 1
        if has & HAS_BARO:
            book["baro_alt_m"] = self._baro[slot]
        if book["aligning"] < ALIGN_FRAMES or not has & HAS_FIX:
            return
        fx, fy, fz, wx, wy, wz, mx, my, mz = (total / book["aligning"]).tolist()
        roll, pitch = math.atan2(-fy, -fz), math.atan2(fx, math.hypot(fy, fz))
        level_y = math.cos(roll) * my - math.sin(roll) * mz
        level_z = math.sin(roll) * my + math.cos(roll) * mz
        level_x = math.cos(pitch) * mx + math.sin(pitch) * level_z
        declination = math.atan2(self._field[1], self._field[0])

        n, fix, s = self.nav[0], self._fix[slot], self._senses
        n["q_ned_frd"] = from_euler(roll, pitch, declination - math.atan2(level_y, level_x))
        n["gyro_bias"] = wx, wy, wz
        place = (float(fix[0]), float(fix[1]), float(fix[2]))
        book["origin"] = geodetic_of_ned(place, self._offset)
        self._pose[:3] = ned_of_geodetic(tuple(book["origin"].tolist()), place)
        self._pose[3:] = 0.0
        book["baro_bias_m"] = book["baro_alt_m"] - place[2]
        gyro_sigma = s.gyro_noise_radps_rthz / math.sqrt(PREDICT_S * book["aligning"])
        tilt = s.accel_bias_mps2 / GRAVITY_MPS2  # the level was taken from a biased accelerometer, so
        sigma = [*self._fix_sigma[:3], *[0.02] * 3, tilt, tilt, 0.02, *[gyro_sigma] * 3]
        P = np.diag(np.array([*sigma, *[s.accel_bias_mps2] * 3]) ** 2)
        P[6, 13] = P[13, 6] = 0.99 * tilt * s.accel_bias_mps2  # tilt errors are its biases seen otherwise
        P[7, 12] = P[12, 7] = -0.99 * tilt * s.accel_bias_mps2
        self.filter.P[:] = P
        book["fix_frame"] = frame
        n["running"] = 1
        self.running = True
        catch_up(self.nav)

    @property
    def fix_frame(self) -> int:
        """The frame in which a fix was used last."""
        return int(self._fix_frame.item())

    def fixes_fresh(self, frame: int) -> bool:
        """Whether position and velocity rest on fixes, or are dead-reckoned for no longer than PX4 does."""
        return self.running and frame - self._fix_frame.item() <= DEAD_RECKONING_FRAMES

    @property
    def knows_place(self) -> bool:
        """Whether position rests on fixes, or on fresh dead reckoning within COM_POS_FS_EPH (PX4's eph)."""
        return self.running and bool(knows_place(self.nav, self.book, self.sheet, self.filter.P))

    def arrays(self) -> tuple[np.ndarray, ...]:
        """All that changes, for a snapshot; `nav` is shared and not among it."""
        return self.book, self.filter.x, self.filter.P

    def resume(self) -> None:
        """Go on from what was written into `arrays()` and `nav`."""
        self.running = bool(self.nav["running"][0])
