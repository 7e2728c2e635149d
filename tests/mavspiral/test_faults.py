"""Wherever a flight fails, it does not hit the building: what once came too near, by truth."""

import pytest

from mavspiral.closedloop import simulate

KEPT_M = 3.0


@pytest.mark.parametrize(
    ("autopilot", "fault", "reason"),
    [
        # Over the podium's edge, beside a tower: it leaves the roof within the 5 s for which PX4 still knows where it is.
        ("px4", "gps_loss@245s", "AUTO.LAND"),
        ("ardupilot", "gps_loss@280s", "its GPS is silent"),
        # A position that wanders on: the way home is shifted by each jump, and comes to its end.
        ("ardupilot", "multipath=2m@280s", "landed, disarmed (its position jumped"),
        ("ardupilot", "link_loss@280s", "link lost"),
        # Thrust that no longer carries it, as the pack's voltage falls: away from the tower and down.
        ("px4", "motor=2:0.66@150s", "its thrust does not carry it; away from the wall and landing it there"),
    ],
)
def test_it_keeps_its_clearance_until_it_is_down(planned, autopilot, fault, reason):
    flight = simulate(planned("podium"), faults=(fault,), autopilot=autopilot, set_failsafes=True)
    assert reason in flight.outcome.reason
    assert "still armed" not in flight.log.events[-1].text
    assert flight.clearance_min_m >= KEPT_M


def test_a_receiver_that_repeats_itself_leads_it_astray_only_where_nothing_stands(planned):
    """PX4 refuses such fixes for 7 s: for so long it knows where it is, and leaves the wall. Then it lands anywhere, or not."""
    flight = simulate(planned("kiosk"), faults=("sensor_stuck=gps@74s",), set_failsafes=True)
    assert any("which leads it astray; away from the wall" in event.text for event in flight.log.events)
    assert flight.clearance_min_m >= KEPT_M
