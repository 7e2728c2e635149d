"""What a judge of plans has found: errors and warnings, each with its place, and never more than one can read."""

from __future__ import annotations

from collections import Counter

__all__ = ["Findings"]

LISTED_MAX = 50


class Findings:
    """Collects sentences. The same sentence at many places is listed once, with the first places and their number."""

    def __init__(self) -> None:
        self._errors: dict[str, list[str]] = {}
        self._warnings: dict[str, list[str]] = {}
        self._counts: Counter[tuple[bool, str]] = Counter()

    def error(self, place: str, text: str) -> None:
        """What keeps the plan from being loaded, taken or flown."""
        self._note(True, self._errors, place, text)

    def warning(self, place: str, text: str) -> None:
        """What is taken, but perhaps not as it was meant."""
        self._note(False, self._warnings, place, text)

    @property
    def errors(self) -> tuple[str, ...]:
        """One line each."""
        return self._lines(True, self._errors)

    @property
    def warnings(self) -> tuple[str, ...]:
        """One line each."""
        return self._lines(False, self._warnings)

    def _note(self, grave: bool, lines: dict[str, list[str]], place: str, text: str) -> None:
        if text not in lines and len(lines) >= LISTED_MAX:
            text = "and more of other kinds"
        places = lines.setdefault(text, [])
        self._counts[grave, text] += 1
        if len(places) < 3:
            places.append(place)

    def _lines(self, grave: bool, lines: dict[str, list[str]]) -> tuple[str, ...]:
        told = []
        for text, places in lines.items():
            beyond = self._counts[grave, text] - len(places)
            told.append(f"{', '.join(places)}{f' and {beyond} more' if beyond else ''}: {text}")
        return tuple(told)
