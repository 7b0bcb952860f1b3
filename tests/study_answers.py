"""Answers of studies, each computed once for all test processes."""

import pickle
import sys

import pytest
from sharing import shared

from pymunk_dragon import Dragon, sensitivity


def answer(name, make):
    """What `make` returns, from a file of this name that is made when it is needed first."""
    path = shared(f"{name}.pickle", lambda draft: draft.write_bytes(pickle.dumps(make())))
    return pickle.loads(path.read_bytes())


def slopes_by_width(**sizes):
    """The sensitivity to one size only, of a shorter dragon, in a fraction of the time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys.modules["pymunk_dragon.studies.sensitivity"], "_SIZES", ("width",))
        return sensitivity(Dragon(benches=25, **sizes))
