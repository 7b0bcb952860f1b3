"""Questions asked of many marches."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from pymunk_dragon.checks import word
from pymunk_dragon.dragon import Dragon
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.studies.max_speed import MaxSpeed, max_speed
from pymunk_dragon.studies.min_pitch import MinPitch, PitchMap, min_pitch
from pymunk_dragon.studies.progress import Progress, silent
from pymunk_dragon.studies.sensitivity import Reach, Sensitivity, Slope, sensitivity
from pymunk_dragon.studies.u_turn import TurnAnswer, u_turn

__all__ = [
    "STUDIES",
    "MaxSpeed",
    "MinPitch",
    "PitchMap",
    "Reach",
    "Sensitivity",
    "Slope",
    "Study",
    "TurnAnswer",
    "max_speed",
    "min_pitch",
    "sensitivity",
    "study",
    "u_turn",
]

DRAGON = ("benches", "head_spacing", "body_spacing", "overhang", "width")


@dataclass(frozen=True, kw_only=True)
class Study:
    """A question that can be asked by name.

    Attributes
    ----------
    asks : str
        What it asks, in one line.
    ask : callable
        Who answers: a function of a `Dragon`, if `of_dragon`, and of the options by name. It gives a frozen dataclass.
    options : tuple of str
        Names of the numbers that it takes beside the dragon's own.
    of_dragon : bool
        Whether a dragon is what it asks about.
    """

    asks: str
    ask: Callable[..., Any]
    options: tuple[str, ...]
    of_dragon: bool = True

    @property
    def takes(self) -> tuple[str, ...]:
        """Names of all the numbers that it takes."""
        return (*DRAGON, *self.options) if self.of_dragon else self.options


STUDIES: Mapping[str, Study] = {
    "min-pitch": Study(
        asks="the smallest pitch at which the head reaches the turning circle (the contest's question 3)",
        ask=min_pitch,
        options=("turns", "speed", "radius"),
    ),
    "max-speed": Study(
        asks="the largest speed of the head in the U-turn at which no handle is too fast (question 5)",
        ask=max_speed,
        options=("limit", "pitch", "radius", "ratio"),
    ),
    "sensitivity": Study(
        asks="what each size of the benches does to the first contact, and to that pitch",
        ask=sensitivity,
        options=("pitch", "turns", "speed", "radius"),
    ),
    "u-turn": Study(
        asks="the turn inside the circle, and the shortest one that is found (the contest's question 4)",
        ask=u_turn,
        options=("pitch", "radius", "ratio", "speed", "fastest", "search", "arcs", "min_radius"),
    ),
}


def study(name: str, values: Mapping[str, Any], progress: Progress = silent) -> Any:
    """Ask one of `STUDIES`.

    Parameters
    ----------
    name : str
        Which.
    values : mapping
        Numbers that it `takes`, by name; what is not among them keeps its default.
    progress : callable, optional
        Called with how much of the study is done, and how much there is.

    Raises
    ------
    ParameterError
        If there is no such study, it does not take one of the values, or one of them cannot be used.
    DragonError
        As the study itself does.
    """
    asked = STUDIES[word("study", name, STUDIES)]
    for given, value in values.items():
        if given not in asked.takes:
            raise ParameterError(given, value, f"left out: {name} takes " + ", ".join(asked.takes))
    options = {given: value for given, value in values.items() if given in asked.options}
    if not asked.of_dragon:
        return asked.ask(**options, progress=progress)
    dragon = Dragon(**{given: value for given, value in values.items() if given in DRAGON})
    return asked.ask(dragon, **options, progress=progress)
