"""The program `pymunk-dragon`, also `python -m pymunk_dragon`. It handles signals before it imports anything else."""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress
from threading import Timer
from time import monotonic
from types import FrameType

from pymunk_dragon._signals import ENDING

# s after a signal in which others are ignored, as a SIGHUP after SIGTERM, while files are removed;
# and until a signal is repeated, which is more than a finalizer takes.
_GRACE, _REPETITION = 2.0, 0.05


class _Interruption(KeyboardInterrupt):
    """A signal ends the program. Python ends itself with SIGINT where the class is exactly KeyboardInterrupt."""


def main() -> None:
    """Run the program and exit with the code of `pymunk_dragon.cli.status`, or with 128 plus the number of a signal."""
    received: list[tuple[int, float]] = []

    def stop(number: int, frame: FrameType | None) -> None:
        if code is None and (not received or monotonic() - received[-1][1] >= _GRACE):
            received.append((number, monotonic()))
            raise _Interruption

    def unraisable(ignored: sys.UnraisableHookArgs) -> None:
        """Repeat a signal after the finalizer or hook that it interrupted: Python ignores exceptions there."""
        if ignored.exc_type is not _Interruption:
            sys.__unraisablehook__(ignored)
        elif os.name == "posix":
            # A signal of the process also ends a wait of the main thread.
            Timer(_REPETITION, os.kill, (os.getpid(), received.pop()[0])).start()
        else:
            Timer(_REPETITION, signal.raise_signal, (received.pop()[0],)).start()

    # Signals that nohup, or a shell that starts it in the background, has the program ignore stay
    # ignored.
    handled = [number for number in ENDING if signal.getsignal(number) != signal.SIG_IGN]
    code: int | None = None  # Until everything is done.
    sys.unraisablehook = unraisable
    try:
        for number in handled:
            signal.signal(number, stop)
        # The program opens no windows; and matplotlib cannot be imported with an unknown backend in
        # the environment.
        os.environ["MPLBACKEND"] = "agg"
        from pymunk_dragon.cli import status

        code = status()
    except (KeyboardInterrupt, Exception):
        # Before or after `status`, which prints this itself. Python makes other errors of some
        # interruptions.
        if not received:
            raise
        with suppress(AttributeError, OSError):  # There may be no stderr, or no space on its disk.
            sys.stderr.write("pymunk-dragon: interrupted\n")
    for number in handled:
        signal.signal(number, signal.SIG_IGN)  # Until Python has shut down.
    sys.exit(128 + received[0][0] if received else code)


if __name__ == "__main__":
    main()
