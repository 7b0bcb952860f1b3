"""One state of a dragon as a picture of palette indices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from pymunk_dragon.contact import Contact
from pymunk_dragon.dragon import Dragon, outlines
from pymunk_dragon.march import March
from pymunk_dragon.render.camera import Camera, View
from pymunk_dragon.render.gaps import smallest_gap
from pymunk_dragon.render.lettering import Lettering
from pymunk_dragon.render.moments import Mark, Moment
from pymunk_dragon.render.overlay import Overlay
from pymunk_dragon.render.palette import BLOCK, CODES

__all__ = ["Scene", "hole_diameter"]

Array = NDArray[np.float64]

# Metres. Diameter of a hole (contest text); nothing but the picture depends on it. No more than a share of a bench's
# width and overhang, so that a hole in a small one does not break its sides.
HOLE_DIAMETER, MOST_HOLE = 0.055, 0.4
# Drawn pixels: a smaller hole would only be dirt on the bench, and the seed's whole field has none below 850 pixels.
MIN_HOLE = 4.0
# Drawn pixels between points of the curve: long enough to cross whole pixels smoothly, short enough to look round.
CURVE_STEP = 6.0
# Points of the curve at most, so that a huge field seen from close by does not fill the memory.
MAX_CURVE_POINTS = 200_000
# Share of a bench's width that the curve is thick; drawn pixels, so at least one.
CURVE_WIDTH = 0.04
# Pixels shown: radius of the ring around a contact, and width of a bench from which on there is room for it.
RING_RADIUS, RING_BENCH_WIDTH = 9, 16
# Metres of gap below which tenths of a millimetre are worth reading.
SMALL_GAP = 0.01
# Metres from which on they are read in metres.
LARGE_GAP = 1.0


class Scene:
    """Draws a march's states, each from the same distance.

    Parameters
    ----------
    march : March
        What is drawn: the sizes of its benches, its curve, its speed.
    camera : Camera
        What it follows.
    centre : tuple of float
        Middle of the view where the camera stands still, m.
    span : float
        Width of the view, m.
    size : tuple of int
        Width and height of the pictures, pixels.
    times : tuple of float
        First and last time of what is drawn, s: so far a curve is drawn that has no begin or no end of its own.
    contact : Contact, optional
        Benches that take the contact colour from its time on.
    gap : bool
        Whether to write down how near the head is to the nearest bench that is not its neighbour.
    marks : tuple of Mark
        What to lay over the benches.
    largest_impulse : float
        Joint impulse that is drawn largest, N s.

    Attributes
    ----------
    size : tuple of int
        As given.
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
        gap: bool = False,
        marks: tuple[Mark, ...] = (),
        largest_impulse: float = 0.0,
    ) -> None:
        self.march = march
        self.camera = camera
        self.contact = contact
        self.gap = gap
        self.size = size
        self._drawn_size = (size[0] * BLOCK, size[1] * BLOCK)
        self._scale = self._drawn_size[0] / span
        self._lettering = Lettering(size)
        self._overlay = Overlay(march, marks, largest_impulse)
        self._colours = [CODES["head"], *[CODES["body"]] * (march.dragon.benches - 2), CODES["tail"]]
        self._curve = self._sampled_curve(*times)
        self._still = View(centre, self._scale, self._drawn_size)
        self._ground = self._drawn_ground(self._still) if camera.follow == "field" else None

    def draw(self, moment: Moment) -> Image.Image:
        """Picture (mode L, palette indices) of a moment."""
        touching = self.contact if self.contact and moment.time >= self.contact.time else None
        view = self.view(moment.poses)
        canvas = self._ground.copy() if self._ground else self._drawn_ground(view)
        self._draw_benches(canvas, view, moment.poses, touching)
        picture = self._overlay.over(canvas.reduce(BLOCK), view, moment)
        self._write(picture, moment, touching)
        return picture

    def view(self, poses: Array) -> View:
        """What a picture of the benches at `poses` (N, 3) shows, at the size at which it is drawn."""
        if self.camera.follow == "field":
            return self._still
        return View((float(poses[0, 0]), float(poses[0, 1])), self._scale, self._drawn_size)

    def _sampled_curve(self, since: float, until: float) -> Array:
        """Points of the curve, (P, 2) in m; from where the dragon stands at 0 s even if the film is later."""
        first, last = self.march.span(min(since, 0.0), max(until, 0.0))
        points = min(int((last - first) * self._scale / CURVE_STEP) + 2, MAX_CURVE_POINTS)
        return self.march.curve.point(np.linspace(first, last, points))

    def _drawn_ground(self, view: View) -> Image.Image:
        canvas = Image.new("L", self._drawn_size, CODES["background"])
        draw = ImageDraw.Draw(canvas)
        seen = view.holds(self._curve, 2 * CURVE_STEP / self._scale)
        # One line for every stretch of the curve that is in view.
        borders = np.flatnonzero(np.diff(np.concatenate([[False], seen, [False]]).astype(np.int8)))
        points = np.floor(view.pixels(self._curve[seen]))
        width = max(1, round(CURVE_WIDTH * self.march.dragon.widths.min() * self._scale))
        begin = 0
        for first, last in borders.reshape(-1, 2).tolist():
            draw.line(points[begin : begin + last - first].ravel().tolist(), fill=CODES["curve"], width=width)
            begin += last - first
        return canvas

    def _draw_benches(self, canvas: Image.Image, view: View, poses: Array, touching: Contact | None) -> None:
        dragon = self.march.dragon
        # ImageDraw fills the pixels on a polygon's edge too: half a pixel less on every side gives the true size.
        pixel = 1 / self._scale
        corners = outlines(poses, dragon.lengths - pixel, dragon.widths - pixel)
        seen = np.flatnonzero(view.holds(poses[:, :2], float(dragon.lengths.max())))
        polygons = np.floor(view.pixels(corners[seen])).astype(int).reshape(-1, 8).tolist()
        draw = ImageDraw.Draw(canvas)
        ink = CODES["ink"]
        # From tail to head, so that the head lies on top.
        for bench, polygon in zip(seen[::-1].tolist(), polygons[::-1], strict=True):
            colour = CODES["contact"] if touching and bench in touching.benches else self._colours[bench]
            draw.polygon(polygon, fill=colour, outline=ink)
        diameter = hole_diameter(dragon) * self._scale
        if diameter >= MIN_HOLE:
            front, rear = dragon.holes(poses)
            holes = np.concatenate([front[seen], rear[seen]])
            corner = np.rint(view.pixels(holes) - diameter / 2)
            boxes = np.concatenate([corner, corner + round(diameter) - 1], axis=1)
            for box in boxes.tolist():
                draw.ellipse(box, fill=ink)
        if touching and dragon.widths.min() * self._scale >= RING_BENCH_WIDTH * BLOCK:
            x, y = view.pixels(touching.point).tolist()
            radius = RING_RADIUS * BLOCK
            draw.ellipse((x - radius, y - radius, x + radius, y + radius), outline=ink, width=BLOCK)

    def _write(self, picture: Image.Image, moment: Moment, touching: Contact | None) -> None:
        left = right = ""
        if touching:
            # Short, to fit into the corner beside a round field.
            left = "bench {} hits {}".format(*touching.benches)
        elif self.gap and (nearest := smallest_gap(self.march.dragon, moment.poses)):
            bench, gap = nearest
            left = f"gap {_length(gap)} to bench {bench}"
        if moment.impulses is not None:
            right = f"joints up to {_impulse(float(moment.impulses.max()))} N s"
        self._lettering.put(
            picture, f"t = {moment.time:.2f} s", f"{float(self.march.speed_profile.at(moment.time)):.2f} m/s"
        )
        self._lettering.put(picture, left, right, bottom=True)


def hole_diameter(dragon: Dragon) -> float:
    """Diameter of a dragon's holes in pictures, m."""
    return min(HOLE_DIAMETER, MOST_HOLE * float(np.minimum(dragon.widths, 2 * dragon.overhangs).min()))


def _length(gap: float) -> str:
    if gap >= LARGE_GAP:
        return f"{gap:.2f} m"
    return f"{1000 * gap:.{1 if gap < SMALL_GAP else 0}f} mm"


def _impulse(size: float) -> str:
    """Two digits, or all before the point."""
    return f"{size:.0f}" if size >= 10 else f"{size:.2g}"
