"""A file that grows while a flight goes on, without the flight ever waiting for a disk."""

from __future__ import annotations

import os
import threading
from collections import deque
from pathlib import Path

from mavspiral.errors import InputError
from mavspiral.flight.priority import run_first

__all__ = ["Spool"]

_EVERY_S = 0.2
_SYNC_EVERY_N = 5
_PENDING_MAX_N = 64 * 2**20
"""Bytes. A disk that hangs for minutes costs log, not memory, and not the stream."""


class Spool:
    """Takes bytes at once and has a thread append them to a file.

    They are with the operating system within 0.2 s, where a killed process does not lose them, and on the disk
    within about a second, where a dead battery does not. What does not fit is counted in `lost_n`, and the first
    error of the disk is kept in `error`; neither is raised.

    Args:
        path: of the file, which is made if it is not there.
        keep_n: how many of the bytes that are there stay; None for all.

    Raises:
        InputError: the file cannot be opened for writing.
    """

    def __init__(self, path: Path, *, keep_n: int | None = None) -> None:
        self.lost_n = 0
        self.error: OSError | None = None
        self._pending: deque[bytes] = deque()
        self._pending_n = 0
        self._written_n = 0
        self._over, self._hurry = threading.Event(), threading.Event()
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
            if keep_n is not None:
                os.ftruncate(self._file, keep_n)
        except OSError as error:
            raise InputError(
                f"{path}: cannot be written ({error.strerror}). Fix: choose another folder with --out"
            ) from None
        self._thread = threading.Thread(target=self._run, name=f"spool {path.name}", daemon=True)
        self._thread.start()

    def write(self, data: bytes) -> None:
        """Take `data`, to be appended soon."""
        if self._pending_n - self._written_n + len(data) > _PENDING_MAX_N:
            self.lost_n += len(data)
            return
        self._pending_n += len(data)
        self._pending.append(data)

    def hurry(self) -> None:
        """Have what was taken on the disk as soon as it can be, without waiting for that."""
        self._hurry.set()

    def close(self) -> None:
        """Append what is left and close the file."""
        self._over.set()
        self._hurry.set()
        self._thread.join()
        os.close(self._file)

    def _run(self) -> None:
        run_first()
        rounds_n = 0
        while True:
            hurries = self._hurry.wait(_EVERY_S)
            if self._over.is_set():
                break
            self._hurry.clear()
            rounds_n += 1
            self._empty(sync=hurries or rounds_n % _SYNC_EVERY_N == 0)
        self._empty(sync=True)

    def _empty(self, *, sync: bool) -> None:
        batch = b"".join(self._pending.popleft() for _ in range(len(self._pending)))
        self._written_n += len(batch)
        if self.error is not None:
            self.lost_n += len(batch)
            return
        rest = memoryview(batch)
        try:
            while rest:
                rest = rest[os.write(self._file, rest) :]
            if sync:
                os.fsync(self._file)
        except OSError as error:
            self.error = error
            self.lost_n += len(rest)
