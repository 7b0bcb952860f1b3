"""Figures over time and along the dragon: gaps of the head, speeds, and the engine's position errors and impulses."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._arrays import Array, Indices
from pymunk_dragon.collision import FirstContact, separation
from pymunk_dragon.drawing.figures.lines import NAME_OFFSET, bundle, label, logarithmic, name, several_times, time_name
from pymunk_dragon.drawing.figures.style import AMBER, BLUE, COLOURS, FAINT, QUIET, page, panel
from pymunk_dragon.drawing.figures.times import (
    TimeInterval,
    contact_or_end,
    last_regular_time,
    spirals_in,
    time_interval,
)
from pymunk_dragon.drawing.scene import smallest_gap
from pymunk_dragon.drawing.snapshots import snapshots
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import HEAD_BENCHES, Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# Times at which gaps are sampled: as many as the line is pixels wide.
GAP_SAMPLES = 1400
# Head lengths: the close-up shows the time in which the head travels this distance.
CLOSE_UP_LENGTHS = 4.5
# Millimetres per metre.
MM = 1e3
# mm: lower end of the scale.
MIN_GAP = 0.3
# mm: replaces smaller gaps, because a gap of 0 has no logarithm; below the scale.
GAP_OF_CONTACT = 0.03
# mm: position of the contact's label on the line, above the labels of the near misses.
CONTACT_LABEL_GAP = 1.2
# Free border at the right of a chart over time, as a fraction of the time interval.
RIGHT_BORDER = 0.02
# Ratio of the upper end of the scale to the largest value.
TOP_BORDER = 1.5
# Largest number of points of a line over time.
TIME_SAMPLES = 600
# Position of a line's label, as a fraction of the line: at the ends the lines are too close to each other.
LABEL_POSITION = 0.42
# Units of position errors: smallest error in m, units per metre, and symbol.
UNITS = ((1.0, 1.0, "m"), (1e-3, 1e3, "mm"), (0.0, 1e6, "\u00b5m"))
# N: larger forces are displayed as whole numbers.
MIN_WHOLE_FORCE = 10.0
# N: smaller forces are rounding errors, as on a straight path at constant speed.
NO_FORCE = 1e-6
# Powers of ten covered by the scale of position errors.
DRIFT_DECADES = 4
# Powers of ten covered by the scale of impulses.
IMPULSE_DECADES = 3


def gap(march: March, interval: TimeInterval) -> Figure:
    """Draw the gap between the head and the benches it passes, on a logarithmic scale."""
    if march.dragon.benches < 3:
        raise ParameterError("benches", march.dragon.benches, "3 or more: neighbours have no gap")
    hit, begin = contact_or_end(march, interval), interval[0]
    near_misses = [near_miss for near_miss in hit.near_misses or () if near_miss.benches[0] == 0]
    title = "How near the head comes to other benches than its neighbour"
    if spirals_in(march):
        title = "The tighter the coil, the closer the head comes to the benches that it passes"
    if hit.contact and near_misses:
        narrow = min(near_misses, key=lambda near_miss: near_miss.gap)
        passed, met = narrow.benches[1], hit.contact.benches[1]
        title = f"The head slips past bench {passed} by {MM * narrow.gap:.1f} mm, and then hits bench {met}"
    figure = page(
        8.0,
        7.6,
        title,
        "gap between the head and the nearest bench but its neighbour, mm; dashed, to each bench by itself",
    )
    since = max(begin, float(march.time(march.distance(hit.time) - CLOSE_UP_LENGTHS * march.dragon.lengths[0])))
    whole = panel(figure, 0.85, 4.85, 6.85, 1.75)
    close = panel(figure, 0.85, 0.65, 6.85, 3.5)
    whole.axvspan(since, hit.time, color=FAINT, lw=0)
    widest = gap_line(whole, march, _sample_times(begin, hit), "gap")
    gap_line(close, march, _sample_times(since, hit), "last-gap")
    for axes, left in ((whole, begin), (close, since)):
        axes.set_xlim(left, hit.time + RIGHT_BORDER * (hit.time - left))
        logarithmic(axes, MIN_GAP, TOP_BORDER * widest)
    close.set_xlabel("time (s)")
    for near_miss in near_misses:
        if near_miss.time > since:
            close.plot(near_miss.time, MM * near_miss.gap, "o", color=COLOURS.ink, ms=6)
            text = f"bench {near_miss.benches[1]}: {MM * near_miss.gap:.3f} mm\nat {near_miss.time:.3f} s"
            label(close, near_miss.time, MM * near_miss.gap, text, (0, -8), ha="center", va="top")
    if hit.contact:
        text = f"bench {hit.contact.benches[1]}:\ncontact at\n{hit.time:.4f} s"
        label(close, hit.time, CONTACT_LABEL_GAP, text, (-9, 0), ha="right", va="bottom", color=COLOURS.contact)
    return figure


def speeds(march: March, interval: TimeInterval) -> Figure:
    """Draw the speed along the dragon at several times."""
    end, when = last_regular_time(contact_or_end(march, interval), interval[0])
    times = several_times(interval[0], end)
    values = march.at(times).speeds
    title = f"The handles go at {values.min():.3f} to {values.max():.3f} m/s"
    if spirals_in(march):
        title = f"The tighter the coil, the slower the body: {values[-1, -1]:.3f} m/s {when}"
    figure = page(8.0, 5.6, title, "speed of every handle, m/s")
    axes = panel(figure, 0.85, 0.65, 5.9, 3.9)
    lines = bundle(axes, values, "speed")
    name(axes, lines, times, -1, NAME_OFFSET)
    axes.set_xlabel("handle, from the head to the tail")
    return figure


def drift(run: Run) -> Figure:
    """Draw the engine's position error against the exact model: over time, and along the dragon."""
    if run.player == "exact":
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
    frames = _thinned(run)
    middle = len(frames) // 3

    def draw(subject: str, drifts: Array, colour: str, dashes: Any, offset: float, side: str) -> None:
        worst = scale * np.fmax.reduce(drifts[frames], axis=1)
        over_time.plot(run.times[frames], worst, color=colour, lw=2.2, ls=dashes, gid=subject.replace(" ", "-"))
        label(over_time, run.times[frames[middle]], worst[middle], subject, (0, offset), "center", side, color=colour)

    # The upper line has its label above, the lower line below.
    draw("any bench", run.drift, BLUE, "-", 6, "bottom")
    if run.march.dragon.benches > HEAD_BENCHES:
        draw(f"first {HEAD_BENCHES} benches", run.drift[:, :HEAD_BENCHES], AMBER, (0, (4, 1.2)), -6, "top")
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
        text = f"smallest gap: {least:.3g} {unit}"
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
    substep = run.substep
    if run.joint_impulses is None or substep is None:
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


def _sample_times(begin: float, hit: FirstContact) -> Array:
    """Return the times, s, from `begin` to the end at which gaps are sampled, including those of near misses."""
    smallest = [near_miss.time for near_miss in hit.near_misses or () if near_miss.time > begin]
    return np.unique([*np.linspace(begin, hit.time, GAP_SAMPLES), *smallest])


def gap_line(axes: Axes, march: March, times: Array, gid: str) -> float:
    """Draw the head's smallest gap and return its maximum, mm; `last-gap` adds the gap to each closest bench."""
    found = [smallest_gap(march.dragon, snapshot.poses) for snapshot in snapshots(march, times)]
    nearest, smallest = np.array(found, dtype=float).T
    if gid == "last-gap":
        for bench in np.unique(nearest).astype(int).tolist():
            line = MM * _gaps_to(march, times, bench)
            axes.plot(times, np.maximum(line, GAP_OF_CONTACT), color=QUIET, lw=0.8, ls=(0, (4, 2)), gid=f"gap-{bench}")
    axes.plot(times, np.maximum(MM * smallest, GAP_OF_CONTACT), color=BLUE, lw=2.0, gid=gid)
    return MM * float(smallest.max())


def _gaps_to(march: March, times: Array, bench: int) -> Array:
    """Return the gap (T,), m, between the head and `bench` at `times` (T,)."""
    corners = march.dragon.outlines(march.at(times, bench + 2).poses)
    return separation(corners[:, 0], corners[:, bench]).distance


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
