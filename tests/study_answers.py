"""Answers of studies, each computed once for all test processes."""

import pickle

from sharing import shared


def answer(name, make):
    """What `make` returns, from a file of this name that is made when it is needed first."""
    path = shared(f"{name}.pickle", lambda draft: draft.write_bytes(pickle.dumps(make())))
    return pickle.loads(path.read_bytes())
