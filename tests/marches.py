"""Marches that are not the paper's: other curves, speeds that change, benches that differ."""

import math

import numpy as np

from pymunk_dragon import Arc, Composite, Dragon, Line, March, Sampled, SpeedTable, UTurn

# The contest's question 4, with a shorter dragon: it comes from infinity, and goes there.
U_TURN = March(Dragon(benches=30), UTurn())
# A tractor with three trailers on a road that crosses itself, faster and slower.
TRACTOR = March(
    Dragon(
        head_spacing=2.6,
        body_spacing=[4.5, 3.0, 6.0],
        overhang=[0.6, 0.5, 0.4, 0.7],
        width=[1.8, 2.2, 1.6, 2.4],
    ),
    Composite(
        [
            Line(start=(-30, 0), stop=(0, 0)),
            Arc(centre=(0, 8), radius=8, begin_angle=-math.pi / 2, sweep=math.pi / 2),
            Line(start=(8, 8), stop=(8, 20)),
            Arc(centre=(2, 20), radius=6, begin_angle=0, sweep=math.pi),
            Line(start=(-4, 20), stop=(-4, -20)),
        ]
    ),
    speed=SpeedTable((0, 5, 20), (0.5, 2.0, 1.5)),
)
# Five links of a robot's arm that creep through points.
_SHARES = np.linspace(0, 1, 18)
ARM = March(
    Dragon(
        head_spacing=0.22,
        body_spacing=[0.2, 0.18, 0.15, 0.12],
        overhang=[0.03, 0.03, 0.025, 0.02, 0.02],
        width=[0.05, 0.07, 0.07, 0.08, 0.09],
    ),
    Sampled(np.stack([2.2 * _SHARES, 0.3 * np.sin(9 * _SHARES) * np.sqrt(_SHARES)], axis=1)),
    speed=0.1,
)


def bent(length, radius, sweep, onward):
    """Straight on, round to the left by an angle, and straight on."""
    arc = Arc(centre=(length, radius), radius=radius, begin_angle=-np.pi / 2, sweep=sweep)
    end, ahead = arc.point(arc.end_s), arc.tangent(arc.end_s)
    return Composite([Line(stop=(length, 0)), arc, Line(start=end, stop=end + onward * ahead)])


# Its legs are closer than a bench is long.
HAIRPIN = bent(10, 0.6, np.pi, 10)
# Points of a loop that a hand may have drawn.
DRAWN = Sampled(
    [
        (-12, 0),
        (-8, 0.3),
        (-4, -0.2),
        (0, 0),
        (3, 1),
        (4, 4),
        (1.5, 6),
        (-1, 4),
        (-1.5, 1),
        (-1, -3),
        (1, -7),
    ]
)
TABLE = SpeedTable([0, 4, 9], [0.5, 2, 1])
