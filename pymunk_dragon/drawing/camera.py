"""Camera of a film, and the mapping from the ground to pixels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import finite, word

Subject = Literal["field", "head"]

# m: bounds of the width of a view, which detect lengths in another unit. The least shows less than two holes of a
# bench, the largest more ground than the longest dragon covers.
_SPANS = 0.1, 1e5
# Widths of the head bench: 6 m for the paper's 0.3 m, which shows the head's turn of the spiral and both adjacent
# turns, where near misses occur.
HEAD_SPAN = 20.0


@dataclass(frozen=True, kw_only=True)
class Camera:
    """Camera of a film: what it follows, and the width of its view.

    Parameters
    ----------
    follow : {"field", "head"}
        Keep the camera fixed over the whole field, or centre it on the head bench.
    span : float, optional
        Width of the ground in view, m, from 0.1 to 1e5. The default for "field" holds the dragon during the whole film,
        the default for "head" is 20 times the head bench's width.

    Examples
    --------
    >>> from pymunk_dragon import Camera
    >>> Camera(follow="head", span=8.0)
    Camera(follow='head', span=8.0)
    """

    follow: Subject = "field"
    span: float | None = None

    def __post_init__(self) -> None:
        word("follow", self.follow, get_args(Subject))
        if self.span is not None:
            finite("span", self.span, *_SPANS, "m")


@dataclass(frozen=True)
class View:
    """Mapping from a rectangle of ground to drawn pixels: its centre, m, drawn pixels per m, and width and height."""

    centre: tuple[float, float]
    scale: float
    size: tuple[int, int]

    def pixels(self, points: ArrayLike) -> Array:
        """Convert `points` (..., 2), m, to pixels right of and below the upper left corner."""
        middle = np.asarray(self.size) / 2
        return (np.asarray(points, dtype=float) - self.centre) * (self.scale, -self.scale) + middle

    def holds(self, points: ArrayLike, margin: float) -> NDArray[np.bool_]:
        """Return which of `points` (..., 2), m, are in view or at most `margin` m outside."""
        half = np.asarray(self.size) / (2 * self.scale) + margin
        inside: NDArray[np.bool_] = np.all(np.abs(np.asarray(points) - self.centre) <= half, axis=-1)
        return inside
