"""Checks of arguments. Each returns the value as a plain Python object, or raises a `ParameterError`."""

from __future__ import annotations

import math
from collections.abc import Iterable
from numbers import Integral, Real

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.errors import ParameterError

# Characters of a word of which similar ones are sought: the search takes time that grows with its square.
MAX_WORD = 40


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
    raise ParameterError(name, value, f"one of {', '.join(known)}{did_you_mean(value, known)}")


def did_you_mean(value: object, words: Iterable[str]) -> str:
    """End of a message about a word that is none of `words`: the most similar one, if one is similar."""
    from difflib import get_close_matches

    similar = get_close_matches(value[:MAX_WORD], words, n=1) if isinstance(value, str) else []
    return f": did you mean {similar[0]}?" if similar else ""


def answer(method: str, value: object, given: tuple[int, ...], tail: tuple[int, ...] = ()) -> NDArray[np.float64]:
    """What a method of a user's class returned, as an array of numbers of the shape `given` + `tail`.

    A single number is broadcast to the shape `given`.
    """
    shape = given + tail
    try:
        array = np.asarray(value)
    except ValueError:  # lists of different lengths
        array = np.array(None)
    if array.dtype.kind not in "iuf":
        raise ParameterError(method, value, f"an array of numbers of shape {shape} for arguments of shape {given}")
    if array.shape != shape and (tail or array.ndim):
        raise ParameterError(f"the shape of {method}", array.shape, f"{shape} for arguments of shape {given}")
    return np.broadcast_to(array, shape).astype(float, order="C")


def number(value: object) -> float:
    """`value` as a float; nan if it is not a real number."""
    try:
        return float(value) if isinstance(value, Real) and not isinstance(value, bool) else math.nan
    except OverflowError:  # an int too large for a double
        return math.inf
