"""PX4: home set by hand, and a flight that is ended by order."""

import math

import pytest


def asked(client, pick, number, *params):
    client.command(number, *params)
    (ack,) = pick(client.live(0.1), "COMMAND_ACK")
    return ack.result


def north_m(client):
    return float(client.simulator.truth.position_ned_m[0])


@pytest.fixture
def aloft(new_client):
    return new_client().airborne()


def test_px4_returns_to_a_home_that_was_set_by_hand(aloft, pick):
    before = aloft.flight.home.point
    there_deg = before.lat_deg + math.degrees(40.0 / 6.357e6)
    assert asked(aloft, pick, 179, 0, 0, 0, 0, there_deg, before.lon_deg, before.alt_amsl_m) == 0
    aloft.live(2.5)
    told = pick([m for _, _, m in aloft.heard], "HOME_POSITION")[-1]
    assert told.latitude * 1e-7 == pytest.approx(there_deg, abs=1e-6)
    home = aloft.flight.home
    aloft.command(20)
    aloft.until(lambda: not aloft.flight.armed, 120.0)
    assert north_m(aloft) == pytest.approx(40.0, abs=1.5)
    aloft.command(400, 1.0)
    aloft.live(0.5)
    assert aloft.flight.armed and aloft.flight.home is home


def test_px4_takes_the_place_where_it_is_for_home(aloft, pick):
    assert asked(aloft, pick, 179, 1) == 0
    here = aloft.simulator.report.place
    assert aloft.flight.home.point.alt_amsl_m == pytest.approx(here[2], abs=0.3)


@pytest.mark.parametrize(
    "place", [(91.0, 0.0, 0.0), (math.nan, 0.0, 0.0), (0.0, 181.0, 0.0), (0.0, 0.0, math.inf)]
)
def test_px4_denies_a_home_that_is_no_place(aloft, pick, place):
    before = aloft.flight.home
    assert asked(aloft, pick, 179, 0, 0, 0, 0, *place) == 2
    assert aloft.flight.home is before


def test_a_terminated_flight_falls(aloft, pick):
    assert asked(aloft, pick, 185, 1) == 0
    aloft.live(0.5)
    assert not aloft.flight.armed
    aloft.live(3.0)
    assert float(aloft.simulator.truth.position_ned_m[2]) > -1.0
