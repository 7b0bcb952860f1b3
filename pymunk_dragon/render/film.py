"""How a run, or a march, becomes a film: its speed, its window, and what it shows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.checks import finite, positive, whole
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.march import March
from pymunk_dragon.render.camera import Camera
from pymunk_dragon.render.moments import Mark, Source, window
from pymunk_dragon.render.palette import Palette
from pymunk_dragon.run import Run

__all__ = ["Film", "shared_window"]

Array = NDArray[np.float64]

# Frames a second: what screens show.
MAX_FPS = 60
# s: the shortest that browsers show a frame of a GIF.
MIN_DELAY = 0.02
# Pixels a side. Below, the type fills the picture; above, a film is the wrong format.
MIN_SIZE, MAX_SIZE = 64, 2048
# Frames: half an hour at 10 a second. More is a slip of the finger.
MAX_FRAMES = 20_000
# Simulated seconds per second: faster than that, any march is over within its first frame.
MAX_SPEEDUP = 1e6
# Seconds; an APNG's longest delay is 65 s.
MAX_HOLD = 60.0
# Characters of a title or a caption: a few lines.
MAX_TEXT = 500
# Share of a frame that a window may be longer than its whole frames without getting one more.
ROUNDING = 1e-6


@dataclass(frozen=True, kw_only=True)
class Film:
    """How a run becomes a film.

    Parameters
    ----------
    fps : int
        Frames per second of film, at most 60, and 50 in a GIF.
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
    show : tuple of str
        Marks to lay over the benches: "velocities", as where each handle would be in half a second; "grid", the cells
        of the broad phase, darker where a bench is filed; of runs "contacts" and "normals" where benches touch; of
        the engine's runs "impulses" in the joints, as the areas of discs, the largest nearly as wide as a bench.
    title, caption : str
        Lines above and below the picture, which grows by as much.
    headings : tuple of str
        What stands above each of several pictures side by side; by default who played it.
    font : str or Path, optional
        File of a TrueType or OpenType face, for words that Pillow's own has no letters for, as Chinese ones.

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
        for name in ("since", "until"):
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
        """Whether the gap is written down."""
        return self.camera.follow == "head" if self.gap is None else self.gap

    def times(self, sources: Sequence[Source]) -> Array:
        """Simulated times of the frames, (F,) in s; the last one is the end of the window, however near.

        Raises
        ------
        ParameterError
            If the window is empty, leaves the run, or takes too many frames.
        """
        since, until = self._window(sources)
        step = self.speedup / self.fps
        frames = (until - since) / step
        if frames > MAX_FRAMES:
            raise ParameterError("speedup", self.speedup, f"such that the film has at most {MAX_FRAMES} frames")
        count = math.ceil(frames - ROUNDING)
        times: Array = np.minimum(since + step * np.arange(count + 1), until)
        return times

    def ends(self, times: Array) -> Array:
        """When in the film the frames at `times` (F,) end, (F,) in s.

        The last stays for `hold`, and at least as long as any.
        """
        starts = (times - times[0]) / self.speedup
        # A window that is no whole number of frames long shortens the last but one.
        starts[-1] = max(starts[-1], starts[max(0, len(times) - 2)] + (MIN_DELAY if len(times) > 1 else 0.0))
        return np.append(starts[1:], starts[-1] + max(1 / self.fps, self.hold))

    def _window(self, sources: Sequence[Source]) -> tuple[float, float]:
        begin, end = shared_window(sources)
        since, until = self.since, self.until
        if since is None:
            since = begin if math.isfinite(begin) else 0.0
        if until is None:
            ends = [float(source.times[-1]) for source in sources if isinstance(source, Run)]
            if not ends:
                raise ParameterError("until", None, f"given for a march, at most {end:.6g} s")
            until = min(max(ends), end)
        finite("since", since, begin, end, "s")
        finite("until", until, begin, end, "s")
        if until < since:
            raise ParameterError("until", until, f"no earlier than the first time, {since:g} s")
        return since, until


def shared_window(sources: Sequence[Source]) -> tuple[float, float]:
    """From when all of them have something to show, s, until when one moves; a run that is over can stand still."""
    windows = [window(source) for source in sources]
    marches = [end for source, (_, end) in zip(sources, windows, strict=True) if isinstance(source, March)]
    return max(begin for begin, _ in windows), min([max(end for _, end in windows), *marches])
