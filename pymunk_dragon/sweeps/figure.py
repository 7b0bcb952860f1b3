"""The figure of a sweep: a line over one axis, or a map over two.

The time of the first contact changes continuously only while the same benches touch. Where these or
the status, a whole number or a text, change, the line is broken, and lines are drawn in the map.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby, pairwise, product
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._arrays import Array, Flags
from pymunk_dragon._language import text
from pymunk_dragon.drawing.figures.style import COLOURS, QUIET, chart, halo
from pymunk_dragon.sweeps.axes import varied
from pymunk_dragon.sweeps.quantities import kind
from pymunk_dragon.sweeps.result import Sweep

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Colours of small to large values: ink is readable on all of them but the last.
_VALUES = ("#fde18b", "#aacd90", "#63ad99", "#2a879d", "#355b92")
# Units by the last words of names.
_LENGTHS = "pitch", "width", "overhang", "spacing", "radius", "gap", "drift", "start_s"
_TIMES = "time", "error", "start", "until", "substep"
_UNITS = dict.fromkeys(_LENGTHS, "m") | dict.fromkeys(_TIMES, "s") | {"speed": "m/s"}
# Share of the points above which the benches that touch there are named.
_NAMED = 0.03


def draw(found: Sweep) -> Figure:
    """Draw a sweep of at most two axes with several values each.

    Matplotlib's current settings apply.
    """
    names = varied(found.axes) or found.names[:1]
    at = [np.array(found.column(name), dtype=float) for name in names]
    cells = [row[len(found.names) :] for row in found.rows()]
    first = [row[0] if isinstance(row[0], int | float) else np.nan for row in cells]
    values = np.array(first, dtype=float)
    labels = list(map(_label, cells))

    figure = chart(8.0, 6.0)
    axes = figure.add_subplot(xlabel=_words(names[0], unit=True))
    quantity = _words(found.columns[len(found.names)], unit=True)
    if len(names) == 1:
        axes.set_ylabel(quantity)
        _draw_line(axes, at[0], values, labels)
    else:
        axes.set_ylabel(_words(names[1], unit=True))
        figure.colorbar(_draw_map(axes, found, at, values, labels), label=quantity)

    _draw_missing(axes, at, ~np.isfinite(values))
    lines = axes.axvline, axes.axhline
    for name, x, line in zip(names, at, lines, strict=False):
        own = found.reference[name]
        if min(x) <= own <= max(x):
            label = text("reference: {0}").format(f"{_words(name)} {own:g}")
            line(own, ls="--", lw=1, color=COLOURS.contact, label=label, gid="reference")
    _write_titles(figure, axes, found, names, values[np.isfinite(values)])
    return figure


def _draw_missing(axes: Axes, at: Sequence[Array], missing: Flags) -> None:
    """Draw crosses at the points that are `missing`."""
    if missing.any():
        bottom = axes.get_ylim()[0]
        x, y = [*at, np.full(missing.size, bottom)][:2]
        label = text("no value")
        axes.plot(x[missing], y[missing], "x", color=QUIET, ms=4, label=label, gid="missing")


def _write_titles(
    figure: Figure, axes: Axes, found: Sweep, names: Sequence[str], values: Array
) -> None:
    """Write titles, with the range of the `values` (P,) that are finite, and a legend."""
    note = text("{0} points")
    if "bench_a" in found.columns and len(names) == 1:
        note = text("{0} points; along each line the same benches touch")
    elif "bench_a" in found.columns:
        note = text("{0} points; labels: benches that touch first; others across each line")
    axes.set_title(note.format(found.points), color=QUIET)

    over = text(" and ").join(map(_words, names))
    title = text("{0} over {1}").format(text(found.summary), over)
    if values.size:
        column = found.columns[len(found.names)]
        unit = _UNITS.get(column.rpartition("_")[2], "")
        span = text(": {0:.4g} to {1:.4g} {2}")
        title += span.format(values.min(), values.max(), unit).rstrip()
    figure.suptitle(title, size=16)
    if axes.get_legend_handles_labels()[0]:
        figure.legend(loc="outside lower center", ncols=4, frameon=False)


def _draw_line(axes: Axes, x: Array, values: Array, labels: Sequence[str]) -> None:
    """Draw values over one axis, with a line for each run of points of one label."""
    order = np.argsort(x, kind="stable").tolist()
    for label, run in groupby(order, key=labels.__getitem__):
        part = list(run)
        if np.isfinite(values[part]).any():
            name = label if len(part) > _NAMED * len(x) else None
            axes.plot(x[part], values[part], marker="o", ms=3, label=name, gid="line")


def _draw_map(
    axes: Axes, found: Sweep, at: Sequence[Array], values: Array, labels: Sequence[str]
) -> Any:
    """Draw values over two axes as colours, which change evenly between points; returned.

    Lines separate points of different labels.
    """
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.tri import Triangulation

    across, up = (np.unique(found.axes[name]) for name in varied(found.axes))
    column = np.searchsorted(across, at[0])
    row = np.searchsorted(up, at[1])
    names = np.full((len(up), len(across)), "", dtype=object)
    names[row, column] = labels

    # Of steps, as the axes have units of their own.
    triangles = Triangulation(column, row).triangles
    colours = LinearSegmentedColormap.from_list("sweep", list(_VALUES))
    look: dict[str, Any] = {"cmap": colours, "rasterized": True, "gid": "values"}
    look["mask"] = ~np.isfinite(values)[triangles].all(axis=1)
    shown = np.ma.masked_invalid(values)
    mesh = axes.tripcolor(at[0], at[1], shown, triangles=triangles, shading="gouraud", **look)
    axes.margins(0)

    for border in _borders(across, up, names, found.step):
        axes.plot(*border, color=COLOURS.ink, lw=0.9, gid="jumps")

    on_grid = (column % found.step == 0) & (row % found.step == 0)
    for name in dict.fromkeys(labels):
        inside = on_grid & [label == name for label in labels]
        if inside.sum() > _NAMED * on_grid.sum():
            middle = at[0][inside].mean(), at[1][inside].mean()
            axes.text(*middle, name, ha="center", va="center", path_effects=halo(), gid="name")
    return mesh


def _borders(x: Array, y: Array, names: Any, step: int) -> list[Array]:
    """Lines (2, 2) between points at `x` and `y` with other `names` (Y, X), "" where none is.

    In each cell of the grid, of `step` points a side, they join the middles between neighbours on
    its sides. Where the same names are on two of them, the line between is straight; others meet.
    """
    found = []
    # Once around a cell.
    around = np.arange(4 * step + 1)
    rows = np.clip(np.minimum(around - step, 4 * step - around), 0, step)
    columns = np.clip(np.minimum(around, 3 * step - around), 0, step)
    for i, j in product(range(0, len(y) - 1, step), range(0, len(x) - 1, step)):
        named = names[i + rows, j + columns]
        known = np.flatnonzero(named)
        points = np.transpose([x[j + columns], y[i + rows]])[known]
        middles: dict[frozenset[str], list[Array]] = {}
        for (one, other), middle in zip(
            pairwise(named[known]), (points[1:] + points[:-1]) / 2, strict=True
        ):
            if one != other:
                middles.setdefault(frozenset({one, other}), []).append(middle)

        loose = []
        for ends in middles.values():
            if len(ends) == 2:
                found.append(np.transpose(ends))
            else:
                loose += ends
        found += [np.transpose([end, np.mean(loose, axis=0)]) for end in loose]
    return found


def _label(cells: Sequence[Any]) -> str:
    """The kind of a point in words."""
    return text(" and ").join(text(str(each)) for each in kind(cells))


def _words(name: str, *, unit: bool = False) -> str:
    """The name of an axis or a column in words, with its unit if it has one."""
    known = _UNITS.get(name, _UNITS.get(name.rpartition("_")[2]))
    words = name.removesuffix("_s").replace("_", " ")
    return text("{}, {}").format(text(words), known) if unit and known else text(words)
