"""`python -m pymunk_dragon` is `pymunk-dragon`. Signals are handled before anything else is imported."""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress
from time import monotonic
from types import FrameType

__all__ = ["main"]

# SIGALRM is the program's own: see AGAIN.
SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGALRM")
# s after a signal in which others are ignored, as the SIGHUP that follows SIGTERM: files are being removed.
GRACE = 2.0
# s until SIGALRM raises an exception again that Python could not raise, as where an object ends.
AGAIN = 1e-3


def main() -> None:
    """Run the program and exit as `pymunk_dragon.cli.main`; after a signal with 128 plus its number, files removed."""
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
            signal.setitimer(signal.ITIMER_REAL, AGAIN)
        else:
            sys.__unraisablehook__(lost)

    # What nohup, or a shell in the background, has the program ignore stays ignored.
    known = [getattr(signal, name) for name in SIGNALS if hasattr(signal, name)]
    handled = [number for number in known if signal.getsignal(number) != signal.SIG_IGN]
    try:
        for number in handled:
            signal.signal(number, stop)
        sys.unraisablehook = notice
        # The program opens no windows. matplotlib refuses to be imported where this holds what it does not know.
        os.environ["MPLBACKEND"] = "agg"
        import logging

        # Errors are one line; what the libraries log beside them is for their developers.
        logging.getLogger().addHandler(logging.NullHandler())
        from pymunk_dragon.cli import status

        code = status()
    except KeyboardInterrupt:
        # Outside the program, which has words of its own for it.
        with suppress(AttributeError, OSError):  # There may be no stderr, or a full disk.
            sys.stderr.write("pymunk-dragon: interrupted\n")
        code = 0
    for number in handled:
        # Python itself takes some time to end.
        signal.signal(number, signal.SIG_IGN)
    # Where the exception left code in a string, as dataclasses are made of, Python remembers that, and would end itself
    # with SIGINT however the exception was handled. Other code in a string makes it forget.
    exec("")
    sys.exit(128 + received[0] if received else code)


if __name__ == "__main__":
    main()
