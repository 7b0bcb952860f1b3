"""Positions with room for text in a panel."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pymunk_dragon._arrays import Array, Flags, Indices
from pymunk_dragon.drawing.figures.style import POINTS_PER_INCH

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Text

# Points: side of a cell of the lattice on which lines are marked, less than half the height of a line of text.
CELL = 1.25
# Points: free space around text that is necessary, and that is preferred.
PADDING, AMPLE = 1.0, 5.0
# Rows of squares that cover a line of text: with more, covers of rotated text extend less beyond the text.
ROWS = 4
# Largest number of positions that are tried.
MAX_POSITIONS = 1000
# Points: width of the lattice's border around the panel.
BORDER = 60.0


class Room:
    """Free space of a panel: text is put where it is clear of the frame, of lines and of other text.

    Lines are marked on a lattice of cells. The axes must have their final position and limits.
    """

    def __init__(self, axes: Axes) -> None:
        self._axes = axes
        self._point = axes.figure.dpi / POINTS_PER_INCH
        self._cell = CELL * self._point
        corners = axes.transAxes.transform([(0, 0), (1, 0), (1, 1), (0, 1)])
        self._origin = corners[0] - BORDER * self._point
        width, height = np.ceil((corners[2] - corners[0] + 2 * BORDER * self._point) / self._cell).astype(int).tolist()
        self._marked = np.zeros((width, height), dtype=bool)
        self._crossable = self._marked.copy()
        # Numbers are at the left of the panel and below.
        border = int(BORDER / CELL)
        self._marked[:border, border:-border] = self._marked[border:, :border] = True
        self._mark(np.stack([corners, np.roll(corners, -1, axis=0)], axis=1))

    def take(self, lines: Array, *, crossable: bool = False) -> None:
        """Keep line segments (S, 2, 2), in data coordinates, free of text, or of text that may not cross them."""
        self._mark(self._axes.transData.transform(lines.reshape(-1, 2)).reshape(-1, 2, 2), crossable)

    def take_path(self, points: Array, *, crossable: bool = False) -> None:
        """Keep the lines between successive points (K, 2), or a single point, free."""
        ends = points[1:] if len(points) > 1 else points
        self.take(np.stack([points[: len(ends)], ends], axis=1), crossable=crossable)

    def take_lines(self) -> None:
        """Keep all lines that are drawn on the axes free."""
        for line in self._axes.get_lines():
            points = np.asarray(line.get_transform().transform(line.get_xydata()))
            self._mark(np.stack([points[:-1], points[1:]], axis=1))

    def put(self, text: Text, positions: Array, *, needed: bool = False, crossing: bool = False) -> bool:
        """Move `text` to one of the `positions` (K, 2), in data coordinates, and return whether one has room.

        Of positions with ample room, or else of those with room, the one nearest to the middle of all is taken. If none
        has room, the text is removed; or, if it is `needed`, put where it covers least. If it is `crossing`, it may
        cover lines that are crossable.
        """
        if len(positions):
            positions = positions[:: -(-len(positions) // MAX_POSITIONS)]
            centres = self._axes.transData.transform(positions).reshape(-1, 2)
            marked = self._marked if crossing else self._marked | self._crossable
            squares, half = self._squares(text, PADDING)
            covered = self._covered(marked, centres[:, None] + squares, half)
            ample_squares, ample_half = self._squares(text, AMPLE)
            tight = self._covered(marked, centres[:, None] + ample_squares, ample_half) > 0
            off_middle = np.hypot(*(centres - centres.mean(axis=0)).T)
            best = int(np.lexsort((off_middle, tight, covered))[0])
            if needed or covered[best] == 0:
                text.set_position(tuple(positions[best]))
                points = centres[best] + squares
                self._mark(np.stack([points, points], axis=1))
                return True
        text.remove()
        return False

    def _squares(self, text: Text, padding: float) -> tuple[Array, float]:
        """Squares that cover a text and padding, in points: centres (K, 2) from the text's own, and half a side."""
        rotation = text.get_rotation()
        text.set_rotation(0)
        box = text.get_window_extent()
        text.set_rotation(rotation)
        size = np.array([box.width, box.height]) + 2 * padding * self._point
        side = float(size.min()) / ROWS
        along, across = (np.linspace(side - each, each - side, int(np.ceil(each / side))) / 2 for each in size)
        cos, sin = np.cos(np.radians(rotation)), np.sin(np.radians(rotation))
        x, y = (each.ravel() for each in np.meshgrid(along, across))
        return np.stack([cos * x - sin * y, sin * x + cos * y], axis=1), side / 2

    def _covered(self, marked: Flags, centres: Array, half: float) -> Indices:
        """Number of marked cells in K groups of squares with `centres` (K, N, 2), (K,)."""
        # Sums of all cells below and to the left.
        sums = np.pad(marked.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
        low = np.floor((centres - half - self._origin) / self._cell)
        high = np.ceil((centres + half - self._origin) / self._cell)
        (left, below), (right, above) = (
            np.moveaxis(np.clip(corner, 0, marked.shape).astype(np.intp), -1, 0) for corner in (low, high)
        )
        covered = sums[right, above] - sums[left, above] - sums[right, below] + sums[left, below]
        return np.asarray(covered.sum(axis=1), dtype=np.intp)

    def _mark(self, lines: Array, crossable: bool = False) -> None:
        """Mark the cells of line segments (S, 2, 2), in pixels."""
        marked = self._crossable if crossable else self._marked
        count = 1 + int(2 * np.abs(lines[:, 1] - lines[:, 0]).max(initial=0.0) / self._cell)
        for share in np.linspace(0, 1, count + 1).tolist():
            cells = np.floor((lines[:, 0] + share * (lines[:, 1] - lines[:, 0]) - self._origin) / self._cell)
            inside = ((cells >= 0) & (cells < marked.shape)).all(axis=1)
            marked[tuple(cells[inside].astype(np.intp).T)] = True
