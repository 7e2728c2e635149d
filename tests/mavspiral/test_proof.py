"""A plan that fails its limits is refused with what would do."""

import re
from pathlib import Path

import pytest

from mavspiral import load_mission, plan, planner
from mavspiral.errors import LimitError

KIOSK = Path(__file__).parents[2] / "missions" / "kiosk.toml"


def test_a_refusal_for_clearance_names_the_clearance_that_the_plan_keeps(monkeypatch):
    mission, proof_of = load_mission(KIOSK), planner.proof_of
    kept_m = float(plan(mission).clearance.distance_m.min())
    monkeypatch.setattr(planner, "proof_of", lambda *args: proof_of(*args[:3], args[3] + 20.0))
    with pytest.raises(LimitError, match="clearance FAILS") as refusal:
        plan(mission)
    fits = re.search(r"Fix: a required clearance of ([\d.]+) m \(now ([\d.]+) m", str(refusal.value))
    assert fits
    assert kept_m - 0.1 <= float(fits[1]) <= kept_m < float(fits[2])
