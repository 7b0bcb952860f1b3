"""Refinement of a sweep's grid along its borders, between points of different kinds.

The axes become finer, and few of the points that they now have are evaluated: those of the given
grid, and then middles between two neighbours on its lines, as long as their kinds differ. Where a
border crosses a line of the given grid is then known to a step of the finer axes, and so is the
width of a band there: the halves always approach what lies between two kinds. A band between two
neighbours of the same kind is not found: nothing shows that it is there.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from pymunk_dragon.sweeps.axes import Axes
from pymunk_dragon.sweeps.partial import PartialTable
from pymunk_dragon.sweeps.quantities import kind


def finer(axes: Axes, halvings: int) -> Axes:
    """Axes whose neighbouring values have been halved, in rising order; the given ones are kept."""
    found = {}
    for name, values in axes.items():
        given = np.unique(values)
        last = len(given) - 1
        places = np.linspace(0, last, last * 2**halvings + 1)
        found[name] = tuple(np.interp(places, range(last + 1), given).tolist())
    return found if halvings else axes


def rounds(partial: PartialTable, halvings: int) -> Iterator[list[int]]:
    """Numbers of points to evaluate, after which `partial` has their outcomes; see this module."""
    shape = [len(values) for values in partial.axes.values()]
    step = 2**halvings
    coarse = np.ix_(*(range(0, count, step) for count in shape))
    numbers = np.ravel_multi_index(coarse, shape).ravel().tolist()
    # From a point to the next one along each axis. Beyond the end of an axis is no known point.
    strides = np.cumprod([1, *shape[:0:-1]]).tolist()
    kinds: dict[int, object] = {}
    while step:
        partial.count += len(numbers)
        yield numbers

        for number in numbers:
            values, error = partial.rows[number]
            kinds[number] = kind([*(values or {}).values(), error])
        middles = set()
        for (number, own), stride in product(kinds.items(), strides):
            if kinds.get(number + step * stride, own) != own:
                middles.add(number + step // 2 * stride)
        numbers = sorted(middles)
        step //= 2
