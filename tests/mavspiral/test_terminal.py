"""The bar of a plan that takes long: on a terminal alone, and not before a second has passed."""

import threading
from pathlib import Path

import pytest
from rich.progress import Progress

from mavspiral import load_mission, plan, terminal
from mavspiral.planner import STAGES
from mavspiral.terminal import stage_bar


@pytest.fixture
def on_a_terminal(monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")


@pytest.mark.parametrize("changes", [{}, {"clearance_m": 5.0}])  # without gaps, and with some to fill
def test_a_plan_tells_its_stages_in_order_and_moves_within_the_last(changes):
    told = []
    mission = load_mission(Path(__file__).parents[2] / "missions" / "kiosk.toml")
    mission = mission.model_copy(update={"limits": mission.limits.model_copy(update=changes)})
    inspection = plan(mission, lambda stage, share: told.append((stage, share)))
    assert tuple(stage for stage, share in told if share == 1.0) == STAGES
    assert set(inspection.planning_ms) == {*STAGES, "total"}
    shares = [share for stage, share in told if stage == "coverage"]
    assert shares == sorted(shares)
    assert len(shares) > 15
    assert told[-1] == ("coverage", 1.0)


@pytest.mark.parametrize(
    ("patience_s", "as_json", "shown"), [(0.0, False, True), (99.0, False, False), (0.0, True, False)]
)
def test_the_bar_comes_only_to_who_waits(on_a_terminal, monkeypatch, capsys, patience_s, as_json, shown):
    monkeypatch.setattr(terminal, "PATIENCE_S", patience_s)
    with stage_bar(STAGES, as_json) as on_stage:
        if shown:
            for late in threading.enumerate():  # or it has been and gone
                if isinstance(late, threading.Timer):
                    late.join()
        on_stage("map", 1.0)
    assert ("planning" in capsys.readouterr().err) is shown


def test_there_is_no_bar_in_a_pipe(monkeypatch, capsys):
    monkeypatch.setattr(terminal, "PATIENCE_S", 0.0)
    with stage_bar(STAGES, as_json=False) as on_stage:
        on_stage("map", 1.0)
    assert capsys.readouterr().err == ""


def test_the_bar_moves_within_the_last_stage_and_goes_when_that_is_done(on_a_terminal, monkeypatch, capsys):
    monkeypatch.setattr(terminal, "PATIENCE_S", 0.0)
    made = []
    real = Progress.update
    monkeypatch.setattr(
        Progress, "update", lambda self, *a, **k: (made.append(k["completed"]), real(self, *a, **k))
    )
    with stage_bar(("map", "curve", "coverage"), as_json=False) as on_stage:
        for stage, share in (("map", 1.0), ("curve", 1.0), ("coverage", 0.5), ("coverage", 1.0)):
            on_stage(stage, share)
        capsys.readouterr()
        assert not [thread for thread in threading.enumerate() if isinstance(thread, threading.Timer)]
    assert made == [1.0, 2.0, 3.0, 4.0]
    assert capsys.readouterr().err == ""
