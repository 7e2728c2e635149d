"""A .tlog of all that passes on a vehicle's links, as ground stations write it: time, frame, time, frame."""

from __future__ import annotations

from collections.abc import Iterator
from typing import BinaryIO

from sitl.clock import EPOCH_UNIX_US
from sitl.link.frames import whole_frames

__all__ = ["TlogWriter", "logged_frames"]

_STAMP, _LONGEST = 8, 280


class TlogWriter:
    """Writes frames to an unbuffered file, so that it can be read while the vehicle lives.

    Simulated time is logged, so that equal flights give equal files. A file that cannot be written any more (a full disk)
    is given up: `fault` says why, and the flight goes on.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.fault: OSError | None = None

    def write(self, now_us: int, *links: bytes) -> None:
        """Add the whole frames among these bytes, of each link its own."""
        stamp = (EPOCH_UNIX_US + now_us).to_bytes(_STAMP, "big")
        record = b"".join(stamp + frame for data in links for frame in whole_frames(data))
        if record and self.fault is None:
            try:
                self._file.write(record)
            except OSError as error:
                self.fault = error


def logged_frames(log: bytes) -> Iterator[bytes]:
    """The frames in a .tlog; a last one that is not whole is left out."""
    begin = 0
    while frame := next(whole_frames(log[begin + _STAMP : begin + _STAMP + _LONGEST]), b""):
        yield frame
        begin += _STAMP + len(frame)
