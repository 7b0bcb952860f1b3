"""What a picture says: legend, scale bar, contact, near misses, the turning circle and position errors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from pymunk_dragon import Camera, Contact, Dragon, March, Palette, Run, UTurn, first_contact
from pymunk_dragon._language import in_language
from pymunk_dragon.drawing import Film, render, still
from pymunk_dragon.drawing.film.layout import lay_out, sampled
from pymunk_dragon.drawing.lettering import Lettering
from pymunk_dragon.drawing.palette import BLOCK
from pymunk_dragon.drawing.scene import RING_RADIUS

PALETTE = Palette()
SMALL = March(Dragon(benches=16), turns=4)
HEAD = Camera(follow="head")
# The reference march at its contact.
TIMES = np.append(np.arange(405.0, 412.4, 0.2), 412.473838)


@pytest.fixture(scope="module")
def reference():
    run = Run.exact(March(), TIMES)
    hit = first_contact(run.march, start=405).contact
    return replace(run, first_contact=replace(hit, time=TIMES[-1]), outcome="contact")


@pytest.fixture(scope="module")
def displaced():
    """A run whose benches are up to 20 um behind those of the exact model."""
    run = Run.exact(SMALL, np.linspace(0, 10, 101))
    poses = run.poses.copy()
    poses[..., 0] += np.linspace(0, 20e-6, 16)
    return replace(run, poses=poses, provenance={"player": "pymunk", "guide": "rails"})


@pytest.fixture
def texts(monkeypatch):
    """Lines that are written into pictures."""
    written = []
    line = Lettering.line
    monkeypatch.setattr(Lettering, "line", lambda self, text: written.append(text) or line(self, text))
    return written


def pixels(picture, name):
    """How many pixels of a picture have a colour of the palette."""
    return int(np.all(picture == np.rint(PALETTE.rgb(name)), axis=-1).sum())


def view_of(sources, time, film):
    """The first scene's function from points of the ground to pixels."""
    [clip, *_] = clips = sampled(sources, np.array([time]), film)
    scene = lay_out(clips, film).scenes[0]
    view = scene.view(next(clip.snapshots).poses)
    return lambda points: view.pixels(points) / BLOCK


# Legend and scale bar


def test_legend_names_the_colours(reference, texts):
    still(reference, TIMES[-1], Film(size=400))
    assert {"head", "body", "tail", "in contact", "2 m", "head 1.00 m/s"} <= set(texts)


def test_legend_has_no_contact_where_there_is_none(texts):
    still(SMALL, 1.0, Film(size=400))
    assert "tail" in texts
    assert "in contact" not in texts


def test_legend_is_below_the_picture():
    film = Film(size=400)
    with_legend, without = still(SMALL, 1.0, film), still(SMALL, 1.0, replace(film, legend=False))
    assert without.shape == (400, 400, 3)
    np.testing.assert_array_equal(with_legend[:400], without)
    for name in ("head", "body", "tail"):
        assert pixels(with_legend[400:], name) > 50


def test_legend_is_left_out_of_narrow_pictures():
    assert still(SMALL, 1.0, Film(size=200)).shape == (200, 200, 3)


@pytest.mark.parametrize(("camera", "metres"), [(Camera(span=24.0), 2), (Camera(follow="head", span=6.0), 1)])
def test_scale_bar_is_as_long_as_it_says(camera, metres, texts):
    picture = still(SMALL, 1.0, Film(size=480, camera=camera))
    assert f"{metres:g} m" in texts
    strip = np.all(picture[480:] == np.rint(PALETTE.rgb("ink")), axis=-1)
    # The longest horizontal line of the strip, with its ends.
    longest = max(len(run) for row in strip for run in "".join(" x"[int(pixel)] for pixel in row).split())
    assert longest - 1 == round(metres * 480 / camera.span)


def test_legend_of_two_runs_is_drawn_once(reference, texts):
    still([reference, reference], TIMES[-1], Film(size=330))
    assert texts.count("tail") == 1


# Contact and near misses


def test_contact_names_both_benches(reference, texts):
    still(reference, TIMES[-1], Film())
    assert "contact: benches 0 and 8" in texts


def test_head_in_contact_has_a_border_if_it_is_wide_enough(reference):
    for camera, border in ((HEAD, True), (Camera(), False)):
        film = Film(size=400, camera=camera, legend=False)
        picture = still(reference, TIMES[-1], film)
        head = reference.march.dragon.outlines(reference.poses_at([TIMES[-1]])[0])[0]
        corners = view_of([reference], TIMES[-1], film)(head)
        # From the middle of a long side inwards.
        edge, middle = corners[[0, 1]].mean(axis=0), corners.mean(axis=0)
        if np.linalg.norm(corners[0] - corners[1]) < np.linalg.norm(corners[1] - corners[2]):
            edge = corners[[1, 2]].mean(axis=0)
        step = (middle - edge) / np.linalg.norm(middle - edge)
        x, y = np.floor(edge + 2 * step).astype(int)
        near_edge = picture[y - 1 : y + 2, x - 1 : x + 2]
        assert (pixels(near_edge, "contact") > 0) is border
        x, y = np.floor(middle).astype(int)
        np.testing.assert_array_equal(picture[y, x], PALETTE.rgb("head"))


@pytest.mark.parametrize(("time", "gap"), [(406.8466, "gap 3.0 mm to bench 9"), (409.8320, "gap 0.9 mm to bench 11")])
def test_near_miss_has_a_ring_and_its_gap(reference, time, gap, texts):
    run = replace(reference, first_contact=None)
    picture = still(run, time, Film(size=440, legend=False))
    assert gap in texts
    plain = still(run, time, Film(size=440, legend=False, gap=False))
    rows, columns = np.nonzero(np.any(picture[:400] != plain[:400], axis=-1))
    assert np.ptp(rows) == pytest.approx(2 * RING_RADIUS, abs=2)
    assert np.ptp(columns) == pytest.approx(2 * RING_RADIUS, abs=2)


def test_wider_gaps_are_displayed_if_the_camera_follows_the_head(texts):
    still(March(), 350.0, Film())
    assert not any(line.startswith("gap") for line in texts)
    still(March(), 350.0, Film(camera=HEAD))
    assert any(line.startswith("gap") for line in texts)


def test_start_that_the_film_has_chosen_is_displayed(tmp_path, texts):
    march = March(Dragon(benches=3), turns=16)
    render(march, tmp_path / "film.gif", until=300, size=200)
    assert any(line.startswith("from t = ") for line in texts)
    texts.clear()
    render(march, tmp_path / "film.gif", start=250, until=300, size=200)
    assert not any(line.startswith("from t = ") for line in texts)


# The turning circle


def test_turning_circle_is_drawn_and_named(texts):
    march = March(Dragon(benches=16), UTurn())
    film = Film(size=600, gap=False, camera=Camera(span=15.0))
    picture = still(march, 0.0, film)
    place = view_of([march], 0.0, film)
    assert "turning circle" in texts
    angles = np.linspace(0, 2 * np.pi, 720, endpoint=False)
    columns, rows = np.floor(place(4.5 * np.stack([np.cos(angles), np.sin(angles)], axis=-1))).astype(int).T
    ground = np.rint(PALETTE.rgb("background"))
    drawn = [np.any(picture[y - 1 : y + 2, x - 1 : x + 2] != ground) for x, y in zip(columns, rows, strict=True)]
    # Dashed.
    assert 0.5 < np.mean(drawn) < 1


def test_spiral_has_no_turning_circle(texts):
    still(SMALL, 0.0, Film(size=600))
    assert "turning circle" not in texts


# Position errors


@pytest.mark.parametrize(("camera", "factor"), [(Camera(), "80,000"), (HEAD, "20,000")])
def test_exact_model_beside_a_run_shows_the_position_errors(displaced, camera, factor, texts):
    film = Film(size=300, camera=camera, gap=False)
    picture = still([displaced, displaced.march], 5.0, film)
    assert f"position error x {factor}" in texts
    assert any(line.startswith("position error up to 0.0") for line in texts)
    scenes = picture[: picture.shape[0] - 40]
    assert pixels(scenes[:, :300], "motion") == 0
    assert pixels(scenes[:, 302:], "motion") > 100


def test_position_error_is_that_of_the_run(displaced, texts):
    still([displaced, displaced.march], 5.0, Film(size=300))
    assert "position error up to 0.0200 mm" in texts


def test_exact_run_beside_its_march_has_no_errors(texts):
    run = Run.exact(SMALL, np.linspace(0, 10, 101))
    still([run, run.march], 5.0, Film(size=300))
    assert not any(line.startswith("position error") for line in texts)


def test_exact_model_beside_a_run_shows_its_own_contact(reference, texts):
    run = replace(reference, provenance={"player": "pymunk", "guide": "rails"})
    picture = still([run, run.march], TIMES[-1], Film(size=400, legend=False))
    assert texts.count("contact: benches 0 and 8") >= 2
    assert pixels(picture[:, 402:], "contact") > 20


def test_film_of_a_march_shows_its_contact(tmp_path, texts):
    march = March(Dragon(benches=16))
    render(march, tmp_path / "film.gif", start=412, until=first_contact(march, start=411).time, size=200)
    assert "contact: benches 0 and 8" in texts


def test_march_alone_has_no_errors(texts):
    still(SMALL, 5.0, Film(size=300))
    assert not any(line.startswith("position error") for line in texts)


# Chinese


def test_films_speak_chinese(reference, texts):
    with in_language("zh"):
        still(reference, TIMES[-1], Film(size=400))
    assert {"龙头", "龙身", "龙尾", "碰撞：板凳 0 与 8", "龙头 1.00 m/s"} <= set(texts)


def test_chinese_films_have_titles_without_another_font(reference):
    with in_language("zh"):
        picture = still(reference, TIMES[-1], Film(size=200, title="板凳龙"))
    assert picture.shape[0] > 200


def test_processes_that_draw_a_film_know_the_language(tmp_path):
    march = March(Dragon(benches=3), turns=16)
    with in_language("zh"):
        for workers in (0, 2):
            render(march, tmp_path / f"{workers}.gif", until=300, size=64, workers=workers)
    assert (tmp_path / "0.gif").read_bytes() == (tmp_path / "2.gif").read_bytes()
    with Image.open(tmp_path / "0.gif") as film:
        assert film.n_frames >= 150


def test_contact_of_other_benches_leaves_the_head_as_it_is():
    run = Run.exact(SMALL, np.linspace(0, 10, 101))
    contact = Contact(time=5.0, raw_time=5.0, benches=(1, 9), point=(1.0, 1.0), normal=(0.0, 1.0), depth=0.0)
    film = Film(size=400, camera=HEAD, legend=False, gap=False)
    before, after = still(run, 5.0, film), still(replace(run, first_contact=contact), 5.0, film)
    assert pixels(before, "head") == pytest.approx(pixels(after, "head"), abs=40)
    assert pixels(after, "contact") > 100
