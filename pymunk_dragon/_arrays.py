"""Types of arrays, vectors of the plane as complex numbers, and values that do not change."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, NoReturn, TypeVar

import numpy as np
from numpy.typing import NDArray

A = TypeVar("A", bound=np.generic)

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]


def as_complex(vectors: Array) -> Complex:
    """Vectors (..., 2) as complex numbers (...), in the same memory if it is contiguous."""
    return np.ascontiguousarray(vectors, dtype=float).view(complex)[..., 0]


def as_vectors(numbers: Complex) -> Array:
    """Complex numbers (...) as vectors (..., 2), in the same memory."""
    return numbers[..., None].view(float)


class FrozenDict(dict[Any, Any]):
    """A dictionary that raises a TypeError when it is changed; JSON and pickle treat it as a dictionary."""

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError("this dictionary does not change")

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[type[FrozenDict], tuple[dict[Any, Any]]]:
        return FrozenDict, (dict(self),)


def frozen(value: Any) -> Any:
    """`value` with each mapping in it as a `FrozenDict`, and each list as a tuple."""
    if isinstance(value, Mapping):
        return FrozenDict({key: frozen(item) for key, item in value.items()})
    return tuple(map(frozen, value)) if isinstance(value, list | tuple) else value


def read_only(array: NDArray[A]) -> NDArray[A]:
    """`array` itself, made read-only."""
    array.flags.writeable = False
    return array


class ArrayRecord:
    """Equality and hash of dataclasses with arrays: their shapes, types and bits.

    Fields with ``compare=False`` are ignored, and others than arrays in the hash.
    """

    def __eq__(self, other: object) -> bool:
        return _values(self) == _values(other) if type(other) is type(self) else NotImplemented

    def __hash__(self) -> int:
        return hash(tuple(value[1] for value in _values(self) if value[0] is np.ndarray))


def _values(record: object) -> list[tuple[type, Any]]:
    """The class and the value of each field that is compared; of an array what can be compared."""
    # Only dataclasses derive from ArrayRecord.
    values = [getattr(record, field.name) for field in fields(record) if field.compare]  # type: ignore[arg-type]
    return [
        (np.ndarray, (each.shape, each.dtype.str, each.tobytes()))
        if isinstance(each, np.ndarray)
        else (type(each), each)
        for each in values
    ]
