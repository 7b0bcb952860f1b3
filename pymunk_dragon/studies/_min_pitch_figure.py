"""The figure of the smallest pitch."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._language import text
from pymunk_dragon.drawing.figures.charts import MM, gap_line
from pymunk_dragon.drawing.figures.lines import label, label_in_room, logarithmic
from pymunk_dragon.drawing.figures.room import Room
from pymunk_dragon.drawing.figures.style import BLUE, COLOURS, FAINT, QUIET, SMALL, halo, panel, slide
from pymunk_dragon.studies._figures import circle, heading, square

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pymunk_dragon.studies.min_pitch import MinPitch

# Distance in head lengths that the head travels while the gap over time is shown.
CLOSE_UP_LENGTHS = 14.0
# Times at which gaps are sampled.
GAP_SAMPLES = 1200
# Ends of the scale of gaps, mm.
GAP_SCALE = (0.1, 400.0)
# Offsets of the label of the contact, points.
TOUCH_OFFSETS = [(side * x, y) for side in (-1, 1) for x in (60.0, 70.0, 80.0) for y in (9.0, 14.0)]
# Width of the view of the contact in head lengths.
VIEW_LENGTHS = 1.35
# Points of the circle.
CIRCLE_POINTS = 600


def draw(found: MinPitch) -> Figure:
    """Draw the gap over the pitch, the contact of two benches, and the head's gap over time."""
    title = text("At a pitch of {:.6f} m the head starts on the circle itself").format(found.pitch)
    if found.benches is not None:
        title = text("At a pitch of {:.6f} m benches {} and {} just touch").format(found.pitch, *found.benches)
    aim = text("the smallest pitch at which handle 0 reaches the circle of {:g} m from turn {:g} without a contact")
    figure = slide(title, aim.format(found.radius, found.turns))
    _draw_contact(panel(figure, 4.5, 0.2, 3.25, 3.25), found)
    if found.benches is None:
        _draw_gap_over_pitch(panel(figure, 0.85, 0.65, 3.3, 2.65), found)
        return figure
    _draw_gap_over_pitch(panel(figure, 0.85, 2.3, 3.3, 1.05), found)
    _draw_gap_over_time(panel(figure, 0.85, 0.6, 3.3, 0.9), found)
    return figure


def _draw_gap_over_pitch(axes: Axes, found: MinPitch) -> None:
    """Draw the smallest gap of a march over the pitch."""
    known = found.map
    heading(axes, text("smallest gap before the circle, mm"))
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
        axes.annotate(text("benches overlap"), (0.97, 0.05), xycoords="axes fraction", ha="right", color=QUIET)
    axes.set_ylim(low, high)
    axes.set_xlabel(text("pitch (m)"))
    axes.margins(x=0.03)


def _draw_contact(axes: Axes, found: MinPitch) -> None:
    """Draw the benches around the head at the contact."""
    dragon = found.march.dragon
    poses = found.march.at(found.march.time(found.distance)).poses[0]
    x, y, _ = poses[0].tolist()
    half = VIEW_LENGTHS * float(dragon.lengths[0]) / 2
    square(axes, half, x, y)
    circle(axes, found.radius, 1.2, CIRCLE_POINTS)
    for bench, outline in reversed(list(enumerate(dragon.outlines(poses)))):
        if np.hypot(*(outline.mean(axis=0) - (x, y))) > 2 * half:
            continue
        touches = bench in (found.benches or ())
        colour = COLOURS.contact if touches else COLOURS.ink
        style: dict[str, Any] = {"lw": 2.0 if touches else 1.1, "zorder": 3 + touches, "gid": f"bench-{bench}"}
        axes.fill(*outline.T, fc=COLOURS.background, ec=colour, **style)
        middle = poses[bench, :2]
        if np.abs(middle - (x, y)).max() < 0.95 * half:
            across, up = middle.tolist()
            number: dict[str, Any] = {"color": colour, "size": SMALL, "ha": "center", "va": "center"}
            axes.text(across, up, str(bench), **number, zorder=5, path_effects=halo())
    note: dict[str, Any] = {"color": COLOURS.motion, "zorder": 6, "path_effects": halo()}
    axes.annotate(text("dashed: the circle"), (0.04, 0.05), xycoords="axes fraction", **note)
    if found.point is not None:
        axes.plot(*found.point, "o", color=COLOURS.contact, ms=5, zorder=6)


def _draw_gap_over_time(axes: Axes, found: MinPitch) -> None:
    """Draw the head's gap at the end of the march at the smallest pitch."""
    march = found.march
    shown = CLOSE_UP_LENGTHS * float(march.dragon.lengths[0])
    arrival = found.arrival_distance
    since, time, end = march.time([max(0.0, arrival - shown), found.distance, arrival]).tolist()
    heading(axes, text("gap of the head at that pitch, mm"))
    times = np.linspace(since, end, GAP_SAMPLES)
    if since < time:
        times = np.unique([*times, time])
    gap_line(axes, march, times, "last-gap")
    logarithmic(axes, *GAP_SCALE)
    axes.set_xlim(since, end)
    axes.set_xlabel(text("time (s); the head arrives at the end"))
    if found.benches is not None and time > since:
        room = Room(axes)
        room.take_lines()
        note = text("touch at {:.4f} s").format(time)
        label_in_room(axes, room, np.array([[time, GAP_SCALE[0]]]), note, TOUCH_OFFSETS, color=COLOURS.contact)
