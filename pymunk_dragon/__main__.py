"""The program `pymunk-dragon`, also `python -m pymunk_dragon`.

It handles signals before it imports anything else.
"""

import os
import signal
import sys
from contextlib import suppress
from types import FrameType


class _Interruption(KeyboardInterrupt):
    """A signal ends the program.

    Python would end itself with SIGINT after a KeyboardInterrupt in `exec`, as that of dataclasses.
    """


def main() -> None:
    """Run the program, and exit with the code of `status` or with 128 plus a signal's number."""
    received: list[int] = []

    def stop(number: int, frame: FrameType | None) -> None:
        received.append(number)
        raise _Interruption

    # Signals that nohup, or a shell that starts the program in the background, has it ignore stay
    # ignored. Windows has no SIGHUP.
    ending = {signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)}
    handled = [number for number in ending if signal.getsignal(number) != signal.SIG_IGN]
    # The program opens no windows; and matplotlib cannot be imported with an unknown backend in the
    # environment.
    os.environ["MPLBACKEND"] = "agg"
    code: int | None = None
    try:
        for number in handled:
            signal.signal(number, stop)
        from pymunk_dragon.cli import status

        code = status()
    except (KeyboardInterrupt, Exception):
        # Modules in C make errors of their own of an interruption of their import.
        if not received:
            raise
        # There may be no stderr, or no space on its disk.
        with suppress(AttributeError, OSError):
            sys.stderr.write("pymunk-dragon: interrupted\n")

    # Until Python has shut down.
    for number in handled:
        signal.signal(number, signal.SIG_IGN)
    sys.exit(128 + received[0] if received else code)


if __name__ == "__main__":
    main()
