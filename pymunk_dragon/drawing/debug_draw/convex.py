"""Convex polygons as lists of corners: clipping, and offsetting inwards and outwards.

Every shape of a physics engine is a convex polygon, a line or a point, offset by a radius. Coordinates are pixels, at
most `MAX_REACH`. The number of corners in a result depends only on the part inside the visible box.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

# x and y, pixels.
Point = tuple[float, float]
# Left, top, right, bottom, pixels.
Box = tuple[float, float, float, float]

# Pixels: largest power of ten at which doubles resolve a thousandth of a pixel.
MAX_REACH = 1e12
# Pixels: largest distance between an arc and its chord, too small to be visible.
FLATNESS = 0.04
# Pixels: an arc with a larger radius is subdivided only where it is visible, to limit the number of chords.
LARGE_RADIUS = 500.0
# Pixels: corners closer to each other are merged, because the direction of so short a side is only rounding error.
SAME_CORNER = 1e-9


def within(points: Sequence[Point], radius: float, box: Box) -> bool:
    """Return whether a shape of `points`, offset by `radius`, can intersect `box`; False for nan and huge numbers."""
    if not (0 <= radius < MAX_REACH and all(abs(x) < MAX_REACH and abs(y) < MAX_REACH for x, y in points)):
        return False
    xs, ys = [x for x, _ in points], [y for _, y in points]
    left, top, right, bottom = box
    return min(xs) - radius < right and max(xs) + radius > left and min(ys) - radius < bottom and max(ys) + radius > top


def clipped(points: list[Point], box: Box) -> list[Point]:
    """Return the part of a polygon inside `box`, which may be empty."""
    left, top, right, bottom = box
    xs, ys = zip(*points, strict=True)
    for outside, nx, ny, limit in (
        (min(xs) < left, -1, 0, -left),
        (max(xs) > right, 1, 0, right),
        (min(ys) < top, 0, -1, -top),
        (max(ys) > bottom, 0, 1, bottom),
    ):
        if outside and points:
            points = _clip(points, nx, ny, limit)
    return points


def covers(points: list[Point], box: Box) -> bool:
    """Return whether a polygon that was clipped to `box` fills it."""
    left, top, right, bottom = box
    corners = {(left, top), (right, top), (right, bottom), (left, bottom)}
    return len(points) >= len(corners) and corners.issubset(points)


def offset_polygon(points: Sequence[Point], distance: float, box: Box) -> list[Point]:
    """Return the offset polygon at `distance`, pixels, from a convex polygon, a line (2 points) or a point.

    A negative distance moves the sides inwards; the result may then be empty. Round corners are approximated by chords,
    which are short only inside `box`.
    """
    corners = _ordered_corners(points)
    if distance < 0:
        return _inset_polygon(corners, -distance)
    if distance == 0:
        return corners
    if len(corners) == 1:
        return _arc(corners[0], distance, 0.0, math.tau, box)
    outline: list[Point] = []
    count = len(corners)
    headings = [_heading(corners[i], corners[(i + 1) % count]) for i in range(count)]
    for i, corner in enumerate(corners):
        turn = (headings[i] - headings[i - 1]) % math.tau
        # At a straight corner, rounding can give an angle just below a full circle.
        turn = 0.0 if turn > 1.5 * math.pi else turn
        # The outer normal of a side is a quarter turn clockwise from its heading.
        outline += _arc(corner, distance, headings[i - 1] - math.pi / 2, turn, box)
    return outline


def _heading(a: Point, b: Point) -> float:
    return math.atan2(b[1] - a[1], b[0] - a[0])


def _ordered_corners(points: Sequence[Point]) -> list[Point]:
    """Return the corners without duplicates, in the order of increasing heading."""
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


def _inset_polygon(corners: list[Point], depth: float) -> list[Point]:
    """Return a polygon with all sides moved inwards by `depth`."""
    if len(corners) < 3:
        return []
    polygon = corners
    for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True):
        length = math.hypot(x1 - x0, y1 - y0)
        nx, ny = (y1 - y0) / length, (x0 - x1) / length
        polygon = _clip(polygon, nx, ny, nx * x0 + ny * y0 - depth)
        if not polygon:
            return []
    return polygon


def _clip(points: list[Point], nx: float, ny: float, limit: float) -> list[Point]:
    """Return the part of a polygon where nx x + ny y is at most `limit` (Sutherland and Hodgman)."""
    kept: list[Point] = []
    x0, y0 = points[-1]
    over0 = nx * x0 + ny * y0 - limit
    for x1, y1 in points:
        over1 = nx * x1 + ny * y1 - limit
        if (over0 > 0) != (over1 > 0):
            share = over0 / (over0 - over1)
            x, y = x0 + share * (x1 - x0), y0 + share * (y1 - y0)
            # Exactly on a side of an upright box, so that `covers` can compare corners exactly.
            kept.append((limit * nx if ny == 0 else x, limit * ny if nx == 0 else y))
        if over1 <= 0:
            kept.append((x1, y1))
        x0, y0, over0 = x1, y1, over1
    return kept


def _arc(centre: Point, radius: float, start: float, turn: float, box: Box) -> list[Point]:
    """Return points on an arc, including both ends."""
    if radius > LARGE_RADIUS:
        angles = list(_visible_angles(centre, radius, start, turn, box))
    else:
        step = 2 * math.acos(max(0.0, 1 - FLATNESS / radius))
        pieces = max(1, math.ceil(turn / step))
        angles = [start + turn * i / pieces for i in range(pieces + 1)]
    x, y = centre
    return [(x + radius * math.cos(angle), y + radius * math.sin(angle)) for angle in angles]


def _visible_angles(centre: Point, radius: float, start: float, turn: float, box: Box) -> Iterator[float]:
    """Yield angles that divide an arc into pieces that are flat within `FLATNESS`, or outside `box`."""
    yield start
    todo = [(start, turn)]
    while todo:
        begin, angle = todo.pop()
        bow = radius * (1 - math.cos(angle / 2))
        if angle > math.pi / 2 or (bow > FLATNESS and within(_bounding_triangle(centre, radius, begin, angle), 0, box)):
            todo += [(begin + angle / 2, angle / 2), (begin, angle / 2)]
        else:
            yield begin + angle


def _bounding_triangle(centre: Point, radius: float, start: float, turn: float) -> list[Point]:
    """Return a triangle that contains an arc of at most a quarter circle: its ends and the tangents' intersection."""
    x, y = centre
    peak = radius / math.cos(turn / 2)
    return [
        (x + reach * math.cos(angle), y + reach * math.sin(angle))
        for reach, angle in ((radius, start), (peak, start + turn / 2), (radius, start + turn))
    ]
