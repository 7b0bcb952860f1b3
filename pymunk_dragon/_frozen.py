"""Immutable values: read-only arrays and mappings, and equality of dataclasses with arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, NoReturn, TypeVar

import numpy as np
from numpy.typing import NDArray

A = TypeVar("A", bound=np.generic)


class FrozenDict(dict[Any, Any]):
    """A dictionary that raises a TypeError when it is changed; JSON, copy and pickle treat it as a dictionary."""

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError(f"a {type(self).__name__} does not change")

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[type[FrozenDict], tuple[dict[Any, Any]]]:
        return FrozenDict, (dict(self),)


def frozen(value: Any) -> Any:
    """`value` with each mapping in it as a `FrozenDict`, and each list as a tuple."""
    if isinstance(value, Mapping):
        return FrozenDict({key: frozen(item) for key, item in value.items()})
    if isinstance(value, list | tuple):
        return tuple(map(frozen, value))
    return value


def read_only(array: NDArray[A]) -> NDArray[A]:
    """`array` itself, made read-only."""
    array.flags.writeable = False
    return array


class ArrayRecord:
    """Equality and hash of dataclasses with fields that are arrays.

    Two records are equal if they have the same class, arrays of the same shapes, types and bits, and equal other
    fields. Fields with ``compare=False`` are ignored. The hash is that of the arrays.
    """

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return all(_same(one, two) for one, two in zip(_compared(self), _compared(other), strict=True))

    def __hash__(self) -> int:
        arrays = (value for value in _compared(self) if isinstance(value, np.ndarray))
        return hash(tuple((array.shape, array.tobytes()) for array in arrays))


def _compared(record: object) -> list[Any]:
    """Values of the fields that are compared."""
    # Only dataclasses derive from ArrayRecord.
    return [getattr(record, field.name) for field in fields(record) if field.compare]  # type: ignore[arg-type]


def _same(one: Any, two: Any) -> bool:
    """Whether two values of a field are equal."""
    if not (isinstance(one, np.ndarray) and isinstance(two, np.ndarray)):
        return type(one) is type(two) and bool(one == two)
    return one.shape == two.shape and one.dtype == two.dtype and one.tobytes() == two.tobytes()
