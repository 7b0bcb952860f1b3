"""The figure of a sweep: a line over one axis, a map over two axes, and a matrix of maps over more.

A quantity such as the time of the first contact changes continuously with the axes only while the same benches touch.
So points with equal labels form a class: lines and colours are continuous within a class, and broken between classes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon.sweeps.figure.field import field_page
from pymunk_dragon.sweeps.figure.line import line_page
from pymunk_dragon.sweeps.figure.matrix import matrix_page
from pymunk_dragon.sweeps.figure.pages import Content
from pymunk_dragon.sweeps.figure.panels import Samples

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Map", "draw"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Map:
    """Values of a quantity at P points of A axes.

    Parameters
    ----------
    names : tuple of str
        Names of the axes.
    points : ndarray, shape (P, A)
        Coordinates of the points.
    column : str
        Name of the quantity.
    values : ndarray, shape (P,)
        Values; nan where there is none, as the time of the contact where no benches touch.
    labels : sequence of tuple or None
        For each point what cannot change continuously, as the benches that touch and the status; None for a point that
        failed.
    statuses : sequence of str or None
        For each point the status of its first contact, None for a quantity without status, or "failed".
    reference : mapping
        Values of the reference dragon by the names of axes, some of which may be absent.
    title, subtitle : str
        Text above the figure.
    """

    names: tuple[str, ...]
    points: Array
    column: str
    values: Array
    labels: Sequence[tuple[Any, ...] | None]
    statuses: Sequence[str | None]
    reference: Mapping[str, float]
    title: str
    subtitle: str


def draw(map: Map) -> Figure:
    """Draw the map with matplotlib's current settings, which `drawing.figures.style.styled` makes those of all figures.

    Points without a value have the tint of their status. Of several equal points the first is drawn.

    Examples
    --------
    >>> from pymunk_dragon.drawing.figures import styled_figure
    >>> pitches = np.array([[0.40], [0.45], [0.50]])
    >>> times, benches = np.array([np.nan, 215.3, 336.5]), [(0, 22), (0, 19), (0, 14)]
    >>> statuses = ["overlapping", "contact", "contact"]
    >>> data = {"points": pitches, "values": times, "labels": benches, "statuses": statuses, "reference": {}}
    >>> found = Map(names=("pitch",), column="contact_time", title="Three pitches", subtitle="", **data)
    >>> styled_figure(lambda: draw(found)).axes[0].get_xlabel()
    'pitch, m'
    """
    points = np.asarray(map.points, dtype=float)
    _, first = np.unique(points, axis=0, return_index=True)
    first = first[np.isfinite(points[first]).all(axis=1)]
    content = Content(
        names=map.names,
        column=map.column,
        points=points[first],
        samples=Samples.of(map.values, map.labels, map.statuses).at(first),
        reference=map.reference,
        title=map.title,
        subtitle=map.subtitle,
    )
    if len(map.names) == 1:
        return line_page(content)
    return field_page(content) if len(map.names) == 2 else matrix_page(content)
