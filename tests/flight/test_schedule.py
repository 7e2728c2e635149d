import pytest

from mavspiral.flight.schedule import Schedule


def test_deadlines_are_absolute_and_missed_ones_are_dropped():
    schedule = Schedule(20_000)
    schedule.start(1000)
    calls = [1000, 5000, 20_999, 21_000, 43_000, 61_000, 200_500, 200_600, 201_000]
    assert [schedule.take(t) for t in calls] == [True, False, False, True, True, True, True, False, True]
    assert schedule.due_us == 221_000


def test_figures_leave_pauses_out():
    schedule = Schedule(20_000)
    assert schedule.figures.sent_n == 0 and schedule.figures.rate_hz == 0.0
    gaps = [schedule.sent(t) for t in (0, 20_000, 70_000)]
    schedule.paused()
    gaps += [schedule.sent(t) for t in (9_000_000, 9_010_000)]
    assert gaps == pytest.approx([0, 0.02, 0.05, 0, 0.01])
    figures = schedule.figures
    assert (figures.sent_n, figures.worst_gap_s) == (5, pytest.approx(0.05))
    assert figures.rate_hz == pytest.approx(3 / 0.08)
