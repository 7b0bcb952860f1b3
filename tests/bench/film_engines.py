"""Film four engines side by side as the head passes bench 11: `film_engines.py FILE`.

All are on rails, as in the table of `engines.py`.
"""

from __future__ import annotations

import sys

import numpy as np
from engines import errors, exact_poses, play_python

from pymunk_dragon import Camera, Film, March, Run, render

# Modules of the engines, and what stands above their pictures.
SHOWN = {
    "pymunk_world": "Pymunk, this package",
    "box2d_3": "Box2D 3",
    "box2d": "Box2D 2.3",
    "pymunk_plain": "Pymunk, plain driver",
}

# s: the head passes bench 11 at 409.75 s, and touches bench 8 at 412.474 s.
START, UNTIL = 409.2, 412.6


def run_of(module: str) -> Run:
    """The run of an engine on rails, from a while before the film."""
    played = play_python(module, "rails")
    _, exact = exact_poses("rails", float(np.diff(played.times[:2])[0]))
    seen = (played.times > START - 1) & (played.times < UNTIL + 0.1)
    return Run(
        march=March(),
        times=played.times[seen],
        poses=played.poses[seen],
        drift=errors(played.poses[seen], exact[seen]),
    )


if __name__ == "__main__":
    runs = [run_of(module) for module in SHOWN]
    film = Film(
        fps=10,
        speedup=0.6,
        size=240,
        start=START,
        until=UNTIL,
        camera=Camera(follow="head", span=4.4),
        legend=False,
        title="A dragon on rails in four engines: the near miss of bench 11, and the first contact",
        headings=tuple(SHOWN.values()),
    )
    render(runs, sys.argv[1], film)
