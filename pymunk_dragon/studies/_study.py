"""What all studies share: the base class of results, and the declaration of a study by its name."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pymunk_dragon._checks import instance, silent
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.model._display import TextResult, width
from pymunk_dragon.model.dragon import Dragon

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Called with the work that is done and the whole work, in the same unit.
Progress = Callable[[float, float], None]

# Names of the sizes of a dragon, which all studies take.
_DRAGON_SIZES = ("benches", "head_spacing", "body_spacing", "overhang", "width")
# Columns of a terminal that the labels of a text take.
_LABEL_COLUMNS = 11


def checked_dragon(dragon: Dragon | None) -> Dragon:
    """`dragon`, or the contest's."""
    return Dragon() if dragon is None else instance("dragon", dragon, Dragon, "a Dragon")


def labelled(label: str, lines: str) -> str:
    """Lines of a text beside a label."""
    padding = " " * (_LABEL_COLUMNS - width(label))
    return label + padding + lines.replace("\n", "\n" + " " * _LABEL_COLUMNS)


class Result(TextResult, ABC):
    """Base class of the studies' results: ``str`` is the text of the command and of notebooks."""

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """Values in SI units, as `study --json` prints them."""

    @abstractmethod
    def _lines(self) -> list[str]:
        """Paragraphs of the text, each of one line or more."""

    def _draw(self) -> Figure:
        """The figure, drawn with the settings of all figures."""
        raise DragonError(f"a {type(self).__name__} has no figure")

    def __str__(self) -> str:
        return "\n".join(self._lines())

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {str(self).splitlines()[0]}>"

    def plot(self) -> Figure:
        """The figure, which notebooks display; raises `MissingExtraError` without matplotlib."""
        from pymunk_dragon.drawing.figures import styled_figure

        return styled_figure(self._draw)

    def write_figure(self, path: str | Path) -> None:
        """Write the figure as PNG, SVG or PDF; raises `ParameterError` or `OutputError`."""
        from pymunk_dragon.drawing.figures import write_styled

        write_styled(self._draw, path)


@dataclass(frozen=True, kw_only=True)
class Study:
    """A study that can be run by name.

    Attributes
    ----------
    name : str
        Name of the study.
    summary : str
        One line on what the study computes.
    run : callable
        Function of a `Dragon`, of keyword-only parameters with defaults, and of `progress`. It
        returns a `Result`.
    flags : mapping
        Flags of the command line for the parameters that no scenario has, and what they
        are.
    formats : tuple of str
        Endings of the files that the result can be written to: .xlsx if it has a `march` and
        `times`.
    """

    name: str
    summary: str
    run: Callable[..., Any]
    flags: Mapping[str, str] = field(default_factory=dict)
    formats: tuple[str, ...] = (".json", ".png", ".svg", ".pdf")

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of all parameters, including the dragon's sizes."""
        _, *others = signature(self.run).parameters
        return *_DRAGON_SIZES, *(name for name in others if name != "progress")

    def answer(self, values: Mapping[str, Any], progress: Progress = silent) -> Any:
        """Result for values of `parameters` by name; `ParameterError` for a wrong name or value."""
        instance("values", values, Mapping, "a mapping of names and values")
        for name, value in values.items():
            if name not in self.parameters:
                known = f"left out: {self.name} takes " + ", ".join(self.parameters)
                raise ParameterError(name, value, known)

        rest = dict(values)
        sizes = {name: rest.pop(name) for name in _DRAGON_SIZES if name in rest}
        return self.run(Dragon(**sizes), **rest, progress=progress)
