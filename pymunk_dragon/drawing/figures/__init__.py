"""Named figures: those of the paper, and others.

`pymunk-dragon figure NAME` draws a figure as PNG, or as SVG or PDF if it has axes (`pip install
'pymunk-dragon[figures]'`), and `pymunk-dragon figure` lists all.

Sixteen benches at the start, as they close a loop, and at their first contact (figures 3 to 5 of
the paper); the spiral (figure 2), and the trajectories and velocities of seven handles (figures 7
and 8); speeds along the dragon; and forces in the joints of a run. The grid (figure
6) and the gap before the head are in `pymunk_dragon.collision`; the drift of a run and the order of
the engine are in `pymunk_dragon.physics`.

![Sixteen benches at their start](renders/figures/outer-loop.png)
![Sixteen benches that close a loop](renders/figures/inward.png)
![Sixteen benches at their first contact](renders/figures/collision.png)
![The spiral and the handles of the reference scenario](renders/figures/spiral.png)
![The trajectories of seven handles](renders/figures/trajectories.png)
![The velocities of seven handles](renders/figures/velocities.png)
![Speeds along the dragon](renders/figures/speeds.png)
![Forces in the joints of a run, and the exact ones](renders/figures/forces.png)
"""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from PIL import Image

from pymunk_dragon._checks import instance, word
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon.drawing import STILL_ENDINGS, render
from pymunk_dragon.drawing.figures.charts import FIGURES, NamedFigure
from pymunk_dragon.drawing.figures.style import FigureSource, styled
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["FIGURES", "figure", "styled_figure", "write_figure", "write_styled"]

# File endings of figures with axes, and metadata that leave out the date, for the same bytes each
# time.
_METADATA: dict[str, dict[str, Any]] = {
    ".png": {},
    ".svg": {"Date": None},
    ".pdf": {"CreationDate": None},
}
_FIGURE_ENDINGS = tuple(_METADATA)
# s: a march that ends earlier has no time to draw; axes of a shorter interval have equal ends.
_SHORTEST_MARCH = 1e-6


def figure(name: str, source: Run | March | None = None) -> Figure:
    """Draw a figure with axes as a matplotlib figure, which notebooks display.

    Parameters
    ----------
    name : str
        One of `FIGURES`. Pictures of the dragon are excluded; `write_figure` writes them.
    source : Run or March, optional
        March to draw, or run whose march is drawn; by default the paper's march. "drift" and
        "forces" require a run.

    Returns
    -------
    matplotlib.figure.Figure
        Figure in SI units.

    Raises
    ------
    ParameterError
        If the figure does not exist, or the source has no data for it.
    MissingExtraError
        If matplotlib is not installed.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March
    >>> from pymunk_dragon.drawing.figures import figure
    >>> figure("speeds", March(Dragon(benches=16), turns=8)).axes[0].get_xlabel()
    'handle, from the head to the tail'
    """
    named = FIGURES[word("figure", name, FIGURES)]
    if named.still:
        raise ParameterError("figure", name, "one with axes, or written by `write_figure`")
    return styled_figure(lambda: named.draw(_figure_source(named, source)))


def styled_figure(draw: Callable[[], Figure]) -> Figure:
    """Figure that `draw` draws, with the fonts and colours of all figures.

    It is for `figure` and for packages above.
    """
    with styled():
        return _laid_out(draw())


def write_figure(name: str, path: str | Path, source: Run | March | None = None) -> None:
    """Write one of `FIGURES` as PNG, or as SVG or PDF if it has axes.

    `name` and `source` are those of `figure`. If writing is interrupted, an old file is kept and no
    incomplete file is left; if it fails, an `OutputError` is raised.

    Examples
    --------
    >>> from pymunk_dragon.drawing.figures import write_figure
    >>> write_figure("spiral", "spiral.svg")
    """
    named = FIGURES[word("figure", name, FIGURES)]
    if named.still:
        destination = check_destination(path, STILL_ENDINGS)
        run, film = named.draw(_figure_source(named, source))
        render(run, destination, film)
    else:
        write_styled(lambda: named.draw(_figure_source(named, source)), path)


def write_styled(draw: Callable[[], Figure], path: str | Path) -> None:
    """Write the figure that `draw` draws as PNG, SVG or PDF.

    It is for `write_figure` and for packages above.
    """
    destination = check_destination(path, _FIGURE_ENDINGS)
    ending = destination.suffix.lower()
    content = io.BytesIO()
    with styled():
        drawn = _laid_out(draw())
        drawn.savefig(content, format=ending[1:], metadata=_METADATA[ending])
    # With 256 colours no pixel changes by more than two levels, and the file is a third as large.
    # Gradients, which are rasterized in the other formats, would have visible bands.
    if ending == ".png" and not any(part.get_rasterized() for part in drawn.findobj()):
        with Image.open(content) as picture:
            colours = picture.convert("RGB")
        few = colours.quantize(256, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
        content = io.BytesIO()
        few.save(content, format="PNG", optimize=True)
    with written_in_place(destination) as draft:
        draft.write_bytes(content.getbuffer())


def svg_of(drawn: Figure) -> bytes:
    """A figure as SVG, the same bytes each time; for packages above."""
    content = io.BytesIO()
    with styled():
        drawn.savefig(content, format="svg", metadata=_METADATA[".svg"])
    return content.getvalue()


def _laid_out(drawn: Figure) -> Figure:
    """Fix the layout of a figure, and its ticks.

    Ticks have the settings of the time at which they are created.
    """
    drawn.draw_without_rendering()
    drawn.set_layout_engine("none")
    for axes in drawn.axes:
        # matplotlib's solver adds in the order of addresses: its last digits differ.
        bounds = axes.get_position(original=True).bounds
        axes.set_position(np.round(bounds, 6).tolist())
    return drawn


def _figure_source(named: NamedFigure, source: Run | March | None) -> FigureSource:
    """What is drawn of a source: a march to the end of its curve, or for the times of a run."""
    if isinstance(source, Run):
        if np.isfinite(source.march.end):
            return FigureSource(source.march, run=source)
        return FigureSource(source.march, *source.interval, run=source)
    march = March(Dragon(benches=named.benches)) if source is None else source
    instance("source", march, March, "a run or a march")
    if not np.isfinite(march.end):
        bound = "a run, which defines the time interval"
        raise ParameterError("march", "one on a curve without end", bound)
    if march.end < _SHORTEST_MARCH:
        bound = f"one of at least {_SHORTEST_MARCH:g} s"
        raise ParameterError("march", f"one of {march.end:g} s", bound)
    return FigureSource(march)
