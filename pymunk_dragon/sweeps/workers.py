"""Where the points of a sweep are evaluated: processes, a Dask cluster, or an executor of the user's."""

from __future__ import annotations

import os
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor
from contextlib import suppress
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.process import BaseProcess
from time import monotonic
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


class Workers(ABC):
    """Evaluate functions elsewhere; a context that ends with all of them stopped."""

    # Batches for each worker at a time: one that it evaluates, and one that waits for it.
    depth = 2
    # Exceptions of futures which say that a worker was lost.
    lost: tuple[type[BaseException], ...] = (BrokenExecutor,)

    @property
    @abstractmethod
    def count(self) -> int:
        """Number of functions that can be evaluated at the same time."""

    @abstractmethod
    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Future result of a function; it needs `pickle` for arguments and result."""

    def check(self) -> None:  # noqa: B027  # Not every kind can be lost.
        """Raise a `DragonError` if no result can be expected any more."""

    @abstractmethod
    def restart(self, running: Sequence[Future[Any]]) -> None:
        """Stop the workers that evaluate these, and start them anew; a `DragonError` if this is not possible."""

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
        self._pool = ProcessPoolExecutor(self._count, get_context("spawn"), _begin_worker)
        others = active_children()
        with signals_blocked():
            # The first function starts all processes.
            self._pool.submit(_cores)
        self._processes: list[BaseProcess] = [process for process in active_children() if process not in others]

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Future result of a function."""
        try:
            return self._pool.submit(function, *arguments)
        except BrokenExecutor as error:
            # The same as if it had broken a moment later.
            future: Future[Any] = Future()
            future.set_exception(error)
            return future

    def restart(self, running: Sequence[Future[Any]]) -> None:
        """Kill all processes, and start others."""
        self.close(abort=True)
        self._start()

    def close(self, *, abort: bool) -> None:
        """End all processes."""
        self._pool.shutdown(wait=not abort, cancel_futures=True)
        if abort:
            for process in self._processes:
                process.kill()
            for process in self._processes:
                process.join()


class Dask(Workers):
    """Workers of a Dask scheduler at an address, or "local" for a scheduler and workers of its own."""

    # One more is on its way to the worker, and one on its way back.
    depth = 4

    def __init__(self, scheduler: str, count: int | None = None) -> None:
        distributed = library("distributed")
        self._cluster: Any = None
        if scheduler == "local":
            self._cluster = distributed.LocalCluster(
                n_workers=count or _cores(),
                threads_per_worker=1,
                dashboard_address="127.0.0.1:0",
                silence_logs="CRITICAL",
            )
        try:
            self._client: Any = distributed.Client(
                self._cluster or scheduler, timeout=CONNECT_TIMEOUT, set_as_default=False
            )
        except (OSError, ValueError, TypeError) as error:
            bound = "local, or the address of a Dask scheduler that answers, such as tcp://HOST:8786"
            raise ParameterError("scheduler", scheduler, bound) from error
        self.lost = (BrokenExecutor, distributed.KilledWorker)
        self._executor: Executor = self._client.get_executor(pure=False)
        self._address = scheduler
        self._counted, self._counted_at = 0, -COUNT_INTERVAL
        self._seen = monotonic()

    @property
    def count(self) -> int:
        """Number of threads of all workers."""
        if monotonic() - self._counted_at > COUNT_INTERVAL:
            with suppress(OSError, TimeoutError):
                self._counted = sum(self._client.nthreads().values())
            self._counted_at = monotonic()
        return max(1, self._counted)

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Future result of a function, which Dask computes again if it lost a worker."""
        return self._executor.submit(function, *arguments)

    def check(self) -> None:
        """Raise a `DragonError` if the scheduler was lost."""
        if self._client.status == "running":
            self._seen = monotonic()
        elif monotonic() - self._seen > LOST_AFTER:
            raise DragonError(f"the Dask scheduler {self._address} does not answer any more")

    def restart(self, running: Sequence[Future[Any]]) -> None:
        """Restart the workers that evaluate points."""
        if not running:
            return
        busy = [worker for worker, keys in self._client.processing().items() if any(map(_is_ours, keys))]
        for future in running:
            # Or the scheduler would send them to other workers.
            future.cancel()
        self._client.restart_workers(busy, raise_for_error=False)

    def close(self, *, abort: bool) -> None:
        """Close the connection, and a scheduler of its own."""
        with suppress(OSError, TimeoutError, CancelledError):
            self._executor.shutdown(wait=not abort)
            self._client.close()
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

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Future result of a function."""
        return self._executor.submit(function, *arguments)

    def restart(self, running: Sequence[Future[Any]]) -> None:
        """Raise a `DragonError`."""
        raise DragonError("a worker of the executor was lost; a sweep restarts only workers of its own")


def _is_ours(key: object) -> bool:
    """Whether a task of Dask evaluates points: its key begins with the name of the function."""
    return str(key).startswith("evaluate-")


def _cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _begin_worker() -> None:
    """Prepare a worker process: it ends when its parent does, even if that was killed."""
    unblock_in_worker()
    parent = parent_process()
    assert parent is not None

    def end() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=end, daemon=True).start()
