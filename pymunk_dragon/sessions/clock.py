"""When steps, pictures and values of charts are due, and how many events a second are sent."""

import math
from collections.abc import Callable

# Least time between two pictures, s.
_FRAME_TIME = 1 / 60
# Time between two values of a chart, s.
_PLOT_TIME = 0.1
# Most time of steps that a slow computer makes up for, s.
_MAX_DEBT = 0.1
# Events that clients get in a second: more cannot be read.
_MAX_EVENTS = 20


class Clock:
    """Times at which steps and pictures are due; `read` returns the present time, s."""

    def __init__(self, read: Callable[[], float], *, running: bool) -> None:
        self.read = read
        self.running = running
        # Simulated time over real time.
        self.speed = 1.0
        # Steps to be made while the clock does not run.
        self.single_steps = 0
        begin = read()
        self._step_due = begin
        self._frame_due = begin
        self._plot_due = begin

    def play(self) -> None:
        """Let steps be due in real time."""
        self.running = True

    def pause(self) -> None:
        """Let no step be due."""
        self.step(0)

    def step(self, count: int) -> None:
        """Let so many steps be due at once, and none afterwards."""
        self.running = False
        self.single_steps = count

    def step_is_due(self, now: float) -> bool:
        """Whether a step is due.

        Time while the clock did not run, and a large debt, are not made up for.
        """
        if not self.running:
            self._step_due = now
            return self.single_steps > 0

        self._step_due = max(self._step_due, now - _MAX_DEBT)
        return now >= self._step_due or self.single_steps > 0

    def frame_is_due(self, now: float, *, before_step: bool) -> bool:
        """Whether a picture is due: a step comes before it, until it is late by one picture."""
        return now >= self._frame_due + (_FRAME_TIME if before_step else 0.0)

    def plot_is_due(self, now: float) -> bool:
        """Whether values of charts are due; if so, the next ones are due later."""
        is_due = self.running and now >= self._plot_due
        if is_due:
            self._plot_due = now + _PLOT_TIME
        return is_due

    def step_was_made(self, length: float) -> None:
        """Let the next step be due after the `length` of this one, s."""
        self.single_steps = max(self.single_steps - 1, 0)
        self._step_due += length / self.speed

    def frame_was_made(self) -> None:
        """Let the next picture be due: at even intervals, but none is made up for."""
        self._frame_due = max(self._frame_due + _FRAME_TIME, self.read())

    def wait(self, *, with_frames: bool) -> float:
        """The time until a step or, with clients, a picture is due, s."""
        if self.single_steps > 0:
            return 0.0
        step_due = self._step_due if self.running else math.inf
        frame_due = self._frame_due if with_frames else math.inf
        return max(min(step_due, frame_due) - self.read(), 0.0)


class EventLimit:
    """Passes on a number of events a second, and counts the others."""

    def __init__(self) -> None:
        self._second = 0.0
        self._count = 0

    def passed(self, texts: list[str], now: float) -> list[str]:
        """The texts of events to send.

        The first ones of a second follow the number of those that were left out before.
        """
        # The catalogue of translations has the names of fields, here {i}.
        i = self._count - _MAX_EVENTS
        if now - self._second >= 1:
            self._second = now
            self._count = 0
            if i > 0:
                texts = [f"{i} further events in a second", *texts]
        passed = texts[: max(_MAX_EVENTS - self._count, 0)]
        self._count += len(texts)
        return passed

    def forget(self) -> None:
        """Forget the number of events left out."""
        self._count = min(self._count, _MAX_EVENTS)
