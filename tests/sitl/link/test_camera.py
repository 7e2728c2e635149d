"""The camera on its gimbal, as component 100 and as PX4's gimbal manager; nothing of it without --camera."""

from __future__ import annotations

import math

import pytest

CAMERA = 100
INFORMATION, SETTINGS, STORAGE, CAPTURE, IMAGE = 259, 260, 261, 262, 263


@pytest.fixture
def camera(new_client):
    client = new_client(camera=True)
    client.until(lambda: client.flight.ready, 10.0)
    return client


def asked(client, pick, number, *params, component=CAMERA):
    """The result of a command, and the names of what came with it."""
    client.command(number, *params, component=component)
    heard = client.live(0.05)
    (ack,) = [ack for ack in pick(heard, "COMMAND_ACK") if ack.command == number]
    return ack.result, heard


def test_it_has_a_heartbeat_of_its_own(camera):
    codec = camera.codecs[0]
    data = b"".join(
        camera.simulator.exchange(camera.simulator.time_us + 10_000, (b"",))[0] for _ in range(300)
    )
    beats = [item for item in codec.decode(data) if type(item.message).__name__ == "HEARTBEAT"]
    of_camera = [item.message for item in beats if item.component == CAMERA]
    assert len(of_camera) == len(beats) - len(of_camera) == 3
    assert (of_camera[0].type, of_camera[0].autopilot) == (30, 8)


def test_it_says_what_it_is_by_the_new_request_and_by_the_old_ones(camera, pick):
    for number, old, name in (
        (INFORMATION, 521, "CAMERA_INFORMATION"),
        (SETTINGS, 522, "CAMERA_SETTINGS"),
        (STORAGE, 525, "STORAGE_INFORMATION"),
        (CAPTURE, 527, "CAMERA_CAPTURE_STATUS"),
    ):
        for request in ((512, number), (old, 1)):
            result, heard = asked(camera, pick, *request)
            assert result == 0
            assert len(pick(heard, name)) == 1
    _, heard = asked(camera, pick, 512, INFORMATION)
    (told,) = pick(heard, "CAMERA_INFORMATION")
    assert (told.focal_length, told.resolution_h, bytes(told.model_name).rstrip(b"\0")) == (
        pytest.approx(8.8),
        5472,
        b"sitl",
    )


def test_pictures_are_taken_counted_and_stored(camera, pick):
    result, _ = asked(camera, pick, 2000, 0.0, 0.0, 1.0)
    assert result == 0
    camera.live(0.1)
    asked(camera, pick, 2000, 0.0, 0.5, 4.0)
    camera.live(4.0)
    assert len(pick([m for _, _, m in camera.heard], "CAMERA_IMAGE_CAPTURED")) == 5
    _, heard = asked(camera, pick, 512, CAPTURE)
    assert pick(heard, "CAMERA_CAPTURE_STATUS")[0].image_count == 5
    _, heard = asked(camera, pick, 512, STORAGE)
    assert pick(heard, "STORAGE_INFORMATION")[0].used_capacity > 0.0


@pytest.mark.parametrize(("number", "result"), [(2.0, 1), (1.0, 0), (0.0, 1)])
def test_a_camera_that_has_not_taken_the_last_picture_says_that_it_is_busy(camera, pick, number, result):
    """Both commands come within one frame: each that it accepts makes a picture, the same number the same one."""
    for each in (1.0, number):
        camera.command(2000, 0.0, 0.0, 1.0, each, component=CAMERA)
    heard = camera.live(0.1)
    assert [ack.result for ack in pick(heard, "COMMAND_ACK")] == [0, result]
    assert len(pick(heard, "CAMERA_IMAGE_CAPTURED")) == 1
    assert asked(camera, pick, 2000, 0.0, 0.0, 1.0, number)[0] == 0
    taken_n = len(pick([message for _, _, message in camera.heard], "CAMERA_IMAGE_CAPTURED"))
    assert taken_n == (1 if number == 1.0 else 2)


def test_a_picture_is_told_again_to_whoever_asks_for_its_number(camera, pick):
    asked(camera, pick, 2000, 0.0, 0.5, 2.0)
    camera.live(2.0)
    first, second = pick([m for _, _, m in camera.heard], "CAMERA_IMAGE_CAPTURED")
    for picture in (second, first):
        result, heard = asked(camera, pick, 512, IMAGE, picture.image_index)
        assert result == 0
        (again,) = pick(heard, "CAMERA_IMAGE_CAPTURED")
        assert (again.image_index, again.time_boot_ms) == (picture.image_index, picture.time_boot_ms)
    for number in (2, -1, math.nan):
        result, heard = asked(camera, pick, 512, IMAGE, number)
        assert result == 2 and not pick(heard, "CAMERA_IMAGE_CAPTURED")


def test_an_interval_is_told_while_it_runs_and_stops(camera, pick):
    asked(camera, pick, 2000, 0.0, 0.5, 0.0)
    _, heard = asked(camera, pick, 512, CAPTURE)
    assert pick(heard, "CAMERA_CAPTURE_STATUS")[0].image_interval == 0.5
    asked(camera, pick, 2001)
    _, heard = asked(camera, pick, 512, CAPTURE)
    assert pick(heard, "CAMERA_CAPTURE_STATUS")[0].image_interval == 0.0


@pytest.mark.parametrize(
    ("request_", "result"),
    [
        ((530, 0.0, 0.0), 0),
        ((530, 0.0, 1.0), 2),
        ((512, 1), 3),
        ((512, math.nan), 3),
        ((2500,), 3),
        ((400, 1.0), 3),
    ],
)
def test_photographs_it_takes_and_nothing_else(camera, pick, request_, result):
    assert asked(camera, pick, *request_)[0] == result
    assert not camera.flight.armed


def test_the_gimbal_manager_says_what_it_can_and_who_has_control(camera, pick):
    result, heard = asked(camera, pick, 512, 280, component=1)
    assert (result, pick(heard, "GIMBAL_MANAGER_INFORMATION")[0].gimbal_device_id) == (0, 1)
    assert len(pick(asked(camera, pick, 512, 283, component=1)[1], "GIMBAL_DEVICE_INFORMATION")) == 1
    assert asked(camera, pick, 1001, -2.0, -2.0, -1.0, -1.0, component=1)[0] == 0
    _, heard = asked(camera, pick, 512, 281, component=1)
    status = pick(heard, "GIMBAL_MANAGER_STATUS")[0]
    assert (status.primary_control_sysid, status.primary_control_compid) == (255, 190)
    asked(camera, pick, 1001, -3.0, -3.0, -1.0, -1.0, component=1)
    _, heard = asked(camera, pick, 512, 281, component=1)
    assert pick(heard, "GIMBAL_MANAGER_STATUS")[0].primary_control_sysid == 0


def test_the_gimbal_is_told_of_unasked_as_px4_does(camera, pick):
    heard = camera.live(10.0)
    assert len(pick(heard, "GIMBAL_DEVICE_ATTITUDE_STATUS")) == pytest.approx(10, abs=1)
    assert len(pick(heard, "GIMBAL_MANAGER_STATUS")) == pytest.approx(5, abs=1)


def test_the_gimbals_attitude_is_what_was_ordered(camera, pick):
    asked(camera, pick, 1000, -30.0, 40.0, component=1)
    asked(camera, pick, 511, 285, 100_000, component=1)
    told = pick(camera.live(1.0), "GIMBAL_DEVICE_ATTITUDE_STATUS")
    assert len(told) == pytest.approx(10, abs=1)
    w, x, y, z = told[-1].q
    assert math.degrees(math.asin(2 * (w * y - x * z))) == pytest.approx(-30.0, abs=0.01)
    assert math.degrees(math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))) == pytest.approx(
        40.0, abs=0.01
    )


def test_without_a_camera_there_is_none(client, pick):
    client.until(lambda: client.flight.ready, 10.0)
    client.command(512, INFORMATION, component=CAMERA)
    heard = client.live(2.0)
    assert pick(heard, "COMMAND_ACK") == []
    assert {beat.type for beat in pick(heard, "HEARTBEAT")} == {2}
    assert asked(client, pick, 512, 280, component=1)[0] == 2


def test_a_camera_survives_a_snapshot(camera):
    state, ends = camera.simulator.snapshot(), []
    for _ in range(2):
        camera.simulator.restore(state)
        ends.append(
            camera.simulator.exchange(
                state.craft.vehicle.arrays[1]["nav"]["frame"][0] * 10_000 + 1_500_000, (b"",)
            )
        )
    assert ends[0] == ends[1]
