from hypothesis import given, settings
from hypothesis import strategies as st

from mavspiral.flight import steering
from mavspiral.flight.governor import GovernorLimits, Pace

LIMITS = GovernorLimits(reserve_m=1.5)
steps = st.lists(
    st.tuples(st.floats(-0.1, 0.4), st.floats(0, 5), st.floats(0, 8)),  # vehicle time passed, error, speed
    max_size=200,
)


def wanted_rate(error_m):
    return steering.wanted_rate(error_m, LIMITS.slow_m, LIMITS.stop_m)


def advance(pace, dt_s, wanted, speed_mps):
    return Pace(*steering.paced(*pace, dt_s, wanted, speed_mps, LIMITS.brake_mps2, LIMITS.recover_mps2))


@given(steps)
@settings(max_examples=60, deadline=None)
def test_path_time_never_runs_back_and_never_ahead_of_the_vehicle(moves):
    pace, vehicle_s = Pace(), 0.0
    for dt_s, error_m, speed_mps in moves:
        after = advance(pace, dt_s, wanted_rate(error_m), speed_mps)
        vehicle_s += max(0.0, dt_s)
        assert pace.path_t_s <= after.path_t_s <= vehicle_s + 1e-9
        assert 0.0 <= after.rate <= 1.0
        pace = after


@given(steps, st.floats(1.2, 50), st.floats(0, 8))
@settings(max_examples=60, deadline=None)
def test_it_stands_still_within_the_braking_time_once_the_error_nears_the_reserve(moves, error_m, speed_mps):
    pace = Pace()
    for dt_s, small_m, speed in moves:
        pace = advance(pace, dt_s, wanted_rate(small_m / 10), speed)
    assert wanted_rate(error_m) < 1e-9  # 1.2 m is 0.8 of the reserve
    braking_s = max(speed_mps, 0.5) / LIMITS.brake_mps2
    for _ in range(int(braking_s / 0.02) + 2):
        pace = advance(pace, 0.02, wanted_rate(error_m), speed_mps)
    assert pace.rate < 1e-9
    assert advance(pace, 0.02, 0.0, speed_mps).path_t_s <= pace.path_t_s + 1e-9


def test_while_the_vehicle_keeps_up_the_rate_is_exactly_one():
    pace = Pace()
    for _ in range(5000):
        pace = advance(pace, 0.02, wanted_rate(0.59), 5.0)
        assert pace.rate == 1.0 and pace.rate_change_per_s == 0.0
    assert abs(pace.path_t_s - 100.0) < 1e-9


def test_less_error_is_never_slower():
    rates = [wanted_rate(error / 100) for error in range(300)]
    assert rates == sorted(rates, reverse=True)
    assert rates[60] == 1.0 and rates[120] < 1e-9 and 0.4 < rates[90] < 0.6


def test_it_catches_up_more_gently_than_it_brakes():
    braking = advance(Pace(), 0.02, 0.0, 4.0)
    recovering = advance(Pace(9.0, 0.0, 0.0), 0.02, 1.0, 4.0)
    assert abs(braking.rate_change_per_s * 4.0 + LIMITS.brake_mps2) < 1e-9
    assert abs(recovering.rate_change_per_s * 4.0 - LIMITS.recover_mps2) < 1e-9
    assert LIMITS.recover_mps2 < LIMITS.brake_mps2
