"""Types of arrays, and vectors of the plane as complex numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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
