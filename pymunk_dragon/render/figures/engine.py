"""Figures of a run of the engine: how far it drifts, and what its joints carry."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.errors import ParameterError
from pymunk_dragon.render.figures.lines import ASIDE, bundle, label, logarithmic, name, several_times, time_name
from pymunk_dragon.render.figures.style import AMBER, BLUE, COLOURS, page, panel
from pymunk_dragon.render.figures.times import ending, stretch
from pymunk_dragon.run import HEAD_BENCHES, Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["drift", "impulses"]

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

# Points of a line over time at most.
MOMENTS = 600
# Where along a line its name stands, as a share.
NAME_PLACE = 0.42
# Metres of drift from which on a unit of so many in a metre is used.
UNITS = ((1.0, 1.0, "m"), (1e-3, 1e3, "mm"), (0.0, 1e6, "\N{MICRO SIGN}m"))
# N from which on the digits after the point tell nothing.
WHOLE_FORCE = 10.0
# N below which nothing pulls: on a straight way at one speed joints still carry what rounding leaves.
NO_FORCE = 1e-6
# Powers of ten that the scales of drift and of impulse cover.
DRIFT_DECADES, IMPULSE_DECADES = 4, 3


def drift(run: Run) -> Figure:
    """How far the engine is from the exact model: over time, and along the dragon."""
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
    # The name of the higher line stands above it, that of the lower one below.
    series: list[tuple[str, str, Any, Array, float, str]] = [("any bench", BLUE, "-", run.drift, 6, "bottom")]
    if run.march.dragon.benches > HEAD_BENCHES:
        first = run.drift[:, :HEAD_BENCHES]
        series.append((f"first {HEAD_BENCHES} benches", AMBER, (0, (4, 1.2)), first, -6, "top"))
    frames = _thinned(run)
    middle = len(frames) // 3
    for who, colour, dashes, drifts, offset, side in series:
        worst = scale * np.fmax.reduce(drifts[frames], axis=1)
        over_time.plot(run.times[frames], worst, color=colour, lw=2.2, ls=dashes, gid=who.replace(" ", "-"))
        label(over_time, run.times[frames[middle]], worst[middle], who, (0, offset), ha="center", va=side, color=colour)
    rows = _rows(run, several_times(float(run.times[0]), float(run.times[-1]))[1:])
    profiles = scale * run.drift[rows]
    lines = bundle(along, profiles, "drift")
    low, high = _decades(scale * run.max_drift, DRIFT_DECADES)
    misses = ending(run.march, stretch(run)).near_misses or ()
    gaps = [miss.gap for miss in misses if run.times[0] <= miss.time <= run.times[-1]]
    if gaps:
        # What the drift has to be compared with: an engine that is as far off meets the wrong bench.
        least = scale * min(gaps)
        high = max(high, 2 * least)
        for axes in (over_time, along):
            axes.axhline(least, color=COLOURS.ink, lw=1.0, ls=(0, (1, 2)), gid="smallest-gap")
        text = f"smallest gap on the way: {least:.3g} {unit}"
        label(over_time, float(run.times[0]), least, text, (8, -6), va="top")
    logarithmic(over_time, low, high)
    name(along, lines, run.times[rows], -1, ASIDE)
    along.tick_params(labelleft=False)
    over_time.set_xlim(run.times[0], run.times[-1])
    over_time.set_xlabel("time (s)")
    along.set_xlabel("bench")
    return figure


def impulses(run: Run) -> Figure:
    """The impulse in every joint in a substep, and the force that it makes, at several times."""
    substep = run.provenance.get("substep")
    if run.joint_impulses is None or not isinstance(substep, int | float):
        raise ParameterError("run", "one without joint impulses", "one of the engine, as `simulate` makes it")
    # The frame of the contact ends a cut substep, in which the joints have not settled.
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
    # At their ends the lines run together.
    name(axes, lines, run.times[rows], int(NAME_PLACE * values.shape[1]), 0, ha="center")
    axes.set_xlabel("joint, from the head to the tail; joint i is between benches i and i + 1")
    return figure


def _force(size: float) -> str:
    """In N: whole ones, or two digits of a small one."""
    return f"{size:.0f} N" if size >= WHOLE_FORCE or size < NO_FORCE else f"{size:.2g} N"


def _rows(run: Run, times: Array) -> Indices:
    """Frames of `run` at or right after `times`."""
    return np.unique(np.searchsorted(run.times, times))


def _thinned(run: Run) -> Indices:
    """Frames to draw over time, but for the first, which has no drift yet."""
    return np.unique(np.linspace(min(1, len(run.times) - 1), len(run.times) - 1, MOMENTS).astype(np.intp))


def _decades(largest: float, count: int) -> tuple[float, float]:
    """So many powers of ten, of which the last holds `largest`."""
    high = float(np.ceil(np.log10(largest)))
    return 10.0 ** (high - count), 10.0**high
