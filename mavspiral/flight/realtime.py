"""The wall clock: drives a session against the world.

Absolute deadlines: the loop sleeps until a packet comes or the next deadline is near, and is awake when it comes.
"""

from __future__ import annotations

import contextlib
import gc
import signal
import sys
import time
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Protocol, TypeVar

from mavspiral.errors import LinkError
from mavspiral.flight.outcome import Outcome, Step
from mavspiral.flight.priority import run_as, run_first
from mavspiral.flight.signing import Signer
from mavspiral.flight.transports import Transport

__all__ = ["Machine", "drive", "signer_now"]

SIGNING_EPOCH_NS = 1_420_070_400_000_000_000
"""2015-01-01 UTC, from which MAVLink's signatures count."""

_ENDS = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))
_SWITCH_S = 0.0005
_AWAKE_US = 1000
_AWAKE_OF_WAIT = 20


class Machine(Protocol):
    """What can be driven: a flight, an upload."""

    @property
    def outcome(self) -> Outcome | None:
        """How it ended; None as long as it goes on."""

    def step(self, now_us: int, received: bytes) -> Step:
        """Take in `received`; what to send, and when to call again."""

    def stop(self) -> None:
        """Ask for an end."""

    def link_broke(self, reason: str) -> None:
        """Be told that the link is gone for good."""


M = TypeVar("M", bound=Machine)


def signer_now(key: bytes) -> Signer:
    """Signs with the 32 bytes of `key` from this moment on."""
    return Signer(key, (time.time_ns() - SIGNING_EPOCH_NS) // 10_000)


def drive(
    session: M,
    transport: Transport,
    on_step: Callable[[M, Step], None] | None = None,
    *,
    on_end: Callable[[], None] | None = None,
    now_us: Callable[[], int] = lambda: time.monotonic_ns() // 1000,
) -> Outcome:
    """Fly `session` over `transport` to its end. Ctrl-C, a polite kill and a terminal that hangs up never cut it off.

    Ctrl-C asks it to stop.

    Args:
        session: what to drive.
        transport: to the vehicle.
        on_step: is shown every step; what it does must be quick. If it fails it is not asked again, and the flight
            goes on; the error is raised at the end unless it is an OSError.
        on_end: is called when the process is to end, or its terminal has gone, so that nobody can be asked any more; by
            default it is asked to stop.
        now_us: a clock that only goes forward.
    """
    received, due_us, awake_us = b"", now_us(), 0
    told: Exception | None = None
    with _interrupts(session.stop, on_end or session.stop), _punctual():
        while session.outcome is None:
            step = session.step(now_us(), received)
            try:
                transport.send(step.send)
                if step.afterwards is not None:
                    step.afterwards()
                if on_step is not None and told is None:
                    try:
                        on_step(session, step)
                    except Exception as error:  # a closed terminal must not leave a vehicle in the air
                        told = error
                if step.next_due_us != due_us:
                    awake_us = min(_AWAKE_US, (step.next_due_us - due_us) // _AWAKE_OF_WAIT)
                    due_us = step.next_due_us
                received = _received(transport, due_us, awake_us, now_us)
            except LinkError as error:
                session.link_broke(str(error))
    if told is not None and not isinstance(told, OSError):
        raise told
    return session.outcome


def _received(transport: Transport, due_us: int, awake_us: int, now_us: Callable[[], int]) -> bytes:
    """What has come, or nothing once it is `due_us`.

    The last `awake_us` are not slept: a processor that sleeps takes up to a millisecond to wake, and a packet that is
    taken in just before the deadline would hold up the setpoint.
    """
    asleep_us = due_us - awake_us - now_us()
    received = transport.receive(asleep_us * 1e-6) if asleep_us > 0 else b""
    if received:
        return received
    while now_us() < due_us:
        pass
    return transport.receive(0.0)


@contextlib.contextmanager
def _punctual() -> Iterator[None]:
    """Within, no garbage is looked for, no other thread keeps us waiting, and, where the system lets us, no other program.

    A full collection after planning takes a tenth of a second, five setpoints; a whole flight leaves some hundred objects
    that only a collection would find. A thread that writes the log gives way within half a millisecond, not five. The
    priority is this thread's alone.
    """
    gc.collect()
    collects, switches_s = gc.isenabled(), sys.getswitchinterval()
    gc.disable()
    sys.setswitchinterval(_SWITCH_S)
    before = run_first()
    try:
        yield
    finally:
        sys.setswitchinterval(switches_s)
        if collects:
            gc.enable()
        run_as(before)


@contextlib.contextmanager
def _interrupts(stop: Callable[[], None], end: Callable[[], None]) -> Iterator[None]:
    """Within, Ctrl-C calls `stop`, a polite kill or a hang-up `end`, where the interpreter lets us (not in a thread)."""

    def caught(number: int, _frame: FrameType | None) -> None:
        (stop if number == signal.SIGINT else end)()

    try:
        before = {number: signal.signal(number, caught) for number in (signal.SIGINT, *_ENDS)}
    except ValueError:
        yield
        return
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
