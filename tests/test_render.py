"""Pictures of the dragon: colours, sizes, texts, marks, and other marches than the paper's."""

from dataclasses import replace

import imageio.v3 as iio
import numpy as np
import pytest
from conftest import refusal
from marches import ARM, TRACTOR
from PIL import Image

from pymunk_dragon import Camera, Dragon, Film, March, Run, UTurn, first_contact, render
from pymunk_dragon._language import in_language
from pymunk_dragon.drawing import lettering, still
from pymunk_dragon.drawing.film.layout import Canvas
from pymunk_dragon.drawing.overlay import impulses, touches, velocities
from pymunk_dragon.drawing.palette import BLOCK, COLOURS, colour_table
from pymunk_dragon.drawing.scene import smallest_gap
from pymunk_dragon.drawing.sources import states

SMALL = March(Dragon(benches=16), turns=4)
# The paper's first contact, as every solver of the project finds it.
CONTACT_TIME = 412.473838


@pytest.fixture(scope="module")
def run():
    return Run.exact(SMALL, np.linspace(0, 10, 1001))


@pytest.fixture(scope="module")
def seed():
    """The last seconds of the paper's march, with its contact."""
    run = Run.exact(March(), np.append(np.arange(405.0, 412.4, 0.2), CONTACT_TIME))
    hit = first_contact(run.march, start=405).contact
    return replace(run, first_contact=replace(hit, time=CONTACT_TIME), outcome="contact")


@pytest.fixture
def texts(monkeypatch):
    """Lines that are written into pictures."""
    written = []
    line = lettering.line
    monkeypatch.setattr(lettering, "line", lambda text, height: written.append(text) or line(text, height))
    return written


def displaced(run):
    """A run with position errors that grow towards the tail."""
    poses = run.poses.copy()
    poses[..., 0] += np.linspace(0, 20e-6, poses.shape[1])
    drift = np.abs(poses[..., 0] - run.poses[..., 0])
    return replace(run, poses=poses, drift=drift, provenance={"player": "pymunk", "guide": "rails"})


def shown(source, time, film):
    """A picture, and where points of the ground lie on it."""
    [scene], [state] = Canvas([source], np.array([time]), film).scenes, states(source, np.array([time]))
    layer = scene.layer(*state)
    return still(source, time, film), lambda points: layer.pixels(points) / BLOCK


def colour_at(picture, xy):
    x, y = (int(v) for v in xy)
    return "#" + bytes(picture[y, x].tolist()).hex()


def count(picture, name):
    """How many pixels of a picture have a colour of the palette."""
    return int(np.all(picture == np.rint(COLOURS.rgb(name)), axis=-1).sum())


def near(picture, xy, size=1):
    """Pixels at `xy` and beside it."""
    x, y = (int(v) for v in xy)
    return picture[max(y - size, 0) : y + size + 1, max(x - size, 0) : x + size + 1]


def test_table_of_films_has_every_colour_of_pictures(seed):
    assert len(colour_table()) <= 255
    table = colour_table().astype(int)
    for camera in (Camera(), Camera(follow="head")):
        pixels = still(seed, CONTACT_TIME, Film(camera=camera)).reshape(-1, 3)
        colours, counts = np.unique(pixels, axis=0, return_counts=True)
        off = np.abs(colours[:, None] - table).max(axis=-1).min(axis=-1)
        # But for rare mixtures of three colours.
        assert (off.max() <= 32, counts[off > 16].sum() < len(pixels) / 1000) == (True, True)


def test_no_two_bench_colours_look_alike_to_anyone_or_in_grey():
    # Machado, Oliveira and Fernandes 2009, severity 1, on linear light.
    visions = {
        "normal": np.eye(3),
        "deuteranope": np.array([[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]]),
        "protanope": np.array([[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]]),
    }
    colours = np.array([COLOURS.rgb(name) for name in ("head", "body", "tail", "contact", "background")])
    for vision, matrix in visions.items():
        seen = 255 * np.clip((colours / 255) ** 2.2 @ matrix.T, 0, 1) ** (1 / 2.2)
        distances = np.linalg.norm(seen[:, None] - seen[None], axis=-1)[np.triu_indices(len(seen), 1)]
        assert distances.min() > 60, vision
    assert np.diff(np.sort(colours @ (0.299, 0.587, 0.114))).min() > 255 / 7


def test_bad_cameras_marks_and_times_are_refused(run, tmp_path):
    cases = [(name, Camera, {name: value}) for name, value in [("span", 0), ("span", float("inf")), ("follow", "tail")]]
    cases += [("time", still, {"source": run, "time": 11.0})]
    cases += [("until", render, {"source": run, "until": 11.0, "path": tmp_path / "still.png"})]
    for mark in ("contacts", "normals", "impulses"):
        cases += [("show", still, {"source": SMALL, "time": 1.0, "film": Film(show=(mark,))})]
    for name, call, arguments in cases:
        assert refusal(call, **arguments).name == name
    render(run, tmp_path / "still.png", size=120, until=4.0)
    np.testing.assert_array_equal(iio.imread(tmp_path / "still.png"), still(run, 4.0, Film(size=120)))


def test_camera_stays_above_the_head_or_shows_every_bench(run):
    for time in (0.0, 3.3, 10.0):
        picture, _ = shown(run, time, Film(size=200, camera=Camera(follow="head")))
        assert colour_at(picture, (100, 100)) == COLOURS.head
        _, place = shown(run, time, Film(size=(300, 200)))
        corners = place(SMALL.dragon.outlines(run.poses_at([time])[0])).reshape(-1, 2)
        assert np.all((corners > 0) & (corners < (300, 200)))
    for march, metres in ((SMALL, 6.0), (TRACTOR, 36.0), (ARM, 1.0)):
        _, place = shown(march, 0.5, Film(size=600, camera=Camera(follow="head")))
        (x0, _), (x1, _) = place([(0.0, 0.0), (1.0, 0.0)])
        assert 600 / (x1 - x0) == pytest.approx(metres)


def test_legend_and_scale_bar_are_below_the_picture(texts):
    film = Film(size=480, camera=Camera(follow="head", span=6.0))
    with_legend, without = still(SMALL, 1.0, film), still(SMALL, 1.0, replace(film, legend=False))
    assert without.shape == still(SMALL, 1.0, Film(size=480, legend=False)).shape == (480, 480, 3)
    np.testing.assert_array_equal(with_legend[:480], without)
    assert all(count(with_legend[480:], name) > 50 for name in ("head", "body", "tail"))
    assert {"head", "body", "tail", "1 m", "head 1.00 m/s"} <= set(texts)
    assert not {"in contact", "turning circle"} & set(texts)
    # The longest horizontal line of the strip, with its ends, is as long as it says.
    strip = np.all(with_legend[480:] == np.rint(COLOURS.rgb("ink")), axis=-1)
    longest = max(len(run) for row in strip for run in "".join(" x"[int(pixel)] for pixel in row).split())
    assert longest - 1 == round(480 / 6.0)
    assert still(SMALL, 1.0, Film(size=200)).shape == (200, 200, 3)  # too narrow for a legend


def test_contact_and_near_misses_are_named(seed, texts):
    still(seed, CONTACT_TIME, Film(size=400))
    assert {"in contact", "contact: benches 0 and 8"} <= set(texts)
    run = replace(seed, first_contact=None)
    for time, bench, gap in ((406.8466, 9, 3.0), (409.8320, 11, 0.9)):
        found = smallest_gap(seed.march.dragon, seed.march.at(time).poses[0])
        assert (found[0], found[1]) == (bench, pytest.approx(gap / 1000, abs=5e-5))
        still(run, time, Film(size=440, legend=False))
        assert f"gap {gap} mm to bench {bench}" in texts


def test_exact_model_beside_a_run_shows_the_position_errors_of_the_run(run, texts):
    for camera, factor in ((Camera(), "80,000"), (Camera(follow="head"), "20,000")):
        picture = still([displaced(run), SMALL], 5.0, Film(size=300, camera=camera))
        assert f"position error x {factor}" in texts
        assert count(picture[:260, :300], "motion") == 0
        assert count(picture[:260, 302:], "motion") > 100


def test_velocities_of_a_run_are_those_of_its_march(run):
    [state] = states(run, np.array([4.321]))
    np.testing.assert_allclose(velocities(run, *state), SMALL.at([4.321]).velocities[0], atol=2e-3)


def test_pictures_look_as_they_did(seed, golden):
    films = {
        "field": (seed, Film(size=330, show=("velocities", "grid"))),
        "contact": (seed, Film(size=330, camera=Camera(follow="head"), show=("grid", "contacts", "normals"))),
        "u-turn": (March(Dragon(benches=40), UTurn()), Film(size=(330, 200), title="A turn", camera=Camera(span=20.0))),
    }
    for name, (source, film) in films.items():
        time = CONTACT_TIME if source is seed else 20.0
        golden(Image.fromarray(still(source, time, film)), f"films/{name}")
    with in_language("zh"):
        film = Film(size=330, camera=Camera(follow="head"), title="\u677f\u51f3\u9f99")
        golden(Image.fromarray(still([displaced(seed), seed.march], 410.0, film)), "films/errors")


def test_contacts_are_shown_while_benches_touch(seed, small_run):
    assert touches(seed, CONTACT_TIME) == [([seed.first_contact.point], seed.first_contact.normal)]
    [window] = [window for window in small_run.events.windows() if window.end is not None]
    assert touches(small_run, (window.begin + window.end) / 2)
    assert not touches(small_run, window.begin - 0.05)


def test_area_of_a_disc_is_in_proportion_to_the_impulse_of_the_frame_before(run):
    sizes = np.full((len(run.times), 15), 1.0)
    sizes[:, 0] = 4.0
    film = Film(size=1200, camera=Camera(follow="head", span=8.0), show=("impulses",))
    picture, place = shown(replace(run, joint_impulses=sizes), 5.0, film)
    _, rear = SMALL.dragon.holes(run.poses_at([5.0])[0])
    areas = [count(near(picture, xy, 40), "force") for xy in place(rear[:2])]
    assert areas[0] / areas[1] == pytest.approx(4.0, rel=0.1)
    rising = replace(run, joint_impulses=np.repeat(np.arange(len(run.times), dtype=float)[:, None], 15, axis=1))
    for time, frame in ((0.0, 0), (0.0149, 1), (9.999, 999), (10.0, 1000)):
        assert impulses(rising, time)[0] == frame
