"""Pymunk's debug drawing on Pillow images; no window is needed.

`PillowDrawOptions` draws any space on a Pillow image, over whatever the image shows already. It
needs nothing else of this package.

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
    body.position = 0.65 + 0.75 * (i % 6), 0.5 + 0.7 * (i // 6)
    body.angle = i
    box = pymunk.Poly.create_box(body, (0.35 + 0.05 * (i % 7), 0.5), radius=0.03 * (i % 4))
    shape = box if i % 3 else pymunk.Circle(body, 0.16 + 0.02 * (i % 8))
    shape.mass = 1
    shape.friction = 0.6
    space.add(body, shape)
for i in range(5):  # Newton's cradle, its last ball drawn aside
    body = pymunk.Body()
    body.position = (6 + 0.5 * i, 0.6) if i < 4 else (9.15, 0.89)
    ball = pymunk.Circle(body, 0.245)
    ball.mass = 1
    ball.elasticity = 1
    ball.color = (241, 196, 15, 255)
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

`fit` shows a whole space, or a `pymunk.BB` of it; any other view is a `transform`, as everywhere in
Pymunk. For a film set `image` to a new picture for each frame, and `fit` a box, which keeps the
view.

A picture of 223 benches and their pivots, 640 x 640 pixels, takes 38 ms, and 366 ms with
`pymunk.matplotlib_util` (`python tests/bench/bench.py debug-draw`).
"""

import math
from collections.abc import Mapping, Sequence
from io import BytesIO
from itertools import chain, pairwise

import pymunk
from PIL import Image, ImageChops, ImageDraw, ImageOps

from pymunk_dragon._checks import finite, flag, instance
from pymunk_dragon.drawing import strokes
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.physics.draw_calls import DrawCall, DrawRecorder, extent

__all__ = ["PillowDrawOptions"]

_Point = tuple[float, float]
_Arcs = list[list[_Point]]

# Line widths: half the length of a collision mark. Chipmunk's is two units of the space, which may
# be two metres.
_COLLISION_MARK = 5.0
# Drawn pixels per pixel along each axis.
_SAMPLES = 2
# Drawn pixels: ImageDraw also fills the pixels on a polygon's edge, so every radius is smaller by
# this.
_EDGE_INSET = 0.4
# Drawn pixels: inset of round outlines at their inner edge. A circle is larger by 1 / pi on
# average, and a hole is smaller by as much.
_HOLE_INSET = 2 / math.pi - _EDGE_INSET
# Drawn pixels: what reaches farther is not drawn, because ImageDraw has integers of 32 bits.
_MAX_REACH = 1e9
# Pixels.
_STILL_SIZE = 640, 480


class PillowDrawOptions(DrawRecorder):
    """Debug drawing of a space on a Pillow image: `space.debug_draw(PillowDrawOptions(image))`.

    Everything is drawn with the alpha of its colour, at twice the image's size, which is then
    reduced. `with options:` around calls of the drawing methods draws more, in the space's
    coordinates.

    Parameters
    ----------
    image : PIL.Image.Image
        Target image, in mode RGB or RGBA; an attribute that can be set, for example to the next
        frame of a film. An image in mode RGBA may be transparent; it takes twice the time.
    positive_y_is_up : bool
        Whether y increases upwards from the image's lower edge. If False, y increases downwards
        from the upper edge as in `pymunk.pygame_util`.
    line_width : float
        Width of outlines and lines, pixels, from 1 to 100; at every angle they are as thick, to a
        quarter of a pixel. Dots and contacts scale with the line width.

    Examples
    --------
    >>> import pymunk
    >>> from PIL import Image
    >>> from pymunk_dragon import PillowDrawOptions
    >>> space = pymunk.Space()
    >>> space.add(pymunk.Circle(space.static_body, 0.5))
    >>> space.add(pymunk.Segment(space.static_body, (-2, -0.6), (2, -0.6), 0.1))
    >>> image = Image.new("RGB", (320, 160), "white")
    >>> options = PillowDrawOptions(image, positive_y_is_up=True)
    >>> options.fit(space)
    >>> space.debug_draw(options)
    >>> image.getpixel((160, 80))
    (149, 165, 166)
    """

    def __init__(
        self, image: Image.Image, *, positive_y_is_up: bool = False, line_width: float = 1.0
    ) -> None:
        super().__init__()
        if instance("image", image, Image.Image, "a PIL.Image.Image").mode not in ("RGB", "RGBA"):
            raise ParameterError("image", image, "a PIL.Image.Image in mode RGB or RGBA")
        self.image = image
        self.positive_y_is_up = flag("positive_y_is_up", positive_y_is_up)
        # Pillow draws a line of one drawn pixel step by step, however long the line is; a wide one
        # hides the picture.
        self.line_width = finite("line_width", line_width, 1, 100, "pixels")

    def fit(self, area: pymunk.Space | pymunk.BB, margin: float = 10.0) -> None:
        """Set `transform` so that a space, or a part of it, fills the image and is centred.

        The margin is in pixels. A `ParameterError` is raised if `area` has no extent, or `margin`
        leaves less than 2 pixels.
        """
        instance("area", area, pymunk.Space | pymunk.BB, "a pymunk.Space or a pymunk.BB")
        width, height = self.image.size
        margin = finite("margin", margin, 0, min(width, height) / 2 - 1, "pixels")
        box = extent(area) if isinstance(area, pymunk.Space) else area
        lengths = box.right - box.left, box.top - box.bottom
        if not (min(lengths) >= 0 and 0 < max(lengths) < math.inf):
            raise ParameterError("area", area, "something that has a size")

        sides = zip((width, height), lengths, strict=True)
        scale = min((pixels - 2 * margin) / length for pixels, length in sides if length > 0)
        x, y = box.center()
        right = width / 2 - scale * x
        down = height / 2 - scale * y
        self.transform = pymunk.Transform(scale, 0, 0, scale, right, down)

    def __exit__(self, *raised: object) -> None:
        """Draw what was recorded."""
        super().__exit__(*raised)
        if raised[1] is not None:
            return
        if self.image.mode == "RGB":
            self.image.paste(self._painted(self.image))
            return
        size = self.image.size
        black = self._painted(Image.new("RGB", size, "black"))
        white = self._painted(Image.new("RGB", size, "white"))
        # A ground shows as far as what is drawn is transparent; on black, colours are multiplied
        # by their alpha.
        ground = ImageChops.subtract(white, black).getchannel("G")
        layer = Image.merge("RGBa", (*black.split(), ImageChops.invert(ground)))
        self.image.alpha_composite(layer.convert("RGBA"))

    def _painted(self, image: Image.Image) -> Image.Image:
        """An image in mode RGB with what was recorded."""
        canvas = ImageOps.scale(image, _SAMPLES, Image.Resampling.NEAREST)
        view = pymunk.Transform.scaling(_SAMPLES) @ self.transform
        if self.positive_y_is_up:
            view = pymunk.Transform(1, 0, 0, -1, 0, canvas.height) @ view
        # Blends translucent colours with the canvas.
        draw = ImageDraw.Draw(canvas, "RGBA")
        for call in self.calls:
            _paint(draw, view, _SAMPLES * self.line_width, call)
        return canvas.reduce(_SAMPLES)


def still(
    space: pymunk.Space,
    field: Mapping[str, Sequence[float]],
    *,
    y_down: bool,
    more: Sequence[DrawCall],
) -> bytes:
    """PNG of the shapes in a part of a space, of a centre and a size, and of `more` over them."""
    options = PillowDrawOptions(Image.new("RGB", _STILL_SIZE, "white"), positive_y_is_up=not y_down)
    options.flags = options.DRAW_SHAPES
    x, y = field["centre"]
    width, height = field["size"]
    options.fit(pymunk.BB(x - width / 2, y - height / 2, x + width / 2, y + height / 2))
    space.debug_draw(options)
    with options:
        options.calls += more
    file = BytesIO()
    options.image.save(file, "png")
    return file.getvalue()


def _paint(draw: ImageDraw.ImageDraw, view: pymunk.Transform, line: float, call: DrawCall) -> None:
    """Paint a call with lines of a width in drawn pixels, to which `view` transforms the space."""
    points = [view @ point for point in call.points]
    scale = math.sqrt(abs(view.a * view.d - view.b * view.c))
    radius = call.radius * (line if call.name == "dot" else scale)
    if not all(abs(number) < _MAX_REACH for number in (radius, *chain(*points))):
        return
    fill = tuple(map(round, call.fill))
    width = round(line)

    if call.name == "contact":
        # A mark in the middle, whose length does not depend on the scale.
        begin, end = points
        middle = (begin + end) / 2
        reach = _COLLISION_MARK * line * (end - begin).normalized()
        points = [middle - reach, middle + reach]
    if call.name in ("contact", "line"):
        for begin, end in pairwise(points):
            _paint_line(draw, begin, end, width, fill)
        return

    if call.name == "segment":
        # No segment is thinner than a line.
        radius = max(radius, line / 2)
    corners, headings = _sides(points)
    roundness = max(radius - _EDGE_INSET, 0.0)
    outer = _around(corners, headings, roundness, roundness)
    edge = [_pixels(arc) for arc in outer]
    if call.name == "segment" and len(corners) == 2:
        # The straight sides are as thick at every angle.
        sides = strokes.line(corners[0], corners[1], 2 * radius)
        edge[0][-1], edge[1][0] = sides[:2]
        edge[1][-1], edge[0][0] = sides[2:]
    draw.polygon([*chain(*edge)], fill)

    # An outline would cover a thin shape.
    thin = 2 * radius + _thickness(corners, headings) <= 4 * line
    if call.outline is None or thin:
        return
    outline = tuple(map(round, call.outline))
    inside = radius - width
    inner = _around(corners, headings, inside + _HOLE_INSET if inside > 0 else inside, roundness)
    draw.polygon(_ring(edge, outer, inner, width), outline)
    if call.name == "circle":
        centre = pymunk.Vec2d(*call.points[0])
        heading = view @ (centre + pymunk.Vec2d.from_polar(call.radius, call.angle)) - points[0]
        # A stretched circle is drawn as a circle.
        tip = points[0] + heading.scale_to_length(radius)
        _paint_line(draw, points[0], tip, width, outline)


def _paint_line(
    draw: ImageDraw.ImageDraw,
    begin: pymunk.Vec2d,
    end: pymunk.Vec2d,
    width: int,
    colour: tuple[int, ...],
) -> None:
    """Paint the part of a line that is in the picture or near it.

    Polygons have single precision.
    """
    right, bottom = draw.im.size
    near = 2 * width
    area = pymunk.BB(-near, -near, right + near, bottom + near)
    # Fractions of the line, infinite if it misses the area.
    first = area.segment_query(begin, end)
    last = 1 - area.segment_query(end, begin)
    if first < last and begin != end:
        move = end - begin
        shown = strokes.line(begin + first * move, begin + last * move, width)
        draw.polygon(shown, colour)


def _sides(points: Sequence[pymunk.Vec2d]) -> tuple[list[pymunk.Vec2d], list[float]]:
    """Corners of a polygon, counter-clockwise where y points up, and headings of its sides, rad."""
    corners = list(dict.fromkeys(points))
    if pymunk.area_for_poly(corners) < 0:
        corners[1:] = corners[:0:-1]
    following = [*corners[1:], corners[0]]
    sides = zip(corners, following, strict=True)
    return corners, [(after - corner).angle for corner, after in sides]


def _thickness(corners: Sequence[pymunk.Vec2d], headings: Sequence[float]) -> float:
    """Least extent of corners across a heading."""
    extents = []
    for heading in headings:
        across = [corner.rotated(-heading).y for corner in corners]
        extents.append(max(across) - min(across))
    return min(extents)


def _around(
    corners: Sequence[_Point], headings: Sequence[float], distance: float, roundness: float
) -> _Arcs:
    """Polygon at a distance around a point, a line or a convex polygon, or inside if negative.

    There is an arc for each corner, with as many points as a radius of `roundness` needs.
    """
    arcs: _Arcs = []
    for i, (x, y) in enumerate(corners):
        turn = (headings[i] - headings[i - 1]) % math.tau
        if len(corners) == 1:
            # Around a point the arc is a circle.
            turn = math.tau
        elif turn >= 1.5 * math.pi:
            # At a straight corner, rounding can give an angle just below a full circle.
            turn = 0.0

        # The chords are within 0.13 drawn pixels of the arc.
        chords = 1 + int(turn * (1 + math.sqrt(roundness)))
        # The outer normal of a side is a quarter turn clockwise from its heading.
        first = headings[i - 1] - math.pi / 2
        angles = [first + turn * k / chords for k in range(chords + 1)]
        away = distance
        if distance < 0:
            # Where the two sides inside meet.
            angles = [first + turn / 2] * (chords + 1)
            away = distance / math.cos(turn / 2)
        arcs.append([(x + away * math.cos(angle), y + away * math.sin(angle)) for angle in angles])
    return arcs


def _ring(
    edge: list[list[strokes.Pixel]], outer: _Arcs, inner: _Arcs, width: int
) -> list[strokes.Pixel]:
    """Polygon between two polygons, of which the pixels of the `outer` one are the `edge`."""
    hole = [_pixels(arc) for arc in inner]
    # Straight sides have the distance of the line's width from the pixels of the outer ones.
    for i in range(len(hole) if len(hole) > 1 else 0):
        after = (i + 1) % len(hole)
        begins = outer[i][-1], outer[after][0]
        ends = inner[i][-1], inner[after][0]
        across = []
        for (x, y), (x_end, y_end) in zip(begins, ends, strict=True):
            across.append((x_end - x, y_end - y))
        side = [edge[i][-1], edge[after][0]]
        hole[i][-1], hole[after][0] = strokes.parallel(side, across, width)
    around = [*chain(*edge)]
    within = [*chain(*hole)]
    return [*around, around[0], *within, within[0]]


def _pixels(points: Sequence[_Point]) -> list[strokes.Pixel]:
    """Points in the coordinates of ImageDraw, whose origin is the centre of the first pixel."""
    return [(round(x - 0.5), round(y - 0.5)) for x, y in points]
