"""Every mission in missions/ plans, within its limits, and shows what it asks of its walls."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from mavspiral import load_mission, plan

MISSIONS = sorted((Path(__file__).parents[2] / "missions").glob("*.toml"))


@pytest.mark.parametrize("path", MISSIONS, ids=lambda path: path.stem)
def test_every_mission_plans_within_its_limits_and_shows_its_walls(path):
    mission = load_mission(path)
    assert mission.name == path.stem
    assert mission.accept.coverage is not None
    inspection = plan(mission)
    figures = inspection.certificate
    assert figures.ok
    for figure in figures.figures:
        if not figure.at_least:
            assert figure.worst <= figure.allowed * (1 + 1e-9), figure
    assert figures["clearance"].worst >= inspection.clearance_required_m
    assert inspection.coverage.walls >= mission.accept.coverage
    assert inspection.trajectory.duration_s <= mission.vehicle.endurance_s


@pytest.mark.parametrize("path", MISSIONS, ids=lambda path: path.stem)
def test_every_map_says_where_its_figures_come_from_and_how_exact_they_are(path):
    document = json.loads(load_mission(path).map_path.read_text(encoding="utf-8"))
    assert len(document["sources"]) > 20
    assert "rehearsal" in document["accuracy"]
