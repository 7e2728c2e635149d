"""The bar of a plan that takes long: on a terminal alone, and not before a second has passed."""

import threading
from pathlib import Path

import pytest

from mavspiral import load_mission, plan, terminal
from mavspiral.planner import STAGES
from mavspiral.terminal import stage_bar


@pytest.fixture
def on_a_terminal(monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")


def test_a_plan_tells_its_stages_in_order():
    stages = []
    inspection = plan(load_mission(Path(__file__).parents[2] / "missions" / "kiosk.toml"), stages.append)
    assert tuple(stages) == STAGES
    assert set(inspection.planning_ms) == {*STAGES, "total"}


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
        on_stage("map")
    assert ("planning" in capsys.readouterr().err) is shown


def test_there_is_no_bar_in_a_pipe(monkeypatch, capsys):
    monkeypatch.setattr(terminal, "PATIENCE_S", 0.0)
    with stage_bar(STAGES, as_json=False) as on_stage:
        on_stage("map")
    assert capsys.readouterr().err == ""
