"""Derivatives of the first contact's time and of the smallest pitch by every size of the benches.

The derivatives are exact (`_gaps.py`). A contact is a zero of a gap g, so its position w changes by -(dg/dq) / (dg/dw)
per unit of a size q, and its time by that over the speed. The smallest pitch p is where a minimal gap is zero, and it
changes by -(dg/dq) / (dg/dp). The derivatives hold as long as the same two benches touch at the same features. The
range of each size in which they do is found by continuation (`_branches.py`). Contacts that the continuation does not
follow are searched just before the end of the range: for the first contact by `first_contact`, which certifies that
there is no earlier contact, and for the pitch by sampling the whole inward spiral.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._display import table
from pymunk_dragon._language import text
from pymunk_dragon.collision import first_contact
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.studies._branches import (
    GAP_TOLERANCE,
    Branch,
    ContactBranch,
    ContinuationPoint,
    Pair,
    Reach,
    TangencyBranch,
    find_reach,
)
from pymunk_dragon.studies._gaps import QUANTITIES, SIZES, InwardMarch, SampledGaps, gaps_of
from pymunk_dragon.studies._study import Progress, Result, Study, silent
from pymunk_dragon.studies.min_pitch import RADIUS, MinPitch, min_pitch

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Largest change of a size that is examined, as a share of the size.
MAX_CHANGE = 0.1
# Share of the width up to which a gap is followed as a near miss. A wider gap that closes first is found by the check
# at the end of the range, which takes longer.
NEAR_MISS_WIDTH = 0.05
# m travelled by the head. Contacts of a pair within this distance are the same contact.
SAME_CONTACT = 1e-6
# Parts of which progress is reported: first contact, smallest pitch, and the derivatives of both.
PARTS = 4

# Of the figure: inches of height of a row, and from the page's bottom to the tables.
ROW_HEIGHT, TABLE_BOTTOM = 0.4, 0.58
# Of the figure: inches from a table's left edge to its columns: slopes as numbers, as lines, and ranges.
NUMBERS_LEFT, LINES_LEFT, RANGES_LEFT = 1.05, 1.8, 2.45
# Of the figure: ratio of an axis limit to the largest slope, and of the smallest slope to the other limit.
AXIS_MARGIN = 3.0
# How a range ends in the text.
ENDS = {
    "nothing": "or more",
    "no contact": "then none",
    "another corner": "then another corner",
    "another pair": "then {} and {}",
}


@dataclass(frozen=True, kw_only=True)
class Slope:
    """Derivative of a result by one size.

    Attributes
    ----------
    size : str
        Name of the size.
    value : float
        The size, m; the least one where the benches differ.
    slope : float
        Derivative of the result: s per m for the time, m per m for the pitch.
    less, more : Reach or None
        Ranges below and above the size in which the derivative holds; None where they are not computed, for a pitch
        that is not limited by benches passing each other.
    """

    size: str
    value: float
    slope: float
    less: Reach | None
    more: Reach | None


@dataclass(frozen=True, kw_only=True, repr=False)
class Sensitivity(Result):
    """Derivatives of the first contact's time and of the smallest pitch by every size.

    Attributes
    ----------
    march : March
        The march whose first contact is differentiated.
    time : float
        Time of the first contact, s.
    benches : tuple of int
        The two benches that touch.
    times : tuple of Slope
        Derivatives of that time by each size, including the pitch.
    smallest : MinPitch
        The smallest pitch of the same dragon.
    pitches : tuple of Slope
        Derivatives of the smallest pitch by each size of the benches; empty where the circle limits the pitch.

    Examples
    --------
    >>> sensitivity()
    <Sensitivity: first contact at t = 412.473837682 s: benches 0 and 8>
    """

    march: March
    time: float
    benches: tuple[int, int]
    times: tuple[Slope, ...]
    smallest: MinPitch
    pitches: tuple[Slope, ...]

    def to_dict(self) -> dict[str, Any]:
        """Values in SI units, as `study sensitivity --json` prints them."""
        times, pitches = (
            {slope.size: {name: value for name, value in asdict(slope).items() if name != "size"} for slope in slopes}
            for slopes in (self.times, self.pitches)
        )
        smallest = self.smallest
        return {
            "contact": {"time": self.time, "benches": self.benches, "slopes": times},
            "smallest_pitch": {"pitch": smallest.pitch, "benches": smallest.benches, "slopes": pitches},
        }

    def _lines(self) -> list[str]:
        i, j = self.benches
        first = text("first contact at t = {time:.9f} s: benches {i} and {j}").format(time=self.time, i=i, j=j)
        lines = [first, *_table(text("s per mm"), 1e3, self.times)]
        pitch = self.smallest.pitch
        if self.smallest.benches is None:
            limited = text("smallest pitch {pitch:.12f} m: limited by the circle, whatever the benches")
            return [*lines, limited.format(pitch=pitch)]
        i, j = self.smallest.benches
        smallest = text("smallest pitch {pitch:.12f} m: benches {i} and {j}").format(pitch=pitch, i=i, j=j)
        return [*lines, smallest, *_table(text("mm per mm"), 1.0, self.pitches)]

    def _draw(self) -> Figure:
        """The derivatives, and the range of each size in which they hold."""
        from pymunk_dragon.drawing.figures.style import QUIET, SLIDE_HEIGHT, SLIDE_WIDTH, SMALL, slide

        name = text("first contact: {:.4f} s,\nbenches {} and {}").format(self.time, *self.benches)
        tables = [(0.3, name, text("change in s\nfor 1 mm more"), 1e3, self.times)]
        if self.smallest.benches is not None:
            name = text("smallest pitch: {:.6f} m,\nbenches {} and {}")
            name = name.format(self.smallest.pitch, *self.smallest.benches)
            tables.append((4.05, name, text("change in mm\nfor 1 mm more"), 1.0, self.pitches))
        figure = slide(
            text("What a millimetre does to the first contact, and to the smallest pitch"),
            text("exact slopes, and the changes of each size for which the same benches touch"),
        )
        for left, name, heading, per, rows in tables:
            _draw_table(figure, left, name, heading, per, rows)
        note = text("Beyond these changes other benches touch first, or none. * Larger changes were not examined.")
        figure.text(0.3 / SLIDE_WIDTH, 0.25 / SLIDE_HEIGHT, note, size=SMALL, color=QUIET)
        return figure


def sensitivity(
    dragon: Dragon | None = None,
    *,
    pitch: float = 0.55,
    turns: float = 16.0,
    speed: float = 1.0,
    radius: float = RADIUS,
    progress: Progress = silent,
) -> Sensitivity:
    """Exact derivatives of the first contact's time and of the smallest pitch by the sizes.

    Parameters
    ----------
    dragon : Dragon, optional
        The dragon; by default the contest's.
    pitch
        As in `Spiral`, for the first contact. The smallest pitch does not depend on it.
    turns, speed
        As in `March`.
    radius
        As in `min_pitch`.
    progress : callable, optional
        Called with the number of parts that are done and the number of all parts.

    Raises
    ------
    ParameterError
        If the dragon never touches itself, or as `March` and `min_pitch` do.
    DragonError
        As `min_pitch` does.

    Examples
    --------
    >>> found = sensitivity(Dragon(benches=25))
    >>> width = found.times[0]
    >>> width.size, round(width.slope / 1e3, 4)  # s for each mm
    ('width', -0.032)
    """
    dragon = dragon or Dragon()
    march = March(dragon, Spiral(pitch=pitch), turns=turns, speed=speed)
    hit = first_contact(march)
    if hit.status != "contact" or hit.benches is None:
        raise ParameterError("pitch", pitch, f"one at which the dragon runs into itself ({hit.status} here)")
    progress(1, PARTS)
    smallest = min_pitch(dragon, turns=turns, speed=speed, radius=radius)
    progress(2, PARTS)
    travelled = float(march.distance(hit.time))
    radius_then = float(np.hypot(*march.curve.point(march.head_start + travelled)))
    inward = InwardMarch(dragon=dragon, pitch=pitch, turns=turns, radius=radius_then)
    speed_then = float(march.speed_profile.at(hit.time))
    times = _contact_slopes(inward, hit.benches, travelled, speed_then)
    progress(3, PARTS)
    return Sensitivity(
        march=march,
        time=hit.time,
        benches=hit.benches,
        times=times,
        smallest=smallest,
        pitches=_pitch_slopes(smallest),
    )


def _contact_slopes(inward: InwardMarch, pair: Pair, travelled: float, speed: float) -> tuple[Slope, ...]:
    """Derivatives of the time of a first contact of `pair` after `travelled` m, at `speed` m/s."""
    sampled = SampledGaps(inward)

    def other_pair(size: str, point: ContinuationPoint, change: float) -> Pair | None:
        found = first_contact(inward.changed(size, change).march)
        same = found.benches == pair and abs(found.time - float(point.contact.travelled[0])) <= SAME_CONTACT
        return None if same else found.benches

    branches = [ContactBranch(sampled.inward, travelled, pair, size) for size in SIZES]
    return _slopes(branches, sampled, other_pair, 1 / speed)


def _pitch_slopes(smallest: MinPitch) -> tuple[Slope, ...]:
    """Derivatives of a smallest pitch by each size of the benches."""
    pair = smallest.benches
    if pair is None:
        return ()
    inward = InwardMarch(
        dragon=smallest.march.dragon, pitch=smallest.pitch, turns=smallest.turns, radius=smallest.radius
    )
    sizes = [size for size in SIZES if size != "pitch"]
    if smallest.limit != "passing":
        contact = gaps_of(inward, smallest.distance, pair)
        at_start = contact.slopes[:, QUANTITIES.index("pitch")]
        by_pitch = contact.slopes_at_radius if smallest.limit == "arrival" else at_start
        by_size = (-contact.slopes[0] / by_pitch[0]).tolist()
        return tuple(
            Slope(size=size, value=inward.size(size), slope=by_size[QUANTITIES.index(size)], less=None, more=None)
            for size in sizes
        )
    sampled = SampledGaps(inward)

    def other_pair(size: str, point: ContinuationPoint, change: float) -> Pair | None:
        found = SampledGaps(replace(inward.changed(size, change), pitch=point.inward.pitch)).minimum()
        if found is None or found.gaps[0] > -GAP_TOLERANCE:
            return None
        first, second = found.pairs[0].tolist()
        return first, second

    branches = [TangencyBranch(sampled.inward, smallest.distance, pair, size) for size in sizes]
    return _slopes(branches, sampled, other_pair, 1.0)


def _slopes(
    branches: Sequence[Branch],
    sampled: SampledGaps,
    other_pair: Callable[[str, ContinuationPoint, float], Pair | None],
    factor: float,
) -> tuple[Slope, ...]:
    """Derivatives by the sizes of the branches: `factor` times the rate of each.

    `other_pair` returns the pair, if any, that touches first instead of the branch's own, for a size, a point of its
    branch, and the change of the size there.
    """
    minima = sampled.local_minima(NEAR_MISS_WIDTH * float(sampled.inward.dragon.widths.min()))
    slopes = []
    for branch in branches:
        value, rate = sampled.inward.size(branch.size), branch.at(0.0).rate
        less, more = (
            find_reach(branch, minima, sign * MAX_CHANGE * value, partial(other_pair, branch.size)) for sign in (-1, 1)
        )
        slopes.append(Slope(size=branch.size, value=value, slope=rate * factor, less=less, more=more))
    return tuple(slopes)


def _table(unit: str, per: float, slopes: Sequence[Slope]) -> list[str]:
    """Lines of a table of derivatives per mm, with their unit; `per` converts them from SI units."""
    heads = (" " + text("size"), text("now (mm)"), unit, text("holds from (mm)"), text("to (mm)"))
    rows = []
    for row in slopes:
        size, ends = row.size.replace("_", "-"), map(_end_text, (row.less, row.more))
        rows.append((" " + text(size), 1e3 * row.value, row.slope / per, *ends))
    return table(heads, ("<13", "8.2f", "+10.7f", "<20", ""), rows)


def _end_text(end: Reach | None) -> str | None:
    return None if end is None else f"{1e3 * end.unchanged:+.4g} " + text(ENDS[end.by]).format(*end.benches or ())


def _draw_table(figure: Figure, left: float, name: str, heading: str, per: float, rows: Sequence[Slope]) -> None:
    """Draw the slopes of a result and the ranges of the sizes, with the name of the result above."""
    from pymunk_dragon.drawing.figures.style import LINE_SPACING, QUIET, SMALL, panel

    across, up = figure.get_size_inches()
    height = ROW_HEIGHT * len(SIZES)
    top = TABLE_BOTTOM + height
    _draw_slopes(panel(figure, left + LINES_LEFT, TABLE_BOTTOM, RANGES_LEFT - LINES_LEFT - 0.15, height), per, rows)
    figure.text(left / across, (top + 0.56) / up, name, size=11.5, linespacing=LINE_SPACING)
    for inches, shown in ((NUMBERS_LEFT, heading), (RANGES_LEFT, text("valid for changes\nof the size, mm"))):
        style: dict[str, Any] = {"size": SMALL, "color": QUIET, "linespacing": LINE_SPACING}
        figure.text((left + inches) / across, (top + 0.08) / up, shown, **style)
    names = _size_names()
    for row_index, row in enumerate(rows):
        style = {"y": (top - (row_index + 0.5) * ROW_HEIGHT) / up, "size": SMALL, "va": "center"}
        slope = f"{row.slope / per:+.5f}".replace("-", "\u2212")
        figure.text(**style, x=left / across, s=names[row.size])
        figure.text(**style, x=(left + NUMBERS_LEFT) / across, s=slope)
        if row.less is not None and row.more is not None:
            shown = text("{} to {}").format(_describe_end(row.less), _describe_end(row.more))
            figure.text(**style, x=(left + RANGES_LEFT) / across, s=shown, gid=f"range-{row.size}")


def _draw_slopes(axes: Axes, per: float, rows: Sequence[Slope]) -> None:
    """Draw the magnitude of each slope on a logarithmic scale; markers of negative slopes are hollow."""
    from pymunk_dragon.drawing.figures.style import BLUE, COLOURS, PALE

    sizes = np.abs([row.slope / per for row in rows])
    axes.set_xscale("log")
    axes.set_xlim(sizes.min() / AXIS_MARGIN, sizes.max() * AXIS_MARGIN)
    axes.set_ylim(len(SIZES) - 0.5, -0.5)
    axes.set_axis_off()
    for row_index, (row, size) in enumerate(zip(rows, sizes.tolist(), strict=True)):
        axes.plot([axes.get_xlim()[0], size], [row_index, row_index], color=PALE, lw=1.4, zorder=1)
        face = BLUE if row.slope > 0 else COLOURS.background
        axes.plot(size, row_index, "o", color=BLUE, mfc=face, ms=7, mew=1.8, gid=f"slope-{row.size}")


def _size_names() -> dict[str, str]:
    """Words for the sizes."""
    return {
        "width": text("width"),
        "overhang": text("overhang"),
        "head_spacing": text("head spacing"),
        "body_spacing": text("body spacing"),
        "pitch": text("pitch"),
    }


def _describe_end(end: Reach) -> str:
    change = f"{1e3 * end.unchanged:+.3g}".replace("-", "\u2212")
    return change + "*" * (end.by == "nothing")


STUDY = Study(
    name="sensitivity",
    summary="effect of each size of the benches on first contact and that pitch",
    run=sensitivity,
)
