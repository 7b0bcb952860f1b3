"""Draws the state of a dragon as a picture of palette indices."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image, ImageDraw

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import text
from pymunk_dragon.collision import separation
from pymunk_dragon.drawing.camera import Camera, View
from pymunk_dragon.drawing.lettering import Lettering
from pymunk_dragon.drawing.overlay import Overlays
from pymunk_dragon.drawing.palette import BLOCK, CODES
from pymunk_dragon.drawing.snapshot import Snapshot
from pymunk_dragon.model.contact import Contact
from pymunk_dragon.model.dragon import Dragon, outlines
from pymunk_dragon.model.march import March

# Metres: diameter of a hole in the paper. Only pictures depend on it.
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
# Pixels: radius of the ring around a contact.
RING_RADIUS = 9
# Pixels: width of a bench from which the ring is drawn. It would hide smaller benches.
RING_BENCH_WIDTH = 3
# Pixels: width of the border of a head in contact.
HEAD_BORDER = 3
# Widths of the border: a narrower head has none, because its own colour would not be visible.
HEAD_BORDERS = 4
# Pixels: length of the dashes of a circle, and of the gaps between them.
CIRCLE_DASH = 4
# Metres: smaller gaps are near misses, displayed with tenths of a millimetre and a ring.
SMALL_GAP = 0.01
# Metres: larger gaps are displayed in metres.
LARGE_GAP = 1.0


@dataclass(frozen=True)
class Words:
    """Texts of a scene in the language in which it was created: other processes draw it without that context."""

    contact: str = field(default_factory=lambda: text("contact: benches {} and {}"))
    gap: str = field(default_factory=lambda: text("gap {gap} to bench {bench}"))
    impulses: str = field(default_factory=lambda: text("joints up to {} N s"))
    error: str = field(default_factory=lambda: text("position error up to {:.4f} mm"))
    since: str = field(default_factory=lambda: text("from t = {:g} s"))
    speed: str = field(default_factory=lambda: text("head {:.2f} m/s"))


class Nearest(NamedTuple):
    """Bench closest to the head bench: its number, the distance, m, and the point midway between both, m."""

    bench: int
    distance: float
    point: tuple[float, float]


class Scene:
    """Renderer of the states of a march at a constant scale.

    Parameters
    ----------
    march : March
        March whose bench sizes, curve and speed are drawn.
    camera : Camera
        What the view follows.
    centre : tuple of float
        Centre of the view of a fixed camera, m.
    span : float
        Width of the view, m.
    size : tuple of int
        Width and height of the pictures, pixels.
    times : tuple of float
        First and last time of the pictures, s. An unbounded curve is drawn for this time interval.
    contact : Contact, optional
        Contact whose benches are drawn in the contact colour from its time on; the head has a border of that colour.
    gap : bool, optional
        Whether to display the gap between the head and the closest bench that is not its neighbour. By default it is
        displayed if the camera follows the head or the gap is below 1 cm.
    marks : tuple of str
        Names of `OVERLAYS` to draw.
    largest_impulse : float
        Joint impulse that is drawn with the largest disc, N s.
    magnification : float, optional
        Factor of the position errors in the snapshots' `displaced` poses, for the legend.
    since : float, optional
        First time of the film, s, if the pictures display it: where there is neither a contact nor a gap to display.
    font : str or Path, optional
        Font file of the texts in the picture.

    Attributes
    ----------
    size : tuple of int
        As given.

    Examples
    --------
    >>> from pymunk_dragon import Camera, Dragon, March, Scene
    >>> from pymunk_dragon.drawing import Snapshot
    >>> march = March(Dragon(benches=16))
    >>> scene = Scene(march, Camera(), centre=(0.0, 0.0), span=24.0, size=(320, 320))
    >>> picture = scene.draw(Snapshot(time=60.0, poses=march.at(60.0).poses[0]))
    >>> picture.mode, picture.size
    ('L', (320, 320))
    """

    def __init__(
        self,
        march: March,
        camera: Camera,
        *,
        centre: tuple[float, float],
        span: float,
        size: tuple[int, int],
        times: tuple[float, float] = (0.0, 0.0),
        contact: Contact | None = None,
        gap: bool | None = False,
        marks: tuple[str, ...] = (),
        largest_impulse: float = 0.0,
        magnification: float | None = None,
        since: float | None = None,
        font: str | Path | None = None,
    ) -> None:
        self.march = march
        self.camera = camera
        self.contact = contact
        self.gap = gap
        self.magnification = magnification
        self.size = size
        self._drawn_size = (size[0] * BLOCK, size[1] * BLOCK)
        self._scale = self._drawn_size[0] / span
        self._text = Lettering(size, font=font)
        self._words = Words()
        self._since = "" if since is None else self._words.since.format(since)
        self._overlay = Overlays(march, marks, largest_impulse)
        self._colours = [CODES["head"], *[CODES["body"]] * (march.dragon.benches - 2), CODES["tail"]]
        self._curve = self._sample_curve(*times)
        self._fixed_view = View(centre, self._scale, self._drawn_size)
        self._background = self._draw_background(self._fixed_view) if camera.follow == "field" else None

    @property
    def scale(self) -> float:
        """Pixels per m."""
        return self._scale / BLOCK

    def draw(self, snapshot: Snapshot) -> Image.Image:
        """Draw a snapshot (mode L, palette indices)."""
        touching = self.contact if self.contact and snapshot.time >= self.contact.time else None
        view = self.view(snapshot.poses)
        image = self._background.copy() if self._background else self._draw_background(view)
        nearest = None if touching or self.gap is False else smallest_gap(self.march.dragon, snapshot.poses)
        near = nearest if nearest is not None and nearest.distance < SMALL_GAP else None
        self._draw_benches(image, view, snapshot.poses, touching)
        if (event := touching or near) and self.march.dragon.widths.min() * self.scale >= RING_BENCH_WIDTH:
            self._draw_ring(image, view, event.point)
        picture = self._overlay.over(image.reduce(BLOCK), view, snapshot)
        self._write_text(picture, snapshot, touching, nearest if self.gap or self.camera.follow == "head" else near)
        return picture

    def view(self, poses: Array) -> View:
        """Return the view of a picture of the benches at `poses` (N, 3), in drawn pixels."""
        if self.camera.follow == "field":
            return self._fixed_view
        return View((float(poses[0, 0]), float(poses[0, 1])), self._scale, self._drawn_size)

    def _sample_curve(self, since: float, until: float) -> Array:
        """Sample the curve: points (P, 2), m. The interval always includes the dragon's position at 0 s."""
        first, last = self.march.span(min(since, 0.0), max(until, 0.0))
        points = min(int((last - first) * self._scale / CURVE_STEP) + 2, MAX_CURVE_POINTS)
        return self.march.curve.point(np.linspace(first, last, points))

    def _draw_background(self, view: View) -> Image.Image:
        image = Image.new("L", self._drawn_size, CODES["background"])
        draw = ImageDraw.Draw(image)
        seen = view.holds(self._curve, 2 * CURVE_STEP / self._scale)
        # One polyline for every visible part of the curve.
        borders = np.flatnonzero(np.diff(np.concatenate([[False], seen, [False]]).astype(np.int8)))
        points = np.floor(view.pixels(self._curve[seen]))
        width = max(1, round(CURVE_WIDTH * self.march.dragon.widths.min() * self._scale))
        begin = 0
        for first, last in borders.reshape(-1, 2).tolist():
            draw.line(points[begin : begin + last - first].ravel().tolist(), fill=CODES["curve"], width=width)
            begin += last - first
        for x, y, radius in self.march.curve.circles:
            _draw_circle(draw, view.pixels((x, y)).tolist(), radius * self._scale)
        return image

    def _draw_benches(self, image: Image.Image, view: View, poses: Array, touching: Contact | None) -> None:
        dragon = self.march.dragon
        # ImageDraw also fills the pixels on a polygon's edge, so every side is inset by half a pixel.
        pixel = 1 / self._scale
        corners = outlines(poses, dragon.lengths - pixel, dragon.widths - pixel)
        seen = np.flatnonzero(view.holds(poses[:, :2], float(dragon.lengths.max())))
        polygons = np.floor(view.pixels(corners[seen])).astype(int).reshape(-1, 8).tolist()
        draw = ImageDraw.Draw(image)
        ink = CODES["ink"]
        # From tail to head, so that the head is drawn on top.
        for bench, polygon in zip(seen[::-1].tolist(), polygons[::-1], strict=True):
            colour = CODES["contact"] if touching and bench in touching.benches else self._colours[bench]
            draw.polygon(polygon, fill=colour, outline=ink)
        if touching and 0 in touching.benches:
            self._draw_head_in_contact(draw, view, poses[:1])
        diameter = hole_diameter(dragon) * self._scale
        if diameter >= MIN_HOLE_DIAMETER:
            front, rear = dragon.holes(poses)
            holes = np.concatenate([front[seen], rear[seen]])
            corner = np.rint(view.pixels(holes) - diameter / 2)
            boxes = np.concatenate([corner, corner + round(diameter) - 1], axis=1)
            for box in boxes.tolist():
                draw.ellipse(box, fill=ink)

    def _draw_head_in_contact(self, draw: ImageDraw.ImageDraw, view: View, pose: Array) -> None:
        """Draw the head in its own colour, inside a border in the contact colour if the head is wide enough."""
        dragon = self.march.dragon
        border = 1 / self._scale
        if dragon.widths[0] * self.scale >= HEAD_BORDERS * HEAD_BORDER:
            border += 2 * HEAD_BORDER / self.scale
        corners = outlines(pose, dragon.lengths[:1] - border, dragon.widths[:1] - border)
        polygon = np.floor(view.pixels(corners)).astype(int).ravel().tolist()
        draw.polygon(polygon, fill=CODES["head"], outline=CODES["ink"])

    def _draw_ring(self, image: Image.Image, view: View, point: tuple[float, float]) -> None:
        x, y = view.pixels(point).tolist()
        radius = RING_RADIUS * BLOCK
        box = (x - radius, y - radius, x + radius, y + radius)
        ImageDraw.Draw(image).ellipse(box, outline=CODES["ink"], width=BLOCK)

    def _write_text(
        self, picture: Image.Image, snapshot: Snapshot, touching: Contact | None, nearest: Nearest | None
    ) -> None:
        words = self._words
        left, right = self._since, ""
        if touching:
            # Short, to fit into a corner beside the spiral.
            left = words.contact.format(*touching.benches)
        elif snapshot.error is not None:
            left = words.error.format(1e3 * snapshot.error)
        elif nearest is not None:
            left = words.gap.format(gap=_length(nearest.distance), bench=nearest.bench)
        if snapshot.impulses is not None:
            right = words.impulses.format(_impulse(float(snapshot.impulses.max())))
        speed = float(self.march.speed_profile.at(snapshot.time))
        self._text.put(picture, f"t = {snapshot.time:.2f} s", words.speed.format(speed))
        self._text.put(picture, left, right, bottom=True)


def _draw_circle(draw: ImageDraw.ImageDraw, centre: tuple[float, float], radius: float) -> None:
    """Draw a dashed circle; lengths are in drawn pixels."""
    x, y = centre
    dashes = max(8, round(math.pi * radius / (CIRCLE_DASH * BLOCK)))
    for dash in range(dashes):
        begin, end = 360 * dash / dashes, 360 * (dash + 0.5) / dashes
        draw.arc((x - radius, y - radius, x + radius, y + radius), begin, end, fill=CODES["ink"], width=BLOCK)


def hole_diameter(dragon: Dragon) -> float:
    """Return the diameter of a dragon's holes in pictures, m."""
    return min(HOLE_DIAMETER, MAX_HOLE_FRACTION * float(np.minimum(dragon.widths, 2 * dragon.overhangs).min()))


def smallest_gap(dragon: Dragon, poses: Array) -> Nearest | None:
    """Return the bench closest to the head bench, its neighbour excluded, and the gap in m.

    Parameters
    ----------
    dragon : Dragon
        Sizes of the benches.
    poses : ndarray, shape (N, 3)
        Poses of the benches: centres in m, angles in rad.

    Returns
    -------
    Nearest or None
        Number of the bench, the gap in m, which is 0 if the benches overlap, and the point midway between both. None if
        the dragon has fewer than 3 benches.

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
