"""Figures: what they draw is true, can be read, and comes out the same again."""

from __future__ import annotations

import hashlib
import io
import math
import os
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any

import hypothesis
import hypothesis.strategies as st
import matplotlib.text
import mpmath as mp
import numpy as np
import oracle
import pytest
import shapely
from conftest import assert_says
from marches import ARM, TRACTOR, U_TURN
from PIL import Image, ImageFont

from pymunk_dragon.collision import Grid, first_contact
from pymunk_dragon.drawing import Palette
from pymunk_dragon.drawing.figures import FIGURES, figure, style, write_figure
from pymunk_dragon.drawing.figures.lines import FIRST_COLOUR, spread
from pymunk_dragon.drawing.figures.times import closing_time, model
from pymunk_dragon.errors import MissingExtraError, OutputError, ParameterError
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.physics import simulate

CHARTS = [name for name, kind in FIGURES.items() if kind.still is None]
STILLS = [name for name, kind in FIGURES.items() if kind.still is not None]
# The seed's first contact, as every solver of the project finds it.
CONTACT_TIME = 412.473837682
NEAR_MISSES = {9: (406.847, 2.957), 11: (409.832, 0.865)}
PAPER = {"spiral", "outer-loop", "inward", "collision", "grid", "trajectories", "velocities"}
SEED = {"benches": 223, "head_spacing": 2.86, "body_spacing": 1.65, "pitch": 0.55, "turns": 16, "speed": 1}


@pytest.fixture(scope="module")
def run() -> Run:
    """The seed's last seconds, as the engine plays them: quick, and rough."""
    return simulate(March(Dragon(benches=40)), start=400, substep=0.02, iterations=15)


@pytest.fixture(scope="module")
def drawn(run: Run) -> dict[str, Any]:
    return {name: figure(name, run if FIGURES[name].needs_run else None) for name in CHARTS}


def artist(drawing: Any, gid: str) -> Any:
    [found] = drawing.findobj(lambda part: part.get_gid() == gid)
    return found


def line(drawing: Any, gid: str) -> tuple[np.ndarray, np.ndarray]:
    x, y = artist(drawing, gid).get_data()
    return np.asarray(x, dtype=float), np.asarray(y, dtype=float)


def test_all_of_the_papers_pictures_and_four_more_are_there() -> None:
    assert set(FIGURES) == PAPER | {"gap", "speeds", "drift", "impulses"}
    assert {name for name, kind in FIGURES.items() if kind.needs_run} == {"drift", "impulses"}
    assert all(kind.shows and "\n" not in kind.shows for kind in FIGURES.values())


@pytest.fixture(scope="module")
def written(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, str], Path]:
    """A function that gives the file of a figure, written once for all tests."""
    folder = tmp_path_factory.mktemp("figures")

    @cache
    def write(name: str, ending: str) -> Path:
        file = folder / f"{name}{ending}"
        write_figure(name, file, run if FIGURES[name].needs_run else None)
        return file

    return write


@pytest.mark.parametrize("name", FIGURES)
def test_each_figure_writes_each_of_its_endings(name: str, written: Callable[[str, str], Path]) -> None:
    for ending in FIGURES[name].endings:
        file = written(name, ending)
        content = file.read_bytes()
        if ending == ".svg":
            assert len(content) < 400_000
            assert b"<text" not in content  # a reader need not have the face
            assert b"<dc:date>" not in content
        elif ending == ".pdf":
            assert len(content) < 300_000
            assert content.startswith(b"%PDF")
            assert b"/CreationDate" not in content
        else:
            assert len(content) < 300_000
            with Image.open(file) as picture:
                assert picture.format == "PNG"
                assert picture.width == (1600 if name in CHARTS else 880)


@pytest.mark.parametrize("name", FIGURES)
def test_the_same_figure_has_the_same_bytes(
    name: str, run: Run, tmp_path: Path, written: Callable[[str, str], Path]
) -> None:
    for ending in FIGURES[name].endings[-2:]:
        write_figure(name, tmp_path / f"again{ending}", run if FIGURES[name].needs_run else None)
        assert (tmp_path / f"again{ending}").read_bytes() == written(name, ending).read_bytes()


def test_another_process_writes_the_same_bytes(tmp_path: Path, written: Callable[[str, str], Path]) -> None:
    digests = set()
    for seed in ("1", "2"):
        file = tmp_path / f"{seed}.svg"
        program = f"from pymunk_dragon.drawing.figures import write_figure; write_figure('grid', {str(file)!r})"
        subprocess.run(
            [sys.executable, "-W", "error", "-c", program], check=True, env=os.environ | {"PYTHONHASHSEED": seed}
        )
        digests.add(hashlib.sha256(file.read_bytes()).hexdigest())
    digests.add(hashlib.sha256(written("grid", ".svg").read_bytes()).hexdigest())
    assert len(digests) == 1


def test_a_picture_with_axes_loses_next_to_nothing_to_its_palette(
    written: Callable[[str, str], Path], drawn: dict[str, Any]
) -> None:
    exact = io.BytesIO()
    drawn["velocities"].savefig(exact, format="png")
    with Image.open(written("velocities", ".png")) as small, Image.open(exact) as full:
        difference = np.asarray(small.convert("RGB")).astype(int) - np.asarray(full.convert("RGB"))
    assert np.abs(difference).max() <= 4
    assert np.mean(difference != 0) < 0.1


# --- What is drawn is true.


def test_the_spiral_is_that_of_the_paper_and_ends_where_the_head_is_stopped(drawn: dict[str, Any]) -> None:
    k = 0.55 / (2 * math.pi)
    walked, ahead = np.array(line(drawn["spiral"], "walked")).T, np.array(line(drawn["spiral"], "ahead")).T
    for way in (walked, ahead):
        radius = np.hypot(*way.T)
        angle = radius / k
        np.testing.assert_allclose(way, radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1), atol=1e-9)
    np.testing.assert_allclose(walked[0], (8.8, 0), atol=1e-9)
    np.testing.assert_allclose(walked[-1], ahead[0], atol=1e-9)
    np.testing.assert_allclose(ahead[-1], 0, atol=1e-3)
    # A chord of the drawn line is a little shorter than the arc.
    assert np.hypot(*np.diff(walked, axis=0).T).sum() == pytest.approx(CONTACT_TIME, rel=1e-4)
    assert np.hypot(*np.diff(walked, axis=0).T).max() < 0.5


def test_the_dots_on_the_spiral_are_whole_minutes(drawn: dict[str, Any]) -> None:
    dots = np.array(line(drawn["spiral"], "minutes")).T
    assert len(dots) == 7
    for minute, dot in enumerate(dots):
        with mp.workdps(oracle.DIGITS):
            theta = oracle.head_angle(60 * minute, mp.mpf("0.55"), 16, 1)
            x, y = oracle.spiral_point(theta, mp.mpf("0.55"))
        np.testing.assert_allclose(dot, (float(x), float(y)), atol=1e-9)


@pytest.mark.thorough
def test_seven_handles_walk_from_where_they_start_to_where_the_contact_stops_them(drawn: dict[str, Any]) -> None:
    for column, time in ((0, 0.0), (-1, CONTACT_TIME)):
        positions, _ = oracle.solve(time, **SEED, difference=False)
        for handle in (0, 1, 51, 101, 151, 201, 223):
            x, y = line(drawn["trajectories"], f"path-{handle}")
            expected = [float(part) for part in positions[handle]]
            np.testing.assert_allclose((x[column], y[column]), expected, atol=1e-8)


@pytest.mark.thorough
def test_the_arrows_are_the_velocities_at_the_contact(drawn: dict[str, Any]) -> None:
    positions, velocities = oracle.solve(CONTACT_TIME, **SEED)
    handles = [0, 1, 51, 101, 151, 201, 223]
    arrows = artist(drawn["velocities"], "velocities")
    tips = np.column_stack([arrows.U, arrows.V]) / arrows.scale
    expected = np.array([[float(part) for part in velocities[handle]] for handle in handles])
    scale = np.hypot(*tips[0]) / np.hypot(*expected[0])
    np.testing.assert_allclose(tips, scale * expected, rtol=1e-7, atol=1e-7)
    places = np.array([[float(part) for part in positions[handle]] for handle in handles])
    np.testing.assert_allclose(arrows.XY, places, atol=1e-8)
    texts = {text.get_text() for text in drawn["velocities"].findobj(matplotlib.text.Text)}
    for handle, (vx, vy) in zip(handles, expected, strict=True):
        assert f"handle {handle}: {math.hypot(vx, vy):.3f} m/s" in texts


def test_cells_are_shaded_as_shapely_finds_benches_in_them(drawn: dict[str, Any]) -> None:
    march = model()
    outlines = [shapely.Polygon(c) for c in march.dragon.outlines(march.at(CONTACT_TIME).poses[0])]
    mesh = artist(drawn["grid"], "cells")
    edges, shown = np.asarray(mesh.get_coordinates()), np.asarray(mesh.get_array())
    kinds = []
    for row, column in np.ndindex(shown.shape):
        cell = shapely.Polygon(edges[[row, row + 1, row + 1, row], [column, column, column + 1, column + 1]])
        benches = [i for i, outline in enumerate(outlines) if outline.intersects(cell)]
        alone = all(j - i <= 1 for i, j in combinations(benches, 2))
        expected = min(len(benches), 2) if alone else 3
        assert shown[row, column] == expected, (row, column, benches)
        kinds.append(expected)
        assert cell.length == pytest.approx(4 * 0.55)
    assert set(kinds) == {0, 1, 2, 3}
    # Nothing lies outside what is shown.
    frame = shapely.box(*edges.reshape(-1, 2).min(axis=0), *edges.reshape(-1, 2).max(axis=0))
    assert all(frame.contains(outline) for outline in outlines)


def test_a_cells_indices_stand_beside_its_row_and_above_its_column(drawn: dict[str, Any]) -> None:
    [axes] = drawn["grid"].axes
    grid = Grid.of(model())
    for y, row in zip(axes.get_yticks(), axes.get_yticklabels(), strict=True):
        for x, column in zip(axes.get_xticks(), axes.get_xticklabels(), strict=True):
            assert grid.cell_of((x, y)).tolist() == [int(row.get_text()), int(column.get_text())]
    assert axes.get_yticks()[0] > axes.get_yticks()[-1]
    assert axes.get_xticks()[0] < axes.get_xticks()[-1]


def test_the_benches_on_the_grid_are_outlined_and_the_touching_ones_in_red(drawn: dict[str, Any]) -> None:
    march = model()
    corners = march.dragon.outlines(march.at(CONTACT_TIME).poses[0])
    for bench in range(16):
        patch = artist(drawn["grid"], f"bench-{bench}")
        np.testing.assert_allclose(patch.get_xy()[:4], corners[bench], atol=1e-8)
        red = matplotlib.colors.to_hex(patch.get_edgecolor()) == Palette().contact
        assert red == (bench in (0, 8))


def test_the_title_of_the_grid_counts_its_candidates(drawn: dict[str, Any]) -> None:
    march = model()
    outlines = march.dragon.outlines(march.at(CONTACT_TIME).poses[0])
    cells = [{tuple(cell) for cell in Grid.of(march).file(outlines[i : i + 1])[0].tolist()} for i in range(16)]
    apart = [(i, j) for i, j in combinations(range(16), 2) if j - i > 1]
    candidates = [pair for pair in apart if cells[pair[0]] & cells[pair[1]]]
    title = drawn["grid"].texts[0].get_text().replace("\n", " ")
    assert (
        title == f"Of {len(apart)} pairs of benches that share no hole, {len(candidates)} share a cell and are tested"
    )


def test_the_gap_is_smallest_where_the_exact_model_says_so(drawn: dict[str, Any]) -> None:
    near_misses = {c.benches[1]: c for c in first_contact(March()).near_misses or ()}
    assert set(near_misses) == set(NEAR_MISSES)
    for name in ("gap", "last-gap"):
        times, gaps = line(drawn["gap"], name)
        for bench, (time, gap) in NEAR_MISSES.items():
            window = np.abs(times - time) < 1
            place = np.flatnonzero(window)[gaps[window].argmin()]
            assert gaps[place] == pytest.approx(gap, abs=5e-4)
            assert gaps[place] == pytest.approx(1e3 * near_misses[bench].gap, abs=1e-9)
            assert times[place] == near_misses[bench].time
        assert times[-1] == pytest.approx(CONTACT_TIME, abs=1e-9)
        # At the contact there is no gap, and the line leaves the scale.
        assert gaps[-1] < artist(drawn["gap"], name).axes.get_ylim()[0] / 5
    texts = [text.get_text() for text in drawn["gap"].findobj(matplotlib.text.Text)]
    assert "bench 9: 2.957 mm\nat 406.847 s" in texts
    assert "bench 11: 0.865 mm\nat 409.832 s" in texts
    assert "bench 8:\ncontact at\n412.4738 s" in texts


def test_gaps_are_those_that_shapely_measures_to_all_benches(drawn: dict[str, Any]) -> None:
    march = March()
    times, gaps = line(drawn["gap"], "gap")
    for place in range(0, len(times) - 1, 100):
        poses = march.at(times[place]).poses[0]
        head, _, *others = (shapely.Polygon(corners) for corners in march.dragon.outlines(poses))
        assert gaps[place] == pytest.approx(1e3 * min(head.distance(other) for other in others), abs=1e-7)


def test_each_dashed_line_is_the_gap_to_its_bench(drawn: dict[str, Any]) -> None:
    march = March()
    for bench in (8, 9, 10, 11):
        times, gaps = line(drawn["gap"], f"gap-{bench}")
        for place in range(0, len(times) - 1, 300):
            corners = march.dragon.outlines(march.at(times[place]).poses[0])
            distance = shapely.Polygon(corners[0]).distance(shapely.Polygon(corners[bench]))
            assert gaps[place] == pytest.approx(1e3 * distance, abs=1e-7)


def test_speeds_are_the_oracles_at_the_times_beside_their_lines(drawn: dict[str, Any]) -> None:
    [axes] = drawn["speeds"].axes
    names = [text for text in axes.texts if text.get_text().endswith(" s")]
    assert [text.get_text() for text in names] == ["0 s", "100 s", "200 s", "300 s", "400 s", "412.47 s"]
    for rank, time in ((0, 0.0), (5, CONTACT_TIME)):
        _, velocities = oracle.solve(time, **(SEED | {"benches": 20}))
        handles, speeds = line(drawn["speeds"], f"speed-{rank}")
        assert handles.tolist() == list(range(224))
        expected = [float(mp.hypot(*velocity)) for velocity in velocities]
        np.testing.assert_allclose(speeds[:21], expected, atol=1e-9)
    low, high = axes.get_ylim()
    for rank, name in enumerate(names):
        assert abs(name.xy[1] - line(drawn["speeds"], f"speed-{rank}")[1][-1]) < 0.06 * (high - low)


def test_drift_is_that_of_the_run(drawn: dict[str, Any], run: Run) -> None:
    times, worst = line(drawn["drift"], "any-bench")
    for time, value in list(zip(times, worst, strict=True))[::20]:
        [frame] = np.flatnonzero(run.times == time)
        assert value == pytest.approx(1e6 * max(run.drift[frame]))
    assert times[-1] == run.times[-1]
    frame = np.flatnonzero(run.times == times[40])[0]
    assert line(drawn["drift"], "first-12-benches")[1][40] == pytest.approx(1e6 * max(run.drift[frame, :12]))
    benches, last = line(drawn["drift"], "drift-0")
    assert benches.tolist() == list(range(40))
    assert any(np.allclose(last, 1e6 * row) for row in run.drift)
    levels = [part for part in drawn["drift"].findobj(matplotlib.lines.Line2D) if part.get_gid() == "smallest-gap"]
    assert {round(float(level.get_ydata()[0])) for level in levels} == {865}


def test_impulses_are_those_of_the_frames_before_the_contact_and_the_force_is_over_a_substep(
    drawn: dict[str, Any], run: Run
) -> None:
    axes = drawn["impulses"].axes[0]
    assert run.joint_impulses is not None
    for rank, name in enumerate(text.get_text() for text in axes.texts):
        frame = int(np.abs(run.times - float(name.removesuffix(" s"))).argmin())
        joints, values = line(drawn["impulses"], f"impulse-{rank}")
        assert joints.tolist() == list(range(39))
        np.testing.assert_array_equal(values, run.joint_impulses[frame])
        assert run.times[frame] < run.times[-1]
    [force] = axes.child_axes
    np.testing.assert_allclose(force.get_ylim(), np.array(axes.get_ylim()) / 0.02)


# --- Pictures of the dragon.


def colours_of(path: Path) -> dict[str, int]:
    with Image.open(path) as picture:
        found = picture.convert("RGB").getcolors(1 << 20) or []
    return {"#" + bytes(colour).hex(): count for count, colour in found}


def test_only_at_the_collision_two_benches_have_the_contact_colour(written: Callable[[str, str], Path]) -> None:
    palette = Palette()
    shares = {}
    for name in STILLS:
        shares[name] = colours_of(written(name, ".png"))
    assert palette.contact not in shares["outer-loop"]
    assert palette.contact not in shares["inward"]
    # The head is 3.41 m long, bench 8 is 2.20 m, and 13 others of that length are blue, as far as they are in sight.
    contact, head, body = (shares["collision"][getattr(palette, part)] for part in ("contact", "head", "body"))
    assert head / body == pytest.approx(3.41 / (13 * 2.20), rel=0.15)
    # The head has its own colour, with an outline in that of the contact.
    assert 2.20 / (13 * 2.20) < contact / body < 3.41 / (13 * 2.20)


def test_the_dragon_is_large_in_its_pictures(written: Callable[[str, str], Path]) -> None:
    palette = Palette()
    for name in STILLS:
        with Image.open(written(name, ".png")) as picture:
            pixels = np.asarray(picture.convert("RGB"))
        bench = np.any([np.all(pixels == palette.rgb(part), axis=-1) for part in ("body", "tail", "head")], axis=0)
        columns = np.flatnonzero(bench.any(axis=0))
        assert columns[-1] - columns[0] > 0.8 * pixels.shape[1]


def test_inward_is_when_the_tail_has_a_full_loop_to_the_head() -> None:
    march = model()
    time = closing_time(march, 0.0, CONTACT_TIME)
    angles = march.curve.angle(march.handles_s([time - 0.01, time, time + 0.01]))
    # The path turns as its angle does, and a little more the tighter it is.
    turning = angles + np.arctan(angles)
    before, at, after = turning[:, -1] - turning[:, 0]
    assert before < at < after
    assert at == pytest.approx(2 * np.pi, abs=1e-6)


def test_a_dragon_that_never_closes_a_loop_is_shown_halfway() -> None:
    assert closing_time(March(Dragon(benches=3)), 0.0, 100.0) == 50.0


# --- What it looks like.


@pytest.fixture
def type_on(monkeypatch: pytest.MonkeyPatch) -> Callable[[Any], list[tuple[str, Any]]]:
    """Gives every line of type that is really drawn, and its box in pixels."""
    draw, seen = matplotlib.text.Text.draw, []

    def draw_and_note(text: Any, *arguments: Any, **options: Any) -> None:
        draw(text, *arguments, **options)
        if text.get_visible() and text.get_text().strip():
            # Of an annotation, the box of the text without its leader.
            seen.append((text.get_text(), matplotlib.text.Text.get_window_extent(text)))

    def look(drawing: Any) -> list[tuple[str, Any]]:
        seen.clear()
        drawing.savefig(io.BytesIO(), format="png")
        return list(seen)

    monkeypatch.setattr(matplotlib.text.Text, "draw", draw_and_note)
    return look


@pytest.mark.parametrize("name", CHARTS)
def test_type_is_large_enough_to_be_read_at_half_its_size(name: str, drawn: dict[str, Any]) -> None:
    sizes = {text.get_size() for text in drawn[name].findobj(matplotlib.text.Text)}
    # Half of 200 pixels to the inch, and 72 points to the inch: no type below 14 pixels.
    assert min(sizes) * 200 / 2 / 72 > 14


@pytest.mark.parametrize(
    ("name", "words"),
    {
        "spiral": ["x (m)", "y (m)", "0.55 m apart"],
        "grid": ["column j", "row i", "cells of 0.55 m"],
        "trajectories": ["412.47 s", "10 m"],
        "velocities": ["x (m)", "y (m)", "m/s"],
        "gap": ["mm", "time (s)"],
        "speeds": ["m/s", "handle"],
        "drift": ["\N{MICRO SIGN}m", "time (s)", "bench"],
        "impulses": ["N s", "at the right", "N", "joint"],
    }.items(),
)
def test_units_are_told(name: str, words: list[str], drawn: dict[str, Any]) -> None:
    told = " ".join(text.get_text() for text in drawn[name].findobj(matplotlib.text.Text))
    for word in words:
        assert word in told


@pytest.mark.parametrize("name", CHARTS)
def test_the_face_is_that_of_the_films(name: str, drawn: dict[str, Any]) -> None:
    for text in drawn[name].findobj(matplotlib.text.Text):
        assert text.get_fontfamily()[0] == ImageFont.load_default(12).getname()[0]


def luminance(colour: str) -> float:
    red, green, blue = ((part / 255) ** 2.2 for part in bytes.fromhex(colour[1:]))
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one: str, other: str) -> float:
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_lines_and_type_have_contrast_to_the_ground() -> None:
    ground = Palette().background
    for colour in (style.BLUE, style.AMBER, FIRST_COLOUR):
        assert contrast(colour, ground) > 3
    for colour in (style.QUIET, Palette().ink, Palette().contact):
        assert contrast(colour, ground) > 4.5


# How people without one kind of cones see linear red, green and blue (Vienot, Brettel and Mollon, 1999).
CONES = {
    "protanopia": [[0.11238, 0.88762, 0], [0.11238, 0.88762, 0], [0.00401, -0.00401, 1]],
    "deuteranopia": [[0.29275, 0.70725, 0], [0.29275, 0.70725, 0], [-0.02234, 0.02234, 1]],
    "greyscale": [[0.2126, 0.7152, 0.0722]] * 3,
}


@pytest.mark.parametrize("eye", CONES)
def test_shades_of_cells_stay_apart_for_the_colour_blind_and_in_grey(eye: str) -> None:
    shades = [Palette().background, style.FAINT, style.SHARED, style.CANDIDATE]
    seen = []
    for shade in shades:
        linear = (np.array(list(bytes.fromhex(shade[1:]))) / 255) ** 2.2
        seen.append(255 * np.clip(np.array(CONES[eye]) @ linear, 0, 1) ** (1 / 2.2))
    for (i, one), (j, other) in combinations(enumerate(seen), 2):
        assert np.abs(one - other).max() >= 10, (shades[i], shades[j])


def test_lines_of_one_panel_differ_in_more_than_colour(drawn: dict[str, Any]) -> None:
    for name, gids in (("drift", ("any-bench", "first-12-benches")), ("gap", ("last-gap", "gap-9"))):
        first, second = (artist(drawn[name], gid) for gid in gids)
        assert first.get_linestyle() != second.get_linestyle()
    widths = [artist(drawn["speeds"], f"speed-{rank}").get_linewidth() for rank in range(6)]
    greys = [luminance(matplotlib.colors.to_hex(artist(drawn["speeds"], f"speed-{i}").get_color())) for i in range(6)]
    assert widths == sorted(widths)
    assert greys == sorted(greys, reverse=True)
    assert np.all(np.diff(widths) > 0.1)
    assert -np.diff(greys).max() > 0.01


@hypothesis.given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=12), st.floats(0.1, 50))
def test_labels_keep_apart_and_in_order_and_move_no_more_than_they_have_to(places: list[float], apart: float) -> None:
    found = spread(places, apart)
    order = np.argsort(places, kind="stable")
    gaps = np.diff(np.array(found)[order])
    assert np.all(gaps >= apart - 1e-6)
    if np.all(np.diff(np.array(places)[order]) >= apart):
        np.testing.assert_allclose(found, places)
    # As a whole they stay where they were.
    assert np.mean(found) == pytest.approx(np.mean(places), abs=1e-6)


# --- How it is asked for.


def test_matplotlibs_own_settings_are_as_before(tmp_path: Path) -> None:
    before = dict(matplotlib.rcParams)
    figure("speeds")
    write_figure("grid", tmp_path / "grid.svg")
    assert dict(matplotlib.rcParams) == before


def test_a_users_settings_change_nothing(tmp_path: Path) -> None:
    write_figure("grid", tmp_path / "plain.svg")
    with matplotlib.rc_context({"font.size": 30, "axes.labelpad": 30, "svg.fonttype": "none"}):
        write_figure("grid", tmp_path / "with.svg")
    assert (tmp_path / "plain.svg").read_bytes() == (tmp_path / "with.svg").read_bytes()


def test_nothing_imports_pyplot_and_nothing_imports_matplotlib_before_a_figure_is_drawn() -> None:
    program = """
import sys
from pymunk_dragon.drawing.figures import FIGURES, figure
assert "matplotlib" not in sys.modules
figure("speeds")
assert "matplotlib" in sys.modules and "matplotlib.pyplot" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", program], check=True)


def test_a_run_and_its_march_give_the_same_figure(tmp_path: Path) -> None:
    march = March(Dragon(benches=20), turns=8)
    write_figure("speeds", tmp_path / "march.svg", march)
    write_figure("speeds", tmp_path / "run.svg", Run.exact(march, [0.0, 1.0]))
    assert (tmp_path / "march.svg").read_bytes() == (tmp_path / "run.svg").read_bytes()


@pytest.mark.parametrize("name", CHARTS)
def test_without_matplotlib_one_line_says_what_to_install(
    name: str, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    for call in (lambda: figure(name, run), lambda: write_figure(name, tmp_path / "x.png", run)):
        with pytest.raises(MissingExtraError) as error:
            call()
        assert_says(error.value, "a figure", "pip install 'pymunk-dragon[figures]'")
    assert list(tmp_path.iterdir()) == []


def test_pictures_of_the_dragon_need_no_matplotlib(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    write_figure("inward", tmp_path / "inward.png")
    assert (tmp_path / "inward.png").exists()


@pytest.mark.parametrize(
    ("name", "file", "source", "words"),
    [
        ("spirals", "x.png", None, ["figure", "'spirals'", "one of spiral, outer-loop"]),
        ("spiral", "x.gif", None, ["output", "x.gif", ".png or .svg"]),
        ("collision", "x.svg", None, ["output", "x.svg", "ends in .png"]),
        ("spiral", "no/such/x.png", None, ["output", "folder"]),
        ("spiral", "x.png", "march", ["source", "'march'", "a run or a march"]),
        ("drift", "x.png", None, ["run", "None", "a run of the engine", "drift"]),
        ("impulses", "x.svg", March(), ["run", "a run of the engine", "impulses"]),
        ("collision", "x.png", March(Dragon(benches=3), turns=3), ["march", "clear", "runs into itself"]),
        ("gap", "x.png", March(Dragon(benches=2)), ["benches", "2", "3 or more"]),
        ("gap", "x.png", March(Dragon(benches=40), turns=3.9), ["march", "overlap at the start"]),
        ("drift", "x.png", Run.exact(model(), [0.0, 1.0]), ["run", "exact model", "engine"]),
        ("impulses", "x.png", Run.exact(model(), [0.0, 1.0]), ["run", "without joint impulses", "simulate"]),
    ],
)
def test_what_cannot_be_drawn_is_told_in_one_line(
    name: str, file: str, source: Any, words: list[str], tmp_path: Path
) -> None:
    folder = tmp_path / ("long" * 20)
    folder.mkdir()
    with pytest.raises(ParameterError) as error:
        write_figure(name, folder / file, source)
    assert_says(error.value, *words)
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("name", STILLS)
def test_pictures_of_the_dragon_are_only_written(name: str) -> None:
    with pytest.raises(ParameterError) as error:
        figure(name)
    assert_says(error.value, "figure", name, "write_figure")


@pytest.mark.parametrize("name", [name for name in FIGURES if not FIGURES[name].needs_run and name != "collision"])
def test_other_marches_have_figures_too(name: str, tmp_path: Path) -> None:
    # Wide turns, on which nothing touches; and a start that is already tight.
    for march in (March(Dragon(benches=16), Spiral(pitch=1.7), turns=6), March(Dragon(benches=5), turns=5, speed=0.01)):
        write_figure(name, tmp_path / "figure.png", march)
        with Image.open(tmp_path / "figure.png") as picture:
            assert len(picture.convert("RGB").getcolors(1 << 20) or []) > 20


OTHERS = {"u-turn": Run.exact(U_TURN, np.linspace(-20, 20, 5)), "tractor": TRACTOR, "arm": ARM}


@pytest.mark.parametrize("name", [name for name in FIGURES if not FIGURES[name].needs_run])
@pytest.mark.parametrize("source", OTHERS.values(), ids=OTHERS)
def test_other_curves_have_figures_or_are_told_why_not(
    name: str, source: Any, tmp_path: Path, type_on: Callable[[Any], list[tuple[str, Any]]]
) -> None:
    if name in ("spiral", "collision"):
        with pytest.raises(ParameterError) as error:
            write_figure(name, tmp_path / "figure.png", source)
        assert_says(error.value, "a Spiral inward" if name == "spiral" else "runs into itself")
        return
    if name in STILLS:
        write_figure(name, tmp_path / "figure.png", source)
        return
    drawing = figure(name, source)
    width, height = drawing.canvas.get_width_height()
    for text, box in type_on(drawing):
        assert 5 < box.x0 < box.x1 < width - 5, text
        assert 5 < box.y0 < box.y1 < height - 5, text
        for word in ("spiral", "coil", "inward"):
            assert word not in text


def test_a_curve_without_end_is_looked_at_for_as_long_as_a_run() -> None:
    line = artist(figure("trajectories", OTHERS["u-turn"]), "path-0").get_xydata()
    np.testing.assert_allclose(line[[0, -1]], U_TURN.at([-20, 20]).positions[:, 0], atol=1e-9)
    with pytest.raises(ParameterError) as error:
        figure("trajectories", U_TURN)
    assert_says(error.value, "march", "curve without end", "a run")


def test_an_interrupted_figure_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "speeds.svg"
    file.write_text("old")

    def fail(*_: Any, **__: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(matplotlib.figure.Figure, "savefig", fail)
    with pytest.raises(OutputError):
        write_figure("speeds", file)
    assert file.read_text() == "old"
    assert list(tmp_path.iterdir()) == [file]
