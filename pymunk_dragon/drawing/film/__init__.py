"""Films of a run or march, or of several side by side.

A film passes through these modules: `settings` (parameters), `timing` (times of the frames), `drawing.snapshots`
(states at these times), `layout` (arranges the scenes, which draw the states, and the `legend`), `workers` (draws
frames in parallel), and `formats` (file).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from pathlib import Path

from PIL import Image

from pymunk_dragon._checks import whole
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon.drawing.camera import Camera
from pymunk_dragon.drawing.film.formats import WRITERS, Frames
from pymunk_dragon.drawing.film.layout import lay_out, sampled
from pymunk_dragon.drawing.film.settings import Film, checked_sources
from pymunk_dragon.drawing.film.timing import Timing
from pymunk_dragon.drawing.film.workers import map_in_processes
from pymunk_dragon.drawing.palette import Palette
from pymunk_dragon.drawing.snapshots import Source

__all__ = ["FILM_ENDINGS", "render", "write_film"]

# Function that is called with the number of frames done and the number of all frames.
Progress = Callable[[int, int], None]

# All endings of films, in lower case.
FILM_ENDINGS = tuple(WRITERS)
# Processes: more than common machines have cores.
MAX_WORKERS = 64


def render(
    source: Source | Sequence[Source],
    path: str | Path,
    *,
    fps: int | None = Film.fps,
    speedup: float | None = Film.speedup,
    size: int | tuple[int, int] = Film.size,
    start: float | None = None,
    until: float | None = None,
    hold: float = Film.hold,
    camera: Camera = Film.camera,
    palette: Palette = Film.palette,
    gap: bool | None = Film.gap,
    legend: bool = Film.legend,
    show: tuple[str, ...] = (),
    title: str = "",
    caption: str = "",
    headings: tuple[str, ...] = (),
    font: str | Path | None = None,
    progress: Progress | None = None,
    workers: int = 0,
) -> None:
    """Write a film of a run or march, or of several side by side.

    Parameters
    ----------
    source, path, progress, workers
        As in `write_film`.
    fps, speedup, size, start, until, hold, camera, palette, gap, legend, show, title, caption, headings, font
        Parameters of the film, as in `Film`.

    Raises
    ------
    ParameterError, UnreachableError, MissingExtraError, OutputError
        As in `write_film`.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March, render
    >>> render(March(Dragon(benches=16)), "march.gif", until=60, size=320)
    """
    film = Film(
        fps=fps,
        speedup=speedup,
        size=size,
        start=start,
        until=until,
        hold=hold,
        camera=camera,
        palette=palette,
        gap=gap,
        legend=legend,
        show=show,
        title=title,
        caption=caption,
        headings=headings,
        font=font,
    )
    write_film(source, path, film, progress, workers)


def write_film(
    source: Source | Sequence[Source],
    path: str | Path,
    film: Film | None = None,
    progress: Progress | None = None,
    workers: int = 0,
) -> Timing:
    """Write a film with the parameters of a `Film`; each frame is written as it is drawn.

    Parameters
    ----------
    source : Run or March, or a sequence of them
        A run is played from its frames, a march by the exact model. Several sources are shown side by side at the same
        simulated time; a run that has ended keeps its last frame.
    path : path
        File to write: .gif, .apng, .webp, or .mp4 with the extra `mp4`. If writing is interrupted, an old file is kept
        and no incomplete file is left. The memory for a GIF or MP4 does not depend on the length of the film; for a
        WebP the compressed film is in memory, for an APNG all frames are.
    film : Film, optional
        Speed, size, window, camera, marks, texts and colours.
    progress : callable, optional
        Function called for each frame with the number of frames done and the number of all frames.
    workers : int
        Number of worker processes that draw films of 150 frames and more. The film does not depend on this number, to
        the byte. A script that uses workers must guard its entry point with `if __name__ == "__main__":`.

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
    snapshots = zip(*(clip.snapshots for clip in clips), strict=True)
    with (
        written_in_place(destination) as draft,
        closing(map_in_processes(canvas.draw, snapshots, len(times), workers)) as pictures,
    ):
        counted = _counted(pictures, len(times), progress)
        frames = Frames(pictures=counted, ends=ends, size=canvas.size, colours=film.palette.table, fps=timing.fps)
        WRITERS[destination.suffix.lower()](draft, frames)
    return timing


def _counted(pictures: Iterator[Image.Image], total: int, progress: Progress | None) -> Iterator[Image.Image]:
    """Yield `pictures`, and report their number."""
    for done, picture in enumerate(pictures, start=1):
        if progress is not None:
            progress(done, total)
        yield picture
