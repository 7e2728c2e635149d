"""How long the clients' tests wait for what is to come: only lest they hang, since no test is right or wrong by the clock."""

import time

LIMIT_S = 90.0


def eventually(ask, limit_s=LIMIT_S):
    """What `ask` says, as soon as it says anything."""
    deadline = time.monotonic() + limit_s
    while not (answer := ask()):
        assert time.monotonic() < deadline, f"not within {limit_s} s"
        time.sleep(0.02)
    return answer
