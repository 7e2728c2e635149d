"""A radio link that loses and delays: what its faults do to the bytes of one direction. Sans-I/O."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sitl.faults import LinkDelay, LinkFault, LinkLoss, PacketLoss
from sitl.link.frames import frames

__all__ = ["Channel", "ChannelState"]


@dataclass(frozen=True, slots=True)
class ChannelState:
    """What is under way, oldest first, and where the dice stand."""

    waiting: tuple[tuple[int, bytes], ...]
    generator: Mapping[str, Any]


class Channel:
    """One direction of a link. Frames are lost one by one, by a die of its own; they never overtake."""

    def __init__(self, seed: np.random.SeedSequence) -> None:
        self._generator = np.random.Generator(np.random.PCG64(seed))
        self._waiting: list[tuple[int, bytes]] = []

    def carry(self, now_us: int, data: bytes, active: Sequence[LinkFault]) -> bytes:
        """What arrives now, of what was sent before and now, under the faults that are active."""
        if not active and not self._waiting:
            return data
        delay_us, kept = 0, 1.0
        for fault in active:
            match fault:
                case LinkLoss():
                    kept = 0.0
                case PacketLoss(share=share):
                    kept *= 1.0 - share
                case LinkDelay():
                    delay_us += fault.delay_us
        for frame in frames(data):
            if kept == 1.0 or self._generator.random() < kept:
                self._waiting.append((now_us + delay_us, frame))
        arrived = bytearray()
        while self._waiting and self._waiting[0][0] <= now_us:
            arrived += self._waiting.pop(0)[1]
        return bytes(arrived)

    def snapshot(self) -> ChannelState:
        """The whole state, as a value."""
        return ChannelState(tuple(self._waiting), self._generator.bit_generator.state)

    def restore(self, state: ChannelState) -> None:
        """Go on from a snapshot."""
        self._waiting = list(state.waiting)
        self._generator.bit_generator.state = state.generator
