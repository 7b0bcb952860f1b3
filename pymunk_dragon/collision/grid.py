"""Broad phase: which benches are close enough to be worth a test (paper, section 2.2 and figure 6).

Every bench is filed under the square cells that it touches, and only benches that share a cell are
candidates for a collision. A digital differential analyser (DDA; J. Amanatides and A. Woo, "A Fast
Voxel Traversal Algorithm for Ray Tracing", Eurographics 1987) follows each edge from column to
column; each crossing is computed from the edge's two ends, so errors do not accumulate.

A cell owns its sides and its corners, so two benches that merely touch always share a cell. A bench
is also filed under the cells that lie inside its outline, so one that lies wholly inside another
shares a cell with it too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import finite
from pymunk_dragon.collision.sat import coordinates
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March, check_march

_Cells = NDArray[np.intp]

# m. Least and largest pitch of a spiral, to which the paper ties the cell.
CELLS = 0.001, 1000.0
# Cells from the origin, in either direction. At the paper's pitch that is 550 km.
_MAX_INDEX = 1_000_000
# Cells by which an edge is taken to be closer to a grid line than its ends say, so that rounding
# never makes the walk miss a cell that the edge touches: at _MAX_INDEX a crossing is wrong by less
# than 3e-9. It adds cells that the edge passes at less than twice the slack, which is 20 nm where a
# cell is a metre.
_SLACK = 1e-8
# Cells. An edge that is steeper than this per column crosses none; below it, dividing by the rise
# would overflow.
_UPRIGHT = 1e-30
# Entries or pairs, 8 bytes each in several arrays: beyond it the memory of a laptop ends.
_MAX_ENTRIES = 20_000_000


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Square cells (i, j) as in figure 6: row i counts downward, column j to the right.

    Both count from the origin. There is no frame: the dragon is wider than the paper's grid, and
    cells above and to the left of the origin have negative indices.

    Parameters
    ----------
    cell : float
        Side of a cell, from 0.001 to 1000 m.
    origin : tuple of float
        Upper left corner of cell (0, 0), m.

    Examples
    --------
    >>> Grid(cell=1.0, origin=(0.0, 0.0)).walk([0.5, -0.5], [1.5, -0.6]).tolist()
    [[0, 0], [0, 1]]
    """

    cell: float = 0.55
    origin: tuple[float, float] = (-8.8, 8.8)

    def __post_init__(self) -> None:
        origin = coordinates("origin", self.origin, 2, axes=1)
        cell = finite("cell", self.cell, *CELLS, "m")
        vars(self).update(cell=cell, origin=tuple(origin.tolist()))

    @classmethod
    def of(cls, march: March) -> Grid:
        """The grid for `march`.

        On a spiral the paper's grid, with cells a pitch wide and the head's start on its right
        side. On other curves the cells are as wide as the longest bench is long, and the origin is
        the plane's.
        """
        check_march(march)
        width = march.curve.turn_width
        turns = march.turns
        if turns is None:
            turns = march.curve.turns(march.head_start)
        if width is None or turns is None:
            return cls(cell=float(march.dragon.lengths.max()), origin=(0.0, 0.0))
        return cls(cell=width, origin=(-turns * width, turns * width))

    def walk(self, start: ArrayLike, end: ArrayLike) -> _Cells:
        """Cells (K, 2) as (i, j) that the edge from `start` (2,) to `end` (2,) in m touches.

        They are in the order from its start on.
        """
        one = coordinates("start", start, 2, axes=1)
        two = coordinates("end", end, 2, axes=1)
        self._in_cells("start", one)
        self._in_cells("end", two)
        # The cells of an outline without a width.
        cells = self.file([[one, one, two, two]])[0]
        rows, columns = cells.T
        down = rows if two[1] <= one[1] else -rows
        across = columns if two[0] >= one[0] else -columns
        return cells[np.lexsort((down, across))]

    def file(self, outlines: ArrayLike) -> tuple[_Cells, _Cells]:
        """File N benches under the cells that they touch or cover.

        Parameters
        ----------
        outlines : array_like, shape (N, 4, 2)
            Corners in m, as `dragon.outlines` gives them. Any convex outline will do.

        Returns
        -------
        cells : ndarray, shape (K, 2)
            Every cell (i, j) of every bench: those that `walk` finds for its edges, and those
            within.
        benches : ndarray, shape (K,)
            Whose cell it is: rising, and within a bench by column and row.
        """
        corners = coordinates("outlines", outlines, 4, 2, axes=3)
        # Of shape (4, N).
        u, v = (np.ascontiguousarray(cells.T) for cells in self._in_cells("outlines", corners))
        first, last = _range(u.min(axis=0), u.max(axis=0))
        counts = last - first + 1
        self._check_entries(counts, "large")
        bench, columns = _runs(first, counts)

        # In a column, a convex outline lies between the lowest and the highest row of its edges.
        u = u[:, bench]
        v = v[:, bench]
        ends = np.roll(u, -1, axis=0), np.roll(v, -1, axis=0)
        low, high = _rows(u, v, *ends, columns)
        top, bottom = _range(low.min(axis=0), high.max(axis=0))
        counts = bottom - top + 1
        self._check_entries(counts, "large")
        owner, rows = _runs(top, counts)
        return np.stack([rows, columns[owner]], axis=-1), bench[owner]

    def pairs(self, outlines: ArrayLike) -> _Cells:
        """Pairs (P, 2) of benches that share a cell, without neighbours, in order.

        The smaller number is first. No two benches that overlap or touch are missing; most of the
        pairs neither overlap nor touch. `outlines` (N, 4, 2) are those that `file` takes.
        """
        cells, benches = self.file(outlines)
        if not benches.size:
            return np.empty((0, 2), dtype=np.intp)
        # One number for cell and bench sorts the entries by cell, and within a cell by bench. A
        # million cells squared need 64 bits: on some platforms counts and indices have fewer.
        n = int(benches[-1]) + 1
        rows, columns = (cells - cells.min(axis=0)).astype(np.int64, copy=False).T
        numbers = rows * (columns.max() + 1) + columns
        entries = np.sort(numbers * n + benches)
        cells, benches = np.divmod(entries, n)

        # Every entry is paired with the later ones of its cell.
        ends = np.append(np.flatnonzero(np.diff(cells)) + 1, cells.size)
        entries = np.arange(cells.size)
        later = np.repeat(ends, np.diff(ends, prepend=0)) - entries - 1
        self._check_entries(later, "small")
        owner, other = _runs(entries + 1, later)
        one = benches[owner]
        two = benches[other]
        far = two - one > 1
        # `np.unique` would do the rest, but takes twice as long and imports masked arrays.
        codes = np.sort(one[far] * n + two[far])
        codes = codes[np.diff(codes, prepend=-1) > 0]
        return np.stack(np.divmod(codes, n), axis=-1).astype(np.intp, copy=False)

    def _in_cells(self, name: str, points: Array) -> tuple[Array, Array]:
        """Distances (...) of `points` (..., 2) from the origin in cells: right, and downward."""
        offset = points - self.origin
        inside = np.abs(offset) <= _MAX_INDEX * self.cell
        if not inside.all():
            bound = f"at most {_MAX_INDEX:,} cells of {self.cell:g} m from the grid's origin"
            raise ParameterError(name, points[~inside][0].item(), bound)
        return offset[..., 0] / self.cell, offset[..., 1] / -self.cell

    def _check_entries(self, counts: _Cells, size: str) -> None:
        # A float, which no sum overflows.
        total = int(counts.sum(dtype=float))
        if total > _MAX_ENTRIES:
            bound = f"{size} enough for {_MAX_ENTRIES:,} entries, not {total:,}"
            raise ParameterError("cell", self.cell, bound)


def _range(low: Array, high: Array) -> tuple[_Cells, _Cells]:
    """First and last cell, in one direction, that a segment from `low` to `high` touches."""
    first = np.floor(low - _SLACK)
    last = np.floor(high + _SLACK)
    return first.astype(np.intp), last.astype(np.intp)


def _runs(starts: _Cells, counts: _Cells) -> tuple[_Cells, _Cells]:
    """Concatenated ranges of `counts[k]` integers from `starts[k]` on, and the k of each integer.

    The k come first.
    """
    owner = np.repeat(np.arange(counts.size), counts)
    before = np.cumsum(counts) - counts
    return owner, np.arange(owner.size) + (starts - before)[owner]


def _rows(u0: Array, v0: Array, u1: Array, v1: Array, columns: _Cells) -> tuple[Array, Array]:
    """The DDA's step: the highest and the lowest points of edges within a column.

    Edges run from (u0, v0) to (u1, v1), distances from the origin in cells to the right and
    downward; the points are distances downward. An edge that misses its column gives an empty
    range, inf to -inf.
    """
    across = u1 - u0
    across = np.where(np.abs(across) < _UPRIGHT, _UPRIGHT, across)
    # Shares of the edge at which it crosses the column's two sides. They are moved out by twice the
    # slack, so that no edge misses a column in which `_range` has put it.
    left = (columns - 2 * _SLACK - u0) / across
    right = (columns + 1 + 2 * _SLACK - u0) / across
    enter = np.maximum(np.minimum(left, right), 0.0)
    leave = np.minimum(np.maximum(left, right), 1.0)
    missed = enter > leave
    down = v1 - v0
    one = v0 + enter * down
    two = v0 + leave * down
    highest = np.where(missed, np.inf, np.minimum(one, two))
    return highest, np.where(missed, -np.inf, np.maximum(one, two))
