"""Pymunk's debug drawing on Pillow images; no window is needed.

Pymunk's debug drawing comes for pygame and pyglet, and for matplotlib, where it is deprecated. `PillowDrawOptions`
draws any space on a Pillow image, with smooth edges, over whatever the image shows already. It needs nothing else of
this package: no dragon, no march, no run.

## A picture

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

`fit` shows a whole space, or a `pymunk.BB` of it; any other view is a `transform`, as everywhere in Pymunk. Colours
and flags are Pymunk's own. Shapes outside the picture cost next to nothing. An exception in a subclass's
`draw_circle` reaches the caller of `debug_draw`, although C code lies between them.

## A film

Set `image` to a new picture for each frame. `fit` on a box keeps the view the same in all frames:

```python
import pymunk
from PIL import Image

from pymunk_dragon import PillowDrawOptions

space = pymunk.Space()
space.gravity = 0, -9.8
floor = pymunk.Segment(space.static_body, (-3, 0), (3, 0), radius=0.1)
floor.elasticity = 1
ball = pymunk.Body()
ball.position = 0, 3
circle = pymunk.Circle(ball, 0.4)
circle.mass, circle.elasticity = 1, 0.8
space.add(floor, ball, circle)

options = PillowDrawOptions(Image.new("RGB", (320, 240)), positive_y_is_up=True, line_width=2)
options.flags = pymunk.SpaceDebugDrawOptions.DRAW_SHAPES
options.fit(pymunk.BB(-3, -0.2, 3, 4.3))
frames = []
for _ in range(50):  # two seconds
    options.image = Image.new("RGB", (320, 240), "white")
    space.debug_draw(options)
    frames.append(options.image)
    for _ in range(8):
        space.step(0.005)
frames[0].save("ball.gif", save_all=True, append_images=frames[1:], duration=40, loop=0)
```

## Measurements

Milliseconds of processor time for a picture of 640 x 640 pixels (`python tests/bench/bench_debug_draw.py`, with
matplotlib installed beside it):

| space | RGB image | RGBA image | `pymunk.matplotlib_util` |
| --- | --- | --- | --- |
| 223 benches and their pivots | 55 | 62 | 397 |
| pile of 100 boxes and its contacts | 28 | 32 | 100 |
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import reduce
from types import TracebackType
from typing import Any

import pymunk
from PIL import Image
from pymunk.space_debug_draw_options import SpaceDebugColor

from pymunk_dragon._checks import finite
from pymunk_dragon.drawing.debug_draw.compositing import EDGE_INSET, composite
from pymunk_dragon.drawing.debug_draw.convex import Point, offset_polygon, within
from pymunk_dragon.drawing.debug_draw.deferred_calls import DeferredCalls
from pymunk_dragon.errors import ParameterError

__all__ = ["PillowDrawOptions"]

# Image modes that are supported.
MODES = ("RGB", "RGBA")
# Line widths: smallest thickness of a shape with an outline. The outline would cover all of a thinner shape.
MIN_OUTLINED_THICKNESS = 3.0
# Line widths: length of a collision mark. Chipmunk's is four units of the space, which may be four metres.
COLLISION_MARK_LENGTH = 10.0
# Pixels: a thinner line is invisible, a wider one hides the picture.
LINE_WIDTH_RANGE = (0.25, 100.0)
# Pixels around a space: the dots of constraints have a radius of 5.
MARGIN = 10.0
# Names of the methods that Chipmunk calls.
CALLBACKS = ("color_for_shape", "draw_circle", "draw_segment", "draw_fat_segment", "draw_polygon", "draw_dot")


class PillowDrawOptions(pymunk.SpaceDebugDrawOptions):
    """Debug drawing of a space on a Pillow image: `space.debug_draw(PillowDrawOptions(image))`.

    Shapes, constraints and collision points are composited onto the image with anti-aliased edges and the alpha of
    their colours. Coordinates are pixels after `transform`, as in Pymunk's other drawing utilities.

    Parameters
    ----------
    image : PIL.Image.Image
        Target image, in mode RGB or RGBA. The attribute can be set, for example to the next frame of a film.
    positive_y_is_up : bool
        Whether y increases upwards from the image's lower edge. If False, y increases downwards from the upper edge as
        in `pymunk.pygame_util`.
    line_width : float
        Width of outlines and lines, pixels. Dots and collision marks scale with the line width.

    Raises
    ------
    ParameterError
        If `image` is not an image or has another mode, or `line_width` is not a number from 0.25 to 100.

    Notes
    -----
    A shape is drawn in its own `color` if it has one, and otherwise in the colours of `pymunk.SpaceDebugDrawOptions`,
    as (red, green, blue, alpha) from 0 to 255. `flags` selects shapes, constraints and collision points.

    `transform` may translate, scale, rotate and mirror. It may also scale polygons non-uniformly and shear them;
    circles and round corners stay round, with their radius along x. Lines, dots and collision marks keep their size.
    (Chipmunk scales collision marks. Only the colour distinguishes them from constraints, so the two colours must
    differ.)

    Shapes outside the image cost almost nothing, however large they are. Shapes with a coordinate that is nan or
    greater than 1e12 pixels are not drawn.

    `debug_draw` raises the exceptions of the drawing methods. Chipmunk is written in C, and Python only prints an
    exception in a function called from C. The calls from C are therefore recorded. After Chipmunk has returned, the
    drawing methods and `color_for_shape` are called with the recorded arguments, including overridden methods; the
    first exception ends the drawing. An exception during recording, by Ctrl-C or lack of memory, is taken from
    `sys.unraisablehook` and raised before anything is drawn.

    Examples
    --------
    >>> import pymunk
    >>> from PIL import Image
    >>> from pymunk_dragon import PillowDrawOptions
    >>> space = pymunk.Space()
    >>> space.gravity = 0, -9.8
    >>> ball = pymunk.Body(mass=1, moment=1)
    >>> ball.position = 0, 1
    >>> floor = pymunk.Segment(space.static_body, (-2, 0), (2, 0), radius=0.1)
    >>> space.add(ball, pymunk.Circle(ball, 0.5), floor)
    >>> for _ in range(100):
    ...     space.step(0.01)
    >>> image = Image.new("RGB", (320, 160), "white")
    >>> options = PillowDrawOptions(image, positive_y_is_up=True)
    >>> options.fit(space)
    >>> space.debug_draw(options)
    >>> image.getpixel((160, 80))  # the ball, which rests on the floor
    (52, 152, 219)
    >>> image.save("ball.png")
    """

    def __init__(self, image: Image.Image, *, positive_y_is_up: bool = False, line_width: float = 1.0) -> None:
        super().__init__()
        self.image = image
        self.positive_y_is_up = positive_y_is_up
        self.line_width = finite("line_width", line_width, *LINE_WIDTH_RANGE, "pixels")
        self._deferred: DeferredCalls | None = None

    @property
    def image(self) -> Image.Image:
        """Target image."""
        return self._image

    @image.setter
    def image(self, image: Image.Image) -> None:
        if not isinstance(image, Image.Image):
            raise ParameterError("image", image, "a PIL.Image.Image")
        if image.mode not in MODES:
            raise ParameterError("image.mode", image.mode, " or ".join(MODES))
        self._image = image

    def fit(self, area: pymunk.Space | pymunk.BB, margin: float = MARGIN) -> None:
        """Set `transform` so that a space, or a part of it, fills the image and is centred.

        Parameters
        ----------
        area : pymunk.Space or pymunk.BB
            Area to show. For a space, the current bounding box of its shapes and its constraints' anchors.
        margin : float
            Free border on every side, pixels.

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

    def draw_circle(
        self,
        pos: pymunk.Vec2d,
        angle: float,
        radius: float,
        outline_color: SpaceDebugColor,
        fill_color: SpaceDebugColor,
    ) -> None:
        """Draw a circle with a line from its centre in the direction of `angle`."""
        # The round end of the line stays inside the circle.
        length = max(0.0, radius - self.line_width / 2)
        radius_line = [pos, pos + pymunk.Vec2d.from_polar(length, angle)] if math.isfinite(angle) else []
        self._draw_shape([pos], radius, outline_color, fill_color, radius_line)

    def draw_segment(self, a: pymunk.Vec2d, b: pymunk.Vec2d, color: SpaceDebugColor) -> None:
        """Draw a line."""
        self._draw_filled([a, b], self.line_width / 2, color)

    def draw_fat_segment(
        self,
        a: pymunk.Vec2d,
        b: pymunk.Vec2d,
        radius: float,
        outline_color: SpaceDebugColor,
        fill_color: SpaceDebugColor,
    ) -> None:
        """Draw a segment with round ends."""
        self._draw_shape([a, b], radius, outline_color, fill_color, [])

    def draw_polygon(
        self,
        verts: Sequence[pymunk.Vec2d],
        radius: float,
        outline_color: SpaceDebugColor,
        fill_color: SpaceDebugColor,
    ) -> None:
        """Draw a convex polygon with corners rounded by a radius."""
        self._draw_shape(verts, radius, outline_color, fill_color, [])

    def draw_dot(self, size: float, pos: pymunk.Vec2d, color: SpaceDebugColor) -> None:
        """Draw a disc of radius `size`."""
        self._draw_filled([pos], size, color)

    def __enter__(self) -> None:
        """Start recording calls; for `debug_draw` only."""
        self._deferred = DeferredCalls(self, CALLBACKS)
        self._deferred.begin()

    def __exit__(
        self, type: type[BaseException] | None, value: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Replay the recorded calls; for `debug_draw` only."""
        deferred, self._deferred = self._deferred, None
        if deferred is None:
            return
        calls = deferred.end()
        if value is not None:
            return
        fill_color: SpaceDebugColor | None = None
        for name, arguments in calls:
            if name == "color_for_shape":
                fill_color = SpaceDebugColor(*self.color_for_shape(*arguments))
                continue
            if fill_color is not None:
                # Chipmunk requests a shape's colour first, and passes it as the last argument of the drawing call.
                arguments, fill_color = (*arguments[:-1], fill_color), None
            getattr(self, name)(*self._corrected(name, arguments))

    def _corrected(self, name: str, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        """Correct arguments in which Chipmunk ignores mirroring, the size of the space or the line width."""
        if name == "draw_circle":
            pos, angle, *others = arguments
            return pos, self._angle_on_image(angle), *others
        if name == "draw_segment":
            a, b, color = arguments
            length = math.dist(a, b)
            if color == self.collision_point_color != self.constraint_color and 0 < length < math.inf:
                middle, half = (a + b) / 2, (b - a) / length * COLLISION_MARK_LENGTH * self.line_width / 2
                return middle - half, middle + half, color
        if name == "draw_dot":
            size, *others = arguments
            return size * self.line_width, *others
        return arguments

    def _angle_on_image(self, angle: float) -> float:
        """Return the angle of a body's x axis on the image. Chipmunk's own angle is wrong if the image is mirrored."""
        a, b, c, d, _, _ = self.transform
        if (a == d and b == -c) or not math.isfinite(angle):
            return angle
        x, y = math.cos(angle - math.atan2(b, a)), math.sin(angle - math.atan2(b, a))
        return math.atan2(b * x + d * y, a * x + c * y)

    def _draw_shape(
        self,
        points: Sequence[Point],
        radius: float,
        outline_color: SpaceDebugColor,
        fill_color: SpaceDebugColor,
        radius_line: Sequence[Point],
    ) -> None:
        """Draw a point, a line or a polygon offset by `radius`, with an outline and an optional line in it."""
        line = self.line_width
        points, box = self._on_image(points), (0, 0, *self.image.size)
        if not within(points, max(radius, line / 2), box):
            return
        if not offset_polygon(points, radius - MIN_OUTLINED_THICKNESS * line / 2, box):
            if not offset_polygon(points, radius - line / 2, box):
                radius = max(radius, line / 2)  # No shape is thinner than a line.
            composite(self.image, fill_color, [offset_polygon(points, radius - EDGE_INSET, box)])
            return
        # The fill extends to the middle of the outline, so that no background shows between the two.
        outer, middle, inside = (
            offset_polygon(points, radius - depth - EDGE_INSET, box) for depth in (0, line / 2, line)
        )
        composite(self.image, fill_color, [middle])
        strokes = [offset_polygon(self._on_image(radius_line), line / 2 - EDGE_INSET, box)] if radius_line else []
        composite(self.image, outline_color, [outer, inside, *strokes])

    def _draw_filled(self, points: Sequence[Point], radius: float, color: SpaceDebugColor) -> None:
        """Draw a point or a line offset by `radius`, in one colour."""
        points, box = self._on_image(points), (0, 0, *self.image.size)
        if within(points, radius, box):
            composite(self.image, color, [offset_polygon(points, radius - EDGE_INSET, box)])

    def _on_image(self, points: Sequence[Point]) -> list[Point]:
        """Convert points to pixels right of and below the image's upper left corner."""
        height = self.image.height
        return [(x, height - y if self.positive_y_is_up else y) for x, y in points]


def _extent(space: pymunk.Space) -> pymunk.BB:
    """Return the current bounding box of a space's shapes and its constraints' anchors."""
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
