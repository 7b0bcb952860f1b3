"""A quantity at many points, evaluated in parallel."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from functools import partial as partial_of
from importlib.metadata import version
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.spawn import get_executable
from pathlib import Path
from queue import SimpleQueue
from threading import Thread, current_thread, main_thread
from time import perf_counter
from types import FrameType
from typing import Any
from zlib import crc32

from pymunk_dragon._checks import flag, function, instance, instances, whole
from pymunk_dragon._extras import library
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.scenario import Scenario
from pymunk_dragon.sweeps.axes import Axes, axes_of, base_values, given_values, reference_values
from pymunk_dragon.sweeps.partial import PartialTable
from pymunk_dragon.sweeps.quantities import Outcome, Quantity, Values, evaluate, quantity_of
from pymunk_dragon.sweeps.refine import finer, rounds
from pymunk_dragon.sweeps.result import Sweep, check_format

# A function that submits calls to workers.
_Submit = Callable[..., Future[Outcome]]

# Futures that are submitted and not finished, at most: enough for as many workers, and few in
# memory.
_MAX_RUNNING = 256
# Worker processes, at most: Windows waits for no more.
_MAX_WORKERS = 61 if os.name == "nt" else 1000
# Times that the distance between neighbours is halved, at most: to a thousandth.
_MAX_HALVINGS = 10
# Processors for this process, of which each worker gets one.
_CORES = min(os.cpu_count() or 1, _MAX_WORKERS)
if hasattr(os, "sched_getaffinity"):
    _CORES = len(os.sched_getaffinity(0))

# Signals that end the program. Windows has no SIGHUP.
_ENDING = {signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)}


def sweep(
    scenario: Scenario | March | Mapping[str, Any] | None = None,
    axes: Mapping[str, Sequence[float]] | None = None,
    quantity: str | Callable[..., Values] = "contact-time",
    executor: Executor | None = None,
    out: str | Path | Sequence[str | Path] = (),
    *,
    refine: int = 0,
    resume: bool = False,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], object] = lambda done, total: None,
) -> Sweep:
    r"""Compute a quantity of a dragon at many values of its parameters, in parallel.

    Parameters
    ----------
    scenario : Scenario, March or mapping, optional
        The dragon and its curve; a mapping has values of a scenario's parameters. By default the
        reference scenario.
    axes : mapping
        Names of parameters, of the scenario or of the quantity, and values of each. The points are
        all combinations.
    quantity : str or callable
        One of `QUANTITIES`, or an importable function of a march, as itself or as
        ``"module:function"``, that returns numbers or texts by name. Its keyword-only parameters
        may be axes.
    executor : concurrent.futures.Executor, optional
        Evaluates the points; by default new processes. They import a script, which calls `sweep`
        under ``if __name__ == "__main__":``.
    out : path or sequence of paths, optional
        Files to write: .csv, or .png, .svg or .pdf for a picture of one or two axes. Until then,
        finished points are in a partial table beside the first one, with the ending ``.partial``.
    refine : int
        How often the distance between neighbours of different kinds is halved, on the lines of the
        grid: where the benches that touch change, or another whole number, or else a text.
    resume : bool
        Whether to go on from the partial table of an interrupted sweep, if there is one.
    scheduler : str, optional
        Address of a Dask scheduler, as ``"tcp://HOST:8786"``, instead of an executor.
    workers : int, optional
        Number of processes.  [the cores]
    progress : callable, optional
        Called with the numbers of finished points and of all points.

    Returns
    -------
    Sweep
        The table. A point without values, as of a dragon that does not fit on its curve, has the
        reason as `error`.

    Raises
    ------
    ParameterError, FileFormatError, OutputError, DragonError
        If an argument is out of range; the partial table is damaged or of another sweep; a file
        cannot be written; a worker or the scheduler was lost.

    Examples
    --------
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> scenario, pool = Scenario(benches=16, turns=8), ThreadPoolExecutor(1)
    >>> found = sweep(scenario, {"width": [0.3, 0.4]}, executor=pool)
    >>> print(*found.csv(), sep="\n")  # doctest: +ELLIPSIS
    width,contact_time,bench_a,bench_b,status,error
    0.3,80.691317691...,0,8,contact,
    0.4,14.323208054...,0,15,contact,
    """
    begin = perf_counter()
    function("progress", progress)
    flag("resume", resume)
    if isinstance(out, str | Path):
        out = [out]
    paths = instances("out", out, str | Path, "a path, or several")
    chosen = quantity_of(quantity)
    halvings = whole("refine", refine, 0, _MAX_HALVINGS)
    points = finer(axes_of(axes, chosen.parameters), halvings)
    given = given_values(scenario, points)
    base = base_values(chosen, given, points)
    if resume and not paths:
        raise ParameterError("resume", resume, "absent without a file to write")
    files = [check_format(path, points) for path in paths]

    pool = _pool(executor, scheduler, workers)
    call = partial_of(evaluate, chosen.name, base)
    with PartialTable(files, _description(chosen, points, base), points, resume=resume) as partial:
        with pool as submit:
            for numbers in rounds(partial, halvings):
                for rows in _outcomes(submit, call, partial.missing(numbers)):
                    partial.append(rows)
                    progress(len(partial.rows), partial.count)
        reference = reference_values(chosen, given, points)
        found = Sweep(chosen, partial, reference, perf_counter() - begin, 2**halvings)
        for file in files:
            found.write(file)
    return found


def _description(quantity: Quantity, axes: Axes, base: Values) -> dict[str, Any]:
    """Plain values that determine all outcomes."""
    file = getattr(sys.modules[quantity.function.__module__], "__file__", None)
    source = file and crc32(Path(file).read_bytes())
    described = {"version": version("pymunk-dragon"), "quantity": quantity.name, "source": source}
    return described | {"axes": list(axes.items()), "scenario": sorted(base.items())}


def _outcomes(
    submit: _Submit, call: Callable[..., Outcome], points: Iterable[Any]
) -> Iterator[dict[int, Outcome]]:
    """Evaluate a quantity by `call` at numbered points; yields outcomes by these numbers."""
    running: dict[Future[Outcome], int] = {}
    # Not `concurrent.futures.wait`: an interruption in it leaves futures locked, for which workers
    # wait without end.
    done: SimpleQueue[Future[Outcome]] = SimpleQueue()
    try:
        for number, at in points:
            running[future := submit(call, at)] = number
            future.add_done_callback(done.put)
            if len(running) >= _MAX_RUNNING:
                yield from _finished(running, done)
        while running:
            yield from _finished(running, done)
    except Exception as error:  # Whatever an executor raises.
        reason = f"{type(error).__name__}: {error}"
        raise DragonError(f"a worker was lost, or did not start: {reason}") from error


def _finished(
    running: dict[Future[Outcome], int], done: SimpleQueue[Future[Outcome]]
) -> Iterator[dict[int, Outcome]]:
    """Remove futures that are done; yields their outcomes, and then raises the error of one."""
    found = [done.get(), *(done.get() for _ in range(done.qsize()))]
    outcomes = {running.pop(each): each.result() for each in found if not each.exception()}
    if outcomes:
        yield outcomes
    for each in found:
        each.result()


def _pool(
    executor: Executor | None, scheduler: str | None, workers: int | None
) -> AbstractContextManager[_Submit]:
    """A context with the method `submit` of the executor that these arguments of `sweep` mean."""
    count = whole("workers", _CORES if workers is None else workers, 1, _MAX_WORKERS)
    instance("executor", executor, Executor | None, "a concurrent.futures.Executor")
    if scheduler is not None:
        return _cluster(library("distributed"), scheduler)
    return nullcontext(executor.submit) if executor else _processes(count)


@contextmanager
def _processes(count: int) -> Iterator[_Submit]:
    """Worker processes, which end at once when this context ends with an exception."""
    try:
        # Multiprocessing itself ends in errors of all kinds, and prints some.
        subprocess.run([get_executable(), "-ISc", ""], check=True, capture_output=True)
    except (OSError, subprocess.SubprocessError) as error:
        raise DragonError(f"no worker process starts: {error}") from error
    others = active_children()
    with _blocked_signals(), _held_signals():
        pool = ProcessPoolExecutor(count, get_context("spawn"), _begin_worker)

    def submit(*arguments: Any) -> Future[Outcome]:
        """Submit a call, for which a process may be started."""
        with _blocked_signals(), _held_signals():
            return pool.submit(*arguments)

    try:
        yield submit
    except BaseException:
        # `kill_workers` comes with Python 3.14.
        for process in set(active_children()).difference(others):
            process.kill()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


@contextmanager
def _blocked_signals() -> Iterator[None]:
    """Block the signals that end the program in processes that start.

    A terminal sends them to all processes.
    """
    if not hasattr(signal, "pthread_sigmask"):  # On Windows.
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _ENDING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _held_signals() -> Iterator[None]:
    """Hold the signals that end the program until processes that start have what they read first.

    A signal that this thread blocks goes to another one, as of OpenBLAS (NumPy's issue 23170), and
    Python calls its handler in the main thread nonetheless.
    """
    handlers = {}
    if current_thread() is main_thread():
        found = {number: signal.getsignal(number) for number in _ENDING}
        handlers = {number: handler for number, handler in found.items() if callable(handler)}
    held: list[int] = []

    def hold(number: int, frame: FrameType | None) -> None:
        held.append(number)

    try:
        for number in handlers:
            signal.signal(number, hold)
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for number in held:
            signal.raise_signal(number)


def _begin_worker() -> None:
    """Prepare a worker process, which ends when its parent does, even if that was killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # What a quantity prints is not part of a table on stdout.
    with suppress(OSError):  # There may be no stderr.
        os.dup2(2, 1)

    def end_with(parent: Any) -> None:
        parent.join()
        os._exit(1)

    Thread(target=end_with, args=[parent_process()], daemon=True).start()


@contextmanager
def _cluster(distributed: Any, scheduler: str) -> Iterator[_Submit]:
    """The workers of a Dask scheduler at an address."""
    try:
        # A client with an address of another form waits for itself when it is closed.
        distributed.comm.get_address_host_port(scheduler)
        client = distributed.Client(scheduler, timeout=10, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        bound = "the address of a Dask scheduler that answers, such as tcp://HOST:8786"
        raise ParameterError("scheduler", scheduler, bound) from error
    with client:
        yield client.get_executor(pure=False).submit
