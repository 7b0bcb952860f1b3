"""Marks that are laid over a finished picture: velocities, joint impulses, contacts, normals, and the grid."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import get_args

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from pymunk_dragon.collision import Grid
from pymunk_dragon.march import March
from pymunk_dragon.render.camera import View
from pymunk_dragon.render.moments import Mark, Moment
from pymunk_dragon.render.palette import BLOCK, Accent, blends

__all__ = ["Overlay"]

Array = NDArray[np.float64]

# s: how far ahead an arrow points; it ends where its handle would be then.
AHEAD = 0.5
# Drawn pixels: width of a shaft, length of a head and half of its width, and the shortest arrow.
SHAFT, HEAD_ALONG, HEAD_ACROSS, SHORTEST_ARROW = 4, 13.0, 5.0, 2.0
# Drawn pixels: radius of the disc of the largest impulse, at most and as a share of a bench's width; of a contact
# point; length and width of a normal.
MAX_DISC, DISC_SHARE = 36.0, 0.7
POINT, NORMAL, NORMAL_WIDTH = 8.0, 72.0, 6
# Drawn pixels: cells narrower than this are not worth their lines.
MIN_CELL = 8.0
# Quarters of a pixel that a mark covers, for every grey that its average can have.
COVERAGES = [round(4 * grey / 255) for grey in range(256)]
BLENDS: dict[Accent, NDArray[np.uint8]] = {accent: blends(accent) for accent in get_args(Accent)}


class Overlay:
    """Lays marks over the pictures of a scene.

    Parameters
    ----------
    march : March
        Whose pictures they are.
    marks : tuple of Mark
        What to lay over them.
    largest_impulse : float
        Impulse whose disc has the largest size, N s.
    """

    def __init__(self, march: March, marks: tuple[Mark, ...], largest_impulse: float) -> None:
        self._march = march
        self._marks = marks
        self._largest = largest_impulse
        self._grid = Grid.of(march)

    def over(self, picture: Image.Image, view: View, moment: Moment) -> Image.Image:
        """`picture` of `moment` with the marks over it; `view` is at the size at which a scene is drawn."""
        if {"impulses", "contacts", "normals"} & set(self._marks):
            picture = self._with(picture, "force", lambda draw: self._forces(draw, view, moment))
        if "velocities" in self._marks:
            picture = self._with(picture, "motion", lambda draw: self._velocities(draw, view, moment))
        # It only tints ground that is still bare, so it comes last.
        return self._with_grid(picture, view, moment.poses) if "grid" in self._marks else picture

    def _with_grid(self, picture: Image.Image, view: View, poses: Array) -> Image.Image:
        """The ground in cells, darker where a bench is filed."""
        scale = view.scale / BLOCK
        cell = self._grid.cell * scale
        if cell * BLOCK < MIN_CELL:
            return picture
        width, height = picture.size
        left, top = view.pixels(self._grid.origin) / BLOCK
        # Which row and column every pixel is in, from the cells' own sides: no error adds up across the picture.
        columns = np.floor((np.arange(width) + 0.5 - left) / cell).astype(int)
        rows = np.floor((np.arange(height) + 0.5 - top) / cell).astype(int)
        cells, _ = self._grid.file(self._march.dragon.outlines(poses))
        i, j = cells[:, 0] - rows[0], cells[:, 1] - columns[0]
        seen = (i >= 0) & (i <= rows[-1] - rows[0]) & (j >= 0) & (j <= columns[-1] - columns[0])
        filed = np.zeros((rows[-1] - rows[0] + 1, columns[-1] - columns[0] + 1), dtype=np.uint8)
        filed[i[seen], j[seen]] = 1
        levels = filed[np.ix_(rows - rows[0], columns - columns[0])]
        levels[np.flatnonzero(np.diff(rows)) + 1] = 2
        levels[:, np.flatnonzero(np.diff(columns)) + 1] = 2
        return _blended(picture, "grid", levels)

    def _with(self, picture: Image.Image, accent: Accent, paint: Callable[[ImageDraw.ImageDraw], None]) -> Image.Image:
        """`picture` with what `paint` draws in white on black, at the size of a scene, in an accent."""
        canvas = Image.new("L", (picture.width * BLOCK, picture.height * BLOCK))
        paint(ImageDraw.Draw(canvas))
        return _blended(picture, accent, np.asarray(canvas.reduce(BLOCK).point(COVERAGES)))

    def _velocities(self, draw: ImageDraw.ImageDraw, view: View, moment: Moment) -> None:
        assert moment.velocities is not None
        front, rear = self._march.dragon.holes(moment.poses)
        handles = np.concatenate([front, rear[-1:]])
        seen = view.holds(handles, float(AHEAD * np.linalg.norm(moment.velocities, axis=-1).max()))
        begins = view.pixels(handles[seen])
        ends = view.pixels(handles[seen] + AHEAD * moment.velocities[seen])
        for begin, end in zip(begins.tolist(), ends.tolist(), strict=True):
            _arrow(draw, begin, end)

    def _forces(self, draw: ImageDraw.ImageDraw, view: View, moment: Moment) -> None:
        if "impulses" in self._marks and moment.impulses is not None and self._largest > 0:
            largest = min(MAX_DISC, DISC_SHARE * float(self._march.dragon.widths.min()) * view.scale)
            # The disc's area is in proportion to the impulse.
            radii = largest * np.sqrt(moment.impulses / self._largest)
            _, rear = self._march.dragon.holes(moment.poses)
            for (x, y), radius in zip(view.pixels(rear[:-1]).tolist(), radii.tolist(), strict=True):
                draw.ellipse((x - radius, y - radius, x + radius, y + radius), fill=255)
        for touch in moment.touches:
            points = view.pixels(touch.points)
            if "contacts" in self._marks:
                for x, y in points.tolist():
                    draw.ellipse((x - POINT, y - POINT, x + POINT, y + POINT), fill=255)
            if "normals" in self._marks:
                begin = points.mean(axis=0)
                # On a picture y goes down.
                end = begin + NORMAL * np.array(touch.normal) * (1, -1)
                _arrow(draw, begin.tolist(), end.tolist(), NORMAL_WIDTH)


def _blended(picture: Image.Image, accent: Accent, levels: NDArray[np.uint8]) -> Image.Image:
    """`picture` under an accent at the strength of each pixel's level, none at 0."""
    places = levels.astype(np.intp) * 256 + np.asarray(picture)
    return Image.fromarray(BLENDS[accent].ravel().take(places))


def _arrow(draw: ImageDraw.ImageDraw, begin: list[float], end: list[float], width: int = SHAFT) -> None:
    (x0, y0), (x1, y1) = begin, end
    length = math.hypot(x1 - x0, y1 - y0)
    if length < SHORTEST_ARROW:
        return
    along_x, along_y = (x1 - x0) / length, (y1 - y0) / length
    head = min(HEAD_ALONG, length)
    neck_x, neck_y = x1 - head * along_x, y1 - head * along_y
    across_x, across_y = -HEAD_ACROSS * along_y, HEAD_ACROSS * along_x
    draw.line((x0, y0, neck_x, neck_y), fill=255, width=width)
    draw.polygon([(x1, y1), (neck_x + across_x, neck_y + across_y), (neck_x - across_x, neck_y - across_y)], fill=255)
