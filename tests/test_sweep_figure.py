"""The figure of a sweep: jumps are where labels change, no colour is blended across them, and any data can be drawn."""

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
from pymunk_dragon.sweeps.figure.panels import colour_map

NAMES = ("pitch", "width", "turns", "overhang", "benches")


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
        "reference": {"pitch": 0.55, "width": 0.3},
        "title": "A sweep",
        "subtitle": "of numbers",
    }
    return Map(**settings | changed)


def two_sides(points, slope=0.4, **changed):
    """A map with one jump, from 0 to 1, at the straight line x = 0.31 + slope * y."""
    left = points[:, 0] < 0.31 + slope * points[:, 1]
    labels = [(0, 8, "contact") if side else (0, 11, "contact") for side in left]
    return sweep(points, np.where(left, 0.0, 1.0), labels, **changed)


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


def test_a_jump_is_drawn_where_it_is_on_grids_and_between_samples():
    for points, slope, near, ends in (
        # Half a cell aside, and for a sloping line also half a cell up.
        (grid(21, 21), 0.4, 0.035, 0.05),
        (grid(41, 11), 1.0, 0.1, 0.1),
        (samples(300, 2), 0.4, 0.07, 0.05),
    ):
        drawing = drawn(two_sides(points, slope))
        [lines] = artists(drawing, "jumps")
        x, y = np.asarray(lines.get_path().vertices).T
        assert np.abs(x - 0.31 - slope * y).max() <= near + 1e-9
        assert (y.min(), y.max()) == pytest.approx((0.0, 1.0 if slope < 1 else 0.69), abs=ends)
        assert {"other benches touch first", "contact time, s", "pitch, m", "A sweep"} <= set(texts(drawing))
    assert not artists(drawn(sweep(grid(5, 5), np.arange(25))), "jumps")


def test_no_colour_is_blended_across_a_jump_and_no_point_without_value_has_one(tmp_path):
    data = two_sides(samples(200, 2), reference={})
    [mesh] = artists(drawn(data), "values")
    assert set(np.unique(mesh.get_array())) == {0.0, 1.0}
    write_styled(lambda: draw(data), tmp_path / "map.png")
    with Image.open(tmp_path / "map.png") as picture:
        # Left of the colour bar.
        pixels = np.asarray(picture.convert("RGB"))[:, :1300].astype(int)
    for share, least in ((0.0, 100_000), (0.5, None), (1.0, 100_000)):
        colour = 255 * np.array(colour_map()(share)[:3])
        alike = np.count_nonzero(np.abs(pixels - colour).max(axis=2) < 8)
        assert alike > least if least else alike < 50
    [mesh] = artists(drawn(five_statuses(grid(31, 7))), "values")
    shape = mesh._triangulation
    # The last contact is at x = 4 / 30.
    assert shape.x[shape.triangles].max() == pytest.approx(4.5 / 30)


def test_the_reference_is_marked_if_it_is_inside():
    for data, expected in ((two_sides(grid(9, 9)), (0.55, 0.3)), (sweep(grid(9), np.linspace(0, 80, 9)), (0.55, 44.0))):
        [dot] = artists(drawn(data), "reference")
        assert np.ravel(dot.get_data()) == pytest.approx(expected)
    for reference in ({"pitch": 0.55}, {"pitch": 0.55, "width": 1.01}, {"pitch": np.nan, "width": 0}):
        assert not artists(drawn(two_sides(grid(5, 5), reference=reference)), "reference"), reference


def test_the_line_is_broken_where_the_label_changes():
    x = np.linspace(0, 1, 21)[:, None]
    labels = [(0, 19 if value < 0.42 else 8, "contact") for value in x[:, 0]]
    drawing = drawn(sweep(x, np.sqrt(x[:, 0]), labels))
    first, second = (line.get_data() for line in artists(drawing, "line"))
    np.testing.assert_allclose(np.concatenate([first[1], second[1]]), np.sqrt(x[:, 0]))
    assert (first[0][-1], second[0][0]) == pytest.approx((0.4, 0.45))
    [marks] = artists(drawing, "jumps")
    assert [segment[0][0] for segment in marks.get_segments()] == pytest.approx([0.425])
    assert {"0 and 19", "0 and 8"} <= set(texts(drawing))


def test_more_axes_have_a_panel_for_each_axis_and_each_pair_with_the_slice_nearest_to_the_reference():
    points = grid(5, 5, 5)
    drawing = drawn(sweep(points, points @ (1, 10, 100)))
    for name in NAMES[:3]:
        [over] = artists(drawing, f"over-{name}")
        assert len(over.get_xdata()) == 125
    # The reference has a pitch of 0.55, a width of 0.3 and no turns, whose middle is 0.5.
    pairs = (1, 10, 50), (1, 100, 2.5), (10, 100, 0.5)
    for mesh, (first, second, constant) in zip(artists(drawing, "values"), pairs, strict=True):
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
