"""Inputs of a recording that are carried out again."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterator, Sequence
from typing import Any

from pymunk_dragon.errors import DragonError

# s between two moments at which a waiting thread takes notice of Ctrl-C.
PATIENCE = 0.2


class Replay:
    """A recording that is repeated: each input is carried out before a certain step.

    Parameters
    ----------
    inputs : sequence of (int, dict)
        Numbers of the steps before which messages take effect, and these.
    steps : int
        Number of the last step.

    Examples
    --------
    >>> replay = Replay([(3, {"do": "cut", "joint": 1})], steps=5)
    >>> list(replay.due(2)), list(replay.due(3))
    ([], [(3, {'do': 'cut', 'joint': 1})])
    >>> replay.end(poses="")
    >>> replay.has_ended
    True
    """

    def __init__(self, inputs: Sequence[tuple[int, dict[str, Any]]], steps: int) -> None:
        self.steps = steps
        self._inputs = deque(inputs)
        self._ended = threading.Event()
        self._poses: str | None = None
        self._error: str | None = None

    @property
    def has_ended(self) -> bool:
        """Whether the replay has ended."""
        return self._ended.is_set()

    def due(self, step: int) -> Iterator[tuple[int, dict[str, Any]]]:
        """Remove and yield the inputs that take effect before this step."""
        while self._inputs and self._inputs[0][0] <= step:
            yield self._inputs.popleft()

    def end(self, *, poses: str | None = None, error: str | None = None) -> None:
        """End the replay with its last poses, with an error, or with neither if it is cancelled; only once."""
        if not self.has_ended:
            self._poses, self._error = poses, error
            self._ended.set()

    def wait(self) -> str | None:
        """Wait for the end, and return the last poses, or None if the replay was cancelled.

        Raises
        ------
        DragonError
            If an input cannot be carried out.
        """
        while not self._ended.wait(PATIENCE):
            pass
        if self._error is not None:
            raise DragonError(self._error)
        return self._poses
