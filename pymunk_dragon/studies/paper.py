"""All five answers to the contest's questions, with their errors and sensitivities."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pymunk_dragon._checks import function, silent
from pymunk_dragon.collision import FirstContact
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March, States
from pymunk_dragon.studies._study import Progress, Result, checked_dragon
from pymunk_dragon.studies.max_speed import MaxSpeed, max_speed
from pymunk_dragon.studies.min_pitch import MinPitch
from pymunk_dragon.studies.sensitivity import Sensitivity, sensitivity, slopes
from pymunk_dragon.studies.u_turn import TurnResult, u_turn

# s: times of the paper's tables 1 and 2.
_TIMES = (0.0, 60.0, 120.0, 180.0, 240.0, 300.0)


@dataclass(frozen=True, kw_only=True, repr=False)
class Paper(Result):
    """All five answers.

    Attributes
    ----------
    march : March
        The march of the first two questions.
    states : States
        Question 1: all handles at the times of the paper's tables.
    sensitivity : Sensitivity
        Questions 2 and 3, as `contact` and `smallest`, and their derivatives.
    turn : TurnResult
        Question 4.
    fastest : MaxSpeed
        Question 5.
    last_slopes : dict
        Derivatives of the last handle's way along the path at the last time by the sizes, m per m:
        negative where the handle is further back.
    speed_slopes : dict
        Derivatives of the largest speed by the sizes, m/s per m.
    """

    march: March
    states: States
    sensitivity: Sensitivity
    turn: TurnResult
    fastest: MaxSpeed
    last_slopes: Mapping[str, float]
    speed_slopes: Mapping[str, float]

    @property
    def contact(self) -> FirstContact:
        """The first contact."""
        return self.sensitivity.contact

    @property
    def smallest(self) -> MinPitch:
        """The smallest pitch."""
        return self.sensitivity.smallest

    @property
    def errors(self) -> tuple[float, ...]:
        """Errors of the answers, in the order of the questions, in SI units.

        Question 1: the largest difference between the distance of two holes and their spacing.
        2: the largest overlap that the certificate does not rule out. 3: the distance to the
        certified pitches. 4: the difference between the length of the arcs and the closed form, at
        least a last digit. 5: the amount by which the speed may be smaller.
        """
        benches = np.diff(self.states.positions, axis=1)
        distances = np.linalg.norm(benches, axis=-1) - self.march.dragon.spacings
        turn = self.turn.turn
        half = math.atan(2 * math.pi * turn.radius / turn.pitch)
        length = 2 * half * turn.radius / math.sin(half)
        return (
            float(np.abs(distances).max()),
            self.contact.resolution or 0.0,
            self.smallest.clear_pitch - self.smallest.pitch,
            max(abs(turn.length - length), math.ulp(length)),
            self.fastest.excess * self.fastest.speed,
        )

    @property
    def slopes(self) -> tuple[Mapping[str, float | None], ...]:
        """Derivatives of the answers by the sizes; no size of the dragon changes the turn."""
        none = dict.fromkeys(self.speed_slopes, 0.0)
        contacts = self.sensitivity.times, self.sensitivity.pitches
        return self.last_slopes, *contacts, none, self.speed_slopes

    def to_dict(self) -> dict[str, Any]:
        """Values in SI units, as `study paper --json` prints them."""
        return {
            "states": self.states.to_dict(self.march.dragon.representatives),
            "contact": self.contact.to_dict(),
            "smallest_pitch": self.smallest.to_dict(),
            "turn": self.turn.to_dict(),
            "largest_speed": self.fastest.to_dict(),
            "errors": self.errors,
            "slopes": self.slopes,
        }

    def _lines(self) -> list[str]:
        results = [self.contact, self.sensitivity.smallest, self.turn, self.fastest]
        states = self.states.text(self.march.dragon.representatives)
        return ["\n\n".join([states, *map(str, [*results, self.sensitivity])])]


def paper(dragon: Dragon | None = None, *, progress: Progress = silent) -> Paper:
    """All five answers to the contest's questions for a dragon.

    Parameters
    ----------
    dragon : Dragon, optional
        The dragon; by default the contest's. Its benches but the head must be alike.
    progress : callable, optional
        Called with the part of the work that is done and the whole.

    Raises
    ------
    ParameterError
        If one of the questions has no answer for the dragon, as where it is too short to touch
        itself.

    Examples
    --------
    >>> found = paper(Dragon(benches=25))
    >>> print(f"{found.contact.time:.9f} s, {found.smallest.pitch:.6f} m")
    412.473837682 s, 0.450337 m
    """
    dragon = checked_dragon(dragon)
    function("progress", progress)
    sensed = sensitivity(dragon, progress=lambda done, total: progress(done, total + 1))

    def answers(dragon: Dragon) -> list[tuple[float, None]]:
        last = float(March(dragon).at(_TIMES[-1]).handles_s[0, -1])
        return [(last, None), (max_speed(dragon).speed, None)]

    last_slopes, speed_slopes = slopes(dragon, answers)
    march = March(dragon)
    found = Paper(
        march=march,
        states=march.at(_TIMES),
        sensitivity=sensed,
        turn=u_turn(dragon, search=False),
        fastest=max_speed(dragon),
        last_slopes=last_slopes,
        speed_slopes=speed_slopes,
    )
    progress(1, 1)
    return found
