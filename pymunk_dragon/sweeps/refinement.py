"""New points of a grid where what is discrete changes between neighbours."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from itertools import pairwise, product

from pymunk_dragon.sweeps.axes import Grid, Point

# Lower and upper end of a cell along each axis.
Cell = tuple[tuple[float, float], ...]


class Refinement:
    """Divides the cells of a grid in which the labels of points differ, the largest cells first.

    Each round gives the new points of the cells of one size: the middles of their edges and faces, and their centres.
    The rounds depend on the labels only, so a resumed sweep repeats them.

    Parameters
    ----------
    grid : Grid
        The points of the first round.
    count : int
        New points, at most.
    integers : collection of str
        Axes with whole numbers, which are not divided further than that.

    Examples
    --------
    >>> refinement = Refinement(Grid({"pitch": (0.0, 1.0, 2.0)}), 10, frozenset())
    >>> labels = {(0.0,): "contact", (1.0,): "contact", (2.0,): "clear"}
    >>> refinement.round(labels)
    [(1.5,)]
    """

    def __init__(self, grid: Grid, count: int, integers: frozenset[str]) -> None:
        self._left = count
        self._whole = [name in integers for name in grid.names]
        edges = [list(pairwise(sorted(set(values)))) or [(values[0],) * 2] for values in grid.values.values()]
        # Cells and how often they were divided.
        self._cells: dict[Cell, int] = dict.fromkeys(product(*edges), 0) if count else {}

    def round(self, labels: Mapping[Point, Hashable]) -> list[Point]:
        """New points, given the labels of all points so far; none if no cell is left or all points are used."""
        new: dict[Point, None] = {}
        while not new and (mixed := {cell: size for cell, size in self._cells.items() if self._is_mixed(cell, labels)}):
            largest = min(mixed.values())
            for cell in (cell for cell, size in mixed.items() if size == largest):
                new |= dict.fromkeys(point for point in self._lattice(cell) if point not in labels)
                del self._cells[cell]
                sides = [list(pairwise(values)) or [edge] for values, edge in self._divided(cell)]
                self._cells |= dict.fromkeys(product(*sides), largest + 1)
        points = list(new)
        if len(points) >= self._left:
            # As many as are left, from everywhere; the cells would not be divided as they should be.
            points = [points[number * len(points) // self._left] for number in range(self._left)]
            self._cells = {}
        self._left -= len(points)
        return points

    def _divided(self, cell: Cell) -> list[tuple[list[float], tuple[float, float]]]:
        """The ends of a cell along each axis, with the middle between them if there is one; and its edge."""
        return [
            (sorted({low, *self._middle(low, high, whole), high}), (low, high))
            for (low, high), whole in zip(cell, self._whole, strict=True)
        ]

    @staticmethod
    def _middle(low: float, high: float, whole: bool) -> list[float]:
        middle = (low + high) // 2 if whole else (low + high) / 2
        return [middle] if low < middle < high else []

    def _lattice(self, cell: Cell) -> list[Point]:
        """Corners of a cell, middles of its edges and faces, and its centre."""
        return list(product(*(values for values, _ in self._divided(cell))))

    def _is_mixed(self, cell: Cell, labels: Mapping[Point, Hashable]) -> bool:
        """Whether the known labels of a cell differ, and it can be divided."""
        lattice = self._lattice(cell)
        known = {labels[point] for point in lattice if point in labels}
        return len(known) > 1 and any(len(values) > 2 for values, _ in self._divided(cell))
