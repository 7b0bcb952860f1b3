"""Writes films and still pictures of one run or march, or of several side by side."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._checks import finite, whole
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon.drawing.camera import HEAD_SPAN
from pymunk_dragon.drawing.canvas import Canvas
from pymunk_dragon.drawing.encode import encode_frames
from pymunk_dragon.drawing.film import Film, shared_window
from pymunk_dragon.drawing.moments import Source, check_marks, largest_impulse, moments
from pymunk_dragon.drawing.scene import Scene
from pymunk_dragon.drawing.streams import FILM_ENDINGS, check_ending, open_stream
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

__all__ = ["STILL_ENDINGS", "make_canvas", "render", "still", "still_png", "write_film", "write_still"]

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]

# All endings of still pictures, in lower case.
STILL_ENDINGS = (".png",)
# Pictures side by side: more would be too small to see.
MAX_PANELS = 4
# Processes: more than common machines have cores.
MAX_WORKERS = 64
# Times at which the extent of the dragon is sampled to find the field of view.
FIELD_SAMPLES = 64
# Free border on each side of the field of view, as a fraction of its size.
FIELD_BORDER = 0.03


def render(
    source: Source | Sequence[Source],
    path: str | Path,
    *,
    progress: Progress | None = None,
    workers: int = 0,
    **options: Any,
) -> None:
    """Write a film: `write_film` with the parameters of `Film` as keyword arguments.

    Examples
    --------
    >>> render(March(), "march.gif", until=412.47, speedup=20)  # doctest: +SKIP
    """
    write_film(source, path, Film(**options), progress, workers)


def write_film(
    source: Source | Sequence[Source],
    path: str | Path,
    film: Film | None = None,
    progress: Progress | None = None,
    workers: int = 0,
) -> None:
    """Write a film frame by frame; memory use does not depend on its length.

    Parameters
    ----------
    source : Run or March, or a sequence of them
        A run is played from its frames, a march by the exact model. Several sources are shown side by side at the same
        time; a run that has ended keeps its last frame.
    path : path
        File to write: .gif, .apng, .webp, or .mp4 with the extra `mp4`. If writing is interrupted, an old file is kept
        and no incomplete file is left.
    film : Film, optional
        Speed, size, window, camera, marks, texts and colours.
    progress : callable, optional
        Function called after each frame with the number of frames done and the number of all frames.
    workers : int
        Number of worker processes for films of 150 frames and more. The film does not depend on this number, to the
        byte. A script that uses workers must guard its entry point with `if __name__ == "__main__":`.

    Raises
    ------
    ParameterError
        If the file cannot be created, or the film does not fit the run.
    UnreachableError
        If the dragon of a march does not fit on its curve at a time of the film.
    MissingExtraError
        If the film is an MP4 and FFmpeg is not installed.
    OutputError
        If writing fails.
    """
    film = film or Film()
    sources = _sources(source)
    whole("workers", workers, 0, MAX_WORKERS)
    destination = check_destination(path, FILM_ENDINGS)
    check_ending(destination, film.fps)
    times = film.times(sources)
    canvas = make_canvas(sources, film, times)
    frame_moments = zip(*(moments(source, times, film.show) for source in sources), strict=True)
    report = progress or (lambda done, total: None)
    with (
        written_in_place(destination) as draft,
        open_stream(draft, canvas.size, film.palette.table, film.fps) as stream,
    ):
        ends = film.ends(times).tolist()
        encode_frames(stream, canvas, frame_moments, ends, workers, lambda done: report(done, len(times)))


def write_still(source: Source | Sequence[Source], time: float, path: str | Path, film: Film | None = None) -> None:
    """Write the picture at `time`, s, as PNG, drawn as in `film`; the film's window is ignored.

    Raises
    ------
    ParameterError
        If the file cannot be created, or `time` is outside the run.
    UnreachableError
        If the dragon of a march does not fit on its curve at `time`.
    OutputError
        If writing fails.
    """
    destination = check_destination(path, STILL_ENDINGS)
    picture = still_png(source, time, film)
    with written_in_place(destination) as draft:
        draft.write_bytes(picture)


def still_png(source: Source | Sequence[Source], time: float, film: Film | None = None) -> bytes:
    """Return the content of the PNG file that `write_still` writes."""
    # Imported here because imageio loads slowly and films do not use it.
    import imageio.v3 as iio

    picture: bytes = iio.imwrite("<bytes>", still(source, time, film), extension=".png")
    return picture


def still(source: Source | Sequence[Source], time: float, film: Film | None = None) -> NDArray[np.uint8]:
    """Draw the picture at `time`, s, as red, green and blue (height, width, 3); the window of `film` is ignored.

    Raises
    ------
    ParameterError
        If `time` is outside the run.
    UnreachableError
        If the dragon of a march does not fit on its curve at `time`.
    """
    film = film or Film()
    sources = _sources(source)
    begin, end = shared_window(sources)
    finite("time", time, begin, end, "s")
    times = np.array([time], dtype=float)
    picture = make_canvas(sources, film, times).draw([next(moments(one, times, film.show)) for one in sources])
    colours: NDArray[np.uint8] = film.palette.table[np.asarray(picture)]
    return colours


def make_canvas(sources: Sequence[Source], film: Film, times: Array) -> Canvas:
    """Create the canvas that draws the frames of a film at `times` (F,), s."""
    for source in sources:
        check_marks(source, film.show)
    centre, span = (0.0, 0.0), HEAD_SPAN * max(float(_march(source).dragon.widths[0]) for source in sources)
    if film.camera.follow == "field":
        sample = np.linspace(times[0], times[-1], min(FIELD_SAMPLES, len(times)))
        # One scale for all scenes, because pictures side by side are compared.
        corners = np.array([_extent(source, sample) for source in sources])
        low, high = corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)
        centre = (float(low[0] + high[0]) / 2, float(low[1] + high[1]) / 2)
        width, height = film.shape
        span = (1 + 2 * FIELD_BORDER) * float(max(high[0] - low[0], (high[1] - low[1]) * width / height))
    largest = largest_impulse(sources, times)
    scenes = [
        Scene(
            _march(source),
            film.camera,
            centre=centre,
            span=film.camera.span or span,
            size=film.shape,
            times=_window(source, times),
            contact=source.first_contact if isinstance(source, Run) else None,
            gap=film.shows_gap,
            marks=film.show,
            largest_impulse=largest,
        )
        for source in sources
    ]
    headings = film.headings or (tuple(map(_heading, sources)) if len(sources) > 1 else ())
    if headings and len(headings) != len(sources):
        raise ParameterError("headings", headings, f"one for each picture, so {len(sources)}")
    return Canvas(scenes, headings, film.title, film.caption, film.font)


def _sources(source: Any) -> tuple[Source, ...]:
    if isinstance(source, Run | March):
        return (source,)
    sources = tuple(source) if isinstance(source, Sequence) else ()
    if not all(isinstance(one, Run | March) for one in sources) or not 1 <= len(sources) <= MAX_PANELS:
        kinds = [type(one).__name__ for one in sources] if sources else source
        raise ParameterError("source", kinds, f"a Run or a March, or a list of at most {MAX_PANELS} of them")
    return sources


def _march(source: Source) -> March:
    return source.march if isinstance(source, Run) else source


def _window(source: Source, times: Array) -> tuple[float, float]:
    """Return the first and last time, s, of a run, or of the frame times `times` (F,) of a march."""
    known = source.times if isinstance(source, Run) else times
    return float(known[0]), float(known[-1])


def _heading(source: Source) -> str:
    """Return a heading that names the model and its options."""
    if isinstance(source, March) or source.player == "exact":
        return "exact model"
    words = ["engine"]
    if source.guide is not None:
        words.append("no guide" if source.guide == "none" else source.guide)
    if source.settings is not None and source.settings.contacts == "resolve":
        words.append("contacts resolved")
    return ", ".join(words)


def _extent(source: Source, times: Array) -> tuple[Array, Array]:
    """Return the lower left and upper right corner, m, of the dragon's bounding box over `times`."""
    dragon = _march(source).dragon
    corners = [dragon.outlines(moment.poses).reshape(-1, 2) for moment in moments(source, times)]
    return np.min([c.min(axis=0) for c in corners], axis=0), np.max([c.max(axis=0) for c in corners], axis=0)
