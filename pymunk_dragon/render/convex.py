"""Convex shapes as lists of corners: clipped, moved inwards, rounded.

Everything that a physics engine draws is a convex polygon, a line or a point, grown by a radius. Coordinates are pixels
and may be as large as `MAX_REACH`; what comes out is as long as the part of it that can be seen needs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

__all__ = ["MAX_REACH", "Box", "Point", "clipped", "covers", "grown", "within"]

Point = tuple[float, float]
# Left, top, right, bottom.
Box = tuple[float, float, float, float]

# Pixels from the origin up to which doubles place a point to a thousandth of a pixel, rounded down to a power of ten.
MAX_REACH = 1e12
# Pixels that a chord may lie inside its arc: too little to be seen.
FLATNESS = 0.04
# Pixels of radius above which only the part of an arc that is seen is worth its chords.
LARGE_RADIUS = 500.0
# Pixels: corners nearer to each other than this are one.
SAME_CORNER = 1e-9


def within(points: Sequence[Point], radius: float, box: Box) -> bool:
    """Whether anything nearer than `radius` to `points` can lie in `box`; never where a number is nan or too large."""
    if not (0 <= radius < MAX_REACH and all(abs(x) < MAX_REACH and abs(y) < MAX_REACH for x, y in points)):
        return False
    xs, ys = [x for x, _ in points], [y for _, y in points]
    left, top, right, bottom = box
    return min(xs) - radius < right and max(xs) + radius > left and min(ys) - radius < bottom and max(ys) + radius > top


def clipped(points: list[Point], box: Box) -> list[Point]:
    """The part of a polygon that lies in `box`, perhaps empty."""
    left, top, right, bottom = box
    xs, ys = zip(*points, strict=True)
    for out, nx, ny, reach in (
        (min(xs) < left, -1, 0, -left),
        (max(xs) > right, 1, 0, right),
        (min(ys) < top, 0, -1, -top),
        (max(ys) > bottom, 0, 1, bottom),
    ):
        if out and points:
            points = _cut(points, nx, ny, reach)
    return points


def covers(points: list[Point], box: Box) -> bool:
    """Whether a polygon that was clipped to `box` is all of it."""
    left, top, right, bottom = box
    corners = {(left, top), (right, top), (right, bottom), (left, bottom)}
    return len(points) >= len(corners) and corners.issubset(points)


def grown(points: Sequence[Point], distance: float, box: Box) -> list[Point]:
    """The polygon around everything nearer than `distance` to a convex one, a line (2 points) or a point.

    With a negative distance the sides move inwards; the list is empty where nothing is left. Round corners are made of
    chords, fine only where they are seen in `box`.
    """
    corners = _proper(points)
    if distance < 0:
        return _shrunk(corners, -distance)
    if distance == 0:
        return corners
    if len(corners) == 1:
        return _arc(corners[0], distance, 0.0, math.tau, box)
    rim: list[Point] = []
    count = len(corners)
    headings = [_heading(corners[i], corners[(i + 1) % count]) for i in range(count)]
    for i, corner in enumerate(corners):
        turn = (headings[i] - headings[i - 1]) % math.tau
        # Rounding can make a straight corner turn back by a whole circle less 1e-16.
        turn = 0.0 if turn > 1.5 * math.pi else turn
        # The side before the corner has its outer normal a quarter turn clockwise.
        rim += _arc(corner, distance, headings[i - 1] - math.pi / 2, turn, box)
    return rim


def _heading(a: Point, b: Point) -> float:
    return math.atan2(b[1] - a[1], b[0] - a[0])


def _proper(points: Sequence[Point]) -> list[Point]:
    """Corners without repetitions, in the order in which headings grow."""
    corners: list[Point] = []
    for point in points:
        if not corners or math.dist(point, corners[-1]) > SAME_CORNER:
            corners.append(point)
    if len(corners) > 1 and math.dist(corners[0], corners[-1]) <= SAME_CORNER:
        corners.pop()
    area = sum(
        (x0 - corners[0][0]) * (y1 - corners[0][1]) - (x1 - corners[0][0]) * (y0 - corners[0][1])
        for (x0, y0), (x1, y1) in pairwise(corners)
    )
    return corners[::-1] if area < 0 else corners


def _shrunk(corners: list[Point], depth: float) -> list[Point]:
    """A polygon whose sides are all moved inwards."""
    if len(corners) < 3:
        return []
    polygon = corners
    for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True):
        length = math.hypot(x1 - x0, y1 - y0)
        nx, ny = (y1 - y0) / length, (x0 - x1) / length
        polygon = _cut(polygon, nx, ny, nx * x0 + ny * y0 - depth)
        if not polygon:
            return []
    return polygon


def _cut(points: list[Point], nx: float, ny: float, reach: float) -> list[Point]:
    """The part of a polygon where nx x + ny y is at most `reach` (Sutherland and Hodgman)."""
    kept: list[Point] = []
    x0, y0 = points[-1]
    over0 = nx * x0 + ny * y0 - reach
    for x1, y1 in points:
        over1 = nx * x1 + ny * y1 - reach
        if (over0 > 0) != (over1 > 0):
            share = over0 / (over0 - over1)
            x, y = x0 + share * (x1 - x0), y0 + share * (y1 - y0)
            # On a side of a box exactly, so that `covers` need not guess.
            kept.append((reach * nx if ny == 0 else x, reach * ny if nx == 0 else y))
        if over1 <= 0:
            kept.append((x1, y1))
        x0, y0, over0 = x1, y1, over1
    return kept


def _arc(centre: Point, radius: float, start: float, turn: float, box: Box) -> list[Point]:
    """Points on an arc, both ends included."""
    if radius > LARGE_RADIUS:
        angles = list(_seen_angles(centre, radius, start, turn, box))
    else:
        step = 2 * math.acos(max(0.0, 1 - FLATNESS / radius))
        pieces = max(1, math.ceil(turn / step))
        angles = [start + turn * i / pieces for i in range(pieces + 1)]
    x, y = centre
    return [(x + radius * math.cos(angle), y + radius * math.sin(angle)) for angle in angles]


def _seen_angles(centre: Point, radius: float, start: float, turn: float, box: Box) -> Iterator[float]:
    """Angles between which an arc is as good as straight, or out of sight with its chord and all between the two."""
    yield start
    todo = [(start, turn)]
    while todo:
        begin, angle = todo.pop()
        bow = radius * (1 - math.cos(angle / 2))
        if angle > math.pi / 2 or (bow > FLATNESS and within(_hull(centre, radius, begin, angle), 0, box)):
            todo += [(begin + angle / 2, angle / 2), (begin, angle / 2)]
        else:
            yield begin + angle


def _hull(centre: Point, radius: float, start: float, turn: float) -> list[Point]:
    """Triangle that holds an arc of at most a quarter circle: its ends, and where their tangents meet."""
    x, y = centre
    peak = radius / math.cos(turn / 2)
    return [
        (x + reach * math.cos(angle), y + reach * math.sin(angle))
        for reach, angle in ((radius, start), (peak, start + turn / 2), (radius, start + turn))
    ]
