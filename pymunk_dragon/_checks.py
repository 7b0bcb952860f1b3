"""Checks of arguments, each of which returns a plain Python object or raises a `ParameterError`."""

import math
from collections.abc import Callable, Iterable, Sequence
from numbers import Integral, Real
from types import UnionType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._arrays import Array
from pymunk_dragon.errors import ParameterError

C = TypeVar("C", bound=Callable[..., Any])
T = TypeVar("T")

# m: coordinates of benches. A thousand times the rim of the largest spiral; products of such
# coordinates are far from the ends of a double.
MAX_COORDINATE = 1e9


def finite(
    name: str,
    value: object,
    low: float = -math.inf,
    high: float = math.inf,
    unit: str = "",
) -> float:
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
    limited = f"a number above 0 and at most {high:g}"
    bound = "a finite number above 0" if high == math.inf else limited
    raise ParameterError(name, value, f"{bound} {unit}".rstrip())


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


def instance(name: str, value: object, kind: type[T] | UnionType, described: str) -> T:
    """`value`, if it is an object of a class."""
    if isinstance(value, kind):
        checked: T = value
        return checked
    raise ParameterError(name, value, described)


def instances(name: str, value: object, kind: type[T] | UnionType, described: str) -> tuple[T, ...]:
    """`value` as a tuple, if it is a sequence of objects of a class, or of one of several."""
    if isinstance(value, Sequence) and not isinstance(value, str | bytes):
        items = tuple(value)
        if all(isinstance(each, kind) for each in items):
            return items
    raise ParameterError(name, value, described)


def flag(name: str, value: object) -> bool:
    """`value` as a bool."""
    return bool(instance(name, value, bool | np.bool_, "True or False"))


def label(name: str, value: object) -> str:
    """`value`, if it is a text."""
    return instance(name, value, str, "a text")


def function(name: str, value: C) -> C:
    """`value`, if it can be called."""
    if callable(value):
        return value
    raise ParameterError(name, value, "a function")


def silent(done: float, total: float) -> None:
    """Report nothing; what functions call by default to report their progress."""


def within(name: str, values: Array, low: float, high: float, unit: str) -> Array:
    """`values`, if all of them are finite numbers within [low, high]."""
    wrong = values[~((values >= low) & (values <= high))]
    if wrong.size:
        bound = f"numbers from {low:g} to {high:g} {unit}".rstrip()
        raise ParameterError(name, wrong[0].item(), bound)
    return values


def fitting(names: str, *shapes: tuple[int, ...]) -> tuple[int, ...]:
    """The shape of arrays of these shapes that are combined, element by element."""
    try:
        return np.broadcast_shapes(*shapes)
    except ValueError as error:
        raise ParameterError(f"the shapes of {names}", shapes, "ones that go together") from error


def numbers(name: str, value: object, *tail: int, kind: type = float) -> NDArray[Any]:
    """`value` as an array of a `kind` of numbers, whose last axes have the lengths `tail`."""
    try:
        array = np.asarray(value)
    except ValueError:
        # Lists of different lengths.
        array = np.array(None)

    allowed = {int: "iu", float: "iuf", complex: "iufc"}[kind]
    if array.dtype.kind not in allowed or (tail and array.shape[-len(tail) :] != tail):
        bound = "whole numbers" if kind is int else "numbers"
        if tail:
            bound += f" of the shape (..., {', '.join(map(str, tail))})"
        raise ParameterError(name, value, bound)
    return array.astype(kind, copy=False)


def number(value: object) -> float:
    """`value` as a float; nan if it is not a real number."""
    try:
        return float(value) if isinstance(value, Real) and not isinstance(value, bool) else math.nan
    except OverflowError:
        # An int too large for a double.
        return math.inf
