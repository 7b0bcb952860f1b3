"""The frames of a film, drawn and compressed here or by several processes."""

from __future__ import annotations

import signal
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import closing
from dataclasses import dataclass
from itertools import islice
from multiprocessing import get_context

from pymunk_dragon.render.moments import Moment
from pymunk_dragon.render.sheet import Sheet
from pymunk_dragon.render.streams import Stream
from pymunk_dragon.render.streams.base import Patch, PatchStream, Table

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
    encoder is a process of its own already.
    """
    if workers and len(ends) >= WORTHWHILE and isinstance(stream, PatchStream):
        darkroom = Darkroom(sheet, type(stream), stream.table)
        with closing(_developed(darkroom, moments, workers)) as patches:
            for done, (patch, end) in enumerate(zip(patches, ends, strict=True), start=1):
                stream.put(patch, end)
                tell(done)
    else:
        for done, (moment, end) in enumerate(zip(moments, ends, strict=True), start=1):
            stream.add(sheet.draw(moment), end)
            tell(done)


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
            for batch in islice(batches, QUEUE * workers - asked):
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
    # Ctrl-C goes to every process of a terminal; the one that asked for the patches tells the others to stop.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _patches(before: View | None, batch: Sequence[View]) -> list[Patch | None]:
    return _darkroom.patches(before, batch)
