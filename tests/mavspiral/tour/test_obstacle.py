"""What is too near is called by its kind or its name, with its place and its height."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from mavspiral.brief import map_request, with_keepouts
from mavspiral.mission import load_mission
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.shape.readers import read_site
from mavspiral.tour.obstacle import nearest_obstacle

KIOSK = Path(__file__).parents[3] / "missions" / "kiosk.toml"


@pytest.fixture(name="stage")
def fixture_stage():
    """The kiosk, a house of 5 m twenty metres north of it, and two keep-outs east and west."""
    mission = load_mission(KIOSK)
    raw = mission.model_dump(by_alias=True, mode="json")
    raw["keepout"] = [
        {"circle": [23.9605, 32.8677, 1.0], "height_m": [0.0, 15.0], "name": "tree"},
        {"circle": [23.9605, 32.8673, 1.0], "height_m": [0.0, 12.0]},
    ]
    mission = type(mission).model_validate(raw | {"path": KIOSK}, strict=False)
    site = with_keepouts(mission, read_site(map_request(mission)).site.padded(30.0))
    heights = site.heights.height_agl_m.copy()
    row, col = site.heights.index(np.array([0.0, 20.0]))
    heights[row : row + 8, col : col + 8] = 5.0
    changed = HeightMap(heights, site.heights.cell_m, site.heights.frame, site.heights.origin_enu_m)
    return mission, Site(changed, site.building)


@pytest.mark.parametrize(
    ("place", "name", "nearest"),
    [
        ((2.0, -3.0, 20.0), "the building", (2.0, -3.0)),
        ((16.0, 0.0, 8.0), 'keepout "tree"', (19.4, 0.0)),
        ((-16.0, 0.0, 8.0), "[[keepout]] 2", (-19.4, 0.0)),
        ((0.0, 30.0, 3.0), "something else on the map", (0.1, 22.0)),
    ],
)
def test_each_kind_of_obstacle_is_named_where_it_is_nearest(stage, place, name, nearest):
    told = nearest_obstacle(*stage, np.array(place))
    lat, lon = (float(word) for word in re.findall(r"(?:lat|lon) (\d+\.\d+)", told))
    assert told.startswith(f"{name} at lat")
    place_enu_m = stage[1].heights.frame.to_enu(lat, lon, stage[1].heights.frame.origin.alt_amsl_m)
    assert place_enu_m[:2] == pytest.approx(nearest, abs=0.4)


def test_a_way_is_judged_by_the_obstacle_that_it_ends_at(stage):
    start, sweep = np.array([0.0, 12.0, 10.0]), np.array([18.0, -12.0, 0.0])
    assert nearest_obstacle(*stage, start).startswith("the building")
    assert nearest_obstacle(*stage, start, sweep).startswith('keepout "tree"')
    assert nearest_obstacle(*stage, start, sweep).endswith("15.0 m high")
