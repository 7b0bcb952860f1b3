"""Geometry of a report's charts: the timeline of contact windows, and drift over time.

Horizontal coordinates are percentages of the chart's width. Charts then scale with the page, while text keeps its size.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pymunk_dragon.reports.tables import format_pair

__all__ = ["Bar", "DriftChart", "Line", "Row", "Tick", "Timeline", "drift_chart", "ticks", "timeline"]

Contents = Mapping[str, Any]

# Ticks of an axis: labels of ten characters that fit side by side on a phone.
MAX_TICKS = 5
# Pairs in a timeline: more rows are hard to read in a chart. The table and the other formats have all pairs.
MAX_ROWS = 40
# Percent of the chart's width: windows of a pair with a smaller gap are drawn as one bar, since the gap is not visible.
MIN_GAP = 0.05
# Fraction of the time range that a timeline shows before the first window.
LEADING_MARGIN = 0.03
# Points of a line: more than twice the number of pixels on a phone, in a file that is still short.
MAX_POINTS = 800
# Side of the SVG view box of a line, in user units; the page scales the view box to the chart.
VIEW_BOX = 1000.0
# (smallest drift in m, units per metre, unit): mm from 0.01 mm on, since 0.01 mm is easier to read than 10 micrometres.
UNITS = ((1.0, 1.0, "m"), (1e-5, 1e3, "mm"), (0.0, 1e6, "\N{MICRO SIGN}m"))


@dataclass(frozen=True)
class Tick:
    """A tick at `at` percent of an axis."""

    at: float
    label: str


@dataclass(frozen=True)
class Bar:
    """A contact window: `at` and `width` in percent; `open` if the window had not ended with the run."""

    at: float
    width: float
    open: bool
    label: str


@dataclass(frozen=True)
class Row:
    """Contact windows of a pair of benches."""

    label: str
    bars: tuple[Bar, ...]


@dataclass(frozen=True)
class Timeline:
    """Contact windows over time.

    Attributes
    ----------
    rows : tuple of Row
        One for each pair.
    ticks : tuple of Tick
        Ticks of the time axis.
    hidden : int
        Number of pairs that are omitted.
    """

    rows: tuple[Row, ...]
    ticks: tuple[Tick, ...]
    hidden: int

    @property
    def unfinished(self) -> bool:
        """Whether two benches were still in contact when the run ended."""
        return any(bar.open for row in self.rows for bar in row.bars)


@dataclass(frozen=True)
class Line:
    """A line as points of SVG polylines in a view box of `VIEW_BOX`, a polyline for each segment of known values."""

    name: str
    kind: str
    segments: tuple[str, ...]


@dataclass(frozen=True)
class DriftChart:
    """Drift over time: lines, ticks of the time axis, and levels of drift in `unit`."""

    lines: tuple[Line, ...]
    ticks: tuple[Tick, ...]
    levels: tuple[Tick, ...]
    unit: str


def ticks(low: float, high: float, most: int = MAX_TICKS) -> tuple[float, ...]:
    """At most `most` evenly spaced round numbers from `low` to `high`."""
    if not high > low:
        return (low,)
    rough = (high - low) / most
    decade = 10.0 ** math.floor(math.log10(rough))
    for step in (decade, 2 * decade, 5 * decade, 10 * decade):
        first, last = math.ceil(low / step), math.floor(high / step)
        if last - first < most:
            break
    return tuple(i * step for i in range(first, last + 1))


def timeline(contents: Contents) -> Timeline | None:
    """Timeline of the contact windows; None if no window has a known duration, as in a run that ended at a contact."""
    windows = [window for window in contents["windows"] if window["begin"] is not None]
    if not windows:
        return None
    begin = min(window["begin"] for window in windows)
    high = max([contents["outcome"]["until"], *(w["end"] for w in windows if w["end"] is not None)])
    if not high > begin:
        return None
    low = begin - LEADING_MARGIN * (high - begin)
    pairs: dict[tuple[int, ...], list[Contents]] = {}
    for window in windows:
        pairs.setdefault(tuple(window["benches"]), []).append(window)
    rows = [Row(f"{i} \N{MIDDLE DOT} {j}", _bars(found, low, high)) for (i, j), found in pairs.items()]
    return Timeline(tuple(rows[:MAX_ROWS]), _ticks(low, high), max(0, len(rows) - MAX_ROWS))


def drift_chart(contents: Contents) -> DriftChart | None:
    """Largest drift over time; None if there is no drift, or only one time."""
    drift = contents["drift"]
    times, largest = drift["times"], drift["max"]
    if not largest or not times[-1] > times[0]:
        return None
    scale, unit = next((scale, unit) for least, scale, unit in UNITS if largest >= least)
    levels = ticks(0.0, largest * scale)
    # A margin of 5 % keeps the line and the topmost level within the chart.
    top = largest * scale * 1.05
    series = [("any bench", "any", drift["max_over_time"])]
    if drift["head_benches"] < contents["scenario"]["benches"]:
        series.append((f"first {drift['head_benches']} benches", "head", drift["head_over_time"]))
    lines = [Line(name, kind, _segments(times, values, top / scale)) for name, kind, values in series]
    return DriftChart(
        tuple(lines),
        _ticks(times[0], times[-1]),
        tuple(Tick(100 - 100 * level / top, f"{level:.6g}") for level in levels),
        unit,
    )


def _bars(windows: Sequence[Contents], low: float, high: float) -> tuple[Bar, ...]:
    """Bars of a pair's windows; windows with gaps below `MIN_GAP` are merged."""
    bars: list[list[Contents]] = []
    for window in windows:
        if bars and _percent(window["begin"] - _end(bars[-1][-1], high), 0, high - low) < MIN_GAP:
            bars[-1].append(window)
        else:
            bars.append([window])
    return tuple(_bar(merged, low, high) for merged in bars)


def _bar(windows: Sequence[Contents], low: float, high: float) -> Bar:
    first, last = windows[0], windows[-1]
    begin, end = first["begin"], max(_end(last, high), first["begin"])
    unfinished = last["end"] is None
    label = f"{begin:.4f} s to {'the end' if unfinished else f'{end:.4f} s'}"
    if len(windows) > 1:
        label = f"{len(windows)} contacts from {label}"
    at = _percent(begin, low, high)
    return Bar(
        at, round(_percent(end, low, high) - at, 3), unfinished, f"benches {format_pair(first['benches'])}: {label}"
    )


def _end(window: Contents, high: float) -> float:
    end: float | None = window["end"]
    return high if end is None else end


def _segments(times: Sequence[float], values: Sequence[float | None], top: float) -> tuple[str, ...]:
    """Points of polylines, interrupted at unknown values."""
    segments: list[list[str]] = [[]]
    for time, value in _downsampled(times, values):
        if value is None:
            segments.append([])
        else:
            x = _percent(time, times[0], times[-1]) * VIEW_BOX / 100
            segments[-1].append(f"{x:.1f},{VIEW_BOX * (1 - value / top):.1f}")
    return tuple(" ".join(points) for points in segments if points)


def _downsampled(times: Sequence[float], values: Sequence[float | None]) -> list[tuple[float, float | None]]:
    """At most `MAX_POINTS` points: the largest value of each time interval, so that peaks are kept."""
    size = math.ceil(len(times) / MAX_POINTS)
    samples = []
    for begin in range(0, len(times), size):
        chunk = range(begin, min(begin + size, len(times)))
        known = [i for i in chunk if values[i] is not None]
        largest = max(known, key=lambda i: values[i] or 0.0) if known else begin
        samples.append((times[largest], values[largest]))
    return samples


def _ticks(low: float, high: float) -> tuple[Tick, ...]:
    return tuple(Tick(_percent(time, low, high), f"{time:.9g}") for time in ticks(low, high))


def _percent(value: float, low: float, high: float) -> float:
    """Position of `value` between `low` and `high`, percent."""
    return round(100 * (value - low) / (high - low), 3)
