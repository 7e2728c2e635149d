"""Roofs of the gallery's missions: planned, judged, flown and told of."""

import itertools
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mavspiral import load_mission, plan, simulate
from mavspiral.deliver import write_plan
from mavspiral.export.check import check_file
from mavspiral.motion.trajectory import belongs

MISSIONS = Path(__file__).parents[3] / "missions"


def with_roof(name, **camera):
    mission = load_mission(MISSIONS / f"{name}.toml")
    return mission.model_copy(
        update={
            "inspection": mission.inspection.model_copy(update={"roof": True}),
            "camera": mission.camera.model_copy(update=camera),
        }
    )


@pytest.mark.parametrize(("name", "roofs"), [("asilo", 1), ("kiosk", 1), ("torre", 4)])
def test_the_gallerys_roofs_are_seen_when_asked(name, roofs):
    inspection = plan(with_roof(name))
    assert [each.kind for each in inspection.passes].count("roof") == roofs
    assert inspection.coverage.roof >= 0.95
    assert inspection.coverage.walls >= 0.99
    assert inspection.certificate.ok
    assert inspection.summary()["coverage"]["roof"] == round(inspection.coverage.roof, 4)


def test_a_camera_that_looks_straight_down_is_aimed_at_points_on_earth(tmp_path):
    inspection = plan(with_roof("asilo"))
    assert inspection.shots.pitch_rad.min() == pytest.approx(-np.pi / 2)
    path = Path(write_plan(inspection, tmp_path, inspection.summary())["plan"])
    document = json.loads(path.read_text())
    aims_m = [item["params"][6] for item in document["mission"]["items"] if item.get("command") == 195]
    assert -6500.0 < min(aims_m) < -1000.0
    assert check_file(path).ok


def test_the_church_is_seen_walls_and_roofs(planned):
    church = planned("church")
    assert church.mission.inspection.roof
    assert min(church.coverage.roof, church.coverage.walls) >= 0.99
    assert sum(each.kind == "roof" for each in church.passes) >= 3
    names = [each.leg.name for each in church.passes]
    assert not any(belongs(one, other) for one, other in itertools.permutations(names, 2))
    assert not any("ignored" in line for line in church.warnings)
    t_s = church.shots.t_s
    assert np.degrees(church.shots.pitch_rad).min() < -60.0
    for span_s in church.trajectory.spans_s("inspection-building"):
        assert (church.shots.pitch_rad[(t_s >= span_s[0]) & (t_s <= span_s[1])] == 0.0).all()


def test_the_church_is_flown_and_what_accept_asks_holds_for_roofs_too(planned):
    flight = simulate(planned("church"), seed=2)
    assert flight.passed, flight.failures
    more_than_all = flight.inspection.mission.accept.model_copy(update={"coverage": 1.5})
    mission = flight.inspection.mission.model_copy(update={"accept": more_than_all})
    stricter = replace(flight, inspection=replace(flight.inspection, mission=mission))
    assert any(line.startswith("[accept] coverage, roof:") for line in stricter.failures)


def test_a_camera_without_a_gimbal_sees_no_roof_and_it_is_said():
    inspection = plan(with_roof("kiosk", gimbal=False))
    assert [each.kind for each in inspection.passes] == ["spiral"]
    assert any("[camera] gimbal = true" in line for line in inspection.warnings)
    assert inspection.coverage.roof == 0.0
    assert any(line.startswith("unseen roof: ") for line in inspection.warnings)


def test_roofs_are_not_flown_unasked(planned):
    assert all(each.kind != "roof" for each in planned("kiosk").passes)
    assert (planned("kiosk").shots.pitch_rad == 0.0).all()


def test_no_way_above_the_church_s_roofs_is_curly(planned):
    for each in planned("church").passes:
        if each.kind == "roof":
            east, north = each.path(np.linspace(0.0, each.path.u_end_rad, 4000), 1)[:, :2].T
            turned_rad = np.abs(np.diff(np.unwrap(np.arctan2(north, east)))).sum()
            assert turned_rad < 2.0 * np.pi * 1.8, each.name  # once round, and the corners' overshoot
