"""Sampled gaps of the head bench and the bench behind it to the benches that they pass on the inward spiral."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.collision import separation
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.studies.gaps import TRAVELLED, Gaps, gaps_of

__all__ = ["SampledGaps", "minimal_gaps"]

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

# Samples per shortest spacing travelled by the head. A local minimum of a gap hardly changes between two samples.
SAMPLES_PER_SPACING = 6
# Positions of the head evaluated at once: 30 MB with a hundred handles.
BATCH = 4000
# Turns behind the head that contain all benches that it passes. Benches further back are further away.
TURNS_BACK = 1.25
# Points per bracket of a local minimum in each refinement pass, which narrows the bracket fourteenfold.
POINTS = 15
# Refinement passes: half a metre becomes 3e-11 m.
PASSES = 9


class SampledGaps:
    """Gaps of benches 0 and 1 to the benches that they pass, at closely spaced positions of the head.

    Where all benches but the head are alike, every other bench repeats the motion of bench 1. Sampling is fast and
    proves nothing; `first_contact` certifies its results.

    Parameters
    ----------
    dragon : Dragon
        The dragon.
    curve : Spiral
        The inward spiral.
    turns : float
        Turn of the spiral at which handle 0 starts.
    radius : float
        Distance of handle 0 from the centre at the last sample, m.
    further : float
        Factor on `turns` that gives the turn of the first sample.

    Attributes
    ----------
    march : March
        March of the foremost benches at 1 m/s.
    travelled : ndarray, shape (T,)
        Distance travelled by the head from its start at each sample, m; negative before the start.
    gaps : ndarray, shape (T, B, 2)
        Gaps of bench 0 and of bench 1 to each of the foremost B benches, m; inf for distant benches and neighbours.
    """

    def __init__(self, dragon: Dragon, curve: Spiral, turns: float, radius: float, further: float = 1.0) -> None:
        start, outside = curve.at_turn(turns), curve.at_turn(further * turns)
        passed = outside - curve.at_turn(further * turns + TURNS_BACK)
        self.march = March(_front_part(dragon, int(passed / dragon.spacings.min()) + 2), curve, turns=turns)
        step = float(dragon.spacings.min()) / SAMPLES_PER_SPACING
        before, after = (int(np.ceil(part / step)) for part in (start - outside, curve.at_radius(radius) - start))
        first, last = outside - start, max(0.0, curve.at_radius(radius) - start)
        self.travelled = np.concatenate([np.linspace(first, 0.0, before + 1)[:-1], np.linspace(0.0, last, after + 1)])
        parts = [self._gaps(self.travelled[at : at + BATCH]) for at in range(0, len(self.travelled), BATCH)]
        self.gaps = np.concatenate(parts)

    def _gaps(self, travelled: Array) -> Array:
        """Gaps (T, B, 2) at distances travelled (T,)."""
        dragon, poses = self.march.dragon, self.march.at(travelled).poses
        benches = dragon.benches
        gaps = np.full((len(travelled), benches, 2), np.inf)
        corners = dragon.outlines(poses)
        # Benches whose bounding circles are further apart than the largest width are skipped.
        reach = np.hypot(dragon.lengths, dragon.widths) / 2 + dragon.widths.max()
        for own in range(min(2, benches)):
            between = poses[:, own + 2 :, :2] - poses[:, own : own + 1, :2]
            in_reach = np.hypot(between[..., 0], between[..., 1]) < (reach[own + 2 :] + reach[own])
            row, other = np.nonzero(in_reach)
            gaps[row, own + 2 + other, own] = separation(corners[row, own], corners[row, own + 2 + other]).distance
        return gaps

    def close_to_zero(self, tolerance: float) -> Gaps | None:
        """Gaps within `tolerance` m of zero, from samples without a deeper overlap; None if there are none."""
        shallow = self.gaps.min(axis=(1, 2), keepdims=True) >= -tolerance
        row, other, own = np.nonzero(shallow & (np.abs(self.gaps) <= tolerance))
        return gaps_of(self.march, self.travelled[row], np.stack([own, other], axis=-1)) if row.size else None

    def minimum(self) -> Gaps | None:
        """The smallest of all gaps, refined about its sample; None if the head passes no bench."""
        if not np.isfinite(self.gaps).any():
            return None
        row, other, own = np.unravel_index(int(self.gaps.argmin()), self.gaps.shape)
        return self._refined(np.array([row]), np.array([[own, other]]))

    def local_minima(self, below: float) -> Gaps | None:
        """All local minima over the distance travelled whose samples are below `below` m; None if there are none.

        Minima at the first and the last sample are included.
        """
        padded = np.pad(self.gaps, ((1, 1), (0, 0), (0, 0)), constant_values=np.inf)
        row, other, own = np.nonzero((self.gaps <= padded[:-2]) & (self.gaps <= padded[2:]) & (self.gaps < below))
        return self._refined(row, np.stack([own, other], axis=-1)) if row.size else None

    def _refined(self, rows: Indices, pairs: Indices) -> Gaps:
        """Minimal gaps of `pairs` (P, 2) between the samples next to `rows` (P,)."""
        last = len(self.travelled) - 1
        low, high = self.travelled[np.maximum(rows - 1, 0)], self.travelled[np.minimum(rows + 1, last)]
        return minimal_gaps(self.march, pairs, low, high)


def minimal_gaps(march: March, pairs: Indices, low: Array, high: Array) -> Gaps:
    """The minima of the gaps of `pairs` (P, 2) between distances travelled `low` and `high` (P,), m.

    The march is one that `gaps_of` accepts. Each gap has one local minimum in its bracket, or is smallest at an end.
    """
    chosen, many = np.arange(len(pairs)), np.repeat(pairs, POINTS, axis=0)
    for _ in range(PASSES):
        travelled = np.linspace(low, high, POINTS, axis=-1)
        falling = gaps_of(march, travelled, many).slopes[:, TRAVELLED].reshape(travelled.shape) < 0
        # First point at which the gap does not decrease.
        turning = np.where(falling.all(axis=1), POINTS, falling.argmin(axis=1))
        low, high = (travelled[chosen, np.clip(turning - back, 0, POINTS - 1)] for back in (1, 0))
    return gaps_of(march, (low + high) / 2, pairs)


def _front_part(dragon: Dragon, benches: int) -> Dragon:
    """The foremost `benches` benches of a dragon, or the whole dragon if it has no more."""
    if benches >= dragon.benches:
        return dragon
    return Dragon(
        head_spacing=dragon.head_spacing,
        body_spacing=dragon.spacings[1:benches].tolist(),
        overhang=dragon.overhangs[:benches].tolist(),
        width=dragon.widths[:benches].tolist(),
    )
