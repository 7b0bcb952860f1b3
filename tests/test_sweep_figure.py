"""The figure of a sweep: jumps are where labels change, colours are true within them, and any data can be drawn."""

from __future__ import annotations

import os
import subprocess
import sys

import matplotlib.text
import numpy as np
import pytest
from PIL import Image

from pymunk_dragon.drawing.figures import styled_figure, write_styled
from pymunk_dragon.sweeps.figure import Map, draw
from pymunk_dragon.sweeps.figure.panels import TINTS, colour_map

NAMES = ("pitch", "width", "turns", "overhang", "benches")
REFERENCE = {"pitch": 0.55, "width": 0.3}


def grid(*counts):
    """Points of a grid on the unit square or cube, (P, A)."""
    axes = np.meshgrid(*(np.linspace(0, 1, count) for count in counts), indexing="ij")
    return np.stack(axes, axis=-1).reshape(-1, len(counts))


def samples(count, axes):
    return np.random.default_rng(count).random((count, axes))


def sweep(points, values, labels=None, statuses=None, **changed):
    points = np.asarray(points, dtype=float)
    count = len(points)
    settings = {
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


def two_sides(points, slope=0.4, **changed):
    """A map with one jump, from 0 to 1, at the straight line x = 0.31 + slope * y."""
    left = points[:, 0] < 0.31 + slope * points[:, 1]
    labels = [(0, 8, "contact") if side else (0, 11, "contact") for side in left]
    return sweep(points, np.where(left, 0.0, 1.0), **{"labels": labels} | changed)


def five_statuses(points):
    """A map with values on the left, and all statuses without value in strips on the right."""
    kinds = ["contact", "clear", "overlapping", "unreachable", "failed", None]
    statuses = [kinds[min(int(6 * x), 5)] for x in points[:, 0]]
    values = [y if status == "contact" else np.nan for y, status in zip(points[:, -1], statuses, strict=True)]
    labels = [None if status == "failed" else (0, 1, status) for status in statuses]
    return sweep(points, values, labels, statuses)


def drawn(data):
    return styled_figure(lambda: draw(data))


def artists(drawing, gid):
    return list(drawing.findobj(lambda part: part.get_gid() == gid))


def texts(drawing):
    return [text.get_text() for text in drawing.findobj(matplotlib.text.Text) if text.get_text()]


def jumps(drawing):
    [lines] = artists(drawing, "jumps")
    return np.asarray(lines.get_path().vertices).reshape(-1, 2, 2)


def test_a_jump_is_drawn_where_it_is_on_grids_divided_cells_and_samples():
    for points, slope, near, ends in (
        # Half a cell aside, and for a sloping line also half a cell up.
        (grid(21, 21), 0.4, 0.035, 0.05),
        (grid(41, 11), 1.0, 0.1, 0.1),
        (samples(300, 2), 0.4, 0.07, 0.05),
    ):
        drawing = drawn(two_sides(points, slope))
        x, y = jumps(drawing).reshape(-1, 2).T
        assert np.abs(x - 0.31 - slope * y).max() <= near + 1e-9
        assert (y.min(), y.max()) == pytest.approx((0.0, 1.0 if slope < 1 else 0.69), abs=ends)
        assert "other benches touch first" in texts(drawing)


def test_without_jumps_no_line_is_drawn():
    drawing = drawn(sweep(grid(5, 5), np.arange(25)))
    assert not artists(drawing, "jumps")
    assert {"contact time, s", "pitch, m", "width, m", "A sweep", "of numbers"} <= set(texts(drawing))


def field(drawing):
    """Corners of all triangles with values, (M, 3, 2), and the values there, (M, 3)."""
    [mesh] = artists(drawing, "values")
    shape = mesh._triangulation
    corners = np.stack([shape.x, shape.y], axis=1)[shape.triangles]
    return corners, np.asarray(mesh.get_array())[shape.triangles]


def test_no_colour_is_blended_across_a_jump(tmp_path):
    data = two_sides(samples(200, 2), reference={})
    _, values = field(drawn(data))
    assert set(np.unique(values)) == {0.0, 1.0}
    write_styled(lambda: draw(data), tmp_path / "map.png")
    with Image.open(tmp_path / "map.png") as picture:
        # Left of the colour bar.
        pixels = np.asarray(picture.convert("RGB"))[:, :1300].astype(int)
    for share, least in ((0.0, 100_000), (0.5, None), (1.0, 100_000)):
        colour = 255 * np.array(colour_map()(share)[:3])
        alike = np.count_nonzero(np.abs(pixels - colour).max(axis=2) < 8)
        assert alike > least if least else alike < 50


def test_values_are_exact_up_to_the_jumps_if_they_are_linear():
    points = grid(13, 9)
    left = points[:, 0] < 0.31 + 0.4 * points[:, 1]
    x, y = points.T
    data = sweep(points, np.where(left, 1 + 2 * x - y, 7 - x + 3 * y), [(bool(side),) for side in left])
    corners, values = field(drawn(data))
    (x, y), middle = np.moveaxis(corners, -1, 0), corners.mean(axis=1)
    first, second = 1 + 2 * x - y, 7 - x + 3 * y
    on_first = np.abs(values - first).max(axis=1) < 1e-9
    assert np.all(on_first | (np.abs(values - second).max(axis=1) < 1e-9))
    far = np.abs(middle[:, 0] - 0.31 - 0.4 * middle[:, 1]) > 0.1
    np.testing.assert_array_equal(on_first[far], (middle[:, 0] < 0.31 + 0.4 * middle[:, 1])[far])


def test_every_status_without_value_has_a_tint_of_its_own_and_is_named_once():
    for points in (grid(30), grid(30, 7), samples(300, 2), grid(13, 5, 5), samples(60, 3)):
        drawing = drawn(five_statuses(points))
        shown = [text.replace("\n", " ") for text in texts(drawing)]
        for key, tint in TINTS.items():
            assert shown.count(tint.text) == 1, tint.text
            assert artists(drawing, key or "none"), key


def test_a_point_without_value_never_has_a_colour():
    data = five_statuses(grid(31, 7))
    corners, values = field(drawn(data))
    assert np.isfinite(values).all()
    # The last contact is at x = 4 / 30.
    assert corners[..., 0].max() == pytest.approx(4.5 / 30)


def test_the_reference_is_marked_and_named_if_it_is_inside():
    for data, expected in ((two_sides(grid(9, 9)), (0.55, 0.3)), (sweep(grid(9), np.linspace(0, 80, 9)), (0.55, 44.0))):
        drawing = drawn(data)
        [dot] = artists(drawing, "reference")
        assert np.ravel(dot.get_data()) == pytest.approx(expected)
        assert texts(drawing).count("reference") == 1
    for reference in ({"pitch": 0.55}, {"pitch": 0.55, "width": 1.01}, {"pitch": np.nan, "width": 0}):
        assert not artists(drawn(two_sides(grid(5, 5), reference=reference)), "reference"), reference


def test_the_line_is_broken_where_the_label_changes():
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


def test_more_axes_have_a_panel_for_each_pair_and_each_axis():
    drawing = drawn(sweep(samples(40, 4), np.arange(40)))
    assert len(artists(drawing, "values")) == 6
    for name in NAMES[:4]:
        [points] = artists(drawing, f"over-{name}")
        assert len(points.get_xdata()) == 40


def test_panels_of_a_grid_are_the_slices_nearest_to_the_reference():
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


LINE = np.linspace(0, 1, 7)
ODD = {
    "no values": sweep(samples(20, 2), np.nan, statuses=["clear"] * 20),
    "all failed": sweep(samples(20, 3), np.nan, [None] * 20, ["failed"] * 20),
    "one value": sweep(samples(20, 2), 3.0),
    "a diagonal": sweep(np.stack([LINE, LINE], axis=1), LINE, [(0, k // 3) for k in range(7)]),
    "duplicates": sweep(np.repeat(samples(10, 2), 3, axis=0), np.arange(30)),
    "one point": sweep([[0.5, 0.5]], [1.0]),
    "no point": sweep(np.empty((0, 2)), []),
    "no point on a line": sweep(np.empty((0, 1)), []),
    "a label each": sweep(grid(4, 4), np.arange(16), [(0, k) for k in range(16)]),
    "infinite values": sweep(samples(20, 2), [np.inf, -np.inf, *range(18)]),
    "large values": sweep(samples(20, 2), 1e300 * np.arange(20)),
    "no coordinate": sweep([[np.nan, 1], *samples(5, 2)], np.arange(6)),
}


@pytest.mark.parametrize("step", [6, pytest.param(1, marks=pytest.mark.thorough)])
def test_odd_data_are_drawn(step, tmp_path):
    for name in [*ODD][::step]:
        # Warnings are errors.
        write_styled(lambda name=name: draw(ODD[name]), tmp_path / f"{name}.svg")
        assert (tmp_path / f"{name}.svg").stat().st_size > 5000, name


def test_another_process_writes_the_same_bytes(tmp_path):
    program = (
        "from test_sweep_figure import draw, five_statuses, grid, write_styled;"
        f"write_styled(lambda: draw(five_statuses(grid(40, 5))), {str(tmp_path / '2.svg')!r})"
    )
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    subprocess.run([sys.executable, "-c", program], check=True, env=environment)
    write_styled(lambda: draw(five_statuses(grid(40, 5))), tmp_path / "1.svg")
    assert (tmp_path / "1.svg").read_bytes() == (tmp_path / "2.svg").read_bytes()


@pytest.mark.thorough
def test_files_of_ten_thousand_points_are_small_and_have_the_same_bytes_each_time(tmp_path):
    points = samples(10_000, 2)
    number = (20 * (points[:, 0] - 0.4 * points[:, 1])).astype(int)
    data = sweep(points, points[:, 0] + number % 3, [(0, int(k)) for k in number])
    for ending in (".png", ".svg", ".pdf"):
        files = [tmp_path / f"{attempt}{ending}" for attempt in (1, 2)]
        for file in files:
            write_styled(lambda: draw(data), file)
        assert files[0].read_bytes() == files[1].read_bytes(), ending
        assert files[0].stat().st_size < 1_000_000, ending
