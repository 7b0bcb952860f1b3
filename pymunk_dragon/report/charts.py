"""Where the lines and bars of a report's charts go.

Along a chart everything is measured in hundredths of its width, so that a page draws it as wide as there is room,
with type that keeps its size.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pymunk_dragon.report.tables import pair

__all__ = ["Bar", "DriftChart", "Line", "Row", "Tick", "Timeline", "drift_chart", "ticks", "timeline"]

Contents = Mapping[str, Any]

# Ticks along a chart: as many labels of ten characters as a phone has room for.
MOST_TICKS = 5
# Pairs in a timeline: as many lines as one can still follow. The table and the other formats have all of them.
MAX_ROWS = 40
# Hundredths of the width under which two windows of a pair run into each other anyway.
MIN_BREAK = 0.05
# Share of the time that a timeline shows before the first window.
LEAD = 0.03
# Points of a line: more than twice as many as there are pixels on a phone, and still a short file.
MAX_POINTS = 800
# The side of the square that a line is drawn in; it has no unit, and is stretched to the chart.
SQUARE = 1000.0
# Metres of drift from which on a unit of so many in a metre is used: 0.01 mm is better read than 10 micrometres.
UNITS = ((1.0, 1.0, "m"), (1e-5, 1e3, "mm"), (0.0, 1e6, "\N{MICRO SIGN}m"))


@dataclass(frozen=True)
class Tick:
    """A mark: `at` hundredths of the way along an axis."""

    at: float
    label: str


@dataclass(frozen=True)
class Bar:
    """A window: `at` and `width` in hundredths; `open` where it had not ended."""

    at: float
    width: float
    open: bool
    label: str


@dataclass(frozen=True)
class Row:
    """The windows of a pair of benches."""

    label: str
    bars: tuple[Bar, ...]


@dataclass(frozen=True)
class Timeline:
    """Windows over time.

    Attributes
    ----------
    rows : tuple of Row
        A line for each pair.
    ticks : tuple of Tick
        Times.
    hidden : int
        Number of pairs that are left out.
    """

    rows: tuple[Row, ...]
    ticks: tuple[Tick, ...]
    hidden: int

    @property
    def unfinished(self) -> bool:
        """Whether two benches still touched when the run ended."""
        return any(bar.open for row in self.rows for bar in row.bars)


@dataclass(frozen=True)
class Line:
    """A line as the points of SVG polylines in a square of `SQUARE`, one for every stretch without a hole."""

    name: str
    kind: str
    stretches: tuple[str, ...]


@dataclass(frozen=True)
class DriftChart:
    """Drift over time."""

    lines: tuple[Line, ...]
    ticks: tuple[Tick, ...]
    levels: tuple[Tick, ...]
    unit: str


def ticks(low: float, high: float, most: int = MOST_TICKS) -> tuple[float, ...]:
    """At most `most` round numbers from `low` to `high`, evenly apart."""
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
    """When which pair touched; None where no window is known to have lasted, as in a run that a contact ended."""
    windows = [window for window in contents["windows"] if window["begin"] is not None]
    if not windows:
        return None
    begin = min(window["begin"] for window in windows)
    high = max([contents["outcome"]["until"], *(w["end"] for w in windows if w["end"] is not None)])
    if not high > begin:
        return None
    low = begin - LEAD * (high - begin)
    pairs: dict[tuple[int, ...], list[Contents]] = {}
    for window in windows:
        pairs.setdefault(tuple(window["benches"]), []).append(window)
    rows = [Row(f"{i} \N{MIDDLE DOT} {j}", _bars(found, low, high)) for (i, j), found in pairs.items()]
    return Timeline(tuple(rows[:MAX_ROWS]), _ticks(low, high), max(0, len(rows) - MAX_ROWS))


def drift_chart(contents: Contents) -> DriftChart | None:
    """The worst drift over time; None where there is nothing to draw."""
    drift = contents["drift"]
    times, largest = drift["times"], drift["max"]
    if not largest or not times[-1] > times[0]:
        return None
    scale, unit = next((scale, unit) for least, scale, unit in UNITS if largest >= least)
    levels = ticks(0.0, largest * scale)
    # The line ends within the chart, and the topmost level is not above it.
    top = largest * scale * 1.05
    series = [("any bench", "any", drift["max_over_time"])]
    if drift["head_benches"] < contents["scenario"]["benches"]:
        series.append((f"first {drift['head_benches']} benches", "head", drift["head_over_time"]))
    lines = [Line(name, kind, _stretches(times, values, top / scale)) for name, kind, values in series]
    return DriftChart(
        tuple(lines),
        _ticks(times[0], times[-1]),
        tuple(Tick(100 - 100 * level / top, f"{level:.6g}") for level in levels),
        unit,
    )


def _bars(windows: Sequence[Contents], low: float, high: float) -> tuple[Bar, ...]:
    """Bars of a pair's windows, one for all between which no eye could see a break."""
    bars: list[list[Contents]] = []
    for window in windows:
        if bars and _share(window["begin"] - _end(bars[-1][-1], high), 0, high - low) < MIN_BREAK:
            bars[-1].append(window)
        else:
            bars.append([window])
    return tuple(_bar(merged, low, high) for merged in bars)


def _bar(windows: Sequence[Contents], low: float, high: float) -> Bar:
    first, last = windows[0], windows[-1]
    begin, end = first["begin"], max(_end(last, high), first["begin"])
    still = last["end"] is None
    label = f"{begin:.4f} s to {'the end' if still else f'{end:.4f} s'}"
    if len(windows) > 1:
        label = f"{len(windows)} contacts from {label}"
    at = _share(begin, low, high)
    return Bar(at, round(_share(end, low, high) - at, 3), still, f"benches {pair(first['benches'])}: {label}")


def _end(window: Contents, high: float) -> float:
    end: float | None = window["end"]
    return high if end is None else end


def _stretches(times: Sequence[float], values: Sequence[float | None], top: float) -> tuple[str, ...]:
    """Points of polylines, broken where a value is not known."""
    stretches: list[list[str]] = [[]]
    for time, value in _thinned(times, values):
        if value is None:
            stretches.append([])
        else:
            x = _share(time, times[0], times[-1]) * SQUARE / 100
            stretches[-1].append(f"{x:.1f},{SQUARE * (1 - value / top):.1f}")
    return tuple(" ".join(points) for points in stretches if points)


def _thinned(times: Sequence[float], values: Sequence[float | None]) -> list[tuple[float, float | None]]:
    """At most `MAX_POINTS` points, of each stretch of time the one with the largest value: no peak is lost."""
    size = math.ceil(len(times) / MAX_POINTS)
    thinned = []
    for begin in range(0, len(times), size):
        chunk = range(begin, min(begin + size, len(times)))
        known = [i for i in chunk if values[i] is not None]
        most = max(known, key=lambda i: values[i] or 0.0) if known else begin
        thinned.append((times[most], values[most]))
    return thinned


def _ticks(low: float, high: float) -> tuple[Tick, ...]:
    return tuple(Tick(_share(time, low, high), f"{time:.9g}") for time in ticks(low, high))


def _share(value: float, low: float, high: float) -> float:
    return round(100 * (value - low) / (high - low), 3)
