"""Checks of arguments. Each returns the value as a plain Python object, or raises a `ParameterError`."""

from __future__ import annotations

import math
from collections.abc import Iterable
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.errors import ParameterError

# m: coordinates of benches. A thousand times the rim of the largest spiral; products of such coordinates are far from
# the ends of a double.
MAX_COORDINATE = 1e9


def finite(name: str, value: object, low: float, high: float, unit: str) -> float:
    """`value` as a float, if it is a finite number within [low, high]."""
    amount = number(value)
    if math.isfinite(amount) and low <= amount <= high:
        return amount
    raise ParameterError(name, value, f"a number from {low:g} to {high:g} {unit}".rstrip())


def positive(name: str, value: object, high: float, unit: str) -> float:
    """`value` as a float, if it is a finite number above 0 and at most `high`."""
    amount = number(value)
    if math.isfinite(amount) and 0 < amount <= high:
        return amount
    upper = "finite" if high == math.inf else f"at most {high:g}"
    raise ParameterError(name, value, f"a number above 0 and {upper} {unit}".rstrip())


def whole(name: str, value: object, low: int, high: int) -> int:
    """`value` as an int, if it is a whole number within [low, high]."""
    if not isinstance(value, bool) and isinstance(value, Integral) and low <= int(value) <= high:
        return int(value)
    raise ParameterError(name, value, f"a whole number from {low} to {high}")


def word(name: str, value: object, words: Iterable[str]) -> str:
    """`value`, if it is one of `words`."""
    known = list(words)
    if isinstance(value, str) and value in known:
        return value
    raise ParameterError(name, value, f"one of {', '.join(known)}")


def numbers(name: str, value: object, *tail: int, kind: type = float) -> NDArray[Any]:
    """`value` as an array of floats, or of another `kind`, whose last axes have the lengths `tail`."""
    try:
        array = np.asarray(value)
    except ValueError:  # lists of different lengths
        array = np.array(None)
    real = array.dtype.kind in ("iufc" if kind is complex else "iuf") and (kind is not int or array.dtype.kind != "f")
    if not real or (tail and array.shape[-len(tail) :] != tail):
        shape = "".join(f", {length}" for length in tail)
        raise ParameterError(
            name, value, f"{'whole ' * (kind is int)}numbers" + f" of the shape (...{shape})" * bool(tail)
        )
    return array.astype(kind, copy=False)


def number(value: object) -> float:
    """`value` as a float; nan if it is not a real number."""
    try:
        return float(value) if isinstance(value, Real) and not isinstance(value, bool) else math.nan
    except OverflowError:  # an int too large for a double
        return math.inf
