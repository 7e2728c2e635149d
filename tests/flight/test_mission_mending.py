"""Uploads to the bundled ArduCopter through loss and delay: what broke is taken up where it broke, until all reads back equal."""

from __future__ import annotations

import pytest
from lossy_air import Air, frames_of

import sitl.link.ardupilot_missions as dialect
from mavspiral.errors import LimitError, LinkError
from mavspiral.flight.link import Link
from mavspiral.flight.messages import Heartbeat
from mavspiral.flight.mission_mending import MissionMending
from mavspiral.flight.mission_messages import (
    MissionAck,
    MissionCount,
    MissionItem,
    MissionKind,
    MissionRequest,
)
from mavspiral.flight.mission_protocol import MissionTransfer
from mavspiral.flight.plan_upload import PlanUpload
from sitl.airframe import load_airframe
from sitl.link.messages import message_type
from sitl.params import Params
from sitl.plans import PlanItem
from sitl.signals import GeoPoint
from sitl.simulator import Simulator, SimulatorConfig
from sitl.vehicle import VehicleConfig

STEP_US = 20_000
HOME = GeoPoint(47.4, 8.55, 500.0)


def waypoints(count):
    """Home and a line of waypoints."""
    line = [
        MissionItem(
            seq, 16, 3, (0.0,) * 4, 474_000_000 + 7 * seq, 85_500_000, 20.0 + seq, True, MissionKind.MISSION
        )
        for seq in range(count)
    ]
    return [line[0]._replace(frame=0), *line[1:]]


def rally(count):
    places = ((474_000_000 + 90 * seq, 85_500_000) for seq in range(count))
    return [
        MissionItem(seq, 5100, 3, (0.0,) * 4, x, y, 30.0, True, MissionKind.RALLY)
        for seq, (x, y) in enumerate(places)
    ]


def fence(count):
    return [
        MissionItem(seq, 5001, 0, (count, 0.0, 0.0, 0.0), seq, seq * seq, 0.0, True, MissionKind.FENCE)
        for seq in range(count)
    ]


class Flight:
    """A copter, an upload to it, and the air between them."""

    def __init__(self, lists, seed, *, loss=0.3, delay_us=200_000, kept=()):
        airframe = load_airframe("x500")
        self.copter = Simulator(
            SimulatorConfig(VehicleConfig(airframe, Params(airframe.params), HOME), "ardupilot")
        )
        craft = self.copter._craft.commander._state
        craft.plans = craft.plans.with_items(0, tuple(kept))
        self.up, self.down = Air(loss, seed, delay_us), Air(loss, seed + 1000, delay_us)
        self.link, self.lists, self.upload = Link(), lists, None
        self.told = []
        self.now_us = self.begun_us = 0

    def until_done(self, limit_s=600.0):
        """How long it took, in simulated seconds."""
        to_vehicle = b""
        while self.now_us < limit_s * 1e6:
            heard = self.copter.step(self.now_us, self.up.carry(self.now_us, to_vehicle)).send
            messages = self.link.receive(self.down.carry(self.now_us, heard))
            to_vehicle = b""
            for beat in messages:
                if isinstance(beat, Heartbeat) and self.upload is None:
                    self.link.vehicle, self.begun_us = (beat.system_id, beat.component_id), self.now_us
                    self.upload = PlanUpload(self.link, self.lists, ardupilot=True)
            if self.upload is not None:
                to_vehicle = self.upload.step(self.now_us, messages)
                self.told.append(self.upload.progress)
                if self.upload.done:
                    return (self.now_us - self.begun_us) / 1e6
            self.now_us += STEP_US
        raise AssertionError(f"not done after {limit_s} s: {self.upload.progress}")


def uploaded(lists, seed, **ill):
    flight = Flight(lists, seed, **ill)
    flight.until_done()
    assert set(flight.upload.differences.values()) == {()}
    return flight


def stored(flight, kind):
    return [round(item.params[4] * 1e7) for item in flight.copter.report.flight.plans.of(kind)]


@pytest.fixture(params=["as seen", "as the source has it", "no partial list while it uploads"])
def habit(request, monkeypatch):
    """What ArduPilots may do otherwise: end an upload at a wrong number, wait on, or refuse a part while they upload."""
    item_int, part = message_type("MISSION_ITEM_INT"), message_type("MISSION_WRITE_PARTIAL_LIST")
    take_item, take_part = dialect._HANDLERS[item_int], dialect._HANDLERS[part]

    def patient(service, message, partner, helm):
        if service.taking and message.seq != service.next:
            return service._answer(13)
        return take_item(service, message, partner, helm)

    def busy(service, message, partner, helm):
        return service._answer(1) if service.taking else take_part(service, message, partner, helm)

    if request.param == "as the source has it":
        monkeypatch.setitem(dialect._HANDLERS, item_int, patient)
    if request.param == "no partial list while it uploads":
        monkeypatch.setitem(dialect._HANDLERS, part, busy)


@pytest.mark.parametrize("seed", [0, 1])
def test_with_30_percent_lost_each_way_and_200_ms_of_delay_it_reads_back_equal(habit, seed):
    items = waypoints(40)
    flight = uploaded({MissionKind.MISSION: items}, seed)
    assert stored(flight, 0) == [item.x for item in items]
    assert flight.up.lost_n > 30


def test_500_items_with_30_percent_lost_each_way_come_back_equal():
    items = waypoints(500)
    flight = uploaded({MissionKind.MISSION: items}, 7, delay_us=0)
    assert stored(flight, 0) == [item.x for item in items]


def test_a_good_link_needs_no_mending():
    items = waypoints(20)
    flight = Flight({MissionKind.MISSION: items}, 1, loss=0.0, delay_us=0)
    assert flight.until_done() < 5.0
    assert flight.upload.differences[MissionKind.MISSION] == ()


def test_after_ten_seconds_of_silence_it_goes_on_where_it_broke_and_sends_nothing_that_is_there_again():
    flight = Flight({MissionKind.MISSION: waypoints(60)}, 1, loss=0.0, delay_us=20_000)
    sent, carry = [], flight.up.carry

    def watched(now_us, data):
        sent.extend(int.from_bytes(frame[10:12], "little") for frame in frames_of(data) if frame[7] == 38)
        silent = flight.upload is not None and 2e6 < now_us - flight.begun_us < 12e6
        flight.up.loss = flight.down.loss = float(silent)
        return carry(now_us, data)

    flight.up.carry = watched
    flight.until_done()
    assert flight.upload.differences[MissionKind.MISSION] == ()
    assert 5 < min(sent) < 55
    assert sorted(set(sent)) == list(range(min(sent), 60))


def test_the_tail_of_an_older_and_longer_mission_does_not_stand_in_for_items_that_were_lost():
    tail = [PlanItem(16, 3, (0.0,) * 4 + (1.0, 1.0, 5.0))] * 60
    items = waypoints(40)
    for seed in (0, 1, 2):
        flight = uploaded({MissionKind.MISSION: items}, seed, kept=tail)
        assert stored(flight, 0) == [item.x for item in items]


@pytest.mark.parametrize("seed", [0, 1])
def test_a_fence_is_begun_anew_and_rally_points_are_mended(seed):
    lists = {MissionKind.FENCE: fence(20), MissionKind.RALLY: rally(12)}
    flight = uploaded(lists, seed)
    assert stored(flight, 1) == list(range(20))
    assert len(stored(flight, 2)) == 12


def test_a_lost_word_of_completion_is_not_taken_for_a_broken_upload():
    """The last item again is answered with an error: nobody waits for it. What is read back says that it is there."""
    link = Link()
    link.vehicle = (1, 1)
    transfer = MissionTransfer(link, MissionKind.FENCE, fence(2), ardupilot=True)
    transfer.step(0, [MissionRequest(0, 1)])
    transfer.step(10_000, [MissionRequest(1, 1)])
    transfer.step(400_000, [MissionAck(1, 1)])
    assert not transfer.proven
    transfer.step(410_000, [MissionCount(2, 1)])
    transfer.step(420_000, [fence(2)[0]])
    transfer.step(430_000, [fence(2)[1]])
    assert transfer.done


def test_a_refused_item_is_named_among_those_that_were_under_way():
    items = waypoints(30)
    items[20] = items[20]._replace(command=31010)
    with pytest.raises(LimitError, match=r"refuses the mission at (one of the )?items? \d\d.*UNSUPPORTED"):
        Flight({MissionKind.MISSION: items}, 2).until_done()


def test_a_vehicle_that_rejects_every_partial_list_is_given_up():
    link = Link()
    link.vehicle = (1, 1)
    transfer = MissionTransfer(link, MissionKind.MISSION, waypoints(9), ardupilot=True)
    transfer.step(0, [MissionRequest(0, 0)])
    transfer.step(10_000, [MissionRequest(1, 0)])
    transfer.step(3_100_000, [])
    with pytest.raises(LinkError, match="mending the mission: nothing moved for 30 s"):
        for now_us in range(3_200_000, 60_000_000, 100_000):
            transfer.step(now_us, [MissionRequest(0, 0), MissionAck(1, 0), MissionCount(1, 0)])


def test_what_is_stored_is_counted_by_requests_upwards_and_by_counts_both_ways():
    link = Link()
    link.vehicle = (1, 1)
    mending = MissionMending(link, MissionKind.MISSION, waypoints(9), 3)
    assert not mending.hear(MissionRequest(7, 0))  # before the tail is cut off
    assert mending.hear(MissionRequest(0, 0))
    assert mending.hear(MissionRequest(5, 0))
    assert not mending.hear(MissionRequest(4, 0))
    assert not mending.hear(MissionRequest(6, 2))
    assert mending.stored_n == 5
    assert mending.hear(MissionCount(4, 0))
    assert mending.on_the_way == range(4, 8)
    assert mending.hear(MissionCount(9, 0))
    assert mending.done


def test_progress_is_told_and_only_goes_up():
    flight = uploaded({MissionKind.MISSION: waypoints(30)}, 3)
    up = [line for line in flight.told if line.startswith("mission: uploading")]
    numbers = [int(line.split(", ")[1].split()[0]) for line in up]
    assert numbers == sorted(numbers)
    assert up[-1].endswith("of 30")
    assert (
        "mission: reading back, 30 of 30" in flight.told or "mission: reading back, 29 of 30" in flight.told
    )
