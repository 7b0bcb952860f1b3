"""Figures over time and along the dragon: gaps of the head, speeds, and the engine's position errors and forces."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import text
from pymunk_dragon.collision import separation
from pymunk_dragon.drawing.figures import style
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.run import HEAD_BENCHES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# m: lower end of the scale of gaps.
_MIN_GAP = 1.5e-4
# Head lengths travelled: the part of a march before its end that `gap` shows.
_GAP_LENGTHS = 4.5


def gap(subject: style.Subject) -> Figure:
    """Draw the gap between the head and the benches it passes at last, on a logarithmic scale."""
    march, hit = subject.march, subject.hit
    if march.dragon.benches < 3:
        raise ParameterError("benches", march.dragon.benches, "3 or more: neighbours have no gap")
    since = float(march.time(march.distance(hit.time) - _GAP_LENGTHS * march.dragon.lengths[0]))
    since = max(subject.begin, since)
    misses = [miss for miss in hit.near_misses or () if miss.benches[0] == 0 and miss.time > since]
    subtitle = text("gap between the head and the nearest bench but its neighbour; dashed: to each bench by itself")
    figure = style.slide(text("How near the head comes to other benches than its neighbour"), subtitle)
    axes = style.panels(figure)
    times = np.union1d(np.linspace(since, hit.time, 1000), [miss.time for miss in misses])
    # In parts, to limit memory.
    corners = (march.dragon.outlines(march.at(part).poses) for part in np.array_split(times, 10))
    gaps = np.concatenate([separation(part[:, :1], part[:, 2:]).distance for part in corners])
    for row in np.unique(gaps.argmin(axis=1)).tolist():
        axes.plot(times, gaps[:, row], color=style.QUIET, lw=0.8, ls=(0, (4, 2)), gid=f"gap-{row + 2}")
    smallest = gaps.min(axis=1)
    low, high = float(smallest.min()) / 3, 3 * float(smallest.max())
    axes.plot(times, smallest, color=style.BLUE, lw=2.0, gid="gap")
    style.logarithmic(axes, "m", _MIN_GAP if hit.contact else max(_MIN_GAP, low), high)
    axes.set(xlim=(since, hit.time), xlabel=text("time (s)"))
    for miss, marker in zip(misses, "osD^v", strict=False):
        note = text("bench {}: {:.3f} mm\nat {:.3f} s").format(miss.benches[1], 1e3 * miss.gap, miss.time)
        axes.plot(miss.time, miss.gap, marker, color=style.COLOURS.ink, ms=6, label=note)
    if hit.contact:
        note = text("bench {}: contact\nat {:.4f} s").format(hit.contact.benches[1], hit.time)
        axes.plot(hit.time, _MIN_GAP, "X", color=style.COLOURS.contact, ms=8, label=note, clip_on=False)
    if misses or hit.contact:
        axes.legend(**style.BESIDE)
    return figure


def speeds(subject: style.Subject) -> Figure:
    """Draw the speed along the dragon at several times."""
    times = _several_times(subject.begin, subject.last_regular_time)
    values = subject.march.at(times).speeds
    title = text("The handles go at {:.3f} to {:.3f} m/s").format(values.min(), values.max())
    figure = style.slide(title, text("speed of every handle at several times, m/s"))
    _bundle(style.panels(figure), values, times, "speed", text("handle, from the head to the tail"))
    return figure


def drift(subject: style.Subject) -> Figure:
    """Draw the engine's position error against the exact model over time."""
    from matplotlib.ticker import EngFormatter

    run = subject.run
    if run is None or len(run.times) == 1 or not run.max_drift > 0:
        raise ParameterError("run", "one without a drift", "one that the engine has played for a while")
    metres = EngFormatter("m", places=1)
    title = text("The engine stays within {} of the exact model").format(metres(run.max_drift))
    figure = style.slide(title, text("position errors of the benches, at the worse of their two holes"))
    axes = style.panels(figure)
    # Without the first frame, whose position error is 0.
    frames = np.unique(np.linspace(1, len(run.times) - 1, 600).astype(np.intp))
    some = text("largest of the first {}").format(HEAD_BENCHES)
    worst = np.fmax.reduce(run.drift[frames], axis=1), np.fmax.reduce(run.drift[frames, :HEAD_BENCHES], axis=1)
    axes.plot(run.times[frames], worst[0], color=style.BLUE, lw=2.2, gid="any-bench", label=text("largest of all"))
    axes.plot(run.times[frames], worst[1], color=style.AMBER, lw=2.2, ls="--", gid="first-benches", label=some)
    high = 10.0 ** np.ceil(np.log10(run.max_drift))
    # An engine with a position error as large as the smallest gap can find the wrong first contact.
    gaps = [miss.gap for miss in subject.hit.near_misses or () if run.times[0] <= miss.time <= run.times[-1]]
    if gaps:
        note = text("smallest gap: {}").format(metres(min(gaps)))
        axes.axhline(min(gaps), color=style.COLOURS.ink, lw=1.2, ls=":", gid="smallest-gap", label=note)
    style.logarithmic(axes, "m", 1e-4 * high, max(high, 2 * min(gaps, default=0.0)))
    axes.set(xlim=(run.times[0], run.times[-1]), xlabel=text("time (s)"))
    axes.legend(**style.BESIDE)
    return figure


def impulses(subject: style.Subject) -> Figure:
    """Draw the force in every joint at several times: the impulse in a substep over the substep."""
    run = subject.run
    if run is None or run.joint_impulses is None or run.substep is None:
        raise ParameterError("run", "one without joint impulses", "one of the engine, as `simulate` makes it")
    # The frame of the contact follows a shortened substep, in which the joint solver has not converged.
    before = run.times < (run.first_contact.time if run.first_contact else np.inf)
    times, forces = run.times[before], run.joint_impulses[before] / run.substep
    if not forces.max(initial=0.0) > 0:
        raise ParameterError("run", "one whose joints carry nothing", "one that the engine has played for a while")
    rows = np.unique(np.searchsorted(times, _several_times(times[0], times[-1])))
    title = text("The joints carry up to {:.2f} N").format(forces[rows].max())
    subtitle = text("force in every joint, N: the mean over a substep of {:g} ms").format(1e3 * run.substep)
    figure = style.slide(title, subtitle)
    joint = text("joint, from the head to the tail; joint i is between benches i and i + 1")
    _bundle(style.panels(figure), forces[rows], times[rows], "impulse", joint)
    return figure


def _several_times(begin: float, end: float) -> Array:
    """Return a few round times, s, from `begin` on, and `end`."""
    from matplotlib.ticker import MaxNLocator

    ticks = MaxNLocator(5, steps=[1, 2, 5, 10]).tick_values(begin, end)
    # A tick within a fiftieth of the interval before the end is omitted.
    return np.array([*(tick for tick in ticks if begin <= tick < end - (end - begin) / 50), end])


def _bundle(axes: Axes, values: Array, times: Array, gid: str, along: str) -> None:
    """Draw lines of `values` (T, K) along the dragon, later ones darker, with their `times` in a legend."""
    from matplotlib import colormaps

    colours = colormaps["Blues"](np.linspace(0.4, 1.0, len(times)))
    for rank, (line, time) in enumerate(zip(values, times, strict=True)):
        axes.plot(line, color=colours[rank], lw=1.8, gid=f"{gid}-{rank}", label=f"{time:.5g} s")
    axes.set(xlim=(0, values.shape[1] - 1), xlabel=along)
    axes.locator_params(axis="x", integer=True)
    axes.grid(axis="y", color=style.RULE, lw=0.6)
    axes.legend(**style.BESIDE)
