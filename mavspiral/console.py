"""What a pilot reads and answers while it flies. Neither a terminal that stands still nor a pilot who thinks keeps the flight waiting."""

from __future__ import annotations

import contextlib
import os
import queue
import sys
import threading
from types import TracebackType

from mavspiral.flight.flight_log import Event
from mavspiral.flight.priority import run_first
from mavspiral.flight.wishes import Wish

__all__ = ["Console"]

_STDIN = 0
_LINE_N = 4096
_LAST_WORDS_S = 2.0
_YES, _NO = ("y", "yes"), ("n", "no", "")
_WISHES = {
    "g": Wish.GO_ON,
    "r": Wish.GO_HOME,
    "l": Wish.LAND,
    "h": Wish.HAND_OVER,
}
_MENU = "g go on · r return home · l land here · h hand over to you [g/r/l/h], Ctrl-C returns home: "


class Console:
    """Prints what is told in a thread of its own, and hears answers in another; every method comes back at once.

    Args:
        quiet: print no events, as with --json; questions are asked all the same, on stderr.
        yes: every question has been answered with yes.
    """

    def __init__(self, *, quiet: bool = False, yes: bool = False) -> None:
        self._quiet, self._yes = quiet, yes
        self._asks = sys.stdin is not None and sys.stdin.isatty()
        self._told: queue.SimpleQueue[tuple[bool, str] | None] = queue.SimpleQueue()
        self._answers: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._asked = ""
        self._listens = False
        self._printer = threading.Thread(target=self._print, name="console", daemon=True)
        self._printer.start()

    def say(self, event: Event) -> None:
        """Print what happened in flight, and when."""
        if self._quiet:
            return
        word = "" if event.severity == "info" else f"{event.severity}: "
        begin = "\n" if self._asked else ""  # a prompt stands there
        self._told.put((False, f"{begin}{event.t_us / 1e6:8.1f} s  {word}{event.text}\n"))
        if self._asked:
            self._told.put((True, self._asked))

    def approve(self, question: str) -> bool | None:
        """The answer to `question`; None as long as there is none."""
        if self._yes:
            return True
        answer = self._answer(f"{question[:1].upper()}{question[1:]}? [y/N]: ")
        if answer is None:
            return None
        if answer in _YES:
            return True
        return False if answer in _NO else None

    def wish(self, held: bool) -> Wish | None:
        """What the pilot wants of a vehicle that is `held`; None as long as nothing was said. Home, where nobody can be asked."""
        if not held:
            if self._asked == _MENU:  # it was let go otherwise
                self._asked = ""
            return None
        if not self._asks:
            return Wish.GO_HOME
        answer = self._answer(_MENU)
        return None if answer is None else _WISHES.get(answer)

    def __enter__(self) -> Console:
        """Itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Waits until all is printed, but not for ever."""
        if self._asked:
            self._told.put((True, "\n"))
        self._told.put(None)
        self._printer.join(_LAST_WORDS_S)

    def _answer(self, prompt: str) -> str | None:
        if prompt != self._asked:
            self._asked = prompt
            self._listen()
            self._told.put((True, prompt))
        try:
            answer = self._answers.get_nowait()
        except queue.Empty:
            return None
        self._asked = ""
        return "" if answer is None else answer.strip().lower()

    def _listen(self) -> None:
        """From now on; what was typed before the question is no answer to it."""
        with contextlib.suppress(ImportError, OSError):
            import termios  # not on every system

            termios.tcflush(_STDIN, termios.TCIFLUSH)
        while not self._answers.empty():
            self._answers.get_nowait()
        if not self._listens:
            self._listens = True
            threading.Thread(target=self._hear, name="answers", daemon=True).start()

    def _hear(self) -> None:
        run_first()
        with contextlib.suppress(OSError):
            while line := os.read(_STDIN, _LINE_N):
                self._answers.put(line.decode(errors="replace"))
        self._answers.put(None)  # nobody is there any more

    def _print(self) -> None:
        run_first()
        with contextlib.suppress(OSError, ValueError):  # the terminal has gone: the flight goes on
            while (words := self._told.get()) is not None:
                asks, text = words
                print(text, end="", flush=True, file=sys.stderr if asks else sys.stdout)
