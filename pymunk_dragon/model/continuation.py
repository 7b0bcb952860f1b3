"""The state of a chain that continuous motion along a curve leads to, jackknifed benches included.

In the notation of `chain.py`, a bench has F(s, r) = (|P(s) - P(r)|^2 - d^2) / 2 = 0, whose
derivatives are A = e . T(s) by s and -B = -e . T(r) by r. While B > 0, r is a smooth function g(s)
with g' = A / B (implicit function theorem): the bench pushes its rear handle back where A < 0
(jackknife), and motion goes on. Motion ends at a fold, B = 0, where the bench is perpendicular to
the path at its rear handle, and where r reaches the curve's begin.

So g depends on s alone, not on the motion that led to s, and the whole chain is a composition of
such functions. Two facts make g certain:

- Where the path is less curved than a circle with the bench as its diameter, over half that
  circle's circumference back (pi / 2 d from s), A and B are positive, and the rear handle is the
  only one within that length: the "gentle" case, in which `Curve.chain` finds it. This is checked
  with the curve's own bound on its curvature.
- Elsewhere g is followed in cells. From a root (s0, r0), and with bounds K_s and K_r on the
  curvature near both handles, |F(s, r0)| <= |A| h + M_s h^2 / 2 for |s - s0| <= h, and B is at
  least B - h - M_r x at |r - r0| = x, where M = 1 + K times the longest distance in the cell. While
  this is positive up to x = p, F changes with r in one direction, and by no less than its integral
  to either side. So if |A| h + M_s h^2 / 2 < p (B - h - M_r p / 2), then for every s of the cell F
  changes sign once and only once within |r - r0| <= p. No other branch can be met, however long the
  step.

Handles that move back and forth may pass the end of the next bench's g and return, although motion
has ended there. What counts is the range of each handle since the start. The image of an interval
under g is known from its ends and from the coordinates between them where A = 0, so these ranges
are followed along the chain as well.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import cached_property
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._arrays import Array, Flags
from pymunk_dragon.model.chain import (
    ChainMotion,
    chain_motion,
    chains,
    gentle_offsets,
    rear_between,
    rear_handle,
)
from pymunk_dragon.model.curves.base import Curve

T = TypeVar("T")

# Share of a spacing: the grid on which the curvature is checked.
_GRID = 0.25
# Share of a spacing: longest half cell in either coordinate.
_WINDOW = 0.125
# Cells of the grid that are checked at once.
_GRID_CELLS = 4096
# Share of the longest step that is proven, to cover its rounding.
_SAFE = 0.9
# Share of a spacing. Shorter steps only approach a fold, whose coordinate is then known to that.
_SHORTEST = 1e-13
# Share of a spacing. Longest step where A may vanish: two reversals in it displace the rear handle
# negligibly.
_REVERSAL = 1e-4
# Points of a cell among which one pass locates A = 0.
_SECTIONS = 17
# Such passes: to 1e-12 of the cell.
_PASSES = 10
# m by which two benches may differ in a state that they share.
_SAME = 1e-9
# Cells after which a strongly curved path is not followed any further.
_MAX_CELLS = 100_000


class Continuation:
    """States of a chain with spacings (N,) that moves continuously from its start.

    There `Curve.chain` has it for `head`, m. No result depends on earlier calls, not even in its
    last digits: the cells that are kept between calls are the same whichever call needs them first,
    and each coordinate is computed from one cell. The other heads of a call, and the number of
    handles, may change the last digits, as Newton's method goes on until all have converged.
    """

    def __init__(self, curve: Curve, head: float, spacings: Array) -> None:
        self._curve = curve
        self._head = head
        self._spacings = spacings
        # States of handles for which `keep` has room: without it, nothing is kept.
        self.room = 0
        self._kept: dict[Hashable, Any] = {}

    @cached_property
    def start(self) -> Array:
        """Coordinates (H,) at the start, m; nan for handles without one and all behind."""
        (handles_s,) = self._curve.chain([self._head], self._spacings)
        return np.asarray(handles_s)

    def motion(self, heads: Array, handles: int) -> ChainMotion:
        """Motion of the foremost handles for heads (T,), m; nan where no motion leads."""
        spacings = self._spacings[: handles - 1]
        direct = self.is_direct(heads, handles)
        if direct.all():
            return chains(self._curve, heads, spacings)

        handles_s = np.empty((heads.size, handles))
        handles_s[direct] = self._curve.chain(heads[direct], spacings)
        handles_s[~direct] = self._followed(heads[~direct], handles)
        return chain_motion(self._curve, handles_s, spacings)

    def is_direct(self, heads: Array, handles: int | None = None) -> Flags:
        """Whether (T,) `Curve.chain` has the foremost handles for heads (T,), m."""
        lows = np.minimum(heads, self._head)
        highs = np.maximum(heads, self._head)
        return self._gentle(lows, highs, self._spacings[: handles and handles - 1])

    def keep(self, key: Hashable, states: int, compute: Callable[[], T]) -> T:
        """The result of `compute`, which the key and this object determine.

        It is kept for later calls while `room`, a number of handles' states, lasts.
        """
        if key in self._kept:
            return cast(T, self._kept[key])
        found = compute()
        if states <= self.room:
            self.room -= states
            self._kept[key] = found
        return found

    def ranges(self, first: Array, last: Array) -> tuple[Array, Array]:
        """Lowest and highest coordinates (T, H) of handles in motion between two states (T, H)."""
        lows = np.minimum(first, last)
        highs = np.maximum(first, last)
        spacings = self._spacings[: first.shape[1] - 1]
        rows = np.flatnonzero(~self._gentle(lows[:, 0], highs[:, 0], spacings))
        if not rows.size:
            return lows, highs

        for i, branch in enumerate(self._branches[: spacings.size]):
            # Chains whose rest is gentle move in one direction.
            gentle = self._gentle(lows[rows, i], highs[rows, i], spacings[i:])
            rest = rows[gentle]
            for ends in (lows, highs):
                ends[rest, i:] = self._curve.chain(ends[rest, i], spacings[i:])
            rows = rows[~gentle]
            if not rows.size:
                break
            # The others are followed through the function of this bench.
            low, high = branch.image(lows[rows, i], highs[rows, i])
            hidden = branch.hidden(lows[rows, i], highs[rows, i])
            lows[rows, i + 1] = low - hidden
            highs[rows, i + 1] = high + hidden
        return lows, highs

    def is_one_function(self, low: float, high: float) -> bool:
        """Whether all benches behind bench 0 are one function for heads from `low` to `high`, m."""
        if len({*self._spacings[1:].tolist()}) > 1:
            return False
        lows = np.array([min(low, self._head)])
        highs = np.array([max(high, self._head)])
        if self._gentle(lows, highs, self._spacings)[0]:
            return True
        return len({id(each) for each in self._branches[1:]}) <= 1

    def _gentle(self, lows: Array, highs: Array, spacings: Array) -> Flags:
        """Whether A and B are positive for benches whose fronts begin in [lows, highs], (T,)."""
        tails = lows - np.pi / 2 * spacings.sum()
        curvature = self._curve.max_curvature(tails, highs)
        return np.asarray(~(curvature * spacings.max(initial=0) >= 2))

    @cached_property
    def _branches(self) -> list[_Branch]:
        """The function of each bench; benches of one spacing that it connects share it."""
        found: dict[int, _Branch] = {}
        rest = np.arange(self._spacings.size)
        while rest.size:
            bench = rest[0]
            spacing = float(self._spacings[bench])
            branch = _Branch(self._curve, spacing, *self.start[bench : bench + 2].tolist())
            others = rest[self._spacings[rest] == spacing]

            fronts = self.start[others]
            branch.cover(fronts.min(), fronts.max())
            rears = self.start[others + 1]
            same = np.abs(branch.rear(fronts) - rears) <= _SAME
            shared = others[same | (others == bench)]
            found |= dict.fromkeys(shared.tolist(), branch)
            rest = np.setdiff1d(rest, shared)
        return [found[bench] for bench in range(self._spacings.size)]

    def _followed(self, heads: Array, handles: int) -> Array:
        """Coordinates (T, handles), computed bench by bench."""
        handles_s = np.full((heads.size, handles), np.nan)
        handles_s[:, 0] = heads
        # Range of the handle since the start.
        lows = np.minimum(heads, self._head)
        highs = np.maximum(heads, self._head)
        spacings = self._spacings[: handles - 1]
        done = np.zeros(heads.size, dtype=bool)

        for i, branch in enumerate(self._branches[: handles - 1]):
            rows = np.flatnonzero(~done & ~np.isnan(handles_s[:, i]))
            gentle = self._gentle(lows[rows], highs[rows], spacings[i:])
            self._fill_rest(handles_s, rows[gentle], i, lows)
            done[rows[gentle]] = True
            rows = rows[~gentle]
            if not rows.size:
                break
            lows[rows], highs[rows] = branch.image(lows[rows], highs[rows])
            rears = branch.rear(handles_s[rows, i])
            lost = np.isnan(lows[rows] + highs[rows])
            handles_s[rows, i + 1] = np.where(lost, np.nan, rears)
        return handles_s

    def _fill_rest(self, handles_s: Array, rows: NDArray[np.intp], i: int, lows: Array) -> None:
        """Compute the handles behind `i` by `Curve.chain`; nan if pushed beyond the begin."""
        fronts = handles_s[rows, i]
        low = lows[rows]
        spacings = self._spacings[i : handles_s.shape[1] - 1]
        handles_s[rows, i:] = self._curve.chain(fronts, spacings)
        lower = np.flatnonzero((low < fronts) & (low < self.start[i]))
        if lower.size:
            lost = np.isnan(self._curve.chain(low[lower], spacings))
            rows = rows[lower]
            handles_s[rows, i:] = np.where(lost, np.nan, handles_s[rows, i:])


class _Branch:
    """Rear handle's coordinate of a bench as a continuous function of the front handle's."""

    def __init__(self, curve: Curve, chord: float, front: float, rear: float) -> None:
        self._curve = curve
        self._chord = chord
        self._start = (front, rear)
        # By direction: the state reached last, None where the function ends, and the cells, each
        # with the coordinate at which it ends and a bracket of the rear handle's. A cell includes
        # the end that is farther from the start: at the other one, the cell before it is known
        # already. So more cells never change what is found.
        self._tips: dict[int, tuple[float, float] | None] = {-1: self._start, 1: self._start}
        self._cells: dict[int, list[tuple[float, float, float]]] = {-1: [], 1: []}
        # Coordinates of both handles at reversals.
        self._reversals: list[tuple[float, float]] = []
        # Fronts between which there may be one, and how far two of them there may move the rear
        # handle, m.
        self._possible_reversals: list[tuple[float, float, float]] = []
        self._join()

    def cover(self, low: float, high: float) -> None:
        """Follow the function to both coordinates of the front handle, or to where it ends."""
        grown = False
        for direction, aim in ((-1, low), (1, high)):
            while (tip := self._tips[direction]) is not None and (aim - tip[0]) * direction > 0:
                self._tips[direction] = self._extended(*tip, direction, aim)
                grown = True
        if grown:
            self._join()

    def rear(self, fronts: Array) -> Array:
        """Coordinates (T,) of the rear handle, m; nan outside of what is covered."""
        edges = self._edges
        # The bracket of the start stands between those of the cells to its left and to its right.
        cells = np.searchsorted(edges, fronts, side="left")
        left = fronts < self._start[0]
        cells[left] = np.searchsorted(edges, fronts[left], side="right") - 1
        inside = (fronts >= edges[0]) & (fronts <= edges[-1])
        low, high = self._brackets[np.clip(cells, 0, len(edges) - 1)].T

        # A gentle cell has no bracket.
        gentle = np.isnan(low)
        shortest, longest, _ = gentle_offsets(self._curve, fronts, self._chord)
        shortest = np.where(gentle, shortest, fronts - high)
        longest = np.where(gentle, longest, fronts - low)
        shortest = np.where(inside, shortest, np.nan)
        return rear_between(self._curve, fronts, self._chord, shortest, longest)

    def image(self, lows: Array, highs: Array) -> tuple[Array, Array]:
        """Lowest and highest rear coordinates (T,) for fronts from `lows` to `highs`.

        They are nan where the function ends.
        """
        self.cover(lows.min(), highs.max())
        ends = self.rear(lows), self.rear(highs)
        low = np.minimum(*ends)
        high = np.maximum(*ends)
        for front_s, rear_s in self._reversals:
            passed = np.where((lows < front_s) & (front_s < highs), rear_s, low)
            low = np.minimum(low, passed)
            high = np.maximum(high, passed)
        return low, high

    def hidden(self, lows: Array, highs: Array) -> Array:
        """How far reversals may move the rear handle for fronts from `lows` to `highs` (T,), m.

        The function has been followed to these.
        """
        found = np.zeros(lows.shape)
        for low, high, hidden in self._possible_reversals:
            # A cell that is only touched adds nothing, so it does not matter whether it is known.
            passed = (lows < high) & (highs > low)
            found = np.where(passed, np.maximum(found, hidden), found)
        return found

    def _join(self) -> None:
        """Join the cells of both directions into arrays."""
        front, rear = self._start
        cells = np.array([*self._cells[-1][::-1], (front, rear, rear), *self._cells[1]])
        self._edges = cells[:, 0]
        self._brackets = cells[:, 1:]

    def _extended(
        self, front: float, rear: float, direction: int, aim: float
    ) -> tuple[float, float] | None:
        """Append gentle cells up to `aim`, or one proven cell; the state at the end."""
        cells = self._cells[direction]
        end = self._gentle_run(front, rear, direction, aim)
        if end != front:
            if cells and np.isnan(cells[-1][1]):
                # One cell, however many calls it took to get to its end.
                cells.pop()
            cells.append((end, np.nan, np.nan))
            rear = float(rear_handle(self._curve, np.array([end]), self._chord)[0])
            return None if np.isnan(rear) else (end, rear)

        last = self._curve.end_s if direction > 0 else self._curve.begin_s
        growth = self._growth(front, rear)
        step, half, hidden = self._step(front, rear, growth, direction)
        step = min(step, abs(last - front))
        rounding = 4 * float(np.spacing(abs(front)))
        shortest = max(_SHORTEST * self._chord, rounding)
        bracket = rear - half, rear + half
        while step > shortest and len(cells) < _MAX_CELLS:
            following = front + direction * step
            guess = rear + direction * step * growth[0] / growth[1]
            there = float(self._rears(np.array([following]), bracket, guess)[0])
            if not np.isnan(there):
                low, high = sorted((front, following))
                if hidden:
                    self._possible_reversals.append((low, high, hidden))
                if (growth[0] >= 0) != (self._growth(following, there)[0] >= 0):
                    self._reversals.append(self._reversal(low, high, bracket))
                cells.append((following, *bracket))
                return following, there
            # The rear handle is before the begin of the curve.
            step /= 2
        return None

    def _gentle_run(self, front: float, rear: float, direction: int, aim: float) -> float:
        """Front at the end of a row of gentle cells of the grid; `front` if there is none."""
        chord = self._chord
        curve = self._curve
        cell = _GRID * chord
        first = np.floor(front / cell) if direction > 0 else np.ceil(front / cell)
        # Rounding may leave nothing of the first cell.
        if ((first + direction) * cell - front) * direction <= 0:
            first += direction

        needed = np.ceil(abs(aim - front) / cell) + 1
        count = int(min(_GRID_CELLS, needed))
        edges = (first + direction * np.arange(count + 1)) * cell
        lows = np.minimum(edges[:-1], edges[1:])
        highs = np.maximum(edges[:-1], edges[1:])
        gentle = curve.max_curvature(lows - np.pi / 2 * chord, highs) * chord < 2
        number = count if gentle.all() else int(np.argmin(gentle))

        # On another branch the rear handle is further away.
        _, longest, _ = gentle_offsets(curve, np.array([front]), chord)
        if number == 0 or front - rear > longest[0]:
            return front
        return float(np.clip(edges[number], curve.begin_s, curve.end_s))

    def _rears(self, fronts: Array, bracket: tuple[float, float], guess: float) -> Array:
        """Coordinates (T,) of the rear handle within a bracket, m, near a guess."""
        low, high = bracket
        offsets = fronts - high, fronts - low, fronts - guess
        return rear_between(self._curve, fronts, self._chord, *offsets)

    def _growth(self, fronts: float | Array, rears: float | Array) -> Array:
        """A and B of the module's docstring, (2, ...)."""
        points, tangents = self._curve.frame(np.stack([fronts, rears]))
        return np.asarray(np.sum(tangents * (points[0] - points[1]), axis=-1))

    def _step(
        self, front: float, rear: float, growth: Array, direction: int
    ) -> tuple[float, float, float]:
        """Length, half height and hidden reversal of a proven cell, m; all 0 at a fold."""
        ahead, behind = growth.tolist()
        if behind <= 0:
            return 0.0, 0.0, 0.0

        # The cell stays within this of its root in both coordinates.
        window = min(_WINDOW * self._chord, behind / 2)
        others = np.array([front + direction * window, rear + window])
        curvature = self._curve.max_curvature(np.array([front, rear - window]), others)
        # M_s and M_r, the half height p, and the positive root h of the module's inequality.
        own, other = (1 + curvature * (self._chord + 2 * window)).tolist()
        half = min(window, behind / (2 * other))
        room = half * (behind - other * half / 2)
        slope = abs(ahead) + half
        root = 2 * room / (slope + float(np.sqrt(slope**2 + 2 * own * room)))
        step = _SAFE * min(root, behind / 4, window)

        # For each metre, A changes by no more than `own` and the rear handle's rate. B stays above
        # half of itself less the step, so that rate is at most 8 |A| / B as long as A keeps its
        # sign.
        change = own + 8 * abs(ahead) / behind
        certain = _SAFE * abs(ahead) / change
        if step <= certain:
            return step, half, 0.0
        step = min(step, max(certain, _REVERSAL * self._chord))
        # |A| is below 2 `change` times the step in a longer cell.
        return step, half, 0.0 if step <= certain else 8 * change * step**2 / behind

    def _reversal(
        self, low: float, high: float, bracket: tuple[float, float]
    ) -> tuple[float, float]:
        """Coordinates of both handles where A = 0, between two fronts at which its signs differ."""
        for _ in range(_PASSES):
            fronts = np.linspace(low, high, _SECTIONS)
            rears = self._rears(fronts, bracket, bracket[0])
            forward = self._growth(fronts, rears)[0] >= 0
            change = int(np.argmax(forward != forward[0]))
            if change == 0:
                break
            low, high = fronts[change - 1 : change + 1].tolist()
        return float(fronts[change]), float(rears[change])
