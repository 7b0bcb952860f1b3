"""What a picture shows: the part of the ground, and where on the picture it lies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon.checks import finite, word

__all__ = ["Camera", "Subject", "View"]

Array = NDArray[np.float64]
Subject = Literal["field", "head"]

# Metres: two holes, and more ground than the longest dragon covers. The bounds catch lengths in another unit.
MIN_SPAN, MAX_SPAN = 0.1, 1e5
# Widths of the head: at the contest's 0.3 m it is seen with the turn it is on and the two beside it, where the near
# misses are.
HEAD_SPAN = 20.0


@dataclass(frozen=True, kw_only=True)
class Camera:
    """Where a film looks.

    Parameters
    ----------
    follow : {"field", "head"}
        Stand still over the whole field, or stay above the head bench.
    span : float, optional
        Width of the ground in view, m. By default whatever holds the dragon during the whole film, and 20 times the
        head's width where that is followed.

    Raises
    ------
    ParameterError
        If `follow` is something else, or `span` is not a number from 0.1 m to 1e5 m.
    """

    follow: Subject = "field"
    span: float | None = None

    def __post_init__(self) -> None:
        word("follow", self.follow, get_args(Subject))
        if self.span is not None:
            finite("span", self.span, MIN_SPAN, MAX_SPAN, "m")


@dataclass(frozen=True)
class View:
    """A rectangle of ground on a picture.

    Attributes
    ----------
    centre : tuple of float
        Point in the middle of the picture, m.
    scale : float
        Pixels per m.
    size : tuple of int
        Width and height, pixels.
    """

    centre: tuple[float, float]
    scale: float
    size: tuple[int, int]

    def pixels(self, points: ArrayLike) -> Array:
        """Where `points` (..., 2) in m lie on the picture: pixels right of and below its upper left corner."""
        middle = np.asarray(self.size) / 2
        return (np.asarray(points, dtype=float) - self.centre) * (self.scale, -self.scale) + middle

    def holds(self, points: ArrayLike, margin: float) -> NDArray[np.bool_]:
        """Which of `points` (..., 2) in m lie in view or at most `margin` m outside."""
        half = np.asarray(self.size) / (2 * self.scale) + margin
        inside: NDArray[np.bool_] = np.all(np.abs(np.asarray(points) - self.centre) <= half, axis=-1)
        return inside
