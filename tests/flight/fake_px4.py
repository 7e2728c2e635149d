"""A scripted PX4: its replies as they were seen on v1.17, a body that lags a little.

It is written against pymavlink alone and shares no code with what it tests. `step` takes and gives frames.
"""

import math
import struct

import pymap3d
from pymavlink.dialects.v20 import common as mavlink

OFFBOARD, TAKEOFF, LOITER, LAND, RTL, POSCTL = (
    6 << 16,
    *(4 << 16 | sub << 24 for sub in (2, 3, 6, 5)),
    3 << 16,
)
AUTOSTART_HZ = {
    "ATTITUDE": 100,
    "LOCAL_POSITION_NED": 30,
    "GLOBAL_POSITION_INT": 50,
    "HIGHRES_IMU": 50,
    "EXTENDED_SYS_STATE": 5,
    "SYS_STATUS": 5,
    "VFR_HUD": 10,
}
PARAMETERS = {
    "COM_OF_LOSS_T": 1.0,
    "COM_OBL_RC_ACT": 5,
    "MPC_XY_VEL_MAX": 12.0,
    "MPC_Z_VEL_MAX_UP": 3.0,
    "MPC_Z_VEL_MAX_DN": 1.5,
}


class FakePx4:
    """A vehicle standing at `start_ned_m` of a local frame that begins at `origin` (lat, lon, AMSL)."""

    def __init__(self, origin, start_ned_m=(0.0, 0.0, 0.0), yaw_ned_rad=0.7, clock_rate=1.0):
        self.origin, self.position, self.yaw = origin, list(start_ned_m), yaw_ned_rad
        self.ground_down_m = start_ned_m[2]
        self.velocity = [0.0, 0.0, 0.0]
        self.wind_ned_mps = (0.0, 0.0, 0.0)
        self.clock_rate = clock_rate
        self.mode, self.armed, self.status = LOITER, False, mavlink.MAV_STATE_STANDBY
        self.battery_pct = 90
        self.parameters = dict(PARAMETERS)
        self.intervals_us = {name: 1e6 / hz for name, hz in AUTOSTART_HZ.items()}
        # quirks, for tests to set
        self.stuck = self.mute_heartbeat = self.hides_origin = self.ignores_arming = self.ignores_offboard = (
            False
        )
        self.denies_arming_n = 0
        self.fix_type, self.frozen_place = 6, None
        self.estimate_off_ne_m = [0.0, 0.0]  # what the estimate is off, without its speed showing it
        self.offboard_grace_us = 0
        # what tests look at
        self.setpoints = []  # (vehicle's time in us, message)
        self.commands = []
        self.set_parameters = []
        self.modes = []  # that were asked for and entered
        self.track = []  # (time in us, position)
        self._mav = mavlink.MAVLink(None, 1, 1)
        self._mav.robust_parsing = True
        self._due_us = {}
        self._last_us = None
        self._boot_us = 0.0
        self._takeoff_down_m = None
        self._landed_us = None
        self._out = []

    def step(self, now_us, frames):
        dt = 0.0 if self._last_us is None else (now_us - self._last_us) * 1e-6 * self.clock_rate
        self._last_us = now_us
        self._boot_us += dt * 1e6
        for frame in frames:
            for message in self._mav.parse_buffer(frame) or []:
                handler = getattr(self, "_on_" + message.get_type().lower(), None)
                if handler:
                    handler(message)
        self._move(dt)
        self.track.append((now_us, tuple(self.position)))
        self._stream()
        out, self._out = self._out, []
        return out

    @property
    def armed_height_m(self):
        return self.ground_down_m - self.position[2]

    def _send(self, message):
        self._out.append(message.pack(self._mav))
        self._mav.seq = (self._mav.seq + 1) % 256

    def _boot_ms(self):
        return int(self._boot_us / 1000)

    # -- the body

    def _move(self, dt):
        if dt <= 0:
            return
        velocity = (0.0, 0.0, 0.0)
        newest = self.setpoints[-1] if self.setpoints else None
        if self.armed and self.mode == OFFBOARD and newest:
            if self._boot_us - newest[0] > self.parameters["COM_OF_LOSS_T"] * 1e6:
                self.mode, self.status = RTL, mavlink.MAV_STATE_CRITICAL
            m = newest[1]
            wanted = (m.vx + m.x, m.vy + m.y, m.vz + m.z)
            velocity = [w - p for w, p in zip(wanted, self.position, strict=True)]
            if self.stuck:
                velocity = (0.0, 0.0, 0.0)
            self.yaw = m.yaw
        elif self.armed and self.mode == TAKEOFF:
            climb = self.position[2] - self._takeoff_down_m
            velocity = (0.0, 0.0, -min(1.5, max(-0.5, climb)))
            if abs(climb) < 0.3:
                self.mode = LOITER
        elif self.armed and self.mode in (LAND, RTL):
            velocity = (0.0, 0.0, 1.5)
        self.velocity = (
            [v + w for v, w in zip(velocity, self.wind_ned_mps, strict=True)]
            if self.flying()
            else ([0.0, 0.0, min(0.0, velocity[2])])
        )
        self.position = [p + v * dt for p, v in zip(self.position, self.velocity, strict=True)]
        if not self.flying() and velocity[2] >= 0:
            self.position[2] = self.ground_down_m
            if self.armed and self.mode in (LAND, RTL):
                self._landed_us = self._landed_us or self._boot_us
                if self._boot_us - self._landed_us > 2e6:
                    self.armed = False

    def flying(self):
        return self.ground_down_m - self.position[2] > 0.05

    # -- what it hears

    def _on_set_position_target_local_ned(self, m):
        self.setpoints.append((self._boot_us, m))

    def _on_param_request_read(self, m):
        if m.param_id in self.parameters:
            value = self.parameters[m.param_id]
            kind = mavlink.MAV_PARAM_TYPE_INT32 if isinstance(value, int) else mavlink.MAV_PARAM_TYPE_REAL32
            if isinstance(value, int):
                value = struct.unpack("<f", struct.pack("<i", value))[0]
            self._send(mavlink.MAVLink_param_value_message(m.param_id.encode(), value, kind, 878, 0))

    def _on_param_set(self, m):
        now = self.parameters.get(m.param_id)
        if now is None:
            return
        value = m.param_value
        if isinstance(now, int):
            assert m.param_type == mavlink.MAV_PARAM_TYPE_INT32
            value = struct.unpack("<i", struct.pack("<f", value))[0]
        self.parameters[m.param_id] = value
        self.set_parameters.append((m.param_id, value))
        self._on_param_request_read(m)

    def _on_command_long(self, m):
        if (m.target_system, m.target_component) != (1, 1):
            return
        self.commands.append((self._boot_us, m))
        handler = getattr(self, f"_command_{m.command}", None)
        result = handler(m) if handler else mavlink.MAV_RESULT_UNSUPPORTED
        self._send(mavlink.MAVLink_command_ack_message(m.command, result))

    def _command_400(self, m):
        if self.denies_arming_n:
            self.denies_arming_n -= 1
            return mavlink.MAV_RESULT_TEMPORARILY_REJECTED
        if m.param1 == 0:
            self.armed = self.armed and self.flying()
        elif not self.ignores_arming:
            self.armed, self.status = True, mavlink.MAV_STATE_ACTIVE
        return 0

    def _command_22(self, m):
        assert all(map(math.isnan, (m.param4, m.param5, m.param6)))
        self.mode, self._takeoff_down_m = TAKEOFF, self.origin[2] - m.param7
        return 0

    def _command_176(self, m):
        mode = int(m.param2) << 16 | int(m.param3) << 24
        self._send(mavlink.MAVLink_command_ack_message(176, 0))  # the receiver's own, always yes
        if mode == OFFBOARD:
            if not self.setpoints or self._boot_us - self.setpoints[-1][0] > 0.5e6:
                return mavlink.MAV_RESULT_TEMPORARILY_REJECTED
            if self.ignores_offboard:
                return 0
        self.mode = mode
        self.modes.append(mode)
        return 0

    def _command_511(self, m):
        name = mavlink.mavlink_map[int(m.param1)].msgname
        if m.param2 < 0:
            self.intervals_us.pop(name, None)
        else:
            self.intervals_us[name] = m.param2
        return 0

    def _command_512(self, m):
        sender = getattr(self, "_send_" + mavlink.mavlink_map[int(m.param1)].msgname.lower(), None)
        if sender is None:
            return mavlink.MAV_RESULT_DENIED
        sender()
        return 0

    # -- what it says

    def _stream(self):
        if not self.mute_heartbeat:
            self._periodic("HEARTBEAT", 1e6)
        for name, interval_us in tuple(self.intervals_us.items()):
            self._periodic(name, interval_us)

    def _periodic(self, name, interval_us):
        if self.mute_heartbeat:
            return
        if self._boot_us >= self._due_us.get(name, 0.0):
            self._due_us[name] = max(self._boot_us, self._due_us.get(name, 0.0) + interval_us)
            getattr(self, "_send_" + name.lower())()

    def _send_heartbeat(self):
        base = 1 | (mavlink.MAV_MODE_FLAG_SAFETY_ARMED if self.armed else 0)
        quad, px4 = mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_AUTOPILOT_PX4
        self._send(mavlink.MAVLink_heartbeat_message(quad, px4, base, self.mode, self.status, 3))

    def _send_local_position_ned(self):
        (north, east, down), (off_north, off_east) = self.position, self.estimate_off_ne_m
        values = (north + off_north, east + off_east, down, *self.velocity)
        self._send(mavlink.MAVLink_local_position_ned_message(self._boot_ms(), *values))

    def _send_attitude(self):
        self._send(mavlink.MAVLink_attitude_message(self._boot_ms(), 0.0, 0.0, self.yaw, 0.0, 0.0, 0.0))

    def _send_global_position_int(self):
        north, east, down = self.position
        lat, lon, alt = pymap3d.ned2geodetic(north, east, down, *self.origin)
        where = (round(lat * 1e7), round(lon * 1e7), round(alt * 1e3))
        self._send(mavlink.MAVLink_global_position_int_message(self._boot_ms(), *where, 0, 0, 0, 0, 65535))

    def _send_gps_raw_int(self):
        lat, lon, alt = self.frozen_place or pymap3d.ned2geodetic(*self.position, *self.origin)
        where = (round(lat * 1e7), round(lon * 1e7), round(alt * 1e3))
        self._send(
            mavlink.MAVLink_gps_raw_int_message(int(self._boot_us), self.fix_type, *where, 70, 110, 0, 0, 15)
        )

    def _send_gps_global_origin(self):
        if not self.hides_origin:
            lat, lon, alt = self.origin
            where = (round(lat * 1e7), round(lon * 1e7), round(alt * 1e3))
            self._send(mavlink.MAVLink_gps_global_origin_message(*where, 0))

    def _send_autopilot_version(self):
        self._send(
            mavlink.MAVLink_autopilot_version_message(
                0xE8FF, 0x011100FF, 0, 0, 0, [0] * 8, [0] * 8, [0] * 8, 0, 0, 0, [0] * 18
            )
        )

    def _send_extended_sys_state(self):
        self._send(mavlink.MAVLink_extended_sys_state_message(0, 2 if self.flying() else 1))

    def _send_sys_status(self):
        self._send(
            mavlink.MAVLink_sys_status_message(0, 0, 0, 100, 16000, -1, self.battery_pct, 0, 0, 0, 0, 0, 0)
        )

    def _send_highres_imu(self):
        zeros = (0.0,) * 13
        self._send(mavlink.MAVLink_highres_imu_message(int(self._boot_us), *zeros, 0))

    def _send_vfr_hud(self):
        self._send(mavlink.MAVLink_vfr_hud_message(0.0, 0.0, 0, 0, 0.0, 0.0))
