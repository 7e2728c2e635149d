import dataclasses

import numpy as np
import pytest

from mavspiral.curve.line import LinePath
from mavspiral.motion.limits import Limits
from mavspiral.motion.timing import fastest_law
from mavspiral.motion.trajectory import Leg, Trajectory
from mavspiral.motion.turn import TurnGaze
from mavspiral.survey.certificate import (
    Certificate,
    LimitFigure,
    ceiling_figure,
    clearance_figures,
    motion_figures,
)
from mavspiral.survey.clearance import Clearance, Nearest
from mavspiral.survey.peaks import peaks_of
from mavspiral.survey.solids import Solids

LIMITS = Limits(5.0, 2.0, 1.5, 2.0, 4.0, 0.8, 1.0)


@pytest.fixture
def flight():
    path, gaze = LinePath([0, 0, 10], [3, 4, 60]), TurnGaze(0.0, 2.0)
    return Trajectory((Leg("leg", path, gaze, fastest_law(path, gaze, LIMITS)),))


def peaks_on_grid(flight):
    return peaks_of(flight, flight.grid_s(0.01))


def downwards(flight):
    """The same way from its end to its beginning."""
    (leg,) = flight.legs
    path = LinePath(leg.path(1.0), leg.path(0.0))
    return Trajectory((dataclasses.replace(leg, path=path),))


def test_a_flight_within_its_limits_holds(flight):
    peaks = peaks_on_grid(flight)
    certificate = Certificate((*motion_figures(peaks, LIMITS), ceiling_figure(peaks, 60.0)))
    assert certificate.ok
    assert certificate.failures == ()
    assert [figure.name for figure in certificate.figures] == [
        "speed", "climb", "descent", "acceleration", "jerk", "yaw rate", "yaw acceleration", "height",
    ]  # fmt: skip
    assert certificate["climb"].worst == pytest.approx(2.0, rel=1e-3)
    assert certificate["descent"].worst == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("name", [field.name for field in dataclasses.fields(Limits)])
def test_each_limit_that_is_exceeded_fails_with_value_moment_and_place(flight, name):
    if name == "descent_mps":
        flight = downwards(flight)
    peaks = peaks_on_grid(flight)
    wide = dataclasses.replace(LIMITS, descent_mps=LIMITS.climb_mps)
    honest = {figure.name: figure for figure in motion_figures(peaks, wide)}
    quantity = name.rsplit("_", 1)[0].replace("_", " ")
    tight = dataclasses.replace(wide, **{name: honest[quantity].worst * (1 - 1e-6)})
    (failure,) = [figure for figure in motion_figures(peaks, tight) if not figure.ok]
    assert failure.name == quantity
    np.testing.assert_allclose(failure.at_enu_m, flight(failure.at_t_s).position_enu_m, atol=1e-9)
    (sentence,) = Certificate((failure,)).failures
    assert f"{quantity} FAILS" in sentence
    assert f"at {failure.at_t_s:.2f} s" in sentence


def test_rounding_is_forgiven_and_no_more():
    def figure(worst, at_least):
        return LimitFigure("clearance", "m", worst, 4.0, 0.0, (0.0, 0.0, 0.0), at_least)

    assert figure(4.0 * (1 + 9e-10), at_least=False).ok
    assert not figure(4.0 * (1 + 2e-9), at_least=False).ok
    assert figure(4.0 * (1 - 9e-10), at_least=True).ok
    assert not figure(4.0 * (1 - 2e-9), at_least=True).ok
    assert not figure(np.nan, at_least=True).ok
    assert not figure(np.nan, at_least=False).ok


def test_clearance_must_be_at_least_what_is_required():
    clearance = Clearance(
        t_s=np.arange(3.0),
        position_enu_m=np.eye(3),
        solids=Solids.of([[0.0]], 1.0, (0.0, 0.0)),
        nearest=Nearest(4.5, 2.0, (0.0, 0.0, 1.0)),
        straight_on=Nearest(0.2, 0.0, (1.0, 0.0, 0.0)),
    )
    near, ahead = clearance_figures(clearance, required_m=4.0, vehicle_radius_m=0.4)
    assert (near.worst, near.at_t_s, near.at_enu_m, near.ok) == (4.5, 2.0, (0.0, 0.0, 1.0), True)
    assert (ahead.worst, ahead.at_t_s, ahead.ok) == (0.2, 0.0, False)
    assert not clearance_figures(clearance, required_m=4.6, vehicle_radius_m=0.1)[0].ok


def test_a_figure_is_found_by_its_name(flight):
    with pytest.raises(KeyError, match="'warmth'"):
        Certificate(motion_figures(peaks_on_grid(flight), LIMITS))["warmth"]
