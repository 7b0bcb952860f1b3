"""Draws and encodes the frames of a film, in this process or in parallel worker processes."""

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

from pymunk_dragon._signals import ENDING, signals_held
from pymunk_dragon.drawing.canvas import Canvas
from pymunk_dragon.drawing.moments import Moment
from pymunk_dragon.drawing.streams import Stream
from pymunk_dragon.drawing.streams.base import DirtyRectangle, DirtyRectangleStream, Table
from pymunk_dragon.errors import DragonError

__all__ = ["encode_frames"]

# Moments of one frame, one for each scene of the canvas.
FrameMoments = Sequence[Moment]
# Changes from frame to frame; None is no change.
Changes = list[DirtyRectangle | None]
# Frames: in a shorter film the start of the worker processes takes longer than they save.
MIN_PARALLEL_FRAMES = 150
# Frames per batch. A batch also draws the last frame of the previous batch, so this overhead is 1 in 16.
BATCH_FRAMES = 16
# Batches queued for each worker, so that no worker waits for its next batch.
BATCHES_PER_WORKER = 2
# Batches that may wait to be written: about 10 MB of compressed frames of 640 x 640 pixels.
MAX_PENDING_BATCHES = 24


def encode_frames(
    stream: Stream,
    canvas: Canvas,
    moments: Iterator[FrameMoments],
    ends: Sequence[float],
    workers: int,
    progress: Callable[[int], None],
) -> None:
    """Add a frame to a film for each of `moments`, each shown until its time in `ends`, s.

    `progress` is called with the number of frames done. `workers` other processes draw and compress frames, except for
    a film of few frames, for a video (FFmpeg is a process of its own), and for a canvas that cannot be pickled, such
    as one of a march whose speed is a lambda.
    """
    if (
        workers
        and len(ends) >= MIN_PARALLEL_FRAMES
        and isinstance(stream, DirtyRectangleStream)
        and _can_be_pickled(canvas)
    ):
        context = WorkerContext(canvas, type(stream), stream.table)
        with closing(_encoded_in_parallel(context, moments, workers)) as changes:
            for done, (change, end) in enumerate(zip(changes, ends, strict=True), start=1):
                stream.put(change, end)
                progress(done)
    else:
        for done, (moment, end) in enumerate(zip(moments, ends, strict=True), start=1):
            stream.add(canvas.draw(moment), end)
            progress(done)


def _can_be_pickled(canvas: Canvas) -> bool:
    """Return whether a canvas can be sent to other processes."""
    try:
        ForkingPickler.dumps(canvas)
    except Exception:
        # The exception type differs between a lambda, a class defined in a notebook and a user's own class.
        return False
    return True


@dataclass(frozen=True)
class WorkerContext:
    """Data that a worker process needs to encode frames."""

    canvas: Canvas
    stream_type: type[DirtyRectangleStream]
    table: Table

    def encode(self, before: FrameMoments | None, batch: Sequence[FrameMoments]) -> Changes:
        """Encode the frames of a batch; `before` holds the moments of the frame before the batch."""
        previous = None if before is None else self.canvas.draw(before)
        changes = []
        for moment in batch:
            frame = self.canvas.draw(moment)
            changes.append(self.stream_type.encode(frame, previous, self.table))
            previous = frame
        return changes


def _encoded_in_parallel(
    context: WorkerContext, moments: Iterator[FrameMoments], workers: int
) -> Generator[DirtyRectangle | None]:
    """Yield the changes of all frames in order. This process encodes batches too while it waits for the workers."""
    batches = _batches(moments)
    # Spawned, because forking a program with threads can deadlock.
    pool = ProcessPoolExecutor(workers, get_context("spawn"), initializer=_initialise_worker, initargs=(context,))
    pending: deque[Future[Changes] | Changes] = deque()
    try:
        while True:
            running = sum(isinstance(batch, Future) and not batch.done() for batch in pending)
            free = min(BATCHES_PER_WORKER * workers - running, MAX_PENDING_BATCHES - len(pending))
            for batch in islice(batches, max(0, free)):
                with _signals_blocked():
                    pending.append(pool.submit(_encode, *batch))
            if not pending:
                return
            first = pending[0]
            if isinstance(first, Future) and not first.done() and len(pending) < MAX_PENDING_BATCHES:
                own = next(batches, None)
                if own is not None:
                    pending.append(context.encode(*own))
                    continue
            pending.popleft()
            yield from first.result() if isinstance(first, Future) else first
    except BrokenProcessPool as error:
        raise DragonError("a process that drew the film was ended from outside; 0 workers need none") from error
    finally:
        pool.shutdown(cancel_futures=True)


def _batches(moments: Iterator[FrameMoments]) -> Iterator[tuple[FrameMoments | None, list[FrameMoments]]]:
    """Split moments into batches, each with the moments of the frame before the batch."""
    before: FrameMoments | None = None
    while batch := list(islice(moments, BATCH_FRAMES)):
        yield before, batch
        before = batch[-1]


_context: WorkerContext


def _initialise_worker(context: WorkerContext) -> None:
    global _context
    _context = context
    if hasattr(signal, "pthread_sigmask"):
        # Signals were blocked while this process started. Ctrl-C stays blocked: the parent process handles it.
        signal.pthread_sigmask(signal.SIG_UNBLOCK, set(ENDING) - {signal.SIGINT})
    threading.Thread(target=_exit_with_parent, daemon=True).start()


def _exit_with_parent() -> None:
    """End this process when its parent process ends for any reason."""
    parent = parent_process()
    assert parent is not None
    wait([parent.sentinel])
    os._exit(1)


@contextmanager
def _signals_blocked() -> Iterator[None]:
    """Block signals while a worker starts, so that the data written to the new process arrives completely.

    The worker inherits the blocked Ctrl-C, which a terminal sends to all processes; the parent process stops the
    workers.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # The resource tracker unblocks interrupts when it starts, so it must run before signals are blocked.
    resource_tracker.ensure_running()
    with signals_held():
        before = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
        try:
            yield
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _encode(before: FrameMoments | None, batch: Sequence[FrameMoments]) -> Changes:
    return _context.encode(before, batch)
