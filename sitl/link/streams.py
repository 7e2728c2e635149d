"""When which message is due: PX4's rates at the start, then whatever the other end asks for."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from heapq import heapify, heappop, heappush
from operator import itemgetter

from sitl.link.messages import message_type

__all__ = ["GCS_RATES_HZ", "OFFBOARD_RATES_HZ", "Schedule", "Streams"]

OFFBOARD_RATES_HZ: Mapping[str, float] = {
    "ATTITUDE": 100.0,
    "ATTITUDE_QUATERNION": 50.0,
    "HIGHRES_IMU": 50.0,
    "GLOBAL_POSITION_INT": 50.0,
    "LOCAL_POSITION_NED": 30.0,
    "ODOMETRY": 30.0,
    "TIMESYNC": 10.0,
    "ALTITUDE": 10.0,
    "DISTANCE_SENSOR": 10.0,
    "ATTITUDE_TARGET": 10.0,
    "POSITION_TARGET_LOCAL_NED": 10.0,
    "SERVO_OUTPUT_RAW": 10.0,
    "VFR_HUD": 10.0,
    "GPS_RAW_INT": 8.0,
    "EXTENDED_SYS_STATE": 5.0,
    "SYS_STATUS": 5.0,
    "HEARTBEAT": 1.0,
    "GPS_GLOBAL_ORIGIN": 1.0,
    "ESTIMATOR_STATUS": 1.0,
    "PING": 1.0,
    "SCALED_PRESSURE": 1.0,
    "SYSTEM_TIME": 1.0,
    "BATTERY_STATUS": 0.5,
    "HOME_POSITION": 0.5,
    "CURRENT_MODE": 0.5,
    "CURRENT_EVENT_SEQUENCE": 1.0 / 3.0,
    "VIBRATION": 0.5,
    "ORBIT_EXECUTION_STATUS": 2.0,
}
"""What PX4 v1.17 was seen to send on 14540, as far as this vehicle has it to send."""

GCS_RATES_HZ: Mapping[str, float] = {
    "ATTITUDE": 50.0,
    "ATTITUDE_QUATERNION": 50.0,
    "GLOBAL_POSITION_INT": 50.0,
    "LOCAL_POSITION_NED": 50.0,
    "POSITION_TARGET_LOCAL_NED": 50.0,
    "SERVO_OUTPUT_RAW": 20.0,
    "VFR_HUD": 4.0,
    "ODOMETRY": 3.0,
    "ALTITUDE": 1.0,
    "BATTERY_STATUS": 0.5,
    "DISTANCE_SENSOR": 0.5,
    "ESTIMATOR_STATUS": 0.5,
    "EXTENDED_SYS_STATE": 1.0,
    "GPS_GLOBAL_ORIGIN": 1.0,
    "GPS_RAW_INT": 1.0,
    "HEARTBEAT": 1.0,
    "HOME_POSITION": 0.5,
    "PING": 0.1,
    "SYSTEM_TIME": 1.0,
    "SYS_STATUS": 1.0,
    "CURRENT_MODE": 0.5,
    "CURRENT_EVENT_SEQUENCE": 1.0 / 3.0,
    "VIBRATION": 0.1,
    "ORBIT_EXECUTION_STATUS": 5.0,
}
"""PX4's "normal" mode with what its SITL start script (px4-rc.mavlink) adds for a ground station."""

Schedule = tuple[tuple[int, int, int], ...]
"""(due_us, interval_us, message id) of each stream that is on."""

_LONGEST_US = 2**31
_NEVER_US = 2**63


class Streams:
    """The messages that a link sends unasked, each at its own interval."""

    def __init__(self, rates_hz: Mapping[str, float]) -> None:
        self._defaults_us = {
            message_type(name).ID: round(1e6 / rate_hz) for name, rate_hz in rates_hz.items()
        }
        self._queue: list[tuple[int, int, int, int]] = []
        """Due, rank, interval and message id of each stream, as a heap; what is due at once goes out by rank."""
        self.next_us = 0
        """When the next message is due."""
        self._set((0, interval_us, message_id) for message_id, interval_us in self._defaults_us.items())

    def due(self, now_us: int) -> list[int]:
        """The numbers of the messages to send now. Each call uses them up."""
        if now_us < self.next_us:
            return []
        queue, late = self._queue, []
        while queue and queue[0][0] <= now_us:
            late.append(heappop(queue))
        for due_us, rank, interval_us, message_id in late:
            # Late by more than an interval: go on from now rather than catch up in a burst.
            due_us = max(due_us + interval_us, now_us - interval_us + 1)
            heappush(queue, (due_us, rank, interval_us, message_id))
        self.next_us = queue[0][0]
        if len(late) > 1:
            late.sort(key=itemgetter(1))
        return [stream[-1] for stream in late]

    def interval_us(self, message_id: int) -> int:
        """How far apart that message is sent; -1 when it is off."""
        return next((interval_us for *_, interval_us, number in self._queue if number == message_id), -1)

    def set_interval_us(self, message_id: int, interval_us: float, now_us: int) -> None:
        """Send that message so far apart; negative is off, zero PX4's default (off where there is none)."""
        others = [stream for stream in self.snapshot() if stream[2] != message_id]
        if interval_us == 0:
            interval_us = self._defaults_us.get(message_id, -1)
        if 0 < interval_us < _LONGEST_US:
            others.append((now_us, round(interval_us), message_id))
        self._set(others)

    def snapshot(self) -> Schedule:
        """All that the streams remember."""
        by_rank = sorted(self._queue, key=itemgetter(1))
        return tuple((due_us, interval_us, message_id) for due_us, _, interval_us, message_id in by_rank)

    def restore(self, schedule: Schedule) -> None:
        """Go on from a snapshot."""
        self._set(schedule)

    def _set(self, schedule: Iterable[tuple[int, int, int]]) -> None:
        ranked = enumerate(schedule)
        self._queue = [(due_us, rank, interval_us, number) for rank, (due_us, interval_us, number) in ranked]
        heapify(self._queue)
        self.next_us = self._queue[0][0] if self._queue else _NEVER_US
