"""Overlays of a picture: velocities, joint impulses, contacts, normals, the grid of the broad phase, position errors.

An overlay is a function that draws it, and an entry in `OVERLAYS`, from which films and the command line have its name.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw

from pymunk_dragon.collision import Grid
from pymunk_dragon.drawing.camera import View
from pymunk_dragon.drawing.palette import BLOCK, CELL_TINT, LINE_TINT, Colour, Palette
from pymunk_dragon.drawing.snapshots import Snapshot
from pymunk_dragon.model.march import March

# s: an arrow ends where its handle would be after this time, so its length is proportional to the speed.
_ARROW_TIME = 0.5
# Drawn pixels: width of an arrow's shaft; length and half the width of its head. A shorter arrow has no direction.
_SHAFT_WIDTH, _ARROWHEAD_LENGTH, _ARROWHEAD_HALF_WIDTH, _MIN_ARROW_LENGTH = 4, 13.0, 5.0, 2.0
# Drawn pixels: width and length of a normal.
_NORMAL_WIDTH, _NORMAL_LENGTH = 6, 72.0
# Drawn pixels: width of the outline of a displaced bench, and of benches that are not covered by such outlines.
_OUTLINE_WIDTH, _MIN_OUTLINE_WIDTH = 3, 20.0
# Drawn pixels: largest radius of the disc of the largest impulse; and the same as a fraction of a bench's width, so
# that the disc does not hide small benches.
_MAX_DISC_RADIUS, _MAX_DISC_FRACTION = 36.0, 0.7
# Drawn pixels: radius of a contact point; and size of a cell, of which smaller ones would cover the ground.
_CONTACT_RADIUS, _MIN_CELL_SIZE = 8.0, 8.0


@dataclass(frozen=True)
class Layer:
    """What an overlay draws on, and what it shows: a picture of drawn pixels, and the film's largest impulse, N s."""

    image: Image.Image
    view: View
    snapshot: Snapshot
    march: March
    palette: Palette
    largest_impulse: float

    def disc(self, centre: Sequence[float], radius: float) -> None:
        """Draw a disc of force; lengths in drawn pixels."""
        ImageDraw.Draw(self.image).circle(centre, radius, fill=self.palette.rgb("force"))

    def arrow(self, begin: list[float], end: list[float], colour: Colour, width: int = _SHAFT_WIDTH) -> None:
        """Draw an arrow from a drawn pixel to another one."""
        (x0, y0), (x1, y1) = begin, end
        length = math.hypot(x1 - x0, y1 - y0)
        if length < _MIN_ARROW_LENGTH:
            return
        along_x, along_y = (x1 - x0) / length, (y1 - y0) / length
        head = min(_ARROWHEAD_LENGTH, length)
        neck_x, neck_y = x1 - head * along_x, y1 - head * along_y
        across_x, across_y = -_ARROWHEAD_HALF_WIDTH * along_y, _ARROWHEAD_HALF_WIDTH * along_x
        draw = ImageDraw.Draw(self.image)
        draw.line((x0, y0, neck_x, neck_y), fill=colour, width=width)
        corners = [(x1, y1), (neck_x + across_x, neck_y + across_y), (neck_x - across_x, neck_y - across_y)]
        draw.polygon(corners, fill=colour)


@dataclass(frozen=True, kw_only=True)
class Overlay:
    """Kind of overlay: what it shows, for the help, a function that draws it, and whether it lies below the benches.

    `needs` is the field of a `Snapshot` that it needs beside the poses: "velocities", "impulses" or "touches".
    """

    shows: str
    draw: Callable[[Layer], None]
    needs: str | None = None
    below: bool = False


def draw_overlays(layer: Layer, names: Collection[str], *, below: bool = False) -> None:
    """Draw the overlays with these names that lie above, or below, the benches."""
    for name, overlay in OVERLAYS.items():
        if name in names and overlay.below == below:
            overlay.draw(layer)


def draw_errors(layer: Layer) -> None:
    """Draw the outlines of the displaced benches, or arrows to there if the benches are small."""
    snapshot, dragon, colour = layer.snapshot, layer.march.dragon, layer.palette.rgb("motion")
    if snapshot.displaced is None:
        return
    if layer.view.scale * float(dragon.widths.min()) < _MIN_OUTLINE_WIDTH:
        begins, ends = (layer.view.pixels(poses[:, :2]).tolist() for poses in (snapshot.poses, snapshot.displaced))
        for begin, end in zip(begins, ends, strict=True):
            layer.arrow(begin, end, colour)
        return
    draw = ImageDraw.Draw(layer.image)
    for corners in layer.view.pixels(dragon.outlines(snapshot.displaced)).reshape(-1, 8).tolist():
        draw.line([*corners, *corners[:2]], fill=colour, width=_OUTLINE_WIDTH)


def _draw_velocities(layer: Layer) -> None:
    velocities = layer.snapshot.velocities
    assert velocities is not None  # Filled where velocities are shown.
    front, rear = layer.march.dragon.holes(layer.snapshot.poses)
    handles = np.concatenate([front, rear[-1:]])
    seen = layer.view.holds(handles, float(_ARROW_TIME * np.linalg.norm(velocities, axis=-1).max()))
    begins = layer.view.pixels(handles[seen])
    ends = layer.view.pixels(handles[seen] + _ARROW_TIME * velocities[seen])
    for begin, end in zip(begins.tolist(), ends.tolist(), strict=True):
        layer.arrow(begin, end, layer.palette.rgb("motion"))


def _draw_impulses(layer: Layer) -> None:
    impulses, dragon = layer.snapshot.impulses, layer.march.dragon
    if impulses is None or not layer.largest_impulse > 0:
        return
    largest = min(_MAX_DISC_RADIUS, _MAX_DISC_FRACTION * float(dragon.widths.min()) * layer.view.scale)
    # The disc's area is proportional to the impulse.
    radii = largest * np.sqrt(impulses / layer.largest_impulse)
    _, rear = dragon.holes(layer.snapshot.poses)
    for centre, radius in zip(layer.view.pixels(rear[:-1]).tolist(), radii.tolist(), strict=True):
        layer.disc(centre, radius)


def _draw_contacts(layer: Layer) -> None:
    for touch in layer.snapshot.touches:
        for centre in layer.view.pixels(touch.points).tolist():
            layer.disc(centre, _CONTACT_RADIUS)


def _draw_normals(layer: Layer) -> None:
    for touch in layer.snapshot.touches:
        begin = layer.view.pixels(touch.points).mean(axis=0)
        # y points downwards in a picture.
        end = begin + _NORMAL_LENGTH * np.array(touch.normal) * (1, -1)
        layer.arrow(begin.tolist(), end.tolist(), layer.palette.rgb("force"), _NORMAL_WIDTH)


def _draw_grid(layer: Layer) -> None:
    """Tint the cells that contain a bench, and draw the lines between cells, a pixel wide."""
    grid, cell = Grid.of(layer.march), Grid.of(layer.march).cell * layer.view.scale
    if cell < _MIN_CELL_SIZE:
        return
    # Column and row of every pixel, computed from the grid's origin so that rounding errors do not accumulate.
    columns, rows = (
        np.floor(((np.arange(length // BLOCK) + 0.5) * BLOCK - origin) / cell).astype(int)
        for length, origin in zip(layer.image.size, layer.view.pixels(grid.origin), strict=True)
    )
    cells, _ = grid.file(layer.march.dragon.outlines(layer.snapshot.poses))
    cells -= (rows[0], columns[0])
    tints = np.zeros((np.ptp(rows) + 1, np.ptp(columns) + 1), dtype=np.uint8)
    i, j = cells[np.all((cells >= 0) & (cells < tints.shape), axis=1)].T
    tints[i, j] = CELL_TINT
    mask = tints[np.ix_(rows - rows[0], columns - columns[0])]
    mask[np.flatnonzero(np.diff(rows)) + 1] = LINE_TINT
    mask[:, np.flatnonzero(np.diff(columns)) + 1] = LINE_TINT
    drawn = Image.fromarray(mask).resize(layer.image.size, Image.Resampling.NEAREST)
    layer.image.paste(layer.palette.rgb("grid"), (0, 0), drawn)


# All overlays by name, in the order in which they are drawn.
OVERLAYS: Mapping[str, Overlay] = {
    "velocities": Overlay(
        shows="Arrows to where the handles would be in half a second.", needs="velocities", draw=_draw_velocities
    ),
    "grid": Overlay(shows="The cells of the broad phase, darker where a bench is filed.", draw=_draw_grid, below=True),
    "contacts": Overlay(shows="Contact points.", needs="touches", draw=_draw_contacts),
    "normals": Overlay(shows="Contact normals.", needs="touches", draw=_draw_normals),
    "impulses": Overlay(shows="Impulses in the joints, as discs.", needs="impulses", draw=_draw_impulses),
}
