"""Draws the state of a dragon as a picture."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import text
from pymunk_dragon.collision import separation
from pymunk_dragon.drawing import lettering
from pymunk_dragon.drawing.marks import Layer, draw_overlays
from pymunk_dragon.drawing.palette import BLOCK, COLOURS
from pymunk_dragon.drawing.snapshots import Snapshots
from pymunk_dragon.model.contact import Contact
from pymunk_dragon.model.dragon import Dragon, hole_diameter, rectangles
from pymunk_dragon.model.run import Run

# Drawn pixels: a smaller hole is not recognisable. Films of the reference scenario's whole field
# show holes from 850 pixels on.
_MIN_HOLE_DIAMETER = 4.0
# Drawn pixels between points of the curve: long enough to be smooth in whole pixels, short enough
# to appear round.
_CURVE_STEP = 6.0
# Points of the curve: limits memory if the curve is much longer than the view.
_MAX_CURVE_POINTS = 200_000
# Width of the curve as a fraction of the width of the narrowest bench.
_CURVE_WIDTH = 0.04
# Pixels: radius of the ring around a contact or a near miss.
_RING_RADIUS = 9
# Width of the border of a head in contact, as a fraction of its width.
_HEAD_BORDER = 0.12
# m: smaller gaps are near misses, displayed in every film, with a ring.
_SMALL_GAP = 0.01
# Text height as a fraction of the picture's shorter side, readable and small beside the dragon.
_TEXT_HEIGHT = 0.036
# Pixels.
_MIN_TEXT_HEIGHT = 15


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Renderer of the states of a run or march at a constant scale.

    The camera follows the "field" around `centre`, m, or the "head"; `span` is the width of the
    view, m, and `size` that of pictures, pixels. A curve without ends is drawn for `times`, s, of
    the first and last picture. From the time of `contact` on, its benches have the contact colour.
    `show` has names of `OVERLAYS`. The position errors of a run `beside` are drawn as arrows,
    enlarged by `factor`.
    """

    source: Snapshots
    follow: str
    centre: tuple[float, float]
    span: float
    size: tuple[int, int]
    show: tuple[str, ...]
    times: tuple[float, float]
    contact: Contact | None
    beside: Run | None
    factor: float | None

    @property
    def scale(self) -> float:
        """Pixels per m."""
        return self.size[0] / self.span

    def layer(self, time: float, poses: Array) -> Layer:
        """Surface for the benches at `poses` (N, 3), with the curve and its circles."""
        if self.follow == "field":
            return replace(self._field, image=self._field.image.copy(), time=time, poses=poses)
        x, y = poses[0, :2].tolist()
        return self._ground((x, y), time, poses)

    def parts(self, samples: Iterable[tuple[float, Array]]) -> set[str]:
        """Kinds of benches in view in samples: names of the palette's colours."""
        kinds = set[str]()
        half = np.array(self.size) / self.scale / 2
        for time, poses in samples:
            middle = poses[0, :2] if self.follow == "head" else self.centre
            offsets = poses[:, :2] - middle
            seen = np.all(np.abs(offsets) < half, axis=1)
            kinds.update(_kinds(len(poses), self._contact_at(time))[seen].tolist())
        return kinds

    def draw(self, time: float, poses: Array, rate: float | None = None) -> Image.Image:
        """Draw the benches at `poses` (N, 3) and a time, s (mode RGB).

        In a film, `rate` is the simulated time in a second of film, s.
        """
        layer = self.layer(time, poses)
        contact = self._contact_at(time)
        draw_overlays(layer, self.show, below=True)
        _draw_benches(layer, contact)

        below = ""
        if contact:
            # Short, to fit into a corner beside the spiral.
            below = text("contact: benches {} and {}", *contact.benches)
            _draw_ring(layer, contact.point)
        else:
            gap, bench, point = _smallest_gap(layer.dragon, poses)
            if gap < (np.inf if self.follow == "head" else _SMALL_GAP):
                below = text("gap {gap:.1f} mm to bench {bench}", gap=1e3 * gap, bench=bench)
            if gap < _SMALL_GAP:
                _draw_ring(layer, point)

        if self.beside and self.factor and self.beside.times[0] <= time <= self.beside.times[-1]:
            exact = poses[:, :2]
            errors = self.beside.poses_at([time])[0, :, :2] - exact
            layer.arrows(exact, self.factor * errors)
        draw_overlays(layer, self.show)
        speed = float(self.source.march.speed_profile.at(time))
        right = text("head {:.2f} m/s", speed)
        left = f"t = {time:.2f} s"
        if rate is not None:
            left += text(", {:.2g} x real time", rate)
        return self._with_texts(layer.image.reduce(BLOCK), left, right, below)

    def _contact_at(self, time: float) -> Contact | None:
        """First contact, if it has occurred."""
        return self.contact if self.contact and time >= self.contact.time else None

    def _with_texts(self, picture: Image.Image, left: str, right: str, below: str) -> Image.Image:
        """Write texts into the upper corners and the lower left one.

        `right` is omitted if it would overlap `left`.
        """
        height = text_height(self.size)
        first = lettering.line(left, height)
        second = lettering.line(right, height)
        picture.paste(first, (0, 0))
        if first.width + second.width <= picture.width:
            picture.paste(second, (picture.width - second.width, 0))
        if below:
            third = lettering.line(below, height)
            picture.paste(third, (0, picture.height - third.height))
        return picture

    @cached_property
    def _curve(self) -> Array:
        """Points (P, 2), m, of the curve, with the dragon's position at 0 s among them."""
        march = self.source.march
        begin, end = self.times
        first, last = march.span(min(begin, 0.0), max(end, 0.0))
        steps = int((last - first) * self.scale * BLOCK / _CURVE_STEP)
        points = np.linspace(first, last, min(steps + 2, _MAX_CURVE_POINTS))
        return march.curve.point(points)

    @cached_property
    def _field(self) -> Layer:
        return self._ground(self.centre, 0.0, np.empty((0, 3)))

    def _ground(self, centre: tuple[float, float], time: float, poses: Array) -> Layer:
        """Surface with the curve and its circles."""
        width, height = self.size
        image = Image.new("RGB", (width * BLOCK, height * BLOCK), COLOURS.background)
        layer = Layer(image, centre, self.scale * BLOCK, self.source, time, poses)
        draw = ImageDraw.Draw(image)

        # One polyline for every visible part of the curve.
        seen = layer.holds(self._curve, 2 * _CURVE_STEP / layer.scale)
        changes = np.diff(seen.astype(np.int8), prepend=0, append=0)
        curve_width = max(1, round(_CURVE_WIDTH * layer.dragon.widths.min() * layer.scale))
        for first, last in np.flatnonzero(changes).reshape(-1, 2).tolist():
            visible = layer.pixels(self._curve[first:last])
            points = np.floor(visible).ravel().tolist()
            draw.line(points, fill=COLOURS.curve, width=curve_width)

        for x, y, radius in self.source.march.curve.circles:
            middle = layer.pixels((x, y)).tolist()
            draw.circle(middle, radius * layer.scale, outline=COLOURS.ink, width=BLOCK)
        return layer


def text_height(size: tuple[int, int]) -> int:
    """Height of texts in a picture of a size, pixels."""
    return max(_MIN_TEXT_HEIGHT, round(_TEXT_HEIGHT * min(size)))


def _smallest_gap(dragon: Dragon, poses: Array) -> tuple[float, int, tuple[float, float]]:
    """Smallest gap, m, of the head at `poses` (N, 3), to which bench, and where, m.

    Its neighbour, which it always overlaps, is left out.
    """
    if dragon.benches < 3:
        return np.inf, 0, (0.0, 0.0)
    corners = dragon.outlines(poses)
    found = separation(corners[0], corners[2:])
    nearest = int(np.argmin(found.distance))
    x, y = found.point[nearest].tolist()
    return max(0.0, float(found.distance[nearest])), nearest + 2, (x, y)


def _kinds(benches: int, contact: Contact | None) -> NDArray[np.object_]:
    """Kind of each bench, a name of the palette; the head stays the head in a contact."""
    kinds = np.full(benches, "body", dtype=object)
    kinds[-1] = "tail"
    if contact:
        kinds[list(contact.benches)] = "contact"
    kinds[0] = "head"
    return kinds


def _draw_ring(layer: Layer, point: tuple[float, float]) -> None:
    """Draw the ring around a contact or a near miss at a point, m."""
    centre = layer.pixels(point).tolist()
    draw = ImageDraw.Draw(layer.image)
    draw.circle(centre, _RING_RADIUS * BLOCK, outline=COLOURS.ink, width=BLOCK)


def _draw_benches(layer: Layer, contact: Contact | None) -> None:
    """Draw benches and holes, from tail to head, so that the head is on top."""
    dragon = layer.dragon
    poses = layer.poses
    longest = float(dragon.lengths.max())
    seen = np.flatnonzero(layer.holds(poses[:, :2], longest))[::-1]

    # ImageDraw also fills the pixels on a polygon's edge, so every side is inset by half a pixel.
    lengths = dragon.lengths[seen] - 1 / layer.scale
    widths = dragon.widths[seen] - 1 / layer.scale
    corners = layer.pixels(rectangles(poses[seen], lengths, widths))
    polygons = np.floor(corners).reshape(-1, 8).tolist()
    draw = ImageDraw.Draw(layer.image)
    kinds = _kinds(dragon.benches, contact)[seen].tolist()
    for kind, polygon in zip(kinds, polygons, strict=True):
        draw.polygon(polygon, fill=getattr(COLOURS, kind), outline=COLOURS.ink)
        if kind == "head" and contact and contact.benches[0] == 0:
            border = max(1, round(_HEAD_BORDER * dragon.widths[0] * layer.scale))
            draw.polygon(polygon, outline=COLOURS.contact, width=border)

    diameter = hole_diameter(dragon) * layer.scale
    if diameter >= _MIN_HOLE_DIAMETER:
        holes = np.concatenate([hole[seen] for hole in dragon.holes(poses)])
        corner = np.rint(layer.pixels(holes) - diameter / 2)
        boxes = np.concatenate([corner, corner + round(diameter) - 1], axis=1)
        for box in boxes.tolist():
            draw.ellipse(box, fill=COLOURS.ink)
