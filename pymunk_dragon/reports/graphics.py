"""Graphics of a report: stills of the run as PNG data, and the geometry of the charts.

Horizontal coordinates of charts are percentages of the width. Charts then scale with the page, and text keeps its size.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import text
from pymunk_dragon.drawing import Camera, Film, still_png
from pymunk_dragon.model.contact import ContactWindow
from pymunk_dragon.reports.summary import Summary
from pymunk_dragon.reports.tables import format_pair

# Pixels: width and height of a still, twice the displayed size for screens with a pixel ratio of two.
STILL_SIZE = 880
# m: least width of the close-up around the head.
CLOSE_SPAN = 6.0
# Ratio of the close-up's half width to the distance of the contact from the head: keeps the contact of an unguided run,
# which may be far from the head, within the picture.
CLOSE_MARGIN = 1.5
# Ticks of an axis: labels of ten characters that fit side by side on a phone.
MAX_TICKS = 5
# Pairs in a timeline: more rows are hard to read in a chart. The table and the other formats have all pairs.
MAX_PAIRS = 40
# Percent of the chart's width: windows of a pair with a smaller gap are drawn as one bar, since the gap is not visible.
MIN_GAP = 0.05
# Fraction of the time range that a timeline shows before the first window.
LEADING_MARGIN = 0.03
# Points of a line: more than twice the number of pixels on a phone, in a file that is still short.
MAX_POINTS = 800
# Side of the SVG view box of a line, in user units; the page scales the view box to the chart.
VIEW_BOX = 1000.0
# Ratio of the top of a drift chart to the largest value: keeps the line and the topmost level within the chart.
TOP_MARGIN = 1.05
# (smallest value in m, units per metre, unit): mm from 0.01 mm on, since 0.01 mm is easier to read than 10 micrometres.
UNITS = ((1.0, 1.0, "m"), (1e-5, 1e3, "mm"), (0.0, 1e6, "\u00b5m"))


class Tick(NamedTuple):
    """A tick at `at` percent of an axis."""

    at: float
    label: str


class Bar(NamedTuple):
    """A contact window: `at` and `width` in percent; `open` if the window had not ended with the run."""

    at: float
    width: float
    open: bool
    label: str


class Timeline(NamedTuple):
    """Contact windows over time: bars by the label of the pair; `hidden` pairs are omitted."""

    rows: dict[str, list[Bar]]
    ticks: list[Tick]
    hidden: int

    @property
    def unfinished(self) -> bool:
        """Whether two benches were still in contact when the run ended."""
        return any(bar.open for bars in self.rows.values() for bar in bars)


class Line(NamedTuple):
    """A line as points of SVG polylines in a view box of `VIEW_BOX`, a polyline for each segment of known values."""

    name: str
    kind: str
    segments: list[str]


class DriftChart(NamedTuple):
    """Position error over time: lines, ticks of the time axis, and levels of the error in `unit`."""

    lines: list[Line]
    ticks: list[Tick]
    levels: list[Tick]
    unit: str


def stills(summary: Summary) -> list[tuple[str, bytes]]:
    """Captions and PNG data of a close-up of the first contact, if any, and of the whole dragon then or at the end."""
    run, first = summary.run, summary.run.first_contact
    if first is None:
        end = float(run.times[-1])
        return [(text("The whole dragon at {time} s").format(time=f"{end:.2f}"), still_png(run, end, _film(Camera())))]
    time = float(np.clip(first.time, run.times[0], run.times[-1]))
    distance = float(np.max(np.abs(np.array(first.point) - run.poses_at(time)[0, 0, :2])))
    close = Camera(follow="head", span=max(CLOSE_SPAN, 2 * CLOSE_MARGIN * distance))
    return [
        (text("Benches {pair} touch").format(pair=format_pair(first.benches)), still_png(run, time, _film(close))),
        (text("The whole dragon at that time"), still_png(run, time, _film(Camera()))),
    ]


def ticks(low: float, high: float, most: int = MAX_TICKS) -> list[float]:
    """At most `most` evenly spaced round numbers from `low` to `high`."""
    if not high > low:
        return [low]
    rough = (high - low) / most
    decade = 10.0 ** math.floor(math.log10(rough))
    for step in (decade, 2 * decade, 5 * decade, 10 * decade):
        first, last = math.ceil(low / step), math.floor(high / step)
        if last - first < most:
            break
    return [i * step for i in range(first, last + 1)]


def timeline(summary: Summary) -> Timeline | None:
    """Timeline of the contact windows; None if no window has a known duration, as in a run that ended at a contact."""
    pairs: dict[tuple[int, int], list[ContactWindow]] = {}
    for window in summary.windows:
        if math.isfinite(window.begin):
            pairs.setdefault(window.benches, []).append(window)
    end = float(summary.run.times[-1])
    found = [window for windows in pairs.values() for window in windows]
    begin = min((window.begin for window in found), default=end)
    high = max([end, *(_end(window, end) for window in found)])
    if not high > begin:
        return None
    low = begin - LEADING_MARGIN * (high - begin)
    shown = list(pairs.items())[:MAX_PAIRS]
    rows = {f"{i} \u00b7 {j}": _bars(windows, low, high) for (i, j), windows in shown}
    return Timeline(rows, _ticks(low, high), len(pairs) - len(rows))


def drift_chart(summary: Summary) -> DriftChart | None:
    """Largest position error over time; None if there is no error, or only one time."""
    drift = summary.drift
    begin, end = drift.times[[0, -1]].tolist()
    if not (drift.max > 0 and end > begin):
        return None
    scale, unit = next((scale, unit) for least, scale, unit in UNITS if drift.max >= least)
    top = TOP_MARGIN * drift.max * scale
    levels = [Tick(100 - 100 * level / top, f"{level:.6g}") for level in ticks(0.0, drift.max * scale)]
    lines = [Line(text("any bench"), "any", _segments(drift.times, drift.max_over_time, top / scale))]
    if drift.head_benches < summary.run.march.dragon.benches:
        head = _segments(drift.times, drift.head_over_time, top / scale)
        lines.append(Line(text("first {count} benches").format(count=drift.head_benches), "head", head))
    return DriftChart(lines, _ticks(begin, end), levels, unit)


def _film(camera: Camera) -> Film:
    return Film(size=STILL_SIZE, camera=camera, gap=False)


def _bars(windows: Sequence[ContactWindow], low: float, high: float) -> list[Bar]:
    """Bars of a pair's windows; windows with gaps below `MIN_GAP` are merged."""
    merged: list[list[ContactWindow]] = []
    for window in windows:
        if merged and _percent(window.begin - _end(merged[-1][-1], high), 0, high - low) < MIN_GAP:
            merged[-1].append(window)
        else:
            merged.append([window])
    return [_bar(group, low, high) for group in merged]


def _bar(windows: Sequence[ContactWindow], low: float, high: float) -> Bar:
    begin, end = windows[0].begin, max(_end(windows[-1], high), windows[0].begin)
    unfinished = windows[-1].end is None
    one = text("benches {pair}: {begin} to {end}")
    label = (one if len(windows) == 1 else text("benches {pair}: {count} contacts from {begin} to {end}")).format(
        pair=format_pair(windows[0].benches),
        count=len(windows),
        begin=f"{begin:.4f} s",
        end=text("the end") if unfinished else f"{end:.4f} s",
    )
    at = _percent(begin, low, high)
    return Bar(at, round(_percent(end, low, high) - at, 3), unfinished, label)


def _end(window: ContactWindow, high: float) -> float:
    return window.end if window.end is not None and math.isfinite(window.end) else high


def _segments(times: Array, values: Array, top: float) -> list[str]:
    """Points of polylines, interrupted at unknown values."""
    segments: list[list[str]] = [[]]
    for time, value in zip(*_downsampled(times, values), strict=True):
        if math.isfinite(value):
            x = _percent(time, times[0], times[-1]) * VIEW_BOX / 100
            segments[-1].append(f"{x:.1f},{VIEW_BOX * (1 - value / top):.1f}")
        else:
            segments.append([])
    return [" ".join(points) for points in segments if points]


def _downsampled(times: Array, values: Array) -> tuple[Array, Array]:
    """At most `MAX_POINTS` points: the largest known value of each time interval, so that peaks are kept."""
    size = math.ceil(len(times) / MAX_POINTS)
    known = np.where(np.isfinite(values), values, -np.inf)
    chosen = [begin + int(np.argmax(known[begin : begin + size])) for begin in range(0, len(times), size)]
    return times[chosen], values[chosen]


def _ticks(low: float, high: float) -> list[Tick]:
    return [Tick(_percent(time, low, high), f"{time:.9g}") for time in ticks(low, high)]


def _percent(value: float, low: float, high: float) -> float:
    """Position of `value` between `low` and `high`, percent."""
    return round(100 * float(value - low) / float(high - low), 3)
