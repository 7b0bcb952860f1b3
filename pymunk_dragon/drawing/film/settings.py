"""Parameters of a film, and the times of its frames."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pymunk_dragon._checks import finite, positive, whole, word
from pymunk_dragon.drawing.camera import Camera
from pymunk_dragon.drawing.film.timing import FIELD_ADVANCE, HEAD_ADVANCE, STANDARD_FPS, Timing, constant, slowed
from pymunk_dragon.drawing.overlay import OVERLAYS
from pymunk_dragon.drawing.palette import Palette
from pymunk_dragon.drawing.snapshots import Source
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

# Frames per second: the refresh rate of common screens.
MAX_FPS = 60
# Pixels: in a smaller picture the text covers the dragon, and a film is not a suitable format for larger ones.
SIZES = 64, 2048
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


@dataclass(frozen=True, kw_only=True)
class Film:
    """Parameters of a film.

    Parameters
    ----------
    fps : int, optional
        Frames per second of film, at most 60, and 50 in a GIF. The default is 20, or 25 or 50 in long films.
    speedup : float, optional
        Simulated seconds per second of film. By default the film slows down towards near misses and contacts.
    size : int or tuple of int
        Width and height, pixels; one number for a square.
    start, until : float, optional
        Simulated time of the first and the last frame, s. By default a film with a constant speed begins with the run,
        any other late enough to be 11 s long, and both end with the run. A march requires `until`.
    hold : float
        Duration of the last frame, s.
    camera, palette : Camera, Palette
        View and colours.
    gap : bool, optional
        Whether to display the smallest gap between the head and a bench that is not its neighbour. By default the gap
        is displayed if the camera follows the head or the gap is below 1 cm.
    legend : bool
        Whether to display a legend and a scale bar below the picture, if it is wide enough.
    show : tuple of str
        Overlays by their names in `OVERLAYS`: "velocities"; "grid"; "contacts" and "normals", for runs only;
        "impulses" in the joints, for runs of the engine only.
    title, caption : str
        Text above and below the picture; the height of the film increases accordingly.
    headings : tuple of str
        Text above each of several pictures side by side; by default the model that computed the run.
    font : str or Path, optional
        TrueType or OpenType font file of title, caption and headings, for characters that the default font lacks.

    Raises
    ------
    ParameterError
        If a number is out of bounds.

    Notes
    -----
    Without `speedup`, each near miss of the exact model adds about 1 s and a contact 2 s to the film, half of that
    before the event. Elsewhere the head travels 0.4 of the shortest body spacing in a frame (0.1 if the camera follows
    the head): 0.66 m of the paper's dragon. From 0.5 on, the eye would take each bench for the next one. With `start`,
    the film is at most 20 s long, with up to 50 frames per second for a long march, and only then faster. It is shorter
    than 8 s only if it would be slower than half of real time otherwise.

    Examples
    --------
    >>> from pymunk_dragon import March
    >>> from pymunk_dragon.drawing import Film
    >>> Film(fps=10, speedup=20, until=8).timing([March()]).times
    array([0., 2., 4., 6., 8.])
    >>> timing = Film(start=0, until=400).timing([March()])
    >>> timing.fps, timing.ends[-1].item()
    (50, 14.62)
    """

    fps: int | None = None
    speedup: float | None = None
    size: int | tuple[int, int] = 440
    start: float | None = None
    until: float | None = None
    hold: float = 2.5
    camera: Camera = FIXED_CAMERA
    palette: Palette = COLOURS
    gap: bool | None = None
    legend: bool = True
    show: tuple[str, ...] = ()
    title: str = ""
    caption: str = ""
    headings: tuple[str, ...] = ()
    font: str | Path | None = None

    def __post_init__(self) -> None:
        if self.fps is not None:
            whole("fps", self.fps, 1, MAX_FPS)
        if self.speedup is not None:
            positive("speedup", self.speedup, MAX_SPEEDUP, "")
        if isinstance(self.size, tuple) and len(self.size) != 2:
            raise ParameterError("size", self.size, "one number, or a width and a height")
        for length in self.shape:
            whole("size", length, *SIZES)
        for name in ("start", "until"):
            if getattr(self, name) is not None:
                finite(name, getattr(self, name), -math.inf, math.inf, "s")
        finite("hold", self.hold, 0.0, MAX_HOLD, "s")
        self._check_texts()

    def _check_texts(self) -> None:
        kinds = {"camera": Camera, "palette": Palette, "show": tuple, "headings": tuple}
        for name, kind in kinds.items():
            if not isinstance(getattr(self, name), kind):
                raise ParameterError(name, getattr(self, name), f"a {kind.__name__}")
        for overlay in self.show:
            word("show", overlay, OVERLAYS)
        texts: list[tuple[str, object]] = [("title", self.title), ("caption", self.caption)]
        for name, text in texts + [("headings", heading) for heading in self.headings]:
            if not (isinstance(text, str) and len(text) <= MAX_TEXT):
                raise ParameterError(name, text, f"a text of at most {MAX_TEXT} characters")

    @property
    def shape(self) -> tuple[int, int]:
        """Width and height, pixels."""
        return self.size if isinstance(self.size, tuple) else (self.size, self.size)

    def timing(self, sources: Sequence[Source]) -> Timing:
        """Return the times of the frames; a ParameterError if the window is not in the run, or has too many frames."""
        start, until = self.window(sources)
        if self.speedup is None:
            advance = HEAD_ADVANCE if self.camera.follow == "head" else FIELD_ADVANCE
            choose = self.start is None
            return slowed(sources, (start, until), choose_start=choose, fps=self.fps, hold=self.hold, advance=advance)
        fps = self.fps or STANDARD_FPS
        if (until - start) * fps / self.speedup > MAX_FRAMES:
            raise ParameterError("speedup", self.speedup, f"such that the film has at most {MAX_FRAMES} frames")
        return constant(start, until, self.speedup, fps, self.hold)

    def window(self, sources: Sequence[Source]) -> tuple[float, float]:
        """Return the first and last time that the film may show, s; errors as in `timing`."""
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
    """Return `source`, one run or march or a sequence of them, as a tuple."""
    sources = tuple(source) if isinstance(source, Sequence) else (source,)
    if not all(isinstance(one, Run | March) for one in sources) or not 1 <= len(sources) <= MAX_PANELS:
        kinds = [type(one).__name__ for one in sources] if sources and isinstance(source, Sequence) else source
        raise ParameterError("source", kinds, f"a Run or a March, or a list of at most {MAX_PANELS} of them")
    return sources
