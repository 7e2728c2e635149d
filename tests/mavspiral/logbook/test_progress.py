"""Going on where a journal ends: only with the plan that was flown, and only if something is left."""

from __future__ import annotations

import numpy as np
import pytest

from mavspiral.errors import InputError
from mavspiral.flight.flight_log import ROW_N
from mavspiral.flight.journal import JournalWriter
from mavspiral.logbook.progress import progress_of


def journal(path, inspection, to_s, *, digest=None, resumes=False, begin_s=0.0, shift_enu_m=None):
    """A flight of a sortie from `begin_s`, along it for `to_s`, written record by record."""
    sortie = inspection.sortie(begin_s, inspection.duration_s)
    facts = {"digest": digest or inspection.digest, "resumes": resumes, "begin_s": sortie.begin_s}
    data = bytearray()
    writer = JournalWriter(data.extend)
    writer.begin({**facts, "end_s": sortie.end_s})
    if shift_enu_m is not None:
        writer.aligned(shift_enu_m)
    origin = inspection.site.heights.frame.origin
    place = {
        "origin": [origin.lat_deg, origin.lon_deg, origin.alt_amsl_m],
        "legs": ["a"],
        "inspection_s": 7.0,
    }
    writer._json(b"P", place)
    rows = np.zeros((round(to_s * 50), ROW_N))
    rows[:, 3] = 7.0 + np.arange(len(rows)) / 50
    writer._record(b"R", rows.tobytes())
    with path.open("ab") as file:
        file.write(data)
    return sortie


def test_it_goes_on_where_the_path_time_ended(planned, tmp_path):
    kiosk = planned("kiosk")
    journal(tmp_path / "j", kiosk, 20.0)
    progress = progress_of(kiosk, tmp_path / "j")
    assert progress.done_s == pytest.approx(20.0, abs=0.03) and progress.flights_n == 1
    [(begin_s, end_s)] = progress.left_s
    assert 10.0 < begin_s < 20.0 and end_s == kiosk.duration_s
    sortie = journal(tmp_path / "j", kiosk, 15.0, resumes=True, begin_s=begin_s)
    progress = progress_of(kiosk, tmp_path / "j")
    assert progress.flights_n == 2
    assert progress.done_s == pytest.approx(float(sortie.inspection_s(15.0)), abs=0.03)
    assert progress.done_s > 20.0 and len(progress.shots) == 2


def test_a_fresh_beginning_counts_alone(planned, tmp_path):
    kiosk = planned("kiosk")
    journal(tmp_path / "j", kiosk, 20.0)
    journal(tmp_path / "j", kiosk, 5.0)
    progress = progress_of(kiosk, tmp_path / "j")
    assert progress.flights_n == 1 and progress.done_s == pytest.approx(5.0, abs=0.03)


def test_a_fresh_beginning_that_never_took_off_does_not_count(planned, tmp_path):
    kiosk = planned("kiosk")
    journal(tmp_path / "j", kiosk, 20.0)
    journal(tmp_path / "j", kiosk, 0.0)
    assert progress_of(kiosk, tmp_path / "j").done_s == pytest.approx(20.0, abs=0.03)


def test_a_changed_mission_refuses_to_resume(planned, tmp_path):
    journal(tmp_path / "j", planned("asilo"), 20.0)
    with pytest.raises(InputError, match="holds flights of another plan") as refusal:
        progress_of(planned("kiosk"), tmp_path / "j")
    assert "Fix:" in str(refusal.value) and "\n" not in str(refusal.value)


def test_what_is_finished_is_not_resumed(planned, tmp_path):
    kiosk = planned("kiosk")
    journal(tmp_path / "j", kiosk, kiosk.duration_s + 1.0)
    with pytest.raises(InputError, match="nothing is left to fly"):
        progress_of(kiosk, tmp_path / "j")


def test_an_alignment_is_kept_be_it_of_a_dry_run_and_the_log_is_of_the_plan_as_it_lay(planned, tmp_path):
    kiosk = planned("kiosk")
    shift_enu_m = np.array([2.0, -1.0, 0.0])
    journal(tmp_path / "j", kiosk, 20.0, shift_enu_m=shift_enu_m)
    progress = progress_of(kiosk, tmp_path / "j")
    assert np.array_equal(progress.shift_enu_m, shift_enu_m)
    # Its rows are at the vehicle's origin, which is the plan's: the plan that lies 2 m east has that 2 m to its west.
    assert progress.logs[0].estimate_position_enu_m[0] == pytest.approx(-shift_enu_m, abs=1e-3)
    journal(tmp_path / "j", kiosk, 0.0, shift_enu_m=-shift_enu_m)
    progress = progress_of(kiosk, tmp_path / "j")
    assert progress.done_s == pytest.approx(20.0, abs=0.03)
    assert np.array_equal(progress.shift_enu_m, -shift_enu_m)


def test_who_begins_afresh_without_alignment_resumes_without_it(planned, tmp_path):
    kiosk = planned("kiosk")
    journal(tmp_path / "j", kiosk, 20.0, shift_enu_m=np.array([2.0, -1.0, 0.0]))
    journal(tmp_path / "j", kiosk, 5.0)
    assert progress_of(kiosk, tmp_path / "j").shift_enu_m is None


def test_an_alignment_of_another_plan_is_refused(planned, tmp_path):
    journal(tmp_path / "j", planned("asilo"), 0.0, shift_enu_m=np.ones(3))
    with pytest.raises(InputError, match="holds flights of another plan"):
        progress_of(planned("kiosk"), tmp_path / "j")
