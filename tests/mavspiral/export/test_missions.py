"""What the exporter promises of a mission: how near the curve it stays, where it looks, what it fits into."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from mavspiral.export.aiming import aim_over
from mavspiral.export.check import check_document
from mavspiral.export.corners import ACCEPTANCE_M, CUT_M, acceptance_m, cut_lines_m
from mavspiral.export.fences import exclusion_fences_enu_m, fence_enu_m, safe_area
from mavspiral.export.items import mission_items
from mavspiral.export.thinning import LEAD_S, Tolerance, thin
from mavspiral.frames import GeoPoint, LocalFrame, wrap_rad
from mavspiral.handover import inspection_documents, inspection_missions, mission_warnings
from mavspiral.mission import Mission
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.tour.sorties import OVERLAP_SHOTS_N


def changed(inspection, table, **values):
    part = getattr(inspection.mission, table).model_copy(update=values)
    return replace(inspection, mission=inspection.mission.model_copy(update={table: part}))


def commands(items):
    return [item.command for item in items]


@pytest.mark.parametrize("chord_m", [0.1, 0.35, 0.8])
def test_the_polygon_stays_within_the_stated_chord_error(planned, chord_m):
    trajectory = planned("kiosk").trajectory
    thinned = thin(trajectory, Tolerance(chord_m, np.radians(20.0)))
    dense = trajectory.sampled(0.05)
    leg = np.clip(np.searchsorted(thinned.t_s, dense.t_s, side="right") - 1, 0, len(thinned.t_s) - 2)
    a, b = thinned.position_enu_m[leg], thinned.position_enu_m[leg + 1]
    along = ((dense.position_enu_m - a) * (b - a)).sum(1) / np.maximum(((b - a) ** 2).sum(1), 1e-12)
    off = np.sqrt(((dense.position_enu_m - a - np.clip(along, 0, 1)[:, None] * (b - a)) ** 2).sum(1))
    assert off.max() <= thinned.chord_error_m + 0.02
    assert thinned.chord_error_m <= chord_m


def test_waypoints_beside_the_curve_are_fewer_than_on_it(planned):
    trajectory = planned("torre").trajectory
    beside = thin(trajectory, Tolerance(0.35, np.radians(30.0)))
    sides = np.diff(beside.position_enu_m, axis=0)
    assert beside.chord_error_m <= 0.35
    states = trajectory.sampled(0.1)
    away = min(
        np.sqrt(((states.position_enu_m - place) ** 2).sum(axis=1)).min()
        for place in beside.position_enu_m[5:-5]
    )
    assert away <= 0.35
    assert len(sides) < len(thin(trajectory, Tolerance(0.2, np.radians(30.0))).t_s)


@pytest.mark.parametrize("name", ["kiosk", "asilo"])
def test_the_aims_look_where_the_gaze_looks(planned, name):
    trajectory = planned(name).trajectory
    thinned = thin(trajectory, Tolerance(0.35, np.radians(12.0)))
    firsts = [first for first, _ in thinned.aims]
    dense = trajectory.sampled(0.1)
    waypoint = np.searchsorted(thinned.t_s, dense.t_s, side="right") - 1
    which = np.searchsorted(firsts, np.clip(waypoint, 0, len(thinned.t_s) - 2), side="right") - 1
    points = np.array([aim.point_enu_m for _, aim in thinned.aims])[which]
    way = points - dense.position_enu_m
    gaze = trajectory(dense.t_s + LEAD_S).yaw_enu_rad
    error = np.degrees(np.abs(wrap_rad(np.arctan2(way[:, 1], way[:, 0]) - gaze)))
    assert error.max() <= np.degrees(thinned.heading_error_rad) + 0.5
    assert thinned.heading_error_rad <= np.radians(12.0)
    assert len(thinned.aims) < 0.8 * len(thinned.t_s)


@pytest.mark.parametrize("name", ["kiosk", "asilo"])
def test_arducopter_turns_its_nose_evenly_from_waypoint_to_waypoint(planned, name):
    (sortie,) = inspection_missions(planned(name).flown_by("ardupilot")).sorties
    items, headings, held = sortie.fit.mission.items, [], False
    assert not {195, 197} & set(commands(items))
    for item in items:
        if item.command in (16, 22):
            held = False
            headings.append([item.t_s, headings[-1][1] if headings else np.nan])
        assert not held, "an item behind CONDITION_YAW, which would hold it up"
        if item.command == 115:
            held = True
            heading_deg, rate_dps, way, relative = item.params[:4]
            assert (way, relative, item.frame) == (0.0, 0.0, 2) and 0.0 <= heading_deg < 360.0
            headings[-1][1] = heading_deg
            headings[-1].append(rate_dps)
    begin_s, end_s = sortie.route.span_s("inspection")
    for here, then in pairwise(headings):
        gaze = 90.0 - np.degrees(sortie.route(min(then[0] + LEAD_S, sortie.route.duration_s)).yaw_enu_rad)
        assert abs((here[1] - gaze + 180.0) % 360.0 - 180.0) < 0.7
        if len(here) > 2 and begin_s < here[0] and then[0] < end_s:
            turned = np.degrees(np.ptp(sortie.route(np.array([here[0], then[0]]) + LEAD_S).yaw_enu_rad))
            assert here[2] <= turned / (then[0] - here[0]) + 1.0
            assert here[2] >= 0.5 * turned / (then[0] - here[0])


def test_where_turns_are_too_many_for_the_board_arducopter_keeps_points_in_view(planned):
    kiosk = planned("kiosk").flown_by("ardupilot")
    (whole,) = inspection_missions(kiosk).missions
    (fewer,) = inspection_missions(changed(kiosk, "vehicle", max_items=len(whole.items) - 5)).missions
    assert 115 in commands(whole.items) and 195 not in commands(whole.items)
    assert 195 in commands(fewer.items) and 115 not in commands(fewer.items)
    assert fewer.thinned.chord_error_m <= 0.35


def test_arducopters_gimbal_is_tilted_where_the_pitch_changes(planned):
    kiosk = planned("kiosk").flown_by("ardupilot")
    (mission,) = inspection_missions(kiosk).missions
    pitch_rad = np.where(np.arange(len(mission.thinned.t_s)) < 5, 0.0, np.radians(-30.0))

    def tilts(gimbal):
        made = mission_items(
            replace(mission.thinned, pitch_rad=pitch_rad),
            kiosk.site.heights.frame,
            kiosk.home_enu_m,
            autopilot="ardupilot",
            camera={},
            gimbal=gimbal,
        )
        numbers = np.cumsum([item.command in (16, 22) for item in made.items]) - 1
        return [
            (int(number), *item.params)
            for number, item in zip(numbers, made.items, strict=True)
            if item.command == 1000
        ]

    assert tilts(gimbal=True) == [(0, *(0.0,) * 7), (5, -30.0, *(0.0,) * 6)]
    assert tilts(gimbal=False) == []


def test_gazes_that_meet_have_their_meeting_point_for_an_aim(planned):
    states = planned("kiosk").trajectory.sampled(0.1)
    angle = np.linspace(0.0, 1.0, 40)
    circle = np.column_stack([6.0 * np.cos(angle), 6.0 * np.sin(angle), np.full(40, 5.0)])
    inward = replace(
        states,
        t_s=angle,
        position_enu_m=circle,
        yaw_enu_rad=angle + np.pi,
        gimbal_pitch_rad=np.zeros(40),
    )
    aim = aim_over(inward, 0, 39)
    assert aim.point_enu_m == pytest.approx([0.0, 0.0, 5.0], abs=1e-6)
    assert aim.error_rad < 1e-9
    outward = aim_over(replace(inward, yaw_enu_rad=angle.copy()), 0, 39)
    # They meet behind: straight ahead is the best there is.
    assert outward.error_rad == pytest.approx(0.5, abs=0.03)


def test_no_corner_is_cut_deeper_than_stated():
    square = np.array([[0.0, 0, 0], [20, 0, 0], [20, 20, 0], [20.0, 22, 0], [19, 40, 0]])
    radius_m = acceptance_m(square, CUT_M)
    assert radius_m[1] == pytest.approx(CUT_M / np.sin(np.pi / 4))
    assert radius_m[2] == pytest.approx(1.0)  # half way to the next
    assert radius_m[0] == ACCEPTANCE_M
    begin, sweep = cut_lines_m(square, radius_m)
    middle = begin[len(square) - 1] + 0.5 * sweep[len(square) - 1]
    assert np.hypot(*(middle - square[1])[:2]) == pytest.approx(CUT_M)


def test_the_trigger_decides_the_camera_items(planned):
    kiosk = planned("kiosk")
    shots = kiosk.shots

    def items(trigger):
        return inspection_missions(changed(kiosk, "camera", trigger=trigger)).missions[0].items

    by_time = items("camera")
    start, stop = commands(by_time).index(2000), commands(by_time).index(2001)
    assert start < stop
    interval_s = by_time[start].params[1]
    assert 0.7 <= interval_s <= np.diff(shots.t_s).min()
    assert by_time[start - 1].command in (16, 178, 195)
    assert commands(by_time).count(2000) == 1, "where the plan's intervals are alike, one does"
    by_distance = [item for item in items("distance") if item.command == 206]
    assert by_distance[0].params[0] > 0.0 == by_distance[1].params[0]
    single = [item for item in items("digicam") if item.command == 203]
    assert len(single) == len(shots)
    assert all(item.params[4] == 1.0 and item.frame == 2 for item in single)
    assert not {203, 206, 2000, 2001} & set(commands(items("none")))


def test_a_small_board_gets_a_coarser_mission_and_is_told_the_cost(planned):
    asilo = planned("asilo")
    whole = inspection_missions(asilo)
    tight = len(whole.missions[0].items) - 8
    coarse = inspection_missions(changed(asilo, "vehicle", max_items=tight))
    assert len(coarse.missions) == 1
    assert len(coarse.missions[0].items) <= tight
    assert coarse.missions[0].thinned.chord_error_m > whole.missions[0].thinned.chord_error_m
    assert mission_warnings(whole, 500) == ()
    (warning,) = mission_warnings(coarse, tight)
    assert f"max_items = {tight}" in warning
    assert f"{coarse.clearance_m:.2f} m of clearance" in warning


def test_a_tiny_board_gets_several_complete_sorties(planned):
    asilo = changed(planned("asilo"), "vehicle", max_items=30)
    assert len(asilo.sorties()) == 1, "streamed, the battery lasts"
    handover = inspection_missions(asilo)
    assert len(handover.missions) >= 2
    assert handover.refusals == ()
    assert handover.clearance_m >= asilo.clearance_required_m
    plans = inspection_documents(asilo, handover)
    for number, (mission, plan) in enumerate(zip(handover.missions, plans, strict=True), start=1):
        assert len(mission.items) <= 30
        kinds = commands(mission.items)
        assert (kinds[0], kinds[-2:]) == (22, [197, 20])
        assert kinds.count(2000) == kinds.count(2001) >= 1
        assert check_document(plan).errors == ()
        assert plan["mavspiral"]["sortie"] == [number, len(plans)]
        above_home = asilo.home_enu_m[:2]
        assert mission.thinned.position_enu_m[[0, -1], :2] == pytest.approx(np.tile(above_home, (2, 1)))
    spans_s = [plan["mavspiral"]["inspection_s"] for plan in plans]
    assert (spans_s[0][0], spans_s[-1][1]) == pytest.approx((0.0, asilo.duration_s), abs=1e-3)
    for (_, ended_s), (begins_s, _) in pairwise(spans_s):
        shared = (asilo.shots_s > begins_s - 0.05) & (asilo.shots_s < ended_s + 0.05)
        assert shared.sum() == OVERLAP_SHOTS_N + 1


def test_a_sortie_flies_the_same_curve_as_the_whole(planned):
    asilo = planned("asilo")
    curve = asilo.trajectory.sampled(0.05).position_enu_m
    for handed in inspection_missions(changed(asilo, "vehicle", max_items=30)).sorties:
        t_s = np.linspace(*handed.route.span_s("inspection"), 200)
        for place in handed.route(t_s).position_enu_m:
            assert np.sqrt(((curve - place) ** 2).sum(axis=1)).min() < 0.2


def test_an_endurance_that_forces_sorties_and_one_that_forbids_them(planned):
    """AUTO is 1.3 times as slow and takes off and lands for a minute: it needs more sorties than the stream."""
    short = changed(planned("kiosk"), "vehicle", endurance_s=130.0)
    handover = inspection_missions(short)
    assert len(handover.missions) > len(short.sorties()) == 1
    assert max(1.3 * handed.route.duration_s + 60.0 for handed in handover.sorties) <= 130.0
    none = inspection_missions(changed(planned("kiosk"), "vehicle", endurance_s=60.0))
    assert none.missions == ()
    (refusal,) = none.refusals
    assert "no .plan for the inspection from 0 to 62 of 62 s: [vehicle] endurance_s = 60" in refusal
    assert refusal in mission_warnings(none, 500)


def test_a_board_that_holds_next_to_nothing_gets_no_mission(planned):
    handover = inspection_missions(changed(planned("kiosk"), "vehicle", max_items=8))
    assert handover.missions == ()
    assert "[vehicle] max_items = 8: even in" in handover.refusals[0]


def test_chords_that_come_too_near_are_refused(planned):
    handover = inspection_missions(replace(planned("kiosk"), clearance_required_m=5.9))
    assert handover.missions == ()
    assert re.search(r"comes within .* 5\.90 m are required", handover.refusals[0])


def test_intervals_change_where_the_plans_do(planned):
    """Round the asilo a picture is due every 3.2 s, and every 0.7 s in the corner."""
    asilo = planned("asilo")
    mission = inspection_missions(asilo).missions[0]
    t_s, intervals_s, now = 0.0, [], None
    for item in mission.items:
        t_s = t_s if np.isnan(item.t_s) else item.t_s
        if item.command == 2000:
            now = (t_s, item.params[1])
        elif item.command == 2001:
            intervals_s.append((now[0], t_s, now[1]))
    assert 2 <= len(intervals_s) <= 4
    due_s = asilo.shots.t_s
    for begin_s, end_s, every_s in intervals_s:
        gaps_s = np.diff(due_s[(due_s >= begin_s) & (due_s <= end_s)])[1:-1]
        assert every_s <= gaps_s.min() + 0.01
    pictures = sum((end_s - begin_s) / every_s for begin_s, end_s, every_s in intervals_s)
    assert len(due_s) <= pictures <= 1.6 * len(due_s)


def test_our_own_plan_says_what_it_was_made_from_and_when_it_is_where(planned):
    kiosk = planned("kiosk")
    fit = inspection_missions(kiosk)
    (document,) = inspection_documents(kiosk, fit)
    plan = json.loads(json.dumps(document, allow_nan=False))
    notes = plan["mavspiral"]
    again = Mission.model_validate_json(json.dumps(notes["mission"]))
    assert again.model_copy(update={"path": kiosk.mission.path}) == kiosk.mission
    assert notes["sortie"] == [1, 1]
    for item, t_s in zip(plan["mission"]["items"], notes["item_t_s"], strict=True):
        assert (t_s is not None) == (item["command"] in (16, 22))
    placed_s = [t_s for t_s in notes["item_t_s"] if t_s is not None]
    assert placed_s == pytest.approx(fit.missions[0].thinned.t_s, abs=1e-3)


def test_the_fence_keeps_its_margin(planned):
    place = planned("kiosk").clearance.position_enu_m
    corners = fence_enu_m(place, 7.0)
    following = np.roll(corners, -1, axis=0)
    side = following - corners
    normal = np.column_stack([side[:, 1], -side[:, 0]]) / np.hypot(*side.T)[:, None]
    inward = -((place[None, ::20, :2] - corners[:, None]) * normal[:, None]).sum(axis=-1)
    assert inward.min() >= 7.0 - 1e-9
    assert inward.min() < 7.5


def test_exclusion_only_where_neither_flight_nor_return_comes_near():
    heights = np.zeros((200, 200))
    heights[60:70, 20:30] = 10.0  # beside the way
    heights[98:102, 90:100] = 10.0  # under the way home
    heights[140:150, 150:160] = 0.5  # a kerb
    heights[170:180, 190:199] = 20.0  # the building: nobody asks for a fence round it
    flat = HeightMap(heights, 0.5, LocalFrame(GeoPoint(0.0, 0.0, 0.0)), np.zeros(2))
    site = Site(flat, heights == 20.0)
    home = np.array([5.0, 50.0, 0.0])
    flown = np.column_stack([np.linspace(90.0, 95.0, 50), np.full(50, 50.0), np.full(50, 20.0)])
    inside = np.array([[0.0, 0.0], [99.0, 0.0], [99.0, 99.0], [0.0, 99.0]])
    flown = np.vstack([flown, [97.0, 87.0, 30.0]])
    polygons, omitted = exclusion_fences_enu_m(flown, site, home, inside, 4.0)
    assert omitted == pytest.approx(np.array([[45.25, 49.25, 10.0]]))
    (polygon,) = polygons
    assert polygon.min(axis=0) == pytest.approx([10.0, 30.0], abs=0.5)
    assert polygon.max(axis=0) == pytest.approx([15.0, 35.0], abs=0.5)
    told = safe_area(flown, site, home, margin_m=4.0, return_m=24.0).omitted
    assert told.startswith("no exclusion fence round an obstacle at lat 0.000445, lon 0.000406, 10.0 m high")
    assert told.endswith("Fix: a Return at 24 m or more")
    far = np.array([12.0, 10.0, 0.0])
    assert len(exclusion_fences_enu_m(flown[:-1], site, far, inside, 4.0)[1]) == 0
    assert safe_area(flown[:-1], site, far, margin_m=4.0, return_m=24.0).omitted is None
