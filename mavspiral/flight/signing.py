"""MAVLink 2 signatures of our end of the link: made and checked, sans-I/O. The clock's part comes in as a number.

Source: mavlink.io, "Message Signing (Authentication)". The bundled vehicle has its own (`sitl.link.signing`), so that
each is checked by the other, and both by pymavlink.
"""

from __future__ import annotations

import hashlib
import hmac
import re
from pathlib import Path

from mavspiral.errors import InputError

__all__ = ["SIGNATURE_N", "SIGNED", "Signer", "is_signed", "read_key"]

SIGNED = 1  # MAVLINK_IFLAG_SIGNED
SIGNATURE_N = 13

_V2 = 0xFD
_KEY_N = 32
_MINUTE = 6_000_000
_LINK_ID = b"\1"  # the vehicle's own is another


class Signer:
    """Signs what we send; refuses and counts whatever is not signed with the same key, or has come before.

    Args:
        key: 32 bytes, the vehicle's own.
        timestamp: what the clock says now, in units of 10 µs since 2015-01-01 UTC.
    """

    def __init__(self, key: bytes, timestamp: int) -> None:
        self._key = key
        self._timestamp = timestamp
        self._newest: dict[bytes, int] = {}  # of each link, system and component that has signed well
        self.refused_n = 0

    def sign(self, frame: bytes) -> bytes:
        """`frame`, already flagged as signed, with its signature."""
        self._timestamp += 1
        body = frame + _LINK_ID + self._timestamp.to_bytes(6, "little")
        return body + self._digest(body)

    def accepts(self, frame: bytes) -> bool:
        """Whether that whole frame comes from somebody who has the key, and for the first time."""
        good = is_signed(frame) and self._is_new_and_signed(frame)
        self.refused_n += not good
        return good

    def _is_new_and_signed(self, frame: bytes) -> bool:
        body, digest = frame[:-6], frame[-6:]
        who, stamp = body[-7:-6] + body[5:7], int.from_bytes(body[-6:], "little")
        newest = self._newest.get(who)
        is_new = stamp > newest if newest is not None else stamp >= self._timestamp - _MINUTE
        if not is_new or not hmac.compare_digest(self._digest(body), digest):
            return False
        self._newest[who] = stamp
        self._timestamp = max(self._timestamp, stamp)
        return True

    def _digest(self, body: bytes) -> bytes:
        return hashlib.sha256(self._key + body).digest()[:6]


def is_signed(frame: bytes) -> bool:
    """Whether that whole frame says that it is signed."""
    return frame[0] == _V2 and bool(frame[2] & SIGNED)


def read_key(path: Path) -> bytes:
    """The 32 bytes in a key file: as they are, or as 64 hexadecimal digits.

    Raises:
        InputError: it cannot be read, or is no key.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"--signing {path}: {error.strerror}. Fix: openssl rand -hex 32 > {path}") from None
    if len(data) == _KEY_N:
        return data
    if re.fullmatch(rb"[0-9a-fA-F]{64}", data.strip()):
        return bytes.fromhex(data.strip().decode("ascii"))
    raise InputError(
        f"--signing {path}: {len(data)} bytes are no key. Fix: 32 bytes, or 64 hexadecimal digits as `openssl rand -hex 32` gives"
    )
