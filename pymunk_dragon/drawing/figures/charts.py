"""Figures over time and along the dragon: gaps of the head, speeds, and the engine's position errors and forces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import text
from pymunk_dragon.collision import FirstContact, NearMiss, separation
from pymunk_dragon.drawing.figures import style
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import HEAD_BENCHES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Millimetres per metre.
_MM = 1e3
# mm: lower end of the scale of gaps.
_MIN_GAP = 0.15
# Ratio of an end of the scale of gaps to the largest or smallest gap; and of the ends of that of position errors.
BORDER, _DRIFT_RANGE = 1.5, 1e4
# Colour of the first of several lines; the colours of later lines change gradually to ink.
_FIRST_COLOUR = "#6391bb"


def gap(subject: style.Subject) -> Figure:
    """Draw the gap between the head and the benches it passes, on a logarithmic scale."""
    march, hit = subject.march, subject.hit
    if march.dragon.benches < 3:
        raise ParameterError("benches", march.dragon.benches, "3 or more: neighbours have no gap")
    # The close-up shows the time in which the head travels a few of its lengths.
    since = max(subject.begin, float(march.time(march.distance(hit.time) - 4.5 * march.dragon.lengths[0])))
    misses = sorted((miss for miss in hit.near_misses or () if miss.benches[0] == 0), key=lambda miss: miss.gap)
    subtitle = text("gap between the head and the nearest bench but its neighbour, mm; dashed: to each bench by itself")
    figure = style.slide(_gap_title(misses, hit), subtitle)
    whole, close = style.panels(figure, columns=2, sharey=True, width_ratios=(1, 2))
    whole.axvspan(since, hit.time, color=style.FAINT, lw=0)
    for axes, left, gid in ((whole, subject.begin, "gap"), (close, since, "last-gap")):
        # As many times as the line is pixels wide.
        times = np.union1d(np.linspace(left, hit.time, 1000), [miss.time for miss in misses if miss.time > left])
        _gap_lines(axes, march, times, gid)
        axes.set(xlim=(left, hit.time), xlabel=text("time (s)"))
        axes.locator_params(axis="x", nbins=5)
    low, high = whole.dataLim.intervaly
    style.logarithmic(whole, _MIN_GAP if hit.contact else max(_MIN_GAP, low / BORDER), BORDER * high)
    _mark_events(close, [miss for miss in misses if miss.time > since], hit)
    return figure


def _gap_title(misses: Sequence[NearMiss], hit: FirstContact) -> str:
    if not hit.contact or not misses:
        return text("How near the head comes to other benches than its neighbour")
    title = text("The head slips past bench {} by {:.1f} mm, and then hits bench {}")
    return title.format(misses[0].benches[1], _MM * misses[0].gap, hit.contact.benches[1])


def _gap_lines(axes: Axes, march: March, times: Array, gid: str) -> None:
    """Draw the head's smallest gap, mm; `last-gap` adds the gap to each closest bench."""
    # In parts, to limit memory.
    corners = (march.dragon.outlines(march.at(part).poses) for part in np.array_split(times, 10))
    gaps = _MM * np.concatenate([separation(part[:, :1], part[:, 2:]).distance for part in corners])
    if gid == "last-gap":
        for row in np.unique(gaps.argmin(axis=1)).tolist():
            axes.plot(times, gaps[:, row], color=style.QUIET, lw=0.8, ls=(0, (4, 2)), gid=f"gap-{row + 2}")
    axes.plot(times, gaps.min(axis=1), color=style.BLUE, lw=2.0 if gid == "last-gap" else 1.2, gid=gid)


def _mark_events(axes: Axes, misses: Sequence[NearMiss], hit: FirstContact) -> None:
    """Mark near misses and the contact, with a legend."""
    for miss, marker in zip(misses, "osD^v", strict=False):
        note = text("bench {}: {:.3f} mm\nat {:.3f} s").format(miss.benches[1], _MM * miss.gap, miss.time)
        axes.plot(miss.time, _MM * miss.gap, marker, color=style.COLOURS.ink, ms=6, label=note)
    if hit.contact:
        note = text("bench {}: contact\nat {:.4f} s").format(hit.contact.benches[1], hit.time)
        axes.plot(hit.time, _MIN_GAP, "X", color=style.COLOURS.contact, ms=8, label=note, clip_on=False)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left", bbox_to_anchor=(1, 1), frameon=False, labelspacing=1.0, handletextpad=0.2)


def speeds(subject: style.Subject) -> Figure:
    """Draw the speed along the dragon at several times."""
    times = _several_times(subject.begin, subject.last_regular_time)
    values = subject.march.at(times).speeds
    title = text("The handles go at {:.3f} to {:.3f} m/s").format(values.min(), values.max())
    if subject.march.curve.inward:
        title = text("The tighter the coil, the slower the body: {:.3f} m/s at {:.5g} s").format(
            values[-1, -1], times[-1]
        )
    figure = style.slide(title, text("speed of every handle at several times, m/s"))
    _bundle(style.panels(figure), values, times, "speed", text("handle, from the head to the tail"))
    return figure


def drift(subject: style.Subject) -> Figure:
    """Draw the engine's position error against the exact model: over time, and along the dragon."""
    from matplotlib.ticker import EngFormatter

    run = subject.run
    if run is None or len(run.times) == 1 or not run.max_drift > 0:
        raise ParameterError("run", "one without a drift", "one that the engine has played for a while")
    metres = EngFormatter("m", places=1)
    title = text("The engine stays within {} of the exact model").format(metres(run.max_drift))
    figure = style.slide(title, text("position errors of the benches, at the worse of their two holes"))
    over_time, along = style.panels(figure, columns=2, sharey=True, width_ratios=(2, 1))
    # Without the first frame, whose position error is 0.
    frames = np.unique(np.linspace(1, len(run.times) - 1, 600).astype(np.intp))
    noted = text("largest of the first {}").format(HEAD_BENCHES)
    for gid, note, count, line in (
        ("any-bench", text("largest of all"), None, {"color": style.BLUE, "ls": "-"}),
        ("first-benches", noted, HEAD_BENCHES, {"color": style.AMBER, "ls": "--"}),
    ):
        worst = np.fmax.reduce(run.drift[frames, :count], axis=1)
        over_time.plot(run.times[frames], worst, lw=2.2, gid=gid, label=note, **line)
    low, high = 10.0 ** np.ceil(np.log10(run.max_drift)) * np.array([1 / _DRIFT_RANGE, 1.0])
    gaps = [miss.gap for miss in subject.hit.near_misses or () if run.times[0] <= miss.time <= run.times[-1]]
    for axes in (over_time, along) if gaps else ():
        note = text("smallest gap: {}").format(metres(min(gaps)))
        axes.axhline(min(gaps), color=style.COLOURS.ink, lw=1.2, ls=":", gid="smallest-gap", label=note)
    # An engine with a position error as large as the smallest gap can find the wrong first contact.
    style.logarithmic(over_time, low, max(high, 2 * min(gaps, default=0.0)))
    over_time.yaxis.set_major_formatter(EngFormatter("m"))
    over_time.set(xlim=(run.times[0], run.times[-1]), xlabel=text("time (s)"))
    over_time.legend(loc="lower right", frameon=False)
    rows = np.unique(np.searchsorted(run.times, _several_times(run.times[0], run.times[-1])[1:]))
    _bundle(along, run.drift[rows], run.times[rows], "drift", text("bench"))
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
    times, forces = times[rows], forces[rows]
    title = text("The joints carry up to {:.2f} N at first, and up to {:.2f} N at {:.5g} s")
    title = title.format(forces[0].max(), forces[-1].max(), times[-1])
    subtitle = text("force in every joint, N: the mean over a substep of {:g} ms").format(1e3 * run.substep)
    figure = style.slide(title, subtitle)
    axes = style.panels(figure)
    # The names are at the head, where the lines are farthest apart.
    axes.yaxis.tick_right()
    axes.spines["left"].set_visible(False)
    axes.grid(axis="y", color=style.RULE, lw=0.6)
    joint = text("joint, from the head to the tail; joint i is between benches i and i + 1")
    _bundle(axes, forces, times, "impulse", joint, end=0)
    return figure


def _several_times(begin: float, end: float) -> Array:
    """Return a few round times, s, from `begin` on, and `end`."""
    from matplotlib.ticker import MaxNLocator

    ticks = MaxNLocator(5, steps=[1, 2, 5, 10]).tick_values(begin, end)
    # A tick within a fiftieth of the interval before the end is omitted.
    return np.array([*(tick for tick in ticks if begin <= tick < end - (end - begin) / 50), end])


def _bundle(axes: Axes, values: Array, times: Array, gid: str, along: str, end: int = -1) -> None:
    """Draw lines of `values` (T, K) along the dragon, later ones darker and thicker, with their `times` at an end."""
    from matplotlib.colors import LinearSegmentedColormap

    ages, names = np.linspace(0, 1, len(values)), [f"{time:.5g} s" for time in times]
    colours = LinearSegmentedColormap.from_list("ages", [_FIRST_COLOUR, style.COLOURS.ink])(ages)
    for rank, (line, age) in enumerate(zip(values, ages.tolist(), strict=True)):
        axes.plot(line, color=colours[rank], lw=1.2 + 1.2 * age, gid=f"{gid}-{rank}", label=names[rank])
    last = values.shape[1] - 1
    axes.set(xlim=(0, last), xlabel=along)
    axes.locator_params(axis="x", integer=True)
    points = np.column_stack([np.full(len(values), last if end else 0), values[:, end]])
    style.lead(axes, points, names, 1.06 if end else -0.06, list(colours))
