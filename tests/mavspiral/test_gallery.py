"""The gallery's buildings of several parts: what is planned for each, and that it is seen."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from mavspiral.survey.solids import Solids

MISSIONS = sorted(path.stem for path in (Path(__file__).parents[2] / "missions").glob("*.toml"))
KINDS = {
    "podium": {"spiral": 3},
    "patio": {"courtyard": 1, "spiral": 1, "fill": 1},
    "terrace": {"facade": 2, "fill": 1},
    "slab": {"facade": 1, "spiral": 1, "fill": 3},
}


@pytest.mark.parametrize("name", KINDS)
def test_each_building_is_flown_in_its_pieces_and_seen_as_its_mission_asks(name, planned):
    inspection = planned(name)
    accept = inspection.mission.accept
    assert Counter(part.kind for part in inspection.passes) == KINDS[name]
    assert inspection.coverage.walls >= max(accept.coverage, 0.99 * inspection.coverage.walls_seeable)
    assert inspection.trajectory.duration_s < accept.duration_max_s
    place = inspection.trajectory.sampled(0.05).position_enu_m
    nearest_m = Solids.of_map(inspection.site.heights).distance_m(place).min()
    assert nearest_m >= max(accept.clearance_min_m, inspection.clearance_required_m)


@pytest.mark.parametrize("name", MISSIONS)
def test_every_limit_is_kept_on_a_grid_of_100_hz_and_nearly_used(name, planned):
    inspection = planned(name)
    limits, state = inspection.mission.limits, inspection.trajectory.sampled(0.01)
    yaw_rate_radps = np.radians(limits.yaw_rate_dps)
    climb_mps = state.velocity_enu_mps[:, 2]
    used = {
        "speed": np.linalg.norm(state.velocity_enu_mps, axis=1).max() / limits.speed_mps,
        "climb": climb_mps.max() / limits.climb_mps,
        "descent": -climb_mps.min() / limits.descent_mps,
        "acceleration": np.linalg.norm(state.acceleration_enu_mps2, axis=1).max() / limits.acceleration_mps2,
        "jerk": np.linalg.norm(state.jerk_enu_mps3, axis=1).max() / limits.jerk_mps3,
        "yaw rate": np.abs(state.yaw_rate_enu_radps).max() / yaw_rate_radps,
        "yaw acceleration": np.abs(state.yaw_acceleration_enu_radps2).max() / yaw_rate_radps,
        "gimbal": np.abs(np.gradient(state.gimbal_pitch_rad, state.t_s)).max() / np.radians(30.0),
        "blur": inspection.certificate["blur"].worst / inspection.mission.quality.blur_max_px,
    }
    assert all(share <= 1.0 + 1e-9 for share in used.values()), used
    assert used["speed"] > 0.999 and used["acceleration"] > 0.999 and used["jerk"] > 0.99


def test_the_podium_s_towers_begin_above_it_and_end_at_their_own_roofs(planned):
    heights = {
        part.name: part.path(np.linspace(0.0, part.path.u_end_rad, 999))[:, 2]
        for part in planned("podium").passes
    }
    assert set(heights) == {"podium", "tower 1", "tower 2"}
    assert heights["podium"].min() == 4.0 and heights["podium"].max() < 12.0
    tops = sorted(float(heights[name].max()) for name in ("tower 1", "tower 2"))
    assert tops == pytest.approx([20.0, 26.0])
    assert all(15.0 < heights[name].min() < 16.0 for name in ("tower 1", "tower 2"))


def test_the_slab_s_report_names_the_wall_that_no_drone_can_pass(planned):
    told = [line for line in planned("slab").warnings if line.startswith("no drone can pass the west side")]
    assert len(told) == 1
    assert "lat 40.0401" in told[0] or "lat 40.0402" in told[0]
    assert "for 23 m" in told[0] and "from 3.0 to 14.1 m up" in told[0]


@pytest.mark.parametrize(("name", "on_a_roof"), [("podium", True), ("torre", False)])
def test_a_flight_that_would_come_down_on_a_roof_without_a_position_says_so(planned, name, on_a_roof):
    told = [line for line in planned(name).warnings if "it would come down on" in line]
    assert len(told) == on_a_roof, told
