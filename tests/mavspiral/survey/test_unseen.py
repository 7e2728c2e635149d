import math

import numpy as np

from mavspiral.shape.courts import enclosed_ground
from mavspiral.survey.coverage import Demand, measure_coverage
from mavspiral.survey.patches import patches_of
from mavspiral.survey.seeable import Room
from mavspiral.survey.unseen import unseen_lines

HOUSE = [(20, 20, 40, 30, 10)]


def lines(trial, camera, shots, demand, building=HOUSE, obstacles=(), narrow_m=5.0, roofs=False, closed=None):
    site = trial.site_of(building, obstacles)
    coverage = measure_coverage(patches_of(site), shots, site, camera, demand)
    return unseen_lines(
        coverage,
        shots,
        site,
        camera,
        narrow_m=narrow_m,
        room=Room(2.0, 2.0, 60.0),
        roofs=roofs,
        closed=np.zeros_like(site.building) if closed is None else closed(site.building),
    )


def all_round(trial, z, away=8):
    south = [(x, 20 - away, z, 90, 0) for x in np.arange(18, 43, 2.0)]
    north = [(x, 30 + away, z, -90, 0) for x in np.arange(18, 43, 2.0)]
    west = [(20 - away, y, z, 0, 0) for y in np.arange(18, 33, 2.0)]
    east = [(40 + away, y, z, 180, 0) for y in np.arange(18, 33, 2.0)]
    return trial.shots_at(*south, *north, *west, *east)


def test_a_fully_seen_house_says_nothing(trial, camera):
    demand = Demand(0.01, math.radians(60), 1)
    both = trial.shots_at(
        *[
            (*p, a, 0)
            for z in (3, 7)
            for p, a in zip(
                all_round(trial, z).position_enu_m, np.degrees(all_round(trial, z).yaw_enu_rad), strict=True
            )
        ]
    )
    assert lines(trial, camera, both, demand) == ()


def test_the_foot_below_the_pictures_is_named_with_its_height(trial, camera):
    (line,) = lines(trial, camera, all_round(trial, 7.0), Demand(0.01, math.radians(60), 1))
    assert (
        line
        == "unseen wall: 180 m² (30.0 %) below the pictures (the lowest shot is 7.0 m up); all sides, 0.0 to 3.0 m up"
    )


def test_a_hidden_half_and_a_side_that_nobody_flies(trial, camera):
    shots = trial.shots_at(*[(x, 10, 5, 90, 0) for x in np.arange(20, 41, 2.0)])
    found = lines(trial, camera, shots, Demand(0.01, math.radians(60), 1), obstacles=[(18, 15, 42, 16, 9)])
    assert any("hidden behind" in line and "south side" in line for line in found), found
    assert any("turned away" in line and "north, east and west" in line for line in found), found


def test_too_far_too_oblique_too_few_and_too_narrow(trial, camera):
    shots = all_round(trial, 5.0)
    assert "a pixel is more than 1.9 mm" in " ".join(lines(trial, camera, shots, Demand(0.0019, 1.0, 1)))
    assert "no shot comes within" in " ".join(lines(trial, camera, shots, Demand(0.0005, 1.0, 1)))
    assert "more than 3° from square" in " ".join(
        lines(trial, camera, shots, Demand(0.01, math.radians(3), 1))
    )
    assert "fewer than 50 shots" in " ".join(lines(trial, camera, shots, Demand(0.01, 1.0, 50)))
    slot = [(20, 20, 29, 30, 10), (31, 20, 40, 30, 10)]
    found = lines(trial, camera, shots, Demand(0.01, 1.0, 1), building=slot)
    assert any(
        "facing something 2 m away or more" in line
        and "where it is 5 m" in line
        and "east and west sides" in line
        for line in found
    ), found


def test_roofs_are_told_of_when_asked(trial, camera):
    shots, demand = all_round(trial, 5.0), Demand(0.01, 1.0, 1)
    assert not any("roof" in line for line in lines(trial, camera, shots, demand))
    assert "unseen roof: 200 m² (100.0 %)" in " ".join(lines(trial, camera, shots, demand, roofs=True))


def test_a_courtyard_that_nobody_asked_for_is_named(trial, camera):
    ring = [(20, 20, 40, 24, 10), (20, 36, 40, 40, 10), (20, 24, 24, 36, 10), (36, 24, 40, 36, 10)]
    shots, demand = all_round(trial, 5), Demand(0.01, math.radians(60), 1)
    told = lines(trial, camera, shots, demand, building=ring, closed=enclosed_ground)
    assert any("in a courtyard, which courtyards = false leaves alone; all sides" in line for line in told), (
        told
    )
    assert not any("courtyard" in line for line in lines(trial, camera, shots, demand, building=ring))
