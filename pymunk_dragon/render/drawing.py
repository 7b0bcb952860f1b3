"""Frames, drawn here or in processes of their own."""

from __future__ import annotations

import signal
from collections import deque
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from itertools import islice
from multiprocessing import get_context

from PIL import Image

from pymunk_dragon.render.moments import Moment
from pymunk_dragon.render.sheet import Sheet

__all__ = ["drawn"]

# Frames below which other processes are not worth their start.
WORTHWHILE = 300
# Frames in one task, and tasks for each process that are drawn ahead of the encoder.
BATCH, AHEAD = 8, 2

_sheet: Sheet


def drawn(sheet: Sheet, moments: Iterator[Sequence[Moment]], frames: int, workers: int) -> Generator[Image.Image]:
    """Pictures of all `moments`, in their order; by `workers` processes if there are enough `frames` to draw."""
    if workers == 1 or frames < WORTHWHILE:
        yield from map(sheet.draw, moments)
        return
    # Spawned, because a fork of a program that has threads may hang.
    pool = ProcessPoolExecutor(workers, get_context("spawn"), initializer=_prepare, initargs=(sheet,))
    try:
        coming: deque[Future[list[bytes]]] = deque()
        while True:
            while len(coming) < AHEAD * workers and (batch := list(islice(moments, BATCH))):
                coming.append(pool.submit(_pixels, batch))
            if not coming:
                return
            for pixels in coming.popleft().result():
                yield Image.frombytes("L", sheet.size, pixels)
    finally:
        pool.shutdown(cancel_futures=True)


def _prepare(sheet: Sheet) -> None:
    global _sheet
    _sheet = sheet
    # Ctrl-C goes to every process of a terminal; the one that asked for the frames tells the others to stop.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _pixels(batch: list[Sequence[Moment]]) -> list[bytes]:
    return [_sheet.draw(moments).tobytes() for moments in batch]
