"""Overlays of a picture: velocities, joint impulses, contacts, normals, the grid of the broad phase, position errors.

An overlay is a function that draws it, and an entry in `OVERLAYS`, from which films and the command line have its name.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import get_args

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from pymunk_dragon.collision import Grid
from pymunk_dragon.drawing.camera import View
from pymunk_dragon.drawing.palette import BLOCK, Accent, blends
from pymunk_dragon.drawing.snapshot import Snapshot
from pymunk_dragon.model.march import March

# s: an arrow ends where its handle would be after this time, so its length is proportional to the speed.
ARROW_TIME = 0.5
# Drawn pixels: width of an arrow's shaft.
SHAFT_WIDTH = 4
# Drawn pixels: width of the outline of a displaced bench.
OUTLINE_WIDTH = 3
# Drawn pixels: width of a bench from which outlines of displaced benches do not cover the benches.
MIN_OUTLINE_WIDTH = 20.0
# Drawn pixels: length of an arrowhead.
ARROWHEAD_LENGTH = 13.0
# Drawn pixels: half the width of an arrowhead.
ARROWHEAD_HALF_WIDTH = 5.0
# Drawn pixels: a shorter arrow has no visible direction.
MIN_ARROW_LENGTH = 2.0
# Drawn pixels: largest radius of the disc of the largest impulse.
MAX_DISC_RADIUS = 36.0
# Largest radius of that disc as a fraction of a bench's width, so that the disc does not hide small benches.
MAX_DISC_FRACTION = 0.7
# Drawn pixels: radius of a contact point.
CONTACT_RADIUS = 8.0
# Drawn pixels: length of a normal.
NORMAL_LENGTH = 72.0
# Drawn pixels: width of a normal's shaft.
NORMAL_WIDTH = 6
# Drawn pixels: the lines of smaller cells would cover the ground.
MIN_CELL_SIZE = 8.0
# Quarters of a pixel that an overlay covers, for every grey level of the averaged mask.
COVERAGES = [round(4 * grey / 255) for grey in range(256)]
# Palette index (strength level, index before) after blending with each accent.
BLENDS: dict[Accent, NDArray[np.uint8]] = {accent: blends(accent) for accent in get_args(Accent)}


Draw = Callable[[ImageDraw.ImageDraw, View, Snapshot, March, float], None]
Paint = Callable[[Image.Image, View, Snapshot, March], Image.Image]


@dataclass(frozen=True, kw_only=True)
class Overlay:
    """Kind of overlay; exactly one of `draw` and `paint` is given.

    Attributes
    ----------
    shows : str
        What it shows, for the help of the command line.
    needs : str or None
        Field of a `Snapshot` that it needs beside the poses: "velocities", "impulses" or "touches".
    accent : str
        Colour in which `draw` is blended with the picture.
    draw : callable or None
        Function of a mask, on which it draws in white, the view in drawn pixels, the snapshot, the march, and the
        largest joint impulse of the film, N s.
    paint : callable or None
        Function of the picture, the view, the snapshot and the march that returns another picture.
    """

    shows: str
    needs: str | None = None
    accent: Accent = "motion"
    draw: Draw | None = None
    paint: Paint | None = None


class Overlays:
    """Renderer of overlays over the pictures of a scene.

    Parameters
    ----------
    march : March
        March that the scene shows.
    names : tuple of str
        Names of `OVERLAYS` to draw.
    largest_impulse : float
        Impulse that is drawn with the largest disc, N s.
    """

    def __init__(self, march: March, names: tuple[str, ...], largest_impulse: float) -> None:
        self._march = march
        self._chosen = [overlay for name, overlay in OVERLAYS.items() if name in names]
        self._largest = largest_impulse

    def over(self, picture: Image.Image, view: View, snapshot: Snapshot) -> Image.Image:
        """Return `picture` of `snapshot` with the overlays drawn over it; `view` is in drawn pixels."""
        if snapshot.displaced is not None:
            picture = self._blended(picture, "motion", [_draw_errors], view, snapshot)
        for accent in dict.fromkeys(overlay.accent for overlay in self._chosen):
            # What has one accent is one mask: it is not darker where it overlaps.
            masks = [overlay.draw for overlay in self._chosen if overlay.draw is not None and overlay.accent == accent]
            if masks:
                picture = self._blended(picture, accent, masks, view, snapshot)
        # These are last, because they tint only uncovered ground.
        for overlay in self._chosen:
            if overlay.paint is not None:
                picture = overlay.paint(picture, view, snapshot, self._march)
        return picture

    def _blended(
        self, picture: Image.Image, accent: Accent, draws: list[Draw], view: View, snapshot: Snapshot
    ) -> Image.Image:
        """Return `picture` blended with an accent where the mask is white that is drawn, in drawn pixels."""
        mask = Image.new("L", (picture.width * BLOCK, picture.height * BLOCK))
        for draw in draws:
            draw(ImageDraw.Draw(mask), view, snapshot, self._march, self._largest)
        return _blend(picture, accent, np.asarray(mask.reduce(BLOCK).point(COVERAGES)))


def _draw_errors(
    draw: ImageDraw.ImageDraw, view: View, snapshot: Snapshot, march: March, largest_impulse: float
) -> None:
    """Draw the outlines of the displaced benches, or arrows to there if the benches are small."""
    assert snapshot.displaced is not None  # Filled where errors are shown.
    if view.scale * float(march.dragon.widths.min()) < MIN_OUTLINE_WIDTH:
        begins, ends = (view.pixels(poses[:, :2]).tolist() for poses in (snapshot.poses, snapshot.displaced))
        for begin, end in zip(begins, ends, strict=True):
            _draw_arrow(draw, begin, end)
        return
    for corners in view.pixels(march.dragon.outlines(snapshot.displaced)).reshape(-1, 8).tolist():
        draw.line([*corners, *corners[:2]], fill=255, width=OUTLINE_WIDTH)


def _draw_velocities(
    draw: ImageDraw.ImageDraw, view: View, snapshot: Snapshot, march: March, largest_impulse: float
) -> None:
    assert snapshot.velocities is not None  # Filled where velocities are shown.
    front, rear = march.dragon.holes(snapshot.poses)
    handles = np.concatenate([front, rear[-1:]])
    seen = view.holds(handles, float(ARROW_TIME * np.linalg.norm(snapshot.velocities, axis=-1).max()))
    begins = view.pixels(handles[seen])
    ends = view.pixels(handles[seen] + ARROW_TIME * snapshot.velocities[seen])
    for begin, end in zip(begins.tolist(), ends.tolist(), strict=True):
        _draw_arrow(draw, begin, end)


def _draw_impulses(
    draw: ImageDraw.ImageDraw, view: View, snapshot: Snapshot, march: March, largest_impulse: float
) -> None:
    if snapshot.impulses is None or not largest_impulse > 0:
        return
    largest = min(MAX_DISC_RADIUS, MAX_DISC_FRACTION * float(march.dragon.widths.min()) * view.scale)
    # The disc's area is proportional to the impulse.
    radii = largest * np.sqrt(snapshot.impulses / largest_impulse)
    _, rear = march.dragon.holes(snapshot.poses)
    for (x, y), radius in zip(view.pixels(rear[:-1]).tolist(), radii.tolist(), strict=True):
        draw.ellipse((x - radius, y - radius, x + radius, y + radius), fill=255)


def _draw_contacts(
    draw: ImageDraw.ImageDraw, view: View, snapshot: Snapshot, march: March, largest_impulse: float
) -> None:
    for touch in snapshot.touches:
        for x, y in view.pixels(touch.points).tolist():
            draw.ellipse((x - CONTACT_RADIUS, y - CONTACT_RADIUS, x + CONTACT_RADIUS, y + CONTACT_RADIUS), fill=255)


def _draw_normals(
    draw: ImageDraw.ImageDraw, view: View, snapshot: Snapshot, march: March, largest_impulse: float
) -> None:
    for touch in snapshot.touches:
        begin = view.pixels(touch.points).mean(axis=0)
        # y points downwards in a picture.
        end = begin + NORMAL_LENGTH * np.array(touch.normal) * (1, -1)
        _draw_arrow(draw, begin.tolist(), end.tolist(), NORMAL_WIDTH)


def _paint_grid(picture: Image.Image, view: View, snapshot: Snapshot, march: March) -> Image.Image:
    """Draw the cells of the grid, darker if they contain a bench."""
    grid = Grid.of(march)
    scale = view.scale / BLOCK
    cell = grid.cell * scale
    if cell * BLOCK < MIN_CELL_SIZE:
        return picture
    width, height = picture.size
    left, top = view.pixels(grid.origin) / BLOCK
    # Row and column of every pixel, computed from the grid's origin so that rounding errors do not accumulate.
    columns = np.floor((np.arange(width) + 0.5 - left) / cell).astype(int)
    rows = np.floor((np.arange(height) + 0.5 - top) / cell).astype(int)
    cells, _ = grid.file(march.dragon.outlines(snapshot.poses))
    i, j = cells[:, 0] - rows[0], cells[:, 1] - columns[0]
    seen = (i >= 0) & (i <= rows[-1] - rows[0]) & (j >= 0) & (j <= columns[-1] - columns[0])
    filed = np.zeros((rows[-1] - rows[0] + 1, columns[-1] - columns[0] + 1), dtype=np.uint8)
    filed[i[seen], j[seen]] = 1
    levels = filed[np.ix_(rows - rows[0], columns - columns[0])]
    levels[np.flatnonzero(np.diff(rows)) + 1] = 2
    levels[:, np.flatnonzero(np.diff(columns)) + 1] = 2
    return _blend(picture, "grid", levels)


def _blend(picture: Image.Image, accent: Accent, levels: NDArray[np.uint8]) -> Image.Image:
    """Blend `picture` with an accent at each pixel's strength level; level 0 leaves the pixel unchanged."""
    indices = levels.astype(np.intp) * 256 + np.asarray(picture)
    return Image.fromarray(BLENDS[accent].ravel().take(indices))


def _draw_arrow(draw: ImageDraw.ImageDraw, begin: list[float], end: list[float], width: int = SHAFT_WIDTH) -> None:
    (x0, y0), (x1, y1) = begin, end
    length = math.hypot(x1 - x0, y1 - y0)
    if length < MIN_ARROW_LENGTH:
        return
    along_x, along_y = (x1 - x0) / length, (y1 - y0) / length
    head = min(ARROWHEAD_LENGTH, length)
    neck_x, neck_y = x1 - head * along_x, y1 - head * along_y
    across_x, across_y = -ARROWHEAD_HALF_WIDTH * along_y, ARROWHEAD_HALF_WIDTH * along_x
    draw.line((x0, y0, neck_x, neck_y), fill=255, width=width)
    draw.polygon([(x1, y1), (neck_x + across_x, neck_y + across_y), (neck_x - across_x, neck_y - across_y)], fill=255)


# All overlays by name.
OVERLAYS: Mapping[str, Overlay] = {
    "velocities": Overlay(
        shows="Arrows to where the handles would be in half a second.", needs="velocities", draw=_draw_velocities
    ),
    "grid": Overlay(shows="The cells of the broad phase, darker where a bench is filed.", paint=_paint_grid),
    "contacts": Overlay(shows="Contact points.", needs="touches", accent="force", draw=_draw_contacts),
    "normals": Overlay(shows="Contact normals.", needs="touches", accent="force", draw=_draw_normals),
    "impulses": Overlay(
        shows="Impulses in the joints, as discs.", needs="impulses", accent="force", draw=_draw_impulses
    ),
}
