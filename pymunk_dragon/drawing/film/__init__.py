"""Films of a run or march, or of several side by side, and pictures of one time.

A film passes through these modules: `settings` (parameters), `take` (what the film shows of each
source), `timing` (times of the frames), `layout` (arranges the scenes, which draw the states of a
source at these times), and `formats` (file).
"""

import io
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from pymunk_dragon._checks import finite, function, instance
from pymunk_dragon._files import check_destination, passed_on, written_in_place
from pymunk_dragon.drawing.film.formats import WRITERS, Frames, written_size
from pymunk_dragon.drawing.film.layout import Layout
from pymunk_dragon.drawing.film.settings import Film
from pymunk_dragon.drawing.film.take import checked_sources, shared_window, takes_in, takes_of_film
from pymunk_dragon.drawing.film.timing import Timing, frame_times
from pymunk_dragon.drawing.snapshots import Source

# Endings of films, in lower case.
FILM_ENDINGS = tuple(WRITERS)
# Endings of still pictures, in lower case.
STILL_ENDINGS = (".png",)


def render(
    source: Source | Sequence[Source],
    path: str | Path,
    film: Film | None = None,
    progress: Callable[[int, int], None] | None = None,
    **parameters: Any,
) -> Timing:
    """Write a film of a run or march, or of several side by side, or a picture of its last time.

    Parameters
    ----------
    source : Run or March, or a sequence of them
        Several sources are shown side by side at the same simulated time; a run that has ended
        keeps its last frame. Without `until`, a march is shown until its first contact.
    path : path
        File to write: .gif; .webp, which keeps all colours and needs memory for all frames; or
        .mp4 with the extra `mp4`. A picture is .png. If writing is interrupted, an old file is
        kept and no incomplete file is left.
    film : Film, optional
        Speed, size, window, camera, marks and texts.
    progress : callable, optional
        Function called after each frame with the number of frames done and of all frames.
    **parameters
        Parameters of a `Film` by their names, instead of those of `film`.

    Returns
    -------
    Timing
        Times of the frames, and `size`: width and height of the film or picture with its texts,
        pixels. An MP4 has even ones: the last column of an odd width and the last row of an odd
        height are left out.

    Raises
    ------
    ParameterError
        If the file cannot be created, the film does not fit the run, or the format cannot hold it.
    UnreachableError
        If the dragon of a march does not fit on its curve at a time of the film.
    MissingExtraError
        If the film is an MP4 and FFmpeg is not installed.
    OutputError
        If writing fails. An error that `progress`, or a curve of your own, raises is not changed.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March, render
    >>> march = March(Dragon(benches=16))
    >>> timing = render(march, "march.gif", size=320, until=60, title="16 benches")
    >>> timing.fps, float(timing.ends[-1])  # frames per second, and length of the film in s
    (20, 8.0)
    >>> timing.size  # with the title above and the legend below
    (320, 381)
    """
    film = replace(_checked(film), **parameters)
    if progress is not None:
        function("progress", progress)
    sources = checked_sources(source)
    destination = check_destination(path, (*FILM_ENDINGS, *STILL_ENDINGS))
    ending = destination.suffix.lower()
    still = ending in STILL_ENDINGS
    takes = takes_of_film(sources, film, still=still)
    timing = frame_times(takes, film)

    layout = Layout(takes, timing.times, film)
    pictures = passed_on(layout.frames() if still else layout.pictures(progress))
    size = written_size(ending, layout.size)
    ends = timing.ends.tolist()
    frames = Frames(pictures=pictures, ends=ends, size=size, fps=timing.fps)
    with written_in_place(destination) as draft:
        if still:
            draft.write_bytes(_png(next(pictures)))
        else:
            WRITERS[ending](draft, frames)
    return replace(timing, size=size, is_cropped=size != layout.size)


def still_png(source: Source | Sequence[Source], time: float, film: Film | None = None) -> bytes:
    """Content of a PNG file of a run or march, or of several side by side, at one time, s.

    The film has size, camera, marks and texts; its time window is ignored.

    Raises
    ------
    ParameterError
        If `time` is outside the run, or the run has no data for a mark.
    UnreachableError
        If the dragon of a march does not fit on its curve at `time`.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March
    >>> from pymunk_dragon.drawing import Film, still_png
    >>> still_png(March(Dragon(benches=16)), 60.0, Film(size=320))[1:4]
    b'PNG'
    """
    sources = checked_sources(source)
    finite("time", time, *shared_window(sources), "s")
    film = _checked(film)
    takes = takes_in((time, time), sources, film)
    layout = Layout(takes, np.array([time], dtype=float), film)
    return _png(next(layout.frames()))


def _checked(film: Film | None) -> Film:
    """The film, or one with the default parameters."""
    return Film() if film is None else instance("film", film, Film, "a Film")


def _png(picture: Image.Image) -> bytes:
    """Content of a PNG file of a picture."""
    content = io.BytesIO()
    picture.save(content, "PNG", optimize=True)
    return content.getvalue()
