"""Films and stills of a run, or of a march, or of several side by side."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.checks import finite, whole
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.files import check_destination, written_in_place
from pymunk_dragon.march import March
from pymunk_dragon.render.camera import HEAD_SPAN
from pymunk_dragon.render.film import Film, shared_window
from pymunk_dragon.render.filming import expose
from pymunk_dragon.render.moments import Source, check_marks, largest_impulse, moments
from pymunk_dragon.render.scene import Scene
from pymunk_dragon.render.sheet import Sheet
from pymunk_dragon.render.streams import FILM_ENDINGS, check_ending, open_stream
from pymunk_dragon.run import Run

__all__ = ["STILL_ENDINGS", "make_sheet", "render", "still", "still_png", "write_film", "write_still"]

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]

STILL_ENDINGS = (".png",)
# Side by side; more would be too small to see.
MAX_PANELS = 4
# Processes: more than any machine has that films a dragon.
MAX_WORKERS = 64
# Samples of the march from which the field in view is found, and the free border around it as a share.
FIELD_SAMPLES, FIELD_BORDER = 64, 0.03


def render(
    source: Source | Sequence[Source],
    path: str | Path,
    *,
    progress: Progress | None = None,
    workers: int = 0,
    **options: Any,
) -> None:
    """Write a film: `write_film` with the parameters of `Film` given one by one.

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
    """Write a film, frame by frame: it takes no more memory the longer it gets.

    Parameters
    ----------
    source : Run or March, or a sequence of them
        A run is played from its frames, a march by the exact model. Several stand side by side, in step; one that is
        over stays as it ended.
    path : path
        File to write: .gif, .apng, .webp, or .mp4 with the extra `mp4`. An interrupted film leaves the old file or
        none.
    film : Film, optional
        Speed, size, window, camera, marks, words and colours.
    progress : callable, optional
        Told the number of frames done, and of all frames, after each one.
    workers : int
        Other processes that help with films of 150 frames and more; the film is the same to the byte. As always with
        processes in Python, a script that asks for them must guard its start with `if __name__ == "__main__":`.

    Raises
    ------
    ParameterError
        If the file cannot be made, or the film does not fit the run.
    UnreachableError
        If a march's dragon has no place on its curve within the film.
    MissingExtraError
        If it is an MP4, and FFmpeg is not installed.
    OutputError
        If writing fails.
    """
    film = film or Film()
    sources = _sources(source)
    whole("workers", workers, 0, MAX_WORKERS)
    destination = check_destination(path, FILM_ENDINGS)
    check_ending(destination, film.fps)
    times = film.times(sources)
    sheet = make_sheet(sources, film, times)
    views = zip(*(moments(one, times, film.show) for one in sources), strict=True)
    told = progress or (lambda done, total: None)
    with (
        written_in_place(destination) as draft,
        open_stream(draft, sheet.size, film.palette.table, film.fps) as stream,
    ):
        expose(stream, sheet, views, film.ends(times).tolist(), workers, lambda done: told(done, len(times)))


def write_still(source: Source | Sequence[Source], time: float, path: str | Path, film: Film | None = None) -> None:
    """Write one picture as PNG: what `film`, its window aside, shows at `time` s.

    Raises
    ------
    ParameterError
        If the file cannot be made, or `time` is outside the run.
    UnreachableError
        If the march's dragon has no place on its curve at `time`.
    OutputError
        If writing fails.
    """
    destination = check_destination(path, STILL_ENDINGS)
    picture = still_png(source, time, film)
    with written_in_place(destination) as draft:
        draft.write_bytes(picture)


def still_png(source: Source | Sequence[Source], time: float, film: Film | None = None) -> bytes:
    """What `write_still` writes."""
    # It takes longer to load than all the rest, and films do without it.
    import imageio.v3 as iio

    picture: bytes = iio.imwrite("<bytes>", still(source, time, film), extension=".png")
    return picture


def still(source: Source | Sequence[Source], time: float, film: Film | None = None) -> NDArray[np.uint8]:
    """One picture as red, green and blue (height, width, 3): what `film`, its window aside, shows at `time` s.

    Raises
    ------
    ParameterError
        If `time` is outside the run.
    UnreachableError
        If the march's dragon has no place on its curve at `time`.
    """
    film = film or Film()
    sources = _sources(source)
    begin, end = shared_window(sources)
    finite("time", time, begin, end, "s")
    times = np.array([time], dtype=float)
    picture = make_sheet(sources, film, times).draw([next(moments(one, times, film.show)) for one in sources])
    colours: NDArray[np.uint8] = film.palette.table[np.asarray(picture)]
    return colours


def make_sheet(sources: Sequence[Source], film: Film, times: Array) -> Sheet:
    """What draws the frames of a film at `times` (F,) in s."""
    for source in sources:
        check_marks(source, film.show)
    centre, span = (0.0, 0.0), HEAD_SPAN * max(float(_march(source).dragon.widths[0]) for source in sources)
    if film.camera.follow == "field":
        sample = np.linspace(times[0], times[-1], min(FIELD_SAMPLES, len(times)))
        # All from the same distance: what stands side by side is to be compared.
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
    return Sheet(scenes, headings, film.title, film.caption, film.font)


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
    """First and last time in s of a run, or of the pictures at `times` (F,) of a march."""
    known = source.times if isinstance(source, Run) else times
    return float(known[0]), float(known[-1])


def _heading(source: Source) -> str:
    """Who played, in a word or two."""
    if isinstance(source, March) or source.provenance.get("player") == "exact":
        return "exact model"
    words = ["engine"]
    guide, contacts = (source.provenance.get(name) for name in ("guide", "contacts"))
    if guide is not None:
        words.append("no guide" if guide == "none" else str(guide))
    if contacts == "resolve":
        words.append("contacts resolved")
    return ", ".join(words)


def _extent(source: Source, times: Array) -> tuple[Array, Array]:
    """Lower left and upper right corner, m, of the ground that the dragon covers at `times`."""
    dragon = _march(source).dragon
    corners = [dragon.outlines(moment.poses).reshape(-1, 2) for moment in moments(source, times)]
    return np.min([c.min(axis=0) for c in corners], axis=0), np.max([c.max(axis=0) for c in corners], axis=0)
