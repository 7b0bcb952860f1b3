"""Curves with the direction of travel reversed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array
from pymunk_dragon.model.curves._arguments import check_curve
from pymunk_dragon.model.curves.base import Curve

__all__ = ["Reversed"]


@dataclass(frozen=True)
class Reversed(Curve, kind="reversed"):
    """A curve with the direction of travel reversed; its coordinates are those of the curve with the opposite sign.

    Parameters
    ----------
    curve : Curve
        The same path, travelled forward.

    Raises
    ------
    ParameterError
        If `curve` is no curve.

    Examples
    --------
    >>> from pymunk_dragon.model.curves import Line
    >>> Reversed(Line(stop=(10, 0))).tangent(-4.0).tolist()
    [-1.0, -0.0]
    """

    curve: Curve

    def __post_init__(self) -> None:
        check_curve("curve", self.curve)

    @property
    def begin_s(self) -> float:
        """Where the curve ends, m."""
        return -self.curve.end_s

    @property
    def end_s(self) -> float:
        """Where the curve begins, m."""
        return -self.curve.begin_s

    def point(self, s: ArrayLike) -> Array:
        """Position (..., 2) in m."""
        return self.curve.point(-np.asarray(s, dtype=float))

    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector (..., 2) in the direction of travel."""
        return -self.curve.tangent(-np.asarray(s, dtype=float))

    def frame(self, s: ArrayLike) -> tuple[Array, Array]:
        """Positions and unit vectors in the direction of travel, each (..., 2)."""
        points, tangents = self.curve.frame(-np.asarray(s, dtype=float))
        return points, -tangents

    def curvature(self, s: ArrayLike) -> Array:
        """Curvature (...) in 1/m, positive for a curve to the left."""
        return -self.curve.curvature(-np.asarray(s, dtype=float))

    def max_curvature(self, s: ArrayLike, other: ArrayLike) -> Array:
        """Upper bound (...) on the absolute curvature between two coordinates, 1/m."""
        return self.curve.max_curvature(-np.asarray(s, dtype=float), -np.asarray(other, dtype=float))
