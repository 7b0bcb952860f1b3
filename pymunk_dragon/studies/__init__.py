"""Parameter studies over many marches, and optimisation.

A study is a module with a function, its result, and an entry `STUDY`. The result's class has the text, the JSON values
and the figure; `STUDIES` has all studies by name, from which the command line takes their options.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pymunk_dragon._checks import word
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.studies._study import DRAGON, Progress, Result, Study, silent
from pymunk_dragon.studies.max_speed import STUDY as MAX_SPEED
from pymunk_dragon.studies.max_speed import MaxSpeed, max_speed
from pymunk_dragon.studies.min_pitch import STUDY as MIN_PITCH
from pymunk_dragon.studies.min_pitch import MinPitch, min_pitch
from pymunk_dragon.studies.sensitivity import STUDY as SENSITIVITY
from pymunk_dragon.studies.sensitivity import Sensitivity, Slope, sensitivity
from pymunk_dragon.studies.u_turn import STUDY as U_TURN
from pymunk_dragon.studies.u_turn import TurnResult, u_turn

__all__ = [
    "STUDIES",
    "MaxSpeed",
    "MinPitch",
    "Result",
    "Sensitivity",
    "Slope",
    "Study",
    "TurnResult",
    "max_speed",
    "min_pitch",
    "sensitivity",
    "study",
    "u_turn",
]

# All studies by name.
STUDIES: Mapping[str, Study] = {study.name: study for study in (MIN_PITCH, MAX_SPEED, SENSITIVITY, U_TURN)}


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
    Result
        The result of the study, as `MinPitch`, `MaxSpeed`, `Sensitivity` or `TurnResult`.

    Raises
    ------
    ParameterError
        If there is no such study, it does not take one of the values, or a value is out of range.
    DragonError
        As the study itself does.

    Examples
    --------
    >>> round(study("max-speed", {"limit": 1.5}).speed, 6)
    0.9347
    """
    chosen = STUDIES[word("study", name, STUDIES)]
    for given, value in values.items():
        if given not in chosen.parameters:
            raise ParameterError(given, value, f"left out: {name} takes " + ", ".join(chosen.parameters))
    dragon = Dragon(**{given: value for given, value in values.items() if given in DRAGON})
    return chosen.run(
        dragon, **{given: value for given, value in values.items() if given not in DRAGON}, progress=progress
    )
