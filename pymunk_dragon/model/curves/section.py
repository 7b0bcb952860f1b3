"""A part of a curve."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array, Complex
from pymunk_dragon._checks import number
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves._arguments import check_curve, overlap, within
from pymunk_dragon.model.curves.base import Curve

__all__ = ["Section"]

# m before the section at which a handle still counts as on it.
ROUNDING = 1e-10


@dataclass(frozen=True)
class Section(Curve, kind="section"):
    """Part of a curve, with the coordinates of the curve.

    Parameters
    ----------
    curve : Curve
        What it is a part of.
    begin_s, end_s : float
        Its first and last coordinate on the curve, m. They may be infinite if the curve's are.

    Raises
    ------
    ParameterError
        If `curve` is not a curve, or the coordinates are not on it or not in the order of travel.

    Examples
    --------
    >>> from pymunk_dragon.model.curves import Line
    >>> Section(Line(stop=(10, 0)), 2, 6).point([1.0, 2.0]).tolist()
    [[nan, nan], [2.0, 0.0]]
    """

    curve: Curve
    begin_s: float
    end_s: float

    def __post_init__(self) -> None:
        check_curve("curve", self.curve)
        first, last = self.curve.begin_s, self.curve.end_s
        begin, end = number(self.begin_s), number(self.end_s)
        # Written so that nan fails.
        if not first <= begin < last:
            raise ParameterError("begin_s", self.begin_s, f"a coordinate on the curve, from {first:g} to {last:g} m")
        if not begin < end <= last:
            raise ParameterError(
                "end_s", self.end_s, f"a coordinate on the curve after {begin:g} m, at most {last:g} m"
            )
        object.__setattr__(self, "begin_s", begin)
        object.__setattr__(self, "end_s", end)

    def point(self, s: ArrayLike) -> Array:
        """Position (..., 2) in m."""
        return self.curve.point(within(s, self.begin_s, self.end_s))

    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector (..., 2) in the direction of travel."""
        return self.curve.tangent(within(s, self.begin_s, self.end_s))

    def frame(self, s: ArrayLike) -> tuple[Array, Array]:
        """Positions and unit vectors in the direction of travel, each (..., 2)."""
        return self.curve.frame(within(s, self.begin_s, self.end_s))

    def curvature(self, s: ArrayLike) -> Array:
        """Curvature (...) in 1/m, positive to the left."""
        return self.curve.curvature(within(s, self.begin_s, self.end_s))

    def parameter(self, s: Array) -> Array:
        """Parameters (T,) of the whole curve."""
        return self.curve.parameter(within(s, self.begin_s, self.end_s))

    def coordinate(self, parameter: Array) -> Array:
        """Coordinates (...) of parameters, m; nan before the section."""
        s = self.curve.coordinate(parameter)
        # Rounding may put a handle at the beginning before it.
        return np.where(s < self.begin_s - ROUNDING, np.nan, np.maximum(s, self.begin_s))

    def estimate(self, heads: Array, spacings: Array) -> Array:
        """Estimated parameters (T, H) of chains on the whole curve."""
        return self.curve.estimate(heads, spacings)

    def motion(self, parameter: Array) -> tuple[Complex, Complex]:
        """Positions and their derivatives by the parameter, each (...), as complex numbers."""
        return self.curve.motion(parameter)

    def behind(self, parameter: Array, chord: float) -> Array:
        """Parameters (T,) of the nearest points back along the whole curve."""
        return self.curve.behind(parameter, chord)

    def max_curvature(self, s: ArrayLike, other: ArrayLike) -> Array:
        """Upper bound (...) on the absolute curvature between two coordinates, 1/m."""
        lower, upper = overlap(s, other, self.begin_s, self.end_s)
        shared = lower <= upper
        return np.where(shared, self.curve.max_curvature(np.where(shared, lower, np.nan), upper), 0.0)
