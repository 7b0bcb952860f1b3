"""Pictures of a run, or of a march, as a film or one by one."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import imageio.v3 as iio
import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.checks import finite, positive, whole
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.files import check_destination, written_in_place
from pymunk_dragon.march import March
from pymunk_dragon.render.camera import HEAD_SPAN, Camera
from pymunk_dragon.render.gif import GifStream
from pymunk_dragon.render.palette import TRANSPARENT, Palette
from pymunk_dragon.render.scene import Scene
from pymunk_dragon.run import Run

__all__ = [
    "FILM_ENDINGS",
    "FPS",
    "STILL_ENDINGS",
    "Film",
    "make_scene",
    "render",
    "states",
    "write_film",
    "write_still",
]

Array = NDArray[np.float64]
Source = Run | March
Progress = Callable[[int, int], None]

FILM_ENDINGS, STILL_ENDINGS = (".gif",), (".png",)
# A GIF's delays are whole centiseconds, and browsers slow 1 centisecond down to 10: these are the even rates left.
FPS = (10, 20, 25, 50)
# Centiseconds: the shortest delay that browsers keep to.
MIN_DELAY = 2
# Pixels a side. Below, the type fills the picture; above, a GIF is the wrong format.
MIN_SIZE, MAX_SIZE = 64, 2048
# Frames: half an hour at 10 a second. More is a slip of the finger.
MAX_FRAMES = 20_000
# Simulated seconds per second: faster than that, any march is over within its first frame.
MAX_SPEEDUP = 1e6
# Seconds; a GIF's longest delay is 655 s.
MAX_HOLD = 60.0
# Frames whose poses are worked out at once: enough to make a call per frame cheap, little enough to stay small.
CHUNK = 32
# Samples of the march from which the field in view is found, and the free border around it as a share.
FIELD_SAMPLES, FIELD_BORDER = 64, 0.03
# Share of a frame that a window may be longer than its whole frames without getting one more.
ROUNDING = 1e-6


@dataclass(frozen=True, kw_only=True)
class Film:
    """How a run becomes a film.

    Parameters
    ----------
    fps : {10, 20, 25, 50}
        Frames per second of film.
    speedup : float
        Simulated seconds per second of film.
    size : int or tuple of int
        Width and height in pixels; one number for a square.
    since, until : float, optional
        Simulated time of the first and the last frame, s. By default the whole run; a march needs `until`, and begins
        at 0.
    hold : float
        How long the last frame stays, s.
    camera : Camera
        What the film shows.
    palette : Palette
        Its colours.
    gap : bool, optional
        Whether to write down the smallest gap between the head and a bench that is not its neighbour; by default
        where the camera follows the head.

    Raises
    ------
    ParameterError
        If a number is out of its bounds.

    Notes
    -----
    The defaults film the seed's whole run in 21 s and less than 3 MB. A frame in which 223 benches move takes 14 kB,
    so such a film has about 200 frames.
    """

    fps: int = 10
    speedup: float = 20.0
    size: int | tuple[int, int] = 440
    since: float | None = None
    until: float | None = None
    hold: float = 1.0
    camera: Camera = field(default_factory=Camera)
    palette: Palette = field(default_factory=Palette)
    gap: bool | None = None

    def __post_init__(self) -> None:
        if type(self.fps) is not int or self.fps not in FPS:
            raise ParameterError("fps", self.fps, "one of " + ", ".join(map(str, FPS)))
        positive("speedup", self.speedup, MAX_SPEEDUP, "")
        if isinstance(self.size, tuple) and len(self.size) != 2:
            raise ParameterError("size", self.size, "one number, or a width and a height")
        for length in self.shape:
            whole("size", length, MIN_SIZE, MAX_SIZE)
        for name in ("since", "until"):
            if getattr(self, name) is not None:
                finite(name, getattr(self, name), -math.inf, math.inf, "s")
        finite("hold", self.hold, 0.0, MAX_HOLD, "s")

    @property
    def shape(self) -> tuple[int, int]:
        """Width and height, pixels."""
        return self.size if isinstance(self.size, tuple) else (self.size, self.size)

    @property
    def shows_gap(self) -> bool:
        """Whether the gap is written down."""
        return self.camera.follow == "head" if self.gap is None else self.gap

    def times(self, source: Source) -> Array:
        """Simulated times of the frames, (F,) in s; the last one is the end of the window, however near.

        Raises
        ------
        ParameterError
            If the window is empty, leaves the run, or takes too many frames.
        """
        since, until = self._window(source)
        step = self.speedup / self.fps
        frames = (until - since) / step
        if frames > MAX_FRAMES:
            raise ParameterError("speedup", self.speedup, f"such that the film has at most {MAX_FRAMES} frames")
        count = math.ceil(frames - ROUNDING)
        times: Array = np.minimum(since + step * np.arange(count + 1), until)
        return times

    def delays(self, times: Array) -> list[int]:
        """How long the frames at `times` (F,) stay, in centiseconds.

        A window that is no whole number of frames long shortens the last but one. The last stays for `hold`, and at
        least as long as any.
        """
        delay = 100 // self.fps
        last = max(delay, round(100 * self.hold))
        if len(times) == 1:
            return [last]
        whole_frames = len(times) - 2
        rest = round(100 * (times[-1] - times[0]) / self.speedup) - whole_frames * delay
        return [delay] * whole_frames + [max(MIN_DELAY, rest), last]

    def _window(self, source: Source) -> tuple[float, float]:
        if isinstance(source, Run):
            begin, end = float(source.times[0]), float(source.times[-1])
        else:
            begin, end = -math.inf, source.end
        since, until = self.since, self.until
        if since is None:
            since = begin if isinstance(source, Run) else 0.0
        if until is None:
            if isinstance(source, March):
                raise ParameterError("until", None, f"given for a march, at most {end:.6g} s")
            until = end
        finite("since", since, begin, end, "s")
        finite("until", until, begin, end, "s")
        if until < since:
            raise ParameterError("until", until, f"at least since, {since:g} s")
        return since, until


def render(source: Source, path: str | Path, *, progress: Progress | None = None, **options: Any) -> None:
    """Write a film: `write_film` with the parameters of `Film` given one by one.

    Examples
    --------
    >>> render(March(), "march.gif", until=412.47, speedup=20)  # doctest: +SKIP
    """
    write_film(source, path, Film(**options), progress)


def write_film(source: Source, path: str | Path, film: Film | None = None, progress: Progress | None = None) -> None:
    """Write a film as GIF.

    Parameters
    ----------
    source : Run or March
        A run is played from its frames, a march by the exact model.
    path : path
        File to write, ending in .gif. An interrupted film leaves the old file or none.
    film : Film, optional
        Speed, size, window, camera and colours.
    progress : callable, optional
        Told the number of frames done, and of all frames, after each one.

    Raises
    ------
    ParameterError
        If the file cannot be made, or the film does not fit the run.
    UnreachableError
        If a march's dragon has no place on its curve within the film.
    OutputError
        If writing fails.
    """
    film = film or Film()
    destination = check_destination(path, FILM_ENDINGS)
    times = film.times(source)
    delays = film.delays(times)
    scene = make_scene(source, film, times)
    with (
        written_in_place(destination) as draft,
        draft.open("wb") as file,
        GifStream(file, film.shape, film.palette.table, TRANSPARENT) as gif,
    ):
        for done, (time, poses) in enumerate(states(source, times), start=1):
            gif.add(scene.draw(time, poses), delays[done - 1])
            if progress:
                progress(done, len(times))


def write_still(source: Source, time: float, path: str | Path, film: Film | None = None) -> None:
    """Write one picture of a run or a march as PNG: what `film`, its window aside, shows at `time` s.

    Raises
    ------
    ParameterError
        If the file cannot be made, or `time` is outside the run.
    UnreachableError
        If the march's dragon has no place on its curve at `time`.
    OutputError
        If writing fails.
    """
    film = film or Film()
    destination = check_destination(path, STILL_ENDINGS)
    begin, end = (source.times[0], source.times[-1]) if isinstance(source, Run) else (-math.inf, source.end)
    finite("time", time, begin, end, "s")
    [(_, poses)] = states(source, np.array([time], dtype=float))
    picture = make_scene(source, film, np.array([time], dtype=float)).draw(time, poses)
    with written_in_place(destination) as draft:
        iio.imwrite(draft, film.palette.table[np.asarray(picture)], extension=".png")


def states(source: Source, times: Array) -> Iterator[tuple[float, Array]]:
    """Time and poses (N, 3) of every frame, a few frames at once."""
    for begin in range(0, len(times), CHUNK):
        chunk = times[begin : begin + CHUNK]
        yield from zip(chunk.tolist(), _poses(source, chunk), strict=True)


def _poses(source: Source, times: Array) -> Array:
    return source.poses_at(times) if isinstance(source, Run) else source.at(times).poses


def make_scene(source: Source, film: Film, times: Array) -> Scene:
    """Scene of a film whose frames are at `times` (F,) in s."""
    centre, span = (0.0, 0.0), HEAD_SPAN
    if film.camera.follow == "field":
        low, high = _extent(source, np.linspace(times[0], times[-1], min(FIELD_SAMPLES, len(times))))
        centre = (float(low[0] + high[0]) / 2, float(low[1] + high[1]) / 2)
        width, height = film.shape
        span = (1 + 2 * FIELD_BORDER) * float(max(high[0] - low[0], (high[1] - low[1]) * width / height))
    return Scene(
        source.march if isinstance(source, Run) else source,
        film.camera,
        centre=centre,
        span=film.camera.span or span,
        size=film.shape,
        contact=source.first_contact if isinstance(source, Run) else None,
        gap=film.shows_gap,
    )


def _extent(source: Source, times: Array) -> tuple[Array, Array]:
    """Lower left and upper right corner, m, of the ground that the dragon covers at `times`."""
    dragon = source.march.dragon if isinstance(source, Run) else source.dragon
    corners = [dragon.outlines(poses).reshape(-1, 2) for _, poses in states(source, times)]
    return np.min([c.min(axis=0) for c in corners], axis=0), np.max([c.max(axis=0) for c in corners], axis=0)
