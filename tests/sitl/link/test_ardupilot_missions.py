"""ArduCopter's missions: its protocol, and AUTO by its rules."""

import math

import numpy as np
import pytest
from copter_client import AUTO, HOME, pick, texts, yaw_deg
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sitl.geo import geodetic_of_ned
from sitl.orders import Mode


def place(north_m, east_m, height_m):
    anchor = HOME.lat_deg, HOME.lon_deg, HOME.alt_amsl_m
    lat_deg, lon_deg, _ = geodetic_of_ned(anchor, (north_m, east_m, 0.0))
    return lat_deg, lon_deg, height_m


def waypoint(north_m, east_m, height_m=10.0, delay_s=0.0, yaw_deg=0.0, command=16, frame=3):
    return command, frame, (delay_s, 0, 0, yaw_deg, *place(north_m, east_m, height_m))


def do(command, *params):
    return command, 2, (*params, *(0.0,) * (7 - len(params)))


TAKEOFF = (22, 3, (0, 0, 0, 0, 0, 0, 10.0))
RETURN = do(20)
TWENTY = [TAKEOFF, *[waypoint(5.0 * n, 3.0) for n in range(17)], RETURN]


def request(copter, seq):
    copter.say(mavlink.MAVLink_mission_request_int_message(1, 1, seq, 0))
    return copter.live(0.02)


def test_it_asks_with_mission_request_and_takes_20_items(copter):
    copter.live(4.0)
    copter.say(mavlink.MAVLink_mission_count_message(1, 1, 20, 0))
    (asked,) = pick(copter.live(0.05), "MISSION_REQUEST")
    assert asked.seq == 0
    assert copter.upload(TWENTY) == 0
    assert len(copter.flight.plans.mission) == 20


def test_an_unanswered_item_is_asked_for_every_second_and_given_up_after_8_s(copter):
    copter.live(4.0)
    copter.say(mavlink.MAVLink_mission_count_message(1, 1, 3, 0))
    heard = copter.live(7.9)
    assert len(pick(heard, "MISSION_REQUEST")) == pytest.approx(8, abs=1)
    assert not pick(heard, "MISSION_ACK")
    heard = copter.live(0.3)
    assert [ack.type for ack in pick(heard, "MISSION_ACK")] == [15]
    assert "Mission upload timeout" in texts(heard)


def test_a_wrong_seq_is_answered_with_13_and_ends_the_upload(copter):
    copter.live(4.0)
    copter.say(mavlink.MAVLink_mission_count_message(1, 1, 3, 0))
    copter.live(0.05)
    copter.say(mavlink.MAVLink_mission_item_int_message(1, 1, 2, 3, 16, 0, 1, 0, 0, 0, 0, 0, 0, 5.0, 0))
    heard = copter.live(3.0)
    assert [ack.type for ack in pick(heard, "MISSION_ACK")] == [13]
    assert not pick(heard, "MISSION_REQUEST")


@pytest.mark.parametrize(
    ("item", "result"),
    [
        ((16, 3, (0, 0, 0, 0, 91.0, 10.0, 5.0)), 10),
        ((16, 3, (0, 0, 0, 0, 10.0, 181.0, 5.0)), 11),
        ((31010, 3, (0,) * 7), 3),
        ((115, 2, (math.nan, 0, 1, 0, 0, 0, 0)), 6),
        ((16, 1, (0, 0, 0, 0, 10.0, 10.0, 5.0)), 2),
    ],
    ids=["latitude", "longitude", "command", "nan", "frame"],
)
def test_what_is_wrong_with_an_item_is_said(copter, item, result):
    copter.live(4.0)
    assert copter.upload([item]) == result
    assert len(copter.flight.plans.mission) == 1  # home; what came before the refusal stays


def test_nan_as_a_waypoints_yaw_is_taken_and_forgotten(copter):
    copter.live(4.0)
    assert copter.upload([waypoint(5.0, 0.0, yaw_deg=math.nan)]) == 0
    assert copter.flight.plans.mission[1].params[3] == 0.0


def test_5000_items_do_not_fit_and_none_are_a_mission_too(copter):
    copter.live(4.0)
    for count, result in ((5000, 4), (0, 0)):
        copter.say(mavlink.MAVLink_mission_count_message(1, 1, count, 0))
        assert [ack.type for ack in pick(copter.live(0.05), "MISSION_ACK")] == [result]


def test_a_request_past_the_end_is_answered_with_1(copter):
    copter.live(4.0)
    copter.upload([TAKEOFF])
    assert [ack.type for ack in pick(request(copter, 2), "MISSION_ACK")] == [1]


def test_read_back_item_0_is_home_frame_6_is_3_and_a_waypoint_has_kept_its_delay_alone(copter):
    copter.live(42.0)
    item = (16, 6, (2.7, 3.0, 4.0, 90.0, *place(50.0, 20.0, 12.0)))
    assert copter.upload([item]) == 0
    (home,), (back,) = (pick(request(copter, seq), "MISSION_ITEM_INT") for seq in (0, 1))
    assert home.x == pytest.approx(copter.flight.home.point.lat_deg * 1e7, abs=2)
    assert (home.command, home.frame) == (16, 0)
    assert (back.frame, back.param1, back.param2, back.param3, back.param4) == (3, 2.0, 0.0, 0.0, 0.0)
    assert (back.x, back.z) == (round(item[2][4] * 1e7), 12.0)


def offer(copter, count, kind=0):
    copter.say(mavlink.MAVLink_mission_count_message(1, 1, count, kind))


def offer_part(copter, start, end, kind=0):
    copter.say(mavlink.MAVLink_mission_write_partial_list_message(1, 1, start, end, kind))


def give(copter, seq, kind=0, command=16, p1=0.0, z=5.0):
    item = mavlink.MAVLink_mission_item_int_message(
        1, 1, seq, 3, command, 0, 1, p1, 0, 0, 0, 10_000_000 + seq, 20_000_000, z, kind
    )
    copter.say(item)


def acks(messages):
    return [ack.type for ack in pick(messages, "MISSION_ACK")]


def broken_upload(copter, count=6, given_n=3, kind=0, command=16):
    """An upload of `count` items that ended by its timeout after `given_n`."""
    offer(copter, count, kind)
    copter.live(0.05)
    for seq in range(given_n):
        give(copter, seq, kind, command)
        copter.live(0.05)
    assert acks(copter.live(8.2)) == [15]


def test_an_upload_that_broke_leaves_what_had_come_of_a_mission_and_of_rally_points_but_not_of_a_fence(
    copter,
):
    copter.live(4.0)
    for kind, command, kept_n in ((0, 16, 3), (1, 5003, 0), (2, 5100, 3)):
        broken_upload(copter, kind=kind, command=command)
        copter.say(mavlink.MAVLink_mission_request_list_message(1, 1, kind))
        (count,) = pick(copter.live(0.05), "MISSION_COUNT")
        assert (count.count, count.mission_type) == (kept_n, kind)


def test_an_offer_cuts_a_longer_mission_to_its_length_and_leaves_a_shorter_one(copter):
    copter.live(4.0)
    copter.upload(TWENTY[:4])
    offer(copter, 3)
    copter.live(0.05)
    assert len(copter.flight.plans.mission) == 3
    offer(copter, 9)
    copter.live(0.05)
    assert len(copter.flight.plans.mission) == 3


def test_a_partial_list_replaces_items_and_appends_one_behind_the_last(copter):
    copter.live(4.0)
    broken_upload(copter)
    offer_part(copter, 1, 3)
    (asked,) = pick(copter.live(0.05), "MISSION_REQUEST")
    assert asked.seq == 1
    for seq in (1, 2, 3):
        give(copter, seq, z=70.0 + seq)
        heard = copter.live(0.05)
    assert acks(heard) == [0]
    assert [item.params[6] for item in copter.flight.plans.mission] == [5.0, 71.0, 72.0, 73.0]


def test_a_partial_list_and_its_item_in_one_go_are_taken_without_a_request_and_may_be_repeated(copter):
    copter.live(4.0)
    broken_upload(copter)
    for _ in range(2):
        offer_part(copter, 3, 3)
        give(copter, 3, z=9.0)
        heard = copter.live(0.05)
        assert acks(heard) == [0]
        assert not pick(heard, "MISSION_REQUEST")
        assert [item.params[6] for item in copter.flight.plans.mission] == [5.0, 5.0, 5.0, 9.0]


@pytest.mark.parametrize(("start", "end"), [(4, 4), (3, 4), (2, 1), (-1, 1)])
def test_a_partial_list_beyond_the_end_or_backwards_is_rejected(copter, start, end):
    copter.live(4.0)
    broken_upload(copter)
    offer_part(copter, start, end)
    heard = copter.live(0.05)
    assert acks(heard) == [1]
    assert "Flight plan update rejected" in texts(heard)


def test_a_partial_list_takes_the_place_of_an_upload_that_is_under_way(copter):
    copter.live(4.0)
    offer(copter, 6)
    copter.live(0.05)
    give(copter, 0)
    copter.live(0.05)
    offer_part(copter, 1, 1)
    assert [asked.seq for asked in pick(copter.live(0.05), "MISSION_REQUEST")] == [1]
    give(copter, 1)
    assert acks(copter.live(0.05)) == [0]
    assert len(copter.flight.plans.mission) == 2


def test_a_partial_list_of_a_fence_replaces_its_corners_and_cannot_lengthen_it(copter):
    copter.live(4.0)
    offer(copter, 2, 1)
    for seq in (0, 1):
        copter.live(0.05)
        give(copter, seq, 1, 5003, p1=50.0)
    copter.live(0.05)
    offer_part(copter, 1, 1, 1)
    give(copter, 1, 1, 5003, p1=60.0)
    assert acks(copter.live(0.05)) == [0]
    assert [item.params[0] for item in copter.flight.plans.fence] == [50.0, 60.0]
    offer_part(copter, 2, 2, 1)
    give(copter, 2, 1, 5003)
    assert acks(copter.live(0.05)) == [13]
    assert len(copter.flight.plans.fence) == 2


def test_nothing_of_a_list_is_read_back_while_it_is_being_written(copter):
    copter.live(4.0)
    copter.upload(TWENTY[:3])
    offer_part(copter, 1, 1)
    copter.say(mavlink.MAVLink_mission_request_list_message(1, 1, 0))
    assert acks(copter.live(0.05)) == [14]
    assert acks(request(copter, 1)) == [14]
    copter.say(mavlink.MAVLink_mission_request_list_message(1, 1, 2))
    assert pick(copter.live(0.05), "MISSION_COUNT")[0].mission_type == 2


def test_a_jump_to_behind_all_that_is_there_and_to_come_is_refused(copter):
    copter.live(4.0)
    broken_upload(copter)
    for target, result in ((4.0, 1), (0.0, 1), (1.0, 0)):
        offer_part(copter, 3, 3)
        give(copter, 3, command=177, p1=target)
        assert acks(copter.live(0.05)) == [result]


def test_in_flight_a_mission_that_gets_one_more_item_goes_on(copter):
    copter.live(42.0)
    copter.upload([TAKEOFF, waypoint(60.0, 0.0), waypoint(60.0, 60.0)])
    copter.ask(176, 1, 4)
    copter.ask(400, 1)
    copter.ask(300)
    copter.until(lambda: copter.flight.run.seq == 3, 60.0)
    offer_part(copter, 4, 4)
    give(copter, 4, command=20)
    assert acks(copter.live(0.1)) == [0]
    assert copter.flight.run.seq == 3
    copter.until(lambda: copter.flight.run.seq == 4, 40.0)


def test_fences_and_rally_points_are_kept_beside_the_mission(copter):
    copter.live(4.0)
    copter.upload([TAKEOFF])
    lat, lon, _ = place(10.0, 10.0, 0.0)
    for kind, command in ((1, 5003), (2, 5100)):
        copter.say(mavlink.MAVLink_mission_count_message(1, 1, 1, kind))
        assert pick(copter.live(0.05), "MISSION_REQUEST")[0].mission_type == kind
        copter.say(
            mavlink.MAVLink_mission_item_int_message(
                1, 1, 0, 3, command, 0, 1, 50.0, 0, 0, 0, round(lat * 1e7), round(lon * 1e7), 20.0, kind
            )
        )
        assert [ack.type for ack in pick(copter.live(0.05), "MISSION_ACK")] == [0]
    plans = copter.flight.plans
    assert (len(plans.mission), len(plans.fence), len(plans.rally)) == (2, 1, 1)


@pytest.mark.parametrize(
    ("corners", "said"),
    [
        ([(5001, 4.0)] * 3, "Incorrect item count (want=4 got=3)"),
        ([(5001, 2.0)] * 2, "Invalid vertex count (2)"),
        ([(5001, 3.0), (5001, 4.0), (5001, 3.0)], "Unexpected vertex count want=3 got=4"),
        ([(5001, 3.0), (5002, 3.0)], "Received incorrect vertex type (want=5001 got=5002)"),
        ([(5003, 0.0)], "Non-positive circle radius"),
    ],
    ids=["a corner is missing", "no area", "another count", "another kind", "no radius"],
)
def test_a_fence_that_is_none_is_refused_when_it_is_whole_and_the_old_one_stays(copter, corners, said):
    copter.live(4.0)
    assert upload_fence(copter, [(5001, 3.0)] * 3)[0] == [0]
    old = copter.flight.plans.fence
    results, heard = upload_fence(copter, corners)
    assert results == [1]
    assert said[:50] in texts(heard)  # as much as one text holds
    assert copter.flight.plans.fence == old and len(old) == 3


def upload_fence(copter, corners):
    """What the MISSION_ACKs said, and all heard."""
    offer(copter, len(corners), 1)
    heard = copter.live(0.05)
    for seq, (command, p1) in enumerate(corners):
        give(copter, seq, 1, command, p1)
        heard += copter.live(0.05)
    return acks(heard), heard


# AUTO


def fly(copter, *items, parameters=(), limit_s=200.0):
    """Upload, arm, start; every 0.1 s what it believes, until it is disarmed or finished. Returns that, and all heard."""
    for name, value in parameters:
        copter.say(mavlink.MAVLink_param_set_message(1, 1, name, value, 9))
    copter.live(max(0.0, 42.0 - copter.now_s))
    assert copter.upload(list(items)) == 0
    if not copter.flight.armed:
        copter.ask(176, 1, 4)
        assert copter.ask(400, 1) == 0
    assert copter.ask(300) == 0
    rows, heard = [], []
    begin = copter.now_s
    while copter.flight.armed and not copter.flight.run.finished:
        assert copter.now_s - begin < limit_s, copter.flight.run
        heard += copter.live(0.1)
        flight, place_m = copter.flight, copter.here - copter.flight.home.position_ned_m
        speed = float(np.hypot(*copter.simulator.report.estimate.velocity_ned_mps[:2]))
        rows.append((copter.now_s, flight.run.seq, *place_m, yaw_deg(copter), speed))
    return np.array(rows), heard


def test_auto_needs_a_mission_and_on_the_ground_one_that_takes_off(copter):
    copter.live(42.0)
    assert copter.ask(176, 1, AUTO) == 4
    copter.upload([waypoint(10.0, 0.0)])
    copter.ask(176, 1, 4)
    copter.ask(400, 1)
    copter.command(176, 1, AUTO)
    heard = copter.live(0.1)
    assert [ack.result for ack in pick(heard, "COMMAND_ACK")] == [4]
    assert "Auto: Missing Takeoff Cmd" in texts(heard)


def test_armed_and_switched_to_auto_it_waits_on_the_ground_for_mission_start(copter):
    copter.live(42.0)
    copter.upload(TWENTY)
    copter.ask(176, 1, 4)
    copter.ask(400, 1)
    assert copter.ask(176, 1, AUTO) == 0
    copter.live(4.0)
    assert copter.flight.landed.name == "ON_GROUND"
    assert copter.ask(300) == 0
    copter.live(8.0)
    assert copter.flight.landed.name != "ON_GROUND"


def test_a_mission_is_flown_from_take_off_to_the_disarming_after_return(copter):
    rows, heard = fly(
        copter, TAKEOFF, waypoint(30.0, 0.0), waypoint(30.0, 20.0, 14.0), do(178, 1, 4.0), RETURN
    )
    for north, east, down in ((30.0, 0.0, -10.0), (30.0, 20.0, -14.0)):
        assert np.linalg.norm(rows[:, 2:5] - (north, east, down), axis=1).min() < 2.5
    reached = [message.seq for message in pick(heard, "MISSION_ITEM_REACHED")]
    assert reached[:3] == [1, 2, 3]
    assert not copter.flight.armed
    assert copter.flight.mode is Mode.AUTO
    assert np.linalg.norm(rows[-1, 2:4]) < 1.0


def test_a_waypoint_without_delay_is_passed_without_a_stop_and_one_with_a_delay_is_not(copter):
    state = copter.airborne().simulator.snapshot()
    slowest = []
    for delay_s in (0.0, 2.0):
        copter.simulator.restore(state)
        line = [waypoint(40.0, 0.0, delay_s=delay_s), waypoint(80.0, 0.0)]
        rows, _ = fly(copter, TAKEOFF, *line)
        near = np.abs(rows[:, 2] - 40.0) < 8.0
        slowest.append(rows[near, 6].min())
    assert slowest[0] > 4.0
    assert slowest[1] < 0.5


def test_a_corner_is_cut_by_less_than_wpnav_radius(copter):
    rows, _ = fly(copter, TAKEOFF, waypoint(40.0, 0.0), waypoint(40.0, 40.0))
    off = np.hypot(rows[:, 2] - 40.0, rows[:, 3]).min()
    assert 0.2 < off < 2.5
    assert rows[np.abs(rows[:, 3] - 20.0) < 5.0, 2].max() < 41.5


def test_yaw_in_param4_is_dropped_the_nose_looks_along_the_way(copter):
    rows, _ = fly(copter, TAKEOFF, waypoint(0.0, 40.0, yaw_deg=200.0))
    mid = np.abs(rows[:, 3] - 20.0) < 5.0
    assert rows[mid, 5] == pytest.approx(90.0, abs=6.0)


@pytest.mark.parametrize(("behaviour", "kept"), [(2.0, False), (0.0, True)])
def test_condition_yaw_turns_the_nose_until_the_next_waypoint_unless_yaw_is_never_changed(
    copter, behaviour, kept
):
    rows, _ = fly(
        copter,
        TAKEOFF,
        do(115, 200.0, 0.0, 1.0, 0.0),
        waypoint(0.0, 40.0),
        waypoint(0.0, 80.0),
        parameters=((b"WP_YAW_BEHAVIOR", behaviour),),
    )
    first, second = np.abs(rows[:, 3] - 30.0) < 5.0, np.abs(rows[:, 3] - 79.0) < 1.0
    assert rows[first, 5] % 360.0 == pytest.approx(200.0, abs=6.0)
    assert rows[second, 5] % 360.0 == pytest.approx(200.0 if kept else 90.0, abs=8.0)


def test_a_turn_that_is_not_done_by_the_next_waypoint_gives_way_to_what_stands_behind_that(copter):
    rows, _ = fly(
        copter,
        TAKEOFF,
        do(115, 0.0),
        waypoint(0.0, 20.0),
        do(115, 180.0, 1.0),
        waypoint(0.0, 40.0),
        do(115, 300.0),
        waypoint(0.0, 80.0),
        parameters=((b"WP_YAW_BEHAVIOR", 0.0),),
    )
    slow, last = np.abs(rows[:, 3] - 35.0) < 3.0, np.abs(rows[:, 3] - 75.0) < 3.0
    assert rows[slow, 5] % 360.0 == pytest.approx(10.0, abs=10.0)
    assert rows[last, 5] % 360.0 == pytest.approx(300.0, abs=15.0)  # 180.0 if it were still at the second


def test_do_change_speed_is_obeyed_in_a_mission_and_as_a_command(copter):
    rows, _ = fly(copter, TAKEOFF, do(178, 1, 3.0), waypoint(60.0, 0.0))
    assert rows[:, 6].max() == pytest.approx(3.0, abs=0.3)
    copter.ask(176, 1, 4)
    assert copter.ask(178, 1, 1.5) == 0
    north, east, down = copter.here.tolist()
    copter.target(p=(north + 20.0, east, down))
    copter.live(8.0)
    assert np.hypot(*copter.simulator.report.estimate.velocity_ned_mps[:2]) == pytest.approx(1.5, abs=0.2)
    assert copter.ask(178, 1, -1.0) == 2


def test_without_speed_commands_it_flies_at_wpnav_speed(copter):
    rows, _ = fly(copter, TAKEOFF, waypoint(250.0, 0.0))
    assert rows[:, 6].max() == pytest.approx(10.0, abs=0.5)


def test_land_at_a_place_and_a_jump(copter):
    rows, heard = fly(
        copter,
        TAKEOFF,
        waypoint(15.0, 0.0),
        waypoint(0.0, 15.0),
        do(177, 2, 1),
        waypoint(5, 5, 0, command=21),
    )
    assert [item.seq for item in pick(heard, "MISSION_ITEM_REACHED")][:5] == [1, 2, 3, 2, 3]
    seqs = rows[:, 1]
    assert np.count_nonzero(np.diff(seqs) == -1) == 1
    assert np.linalg.norm(rows[-1, 2:4] - (5.0, 5.0)) < 1.0
    assert not copter.flight.armed


def test_shots_are_told_as_camera_feedback(copter):
    _, heard = fly(
        copter, TAKEOFF, do(206, 5.0, 0.0, 1.0), waypoint(40.0, 0.0), do(206, 0.0), waypoint(60.0, 0.0)
    )
    shots = pick(heard, "CAMERA_FEEDBACK")
    assert len(shots) == pytest.approx(9, abs=1)
    assert [shot.img_idx for shot in shots] == list(range(len(shots)))


def test_a_pause_in_guided_and_auto_goes_on_with_the_same_item(copter):
    copter.live(42.0)
    copter.upload([TAKEOFF, waypoint(60.0, 0.0), waypoint(60.0, 60.0), RETURN])
    copter.ask(176, 1, 4)
    copter.ask(400, 1)
    copter.ask(300)
    copter.until(lambda: copter.flight.run.seq == 3, 60.0)
    copter.ask(176, 1, 5)
    copter.live(8.0)
    assert np.hypot(*copter.simulator.report.estimate.velocity_ned_mps[:2]) < 0.5
    copter.ask(176, 1, AUTO)
    assert copter.flight.run.seq == 3
    copter.until(lambda: copter.flight.run.seq == 4, 40.0)


def test_the_mission_goes_on_with_the_item_that_do_set_mission_current_names(copter):
    copter.live(1.0)
    assert copter.upload([TAKEOFF, waypoint(20.0, 0.0), waypoint(40.0, 0.0)]) == 0
    assert copter.ask(224, 2) == 0
    assert copter.flight.run.seq == 2
    assert copter.ask(224, 9) == 4 and copter.ask(224, math.nan) == 4
    assert copter.flight.run.seq == 2
