"""The order of the engine: its error over the length of its step, where only the head pulls."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pymunk_dragon._language import text
from pymunk_dragon.drawing.figures.style import (
    AMBER,
    BESIDE,
    BLUE,
    QUIET,
    FigureSource,
    logarithmic,
    slide,
)
from pymunk_dragon.dynamics import pull
from pymunk_dragon.model.run import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# s at 1 m/s: lengths of the steps.
_SUBSTEPS = np.array([0.04, 0.02, 0.01, 0.005])
# Iterations of the solver: so many that the joints hold, and only the error of the step is left.
_ITERATIONS = 40
# m: distance that the head travels.
_DISTANCE = 10.0
# Tolerance of the exact dynamics: their error is a thousandth of the smallest one that is drawn.
_TOLERANCE = 1e-8


def draw(source: FigureSource) -> Figure:
    """Draw the largest position error over the step, with both rules and with slopes 1 and 2."""
    march = source.march
    start = source.begin
    until = float(march.time(march.distance(start) + _DISTANCE))
    exact = pull(march, start=start, until=until, tolerance=_TOLERANCE)
    substeps = _SUBSTEPS / march.speed_profile.fastest(start, until)
    figure, axes = slide(
        text("Half the step leaves a half of the error, or a quarter"),
        text("largest position error of a bench where only the head pulls, {:g} m", _DISTANCE),
    )
    smallest = np.inf
    names = text("Pymunk's step (order 1)"), text("this engine's (order 2)")
    for order, name, colour in zip((1, 2), names, (AMBER, BLUE), strict=True):
        errors = [_largest_error(exact, order, substep) for substep in substeps.tolist()]
        axes.loglog(substeps, errors, "o-", color=colour, gid=f"order-{order}", label=name)
        slope = errors[0] * (substeps / substeps[0]) ** order
        label = text("slope {}", order)
        axes.loglog(substeps, slope, "--", color=QUIET, lw=0.9, gid=f"slope-{order}", label=label)
        smallest = min(smallest, *errors)

    logarithmic(axes, smallest / 3, 1e-2)
    axes.set_xticks(substeps, [f"{1e3 * substep:.3g} ms" for substep in substeps])
    axes.set_xticks([], minor=True)
    axes.set(xlabel=text("substep"))
    axes.legend(**BESIDE)
    return figure


def _largest_error(exact: Run, order: int, substep: float) -> float:
    """Largest distance of a bench of the engine from the `exact` run, m."""
    # Drawing does without Pymunk, but for this figure.
    from pymunk_dragon.physics import simulate

    begin, end = exact.interval
    run = simulate(
        exact.march,
        guide="none",
        contacts="report",
        start=begin,
        until=end,
        order=order,
        substep=substep,
        iterations=_ITERATIONS,
    )
    off = run.poses[..., :2] - exact.poses_at(run.times)[..., :2]
    return float(np.linalg.norm(off, axis=-1).max())
