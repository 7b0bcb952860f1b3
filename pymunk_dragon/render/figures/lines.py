"""Lines over time and along the dragon: how they look, and their names beside them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.render.figures.style import COLOURS, RULE, WIDE_HALO, blend, halo

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["ASIDE", "EARLY", "bundle", "label", "logarithmic", "name", "several_times", "spread", "time_name"]

Array = NDArray[np.float64]

# Share of a stretch of time within which two times say the same.
CLOSE = 0.02
# The earliest of several lines; later ones go from here to ink.
EARLY = "#6391bb"
# Points of type: between the middles of two lines of it, and from a line's end to its name.
LINE_HEIGHT, ASIDE = 14.0, 7.0
# Handles or joints that all have their numbers below an axis.
FEW = 10


def several_times(begin: float, end: float) -> Array:
    """A few round times from `begin` on, and `end`, s."""
    from matplotlib.ticker import MaxNLocator

    ticks = MaxNLocator(5, steps=[1, 2, 5, 10]).tick_values(begin, end)
    # One that is close to the end would say the same.
    return np.array([*(tick for tick in ticks if begin <= tick < end - CLOSE * (end - begin)), end])


def logarithmic(axes: Axes, low: float, high: float) -> None:
    """Show `low` to `high` on a logarithmic scale with plain numbers and thin lines."""
    from matplotlib.ticker import NullLocator

    axes.set_yscale("log")
    axes.set_ylim(low, high)
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_locator(NullLocator())
    axes.grid(axis="y", color=RULE, lw=0.6)
    axes.set_axisbelow(True)


def bundle(axes: Axes, values: Array, gid: str) -> list[Any]:
    """Lines of `values` (T, K) along the dragon: the later, the darker and thicker."""
    last = max(len(values) - 1, 1)
    lines: list[Any] = []
    for rank, line in enumerate(values):
        age = rank / last
        lines += axes.plot(line, color=blend(EARLY, COLOURS.ink, age), lw=1.2 + 1.2 * age, gid=f"{gid}-{rank}")
    axes.set_xlim(0, values.shape[1] - 1)
    if values.shape[1] <= FEW:
        # There is nothing between one and the next.
        axes.set_xticks(range(values.shape[1]))
    return lines


def name(axes: Axes, lines: Sequence[Any], times: Array, at: int, offset: float, **options: Any) -> None:
    """Set the lines' times beside their points `at`, as near as they go without touching each other."""
    to_pixels = axes.transData
    points = to_pixels.transform([line.get_xydata()[at] for line in lines])
    points[:, 1] = spread(points[:, 1].tolist(), LINE_HEIGHT / 72 * axes.figure.dpi)
    for (x, y), time in zip(to_pixels.inverted().transform(points).tolist(), times.tolist(), strict=True):
        label(axes, x, y, time_name(time), (offset, 0), va="center_baseline", annotation_clip=False, **options)


def spread(places: Sequence[float], apart: float) -> list[float]:
    """Places for labels as near to `places` as goes while they keep `apart` and their order."""
    order = sorted(range(len(places)), key=lambda i: places[i])
    # Blocks of labels that touch: their numbers, and the middle that suits them best.
    blocks: list[tuple[list[int], float]] = []
    for i in order:
        block, middle = [i], float(places[i])
        while blocks and middle - blocks[-1][1] < apart * (len(block) + len(blocks[-1][0])) / 2:
            before, other = blocks.pop()
            middle = (middle * len(block) + other * len(before)) / (len(block) + len(before))
            block = before + block
        blocks.append((block, middle))
    found = [0.0] * len(places)
    for block, middle in blocks:
        for rank, i in enumerate(block):
            found[i] = middle + apart * (rank - (len(block) - 1) / 2)
    return found


def time_name(time: float) -> str:
    """A time to the hundredth of a second, without zeros at its end."""
    return f"{time:.2f}".rstrip("0").rstrip(".") + " s"


def label(axes: Axes, x: float, y: float, text: str, offset: tuple[float, float], **options: Any) -> None:
    """Type beside a point of a line, readable on others."""
    axes.annotate(text, (x, y), offset, textcoords="offset points", path_effects=halo(WIDE_HALO), **options)
