"""Figures that are pictures of the dragon, drawn as in films (the paper's figures 3, 4 and 5)."""

from __future__ import annotations

from dataclasses import replace

from pymunk_dragon.drawing.figures.times import TimeInterval, closing_time, contact_or_end, spirals_in
from pymunk_dragon.drawing.film.settings import Film
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

__all__ = ["Still", "collision", "inward", "outer_loop"]

# A run of one frame, and the parameters of its picture.
Still = tuple[Run, Film]

# Pixels: twice the width at which two or three of these pictures fit side by side.
SIZE = 880


def outer_loop(march: March, interval: TimeInterval) -> Still:
    """Return the picture of the dragon on the outer loop, at its start."""
    return _moment(march, interval[0], "on the outer loop" if spirals_in(march) else "at the start")


def inward(march: March, interval: TimeInterval) -> Still:
    """Return the picture of the dragon on the inward spiral, as it closes a full loop."""
    time = closing_time(march, interval[0], contact_or_end(march, interval).time)
    return _moment(march, time, "moving inward" if spirals_in(march) else "on their way")


def collision(march: March, interval: TimeInterval) -> Still:
    """Return the picture of the dragon at its first contact."""
    hit = contact_or_end(march, interval, touching=True)
    run, film = _moment(march, hit.time, "at the first contact")
    return replace(run, first_contact=hit.contact, outcome="contact"), film


def _moment(march: March, time: float, where: str) -> Still:
    return Run.exact(march, [time]), Film(size=SIZE, title=f"{march.dragon.benches} benches {where}")
