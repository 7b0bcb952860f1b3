"""Files that one test process makes for all of them."""

import os
from collections.abc import Callable
from pathlib import Path

from filelock import FileLock

from pymunk_dragon import Run

# Environment variable that names the folder of these files; `conftest.py` sets it.
FOLDER = "PYMUNK_DRAGON_TESTS_SHARED"


def shared(name: str, make: Callable[[Path], object]) -> Path:
    """The file or folder `name`, written by `make(path)` when it is needed first."""
    path = Path(os.environ[FOLDER]) / name
    with FileLock(f"{path}.lock"):
        if not path.exists():
            draft = path.parent / "drafts" / name
            draft.parent.mkdir(exist_ok=True)
            make(draft)
            draft.rename(path)
    return path


def shared_run(name: str, play: Callable[[], Run]) -> Run:
    """The run that `play` returns, played once for all test processes."""
    return Run.load(shared(f"{name}.npz", lambda path: play().save(path)))
