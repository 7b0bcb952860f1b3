"""Polygons for `ImageDraw` of lines that are equally thick at every angle.

`ImageDraw.line` has the same pixels for widths of 3, 4 and 5 at 45 degrees (Pillow 13.0). The
corners of `ImageDraw.polygon` are whole pixels too, but the distance between two edges can be
chosen. A polygon fills, in each row from its first corner to its last one, the pixels between two
edges and half a pixel more at either end; along a horizontal edge it fills the edge's row.
"""

import math
from collections.abc import Sequence
from typing import TypeVar

N = TypeVar("N", int, float)
Point = tuple[float, float]
Pixel = tuple[int, int]


def line(begin: Point, end: Point, width: float) -> list[Pixel]:
    """Corners of a line with square ends.

    They are begin and end of its right edge, and end and begin of its left one. The line's
    coordinates are 0.5 at the centre of the first pixel, and y points up for the names of the
    edges. Its length must not be 0.
    """
    length = math.dist(begin, end)
    x_across = width * (begin[1] - end[1]) / length
    y_across = width * (end[0] - begin[0]) / length
    across = x_across, y_across
    steep = abs(x_across) > abs(y_across)
    u, v = _turned(begin, steep)
    u_across, v_across = _turned(across, steep)
    slope = -u_across / v_across
    gap = math.copysign(_gap(slope, width, steep), v_across)
    right: list[Pixel] = []
    for point in (begin, end):
        along = round(_turned(point, steep)[0] - u_across / 2 - 0.5)
        height = v + slope * (along + 0.5 - u) - gap / 2
        right.append(_turned((along, round(height - 0.5)), steep))
    return [*right, *reversed(parallel(right, [across, across], width))]


def parallel(edge: Sequence[Pixel], across: Sequence[Point], width: float) -> list[Pixel]:
    """Second edge of a strip of a width, with `across` from each corner of the first edge to it.

    Rounding at the first corner is compensated at the second one: the mean thickness is within a
    quarter of a pixel.
    """
    (x, y), (x_end, y_end) = edge
    steep = abs(y_end - y) > abs(x_end - x)
    u, v = _turned(edge[0], steep)
    u_end, v_end = _turned(edge[1], steep)
    slope = (v_end - v) / (u_end - u) if u_end != u else 0.0
    u_across, v_across = _turned(across[0], steep)
    gap = math.copysign(_gap(slope, width, steep), v_across - slope * u_across)
    found: list[Pixel] = []
    rounded = 0.0
    for corner, vector in zip(edge, across, strict=True):
        along = round(_turned(corner, steep)[0] + _turned(vector, steep)[0])
        exact = v + slope * (along - u) + gap + rounded
        found.append(_turned((along, round(exact)), steep))
        rounded = exact - round(exact)
    return found


def _gap(slope: float, width: float, steep: bool) -> float:
    """Distance of the edges of a strip in y or, if it is steep, in x."""
    if steep:
        return width * math.hypot(1, slope) - 1
    # Two horizontal edges are whole pixels apart.
    return width * math.hypot(1, slope) - abs(slope) if slope else round(width) - 1


def _turned(pair: tuple[N, N], steep: bool) -> tuple[N, N]:
    """Pair of coordinates, of which the first is along the line: exchanged if it is steep."""
    first, second = pair
    return (second, first) if steep else pair
