import dataclasses

import pytest

from mavspiral.survey.camera import Camera


@pytest.fixture
def camera():
    return Camera(0.0088, (0.0132, 0.0088), (5472, 3648), 0.0005, 0.7, gimbal=True)


def test_the_footprint_is_that_of_a_pinhole(camera):
    assert camera.footprint_m(12.0) == pytest.approx((18.0, 12.0))
    assert camera.gsd_m(12.0) == pytest.approx(18.0 / 5472)


def test_rise_is_equation_2_of_the_paper(camera):
    assert camera.rise_m(12.0, 0.25) == pytest.approx(12.0 / 0.0088 * 0.0088 * (1 - 0.25))
    assert camera.shot_spacing_m(12.0, 0.6) == pytest.approx(7.2)


def test_speed_is_limited_by_blur_or_by_the_shutter(camera):
    assert camera.speed_limit_mps(12.0, 0.0, 1.0) == pytest.approx(18.0 / 5472 / 0.0005)  # 6.6 m/s: blur
    assert camera.speed_limit_mps(12.0, 0.9, 1.0) == pytest.approx(1.8 / 0.7)  # the shutter


def test_blur_counts_on_the_finer_axis_and_ground_sampling_on_the_coarser(camera):
    oblong = dataclasses.replace(camera, image_px=(5472, 1824))
    assert oblong.gsd_m(12.0) == pytest.approx(12.0 / 1824)
    assert oblong.speed_limit_mps(12.0, 0.0, 1.0) == camera.speed_limit_mps(12.0, 0.0, 1.0)


@pytest.mark.parametrize("wrong", [{"focal_length_m": 0.0}, {"image_px": (5472, -1)}, {"exposure_s": 0.0}])
def test_an_impossible_camera_is_refused(camera, wrong):
    with pytest.raises(ValueError, match="positive"):
        dataclasses.replace(camera, **wrong)
