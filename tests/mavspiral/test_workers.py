import os
import threading

import pytest

from mavspiral.workers import WORTH, by_stretches, workers


def test_stretches_cover_all_places_once_and_in_order():
    for places in (0, 1, WORTH, 40_001):
        rows = [row for stretch in by_stretches(lambda *ends: range(*ends), places) for row in stretch]
        assert rows == list(range(places))


def test_many_places_are_shared_by_the_workers_and_few_are_not_handed_over():
    together = threading.Barrier(2, timeout=20)  # broken, unless two are there at once
    by_stretches(lambda first, last: together.wait(), WORTH)
    assert by_stretches(lambda first, last: threading.current_thread(), WORTH - 1) == [
        threading.current_thread()
    ]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_forked_process_has_workers_of_its_own():
    assert workers().submit(os.getpid).result() == os.getpid()
    child = os.fork()
    if child == 0:
        os._exit(0 if workers().submit(os.getpid).result(timeout=20) == os.getpid() else 1)
    assert os.waitpid(child, 0)[1] == 0
