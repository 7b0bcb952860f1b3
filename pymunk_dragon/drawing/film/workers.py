"""Applies a function to a sequence of items in parallel worker processes, and yields the results in order."""

from __future__ import annotations

import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from itertools import islice
from multiprocessing import get_context, parent_process, resource_tracker
from multiprocessing.connection import wait
from multiprocessing.reduction import ForkingPickler
from typing import Any, TypeVar

from pymunk_dragon._signals import ENDING, signals_held
from pymunk_dragon.errors import DragonError

Item = TypeVar("Item")
Result = TypeVar("Result")

# Items: for fewer the start of the worker processes takes longer than they save.
MIN_PARALLEL_ITEMS = 150
# Items per batch: enough to amortise the cost of sending a batch, few enough to limit memory.
BATCH_ITEMS = 8
# Batches queued for each worker, so that no worker waits for its next batch.
BATCHES_PER_WORKER = 2
# Batches that may be ready before they are needed: about 10 MB of frames of 640 x 640 pixels.
READY_BATCHES = 3


def map_in_processes(
    function: Callable[[Item], Result], items: Iterator[Item], count: int, workers: int
) -> Generator[Result]:
    """Yield `function(item)` for the `count` items, in order.

    `workers` other processes and this one evaluate the function. This process does it alone if there are few items, or
    if `function` cannot be pickled, as the drawing of a march whose speed is a lambda.

    Raises
    ------
    DragonError
        If a worker process was ended from outside.
    """
    if not workers or count < MIN_PARALLEL_ITEMS or not _can_be_pickled(function):
        yield from map(function, items)
        return
    batches = iter(lambda: list(islice(items, BATCH_ITEMS)), [])
    # Spawned, because forking a program with threads can deadlock.
    pool = ProcessPoolExecutor(workers, get_context("spawn"), initializer=_initialise_worker, initargs=(function,))
    pending: deque[Future[list[Result]] | list[Result]] = deque()
    max_pending = BATCHES_PER_WORKER * workers + READY_BATCHES
    try:
        while True:
            running = sum(isinstance(batch, Future) and not batch.done() for batch in pending)
            free = min(BATCHES_PER_WORKER * workers - running, max_pending - len(pending))
            for batch in islice(batches, max(0, free)):
                with _signals_blocked():
                    pending.append(pool.submit(_apply, batch))
            if not pending:
                return
            first = pending[0]
            waiting = isinstance(first, Future) and not first.done() and len(pending) < max_pending
            if waiting and (own := next(batches, None)):
                pending.append([function(item) for item in own])
                continue
            pending.popleft()
            yield from first.result() if isinstance(first, Future) else first
    except BrokenProcessPool as error:
        raise DragonError("a process that drew the film was ended from outside; 0 workers need none") from error
    finally:
        pool.shutdown(cancel_futures=True)


def _can_be_pickled(function: Callable[..., Any]) -> bool:
    """Return whether a function can be sent to other processes."""
    try:
        ForkingPickler.dumps(function)
    except Exception:
        # The exception type differs between a lambda, a class defined in a notebook and a user's own class.
        return False
    return True


_function: Callable[[Any], Any]


def _initialise_worker(function: Callable[[Any], Any]) -> None:
    global _function
    _function = function
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


def _apply(batch: list[Any]) -> list[Any]:
    return [_function(item) for item in batch]
