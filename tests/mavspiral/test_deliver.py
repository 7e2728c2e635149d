"""The files of a real flight, where a disk does not take them."""

import json
from types import SimpleNamespace

from mavspiral.deliver import write_live
from mavspiral.files import write_text


def test_what_a_disk_does_not_take_is_warned_of_and_the_rest_is_written(planned, tmp_path):
    """A folder stands where the log should: as with a full disk, that file alone is missing."""
    (tmp_path / "kiosk.flight.npz" / "in the way").mkdir(parents=True)
    earlier = SimpleNamespace(save=lambda path: write_text(path, "rows"))
    broken = SimpleNamespace(save=lambda path: write_text(path, "rows"))
    flight = SimpleNamespace(
        inspection=planned("kiosk"),
        files={"tlog": "kiosk.tlog"},
        log=broken,
        shots=None,
        photo_numbers=(),
        earlier=(earlier,),
    )
    summary = {"passed": True, "warnings": ["left to inspect: all"]}
    files = write_live(flight, tmp_path, summary)
    assert list(files) == ["tlog", "fly_json", "npz_1"]
    left, lost = summary["warnings"]
    assert left == "left to inspect: all"
    assert lost.startswith(f"{tmp_path / 'kiosk.flight.npz'}: cannot be written (")
    assert json.loads((tmp_path / "kiosk.fly.json").read_text())["warnings"] == summary["warnings"]
