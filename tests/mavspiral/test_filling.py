"""Gaps of a plan: lines show what some safe pose could see and the passes do not, and only if that helps."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mavspiral import filling, load_mission, plan
from mavspiral.curve.stretch import Stretch
from mavspiral.errors import LimitError
from mavspiral.filling import filled
from mavspiral.inspection import Inspection
from mavspiral.mission import Keepout
from mavspiral.pieces.filler import Filler
from mavspiral.shape.courts import enclosed_ground
from mavspiral.survey.coverage import SEEABLE
from mavspiral.survey.shots import Shots
from mavspiral.survey.solids import Solids
from mavspiral.tour.route import ways_of

MISSIONS = Path(__file__).parents[2] / "missions"


def varied(name, **tables):
    """A mission of the gallery with some keys of its tables changed."""
    mission = load_mission(MISSIONS / f"{name}.toml")
    changed = {table: getattr(mission, table).model_copy(update=keys) for table, keys in tables.items()}
    return mission.model_copy(update=changed)


def unfilled(mission):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Filler, "pieces", lambda self, coverage, first, headway: ())
        return plan(mission)


@pytest.fixture(scope="module")
def terrace():
    """The terrace as its façades alone show it."""
    return unfilled(varied("terrace"))


def filled_anew(inspection, **asked):
    """The inspection filled as if its mission asked for something else."""
    mission = inspection.mission
    mission = mission.model_copy(update={"inspection": mission.inspection.model_copy(update=asked)})
    ways = ways_of(mission, inspection.site, inspection.clearance_required_m)
    return filled(replace(inspection, mission=mission, warnings=()), ways)


def taken(shots, rows):
    return Shots(shots.t_s[rows], shots.position_enu_m[rows], shots.yaw_enu_rad[rows], shots.pitch_rad[rows])


def fills(passes):
    return [part for part in passes if part.kind == "fill"]


def test_a_gap_goes_from_unseen_to_seen(terrace, planned):
    whole = planned("terrace")
    gap = ~terrace.coverage.seen & terrace.coverage.patches.is_wall
    assert (terrace.coverage.best_pose[gap] == SEEABLE).all()
    assert terrace.coverage.summary()["walls_of_seeable"] < 0.97
    assert whole.coverage.seen[gap].mean() > 0.95
    assert whole.coverage.seen[terrace.coverage.seen].all()
    assert any("seeable, not seen by this plan" in line for line in terrace.warnings)
    assert not any("seeable" in line for line in whole.warnings)
    # What the line is for, its own shots see, and they are its leg's.
    (line,) = fills(whole.passes)
    begin_s, end_s = whole.trajectory.span_s(line.leg.name)
    own = (whole.shots.t_s >= begin_s) & (whole.shots.t_s <= end_s)
    assert own.sum() >= 2
    shots = whole.coverage_from(taken(whole.shots, own))
    assert shots.seen[gap].mean() > 0.9


def test_a_filled_plan_keeps_all_that_a_plan_keeps(planned):
    whole = planned("slab")
    assert len(fills(whole.passes)) >= 2
    assert whole.certificate.ok
    place = whole.trajectory.sampled(0.05).position_enu_m
    nearest_m = Solids.of_map(whole.site.heights).distance_m(place).min()
    assert nearest_m >= whole.clearance_required_m
    names = [leg.name for leg in whole.trajectory.legs]
    assert len(set(names)) == len(names)
    assert sum(name.startswith("inspection-fill-") for name in names) == len(fills(whole.passes))
    assert "inspection" not in names


def test_the_foot_below_the_lowest_safe_height_is_seen_with_the_camera_tilted():
    """At 8 m up and 9 m off a level camera sees no lower than 5 m."""
    mission = varied("l_block", limits={"clearance_m": 8.0})
    level, tilted = unfilled(mission), plan(mission)
    assert level.coverage.walls < 0.85
    assert tilted.coverage.walls > 0.99
    assert all(part.path(0.0)[2] >= 8.0 - 1e-9 for part in tilted.passes)
    assert tilted.clearance.distance_m.min() >= 8.0
    assert min(float(part.leg.gimbal_pitch(0.0)) for part in fills(tilted.passes)) < -0.1


def test_a_band_that_is_unseen_all_round_gets_one_turn_with_the_camera_tilted():
    """At 13 m up and 14 m off the level camera sees the round silo down to 6 m; what can be seen ends at 4 m."""
    mission = varied("silo", limits={"clearance_m": 13.0})
    level, tilted = unfilled(mission), plan(mission)
    (turn,) = fills(tilted.passes)
    assert level.coverage.summary()["walls_of_seeable"] < 0.985
    assert tilted.coverage.summary()["walls_of_seeable"] > 0.999
    # Once round, level, at one tilt, looking at the silo's axis, and as far off as is asked.
    u = np.linspace(0.0, turn.path.u_end_rad, 100)
    place, yaw = turn.path(u), turn.leg.gaze(u)
    assert np.ptp(place[:, 2]) == 0.0 and np.ptp(turn.leg.gimbal_pitch(u)) == 0.0
    assert float(turn.leg.gimbal_pitch(0.0)) < -0.1
    assert yaw[-1] - yaw[0] == pytest.approx(2.0 * np.pi, abs=1e-3)
    middle = place[:-1].mean(axis=0)[:2]
    toward = np.arctan2(*(middle - place[:, :2]).T[::-1])
    assert np.abs(np.angle(np.exp(1j * (yaw - toward)))).max() < 0.02
    assert tilted.certificate.ok and tilted.clearance.distance_m.min() >= 13.0


def test_where_something_stands_in_the_turn_s_way_an_arc_of_it_is_flown():
    """A mast where the turn would pass: the rest of the band is seen from the rest of the turn."""
    mission = varied("silo", limits={"clearance_m": 13.0})
    free = plan(mission)
    (turn,) = fills(free.passes)
    place = free.site.heights.frame.geo_point(turn.path(1.0))
    mast = Keepout(circle=(place.lat_deg, place.lon_deg, 1.0), height_m=(0.0, 25.0))
    inspection = plan(mission.model_copy(update={"keepout": (mast,)}))
    (arc,) = fills(inspection.passes)
    assert isinstance(arc.path, Stretch) and 0.6 * turn.length_m < arc.length_m < turn.length_m
    assert inspection.coverage.summary()["walls_of_seeable"] > 0.99
    assert inspection.certificate.ok and inspection.clearance.distance_m.min() >= 13.0


def test_a_camera_without_a_gimbal_stays_level():
    inspection = plan(varied("terrace", camera={"gimbal": False}))
    assert (inspection.shots.pitch_rad == 0.0).all()
    before = unfilled(inspection.mission)
    assert inspection.coverage.walls >= before.coverage.walls
    assert before.coverage.walls_seeable == inspection.coverage.walls_seeable <= 1.0


def test_lines_stay_within_the_band_that_was_asked_for(terrace):
    high = fills(filled_anew(terrace).passes)
    assert max(part.path(0.0)[2] for part in high) > 9.0
    assert not fills(filled_anew(terrace, top_m=7.0).passes)


def test_the_paper_s_mode_is_left_as_it_is_and_still_told_what_could_be_seen(terrace):
    draft = filled_anew(terrace, mode="paper")
    assert draft.passes == terrace.passes
    assert draft.coverage.walls_seeable == terrace.coverage.walls_seeable == 1.0


@pytest.mark.parametrize("why", ["no way", "fails", "no help"])
def test_lines_that_do_not_help_are_not_flown(why, terrace, monkeypatch):
    def no_way(passes, ways):
        raise LimitError("no way between this and that")

    survey_of = filling.survey_of
    if why == "no way":
        monkeypatch.setattr(filling, "tour_of", no_way)
    if why == "fails":
        monkeypatch.setattr(type(terrace.certificate), "ok", property(lambda self: False))
    if why == "no help":  # lines that see nothing
        monkeypatch.setattr(
            filling,
            "survey_of",
            lambda mission, site, passes, trajectory, *rest: survey_of(
                mission, site, terrace.passes, terrace.trajectory, *rest
            ),
        )
    draft = filled_anew(terrace)
    assert not fills(draft.passes)
    assert len(draft.warnings) == (0 if why == "no help" else 1)
    assert all("not flown: a pass for what is unseen, from lat" in line for line in draft.warnings)


def test_one_bad_line_does_not_take_the_good_ones_along(monkeypatch):
    tour_of = filling.tour_of

    def no_way_to_the_second(passes, ways):
        if any(part.name == "fill 2" for part in passes):
            raise LimitError("no way between this and that")
        return tour_of(passes, ways)

    whole = plan(varied("slab"))
    monkeypatch.setattr(filling, "tour_of", no_way_to_the_second)
    without = plan(whole.mission)
    assert {part.name for part in fills(without.passes)} >= {
        part.name for part in fills(whole.passes) if part.name != "fill 2"
    }
    assert len(fills(whole.passes)) >= 2
    assert any("not flown: a pass" in line and "no way between this" in line for line in without.warnings)
    names = [part.name for part in without.passes]
    assert len(set(names)) == len(names)


def test_where_no_battery_lasts_for_the_lines_the_plan_without_them_is_flown(monkeypatch):
    sorties = Inspection.sorties

    def none_for_lines(self, *args, **more):
        if fills(self.passes):
            raise LimitError("[vehicle] endurance_s leaves nothing to inspect")
        return sorties(self, *args, **more)

    monkeypatch.setattr(Inspection, "sorties", none_for_lines)
    inspection = plan(varied("terrace"))
    assert not fills(inspection.passes)
    assert any("no battery lasts: [vehicle] endurance_s" in line for line in inspection.warnings)
    assert any("seeable, not seen by this plan" in line for line in inspection.warnings)
    monkeypatch.setattr(
        Inspection, "sorties", lambda self, *args, **more: (_ for _ in ()).throw(LimitError("none"))
    )
    with pytest.raises(LimitError, match="none"):
        plan(varied("terrace"))


def test_nobody_looks_into_a_courtyard_unasked(planned):
    """The court's walls are seeable all the same, and the plan says so."""
    mission = varied("patio", inspection={"courtyards": False})
    inspection = plan(mission)
    coverage = inspection.coverage
    assert coverage.walls < 0.85 and coverage.walls_seeable > 0.99
    court = enclosed_ground(inspection.site.building)
    place = inspection.trajectory.sampled(0.1).position_enu_m
    row, col = inspection.site.heights.index(place).T
    on_map = (row >= 0) & (row < court.shape[0]) & (col >= 0) & (col < court.shape[1])
    assert court.sum() * inspection.site.heights.cell_m**2 > 400
    assert place[on_map][court[row[on_map], col[on_map]], 2].min(initial=np.inf) > 12.0
    assert any("seeable, not seen by this plan" in line for line in inspection.warnings)
