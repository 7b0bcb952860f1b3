"""A quantity at many points, evaluated in parallel."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter
from typing import Any

from pymunk_dragon._checks import positive, whole
from pymunk_dragon._extras import library
from pymunk_dragon._files import check_destination
from pymunk_dragon.errors import DragonError, MissingExtraError, ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.scenario import Scenario
from pymunk_dragon.sweeps.axes import Grid, Point, Sampling
from pymunk_dragon.sweeps.computation import MOST_POINTS, Computation
from pymunk_dragon.sweeps.journal import ENDING, Journal
from pymunk_dragon.sweeps.plan import Plan, Points
from pymunk_dragon.sweeps.quantities import Values
from pymunk_dragon.sweeps.refinement import Refinement
from pymunk_dragon.sweeps.result import FORMATS, PICTURES, Sweep, label
from pymunk_dragon.sweeps.workers import Borrowed, Dask, Processes, Workers

# Called with the number of finished points and the number of all points so far.
Progress = Callable[[int, int], None]

# Libraries that formats need.
LIBRARIES = {".parquet": "pyarrow"} | dict.fromkeys(PICTURES, "matplotlib")
# New points of a refinement, at most.
MAX_REFINE = 10_000_000
# Workers, at most.
MAX_WORKERS = 100_000
# s. Longest time limit of a point.
MAX_TIMEOUT = 1e6


def sweep(
    scenario: Scenario | March | Mapping[str, Any] | None = None,
    axes: Mapping[str, Sequence[float]] | None = None,
    quantity: str | Callable[..., Values] = "contact-time",
    executor: Executor | None = None,
    out: str | Path | Sequence[str | Path] | None = None,
    *,
    samples: int | None = None,
    seed: int = 0,
    sampling: Sampling = "sobol",
    refine: int = 0,
    timeout: float | None = None,
    resume: bool = False,
    scheduler: str | None = None,
    workers: int | None = None,
    batch_size: int | None = None,
    progress: Progress | None = None,
) -> Sweep:
    r"""Compute a quantity of a dragon at many values of its parameters, in parallel.

    Finished points are written to a journal beside the first file, `out` with the ending ``.journal``. An interrupted
    sweep goes on from there with `resume`; the journal is removed when all files are written.

    Parameters
    ----------
    scenario : Scenario, March or mapping, optional
        The dragon and its curve; by default the reference scenario. A mapping has values of a scenario's parameters.
    axes : mapping
        Names of parameters, of the scenario or of the quantity, and the values of each. The points are all
        combinations. With `samples`, each axis has two values, the ends of an interval.
    quantity : str or callable
        "contact-time", "nearest-gap", "min-pitch", "max-speed", "engine-contact-time", "engine-error", or a function of
        a march, as itself or as ``"module:function"``, that returns a mapping of numbers or texts by name. Its
        keyword-only parameters may be axes. Workers import it by its name.
    executor : concurrent.futures.Executor, optional
        Evaluates the points; by default new processes, one for each core. As they import the main program, a script
        calls `sweep` under ``if __name__ == "__main__":``.
    out : path or sequence of paths, optional
        Files to write: .csv, .parquet, or .png, .svg or .pdf for a picture.
    samples, seed, sampling
        Number of samples to take instead of a grid, the seed, and "sobol" or "random".
    refine : int
        New points of a grid, at most, where a text or a whole number, as the status or a bench, changes between
        neighbours. They follow the points of the grid.
    timeout : float, optional
        Time limit of a point, s. A point that takes longer has failed.
    resume : bool
        Whether to use the journal of an interrupted sweep, if there is one.
    scheduler : str, optional
        "local", or the address of a Dask scheduler such as ``"tcp://HOST:8786"``, instead of an executor.
    workers : int, optional
        Number of processes, or points that the executor evaluates at the same time.
    batch_size : int, optional
        Points that a worker gets at a time; by default as many as take about half a second.
    progress : callable, optional
        Called with the number of finished points and the number of all points.

    Returns
    -------
    Sweep
        The table. A point without values, as for a dragon that does not fit on its curve, has the reason as `error`.

    Raises
    ------
    ParameterError
        If an argument is out of range, no corner of the axes is a valid scenario, or another sweep left a journal.
    FileFormatError
        If the journal is of another scenario, axis, quantity or version, which is named.
    MissingExtraError
        If Dask, Parquet, pictures or Sobol sequences are not installed.
    OutputError
        If the journal or a file cannot be written.
    DragonError
        If no worker can evaluate points.

    Examples
    --------
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> found = sweep(Scenario(benches=16, turns=8), {"width": [0.3, 0.4]}, executor=ThreadPoolExecutor(1))
    >>> print(*found.csv(), sep="\n")
    width,contact_time,bench_a,bench_b,status,error
    0.3,80.6913176918045,0,8,contact,
    0.4,14.32320805466254,0,15,contact,
    """
    begin = perf_counter()
    plan = Plan.of(scenario, axes or {}, quantity, samples, seed, sampling)
    refine = whole("refine", refine, 0, MAX_REFINE)
    if refine and not isinstance(plan.axes, Grid):
        raise ParameterError("refine", refine, "absent where samples are taken")
    if timeout is not None:
        timeout = positive("timeout", timeout, MAX_TIMEOUT, "s")
    if batch_size is not None:
        batch_size = whole("batch_size", batch_size, 1, MOST_POINTS)
    files = _destinations(out)
    if resume and not files:
        raise ParameterError("resume", resume, "absent without a file to write")
    if workers is not None:
        workers = whole("workers", workers, 1, MAX_WORKERS)
    if executor is not None and scheduler is not None:
        raise ParameterError("scheduler", scheduler, "absent where an executor is given")
    journal = Journal(Path(f"{files[0]}{ENDING}") if files else None, plan.to_dict(refine), resume=resume)
    points = Points(plan.axes)

    def report() -> None:
        if progress is not None:
            progress(len(journal), len(points))

    with _resumable(journal, points):
        with _workers(executor, scheduler, workers) as started:
            computation = Computation(plan.task(timeout), started, journal, batch_size, report)
            _compute(plan, points, computation, journal, refine)
        found = Sweep(plan, points, journal, perf_counter() - begin)
        for path in files:
            found.write(path)
    journal.remove()
    return found


def _destinations(out: str | Path | Sequence[str | Path] | None) -> list[Path]:
    """The files to write, for which the libraries are there."""
    files = [check_destination(path, FORMATS) for path in ([out] if isinstance(out, str | Path) else out or ())]
    for path in files:
        if (ending := path.suffix.lower()) in LIBRARIES:
            library(LIBRARIES[ending])
    return files


def _workers(executor: Executor | None, scheduler: str | None, count: int | None) -> Workers:
    """The workers of the arguments of `sweep`."""
    if executor is not None:
        return Borrowed(executor, count)
    return Processes(count) if scheduler is None else Dask(scheduler, count)


def _compute(plan: Plan, points: Points, computation: Computation, journal: Journal, refine: int) -> None:
    """Evaluate the points that the journal does not have, and those of the refinement."""
    refinement = Refinement(plan.axes, refine, plan.integers) if isinstance(plan.axes, Grid) and refine else None
    labels: dict[Point, Hashable] = {}
    first = 0
    while first < len(points):
        numbers = range(first, len(points))
        missing = sum(number not in journal for number in numbers)
        if missing:
            computation.run(((number, points[number]) for number in numbers if number not in journal), missing)
        first = len(points)
        if refinement is not None:
            labels |= {points[number]: label(journal[number][0]) for number in numbers}
            points.extend(refinement.round(labels))


@contextmanager
def _resumable(journal: Journal, points: Points) -> Iterator[None]:
    """Close the journal after an exception, which then says what the journal has."""
    try:
        yield
    except BaseException as error:
        journal.close()
        if not len(journal):
            journal.remove()
        elif journal.path is not None:
            kept = f"{len(journal)} of {len(points)} points are in {journal.path}, from where the sweep can be resumed"
            if isinstance(error, KeyboardInterrupt):
                raise KeyboardInterrupt(kept) from None
            if isinstance(error, DragonError) and not isinstance(error, ParameterError | MissingExtraError):
                raise DragonError(f"{error}; {kept}") from error
        raise
