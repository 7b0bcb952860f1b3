"""Figures that are pictures of the dragon, in the films' own hand (the paper's figures 3, 4 and 5)."""

from __future__ import annotations

from dataclasses import replace

from pymunk_dragon.march import March
from pymunk_dragon.render.figures.times import Stretch, closing_time, ending, spirals_in
from pymunk_dragon.render.film import Film
from pymunk_dragon.run import Run

__all__ = ["Still", "collision", "inward", "outer_loop"]

Still = tuple[Run, Film]

# Pixels a side: twice the width at which two or three of them stand beside each other.
SIZE = 880


def outer_loop(march: March, look: Stretch) -> Still:
    """The dragon on the outer loop, at its start."""
    return _moment(march, look[0], "on the outer loop" if spirals_in(march) else "at the start")


def inward(march: March, look: Stretch) -> Still:
    """The dragon on its way in, as it closes a full loop."""
    time = closing_time(march, look[0], ending(march, look).time)
    return _moment(march, time, "moving inward" if spirals_in(march) else "on their way")


def collision(march: March, look: Stretch) -> Still:
    """The dragon at its first contact."""
    hit = ending(march, look, touching=True)
    run, film = _moment(march, hit.time, "at the first contact")
    return replace(run, first_contact=hit.contact, outcome="contact"), film


def _moment(march: March, time: float, where: str) -> Still:
    return Run.exact(march, [time]), Film(size=SIZE, title=f"{march.dragon.benches} benches {where}")
