"""Parameters of a film."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from pymunk_dragon._checks import finite, flag, instance, label, positive, whole, word
from pymunk_dragon.drawing.camera import Camera
from pymunk_dragon.drawing.marks import OVERLAYS
from pymunk_dragon.errors import ParameterError

# Frames per second, of which the delay in a GIF is a whole number of centiseconds.
_FPS = 20
# Frames per second: the refresh rate of common screens.
_MAX_FPS = 60
# Pixels: in a smaller picture the text covers the dragon.
_MIN_SIZE = 64
# Pixels: a film is not a suitable format for larger pictures.
_MAX_SIZE = 2048
# s: a longer one is taken for a typing error.
_MAX_HOLD = 60.0
# Characters of a text: more are higher than a film.
_MAX_TEXT = 10_000


@dataclass(frozen=True, kw_only=True)
class Film:
    """Parameters of a film.

    Parameters
    ----------
    fps : int
        Frames per second of film, at most 60, and 50 in a GIF.
    speedup : float, optional
        Simulated seconds per second of film. By default the film slows down towards near misses and
        contacts.
    size : int or tuple of int
        Width and height of the picture without texts, pixels; one number for a square. An MP4
        leaves out the last column or row that would make the size of the film odd.
    start : float, optional
        Simulated time of the first frame, s. By default a film with a constant speed begins with
        the run, any other late enough to be 11 s long.
    until : float, optional
        Simulated time of the last frame, s; by default the end of the run. A march ends with its
        first contact, or after 60 s if there is none or its curve has no end; several marches
        require `until`.
    hold : float
        Duration of the last frame, s.
    camera : Camera
        View.
    legend : bool
        Whether to display a legend and a scale bar below the picture, if it is wide enough.
    show : tuple of str
        Overlays by their names in `OVERLAYS`: "velocities"; "grid"; "contacts", for runs only;
        "forces" in the joints, for runs that have them.
    title : str
        Text above the picture; the height of the film increases accordingly.
    caption : str
        Text below the picture, which adds to the height too.
    headings : tuple of str
        Text above each of several pictures side by side; by default the model that computed the
        run.

    Raises
    ------
    ParameterError
        If a number is out of bounds.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, Film, March, render
    >>> film = Film(fps=10, speedup=20, until=8)
    >>> render(March(Dragon(benches=16)), "march.gif", film).times
    array([0., 2., 4., 6., 8.])
    """

    fps: int = _FPS
    speedup: float | None = None
    size: int | tuple[int, int] = 440
    start: float | None = None
    until: float | None = None
    hold: float = 2.5
    camera: Camera = field(default_factory=Camera)
    legend: bool = True
    show: tuple[str, ...] = ()
    title: str = ""
    caption: str = ""
    headings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        whole("fps", self.fps, 1, _MAX_FPS)
        if self.speedup is not None:
            positive("speedup", self.speedup, math.inf, "")
        if len(self.shape) != 2:
            raise ParameterError("size", self.size, "one number, or a width and a height")
        for length in self.shape:
            whole("size", length, _MIN_SIZE, _MAX_SIZE)
        finite("hold", self.hold, 0.0, _MAX_HOLD, "s")
        for name, time in (("start", self.start), ("until", self.until)):
            if time is not None:
                finite(name, time, unit="s")
        instance("camera", self.camera, Camera, "a Camera")
        flag("legend", self.legend)
        for overlay in instance("show", self.show, tuple, "a tuple of overlays"):
            word("show", overlay, OVERLAYS)
        instance("headings", self.headings, tuple, "a tuple of texts")
        for name, text in self.texts(self.headings):
            if len(label(name, text)) > _MAX_TEXT:
                raise ParameterError(name, text, f"a text of at most {_MAX_TEXT} characters")

    @property
    def shape(self) -> tuple[int, int]:
        """Width and height, pixels."""
        return self.size if isinstance(self.size, tuple) else (self.size, self.size)

    def texts(self, headings: Sequence[str]) -> list[tuple[str, str]]:
        """Names and values of title, caption and headings."""
        texts = [("title", self.title), ("caption", self.caption)]
        return texts + [("headings", each) for each in headings]
