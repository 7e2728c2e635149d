"""Numbers on the card: what the camera told decides, and what nobody told is not guessed."""

import pytest

from mavspiral.flight.shutter import Picture
from mavspiral.logbook.card import card_numbers


def flight(*indices):
    return tuple(Picture(row, 10.0 + row, index) for row, index in enumerate(indices))


@pytest.mark.parametrize(
    ("told", "numbers"),
    [
        ((0, 1, 2), (0, 1, 2)),  # shots that gave no picture are no rows, and shift nothing
        ((7, 8, 10), (0, 1, 3)),  # one lies between that we know nothing of
        ((0, -1, 2), (0, 1, 2)),
        ((0, -1, 3), (0, -1, 3)),  # one of two: nobody knows which
        ((0, -1, 1), (0, -1, 1)),  # there is none between: no such picture is on the card
        ((-1, 4, 5), (0, 1, 2)),
        ((-1, 0, 1), (-1, 0, 1)),
        ((3, 4, -1), (0, 1, 2)),
        ((-1, -1), (0, 1)),
        ((), ()),
    ],
)
def test_a_flights_pictures_are_numbered_as_the_camera_did(told, numbers):
    assert card_numbers([flight(*told)]) == (numbers,)


def test_pictures_that_were_told_late_stand_where_they_were_taken():
    early, late = Picture(0, 5.0, 0), Picture(1, 6.0, 1)
    assert card_numbers([(late, early)]) == ((0, 1),)


def test_the_next_flight_goes_on_where_the_last_one_ended_though_the_camera_counts_anew():
    assert card_numbers([flight(0, 1, 3), (), flight(0, 1)]) == ((0, 1, 3), (), (4, 5))
