"""MAVLink 2 signatures: made and checked, sans-I/O. The clock's part comes in as a number.

Source: mavlink.io, "Message Signing (Authentication)". Stricter than most autopilots: whatever is not signed is
refused, MAVLink 1 and radio reports too.
"""

from __future__ import annotations

import hmac
import re
from dataclasses import dataclass
from hashlib import sha256

from sitl.link.frames import MAGIC, SIGNED

__all__ = ["Signer", "SignerState", "Signing", "parse_key"]

_KEY_LENGTH = 32
_BLOCK = 13  # link, timestamp, signature
_STAMP, _SIGNATURE = 6, 6
_MINUTE = 6_000_000  # in units of 10 µs


@dataclass(frozen=True, slots=True)
class Signing:
    """A secret key of 32 bytes, and the time to begin at: 10 µs since 2015-01-01 UTC."""

    key: bytes
    timestamp: int


@dataclass(frozen=True, slots=True)
class SignerState:
    """All that a signer remembers: its time, the newest time of each stream, and its count."""

    timestamp: int
    streams: tuple[tuple[bytes, int], ...]
    refused: int


class Signer:
    """Signs what one vehicle sends, and refuses and counts what is unsigned, wrongly signed or replayed.

    Only a good signature changes what it remembers, so that nobody without the key can make it forget or grow.
    """

    def __init__(self, signing: Signing) -> None:
        self._key = signing.key
        self._timestamp = signing.timestamp
        self._streams: dict[bytes, int] = {}
        self.refused = 0

    def sign(self, frame: bytes) -> bytes:
        """The frame, whose header and checksum say that it is signed, with its signature."""
        self._timestamp += 1
        signed = frame + b"\0" + self._timestamp.to_bytes(_STAMP, "little")
        return signed + self._signature(signed)

    def accepts(self, frame: bytes) -> bool:
        """Whether a whole frame is signed with our key and newer than all that its stream sent before."""
        accepted = self._judge(frame)
        self.refused += not accepted
        return accepted

    def _judge(self, frame: bytes) -> bool:
        if frame[0] != MAGIC or not frame[2] & SIGNED:
            return False
        stamp = int.from_bytes(frame[-_STAMP - _SIGNATURE : -_SIGNATURE], "little")
        stream = frame[-_BLOCK : -_BLOCK + 1] + frame[5:7]  # link, system, component
        # A stream that nobody has heard of may be a minute late, but no more.
        if stamp <= self._streams.get(stream, self._timestamp - _MINUTE - 1):
            return False
        if not hmac.compare_digest(self._signature(frame[:-_SIGNATURE]), frame[-_SIGNATURE:]):
            return False
        self._streams[stream] = stamp
        self._timestamp = max(self._timestamp, stamp)
        return True

    def _signature(self, signed: bytes) -> bytes:
        return sha256(self._key + signed).digest()[:_SIGNATURE]

    def snapshot(self) -> SignerState:
        """All that it remembers."""
        return SignerState(self._timestamp, tuple(self._streams.items()), self.refused)

    def restore(self, state: SignerState) -> None:
        """Go on from a snapshot."""
        self._timestamp, self._streams, self.refused = state.timestamp, dict(state.streams), state.refused


def parse_key(data: bytes) -> bytes:
    """The key in a key file: 32 bytes as they are, or 64 hexadecimal digits.

    Raises:
        ValueError: it is neither.
    """
    if len(data) == _KEY_LENGTH:
        return data
    if re.fullmatch(rb"[0-9a-fA-F]{64}", data.strip()):
        return bytes.fromhex(data.strip().decode("ascii"))
    raise ValueError(
        f"{len(data)} bytes are no key: wanted 32 bytes or 64 hexadecimal digits, as `openssl rand -hex 32` gives"
    )
