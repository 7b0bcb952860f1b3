"""Figures of the studies' results, selected by the type of the result."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pymunk_dragon.drawing.figures.max_speed import max_speed
from pymunk_dragon.drawing.figures.min_pitch import min_pitch
from pymunk_dragon.drawing.figures.sensitivity import sensitivity
from pymunk_dragon.drawing.figures.u_turn import u_turn
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.studies import MaxSpeed, MinPitch, Sensitivity, TurnAnswer

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["study_figure"]

# Drawing function for each type of result.
DRAW_FUNCTIONS: Mapping[type, Callable[[Any], Figure]] = {
    MaxSpeed: max_speed,
    MinPitch: min_pitch,
    Sensitivity: sensitivity,
    TurnAnswer: u_turn,
}


def study_figure(found: object) -> Figure:
    """Draw the figure of a study's result.

    Raises
    ------
    ParameterError
        If `found` is not the result of a study.
    """
    if type(found) not in DRAW_FUNCTIONS:
        raise ParameterError("answer", found, "what a study answers")
    return DRAW_FUNCTIONS[type(found)](found)
