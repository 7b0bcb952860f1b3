"""The points of a sweep: all combinations of listed values, or samples of a box."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import floor, prod
from typing import Any, Literal

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import number, whole, word
from pymunk_dragon._extras import library
from pymunk_dragon.errors import ParameterError

Sampling = Literal["sobol", "random"]
Point = tuple[float, ...]

# Points of one sweep, at most: their number has a place in memory for each, 8 bytes.
MAX_POINTS = 100_000_000
# Largest seed of the samples.
MAX_SEED = 2**63 - 1


class Axes(ABC):
    """Points of a sweep, by their number; `names` are those of the axes."""

    names: tuple[str, ...]

    @abstractmethod
    def __len__(self) -> int: ...

    @abstractmethod
    def __getitem__(self, index: int) -> Point: ...

    @property
    @abstractmethod
    def ends(self) -> Sequence[tuple[float, float]]:
        """Smallest and largest value of each axis."""

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """Plain values that determine the points."""

    def corners(self) -> Iterator[Point]:
        """The points at the ends of all axes."""
        yield from dict.fromkeys(product(*self.ends))


@dataclass(frozen=True)
class Grid(Axes):
    """All combinations of the values of the axes; those of the last axis change first.

    Examples
    --------
    >>> list(Grid({"pitch": (0.5, 0.6), "benches": (10, 20)}))
    [(0.5, 10), (0.5, 20), (0.6, 10), (0.6, 20)]
    """

    values: Mapping[str, tuple[float, ...]]

    @property
    def names(self) -> tuple[str, ...]:  # type: ignore[override]  # Not to be set.
        return tuple(self.values)

    @cached_property
    def _length(self) -> int:
        return prod(map(len, self.values.values()))

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, index: int) -> Point:
        if not 0 <= index < self._length:
            raise IndexError(index)
        point = []
        for values in reversed(self.values.values()):
            index, place = divmod(index, len(values))
            point.append(values[place])
        return tuple(reversed(point))

    @property
    def ends(self) -> Sequence[tuple[float, float]]:
        return [(min(values), max(values)) for values in self.values.values()]

    def to_dict(self) -> dict[str, Any]:
        return {name: list(values) for name, values in self.values.items()}


@dataclass(frozen=True)
class Samples(Axes):
    """`count` points of a box: a scrambled Sobol sequence, or independent random ones."""

    intervals: Mapping[str, tuple[float, float]]
    integers: frozenset[str]
    count: int
    seed: int
    sampling: Sampling

    @property
    def names(self) -> tuple[str, ...]:  # type: ignore[override]  # Not to be set.
        return tuple(self.intervals)

    @cached_property
    def _shares(self) -> Array:
        """Coordinates (count, axes) in the unit cube."""
        dimensions = len(self.intervals)
        if self.sampling == "random":
            return np.random.default_rng(self.seed).random((self.count, dimensions))
        sequence = library("scipy.stats").qmc.Sobol(dimensions, rng=np.random.default_rng(self.seed))
        # A Sobol sequence is balanced if its length is a power of two.
        shares: Array = sequence.random_base2((self.count - 1).bit_length())[: self.count]
        return shares

    def __len__(self) -> int:
        return self.count

    def __getitem__(self, index: int) -> Point:
        return tuple(
            low + floor(share * (high - low + 1)) if name in self.integers else low + share * (high - low)
            for share, (name, (low, high)) in zip(self._shares[index].tolist(), self.intervals.items(), strict=True)
        )

    @property
    def ends(self) -> Sequence[tuple[float, float]]:
        return list(self.intervals.values())

    def to_dict(self) -> dict[str, Any]:
        sampled = {"samples": self.count, "sampling": self.sampling, "seed": self.seed}
        return {name: list(interval) for name, interval in self.intervals.items()} | sampled


def axes_of(
    values: Mapping[str, Sequence[float]],
    parameters: Mapping[str, type],
    samples: int | None,
    seed: int,
    sampling: str,
) -> Axes:
    """The points of a sweep over `values` of `parameters`, which have these types.

    Raises
    ------
    ParameterError
        If an axis is no parameter or has other values than numbers of its type, or another argument is out of range.
    MissingExtraError
        If SciPy, which has Sobol sequences, is not installed.
    """
    if not values:
        raise ParameterError("axis", None, "at least one: a parameter and its values")
    checked = {name: _numbers(name, values[name], parameters) for name in values}
    if samples is None:
        grid = Grid(checked)
        if grid._length > MAX_POINTS:
            raise ParameterError("axis", f"{grid._length} points", f"at most {MAX_POINTS} points")
        return grid
    for name, numbers in checked.items():
        if len(numbers) != 2 or numbers[0] >= numbers[1]:
            raise ParameterError(name, values[name], "the two ends of an interval, of which samples are taken")
    drawn = Samples(
        {name: (low, high) for name, (low, high) in checked.items()},
        frozenset(name for name in checked if parameters[name] is int),
        whole("samples", samples, 1, MAX_POINTS),
        whole("seed", seed, 0, MAX_SEED),
        "random" if word("sampling", sampling, ("sobol", "random")) == "random" else "sobol",
    )
    if drawn.sampling == "sobol":
        library("scipy.stats")
    return drawn


def _numbers(name: str, values: object, parameters: Mapping[str, type]) -> tuple[float, ...]:
    """The values of an axis as numbers of its type."""
    if name not in parameters:
        raise ParameterError("axis", name, "one of " + ", ".join(parameters))
    try:
        listed = np.asarray(values).ravel().tolist()
    except ValueError:
        listed = []
    numbers = [number(value) for value in listed]
    if not numbers or not np.isfinite(numbers).all():
        raise ParameterError(name, values, "finite numbers, at least one")
    if parameters[name] is float:
        return tuple(numbers)
    if any(value != floor(value) for value in numbers):
        raise ParameterError(name, values, "whole numbers")
    return tuple(map(int, numbers))
