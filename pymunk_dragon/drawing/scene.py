"""Draws the state of a dragon as a picture."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image, ImageDraw

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import text
from pymunk_dragon.collision import separation
from pymunk_dragon.drawing.camera import Camera, View
from pymunk_dragon.drawing.lettering import Lettering
from pymunk_dragon.drawing.overlay import OVERLAYS, Layer, draw_errors
from pymunk_dragon.drawing.palette import BLOCK, Palette
from pymunk_dragon.drawing.snapshots import Snapshot
from pymunk_dragon.model.contact import Contact
from pymunk_dragon.model.dragon import Dragon, outlines
from pymunk_dragon.model.march import March

# m: diameter of a hole in the paper. Only pictures depend on it.
HOLE_DIAMETER = 0.055
# Largest diameter of a hole as a fraction of a bench's width and twice its overhang, so that the holes of a small bench
# stay inside its outline.
MAX_HOLE_FRACTION = 0.4
# Drawn pixels: a smaller hole is not recognisable. Films of the reference scenario's whole field show holes from 850
# pixels on.
MIN_HOLE_DIAMETER = 4.0
# Drawn pixels between points of the curve: long enough to be smooth in whole pixels, short enough to appear round.
CURVE_STEP = 6.0
# Points of the curve: limits memory if the curve is much longer than the view.
MAX_CURVE_POINTS = 200_000
# Width of the curve as a fraction of a bench's width; it is at least one drawn pixel.
CURVE_WIDTH = 0.04
# Pixels: radius of the ring around a contact, and width of a bench from which it is drawn: it would hide smaller ones.
RING_RADIUS, RING_BENCH_WIDTH = 9, 3
# Pixels: width of the border of a head in contact; a head narrower than four of them has none, to keep its colour.
HEAD_BORDER, HEAD_BORDERS = 3, 4
# Pixels: length of the dashes of a circle, and of the gaps between them.
CIRCLE_DASH = 4
# m: smaller gaps are near misses, displayed with tenths of a millimetre and a ring; larger ones are displayed in m.
SMALL_GAP, LARGE_GAP = 0.01, 1.0


class Nearest(NamedTuple):
    """Bench closest to the head bench: its number, the distance, m, and the point midway between both, m."""

    bench: int
    distance: float
    point: tuple[float, float]


class Scene:
    """Renderer of the states of a march at a constant scale.

    `centre`, m, is that of the view of a fixed camera, `span` the width of the view, m, and `size` that of pictures,
    pixels. A curve without ends is drawn for `times`, s, of the first and last picture. From the time of `contact` on,
    its benches have the contact colour. `gap` is that of a `Film`, and `show` has names of `OVERLAYS`.
    `largest_impulse`, N s, has the largest disc. `magnification` is the factor of the position errors in the snapshots'
    `displaced` poses. Pictures without contact or gap display the film's first time, `since`, s, if it is given.
    """

    def __init__(
        self,
        march: March,
        camera: Camera,
        *,
        centre: tuple[float, float],
        span: float,
        size: tuple[int, int],
        palette: Palette,
        times: tuple[float, float],
        contact: Contact | None,
        gap: bool | None,
        show: tuple[str, ...],
        largest_impulse: float,
        magnification: float | None,
        since: float | None,
        font: str | Path | None,
    ) -> None:
        self.march, self.camera, self.contact, self.size = march, camera, contact, size
        self.magnification = magnification
        self._palette = palette
        self._gap, self._since, self._largest_impulse = gap, since, largest_impulse
        shown = [overlay for name, overlay in OVERLAYS.items() if name in show]
        self._below = [overlay.draw for overlay in shown if overlay.below]
        self._above = [draw_errors, *(overlay.draw for overlay in shown if not overlay.below)]
        self._text = Lettering(size, self._palette, font=font)
        drawn_size = (size[0] * BLOCK, size[1] * BLOCK)
        self._view = View(centre, drawn_size[0] / span, drawn_size)
        body = march.dragon.benches - 2
        self._colours = [self._palette.rgb(name) for name in ("head", *["body"] * body, "tail")]
        self._curve = self._sample_curve(*times)
        self._background = self._draw_background(self._view) if camera.follow == "field" else None

    @property
    def scale(self) -> float:
        """Pixels per m."""
        return self._view.scale / BLOCK

    def draw(self, snapshot: Snapshot) -> Image.Image:
        """Draw a snapshot (mode RGB)."""
        touching = self.contact if self.contact and snapshot.time >= self.contact.time else None
        nearest = None if touching or self._gap is False else smallest_gap(self.march.dragon, snapshot.poses)
        near = nearest if nearest is not None and nearest.distance < SMALL_GAP else None
        view = self.view(snapshot.poses)
        image = self._background.copy() if self._background else self._draw_background(view)
        layer = Layer(image, view, snapshot, self.march, self._palette, self._largest_impulse)
        for draw in self._below:
            draw(layer)
        self._draw_benches(image, view, snapshot.poses, touching)
        if event := touching or near:
            self._draw_ring(image, view, event.point)
        for draw in self._above:
            draw(layer)
        picture = image.reduce(BLOCK)
        self._write_text(picture, snapshot, touching, nearest if self._gap or self.camera.follow == "head" else near)
        return picture

    def view(self, poses: Array) -> View:
        """Return the view of a picture of the benches at `poses` (N, 3), in drawn pixels."""
        if self.camera.follow == "field":
            return self._view
        return View((float(poses[0, 0]), float(poses[0, 1])), self._view.scale, self._view.size)

    def _sample_curve(self, since: float, until: float) -> Array:
        """Sample the curve: points (P, 2), m. The interval always includes the dragon's position at 0 s."""
        first, last = self.march.span(min(since, 0.0), max(until, 0.0))
        points = min(int((last - first) * self._view.scale / CURVE_STEP) + 2, MAX_CURVE_POINTS)
        return self.march.curve.point(np.linspace(first, last, points))

    def _draw_background(self, view: View) -> Image.Image:
        image = Image.new("RGB", view.size, self._palette.rgb("background"))
        draw = ImageDraw.Draw(image)
        seen = view.holds(self._curve, 2 * CURVE_STEP / view.scale)
        width = max(1, round(CURVE_WIDTH * self.march.dragon.widths.min() * view.scale))
        # One polyline for every visible part of the curve.
        borders = np.flatnonzero(np.diff(np.concatenate([[False], seen, [False]]).astype(np.int8)))
        for first, last in borders.reshape(-1, 2).tolist():
            points = np.floor(view.pixels(self._curve[first:last])).ravel().tolist()
            draw.line(points, fill=self._palette.rgb("curve"), width=width)
        for x, y, radius in self.march.curve.circles:
            self._draw_circle(draw, view.pixels((x, y)).tolist(), radius * view.scale)
        return image

    def _draw_circle(self, draw: ImageDraw.ImageDraw, centre: tuple[float, float], radius: float) -> None:
        """Draw a dashed circle; lengths are in drawn pixels."""
        x, y = centre
        dashes = max(8, round(math.pi * radius / (CIRCLE_DASH * BLOCK)))
        for dash in range(dashes):
            box = (x - radius, y - radius, x + radius, y + radius)
            angles = 360 * dash / dashes, 360 * (dash + 0.5) / dashes
            draw.arc(box, *angles, fill=self._palette.rgb("ink"), width=BLOCK)

    def _draw_benches(self, image: Image.Image, view: View, poses: Array, touching: Contact | None) -> None:
        dragon, draw, ink = self.march.dragon, ImageDraw.Draw(image), self._palette.rgb("ink")
        # ImageDraw also fills the pixels on a polygon's edge, so every side is inset by half a pixel.
        pixel = 1 / view.scale
        corners = outlines(poses, dragon.lengths - pixel, dragon.widths - pixel)
        seen = np.flatnonzero(view.holds(poses[:, :2], float(dragon.lengths.max())))
        polygons = np.floor(view.pixels(corners[seen])).astype(int).reshape(-1, 8).tolist()
        # From tail to head, so that the head is drawn on top.
        for bench, polygon in zip(seen[::-1].tolist(), polygons[::-1], strict=True):
            hit = touching and bench in touching.benches
            draw.polygon(polygon, fill=self._palette.rgb("contact") if hit else self._colours[bench], outline=ink)
        if touching and 0 in touching.benches:
            self._draw_head_in_contact(draw, view, poses[:1])
        diameter = hole_diameter(dragon) * view.scale
        if diameter >= MIN_HOLE_DIAMETER:
            front, rear = dragon.holes(poses)
            corner = np.rint(view.pixels(np.concatenate([front[seen], rear[seen]])) - diameter / 2)
            for box in np.concatenate([corner, corner + round(diameter) - 1], axis=1).tolist():
                draw.ellipse(box, fill=ink)

    def _draw_head_in_contact(self, draw: ImageDraw.ImageDraw, view: View, pose: Array) -> None:
        """Draw the head in its own colour, inside a border in the contact colour if the head is wide enough."""
        dragon = self.march.dragon
        border = 1 / view.scale
        if dragon.widths[0] * self.scale >= HEAD_BORDERS * HEAD_BORDER:
            border += 2 * HEAD_BORDER / self.scale
        corners = outlines(pose, dragon.lengths[:1] - border, dragon.widths[:1] - border)
        polygon = np.floor(view.pixels(corners)).astype(int).ravel().tolist()
        draw.polygon(polygon, fill=self._palette.rgb("head"), outline=self._palette.rgb("ink"))

    def _draw_ring(self, image: Image.Image, view: View, point: tuple[float, float]) -> None:
        if self.march.dragon.widths.min() * self.scale < RING_BENCH_WIDTH:
            return
        x, y = view.pixels(point).tolist()
        radius = RING_RADIUS * BLOCK
        box = (x - radius, y - radius, x + radius, y + radius)
        ImageDraw.Draw(image).ellipse(box, outline=self._palette.rgb("ink"), width=BLOCK)

    def _write_text(
        self, picture: Image.Image, snapshot: Snapshot, touching: Contact | None, nearest: Nearest | None
    ) -> None:
        left = "" if self._since is None else text("from t = {:g} s").format(self._since)
        if touching:
            # Short, to fit into a corner beside the spiral.
            left = text("contact: benches {} and {}").format(*touching.benches)
        elif snapshot.error is not None:
            left = text("position error up to {:.4f} mm").format(1e3 * snapshot.error)
        elif nearest is not None:
            left = text("gap {gap} to bench {bench}").format(gap=_length(nearest.distance), bench=nearest.bench)
        right = ""
        if snapshot.impulses is not None:
            right = text("joints up to {} N s").format(_impulse(float(snapshot.impulses.max())))
        speed = float(self.march.speed_profile.at(snapshot.time))
        self._text.put(picture, f"t = {snapshot.time:.2f} s", text("head {:.2f} m/s").format(speed))
        self._text.put(picture, left, right, bottom=True)


def hole_diameter(dragon: Dragon) -> float:
    """Return the diameter of a dragon's holes in pictures, m."""
    return min(HOLE_DIAMETER, MAX_HOLE_FRACTION * float(np.minimum(dragon.widths, 2 * dragon.overhangs).min()))


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


def _length(gap: float) -> str:
    if gap >= LARGE_GAP:
        return f"{gap:.2f} m"
    return f"{1000 * gap:.{1 if gap < SMALL_GAP else 0}f} mm"


def _impulse(size: float) -> str:
    """Format an impulse with two significant digits, or as a whole number from 10 on."""
    return f"{size:.0f}" if size >= 10 else f"{size:.2g}"
