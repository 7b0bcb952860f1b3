"""The smallest pitch: the gap over the pitch, where two benches touch, and how near the head comes on its way."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon.render.figures.charts import MM, gap_line
from pymunk_dragon.render.figures.lines import label, logarithmic
from pymunk_dragon.render.figures.style import BLUE, COLOURS, FAINT, QUIET, RULE, halo, page, panel
from pymunk_dragon.studies import MinPitch

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["smallest_pitch"]

# How much of the way in is shown from close by: as long as the head takes for so many of its own lengths. Moments at
# which gaps are measured there, and the lowest and the highest one on the scale, mm.
LAST_LENGTHS, GAP_MOMENTS, LEAST_GAP, MOST_GAP = 14.0, 1200, 0.1, 400.0
# Inches of a page's upper part, and of the way's last part below it.
TOP, LAST = 4.4, 3.9
# Lengths of the head that a close-up is wide. Points of a line on the ground.
CLOSE_UP, LINE_POINTS = 1.35, 600


def smallest_pitch(found: MinPitch) -> Figure:
    """The answer of `min_pitch`."""
    title, height = f"At a pitch of {found.pitch:.6f} m the head starts on the circle itself", TOP
    if found.benches is not None:
        first, second = found.benches
        title, height = f"At a pitch of {found.pitch:.6f} m benches {first} and {second} just touch", TOP + LAST
    aim = f"handle 0 reaches the circle of {found.radius:g} m from turn {found.march.turns:g}"
    figure = page(8.0, height, title, f"the smallest pitch at which {aim} without a collision")
    _over_pitch(panel(figure, 0.85, height - 3.85, 3.4, 2.6), found)
    _surroundings(panel(figure, 4.75, height - 4.1, 2.95, 2.95), found)
    if found.benches is not None:
        _last_of_way(panel(figure, 0.85, 0.65, 6.85, 2.6), found)
    return figure


def _over_pitch(axes: Axes, found: MinPitch) -> None:
    """The smallest gap on the way over the pitch."""
    known = found.map
    axes.set_title("smallest gap on the way, mm", loc="left", size=11.5, color=QUIET, pad=10)
    axes.axhline(0.0, color=QUIET, lw=0.8)
    axes.plot(known.pitches, MM * known.gaps, "o-", color=BLUE, lw=2.0, ms=3, gid="gap-over-pitch")
    gap = 0.0 if found.benches is not None else MM * float(known.gaps[0])
    axes.plot(found.pitch, gap, "o", color=COLOURS.contact, ms=7, zorder=4, gid="answer")
    aside: dict[str, Any] = {"offset": (8, -8), "ha": "left", "va": "top"}
    if found.pitch > known.pitches.mean():
        aside = {"offset": (-8, 8), "ha": "right", "va": "bottom"}
    label(axes, found.pitch, gap, f"{found.pitch:.9f} m", color=COLOURS.contact, **aside)
    low, high = axes.get_ylim()
    if known.gaps[0] < 0:
        axes.axhspan(low, 0.0, color=FAINT, lw=0, zorder=0)
        axes.annotate("benches overlap", (0.97, 0.05), xycoords="axes fraction", ha="right", color=QUIET)
    axes.set_ylim(low, high)
    axes.set_xlabel("pitch (m)")
    axes.margins(x=0.03)


def _surroundings(axes: Axes, found: MinPitch) -> None:
    """The benches around the head as two touch."""
    march, turn = found.march, np.linspace(0, 2 * np.pi, LINE_POINTS)
    dragon = march.dragon
    poses = march.at(march.time(found.way)).poses[0]
    x, y, _ = poses[0].tolist()
    half = CLOSE_UP * float(dragon.lengths[0]) / 2
    axes.set_aspect("equal")
    axes.set_xlim(x - half, x + half)
    axes.set_ylim(y - half, y + half)
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set(visible=True, color=RULE)
    axes.plot(
        found.radius * np.cos(turn),
        found.radius * np.sin(turn),
        color=COLOURS.motion,
        lw=1.2,
        ls=(0, (5, 3)),
        gid="circle",
    )
    for bench, outline in reversed(list(enumerate(dragon.outlines(poses)))):
        if np.hypot(*(outline.mean(axis=0) - (x, y))) > 2 * half:
            continue
        touches = bench in (found.benches or ())
        colour = COLOURS.contact if touches else COLOURS.ink
        axes.fill(
            *outline.T,
            fc=COLOURS.background,
            ec=colour,
            lw=2.0 if touches else 1.1,
            zorder=3 + touches,
            gid=f"bench-{bench}",
        )
        middle = poses[bench, :2]
        if np.abs(middle - (x, y)).max() < 0.95 * half:
            across, up = middle.tolist()
            axes.text(across, up, str(bench), color=colour, ha="center", va="center", zorder=5, path_effects=halo())
    note: dict[str, Any] = {"color": COLOURS.motion, "zorder": 6, "path_effects": halo()}
    axes.annotate("dashed: the circle", (0.04, 0.05), xycoords="axes fraction", **note)
    if found.point is not None:
        axes.plot(*found.point, "o", color=COLOURS.contact, ms=5, zorder=6)


def _last_of_way(axes: Axes, found: MinPitch) -> None:
    """The head's gap on the last of its way at the pitch found."""
    march = found.march
    shown = LAST_LENGTHS * float(march.dragon.lengths[0])
    since, time, end = march.time([max(0.0, found.way_in - shown), found.way, found.way_in]).tolist()
    axes.set_title(
        "the head's gap on the last of the way at that pitch, mm", loc="left", size=11.5, color=QUIET, pad=10
    )
    times = np.linspace(since, end, GAP_MOMENTS)
    if since < time:
        times = np.unique([*times, time])
    gap_line(axes, march, times, "last-gap")
    logarithmic(axes, LEAST_GAP, MOST_GAP)
    axes.set_xlim(since, end)
    axes.set_xlabel("time (s); the head arrives at the end")
    if found.benches is not None and time > since:
        label(
            axes,
            time,
            LEAST_GAP,
            f"touch at {time:.4f} s",
            (-12, 6),
            ha="right",
            va="bottom",
            color=COLOURS.contact,
        )
