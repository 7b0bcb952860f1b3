"""Sessions that have not ended: those of a notebook's cell, and those of a program at its end."""

import atexit
import sys
from importlib.util import find_spec
from typing import Any

from pymunk_dragon.sessions.session import Session

# Handles of sessions, with the cell that began each, and the number of the cell's run.
_OPEN: dict[Any, tuple[Session, str | None, int]] = {}


def begin(handle: Any, session: Session) -> None:
    """Note a session that begins, and end those of an earlier run of the same cell."""
    cell, run = None, 0
    if (shell := _shell()) is not None:
        # Without an identifier, a cell is known by its text.
        about = shell.kernel.get_parent().get("metadata", {})
        cell = about.get("cellId") or shell.user_ns["In"][-1]
        run = shell.execution_count
        for other, (_, its_cell, its_run) in [*_OPEN.items()]:
            if its_cell == cell and its_run != run:
                other.stop()
    _OPEN[handle] = session, cell, run


def forget(handle: object) -> None:
    """Take note that a session ends."""
    _OPEN.pop(handle, None)


def note(text: str) -> None:
    """Print a line on stderr."""
    sys.stderr.write(f"{text}\n")


def is_interactive() -> bool:
    """Whether somebody types commands, or runs cells."""
    return hasattr(sys, "ps1")


def has_widgets() -> bool:
    """Whether this runs in a notebook, for which anywidget is installed."""
    return _shell() is not None and find_spec("anywidget") is not None


def _shell() -> Any:
    """What runs the cells of a notebook, or None."""
    python = sys.modules.get("IPython")
    shell = python and python.get_ipython()
    return shell if getattr(shell, "kernel", None) is not None else None


@atexit.register
def _warn() -> None:
    """Say so if the program has ended before a session that it shows."""
    going_on = any(session.goes_on() for session, *_ in _OPEN.values())
    if going_on and not is_interactive():
        note("the program has ended, and its session with it: call its wait() at the end")
