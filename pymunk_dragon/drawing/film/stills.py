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
# Pixels per inch of a picture in a PDF: a page of 8 inches has 1600.
PDF_RESOLUTION = 200.0
# JPEG quality of a picture in a PDF: edges and text have no visible artefacts.
PDF_QUALITY = {"quality": 95, "subsampling": 0}
# Properties of a PDF that are omitted, so that equal pictures give equal bytes.
PDF_OMITTED = dict.fromkeys(("title", "creationDate", "modDate"))


def write_still(source: Source | Sequence[Source], time: float, path: str | Path, film: Film | None = None) -> None:
    """Write the picture at one time as a PNG file, or as a PDF with one page.

    Parameters
    ----------
    source, time, film
        As in `still`.
    path : path
        File to write, .png or .pdf. If writing is interrupted, an old file is kept and no incomplete file is left.

    Raises
    ------
    ParameterError
        As in `still`, or if the file cannot be created.
    UnreachableError
        As in `still`.
    OutputError
        If writing fails.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March
    >>> from pymunk_dragon.drawing import Film, write_still
    >>> write_still(March(Dragon(benches=16)), 60.0, "march.png", Film(size=640))
    """
    destination = check_destination(path, STILL_ENDINGS)
    if destination.suffix.lower() != ".pdf":
        png = still_png(source, time, film)
        with written_in_place(destination) as draft:
            draft.write_bytes(png)
        return
    picture = Image.fromarray(still(source, time, film))
    with written_in_place(destination) as draft:
        picture.save(draft, format="PDF", resolution=PDF_RESOLUTION, **PDF_QUALITY, **PDF_OMITTED)


def still_png(source: Source | Sequence[Source], time: float, film: Film | None = None) -> bytes:
    r"""Return the content of the PNG file that `write_still` writes; parameters and errors as in `still`.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March
    >>> from pymunk_dragon.drawing import still_png
    >>> still_png(March(Dragon(benches=16)), 60.0)[:6]
    b'\x89PNG\r\n'
    """
    # Imported here because imageio loads slowly and films do not use it.
    import imageio.v3 as iio

    picture: bytes = iio.imwrite("<bytes>", still(source, time, film), extension=".png")
    return picture


def still(source: Source | Sequence[Source], time: float, film: Film | None = None) -> NDArray[np.uint8]:
    """Draw the picture at one time.

    Parameters
    ----------
    source : Run or March, or a sequence of them
        Several sources are shown side by side.
    time : float
        Simulated time, s.
    film : Film, optional
        Size, camera, marks, texts and colours; the film's time window is ignored.

    Returns
    -------
    ndarray of uint8, shape (height, width, 3)
        Red, green and blue.

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
    times = np.array([time], dtype=float)
    clips = sampled(sources, times, film)
    picture = lay_out(clips, film).draw([next(clip.snapshots) for clip in clips])
    colours: NDArray[np.uint8] = film.palette.table[np.asarray(picture)]
    return colours


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
