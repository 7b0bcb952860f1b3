"""Turns on circular arcs by brute force, from their definitions alone: it imports nothing of the package.

A path is a table of points; a chain is placed on it by walking back until a point is a bench's length away.
"""

from __future__ import annotations

import numpy as np

PITCH, RADIUS, MIN_RADIUS = 1.7, 4.5, 0.5
SPACINGS = (2.86, *[1.65] * 7)
# m between the points of the table; before the entry and behind the exit it reaches so far, and the head goes so far.
FINE, BEFORE, AFTER, BEYOND, EVERY = 0.004, 18.0, 9.0, 9.0, 0.04


def spiral_from_circle(length):
    """Points and headings of the outward spiral r = k theta from the circle on, (T,), by the trapezoid rule."""
    k = PITCH / (2 * np.pi)
    theta = np.linspace(RADIUS / k, (RADIUS + length / 3) / k, 40_001)
    rise = k * np.hypot(theta, 1)
    ways = np.concatenate([[0], np.cumsum((rise[1:] + rise[:-1]) / 2 * np.diff(theta))])
    theta = np.interp(np.arange(0, length, FINE), ways, theta)
    return k * theta * np.exp(1j * theta), theta + np.arctan(theta)


OUT, OUT_HEADINGS = spiral_from_circle(max(BEFORE, AFTER))
ENTRY, HEADING = OUT[0], OUT_HEADINGS[0] + np.pi


def arcs(x):
    """Ends (n + 1,) and headings there of arcs with curvatures and lengths `x` (2 n,) from the entry on."""
    points, headings = [ENTRY], [HEADING]
    for curvature, length in zip(*np.split(np.asarray(x), 2), strict=True):
        turned = curvature * length
        chord = length if turned == 0 else 2 / curvature * np.sin(turned / 2)
        points.append(points[-1] + chord * np.exp(1j * (headings[-1] + turned / 2)))
        headings.append(headings[-1] + turned)
    return np.array(points), np.array(headings)


def miss(x):
    """How far the arcs end from the exit, and by which angle they are off."""
    points, headings = arcs(x)
    off = points[-1] + ENTRY
    return np.array([off.real, off.imag, headings[-1] - HEADING])


def closed(x):
    """The nearest curvatures and lengths that lead to the exit, by Gauss-Newton steps; None if there are none near."""
    x = np.array(x, dtype=float)
    for _ in range(20):
        error = miss(x)
        if np.abs(error).max() < 1e-11:
            return x if x[x.size // 2 :].min() > 0.02 and np.abs(x[: x.size // 2]).max() <= 1 / MIN_RADIUS else None
        slopes = np.stack([(miss(x + 1e-7 * unit) - error) / 1e-7 for unit in np.eye(x.size)], axis=1)
        x = x - np.linalg.pinv(slopes) @ error
    return None


def largest_ratio(x):
    """Largest speed of a handle over the head's on a turn, seen every few centimetres; inf if it leaves the circle."""
    x = np.asarray(x)
    ends, starts = arcs(x)
    edges = np.concatenate([[0], np.cumsum(x[x.size // 2 :])])
    s = np.arange(0, edges[-1], FINE)
    k = np.searchsorted(edges, s, side="right") - 1
    turned = x[k] * (s - edges[k])
    inside = ends[k] + (s - edges[k]) * np.exp(1j * (starts[k] + turned / 2)) * np.sinc(turned / 2 / np.pi)
    if np.abs(inside).max() > RADIUS + 1e-9:
        return np.inf
    back, on = int(BEFORE / FINE), int(AFTER / FINE)
    points = np.concatenate([OUT[back:0:-1], inside, -OUT[:on]])
    headings = np.concatenate([OUT_HEADINGS[back:0:-1] + np.pi, starts[k] + turned, OUT_HEADINGS[:on] + np.pi])
    here = np.arange(back, points.size, int(EVERY / FINE))
    place, z, heading = here.astype(float), points[here], headings[here]
    speeds, largest = np.ones(here.size), 1.0
    for spacing in SPACINGS:
        index, walking = np.floor(place).astype(int), np.ones(here.size, dtype=bool)
        while walking.any():
            index[walking] -= 1
            if index.min() < 1:
                break
            walking &= np.abs(points[index] - z) < spacing
        known = index >= 1
        index = np.maximum(index, 0)
        far, near = np.abs(points[index] - z), np.abs(points[index + 1] - z)
        share = (spacing - near) / (far - near)
        place = index + 1 - share
        z_next = points[index + 1] + share * (points[index] - points[index + 1])
        turn = np.angle(np.exp(1j * (headings[index] - headings[index + 1])))
        heading_next = headings[index + 1] + share * turn
        bench = np.angle(z - z_next)
        front, rear = np.cos(heading - bench), np.cos(heading_next - bench)
        if min(front[known].min(), rear[known].min()) <= 0:
            return np.inf
        speeds = speeds * front / rear
        largest = max(largest, speeds[known].max())
        place, z, heading = place[known], z_next[known], heading_next[known]
        speeds = speeds[known]
        here = here[known]
    return float(largest)


def random_search(count, limit, trials, start=None, seed=1):
    """The shortest turn on `count` arcs that steps at random from a start find: its length, and the arcs."""
    rng = np.random.default_rng(seed)
    if start is None:
        # Two arcs of the same radius about the middle, as the contest's turn has for the ratio 1, cut into pieces.
        angle = np.arctan(2 * np.pi * RADIUS / PITCH)
        radius = RADIUS / 2 / np.sin(angle)
        pieces = np.array([count // 2 + 1, count // 2])
        curvatures = np.repeat([-1 / radius, 1 / radius], pieces)
        start = np.concatenate([curvatures, np.repeat(2 * angle * radius / pieces, pieces)])
    best, size = np.array(start), 0.1
    for _ in range(trials):
        step = rng.standard_normal(best.size) * (rng.random(best.size) < 0.5)
        x = closed(best + size * step)
        if x is not None and x[count:].sum() < best[count:].sum() and largest_ratio(x) <= limit:
            best, size = x, min(size * 2, 0.3)
        else:
            size = max(size * 0.97, 1e-3)
    return float(best[count:].sum()), best
