"""Pictures of the dragon: colours, sizes, texts, marks, and other marches than the paper's."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations_with_replacement

import imageio.v3 as iio
import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from marches import ARM, TRACTOR, U_TURN
from PIL import Image
from shapely import affinity, box

from pymunk_dragon import Camera, Contact, Dragon, March, Palette, Run, UTurn, first_contact
from pymunk_dragon._language import in_language
from pymunk_dragon.drawing import Film, still, write_still
from pymunk_dragon.drawing.film.layout import lay_out
from pymunk_dragon.drawing.lettering import Lettering
from pymunk_dragon.drawing.palette import BLOCK, CODES, STRENGTHS, TRANSPARENT, TYPE_RAMP, index_of, occurs
from pymunk_dragon.drawing.scene import RING_RADIUS, hole_diameter, smallest_gap
from pymunk_dragon.drawing.snapshots import sample, snapshots
from pymunk_dragon.errors import ParameterError

PALETTE = Palette()
SMALL = March(Dragon(benches=16), turns=4)
HEAD = Camera(follow="head", span=4.0)
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
    line = Lettering.line
    monkeypatch.setattr(Lettering, "line", lambda self, text: written.append(text) or line(self, text))
    return written


def shown(source, time, film):
    """A picture, and where points of the ground lie on it."""
    times = np.array([time])
    canvas = lay_out([sample(source, times, film.show, extent=film.camera.follow == "field")], film)
    [snapshot] = snapshots(source, times, film.show)
    view = canvas.scenes[0].view(snapshot.poses)
    return still(source, time, film), lambda points: view.pixels(points) / BLOCK


def colour_at(picture, xy):
    x, y = (int(v) for v in xy)
    return "#" + bytes(picture[y, x].tolist()).hex()


def count(picture, name):
    """How many pixels of a picture have a colour of the palette."""
    return int(np.all(picture == np.rint(PALETTE.rgb(name)), axis=-1).sum())


def near(picture, xy, size=1):
    """Pixels at `xy` and beside it."""
    x, y = (int(v) for v in xy)
    return picture[max(y - size, 0) : y + size + 1, max(x - size, 0) : x + size + 1]


def share_drawn(picture, points):
    """Share of points of a picture that have something beside bare ground within a pixel."""
    ground = PALETTE.rgb("background")
    return np.mean([np.any(near(picture, point) != ground) for point in points])


def test_every_mixture_that_occurs_has_an_index_with_its_mean_colour():
    mixtures = list(combinations_with_replacement(CODES, BLOCK**2))
    common = [m for m in mixtures if occurs(m)]
    assert len({index_of(m) for m in common}) == len(common) == 89
    assert not {index_of(m) for m in mixtures} & {*TYPE_RAMP, TRANSPARENT}
    for mixture in common:
        block = Image.fromarray(np.array([CODES[name] for name in mixture], dtype=np.uint8).reshape(BLOCK, BLOCK))
        colour = PALETTE.table[np.asarray(block.reduce(BLOCK))[0, 0]]
        assert np.abs(colour - np.mean([PALETTE.rgb(name) for name in mixture], axis=0)).max() <= 0.5


def test_no_two_bench_colours_look_alike_to_anyone_or_in_grey():
    # Machado, Oliveira and Fernandes 2009, severity 1, on linear light.
    visions = {
        "normal": np.eye(3),
        "deuteranope": np.array([[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]]),
        "protanope": np.array([[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]]),
    }
    colours = np.array([PALETTE.rgb(name) for name in ("head", "body", "tail", "contact", "background")])
    for vision, matrix in visions.items():
        seen = 255 * np.clip((colours / 255) ** 2.2 @ matrix.T, 0, 1) ** (1 / 2.2)
        distances = np.linalg.norm(seen[:, None] - seen[None], axis=-1)[np.triu_indices(len(seen), 1)]
        assert distances.min() > 60, vision
    assert np.diff(np.sort(colours @ (0.299, 0.587, 0.114))).min() > 255 / 7


def test_benches_have_their_colours_and_a_touched_one_that_of_the_contact(seed):
    film = Film(size=640)
    picture, place = shown(seed, 408.0, film)
    centres = place(seed.poses_at([408.0])[0, :, :2])
    assert colour_at(picture, centres[0]) == PALETTE.head
    assert {colour_at(picture, xy) for xy in centres[1:-1]} == {PALETTE.body}
    assert colour_at(picture, centres[-1]) == PALETTE.tail
    for camera in (Camera(), Camera(follow="head")):
        for time, body in ((CONTACT_TIME - 0.01, PALETTE.body), (CONTACT_TIME, PALETTE.contact)):
            picture, place = shown(seed, time, replace(film, camera=camera))
            poses = seed.poses_at([time])[0, [0, 8]]
            # Half a metre in front of the centres: there is no ring, and no other bench.
            points = place(poses[:, :2] + 0.5 * np.stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])], axis=-1))
            assert [colour_at(picture, point) for point in points] == [PALETTE.head, body]


def test_bad_cameras_palettes_marks_and_times_are_refused(run, tmp_path):
    cases = [("span", lambda value=value: Camera(span=value)) for value in (0, -1, float("inf"), "wide")]
    cases += [("follow", lambda: Camera(follow="tail"))]
    for colour in ("red", "#12345", "#12345g", "#1234567", None):
        cases += [("body", lambda colour=colour: Palette(body=colour))]
    for mark in ("contacts", "normals", "impulses", "shadows"):
        cases += [("show", lambda mark=mark: still(SMALL, 1.0, Film(show=(mark,))))]
    cases += [("time", lambda: write_still(run, 11.0, tmp_path / "still.png"))]
    for name, call in cases:
        with pytest.raises(ParameterError, match=name):
            call()
    write_still(run, 4.0, tmp_path / "still.png", Film(size=120))
    np.testing.assert_array_equal(iio.imread(tmp_path / "still.png"), still(run, 4.0, Film(size=120)))


def test_each_bench_is_drawn_in_its_true_size():
    march = March(Dragon(benches=2), turns=4)
    picture, _ = shown(march, 0.0, Film(size=600, camera=HEAD, gap=False))
    dragon, scale = march.dragon, 600 / 4
    # What is missing are the outline, half a pixel inside the edge, and the two holes.
    outline = (dragon.width + dragon.lengths[0]) * scale
    holes = 2 * np.pi * (0.055 / 2 * scale) ** 2
    area = dragon.width * dragon.lengths[0] * scale**2
    assert count(picture, "head") == pytest.approx(area - 1.5 * outline - holes, rel=0.03)
    dragon = Dragon(body_spacing=[1.65, 2.5, 1.65], overhang=[0.2, 0.4, 0.1, 0.3], width=[0.2, 0.5, 0.3, 0.4])
    march = March(dragon, turns=6)
    picture, place = shown(march, 0.0, Film(size=600, gap=False))
    ground = colour_at(picture, (5, 300))
    for length, width, (x, y, angle) in zip(dragon.lengths, dragon.width, march.at(0.0).poses[0], strict=True):
        along, left = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        for way, reach in ((along, length / 2), (-along, length / 2), (left, width / 2), (-left, width / 2)):
            inside, outside = place(np.array([[x, y] + (reach - 0.02) * way, [x, y] + (reach + 0.04) * way]))
            assert colour_at(picture, inside) != ground
            # An end lies on the neighbour, and nowhere else is there anything but the curve.
            assert reach == length / 2 or colour_at(picture, outside) in (ground, PALETTE.curve)


def test_camera_stays_above_the_head_or_shows_every_bench(run):
    for time in (0.0, 3.3, 10.0):
        picture, _ = shown(run, time, Film(size=200, camera=Camera(follow="head")))
        assert colour_at(picture, (100, 100)) == PALETTE.head
        _, place = shown(run, time, Film(size=(300, 200)))
        corners = place(SMALL.dragon.outlines(run.poses_at([time])[0])).reshape(-1, 2)
        assert np.all((corners > 0) & (corners < (300, 200)))
    for march, metres in ((SMALL, 6.0), (TRACTOR, 36.0), (ARM, 1.0)):
        _, place = shown(march, 0.5, Film(size=600, camera=Camera(follow="head")))
        (x0, _), (x1, _) = place([(0.0, 0.0), (1.0, 0.0)])
        assert 600 / (x1 - x0) == pytest.approx(metres)


def test_curves_are_drawn_as_far_as_the_run_or_the_curve_goes():
    run = Run.exact(U_TURN, np.arange(-20.0, 21.0))
    picture, place = shown(run, -20.0, Film(size=800, gap=False, camera=Camera(span=16)))
    # The head's overhang ends 0.3 m before it.
    assert share_drawn(picture, place(U_TURN.curve.point(np.linspace(-19.5, 19.9, 300)))) == 1
    assert hole_diameter(Dragon()) == 0.055
    for march, time in ((TRACTOR, 20.0), (ARM, 8.0)):
        points = march.curve.point(np.linspace(0, march.curve.end_s, 400)[1:-1])
        film = Film(size=800, gap=False, camera=Camera(span=1.2 * float(np.ptp(points, axis=0).max())))
        picture, place = shown(Run.exact(march, np.linspace(0, march.end, 50)), time, film)
        assert share_drawn(picture, place(points)) > 0.99
        assert hole_diameter(march.dragon) < march.dragon.widths.min()


@given(st.lists(st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-4, 4)), min_size=4, max_size=4))
def test_gap_is_that_of_shapely_for_benches_of_their_own_widths(rows):
    dragon = Dragon(body_spacing=[1.0, 2.0, 0.8], overhang=[0.3, 0.1, 0.2, 0.25], width=[0.5, 0.2, 1.1, 0.05])
    # Shapely knows nothing of the project's outlines.
    benches = [
        affinity.translate(affinity.rotate(box(-a / 2, -c / 2, a / 2, c / 2), angle, use_radians=True), x, y)
        for a, c, (x, y, angle) in zip([3.46, 1.2, 2.4, 1.3], dragon.width, rows, strict=True)
    ]
    gaps = {i: benches[0].distance(benches[i]) for i in (2, 3)}
    crossing = any(benches[0].intersects(benches[i]) for i in (2, 3))
    bench, gap, _ = smallest_gap(dragon, np.array(rows)) or (0, 0.0, None)
    assert crossing or gap == pytest.approx(min(gaps.values()), abs=1e-9)
    assert crossing or gaps[bench] == pytest.approx(gap, abs=1e-9)


def test_legend_and_scale_bar_are_below_the_picture(texts):
    film = Film(size=480, camera=Camera(follow="head", span=6.0))
    with_legend, without = still(SMALL, 1.0, film), still(SMALL, 1.0, replace(film, legend=False))
    assert without.shape == still(SMALL, 1.0, Film(size=480, legend=False)).shape == (480, 480, 3)
    np.testing.assert_array_equal(with_legend[:480], without)
    assert all(count(with_legend[480:], name) > 50 for name in ("head", "body", "tail"))
    assert {"head", "body", "tail", "1 m", "head 1.00 m/s"} <= set(texts)
    assert not {"in contact", "turning circle"} & set(texts)
    # The longest horizontal line of the strip, with its ends, is as long as it says.
    strip = np.all(with_legend[480:] == np.rint(PALETTE.rgb("ink")), axis=-1)
    longest = max(len(run) for row in strip for run in "".join(" x"[int(pixel)] for pixel in row).split())
    assert longest - 1 == round(480 / 6.0)
    assert still(SMALL, 1.0, Film(size=200)).shape == (200, 200, 3)  # too narrow for a legend


def test_contact_and_near_misses_are_named(seed, texts):
    still(seed, CONTACT_TIME, Film(size=400))
    assert {"in contact", "contact: benches 0 and 8"} <= set(texts)
    texts.clear()
    with in_language("zh"):
        still(seed, CONTACT_TIME, Film(size=400))
    assert {"\u9f99\u5934", "\u9f99\u8eab", "\u9f99\u5c3e", "\u78b0\u649e\uff1a\u677f\u51f3 0 \u4e0e 8"} <= set(texts)
    run = replace(seed, first_contact=None)
    for time, bench, gap in ((406.8466, 9, 3.0), (409.8320, 11, 0.9)):
        found = smallest_gap(seed.march.dragon, seed.march.at(time).poses[0])
        assert (found[0], found[1]) == (bench, pytest.approx(gap / 1000, abs=5e-5))
        picture = still(run, time, Film(size=440, legend=False))
        assert f"gap {gap} mm to bench {bench}" in texts
        plain = still(run, time, Film(size=440, legend=False, gap=False))
        rows, columns = np.nonzero(np.any(picture[:400] != plain[:400], axis=-1))
        # A ring around the gap.
        assert (np.ptp(rows), np.ptp(columns)) == pytest.approx((2 * RING_RADIUS, 2 * RING_RADIUS), abs=2)


def test_turning_circle_is_drawn_dashed_and_named(texts):
    picture, place = shown(March(Dragon(benches=16), UTurn()), 0.0, Film(size=600, gap=False, camera=Camera(span=15.0)))
    assert "turning circle" in texts
    angles = np.linspace(0, 2 * np.pi, 720, endpoint=False)
    assert 0.5 < share_drawn(picture, place(4.5 * np.stack([np.cos(angles), np.sin(angles)], axis=-1))) < 1


def test_exact_model_beside_a_run_shows_the_position_errors_of_the_run(run, texts):
    poses = run.poses.copy()
    poses[..., 0] += np.linspace(0, 20e-6, 16)
    displaced = replace(run, poses=poses, provenance={"player": "pymunk", "guide": "rails"})
    for camera, factor in ((Camera(), "80,000"), (Camera(follow="head"), "20,000")):
        picture = still([displaced, SMALL], 5.0, Film(size=300, camera=camera, gap=False))
        assert {f"position error x {factor}", "position error up to 0.0200 mm"} <= set(texts)
        assert count(picture[:260, :300], "motion") == 0
        assert count(picture[:260, 302:], "motion") > 100


def test_arrow_points_to_where_the_handle_would_be_in_half_a_second(run):
    picture, place = shown(SMALL, 3.0, Film(size=600, camera=HEAD, gap=False, show=("velocities",)))
    states = SMALL.at([3.0])
    for handle in (0, 1):
        begin, velocity = states.positions[0, handle], states.velocities[0, handle]
        for share in (0.3, 0.6, 0.95):
            assert count(near(picture, place(begin + 0.5 * share * velocity)), "motion")
        assert not count(near(picture, place(begin + 0.5 * 1.1 * velocity)), "motion")
    [snapshot] = snapshots(run, np.array([4.321]), ("velocities",))
    np.testing.assert_allclose(snapshot.velocities, SMALL.at([4.321]).velocities[0], atol=2e-3)


def test_cells_are_dark_where_a_bench_touches_them():
    picture, place = shown(SMALL, 3.0, Film(size=600, gap=False, show=("grid",)))
    benches = shapely.union_all([shapely.Polygon(c) for c in SMALL.dragon.outlines(SMALL.at([3.0]).poses[0])])
    ground, strength = PALETTE.rgb("background"), STRENGTHS["grid"][0]
    level = (1 - strength) * ground + strength * PALETTE.rgb("grid")
    checked = {True: 0, False: 0}
    for i, j in np.ndindex(8, 8):
        x, y = (j - 4) * 0.55, (4 - i) * 0.55
        square = shapely.box(x, y - 0.55, x + 0.55, y)
        corners = place(np.array(square.exterior.coords))
        (x0, y0), (x1, y1) = np.ceil(corners.min(axis=0)) + 1, np.floor(corners.max(axis=0)) - 1
        inside = picture[int(y0) : int(y1), int(x0) : int(x1)].reshape(-1, 3)
        filed = benches.intersects(square)
        wanted, other = (level, ground) if filed else (ground, level)
        checked[filed] += np.any(np.all(inside == np.rint(wanted), axis=-1))
        assert not np.any(np.all(inside == np.rint(other), axis=-1))
    assert checked[True] > 20
    assert checked[False] > 5


def test_contact_has_its_point_and_its_normal(run, small_run):
    x, y = SMALL.dragon.outlines(run.poses_at([5.0])[0])[0, 2]
    contact = Contact(time=5.0, raw_time=5.0, benches=(0, 9), point=(x, y), normal=(0.6, 0.8), depth=0.0)
    touching = replace(run, first_contact=contact, outcome="contact")
    film = Film(size=600, camera=HEAD, gap=False, show=("contacts", "normals"))
    picture, place = shown(touching, 5.0, film)
    x, y = place(contact.point)
    assert count(near(picture, (x, y)), "force")
    assert count(near(picture, (x + 0.6 * 30, y - 0.8 * 30)), "force")
    assert not count(near(picture, (x - 0.6 * 15, y + 0.8 * 15)), "force")
    assert not count(still(touching, 4.9, film), "force")
    [window] = [window for window in small_run.events.windows() if window.end is not None]
    times = np.array([window.begin - 0.05, (window.begin + window.end) / 2])
    before, inside = snapshots(small_run, times, ("contacts",))
    assert inside.touches
    assert not before.touches


def test_area_of_a_disc_is_in_proportion_to_the_impulse_of_the_frame_before(run):
    impulses = np.full((len(run.times), 15), 1.0)
    impulses[:, 0] = 4.0
    film = Film(size=1200, camera=Camera(follow="head", span=8.0), gap=False, show=("impulses",))
    picture, place = shown(replace(run, joint_impulses=impulses), 5.0, film)
    _, rear = SMALL.dragon.holes(run.poses_at([5.0])[0])
    areas = [count(near(picture, xy, 40), "force") for xy in place(rear[:2])]
    assert areas[0] / areas[1] == pytest.approx(4.0, rel=0.1)
    strong, weak = (replace(run, joint_impulses=np.full((len(run.times), 15), value)) for value in (4.0, 1.0))
    both = still([strong, weak], 5.0, replace(film, size=600))
    assert count(both[:, :600], "force") / count(both[:, -600:], "force") == pytest.approx(4.0, rel=0.15)
    rising = replace(run, joint_impulses=np.repeat(np.arange(len(run.times), dtype=float)[:, None], 15, axis=1))
    for time, frame in ((0.0, 0), (0.0149, 1), (9.999, 999), (10.0, 1000)):
        [snapshot] = snapshots(rising, np.array([time]), ("impulses",))
        assert snapshot.impulses[0] == frame
