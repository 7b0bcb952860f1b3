"""Parameters of a film, and the times of its frames."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import finite, positive, whole
from pymunk_dragon.drawing.camera import Camera
from pymunk_dragon.drawing.palette import Palette
from pymunk_dragon.drawing.snapshots import Mark, Source
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

# Frames per second: the refresh rate of common screens.
MAX_FPS = 60
# s: shortest delay of a GIF frame that browsers respect.
MIN_DELAY = 0.02
# Pixels: in a smaller picture the text covers the dragon.
MIN_SIZE = 64
# Pixels: a film is not a suitable format for larger pictures.
MAX_SIZE = 2048
# Frames: half an hour at 10 frames per second. A larger number is taken for a typing error.
MAX_FRAMES = 20_000
# Simulated seconds per second of film: at a higher factor any march ends within its first frame.
MAX_SPEEDUP = 1e6
# s: below the longest delay of an APNG, 65 s.
MAX_HOLD = 60.0
# Characters of a title or a caption: a few lines.
MAX_TEXT = 500
# Pictures side by side: more would be too small to see.
MAX_PANELS = 4
# Default view and colours.
FIXED_CAMERA = Camera()
COLOURS = Palette()
# Frames: a remainder of the window below this is rounding error and gets no frame of its own.
ROUNDING = 1e-6


@dataclass(frozen=True, kw_only=True)
class Film:
    """Parameters of a film.

    Parameters
    ----------
    fps : int
        Frames per second of film, at most 60, and 50 in a GIF.
    speedup : float
        Simulated seconds per second of film.
    size : int or tuple of int
        Width and height, pixels; one number for a square.
    start, until : float, optional
        Simulated time of the first and the last frame, s. The default is the whole run. A march begins at 0 and
        requires `until`.
    hold : float
        Duration of the last frame, s.
    camera : Camera
        View of the film.
    palette : Palette
        Colours of the film.
    gap : bool, optional
        Whether to display the smallest gap between the head and a bench that is not its neighbour. By default the gap
        is displayed if the camera follows the head.
    show : tuple of str
        Marks drawn over the benches. "velocities": arrows to where each handle would be in half a second. "grid": the
        cells of the broad phase, darker if they contain a bench. "contacts" and "normals" of benches that touch, for
        runs only. "impulses" in the joints as areas of discs, the largest nearly as wide as a bench, for runs of the
        engine only.
    title, caption : str
        Text above and below the picture; the height of the film increases accordingly.
    headings : tuple of str
        Text above each of several pictures side by side; by default the model that computed the run.
    font : str or Path, optional
        TrueType or OpenType font file, for characters that Pillow's default font lacks, such as Chinese.

    Raises
    ------
    ParameterError
        If a number is out of bounds.

    Notes
    -----
    With the defaults, the film of the reference scenario's whole run lasts 21 s and is smaller than 3 MB. It has about
    200 frames; a frame with 223 moving benches takes 14 kB.

    Examples
    --------
    >>> from pymunk_dragon import March
    >>> from pymunk_dragon.drawing import Film
    >>> film = Film(fps=10, speedup=20, until=8)
    >>> film.times([March()])
    array([0., 2., 4., 6., 8.])
    """

    fps: int = 10
    speedup: float = 20.0
    size: int | tuple[int, int] = 440
    start: float | None = None
    until: float | None = None
    hold: float = 1.0
    camera: Camera = FIXED_CAMERA
    palette: Palette = COLOURS
    gap: bool | None = None
    show: tuple[Mark, ...] = ()
    title: str = ""
    caption: str = ""
    headings: tuple[str, ...] = ()
    font: str | Path | None = None

    def __post_init__(self) -> None:
        whole("fps", self.fps, 1, MAX_FPS)
        positive("speedup", self.speedup, MAX_SPEEDUP, "")
        if isinstance(self.size, tuple) and len(self.size) != 2:
            raise ParameterError("size", self.size, "one number, or a width and a height")
        for length in self.shape:
            whole("size", length, MIN_SIZE, MAX_SIZE)
        for name in ("start", "until"):
            if getattr(self, name) is not None:
                finite(name, getattr(self, name), -math.inf, math.inf, "s")
        finite("hold", self.hold, 0.0, MAX_HOLD, "s")
        for name, kind in (("camera", Camera), ("palette", Palette)):
            if not isinstance(getattr(self, name), kind):
                raise ParameterError(name, getattr(self, name), f"a {kind.__name__}")
        for name in ("show", "headings"):
            if not isinstance(getattr(self, name), tuple):
                raise ParameterError(name, getattr(self, name), "a tuple of texts")
        texts: list[tuple[str, object]] = [("title", self.title), ("caption", self.caption)]
        for name, text in texts + [("headings", heading) for heading in self.headings]:
            if not (isinstance(text, str) and len(text) <= MAX_TEXT):
                raise ParameterError(name, text, f"a text of at most {MAX_TEXT} characters")

    @property
    def shape(self) -> tuple[int, int]:
        """Width and height, pixels."""
        return self.size if isinstance(self.size, tuple) else (self.size, self.size)

    @property
    def shows_gap(self) -> bool:
        """Whether the gap is displayed."""
        return self.camera.follow == "head" if self.gap is None else self.gap

    def times(self, sources: Sequence[Source]) -> Array:
        """Return the simulated times of the frames (F,), s. The last time is always the end of the window.

        Raises
        ------
        ParameterError
            If the window is empty, extends beyond the run, or requires too many frames.
        """
        start, until = self._window(sources)
        step = self.speedup / self.fps
        frames = (until - start) / step
        if frames > MAX_FRAMES:
            raise ParameterError("speedup", self.speedup, f"such that the film has at most {MAX_FRAMES} frames")
        count = math.ceil(frames - ROUNDING)
        times: Array = np.minimum(start + step * np.arange(count + 1), until)
        return times

    def ends(self, times: Array) -> Array:
        """Return the film times (F,), s, at which the frames at the simulated `times` (F,), s, end.

        The last frame is shown for `hold`, but at least for 1 / `fps`.
        """
        starts = (times - times[0]) / self.speedup
        # The last frame but one is shorter if the window is not a whole number of frames long.
        starts[-1] = max(starts[-1], starts[max(0, len(times) - 2)] + (MIN_DELAY if len(times) > 1 else 0.0))
        return np.append(starts[1:], starts[-1] + max(1 / self.fps, self.hold))

    def _window(self, sources: Sequence[Source]) -> tuple[float, float]:
        begin, end = shared_window(sources)
        start, until = self.start, self.until
        if start is None:
            start = begin if math.isfinite(begin) else 0.0
        if until is None:
            ends = [float(source.times[-1]) for source in sources if isinstance(source, Run)]
            if not ends:
                raise ParameterError("until", None, f"given for a march, at most {end:.6g} s")
            until = min(max(ends), end)
        finite("start", start, begin, end, "s")
        finite("until", until, begin, end, "s")
        if until < start:
            raise ParameterError("until", until, f"no earlier than the first time, {start:g} s")
        return start, until


def shared_window(sources: Sequence[Source]) -> tuple[float, float]:
    """Return the time interval, s, in which all sources can be shown; a run that has ended keeps its last frame."""
    runs = [source.times for source in sources if isinstance(source, Run)]
    marches = [source.end for source in sources if isinstance(source, March)]
    begin = max((float(times[0]) for times in runs), default=-math.inf)
    return begin, min(marches) if marches else max(float(times[-1]) for times in runs)


def checked_sources(source: Any) -> tuple[Source, ...]:
    """Return `source`, one run or march or a sequence of them, as a tuple.

    Raises
    ------
    ParameterError
        If `source` is anything else, or a sequence of more than 4.
    """
    sources = tuple(source) if isinstance(source, Sequence) else (source,)
    if not all(isinstance(one, Run | March) for one in sources) or not 1 <= len(sources) <= MAX_PANELS:
        kinds = [type(one).__name__ for one in sources] if sources and isinstance(source, Sequence) else source
        raise ParameterError("source", kinds, f"a Run or a March, or a list of at most {MAX_PANELS} of them")
    return sources
