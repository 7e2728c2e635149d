"""One way through the air: loses MAVLink 2 frames, by a seed, and delays the others."""

import random


def frames_of(data):
    """Whole MAVLink 2 frames."""
    while data:
        size = data[1] + 12
        yield data[:size]
        data = data[size:]


class Air:
    """Loses the share `loss` of what it is given, and lets the rest out `delay_us` later."""

    def __init__(self, loss, seed=1, delay_us=0):
        self.loss, self.delay_us, self.random = loss, delay_us, random.Random(seed)
        self.lost_n, self.under_way = 0, []

    def carry(self, now_us, data):
        for frame in frames_of(data):
            if self.random.random() < self.loss:
                self.lost_n += 1
            else:
                self.under_way.append((now_us + self.delay_us, frame))
        out = b"".join(frame for due_us, frame in self.under_way if due_us <= now_us)
        self.under_way = [(due_us, frame) for due_us, frame in self.under_way if due_us > now_us]
        return out
