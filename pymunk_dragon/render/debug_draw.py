"""Pymunk's debug drawing on Pillow images, without a window."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import reduce
from types import TracebackType
from typing import Any

import pymunk
from PIL import Image
from pymunk.space_debug_draw_options import SpaceDebugColor

from pymunk_dragon.checks import finite
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.render.convex import Point, grown, within
from pymunk_dragon.render.recording import Recording
from pymunk_dragon.render.stencil import FRINGE, lay

__all__ = ["PillowDrawOptions"]

# Modes of images that can be drawn on.
MODES = ("RGB", "RGBA")
# Line widths that a shape must be thick to have an outline; a thinner one would be nothing but outline.
MIN_THICKNESS = 3.0
# Line widths that a collision mark is long. Chipmunk makes it four units of the space, which may be four metres.
MARK_LENGTH = 10.0
# Pixels: from the faintest line that is seen at all to one that hides everything.
LINE_WIDTHS = (0.25, 100.0)
# Pixels beside a space: the dots of constraints have a radius of 5.
MARGIN = 10.0
# What Chipmunk calls.
CALLBACKS = ("color_for_shape", "draw_circle", "draw_segment", "draw_fat_segment", "draw_polygon", "draw_dot")


class PillowDrawOptions(pymunk.SpaceDebugDrawOptions):
    """Draws a space on a Pillow image: `space.debug_draw(PillowDrawOptions(image))`.

    Shapes, constraints and collision points are laid over what the image shows already, with smooth edges, and with the
    alpha of their colours. Coordinates are pixels once `transform` is applied, as in Pymunk's other utilities.

    Parameters
    ----------
    image : PIL.Image.Image
        What is drawn on, in mode RGB or RGBA. The attribute can be set, as to the next frame of a film.
    positive_y_is_up : bool
        Whether y grows upwards from the image's lower edge, or downwards from its upper one as in `pymunk.pygame_util`.
    line_width : float
        Pixels of width of outlines and lines. Dots and collision marks grow with it.

    Raises
    ------
    ParameterError
        If `image` is no image or has another mode, or `line_width` is no number from 0.25 to 100.

    Notes
    -----
    The colours are those of `pymunk.SpaceDebugDrawOptions`, and a shape's own `color` where it has one, as
    (red, green, blue, alpha) from 0 to 255. `flags` says what is drawn.

    `transform` may move, scale, turn and mirror. Polygons can also be stretched and sheared; circles and round corners
    stay round, with the radius that they have along x. Lines, dots and collision marks keep their size. (Chipmunk
    scales collision marks. They can only be told from constraints by their colour, so leave the two colours different.)

    What lies outside the picture costs next to nothing, however large it is. Whatever has a coordinate that is nan, or
    beyond 1e12 pixels, is not drawn.

    Exceptions arrive where `debug_draw` was called. That takes care, because Chipmunk is written in C, and what a
    function raises that C has called is printed and forgotten. So as long as C calls back, its calls are only written
    down. Once it is done, the methods that draw, and `color_for_shape`, are called as it wanted, overridden ones too;
    the first to raise something ends the drawing. What is raised in the meantime, by Ctrl-C or the lack of memory,
    is taken from `sys.unraisablehook` and raised before anything is drawn.

    Examples
    --------
    >>> space = pymunk.Space()
    >>> space.add(pymunk.Circle(space.static_body, 2))
    >>> image = Image.new("RGB", (100, 100), "white")
    >>> options = PillowDrawOptions(image, positive_y_is_up=True)
    >>> options.fit(space)
    >>> space.debug_draw(options)
    >>> image.getpixel((50, 70))
    (149, 165, 166)
    """

    def __init__(self, image: Image.Image, *, positive_y_is_up: bool = False, line_width: float = 1.0) -> None:
        super().__init__()
        self.image = image
        self.positive_y_is_up = positive_y_is_up
        self.line_width = finite("line_width", line_width, *LINE_WIDTHS, "pixels")
        self._recording: Recording | None = None

    @property
    def image(self) -> Image.Image:
        """The image that is drawn on."""
        return self._image

    @image.setter
    def image(self, image: Image.Image) -> None:
        if not isinstance(image, Image.Image):
            raise ParameterError("image", image, "a PIL.Image.Image")
        if image.mode not in MODES:
            raise ParameterError("image.mode", image.mode, " or ".join(MODES))
        self._image = image

    def fit(self, area: pymunk.Space | pymunk.BB, margin: float = MARGIN) -> None:
        """Set `transform` to what shows all of a space, or a part of it, as large as the image allows, in its middle.

        Parameters
        ----------
        area : pymunk.Space or pymunk.BB
            A space stands for the box around its shapes and its constraints' anchors, where they are now.
        margin : float
            Pixels to leave free on every side.

        Raises
        ------
        ParameterError
            If `area` has no size, as a space without shapes, or `margin` leaves less than 2 pixels.
        """
        width, height = self.image.size
        margin = finite("margin", margin, 0, min(width, height) / 2 - 1, "pixels")
        box = _extent(area) if isinstance(area, pymunk.Space) else area
        wide, high = box.right - box.left, box.top - box.bottom
        if not (min(wide, high) >= 0 and 0 < max(wide, high) < math.inf):
            raise ParameterError("area", area, "something that has a size")
        scale = min((room - 2 * margin) / size for room, size in ((width, wide), (height, high)) if size > 0)
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
        # Its round end stays inside the circle.
        reach = max(0.0, radius - self.line_width / 2)
        needle = [pos, pos + pymunk.Vec2d.from_polar(reach, angle)] if math.isfinite(angle) else []
        self._draw_shape([pos], radius, outline_color, fill_color, needle)

    def draw_segment(self, a: pymunk.Vec2d, b: pymunk.Vec2d, color: SpaceDebugColor) -> None:
        """Draw a line."""
        self._draw_plain([a, b], self.line_width / 2, color)

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
        """Draw a convex polygon that is grown by a radius."""
        self._draw_shape(verts, radius, outline_color, fill_color, [])

    def draw_dot(self, size: float, pos: pymunk.Vec2d, color: SpaceDebugColor) -> None:
        """Draw a disc of radius `size`."""
        self._draw_plain([pos], size, color)

    def __enter__(self) -> None:
        """Write down from now on what is called; for `debug_draw` only."""
        self._recording = Recording(self, CALLBACKS)
        self._recording.begin()

    def __exit__(
        self, type: type[BaseException] | None, value: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Draw what was written down; for `debug_draw` only."""
        recording, self._recording = self._recording, None
        if recording is None:
            return
        calls = recording.end()
        if value is not None:
            return
        fill_color: SpaceDebugColor | None = None
        for name, arguments in calls:
            if name == "color_for_shape":
                fill_color = SpaceDebugColor(*self.color_for_shape(*arguments))
                continue
            if fill_color is not None:
                # Chipmunk asks for a shape's colour, and hands it on as the last argument when it draws the shape.
                arguments, fill_color = (*arguments[:-1], fill_color), None
            getattr(self, name)(*self._mended(name, arguments))

    def _mended(self, name: str, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        """Arguments as they should be: Chipmunk has an eye neither for mirrors nor for the size of the space."""
        if name == "draw_circle":
            pos, angle, *others = arguments
            return pos, self._seen_angle(angle), *others
        if name == "draw_segment":
            a, b, color = arguments
            length = math.dist(a, b)
            if color == self.collision_point_color != self.constraint_color and 0 < length < math.inf:
                middle, half = (a + b) / 2, (b - a) / length * MARK_LENGTH * self.line_width / 2
                return middle - half, middle + half, color
        if name == "draw_dot":
            size, *others = arguments
            return size * self.line_width, *others
        return arguments

    def _seen_angle(self, angle: float) -> float:
        """Direction of a body's x axis on the picture: Chipmunk adds the picture's angle even where it is mirrored."""
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
        needle: Sequence[Point],
    ) -> None:
        """Draw what is nearer than `radius` to a point, a line or a polygon, with a line in it."""
        line = self.line_width
        points, box = self._on_image(points), (0, 0, *self.image.size)
        if not within(points, max(radius, line / 2), box):
            return
        if not grown(points, radius - MIN_THICKNESS * line / 2, box):
            if not grown(points, radius - line / 2, box):
                radius = max(radius, line / 2)  # Nothing is thinner than a line.
            lay(self.image, fill_color, [grown(points, radius - FRINGE, box)])
            return
        # The fill reaches to the middle of the outline, so that no ground shines through between the two.
        rim, middle, inside = (grown(points, radius - depth - FRINGE, box) for depth in (0, line / 2, line))
        lay(self.image, fill_color, [middle])
        strokes = [grown(self._on_image(needle), line / 2 - FRINGE, box)] if needle else []
        lay(self.image, outline_color, [rim, inside, *strokes])

    def _draw_plain(self, points: Sequence[Point], radius: float, color: SpaceDebugColor) -> None:
        """Draw what is nearer than `radius` to a point or a line, in one colour."""
        points, box = self._on_image(points), (0, 0, *self.image.size)
        if within(points, radius, box):
            lay(self.image, color, [grown(points, radius - FRINGE, box)])

    def _on_image(self, points: Sequence[Point]) -> list[Point]:
        """Pixels right of and below the image's upper left corner."""
        height = self.image.height
        return [(x, height - y if self.positive_y_is_up else y) for x, y in points]


def _extent(space: pymunk.Space) -> pymunk.BB:
    """Box around a space's shapes and its constraints' anchors, where a picture would show them now."""
    boxes = [shape.bb for shape in space.shapes]
    for joint in space.constraints:
        for name, body in (("anchor_a", joint.a), ("anchor_b", joint.b), ("groove_a", joint.a), ("groove_b", joint.a)):
            if hasattr(joint, name):
                x, y = body.local_to_world(getattr(joint, name))
                boxes.append(pymunk.BB(x, y, x, y))
    # What was flung to infinity is not drawn either.
    boxes = [box for box in boxes if all(map(math.isfinite, box))]
    if not boxes:
        raise ParameterError("area", space, "a space with something in it")
    return reduce(pymunk.BB.merge, boxes)
