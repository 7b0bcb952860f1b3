"""Named figures: those of the paper, and others.

`pymunk-dragon figure NAME` draws a figure as PNG, SVG or PDF (`pip install 'pymunk-dragon[figures]'`); without a name
it lists all figures.

```console
$ pymunk-dragon figure
$ pymunk-dragon figure gap -o gap.svg
$ pymunk-dragon figure spiral -o spiral.png
```

Sixteen benches are enough for a first contact: at the start, as they close a loop, and as they touch (figures 3 to 5
of the paper).

![Sixteen benches on the outer loop](renders/figures/outer-loop.png)

![Sixteen benches that close a loop](renders/figures/inward.png)

![Sixteen benches at their first contact](renders/figures/collision.png)

The spiral (figure 2), and the trajectories and the velocities of seven handles (figures 7 and 8):

![The spiral and the handles of the reference scenario](renders/figures/spiral.png)

![The trajectories of seven handles](renders/figures/trajectories.png)

![The velocities of seven handles](renders/figures/velocities.png)

The grid (figure 6) and the gap before the head are in `pymunk_dragon.collision`, the drift of a run of the engine in
`pymunk_dragon.physics`. Two more show the speeds along the dragon, and the impulses in the joints of a run:

![Speeds along the dragon](renders/figures/speeds.png)

![Impulses in the joints of a run of the engine](renders/figures/impulses.png)
"""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PIL import Image

from pymunk_dragon._checks import word
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon.drawing.figures.charts import drift, gap, impulses, speeds
from pymunk_dragon.drawing.figures.grid_partition import grid
from pymunk_dragon.drawing.figures.plan_views import (
    Still,
    collision,
    inward,
    outer_loop,
    spiral,
    trajectories,
    velocities,
)
from pymunk_dragon.drawing.figures.style import styled
from pymunk_dragon.drawing.figures.times import TimeInterval, model, time_interval
from pymunk_dragon.drawing.film.stills import STILL_ENDINGS, write_still
from pymunk_dragon.drawing.snapshots import Source
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["FIGURES", "FIGURE_ENDINGS", "Kind", "figure", "styled_figure", "write_figure", "write_styled"]

# File endings of figures with axes.
FIGURE_ENDINGS = (".png", ".svg", ".pdf")
# Metadata that leave out the date, for the same bytes each time.
WITHOUT_DATE: Mapping[str, dict[str, Any]] = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
# Colours of a PNG: with 256 no pixel changes by more than two levels, and the file is a third as large.
PNG_COLOURS = 256


@dataclass(frozen=True, kw_only=True)
class Kind:
    """Kind of figure; exactly one of `of_march`, `of_run` and `still` is given.

    Attributes
    ----------
    shows : str
        Description in one line.
    of_march, of_run : callable or None
        Function that draws a figure with axes from a march and a time interval, or from a run of the engine.
    still : callable or None
        Function that returns the run and the film parameters of a picture of the dragon.
    default : callable
        Function that returns the march to draw if no source is given.

    Examples
    --------
    >>> from pymunk_dragon.drawing.figures import FIGURES
    >>> FIGURES["drift"].needs_run, FIGURES["collision"].endings
    (True, ('.png', '.pdf'))
    """

    shows: str
    of_march: Callable[[March, TimeInterval], Figure] | None = None
    of_run: Callable[[Run], Figure] | None = None
    still: Callable[[March, TimeInterval], Still] | None = None
    default: Callable[[], March] = March

    @property
    def needs_run(self) -> bool:
        """Whether the figure requires a run of the engine."""
        return self.of_run is not None

    @property
    def endings(self) -> tuple[str, ...]:
        """File endings of the formats in which the figure can be written."""
        return FIGURE_ENDINGS if self.still is None else STILL_ENDINGS


# All figures by name.
FIGURES: Mapping[str, Kind] = {
    "spiral": Kind(shows="the spiral that handle 0 walks (the paper's figure 2)", of_march=spiral),
    "outer-loop": Kind(shows="16 benches on the outer loop (figure 3)", still=outer_loop, default=model),
    "inward": Kind(shows="16 benches as they close a full loop (figure 4)", still=inward, default=model),
    "collision": Kind(shows="16 benches at their first contact (figure 5)", still=collision, default=model),
    "grid": Kind(shows="which benches are filed in which cells (figure 6)", of_march=grid, default=model),
    "trajectories": Kind(shows="the trajectories of seven handles (figure 7)", of_march=trajectories),
    "velocities": Kind(shows="the velocities of seven handles (figure 8)", of_march=velocities),
    "gap": Kind(shows="how near the head comes to the benches that it passes", of_march=gap),
    "speeds": Kind(shows="speed along the dragon at several times", of_march=speeds),
    "drift": Kind(shows="how far the engine is from the exact model", of_run=drift),
    "impulses": Kind(shows="what the engine's joints carry along the dragon", of_run=impulses),
}


def figure(name: str, source: Source | None = None) -> Figure:
    """Draw a figure with axes as a matplotlib figure, which notebooks display.

    Parameters
    ----------
    name : str
        One of `FIGURES`. Pictures of the dragon are excluded; `write_figure` writes them.
    source : Run or March, optional
        March to draw, or run whose march is drawn; by default the paper's march. The figures "drift" and "impulses"
        require a run of the engine.

    Returns
    -------
    matplotlib.figure.Figure
        Figure in SI units.

    Raises
    ------
    ParameterError
        If the figure does not exist, requires another source, or the source has no data for it.
    UnreachableError
        If the march's dragon does not fit on its curve at the start.
    MissingExtraError
        If matplotlib is not installed.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March
    >>> from pymunk_dragon.drawing.figures import figure
    >>> figure("speeds", March(Dragon(benches=16), turns=8)).axes[0].get_xlabel()
    'handle, from the head to the tail'
    """
    kind = _kind(name)
    if kind.still is not None:
        raise ParameterError("figure", name, "one with axes, or written by `write_figure`")
    return styled_figure(lambda: _draw(name, kind, source))


def styled_figure(draw: Callable[[], Figure]) -> Figure:
    """Figure that `draw` draws, with the fonts and colours of all figures; notebooks display it.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> styled_figure(Figure).axes
    []
    """
    with styled():
        drawn = draw()
        # matplotlib creates some ticks during drawing, with the settings of that time.
        drawn.draw_without_rendering()
    return drawn


def write_figure(name: str, path: str | Path, source: Source | None = None) -> None:
    """Write one of `FIGURES` as PNG or PDF, or as SVG if it has axes.

    Parameters
    ----------
    name, source
        As in `figure`.
    path : path
        File to write. If writing is interrupted, an old file is kept and no incomplete file is left.

    Raises
    ------
    ParameterError
        As in `figure`, and if the file cannot be created.
    UnreachableError, MissingExtraError
        As in `figure`.
    OutputError
        If writing fails.

    Examples
    --------
    >>> from pymunk_dragon.drawing.figures import write_figure
    >>> write_figure("spiral", "spiral.svg")
    """
    kind = _kind(name)
    destination = check_destination(path, kind.endings)
    if kind.still is not None:
        run, film = kind.still(*_march_and_interval(kind, source))
        write_still(run, float(run.times[0]), destination, film)
        return
    write_styled(lambda: _draw(name, kind, source), destination)


def write_styled(draw: Callable[[], Figure], path: str | Path) -> None:
    """Write the figure that `draw` draws, with the fonts and colours of all figures, as PNG, SVG or PDF.

    Raises
    ------
    ParameterError
        If the file cannot be created.
    MissingExtraError
        If matplotlib is not installed.
    OutputError
        If writing fails.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> write_styled(Figure, "empty.svg")
    """
    destination = check_destination(path, FIGURE_ENDINGS)
    with styled():
        drawn = draw()
        with written_in_place(destination) as draft:
            ending = destination.suffix.lower()
            if ending in WITHOUT_DATE:
                drawn.savefig(draft, format=ending[1:], metadata=WITHOUT_DATE[ending])
            else:
                _write_png(drawn, draft)


def _kind(name: str) -> Kind:
    return FIGURES[word("figure", name, FIGURES)]


def _march_and_interval(kind: Kind, source: Source | None) -> tuple[March, TimeInterval]:
    """Return the march to draw, and its time interval."""
    if source is None:
        source = kind.default()
    if not isinstance(source, Run | March):
        raise ParameterError("source", source, "a run or a march")
    return source.march if isinstance(source, Run) else source, time_interval(source)


def _draw(name: str, kind: Kind, source: Source | None) -> Figure:
    if kind.of_run is not None:
        if not isinstance(source, Run):
            raise ParameterError("run", source, f"a run of the engine, which the figure {name} is made from")
        return kind.of_run(source)
    assert kind.of_march is not None  # A figure is of a run or of a march.
    return kind.of_march(*_march_and_interval(kind, source))


def _write_png(drawn: Figure, draft: Path) -> None:
    buffer = io.BytesIO()
    drawn.savefig(buffer, format="png")
    with Image.open(buffer) as picture:
        flat = picture.convert("RGB")
    if any(part.get_rasterized() for part in drawn.findobj()):
        # Gradients, which are rasterized in the other formats, would have visible bands.
        flat.save(draft, format="PNG")
        return
    few = flat.quantize(PNG_COLOURS, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    few.save(draft, format="PNG", optimize=True)
