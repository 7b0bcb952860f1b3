"""Figures of a run of the engine: position errors, and impulses in the joints."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.drawing.figures.lines import NAME_OFFSET, bundle, label, logarithmic, name, several_times, time_name
from pymunk_dragon.drawing.figures.style import AMBER, BLUE, COLOURS, page, panel
from pymunk_dragon.drawing.figures.times import contact_or_end, time_interval
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.run import HEAD_BENCHES, Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["drift", "impulses"]

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

# Largest number of points of a line over time.
TIME_SAMPLES = 600
# Position of a line's label, as a fraction of the line: at the ends the lines are too close to each other.
LABEL_POSITION = 0.42
# Units of position errors: smallest error in m, units per metre, and symbol.
UNITS = ((1.0, 1.0, "m"), (1e-3, 1e3, "mm"), (0.0, 1e6, "\N{MICRO SIGN}m"))
# N: larger forces are displayed as whole numbers.
MIN_WHOLE_FORCE = 10.0
# N: smaller forces are rounding errors, as on a straight path at constant speed.
NO_FORCE = 1e-6
# Powers of ten covered by the scale of position errors.
DRIFT_DECADES = 4
# Powers of ten covered by the scale of impulses.
IMPULSE_DECADES = 3


def drift(run: Run) -> Figure:
    """Draw the engine's position error against the exact model: over time, and along the dragon."""
    if run.provenance.get("player") == "exact":
        raise ParameterError("run", "one of the exact model", "one of the engine, which alone drifts")
    if len(run.times) == 1 or not run.max_drift > 0:
        raise ParameterError("run", "one without a drift", "one that the engine has played for a while")
    scale, unit = next((scale, unit) for least, scale, unit in UNITS if run.max_drift >= least)
    figure = page(
        8.0,
        5.6,
        f"The engine stays within {scale * run.max_drift:.3g} {unit} of the exact model",
        f"distance of every bench's worse hole from where the exact model has it, {unit}",
    )
    over_time = panel(figure, 0.85, 0.65, 3.7, 3.9)
    along = panel(figure, 4.75, 0.65, 2.2, 3.9, sharey=over_time)
    # The upper line has its label above, the lower line below.
    series: list[tuple[str, str, Any, Array, float, str]] = [("any bench", BLUE, "-", run.drift, 6, "bottom")]
    if run.march.dragon.benches > HEAD_BENCHES:
        first = run.drift[:, :HEAD_BENCHES]
        series.append((f"first {HEAD_BENCHES} benches", AMBER, (0, (4, 1.2)), first, -6, "top"))
    frames = _thinned(run)
    middle = len(frames) // 3
    for subject, colour, dashes, drifts, offset, side in series:
        worst = scale * np.fmax.reduce(drifts[frames], axis=1)
        over_time.plot(run.times[frames], worst, color=colour, lw=2.2, ls=dashes, gid=subject.replace(" ", "-"))
        label(
            over_time,
            run.times[frames[middle]],
            worst[middle],
            subject,
            (0, offset),
            ha="center",
            va=side,
            color=colour,
        )
    rows = _rows(run, several_times(float(run.times[0]), float(run.times[-1]))[1:])
    profiles = scale * run.drift[rows]
    lines = bundle(along, profiles, "drift")
    low, high = _decades(scale * run.max_drift, DRIFT_DECADES)
    near_misses = contact_or_end(run.march, time_interval(run)).near_misses or ()
    gaps = [near_miss.gap for near_miss in near_misses if run.times[0] <= near_miss.time <= run.times[-1]]
    if gaps:
        # An engine with a position error as large as the smallest gap can find the wrong first contact.
        least = scale * min(gaps)
        high = max(high, 2 * least)
        for axes in (over_time, along):
            axes.axhline(least, color=COLOURS.ink, lw=1.0, ls=(0, (1, 2)), gid="smallest-gap")
        text = f"smallest gap on the way: {least:.3g} {unit}"
        label(over_time, float(run.times[0]), least, text, (8, -6), va="top")
    logarithmic(over_time, low, high)
    name(along, lines, run.times[rows], -1, NAME_OFFSET)
    along.tick_params(labelleft=False)
    over_time.set_xlim(run.times[0], run.times[-1])
    over_time.set_xlabel("time (s)")
    along.set_xlabel("bench")
    return figure


def impulses(run: Run) -> Figure:
    """Draw the impulse in every joint in a substep, and the equivalent force, at several times."""
    substep = run.provenance.get("substep")
    if run.joint_impulses is None or not isinstance(substep, int | float):
        raise ParameterError("run", "one without joint impulses", "one of the engine, as `simulate` makes it")
    # The frame of the contact follows a shortened substep, in which the joint solver has not converged.
    end = run.first_contact.time if run.first_contact else np.inf
    played = run.times[run.times < end]
    if not played.size:
        raise ParameterError("run", "one that begins with its contact", "one with a frame before its contact")
    rows = _rows(run, several_times(float(played[0]), float(played[-1])))
    values = run.joint_impulses[rows]
    least, most = values[0].max() / substep, values[-1].max() / substep
    if not values.max() > 0:
        raise ParameterError("run", "one whose joints carry nothing", "one that the engine has played for a while")
    last = time_name(run.times[rows[-1]])
    figure = page(
        8.0,
        5.6,
        f"The joints carry up to {_force(least)} at first, and up to {_force(most)} at {last}",
        f"impulse in every joint in a substep of {1e3 * substep:g} ms, N s; at the right the force that makes it, N",
    )
    axes = panel(figure, 0.85, 0.65, 6.25, 3.9)
    lines = bundle(axes, values, "impulse")
    logarithmic(axes, *_decades(float(values.max()), IMPULSE_DECADES))
    force = axes.secondary_yaxis("right", functions=(partial(np.multiply, 1 / substep), partial(np.multiply, substep)))
    force.yaxis.set_major_formatter("{x:g}")
    force.minorticks_off()
    force.spines["right"].set_visible(True)
    # Labels are not at the lines' ends, where the lines converge.
    name(axes, lines, run.times[rows], int(LABEL_POSITION * values.shape[1]), 0, ha="center")
    axes.set_xlabel("joint, from the head to the tail; joint i is between benches i and i + 1")
    return figure


def _force(size: float) -> str:
    """Format a force in N: as a whole number, or a small force with two significant digits."""
    return f"{size:.0f} N" if size >= MIN_WHOLE_FORCE or size < NO_FORCE else f"{size:.2g} N"


def _rows(run: Run, times: Array) -> Indices:
    """Return the first frames of `run` at or after `times`."""
    return np.unique(np.searchsorted(run.times, times))


def _thinned(run: Run) -> Indices:
    """Return the frames to draw over time, without the first frame, whose position error is 0."""
    return np.unique(np.linspace(min(1, len(run.times) - 1), len(run.times) - 1, TIME_SAMPLES).astype(np.intp))


def _decades(largest: float, count: int) -> tuple[float, float]:
    """Return the limits of a scale of `count` powers of ten whose last one contains `largest`."""
    high = float(np.ceil(np.log10(largest)))
    return 10.0 ** (high - count), 10.0**high
