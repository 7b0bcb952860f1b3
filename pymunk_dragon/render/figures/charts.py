"""Figures over time and along the dragon: the gap before the head, and speeds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.collision import FirstContact, separation
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.march import March
from pymunk_dragon.render.figures.lines import ASIDE, bundle, label, logarithmic, name, several_times
from pymunk_dragon.render.figures.style import BLUE, COLOURS, FAINT, QUIET, page, panel
from pymunk_dragon.render.figures.times import Stretch, ending, last_look, spirals_in
from pymunk_dragon.render.gaps import smallest_gap
from pymunk_dragon.render.moments import moments

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["MM", "gap", "gap_line", "speeds"]

Array = NDArray[np.float64]

# Moments at which gaps are measured: as many as a line that wide has pixels.
GAP_MOMENTS = 1400
# How much of the end is shown from close by: as long as the head takes for so many of its own lengths.
LAST_LENGTHS = 4.5
MM = 1e3
# mm: the lowest gap on the scale, and what stands for none, of which there is no logarithm.
LEAST_GAP, NO_GAP = 0.3, 0.03
# mm: how high on the falling line its name stands, above the names of the near misses.
CONTACT_PLACE = 1.2
# Free borders of a chart over time, as a share of the time, and above its highest value, as a factor.
RIGHT_BORDER, TOP_BORDER = 0.02, 1.5


def gap(march: March, look: Stretch) -> Figure:
    """The gap between the head and the benches that it passes, on a scale for 1 mm and for 200 mm."""
    if march.dragon.benches < 3:
        raise ParameterError("benches", march.dragon.benches, "3 or more: neighbours have no gap")
    hit, begin = ending(march, look), look[0]
    misses = [miss for miss in hit.near_misses or () if miss.benches[0] == 0]
    title = "How near the head comes to other benches than its neighbour"
    if spirals_in(march):
        title = "The tighter the coil, the closer the head comes to the benches that it passes"
    if hit.contact and misses:
        narrow = min(misses, key=lambda miss: miss.gap)
        passed, met = narrow.benches[1], hit.contact.benches[1]
        title = f"The head slips past bench {passed} by {MM * narrow.gap:.1f} mm, and then hits bench {met}"
    figure = page(
        8.0,
        7.6,
        title,
        "gap between the head and the nearest bench but its neighbour, mm; dashed, to each bench by itself",
    )
    since = max(begin, float(march.time(march.distance(hit.time) - LAST_LENGTHS * march.dragon.lengths[0])))
    whole = panel(figure, 0.85, 4.85, 6.85, 1.75)
    close = panel(figure, 0.85, 0.65, 6.85, 3.5)
    whole.axvspan(since, hit.time, color=FAINT, lw=0)
    widest = gap_line(whole, march, _moments(begin, hit), "gap")
    gap_line(close, march, _moments(since, hit), "last-gap")
    for axes, left in ((whole, begin), (close, since)):
        axes.set_xlim(left, hit.time + RIGHT_BORDER * (hit.time - left))
        logarithmic(axes, LEAST_GAP, TOP_BORDER * widest)
    close.set_xlabel("time (s)")
    for miss in misses:
        if miss.time > since:
            close.plot(miss.time, MM * miss.gap, "o", color=COLOURS.ink, ms=6)
            text = f"bench {miss.benches[1]}: {MM * miss.gap:.3f} mm\nat {miss.time:.3f} s"
            label(close, miss.time, MM * miss.gap, text, (0, -8), ha="center", va="top")
    if hit.contact:
        text = f"bench {hit.contact.benches[1]}:\ncontact at\n{hit.time:.4f} s"
        label(close, hit.time, CONTACT_PLACE, text, (-9, 0), ha="right", va="bottom", color=COLOURS.contact)
    return figure


def speeds(march: March, look: Stretch) -> Figure:
    """Speed along the dragon at several times."""
    end, when = last_look(ending(march, look), look[0])
    times = several_times(look[0], end)
    values = march.at(times).speeds
    title = f"The handles go at {values.min():.3f} to {values.max():.3f} m/s"
    if spirals_in(march):
        title = f"The tighter the coil, the slower the body: {values[-1, -1]:.3f} m/s {when}"
    figure = page(8.0, 5.6, title, "speed of every handle, m/s")
    axes = panel(figure, 0.85, 0.65, 5.9, 3.9)
    lines = bundle(axes, values, "speed")
    name(axes, lines, times, -1, ASIDE)
    axes.set_xlabel("handle, from the head to the tail")
    return figure


def _moments(begin: float, hit: FirstContact) -> Array:
    """Times from `begin` to the end at which gaps are measured, s; those of the smallest ones are among them."""
    smallest = [miss.time for miss in hit.near_misses or () if miss.time > begin]
    return np.unique([*np.linspace(begin, hit.time, GAP_MOMENTS), *smallest])


def gap_line(axes: Axes, march: March, times: Array, gid: str) -> float:
    """Draw the head's smallest gap, and give the widest, mm; as `last-gap` also, thinly, that of each nearest bench."""
    found = [smallest_gap(march.dragon, moment.poses) for moment in moments(march, times)]
    nearest, smallest = np.array(found, dtype=float).T
    if gid == "last-gap":
        for bench in np.unique(nearest).astype(int).tolist():
            line = MM * _gaps_to(march, times, bench)
            axes.plot(times, np.maximum(line, NO_GAP), color=QUIET, lw=0.8, ls=(0, (4, 2)), gid=f"gap-{bench}")
    axes.plot(times, np.maximum(MM * smallest, NO_GAP), color=BLUE, lw=2.0, gid=gid)
    return MM * float(smallest.max())


def _gaps_to(march: March, times: Array, bench: int) -> Array:
    """Gap (T,) in m between the head and `bench` at `times` (T,)."""
    corners = march.dragon.outlines(march.at(times, bench + 2).poses)
    return separation(corners[:, 0], corners[:, bench]).distance
