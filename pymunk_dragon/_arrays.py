"""Types of arrays, vectors as complex numbers, and records with arrays."""

from dataclasses import fields
from typing import Any, TypeVar

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


def read_only(array: NDArray[A]) -> NDArray[A]:
    """`array` itself, made read-only."""
    array.flags.writeable = False
    return array


class ArrayRecord:
    """Equality and hash of dataclasses with arrays: their shapes, types and bits.

    Fields with ``compare=False`` are ignored. The hash is that of the arrays.
    """

    def __eq__(self, other: object) -> bool:
        return _values(self) == _values(other) if type(other) is type(self) else NotImplemented

    def __hash__(self) -> int:
        return hash(tuple(value for kind, value in _values(self) if kind is np.ndarray))


def _values(record: Any) -> list[tuple[type, Any]]:
    """Class and value of each field that is compared; of an array its shape, type and bytes."""
    values: list[tuple[type, Any]] = []
    for field in fields(record):
        if field.compare:
            value = getattr(record, field.name)
            kind = type(value)
            if isinstance(value, np.ndarray):
                value = value.shape, value.dtype.str, value.tobytes()
            values.append((kind, value))
    return values
