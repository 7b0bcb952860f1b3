"""Overlays of a picture: velocities, joint impulses, contacts, the grid of the broad phase, position errors.

An overlay is a function that draws it, and an entry in `OVERLAYS`, from which films and the command
line have its name.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw

from pymunk_dragon._arrays import Array
from pymunk_dragon.collision import Grid
from pymunk_dragon.drawing.palette import BLOCK, COLOURS
from pymunk_dragon.drawing.snapshots import Snapshots
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.run import Run

# s: an arrow ends where its handle would be after this time, so its length is proportional to the
# speed.
_ARROW_TIME = 0.5
# Drawn pixels: width of an arrow's shaft; length and half the width of its head. A shorter arrow
# has no direction.
_SHAFT_WIDTH, _ARROWHEAD_LENGTH, _ARROWHEAD_HALF_WIDTH, _MIN_ARROW_LENGTH = 4, 13.0, 5.0, 2.0
# Drawn pixels: length of a normal, and radius of a contact point.
_NORMAL_LENGTH, _CONTACT_RADIUS = 72.0, 8.0
# Radius of the disc of the run's largest impulse, as a fraction of a bench's width: it does not
# hide the bench.
_DISC_RADIUS = 0.55
# Drawn pixels: smallest size of a cell, of which smaller ones would cover the ground. Opacities of
# 255 of a cell with a bench, and of a line between cells: sixteenths, which are in the table of
# colours.
_MIN_CELL_SIZE, _CELL_TINT, _LINE_TINT = 8.0, 32, 64
# Substeps: a contact callback is shown if it is at most this much older than the frame. The last
# substep, and a margin for rounding.
_RECENT_SUBSTEPS = 1.5


@dataclass(frozen=True)
class Layer:
    """Surface on which a state is drawn: `image`, with `scale` pixels per m around `centre`, m; `poses` (N, 3)."""

    image: Image.Image
    centre: tuple[float, float]
    scale: float
    source: Snapshots
    time: float
    poses: Array

    @property
    def dragon(self) -> Dragon:
        """Dragon that is drawn."""
        return self.source.march.dragon

    def pixels(self, points: ArrayLike) -> Array:
        """Convert `points` (..., 2), m, to pixels right of and below the upper left corner."""
        middle = np.asarray(self.image.size) / 2
        return (np.asarray(points, dtype=float) - self.centre) * (self.scale, -self.scale) + middle

    def holds(self, points: ArrayLike, margin: float) -> NDArray[np.bool_]:
        """Return which of `points` (..., 2), m, are in view or at most `margin` m outside."""
        half = np.asarray(self.image.size) / (2 * self.scale) + margin
        return np.asarray(np.all(np.abs(np.asarray(points) - self.centre) <= half, axis=-1))

    def disc(self, centre: Sequence[float], radius: float) -> None:
        """Draw a disc of force; lengths in pixels."""
        ImageDraw.Draw(self.image).circle(centre, radius, fill=COLOURS.force)

    def arrow(
        self, begin: Sequence[float], end: Sequence[float], colour: str = COLOURS.motion
    ) -> None:
        """Draw an arrow from a pixel to another one."""
        tip, along = complex(*end), complex(*end) - complex(*begin)
        length = abs(along)
        if length < _MIN_ARROW_LENGTH:
            return
        neck, across = (
            tip - min(_ARROWHEAD_LENGTH / length, 1) * along,
            1j * _ARROWHEAD_HALF_WIDTH * along / length,
        )
        draw = ImageDraw.Draw(self.image)
        draw.line((*begin, neck.real, neck.imag), fill=colour, width=_SHAFT_WIDTH)
        draw.polygon(
            [(point.real, point.imag) for point in (tip, neck + across, neck - across)], fill=colour
        )

    def arrows(self, points: Array, vectors: Array) -> None:
        """Draw arrows of motion from `points` (K, 2) along `vectors` (K, 2), m, where they can be in view."""
        seen = self.holds(points, float(np.linalg.norm(vectors, axis=-1).max()))
        begins, ends = (
            self.pixels(points[seen]).tolist(),
            self.pixels((points + vectors)[seen]).tolist(),
        )
        for begin, end in zip(begins, ends, strict=True):
            self.arrow(begin, end)


@dataclass(frozen=True, kw_only=True)
class _Overlay:
    """Kind of overlay: what it shows, for the help, a function that draws it, and whether it lies below the benches.

    `needs` is an attribute of a `Run` that marches and some runs do not have.
    """

    shows: str
    draw: Callable[[Layer], None]
    needs: str | None = None
    below: bool = False


def check_overlays(names: Collection[str], source: Snapshots) -> None:
    """Raise a ParameterError if the source has no data for one of the overlays with these names."""
    for name in names:
        needs = OVERLAYS[name].needs
        if needs and getattr(source.run, needs, None) is None:
            raise ParameterError(
                "show", name, "left out: a march has no contacts, and only the engine has impulses"
            )


def draw_overlays(layer: Layer, names: Collection[str], *, below: bool = False) -> None:
    """Draw the overlays with these names that lie above, or below, the benches."""
    for name, overlay in OVERLAYS.items():
        if name in names and overlay.below == below:
            overlay.draw(layer)


def _forces(run: Run, time: float) -> Array:
    """Return the forces (N - 1,) in joints at the frame before a time, N, which are not interpolated."""
    assert run.joint_forces is not None  # Other runs are refused.
    return np.asarray(run.joint_forces[np.searchsorted(run.times, time, side="right") - 1])


def _touches(run: Run, time: float) -> list[tuple[Sequence[Sequence[float]], Sequence[float]]]:
    """Return the contact points, m, and the normal of each contact at a time.

    They are those of the last callback in the last substep; before all callbacks, of the refined
    first contact.
    """
    since = time - _RECENT_SUBSTEPS * (run.substep or 0.0)
    begin, end = (bisect_right(run.events, t, key=lambda event: event.time) for t in (since, time))
    if end > 0:
        last = {
            each.benches: (each.points, each.normal)
            for each in run.events[begin:end]
            if each.normal
        }
        return [*last.values()]
    first = run.first_contact
    return [([first.point], first.normal)] if first and time >= first.time else []


def _draw_velocities(layer: Layer) -> None:
    front, rear = layer.dragon.holes(layer.poses)
    motion = _ARROW_TIME * layer.source.velocities(layer.time, layer.poses)
    layer.arrows(np.concatenate([front, rear[-1:]]), motion)


def _draw_impulses(layer: Layer) -> None:
    run = layer.source.run
    assert run is not None  # Marches are refused.
    assert run.joint_forces is not None
    largest = float(run.joint_forces.max(initial=0.0)) or 1.0
    # The disc's area is proportional to the force, and so to the impulse in a substep.
    shares = np.sqrt(_forces(run, layer.time) / largest)
    radii = _DISC_RADIUS * float(layer.dragon.widths.min()) * layer.scale * shares
    _, rear = layer.dragon.holes(layer.poses)
    for centre, radius in zip(layer.pixels(rear[:-1]).tolist(), radii.tolist(), strict=True):
        layer.disc(centre, radius)


def _draw_contacts(layer: Layer) -> None:
    assert layer.source.run is not None  # Marches are refused.
    for points, normal in _touches(layer.source.run, layer.time):
        centres = layer.pixels(points)
        for centre in centres.tolist():
            layer.disc(centre, _CONTACT_RADIUS)
        begin = centres.mean(axis=0)
        # y points downwards in a picture.
        layer.arrow(
            begin.tolist(),
            (begin + _NORMAL_LENGTH * np.array(normal) * (1, -1)).tolist(),
            COLOURS.force,
        )


def _draw_grid(layer: Layer) -> None:
    """Tint the cells that contain a bench, and draw the lines between cells."""
    grid, draw = Grid.of(layer.source.march), ImageDraw.Draw(layer.image, "RGBA")
    cell, (left, top) = grid.cell * layer.scale, layer.pixels(grid.origin).tolist()
    if cell < _MIN_CELL_SIZE:
        return
    filed, _ = grid.file(layer.dragon.outlines(layer.poses))
    for i, j in np.unique(filed, axis=0).tolist():
        x0, x1, y0, y1 = (
            round(each * cell + edge)
            for each, edge in ((j, left), (j + 1, left), (i, top), (i + 1, top))
        )
        draw.rectangle((x0, y0, x1 - 1, y1 - 1), fill=(*COLOURS.rgb("grid"), _CELL_TINT))
    width, height = layer.image.size
    lines = [(x, 0, x, height) for x in np.arange(left % cell, width, cell).tolist()]
    lines += [(0, y, width, y) for y in np.arange(top % cell, height, cell).tolist()]
    for line in lines:
        draw.line(line, fill=(*COLOURS.rgb("grid"), _LINE_TINT), width=BLOCK)


# All overlays by name, in the order in which they are drawn.
OVERLAYS: Mapping[str, _Overlay] = {
    "velocities": _Overlay(
        shows="Arrows to where the handles would be in half a second.", draw=_draw_velocities
    ),
    "grid": _Overlay(
        shows="The cells of the broad phase, darker where a bench is filed.",
        draw=_draw_grid,
        below=True,
    ),
    "contacts": _Overlay(shows="Contact points and normals.", needs="events", draw=_draw_contacts),
    "impulses": _Overlay(
        shows="Impulses in the joints, as discs.", needs="joint_forces", draw=_draw_impulses
    ),
}
