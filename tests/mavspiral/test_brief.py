"""A smaller clearance is advised by what governs it, and what is advised does it."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mavspiral.brief import budget_of, smaller_clearance
from mavspiral.mission import Mission

KEYS = {
    "clearance_m": r"\[limits\] clearance_m = ([\d.]+)",
    "map_error_m": r"\[building\] map_error_m = ([\d.]+)",
    "gps": r'\[vehicle\] gps = "(rtk)"',
}


def mission(clearance_m, map_error_m, gps, radius_m=0.4):
    document = {
        "schema": 1,
        "name": "a",
        "building": {"map": "a.npz", "map_error_m": map_error_m},
        "camera": {"focal_length_mm": 8.8, "sensor_mm": (13.2, 8.8)},
        "inspection": {"standoff_m": 100.0},
        "limits": {"clearance_m": clearance_m},
        "vehicle": {"gps": gps, "radius_m": radius_m},
    }
    return Mission.model_validate(document)


def required_m(asked):
    return budget_of(asked).required_m(asked.limits.clearance_m)


@given(
    st.floats(0.2, 20.0),
    st.floats(0.0, 5.0),
    st.sampled_from(["rtk", "standard"]),
    st.floats(0.05, 3.0),
    st.floats(0.05, 0.99),
)
def test_who_does_what_is_advised_gets_the_clearance_that_is_named(
    clearance_m, map_error_m, gps, radius_m, share
):
    before = mission(clearance_m, map_error_m, gps, radius_m)
    wanted_m = share * required_m(before)
    words = smaller_clearance(before, wanted_m)
    found = {key: re.search(pattern, words) for key, pattern in KEYS.items()}
    after = mission(
        float(found["clearance_m"][1]) if found["clearance_m"] else clearance_m,
        float(found["map_error_m"][1]) if found["map_error_m"] else map_error_m,
        found["gps"][1] if found["gps"] else gps,
        radius_m,
    )
    if words:
        named_m = float(re.match(r"a required clearance of ([\d.]+) m", words)[1])
        assert wanted_m - 0.1 <= named_m <= wanted_m + 1e-6
        assert required_m(after) <= named_m + 1e-6
    else:  # whatever is done
        assert required_m(mission(0.01, 0.0, "rtk", radius_m)) > wanted_m - 0.1


@pytest.mark.parametrize(
    ("asked", "wanted_m", "sets"),
    [
        ((4.0, 0.5, "rtk"), 3.0, "[limits] clearance_m = 3"),
        ((2.0, 2.0, "rtk"), 3.0, "[building] map_error_m = 0.85, if the map is so good"),
        (
            (2.0, 0.5, "standard"),
            3.0,
            '[vehicle] gps = "rtk", if it has that',
        ),
        (
            (4.0, 2.0, "rtk"),
            3.0,
            "[limits] clearance_m = 3 and [building] map_error_m = 0.85, if the map is so good",
        ),
    ],
)
def test_the_term_that_governs_is_named(asked, wanted_m, sets):
    assert smaller_clearance(mission(*asked), wanted_m).endswith(f" m): {sets}")


def test_nothing_is_advised_that_the_vehicle_alone_forbids():
    assert smaller_clearance(mission(4.0, 0.5, "rtk"), 0.6) == ""
