"""Figures: what they draw is true, can be read, and comes out the same again."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any

import matplotlib.text
import mpmath as mp
import numpy as np
import oracle
import pytest
import shapely
from conftest import assert_says
from marches import ARM, TRACTOR, U_TURN
from matplotlib.colors import to_hex
from PIL import Image
from sharing import shared_run

from pymunk_dragon._language import in_language
from pymunk_dragon.collision import first_contact
from pymunk_dragon.drawing import Palette
from pymunk_dragon.drawing.figures import FIGURES, figure, write_figure
from pymunk_dragon.drawing.figures.times import model
from pymunk_dragon.errors import MissingExtraError, OutputError, ParameterError
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.physics import simulate
from pymunk_dragon.studies import max_speed, min_pitch, u_turn

CHARTS = [name for name, kind in FIGURES.items() if kind.still is None]
STILLS = [name for name, kind in FIGURES.items() if kind.still is not None]
# The paper's first contact, and the near misses before it: bench, time in s and gap in mm.
CONTACT_TIME = 412.473837682
NEAR_MISSES = {9: (406.847, 2.957), 11: (409.832, 0.865)}
SEED = {"benches": 223, "head_spacing": 2.86, "body_spacing": 1.65, "pitch": 0.55, "turns": 16, "speed": 1}
HANDLES = [0, 1, 51, 101, 151, 201, 223]
OTHERS = {"u-turn": Run.exact(U_TURN, np.linspace(-20, 20, 5)), "tractor": TRACTOR, "arm": ARM}


@cache
def run() -> Run:
    """The last seconds before the paper's contact, as the engine plays them: quick, and rough."""
    return shared_run("rough", lambda: simulate(March(Dragon(benches=40)), start=400, substep=0.02, iterations=15))


STUDIES: dict[str, Callable[[], Any]] = {
    "min-pitch": min_pitch,
    "min-pitch of a wide circle": lambda: min_pitch(radius=8.0),
    "max-speed": max_speed,
    "u-turn": lambda: u_turn(Dragon(benches=25), search=False),
}


@cache
def result(name: str) -> Any:
    return STUDIES[name]()


@cache
def drawn(name: str, lang: str = "en") -> Any:
    with in_language(lang):
        if name in STUDIES:
            return result(name).plot()
        return figure(name, run() if FIGURES[name].needs_run else None)


def artist(drawing: Any, gid: str) -> Any:
    [found] = drawing.findobj(lambda part: part.get_gid() == gid)
    return found


def line(drawing: Any, gid: str) -> tuple[np.ndarray, np.ndarray]:
    x, y = artist(drawing, gid).get_data()
    return np.asarray(x, dtype=float), np.asarray(y, dtype=float)


def words(drawing: Any) -> list[str]:
    return [text.get_text() for text in drawing.findobj(matplotlib.text.Text)]


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.thorough] * (name not in ("grid", "inward"))) for name in FIGURES]
)
def test_figure_has_the_same_bytes_in_each_format_whatever_the_settings(name: str, tmp_path: Path) -> None:
    source = run() if FIGURES[name].needs_run else None
    assert FIGURES[name].endings == ((".png", ".svg", ".pdf") if name in CHARTS else (".png", ".pdf"))
    for ending in FIGURES[name].endings:
        file = tmp_path / f"{name}{ending}"
        write_figure(name, file, source)
        content = file.read_bytes()
        assert len(content) < 400_000
        if ending == ".png":
            with Image.open(file) as picture:
                assert (picture.format, picture.width) == ("PNG", 1600 if name in CHARTS else 880)
            continue
        # Neither text that needs a font, nor a date.
        assert content.startswith(b"%PDF" if ending == ".pdf" else b"<?xml")
        assert not any(part in content for part in (b"<text", b"<dc:date>", b"/CreationDate"))
        with matplotlib.rc_context({"font.size": 30, "axes.labelpad": 30, "svg.fonttype": "none"}):
            before = dict(matplotlib.rcParams)
            write_figure(name, tmp_path / f"again{ending}", source)
            assert dict(matplotlib.rcParams) == before
        assert (tmp_path / f"again{ending}").read_bytes() == content


def test_interrupted_figure_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "speeds.svg"
    file.write_text("old")

    def fail(*_: Any, **__: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(matplotlib.figure.Figure, "savefig", fail)
    with pytest.raises(OutputError):
        write_figure("speeds", file, March(Dragon(benches=20), turns=8))
    assert file.read_text() == "old"
    assert list(tmp_path.iterdir()) == [file]


def test_spiral_is_that_of_the_paper_with_a_dot_each_minute() -> None:
    k = 0.55 / (2 * math.pi)
    walked, ahead, dots = (np.array(line(drawn("spiral"), name)).T for name in ("walked", "ahead", "minutes"))
    for way in (walked, ahead):
        radius = np.hypot(*way.T)
        angle = radius / k
        np.testing.assert_allclose(way, radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1), atol=1e-9)
    np.testing.assert_allclose(walked[0], (8.8, 0), atol=1e-9)
    np.testing.assert_allclose(walked[-1], ahead[0], atol=1e-9)
    np.testing.assert_allclose(ahead[-1], 0, atol=1e-3)
    # A chord of the drawn line is a little shorter than the arc.
    assert np.hypot(*np.diff(walked, axis=0).T).sum() == pytest.approx(CONTACT_TIME, rel=1e-4)
    assert len(dots) == 7
    for minute, dot in enumerate(dots):
        with mp.workdps(oracle.DIGITS):
            theta = oracle.head_angle(60 * minute, mp.mpf("0.55"), 16, 1)
            x, y = oracle.spiral_point(theta, mp.mpf("0.55"))
        np.testing.assert_allclose(dot, (float(x), float(y)), atol=1e-9)


@pytest.mark.thorough
def test_handles_end_where_the_contact_stops_them_with_the_velocities_of_fifty_digits() -> None:
    positions, velocities = oracle.solve(CONTACT_TIME, **SEED)
    places = np.array([[float(part) for part in positions[handle]] for handle in HANDLES])
    expected = np.array([[float(part) for part in velocities[handle]] for handle in HANDLES])
    for handle, place in zip(HANDLES, places, strict=True):
        x, y = line(drawn("trajectories"), f"path-{handle}")
        np.testing.assert_allclose((x[-1], y[-1]), place, atol=1e-8)
    arrows = artist(drawn("velocities"), "velocities")
    tips = np.column_stack([arrows.U, arrows.V]) / arrows.scale
    scale = np.hypot(*tips[0]) / np.hypot(*expected[0])
    np.testing.assert_allclose(tips, scale * expected, rtol=1e-7, atol=1e-7)
    np.testing.assert_allclose(arrows.XY, places, atol=1e-8)
    for handle, (vx, vy) in zip(HANDLES, expected, strict=True):
        assert f"handle {handle}: {math.hypot(vx, vy):.3f} m/s" in words(drawn("velocities"))


def test_cells_of_the_grid_are_shaded_as_shapely_finds_benches_in_them() -> None:
    march, drawing = model(), drawn("grid")
    corners = march.dragon.outlines(march.at(CONTACT_TIME).poses[0])
    outlines = [shapely.Polygon(c) for c in corners]
    mesh = artist(drawing, "cells")
    edges, shown = np.asarray(mesh.get_coordinates()), np.asarray(mesh.get_array())
    kinds, candidates = set(), set()
    for row, column in np.ndindex(shown.shape):
        cell = shapely.Polygon(edges[[row, row + 1, row + 1, row], [column, column, column + 1, column + 1]])
        benches = [i for i, outline in enumerate(outlines) if outline.intersects(cell)]
        apart = {(i, j) for i, j in combinations(benches, 2) if j - i > 1}
        assert shown[row, column] == (3 if apart else min(len(benches), 2)), (row, column, benches)
        assert cell.length == pytest.approx(4 * 0.55)
        kinds.add(int(shown[row, column]))
        candidates |= apart
    assert kinds == {0, 1, 2, 3}
    title = drawing.texts[0].get_text().replace("\n", " ")
    assert title.startswith(f"Of 105 pairs of benches that share no hole, {len(candidates)} share a cell")
    # Nothing lies outside what is shown.
    frame = shapely.box(*edges.reshape(-1, 2).min(axis=0), *edges.reshape(-1, 2).max(axis=0))
    assert all(frame.contains(outline) for outline in outlines)
    for bench in range(16):
        patch = artist(drawing, f"bench-{bench}")
        np.testing.assert_allclose(patch.get_xy()[:4], corners[bench], atol=1e-8)
        assert (to_hex(patch.get_edgecolor()) == Palette().contact) == (bench in (0, 8))


def test_gaps_are_those_of_shapely_and_smallest_where_the_exact_model_says() -> None:
    march, drawing = March(), drawn("gap")
    near_misses = {c.benches[1]: c for c in first_contact(march).near_misses or ()}
    assert set(near_misses) == set(NEAR_MISSES)
    for name in ("gap", "last-gap"):
        times, gaps = line(drawing, name)
        for bench, (time, gap) in NEAR_MISSES.items():
            window = np.abs(times - time) < 1
            place = np.flatnonzero(window)[gaps[window].argmin()]
            assert gaps[place] == pytest.approx(gap, abs=5e-4)
            assert gaps[place] == pytest.approx(1e3 * near_misses[bench].gap, abs=1e-9)
        assert times[-1] == pytest.approx(CONTACT_TIME, abs=1e-9)
        # At the contact there is no gap, and the line leaves the scale.
        assert gaps[-1] < artist(drawing, name).axes.get_ylim()[0] / 5
    for label in ("bench 9: 2.957 mm\nat 406.847 s", "bench 11: 0.865 mm\nat 409.832 s", "contact at\n412.4738 s"):
        assert any(label in text for text in words(drawing))
    for name, benches in (("gap", range(2, 223)), *((f"gap-{bench}", [bench]) for bench in (8, 9, 10, 11))):
        times, gaps = line(drawing, name)
        for place in range(0, len(times) - 1, 200):
            corners = march.dragon.outlines(march.at(times[place]).poses[0])
            head = shapely.Polygon(corners[0])
            gap = min(head.distance(shapely.Polygon(corners[bench])) for bench in benches)
            assert gaps[place] == pytest.approx(1e3 * gap, abs=1e-7)


def test_speeds_are_those_of_fifty_digits_at_the_times_beside_their_lines() -> None:
    [axes] = drawn("speeds").axes
    names = [text.get_text() for text in axes.texts if text.get_text().endswith(" s")]
    assert names == ["0 s", "100 s", "200 s", "300 s", "400 s", "412.47 s"]
    for rank, time in ((0, 0.0), (5, CONTACT_TIME)):
        _, velocities = oracle.solve(time, **(SEED | {"benches": 20}))
        handles, speeds = line(drawn("speeds"), f"speed-{rank}")
        assert handles.tolist() == list(range(224))
        np.testing.assert_allclose(speeds[:21], [float(mp.hypot(*velocity)) for velocity in velocities], atol=1e-9)


def test_drift_and_impulses_are_those_of_the_run() -> None:
    played, drawing = run(), drawn("drift")
    times, worst = line(drawing, "any-bench")
    for time, value in list(zip(times, worst, strict=True))[::20]:
        [frame] = np.flatnonzero(played.times == time)
        assert value == pytest.approx(1e6 * max(played.drift[frame]))
    assert times[-1] == played.times[-1]
    frame = np.flatnonzero(played.times == times[40])[0]
    assert line(drawing, "first-12-benches")[1][40] == pytest.approx(1e6 * max(played.drift[frame, :12]))
    _, last = line(drawing, "drift-0")
    assert any(np.allclose(last, 1e6 * row) for row in played.drift)
    levels = [part for part in drawing.findobj(matplotlib.lines.Line2D) if part.get_gid() == "smallest-gap"]
    assert {round(float(level.get_ydata()[0])) for level in levels} == {865}
    axes = drawn("impulses").axes[0]
    assert played.joint_impulses is not None
    for rank, name in enumerate(text.get_text() for text in axes.texts):
        frame = int(np.abs(played.times - float(name.removesuffix(" s"))).argmin())
        _, values = line(drawn("impulses"), f"impulse-{rank}")
        np.testing.assert_array_equal(values, played.joint_impulses[frame])
        assert played.times[frame] < played.times[-1]
    # The force is the impulse over a substep.
    [force] = axes.child_axes
    np.testing.assert_allclose(force.get_ylim(), np.array(axes.get_ylim()) / 0.02)


def test_pictures_of_the_dragon_are_large_and_only_the_collision_shows_a_contact(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)  # They need none.
    counts = {}
    for name in STILLS:
        write_figure(name, tmp_path / f"{name}.png")
        with Image.open(tmp_path / f"{name}.png") as picture:
            pixels = np.asarray(picture.convert("RGB"))
        parts = {part: np.all(pixels == Palette().rgb(part), axis=-1) for part in ("head", "body", "tail", "contact")}
        columns = np.flatnonzero((parts["body"] | parts["tail"] | parts["head"]).any(axis=0))
        assert columns[-1] - columns[0] > 0.8 * pixels.shape[1]
        counts[name] = {part: shown.sum() for part, shown in parts.items()}
    assert counts["outer-loop"]["contact"] == counts["inward"]["contact"] == 0
    # The head is 3.41 m long, bench 8 is 2.20 m, and 13 others of that length are blue, as far as they are in sight.
    shares = {part: count / counts["collision"]["body"] for part, count in counts["collision"].items()}
    assert shares["head"] == pytest.approx(3.41 / (13 * 2.20), rel=0.15)
    assert 2.20 / (13 * 2.20) < shares["contact"] < 3.41 / (13 * 2.20)


def texts_of(drawing: Any) -> list[tuple[Any, Any]]:
    """All texts that are drawn, with their boxes in pixels; those of annotations without leaders."""
    draw, seen = matplotlib.text.Text.draw, []

    def draw_and_note(text: Any, *arguments: Any, **options: Any) -> None:
        draw(text, *arguments, **options)
        if text.get_visible() and text.get_text().strip():
            seen.append((text, matplotlib.text.Text.get_window_extent(text)))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(matplotlib.text.Text, "draw", draw_and_note)
        drawing.draw_without_rendering()
    return seen


def check_texts(drawing: Any, border: int = 10) -> list[str]:
    """All texts are whole, large and clear of each other."""
    boxes, (width, height) = texts_of(drawing), drawing.canvas.get_width_height()
    for (one, first), (other, second) in combinations(boxes, 2):
        assert not first.overlaps(second), (one, other)
    for text, box in boxes:
        assert border < box.x0 < box.x1 < width - border, text
        assert border < box.y0 < box.y1 < height - border, text
        assert text.get_size() >= 72 * drawing.get_size_inches()[1] / 40
    return [text.get_text() for text, _ in boxes]


UNITS = {"spiral": "y (m)", "grid": "cells of 0.55 m", "trajectories": "412.47 s", "velocities": "m/s"}
UNITS |= {"gap": "mm", "speeds": "m/s", "drift": "\N{MICRO SIGN}m", "impulses": "N s"}


@pytest.mark.parametrize("name", CHARTS)
def test_texts_of_a_figure_are_large_do_not_overlap_and_tell_the_units(name: str) -> None:
    assert UNITS[name] in " ".join(check_texts(drawn(name)))


@pytest.mark.thorough
@pytest.mark.parametrize("name", [*CHARTS, *STUDIES])
def test_texts_of_studies_and_chinese_figures_do_not_overlap(name: str) -> None:
    if name in STUDIES:
        assert len(check_texts(drawn(name))) > 5
    units = {"m", "mm", "ms", "s", "N", "x", "y", "i", "j"}
    for text in check_texts(drawn(name, "zh")):
        letters = "".join(c if c.isascii() and c.isalpha() else " " for c in text)
        assert set(letters.split()) <= units, text


def test_matplotlib_and_pymunk_are_imported_when_they_are_needed_and_pyplot_never() -> None:
    program = """
import sys
import pymunk_dragon.drawing
from pymunk_dragon.drawing.figures import FIGURES, figure
assert "matplotlib" not in sys.modules and "pymunk" not in sys.modules
figure("speeds")
assert "matplotlib" in sys.modules and "matplotlib.pyplot" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", program], check=True)


def test_without_matplotlib_one_line_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    played = run()
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    for name in CHARTS:
        for call in (lambda: figure(name, played), lambda: write_figure(name, tmp_path / "x.png", played)):  # noqa: B023  # Called within the loop.
            with pytest.raises(MissingExtraError) as error:
                call()
            assert_says(error.value, "pip install 'pymunk-dragon[figures]'")
    assert list(tmp_path.iterdir()) == []


def test_figures_that_cannot_be_drawn_are_refused(tmp_path: Path) -> None:
    exact = Run.exact(model(), [0.0, 1.0])
    cases: list[tuple[str, str, Any, str]] = [
        ("spirals", "x.png", None, "figure"),
        ("spiral", "x.gif", None, "output"),
        ("collision", "x.svg", None, "output"),
        ("spiral", "no/such/x.png", None, "output"),
        ("spiral", "x.png", "march", "source"),
        ("spiral", "x.png", TRACTOR, "curve"),
        ("trajectories", "x.png", U_TURN, "march"),  # without end
        ("drift", "x.png", None, "run"),
        ("impulses", "x.svg", March(), "run"),
        ("drift", "x.png", exact, "run"),
        ("impulses", "x.png", exact, "run"),
        ("collision", "x.png", March(Dragon(benches=3), turns=3), "march"),  # never touches itself
        ("gap", "x.png", March(Dragon(benches=2)), "benches"),
        ("gap", "x.png", March(Dragon(benches=40), turns=3.9), "march"),  # overlaps at the start
    ]
    for name, file, source, parameter in cases:
        with pytest.raises(ParameterError) as error:
            write_figure(name, tmp_path / file, source)
        assert error.value.name == parameter, (name, file)
        assert_says(error.value)
        assert list(tmp_path.iterdir()) == []
    for name in STILLS:
        with pytest.raises(ParameterError, match="write_figure"):
            figure(name)


@pytest.mark.thorough
@pytest.mark.parametrize("source", OTHERS.values(), ids=OTHERS)
def test_other_curves_have_figures_whose_labels_do_not_overlap(source: Any, tmp_path: Path) -> None:
    for name in ("outer-loop", "inward"):
        write_figure(name, tmp_path / "still.png", source)
    for name in ("grid", "trajectories", "velocities", "gap", "speeds"):
        told = " ".join(check_texts(figure(name, source), border=5))
        assert not any(word in told for word in ("spiral", "coil", "inward"))


def test_endless_curve_is_looked_at_for_as_long_as_a_run() -> None:
    way = artist(figure("trajectories", OTHERS["u-turn"]), "path-0").get_xydata()
    np.testing.assert_allclose(way[[0, -1]], U_TURN.at([-20, 20]).positions[:, 0], atol=1e-9)
    [axes] = figure("speeds", OTHERS["u-turn"]).axes
    assert [text.get_text() for text in axes.texts][:2] == ["\N{MINUS SIGN}20 s", "\N{MINUS SIGN}10 s"]
