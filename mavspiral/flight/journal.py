"""The journal of an inspection: what was flown, written as it happens, to be read after any end.

A file of records, each `kind` (one byte), the size of its body (u32), the body and a CRC-32 of all of these; all
little-endian. It only grows: every flight of the inspection begins with a "B". A process that is killed leaves at
most one record torn, the last; reading ends there, and writing goes on there.

    B  JSON   a flight begins: what is flown, of which plan, from where to where
    A  JSON   where the plan lies: {"shift_enu_m": [east, north, 0]}; without it, as planned
    P  JSON   where it is placed: the vehicle's origin, the legs, when the inspection begins
    F  JSON   parameters set for the flight and not yet put back: {name: [the vehicle's own value, the one given]}; written
              at once, since they outlast us
    R  rows   of the flight log, 19 doubles each (`Recorder`)
    E  JSON   an event: [t_us, severity, text]
    S  JSON   pictures: [shot, the vehicle's seconds, the camera's number] each
    Z  JSON   the flight is over: {"ok": …, "reason": …}
"""

from __future__ import annotations

import json
import struct
import zlib
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.flight.alignment import shifted
from mavspiral.flight.flight_log import ROW_N, Event, FlightLog, log_of_rows
from mavspiral.flight.outcome import Step
from mavspiral.flight.session import Session
from mavspiral.flight.shutter import Picture
from mavspiral.frames import GeoPoint, LocalFrame

__all__ = ["AT_ONCE", "JournalWriter", "JournaledFlight", "borrowed_in", "read_journal", "whole_n"]

AT_ONCE = b"F"
"""The records that may not wait for the next round of the disk."""

_HEAD = struct.Struct("<cI")
_CRC = struct.Struct("<I")


@dataclass(frozen=True, slots=True, eq=False)
class JournaledFlight:
    """One flight of a journal.

    Args:
        begin: what was told at its beginning (`JournalWriter.begin`).
        shift_enu_m: by which the plan lay elsewhere, `(3,)`; None if it was not aligned.
        place: the vehicle's origin and the legs; None if it ended before the vehicle's place was known.
        rows: of the log, `(n, 19)`.
        pictures: that were taken.
        borrowed: what it had last set and not put back (`Session.borrowed`); None if it wrote nothing of that.
        end: how it ended; None if nobody lived to write it.
    """

    begin: dict[str, Any]
    shift_enu_m: FloatArray | None
    place: dict[str, Any] | None
    rows: FloatArray
    events: tuple[Event, ...]
    pictures: tuple[Picture, ...]
    borrowed: dict[str, tuple[float, float]] | None
    end: dict[str, Any] | None

    def log(self, frame: LocalFrame) -> FlightLog | None:
        """Its log in the plan's `frame`, as planned, wherever it lay; None if it never came off the ground."""
        if self.place is None or not len(self.rows):
            return None
        if self.shift_enu_m is not None:
            frame = shifted(frame, self.shift_enu_m)
        to_vehicle = frame.to_vehicle(GeoPoint(*self.place["origin"]))
        return log_of_rows(self.rows, to_vehicle, tuple(self.place["legs"]), self.events)


class JournalWriter:
    """Writes one flight into a journal, record by record.

    Args:
        write: takes the bytes; it must not wait.
    """

    def __init__(self, write: Callable[[bytes], object]) -> None:
        self._write = write
        self._rows_n = 0
        self._pictures_n = 0
        self._placed = False
        self._borrowed: dict[str, tuple[float, float]] = {}

    def begin(self, facts: dict[str, Any]) -> None:
        """The flight begins; `facts` are what a later one must know."""
        self._json(b"B", facts)

    def aligned(self, shift_enu_m: FloatArray) -> None:
        """The plan lies so far from where it was planned."""
        self._json(b"A", {"shift_enu_m": shift_enu_m.tolist()})

    def note(self, session: Session, step: Step) -> None:
        """Write down what the step has brought."""
        if not self._placed and session.trajectory is not None:
            self._placed = True
            self._json(
                b"P",
                {
                    "origin": session.origin,
                    "legs": [leg.name for leg in session.trajectory.legs],
                    "inspection_s": session.trajectory.span_s("inspection")[0],
                },
            )
        for event in step.events:
            self._json(b"E", event)
        if (borrowed := session.borrowed) != self._borrowed:
            self._borrowed = borrowed
            self._json(b"F", borrowed)
        pictures = session.pictures_since(self._pictures_n)
        if pictures:
            self._pictures_n += len(pictures)
            self._json(b"S", [astuple(picture) for picture in pictures])
        rows = session.rows_since(self._rows_n)
        if rows:
            self._rows_n += len(rows) // (8 * ROW_N)
            self._record(b"R", rows)

    def end(self, session: Session) -> None:
        """The flight is over."""
        outcome = session.outcome
        if outcome is not None:
            self._json(b"Z", {"ok": outcome.ok, "reason": outcome.reason})

    def _json(self, kind: bytes, document: Any) -> None:
        self._record(kind, json.dumps(document, ensure_ascii=False).encode())

    def _record(self, kind: bytes, body: bytes) -> None:
        framed = _HEAD.pack(kind, len(body)) + body
        self._write(framed + _CRC.pack(zlib.crc32(framed)))


def read_journal(path: Path) -> tuple[JournaledFlight, ...]:
    """Every flight in the journal at `path`, in order; what a kill has torn off is not there.

    Raises:
        InputError: it cannot be read, or is no journal.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(
            f"{path}: no journal to resume from ({error.strerror}). Fix: `fly` without --resume, or --out with its folder"
        ) from None
    flights: list[dict[bytes, list[bytes]]] = []
    for kind, body in _records(data):
        if kind == b"B":
            flights.append(defaultdict(list))
        if flights:
            flights[-1][kind].append(body)
    if data and not flights:
        raise InputError(f"{path}: is no journal of mavspiral. Fix: move it away, and `fly` without --resume")
    return tuple(map(_flight, flights))


def borrowed_in(path: Path) -> dict[str, tuple[float, float]]:
    """What the flights in the journal at `path` have set and not put back (`Session.borrowed`); nothing without one.

    Raises:
        InputError: it cannot be read.
    """
    data = _data(path)
    return _borrowed([body for kind, body in _records(data) if kind == b"F"]) or {}


def _flight(told: dict[bytes, list[bytes]]) -> JournaledFlight:
    """One flight, from the bodies of its records of each kind."""
    shift, place, end = (json.loads(told[kind][-1]) if told[kind] else None for kind in (b"A", b"P", b"Z"))
    return JournaledFlight(
        begin=json.loads(told[b"B"][-1]),
        shift_enu_m=None if shift is None else np.array(shift["shift_enu_m"], dtype=np.float64),
        place=place,
        rows=np.frombuffer(b"".join(told[b"R"]), dtype="<f8").reshape(-1, ROW_N),
        events=tuple(Event(*json.loads(body)) for body in told[b"E"]),
        pictures=tuple(Picture(*fields) for body in told[b"S"] for fields in json.loads(body)),
        borrowed=_borrowed(told[b"F"]),
        end=end,
    )


def _borrowed(told: list[bytes]) -> dict[str, tuple[float, float]] | None:
    """What the last of these records says, if there is one."""
    if not told:
        return None
    return {name: (own, given) for name, (own, given) in json.loads(told[-1]).items()}


def whole_n(path: Path) -> int:
    """How many bytes of the journal at `path` are whole records: there the next one is written.

    Raises:
        InputError: it cannot be read.
    """
    data = _data(path)
    return sum(_HEAD.size + len(body) + _CRC.size for _, body in _records(data))


def _data(path: Path) -> bytes:
    """The journal's bytes; none where there is none."""
    try:
        return path.read_bytes()
    except FileNotFoundError:
        return b""
    except OSError as error:
        raise InputError(
            f"{path}: cannot be read ({error.strerror}). Fix: move it away, or another --out"
        ) from None


def _records(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Kind and body of each record, up to the first that is not whole."""
    at = 0
    while at + _HEAD.size <= len(data):
        kind, size = _HEAD.unpack_from(data, at)
        end = at + _HEAD.size + size
        if end + _CRC.size > len(data) or _CRC.unpack_from(data, end)[0] != zlib.crc32(data[at:end]):
            return
        yield kind, data[at + _HEAD.size : end]
        at = end + _CRC.size
