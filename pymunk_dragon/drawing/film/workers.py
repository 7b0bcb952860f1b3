"""Applies a function to a sequence of items in parallel worker processes, and yields the results in order."""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager, suppress
from itertools import islice
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler
from pathlib import Path
from typing import Any, TypeVar

from pymunk_dragon._signals import signals_blocked, unblock_in_worker
from pymunk_dragon.errors import DragonError

Item = TypeVar("Item")
Result = TypeVar("Result")

# Items: for fewer the start of the worker processes takes longer than they save.
MIN_PARALLEL_ITEMS = 150
# Items per batch: enough to amortise the cost of sending a batch, few enough to limit memory.
BATCH_ITEMS = 8
# Batches that this process may have ready: about 10 MB of frames of 640 x 640 pixels.
READY_BATCHES = 3


def map_in_processes(
    function: Callable[[Item], Result], items: Iterator[Item], count: int, workers: int
) -> Generator[Result]:
    """Yield `function(item)` for the `count` items, in order.

    `workers` other processes and this one evaluate the function. This process does it alone if there are few items, or
    if `function` cannot be pickled, for example if the speed of the march is a lambda.

    Raises
    ------
    DragonError
        If a worker process was ended from outside.
    """
    pickled = _pickled(function) if workers and count >= MIN_PARALLEL_ITEMS else None
    if pickled is None:
        yield from map(function, items)
        return
    batches = iter(lambda: list(islice(items, BATCH_ITEMS)), [])
    # Spawned, because forking a program with threads can deadlock.
    context = get_context("spawn")
    processes = []
    # A worker has at most one batch. With a second one, it and this process could wait for each other to read.
    starting: list[Connection] = []
    idle: list[Connection] = []
    pending: deque[Connection | list[Result]] = deque()
    try:
        for _ in range(workers):
            connection, other_end = context.Pipe()
            process = context.Process(target=_work, args=(other_end,), daemon=True)
            processes.append(process)
            with signals_blocked():
                process.start()
            # So that the end of the worker ends the connection.
            other_end.close()
            starting.append(connection)
        while True:
            for connection in [connection for connection in starting if connection.poll()]:
                state = _state(connection, pickled)
                if state != "started":
                    starting.remove(connection)
                if state == "ready":
                    idle.append(connection)
            while idle and (batch := next(batches, None)):
                with _worker_failures_reported():
                    idle[-1].send(batch)
                pending.append(idle.pop())
            if not pending:
                # No worker has started, or all items are done.
                if not (own := next(batches, None)):
                    return
                yield from map(function, own)
                continue
            first = pending[0]
            waiting = isinstance(first, Connection) and not first.poll() and len(pending) < workers + READY_BATCHES
            if waiting and (own := next(batches, None)):
                pending.append([function(item) for item in own])
                continue
            pending.popleft()
            if isinstance(first, list):
                yield from first
                continue
            with _worker_failures_reported():
                results = first.recv()
            if isinstance(results, Exception):
                raise results
            if batch := next(batches, None):
                # The worker continues while this process uses the results.
                with _worker_failures_reported():
                    first.send(batch)
                pending.append(first)
            yield from results
    finally:
        for process in processes:
            if process.pid is not None:
                process.kill()
                process.join()


def _pickled(function: Callable[..., Any]) -> bytes | None:
    """Return a function in the form in which it is sent to other processes, or None if it cannot be sent."""
    main = sys.modules["__main__"]
    path = getattr(main, "__file__", None)
    if main.__spec__ is None and path is not None and not Path(path).exists():
        # A program from the standard input, which other processes cannot import.
        return None
    try:
        return bytes(ForkingPickler.dumps(function))
    except Exception:
        # The exception type differs between a lambda, a class defined in a notebook and a user's own class.
        return None


def _state(connection: Connection, pickled: bytes) -> str:
    """Return the state that a starting worker has sent: "started", and then "ready" or "unable"; send it the function.

    A worker that ends before it is ready is unable: the other processes do its work.
    """
    try:
        state: str = connection.recv()
        if state == "started":
            connection.send_bytes(pickled)
    except (EOFError, OSError):
        return "unable"
    return state


@contextmanager
def _worker_failures_reported() -> Iterator[None]:
    """Raise a `DragonError` if the worker process at the other end of a connection has ended."""
    try:
        yield
    except (EOFError, OSError) as error:
        raise DragonError("a process that drew the film was ended from outside; 0 workers need none") from error


def _work(connection: Connection) -> None:
    """Receive a function, and evaluate it for the batches that follow, until the parent process ends."""
    unblock_in_worker()
    with suppress(EOFError, OSError):
        connection.send("started")
        try:
            function: Callable[[Any], Any] = connection.recv()
        except (AttributeError, ImportError):
            # A class of the main program, which is not a file, as in a notebook.
            connection.send("unable")
            return
        connection.send("ready")
        while True:
            batch = connection.recv()
            results: list[Any] | Exception
            try:
                results = [function(item) for item in batch]
            except Exception as error:
                results = error
            connection.send(results)
