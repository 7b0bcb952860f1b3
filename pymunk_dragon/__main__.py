"""The program `pymunk-dragon`, also `python -m pymunk_dragon`. It handles signals before it imports anything else."""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress
from time import monotonic
from types import FrameType

# Signals that end the program. SIGALRM is sent by the program itself, see RETRY.
SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGALRM")
# s after a signal in which others are ignored, as a SIGHUP after SIGTERM, while files are removed.
GRACE = 2.0
# s until SIGALRM raises the exception again, if Python could not raise it, as in a finalizer.
RETRY = 1e-3


def main() -> None:
    """Run the program and exit with the code of `pymunk_dragon.cli.status`, or with 128 plus the number of a signal."""
    received: list[int] = []
    last = -GRACE

    def stop(number: int, frame: FrameType | None) -> None:
        nonlocal last
        received.append(number)
        if monotonic() - last >= GRACE:
            last = monotonic()
            raise KeyboardInterrupt

    def notice(lost: sys.UnraisableHookArgs) -> None:
        nonlocal last
        if issubclass(lost.exc_type, KeyboardInterrupt) and hasattr(signal, "setitimer"):
            last = -GRACE
            signal.setitimer(signal.ITIMER_REAL, RETRY)
        else:
            sys.__unraisablehook__(lost)

    # Signals that nohup, or a shell that starts it in the background, has the program ignore stay ignored.
    known = [getattr(signal, name) for name in SIGNALS if hasattr(signal, name)]
    handled = [number for number in known if signal.getsignal(number) != signal.SIG_IGN]
    try:
        for number in handled:
            signal.signal(number, stop)
        sys.unraisablehook = notice
        # The program opens no windows; and matplotlib cannot be imported with an unknown backend in the environment.
        os.environ["MPLBACKEND"] = "agg"
        import logging

        # Errors are one line; log messages of libraries are dropped.
        logging.getLogger().addHandler(logging.NullHandler())
        from pymunk_dragon.cli import status

        code = status()
    except KeyboardInterrupt:
        # Before or after `status`, which prints this itself.
        with suppress(AttributeError, OSError):  # There may be no stderr, or no space on its disk.
            sys.stderr.write("pymunk-dragon: interrupted\n")
        code = 0
    for number in handled:
        # Until Python has shut down.
        signal.signal(number, signal.SIG_IGN)
    # If the exception left code that was compiled from a string, as that of dataclasses, Python sets a flag and later
    # ends itself with SIGINT although the exception was handled. Running other code from a string clears the flag.
    exec("")
    sys.exit(128 + received[0] if received else code)


if __name__ == "__main__":
    main()
