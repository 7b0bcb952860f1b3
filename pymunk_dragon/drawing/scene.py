"""Draws the state of a dragon as a picture."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import text
from pymunk_dragon.collision import separation
from pymunk_dragon.drawing.camera import Camera, View
from pymunk_dragon.drawing.lettering import Lettering
from pymunk_dragon.drawing.overlay import Layer, draw_errors, draw_overlays
from pymunk_dragon.drawing.palette import BLOCK, Palette
from pymunk_dragon.drawing.snapshots import Snapshot
from pymunk_dragon.model.contact import Contact
from pymunk_dragon.model.dragon import Dragon, outlines
from pymunk_dragon.model.march import March

# m: diameter of a hole in the paper. Only pictures depend on it.
_HOLE_DIAMETER = 0.055
# Largest diameter of a hole as a fraction of a bench's width and twice its overhang, so that the holes of a small bench
# stay inside its outline.
_MAX_HOLE_FRACTION = 0.4
# Drawn pixels: a smaller hole is not recognisable. Films of the reference scenario's whole field show holes from 850
# pixels on.
_MIN_HOLE_DIAMETER = 4.0
# Drawn pixels between points of the curve: long enough to be smooth in whole pixels, short enough to appear round.
_CURVE_STEP = 6.0
# Points of the curve: limits memory if the curve is much longer than the view.
MAX_CURVE_POINTS = 200_000
# Width of the curve as a fraction of a bench's width; it is at least one drawn pixel.
_CURVE_WIDTH = 0.04
# Pixels: radius of the ring around a contact, and width of a bench from which it is drawn: it would hide smaller ones.
_RING_RADIUS, _RING_BENCH_WIDTH = 9, 3
# Pixels: width of the border of a head in contact; a head narrower than four of them has none, to keep its colour.
_HEAD_BORDER, _HEAD_BORDERS = 3, 4
# Pixels: length of the dashes of a circle, and of the gaps between them.
CIRCLE_DASH = 4
# m: smaller gaps are near misses, displayed with tenths of a millimetre and a ring; larger ones are displayed in m.
_SMALL_GAP, _LARGE_GAP = 0.01, 1.0


class Nearest(NamedTuple):
    """Bench closest to the head bench: its number, the distance, m, and the point midway between both, m."""

    bench: int
    distance: float
    point: tuple[float, float]


@dataclass(frozen=True)
class Scene:
    """Renderer of the states of a march at a constant scale.

    `centre`, m, is that of the view of a fixed camera, `span` the width of the view, m, and `size` that of pictures,
    pixels. A curve without ends is drawn for `times`, s, of the first and last picture. From the time of `contact` on,
    its benches have the contact colour. `gap` is that of a `Film`, and `show` has names of `OVERLAYS`.
    `largest_impulse`, N s, has the largest disc. `magnification` is the factor of the position errors in the snapshots'
    `displaced` poses. Pictures without contact or gap display the film's first time, `since`, s, if it is given.
    """

    march: March
    camera: Camera
    _: KW_ONLY
    centre: tuple[float, float]
    span: float
    size: tuple[int, int]
    palette: Palette
    times: tuple[float, float]
    contact: Contact | None
    gap: bool | None
    show: tuple[str, ...]
    largest_impulse: float
    magnification: float | None
    since: float | None
    font: str | Path | None

    @property
    def scale(self) -> float:
        """Pixels per m."""
        return self.size[0] / self.span

    def view(self, poses: Array) -> View:
        """Return the view of a picture of the benches at `poses` (N, 3), in drawn pixels."""
        x, y = self.centre if self.camera.follow == "field" else poses[0, :2].tolist()
        return View((x, y), self.scale * BLOCK, (self.size[0] * BLOCK, self.size[1] * BLOCK))

    def draw(self, snapshot: Snapshot) -> Image.Image:
        """Draw a snapshot (mode RGB)."""
        view = self.view(snapshot.poses)
        image = self._fixed_ground.copy() if self.camera.follow == "field" else self._ground(view)
        layer = Layer(image, view, snapshot, self.march, self.palette, self.largest_impulse)
        contact = self.contact if self.contact and snapshot.time >= self.contact.time else None
        nearest = None if contact else self._nearest(snapshot.poses)
        draw_overlays(layer, self.show, below=True)
        _draw_benches(layer, contact.benches if contact else ())
        if event := contact or (nearest if nearest and nearest.distance < _SMALL_GAP else None):
            _draw_ring(layer, event.point)
        draw_errors(layer)
        draw_overlays(layer, self.show)
        picture = image.reduce(BLOCK)
        speed = float(self.march.speed_profile.at(snapshot.time))
        self._lettering.put(picture, f"t = {snapshot.time:.2f} s", text("head {:.2f} m/s").format(speed))
        self._lettering.put(picture, *self._lower_texts(snapshot, contact, nearest), bottom=True)
        return picture

    @cached_property
    def _lettering(self) -> Lettering:
        return Lettering(self.size, self.palette, font=self.font)

    @cached_property
    def _curve(self) -> Array:
        """Points (P, 2), m, of the curve. The interval always includes the dragon's position at 0 s."""
        first, last = self.march.span(min(self.times[0], 0.0), max(self.times[1], 0.0))
        points = min(int((last - first) * self.scale * BLOCK / _CURVE_STEP) + 2, MAX_CURVE_POINTS)
        return self.march.curve.point(np.linspace(first, last, points))

    @cached_property
    def _fixed_ground(self) -> Image.Image:
        return self._ground(self.view(np.zeros((1, 3))))

    def _ground(self, view: View) -> Image.Image:
        """Draw the curve and its circles."""
        image = Image.new("RGB", view.size, self.palette.rgb("background"))
        draw = ImageDraw.Draw(image)
        seen = view.holds(self._curve, 2 * _CURVE_STEP / view.scale)
        width = max(1, round(_CURVE_WIDTH * self.march.dragon.widths.min() * view.scale))
        # One polyline for every visible part of the curve.
        borders = np.flatnonzero(np.diff(np.concatenate([[False], seen, [False]]).astype(np.int8)))
        for first, last in borders.reshape(-1, 2).tolist():
            points = np.floor(view.pixels(self._curve[first:last])).ravel().tolist()
            draw.line(points, fill=self.palette.rgb("curve"), width=width)
        for x, y, radius in self.march.curve.circles:
            dashes = max(8, round(math.pi * radius * view.scale / (CIRCLE_DASH * BLOCK)))
            box = [*(view.pixels((x, y)) - radius * view.scale), *(view.pixels((x, y)) + radius * view.scale)]
            for dash in range(dashes):
                angles = 360 * dash / dashes, 360 * (dash + 0.5) / dashes
                draw.arc(box, *angles, fill=self.palette.rgb("ink"), width=BLOCK)
        return image

    def _nearest(self, poses: Array) -> Nearest | None:
        """Return the bench closest to the head bench if its gap is displayed."""
        nearest = None if self.gap is False else smallest_gap(self.march.dragon, poses)
        always = self.gap or self.camera.follow == "head"
        return nearest if nearest and (always or nearest.distance < _SMALL_GAP) else None

    def _lower_texts(self, snapshot: Snapshot, contact: Contact | None, nearest: Nearest | None) -> tuple[str, str]:
        """Return the texts in the lower left and right corners."""
        left = "" if self.since is None else text("from t = {:g} s").format(self.since)
        if contact:
            # Short, to fit into a corner beside the spiral.
            left = text("contact: benches {} and {}").format(*contact.benches)
        elif snapshot.error is not None:
            left = text("position error up to {:.4f} mm").format(1e3 * snapshot.error)
        elif nearest:
            left = text("gap {gap} to bench {bench}").format(gap=_length(nearest.distance), bench=nearest.bench)
        if snapshot.impulses is None:
            return left, ""
        return left, text("joints up to {} N s").format(_impulse(float(snapshot.impulses.max())))


def hole_diameter(dragon: Dragon) -> float:
    """Return the diameter of a dragon's holes in pictures, m."""
    return min(_HOLE_DIAMETER, _MAX_HOLE_FRACTION * float(np.minimum(dragon.widths, 2 * dragon.overhangs).min()))


def smallest_gap(dragon: Dragon, poses: Array) -> Nearest | None:
    """Return the bench closest to the head bench at `poses` (N, 3), its neighbour excluded; None if there is none.

    The distance is 0 if the benches overlap.

    Examples
    --------
    >>> from pymunk_dragon import March
    >>> march = March()
    >>> nearest = smallest_gap(march.dragon, march.at(409.8).poses[0])
    >>> nearest.bench, round(1000 * nearest.distance, 2)
    (11, 0.87)
    """
    if dragon.benches < 3:
        return None
    corners = dragon.outlines(poses)
    found = separation(corners[0], corners[2:])
    nearest = int(np.argmin(found.distance))
    x, y = found.point[nearest].tolist()
    return Nearest(nearest + 2, max(0.0, float(found.distance[nearest])), (x, y))


def _draw_benches(layer: Layer, touching: tuple[int, ...]) -> None:
    """Draw benches and holes, from tail to head, so that the head is on top; `touching` benches are in contact."""
    dragon, poses, rgb = layer.march.dragon, layer.snapshot.poses, layer.palette.rgb
    colours = {0: rgb("head"), dragon.benches - 1: rgb("tail")} | dict.fromkeys(touching, rgb("contact"))
    seen = np.flatnonzero(layer.view.holds(poses[:, :2], float(dragon.lengths.max())))[::-1]
    draw, body, ink = ImageDraw.Draw(layer.image), rgb("body"), rgb("ink")
    for bench, polygon in zip(seen.tolist(), _polygons(layer, seen), strict=True):
        draw.polygon(polygon, fill=colours.get(bench, body), outline=ink)
    if 0 in touching:
        # In its own colour, inside a border in the contact colour if the head is wide enough.
        border = 2 * _HEAD_BORDER * BLOCK / layer.view.scale
        wide = dragon.widths[0] * layer.view.scale >= _HEAD_BORDERS * _HEAD_BORDER * BLOCK
        draw.polygon(_polygons(layer, np.array([0]), border * wide)[0], fill=rgb("head"), outline=ink)
    diameter = hole_diameter(dragon) * layer.view.scale
    if diameter >= _MIN_HOLE_DIAMETER:
        holes = np.concatenate([hole[seen] for hole in dragon.holes(poses)])
        corner = np.rint(layer.view.pixels(holes) - diameter / 2)
        for box in np.concatenate([corner, corner + round(diameter) - 1], axis=1).tolist():
            draw.ellipse(box, fill=ink)


def _polygons(layer: Layer, benches: NDArray[np.intp], border: float = 0.0) -> list[list[int]]:
    """Return the outlines of benches in pixels, without a border, m."""
    # ImageDraw also fills the pixels on a polygon's edge, so every side is inset by half a pixel.
    less, dragon = 1 / layer.view.scale + border, layer.march.dragon
    corners = outlines(layer.snapshot.poses[benches], dragon.lengths[benches] - less, dragon.widths[benches] - less)
    polygons: list[list[int]] = np.floor(layer.view.pixels(corners)).astype(int).reshape(-1, 8).tolist()
    return polygons


def _draw_ring(layer: Layer, point: tuple[float, float]) -> None:
    if layer.march.dragon.widths.min() * layer.view.scale >= _RING_BENCH_WIDTH * BLOCK:
        centre = layer.view.pixels(point).tolist()
        ImageDraw.Draw(layer.image).circle(centre, _RING_RADIUS * BLOCK, outline=layer.palette.rgb("ink"), width=BLOCK)


def _length(gap: float) -> str:
    if gap >= _LARGE_GAP:
        return f"{gap:.2f} m"
    return f"{1000 * gap:.{1 if gap < _SMALL_GAP else 0}f} mm"


def _impulse(size: float) -> str:
    """Format an impulse with two significant digits, or as a whole number from 10 on."""
    return f"{size:.0f}" if size >= 10 else f"{size:.2g}"
