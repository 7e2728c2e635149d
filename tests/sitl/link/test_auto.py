"""AUTO: uploaded missions flown over real bytes, by PX4's rules."""

import math

import numpy as np
import pytest
from px4_client import HOME

from sitl.geo import geodetic_of_ned, ned_of_geodetic
from sitl.orders import Mode

NAN = math.nan
RETURN = (20, (0.0,) * 7, 2)


def place(north_m, east_m, height_m):
    anchor = HOME.lat_deg, HOME.lon_deg, HOME.alt_amsl_m
    lat_deg, lon_deg, _ = geodetic_of_ned(anchor, (north_m, east_m, 0.0))
    return lat_deg, lon_deg, height_m


def takeoff(height_m=10.0):
    return 22, (0, 0, 0, NAN, *place(0.0, 0.0, height_m)), 3


def waypoint(north_m, east_m, height_m=10.0, hold_s=0.0, radius_m=0.0, yaw_deg=NAN):
    return 16, (hold_s, radius_m, 0, yaw_deg, *place(north_m, east_m, height_m)), 3


def do(command, *params):
    return command, (*params, *[0.0] * (7 - len(params))), 2


@pytest.fixture
def loaded(new_client):
    """A client whose vehicle has taken the items and is ready; parameters by name."""

    def make(*items, **params):
        client = new_client(params={k: v for k, v in params.items() if k in KNOWN})
        client.until(lambda: client.flight.ready, 10.0)
        for name, value in params.items():
            client.simulator._craft.set_parameter(name, value)
        assert client.upload(list(items)) == 0
        return client

    return make


KNOWN = ("NAV_ACC_RAD", "MPC_XY_CRUISE")


def start(client):
    client.command(300, 0, 0)
    client.live(0.1)
    assert client.flight.mode is Mode.MISSION
    assert client.flight.armed
    return client


def fly(client, until, limit_s=120.0):
    """Truth every 0.1 s until it holds: time, position, speed, yaw, sequence number."""
    rows = []
    for _ in range(round(limit_s * 10)):
        client.live(0.1)
        truth = client.simulator.truth
        w, x, y, z = truth.q_ned_frd
        yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        speed = float(np.hypot(*truth.velocity_ned_mps[:2]))
        rows.append((1e-6 * client.now_us, *truth.position_ned_m, speed, yaw, client.flight.run.seq))
        if until():
            return np.array(rows)
    raise AssertionError(f"not within {limit_s} s")


def seq_is(client, seq):
    return lambda: client.flight.run.seq == seq


def reached(client, pick):
    seqs = [message.seq for message in pick([m for _, _, m in client.heard], "MISSION_ITEM_REACHED")]
    return list(dict.fromkeys(seqs))


def test_without_a_mission_the_mode_is_refused_in_flight(client, pick):
    client.airborne(5.0)
    client.heartbeat()
    client.command(176, 1, 4, 4)
    heard = client.live(0.1)
    assert [ack.result for ack in pick(heard, "COMMAND_ACK")] == [0, 1]
    assert b"".join(t.text for t in pick(heard, "STATUSTEXT")).startswith(b"Switching to mode 'Mission'")
    client.command(300, 0, 0)
    assert [ack.result for ack in pick(client.live(0.1), "COMMAND_ACK")] == [2]
    assert client.flight.mode is Mode.HOLD


def test_a_mission_that_cannot_be_flown_is_taken_said_and_refused(client, pick):
    client.until(lambda: client.flight.ready, 10.0)
    client.heartbeat()
    client.live(0.1)
    client.heard.clear()
    assert client.upload([waypoint(5, 5), takeoff()]) == 0
    client.live(0.1)
    texts = [m.text for _, _, m in client.heard if type(m).__name__ == "STATUSTEXT"]
    assert b"".join(texts) == b"Mission rejected: takeoff is not the first waypoint item"
    client.command(176, 1, 4, 4)
    client.command(400, 1.0, 0.0)
    client.live(0.1)
    assert (client.flight.mode, client.flight.armed) == (Mode.MISSION, False)


def test_a_far_first_waypoint_is_only_warned_of(client, pick):
    client.until(lambda: client.flight.ready, 10.0)
    client.heartbeat()
    client.live(0.1)
    assert client.upload([waypoint(1000, 0)]) == 0
    client.live(0.1)
    texts = [m.text for _, _, m in client.heard if type(m).__name__ == "STATUSTEXT"]
    assert b"First waypoint far away from Home: 1000m (maximum 900m)".startswith(texts[0])
    assert client.flight.mission_ok


def test_a_whole_mission_from_the_ground_to_the_ground(loaded, pick):
    client = start(loaded(takeoff(8.0), waypoint(12, 0), waypoint(12, 12, 6.0), RETURN))
    rows = fly(client, lambda: not client.flight.armed)
    assert reached(client, pick) == [0, 1, 2, 3]
    modes = [event.text for event in client.simulator.take_events() if event.kind == "mode"]
    assert modes == ["MISSION", "RETURN", "HOLD"]
    assert rows[-1][1:4] == pytest.approx([0.0, 0.0, 0.0], abs=0.5)
    assert client.flight.run.seq == 0  # it would begin anew


def test_mission_start_arms_as_px4_does_and_the_mode_alone_does_not(loaded):
    client = loaded(takeoff(), waypoint(5, 0))
    client.command(176, 1, 4, 4)
    client.live(0.5)
    assert (client.flight.mode, client.flight.armed) == (Mode.MISSION, False)
    client.command(400, 1, 0)
    fly(client, seq_is(client, 1), 20.0)


def test_without_a_take_off_item_it_climbs_first_all_the_same(loaded):
    client = start(loaded(waypoint(15, 0, 10.0)))
    rows = fly(client, lambda: client.flight.mode is Mode.HOLD)
    low = rows[-rows[:, 3] < 8.0]
    assert np.abs(low[:, 1]).max() < 0.5


def test_the_end_of_a_mission_without_a_return_is_a_hold_at_its_last_place(loaded):
    client = start(loaded(takeoff(), waypoint(15, 5, 12.0)))
    fly(client, lambda: client.flight.mode is Mode.HOLD)
    client.live(8.0)
    assert client.simulator.truth.position_ned_m == pytest.approx([15.0, 5.0, -12.0], abs=0.3)


def test_land_comes_down_at_its_place_and_disarms(loaded):
    client = start(loaded(takeoff(6.0), (21, (0, 0, 0, NAN, *place(8, -4, 0.0)), 3)))
    rows = fly(client, lambda: not client.flight.armed)
    assert rows[-1][1:4] == pytest.approx([8.0, -4.0, 0.0], abs=0.4)
    far = np.hypot(rows[:, 1] - 8.0, rows[:, 2] + 4.0) > 3.0
    under_way = rows[:, 6] == 1
    assert (-rows[far & under_way, 3] > 4.9).all()


def test_a_corner_is_rounded_within_the_acceptance_radius_and_not_stopped_at(loaded):
    client = start(loaded(takeoff(), waypoint(30, 0), waypoint(30, 30), waypoint(60, 30)))
    rows = fly(client, lambda: client.flight.mode is Mode.HOLD)
    near = rows[np.hypot(rows[:, 1] - 30.0, rows[:, 2]) < 3.0]
    assert near[:, 4].min() > 0.7
    assert 0.1 < np.hypot(near[:, 1] - 30.0, near[:, 2]).min() < 2.0
    assert rows[:, 1].max() < 60.5
    assert rows[rows[:, 1] < 28.0][:, 2].max() < 0.6


def test_a_straight_row_of_waypoints_is_passed_at_speed(loaded):
    """PX4 could stop at the waypoint after the next: 12 m apart it need not slow down from 5 m/s."""
    client = start(loaded(takeoff(), *[waypoint(12.0 * k, 0) for k in range(1, 7)]))
    rows = fly(client, lambda: client.flight.mode is Mode.HOLD)
    along = rows[(rows[:, 1] > 14.0) & (rows[:, 1] < 50.0)]
    assert along[:, 4].min() > 3.5
    assert along[:, 4].max() < 5.5


def test_close_waypoints_are_flown_slowly(loaded):
    client = start(loaded(takeoff(), *[waypoint(2.0 * k, 0, radius_m=1.0) for k in range(1, 16)]))
    rows = fly(client, lambda: client.flight.mode is Mode.HOLD)
    along = rows[(rows[:, 1] > 6.0) & (rows[:, 1] < 24.0)]
    assert 0.9 < along[:, 4].mean() < 1.8


def test_a_hold_is_a_stop_of_that_length(loaded):
    client = start(loaded(takeoff(), waypoint(10, 0, hold_s=5.0), waypoint(10, 10)))
    fly(client, seq_is(client, 1))
    rows = fly(client, seq_is(client, 2))
    inside = rows[np.abs(rows[:, 1] - 10.0) < 2.0]
    assert len(inside) * 0.1 == pytest.approx(5.0, abs=0.4)
    assert inside[-1][4] < 0.1
    assert inside[-1][1] == pytest.approx(10.0, abs=0.3)


def test_the_radius_of_a_waypoint_goes_before_the_usual_one(loaded):
    client = start(loaded(takeoff(), waypoint(20, 0, radius_m=6.0), waypoint(20, 20)))
    fly(client, seq_is(client, 1))
    rows = fly(client, seq_is(client, 2))
    assert 20.0 - rows[-1][1] == pytest.approx(6.0, abs=0.6)


def test_a_heading_must_be_reached_before_the_waypoint_counts(loaded):
    client = start(loaded(takeoff(), waypoint(6, 0, yaw_deg=180.0), waypoint(6, 6)))
    fly(client, seq_is(client, 1))
    rows = fly(client, seq_is(client, 2))
    assert abs(math.remainder(rows[-1][5] - math.pi, math.tau)) < math.radians(14.0)
    assert rows[-1][0] - rows[np.abs(rows[:, 1] - 6.0) < 2.0][0][0] > 1.0  # it waited for the turn


def test_with_a_yaw_timeout_headings_hold_nobody_up(loaded):
    client = start(loaded(takeoff(), waypoint(6, 0, yaw_deg=180.0), waypoint(6, 6), MIS_YAW_TMT=3.0))
    fly(client, seq_is(client, 1))
    rows = fly(client, seq_is(client, 2))
    assert abs(math.remainder(rows[-1][5] - math.pi, math.tau)) > math.radians(30.0)


def test_without_a_heading_the_nose_looks_to_the_waypoint_and_turns_no_faster_than_it_may(loaded):
    client = start(loaded(takeoff(), waypoint(0, 25), waypoint(0, -25)))
    rows = fly(client, lambda: client.flight.mode is Mode.HOLD)
    assert rows[rows[:, 2] > 15.0][0][5] == pytest.approx(math.pi / 2.0, abs=0.1)
    assert rows[rows[:, 6] == 2][-1][5] == pytest.approx(-math.pi / 2.0, abs=0.1)
    rate = np.abs(np.diff(np.unwrap(rows[:, 5]))) / 0.1
    assert rate.max() < math.radians(75.0)


def test_do_change_speed_sets_the_cruise_and_resets_it(loaded):
    client = start(
        loaded(takeoff(), do(178, 1, 2.0, -1), waypoint(25, 0), do(178, 1, -1, -1), waypoint(70, 0))
    )
    rows = fly(client, lambda: client.flight.mode is Mode.HOLD)
    assert rows[rows[:, 1] < 20.0][:, 4].max() == pytest.approx(2.0, abs=0.3)
    assert rows[:, 4].max() == pytest.approx(5.0, abs=0.5)


def test_do_jump_repeats_as_often_as_it_says(loaded, pick):
    client = start(loaded(takeoff(), waypoint(8, 0), waypoint(0, 0), do(177, 1, 2), waypoint(0, 8)))
    seqs = fly(client, lambda: client.flight.mode is Mode.HOLD)[:, 6]
    visits = [int(s) for s, before in zip(seqs[1:], seqs, strict=False) if s != before]
    assert visits == [1, 2, 1, 2, 1, 2, 4]


def test_a_delay_waits_and_loiter_time_too(loaded):
    client = start(
        loaded(takeoff(), do(93, 4.0), (19, (3.0, 0, 0, NAN, *place(4, 0, 10.0)), 3), waypoint(8, 0))
    )
    fly(client, seq_is(client, 1))
    assert len(fly(client, seq_is(client, 2))) == pytest.approx(40, abs=2)
    rows = fly(client, seq_is(client, 3))
    assert rows[-1][0] - rows[rows[:, 1] > 2.0][0][0] == pytest.approx(3.0, abs=0.4)


def test_loiter_unlimited_stays(loaded):
    client = start(loaded(takeoff(), (17, (0, 0, 0, NAN, *place(6, 0, 10.0)), 3), waypoint(30, 0)))
    client.live(40.0)
    assert client.flight.run.seq == 1
    assert client.simulator.truth.position_ned_m == pytest.approx([6.0, 0.0, -10.0], abs=0.3)


def test_hold_pauses_and_the_mode_goes_on_where_it_was(loaded):
    client = start(loaded(takeoff(), do(206, 2.0, 0, 1), waypoint(40, 0), waypoint(40, 20)))
    fly(client, lambda: client.simulator.truth.position_ned_m[0] > 15.0)
    client.command(176, 1, 4, 3)
    client.live(6.0)
    stopped = client.simulator.truth.position_ned_m
    shots = client.simulator._craft.commander._state.payload.shots
    client.command(192, -1, 1, 0, NAN, *place(float(stopped[0]), 8.0, HOME.alt_amsl_m + 10.0))
    client.live(8.0)
    assert client.flight.run.seq == 2
    assert client.simulator._craft.commander._state.payload.shots == shots  # the camera waits
    client.command(176, 1, 4, 4)
    rows = fly(client, seq_is(client, 3))
    assert rows[-1][1] == pytest.approx(38.0, abs=0.6)
    assert client.simulator._craft.commander._state.payload.shots > shots + 5


def test_set_current_skips(loaded):
    client = start(loaded(takeoff(), waypoint(30, 0), waypoint(0, 20), waypoint(0, 0)))
    fly(client, seq_is(client, 1))
    client.live(1.0)
    client.say("MISSION_SET_CURRENT", seq=2, target_system=1, target_component=1)
    rows = fly(client, seq_is(client, 3))
    assert rows[-1][2] == pytest.approx(18.0, abs=0.6)
    assert rows[:, 1].max() < 6.0


def test_pictures_come_at_their_distance_with_place_and_attitude(loaded, pick):
    client = start(
        loaded(
            takeoff(),
            do(205, -30.0, 0.0, 0.0),
            waypoint(0, 0.1),
            do(206, 4.0, 0, 1),
            waypoint(0, 41),
            do(206, 0, 0, 0),
            waypoint(0, 60),
        )
    )
    fly(client, lambda: client.flight.mode is Mode.HOLD)
    shots = pick([m for _, _, m in client.heard], "CAMERA_IMAGE_CAPTURED")
    anchor = HOME.lat_deg, HOME.lon_deg, HOME.alt_amsl_m
    east = [ned_of_geodetic(anchor, (s.lat * 1e-7, s.lon * 1e-7, HOME.alt_amsl_m))[1] for s in shots]
    assert [s.image_index for s in shots] == list(range(len(shots)))
    assert len(shots) == 10
    assert np.diff(east) == pytest.approx(4.0, abs=0.2)
    assert shots[-1].relative_alt == pytest.approx(10_000, abs=400)
    w, x, y, z = shots[-1].q
    assert math.asin(2.0 * (w * y - x * z)) == pytest.approx(math.radians(-30.0), abs=1e-3)
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    assert yaw == pytest.approx(math.pi / 2.0, abs=0.1)


@pytest.mark.parametrize(
    ("order", "count"),
    [
        (do(214, 1000.0), 10),
        (do(2000, 0, 2.0, 3.0), 3),
        (do(2000, 0, 0.0, 1.0), 1),
        (do(203, 0, 0, 0, 0, 1), 1),
        (do(2001), 0),
    ],
)
def test_pictures_come_by_time_and_by_number(loaded, pick, order, count):
    client = start(loaded(takeoff(3.0), order, do(93, 9.5), do(2001), do(214, 0), do(93, 3.0)))
    fly(client, lambda: client.flight.mode is Mode.HOLD)
    assert len(pick([m for _, _, m in client.heard], "CAMERA_IMAGE_CAPTURED")) == count


def test_a_picture_can_be_ordered_by_command_in_any_mode(client, pick):
    client.live(3.0)
    client.command(2000, 0, 0, 1)
    heard = client.live(0.1)
    assert [ack.result for ack in pick(heard, "COMMAND_ACK")] == [0]
    assert len(pick(heard, "CAMERA_IMAGE_CAPTURED")) == 1


def test_the_camera_has_an_address_of_its_own_and_takes_a_number_once(client, pick):
    client.live(3.0)
    heard = []
    for number in (1, 1, 1, 2):
        client.command(2000, 0, 0, 1, number, component=100)
        heard += client.live(0.1)
    assert [image.image_index for image in pick(heard, "CAMERA_IMAGE_CAPTURED")] == [0, 1]
    assert [ack.result for ack in pick(heard, "COMMAND_ACK")] == [0] * 4
    client.command(400, 1.0, 0.0, component=100)
    assert not pick(client.live(0.2), "COMMAND_ACK"), "it is a camera, and arms nothing"


def test_the_nose_looks_at_a_region_of_interest_until_there_is_none(loaded):
    interest = (195, (0, 0, 0, 0, *place(20, 30, 0.0)), 3)
    client = start(loaded(takeoff(), interest, waypoint(40, 0), do(197), waypoint(60, 0)))
    rows = fly(client, lambda: client.flight.mode is Mode.HOLD)
    beside = rows[np.abs(rows[:, 1] - 20.0) < 1.0]
    assert beside[:, 5].mean() == pytest.approx(math.pi / 2.0, abs=0.25)
    assert abs(rows[rows[:, 1] > 55.0][-1][5]) < 0.1


def test_a_new_mission_in_flight_is_flown_from_its_beginning(loaded):
    client = start(loaded(takeoff(), waypoint(40, 0)))
    fly(client, seq_is(client, 1))
    client.live(2.0)
    assert client.upload([waypoint(0, 10), waypoint(0, 0)]) == 0
    rows = fly(client, lambda: client.flight.mode is Mode.HOLD)
    assert rows[:, 2].max() > 7.5
    assert client.flight.run.finished


def test_the_same_mission_again_in_flight_changes_nothing(loaded):
    items = [takeoff(), waypoint(40, 0), waypoint(40, 10)]
    client = start(loaded(*items))
    fly(client, seq_is(client, 1))
    assert client.upload(items) == 0
    assert client.flight.run.seq == 1


def test_a_cleared_mission_in_flight_is_a_hold(loaded):
    client = start(loaded(takeoff(), waypoint(40, 0)))
    fly(client, seq_is(client, 1))
    client.say("MISSION_CLEAR_ALL", target_system=1, target_component=1, mission_type=0)
    client.live(0.1)
    assert client.flight.mode is Mode.HOLD


def test_a_restored_mission_flies_on_to_the_same_bits(new_client, loaded):
    client = start(loaded(takeoff(), do(206, 3.0, 0, 1), waypoint(20, 0), waypoint(20, 20), RETURN))
    fly(client, seq_is(client, 2))
    kept = client.simulator.snapshot()
    twin = new_client()
    twin.simulator.restore(kept)
    sent = [c.simulator.exchange(kept_us, (b"",))[0] for c in (client, twin) for kept_us in (60_000_000,)]
    assert sent[0] == sent[1]
