"""The loop that evaluates the points of a sweep in batches."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from dataclasses import dataclass
from itertools import islice
from math import inf
from time import monotonic

from pymunk_dragon.errors import DragonError
from pymunk_dragon.sweeps.axes import Point
from pymunk_dragon.sweeps.evaluation import LONGEST_BATCH, REPEAT, Outcome, Task, evaluate, too_long
from pymunk_dragon.sweeps.journal import Journal
from pymunk_dragon.sweeps.workers import Workers

# s that a batch should take: long beside the cost of sending it, short beside what a user waits.
BATCH_SECONDS = 0.5
# Batches a second of all workers, at most: with more workers a batch takes longer. Dask takes about 5 ms for each.
MOST_BATCHES_PER_SECOND = 50
# Points of a batch, at most.
MOST_POINTS = 4096
# Share of the last batch in the estimate of the time of a point.
NEWEST = 0.3
# s between checks of the workers.
POLL = 1.0
# s after the time limit until a worker that does not return is stopped.
GRACE = 10.0

# Reason of a point that failed so.
LOST = "its worker was ended whenever it was evaluated"
# s of a point, in the choice of the size of a batch.
SHORTEST = 1e-9

# A point and its number.
Item = tuple[int, Point]
Running = Future[tuple[list[Outcome], float]]


@dataclass(kw_only=True)
class _Batch:
    """Points that are evaluated together; a suspect, whose worker was lost, with no others at the same time."""

    items: Sequence[Item]
    suspect: bool = False
    losses: int = 0
    # Time at which it has ended at the latest, if all points take as long as the time limit.
    end: float = inf


class Computation:
    """Evaluates points on workers, and writes their outcomes to a journal.

    Parameters
    ----------
    task : Task
        What is the same for all points.
    workers : Workers
        Where the points are evaluated.
    journal : Journal
        Gets the outcomes, in the order in which they are finished.
    batch_size : int or None
        Points of a batch; by default as many as take `BATCH_SECONDS`.
    report : callable
        Called after outcomes were written.
    """

    def __init__(
        self, task: Task, workers: Workers, journal: Journal, batch_size: int | None, report: Callable[[], None]
    ) -> None:
        self._task = task
        self._workers = workers
        self._journal = journal
        self._batch_size = batch_size
        self._report = report
        # s for one point, measured by the workers.
        self._seconds: float | None = None
        self._items: Iterator[Item] = iter(())
        self._left = 0
        # Points of batches that ended early.
        self._returned: deque[Item] = deque()
        self._suspects: deque[_Batch] = deque()
        self._running: dict[Running, _Batch] = {}

    def run(self, items: Iterator[Item], count: int) -> None:
        """Evaluate `count` points.

        Raises
        ------
        OutputError
            If outcomes cannot be written.
        DragonError
            If the workers cannot evaluate any point, or are lost for good.
        """
        self._items, self._left = items, count
        while self._fill():
            done, _ = wait(self._running, timeout=POLL, return_when=FIRST_COMPLETED)
            if done:
                self._collect(done)
            else:
                self._workers.check()
            self._end_overdue()

    def _fill(self) -> bool:
        """Submit as many batches as the workers can use; returns whether any is evaluated."""
        while len(self._running) < self._most_running() and (batch := self._next()):
            points = [point for _, point in batch.items]
            self._limit(batch)
            self._running[self._workers.submit(evaluate, self._task, points)] = batch
        return bool(self._running)

    def _limit(self, batch: _Batch) -> None:
        """Set when a batch has ended at the latest: it begins when less batches than workers are left before it."""
        if self._task.timeout is not None:
            ends = sorted(other.end for other in self._running.values())
            before = len(ends) - self._workers.count
            begin = max(monotonic(), ends[before]) if before >= 0 else monotonic()
            longest = self._task.timeout + REPEAT
            batch.end = begin + min(len(batch.items) * longest, LONGEST_BATCH + longest)

    def _most_running(self) -> int:
        alone = self._suspects or any(batch.suspect for batch in self._running.values())
        return 1 if alone else self._workers.depth * self._workers.count

    def _next(self) -> _Batch | None:
        if self._suspects:
            return self._suspects.popleft()
        size = self._size()
        items = [self._returned.popleft() for _ in range(min(size, len(self._returned)))]
        items += islice(self._items, size - len(items))
        self._left -= len(items)
        return _Batch(items=items) if items else None

    def _size(self) -> int:
        """Points of the next batch: less at the end, so that all workers finish at about the same time."""
        if self._batch_size is not None:
            return self._batch_size
        if self._seconds is None:
            return 1
        count = self._workers.count
        aim = max(BATCH_SECONDS, count / MOST_BATCHES_PER_SECOND)
        return max(
            1,
            min(int(aim / max(self._seconds, SHORTEST)), -(-self._left // (self._workers.depth * count)), MOST_POINTS),
        )

    def _collect(self, done: Iterable[Running]) -> None:
        """Write the outcomes of batches that have ended."""
        outcomes: list[tuple[int, Outcome]] = []
        broken = False
        for future in done:
            batch = self._running.pop(future)
            try:
                found, seconds = future.result()
            except self._workers.lost as error:
                broken |= isinstance(error, BrokenExecutor)
                self._suspect(batch)
                continue
            except CancelledError as error:
                raise DragonError("the workers, or their scheduler, were stopped") from error
            except Exception as error:
                raise DragonError(f"the workers cannot evaluate a point: {type(error).__name__}: {error}") from error
            outcomes += zip((index for index, _ in batch.items), found, strict=False)
            self._return(batch, batch.items[len(found) :])
            share = 1.0 if self._seconds is None else NEWEST
            self._seconds = share * seconds / len(found) + (1 - share) * (self._seconds or 0.0)
        self._write(outcomes)
        if broken:
            # All workers end with the one that was lost.
            self._workers.restart(list(self._running))
            self._suspect_all()

    def _return(self, batch: _Batch, rest: Sequence[Item]) -> None:
        """Evaluate the points later that are left of a batch that ended early."""
        if batch.suspect and rest:
            self._suspects.appendleft(_Batch(items=rest, suspect=True))
        else:
            self._returned += rest
            self._left += len(rest)

    def _write(self, outcomes: Sequence[tuple[int, Outcome]]) -> None:
        if outcomes:
            self._journal.append(outcomes)
            self._report()

    def _fail(self, batch: _Batch, reason: str) -> None:
        self._write([(index, (None, reason)) for index, _ in batch.items])

    def _suspect_all(self) -> None:
        """Evaluate again what was evaluated by workers that were stopped."""
        for batch in self._running.values():
            self._suspect(batch)
        self._running.clear()

    def _suspect(self, batch: _Batch) -> None:
        """Evaluate a batch without others; if that ended a worker before, in halves; a single point fails."""
        middle = len(batch.items) // 2
        if not batch.suspect:
            parts = [_Batch(items=batch.items, suspect=True)]
        elif middle:
            parts = [_Batch(items=items, suspect=True) for items in (batch.items[:middle], batch.items[middle:])]
        elif batch.losses + 1 < self._workers.most_losses:
            parts = [_Batch(items=batch.items, suspect=True, losses=batch.losses + 1)]
        else:
            self._fail(batch, LOST)
            return
        self._suspects += parts

    def _end_overdue(self) -> None:
        """Stop workers that have not ended a point at its time limit; a point that was the only one has failed."""
        if (timeout := self._task.timeout) is None:
            return
        now = monotonic()
        overdue = [future for future, batch in self._running.items() if now > batch.end + GRACE]
        if not overdue:
            return
        if not self._workers.restart(list(self._running)):
            # None has begun, as on a cluster without workers.
            waiting, self._running = self._running, {}
            for future, batch in waiting.items():
                self._limit(batch)
                self._running[future] = batch
            return
        for future in overdue:
            batch = self._running[future]
            # Otherwise it may have waited for its turn.
            if batch.suspect and len(batch.items) == 1:
                self._fail(self._running.pop(future), too_long(timeout))
        self._suspect_all()
