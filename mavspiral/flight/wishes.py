"""What a pilot may wish in flight, and what follows, as one table: `REPLIES`."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum, auto

from mavspiral.flight.outcome import State

__all__ = ["ALREADY", "REPLIES", "Wish"]


class Wish(Enum):
    """What the pilot wants done with the vehicle."""

    STOP = auto()
    """Hold; said again, fly home."""
    GO_ON = auto()
    GO_HOME = auto()
    LAND = auto()
    HAND_OVER = auto()
    """Hold in a mode of the vehicle's own, which the pilot takes over from."""


_CLIMBS = (State.TAKEOFF, State.PRESTREAM, State.OFFBOARD)
_MOVES = (State.ALIGN, State.STREAM, State.RETURN)
_HOMEWARD = ("stopped by the user; flying home", State.BRAKE)
_DOWN = ("stopped by the user; landing", State.LAND)

REPLIES: Mapping[tuple[State, Wish], tuple[str, State]] = {
    **{(state, wish): _DOWN for state in _CLIMBS for wish in (Wish.STOP, Wish.GO_HOME, Wish.LAND)},
    **{(state, Wish.STOP): ("stopping: the vehicle holds its position", State.HOLD) for state in _MOVES},
    (State.ALIGN, Wish.GO_HOME): _HOMEWARD,
    (State.STREAM, Wish.GO_HOME): _HOMEWARD,
    (State.HOLD, Wish.STOP): _HOMEWARD,
    (State.HOLD, Wish.GO_HOME): _HOMEWARD,
    (State.HOLD, Wish.LAND): _DOWN,
    (State.HOLD, Wish.HAND_OVER): ("handed over by the user", State.HAND_OVER),
}
"""The words, and the state that begins. What is not here changes nothing."""

ALREADY: Mapping[State, str] = {
    State.BRAKE: "it is about to fly home already; change its mode to take over",
    State.RETURN: "it is flying home already; change its mode to take over",
    State.LAND: "it is landing already; change its mode to take over",
    State.HAND_OVER: "it is being handed over already; change its mode to take over",
}
"""What is told of a wish that changes nothing."""
