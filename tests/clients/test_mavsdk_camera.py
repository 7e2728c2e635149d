"""MAVSDK 4's camera and gimbal plugins against `python -m sitl --camera`."""

import pytest

pytest.importorskip("mavsdk")

from mavsdk.plugins.camera import Camera, CameraError
from mavsdk.plugins.gimbal import ControlMode, Gimbal, GimbalMode, SendMode
from mavsdk_session import insisted, system_of
from patience import eventually


def stored(camera, component_id):
    """What the card holds, once MAVSDK has asked for it; nothing before."""
    try:
        return camera.get_storage(component_id)
    except CameraError:
        return None


def test_camera_and_gimbal_are_found_and_used(start_vehicle):
    vehicle = start_vehicle("--camera", "--speedup", "4")
    with system_of(vehicle) as system:
        camera, gimbal = Camera(system), Gimbal(system)

        (found,) = eventually(lambda: camera.camera_list().cameras)
        assert (found.vendor_name, found.model_name) == ("mavspiral", "sitl")
        assert (found.horizontal_resolution_px, found.focal_length_mm) == (5472, pytest.approx(8.8))
        pictures = []
        camera.subscribe_capture_info(lambda picture, *_: pictures.append(picture))
        insisted(camera.take_photo, found.component_id)
        eventually(lambda: pictures)
        insisted(camera.start_photo_interval, found.component_id, 0.5)
        eventually(lambda: {0, 1, 2, 3} <= {picture.index for picture in pictures})
        insisted(camera.stop_photo_interval, found.component_id)
        assert pictures[0].index == 0
        assert pictures[0].position.latitude_deg == pytest.approx(23.96028, abs=1e-4)

        (managed,) = eventually(lambda: gimbal.gimbal_list().gimbals)
        insisted(gimbal.take_control, managed.gimbal_id, ControlMode.PRIMARY)
        gimbal.set_angles(managed.gimbal_id, 0.0, -45.0, 20.0, GimbalMode.YAW_FOLLOW, SendMode.ONCE)
        attitudes = []
        gimbal.subscribe_attitude(lambda attitude, *_: attitudes.append(attitude.euler_angle_forward))
        eventually(lambda: attitudes and attitudes[-1].pitch_deg == pytest.approx(-45.0, abs=0.1))
        storage = eventually(lambda: stored(camera, found.component_id))
        assert storage.available_storage_mib > 0.0
        insisted(gimbal.release_control, managed.gimbal_id)
