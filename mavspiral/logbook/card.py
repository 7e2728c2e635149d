"""Which picture on the camera's card is which that was told."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from operator import attrgetter

from mavspiral.flight.shutter import Picture

__all__ = ["card_numbers"]


def card_numbers(flights: Sequence[Sequence[Picture]]) -> tuple[tuple[int, ...], ...]:
    """For each flight's pictures, in the order taken, how many lie before each on the card; -1 where nobody can say.

    The first flight's first picture has 0, and each flight counts on from the last one's end. A number that the camera
    told holds, also past pictures that we know nothing of. Pictures between two such numbers are counted where they
    are as many as the numbers between.
    """
    begin, found = 0, list[tuple[int, ...]]()
    for pictures in flights:
        told = _indices([picture.image_index for picture in sorted(pictures, key=attrgetter("vehicle_s"))])
        first = min((index for index in told if index >= 0), default=0)
        found.append(tuple(begin + index - first if index >= 0 else -1 for index in told))
        begin = max(begin, *(number + 1 for number in found[-1])) if found[-1] else begin
    return tuple(found)


def _indices(told: list[int]) -> list[int]:
    """The camera's numbers with those between filled in where only one way is possible; from 0 if it told none."""
    known = [row for row, index in enumerate(told) if index >= 0]
    if not known:
        return list(range(len(told)))
    filled = list(told)
    first, last = known[0], known[-1]
    if told[first] >= first:
        filled[:first] = range(told[first] - first, told[first])
    for before, after in pairwise(known):
        if told[after] - told[before] == after - before:
            filled[before:after] = range(told[before], told[after])
    filled[last:] = range(told[last], told[last] + len(told) - last)
    return filled
