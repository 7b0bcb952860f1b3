"""Figures: what they draw is true, can be read, and comes out the same again."""

import re
import sys
from dataclasses import replace
from functools import cache
from itertools import combinations

import matplotlib.text
import numpy as np
import pytest
import shapely
from conftest import assert_says, refusal
from marches import ARM, TRACTOR, U_TURN
from matplotlib.colors import to_hex
from PIL import Image
from PIL.ImageColor import getrgb
from sharing import shared_run

from pymunk_dragon import (
    Dragon,
    March,
    NearMiss,
    Run,
    first_contact,
    max_speed,
    min_pitch,
    simulate,
    u_turn,
)
from pymunk_dragon._language import in_language
from pymunk_dragon.drawing.figures import FIGURES, figure, style, write_figure
from pymunk_dragon.drawing.palette import Palette

CHARTS = [name for name, kind in FIGURES.items() if not kind.still]
# Portrait pages, as wide as what they show.
PLANS = ["grid", "spiral", "trajectories", "velocities"]
STILLS = [name for name in FIGURES if name not in CHARTS]
MODEL = March(Dragon(benches=16))
# s: the paper's first contact.
CONTACT_TIME = 412.473837682
HANDLES = [0, 1, 51, 101, 151, 201, 223]
OTHERS = {"u-turn": Run.exact(U_TURN, np.linspace(-20, 20, 5)), "tractor": TRACTOR, "arm": ARM}


@cache
def run():
    """The last seconds before the paper's contact, as the engine plays them: quick, and rough."""
    return shared_run(
        "rough", lambda: simulate(March(Dragon(benches=40)), start=400, substep=0.02, iterations=15)
    )


def source_of(name):
    return run() if name in ("drift", "forces") else None


@cache
def drawn(name, lang="en"):
    with in_language(lang):
        return figure(name, source_of(name))


def artist(drawing, gid):
    return drawing.findobj(lambda part: part.get_gid() == gid)[0]


def line(drawing, gid):
    return np.asarray(artist(drawing, gid).get_xydata(), dtype=float).T


def words(drawing):
    return "\n".join(text.get_text() for text in drawing.findobj(matplotlib.text.Text))


@pytest.mark.parametrize(
    "name",
    [
        "grid",
        *(pytest.param(name, marks=pytest.mark.thorough) for name in FIGURES if name != "grid"),
    ],
)
def test_figure_has_the_same_bytes_in_each_format_whatever_the_settings(name, tmp_path):
    width = 1120 if name in PLANS else 1600 if name in CHARTS else 880
    for ending in (".png", ".svg", ".pdf") if name in CHARTS else (".png",):
        file, again = tmp_path / f"{name}{ending}", tmp_path / f"again{ending}"
        write_figure(name, file, source_of(name))
        content = file.read_bytes()
        assert len(content) < 400_000
        if ending == ".png":
            with Image.open(file) as picture:
                assert picture.width == width
            continue
        # Neither text that needs a font, nor a date.
        assert not any(part in content for part in (b"<text", b"<dc:date>", b"/CreationDate"))
        with matplotlib.rc_context({"font.size": 30, "axes.labelpad": 30, "svg.fonttype": "none"}):
            write_figure(name, again, source_of(name))
            assert matplotlib.rcParams["font.size"] == 30
        assert again.read_bytes() == content


def test_spiral_is_that_of_the_paper_with_a_dot_each_minute():
    walked, ahead, dots = (line(drawn("spiral"), name).T for name in ("walked", "ahead", "minutes"))
    for way in (walked, ahead):
        radius = np.hypot(*way.T)
        angle = radius * 2 * np.pi / 0.55
        np.testing.assert_allclose(
            way.T, radius * np.stack([np.cos(angle), np.sin(angle)]), atol=1e-9
        )
    np.testing.assert_allclose(walked[[0, -1]], [(8.8, 0), ahead[0]], atol=1e-9)
    np.testing.assert_allclose(ahead[-1], 0, atol=1e-3)
    # A chord of the drawn line is a little shorter than the arc.
    assert np.hypot(*np.diff(walked, axis=0).T).sum() == pytest.approx(CONTACT_TIME, rel=1e-4)
    np.testing.assert_allclose(dots, March().at(60.0 * np.arange(7)).positions[:, 0], atol=1e-9)


def test_handles_end_where_the_contact_stops_them_with_the_velocities_of_the_exact_model():
    states = March().at(CONTACT_TIME)
    places, velocities = states.positions[0, HANDLES], states.velocities[0, HANDLES]
    for handle, place in zip(HANDLES, places, strict=True):
        np.testing.assert_allclose(
            line(drawn("trajectories"), f"path-{handle}")[:, -1], place, atol=1e-8
        )
    # An endless curve is shown for as long as a run.
    way = line(figure("trajectories", OTHERS["u-turn"]), "path-0").T
    np.testing.assert_allclose(way[[0, -1]], U_TURN.at([-20, 20]).positions[:, 0], atol=1e-9)
    arrows = artist(drawn("velocities"), "velocities")
    tips = np.column_stack([arrows.U, arrows.V])
    np.testing.assert_allclose(
        tips / np.hypot(*tips[0]), velocities / np.hypot(*velocities[0]), atol=1e-7
    )
    np.testing.assert_allclose(arrows.XY, places, atol=1e-8)
    for handle, speed in zip(HANDLES, np.hypot(*velocities.T), strict=True):
        assert f"handle {handle}: {speed:.3f} m/s" in words(drawn("velocities"))


def test_cells_of_the_grid_are_shaded_as_shapely_finds_benches_in_them():
    drawing, corners = drawn("grid"), MODEL.dragon.outlines(MODEL.at(CONTACT_TIME).poses[0])
    # The axes are column and row, with the indices at the middle of cells, from the paper's origin.
    outlines = [shapely.Polygon((each - (-8.8, 8.8)) / (0.55, -0.55) - 0.5) for each in corners]
    mesh, candidates = artist(drawing, "cells"), set()
    shown, (column, row) = np.asarray(mesh.get_array()), mesh.get_coordinates()[0, 0] + 0.5
    for i, j in np.ndindex(shown.shape):
        cell = shapely.box(column + j - 0.5, row + i - 0.5, column + j + 0.5, row + i + 0.5)
        benches = [bench for bench, outline in enumerate(outlines) if outline.intersects(cell)]
        apart = {(one, other) for one, other in combinations(benches, 2) if other - one > 1}
        assert shown[i, j] == (3 if apart else min(len(benches), 2)), (i, j, benches)
        candidates |= apart
    assert (
        drawing.texts[0]
        .get_text()
        .startswith(f"{len(candidates)} of 105 pairs of benches share a cell")
    )
    for bench, outline in enumerate(outlines):
        patch = artist(drawing, f"bench-{bench}")
        np.testing.assert_allclose(patch.get_xy(), outline.exterior.coords, atol=1e-8)
        assert (to_hex(patch.get_edgecolor()) == Palette().contact) == (bench in (0, 8))


def test_gaps_are_those_of_shapely_and_smallest_where_the_exact_model_says():
    march, drawing = March(), drawn("gap")
    times, gaps = line(drawing, "gap")
    for time, gap in ((406.847, 2.957), (409.832, 0.865)):
        assert 1e3 * gaps[np.abs(times - time) < 1].min() == pytest.approx(gap, abs=5e-4)
    # At the contact there is no gap, and the line leaves the scale.
    assert times[-1] == pytest.approx(CONTACT_TIME, abs=1e-9)
    assert gaps[-1] < artist(drawing, "gap").axes.get_ylim()[0] / 5
    labels = (
        "bench 9: 2.957 mm\nat 406.847 s",
        "bench 11: 0.865 mm\nat 409.832 s",
        "contact\nat 412.4738 s",
    )
    assert all(label in words(drawing) for label in labels)
    for name, benches in (
        ("gap", range(2, 223)),
        *((f"gap-{bench}", [bench]) for bench in (8, 9, 10, 11)),
    ):
        for time, gap in line(drawing, name).T[:-1:200]:
            head, *others = map(shapely.Polygon, march.dragon.outlines(march.at(time).poses[0]))
            assert gap == pytest.approx(
                min(head.distance(others[bench - 1]) for bench in benches), abs=1e-10
            )


def test_speeds_are_those_of_the_exact_model_at_the_times_beside_their_lines():
    [axes] = drawn("speeds").axes
    names = [each.get_label() for each in axes.get_lines()]
    assert names == ["0 s", "100 s", "200 s", "300 s", "400 s", "412.47 s"]
    assert names == [text.get_text() for text in axes.get_legend().get_texts()]
    expected = March().at([0, 100, 200, 300, 400, CONTACT_TIME]).speeds
    np.testing.assert_allclose([each.get_ydata() for each in axes.get_lines()], expected, atol=1e-9)


def test_drift_and_forces_are_those_of_the_run():
    played, drawing = run(), drawn("drift")
    for name, count in (("any-bench", 40), ("first-benches", 12)):
        times, worst = line(drawing, name)
        frames = np.searchsorted(played.times, times)
        np.testing.assert_allclose(worst, played.drift[frames, :count].max(axis=1))
        assert times[-1] == played.times[-1]
    assert round(1e6 * line(drawing, "smallest-gap")[1][0]) == 865
    assert played.joint_forces is not None
    drawing = drawn("forces")
    lines = [each for each in drawing.axes[0].get_lines() if each.get_gid().startswith("force")]
    for rank, each in enumerate(lines):
        frame = int(np.abs(played.times - float(each.get_label().removesuffix(" s"))).argmin())
        forces = line(drawing, f"force-{rank}")[1]
        np.testing.assert_allclose(forces, played.joint_forces[frame])
        # The run is rough.
        exact = line(drawing, f"exact-{rank}")[1]
        np.testing.assert_allclose(exact, forces, atol=0.01 * forces.max())


def test_forces_of_a_pulled_dragon_are_drawn_beside_the_exact_ones():
    pulled = simulate(March(Dragon(benches=40)), guide="none", until=3.0)
    drawing = figure("forces", pulled)
    for rank in range(2):
        forces = line(drawing, f"force-{rank + 1}")[1]
        exact = line(drawing, f"exact-{rank + 1}")[1]
        np.testing.assert_allclose(exact, forces, atol=0.01 * forces.max())


def test_error_of_the_engine_falls_as_the_order_of_its_method():
    for order in (1, 2):
        substeps, errors = line(drawn("order"), f"order-{order}")
        slopes = np.diff(np.log(errors)) / np.diff(np.log(substeps))
        assert order - 0.1 < slopes.min()
        assert slopes.max() < order + 0.5


def test_drift_shows_a_smallest_gap_of_0(monkeypatch):
    touching = NearMiss(time=run().times[-1], benches=(0, 2), gap=0.0)
    result = replace(first_contact(run().march), near_misses=(touching,))
    monkeypatch.setattr(style, "first_contact", lambda march, **window: result)
    assert artist(figure("drift", run()), "smallest-gap").get_label() == "smallest gap: 0.0 m"


def test_only_the_picture_of_the_collision_shows_a_contact(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)  # They need none.
    counts = {}
    for name in STILLS:
        write_figure(name, tmp_path / f"{name}.png")
        with Image.open(tmp_path / f"{name}.png") as picture:
            pixels = np.asarray(picture.convert("RGB"))
        counts[name] = [
            np.all(pixels == getrgb(getattr(Palette(), part)), axis=-1).sum()
            for part in ("body", "contact")
        ]
    assert counts["outer-loop"][1] == counts["inward"][1] == 0
    # Bench 8 is as long as 13 others, which are blue as far as they are in sight.
    assert counts["collision"][1] > counts["collision"][0] / 13 > 0


def check_texts(drawing, border=10):
    """All texts of a figure, which are within the page, large, and clear of each other."""
    draw, seen = matplotlib.text.Text.draw, []

    def draw_and_note(text, *arguments, **options):
        draw(text, *arguments, **options)
        if text.get_visible() and text.get_text().strip():
            # Of an annotation without its leader.
            seen.append((text, matplotlib.text.Text.get_window_extent(text)))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(matplotlib.text.Text, "draw", draw_and_note)
        drawing.draw_without_rendering()
    width, height = drawing.canvas.get_width_height()
    for (one, first), (other, second) in combinations(seen, 2):
        assert not first.overlaps(second), (one, other)
    for text, box in seen:
        assert border < box.x0 < box.x1 < width - border, text
        assert border < box.y0 < box.y1 < height - border, text
        assert text.get_size() >= 8, text  # points, on a slide of 4.5 inches
    return [text.get_text() for text, _ in seen]


UNITS = {
    "spiral": "y (m)",
    "grid": "cells of 0.55 m",
    "trajectories": "412.47 s",
    "velocities": "m/s",
}
UNITS |= {"gap": "mm", "speeds": "m/s", "drift": "\N{MICRO SIGN}m", "forces": "N", "order": "ms"}


@pytest.mark.parametrize("lang", ["en", pytest.param("zh", marks=pytest.mark.thorough)])
@pytest.mark.parametrize("name", CHARTS)
def test_texts_of_a_figure_are_large_do_not_overlap_and_tell_the_units(name, lang):
    shown = " ".join(check_texts(drawn(name, lang)))
    english = set(re.findall("[A-Za-z]+", shown))
    assert (
        UNITS[name] in shown
        if lang == "en"
        else english <= {"m", "mm", "nm", "ms", "s", "N", "x", "y", "i", "j"}
    )


@pytest.mark.thorough
def test_texts_of_other_figures_do_not_overlap(tmp_path):
    for found in (
        min_pitch(),
        min_pitch(radius=8.0),
        max_speed(),
        u_turn(Dragon(benches=25), search=False),
    ):
        for lang in ("en", "zh"):
            with in_language(lang):
                assert len(check_texts(found.plot())) > 5
    for source in OTHERS.values():
        for name in ("outer-loop", "inward"):
            write_figure(name, tmp_path / "still.png", source)
        for name in ("grid", "trajectories", "velocities", "gap", "speeds"):
            told = " ".join(check_texts(figure(name, source), border=5))
            assert not any(word in told for word in ("spiral", "coil", "inward"))


def test_figures_that_cannot_be_drawn_are_refused(tmp_path):
    exact = Run.exact(MODEL, [0.0, 1.0])
    cases = [
        ("spirals", "x.png", None, "figure"),
        ("collision", "x.svg", None, "output"),
        ("spiral", "x.png", "march", "source"),
        ("spiral", "x.png", TRACTOR, "curve"),
        ("trajectories", "x.png", U_TURN, "march"),  # without end
        ("drift", "x.png", None, "run"),
        ("drift", "x.png", exact, "run"),
        ("collision", "x.png", March(Dragon(benches=3), turns=3), "march"),  # never touches itself
        ("gap", "x.png", March(Dragon(benches=2)), "benches"),
        ("gap", "x.png", March(Dragon(benches=40), turns=3.9), "march"),  # overlaps at the start
    ]
    for name, file, source, parameter in cases:
        assert refusal(write_figure, name, tmp_path / file, source).name == parameter, (name, file)
    for name in STILLS:
        assert_says(refusal(figure, name), "write_figure")
    assert list(tmp_path.iterdir()) == []
