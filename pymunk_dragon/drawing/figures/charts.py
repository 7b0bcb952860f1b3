"""Figures over time and along the dragon: gaps of the head, speeds, and the engine's position errors and impulses."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._arrays import Array, Indices
from pymunk_dragon._language import text
from pymunk_dragon.collision import FirstContact, separation
from pymunk_dragon.drawing.figures.lines import (
    bundle,
    label_in_room,
    log_locator,
    logarithmic,
    name,
    name_line,
    several_times,
    time_name,
)
from pymunk_dragon.drawing.figures.room import Room
from pymunk_dragon.drawing.figures.style import AMBER, BLUE, COLOURS, FAINT, QUIET, panel, slide
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
# mm: lower end of the scale, below which are the labels of near misses.
MIN_GAP = 0.15
# mm: replaces smaller gaps, because a gap of 0 has no logarithm; below the scale.
GAP_OF_CONTACT = 0.02
# Points: offsets of the labels of near misses, and of contacts, from their points.
NEAR_MISS_OFFSETS = [(x, y) for y in (-24.0, -30.0) for x in (0.0, -20.0, 20.0, -40.0, 40.0, -60.0, 60.0)]
CONTACT_OFFSETS = [(x, y) for y in range(20, 160, 10) for x in (36.0, 40.0)]
# Free border at the right of a chart over time, as a fraction of the time interval: small, and for a label.
RIGHT_BORDER, LABEL_BORDER = 0.02, 0.26
# Ratio of the upper end of the scale to the largest value, and of the smallest one to the lower end.
BORDER = 1.5
# The same for the lower end, with room for the labels of near misses.
LABEL_ROOM = 6.0
# Largest number of points of a line over time.
TIME_SAMPLES = 600
# Units of position errors: smallest error in m, units per metre, and symbol.
UNITS = ((1.0, 1.0, "m"), (1e-3, 1e3, "mm"), (0.0, 1e6, "\u00b5m"))
# N: larger forces are displayed as whole numbers.
MIN_WHOLE_FORCE = 10.0
# N: smaller forces are rounding errors, as on a straight path at constant speed.
NO_FORCE = 1e-6
# Powers of ten covered by the scale of position errors.
DRIFT_DECADES = 4
# Largest powers of ten covered by the scale of impulses, and ratio of its ends to the data.
IMPULSE_DECADES, IMPULSE_BORDER = 3, 1.12
# Fraction of the joints: free border before the first one, for labels.
LABELS_LEFT = 0.16


def gap(march: March, interval: TimeInterval) -> Figure:
    """Draw the gap between the head and the benches it passes, on a logarithmic scale."""
    if march.dragon.benches < 3:
        raise ParameterError("benches", march.dragon.benches, "3 or more: neighbours have no gap")
    hit, begin = contact_or_end(march, interval), interval[0]
    near_misses = [near_miss for near_miss in hit.near_misses or () if near_miss.benches[0] == 0]
    title = text("How near the head comes to other benches than its neighbour")
    if spirals_in(march):
        title = text("The tighter the coil, the closer the head comes to the benches that it passes")
    if hit.contact and near_misses:
        narrow = min(near_misses, key=lambda near_miss: near_miss.gap)
        title = text("The head slips past bench {} by {:.1f} mm, and then hits bench {}").format(
            narrow.benches[1], MM * narrow.gap, hit.contact.benches[1]
        )
    figure = slide(
        title, text("gap between the head and the nearest bench but its neighbour, mm; dashed: to each bench by itself")
    )
    since = max(begin, float(march.time(march.distance(hit.time) - CLOSE_UP_LENGTHS * march.dragon.lengths[0])))
    whole = panel(figure, 0.75, 0.65, 2.2, 2.75)
    close = panel(figure, 3.25, 0.65, 4.5, 2.75, sharey=whole)
    whole.axvspan(since, hit.time, color=FAINT, lw=0)
    narrowest, widest = gap_line(whole, march, _sample_times(begin, hit), "gap")
    low = MIN_GAP if hit.contact else max(MIN_GAP, narrowest / (LABEL_ROOM if near_misses else BORDER))
    gap_line(close, march, _sample_times(since, hit), "last-gap")
    for axes, left, border in ((whole, begin, RIGHT_BORDER), (close, since, LABEL_BORDER if hit.contact else 0.0)):
        axes.set_xlim(left, hit.time + border * (hit.time - left))
        axes.set_xticks([tick for tick in several_times(left, hit.time) if tick < hit.time])
        logarithmic(axes, low, BORDER * widest)
        axes.set_xlabel(text("time (s)"))
    close.tick_params(labelleft=False)
    room = Room(close)
    room.take_lines()
    if hit.contact:
        note = text("bench {}:\ncontact at\n{:.4f} s").format(hit.contact.benches[1], hit.time)
        at = np.array([[hit.time, low]])
        label_in_room(close, room, at, note, CONTACT_OFFSETS, color=COLOURS.contact)
    for near_miss in near_misses:
        if near_miss.time > since:
            at = np.array([[near_miss.time, MM * near_miss.gap]])
            close.plot(*at.T, "o", color=COLOURS.ink, ms=6)
            note = text("bench {}: {:.3f} mm\nat {:.3f} s").format(near_miss.benches[1], *at[0, ::-1])
            label_in_room(close, room, at, note, NEAR_MISS_OFFSETS)
    return figure


def speeds(march: March, interval: TimeInterval) -> Figure:
    """Draw the speed along the dragon at several times."""
    end, touching = last_regular_time(contact_or_end(march, interval), interval[0])
    times = several_times(interval[0], end)
    values = march.at(times).speeds
    title = text("The handles go at {:.3f} to {:.3f} m/s").format(values.min(), values.max())
    if spirals_in(march):
        title = text("The tighter the coil, the slower the body: {:.3f} m/s shortly before the end")
        if touching:
            title = text("The tighter the coil, the slower the body: {:.3f} m/s at the first contact")
        title = title.format(values[-1, -1])
    figure = slide(title, text("speed of every handle at several times, m/s"))
    axes = panel(figure, 0.85, 0.65, 6.0, 2.85)
    lines = bundle(axes, values, "speed")
    name(axes, lines, times)
    axes.set_xlabel(text("handle, from the head to the tail"))
    return figure


def drift(run: Run) -> Figure:
    """Draw the engine's position error against the exact model: over time, and along the dragon."""
    if run.player == "exact":
        raise ParameterError("run", "one of the exact model", "one of the engine, which alone drifts")
    if len(run.times) == 1 or not run.max_drift > 0:
        raise ParameterError("run", "one without a drift", "one that the engine has played for a while")
    scale, unit = next((scale, unit) for least, scale, unit in UNITS if run.max_drift >= least)
    figure = slide(
        text("The engine stays within {:.3g} {} of the exact model").format(scale * run.max_drift, unit),
        text("position errors of the benches, at the worse of their two holes, {}").format(unit),
    )
    over_time = panel(figure, 0.8, 0.65, 3.75, 2.85)
    along = panel(figure, 4.8, 0.65, 2.15, 2.85, sharey=over_time)
    low, high = _decades(scale * run.max_drift, DRIFT_DECADES)
    near_misses = contact_or_end(run.march, time_interval(run)).near_misses or ()
    gaps = [near_miss.gap for near_miss in near_misses if run.times[0] <= near_miss.time <= run.times[-1]]
    # An engine with a position error as large as the smallest gap can find the wrong first contact.
    least = scale * min(gaps, default=0.0)
    logarithmic(over_time, low, max(high, 2 * least))
    over_time.set_xlim(run.times[0], run.times[-1])
    frames = _thinned(run)
    named: list[tuple[Array, str, str]] = []
    if gaps:
        for axes in (over_time, along):
            axes.axhline(least, color=COLOURS.ink, lw=1.2, ls=(0, (1, 2)), gid="smallest-gap")
        note = text("smallest gap: {:.3g} {}").format(least, unit)
        named.append((np.column_stack([run.times[frames], np.full(len(frames), least)]), note, COLOURS.ink))
    shown: list[tuple[str, str, Array, str, Any]] = [("any-bench", text("largest of all"), run.drift, BLUE, "-")]
    if run.march.dragon.benches > HEAD_BENCHES:
        note = text("largest of the first {}").format(HEAD_BENCHES)
        shown.append((f"first-{HEAD_BENCHES}-benches", note, run.drift[:, :HEAD_BENCHES], AMBER, (0, (4, 1.2))))
    for gid, note, drifts, colour, dashes in shown:
        worst = scale * np.fmax.reduce(drifts[frames], axis=1)
        over_time.plot(run.times[frames], worst, color=colour, lw=2.2, ls=dashes, gid=gid)
        named.append((np.column_stack([run.times[frames], np.maximum(worst, low)]), note, colour))
    room = Room(over_time)
    room.take_lines()
    for points, note, colour in named:
        name_line(over_time, room, points, note, colour)
    rows = _rows(run, several_times(float(run.times[0]), float(run.times[-1]))[1:])
    name(along, bundle(along, scale * run.drift[rows], "drift"), run.times[rows])
    along.tick_params(labelleft=False)
    over_time.set_xlabel(text("time (s)"))
    along.set_xlabel(text("bench"))
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
    figure = slide(
        text("The joints carry up to {} at first, and up to {} at {}").format(_force(least), _force(most), last),
        text("impulse in every joint in a substep of {:g} ms, N s; at the right the force that makes it, N").format(
            1e3 * substep
        ),
    )
    axes = panel(figure, 0.85, 0.65, 6.25, 2.85)
    lines = bundle(axes, values, "impulse")
    low, high = float(values.min()), float(values.max())
    low, high = max(low, high / 10.0**IMPULSE_DECADES) / IMPULSE_BORDER, high * IMPULSE_BORDER
    logarithmic(axes, low, high)
    force = axes.secondary_yaxis("right", functions=(partial(np.multiply, 1 / substep), partial(np.multiply, substep)))
    force.yaxis.set_major_locator(log_locator(low, high))
    force.yaxis.set_major_formatter("{x:g}")
    force.minorticks_off()
    force.spines["right"].set_visible(True)
    # The labels are at the head, where the lines are farthest apart.
    axes.set_xlim(-LABELS_LEFT * values.shape[1], values.shape[1] - 1)
    axes.set_xticks([tick for tick in axes.get_xticks() if 0 <= tick < values.shape[1]])
    name(axes, lines, run.times[rows], "left")
    axes.set_xlabel(text("joint, from the head to the tail; joint i is between benches i and i + 1"))
    return figure


def _sample_times(begin: float, hit: FirstContact) -> Array:
    """Return the times, s, from `begin` to the end at which gaps are sampled, including those of near misses."""
    smallest = [near_miss.time for near_miss in hit.near_misses or () if near_miss.time > begin]
    return np.unique([*np.linspace(begin, hit.time, GAP_SAMPLES), *smallest])


def gap_line(axes: Axes, march: March, times: Array, gid: str) -> tuple[float, float]:
    """Draw the head's smallest gap, and return its range, mm; `last-gap` adds the gap to each closest bench."""
    found = [smallest_gap(march.dragon, snapshot.poses) for snapshot in snapshots(march, times)]
    nearest, smallest = np.array([(each.bench, each.distance) for each in found if each is not None]).T
    if gid == "last-gap":
        for bench in np.unique(nearest).astype(int).tolist():
            line = MM * _gaps_to(march, times, bench)
            axes.plot(times, np.maximum(line, GAP_OF_CONTACT), color=QUIET, lw=0.8, ls=(0, (4, 2)), gid=f"gap-{bench}")
    axes.plot(
        times, np.maximum(MM * smallest, GAP_OF_CONTACT), color=BLUE, lw=2.0 if gid == "last-gap" else 1.2, gid=gid
    )
    return MM * float(smallest.min()), MM * float(smallest.max())


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
