"""How near the head and the bench behind it come to the benches that they pass, on the whole way in."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.collision import separation
from pymunk_dragon.curves import Spiral
from pymunk_dragon.march import March
from pymunk_dragon.studies.slopes import WAY, Gaps, gaps_of

__all__ = ["Passing"]

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

# Looks while the head goes the shortest spacing: a gap that is smallest hardly changes between two of them.
LOOKS = 6
# Moments placed at once: with a hundred handles 30 MB.
SOME = 4000
# Turns behind the head within which the benches are that it passes; whatever is further back is further away.
TURNS_BACK = 1.25
# Points looked at in each bracket of a smallest gap, and passes. Each pass narrows the bracket fourteenfold: from
# half a metre to the last digits of the way.
POINTS, PASSES = 15, 11


class Passing:
    """The gaps of benches 0 and 1 to those that they pass, at places of the head close together.

    Where all benches but the head are alike, the others repeat what bench 1 does. This is to be found quickly;
    `first_contact` certifies it.

    Parameters
    ----------
    march : March
        On a `Spiral`, inward from one of its turns, at 1 m/s.
    until : float
        The last place of the head: its way from the start, m.
    since : float
        The first one; before the start it is negative.

    Attributes
    ----------
    ways : ndarray, shape (T,)
        Where it was looked, m.
    gaps : ndarray, shape (T, B, 2)
        Gaps of bench 0 and of bench 1 to each of the foremost B, m; inf where two are far apart or are neighbours.
    """

    def __init__(self, march: March, until: float, since: float = 0.0) -> None:
        self._march = march
        step = float(march.dragon.spacings.min()) / LOOKS
        before, after = (int(np.ceil(length / step)) for length in (-since, until))
        self.ways = np.concatenate([np.linspace(since, 0.0, before + 1)[:-1], np.linspace(0.0, until, after + 1)])
        benches = min(march.dragon.benches, _passed(march, since))
        parts = [self._gaps(self.ways[at : at + SOME], benches) for at in range(0, len(self.ways), SOME)]
        self.gaps = np.concatenate(parts)

    def _gaps(self, ways: Array, benches: int) -> Array:
        dragon, poses = self._march.dragon, self._march.at(ways, benches + 1).poses
        gaps = np.full((len(ways), benches, 2), np.inf)
        corners = dragon.outlines(poses)
        # Benches whose circles are so far apart are no near ones.
        reach = np.hypot(dragon.lengths, dragon.widths)[:benches] / 2 + dragon.widths.max()
        for own in range(min(2, benches)):
            between = poses[:, own + 2 :, :2] - poses[:, own : own + 1, :2]
            near = np.hypot(between[..., 0], between[..., 1]) < (reach[own + 2 :] + reach[own])
            row, other = np.nonzero(near)
            gaps[row, own + 2 + other, own] = separation(corners[row, own], corners[row, own + 2 + other]).distance
        return gaps

    def about_to_touch(self, near: float) -> Gaps | None:
        """Gaps at most `near` m from zero, at moments at which none is deeper, with their slopes; None without any."""
        shallow = self.gaps.min(axis=(1, 2), keepdims=True) >= -near
        row, other, own = np.nonzero(shallow & (np.abs(self.gaps) <= near))
        return gaps_of(self._march, self.ways[row], np.stack([own, other], axis=-1)) if row.size else None

    def lowest(self) -> Gaps | None:
        """The smallest of all gaps, about the lowest one looked at; None where no bench is ever passed."""
        if not np.isfinite(self.gaps).any():
            return None
        row, other, own = np.unravel_index(int(self.gaps.argmin()), self.gaps.shape)
        return self._refined(np.array([row]), np.array([[own, other]]))

    def smallest(self, below: float) -> Gaps:
        """All gaps that are smallest on the way, and below `below` m when looked at.

        Gaps that still fall at the end are among them, and those that grow from the start on.
        """
        padded = np.pad(self.gaps, ((1, 1), (0, 0), (0, 0)), constant_values=np.inf)
        row, other, own = np.nonzero((self.gaps <= padded[:-2]) & (self.gaps <= padded[2:]) & (self.gaps < below))
        return self._refined(row, np.stack([own, other], axis=-1))

    def _refined(self, rows: Indices, pairs: Indices) -> Gaps:
        """The smallest gaps of `pairs` about the rows `rows`: where they neither fall nor rise."""
        last = len(self.ways) - 1
        low, high = self.ways[np.maximum(rows - 1, 0)], self.ways[np.minimum(rows + 1, last)]
        chosen, many = np.arange(len(rows)), np.repeat(pairs, POINTS, axis=0)
        for _ in range(PASSES):
            ways = np.linspace(low, high, POINTS, axis=-1)
            falling = gaps_of(self._march, ways, many).slopes[:, WAY].reshape(ways.shape) < 0
            # The last point from which it falls without a break from the first one on.
            place = np.where(falling.all(axis=1), POINTS, falling.argmin(axis=1))
            low = ways[chosen, np.clip(place - 1, 0, POINTS - 1)]
            high = ways[chosen, np.clip(place, 0, POINTS - 1)]
        return gaps_of(self._march, (low + high) / 2, pairs)


def _passed(march: March, way: float) -> int:
    """How many benches stand on so many turns behind the head after its `way`."""
    curve, head = march.curve, march.head_start + way
    assert isinstance(curve, Spiral)
    radius = float(np.hypot(*curve.point(head)))
    behind = head - curve.at_radius(radius + TURNS_BACK * curve.pitch)
    return int(np.ceil(behind / march.dragon.spacings.min())) + 2
