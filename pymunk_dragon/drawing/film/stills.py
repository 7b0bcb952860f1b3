"""Still pictures: of a run or march at one time, and the last frame of a film."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageSequence

from pymunk_dragon._checks import finite
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon.drawing.film.layout import lay_out, sampled
from pymunk_dragon.drawing.film.settings import Film, checked_sources, shared_window
from pymunk_dragon.drawing.snapshots import Source

# All endings of still pictures, in lower case.
STILL_ENDINGS = (".png", ".pdf")
# A picture in a PDF: pixels per inch, of which a page of 8 inches has 1600; a JPEG quality without visible artefacts;
# and no properties that would give equal pictures different bytes.
PDF = {"resolution": 200.0, "quality": 95, "subsampling": 0, "title": None, "creationDate": None, "modDate": None}


def write_still(source: Source | Sequence[Source], time: float, path: str | Path, film: Film | None = None) -> None:
    """Write the picture at one time as a PNG file, or as a PDF with one page; parameters as in `still`.

    Raises
    ------
    ParameterError
        As in `still`, or if the file cannot be created.
    OutputError
        If writing fails.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March
    >>> from pymunk_dragon.drawing import Film, write_still
    >>> write_still(March(Dragon(benches=16)), 60.0, "march.png", Film(size=640))
    """
    destination = check_destination(path, STILL_ENDINGS)
    picture = Image.fromarray(still(source, time, film))
    with written_in_place(destination) as draft:
        if destination.suffix.lower() == ".pdf":
            picture.save(draft, format="PDF", **PDF)
        else:
            picture.save(draft, format="PNG", optimize=True)


def still_png(source: Source | Sequence[Source], time: float, film: Film | None = None) -> bytes:
    """Return the content of the PNG file that `write_still` writes."""
    content = io.BytesIO()
    Image.fromarray(still(source, time, film)).save(content, format="PNG", optimize=True)
    return content.getvalue()


def still(source: Source | Sequence[Source], time: float, film: Film | None = None) -> NDArray[np.uint8]:
    """Return the picture (height, width, 3) of a run or march, or of several side by side, at one time, s.

    The film has size, camera, marks, texts and colours; its time window is ignored.

    Raises
    ------
    ParameterError
        If `time` is outside the run, or the run has no data for a mark.
    UnreachableError
        If the dragon of a march does not fit on its curve at `time`.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March
    >>> from pymunk_dragon.drawing import Film, still
    >>> still(March(Dragon(benches=16)), 60.0, Film(size=(320, 240), legend=False)).shape
    (240, 320, 3)
    """
    film = film or Film()
    sources = checked_sources(source)
    finite("time", time, *shared_window(sources), "s")
    clips = sampled(sources, np.array([time], dtype=float), film)
    return np.asarray(lay_out(clips, film).draw([next(clip.snapshots) for clip in clips]))


def picture_size(content: bytes) -> tuple[int, int]:
    """Return width and height, pixels, of a picture or film from the content of its file."""
    with Image.open(io.BytesIO(content)) as opened:
        return opened.size


def last_frame(content: bytes) -> bytes:
    """Return the last frame of a film as PNG, from the content of the film's file."""
    picture = io.BytesIO()
    with Image.open(io.BytesIO(content)) as film:
        *_, last = (frame.convert("RGB") for frame in ImageSequence.Iterator(film))
        last.save(picture, format="PNG", optimize=True)
    return picture.getvalue()
