"""Panels of a map: values over two axes, regions and points without values, and text in them."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._arrays import Array, Flags, Indices
from pymunk_dragon._language import text
from pymunk_dragon.drawing.figures.room import Room
from pymunk_dragon.drawing.figures.style import COLOURS, HALO, POINTS_PER_INCH, QUIET, halo
from pymunk_dragon.sweeps.figure.triangles import Pieces, pieces

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap, Normalize
    from matplotlib.text import Text

# Colours of small to large values: from a light tint of the films' amber to their blue, in equal steps of OKLab
# (B. Ottosson, 2020). Lightness decreases from step to step, so the order is visible also in greyscale and with colour
# blindness; the last one is light enough for lines in ink.
VALUES = ("#fde18b", "#d3d98a", "#aacd90", "#84be95", "#63ad99", "#419b9c", "#2a879d", "#2a729a", "#355b92")
# Points: smallest size of text, 14 pixels in a picture displayed 800 pixels wide.
SMALL = 10.5
# Share of the scale of colours above which the background's colour has more contrast to them than ink.
DARK = 0.7
# Style of text that is put where there is room.
CENTRED: dict[str, Any] = {"size": SMALL, "ha": "center", "va": "center", "zorder": 4}
# Points: width of a line at a jump.
JUMP = 0.9
# Points: shortest contour line; shorter ones, as in narrow regions, would be clutter.
MIN_CONTOUR = 72.0
# Largest number of classes that are named in a panel.
MAX_NAMES = 40
# Square points: size of the marker of a single point.
MARKER = 30.0
# Largest number of points that are shown in a field.
MAX_DOTS = 400


@dataclass(frozen=True, kw_only=True)
class Tint:
    """Flat fill of a region without values: text, colours of the fill and of its hatching, marker of single points."""

    text: str
    colour: str
    hatch: str = ""
    line: str = QUIET
    marker: str

    @property
    def region(self) -> dict[str, Any]:
        """Style of a region."""
        return {"fc": self.colour, "ec": self.line, "hatch": self.hatch, "lw": 0.0}

    @property
    def point(self) -> dict[str, Any]:
        """Style of a single point."""
        return {"marker": self.marker, "facecolors": self.colour, "edgecolors": QUIET}


# Regions without values, by status; distinguishable in greyscale by lightness and hatching.
TINTS = {
    "clear": Tint(text="clear", colour="#f1ebdc", marker="o"),
    "overlapping": Tint(text="overlapping", colour="#e9c9c2", marker="s"),
    "unreachable": Tint(
        text="unreachable: bends become too tight", colour="#dcdfe2", hatch="---", line="#c9cdd2", marker="D"
    ),
    "failed": Tint(text="failed", colour=COLOURS.background, hatch="////", line="#d5cbb6", marker="X"),
    "": Tint(text="no value", colour=COLOURS.background, hatch="xxxx", line="#e2ddd0", marker="v"),
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Samples:
    """What is drawn at P points.

    Attributes
    ----------
    values : ndarray, shape (P,)
        Values; nan at points that have a tint.
    classes : ndarray of int, shape (P,)
        Numbers of the points' classes. Values are continuous within a class, and may jump between classes.
    tints : sequence of str or None
        For each class, the key of its tint; None if its points have values.
    names : sequence of str
        For each class, the text that identifies it.
    """

    values: Array
    classes: Indices
    tints: Sequence[str | None]
    names: Sequence[str]

    @classmethod
    def of(cls, values: Array, labels: Sequence[Any], statuses: Sequence[str | None]) -> Samples:
        """Samples of the values, labels and statuses of P points. A point has a tint if it has no value."""
        drawn = np.array(values, dtype=float)
        numbers: dict[Hashable, int] = {}
        classes = []
        tints: list[str | None] = []
        names = []
        for i, (label, status) in enumerate(zip(labels, statuses, strict=True)):
            tint = None
            if status == "failed" or not np.isfinite(drawn[i]):
                drawn[i] = np.nan
                tint = status if status is not None and status in TINTS else ""
            key: Hashable = (label,) if tint is None else tint
            if key not in numbers:
                numbers[key] = len(numbers)
                tints.append(tint)
                names.append(_benches(label) if tint is None else text(TINTS[tint].text))
            classes.append(numbers[key])
        return cls(values=drawn, classes=np.array(classes, dtype=np.intp), tints=tints, names=names)

    def at(self, rows: Indices) -> Samples:
        """Samples at some of the points."""
        return Samples(values=self.values[rows], classes=self.classes[rows], tints=self.tints, names=self.names)

    @property
    def coloured(self) -> Flags:
        """Which points have values."""
        return np.isfinite(self.values)


def _benches(label: Any) -> str:
    """The whole numbers of a label, which are benches."""
    parts = label if isinstance(label, tuple) else (label,)
    return text(" and ").join(
        str(part) for part in parts if isinstance(part, int | np.integer) and not isinstance(part, bool)
    )


@cache
def colour_map() -> Colormap:
    """Colours of values."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("sweep", list(VALUES))


def draw_field(axes: Axes, points: Array, samples: Samples, norm: Normalize) -> Pieces | None:
    """Draw values over two axes, (P, 2), between the axes' limits; single points and None if they are on a line."""
    from matplotlib.collections import TriMesh
    from matplotlib.tri import Triangulation

    low, high = np.array([axes.get_xlim(), axes.get_ylim()]).T
    found = pieces((points - low) / (high - low), samples.classes, samples.values)
    if found is None:
        draw_points(axes, points, samples, norm)
        return None
    found = found.moved(low, high - low)
    classes = samples.classes[found.owners]
    for number in np.unique(classes).tolist():
        if (tint := samples.tints[number]) is not None:
            _fill(axes, found.points[found.triangles[classes == number]], TINTS[tint], tint)
    inside = found.triangles[samples.coloured[found.owners]]
    if len(inside):
        mesh = TriMesh(Triangulation(found.points[:, 0], found.points[:, 1], inside))
        mesh.set(array=found.values, norm=norm, cmap=colour_map(), rasterized=True, gid="values", zorder=1)
        axes.add_collection(mesh, autolim=False)
    return found


def draw_jumps(axes: Axes, jumps: Array, width: float = JUMP) -> None:
    """Draw the lines between classes, (S, 2, 2)."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    if len(jumps):
        path = Path(jumps.reshape(-1, 2), [Path.MOVETO, Path.LINETO] * len(jumps))
        axes.add_artist(PathPatch(path, fill=False, ec=COLOURS.ink, lw=width, capstyle="round", gid="jumps", zorder=2))


def draw_points(axes: Axes, points: Array, samples: Samples, norm: Normalize, size: float = MARKER) -> None:
    """Draw single points (P, 2): values by colour, tints by marker; `size` in square points."""
    # Small markers have thin outlines.
    width = (size / MARKER) ** 0.5
    for number in np.unique(samples.classes[~samples.coloured]).tolist():
        tint = samples.tints[number]
        assert tint is not None  # Only coloured classes have none.
        x, y = points[samples.classes == number].T
        style = TINTS[tint].point | {"linewidths": 0.7 * width, "zorder": 2, "clip_on": False}
        axes.scatter(x, y, size, **style, gid=tint or "none")
    x, y = points[samples.coloured].T
    style = {"cmap": colour_map(), "norm": norm, "linewidths": 0.4 * width, "edgecolors": COLOURS.ink}
    axes.scatter(x, y, size, samples.values[samples.coloured], **style, zorder=2.5, clip_on=False, gid="values")


def draw_contours(axes: Axes, found: Pieces, samples: Samples, levels: Array, room: Room) -> dict[float, Array]:
    """Draw contour lines within the classes; return the levels that have lines, with all points (K, 2) of these."""
    from matplotlib.collections import LineCollection
    from matplotlib.tri import Triangulation

    inside = found.triangles[samples.coloured[found.owners]]
    values = np.nan_to_num(found.values)
    shown = values[inside]
    levels = levels[(levels > shown.min(initial=np.inf)) & (levels < shown.max(initial=-np.inf))]
    if not len(levels):
        return {}
    contours = axes.tricontour(Triangulation(found.points[:, 0], found.points[:, 1], inside), values, levels)
    shortest = MIN_CONTOUR * axes.figure.dpi / POINTS_PER_INCH
    lines = [[line for line in of_level if _length(axes, line) >= shortest] for of_level in contours.allsegs]
    contours.remove()
    style: dict[str, Any] = {"colors": COLOURS.background, "linewidths": 0.9, "capstyle": "round", "zorder": 1.5}
    axes.add_collection(
        LineCollection([line for each in lines for line in each], **style, gid="contours"), autolim=False
    )
    for line in (line for each in lines for line in each):
        room.take_path(line, crossable=True)
    return {level: np.concatenate(each) for level, each in zip(levels.tolist(), lines, strict=True) if each}


def label_contours(axes: Axes, contours: dict[float, Array], norm: Normalize, room: Room) -> None:
    """Write the value of each contour line once, where there is room."""
    from matplotlib.patheffects import withStroke

    for level, points in contours.items():
        note = axes.text(0, 0, f"{level:g}", **CENTRED, color=_legible(norm, level), gid="contour-label")
        # A border in the colour of the level interrupts the line.
        note.set_path_effects([withStroke(linewidth=HALO, foreground=colour_map()(norm(level)))])
        room.put(note, points, crossing=True)


def _length(axes: Axes, line: Array) -> float:
    """Length of a line in pixels."""
    return float(np.hypot(*np.diff(axes.transData.transform(line), axis=0).T).sum())


def _legible(norm: Normalize, value: float) -> str:
    """Colour of text that is legible on the colour of a value."""
    return COLOURS.ink if norm(value) < DARK else COLOURS.background


def draw_names(axes: Axes, points: Array, found: Pieces, samples: Samples, norm: Normalize, room: Room) -> set[int]:
    """Name the classes, tints and large ones first, where there is room; return the classes that are named."""
    classes = samples.classes[found.owners]
    size = np.bincount(classes, weights=found.areas, minlength=len(samples.names))
    order = sorted(np.flatnonzero(size).tolist(), key=lambda k: (samples.tints[k] is None, -size[k]))
    named = set()
    for number in order[:MAX_NAMES]:
        # Points are in the middle of narrow regions of a grid, which the triangles' middles are not.
        inside = np.concatenate([found.middles[classes == number], points[samples.classes == number]])
        shade = COLOURS.ink
        if samples.tints[number] is None:
            shade = _legible(norm, float(samples.values[samples.classes == number].mean()))
        if put_name(axes, samples, number, room, partial(_anywhere, inside), shade, _direction(axes, inside)):
            named.add(number)
    return named


def _direction(axes: Axes, points: Array) -> float:
    """Direction in which a region extends farthest on the page, degrees from -90 to 90."""
    pixels = axes.transData.transform(points)
    _, axes_of_region = np.linalg.eigh(np.cov(pixels.T)) if len(pixels) > 1 else (None, np.eye(2))
    x, y = axes_of_region[:, -1]
    return float(np.degrees(np.arctan2(y, x) if x > 0 else np.arctan2(-y, -x)))


def _anywhere(positions: Array, _: Text) -> Array:
    """Positions that do not depend on the text."""
    return positions


def put_name(
    axes: Axes,
    samples: Samples,
    number: int,
    room: Room,
    positions: Callable[[Text], Array],
    colour: str = COLOURS.ink,
    direction: float = 90.0,
) -> bool:
    """Write the name of a class if there is room: in one line, in two, or in a direction; return whether there is."""
    name, tint = samples.names[number], samples.tints[number]
    if not name:
        return False
    for written, rotation in ((name, 0), (_two_lines(name), 0), (name, direction)):
        note = axes.text(0, 0, written, rotation=rotation, **CENTRED, color=colour, gid=f"name-{number}")
        if tint is not None:
            note.set_bbox({"facecolor": TINTS[tint].colour, "edgecolor": "none", "pad": 1.5})
        if room.put(note, positions(note)):
            return True
    return False


def _two_lines(name: str) -> str:
    """The name with a line break instead of the space that is nearest to its middle."""
    spaces = [i for i, character in enumerate(name) if character == " "]
    middle = min(spaces, key=lambda i: abs(2 * i + 1 - len(name)), default=len(name))
    return name[:middle] + "\n" + name[middle + 1 :]


def draw_reference(axes: Axes, x: float, y: float, size: float = 7.0) -> None:
    """Mark the reference dragon by a ringed dot."""
    axes.plot(x, y, **reference_style(size), clip_on=False, zorder=5, gid="reference")


def reference_style(size: float) -> dict[str, Any]:
    """Style of the dot of the reference dragon."""
    return {"marker": "o", "ls": "", "ms": size, "color": COLOURS.contact, "mec": COLOURS.background, "mew": 1.5}


def put_reference(axes: Axes, x: float, y: float, room: Room) -> None:
    """Write the word for the reference dragon beside its dot."""
    note = axes.text(0, 0, text("reference"), **CENTRED, color=COLOURS.contact, path_effects=halo())
    box = note.get_window_extent()
    across, up = axes.transData.transform((x, y))
    aside, above = box.width / 2 + box.height, 1.2 * box.height
    room.take(np.full((1, 2, 2), (x, y)))
    positions = [(across + i * aside, up + k * above) for k in (0, 1, -1) for i in (1, -1, 0) if (i, k) != (0, 0)]
    # Above and beside the panel are other names.
    inside = [at for at in positions if axes.bbox.padded(-box.height / 2).contains(*at)]
    room.put(note, axes.transData.inverted().transform(inside or positions), needed=True)


def _fill(axes: Axes, triangles: Array, tint: Tint, name: str) -> None:
    """Fill triangles (M, 3, 2) as one region, without seams."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    closed = np.concatenate([triangles, triangles[:, :1]], axis=1)
    codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY] * len(triangles)
    region = PathPatch(Path(closed.reshape(-1, 2), codes), **tint.region, zorder=0.5, rasterized=True)
    axes.add_artist(region).set_gid(name or "none")
