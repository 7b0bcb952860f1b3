"""Pymunk's debug drawing on Pillow images; no window is needed.

`PillowDrawOptions` draws any space on a Pillow image, with smooth edges, over whatever the image shows already. It
needs nothing else of this package: no dragon, no march, no run.

```python
import pymunk
from PIL import Image

from pymunk_dragon import PillowDrawOptions

space = pymunk.Space()
space.gravity = 0, -9.8
ground = space.static_body
for a, b in [((0, 3), (0, 0)), ((0, 0), (5, 0)), ((5, 0), (5, 3))]:
    space.add(pymunk.Segment(ground, a, b, radius=0.1))
for i in range(33):  # boxes and balls, dropped between two walls
    body = pymunk.Body()
    body.position, body.angle = (0.65 + 0.75 * (i % 6), 0.5 + 0.7 * (i // 6)), i
    box = pymunk.Poly.create_box(body, (0.35 + 0.05 * (i % 7), 0.5), radius=0.03 * (i % 4))
    shape = box if i % 3 else pymunk.Circle(body, 0.16 + 0.02 * (i % 8))
    shape.mass, shape.friction = 1, 0.6
    space.add(body, shape)
for i in range(5):  # Newton's cradle, its last ball drawn aside
    body = pymunk.Body()
    body.position = (6 + 0.5 * i, 0.6) if i < 4 else (9.15, 0.89)
    ball = pymunk.Circle(body, 0.245)
    ball.mass, ball.elasticity, ball.color = 1, 1, (241, 196, 15, 255)
    space.add(body, ball, pymunk.PinJoint(ground, body, (6 + 0.5 * i, 3)))
for _ in range(600):
    space.step(0.005)

image = Image.new("RGB", (1280, 480), "white")
options = PillowDrawOptions(image, positive_y_is_up=True, line_width=2)
options.fit(space, margin=20)
space.debug_draw(options)
image.save("debug_draw.png", optimize=True)
```

![Boxes and balls between two walls, and Newton's cradle](renders/debug_draw.png)

`fit` shows a whole space, or a `pymunk.BB` of it; any other view is a `transform`, as everywhere in Pymunk. For a film
set `image` to a new picture for each frame, and `fit` a box, which keeps the view; Pillow saves the pictures.

Milliseconds of processor time for a picture of 640 x 640 pixels (`python tests/bench/bench_debug_draw.py`, with
matplotlib installed beside it):

| space | Pillow | `pymunk.matplotlib_util` |
| --- | --- | --- |
| 223 benches and their pivots | 28 | 327 |
| pile of 100 boxes and its contacts | 16 | 84 |
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import pairwise

import pymunk
from PIL import Image, ImageDraw
from pymunk.space_debug_draw_options import SpaceDebugColor as Colour

from pymunk_dragon._checks import finite
from pymunk_dragon.errors import ParameterError

__all__ = ["DrawCall", "DrawRecorder", "PillowDrawOptions"]

Point = tuple[float, float]

# Pixels: a thinner line is invisible, a wider one hides the picture.
LINE_WIDTH_RANGE = (0.25, 100.0)
# Pixels around a space: the dots of constraints have a radius of 5.
MARGIN = 10.0
# Line widths: half the length of a collision mark. Chipmunk's is two units of the space, which may be two metres.
COLLISION_MARK = 5.0
# Drawn pixels per pixel along each axis.
SAMPLES = 2
# Drawn pixels: ImageDraw also fills the pixels on a polygon's edge, so every polygon is inset.
EDGE_INSET = 0.38
# Drawn pixels: largest distance between an arc and its chord; and the most chords of an arc.
FLATNESS, MAX_CHORDS = 0.1, 2000
# Drawn pixels: what reaches farther is not drawn, because ImageDraw has integers of 32 bits.
MAX_REACH = 1e9
# Drawn pixels: closer corners are merged, because the direction of so short a side is only rounding error.
SAME_CORNER = 1e-9


@dataclass(slots=True)
class DrawCall:
    """What Pymunk draws for a shape, a constraint or a contact, in the space's units and its own colours, 0 to 255.

    `name` is "circle", "segment" or "polygon" for shapes, "line" or "dot" for constraints, and "contact". `points` has
    a centre, the ends of a line, or corners. The `radius` of a dot is in pixels. Only shapes have an `outline`, and
    only circles an `angle`, rad.
    """

    name: str
    points: tuple[Point, ...]
    radius: float
    fill: Colour
    outline: Colour | None = None
    angle: float = 0.0


class DrawRecorder(pymunk.SpaceDebugDrawOptions):
    """Recorder of Pymunk's debug drawing: `space.debug_draw(recorder)` makes a new list of `calls`, for any painter.

    Chipmunk is written in C, and Python only prints an exception in a function that C calls. That of a shape with a
    wrong `color` is raised by `debug_draw`.

    Examples
    --------
    >>> import pymunk
    >>> from pymunk_dragon.drawing.debug_draw import DrawRecorder
    >>> space = pymunk.Space()
    >>> space.add(pymunk.Circle(space.static_body, 0.5, offset=(2, 1)))
    >>> recorder = DrawRecorder()
    >>> space.debug_draw(recorder)
    >>> recorder.calls[0].name, recorder.calls[0].points, recorder.calls[0].radius
    ('circle', (Vec2d(2.0, 1.0),), 0.5)
    """

    def __init__(self) -> None:
        super().__init__()
        self.calls: list[DrawCall] = []
        self._error: Exception | None = None

    def color_for_shape(self, shape: pymunk.Shape) -> Colour:
        """Return a shape's own colour, or that of its kind of body."""
        try:
            red, green, blue, alpha = map(float, super().color_for_shape(shape))
        except (TypeError, ValueError) as error:
            self._error = error
            return self.shape_static_color
        return Colour(red, green, blue, alpha)

    def draw_circle(self, pos: Point, angle: float, radius: float, outline_color: Colour, fill_color: Colour) -> None:
        """Record a circle with a line from its centre in the direction of `angle`."""
        self.calls.append(DrawCall("circle", (pos,), radius, fill_color, outline_color, angle))

    def draw_segment(self, a: Point, b: Point, color: Colour) -> None:
        """Record a line of a constraint or, if it has the colour of collision points, a contact."""
        contact = color == self.collision_point_color != self.constraint_color
        self.calls.append(DrawCall("contact" if contact else "line", (a, b), 0.0, color))

    def draw_fat_segment(self, a: Point, b: Point, radius: float, outline_color: Colour, fill_color: Colour) -> None:
        """Record a segment with round ends."""
        self.calls.append(DrawCall("segment", (a, b), radius, fill_color, outline_color))

    def draw_polygon(self, verts: Sequence[Point], radius: float, outline_color: Colour, fill_color: Colour) -> None:
        """Record a convex polygon with corners rounded by a radius."""
        self.calls.append(DrawCall("polygon", tuple(verts), radius, fill_color, outline_color))

    def draw_dot(self, size: float, pos: Point, color: Colour) -> None:
        """Record a disc of radius `size`, pixels."""
        self.calls.append(DrawCall("dot", (pos,), size, color))

    def __enter__(self) -> None:
        """Start recording, in the space's own coordinates."""
        self.calls, self._error = [], None
        self._view = self.transform
        self.transform = pymunk.Transform.identity()

    def __exit__(self, *raised: object) -> None:
        """End recording."""
        self.transform = self._view
        if self._error is not None:
            raise self._error


class PillowDrawOptions(DrawRecorder):
    """Debug drawing of a space on a Pillow image: `space.debug_draw(PillowDrawOptions(image))`.

    Shapes, constraints and contacts are drawn with the alpha of their colours, at twice the image's size, which is then
    reduced. `with options:` around calls of the drawing methods draws more, in the space's coordinates.

    Parameters
    ----------
    image : PIL.Image.Image
        Target image, in mode RGB. The attribute can be set, for example to the next frame of a film.
    positive_y_is_up : bool
        Whether y increases upwards from the image's lower edge. If False, y increases downwards from the upper edge as
        in `pymunk.pygame_util`.
    line_width : float
        Width of outlines and lines, pixels. Dots and contacts scale with the line width.

    Raises
    ------
    ParameterError
        If `image` is not an image or has another mode, or `line_width` is not a number from 0.25 to 100.

    Notes
    -----
    `transform`, from the space to pixels, may translate, scale, rotate and mirror. Colours and `flags` are Pymunk's.

    Examples
    --------
    >>> import pymunk
    >>> from PIL import Image
    >>> from pymunk_dragon import PillowDrawOptions
    >>> space = pymunk.Space()
    >>> space.add(pymunk.Circle(space.static_body, 0.5), pymunk.Segment(space.static_body, (-2, -0.6), (2, -0.6), 0.1))
    >>> image = Image.new("RGB", (320, 160), "white")
    >>> options = PillowDrawOptions(image, positive_y_is_up=True)
    >>> options.fit(space)
    >>> space.debug_draw(options)
    >>> image.getpixel((160, 80))
    (149, 165, 166)
    >>> image.save("ball.png")
    """

    def __init__(self, image: Image.Image, *, positive_y_is_up: bool = False, line_width: float = 1.0) -> None:
        super().__init__()
        self.image = image
        self.positive_y_is_up = positive_y_is_up
        self.line_width = finite("line_width", line_width, *LINE_WIDTH_RANGE, "pixels")

    @property
    def image(self) -> Image.Image:
        """Target image."""
        return self._image

    @image.setter
    def image(self, image: Image.Image) -> None:
        if not isinstance(image, Image.Image):
            raise ParameterError("image", image, "a PIL.Image.Image")
        if image.mode != "RGB":
            raise ParameterError("image.mode", image.mode, "RGB")
        self._image = image

    def fit(self, area: pymunk.Space | pymunk.BB, margin: float = MARGIN) -> None:
        """Set `transform` so that a space, or a part of it, fills the image but for a margin, pixels, and is centred.

        Raises
        ------
        ParameterError
            If `area` has no extent (for example an empty space), or `margin` leaves less than 2 pixels.
        """
        width, height = self.image.size
        margin = finite("margin", margin, 0, min(width, height) / 2 - 1, "pixels")
        box = _extent(area) if isinstance(area, pymunk.Space) else area
        box_width, box_height = box.right - box.left, box.top - box.bottom
        if not (min(box_width, box_height) >= 0 and 0 < max(box_width, box_height) < math.inf):
            raise ParameterError("area", area, "something that has a size")
        sizes = ((width, box_width), (height, box_height))
        scale = min((pixels - 2 * margin) / size for pixels, size in sizes if size > 0)
        x, y = box.center()
        self.transform = pymunk.Transform(scale, 0, 0, scale, width / 2 - scale * x, height / 2 - scale * y)

    def __exit__(self, *raised: object) -> None:
        """Draw what was recorded."""
        super().__exit__(*raised)
        if raised[1] is None:
            canvas = self.image.resize([SAMPLES * length for length in self.image.size], Image.Resampling.NEAREST)
            painter = _Painter(canvas, self)
            for call in self.calls:
                painter.paint(call)
            self.image.paste(canvas.reduce(SAMPLES))


def _extent(space: pymunk.Space) -> pymunk.BB:
    """Return the bounding box of a space's shapes and its constraints' anchors."""
    boxes = [shape.bb for shape in space.shapes]
    for joint in space.constraints:
        for name, body in (("anchor_a", joint.a), ("anchor_b", joint.b), ("groove_a", joint.a), ("groove_b", joint.a)):
            if hasattr(joint, name):
                x, y = body.local_to_world(getattr(joint, name))
                boxes.append(pymunk.BB(x, y, x, y))
    # Shapes with infinite coordinates are not drawn either.
    boxes = [box for box in boxes if all(map(math.isfinite, box))]
    if not boxes:
        raise ParameterError("area", space, "a space with something in it")
    return reduce(pymunk.BB.merge, boxes)


class _Painter:
    """Painter of calls on a canvas; lengths are in drawn pixels."""

    def __init__(self, canvas: Image.Image, options: PillowDrawOptions) -> None:
        self._size, self._line = canvas.size, SAMPLES * options.line_width
        self._transform = pymunk.Transform.scaling(SAMPLES) @ options.transform
        if options.positive_y_is_up:
            self._transform = pymunk.Transform(1, 0, 0, -1, 0, canvas.height) @ self._transform
        a, b, c, d, _, _ = self._transform
        self._scale = math.sqrt(abs(a * d - b * c))
        # Blends translucent colours with the canvas.
        self._draw = ImageDraw.Draw(canvas, "RGBA")

    def paint(self, call: DrawCall) -> None:
        """Paint a call."""
        points = [self._transform @ point for point in call.points]
        line, half = self._line, self._line / 2
        if call.name == "contact":
            middle = (points[0] + points[1]) / 2
            reach = COLLISION_MARK * line * (points[1] - points[0]).normalized()
            points = [middle - reach, middle + reach]
        if call.name == "dot":
            self._fill(call.fill, self._offset(points, call.radius * line))
            return
        if call.outline is None:
            self._stroke(call.fill, points[0], points[1])
            return
        radius = self._scale * call.radius
        if radius + _depth(points) < 1.5 * line:
            # The outline would cover all. No shape is thinner than a line.
            self._fill(call.fill, self._offset(points, radius if len(points) > 2 else max(radius, half)))
            return
        outside, inside = self._offset(points, radius), self._offset(points, radius - line)
        # The outline of a translucent shape is a ring: a polygon with a hole in it, and a cut of no width.
        hole = [*outside[:1], *inside, *inside[:1]] if call.fill[3] < 255 else []
        self._fill(call.outline, outside + hole)
        self._fill(call.fill, inside)
        if call.name == "circle":
            tip = self._transform @ (pymunk.Vec2d(*call.points[0]) + pymunk.Vec2d.from_polar(call.radius, call.angle))
            # The round end of the line stays inside the circle.
            end = points[0] + (tip - points[0]) * (1 - half / radius)
            self._stroke(call.outline, points[0], end)

    def _offset(self, points: Sequence[Point], distance: float) -> list[Point]:
        """Return the polygon at a distance around a point, a line or a convex polygon, or inside it if negative.

        The polygon is empty if it is outside the image, or has a coordinate that is nan or huge.
        """
        corners = _corners(points)
        # Only a polygon has an inside.
        distance = max(distance - EDGE_INSET, 2 * FLATNESS if len(corners) < 3 else -math.inf)
        if not all(abs(number) < MAX_REACH for point in points for number in (*point, distance)):
            return []
        for axis, length in enumerate(self._size):
            along = [point[axis] for point in points]
            if max(along) + distance < 0 or min(along) - distance > length:
                return []
        return _offset_polygon(corners, distance)

    def _fill(self, colour: Sequence[float], polygon: list[Point]) -> None:
        if polygon:
            self._draw.polygon(_pixels(polygon), fill=_rounded(colour))

    def _stroke(self, colour: Sequence[float], a: Point, b: Point) -> None:
        # ImageDraw's lines are more even than its thin polygons.
        if all(abs(number) < MAX_REACH for number in (*a, *b)):
            self._draw.line(_pixels([a, b]), fill=_rounded(colour), width=max(1, round(self._line)))


def _pixels(points: Sequence[Point]) -> list[tuple[int, int]]:
    """Return points in the coordinates of ImageDraw, whose origin is the centre of the first pixel."""
    return [(round(x - 0.5), round(y - 0.5)) for x, y in points]


def _rounded(colour: Sequence[float]) -> tuple[int, ...]:
    return tuple(round(part) for part in colour)


def _corners(points: Sequence[Point]) -> list[Point]:
    """Return corners without duplicates, counter-clockwise where y points up."""
    corners = [p for p, q in zip(points, [*points[1:], points[0]], strict=True) if math.dist(p, q) > SAME_CORNER]
    return [*reversed(corners)] if _area(corners) < 0 else corners or [points[0]]


def _area(points: Sequence[Point]) -> float:
    """Return the area of a polygon, negative if its corners are in clockwise order where y points up."""
    x0, y0 = points[0] if points else (0.0, 0.0)
    return sum((x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0) for (x1, y1), (x2, y2) in pairwise(points)) / 2


def _depth(points: Sequence[Point]) -> float:
    """Return a length by which a convex polygon can be inset: at least half of the largest one."""
    perimeter = sum(math.dist(p, q) for p, q in zip(points, [*points[1:], points[0]], strict=True))
    return abs(_area(points)) / perimeter if perimeter > 0 else 0.0


def _offset_polygon(corners: list[Point], distance: float) -> list[Point]:
    """Return the polygon around a convex one, with round corners, or inside it if `distance` is negative."""
    outline: list[Point] = []
    headings = [math.atan2(q[1] - p[1], q[0] - p[0]) for p, q in zip(corners, [*corners[1:], corners[0]], strict=True)]
    for i, (x, y) in enumerate(corners):
        turn = (headings[i] - headings[i - 1]) % math.tau if len(corners) > 1 else math.tau
        # At a straight corner, rounding can give an angle just below a full circle.
        turn = 0.0 if len(corners) > 1 and turn > 1.5 * math.pi else turn
        # The outer normal of a side is a quarter turn clockwise from its heading.
        start, reach, chords = headings[i - 1] - math.pi / 2, distance, 0
        if distance > FLATNESS:
            chords = min(math.ceil(turn / math.acos(1 - FLATNESS / distance) / 2), MAX_CHORDS)
        if chords < 1:
            start, turn, reach = start + turn / 2, 0.0, distance / math.cos(turn / 2)
        angles = [start + turn * k / max(1, chords) for k in range(chords + 1)]
        outline += [(x + reach * math.cos(angle), y + reach * math.sin(angle)) for angle in angles]
    return outline
