"""The map is off: without alignment the clearance suffers by as much, with it the true building is kept as planned."""

from __future__ import annotations

import numpy as np
import pytest
from lockstep import flown

from mavspiral.survey.solids import Solids

MAP_IS_OFF_M = np.array([1.9, -1.2, 0.0])
"""From where the map has things to where they truly stand."""


@pytest.fixture(scope="module")
def clearances_m(planned):
    """Of flights round the true building: of a true map, of one that is off, and of that one aligned."""
    kiosk = planned("kiosk")
    mapped = Solids.of_map(kiosk.site.heights)

    def nearest_m(off_m, align):
        """Positions are in the map's frame; a true place is `off_m` from its place on the map, the building too."""
        stands_enu_m = kiosk.home_enu_m + off_m  # the pilot stands where home truly is
        session, truth_enu_m = flown(
            kiosk, seed=5, stands_enu_m=stands_enu_m, align_at_enu_m=kiosk.home_enu_m if align else None
        )
        assert session.outcome.ok, session.outcome
        return mapped.distance_m(truth_enu_m - off_m).min()

    return nearest_m(np.zeros(3), False), nearest_m(MAP_IS_OFF_M, False), nearest_m(MAP_IS_OFF_M, True)


def test_aligned_the_true_building_is_kept_as_planned(clearances_m):
    true_map_m, _, aligned_m = clearances_m
    assert aligned_m == pytest.approx(true_map_m, abs=0.1)


def test_not_aligned_it_is_missed_by_the_maps_error(clearances_m):
    """Else the test above could not fail."""
    true_map_m, off_m, _ = clearances_m
    assert off_m < true_map_m - 1.0
