"""The hot loops of `timing`, as functions of bare arrays; its docstring has the method.

A `table` has one row per grid point of u, `du` apart: p′, p″, p‴ (three columns each), ψ′, ψ″.
`limits` has the order of `Limits`: speed, climb, descent, acceleration, jerk, yaw rate, yaw acceleration.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from mavspiral.arrays import FloatArray

__all__ = [
    "adjusted",
    "demand",
    "fastest_rates",
    "first_still",
    "knots",
    "level_hills",
    "over_time",
    "rate_caps",
    "rows",
    "time_grid",
    "way_along",
]

GAIN_SLOWER, GAIN_FASTER = 0.7, 0.3
NEARLY = 1.01
"""Where nothing asks for more than this, demand falls as slowness rises: all that is asked for is given at once."""


@njit(cache=True)
def rows(way: FloatArray, yaw: FloatArray) -> FloatArray:
    """The table of a way `(4, M, 3)` and a yaw `(3, M)` with their derivatives by u."""
    table = np.empty((way.shape[1], 11))
    for i in range(len(table)):
        for order in range(3):
            for axis in range(3):
                table[i, 3 * order + axis] = way[order + 1, i, axis]
        table[i, 9], table[i, 10] = yaw[1, i], yaw[2, i]
    return table


@njit(cache=True)
def first_still(table: FloatArray) -> int:
    """The first row with p′ = 0; beyond the last where there is none."""
    for i in range(len(table)):
        if table[i, 0] == 0.0 and table[i, 1] == 0.0 and table[i, 2] == 0.0:
            return i
    return len(table)


@njit(cache=True)
def way_along(table: FloatArray, du: float) -> tuple[FloatArray, FloatArray, bool]:
    """The pace |p′| at each row, the way from the first row to it, and whether the curve is a line at one pace."""
    n = len(table)
    pace, way = np.empty(n), np.empty(n)
    total, straight = 0.0, True
    for i in range(n):
        x, y, z = table[i, :3]
        pace[i] = math.sqrt(x * x + y * y + z * z)
        if i > 0:
            total += 0.5 * (pace[i] + pace[i - 1])
        way[i] = total * du
        for c in range(3, 9):
            straight = straight and table[i, c] == 0.0
    return pace, way, straight


@njit(cache=True)
def rate_caps(table: FloatArray, limits: FloatArray) -> FloatArray:
    """The largest u̇² at each row that is allowed together with some ü."""
    speed, climb, descent, acceleration, _, yaw_rate, yaw_acceleration = limits
    caps = np.empty(len(table))
    for i in range(len(table)):
        x1, y1, z1, x2, y2, z2, _, _, _, w1, w2 = table[i]
        metric = x1 * x1 + y1 * y1 + z1 * z1
        along = (x1 * x2 + y1 * y2 + z1 * z2) / metric
        bend = math.sqrt((x2 - along * x1) ** 2 + (y2 - along * y1) ** 2 + (z2 - along * z1) ** 2)
        swing = abs(w2 - along * w1)
        cap = speed * speed / metric
        if z1 != 0.0:
            cap = min(cap, ((climb if z1 > 0.0 else descent) / z1) ** 2)
        if w1 != 0.0:
            cap = min(cap, (yaw_rate / w1) ** 2)
        if bend > 0.0:
            cap = min(cap, acceleration / bend)
        if swing * cap > yaw_acceleration:
            # ü may help: swing·b = α + |ψ′|·√((A² - bend²·b²) / |p′|²), the larger root.
            help2 = w1 * w1 / metric
            square = swing * swing + help2 * bend * bend
            rest = yaw_acceleration**2 - help2 * acceleration**2
            root = (swing * yaw_acceleration) ** 2 - square * rest
            cap = min(cap, (swing * yaw_acceleration + math.sqrt(max(root, 0.0))) / square)
        caps[i] = cap
    return caps


@njit(cache=True)
def fastest_rates(
    table: FloatArray, du: float, caps: FloatArray, limits: FloatArray, slowness: FloatArray
) -> FloatArray:
    """The largest u̇ at each row, from rest to rest, without jerk: one pass back, one pass forth.

    Each row waits for its neighbour's b, so what does not depend on that is worked out apart: by Lagrange's identity
    both passes need no more of p′ and p″ than |p′ × p″|², and no division is waited for.
    """
    n = len(table)
    b = np.zeros(n)
    q = 0.5 / du
    for i in range(n - 2, 0, -1):  # the largest b from which some allowed a leads to b_{i+1} or below
        x1, y1, z1, x2, y2, z2, _, _, _, w1, w2 = table[i]
        ease = 1.0 / (slowness[i] * slowness[i])
        cap, most, most_yaw = caps[i] * ease, limits[3] * ease, limits[6] * ease
        cross2 = (y1 * z2 - z1 * y2) ** 2 + (z1 * x2 - x1 * z2) ** 2 + (x1 * y2 - y1 * x2) ** 2
        # On the line a = q·(b_{i+1} - b): |e·b + r·p′| ≤ A and |g·b + r·ψ′| ≤ α.
        ex, ey, ez, g = x2 - q * x1, y2 - q * y1, z2 - q * z1, w2 - q * w1
        ee, ep = ex * ex + ey * ey + ez * ez, ex * x1 + ey * y1 + ez * z1
        per_ee, per_g = 1.0 / ee, 1.0 / g if g != 0.0 else 0.0
        reach2 = ee * most * most
        r = q * b[i + 1]
        root = reach2 - r * r * cross2
        b[i] = cap  # if the line misses the allowed set, the set lies wholly below it
        if root >= 0.0:
            side = math.sqrt(root)
            low, high = (-r * ep - side) * per_ee, (-r * ep + side) * per_ee
            if g != 0.0:
                middle, half = -r * w1 * per_g, most_yaw * abs(per_g)
                low, high = max(low, middle - half), min(high, middle + half)
            if low <= high:
                b[i] = min(cap, high)
    b[0] = 0.0
    for i in range(n - 2):  # the largest allowed a that stays at or below it
        x1, y1, z1, x2, y2, z2, _, _, _, w1, w2 = table[i]
        ease = 1.0 / (slowness[i] * slowness[i])
        most, most_yaw = limits[3] * ease, limits[6] * ease
        metric, mixed = x1 * x1 + y1 * y1 + z1 * z1, x1 * x2 + y1 * y2 + z1 * z2
        cross2 = (y1 * z2 - z1 * y2) ** 2 + (z1 * x2 - x1 * z2) ** 2 + (x1 * y2 - y1 * x2) ** 2
        per_metric, reach2 = 1.0 / metric, metric * most * most
        a = (math.sqrt(max(reach2 - b[i] * b[i] * cross2, 0.0)) - mixed * b[i]) * per_metric
        if w1 != 0.0:
            a = min(a, most_yaw / abs(w1) - w2 / w1 * b[i])
        b[i + 1] = max(0.0, min(b[i + 1], b[i] + 2.0 * a * du))
    return np.sqrt(b)


@njit(cache=True)
def level_hills(speed: FloatArray, distance: FloatArray, window: float) -> FloatArray:
    """The speed with the top of each hill cut where it takes `window` seconds to cross."""
    level_ground = 1.0 + 1e-9
    v = speed.copy()
    n = len(v)
    i = 1
    while i < n - 1:
        if not (v[i] > v[i - 1] and v[i] >= v[i + 1]):
            i += 1
            continue
        left = right = i
        level = v[i]
        while left > 0 and right < n - 1 and distance[right] - distance[left] < level * window:
            step = max(v[left - 1], v[right + 1])
            if step == 0.0 or step > level * level_ground:  # rest, or a valley: beyond it rises a higher hill
                break
            if v[left - 1] >= v[right + 1]:
                left -= 1
            else:
                right += 1
            level = min(level, step)
        for j in range(left, right + 1):
            v[j] = min(v[j], level)
        i = max(right, i + 1)
    return v


@njit(cache=True)
def time_grid(rates: FloatArray, du: float) -> FloatArray:
    """When each row is reached, ü being constant between rows."""
    times = np.zeros(len(rates))
    for i in range(len(rates) - 1):
        times[i + 1] = times[i] + 2.0 * du / (rates[i] + rates[i + 1])
    return times


@njit(cache=True)
def knots(
    rates: FloatArray, times: FloatArray, steps: int, width: int, u_end: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The law u, u̇, ü at `steps + width + 1` knots: the running mean, over `width` steps, of u̇(t)."""
    dt = times[-1] / steps
    source = np.zeros(steps + 1 + 2 * width)  # at rest for one window before and after
    i = 0
    area = 0.0
    for k in range(1, steps):
        t = k * dt
        while times[i + 1] < t:
            i += 1
        source[width + k] = rates[i] + (rates[i + 1] - rates[i]) * (t - times[i]) / (times[i + 1] - times[i])
        area += source[width + k] * dt
    source *= u_end / area
    n = steps + width + 1
    u, u1, u2 = np.zeros(n), np.zeros(n), np.zeros(n)
    for k in range(1, n):
        u2[k] = (source[k + width] - source[k]) / (width * dt)
        u1[k] = u1[k - 1] + 0.5 * (u2[k] + u2[k - 1]) * dt
        u[k] = u[k - 1] + dt * (u1[k - 1] + dt * (2.0 * u2[k - 1] + u2[k]) / 6.0)
    u1[-1] = u2[-1] = 0.0
    return u * (u_end / u[-1]), u1, u2


@njit(cache=True)
def demand(
    table: FloatArray,
    du: float,
    limits: FloatArray,
    blur: FloatArray,
    dt: float,
    u: FloatArray,
    u1: FloatArray,
    u2: FloatArray,
) -> FloatArray:
    """How many times slower each knot would have to be passed to be within every limit.

    1 is just so. `blur` is 1/u̇ of the fastest way past each row for the sake of the pictures, or empty.
    """
    # A division takes as long as a dozen products.
    per_speed, per_climb, per_descent, per_acceleration, per_jerk, per_yaw_rate, per_bend = 1.0 / limits
    per_du, per_dt = 1.0 / du, 1.0 / dt
    ratios = np.empty(len(u))
    row = np.empty(11)
    before = 0.0
    for k in range(len(u)):
        x = u[k] * per_du
        i = min(max(int(x), 1), len(table) - 3)
        s = x - i
        # Cubic through four rows.
        c0, c3 = s * (s - 1.0) * (s - 2.0) * (-1.0 / 6.0), (s + 1.0) * s * (s - 1.0) * (1.0 / 6.0)
        c1, c2 = (s + 1.0) * (s - 1.0) * (s - 2.0) * 0.5, (s + 1.0) * s * (s - 2.0) * -0.5
        for c in range(11):
            row[c] = c0 * table[i - 1, c] + c1 * table[i, c] + c2 * table[i + 1, c] + c3 * table[i + 2, c]
        v, a = u1[k], u2[k]
        after = (u2[k + 1] - a) * per_dt if k < len(u) - 1 else 0.0
        v2, v3, va = v * v, v * v * v, 3.0 * v * a
        velocity2 = acceleration2 = jerk2_before = jerk2_after = 0.0
        for c in range(3):
            p1, p2, p3 = row[c], row[3 + c], row[6 + c]
            velocity2 += (p1 * v) ** 2
            acceleration2 += (p2 * v2 + p1 * a) ** 2
            steady = p3 * v3 + p2 * va
            jerk2_before += (steady + p1 * before) ** 2
            jerk2_after += (steady + p1 * after) ** 2
        before = after
        rise = row[2] * v
        rate = max(rise * per_climb, -rise * per_descent, abs(row[9] * v) * per_yaw_rate)
        if len(blur):
            j = min(int(x), len(blur) - 2)
            rate = max(rate, v * (blur[j] + (x - j) * (blur[j + 1] - blur[j])))
        # Squares are compared, for a root takes long and most are not wanted.
        first2 = max(velocity2 * (per_speed * per_speed), rate * rate)
        bend = abs(row[10] * v2 + row[9] * a) * per_bend
        ratio4 = max(first2 * first2, acceleration2 * (per_acceleration * per_acceleration), bend * bend)
        ratio = math.sqrt(math.sqrt(ratio4)) if ratio4 > first2 * first2 else math.sqrt(first2)
        third2 = max(jerk2_before, jerk2_after) * (per_jerk * per_jerk)
        if third2 > ratio4 * ratio * ratio:
            ratio = third2 ** (1.0 / 6.0)
        ratios[k] = ratio
    return ratios


@njit(cache=True)
def adjusted(
    slowness: FloatArray, times: FloatArray, ratios: FloatArray, dt: float, width: int
) -> FloatArray:
    """The slowness after the worst demand that each row had a part in; at least 1.

    A row passed at t before the mean has a part in the law from t to t + `width` steps. The worst of so many knots is that
    of the rest of one block and the beginning of the next (van Herk 1992; Gil and Werman 1993).
    """
    n, block = len(ratios), width + 2
    # The worst since its block began, and until it ends.
    since, until = np.zeros(n + block), np.zeros(n + block)
    since[:n] = ratios
    until[:n] = ratios
    for first in range(0, n, block):
        for k in range(first + 1, first + block):
            since[k] = max(since[k], since[k - 1])
        for k in range(first + block - 2, first - 1, -1):
            until[k] = max(until[k], until[k + 1])
    after = np.ones(len(slowness))
    nearly = ratios.max() <= NEARLY
    for i in range(len(slowness)):
        k = min(int(times[i] / dt), n - 1)
        ratio = max(until[k], since[k + block - 1])
        if ratio > 1.0:
            after[i] = slowness[i] * (ratio if nearly else ratio**GAIN_SLOWER)
        elif slowness[i] > 1.0:
            after[i] = max(1.0, slowness[i] * ratio**GAIN_FASTER)
    return after


@njit(cache=True)
def over_time(way: FloatArray, yaw: FloatArray, u1: FloatArray, u2: FloatArray, u3: FloatArray) -> None:
    """Turn derivatives by u, of a way `(4, M, 3)` and a yaw `(3, M)`, into derivatives by time: the chain rule."""
    for i in range(u1.size):
        v, a, j = u1[i], u2[i], u3[i]
        for axis in range(3):
            p1, p2, p3 = way[1, i, axis], way[2, i, axis], way[3, i, axis]
            way[1, i, axis] = p1 * v
            way[2, i, axis] = p2 * v * v + p1 * a
            way[3, i, axis] = p3 * v * v * v + 3.0 * p2 * v * a + p1 * j
        y1, y2 = yaw[1, i], yaw[2, i]
        yaw[1, i] = y1 * v
        yaw[2, i] = y2 * v * v + y1 * a
