"""The mission protocol as PX4 v1.17 was seen to speak it, and as its mission manager is written."""

import itertools
import math

import pytest

HOME = (19.435235, -99.146145)
WAYPOINT = (16, (0, 0, 0, math.nan, *HOME, 10.0), 3)
TAKEOFF = (22, (0, 0, 0, math.nan, *HOME, 10.0), 3)
RETURN = (20, (0.0,) * 7, 2)
MISSION, FENCE, RALLY = 0, 1, 2


def waypoints(n):
    return [
        (16, (0.0, 1.0, 0.0, 10.0 * k, HOME[0] + 1e-4 * k, HOME[1] - 1e-4 * k, 5.0 + k), 3) for k in range(n)
    ]


def requests(client, pick):
    return [
        (at_us, message.seq)
        for at_us, _, message in client.heard
        if type(message).__name__ == "MISSION_REQUEST_INT"
    ]


def test_twenty_items_are_asked_for_in_order_and_acknowledged_at_once(client, pick):
    assert client.upload(waypoints(20)) == 0
    assert [seq for _, seq in requests(client, pick)] == list(range(20))
    assert len(client.simulator.report.flight.plans.mission) == 20


def test_items_come_back_as_they_were_with_px4s_frames_and_headings(client):
    items = [TAKEOFF, (178, (1, 4.5, -1, 0, 0, 0, 0), 2), *waypoints(3), RETURN]
    items[-2] = (16, (2.0, 1.5, 7.0, -90.0, *HOME, 12.25), 0)
    assert client.upload(items) == 0
    back = client.download()
    assert [item.command for item in back] == [22, 178, 16, 16, 16, 20]
    assert [item.frame for item in back] == [6, 2, 6, 6, 5, 2]
    assert back[1][:4] == (1.0, 4.5, -1.0, 0.0)
    assert (back[4].x, back[4].y, back[4].z) == (round(HOME[0] * 1e7), round(HOME[1] * 1e7), 12.25)
    # PX4 keeps no pass radius, and headings from 0 to 360 degrees.
    assert back[4][:4] == (2.0, 1.5, 0.0, 270.0)
    assert math.isnan(back[0].param4)


def test_a_request_of_the_old_kind_is_answered_in_floats(client, pick):
    client.upload([WAYPOINT])
    client.say("MISSION_REQUEST_LIST", target_system=1, target_component=1, mission_type=0)
    client.live(0.02)
    client.say("MISSION_REQUEST", seq=0, target_system=1, target_component=1, mission_type=0)
    (item,) = pick(client.live(0.02), "MISSION_ITEM")
    assert (item.frame, item.x) == (3, pytest.approx(HOME[0], abs=1e-5))


def test_an_unanswered_request_is_repeated_and_given_up_without_an_acknowledgement(client, pick):
    client.live(0.1)
    client.count(3)
    heard = client.live(8.0)
    times = [at_us for at_us, _ in requests(client, pick)]
    gaps = [b - a for a, b in itertools.pairwise(times)]
    assert set(gaps) == {260_000}
    assert times[-1] - times[0] == pytest.approx(5_070_000, abs=260_000)
    assert pick(heard, "MISSION_ACK") == []
    assert client.upload(waypoints(2)) == 0  # and then it takes another


def test_a_wrong_number_is_ignored(client, pick):
    client.count(2)
    client.live(0.02)
    for seq in (1, 7, 0):
        client.item(seq, *WAYPOINT)
        heard = client.live(0.05)
        assert pick(heard, "MISSION_ACK") == []
        assert [r.seq for r in pick(heard, "MISSION_REQUEST_INT")] == ([1] if seq == 0 else [])


def test_the_last_item_again_is_acknowledged_again(client, pick):
    client.upload([WAYPOINT])
    client.item(0, *WAYPOINT)
    assert [ack.type for ack in pick(client.live(0.05), "MISSION_ACK")] == [0]
    client.item(5, *WAYPOINT)
    assert [ack.type for ack in pick(client.live(0.05), "MISSION_ACK")] == [1]


@pytest.mark.parametrize(
    ("item", "result"),
    [
        ((82, (0, 0, 0, 0, *HOME, 10.0), 3), 3),  # NAV_SPLINE_WAYPOINT
        ((115, (90, 0, 1, 0, 0, 0, 0), 2), 3),  # CONDITION_YAW
        ((531, (0,) * 7, 2), 3),  # SET_CAMERA_ZOOM
        ((178, (1, 4, -1, 0, 0, 0, 0), 3), 3),  # a DO_ item in a global frame
        ((206, (3, 0, 1, 0, 0, 0, 0), 3), 3),
        ((16, (0, 0, 0, 0, *HOME, 10.0), 10), 2),  # terrain
        ((16, (0, 0, 0, 0, 1.0, 1.0, -10.0), 1), 2),  # local
        ((201, (7, 0, 0, 0, *HOME, 0.0), 3), 6),  # DO_SET_ROI of no known kind
        ((5001, (4, 0, 0, 0, *HOME, 0.0), 3), 1),  # a fence's corner in a mission
    ],
)
def test_what_px4_refuses_is_refused_and_nothing_is_stored(client, item, result):
    assert client.upload([WAYPOINT]) == 0
    before = client.simulator.report.flight.plans
    assert client.upload([WAYPOINT, item, RETURN]) == result
    assert client.simulator.report.flight.plans == before
    assert client.upload([TAKEOFF, RETURN]) == 0


@pytest.mark.parametrize("frame", [0, 3, 5, 6])
def test_the_frames_that_px4_takes(client, frame):
    assert client.upload([(16, (0, 0, 0, 0, *HOME, 10.0), frame)]) == 0


@pytest.mark.parametrize(("kind", "most", "command"), [(FENCE, 64, 5001), (RALLY, 32, 5100)])
def test_fence_and_rally_points_are_kept_up_to_px4s_limits(client, kind, most, command):
    items = [(command, (float(most), 0, 0, 0, HOME[0], HOME[1] + 1e-5 * k, 20.0), 3) for k in range(most)]
    assert client.upload([*items, items[0]], kind) == 4
    assert client.upload(items, kind) == 0
    back = client.download(kind)
    assert [(i.command, i.y) for i in back] == [(i[0], round(i[1][5] * 1e7)) for i in items]
    assert {i.mission_type for i in back} == {kind}
    assert client.download(MISSION) == []


def test_a_polygon_of_two_corners_is_an_error(client):
    assert client.upload([(5001, (2.0, 0, 0, 0, *HOME, 0.0), 3)] * 2, FENCE) == 1


def test_too_many_items_find_no_space(client, pick):
    client.count(10_001)
    assert [ack.type for ack in pick(client.live(0.05), "MISSION_ACK")] == [4]


@pytest.mark.parametrize(("kind", "left"), [(0, (0, 1)), (1, (2, 0)), (255, (0, 0))])
def test_clearing_is_acknowledged(client, pick, kind, left):
    client.upload(waypoints(2))
    client.upload([(5003, (50.0, 0, 0, 0, *HOME, 0.0), 3)], FENCE)
    client.say("MISSION_CLEAR_ALL", target_system=1, target_component=1, mission_type=kind)
    assert [(a.type, a.mission_type) for a in pick(client.live(0.05), "MISSION_ACK")] == [(0, kind)]
    plans = client.simulator.report.flight.plans
    assert (len(plans.mission), len(plans.fence)) == left


def test_a_count_of_nothing_clears(client, pick):
    client.upload(waypoints(2))
    client.count(0)
    assert [ack.type for ack in pick(client.live(0.05), "MISSION_ACK")] == [0]
    assert client.simulator.report.flight.plans.mission == ()


def test_one_link_at_a_time_may_upload_and_both_may_read(new_client, pick):
    client = new_client(links=2)
    client.count(2, link=0)
    client.live(0.02)
    assert client.upload(waypoints(1), link=1) == 1
    for seq in (0, 1):
        client.item(seq, *WAYPOINT, current=int(seq == 1))
        client.live(0.02)
    assert len(client.download(link=1)) == 2
    assert [item.current for item in client.download(link=0)] == [0, 1]
    assert client.upload(waypoints(3), link=1) == 0


def test_a_cancelled_upload_is_over(client, pick):
    client.count(2)
    client.live(0.05)
    client.say("MISSION_ACK", target_system=1, target_component=1, type=15, mission_type=0)
    assert client.live(1.0) is not None
    assert pick(client.live(1.0), "MISSION_REQUEST_INT") == []


def test_an_unexpected_request_ends_the_download_with_an_error(client, pick):
    client.upload(waypoints(4))
    client.say("MISSION_REQUEST_LIST", target_system=1, target_component=1, mission_type=0)
    client.live(0.02)
    client.say("MISSION_REQUEST_INT", seq=3, target_system=1, target_component=1, mission_type=0)
    assert [ack.type for ack in pick(client.live(0.02), "MISSION_ACK")] == [1]


def test_mission_current_comes_once_a_second_and_on_change(client, pick):
    client.live(2.0)
    assert [m.seq for m in pick(client.live(5.0), "MISSION_CURRENT")] == [0] * 5
    assert pick(client.live(1.0), "MISSION_CURRENT")[0].mission_state == 1
    client.upload(waypoints(4))
    client.say("MISSION_SET_CURRENT", seq=2, target_system=1, target_component=1)
    told = pick(client.live(0.05), "MISSION_CURRENT")
    assert (told[-1].seq, told[-1].total, told[-1].mission_state) == (2, 4, 2)
    client.say("MISSION_SET_CURRENT", seq=9, target_system=1, target_component=1)
    client.live(1.0)
    assert client.simulator.report.flight.run.seq == 2


def test_half_an_upload_survives_a_snapshot(new_client, pick):
    client = new_client()
    client.count(3)
    client.live(0.05)
    client.item(0, *WAYPOINT)
    client.live(0.05)
    kept = client.simulator.snapshot()
    twin = new_client()
    twin.live(0.1)
    twin.now_us = client.now_us
    twin.simulator.restore(kept)
    for seq in (1, 2):
        twin.item(seq, *WAYPOINT)
    assert [ack.type for ack in pick(twin.live(0.05), "MISSION_ACK")] == [0]
    assert len(twin.simulator.report.flight.plans.mission) == 3
