"""Answers of studies, each computed once for all test processes."""

from __future__ import annotations

import pickle
import sys
from collections.abc import Callable
from typing import Any

import pytest
from sharing import shared

from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.studies import MaxSpeed, MinPitch, Sensitivity, max_speed, min_pitch, sensitivity


def answer(name: str, make: Callable[[], Any]) -> Any:
    """What `make` returns, from a file of this name that is made when it is needed first."""
    path = shared(f"{name}.pickle", lambda draft: draft.write_bytes(pickle.dumps(make())))
    return pickle.loads(path.read_bytes())


def smallest_pitch() -> MinPitch:
    return answer("min-pitch", min_pitch)


def largest_speed() -> MaxSpeed:
    return answer("max-speed", max_speed)


def slopes() -> Sensitivity:
    return answer("sensitivity", sensitivity)


def slopes_by_width() -> Sensitivity:
    """The same by one size only, of a shorter dragon, in a fraction of the time."""

    def make() -> Sensitivity:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(sys.modules["pymunk_dragon.studies.sensitivity"], "SIZES", ("width",))
            return sensitivity(Dragon(benches=25))

    return answer("sensitivity-by-width", make)
