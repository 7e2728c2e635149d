"""The greatest on the way, against the full motion at all of the times."""

import dataclasses

import numpy as np
import pytest

from mavspiral.curve.line import LinePath
from mavspiral.curve.meander import MeanderPath
from mavspiral.motion import trajectory as trajectories
from mavspiral.motion.limits import Limits
from mavspiral.motion.sight import Sight
from mavspiral.motion.timing import fastest_law
from mavspiral.motion.trajectory import Leg, Trajectory
from mavspiral.motion.turn import TurnGaze
from mavspiral.survey.peaks import QUANTITIES, peaks_of

LIMITS = Limits(5.0, 2.0, 1.5, 2.0, 4.0, 0.8, 1.0)


def leg(name, path, gaze, pitch, sight=None):
    law = fastest_law(path, gaze, LIMITS, sight=sight, pitch=pitch)
    return Leg(name, path, gaze, law, pitch, sight)


@pytest.fixture(scope="module")
def flight():
    """A way up, a winding one with a sight along which nose and camera turn, and a way down."""
    rng = np.random.default_rng(4)
    winding = MeanderPath(np.cumsum(rng.normal((1.5, 0.0, 0.1), (0.1, 0.4, 0.3), (40, 3)), axis=0))
    begin, end = winding(0.0), winding(winding.u_end_rad)
    up, down = LinePath([*begin[:2], -40.0], begin), LinePath(end, [*end[:2], -30.0])
    turn, tilt = TurnGaze(0.3, 2.0, winding.u_end_rad), TurnGaze(0.0, -0.7, winding.u_end_rad)
    return Trajectory(
        (
            leg("approach-1", up, TurnGaze(0.3, 0.3), TurnGaze(0.0, 0.0)),
            leg("inspection", winding, turn, tilt, Sight(8.0, 2.0)),
            leg("return-1", down, TurnGaze(2.0, 2.0), TurnGaze(-0.7, 0.0)),
        )
    )


def slow_columns(flight, t_s):
    """Every quantity at every time, from the states; the gimbal's by the chain rule on its own."""
    states = flight(t_s)
    climb = states.velocity_enu_mps[:, 2]
    tilting, passing = np.zeros(len(t_s)), np.zeros(len(t_s))
    for one in flight.legs:
        begin, end = flight.span_s(one.name)
        on = (t_s >= begin) & (t_s <= end)
        u, u1, *_ = one.law.derivatives(t_s[on] - begin)
        tilting[on] = one.gimbal_pitch(u, 1) * u1
        if one.sight is not None:
            yaw = np.stack([states.yaw_enu_rad[on], states.yaw_rate_enu_radps[on]])
            tilt = np.stack([states.gimbal_pitch_rad[on], tilting[on]])
            passing[on] = one.sight.passing(states.velocity_enu_mps[on], yaw, tilt)
    return {
        "speed": np.linalg.norm(states.velocity_enu_mps, axis=1),
        "climb": np.maximum(climb, 0.0),
        "descent": np.maximum(-climb, 0.0),
        "acceleration": np.linalg.norm(states.acceleration_enu_mps2, axis=1),
        "jerk": np.linalg.norm(states.jerk_enu_mps3, axis=1),
        "yaw rate": np.abs(states.yaw_rate_enu_radps),
        "yaw acceleration": np.abs(states.yaw_acceleration_enu_radps2),
        "passing": passing,
        "gimbal rate": np.abs(tilting),
        "height": states.position_enu_m[:, 2],
    }


@pytest.mark.parametrize("block", [100, 8192])
def test_no_moment_of_the_grid_is_left_out(flight, monkeypatch, block):
    monkeypatch.setattr(trajectories, "BLOCK", block)
    t_s = flight.grid_s(0.01)
    peaks = peaks_of(flight, t_s)
    assert len(peaks) > (3 if block == 100 else 2)
    slow = slow_columns(flight, t_s)
    assert set(slow) == set(QUANTITIES)
    for k, name in enumerate(QUANTITIES):
        at = int(np.argmax([each.greatest[k] for each in peaks]))
        assert peaks[at].greatest[k] == pytest.approx(slow[name].max(), rel=1e-12, abs=1e-12), name
        when = np.searchsorted(t_s, peaks[at].at_t_s[k])
        assert t_s[when] == peaks[at].at_t_s[k]
        assert slow[name][when] == pytest.approx(slow[name].max(), rel=1e-12, abs=1e-12), name
        np.testing.assert_allclose(flight(t_s[when]).position_enu_m, peaks[at].at_enu_m[k], atol=1e-9)


def test_one_moment_that_is_worse_is_found_wherever_it_is(flight):
    """A grid with one more moment, at the worst of a fine grid, shows the worst of the fine grid."""
    fine_s = flight.grid_s(0.0005)
    slow = slow_columns(flight, fine_s)
    for name in ("jerk", "yaw acceleration", "passing"):
        worst = int(np.argmax(slow[name]))
        t_s = np.sort(np.append(flight.grid_s(1.0), fine_s[worst]))
        found = max(each.greatest[QUANTITIES.index(name)] for each in peaks_of(flight, t_s))
        assert found == pytest.approx(slow[name][worst], rel=1e-12)


def test_what_is_not_a_number_is_never_passed_over(flight):
    @dataclasses.dataclass
    class Torn:
        """A curve whose third derivative is not a number at one place only."""

        whole: MeanderPath

        @property
        def u_end_rad(self):
            return self.whole.u_end_rad

        def __call__(self, u_rad, order=0):
            return self.whole(u_rad, order)

        def jet(self, u_rad):
            jet = self.whole.jet(u_rad)
            jet[3, len(jet[3]) // 2] = np.nan
            return jet

    torn = dataclasses.replace(flight.legs[1], path=Torn(flight.legs[1].path))
    alone = Trajectory((torn,))
    (peaks,) = peaks_of(alone, alone.grid_s(0.01))
    jerk = peaks.greatest[QUANTITIES.index("jerk")]
    assert np.isnan(jerk)
    assert np.isfinite(np.delete(peaks.greatest, QUANTITIES.index("jerk"))).all()
