"""Parameter studies over many marches, and optimisation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from pymunk_dragon._checks import word
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.dragon import Dragon
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

# Names of the sizes of a dragon that studies take.
DRAGON = ("benches", "head_spacing", "body_spacing", "overhang", "width")


@dataclass(frozen=True, kw_only=True)
class Study:
    """A study that can be run by name.

    Attributes
    ----------
    summary : str
        What the study computes, in one line.
    run : callable
        Function of a `Dragon`, if `of_dragon`, and of the options by name. It returns a frozen dataclass.
    options : tuple of str
        Names of the options apart from the dragon's sizes.
    of_dragon : bool
        Whether the study takes a dragon.
    """

    summary: str
    run: Callable[..., Any]
    options: tuple[str, ...]
    of_dragon: bool = True

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of all parameters, including the dragon's sizes."""
        return (*DRAGON, *self.options) if self.of_dragon else self.options


STUDIES: Mapping[str, Study] = {
    "min-pitch": Study(
        summary="the smallest pitch at which the head reaches the turning circle (the contest's question 3)",
        run=min_pitch,
        options=("turns", "speed", "radius"),
    ),
    "max-speed": Study(
        summary="the largest speed of the head in the U-turn at which no handle is too fast (question 5)",
        run=max_speed,
        options=("limit", "pitch", "radius", "ratio"),
    ),
    "sensitivity": Study(
        summary="what each size of the benches does to the first contact, and to that pitch",
        run=sensitivity,
        options=("pitch", "turns", "speed", "radius"),
    ),
    "u-turn": Study(
        summary="the turn inside the circle, and the shortest one that is found (the contest's question 4)",
        run=u_turn,
        options=("pitch", "radius", "ratio", "speed", "fastest", "search", "arcs", "min_radius"),
    ),
}


def study(name: str, values: Mapping[str, Any], progress: Progress = silent) -> Any:
    """Run one of `STUDIES`.

    Parameters
    ----------
    name : str
        Name of the study.
    values : mapping
        Values of its `parameters`, by name; the others keep their defaults.
    progress : callable, optional
        Called with the part of the study that is done and the whole.

    Returns
    -------
    dataclass
        The result of the study, as `MinPitch`, `MaxSpeed`, `Sensitivity` or `TurnAnswer`.

    Raises
    ------
    ParameterError
        If there is no such study, it does not take one of the values, or a value is out of range.
    DragonError
        As the study itself does.
    """
    chosen = STUDIES[word("study", name, STUDIES)]
    for given, value in values.items():
        if given not in chosen.parameters:
            raise ParameterError(given, value, f"left out: {name} takes " + ", ".join(chosen.parameters))
    options = {given: value for given, value in values.items() if given in chosen.options}
    if not chosen.of_dragon:
        return chosen.run(**options, progress=progress)
    dragon = Dragon(**{given: value for given, value in values.items() if given in DRAGON})
    return chosen.run(dragon, **options, progress=progress)
