"""The paper's figures, and some beyond it, by name."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from PIL import Image

from pymunk_dragon.checks import word
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.files import check_destination, written_in_place
from pymunk_dragon.march import March
from pymunk_dragon.render.figures.answers import answer
from pymunk_dragon.render.figures.cells import grid
from pymunk_dragon.render.figures.charts import gap, speeds
from pymunk_dragon.render.figures.engine import drift, impulses
from pymunk_dragon.render.figures.ground import spiral, trajectories, velocities
from pymunk_dragon.render.figures.stills import Still, collision, inward, outer_loop
from pymunk_dragon.render.figures.style import styled
from pymunk_dragon.render.figures.times import Stretch, model, stretch
from pymunk_dragon.render.moments import Source
from pymunk_dragon.render.output import STILL_ENDINGS, write_still
from pymunk_dragon.run import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["FIGURES", "FIGURE_ENDINGS", "Kind", "answer_figure", "figure", "write_answer", "write_figure"]

FIGURE_ENDINGS = (".png", ".svg")
# Colours of a PNG: with so many no pixel is more than two levels off, and the file is a third.
PNG_COLOURS = 256


@dataclass(frozen=True, kw_only=True)
class Kind:
    """A figure that can be asked for: one of the three ways to make it, and of what.

    Attributes
    ----------
    shows : str
        What it shows, in one line.
    of_march, of_run : callable or None
        What draws it with axes, from a march and when to look at it, or from a run of the engine.
    still : callable or None
        What tells the moment of a picture of the dragon.
    default : callable
        The march that is drawn where none is given.
    """

    shows: str
    of_march: Callable[[March, Stretch], Figure] | None = None
    of_run: Callable[[Run], Figure] | None = None
    still: Callable[[March, Stretch], Still] | None = None
    default: Callable[[], March] = March

    @property
    def needs_run(self) -> bool:
        """Whether it is made from a run of the engine, which has to be given."""
        return self.of_run is not None

    @property
    def endings(self) -> tuple[str, ...]:
        """Endings of the files in which it can be written."""
        return FIGURE_ENDINGS if self.still is None else STILL_ENDINGS


FIGURES: Mapping[str, Kind] = {
    "spiral": Kind(shows="the spiral that handle 0 walks (the paper's figure 2)", of_march=spiral),
    "outer-loop": Kind(shows="16 benches on the outer loop (figure 3)", still=outer_loop, default=model),
    "inward": Kind(shows="16 benches as they close a full loop (figure 4)", still=inward, default=model),
    "collision": Kind(shows="16 benches at their first contact (figure 5)", still=collision, default=model),
    "grid": Kind(shows="which benches are filed in which cells (figure 6)", of_march=grid, default=model),
    "trajectories": Kind(shows="the ways of seven handles (figure 7)", of_march=trajectories),
    "velocities": Kind(shows="the velocities of seven handles (figure 8)", of_march=velocities),
    "gap": Kind(shows="how near the head comes to the benches that it passes", of_march=gap),
    "speeds": Kind(shows="speed along the dragon at several times", of_march=speeds),
    "drift": Kind(shows="how far the engine is from the exact model", of_run=drift),
    "impulses": Kind(shows="what the engine's joints carry along the dragon", of_run=impulses),
}


def figure(name: str, source: Source | None = None) -> Figure:
    """One of the figures with axes, as matplotlib has it; a notebook shows it.

    Parameters
    ----------
    name : str
        One of `FIGURES`, but no picture of the dragon, which is only to be written.
    source : Run or March, optional
        What is drawn: a march, or the march of a run; by default the paper's. Drift and impulses are those of a run of
        the engine, which has to be given.

    Raises
    ------
    ParameterError
        If there is no such figure, it needs another source, or the source has nothing for it to show.
    UnreachableError
        If the march's dragon has no place on its curve at the start.
    MissingExtraError
        If matplotlib is not installed.
    """
    kind = _kind(name)
    if kind.still is not None:
        raise ParameterError("figure", name, "one with axes, or written by `write_figure`")
    return _finished(lambda: _drawn(name, kind, source))


def answer_figure(found: object) -> Figure:
    """The picture of a study's answer, as matplotlib has it; a notebook shows it.

    Raises
    ------
    ParameterError
        If `found` is no answer of a study.
    MissingExtraError
        If matplotlib is not installed.
    """
    return _finished(lambda: answer(found))


def write_figure(name: str, path: str | Path, source: Source | None = None) -> None:
    """Write one of `FIGURES`, as PNG, or as SVG where it has axes.

    Parameters
    ----------
    name, source
        As in `figure`.
    path : path
        File to write. An interrupted figure leaves the old file or none.

    Raises
    ------
    ParameterError
        As in `figure`, and if the file cannot be made.
    UnreachableError, MissingExtraError
        As in `figure`.
    OutputError
        If writing fails.
    """
    kind = _kind(name)
    destination = check_destination(path, kind.endings)
    if kind.still is not None:
        run, film = kind.still(*_marching(kind, source))
        write_still(run, float(run.times[0]), destination, film)
        return
    _write(lambda: _drawn(name, kind, source), destination)


def write_answer(found: object, path: str | Path) -> None:
    """Write the picture of a study's answer as PNG or SVG.

    Raises
    ------
    ParameterError
        If `found` is no answer of a study, or the file cannot be made.
    MissingExtraError
        If matplotlib is not installed.
    OutputError
        If writing fails.
    """
    _write(lambda: answer(found), check_destination(path, FIGURE_ENDINGS))


def _finished(draw: Callable[[], Figure]) -> Figure:
    with styled():
        drawn = draw()
        # Some ticks are made only when they are drawn, and then in the style of that moment.
        drawn.draw_without_rendering()
    return drawn


def _write(draw: Callable[[], Figure], destination: Path) -> None:
    with styled():
        drawn = draw()
        with written_in_place(destination) as draft:
            if destination.suffix.lower() == ".svg":
                drawn.savefig(draft, format="svg", metadata={"Date": None})
            else:
                _write_png(drawn, draft)


def _kind(name: str) -> Kind:
    return FIGURES[word("figure", name, FIGURES)]


def _marching(kind: Kind, source: Source | None) -> tuple[March, Stretch]:
    """The march that is drawn, and when to look at it."""
    if source is None:
        source = kind.default()
    if not isinstance(source, Run | March):
        raise ParameterError("source", source, "a run or a march")
    return source.march if isinstance(source, Run) else source, stretch(source)


def _drawn(name: str, kind: Kind, source: Source | None) -> Figure:
    if kind.of_run is not None:
        if not isinstance(source, Run):
            raise ParameterError("run", source, f"a run of the engine, which the figure {name} is made from")
        return kind.of_run(source)
    assert kind.of_march is not None
    return kind.of_march(*_marching(kind, source))


def _write_png(drawn: Figure, draft: Path) -> None:
    buffer = io.BytesIO()
    drawn.savefig(buffer, format="png")
    with Image.open(buffer) as picture:
        flat = picture.convert("RGB")
    few = flat.quantize(PNG_COLOURS, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    few.save(draft, format="PNG", optimize=True)
