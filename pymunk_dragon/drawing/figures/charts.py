"""The paper's figures, and others: seen from above, over time, and along the dragon."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import text
from pymunk_dragon.collision import Grid, separation
from pymunk_dragon.drawing import Film
from pymunk_dragon.drawing.figures import style
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.run import HEAD_BENCHES, Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# m: lower end of the scale of gaps.
_MIN_GAP = 1.5e-4
# Head lengths travelled: the part of a march before its contact, or its end, that `gap` shows.
_GAP_LENGTHS = 4.5


@dataclass(frozen=True)
class NamedFigure:
    """What a figure shows, its function, the number of benches, and whether it is a `still`, of a run and a film."""

    shows: str
    draw: Callable[[style.FigureSource], Any]
    benches: int = 223
    still: bool = False


def _spiral(source: style.FigureSource) -> Figure:
    """Draw the spiral that handle 0 follows (the paper's figure 2)."""
    march, end = source.march, source.hit.time
    curve, start = march.curve, march.head_start
    turns = curve.turns(start)
    if turns is None or curve.end_s == np.inf:
        raise ParameterError("curve", type(curve).__name__, "a Spiral inward, for this figure")
    gone = float(march.distance(end))
    title = text("Handle 0 walks {:.1f} m of {:.1f} m of spiral").format(gone, curve.end_s - start)
    figure = style.slide(
        title, text("{:.4g} turns inward, {:g} m apart").format(turns, curve.turn_width)
    )
    axes = style.panels(figure)
    # At most ten whole minutes.
    minutes = np.arange(0, end / 60, max(1, np.ceil(end / 600)))
    dots = curve.point(start + march.distance(60 * minutes))
    walked, rest = source.path(start, start + gone), source.path(start + gone, curve.end_s)
    axes.plot(
        *walked.T, color=style.BLUE, lw=1.8, gid="walked", label=text("the march of handle 0")
    )
    axes.plot(
        *dots.T, "o", color=style.COLOURS.ink, ms=13, gid="minutes", label=text("numbers: minutes")
    )
    axes.plot(*walked[-1], "o", color=style.COLOURS.contact, ms=8, gid="last", label=source.end)
    axes.plot(*rest.T, color=style.QUIET, lw=1.0, ls="--", gid="ahead", label=text("not reached"))
    for minute, (x, y) in zip(minutes, dots.tolist(), strict=True):
        axes.text(
            x,
            y,
            f"{minute:g}",
            ha="center",
            va="center",
            color=style.COLOURS.background,
            size=style.SMALL,
        )
    style.plan(axes)
    axes.legend(**style.BESIDE)
    return figure


def _trajectories(source: style.FigureSource) -> Figure:
    """Draw the trajectories of the paper's seven handles until the first contact (its figure 7)."""
    handles, ink = source.march.dragon.representatives, style.COLOURS.ink
    first, last = source.march.handles_s([source.begin, source.hit.time])
    whole = source.path(first[-1], last[0], 900)
    title = text("All handles walk the same path, one behind the other")
    subtitle = text("from {:g} s to {}; the path is {:.3g} m wide and {:.3g} m high")
    figure = style.slide(title, subtitle.format(source.begin, source.end, *np.ptp(whole, axis=0)))
    cells = list(style.panels(figure, rows=-(-(len(handles) + 1) // 4), columns=4).flat)
    for axes in cells:
        axes.set_aspect("equal")
        axes.margins(0.04)
        axes.set_axis_off()
    for axes, handle in zip(cells, handles, strict=False):
        path = source.path(first[handle], last[handle], 900)
        axes.plot(*whole.T, color=style.PALE, lw=0.4)
        axes.plot(*path.T, color=style.BLUE, lw=1.0, gid=f"path-{handle}")
        start = axes.plot(
            *path[0], "o", color=ink, mfc=style.COLOURS.background, ms=6, label=text("at the start")
        )
        stop = axes.plot(*path[-1], "o", color=ink, ms=6, label=text("at the end"))
        axes.set_title(text("handle {}").format(handle), size=11.5, pad=3)
    cells[len(handles)].legend(handles=start + stop, loc="center", frameon=False)
    return figure


def _velocities(source: style.FigureSource) -> Figure:
    """Draw the velocities of the paper's seven handles at the first contact (its figure 8)."""
    time, handles = source.last_regular_time, source.march.dragon.representatives
    states = source.march.at(time)
    title = text("The velocities of {} handles at {:.2f} s").format(len(handles), time)
    figure = style.slide(title, text("each handle walks along the curve"))
    axes = style.panels(figure)
    path = source.path(states.handles_s[0, -1], states.handles_s[0, 0])
    axes.plot(*path.T, color=style.PALE, lw=0.8)
    for handle in handles:
        position, velocity, speed = (
            each[0, handle] for each in (states.positions, states.velocities, states.speeds)
        )
        name = text("handle {}: {:.3f} m/s").format(handle, speed)
        axes.plot(*position, "o", color=style.COLOURS.ink, ms=5, zorder=4, label=name)
        behind: dict[str, Any] = {
            "xytext": -18 * velocity / speed,
            "textcoords": "offset points",
            "ha": "center",
        }
        axes.annotate(
            str(handle),
            position,
            **behind,
            va="center",
            size=9,
            zorder=5,
            path_effects=style.halo(),
        )
    points, arrows = states.positions[0, list(handles)], states.velocities[0, list(handles)]
    axes.quiver(
        *points.T,
        *arrows.T,
        angles="xy",
        color=style.COLOURS.motion,
        width=0.006,
        zorder=3,
        gid="velocities",
    )
    style.plan(axes)
    axes.legend(**style.BESIDE)
    return figure


def _grid(source: style.FigureSource) -> Figure:
    """Draw the grid partition at the first contact, and the benches in its cells (the paper's figure 6)."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    hit, dragon, cells = source.hit, source.march.dragon, Grid.of(source.march)
    corners = dragon.outlines(source.march.at(hit.time).poses[0])
    title = text("{} of {} pairs of benches that share no hole share a cell, and are tested")
    title = title.format(
        len(cells.pairs(corners)), (dragon.benches - 1) * (dragon.benches - 2) // 2
    )
    origin = "({:g}, {:g})".format(*cells.origin).replace("-", "\u2212")
    subtitle = text("{}; cells of {:g} m, counted from {} m").format(source.end, cells.cell, origin)
    figure = style.slide(title, subtitle)
    axes = style.panels(figure)
    # Cells around the benches. 0: empty; 1: one bench; 2: neighbours; 3: benches that are not
    # neighbours.
    filed, benches = cells.file(corners)
    first, last = filed.min(axis=0) - 1, filed.max(axis=0) + 1
    least, most = np.full(last - first + 1, dragon.benches), np.full(last - first + 1, -1)
    np.minimum.at(least, tuple((filed - first).T), benches)
    np.maximum.at(most, tuple((filed - first).T), benches)
    colours = ListedColormap([style.COLOURS.background, style.FAINT, style.SHARED, style.CANDIDATE])
    # The axes are column and row: a cell's indices are at its middle.
    y, x = (np.arange(begin, end + 2) - 0.5 for begin, end in zip(first, last, strict=True))
    lines: dict[str, Any] = {"edgecolor": style.RULE, "lw": 0.6, "gid": "cells"}
    axes.pcolormesh(x, y, np.clip(most - least + 1, 0, 3), cmap=colours, vmin=0, vmax=3, **lines)
    for bench, outline in enumerate((corners - cells.origin) / (cells.cell, -cells.cell) - 0.5):
        hits = bench in (hit.benches or ())
        drawn: dict[str, Any] = {
            "color": style.COLOURS.contact if hits else style.COLOURS.ink,
            "zorder": 3 + hits,
        }
        axes.fill(*outline.T, fill=False, lw=2.2 if hits else 1.1, gid=f"bench-{bench}", **drawn)
        # Numbers of shorter benches would cover each other.
        if hits or dragon.lengths[bench] >= 0.15 * cells.cell * len(x):
            drawn |= {
                "ha": "center",
                "va": "center",
                "size": style.SMALL,
                "path_effects": style.halo(),
            }
            axes.text(*outline.mean(axis=0), str(bench), **drawn)
    axes.set(aspect="equal", xlabel=text("column j"), ylabel=text("row i"))
    axes.locator_params(integer=True)
    axes.invert_yaxis()
    names = (text("one bench"), text("neighbours only"), text("candidates"))
    patches = [
        Patch(fc=colours(kind), ec=style.RULE, label=name) for kind, name in enumerate(names, 1)
    ]
    axes.legend(handles=patches, **style.BESIDE)
    return figure


def _outer_loop(source: style.FigureSource) -> tuple[Run, Film]:
    """Return the run and the film parameters of the picture of the dragon at its start."""
    return _still(source, source.begin, text("{} benches at the start"))


def _inward(source: style.FigureSource) -> tuple[Run, Film]:
    """Return the same as it closes a full loop: its path turns by 2 pi between tail and head."""
    times = np.linspace(source.begin, source.hit.time, 2001)
    tangents = source.march.curve.tangent(source.march.handles_s(times))
    angles = np.unwrap(np.arctan2(tangents[..., 1], tangents[..., 0]), axis=1)
    closed = np.abs(angles[:, 0] - angles[:, -1]) >= 2 * np.pi
    # Half-way if the loop is always or never closed.
    return _still(source, float(times[closed.argmax() or 1000]), text("{} benches on the path"))


def _collision(source: style.FigureSource) -> tuple[Run, Film]:
    """Return the same at the first contact."""
    hit = source.hit
    if hit.contact is None:
        raise ParameterError("march", f"clear until {hit.time:g} s", "one that runs into itself")
    run, film = _still(source, hit.time, text("{} benches at the first contact"))
    return replace(run, first_contact=hit.contact, outcome="contact"), film


def _still(source: style.FigureSource, time: float, title: str) -> tuple[Run, Film]:
    """Return a run of one frame, and the parameters of its picture; the title has the number of benches."""
    # Pixels: twice the width at which two or three pictures fit side by side.
    film = Film(size=880, title=title.format(source.march.dragon.benches))
    return Run.exact(source.march, [time]), film


def _gap(source: style.FigureSource) -> Figure:
    """Draw the gap between the head and the benches that it passes at last, on a logarithmic scale."""
    march, hit = source.march, source.hit
    if march.dragon.benches < 3:
        raise ParameterError("benches", march.dragon.benches, "3 or more: neighbours have no gap")
    since = float(march.time(march.distance(hit.time) - _GAP_LENGTHS * march.dragon.lengths[0]))
    since = max(source.begin, since)
    misses = [miss for miss in hit.near_misses or () if miss.benches[0] == 0 and miss.time > since]
    subtitle = text(
        "gap between the head and the nearest bench but its neighbour; dashed: to each bench by itself"
    )
    figure = style.slide(
        text("How near the head comes to other benches than its neighbour"), subtitle
    )
    axes = style.panels(figure)
    times = np.union1d(np.linspace(since, hit.time, 1000), [miss.time for miss in misses])
    # In parts, to limit memory.
    corners = (march.dragon.outlines(march.at(part).poses) for part in np.array_split(times, 10))
    gaps = np.concatenate([separation(part[:, :1], part[:, 2:]).distance for part in corners])
    for row in np.unique(gaps.argmin(axis=1)).tolist():
        axes.plot(
            times, gaps[:, row], color=style.QUIET, lw=0.8, ls=(0, (4, 2)), gid=f"gap-{row + 2}"
        )
    smallest = gaps.min(axis=1)
    low, high = float(smallest.min()) / 3, 3 * float(smallest.max())
    axes.plot(times, smallest, color=style.BLUE, lw=2.0, gid="gap")
    style.logarithmic(axes, "m", _MIN_GAP if hit.contact else max(_MIN_GAP, low), high)
    axes.set(xlim=(since, hit.time), xlabel=text("time (s)"))
    for miss, marker in zip(misses, "osD^v", strict=False):
        note = text("bench {}: {:.3f} mm\nat {:.3f} s").format(
            miss.benches[1], 1e3 * miss.gap, miss.time
        )
        axes.plot(miss.time, miss.gap, marker, color=style.COLOURS.ink, ms=6, label=note)
    if hit.contact:
        note = text("bench {}: contact\nat {:.4f} s").format(hit.contact.benches[1], hit.time)
        axes.plot(
            hit.time, _MIN_GAP, "X", color=style.COLOURS.contact, ms=8, label=note, clip_on=False
        )
    if misses or hit.contact:
        axes.legend(**style.BESIDE)
    return figure


def _speeds(source: style.FigureSource) -> Figure:
    """Draw the speed along the dragon at several times."""
    times = _several_times(source.begin, source.last_regular_time)
    values = source.march.at(times).speeds
    title = text("The handles go at {:.3f} to {:.3f} m/s").format(values.min(), values.max())
    figure = style.slide(title, text("speed of every handle at several times, m/s"))
    _bundle(style.panels(figure), values, times, "speed", text("handle, from the head to the tail"))
    return figure


def _drift(source: style.FigureSource) -> Figure:
    """Draw the engine's position error against the exact model over time."""
    from matplotlib.ticker import EngFormatter

    run = source.run
    if run is None or len(run.times) == 1 or not run.max_drift > 0:
        raise ParameterError("run", run and "one without position errors", "a run of `simulate`")
    metres = EngFormatter("m", places=1)
    title = text("The largest position error in a frame is {}").format(metres(run.max_drift))
    figure = style.slide(
        title, text("position errors of the benches, at the worse of their two holes")
    )
    axes = style.panels(figure)
    # Without the first frame, whose position error is 0.
    frames = np.unique(np.linspace(1, len(run.times) - 1, 600).astype(np.intp))
    some = text("largest of the first {}").format(HEAD_BENCHES)
    worst = (
        np.fmax.reduce(run.drift[frames], axis=1),
        np.fmax.reduce(run.drift[frames, :HEAD_BENCHES], axis=1),
    )
    axes.plot(
        run.times[frames],
        worst[0],
        color=style.BLUE,
        lw=2.2,
        gid="any-bench",
        label=text("largest of all"),
    )
    axes.plot(
        run.times[frames],
        worst[1],
        color=style.AMBER,
        lw=2.2,
        ls="--",
        gid="first-benches",
        label=some,
    )
    high = 10.0 ** np.ceil(np.log10(run.max_drift))
    # An engine with a position error as large as the smallest gap can find the wrong first contact.
    gaps = [
        miss.gap
        for miss in source.hit.near_misses or ()
        if run.times[0] <= miss.time <= run.times[-1]
    ]
    if gaps:
        note = text("smallest gap: {}").format(metres(min(gaps)))
        axes.axhline(
            min(gaps), color=style.COLOURS.ink, lw=1.2, ls=":", gid="smallest-gap", label=note
        )
    style.logarithmic(axes, "m", 1e-4 * high, max(high, 2 * min(gaps, default=0.0)))
    axes.set(xlim=(run.times[0], run.times[-1]), xlabel=text("time (s)"))
    axes.legend(**style.BESIDE)
    return figure


def _impulses(source: style.FigureSource) -> Figure:
    """Draw the force in every joint at several times: the mean over a substep."""
    run = source.run
    if run is None or run.joint_forces is None or run.substep is None:
        raise ParameterError("run", run and "one without forces in joints", "a run of `simulate`")
    # The frame of the contact follows a shortened substep, in which the joint solver has not
    # converged.
    before = run.times < (run.first_contact.time if run.first_contact else np.inf)
    times, forces = run.times[before], run.joint_forces[before]
    if not forces.max(initial=0.0) > 0:
        raise ParameterError(
            "run", "one without joint forces", "a run of `simulate` with a frame before the contact"
        )
    rows = np.unique(np.searchsorted(times, _several_times(times[0], times[-1])))
    title = text("The joints carry up to {:.2f} N").format(forces[rows].max())
    subtitle = text("force in every joint, N: the mean over a substep of {:g} ms").format(
        1e3 * run.substep
    )
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


# All figures by name. 16 benches are the paper's small model, which closes a full loop before its
# first contact.
FIGURES: Mapping[str, NamedFigure] = {
    "spiral": NamedFigure("the spiral that handle 0 walks (the paper's figure 2)", _spiral),
    "outer-loop": NamedFigure(
        "16 benches on the outer loop (figure 3)", _outer_loop, 16, still=True
    ),
    "inward": NamedFigure(
        "16 benches as they close a full loop (figure 4)", _inward, 16, still=True
    ),
    "collision": NamedFigure(
        "16 benches at their first contact (figure 5)", _collision, 16, still=True
    ),
    "grid": NamedFigure("which benches are filed in which cells (figure 6)", _grid, 16),
    "trajectories": NamedFigure("the trajectories of seven handles (figure 7)", _trajectories),
    "velocities": NamedFigure("the velocities of seven handles (figure 8)", _velocities),
    "gap": NamedFigure("how near the head comes to the benches that it passes", _gap),
    "speeds": NamedFigure("speed along the dragon at several times", _speeds),
    "drift": NamedFigure("how far the engine is from the exact model", _drift),
    "impulses": NamedFigure("forces in the joints of a run of the engine", _impulses),
}
