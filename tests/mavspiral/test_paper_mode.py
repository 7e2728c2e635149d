"""[inspection] mode = "paper": the paper's curve through the same planner, judged by the same certificate."""

from __future__ import annotations

from pathlib import Path

import pytest

from mavspiral import load_mission, plan
from mavspiral.errors import InputError, LimitError

MISSIONS = Path(__file__).parents[2] / "missions"


def changed(tmp_path, name, *changes):
    text = (MISSIONS / f"{name}.toml").read_text().replace("maps/", f"{MISSIONS}/maps/")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / f"{name}.toml"
    path.write_text(text)
    return path


PAPER = ("[inspection]", '[inspection]\nmode = "paper"\nterms = 5')


def test_the_papers_curve_is_planned_judged_and_told_as_what_it_is(tmp_path):
    mission = load_mission(changed(tmp_path, "kiosk", PAPER, ("overlap = 0.25", "overlap = 0.75")))
    inspection = plan(mission)
    assert inspection.certificate.ok
    summary = inspection.summary()
    assert (summary["rings"], summary["harmonics"]) == (2, [5])
    told = " ".join(inspection.warnings)
    assert "2 rings of 5 harmonics as the paper has them" in told
    assert "from where the next one begins" in told


def test_a_ring_that_skims_a_set_back_is_refused_with_number_and_place(tmp_path):
    path = changed(tmp_path, "torre", PAPER, ("clearance_m = 4.0\nceiling", "clearance_m = 8.0\nceiling"))
    with pytest.raises(LimitError, match=r"clearance FAILS: 5\.\d+ m, allowed at least 8 m, at .* m up"):
        plan(load_mission(path))


def test_terms_without_the_papers_mode_are_refused(tmp_path):
    with pytest.raises(InputError, match='terms = 5 is for mode = "paper" alone'):
        load_mission(changed(tmp_path, "kiosk", ("[inspection]", "[inspection]\nterms = 5")))
