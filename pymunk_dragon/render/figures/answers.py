"""Pictures of the studies' answers, found by the type of the answer."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pymunk_dragon.errors import ParameterError
from pymunk_dragon.render.figures.limit import speed_limit
from pymunk_dragon.render.figures.pitch import smallest_pitch
from pymunk_dragon.render.figures.slopes import slopes
from pymunk_dragon.render.figures.turns import turns
from pymunk_dragon.studies import MaxSpeed, MinPitch, Sensitivity, TurnAnswer

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["answer"]

PICTURES: Mapping[type, Callable[[Any], Figure]] = {
    MaxSpeed: speed_limit,
    MinPitch: smallest_pitch,
    Sensitivity: slopes,
    TurnAnswer: turns,
}


def answer(found: object) -> Figure:
    """The picture of a study's answer.

    Raises
    ------
    ParameterError
        If it is none.
    """
    if type(found) not in PICTURES:
        raise ParameterError("answer", found, "what a study answers")
    return PICTURES[type(found)](found)
