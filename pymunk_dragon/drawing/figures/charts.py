"""Figures over time and along the dragon: the head's gap to other benches, and speeds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.collision import FirstContact, separation
from pymunk_dragon.drawing.figures.lines import NAME_OFFSET, bundle, label, logarithmic, name, several_times
from pymunk_dragon.drawing.figures.style import BLUE, COLOURS, FAINT, QUIET, page, panel
from pymunk_dragon.drawing.figures.times import TimeInterval, contact_or_end, last_regular_time, spirals_in
from pymunk_dragon.drawing.gaps import smallest_gap
from pymunk_dragon.drawing.moments import moments
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["MM", "gap", "gap_line", "speeds"]

Array = NDArray[np.float64]

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


def _sample_times(begin: float, hit: FirstContact) -> Array:
    """Return the times, s, from `begin` to the end at which gaps are sampled, including those of near misses."""
    smallest = [near_miss.time for near_miss in hit.near_misses or () if near_miss.time > begin]
    return np.unique([*np.linspace(begin, hit.time, GAP_SAMPLES), *smallest])


def gap_line(axes: Axes, march: March, times: Array, gid: str) -> float:
    """Draw the head's smallest gap and return its maximum, mm; `last-gap` adds the gap to each closest bench."""
    found = [smallest_gap(march.dragon, moment.poses) for moment in moments(march, times)]
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
