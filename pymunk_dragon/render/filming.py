"""The frames of a film, drawn and compressed here or by several processes."""

from __future__ import annotations

import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager
from dataclasses import dataclass
from itertools import islice
from multiprocessing import get_context, parent_process, resource_tracker
from multiprocessing.connection import wait
from multiprocessing.reduction import ForkingPickler

from pymunk_dragon.errors import DragonError
from pymunk_dragon.render.moments import Moment
from pymunk_dragon.render.sheet import Sheet
from pymunk_dragon.render.streams import Stream
from pymunk_dragon.render.streams.base import Patch, PatchStream, Table
from pymunk_dragon.signals import ENDING, signals_held

__all__ = ["expose"]

# What is to be seen of each scene of a sheet.
View = Sequence[Moment]
# Frames below which other processes are not worth their start.
WORTHWHILE = 150
# Frames in a batch, for which the last one of the batch before is drawn once more; batches that wait for each process;
# and batches that may wait to be written, some 10 MB of compressed frames of 640 x 640 pixels.
BATCH, QUEUE, AHEAD = 16, 2, 24


def expose(
    stream: Stream,
    sheet: Sheet,
    moments: Iterator[View],
    ends: Sequence[float],
    workers: int,
    tell: Callable[[int], None],
) -> None:
    """Add a frame for each of `moments` to a film, up to its end among `ends`, and `tell` how many there are.

    `workers` other processes help where that pays: not with the few frames of a short film, nor with a video, whose
    encoder is a process of its own already. Nor do they where the march cannot be handed over, as with a lambda for its
    speed.
    """
    if workers and len(ends) >= WORTHWHILE and isinstance(stream, PatchStream) and _is_portable(sheet):
        darkroom = Darkroom(sheet, type(stream), stream.table)
        with closing(_developed(darkroom, moments, workers)) as patches:
            for done, (patch, end) in enumerate(zip(patches, ends, strict=True), start=1):
                stream.put(patch, end)
                tell(done)
    else:
        for done, (moment, end) in enumerate(zip(moments, ends, strict=True), start=1):
            stream.add(sheet.draw(moment), end)
            tell(done)


def _is_portable(sheet: Sheet) -> bool:
    """Whether other processes can be told what to draw."""
    try:
        ForkingPickler.dumps(sheet)
    except Exception:
        # A lambda raises one kind, a class of a notebook another, and a user's own class whatever it likes.
        return False
    return True


@dataclass(frozen=True)
class Darkroom:
    """What a process needs to turn moments into patches."""

    sheet: Sheet
    kind: type[PatchStream]
    table: Table

    def patches(self, before: View | None, batch: Sequence[View]) -> list[Patch | None]:
        """Patches of the frames of a batch, the first from the frame of the moment `before`."""
        shown = None if before is None else self.sheet.draw(before)
        found = []
        for moment in batch:
            frame = self.sheet.draw(moment)
            found.append(self.kind.patch(frame, shown, self.table))
            shown = frame
        return found


def _developed(darkroom: Darkroom, moments: Iterator[View], workers: int) -> Generator[Patch | None]:
    """Patches of all frames, in their order. What the other processes have not begun, this one does itself."""
    batches = _batches(moments)
    # Spawned, because a fork of a program that has threads may hang.
    pool = ProcessPoolExecutor(workers, get_context("spawn"), initializer=_move_in, initargs=(darkroom,))
    coming: deque[Future[list[Patch | None]] | list[Patch | None]] = deque()
    try:
        while True:
            asked = sum(isinstance(batch, Future) and not batch.done() for batch in coming)
            for batch in islice(batches, max(0, min(QUEUE * workers - asked, AHEAD - len(coming)))):
                with _interrupts_held():
                    coming.append(pool.submit(_patches, *batch))
            if not coming:
                return
            first = coming[0]
            if isinstance(first, Future) and not first.done() and len(coming) < AHEAD:
                own = next(batches, None)
                if own is not None:
                    coming.append(darkroom.patches(*own))
                    continue
            coming.popleft()
            yield from first.result() if isinstance(first, Future) else first
    except BrokenProcessPool as error:
        raise DragonError("a process that drew the film was ended from outside; 0 workers need none") from error
    finally:
        pool.shutdown(cancel_futures=True)


def _batches(moments: Iterator[View]) -> Iterator[tuple[View | None, list[View]]]:
    """Moments a few at once, each time with the one before them."""
    before: View | None = None
    while batch := list(islice(moments, BATCH)):
        yield before, batch
        before = batch[-1]


_darkroom: Darkroom


def _move_in(darkroom: Darkroom) -> None:
    global _darkroom
    _darkroom = darkroom
    if hasattr(signal, "pthread_sigmask"):
        # Held while this process started; now they may end it. Ctrl-C is for the one that asked for the patches.
        signal.pthread_sigmask(signal.SIG_UNBLOCK, set(ENDING) - {signal.SIGINT})
    threading.Thread(target=_follow_parent, daemon=True).start()


def _follow_parent() -> None:
    """End when the process ends that asked for the patches, in whatever way it does."""
    parent = parent_process()
    assert parent is not None
    wait([parent.sentinel])
    os._exit(1)


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Let signals wait: a process that is started needs all that this one is writing to it.

    It will never hear of Ctrl-C, which a terminal sends to all processes. The one that asked for the patches tells the
    others to stop.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # It would let interrupts through when it starts, and it starts before the first process does.
    resource_tracker.ensure_running()
    with signals_held():
        before = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
        try:
            yield
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _patches(before: View | None, batch: Sequence[View]) -> list[Patch | None]:
    return _darkroom.patches(before, batch)
