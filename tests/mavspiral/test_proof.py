"""A plan that fails its limits is refused with what would do."""

import math
import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from mavspiral import load_mission, plan
from mavspiral.errors import LimitError
from mavspiral.mission import Keepout
from mavspiral.proof import judge_limits, judge_sight, proof_of
from mavspiral.survey.solids import Solids

KIOSK = Path(__file__).parents[2] / "missions" / "kiosk.toml"


def test_a_refusal_for_clearance_names_the_clearance_that_the_plan_keeps():
    inspection = plan(load_mission(KIOSK))
    kept_m, site, trajectory = inspection.clearance.nearest.distance_m, inspection.site, inspection.trajectory
    limits = inspection.mission.limits.model_copy(update={"clearance_m": kept_m + 20.0})
    mission = inspection.mission.model_copy(update={"limits": limits})
    _, certificate = proof_of(mission, Solids.of_map(site.heights), trajectory, kept_m + 20.0)
    with pytest.raises(LimitError, match="clearance FAILS") as refusal:
        judge_limits(mission, site, trajectory, certificate)
    fits = re.search(
        r"Fix: a required clearance of ([\d.]+) m \(now ([\d.]+) m\): \[limits\] clearance_m = ([\d.]+) is",
        str(refusal.value),
    )
    assert fits
    assert kept_m - 0.1 <= float(fits[1]) == float(fits[3]) <= kept_m < float(fits[2])


def test_no_clearance_of_nothing_is_recommended():
    mission = load_mission(KIOSK)
    asked = mission.inspection.model_copy(update={"mode": "paper"})
    crane = Keepout(circle=(23.9605, 32.8676, 2.0), height_m=(0.0, 40.0))  # on the paper's own ring
    with pytest.raises(LimitError, match=r"clearance FAILS: 0 m.*Fix: another standoff_m"):
        plan(mission.model_copy(update={"inspection": asked, "keepout": (crane,)}))


def test_a_refusal_for_the_ceiling_names_a_ceiling_that_does():
    """A roof is flown above the building, whatever its walls need; with the ceiling that is named, it is."""
    kiosk = load_mission(KIOSK)
    roof = kiosk.inspection.model_copy(update={"roof": True})
    camera = kiosk.camera.model_copy(update={"gimbal": True})

    def under(ceiling_m):
        limits = kiosk.limits.model_copy(update={"ceiling_m": ceiling_m})
        return kiosk.model_copy(update={"inspection": roof, "camera": camera, "limits": limits})

    flown_m = plan(under(60.0)).certificate["height"].worst
    with pytest.raises(LimitError, match="height FAILS") as refusal:
        plan(under(flown_m - 0.5))
    does = re.search(r"Fix: \[limits\] ceiling_m ≥ (\d+)", str(refusal.value))
    assert does
    assert plan(under(float(does[1]))).certificate.ok


def test_a_building_without_a_wall_of_its_own_is_refused_unless_its_roof_is_asked_for():
    mission, nothing = load_mission(KIOSK), SimpleNamespace(walls=math.nan)
    with pytest.raises(LimitError, match="no wall of its own"):
        judge_sight(mission, nothing)
    roof = mission.inspection.model_copy(update={"roof": True})
    judge_sight(mission.model_copy(update={"inspection": roof}), nothing)
