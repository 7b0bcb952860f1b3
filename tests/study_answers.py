"""Answers of studies, each computed once for all test processes."""

from __future__ import annotations

import pickle
import sys
from collections.abc import Callable
from typing import Any

import pytest
from sharing import shared

from pymunk_dragon import Dragon, sensitivity
from pymunk_dragon.studies import Sensitivity


def answer(name: str, make: Callable[[], Any]) -> Any:
    """What `make` returns, from a file of this name that is made when it is needed first."""
    path = shared(f"{name}.pickle", lambda draft: draft.write_bytes(pickle.dumps(make())))
    return pickle.loads(path.read_bytes())


def slopes_by_width(**sizes: float) -> Sensitivity:
    """The sensitivity to one size only, of a shorter dragon, in a fraction of the time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys.modules["pymunk_dragon.studies.sensitivity"], "SIZES", ("width",))
        return sensitivity(Dragon(benches=25, **sizes))
