"""Films of a run or march, or of several side by side.

A film passes through these modules: `settings` (parameters) with `timing` (times of the frames), `drawing.snapshots`
(states at these times), `layout` (arranges the scenes, which draw the states), and `formats` (file).
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager
from itertools import islice
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.reduction import ForkingPickler
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pymunk_dragon._checks import whole
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon._language import in_language, language
from pymunk_dragon.drawing.film.formats import WRITERS, Frames
from pymunk_dragon.drawing.film.layout import Canvas, lay_out, sampled
from pymunk_dragon.drawing.film.settings import Film, checked_sources
from pymunk_dragon.drawing.film.timing import Timing
from pymunk_dragon.drawing.snapshots import Snapshot, Source
from pymunk_dragon.errors import DragonError

__all__ = ["FILM_ENDINGS", "render", "write_film"]

# Function that is called with the number of frames done and the number of all frames.
Progress = Callable[[int, int], None]
# Snapshots of a frame, one for each scene.
States = tuple[Snapshot, ...]

# Signals that end a program, where they can be delayed: not on Windows.
ENDING = {signal.SIGINT, signal.SIGTERM, signal.SIGHUP} if hasattr(signal, "pthread_sigmask") else set()
# All endings of films, in lower case.
FILM_ENDINGS = tuple(WRITERS)
# Processes: more than common machines have cores.
MAX_WORKERS = 64
# Frames: for fewer the start of the worker processes takes longer than they save.
MIN_PARALLEL_FRAMES = 150
# Frames of a block: enough to amortise the cost of sending it, few enough to limit memory.
BLOCK_FRAMES = 8
# Blocks that a worker has or will have next; and blocks that wait for their turn, about 50 MB of 640 x 640 pixels.
BLOCKS_AHEAD, MAX_BLOCKS = 2, 16


def render(
    source: Source | Sequence[Source],
    path: str | Path,
    *,
    progress: Progress | None = None,
    workers: int = 0,
    **parameters: Any,
) -> None:
    """Write a film of a run or march, or of several side by side.

    Parameters
    ----------
    source, path, progress, workers
        As in `write_film`.
    **parameters
        Parameters of a `Film`: fps, speedup, size, start, until, hold, camera, palette, gap, legend, show, title,
        caption, headings, font.

    Raises
    ------
    ParameterError, UnreachableError, MissingExtraError, OutputError
        As in `write_film`.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March, render
    >>> render(March(Dragon(benches=16)), "march.gif", until=60, size=320)
    """
    write_film(source, path, Film(**parameters), progress, workers)


def write_film(
    source: Source | Sequence[Source],
    path: str | Path,
    film: Film | None = None,
    progress: Progress | None = None,
    workers: int = 0,
) -> Timing:
    """Write a film with the parameters of a `Film`.

    Parameters
    ----------
    source : Run or March, or a sequence of them
        Several sources are shown side by side at the same simulated time; a run that has ended keeps its last frame.
    path : path
        File to write: .gif, .apng, .webp, or .mp4 with the extra `mp4`. If writing is interrupted, an old file is kept
        and no incomplete file is left.
    film : Film, optional
        Speed, size, window, camera, marks, texts and colours.
    progress : callable, optional
        Function called for each frame with the number of frames done and the number of all frames.
    workers : int
        Number of other processes that draw films of 150 frames and more; the file is the same, to the byte. A script
        without a guard `if __name__ == "__main__":`, which each of them would run, or a march with a function or class
        of the script has none.

    Returns
    -------
    Timing
        Times of the frames.

    Raises
    ------
    ParameterError
        If the file cannot be created, the film does not fit the run, or the format cannot hold it.
    UnreachableError
        If the dragon of a march does not fit on its curve at a time of the film.
    MissingExtraError
        If the film is an MP4 and FFmpeg is not installed.
    OutputError
        If writing fails.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March, write_film
    >>> from pymunk_dragon.drawing import Film
    >>> film = Film(size=320, until=60, title="16 benches")
    >>> timing = write_film(March(Dragon(benches=16)), "march.webp", film)
    >>> timing.fps, float(timing.ends[-1])  # frames per second, and length of the film in s
    (20, 8.0)
    """
    film = film or Film()
    sources = checked_sources(source)
    whole("workers", workers, 0, MAX_WORKERS)
    destination = check_destination(path, WRITERS)
    timing = film.timing(sources)
    times, ends = timing.times, timing.ends.tolist()
    clips = sampled(sources, times, film)
    # A start that was not chosen by the user is displayed.
    chosen = film.start is None and times[0] > film.window(sources)[0]
    canvas = lay_out(clips, film, since=float(times[0]) if chosen else None)
    painter = _Painter(canvas, film.palette.table)
    states = zip(*(clip.snapshots for clip in clips), strict=True)
    if not (workers and len(times) >= MIN_PARALLEL_FRAMES and _can_be_sent(painter)):
        workers = 0
    with written_in_place(destination) as draft, closing(_pictures(painter, states, workers)) as pictures:
        frames = Frames(pictures=pictures, ends=ends, size=canvas.size, fps=timing.fps, progress=progress)
        WRITERS[destination.suffix.lower()](draft, frames)
    return timing


class _Painter:
    """Draws frames with a table of colours (mode P), in the language in which it was made."""

    def __init__(self, canvas: Canvas, table: NDArray[np.uint8]) -> None:
        self._canvas, self._language = canvas, language()
        self._table = Image.new("P", (1, 1))
        self._table.putpalette(table.tobytes())

    def draw(self, states: Iterable[States]) -> list[Image.Image]:
        with in_language(self._language):
            frames = [self._canvas.draw(snapshots) for snapshots in states]
        return [frame.quantize(palette=self._table, dither=Image.Dither.NONE) for frame in frames]


def _pictures(painter: _Painter, states: Iterator[States], workers: int) -> Generator[Image.Image]:
    """Yield the pictures of all frames in order; `workers` other processes and this one draw them."""
    if not workers:
        for state in states:
            yield from painter.draw([state])
        return
    with _executor(workers, painter) as executor:
        blocks: deque[Future[list[Image.Image]]] = deque()
        try:
            for block in iter(lambda: list(islice(states, BLOCK_FRAMES)), []):
                if sum(not drawn.done() for drawn in blocks) < BLOCKS_AHEAD * workers:
                    with _signals_later():
                        blocks.append(executor.submit(_draw, block))
                else:
                    # No process is free, or none has started yet.
                    blocks.append(Future())
                    blocks[-1].set_result(painter.draw(block))
                while blocks and (blocks[0].done() or len(blocks) >= MAX_BLOCKS):
                    yield from blocks.popleft().result()
            for drawn in blocks:
                yield from drawn.result()
        except BrokenProcessPool as error:
            raise DragonError("a process that drew the film was ended from outside; 0 workers need none") from error


def _can_be_sent(painter: _Painter) -> bool:
    """Return whether other processes can import the main program without running it, and draw without its classes."""
    file = getattr(sys.modules["__main__"], "__file__", None)
    try:
        guarded = file is None or "__main__" in Path(file).read_text(encoding="utf-8")
        return guarded and b"__main__" not in bytes(ForkingPickler.dumps(painter))
    except Exception:
        # A program from the standard input has no file. The exception of a function that cannot be pickled, as a
        # lambda, differs between kinds of functions.
        return False


@contextmanager
def _executor(workers: int, painter: _Painter) -> Iterator[ProcessPoolExecutor]:
    """Yield an executor, whose processes end with the context, whatever they do then."""
    others = set(active_children())
    # Spawned, because forking a program with threads can deadlock.
    executor = ProcessPoolExecutor(workers, get_context("spawn"), _begin, (painter,))
    try:
        yield executor
    finally:
        for process in set(active_children()) - others:
            process.kill()
        executor.shutdown(cancel_futures=True)


@contextmanager
def _signals_later() -> Iterator[None]:
    """Context that delays signals, so that processes start completely; those that start in it ignore Ctrl-C."""
    if not ENDING or threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    # Other threads may receive the signals, and handlers run in this one. New processes inherit only the mask.
    handlers = {number: signal.signal(number, lambda number, _: came.append(number)) for number in ENDING}
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for number, handler in handlers.items():
            signal.signal(number, handler)
        if came:
            signal.raise_signal(came[0])


def _begin(painter: _Painter) -> None:
    """Prepare a worker process."""
    global _worker  # What a process draws with is sent once, not with every block.
    _worker = painter
    # A terminal sends Ctrl-C to all processes; the first one ends the others.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End this process when the one that started it has ended, however it did."""
    parent = parent_process()
    assert parent is not None  # This is a worker.
    parent.join()
    os._exit(1)


def _draw(states: list[States]) -> list[Image.Image]:
    """Draw a block of frames in a worker process."""
    return _worker.draw(states)


_worker: _Painter
