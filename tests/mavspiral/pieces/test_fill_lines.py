"""Lines through a pose: as far as they show more, and straight up where there is no room to either side."""

import numpy as np
import pytest

from mavspiral.pieces.fill_lines import lines_through
from mavspiral.pieces.gap import Pose, worth_flying
from mavspiral.survey.seeable import Room
from mavspiral.survey.solids import Solids

HEIGHTS_M = np.zeros((20, 20))
HEIGHTS_M[:, 5] = HEIGHTS_M[:, 14] = 30.0  # two walls, 8 m apart
SOLIDS = Solids.of(HEIGHTS_M, 1.0, [-10.0, -10.0])
NORTHWARD = Pose(
    np.array([0.0, 0.0, 5.0]), 0.5 * np.pi, 0.0, np.array([0.0, 9.0, 5.0]), np.array([0.0, -1.0, 0.0])
)


class OneShot:
    """A gap that any shot shows whole."""

    def shows(self, places, yaw, pitch):
        return np.ones((len(places), 3), dtype=bool)


@pytest.mark.parametrize(("clearance_m", "way"), [(2.0, [1.0, 0.0, 0.0]), (3.9, [0.0, 0.0, 1.0])])
def test_one_shot_is_taken_beside_the_wall_or_on_the_way_up(clearance_m, way):
    lines = lines_through(
        NORTHWARD, OneShot(), solids=SOLIDS, room=Room(clearance_m, 1.0, 60.0), spacing_m=3.0
    )
    assert lines
    for line in lines:
        assert line.shows.all()
        assert np.abs(line.path(1.0) - line.path(0.0)) == pytest.approx(way, abs=1e-12)


def test_there_is_no_line_where_there_is_no_room_at_all():
    assert not lines_through(NORTHWARD, OneShot(), solids=SOLIDS, room=Room(3.9, 1.0, 5.5), spacing_m=3.0)


def test_a_line_ends_with_the_last_shot_that_shows_more_but_bridges_a_short_gap():
    shows = np.zeros((9, 4), dtype=bool)
    shows[4, 0] = shows[5, 0] = shows[7, 1] = shows[3, 2] = shows[0, 3] = True
    assert worth_flying(shows, 4) == (0, 7)
    shows[0, 3] = False
    assert worth_flying(shows, 4) == (3, 7)
