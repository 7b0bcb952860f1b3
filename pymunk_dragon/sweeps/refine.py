"""Refinement of a sweep's grid along its borders, between points of different kinds.

The axes become finer, and few of the points that they now have are evaluated: those of the given
grid, and then middles between two neighbours on its lines, as long as their kinds differ. Where a
border crosses a line of the given grid is then known to a step of the finer axes, and so is the
width of a band there: the halves always approach what lies between two kinds.
"""

from __future__ import annotations

from collections.abc import Iterator

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
        found[name] = tuple(np.interp(places, np.arange(last + 1), given).tolist())
    return found if halvings else axes


def rounds(partial: PartialTable, halvings: int) -> Iterator[list[int]]:
    """Numbers of points to evaluate, after which `partial` has their outcomes; see this module."""
    shape = [len(values) for values in partial.axes.values()]
    coarse = np.ix_(*(np.arange(0, count, 2**halvings) for count in shape))
    numbers = np.ravel_multi_index(coarse, shape).ravel().tolist()
    # From a point to the next one along each axis. Beyond the end of an axis is no known point.
    strides = np.cumprod([1, *shape[:0:-1]]).tolist()
    kinds: dict[int, object] = {}
    for level in range(halvings, -1, -1):
        partial.count += len(numbers)
        yield numbers

        for number in numbers:
            values, error = partial.rows[number]
            kinds[number] = kind([*(values or {}).values(), error])
        steps = [stride * 2**level for stride in strides]
        pairs = [(number, number + step) for step in steps for number in kinds]
        apart = {a + b for a, b in pairs if kinds.get(b, kinds[a]) != kinds[a]}
        numbers = sorted(double // 2 for double in apart)
