"""What QGroundControl asks when it connects: every question is answered or refused at once, in both dialects."""

import pytest
from copter_client import mavlink
from copter_client import pick as heard_of
from pymavlink.dialects.v20 import all as everything

ACCEPTED, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4
REQUEST, CAPABILITIES = 512, 520
COMPONENT_METADATA, COMPONENT_INFORMATION, CAMERA_INFORMATION, GIMBAL_MANAGER_INFORMATION = 397, 395, 259, 280
AVAILABLE_MODES, PROTOCOL_VERSION, AUTOPILOT_VERSION, HOME_POSITION, CURRENT_MODE = 435, 300, 148, 242, 436
QUESTIONS = {
    # command, first parameter: what PX4 and ArduCopter answer, and with which message
    (REQUEST, AUTOPILOT_VERSION): (ACCEPTED, ACCEPTED, "AUTOPILOT_VERSION"),
    (CAPABILITIES, 1): (ACCEPTED, ACCEPTED, "AUTOPILOT_VERSION"),
    (REQUEST, AVAILABLE_MODES): (ACCEPTED, ACCEPTED, "AVAILABLE_MODES"),
    (REQUEST, CURRENT_MODE): (ACCEPTED, ACCEPTED, "CURRENT_MODE"),
    (REQUEST, HOME_POSITION): (ACCEPTED, ACCEPTED, "HOME_POSITION"),
    (410, 0): (ACCEPTED, ACCEPTED, "HOME_POSITION"),
    (REQUEST, PROTOCOL_VERSION): (ACCEPTED, FAILED, None),
    (519, 1): (ACCEPTED, UNSUPPORTED, None),
    (REQUEST, COMPONENT_METADATA): (DENIED, FAILED, None),
    (REQUEST, COMPONENT_INFORMATION): (DENIED, FAILED, None),
    (REQUEST, CAMERA_INFORMATION): (DENIED, FAILED, None),
    (REQUEST, GIMBAL_MANAGER_INFORMATION): (DENIED, FAILED, None),
    (521, 1): (UNSUPPORTED, UNSUPPORTED, None),
    (525, 1): (UNSUPPORTED, UNSUPPORTED, None),
    (511, 99999): (FAILED, DENIED, None),
}


@pytest.mark.parametrize("question", QUESTIONS)
def test_a_px4_answers(px4_client, pick, question):
    px4_client.live(max(0.0, 5.0 - px4_client.now_us * 1e-6))
    px4_client.command(*question)
    heard = px4_client.live(0.05)
    result, _, name = QUESTIONS[question]
    assert [ack.result for ack in pick(heard, "COMMAND_ACK")] == [result]
    assert name is None or pick(heard, name)


@pytest.mark.parametrize("question", QUESTIONS)
def test_an_arducopter_answers(aloft, question):
    aloft.mav = everything.MAVLink(None, 255, 190)
    aloft.mav.robust_parsing = True
    aloft.command(*question)
    heard = aloft.live(0.05)
    _, result, name = QUESTIONS[question]
    assert [ack.result for ack in heard_of(heard, "COMMAND_ACK")] == [result]
    assert name is None or heard_of(heard, name)


def test_the_modes_come_one_by_one_or_all_at_once_and_no_further_than_there_are(aloft):
    aloft.mav = everything.MAVLink(None, 255, 190)
    aloft.command(REQUEST, AVAILABLE_MODES, 0)
    all_modes = heard_of(aloft.live(0.05), "AVAILABLE_MODES")
    assert [mode.mode_index for mode in all_modes] == list(range(1, len(all_modes) + 1))
    assert {mode.mode_name: mode.custom_mode for mode in all_modes}["GUIDED"] == 4
    aloft.command(REQUEST, AVAILABLE_MODES, 3)
    (third,) = heard_of(aloft.live(0.05), "AVAILABLE_MODES")
    assert (third.mode_name, third.number_modes) == (all_modes[2].mode_name, len(all_modes))
    assert aloft.ask(REQUEST, AVAILABLE_MODES, len(all_modes) + 1) == FAILED


@pytest.mark.parametrize("kind", [0, 1, 2])
def test_empty_plans_are_counted(copter, client, pick, kind):
    copter.say(mavlink.MAVLink_mission_request_list_message(1, 1, kind))
    assert [message.count for message in heard_of(copter.live(0.05), "MISSION_COUNT")] == [0]
    client.say("MISSION_REQUEST_LIST", target_system=1, target_component=1, mission_type=kind)
    assert [message.count for message in pick(client.live(0.05), "MISSION_COUNT")] == [0]


def test_there_are_no_logs_on_board(copter, client, pick):
    copter.say(mavlink.MAVLink_log_request_list_message(1, 1, 0, 0xFFFF))
    assert [message.num_logs for message in heard_of(copter.live(0.05), "LOG_ENTRY")] == [0]
    client.say("LOG_REQUEST_LIST", target_system=1, target_component=1, start=0, end=0xFFFF)
    assert [message.num_logs for message in pick(client.live(0.05), "LOG_ENTRY")] == [0]


def test_a_servo_moves_but_no_motors(copter):
    copter.live(4.0)
    copter.command(511, 36, 100_000)
    assert copter.ask(183, 9, 1700) == ACCEPTED
    assert copter.ask(183, 2, 1700) == FAILED
    servos = heard_of(copter.live(0.3), "SERVO_OUTPUT_RAW")[-1]
    assert (servos.servo9_raw, servos.servo2_raw) == (1700, 900)


def test_a_mission_pauses_and_goes_on(aloft):
    home = aloft.flight.home.point
    assert aloft.ask(193, 0) == DENIED
    aloft.upload([(16, 3, (0, 0, 0, 0, home.lat_deg + 2e-3, home.lon_deg, 10))])
    aloft.ask(176, 1, 3)
    aloft.live(6.0)
    speeds = []
    for go_on in (0, 1):
        assert aloft.ask(193, go_on) == ACCEPTED
        aloft.live(8.0)
        speeds.append(abs(float(aloft.simulator.report.estimate.velocity_ned_mps[0])))
    assert speeds[0] < 0.3
    assert speeds[1] > 6.0
