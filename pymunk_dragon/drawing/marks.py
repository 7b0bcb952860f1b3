"""Overlays of a picture, such as velocities, contacts or the grid of the broad phase.

An overlay is a function that draws it, and an entry in `OVERLAYS`, from which films and the command
line have its name.
"""

from bisect import bisect_right
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageColor, ImageDraw

from pymunk_dragon._arrays import Array
from pymunk_dragon.collision import Grid
from pymunk_dragon.drawing.palette import BLOCK, COLOURS
from pymunk_dragon.drawing.snapshots import Snapshots
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.run import Run

# Contact points, m, and the normal.
_Touch = tuple[Sequence[Sequence[float]], Sequence[float]]

# s: an arrow ends where its handle would be after this time, so its length is proportional to the
# speed.
_ARROW_TIME = 0.5
# Drawn pixels.
_SHAFT_WIDTH = 4
# Drawn pixels.
_ARROWHEAD_LENGTH = 13.0
# Drawn pixels.
_ARROWHEAD_HALF_WIDTH = 5.0
# Drawn pixels: a shorter arrow has no direction.
_MIN_ARROW_LENGTH = 2.0
# Drawn pixels: length of the arrow of a contact normal.
_NORMAL_LENGTH = 72.0
# Drawn pixels: radius of a contact point.
_CONTACT_RADIUS = 8.0
# Radius of the disc of the run's largest impulse, as a fraction of a bench's width: it does not
# hide the bench.
_DISC_RADIUS = 0.55
# Drawn pixels: size of a cell, of which smaller ones would cover the ground.
_MIN_CELL_SIZE = 8.0
# Opacity of a cell with a bench, of 255. Sixteenths are in the table of colours.
_CELL_TINT = 32
# Opacity of a line between cells, of 255; a multiple of a sixteenth too.
_LINE_TINT = 64
# Substeps: a contact callback is shown if it is at most this much older than the frame. The last
# substep, and a margin for rounding.
_RECENT_SUBSTEPS = 1.5


@dataclass(frozen=True)
class Layer:
    """Surface on which a state is drawn, of `time`, s, and `poses` (N, 3).

    `image` has `scale` pixels per m around `centre`, m.
    """

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
        return np.subtract(points, self.centre) * (self.scale, -self.scale) + middle

    def holds(self, points: ArrayLike, margin: float) -> NDArray[np.bool_]:
        """Whether each of `points` (..., 2), m, is in view or at most `margin` m outside."""
        half = np.asarray(self.image.size) / (2 * self.scale) + margin
        distances = np.abs(np.subtract(points, self.centre))
        return np.asarray(np.all(distances <= half, axis=-1))

    def disc(self, centre: Sequence[float], radius: float) -> None:
        """Draw a disc of force; lengths in pixels."""
        ImageDraw.Draw(self.image).circle(centre, radius, fill=COLOURS.force)

    def arrow(
        self, begin: Sequence[float], end: Sequence[float], colour: str = COLOURS.motion
    ) -> None:
        """Draw an arrow from a pixel to another one."""
        tip = complex(*end)
        along = tip - complex(*begin)
        length = abs(along)
        if length < _MIN_ARROW_LENGTH:
            return

        neck = tip - min(_ARROWHEAD_LENGTH / length, 1) * along
        across = 1j * _ARROWHEAD_HALF_WIDTH * along / length
        head = [(point.real, point.imag) for point in (tip, neck + across, neck - across)]
        draw = ImageDraw.Draw(self.image)
        draw.line((*begin, neck.real, neck.imag), fill=colour, width=_SHAFT_WIDTH)
        draw.polygon(head, fill=colour)

    def arrows(self, points: Array, vectors: Array) -> None:
        """Draw arrows of motion, m, from `points` (K, 2) along `vectors` (K, 2).

        Arrows that cannot be in view are left out.
        """
        longest = float(np.linalg.norm(vectors, axis=-1).max())
        seen = self.holds(points, longest)
        begins = self.pixels(points[seen]).tolist()
        ends = self.pixels((points + vectors)[seen]).tolist()
        for begin, end in zip(begins, ends, strict=True):
            self.arrow(begin, end)


@dataclass(frozen=True)
class _Overlay:
    """Kind of overlay: what it shows, for the help, and a function that draws it.

    `needs` is an attribute of a `Run` that marches and some runs do not have; `below` is whether
    the overlay lies below the benches.
    """

    shows: str
    draw: Callable[[Layer], None]
    needs: str | None = None
    below: bool = False


def check_overlays(names: Collection[str], source: Snapshots) -> None:
    """Raise a ParameterError if the source has no data for one of the overlays `names`."""
    for name in names:
        needs = OVERLAYS[name].needs
        if needs and getattr(source.run, needs, None) is None:
            bound = "left out: a march has no contacts, and the exact model has no forces"
            raise ParameterError("show", name, bound)


def draw_overlays(layer: Layer, names: Collection[str], *, below: bool = False) -> None:
    """Draw the overlays with these names that lie above, or below, the benches."""
    for name, overlay in OVERLAYS.items():
        if name in names and overlay.below == below:
            overlay.draw(layer)


def _touches(run: Run, time: float) -> list[_Touch]:
    """Contact points, m, and the normal of each contact at a time.

    They are those of the last callback in the last substep; before all callbacks, of the refined
    first contact.
    """
    since = time - _RECENT_SUBSTEPS * (run.substep or 0.0)
    when = attrgetter("time")
    begin = bisect_right(run.events, since, key=when)
    end = bisect_right(run.events, time, key=when)
    if end > 0:
        last: dict[tuple[int, int], _Touch] = {}
        for event in run.events[begin:end]:
            if event.normal:
                last[event.benches] = event.points, event.normal
        return list(last.values())

    first = run.first_contact
    return [([first.point], first.normal)] if first and time >= first.time else []


def _draw_velocities(layer: Layer) -> None:
    front, rear = layer.dragon.holes(layer.poses)
    motion = _ARROW_TIME * layer.source.velocities(layer.time, layer.poses)
    layer.arrows(np.concatenate([front, rear[-1:]]), motion)


def _draw_forces(layer: Layer) -> None:
    run = layer.source.run
    assert run is not None  # Marches are refused.
    assert run.joint_forces is not None
    largest = float(run.joint_forces.max(initial=0.0)) or 1.0

    # Forces are not interpolated: they are those of the frame before.
    frame = np.searchsorted(run.times, layer.time, side="right") - 1
    # The disc's area is proportional to the force.
    shares = np.sqrt(run.joint_forces[frame] / largest)
    radii = _DISC_RADIUS * float(layer.dragon.widths.min()) * layer.scale * shares
    _, rear = layer.dragon.holes(layer.poses)
    centres = layer.pixels(rear[:-1]).tolist()
    for centre, radius in zip(centres, radii.tolist(), strict=True):
        layer.disc(centre, radius)


def _draw_contacts(layer: Layer) -> None:
    assert layer.source.run is not None  # Marches are refused.
    for points, normal in _touches(layer.source.run, layer.time):
        centres = layer.pixels(points)
        for centre in centres.tolist():
            layer.disc(centre, _CONTACT_RADIUS)
        begin = centres.mean(axis=0)
        # y points downwards in a picture.
        end = begin + _NORMAL_LENGTH * np.array(normal) * (1, -1)
        layer.arrow(begin.tolist(), end.tolist(), COLOURS.force)


def _draw_grid(layer: Layer) -> None:
    """Tint the cells that contain a bench, and draw the lines between cells."""
    grid = Grid.of(layer.source.march)
    cell = grid.cell * layer.scale
    if cell < _MIN_CELL_SIZE:
        return

    draw = ImageDraw.Draw(layer.image, "RGBA")
    colour = ImageColor.getrgb(COLOURS.grid)
    left, top = layer.pixels(grid.origin).tolist()
    filed, _ = grid.file(layer.dragon.outlines(layer.poses))
    for i, j in np.unique(filed, axis=0).tolist():
        x0, x1 = round(j * cell + left), round((j + 1) * cell + left)
        y0, y1 = round(i * cell + top), round((i + 1) * cell + top)
        draw.rectangle((x0, y0, x1 - 1, y1 - 1), fill=(*colour, _CELL_TINT))

    width, height = layer.image.size
    columns = np.arange(left % cell, width, cell).tolist()
    rows = np.arange(top % cell, height, cell).tolist()
    lines = [(x, 0, x, height) for x in columns]
    lines += [(0, y, width, y) for y in rows]
    for line in lines:
        draw.line(line, fill=(*colour, _LINE_TINT), width=BLOCK)


# All overlays by name, in the order in which they are drawn.
OVERLAYS: Mapping[str, _Overlay] = {
    "velocities": _Overlay(
        "Arrows to where the handles would be in half a second.", _draw_velocities
    ),
    "grid": _Overlay(
        "The cells of the broad phase, darker where a bench is filed.", _draw_grid, below=True
    ),
    "contacts": _Overlay("Contact points and normals.", _draw_contacts, "events"),
    "forces": _Overlay("Forces in the joints, as discs.", _draw_forces, "joint_forces"),
}
