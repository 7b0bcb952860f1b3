"""The curve of a march in pages."""

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon.model.march import March

# Largest distance of the drawn curve from the true one as a fraction of a bench's width: 0.1 mm at
# the contest's 0.3 m.
CURVE_ERROR = 1 / 3000
# Samples of the curvature along the curve.
_CURVE_SAMPLES = 4000
# Largest number of points of the curve in a page.
_MAX_CURVE_POINTS = 20_000
# The largest curvature over the one that straight parts count as: their chords are three times as
# long as the shortest. The page leaves out points in a distant view, and a chord across a joint
# must not be much further off than others.
_STRAIGHT_RATIO = 9


def curve_points(march: March, start: float, end: float) -> Array:
    """Points (P, 2) in m of the curve over `March.span`, closer where the curvature is larger.

    The span begins at the dragon's position at 0 s even if the run from `start` to `end` s is
    later.
    """
    curve = march.curve
    first, last = march.span(min(start, 0.0), max(end, 0.0))
    s = np.linspace(first, last, _CURVE_SAMPLES)
    curvature = curve.max_curvature(s[:-1], s[1:])
    curvature = np.where(curvature > 0, curvature, curvature.max() / _STRAIGHT_RATIO)

    # A chord c of a curve with the curvature k has an error of k c^2 / 8.
    error = CURVE_ERROR * float(march.dragon.widths.min())
    chords = np.sqrt(curvature / (8 * error)) * np.diff(s)
    # Number of chords up to each sample. It rises a little even on a straight line, of which the
    # two ends are shown.
    passed = np.concatenate([[0.0], np.cumsum(chords + 1e-9)])
    count = int(min(passed[-1] + 2, _MAX_CURVE_POINTS))
    shown = np.interp(np.linspace(0.0, passed[-1], count), passed, s)
    return curve.point(shown)
