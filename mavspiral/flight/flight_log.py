"""What happened, in columns; and the packets themselves, as a .tlog."""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.files import write_with
from mavspiral.flight.messages import Setpoint
from mavspiral.flight.vehicle import Vehicle
from mavspiral.frames import RigidMap, yaw_ned_to_enu
from mavspiral.motion.trajectory import belongs

__all__ = ["ROW_N", "Event", "FlightLog", "Recorder", "TlogWriter", "joined", "log_of_rows"]

NO_LEG = -1
ROW_N = 19
"""Numbers in a row of `Recorder`: two clocks, leg, pace (2), the reference's and the estimate's position, velocity, yaw."""

_PACKED = struct.Struct(f"<{ROW_N}d").pack
_NOTHING = (np.nan,) * 7
_NOWHERE = (np.nan,) * 6


class Event(NamedTuple):
    """Something worth telling: `severity` is "info", "warning" or "error"."""

    t_us: int
    severity: str
    text: str


@dataclass(frozen=True, slots=True, eq=False)
class FlightLog:
    """A flight, row by row from arming to the end, in the plan's ENU.

    Args:
        t_us: the clock that drove the session.
        vehicle_s: the vehicle's own clock, since its boot.
        path_t_s: path time of the reference; NaN in rows without one.
        leg: index into `legs` of the leg being flown, -1 off the trajectory.
        truth_position_enu_m: filled in by whoever knows the truth (`with_truth`), else None.
    """

    legs: tuple[str, ...]
    events: tuple[Event, ...]
    t_us: NDArray[np.int64]
    vehicle_s: FloatArray
    leg: NDArray[np.int64]
    path_t_s: FloatArray
    governor_rate: FloatArray
    reference_position_enu_m: FloatArray
    reference_velocity_enu_mps: FloatArray
    reference_yaw_enu_rad: FloatArray
    estimate_position_enu_m: FloatArray
    estimate_velocity_enu_mps: FloatArray
    estimate_yaw_enu_rad: FloatArray
    truth_position_enu_m: FloatArray | None = None
    truth_velocity_enu_mps: FloatArray | None = None
    truth_yaw_enu_rad: FloatArray | None = None

    def on_leg(self, name: str) -> NDArray[np.bool_]:
        """Which rows were flown on a leg that belongs to `name`."""
        wanted = [index for index, leg in enumerate(self.legs) if belongs(leg, name)]
        return np.isin(self.leg, wanted)

    def with_truth(
        self, position_enu_m: FloatArray, velocity_enu_mps: FloatArray, yaw_enu_rad: FloatArray
    ) -> FlightLog:
        """The same flight with the truth beside it, one row for each of ours."""
        return replace(
            self,
            truth_position_enu_m=position_enu_m,
            truth_velocity_enu_mps=velocity_enu_mps,
            truth_yaw_enu_rad=yaw_enu_rad,
        )

    def save(self, path: Path) -> None:
        """Write the log as .npz, whole or not at all."""
        columns = {f.name: getattr(self, f.name) for f in fields(self)}
        columns["legs"] = np.array(self.legs, dtype=np.str_)
        columns["events"] = np.array([(str(e.t_us), e.severity, e.text) for e in self.events], dtype=np.str_)
        present = {name: column for name, column in columns.items() if column is not None}
        write_with(path, lambda file: np.savez_compressed(file, **present))

    @classmethod
    def load(cls, path: Path) -> FlightLog:
        """The log that `save` wrote."""
        with np.load(path, allow_pickle=False) as file:
            columns = {name: file[name] for name in file.files}
        legs = tuple(str(name) for name in columns.pop("legs"))
        events = tuple(
            Event(int(t), str(s), str(text)) for t, s, text in columns.pop("events").reshape(-1, 3)
        )
        return cls(legs, events, **columns)


def joined(logs: Sequence[FlightLog], begins_us: Sequence[int]) -> FlightLog:
    """Flights in a row as one log; each began at `begins_us` of the clock that is common then. Legs are not merged."""
    columns: dict[str, list[np.ndarray]] = {}
    legs: tuple[str, ...] = ()
    events: tuple[Event, ...] = ()
    for log, begin_us in zip(logs, begins_us, strict=True):
        for column in fields(log)[2:]:
            values = getattr(log, column.name)
            if column.name == "t_us":
                values = values + begin_us
            elif column.name == "leg":
                values = np.where(values == NO_LEG, NO_LEG, values + len(legs))
            if values is not None:
                columns.setdefault(column.name, []).append(values)
        legs += log.legs
        events += tuple(event._replace(t_us=event.t_us + begin_us) for event in log.events)
    return FlightLog(legs, events, **{name: np.concatenate(parts) for name, parts in columns.items()})


class Recorder:
    """Takes rows as they happen, in the vehicle's frame, at about a microsecond each."""

    def __init__(self) -> None:
        self._rows = bytearray()

    def row(
        self,
        now_us: int,
        vehicle_us: float,
        leg: int,
        pace: tuple[float, float],
        due: Setpoint | None,
        vehicle: Vehicle,
    ) -> None:
        """Note path time and its rate, the reference and the vehicle's estimate at this moment."""
        local, attitude = vehicle.local, vehicle.attitude
        wanted = (*due[:6], due[9]) if due else _NOTHING
        believed = local[1:7] if local else _NOWHERE
        yaw_ned_rad = attitude[3] if attitude else np.nan
        self._rows += _PACKED(now_us, vehicle_us, leg, *pace, *wanted, *believed, yaw_ned_rad)

    def since(self, row: int) -> bytes:
        """The rows from number `row` on, as little-endian doubles."""
        return bytes(self._rows[8 * ROW_N * row :])

    def log(self, to_vehicle: RigidMap, legs: tuple[str, ...], events: tuple[Event, ...]) -> FlightLog:
        """All rows so far, in the frame that `to_vehicle` comes from."""
        return log_of_rows(np.frombuffer(self.since(0)).reshape(-1, ROW_N), to_vehicle, legs, events)


def log_of_rows(
    rows: FloatArray, to_vehicle: RigidMap, legs: tuple[str, ...], events: tuple[Event, ...]
) -> FlightLog:
    """The log of a recorder's rows `(n, 19)`, in the frame that `to_vehicle` comes from."""
    back = to_vehicle.R_ned_enu
    columns: list[np.ndarray] = [
        rows[:, 0].astype(np.int64),
        rows[:, 1] * 1e-6,
        rows[:, 2].astype(np.int64),
        rows[:, 3].copy(),
        rows[:, 4].copy(),
    ]
    for first in (5, 12):
        columns += [
            to_vehicle.position_enu_m(rows[:, first : first + 3]),
            rows[:, first + 3 : first + 6] @ back,
            yaw_ned_to_enu(rows[:, first + 6]),
        ]
    for column in columns:
        column.setflags(write=False)
    return FlightLog(legs, events, *columns)


class TlogWriter:
    """Writes whole packets as a .tlog: eight bytes of big-endian microseconds, then the frame.

    Args:
        put: takes the bytes, such as a file's `write`.
        epoch_us: what is added to the session's clock to make Unix time.
    """

    def __init__(self, put: Callable[[bytes], object], epoch_us: int = 0) -> None:
        self._put = put
        self._epoch_us = epoch_us
        self._stamped_us, self._stamp = -1, b""

    def write(self, now_us: int, frame: bytes) -> None:
        """Append one packet."""
        if now_us != self._stamped_us:
            self._stamped_us, self._stamp = now_us, (now_us + self._epoch_us).to_bytes(8, "big")
        self._put(self._stamp + frame)
