"""The figure of a sweep: jumps are where labels change, colours are true within them, and any data can be drawn."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from collections.abc import Callable
from itertools import combinations, product
from pathlib import Path
from typing import Any

import hypothesis
import hypothesis.strategies as st
import matplotlib.text
import numpy as np
import pytest
from conftest import examples
from PIL import Image

from pymunk_dragon.drawing import Palette
from pymunk_dragon.drawing.figures import styled_figure, write_styled
from pymunk_dragon.sweeps.figure import Map, draw
from pymunk_dragon.sweeps.figure.pages import words
from pymunk_dragon.sweeps.figure.panels import TINTS, VALUES, colour_map
from pymunk_dragon.sweeps.figure.triangles import pieces

NAMES = ("pitch", "width", "turns", "overhang", "benches")
REFERENCE = {"pitch": 0.55, "width": 0.3}


def grid(*counts: int) -> np.ndarray:
    """Points of a grid on the unit square or cube, (P, A)."""
    axes = np.meshgrid(*(np.linspace(0, 1, count) for count in counts), indexing="ij")
    return np.stack(axes, axis=-1).reshape(-1, len(counts))


def samples(count: int, axes: int) -> np.ndarray:
    return np.random.default_rng(count).random((count, axes))


def refined(levels: int, is_left: Callable[[float, float], bool]) -> np.ndarray:
    """Corners of the cells of a quadtree that is divided where its corners differ."""
    cells, found = [(i / 4, j / 4) for i in range(4) for j in range(4)], set()
    for level in range(levels + 1):
        side, divided = 0.25 / 2**level, []
        for x, y in cells:
            corners = [(x + i * side, y + j * side) for i in (0, 1) for j in (0, 1)]
            found.update(corners)
            if len({is_left(*corner) for corner in corners}) > 1:
                divided += [(x + i * side / 2, y + j * side / 2) for i in (0, 1) for j in (0, 1)]
        cells = divided
    return np.array(sorted(found))


def sweep(points: Any, values: Any, labels: Any = None, statuses: Any = None, **changed: Any) -> Map:
    points = np.asarray(points, dtype=float)
    count = len(points)
    settings: dict[str, Any] = {
        "names": NAMES[: points.shape[1]],
        "points": points,
        "column": "contact_time",
        "values": np.broadcast_to(np.asarray(values, dtype=float), (count,)),
        "labels": [(0, 1, "contact")] * count if labels is None else labels,
        "statuses": ["contact"] * count if statuses is None else statuses,
        "reference": REFERENCE,
        "title": "A sweep",
        "subtitle": "of numbers",
    }
    return Map(**settings | changed)


def two_sides(points: np.ndarray, slope: float = 0.4, **changed: Any) -> Map:
    """A map with one jump, from 0 to 1, at the straight line x = 0.31 + slope * y."""
    left = points[:, 0] < 0.31 + slope * points[:, 1]
    labels = [(0, 8, "contact") if side else (0, 11, "contact") for side in left]
    return sweep(points, np.where(left, 0.0, 1.0), **{"labels": labels} | changed)


def five_statuses(points: np.ndarray) -> Map:
    """A map with values on the left, and all statuses without value in strips on the right."""
    kinds = ["contact", "clear", "overlapping", "unreachable", "failed", None]
    statuses = [kinds[min(int(6 * x), 5)] for x in points[:, 0]]
    values = [y if status == "contact" else np.nan for y, status in zip(points[:, -1], statuses, strict=True)]
    labels = [None if status == "failed" else (0, 1, status) for status in statuses]
    return sweep(points, values, labels, statuses)


def drawn(data: Map) -> Any:
    return styled_figure(lambda: draw(data))


def artists(drawing: Any, gid: str) -> list[Any]:
    return list(drawing.findobj(lambda part: part.get_gid() == gid))


def texts(drawing: Any) -> list[str]:
    return [text.get_text() for text in drawing.findobj(matplotlib.text.Text) if text.get_text()]


def legend_texts(drawing: Any) -> list[str]:
    return [text.get_text() for legend in drawing.legends for text in legend.get_texts()]


def jumps(drawing: Any) -> np.ndarray:
    [lines] = artists(drawing, "jumps")
    return np.asarray(lines.get_path().vertices).reshape(-1, 2, 2)


# --- Two axes: jumps.


@pytest.mark.parametrize("slope", [0.0, 0.4, 1.0])
@pytest.mark.parametrize(("points", "cell"), [(grid(21, 21), 1 / 20), (grid(41, 11), 1 / 10)])
def test_a_jump_on_a_grid_is_drawn_within_half_a_cell(points: np.ndarray, cell: float, slope: float) -> None:
    lines = jumps(drawn(two_sides(points, slope)))
    x, y = lines.reshape(-1, 2).T
    # Half a cell aside, and for a sloping line also half a cell up.
    assert np.abs(x - 0.31 - slope * y).max() <= (0.5 + 0.5 * slope) * cell + 1e-9
    assert (y.min(), y.max()) == pytest.approx((0.0, min(1.0, 0.69 / slope if slope else 1.0)), abs=cell)


def test_a_jump_is_drawn_where_cells_have_been_divided() -> None:
    points = refined(4, lambda x, y: x < 0.31 + 0.4 * y)
    x, y = jumps(drawn(two_sides(points))).reshape(-1, 2).T
    assert np.abs(x - 0.31 - 0.4 * y).max() < 0.7 / 64 + 1e-9
    assert (y.min(), y.max()) == (0.0, 1.0)


def test_a_jump_between_samples_separates_them() -> None:
    data = two_sides(samples(300, 2))
    x, y = jumps(drawn(data)).reshape(-1, 2).T
    assert np.abs(x - 0.31 - 0.4 * y).max() < 0.07
    assert y.max() - y.min() > 0.9


def test_a_sloping_jump_has_no_steps_on_a_grid() -> None:
    lines = jumps(drawn(two_sides(grid(11, 11), 1.0)))
    directions = np.round(np.abs(lines[:, 1] - lines[:, 0]), 9)
    # Along the diagonal of the cells the line is straight.
    assert len(np.unique(directions, axis=0)) == 1


def test_without_jumps_no_line_is_drawn() -> None:
    drawing = drawn(sweep(grid(5, 5), np.arange(25)))
    assert not artists(drawing, "jumps")
    assert not legend_texts(drawing)


def test_the_legend_says_what_the_lines_are() -> None:
    assert "other benches touch first" in legend_texts(drawn(two_sides(grid(9, 9))))
    labels = [(int(x > 0.5),) for x in grid(9, 9)[:, 0]]
    assert "jump" in legend_texts(drawn(sweep(grid(9, 9), 0.0, labels)))


# --- Two axes: colours.


def field(drawing: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Corners of all triangles with values, (M, 3, 2), and the values there, (M, 3)."""
    [mesh] = artists(drawing, "values")
    shape = mesh._triangulation
    corners = np.stack([shape.x, shape.y], axis=1)[shape.triangles]
    return corners, np.asarray(mesh.get_array())[shape.triangles], mesh


@pytest.mark.parametrize("points", [grid(21, 21), samples(200, 2), refined(2, lambda x, y: x < 0.31 + 0.4 * y)])
def test_no_colour_is_blended_across_a_jump(points: np.ndarray, tmp_path: Path) -> None:
    data = two_sides(points, reference={}, labels=[(bool(x < 0.31 + 0.4 * y),) for x, y in points])
    _, values, _ = field(drawn(data))
    assert set(np.unique(values)) == {0.0, 1.0}
    write_styled(lambda: draw(data), tmp_path / "map.png")
    with Image.open(tmp_path / "map.png") as picture:
        # Left of the colour bar.
        pixels = np.asarray(picture.convert("RGB"))[:, :1300].astype(int)
    for share, least in ((0.0, 100_000), (0.25, None), (0.5, None), (0.75, None), (1.0, 100_000)):
        colour = 255 * np.array(colour_map()(share)[:3])
        alike = np.count_nonzero(np.abs(pixels - colour).max(axis=2) < 8)
        assert alike > least if least else alike < 50


def test_values_are_exact_up_to_the_jumps_if_they_are_linear() -> None:
    points = grid(13, 9)
    left = points[:, 0] < 0.31 + 0.4 * points[:, 1]
    x, y = points.T
    data = sweep(points, np.where(left, 1 + 2 * x - y, 7 - x + 3 * y), [(bool(side),) for side in left])
    corners, values, _ = field(drawn(data))
    (x, y), middle = np.moveaxis(corners, -1, 0), corners.mean(axis=1)
    first, second = 1 + 2 * x - y, 7 - x + 3 * y
    on_first = np.abs(values - first).max(axis=1) < 1e-9
    assert np.all(on_first | (np.abs(values - second).max(axis=1) < 1e-9))
    far = np.abs(middle[:, 0] - 0.31 - 0.4 * middle[:, 1]) > 0.1
    np.testing.assert_array_equal(on_first[far], (middle[:, 0] < 0.31 + 0.4 * middle[:, 1])[far])


@hypothesis.given(
    points=st.lists(st.tuples(st.integers(0, 8), st.integers(0, 8), st.integers(0, 3)), min_size=3, max_size=40)
)
@examples(100)
def test_pieces_fill_the_area_between_the_points_and_have_one_class_each(points: list[tuple[int, int, int]]) -> None:
    distinct = {(x, y): number for x, y, number in points}
    places = np.array(list(distinct), dtype=float) / 8
    classes = np.array(list(distinct.values()))
    found = pieces(places, classes, np.zeros(len(places)))
    whole = pieces(places, np.zeros_like(classes), np.zeros(len(places)))
    assert (found is None) == (whole is None)
    if found is None or whole is None:
        return
    assert found.areas.min() > 0
    assert found.areas.sum() == pytest.approx(whole.areas.sum())
    of_corner = classes[found.source][found.triangles]
    assert np.all(of_corner == of_corner[:, :1])
    assert len(found.jumps) > 0 or len(set(classes[whole.triangles].ravel())) == 1


def test_contour_lines_are_where_the_values_are() -> None:
    points = grid(30, 30)
    drawing = drawn(sweep(points, 100 * points[:, 0] ** 2))
    [contours] = artists(drawing, "contours")
    levels = [float(text.get_text()) for text in artists(drawing, "contour-label")]
    assert len(levels) >= 4
    for line in contours.get_segments():
        level = np.interp(line[:, 0], points[::30, 0], 100 * points[::30, 0] ** 2)
        assert np.ptp(level) < 1e-9
        assert level[0] == pytest.approx(round(level[0] / 5) * 5)


def test_the_colours_get_darker_with_the_value() -> None:
    def luminance(colour: str) -> float:
        parts = np.array(list(bytes.fromhex(colour[1:]))) / 255
        linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
        return float(linear @ (0.2126, 0.7152, 0.0722))

    lightness = [luminance(colour) ** (1 / 3) for colour in VALUES]
    steps = -np.diff(lightness)
    assert steps.min() > 0.7 * steps.max() > 0
    # Lines between classes remain visible on the darkest colour, and dark text on the lightest.
    assert (luminance(VALUES[-1]) + 0.05) / (luminance(Palette().ink) + 0.05) > 1.9


def test_gradients_have_no_bands(tmp_path: Path) -> None:
    write_styled(lambda: draw(sweep(grid(9, 9), np.arange(81))), tmp_path / "map.png")
    with Image.open(tmp_path / "map.png") as picture:
        assert picture.width == 1600
        bar = np.asarray(picture.convert("RGB"))[:, 1370]
    assert len(np.unique(bar, axis=0)) > 200


def test_the_colour_bar_has_the_name_and_the_unit() -> None:
    shown = texts(drawn(two_sides(grid(5, 5))))
    assert {"contact time, s", "pitch, m", "width, m", "A sweep", "of numbers"} <= set(shown)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("pitch", "pitch, m"),
        ("body_spacing", "body spacing, m"),
        ("dragon.width", "width, m"),
        ("start_s", "start, m"),
        ("contact_time", "contact time, s"),
        ("speed", "speed, m/s"),
        ("rotation", "rotation, rad"),
        ("benches", "benches"),
        ("turns", "turns"),
    ],
)
def test_names_are_words_with_units(name: str, expected: str) -> None:
    assert words(name) == expected


# --- Statuses, names and the reference.


@pytest.mark.parametrize("points", [grid(30), grid(30, 7), samples(300, 2), grid(13, 5, 5), samples(60, 3)])
def test_every_status_without_value_has_a_tint_of_its_own_and_is_named_once(points: np.ndarray) -> None:
    drawing = drawn(five_statuses(points))
    shown = [text.replace("\n", " ") for text in texts(drawing)]
    for key, tint in TINTS.items():
        assert shown.count(tint.text) == 1, tint.text
        assert artists(drawing, key or "none"), key


def test_tints_differ_without_colour() -> None:
    # As in print: by hatching, or by lightness.
    plain = [tint for tint in TINTS.values() if not tint.hatch]
    greys = [Image.new("RGB", (1, 1), tint.colour).convert("L").getpixel((0, 0)) for tint in plain]
    assert all(abs(first - second) > 20 for first, second in combinations(greys, 2))
    hatches = [tint.hatch for tint in TINTS.values() if tint.hatch]
    assert len(set(hatches)) == len(hatches)
    assert len({tint.marker for tint in TINTS.values()}) == len(TINTS)


def test_a_point_without_value_never_has_a_colour() -> None:
    data = five_statuses(grid(31, 7))
    corners, values, _ = field(drawn(data))
    assert np.isfinite(values).all()
    # The last contact is at x = 4 / 30.
    assert corners[..., 0].max() == pytest.approx(4.5 / 30)


def test_names_are_inside_their_regions_and_clear_of_lines() -> None:
    points = grid(41, 41)
    number = (points[:, 0] + 0.3 * np.sin(5 * points[:, 1])) // 0.14
    labels = [(0, int(k) + 20, "contact") for k in number]
    drawing = drawn(sweep(points, points.sum(axis=1), labels))
    [axes] = [axes for axes in drawing.axes if axes.get_xlabel()]
    lines = axes.transData.transform(jumps(drawing).reshape(-1, 2)).reshape(-1, 2, 2)
    shares = np.linspace(0, 1, 9)[:, None, None]
    on_lines = ((1 - shares) * lines[:, 0] + shares * lines[:, 1]).reshape(-1, 2)
    names = [text for text in axes.texts if text.get_text().startswith("0 and")]
    assert len(names) >= 4
    for text in names:
        x, y = text.get_position()
        assert text.get_text() == f"0 and {int((x + 0.3 * np.sin(5 * y)) // 0.14) + 20}"
        turn, rotation = text.get_rotation(), np.radians(text.get_rotation())
        text.set_rotation(0)
        box = text.get_window_extent()
        text.set_rotation(turn)
        off = on_lines - axes.transData.transform((x, y))
        along = off @ (np.cos(rotation), np.sin(rotation))
        across = off @ (-np.sin(rotation), np.cos(rotation))
        assert not np.any((np.abs(along) < box.width / 2) & (np.abs(across) < box.height / 2))
    assert all(text.get_window_extent().x1 <= axes.bbox.x1 for text in names)


def test_the_reference_is_marked_and_named() -> None:
    for data, expected in (
        (two_sides(grid(9, 9)), (0.55, 0.3)),
        (two_sides(samples(50, 2)), (0.55, 0.3)),
        (sweep(grid(9), np.linspace(0, 80, 9)), (0.55, 44.0)),
    ):
        drawing = drawn(data)
        [dot] = artists(drawing, "reference")
        assert np.ravel(dot.get_data()) == pytest.approx(expected)
        assert texts(drawing).count("reference") == 1


@pytest.mark.parametrize(
    "reference", [{}, {"pitch": 0.55}, {"pitch": 0.55, "width": 1.01}, {"pitch": np.nan, "width": 0}]
)
def test_a_reference_that_is_absent_or_outside_is_not_marked(reference: dict[str, float]) -> None:
    drawing = drawn(two_sides(grid(9, 9), reference=reference))
    assert not artists(drawing, "reference")
    assert "reference" not in texts(drawing)


# --- One axis.


def test_the_line_is_broken_where_the_label_changes() -> None:
    x = np.linspace(0, 1, 21)[:, None]
    labels = [(0, 19 if value < 0.42 else 8, "contact") for value in x[:, 0]]
    drawing = drawn(sweep(x, np.sqrt(x[:, 0]), labels))
    first, second = (line.get_data() for line in artists(drawing, "line"))
    np.testing.assert_allclose(np.concatenate([first[0], second[0]]), x[:, 0])
    np.testing.assert_allclose(np.concatenate([first[1], second[1]]), np.sqrt(x[:, 0]))
    assert (first[0][-1], second[0][0]) == pytest.approx((0.4, 0.45))
    [marks] = artists(drawing, "jumps")
    assert [segment[0][0] for segment in marks.get_segments()] == pytest.approx([0.425])
    assert {"0 and 19", "0 and 8"} <= set(texts(drawing))


def test_bands_end_halfway_between_points() -> None:
    statuses = ["overlapping"] * 3 + ["contact"] * 5 + ["clear"] * 3
    values = [np.nan] * 3 + [1.0, 2.0, 3.0, 4.0, 5.0] + [np.nan] * 3
    drawing = drawn(sweep(grid(11), values, [(status,) for status in statuses], statuses))
    for key, ends in (("overlapping", (0.0, 0.25)), ("clear", (0.75, 1.0))):
        [band] = artists(drawing, key)
        assert (band.get_x(), band.get_x() + band.get_width()) == pytest.approx(ends)


# --- More axes.


def test_more_axes_have_a_panel_for_each_pair_and_each_axis() -> None:
    for count in (3, 4, 5):
        drawing = drawn(sweep(samples(40, count), np.arange(40)))
        panels = [axes for axes in drawing.axes if axes.get_xlim() != (0, 1) or axes.collections or axes.lines]
        assert len(artists(drawing, "values")) == count * (count - 1) // 2
        for name in NAMES[:count]:
            [points] = artists(drawing, f"over-{name}")
            assert len(points.get_xdata()) == 40
        assert len(panels) >= count * (count + 1) // 2


def test_panels_of_a_grid_are_the_slices_nearest_to_the_reference() -> None:
    points = grid(5, 5, 5)
    drawing = drawn(sweep(points, points @ (1, 10, 100)))
    # The reference has a pitch of 0.55, a width of 0.3 and no turns, whose middle is 0.5.
    assert "maps: slices near pitch 0.5 m, width 0.25 m, turns 0.5" in texts(drawing)
    expected = {("pitch", "width"): (1, 10, 50), ("pitch", "turns"): (1, 100, 2.5), ("width", "turns"): (10, 100, 0.5)}
    meshes = artists(drawing, "values")
    assert len(meshes) == 3
    for mesh, (first, second, constant) in zip(meshes, expected.values(), strict=True):
        shape = mesh._triangulation
        np.testing.assert_allclose(mesh.get_array(), first * shape.x + second * shape.y + constant)


def test_samples_on_more_axes_are_drawn_as_points() -> None:
    data = five_statuses(samples(80, 3))
    drawing = drawn(data)
    coloured = np.isfinite(data.values)
    for group in artists(drawing, "values"):
        assert len(group.get_offsets()) == np.count_nonzero(coloured)
        np.testing.assert_allclose(sorted(group.get_array()), sorted(data.values[coloured]))
    assert not any("slices" in text for text in texts(drawing))
    assert len(artists(drawing, "reference")) == 1  # pitch and width; the reference has no turns


# --- Any data.

LINE = np.linspace(0, 1, 7)
ODD = {
    "no values": sweep(samples(20, 2), np.nan, statuses=["clear"] * 20),
    "no values on a line": sweep(samples(20, 1), np.nan, statuses=["unreachable"] * 20),
    "all failed": sweep(samples(20, 3), np.nan, [None] * 20, ["failed"] * 20),
    "one value": sweep(samples(20, 2), 3.0),
    "one value on a line": sweep(grid(9), 3.0),
    "one value in space": sweep(samples(9, 3), 0.0),
    "a row": sweep(np.stack([LINE, 0 * LINE + 0.3], axis=1), LINE),
    "a column": sweep(np.stack([0 * LINE, LINE], axis=1), LINE),
    "a diagonal": sweep(np.stack([LINE, LINE], axis=1), LINE, [(0, k // 3) for k in range(7)]),
    "almost a line": sweep(np.stack([LINE, LINE + 1e-13 * np.sin(99 * LINE)], axis=1), LINE),
    "duplicates": sweep(np.repeat(samples(10, 2), 3, axis=0), np.arange(30)),
    "duplicates on a line": sweep(np.repeat(grid(5), 3, axis=0), np.arange(15)),
    "two points": sweep([[0, 0], [1, 1]], [1, 2]),
    "two points on a line": sweep([[0], [1]], [1, 2]),
    "two points in space": sweep([[0, 0, 0], [1, 1, 1]], [1, 2]),
    "one point": sweep([[0.5, 0.5]], [1.0]),
    "one point on a line": sweep([[0.5]], [1.0]),
    "one point in space": sweep([[0.5, 0.5, 0.5]], [np.nan]),
    "no point": sweep(np.empty((0, 2)), []),
    "no point on a line": sweep(np.empty((0, 1)), []),
    "no point in space": sweep(np.empty((0, 3)), []),
    "three labels": sweep([[0, 0], [1, 0], [0, 1]], [1, 2, 3], [(0, 1), (0, 2), (0, 3)]),
    "a label each": sweep(grid(6, 6), np.arange(36), [(0, k) for k in range(36)]),
    "no labels": sweep(samples(20, 2), np.arange(20), [None] * 20, [None] * 20, reference={}),
    "infinite values": sweep(samples(20, 2), [np.inf, -np.inf, *range(18)]),
    "large values": sweep(samples(20, 2), 1e300 * np.arange(20)),
    "small values": sweep(0.5 + 1e-12 * samples(20, 2), 1e-300 * np.arange(20)),
    "a grid with one column": sweep(
        np.stack(np.meshgrid(LINE, [0.5], [1.0, 2.0]), axis=-1).reshape(-1, 3), np.arange(14)
    ),
    "no coordinate": sweep([[np.nan, 1], *samples(5, 2)], np.arange(6)),
}


@pytest.mark.parametrize("name", ODD)
def test_odd_data_are_drawn(name: str, tmp_path: Path) -> None:
    # Warnings are errors.
    write_styled(lambda: draw(ODD[name]), tmp_path / "map.svg")
    assert (tmp_path / "map.svg").stat().st_size > 5000


def test_of_equal_points_the_first_is_drawn() -> None:
    drawing = drawn(sweep([[0.0], [1.0], [0.0]], [1.0, 2.0, 9.0]))
    [line] = artists(drawing, "line")
    assert line.get_ydata().tolist() == [1.0, 2.0]


MAPS = {
    "a line": five_statuses(grid(40)),
    "a grid": five_statuses(grid(40, 5)),
    "samples": two_sides(samples(100, 2)),
    "slices": five_statuses(grid(13, 4, 4)),
    "samples in space": five_statuses(samples(50, 4)),
}


@pytest.mark.parametrize(("name", "ending"), [*product(MAPS, [".svg"]), ("a grid", ".png"), ("a grid", ".pdf")])
def test_the_same_map_has_the_same_bytes(name: str, ending: str, tmp_path: Path) -> None:
    first, second = tmp_path / f"first{ending}", tmp_path / f"second{ending}"
    write_styled(lambda: draw(MAPS[name]), first)
    write_styled(lambda: draw(MAPS[name]), second)
    assert first.read_bytes() == second.read_bytes()
    assert first.stat().st_size < 600_000


@pytest.mark.thorough
def test_another_process_writes_the_same_bytes(tmp_path: Path) -> None:
    digests = set()
    for seed in ("1", "2"):
        file = tmp_path / f"{seed}.svg"
        program = (
            "from test_sweep_figure import MAPS, draw, write_styled;"
            f"write_styled(lambda: draw(MAPS['a grid']), {str(file)!r})"
        )
        subprocess.run(
            [sys.executable, "-c", program],
            check=True,
            env=os.environ | {"PYTHONHASHSEED": seed, "PYTHONPATH": os.pathsep.join(sys.path)},
        )
        digests.add(hashlib.sha256(file.read_bytes()).hexdigest())
    assert len(digests) == 1


@pytest.mark.thorough
@pytest.mark.parametrize("points", [grid(100, 100), samples(10_000, 2)], ids=["grid", "samples"])
def test_ten_thousand_points_make_small_files(points: np.ndarray, tmp_path: Path) -> None:
    number = (20 * (points[:, 0] - 0.4 * points[:, 1])).astype(int)
    data = sweep(points, points[:, 0] + number % 3, [(0, int(k)) for k in number])
    for ending in (".png", ".svg", ".pdf"):
        write_styled(lambda: draw(data), tmp_path / f"map{ending}")
        assert (tmp_path / f"map{ending}").stat().st_size < 1_000_000
