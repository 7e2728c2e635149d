"""The files that grow while a flight goes on: its packets and its journal."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType

from mavspiral.flight.journal import AT_ONCE, whole_n
from mavspiral.flight.spool import Spool

__all__ = ["Recording"]


class Recording:
    """NAME.tlog and NAME.journal in `folder`, each appended to; nothing at all without a folder.

    Raises:
        InputError: a file cannot be opened for writing.
    """

    def __init__(self, folder: Path | None, name: str) -> None:
        self.files: dict[str, str] = {}
        self._spools: dict[str, Spool] = {}
        self._said: set[str] = set()
        if folder is None:
            return
        tlog, journal = folder / f"{name}.tlog", folder / f"{name}.journal"
        self._spools = {"tlog": Spool(tlog), "journal": Spool(journal, keep_n=whole_n(journal))}
        self.files = {"tlog": str(tlog), "journal": str(journal)}

    def packets(self, data: bytes) -> None:
        """Append to the .tlog."""
        if self._spools:
            self._spools["tlog"].write(data)

    def journal(self, data: bytes) -> None:
        """Append a record to the journal."""
        if self._spools:
            self._spools["journal"].write(data)
            if data[:1] in AT_ONCE:
                self._spools["journal"].hurry()

    def news(self) -> tuple[str, ...]:
        """Which files have begun to fail since the last time, in words: while it flies, there is time to take over."""
        failed = [kind for kind, spool in self._spools.items() if spool.lost_n and kind not in self._said]
        self._said.update(failed)
        return tuple(
            f"{self.files[kind]} is not written any more ({self._why(kind)}); the flight goes on without it"
            for kind in failed
        )

    def _why(self, kind: str) -> str:
        return str(self._spools[kind].error or "the disk is too slow")

    @property
    def troubles(self) -> tuple[str, ...]:
        """What could not be written, in words."""
        return tuple(
            f"{self.files[kind]}: {spool.lost_n} bytes could not be written ({self._why(kind)})"
            for kind, spool in self._spools.items()
            if spool.lost_n
        )

    def __enter__(self) -> Recording:
        """Itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Writes what is left and closes the files."""
        for spool in self._spools.values():
            spool.close()
