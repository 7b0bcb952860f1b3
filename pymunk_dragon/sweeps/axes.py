"""The points of a sweep: all combinations of listed values, or samples of a box."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice, product
from math import floor, prod
from typing import Any, Literal, get_args

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import number, whole, word
from pymunk_dragon._extras import library
from pymunk_dragon.errors import ParameterError

Sampling = Literal["sobol", "random"]
Point = tuple[float, ...]

# Points of one sweep, at most: the journal keeps 8 bytes in memory for each.
MAX_POINTS = 100_000_000
# Samples, at most: their coordinates are in memory.
MAX_SAMPLES = 10_000_000
# Points at the ends of axes, at most, of which the first valid one gives the values of other parameters.
MAX_CORNERS = 4096
# Largest seed of the samples.
MAX_SEED = 2**63 - 1


class Axes(ABC):
    """Points of a sweep, by their number. `values` are those of each axis, or the two ends of its interval."""

    def __init__(self, values: Mapping[str, tuple[float, ...]]) -> None:
        self.values = values
        self.names = tuple(values)

    @abstractmethod
    def __len__(self) -> int: ...

    @abstractmethod
    def __getitem__(self, index: int) -> Point: ...

    def corners(self) -> Iterator[Point]:
        """The points at the ends of all axes, or the first ones of them if they are very many."""
        ends = [sorted({min(values), max(values)}) for values in self.values.values()]
        yield from islice(product(*ends), MAX_CORNERS)

    def to_dict(self) -> dict[str, Any]:
        """Plain values that determine the points."""
        return {name: list(values) for name, values in self.values.items()}


class Grid(Axes):
    """All combinations of the values of the axes; those of the last axis change first.

    Examples
    --------
    >>> list(Grid({"pitch": (0.5, 0.6), "benches": (10, 20)}))
    [(0.5, 10), (0.5, 20), (0.6, 10), (0.6, 20)]
    """

    def __len__(self) -> int:
        return prod(map(len, self.values.values()))

    def __getitem__(self, index: int) -> Point:
        if not 0 <= index < len(self):
            raise IndexError(index)
        point = []
        for values in reversed(list(self.values.values())):
            index, position = divmod(index, len(values))
            point.append(values[position])
        return tuple(reversed(point))


class Samples(Axes):
    """`count` points of a box: a scrambled Sobol sequence, or independent random ones."""

    def __init__(
        self,
        values: Mapping[str, tuple[float, ...]],
        integers: frozenset[str],
        count: int,
        seed: int,
        sampling: Sampling,
    ) -> None:
        super().__init__(values)
        self._integers = integers
        self._count = count
        self._drawn = {"samples": count, "sampling": sampling, "seed": seed}
        generator = np.random.default_rng(seed)
        # Coordinates (count, axes) in the unit cube.
        self._shares: Array
        if sampling == "random":
            self._shares = generator.random((count, len(values)))
        else:
            # SciPy calls it rng from 1.15 on, but takes both names.
            sequence = library("scipy.stats").qmc.Sobol(len(values), seed=generator)
            # A Sobol sequence is balanced if its length is a power of two.
            self._shares = sequence.random_base2((count - 1).bit_length())[:count]

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, index: int) -> Point:
        return tuple(
            low + floor(share * (high - low + 1)) if name in self._integers else low + share * (high - low)
            for share, (name, (low, high)) in zip(self._shares[index].tolist(), self.values.items(), strict=True)
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain values that determine the points."""
        return super().to_dict() | self._drawn


def axes_of(
    values: Mapping[str, Sequence[float]],
    parameters: Mapping[str, type],
    samples: int | None,
    seed: int,
    sampling: Sampling,
) -> Axes:
    """The points of a sweep over `values` of `parameters`, which have these types.

    Raises
    ------
    ParameterError
        If an axis is no parameter or has other values than numbers of its type, or another argument is out of range.
    MissingExtraError
        If SciPy, which has Sobol sequences, is not installed.
    """
    if not values or not isinstance(values, Mapping):
        raise ParameterError("axis", values or None, "at least one: a parameter and its values")
    checked = {name: _numbers(name, values[name], parameters) for name in values}
    if samples is None:
        count = prod(map(len, checked.values()))
        if count > MAX_POINTS:
            raise ParameterError("axis", f"{count} points", f"at most {MAX_POINTS} points")
        return Grid(checked)
    for name, numbers in checked.items():
        if len(numbers) != 2 or numbers[0] >= numbers[1]:
            bound = "the two ends of an interval, of which samples are taken"
            raise ParameterError("axis", f"{name}={values[name]}", bound)
    integers = frozenset(name for name in checked if parameters[name] is int)
    count = whole("samples", samples, 1, MAX_SAMPLES)
    word("sampling", sampling, get_args(Sampling))
    return Samples(checked, integers, count, whole("seed", seed, 0, MAX_SEED), sampling)


def _numbers(name: str, values: object, parameters: Mapping[str, type]) -> tuple[float, ...]:
    """The values of an axis as numbers of its type."""
    word("axis", name, parameters)
    try:
        listed = np.asarray(values).ravel().tolist()
    except ValueError:
        listed = []
    numbers = [number(value) for value in listed]
    if not numbers or not np.isfinite(numbers).all():
        raise ParameterError("axis", f"{name}={values}", "finite numbers, at least one")
    if parameters[name] is float:
        return tuple(numbers)
    if any(value != floor(value) for value in numbers):
        raise ParameterError("axis", f"{name}={values}", "whole numbers")
    return tuple(map(int, numbers))
