"""The paper's figures, and others: seen from above, over time, and along the dragon."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import text
from pymunk_dragon.collision import Grid, separation
from pymunk_dragon.drawing import Film
from pymunk_dragon.drawing.figures.order import draw
from pymunk_dragon.drawing.figures.style import (
    AMBER,
    BESIDE,
    BLUE,
    CANDIDATE,
    COLOURS,
    FAINT,
    PALE,
    QUIET,
    RULE,
    SHARED,
    SMALL,
    FigureSource,
    halo,
    logarithmic,
    plan,
    slide,
)
from pymunk_dragon.dynamics import joint_forces, pull
from pymunk_dragon.errors import MissingExtraError, ParameterError
from pymunk_dragon.model.run import HEAD_BENCHES, Run
from pymunk_dragon.model.settings import EngineSettings

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# m: lower end of the scale of gaps.
_MIN_GAP = 1.5e-4
# Pixels: twice the width at which two or three pictures fit side by side.
_STILL_WIDTH = 880
# Height of the texts of a still picture over its width.
_TEXTS = 0.12
# Length of the largest arrow of a velocity over the width of the path.
_ARROW = 0.16
# Head lengths travelled: the part of a march before its contact, or its end, that `gap` shows.
_GAP_LENGTHS = 4.5


@dataclass(frozen=True)
class NamedFigure:
    """What a figure shows, its function, and the number of benches.

    The function of a `still` returns a run and a film.
    """

    shows: str
    draw: Callable[[FigureSource], Any]
    benches: int = 223
    still: bool = False


def _spiral(source: FigureSource) -> Figure:
    """Draw the spiral that handle 0 follows (the paper's figure 2)."""
    march = source.march
    curve = march.curve
    start = march.head_start
    end = source.hit.time
    turns = curve.turns(start)
    if turns is None or curve.end_s == np.inf:
        raise ParameterError("curve", type(curve).__name__, "a Spiral inward, for this figure")

    gone = float(march.distance(end))
    whole = curve.end_s - start
    title = text("Handle 0 walks {:.1f} m of {:.1f} m of spiral").format(gone, whole)
    subtitle = text("{:.4g} turns inward, {:g} m apart").format(turns, curve.turn_width)
    figure, axes = slide(title, subtitle)

    walked = source.path(start, start + gone)
    name = text("the march of handle 0")
    axes.plot(*walked.T, color=BLUE, gid="walked", label=name)
    # At most ten whole minutes.
    step = max(1, np.ceil(end / 600))
    minutes = np.arange(0, end / 60, step)
    dots = curve.point(start + march.distance(60 * minutes))
    name = text("numbers: minutes")
    axes.plot(*dots.T, "o", color=COLOURS.ink, ms=13, gid="minutes", label=name)
    axes.plot(*walked[-1], "o", color=COLOURS.contact, ms=8, gid="last", label=source.end)
    rest = source.path(start + gone, curve.end_s)
    axes.plot(*rest.T, color=QUIET, lw=1.0, ls="--", gid="ahead", label=text("not reached"))
    centred = {"ha": "center", "va": "center", "color": COLOURS.background, "size": SMALL}
    for minute, (x, y) in zip(minutes, dots.tolist(), strict=True):
        axes.text(x, y, f"{minute:g}", **centred)
    plan(axes)
    axes.legend(**BESIDE)
    return figure


def _trajectories(source: FigureSource) -> Figure:
    """Draw the trajectories of the paper's seven handles until the first contact (its figure 7)."""
    handles = source.march.dragon.representatives
    first, last = source.march.handles_s([source.begin, source.hit.time])
    whole = source.path(first[-1], last[0], 900)
    title = text("All handles walk the same path, one behind the other")
    subtitle = text("from {:g} s to {}; the path is {:.3g} m wide and {:.3g} m high")
    extent = np.ptp(whole, axis=0)
    figure, (seen, over) = slide(title, subtitle.format(source.begin, source.end, *extent), 1, 2)

    seen.plot(*whole.T, color=PALE, lw=0.8)
    for rank, handle in enumerate(handles):
        path = source.path(first[handle], last[handle], 900)
        seen.plot(*path.T, color=BLUE, lw=0.6, gid=f"path-{handle}")
        # The colours of the lines beside it.
        look: dict[str, Any] = {"mec": f"C{rank}", "ms": 7, "mew": 1.8, "zorder": 4}
        hollow = {"mfc": COLOURS.background, "label": text("at the start")}
        start = seen.plot(*path[0], "o", **look, **hollow)
        stop = seen.plot(*path[-1], "o", mfc=f"C{rank}", label=text("at the end"), **look)
    plan(seen)
    seen.legend(
        handles=start + stop, loc="lower left", bbox_to_anchor=(0, 1), ncols=2, borderpad=0.2
    )

    times = np.linspace(source.begin, source.hit.time, 400)
    places = source.march.at(times).positions[:, list(handles)]
    for handle, radius in zip(handles, np.hypot(*np.moveaxis(places, -1, 0)).T, strict=True):
        name = text("handle {}", handle)
        over.plot(times, radius, label=name, gid=f"radius-{handle}")
    # The outermost first, as the lines are.
    over.legend(reverse=True, **BESIDE)
    over.set(
        xlim=(times[0], times[-1]),
        xlabel=text("time (s)"),
        ylabel=text("distance from the centre (m)"),
    )
    return figure


def _velocities(source: FigureSource) -> Figure:
    """Draw the velocities of the paper's seven handles at the first contact (its figure 8)."""
    time = source.last_regular_time
    handles = list(source.march.dragon.representatives)
    states = source.march.at(time)
    title = text("The velocities of {} handles at {:.2f} s").format(len(handles), time)
    figure, axes = slide(title, text("each handle walks along the curve"))
    path = source.path(states.handles_s[0, -1], states.handles_s[0, 0])
    axes.plot(*path.T, color=PALE, lw=0.8)
    for outline in source.march.dragon.outlines(states.poses[0]):
        axes.fill(*outline.T, fc=SHARED, ec=PALE, lw=0.4, zorder=1)

    points = states.positions[0, handles]
    velocities = states.velocities[0, handles]
    speeds = states.speeds[0, handles]
    number: dict[str, Any] = {"ha": "center", "va": "center", "size": 9, "zorder": 5}
    number["textcoords"] = "offset points"
    for handle, point, velocity, speed in zip(handles, points, velocities, speeds, strict=True):
        name = text("handle {}: {:.3f} m/s", handle, speed)
        axes.plot(*point, "o", color=COLOURS.ink, ms=5, zorder=4, label=name)
        # The number is behind the handle.
        number["xytext"] = -18 * velocity / speed
        axes.annotate(str(handle), point, path_effects=halo(), **number)
    arrows: dict[str, Any] = {"angles": "xy", "color": COLOURS.motion, "width": 0.007, "zorder": 3}
    longest = _ARROW * np.ptp(path, axis=0).max()
    arrows |= {"scale_units": "xy", "scale": float(speeds.max()) / longest}
    axes.quiver(*points.T, *velocities.T, gid="velocities", **arrows)
    plan(axes)
    axes.legend(**BESIDE)
    return figure


def _grid(source: FigureSource) -> Figure:
    """Draw the grid at the first contact, and the benches in its cells (the paper's figure 6)."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    hit = source.hit
    dragon = source.march.dragon
    cells = Grid.of(source.march)
    corners = dragon.outlines(source.march.at(hit.time).poses[0])
    title = text("{} of {} pairs of benches that share no hole share a cell, and are tested")
    pairs = (dragon.benches - 1) * (dragon.benches - 2) // 2
    origin = "({:g}, {:g})".format(*cells.origin).replace("-", "\u2212")
    subtitle = text("{}; cells of {:g} m, counted from {} m").format(source.end, cells.cell, origin)
    figure, axes = slide(title.format(len(cells.pairs(corners)), pairs), subtitle)

    # Cells around the benches.
    filed, benches = cells.file(corners)
    first = filed.min(axis=0) - 1
    last = filed.max(axis=0) + 1
    kinds = _kinds_of_cells(filed - first, benches, last - first + 1)
    colours = ListedColormap([COLOURS.background, FAINT, SHARED, CANDIDATE])
    # The axes are column and row: a cell's indices are at its middle.
    x = np.arange(first[1], last[1] + 2) - 0.5
    y = np.arange(first[0], last[0] + 2) - 0.5
    lines: dict[str, Any] = {"edgecolor": RULE, "lw": 0.6, "gid": "cells"}
    axes.pcolormesh(x, y, kinds, cmap=colours, vmin=0, vmax=3, **lines)

    outlines = (corners - cells.origin) / (cells.cell, -cells.cell) - 0.5
    number: dict[str, Any] = {"ha": "center", "va": "center", "size": SMALL}
    for bench, outline in enumerate(outlines):
        hits = bench in (hit.benches or ())
        colour = COLOURS.contact if hits else COLOURS.ink
        drawn: dict[str, Any] = {"color": colour, "zorder": 3 + hits}
        axes.fill(*outline.T, fill=False, lw=2.2 if hits else 1.1, gid=f"bench-{bench}", **drawn)
        # Numbers of shorter benches would cover each other.
        if hits or dragon.lengths[bench] >= 0.15 * cells.cell * len(x):
            middle = outline.mean(axis=0)
            axes.text(*middle, str(bench), path_effects=halo(), **number, **drawn)

    axes.set(aspect="equal", xlabel=text("column j"), ylabel=text("row i"))
    axes.locator_params(integer=True)
    axes.invert_yaxis()
    names = (text("one bench"), text("neighbours only"), text("candidates"))
    patches = [Patch(fc=colours(kind), ec=RULE, label=name) for kind, name in enumerate(names, 1)]
    axes.legend(handles=patches, **BESIDE)
    return figure


def _kinds_of_cells(
    filed: NDArray[np.integer], benches: NDArray[np.integer], shape: NDArray[np.integer]
) -> NDArray[np.integer]:
    """Kinds of cells: 0 empty, 1 with one bench, 2 with neighbours, 3 with other benches too.

    `filed` (K, 2) are the cells in which the `benches` (K,) are.
    """
    indices = tuple(filed.T)
    least = np.full(shape, benches.max())
    np.minimum.at(least, indices, benches)
    most = np.full(shape, -1)
    np.maximum.at(most, indices, benches)
    return np.asarray(np.clip(most - least + 1, 0, 3))


def _outer_loop(source: FigureSource) -> tuple[Run, Film]:
    """Run and film parameters of the picture of the dragon at its start."""
    return _still(source, source.begin, text("{} benches at the start"))


def _inward(source: FigureSource) -> tuple[Run, Film]:
    """Run and film of the dragon as it closes a loop: it turns by 2 pi between tail and head."""
    times = np.linspace(source.begin, source.hit.time, 2001)
    tangents = source.march.curve.tangent(source.march.handles_s(times))
    x, y = np.moveaxis(tangents, -1, 0)
    angles = np.unwrap(np.arctan2(y, x), axis=1)
    turned = np.abs(angles[:, 0] - angles[:, -1])
    closed = turned >= 2 * np.pi
    # Half-way if the loop is always or never closed.
    time = float(times[closed.argmax() or 1000])
    return _still(source, time, text("{} benches on the path"))


def _collision(source: FigureSource) -> tuple[Run, Film]:
    """Run and film of the dragon at the first contact."""
    hit = source.hit
    if hit.contact is None:
        raise ParameterError("march", f"clear until {hit.time:g} s", "one that runs into itself")
    run, film = _still(source, hit.time, text("{} benches at the first contact"))
    return replace(run, first_contact=hit.contact, outcome="contact"), film


def _still(source: FigureSource, time: float, title: str) -> tuple[Run, Film]:
    """Run of one frame, and film with a title that has the number of benches."""
    run = Run.exact(source.march, [time])
    width, height = np.ptp(source.march.dragon.outlines(run.poses[0]), axis=(0, 1)).tolist()
    # A lying dragon needs no square, but texts some room.
    flat = round(_STILL_WIDTH * min(1.0, height / width + _TEXTS))
    film = Film(size=(_STILL_WIDTH, flat), title=title.format(source.march.dragon.benches))
    return run, film


def _gap(source: FigureSource) -> Figure:
    """Draw the gap between the head and the benches that it passes at last."""
    march = source.march
    hit = source.hit
    benches = march.dragon.benches
    if benches < 3:
        raise ParameterError("benches", benches, "3 or more: neighbours have no gap")
    begin = march.distance(hit.time) - _GAP_LENGTHS * march.dragon.lengths[0]
    since = max(source.begin, float(march.time(begin)))
    later = [miss for miss in hit.near_misses or () if miss.time > since]
    misses = [miss for miss in later if miss.benches[0] == 0]
    title = text("How near the head comes to other benches than its neighbour")
    subtitle = text(
        "gap between the head and the nearest bench but its neighbour; "
        "dashed: to each bench by itself"
    )
    figure, axes = slide(title, subtitle)

    even = np.linspace(since, hit.time, 1000)
    times = np.union1d(even, [miss.time for miss in misses])
    corners = march.dragon.outlines(march.at(times).poses)
    gaps = separation(corners[:, :1], corners[:, 2:]).distance
    dashes: dict[str, Any] = {"color": QUIET, "lw": 0.8, "ls": (0, (4, 2))}
    for row in np.unique(gaps.argmin(axis=1)).tolist():
        axes.plot(times, gaps[:, row], gid=f"gap-{row + 2}", **dashes)
    smallest = gaps.min(axis=1)
    axes.plot(times, smallest, color=BLUE, gid="gap")

    low = _MIN_GAP if hit.contact else max(_MIN_GAP, float(smallest.min()) / 3)
    logarithmic(axes, low, 3 * float(smallest.max()))
    axes.set(xlim=(since, hit.time), xlabel=text("time (s)"))
    for miss, marker in zip(misses, "osD^v", strict=False):
        bench = miss.benches[1]
        note = text("bench {}: {:.3f} mm\nat {:.3f} s", bench, 1e3 * miss.gap, miss.time)
        axes.plot(miss.time, miss.gap, marker, color=COLOURS.ink, ms=6, label=note)
    if hit.contact:
        bench = hit.contact.benches[1]
        note = text("bench {}: contact\nat {:.4f} s", bench, hit.time)
        last: dict[str, Any] = {"color": COLOURS.contact, "ms": 8, "clip_on": False}
        axes.plot(hit.time, _MIN_GAP, "X", label=note, **last)
    if misses or hit.contact:
        axes.legend(**BESIDE)
    return figure


def _speeds(source: FigureSource) -> Figure:
    """Draw the speed along the dragon at several times."""
    times = _several_times(source.begin, source.last_regular_time)
    values = source.march.at(times).speeds
    title = text("The handles go at {:.3f} to {:.3f} m/s", values.min(), values.max())
    figure, axes = slide(title, text("speed of every handle at several times, m/s"))
    _bundle(axes, values, times, "speed", text("handle, from the head to the tail"))
    return figure


def _drift(source: FigureSource) -> Figure:
    """Draw the engine's position error against the exact model over time."""
    from matplotlib.ticker import EngFormatter

    run = source.run
    # Benches that the head pulls exactly are off the path, and no error.
    if run is None or run.is_pulled or len(run.times) == 1 or not run.max_drift > 0:
        raise ParameterError("run", run and "one without position errors", "a run of `simulate`")
    metres = EngFormatter("m", places=1)
    title = text("The largest position error in a frame is {}", metres(run.max_drift))
    subtitle = text("position errors of the benches, at the worse of their two holes")
    figure, axes = slide(title, subtitle)

    # Without the first frame, whose position error is 0.
    even = np.linspace(1, len(run.times) - 1, 600)
    frames = np.unique(even.astype(np.intp))
    times = run.times[frames]
    errors = run.drift[frames]
    name = text("largest of all")
    worst = np.fmax.reduce(errors, axis=1)
    axes.plot(times, worst, color=BLUE, gid="any-bench", label=name)
    name = text("largest of the first {}", HEAD_BENCHES)
    worst = np.fmax.reduce(errors[:, :HEAD_BENCHES], axis=1)
    axes.plot(times, worst, color=AMBER, ls="--", gid="first-benches", label=name)

    # An engine with a position error as large as the smallest gap can find the wrong first contact.
    begin, end = run.interval
    misses = source.hit.near_misses or ()
    gaps = [miss.gap for miss in misses if begin <= miss.time <= end]
    high = 10.0 ** np.ceil(np.log10(run.max_drift))
    low = 1e-4 * high
    if gaps:
        gap = min(gaps)
        high = max(high, 2 * gap)
        note = text("smallest gap: {}", metres(gap))
        dots: dict[str, Any] = {"color": COLOURS.ink, "lw": 1.2, "ls": ":"}
        axes.axhline(gap, gid="smallest-gap", label=note, **dots)
    logarithmic(axes, low, high)
    axes.set(xlim=(begin, end), xlabel=text("time (s)"))
    axes.legend(**BESIDE)
    return figure


def _forces(source: FigureSource) -> Figure:
    """Draw the force in every joint at several times, and the exact ones beside an engine's."""
    run = source.run
    if run is None or run.joint_forces is None or not run.joint_forces.max() > 0:
        raise ParameterError("run", run and "one without forces in joints", "a run of `simulate`")
    times = run.times
    forces = run.joint_forces

    several = _several_times(*run.interval)
    rows = np.unique(np.searchsorted(times, several))
    title = text("The joints carry up to {:.2f} N", forces[rows].max())
    figure, axes = slide(title, text("force in every joint, N"))
    exact = _exact_forces(run, times[rows])
    dashes: dict[str, Any] = {"color": COLOURS.ink, "lw": 0.8, "ls": "--", "zorder": 3}
    for rank, line in enumerate(exact):
        name = text("exact") if rank == 0 else None
        axes.plot(line, gid=f"exact-{rank}", label=name, **dashes)
    joint = text("joint, from the head to the tail; joint i is between benches i and i + 1")
    _bundle(axes, forces[rows], times[rows], "force", joint)
    return figure


def _exact_forces(run: Run, times: Array) -> Array:
    """Exact forces (T, N - 1) in the joints of a run of the engine; (0, N - 1) if unknown."""
    march = run.march
    origin = run.provenance
    drag = origin.get("drag", EngineSettings.drag)
    start = origin.get("start", times[0])
    unknown = np.empty((0, march.dragon.benches - 1))
    if run.player != "pymunk" or origin.get("contacts") == "resolve":
        return unknown
    match origin.get("guide"):
        case "rails":
            # Both have a drag in proportion to the highest speed, but in intervals of their own.
            fastest = march.speed_profile.fastest
            drag *= fastest(start, origin.get("until", times[-1])) / fastest(times[0], times[-1])
            return joint_forces(march, times, drag=drag)
        case "none":
            with suppress(MissingExtraError):
                pulled = pull(march, start=start, until=times[-1], drag=drag)
                assert pulled.joint_forces is not None  # A pulled run has forces.
                tracks = pulled.joint_forces.T
                return np.transpose([np.interp(times, pulled.times, track) for track in tracks])
    return unknown


def _several_times(begin: float, end: float) -> Array:
    """A few round times, s, from `begin` on, and `end`."""
    from matplotlib.ticker import MaxNLocator

    ticks = MaxNLocator(5, steps=[1, 2, 5, 10]).tick_values(begin, end)
    # A tick within a fiftieth of the interval before the end is omitted.
    last = end - (end - begin) / 50
    return np.array([*(tick for tick in ticks if begin <= tick < last), end])


def _bundle(axes: Axes, values: Array, times: Array, gid: str, along: str) -> None:
    """Draw lines of `values` (T, K) along the dragon, later ones darker.

    Their `times` are in a legend.
    """
    from matplotlib import colormaps

    colours = colormaps["Blues"](np.linspace(0.4, 1.0, len(times)))
    for rank, (line, time) in enumerate(zip(values, times, strict=True)):
        axes.plot(line, color=colours[rank], gid=f"{gid}-{rank}", label=f"{time:.5g} s")
    axes.set(xlim=(0, values.shape[1] - 1), xlabel=along)
    axes.locator_params(axis="x", integer=True)
    axes.grid(axis="y")
    axes.legend(**BESIDE)


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
    "forces": NamedFigure("forces in the joints of a run, and the exact ones", _forces),
    "order": NamedFigure("the engine's error over its step, where only the head pulls", draw, 40),
}
