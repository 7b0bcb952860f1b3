"""Films of a run or march, or of several side by side.

A film passes through these modules: `settings` (parameters) with `timing` (times of the frames), `drawing.snapshots`
(states at these times), `layout` (arranges the scenes, which draw the states), and `formats` (file).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from PIL import Image

from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon.drawing.film.formats import WRITERS, Frames
from pymunk_dragon.drawing.film.layout import lay_out, sampled
from pymunk_dragon.drawing.film.settings import Film, checked_sources
from pymunk_dragon.drawing.film.timing import Timing
from pymunk_dragon.drawing.snapshots import Source

__all__ = ["FILM_ENDINGS", "render", "write_film"]

# Function that is called with the number of frames done and the number of all frames.
Progress = Callable[[int, int], None]
# All endings of films, in lower case.
FILM_ENDINGS = tuple(WRITERS)


def render(
    source: Source | Sequence[Source],
    path: str | Path,
    *,
    progress: Progress | None = None,
    **parameters: Any,
) -> None:
    """Write a film of a run or march, or of several side by side.

    Parameters
    ----------
    source, path, progress
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
    write_film(source, path, Film(**parameters), progress)


def write_film(
    source: Source | Sequence[Source],
    path: str | Path,
    film: Film | None = None,
    progress: Progress | None = None,
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
    destination = check_destination(path, WRITERS)
    timing = film.timing(sources)
    times, ends = timing.times, timing.ends.tolist()
    clips = sampled(sources, times, film)
    # A start that was not chosen by the user is displayed.
    chosen = film.start is None and times[0] > film.window(sources)[0]
    canvas = lay_out(clips, film, since=float(times[0]) if chosen else None)
    colours = Image.new("P", (1, 1))
    colours.putpalette(film.palette.table.tobytes())

    def pictures() -> Iterator[Image.Image]:
        for states in zip(*(clip.snapshots for clip in clips), strict=True):
            yield canvas.draw(states).quantize(palette=colours, dither=Image.Dither.NONE)

    frames = Frames(pictures=pictures(), ends=ends, size=canvas.size, fps=timing.fps, progress=progress)
    with written_in_place(destination) as draft:
        WRITERS[destination.suffix.lower()](draft, frames)
    return timing
