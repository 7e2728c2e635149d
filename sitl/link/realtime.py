"""Real time: the only place in `sitl` with a wall clock."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from sitl.clock import FRAME_US
from sitl.link.endpoint import GCS_PORTS, INSTANCE_STEP, Endpoint, TcpLink, listens

__all__ = ["run", "signing_timestamp", "wait_for_client"]

_SIGNING_EPOCH_S = 1_420_070_400  # 2015-01-01 UTC
_PROBE_S = 0.05
_GIVE_UP_S = 0.5
"""So late, the clock is set anew rather than caught up with."""
_HASTE = 2.0
"""How much faster than asked for lateness is caught up with: all at once it would overflow the peers' sockets."""


def signing_timestamp() -> int:
    """What the clock says, as MAVLink's signatures count: 10 µs since 2015."""
    return int((time.time() - _SIGNING_EPOCH_S) * 1e5)


def wait_for_client(links: Sequence[Endpoint], instance: int) -> None:
    """Come back when somebody has connected to the first TCP port, or listens on the ground station's UDP port."""
    console = links[0]
    assert isinstance(console, TcpLink)
    while not (console.has_client() or listens(GCS_PORTS[1] + INSTANCE_STEP * instance)):
        time.sleep(_PROBE_S)


def run(
    exchange: Callable[[int, tuple[bytes, ...]], tuple[bytes, ...]],
    links: Sequence[Endpoint],
    *,
    speedup: float = 1.0,
    after_frame: Callable[[], bool] = lambda: True,
) -> None:
    """Drive `exchange` with simulated time, `speedup` times the clock's, until `after_frame` says no.

    Frames have absolute deadlines, so that lateness does not add up; who was kept from running hurries, but sends no flood.
    """
    frame_s = 1e-6 * FRAME_US / speedup
    now_us, deadline_s = 0, time.monotonic()
    begun_s = deadline_s
    while after_frame():
        now_us, deadline_s = now_us + FRAME_US, deadline_s + frame_s
        now_s = time.monotonic()
        if now_s - deadline_s > _GIVE_UP_S:
            deadline_s = now_s
        rest_s = max(deadline_s, begun_s + frame_s / _HASTE) - now_s
        if rest_s > 0.0:
            time.sleep(rest_s)
        begun_s = time.monotonic()
        received = tuple(link.receive() for link in links)
        for link, data in zip(links, exchange(now_us, received), strict=True):
            if data:
                link.send(data)
