"""Smallest gaps of the inward march at many pitches, which show where the free pitches are."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pymunk_dragon._arrays import Array, ArrayRecord, read_only
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.studies._gaps import InwardMarch, SampledGaps
from pymunk_dragon.studies._study import Progress

# Ratio of successive pitches of the map.
PITCH_RATIO = 1.04
# Smallest gap at which the map ends, as a share of the width, or of the smallest gap at wide pitches if that is less:
# beyond it no gap is close to zero.
MAP_END = 0.5
# Size up to which a gap counts as close to zero, as a share of the width: 1 cm at the contest's 0.3 m.
CLOSE_TO_ZERO = 1 / 30
# Least pitch of the map over the width: no march has a pitch that is not larger than the width.
MIN_PITCH_RATIO = 1 + 1e-6


@dataclass(frozen=True, eq=False)
class PitchMap(ArrayRecord):
    """Smallest gaps on the inward spiral at K pitches.

    Attributes
    ----------
    pitches, gaps : ndarray, shape (K,)
        m; a gap is negative where benches overlap.
    further_out : ndarray, shape (K,)
        Smallest gaps on a spiral that begins as far out as that of the next pitch, m.
    growth : tuple of float or None
        Least and largest derivative, by the pitch, of gaps close to zero at a fixed distance of handle 0 from the
        centre, m per m. None where no gap is close to zero.
    threshold : float
        Largest size of a gap that counts as close to zero, m.
    samples : int
        Number of gaps close to zero whose derivatives were computed.
    """

    pitches: Array
    gaps: Array
    further_out: Array
    growth: tuple[float, float] | None
    threshold: float
    samples: int

    def __post_init__(self) -> None:
        for array in (self.pitches, self.gaps, self.further_out):
            read_only(array)


def at_least_pitch(dragon: Dragon, turns: float, radius: float) -> InwardMarch:
    """The march at the least pitch: turns are not closer than the width, and the start is not inside the circle."""
    least = max(float(dragon.widths.max()) * MIN_PITCH_RATIO, radius / turns)
    return InwardMarch(dragon=dragon, pitch=least, turns=turns, radius=radius)


def pitch_map(least: InwardMarch, progress: Progress) -> PitchMap:
    """Smallest gaps from the march at the least pitch to a pitch at which all gaps are wide."""
    close = CLOSE_TO_ZERO * float(least.dragon.widths.min())
    wide = MAP_END * _gap_between_turns_apart(least)
    pitches, rows, slopes = [least.pitch], [], [np.empty(0)]
    while True:
        sampled = SampledGaps(replace(least, pitch=pitches[-1]), PITCH_RATIO)
        rows.append(smallest_gaps(sampled))
        if (found := sampled.close_to_zero(close)) is not None:
            slopes.append(found.slopes_at_radius)
        progress(min(max(0.0, *rows[-1]), wide), wide)
        if min(rows[-1]) >= wide:
            break
        pitches.append(PITCH_RATIO * pitches[-1])
    growth = np.concatenate(slopes)
    bounds = (float(growth.min()), float(growth.max())) if growth.size else None
    gaps, further_out = np.array(rows).T
    return PitchMap(np.array(pitches), gaps, further_out, bounds, close, growth.size)


def smallest_gaps(sampled: SampledGaps) -> tuple[float, float]:
    """The smallest sampled gap from the start on, and that of all samples, m."""
    return float(sampled.gaps[sampled.travelled >= 0].min()), float(sampled.gaps.min())


def _gap_between_turns_apart(inward: InwardMarch) -> float:
    """The largest width or, if smaller, the smallest gap of the dragon where adjacent turns are out of reach, m.

    Raises `ParameterError` if benches touch there, which they then do at any pitch.
    """
    dragon, widest = inward.dragon, float(inward.dragon.widths.max())
    straight = dragon.spacings[1:-1] - dragon.overhangs[:-2] - dragon.overhangs[2:]
    if straight.min(initial=np.inf) >= 2 * widest:
        return widest
    gap = min(smallest_gaps(SampledGaps(replace(inward, pitch=2 * float(dragon.lengths.max()) + widest))))
    if gap <= 0:
        raise ParameterError("body_spacing", dragon.body_spacing, "long enough for benches not to touch on the circle")
    return min(widest, gap)
