"""What Pymunk's debug drawing draws of the shapes of a space: the shapes once, then only poses."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from itertools import chain, starmap
from typing import Any

import numpy as np
import pymunk
from pymunk import batch

# Chipmunk's own functions: those of Pymunk take five times as long for the corners of a polygon.
from pymunk._chipmunk_cffi import lib
from pymunk.batch import BodyFields

from pymunk_dragon._arrays import Array
from pymunk_dragon.physics.draw_calls import DrawCall, DrawRecorder
from pymunk_dragon.physics.readings import grip, vectors
from pymunk_dragon.web.frames import in_binary, packed

# Distance at which two points are the same, units of the space: rounding.
_SAME = 1e-9
# Arguments by function.
_Read = defaultdict[Callable[..., Any], list[Any]]
_POSE = BodyFields.BODY_ID | BodyFields.POSITION | BodyFields.ANGLE


class Outlines:
    """The shapes of a space as Pymunk's debug drawing draws them, in the coordinates of bodies.

    `poses` draws the shapes again if anything has changed but the poses of bodies that move: which
    shapes there are and in which order, their geometry, colours and sensors, and the type or sleep
    of a body.

    Pymunk draws the shapes of a static body where they collide. While that is not where the body
    is, all shapes are drawn each time.
    """

    def __init__(self, space: pymunk.Space) -> None:
        self._space = space
        self._recorder = DrawRecorder()
        self._recorder.flags = DrawRecorder.DRAW_SHAPES
        # Kept, as Pymunk never frees the memory of a buffer.
        self._buffer = batch.Buffer()
        # The shapes in the format of `in_binary`: what `packed` has of them, and the rows of
        # `poses` with which they move.
        self.frame = b""

        self._shapes: list[pymunk.Shape] = []
        # What all but the poses was when the shapes were drawn.
        self._facts: Any = None
        # What numbers and points of the shapes are read of, by the functions that read them.
        self._numbers: _Read = defaultdict(list)
        self._points: _Read = defaultdict(list)

    def poses(self) -> Array:
        """Poses (1 + B, 3) of the space, which are 0, and of its bodies; `frame` goes with them."""
        self._buffer.clear()
        batch.get_space_bodies(self._space, _POSE, self._buffer)
        ids = self._buffer.int_buf()[:]
        bodies = np.frombuffer(self._buffer.float_buf()).reshape(-1, 3)

        if list(self._space.shapes) != self._shapes or self._read(ids) != self._facts:
            self._draw(ids)

        return np.vstack([np.zeros(3), bodies])

    def _read(self, ids: bytes) -> Any:
        """What has to be as it was for the shapes to be drawn as they were."""
        numbers = [[*map(read, those)] for read, those in self._numbers.items()]
        if self._facts and numbers != self._facts[0]:
            # A polygon may have fewer corners than before.
            return None
        found = chain.from_iterable(map(starmap, self._points, self._points.values()))
        return numbers, vectors(found).tobytes(), self._colours(), ids

    def _colours(self) -> dict[pymunk.Shape, tuple[float, ...]]:
        """The colours that shapes have themselves, or by their classes."""
        coloured: Any = self._shapes
        if not any(hasattr(kind, "color") for kind in {*map(type, coloured)}):
            # Pymunk's shapes are slow to tell that they have none.
            coloured = [shape for shape in coloured if "color" in vars(shape)]
        return {shape: tuple(shape.color) for shape in coloured if hasattr(shape, "color")}

    def _draw(self, ids: bytes) -> None:
        """Draw the shapes."""
        self._facts = None
        self._shapes = list(self._space.shapes)
        self._numbers.clear()
        self._points.clear()
        self._space.debug_draw(self._recorder)

        calls = self._recorder.calls
        rows = {number: row for row, number in enumerate(memoryview(ids).cast("P"), 1)}
        rows_of_calls = [self._place(call, rows) for call in calls]
        numbers, colours = packed(calls, grip)
        owners = np.array([row or 0 for row in rows_of_calls], dtype=float)
        self.frame = in_binary({"colours": colours}, {"calls": numbers, "owners": owners})
        if None not in rows_of_calls:
            self._facts = self._read(ids)

    def _place(self, call: DrawCall, rows: Mapping[int, int]) -> int | None:
        """Give a call the coordinates of its body, and return the body's row.

        The row is 0 for what does not move, and None if that is not drawn where its body is.
        """
        shape: Any = call.shape
        body = shape.body
        corners = self._watch(shape, body._body)
        row = rows.get(body.id, 0)
        if row and body.body_type != pymunk.Body.STATIC:
            call.points = tuple(corners)
            call.angle = 0.0
            return row

        self._numbers[lib.cpBodyGetAngle].append(body._body)
        self._points[lib.cpBodyGetPosition].append((body._body,))
        pairs = zip(map(body.local_to_world, corners), call.points, strict=True)
        return 0 if all(one.get_distance(two) < _SAME for one, two in pairs) else None

    def _watch(self, shape: Any, body: Any) -> list[pymunk.Vec2d]:
        """Have what a shape is drawn with be read, and return its corners or centre."""
        raw = shape._shape
        self._numbers[lib.cpShapeGetSensor].append(raw)
        self._numbers[lib.cpBodyGetType].append(body)
        self._numbers[lib.cpBodyIsSleeping].append(body)
        match shape:
            case pymunk.Circle():
                self._numbers[lib.cpCircleShapeGetRadius].append(raw)
                self._points[lib.cpCircleShapeGetOffset].append((raw,))
                return [shape.offset]
            case pymunk.Segment():
                self._numbers[lib.cpSegmentShapeGetRadius].append(raw)
                self._points[lib.cpSegmentShapeGetA].append((raw,))
                self._points[lib.cpSegmentShapeGetB].append((raw,))
                return [shape.a, shape.b]
        corners: list[pymunk.Vec2d] = shape.get_vertices()
        self._numbers[lib.cpPolyShapeGetCount].append(raw)
        self._numbers[lib.cpPolyShapeGetRadius].append(raw)
        self._points[lib.cpPolyShapeGetVert] += [(raw, i) for i in range(len(corners))]
        return corners
