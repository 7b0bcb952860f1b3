"""What a program draws on the picture of its space."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import pymunk
from pymunk.space_debug_draw_options import SpaceDebugColor as Colour

from pymunk_dragon._checks import MAX_COORDINATE, finite, label, positive, whole
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.physics.draw_calls import DrawCall

# Calls in a picture: so many take about the time of a picture, in Python and in the page.
MAX_CALLS = 2000
# Points of a trail: a minute of pictures is 3,600.
_MAX_POINTS = 10_000
# Largest height of texts, pixels.
_MAX_SIZE = 200
# Barbs of an arrow: length over that of the arrow, and angle to its shaft, rad.
_BARB_LENGTH = 0.2
_BARB_ANGLE = 0.4
# That of Pymunk's constraints, which differs from the ground of light and dark pages.
_COLOUR = (142, 68, 173, 255)
_CLEAR = Colour(0, 0, 0, 0)

_Point = tuple[float, float]
_ColourLike = str | Sequence[float]
# Points of trails by the body or, of other points, by the number in the order of calls.
_Trails = Mapping[pymunk.Body | int, deque[_Point]]


class Draw:
    """Draws on one picture of a live session; `live` gives one to `on_draw` for each picture.

    Coordinates and lengths have the units of the space, and lines are 1.5 pixels wide at any zoom.
    All this is drawn over shapes and joints, in the order of the calls, of which a picture has at
    most 2,000. A colour is a name, "#rrggbb" or "#rrggbbaa", those of Pillow's ImageColor, or red,
    green, blue and perhaps alpha from 0 to 255, as in Pymunk's ``SpaceDebugColor``.

    Examples
    --------
    >>> import pymunk
    >>> space = pymunk.Space()
    >>> ball = pymunk.Body(1, 1)
    >>> space.add(ball, pymunk.Circle(ball, 0.5))
    >>> def on_draw(space, draw):
    ...     draw.trail(ball, 100, color="orange")
    ...     draw.arrow(ball.position, ball.position + ball.velocity)
    ...     draw.text(ball.position, f"{ball.velocity.length:.1f} m/s")
    >>> live(space, on_draw=on_draw)  # doctest: +SKIP
    """

    def __init__(self) -> None:
        self.calls: list[DrawCall] = []
        # Middles, texts, sizes and colours.
        self.texts: list[tuple[float, float, str, float, Colour | None]] = []
        self.trails: dict[pymunk.Body | int, deque[_Point]] = {}
        # Those of the picture before.
        self.before: _Trails = {}
        # Trails of points so far.
        self._tips = 0

    def line(self, a: _Point, b: _Point, *more: _Point, color: _ColourLike = _COLOUR) -> None:
        """Draw a line through two or more points.

        Parameters
        ----------
        a : point
            Begin of the line.
        b : point
            The next point.
        *more : point
            Further points.
        color : color
            Colour of the line.

        Raises
        ------
        ParameterError
            If a point or the colour is unusable, or the picture has 2,000 calls.

        Examples
        --------
        >>> draw.line((0, 0), (1, 0), (1, 1), color="red")  # doctest: +SKIP
        """
        self._line([_point("a point", each) for each in (a, b, *more)], color)

    def circle(
        self,
        center: _Point,
        radius: float,
        *,
        color: _ColourLike = _COLOUR,
        fill: _ColourLike | None = None,
    ) -> None:
        """Draw a circle.

        Parameters
        ----------
        center : point
            Centre.
        radius : float
            Radius, in units of the space.
        color : color
            Colour of the outline.
        fill : color, optional
            Colour of the disc within it, which is otherwise not drawn.

        Raises
        ------
        ParameterError
            If an argument is unusable, or the picture has 2,000 calls.

        Examples
        --------
        >>> draw.circle((0, 0), 2, fill="#ff000080")  # doctest: +SKIP
        """
        self._count()
        around = _point("center", center)
        radius = positive("radius", radius, MAX_COORDINATE, "")
        inside = _CLEAR if fill is None else _colour("fill", fill)
        # Pymunk's own circles have a line that shows how they turn.
        self.calls.append(DrawCall("polygon", (around,), radius, inside, _colour("color", color)))

    def arrow(self, begin: _Point, end: _Point, *, color: _ColourLike = _COLOUR) -> None:
        """Draw an arrow, whose head is a fifth of its length.

        Parameters
        ----------
        begin : point
            Where it begins.
        end : point
            Its tip.
        color : color
            Colour of the lines.

        Raises
        ------
        ParameterError
            If an argument is unusable, or the picture has 2,000 calls.

        Examples
        --------
        >>> draw.arrow(body.position, body.position + body.velocity)  # doctest: +SKIP
        """
        tail = pymunk.Vec2d(*_point("begin", begin))
        tip = pymunk.Vec2d(*_point("end", end))
        back = _BARB_LENGTH * (tail - tip)
        barbs = [tip + back.rotated(angle) for angle in (_BARB_ANGLE, -_BARB_ANGLE)]
        self._line([tail, tip, barbs[0], tip, barbs[1]], color)

    def trail(
        self, of: pymunk.Body | _Point, last: int = 100, *, color: _ColourLike = _COLOUR
    ) -> None:
        """Draw a line through the last places of a body or a point in the pictures before.

        Parameters
        ----------
        of : pymunk.Body or point
            The trails of points are told apart by the order in which they are drawn.
        last : int
            Number of places, up to 10,000; those where it stands still count once. A trail that a
            picture leaves out begins anew.
        color : color
            Colour of the line.

        Raises
        ------
        ParameterError
            If an argument is unusable, or the picture has 2,000 calls.

        Examples
        --------
        >>> draw.trail(body, 200, color="steelblue")  # doctest: +SKIP
        """
        key: pymunk.Body | int = self._tips
        if isinstance(of, pymunk.Body):
            key = of
            of = of.position
        else:
            self._tips += 1
        place = _point("of", of)
        points = deque(self.before.get(key, ()), whole("last", last, 2, _MAX_POINTS))
        if not points or points[-1] != place:
            points.append(place)
        self.trails[key] = points
        self._line(points, color)

    def text(
        self, point: _Point, text: str, *, size: float = 14, color: _ColourLike | None = None
    ) -> None:
        """Write a text.

        Parameters
        ----------
        point : point
            Where the middle of the text is.
        text : str
            The text, in one line or several.
        size : float
            Size of the letters, pixels, up to 200.
        color : color, optional
            Colour of the letters; by default that of the page's texts, light or dark.

        Raises
        ------
        ParameterError
            If an argument is unusable, or the picture has 2,000 calls.

        Examples
        --------
        >>> draw.text((0, 5), "Level 3", size=24)  # doctest: +SKIP
        """
        self._count()
        size = positive("size", size, _MAX_SIZE, "pixels")
        place = _point("point", point)
        ink = None if color is None else _colour("color", color)
        self.texts.append((*place, label("text", text), size, ink))

    def _line(self, points: Iterable[_Point], color: _ColourLike) -> None:
        """Record a line."""
        self._count()
        self.calls.append(DrawCall("line", (*points,), 0.0, _colour("color", color)))

    def _count(self) -> None:
        """Raise an error if there are too many calls."""
        count = len(self.calls) + len(self.texts) + 1
        if count > MAX_CALLS:
            raise ParameterError("calls of draw", count, f"at most {MAX_CALLS} in a picture")


def _point(name: str, value: Any) -> _Point:
    """A point as two floats."""
    try:
        x, y = value
    except (TypeError, ValueError):
        raise ParameterError(name, value, "two numbers, x and y") from None
    across = finite(name, x, -MAX_COORDINATE, MAX_COORDINATE, "")
    return across, finite(name, y, -MAX_COORDINATE, MAX_COORDINATE, "")


def _colour(name: str, value: Any) -> Colour:
    """A colour of Pymunk's from a name, a text as "#rrggbb", or three or four numbers."""
    try:
        numbers: Any = value
        if isinstance(value, str):
            # Pages that name no colour begin sooner without it.
            from PIL import ImageColor

            numbers = ImageColor.getcolor(value, "RGBA")
        red, green, blue, *alpha = (finite(name, each, 0, 255, "") for each in numbers)
        return Colour(red, green, blue, *alpha or [255])
    except (TypeError, ValueError):
        bound = "the name of a colour, #rrggbb, or 3 or 4 numbers from 0 to 255"
        raise ParameterError(name, value, bound) from None
