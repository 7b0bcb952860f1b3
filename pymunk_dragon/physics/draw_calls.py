"""What Pymunk's debug drawing draws, as records for any painter; without Pillow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import pymunk
from pymunk.space_debug_draw_options import SpaceDebugColor as Colour

_Point = tuple[float, float]

# Least width and height of the area of a space over the larger of the two.
_THINNEST = 1e-3


@dataclass(slots=True)
class DrawCall:
    """What Pymunk draws for a shape, a constraint or a contact.

    Lengths have the space's units, and colours are those of Pymunk, 0 to 255.

    `name` is "circle", "segment" or "polygon" for shapes, "line" or "dot" for constraints, and
    "contact". `points` has a centre, the points of a line, or corners. The `radius` of a dot is in
    pixels. Only what is drawn for a `shape` has an `outline`, and only circles have an `angle`,
    rad.
    """

    name: str
    points: tuple[_Point, ...]
    radius: float
    fill: Colour
    outline: Colour | None = None
    angle: float = 0.0
    shape: pymunk.Shape | None = None


class DrawRecorder(pymunk.SpaceDebugDrawOptions):
    """Recorder of Pymunk's debug drawing, for any painter.

    `space.debug_draw(recorder)` makes a new list of `calls`.

    Shapes are drawn where their bodies are now, also if these were moved since the last step;
    Pymunk (7.3.1) itself draws them where the step left them. Shapes of a static body stay where
    they are, and collide there, until `Space.reindex_shapes_for_body`. Drawing changes no run: the
    next step places the shapes again.

    Chipmunk is written in C, and Python only prints an exception in a function that C calls. The
    exception of a shape with a wrong `color` is raised by `debug_draw`.
    """

    def __init__(self) -> None:
        super().__init__()
        self.calls: list[DrawCall] = []
        self._error: Exception | None = None
        self._shape: pymunk.Shape | None = None
        self._contact_colour: Colour | None = None

    def color_for_shape(self, shape: pymunk.Shape) -> Colour:
        """Colour of the shape that Chipmunk draws next: its own, or that of its kind of body."""
        self._shape = shape
        if shape.body is not None and shape.body.body_type != pymunk.Body.STATIC:
            # Chipmunk asks for the colour before it reads where the shape is.
            shape.cache_bb()
        try:
            red, green, blue, alpha = map(float, super().color_for_shape(shape))
        except (TypeError, ValueError) as error:
            self._error = error
            return self.shape_static_color
        return Colour(red, green, blue, alpha)

    def draw_circle(
        self, pos: _Point, angle: float, radius: float, outline_color: Colour, fill_color: Colour
    ) -> None:
        """Record a circle with a line from its centre in the direction of `angle`."""
        call = DrawCall("circle", (pos,), radius, fill_color, outline_color, angle, self._shape)
        self.calls.append(call)

    def draw_segment(self, a: _Point, b: _Point, color: Colour) -> None:
        """Record a line of a constraint or, if it has the colour of collision points, a contact."""
        name = "contact" if color == self._contact_colour else "line"
        self.calls.append(DrawCall(name, (a, b), 0.0, color))

    def draw_fat_segment(
        self, a: _Point, b: _Point, radius: float, outline_color: Colour, fill_color: Colour
    ) -> None:
        """Record a segment with round ends."""
        call = DrawCall("segment", (a, b), radius, fill_color, outline_color, 0.0, self._shape)
        self.calls.append(call)

    def draw_polygon(
        self, verts: Sequence[_Point], radius: float, outline_color: Colour, fill_color: Colour
    ) -> None:
        """Record a convex polygon with corners rounded by a radius."""
        corners = tuple(verts)
        call = DrawCall("polygon", corners, radius, fill_color, outline_color, 0.0, self._shape)
        self.calls.append(call)

    def draw_dot(self, size: float, pos: _Point, color: Colour) -> None:
        """Record a disc of radius `size`, pixels."""
        self.calls.append(DrawCall("dot", (pos,), size, color))

    def __enter__(self) -> None:
        """Start recording, in the space's own coordinates."""
        self.calls = []
        self._error = None
        self._shape = None
        # Read once: a spring is 14 lines.
        colour = self.collision_point_color
        self._contact_colour = None if colour == self.constraint_color else colour
        self._view = self.transform
        self.transform = pymunk.Transform.identity()

    def __exit__(self, *raised: object) -> None:
        """End recording."""
        self.transform = self._view
        if self._error is not None:
            raise self._error


def extent(space: pymunk.Space) -> pymunk.BB:
    """Bounding box of a space's shapes and constraints."""
    recorder = DrawRecorder()
    recorder.flags = recorder.DRAW_SHAPES | recorder.DRAW_CONSTRAINTS
    space.debug_draw(recorder)
    box = pymunk.BB(math.inf, math.inf, -math.inf, -math.inf)
    for call in recorder.calls:
        # The radius of a dot is in pixels.
        radius = call.radius if call.outline else 0
        for x, y in call.points:
            # Shapes with infinite coordinates are not drawn either.
            if all(map(math.isfinite, (x, y, radius))):
                box = box.merge(pymunk.BB.newForCircle((x, y), radius))
    return box


def area(space: pymunk.Space) -> tuple[float, float, float, float]:
    """Centre, width and height of what is drawn of a space; an empty one has an area too."""
    box = extent(space)
    if box.left > box.right:
        box = pymunk.BB(-1, -1, 1, 1)
    width = box.right - box.left
    height = box.top - box.bottom
    # All may be a point.
    least = _THINNEST * (max(width, height) or 1.0)
    return *box.center(), max(width, least), max(height, least)
