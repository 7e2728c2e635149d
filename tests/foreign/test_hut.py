from pathlib import Path

HERE = Path(__file__).parent


def test_the_hut_is_seen_and_not_touched(closed_loop):
    flight = closed_loop(HERE / "hut.toml", seed=2)
    assert flight.passed, flight.failures
