"""Where the points of a sweep are evaluated: processes, a Dask cluster, or an executor of the user's."""

from __future__ import annotations

import logging
import os
import sys
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor
from contextlib import suppress
from multiprocessing import get_context, parent_process
from multiprocessing.process import BaseProcess
from multiprocessing.synchronize import Event
from time import monotonic, sleep
from typing import Any

from pymunk_dragon._extras import library
from pymunk_dragon._signals import signals_blocked, unblock_in_worker
from pymunk_dragon.errors import DragonError, ParameterError

# s until a Dask scheduler must answer.
CONNECT_TIMEOUT = 10
# s between counts of the workers of a Dask cluster, which may change.
COUNT_INTERVAL = 2.0
# s for which a Dask scheduler may be gone.
LOST_AFTER = 15.0
# s until a Dask scheduler has cancelled functions, and between checks.
CANCEL_TIMEOUT = 5.0
CANCEL_POLL = 0.02
# s for which a Dask scheduler may have no workers: one that starts them on demand takes minutes.
UNMANNED_AFTER = 300.0


class Workers(ABC):
    """Evaluate functions elsewhere; a context that ends with all of them stopped."""

    # Batches for each worker at a time: one that it evaluates, and one that waits for it.
    depth = 2
    # Exceptions of futures which say that a worker was lost.
    lost: tuple[type[BaseException], ...] = (BrokenExecutor,)
    # How often a worker may be lost that evaluates a single point and no other, until the point has failed.
    most_losses = 2
    _executor: Executor

    @property
    @abstractmethod
    def count(self) -> int:
        """Number of functions that can be evaluated at the same time."""

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Future result of a function; it needs `pickle` for arguments and result."""
        try:
            return self._executor.submit(function, *arguments)
        except BrokenExecutor as error:
            # The same as if it had broken a moment later.
            future: Future[Any] = Future()
            future.set_exception(error)
            return future
        except Exception as error:
            raise DragonError(f"the workers take no points any more: {error}") from error

    def check(self) -> None:  # noqa: B027  # Not every kind can be lost.
        """Raise a `DragonError` if no result can be expected any more."""

    @abstractmethod
    def restart(self, running: Sequence[Future[Any]]) -> bool:
        """Stop the workers that evaluate these, and start them anew; False if none evaluates any.

        Raises
        ------
        DragonError
            If this is not possible.
        """

    def close(self, *, abort: bool) -> None:  # noqa: B027  # An executor of the user's stays open.
        """Stop all workers; `abort` says whether something is still evaluated."""

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, kind: type[BaseException] | None, *rest: object) -> None:
        self.close(abort=kind is not None)


class Processes(Workers):
    """Processes on this machine, which are started anew instead of forked."""

    def __init__(self, count: int | None = None) -> None:
        self._count = count or _cores()
        self._start()

    @property
    def count(self) -> int:
        """Number of processes."""
        return self._count

    def _start(self) -> None:
        context = get_context("spawn")
        # Set when all processes are started: to an idle one the executor gives the next function, and starts no other.
        self._started = context.Event()
        self._executor = ProcessPoolExecutor(self._count, context, _begin_worker, (self._started,))
        self._processes: list[BaseProcess] = []
        try:
            with signals_blocked():
                first = [self._executor.submit(_cores) for _ in range(self._count)]
                self._processes += self._executor._processes.values()
            self._started.set()
            first[0].result()
        except BaseException as error:
            self.close(abort=True)
            if isinstance(error, BrokenExecutor):
                hint = 'a script calls sweep under `if __name__ == "__main__":`'
                raise DragonError(f"worker processes end as soon as they are started; {hint}") from error
            raise

    def restart(self, running: Sequence[Future[Any]]) -> bool:
        """Kill all processes, and start others."""
        self.close(abort=True)
        self._start()
        return True

    def close(self, *, abort: bool) -> None:
        """End all processes."""
        if abort:
            for process in self._processes:
                process.kill()
            for process in self._processes:
                process.join()
        # Its thread must have ended before the program does.
        self._executor.shutdown(cancel_futures=True)


class Dask(Workers):
    """Workers of a Dask scheduler at an address, or "local" for a scheduler and workers of its own."""

    # One more is sent to the worker, and the result of one is sent back.
    depth = 4
    # Dask itself evaluates it four times.
    most_losses = 1

    def __init__(self, scheduler: str, count: int | None = None) -> None:
        distributed = library("distributed")
        self.lost = (BrokenExecutor, distributed.KilledWorker)
        self._address = scheduler
        self._cluster: Any = None
        self._client: Any = None
        self._counted, self._counted_at = 0, -COUNT_INTERVAL
        try:
            if scheduler == "local":
                # Its processes inherit the blocked signals: a terminal sends them Ctrl-C as well.
                with signals_blocked():
                    self._cluster = distributed.LocalCluster(
                        n_workers=count or _cores(),
                        threads_per_worker=1,
                        dashboard_address="127.0.0.1:0",
                        silence_logs="CRITICAL",
                    )
            self._client = self._connected(distributed, self._cluster or scheduler)
            self._executor = self._client.get_executor(pure=False)
        except BaseException:
            self.close(abort=True)
            raise
        self._seen = self._manned = monotonic()

    @staticmethod
    def _connected(distributed: Any, scheduler: Any) -> Any:
        """A client of a scheduler."""
        try:
            if isinstance(scheduler, str):
                # A client with an address of another form waits for itself when it is closed.
                distributed.comm.get_address_host_port(scheduler)
                # It warns of results that were lost with a worker, which is no news: they are computed again.
                logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
            return distributed.Client(scheduler, timeout=CONNECT_TIMEOUT, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            bound = "local, or the address of a Dask scheduler that answers, such as tcp://HOST:8786"
            raise ParameterError("scheduler", scheduler, bound) from error

    @property
    def count(self) -> int:
        """Number of threads of all workers."""
        if monotonic() - self._counted_at > COUNT_INTERVAL:
            with suppress(OSError, TimeoutError):
                self._counted = sum(self._client.nthreads().values())
            self._counted_at = monotonic()
            if self._counted:
                self._manned = self._counted_at
        return max(1, self._counted)

    def check(self) -> None:
        """Raise a `DragonError` if the scheduler or all workers were lost."""
        if self._client.status == "running":
            self._seen = monotonic()
        elif monotonic() - self._seen > LOST_AFTER:
            raise DragonError(f"the Dask scheduler {self._address} does not answer any more")
        if self.count and monotonic() - self._manned > UNMANNED_AFTER:
            raise DragonError(f"the Dask scheduler {self._address} has no workers")

    def restart(self, running: Sequence[Future[Any]]) -> bool:
        """Restart the workers that evaluate points."""
        ours = set(self._client.futures)
        busy = self._evaluating(ours)
        if not busy:
            return False
        for future in running:
            future.cancel()
        # Otherwise the scheduler would send them to other workers.
        end = monotonic() + CANCEL_TIMEOUT
        while self._evaluating(ours) and monotonic() < end:
            sleep(CANCEL_POLL)
        try:
            self._client.restart_workers(busy, raise_for_error=False)
        except ValueError as error:
            raise DragonError(f"a point takes too long, and its worker cannot be restarted: {error}") from error
        return True

    def _evaluating(self, ours: Collection[str]) -> list[str]:
        """The workers that have some of these tasks."""
        return [worker for worker, keys in self._client.processing().items() if not set(keys).isdisjoint(ours)]

    def close(self, *, abort: bool) -> None:
        """Close the connection, and a scheduler of its own."""
        with suppress(OSError, TimeoutError, CancelledError):
            if self._client is not None:
                self._client.close()
        with suppress(OSError, TimeoutError, CancelledError):
            if self._cluster is not None:
                self._cluster.close()


class Borrowed(Workers):
    """An executor of the user's, which is neither restarted nor closed."""

    def __init__(self, executor: Executor, count: int | None = None) -> None:
        if not isinstance(executor, Executor):
            raise ParameterError("executor", executor, "a concurrent.futures.Executor")
        # Those of the standard library have this attribute.
        self._count = count or getattr(executor, "_max_workers", None) or _cores()
        self._executor = executor

    @property
    def count(self) -> int:
        """Number of workers, as far as it is known."""
        return self._count

    def restart(self, running: Sequence[Future[Any]]) -> bool:
        """Raise a `DragonError`."""
        raise DragonError("a worker of the executor was lost; a sweep restarts only workers of its own")


def _cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _begin_worker(started: Event) -> None:
    """Prepare a worker process: it ends when its parent does, even if that was killed."""
    unblock_in_worker()
    # What a quantity prints is not part of a table on stdout.
    os.dup2(2 if sys.stderr else os.open(os.devnull, os.O_WRONLY), 1)
    parent = parent_process()
    assert parent is not None  # This is a worker process.

    def end() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=end, daemon=True).start()
    started.wait()
