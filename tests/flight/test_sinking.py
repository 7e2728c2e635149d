"""A vehicle whose thrust does not carry it is not led home over the building."""

import pytest
from fake_flight import fly, leaving_first, make_session, way_home
from test_doubts import fly_on, until_path

from mavspiral.flight.outcome import State
from mavspiral.flight.sinking import Sinking


def told_after(below_m, *, climb_mps=0.0, seconds=10.0):
    sinking = Sinking()
    for k in range(round(50 * seconds)):
        if sinking.look(20_000 * k, below_m(k / 50), climb_mps) is not None:
            return k / 50
    return None


def test_it_is_told_after_two_seconds_below_the_path():
    assert told_after(lambda t_s: 1.2 * (t_s > 3.0)) == pytest.approx(5.0, abs=0.1)
    assert told_after(lambda t_s: 0.9) is None
    assert told_after(lambda t_s: 1.2 * (t_s % 2.0 < 1.8)) is None, "what is flown back is no sinking"
    assert told_after(lambda t_s: -5.0) is None, "above the path"


def test_a_late_link_is_no_sinking_while_it_climbs():
    assert told_after(lambda t_s: 1.5, climb_mps=2.0) is None
    assert told_after(lambda t_s: 1.5, climb_mps=-1.5) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("ways", [leaving_first, way_home])
def test_who_sinks_goes_away_from_the_wall_and_comes_down_there(px4, ways):
    session = make_session(way_home=ways)
    fly(session, px4, until=until_path(session, 30))
    px4.wind_ned_mps = (0.0, 0.0, 1.6)  # it stays 1.6 m below what it is told, and is waited for
    begin_us, here = px4.track[-1][0], tuple(px4.position)
    ends = {leaving_first: State.LEAVE, way_home: State.LAND}
    fly_on(session, px4, until=lambda: session.state is ends[ways])
    assert 2.0e6 < px4.track[-1][0] - begin_us < 6.0e6
    px4.wind_ned_mps = (0.0, 0.0, 3.0)  # sinking on, it is waited for no longer
    fly_on(session, px4, until=lambda: session.state is State.LAND)
    moved_m = px4.position[1] - here[1]
    if ways is leaving_first:
        assert moved_m > 4.0
    fly_on(session, px4)
    assert "it sinks" in session.outcome.reason and "its thrust does not carry it" in session.outcome.reason
    assert State.RETURN.value not in [event.text for event in session.events] and not px4.armed
