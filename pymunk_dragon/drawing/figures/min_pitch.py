"""Figure of the smallest pitch: the gap over the pitch, the contact of two benches, and the head's gap over time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon.drawing.figures.charts import MM, gap_line
from pymunk_dragon.drawing.figures.lines import label, logarithmic
from pymunk_dragon.drawing.figures.style import BLUE, COLOURS, FAINT, QUIET, RULE, halo, page, panel
from pymunk_dragon.studies import MinPitch

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["min_pitch"]

# Head lengths: the gap over time is shown while the head travels this distance.
CLOSE_UP_LENGTHS = 14.0
# Times at which gaps are sampled.
GAP_SAMPLES = 1200
# mm: lower end of the scale of gaps.
MIN_GAP = 0.1
# mm: upper end of the scale of gaps.
MAX_GAP = 400.0
# Inches: height of the page without the gap over time.
UPPER_HEIGHT = 4.4
# Inches: height of the gap over time.
LOWER_HEIGHT = 3.9
# Head lengths: width of the view of the contact.
VIEW_LENGTHS = 1.35
# Points of the circle: enough to appear round.
CIRCLE_POINTS = 600


def min_pitch(found: MinPitch) -> Figure:
    """Draw the result of the study `min_pitch`."""
    title, height = f"At a pitch of {found.pitch:.6f} m the head starts on the circle itself", UPPER_HEIGHT
    if found.benches is not None:
        first, second = found.benches
        title, height = (
            f"At a pitch of {found.pitch:.6f} m benches {first} and {second} just touch",
            UPPER_HEIGHT + LOWER_HEIGHT,
        )
    aim = f"handle 0 reaches the circle of {found.radius:g} m from turn {found.march.turns:g}"
    figure = page(8.0, height, title, f"the smallest pitch at which {aim} without a collision")
    _draw_gap_over_pitch(panel(figure, 0.85, height - 3.85, 3.4, 2.6), found)
    _draw_contact(panel(figure, 4.75, height - 4.1, 2.95, 2.95), found)
    if found.benches is not None:
        _draw_gap_over_time(panel(figure, 0.85, 0.65, 6.85, 2.6), found)
    return figure


def _draw_gap_over_pitch(axes: Axes, found: MinPitch) -> None:
    """Draw the smallest gap of a march over the pitch."""
    known = found.map
    axes.set_title("smallest gap on the way, mm", loc="left", size=11.5, color=QUIET, pad=10)
    axes.axhline(0.0, color=QUIET, lw=0.8)
    axes.plot(known.pitches, MM * known.gaps, "o-", color=BLUE, lw=2.0, ms=3, gid="gap-over-pitch")
    gap = 0.0 if found.benches is not None else MM * float(known.gaps[0])
    axes.plot(found.pitch, gap, "o", color=COLOURS.contact, ms=7, zorder=4, gid="answer")
    label_position: dict[str, Any] = {"offset": (8, -8), "ha": "left", "va": "top"}
    if found.pitch > known.pitches.mean():
        label_position = {"offset": (-8, 8), "ha": "right", "va": "bottom"}
    label(axes, found.pitch, gap, f"{found.pitch:.9f} m", color=COLOURS.contact, **label_position)
    low, high = axes.get_ylim()
    if known.gaps[0] < 0:
        axes.axhspan(low, 0.0, color=FAINT, lw=0, zorder=0)
        axes.annotate("benches overlap", (0.97, 0.05), xycoords="axes fraction", ha="right", color=QUIET)
    axes.set_ylim(low, high)
    axes.set_xlabel("pitch (m)")
    axes.margins(x=0.03)


def _draw_contact(axes: Axes, found: MinPitch) -> None:
    """Draw the benches around the head at the contact."""
    march, turn = found.march, np.linspace(0, 2 * np.pi, CIRCLE_POINTS)
    dragon = march.dragon
    poses = march.at(march.time(found.way)).poses[0]
    x, y, _ = poses[0].tolist()
    half = VIEW_LENGTHS * float(dragon.lengths[0]) / 2
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


def _draw_gap_over_time(axes: Axes, found: MinPitch) -> None:
    """Draw the head's gap at the end of the march at the smallest pitch."""
    march = found.march
    shown = CLOSE_UP_LENGTHS * float(march.dragon.lengths[0])
    since, time, end = march.time([max(0.0, found.way_in - shown), found.way, found.way_in]).tolist()
    axes.set_title(
        "the head's gap on the last of the way at that pitch, mm", loc="left", size=11.5, color=QUIET, pad=10
    )
    times = np.linspace(since, end, GAP_SAMPLES)
    if since < time:
        times = np.unique([*times, time])
    gap_line(axes, march, times, "last-gap")
    logarithmic(axes, MIN_GAP, MAX_GAP)
    axes.set_xlim(since, end)
    axes.set_xlabel("time (s); the head arrives at the end")
    if found.benches is not None and time > since:
        label(
            axes,
            time,
            MIN_GAP,
            f"touch at {time:.4f} s",
            (-12, 6),
            ha="right",
            va="bottom",
            color=COLOURS.contact,
        )
