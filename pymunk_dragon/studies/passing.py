"""How near the head and the bench behind it come to the benches that they pass, on the whole way in."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.collision import separation
from pymunk_dragon.curves import Spiral
from pymunk_dragon.dragon import Dragon
from pymunk_dragon.march import March
from pymunk_dragon.studies.slopes import WAY, Gaps, gaps_of

__all__ = ["Passing", "foremost", "smallest_between"]

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

# Looks while the head goes the shortest spacing: a gap that is smallest hardly changes between two of them.
LOOKS = 6
# Moments placed at once: with a hundred handles 30 MB.
SOME = 4000
# Turns behind the head within which the benches are that it passes; whatever is further back is further away.
TURNS_BACK = 1.25
# Points looked at in each bracket of a smallest gap, and passes. Each pass narrows the bracket fourteenfold: from
# half a metre to 3e-11 m.
POINTS, PASSES = 15, 9


class Passing:
    """The gaps of benches 0 and 1 to those that they pass, at places of the head close together.

    Where all benches but the head are alike, the others repeat what bench 1 does. This is to be found quickly;
    `first_contact` certifies it.

    Parameters
    ----------
    dragon : Dragon
        Who marches.
    curve : Spiral
        On which, inward.
    turns : float
        Turn of the spiral on which handle 0 starts.
    radius : float
        Distance from the centre, m, as far as which it is looked.
    further : float
        So many times as far out as the start is where it is looked first.

    Attributes
    ----------
    march : March
        That of the foremost benches, at 1 m/s.
    ways : ndarray, shape (T,)
        How far the head has gone from its start where it was looked, m; negative before it.
    gaps : ndarray, shape (T, B, 2)
        Gaps of bench 0 and of bench 1 to each of the foremost B, m; inf where two are far apart or are neighbours.
    """

    def __init__(self, dragon: Dragon, curve: Spiral, turns: float, radius: float, further: float = 1.0) -> None:
        start, outside = curve.at_turn(turns), curve.at_turn(further * turns)
        passed = outside - curve.at_turn(further * turns + TURNS_BACK)
        self.march = March(foremost(dragon, int(passed / dragon.spacings.min()) + 2), curve, turns=turns)
        step = float(dragon.spacings.min()) / LOOKS
        before, after = (int(np.ceil(way / step)) for way in (start - outside, curve.at_radius(radius) - start))
        first, last = outside - start, max(0.0, curve.at_radius(radius) - start)
        self.ways = np.concatenate([np.linspace(first, 0.0, before + 1)[:-1], np.linspace(0.0, last, after + 1)])
        parts = [self._gaps(self.ways[at : at + SOME]) for at in range(0, len(self.ways), SOME)]
        self.gaps = np.concatenate(parts)

    def _gaps(self, ways: Array) -> Array:
        dragon, poses = self.march.dragon, self.march.at(ways).poses
        benches = dragon.benches
        gaps = np.full((len(ways), benches, 2), np.inf)
        corners = dragon.outlines(poses)
        # Benches whose circles are so far apart are no near ones.
        reach = np.hypot(dragon.lengths, dragon.widths) / 2 + dragon.widths.max()
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
        return gaps_of(self.march, self.ways[row], np.stack([own, other], axis=-1)) if row.size else None

    def lowest(self) -> Gaps | None:
        """The smallest of all gaps, about the lowest one looked at; None where no bench is ever passed."""
        if not np.isfinite(self.gaps).any():
            return None
        row, other, own = np.unravel_index(int(self.gaps.argmin()), self.gaps.shape)
        return self._refined(np.array([row]), np.array([[own, other]]))

    def smallest(self, below: float) -> Gaps | None:
        """All gaps that are smallest on the way, and below `below` m when looked at; None where there is none.

        Gaps that still fall at the end are among them, and those that grow from the start on.
        """
        padded = np.pad(self.gaps, ((1, 1), (0, 0), (0, 0)), constant_values=np.inf)
        row, other, own = np.nonzero((self.gaps <= padded[:-2]) & (self.gaps <= padded[2:]) & (self.gaps < below))
        return self._refined(row, np.stack([own, other], axis=-1)) if row.size else None

    def _refined(self, rows: Indices, pairs: Indices) -> Gaps:
        last = len(self.ways) - 1
        low, high = self.ways[np.maximum(rows - 1, 0)], self.ways[np.minimum(rows + 1, last)]
        return smallest_between(self.march, pairs, low, high)


def smallest_between(march: March, pairs: Indices, low: Array, high: Array) -> Gaps:
    """The smallest gaps of `pairs` (P, 2) between the ways `low` and `high` (P,) of the head: where they cease to fall.

    The march is one as in `gaps_of`, and each gap has one such place, or is smallest at an end.
    """
    chosen, many = np.arange(len(pairs)), np.repeat(pairs, POINTS, axis=0)
    for _ in range(PASSES):
        ways = np.linspace(low, high, POINTS, axis=-1)
        falling = gaps_of(march, ways, many).slopes[:, WAY].reshape(ways.shape) < 0
        # The last point from which it falls without a break from the first one on.
        place = np.where(falling.all(axis=1), POINTS, falling.argmin(axis=1))
        low, high = (ways[chosen, np.clip(place - back, 0, POINTS - 1)] for back in (1, 0))
    return gaps_of(march, (low + high) / 2, pairs)


def foremost(dragon: Dragon, benches: int) -> Dragon:
    """The foremost benches of a dragon, if it has more: so much quicker placed."""
    if benches >= dragon.benches:
        return dragon
    return Dragon(
        head_spacing=dragon.head_spacing,
        body_spacing=dragon.spacings[1:benches].tolist(),
        overhang=dragon.overhangs[:benches].tolist(),
        width=dragon.widths[:benches].tolist(),
    )
