"""Uploads in lockstep with the bundled vehicle: whole, with loss both ways, refused, and compared."""

from __future__ import annotations

import pytest
from lossy_air import Air

from mavspiral.errors import LimitError, LinkError
from mavspiral.flight.link import Link
from mavspiral.flight.messages import Heartbeat
from mavspiral.flight.mission_differences import differences
from mavspiral.flight.mission_messages import MissionItem, MissionKind
from mavspiral.flight.mission_protocol import MissionTransfer
from sitl.airframe import load_airframe
from sitl.params import Params
from sitl.signals import GeoPoint
from sitl.simulator import Simulator, SimulatorConfig
from sitl.vehicle import VehicleConfig

STEP_US = 20_000
NAN = float("nan")


def waypoints(count):
    places = ((474_000_000 + 50 * seq, 85_500_000 + 31 * seq, 20.0 + 0.013 * seq) for seq in range(count))
    return [
        MissionItem(
            seq, 16, 3, (0.0, 1.37, 0.0, NAN if seq % 3 else 271.83), *place, True, MissionKind.MISSION
        )
        for seq, place in enumerate(places)
    ]


def vehicle():
    airframe = load_airframe("x500")
    home = GeoPoint(47.4, 8.55, 500.0)
    return Simulator(SimulatorConfig(vehicle=VehicleConfig(airframe, Params(airframe.params), home)))


def transferred(kind, items, loss=0.0, limit_s=300.0):
    """The transfer, done, and how long it took in simulated seconds."""
    simulator, link, air = vehicle(), Link(), Air(loss)
    now_us, to_vehicle, transfer, begin_us = 0, b"", None, 0
    while now_us < limit_s * 1e6:
        messages = link.receive(air.carry(now_us, simulator.step(now_us, to_vehicle).send))
        if link.vehicle is None:
            for beat in messages:
                if isinstance(beat, Heartbeat):
                    link.vehicle, begin_us = (beat.system_id, beat.component_id), now_us
                    transfer = MissionTransfer(link, kind, items)
        to_vehicle = b""
        if transfer is not None:
            to_vehicle = air.carry(now_us, transfer.step(now_us, messages))
            if transfer.done:
                assert loss == 0.0 or air.lost_n > 0
                return transfer, (now_us - begin_us) / 1e6, simulator
        now_us += STEP_US
    raise AssertionError(f"not done after {limit_s} s")


def test_what_was_sent_comes_back():
    items = waypoints(40)
    transfer, took_s, _ = transferred(MissionKind.MISSION, items)
    assert differences(items, transfer.back) == ()
    assert took_s < 5.0
    assert transfer.sent_n == 40 + 1 + 1 + 40  # an offer, the items, a list request, a request for each


def test_500_items_with_30_percent_loss_each_way_come_back_equal():
    items = waypoints(500)
    transfer, took_s, simulator = transferred(MissionKind.MISSION, items, loss=0.3, limit_s=900.0)
    assert differences(items, transfer.back) == ()
    assert len(simulator.report.flight.plans.mission) == 500
    print(f"500 items up and down with 30 % loss: {took_s:.0f} s, {transfer.sent_n} frames")


@pytest.mark.parametrize("kind", [MissionKind.FENCE, MissionKind.RALLY])
def test_fence_and_rally_points(kind):
    command, frame = (5001, 0) if kind is MissionKind.FENCE else (5100, 3)
    items = [
        MissionItem(i, command, frame, (4.0 * (command == 5001), 0.0, 0.0, 0.0), x, y, 0.0, True, kind)
        for i, (x, y) in enumerate(((1, 1), (1, 900), (900, 900), (900, 1)))
    ]
    transfer, _, _ = transferred(kind, items)
    assert differences(items, transfer.back) == ()


def test_no_items_clear_the_list():
    transfer, _, simulator = transferred(MissionKind.MISSION, [])
    assert transfer.back == ()
    assert simulator.report.flight.plans.mission == ()


def test_a_refused_item_is_named():
    items = waypoints(3)
    items[1] = items[1]._replace(command=82)
    with pytest.raises(
        LimitError, match=r"refuses the mission at item 2: command 82 in frame 3 \(UNSUPPORTED\)"
    ):
        transferred(MissionKind.MISSION, items)


def test_a_vehicle_that_falls_silent_is_given_up():
    link = Link()
    link.vehicle = (1, 1)
    transfer = MissionTransfer(link, MissionKind.MISSION, waypoints(2))
    with pytest.raises(LinkError, match="nothing moved for 30 s"):
        for now_us in range(0, 40_000_000, 100_000):
            transfer.step(now_us, [])


def test_differences_are_told_and_spellings_are_not():
    (item,) = waypoints(1)
    assert differences([item], [item._replace(frame=6)]) == ()
    assert differences([item], [item._replace(params=(0.0, 1.37, 0.0, -88.17))]) == ()
    assert differences([item], []) == ("1 items were sent, 0 came back",)
    (told,) = differences([item], [item._replace(x=item.x + 1, z=item.z + 1, params=(0.0, 1.37, 0.0, 90.0))])
    assert told == (
        "item 1: x 474000000 came back as 474000001, param4 271.83 came back as 90, param7 20 came back as 21"
    )


def test_the_frame_of_an_item_without_a_place_says_nothing_but_that_of_a_place_does():
    speed = MissionItem(0, 178, 2, (1.0, 3.0, -1.0, 0.0), 0, 0, 0.0, True, MissionKind.MISSION)
    place = waypoints(1)[0]
    assert differences([speed], [speed._replace(frame=0)]) == ()
    assert "frame 3 came back as 0" in differences([place], [place._replace(frame=0)])[0]
