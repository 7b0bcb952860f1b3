"""Triangles between the points of a map, divided where two of their corners belong to different classes.

A quantity is smooth within a class and may jump between classes. So a triangle with corners of one class is kept, and
any other triangle is divided into pieces of one class each. Every piece has corners of its own, whose values follow
from points of that class only: nothing is interpolated across a jump.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pymunk_dragon._arrays import Array, Flags, Indices

# Area of a triangle, as a share of the map, below which rounding of collinear points has made the triangle.
MIN_AREA = 1e-10
# Singular values of a point's edges, relative to the largest one, below which they have a single direction.
ONE_DIRECTION = 0.05
# Number of an edge: its smaller end times this, and its larger end. More points than any map has.
EDGE_BASE = 1 << 31
# Largest angle, degrees, of triangles at the border: flatter ones connect samples at the border with distant ones.
MAX_ANGLE = 165.0
# Distance, as a share of the map's side, between corners that coincide except for rounding.
ROUNDING = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class Pieces:
    """Triangles of one class each, and the lines between the classes.

    Attributes
    ----------
    points : ndarray, shape (K, 2)
        Corners of triangles.
    values : ndarray, shape (K,)
        Values at the corners: those of points, and between two classes their linear continuation within each class.
    source : ndarray of int, shape (K,)
        For each corner, the point of the map that gives its class.
    triangles : ndarray of int, shape (M, 3)
        Corners of each triangle, counter-clockwise; all three have the same class.
    jumps, border : ndarray, shape (S, 2, 2)
        Line segments between two classes, and around all triangles.
    """

    points: Array
    values: Array
    source: Indices
    triangles: Indices
    jumps: Array
    border: Array

    @cached_property
    def owners(self) -> Indices:
        """For each triangle, a point of the map that gives its class, (M,)."""
        return self.source[self.triangles[:, 0]]

    @cached_property
    def middles(self) -> Array:
        """Centroids of the triangles, (M, 2)."""
        middles: Array = self.points[self.triangles].mean(axis=1)
        return middles

    @cached_property
    def areas(self) -> Array:
        """Areas of the triangles, (M,)."""
        return _areas(self.points, self.triangles)

    def moved(self, offset: Array, scale: Array) -> Pieces:
        """The same in other coordinates, after `scale` and then `offset` (2,)."""
        points, jumps, border = (offset + scale * each for each in (self.points, self.jumps, self.border))
        return replace(self, points=points, jumps=jumps, border=border)


def pieces(points: Array, classes: Indices, values: Array) -> Pieces | None:
    """Delaunay triangles of distinct `points` (P, 2), divided by their classes; None if all points are on a line.

    `values` are finite for all points of a class, or for none.
    """
    triangles = _delaunay(points)
    if triangles is None:
        return None
    triangles = _with_better_diagonals(points, triangles, classes, values)
    edges, count = np.unique(_edges(triangles), return_counts=True)
    border = points[np.stack(np.divmod(edges[count == 1], EDGE_BASE), axis=1)]
    same = classes[triangles] == classes[np.roll(triangles, -1, axis=1)]  # corners 0 and 1, 1 and 2, 2 and 0
    nodes = _Nodes(points, triangles)
    parts, jumps = [triangles[same.all(axis=1)]], []
    for k in range(3):
        # Corner k differs from the other two, which agree: a straight cut between the middles of two edges.
        cut = np.flatnonzero(same[:, (k + 1) % 3] & ~same[:, k])
        odd, second, third = (triangles[cut, (k + i) % 3] for i in range(3))
        near_second, near_third = nodes.middle(odd, second), nodes.middle(odd, third)
        far_second, far_third = nodes.middle(second, odd), nodes.middle(third, odd)
        parts += [
            np.stack(corners, axis=1)
            for corners in (
                (odd, near_second, near_third),
                (second, third, far_third),
                (second, far_third, far_second),
            )
        ]
        jumps.append((near_second, near_third))
        # All corners differ: each owns the piece between the middles of its edges and the centroid.
        cut = np.flatnonzero(~same.any(axis=1))
        own, after, before = (triangles[cut, (k + i) % 3] for i in range(3))
        centre = nodes.centre(cut, own)
        parts += [
            np.stack((own, nodes.middle(own, after), centre), axis=1),
            np.stack((own, centre, nodes.middle(own, before)), axis=1),
        ]
        jumps.append((nodes.middle(own, after), centre))
    used, corners = np.unique(np.concatenate(parts), return_inverse=True)
    ends = np.concatenate([np.stack(pair, axis=1) for pair in jumps])
    positions, source = nodes.points_of(used), nodes.source_of(used)
    return Pieces(
        points=positions,
        values=_continued(points, triangles, classes, values, positions, source),
        source=source,
        triangles=corners.reshape(-1, 3),
        jumps=nodes.points_of(ends.ravel()).reshape(-1, 2, 2),
        border=border,
    )


@dataclass(frozen=True, eq=False)
class _Nodes:
    """Numbers of the corners of pieces: the points, then middles of edges, then centroids; each with its owner."""

    points: Array
    triangles: Indices

    def middle(self, owner: Indices, other: Indices) -> Indices:
        """The owner's side of the middle of an edge."""
        size = len(self.points)
        return size + owner * size + other

    def centre(self, triangle: Indices, owner: Indices) -> Indices:
        """The owner's side of the centroid of a triangle."""
        size = len(self.points)
        return size + size**2 + triangle * size + owner

    def points_of(self, nodes: Indices) -> Array:
        """Coordinates of nodes, (K, 2)."""
        size = len(self.points)
        whole, part = np.divmod(nodes - size, size)
        found = self.points[np.where(nodes < size, nodes, part)]
        middles, centres = (nodes >= size) & (whole < size), whole >= size
        found[middles] = (found[middles] + self.points[whole[middles]]) / 2
        found[centres] = self.points[self.triangles[whole[centres] - size]].mean(axis=1)
        return found

    def source_of(self, nodes: Indices) -> Indices:
        """The points that own nodes, (K,)."""
        size = len(self.points)
        whole, part = np.divmod(nodes - size, size)
        return np.where(nodes < size, nodes, np.where(whole < size, whole, part))


def _delaunay(points: Array) -> Indices | None:
    """Corners of the Delaunay triangles, counter-clockwise; None if all points are on a line."""
    from matplotlib.tri import Triangulation

    try:
        triangles = np.asarray(Triangulation(*points.T).triangles, dtype=np.intp)
    except (RuntimeError, ValueError):  # Of collinear points, and of fewer than three.
        return None
    triangles = triangles[np.abs(_areas(points, triangles)) > MIN_AREA]
    triangles = _without_flat_border(points, triangles)
    return _turned(points, triangles) if len(triangles) else None


def _without_flat_border(points: Array, triangles: Indices) -> Indices:
    """The triangles without those whose longest edge is at the border and almost as long as the other two together."""
    while True:
        sides = np.stack([points[np.roll(triangles, -1, axis=1)[:, k]] - points[triangles[:, k]] for k in range(3)])
        squares = np.sort((sides**2).sum(axis=2), axis=0)
        longest = (sides**2).sum(axis=2).argmax(axis=0)
        cosine = (squares[0] + squares[1] - squares[2]) / (2 * np.sqrt(squares[0] * squares[1]))
        _, which, count = np.unique(_edges(triangles), return_inverse=True, return_counts=True)
        alone = count[which.reshape(3, -1)[longest, np.arange(len(triangles))]] == 1
        flat = alone & (cosine < np.cos(np.radians(MAX_ANGLE)))
        if not flat.any():
            return triangles
        triangles = triangles[~flat]


def _with_better_diagonals(points: Array, triangles: Indices, classes: Indices, values: Array) -> Indices:
    """The triangles, in rectangles of a grid with the diagonal whose ends are more alike.

    Both diagonals are Delaunay there. Ends of one class go before ends of two, and close values before distant ones.
    """
    edges = _edges(triangles)
    order = np.argsort(edges, kind="stable")
    twice = np.flatnonzero(edges[order[1:]] == edges[order[:-1]])
    first, second = order[twice] % len(triangles), order[twice + 1] % len(triangles)
    a, b = np.divmod(edges[order[twice]], EDGE_BASE)
    c, d = (triangles[side].sum(axis=1) - a - b for side in (first, second))
    rectangle = _close(points[a] + points[b], points[c] + points[d]) & (
        np.abs(np.hypot(*(points[a] - points[b]).T) - np.hypot(*(points[c] - points[d]).T)) < ROUNDING
    )
    alike, better = classes[a] == classes[b], classes[c] == classes[d]
    closer = np.abs(values[c] - values[d]) < np.abs(values[a] - values[b])
    flip = rectangle & (better & ~alike | (better == alike) & closer)
    triangles = triangles.copy()
    triangles[first[flip]] = np.stack((a, c, d), axis=1)[flip]
    triangles[second[flip]] = np.stack((b, c, d), axis=1)[flip]
    return _turned(points, triangles)


def _continued(
    points: Array, triangles: Indices, classes: Indices, values: Array, positions: Array, source: Indices
) -> Array:
    """Values at `positions` (K, 2), continued linearly from the points `source` with their gradients in their classes.

    Gradients are least-squares solutions over the edges to points of the same class, of least norm where the edges have
    one direction. A continuation changes by no more than an edge does.
    """
    begin, end = np.divmod(np.unique(_edges(triangles)), EDGE_BASE)
    inner = (classes[begin] == classes[end]) & np.isfinite(values[begin])
    begin, end = np.concatenate([begin[inner], end[inner]]), np.concatenate([end[inner], begin[inner]])
    along, rise = points[end] - points[begin], values[end] - values[begin]
    along, rise = along / np.hypot(*along.T)[:, None], rise / np.hypot(*along.T)
    matrices, sides, steepest = np.zeros((len(points), 2, 2)), np.zeros((len(points), 2)), np.zeros(len(points))
    np.add.at(matrices, begin, along[:, :, None] * along[:, None, :])
    np.add.at(sides, begin, along * rise[:, None])
    np.maximum.at(steepest, begin, np.abs(values[end] - values[begin]))
    gradients = np.einsum("pij,pj->pi", np.linalg.pinv(matrices, rcond=ONE_DIRECTION, hermitian=True), sides)
    change = ((positions - points[source]) * gradients[source]).sum(axis=1)
    continued: Array = values[source] + np.clip(change, -steepest[source], steepest[source])
    return continued


def _edges(triangles: Indices) -> Indices:
    """Numbers of all edges, (3M,): from corner 0 to 1 of all triangles, from 1 to 2, and from 2 to 0."""
    begin, end = triangles.T.ravel(), np.roll(triangles, -1, axis=1).T.ravel()
    return EDGE_BASE * np.minimum(begin, end) + np.maximum(begin, end)


def _areas(points: Array, triangles: Indices) -> Array:
    """Signed areas of triangles, positive if counter-clockwise."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    areas: Array = (ux * vy - uy * vx) / 2
    return areas


def _turned(points: Array, triangles: Indices) -> Indices:
    """The triangles, all counter-clockwise."""
    return np.where(_areas(points, triangles)[:, None] > 0, triangles, triangles[:, ::-1])


def _close(first: Array, second: Array) -> Flags:
    """Whether rows agree except for rounding."""
    close: Flags = np.abs(first - second).max(axis=1) < ROUNDING
    return close
