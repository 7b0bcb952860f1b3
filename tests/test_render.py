from __future__ import annotations

from dataclasses import replace
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any

import imageio.v3 as iio
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from marches import ARM, TRACTOR, U_TURN
from numpy.typing import NDArray
from PIL import Image
from shapely import affinity, box

from pymunk_dragon.drawing import Camera, Film, Palette, render, write_film, write_still
from pymunk_dragon.drawing.film.layout import Canvas, lay_out
from pymunk_dragon.drawing.palette import BLOCK, CODES, TRANSPARENT, TYPE_RAMP, index_of, occurs
from pymunk_dragon.drawing.scene import Nearest, hole_diameter, smallest_gap
from pymunk_dragon.drawing.snapshots import sample, snapshots
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.model.contact import Contact
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

SMALL = Dragon(benches=16)
# The seed's first contact, as every solver of the project finds it.
CONTACT_TIME = 412.4738


@pytest.fixture(scope="module")
def march() -> March:
    return March(SMALL, turns=4)


@pytest.fixture(scope="module")
def run(march: March) -> Run:
    return Run.exact(march, np.linspace(0, 10, 101))


@pytest.fixture(scope="module")
def seed() -> Run:
    """The last seconds of the seed's run, with its contact."""
    run = Run.exact(March(), np.append(np.arange(405.0, 412.4, 0.2), CONTACT_TIME))
    # The head's front left corner is what touches.
    x, y = run.march.dragon.outlines(run.poses[-1])[0, 2]
    contact = Contact(
        time=CONTACT_TIME,
        raw_time=CONTACT_TIME,
        benches=(0, 8),
        point=(float(x), float(y)),
        normal=(0.0, 1.0),
        depth=0.0,
    )
    return replace(run, first_contact=contact, outcome="contact")


def colour_at(picture: NDArray[np.uint8], x: float, y: float) -> str:
    return "#" + bytes(picture[int(y), int(x)].tolist()).hex()


def canvas_of(source: Run | March, film: Film, times: NDArray[np.float64]) -> Canvas:
    return lay_out([sample(source, times, film.show, extent=film.camera.follow == "field")], film)


def drawn(source: Run | March, film: Film, time: float) -> tuple[NDArray[np.uint8], Any]:
    """Picture at a time, as RGB, and where points of the ground lie on it."""
    canvas = canvas_of(source, film, film.timing([source]).times)
    [snapshot] = snapshots(source, np.array([time]), film.show)
    view = canvas.scenes[0].view(snapshot.poses)
    picture = film.palette.table[np.asarray(canvas.draw([snapshot]))]
    return picture, lambda points: view.pixels(points) / BLOCK


def test_the_last_frame_is_the_end_of_the_run(run: Run) -> None:
    times = Film(fps=10, speedup=3).timing([run]).times
    assert times[-1] == run.times[-1]
    assert np.all(np.diff(times) > 0)


def test_a_window_shows_only_that_part(run: Run) -> None:
    times = Film(fps=10, speedup=10, start=3, until=6).timing([run]).times
    np.testing.assert_allclose(times, [3, 4, 5, 6])


def test_every_mixture_that_occurs_has_an_index_of_its_own() -> None:
    mixtures = list(combinations_with_replacement(CODES, BLOCK**2))
    common = [m for m in mixtures if occurs(m)]
    assert len(common) == 89
    assert len({index_of(m) for m in common}) == len(common)
    assert not {index_of(m) for m in mixtures} & {*TYPE_RAMP, TRANSPARENT}


@pytest.mark.parametrize("mixture", [m for m in combinations_with_replacement(CODES, BLOCK**2) if occurs(m)])
def test_shrinking_gives_the_mean_colour(mixture: tuple[str, ...]) -> None:
    palette = Palette()
    block = Image.fromarray(np.array([CODES[name] for name in mixture], dtype=np.uint8).reshape(BLOCK, BLOCK))
    shown = palette.table[np.asarray(block.reduce(BLOCK))[0, 0]]
    assert np.abs(shown - np.mean([palette.rgb(name) for name in mixture], axis=0)).max() <= 0.5


@pytest.mark.parametrize(
    ("film", "bound"),
    [(Film(size=440), 0.001), (Film(size=640), 0.001), (Film(size=440, camera=Camera(follow="head")), 0.0)],
)
def test_hardly_a_pixel_has_not_its_mean_colour(
    seed: Run, film: Film, bound: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    canvases: list[Image.Image] = []
    reduce = Image.Image.reduce

    def kept(image: Image.Image, factor: int) -> Image.Image:
        canvases.append(image)
        return reduce(image, factor)

    monkeypatch.setattr(Image.Image, "reduce", kept)
    drawn(seed, film, CONTACT_TIME)
    canvas = np.asarray(canvases[-1])
    codes = np.zeros((256, 3))
    for name, code in CODES.items():
        codes[code] = film.palette.rgb(name)
    height, width = canvas.shape
    true = codes[canvas].reshape(height // 2, 2, width // 2, 2, 3).mean(axis=(1, 3))
    error = np.abs(film.palette.table[np.asarray(reduce(canvases[-1], BLOCK))] - true).max(axis=-1)
    assert np.mean(error > 1) <= bound


def test_head_body_and_tail_have_their_colours(seed: Run) -> None:
    film = Film(size=640)
    picture, place = drawn(seed, film, 408.0)
    centres = place(seed.poses_at([408.0])[0, :, :2])
    assert colour_at(picture, *centres[0]) == film.palette.head
    assert {colour_at(picture, *xy) for xy in centres[1:-1]} == {film.palette.body}
    assert colour_at(picture, *centres[-1]) == film.palette.tail


@pytest.mark.parametrize("follow", ["field", "head"])
def test_body_changes_colour_at_the_contact_and_head_does_not(seed: Run, follow: Any) -> None:
    film = Film(size=640, camera=Camera(follow=follow))
    for time, colours in ((CONTACT_TIME - 0.01, ("head", "body")), (CONTACT_TIME, ("head", "contact"))):
        picture, place = drawn(seed, film, time)
        poses = seed.poses_at([time])[0, [0, 8]]
        # Half a metre in front of the centres: there is no ring, and no other bench.
        points = place(poses[:, :2] + 0.5 * np.stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])], axis=-1))
        assert tuple(colour_at(picture, *point) for point in points) == tuple(
            getattr(film.palette, name) for name in colours
        )


def test_a_bench_is_drawn_in_its_true_size() -> None:
    march = March(Dragon(benches=2), turns=4)
    film = Film(size=600, until=0, camera=Camera(follow="head", span=4), gap=False)
    picture, _ = drawn(march, film, 0.0)
    head = np.all(picture == film.palette.rgb("head"), axis=-1)
    area = march.dragon.width * march.dragon.lengths[0] * (600 / 4) ** 2
    # What is missing are the outline, half a pixel inside the edge, and the two holes.
    outline = (march.dragon.width + march.dragon.lengths[0]) * 600 / 4
    holes = 2 * np.pi * (0.055 / 2 * 600 / 4) ** 2
    assert head.sum() == pytest.approx(area - 1.5 * outline - holes, rel=0.03)


def test_the_camera_stays_above_the_head(run: Run) -> None:
    film = Film(size=200, camera=Camera(follow="head"))
    for time in (0.0, 3.3, 10.0):
        picture, _ = drawn(run, film, time)
        assert colour_at(picture, 100, 100) == film.palette.head


def test_the_field_holds_every_bench_of_the_film(run: Run) -> None:
    film = Film(size=(300, 200))
    for time in (0.0, 10.0):
        _, place = drawn(run, film, time)
        corners = place(SMALL.outlines(run.poses_at([time])[0])).reshape(-1, 2)
        assert np.all(corners > 0)
        assert np.all(corners < (300, 200))


@pytest.mark.parametrize(("time", "bench", "millimetres"), [(406.8, 9, 3.0), (409.8, 11, 0.9)])
def test_the_gap_shows_the_near_misses(time: float, bench: int, millimetres: float) -> None:
    march = March()
    nearest = smallest_gap(march.dragon, march.at(time).poses[0])
    assert nearest is not None
    assert nearest[0] == bench
    assert nearest[1] == pytest.approx(millimetres / 1000, abs=2e-4)


def test_the_gap_is_the_smallest_distance_between_outlines(march: March) -> None:
    poses = march.at(5.0).poses[0]
    corners = SMALL.outlines(poses)
    shares = np.linspace(0, 1, 401)[:, None, None]
    edges = [(c + shares * (np.roll(c, -1, axis=0) - c)).reshape(-1, 2) for c in corners]
    brute = {i: np.min(np.linalg.norm(edges[0][:, None] - edges[i][None], axis=-1)) for i in range(2, 5)}
    bench, gap, _ = smallest_gap(replace(SMALL, benches=5), poses[:5]) or (0, 0.0, None)
    assert bench == min(brute, key=lambda i: brute[i])
    assert gap == pytest.approx(brute[bench], abs=1e-3)


@given(st.lists(st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-4, 4)), min_size=4, max_size=4))
def test_the_gap_is_that_of_benches_of_their_own_widths(rows: list[tuple[float, float, float]]) -> None:
    dragon = Dragon(body_spacing=[1.0, 2.0, 0.8], overhang=[0.3, 0.1, 0.2, 0.25], width=[0.5, 0.2, 1.1, 0.05])
    poses = np.array(rows)
    # Shapely knows nothing of the project's outlines.
    benches = [
        affinity.translate(affinity.rotate(box(-a / 2, -c / 2, a / 2, c / 2), angle, use_radians=True), x, y)
        for a, c, (x, y, angle) in zip([3.46, 1.2, 2.4, 1.3], dragon.width, rows, strict=True)
    ]
    gaps = {i: benches[0].distance(benches[i]) for i in (2, 3)}
    crossing = any(benches[0].intersects(benches[i]) for i in (2, 3))
    bench, gap, _ = smallest_gap(dragon, poses) or (0, 0.0, None)
    assert crossing or gap == pytest.approx(min(gaps.values()), abs=1e-9)
    assert crossing or gaps[bench] == pytest.approx(gap, abs=1e-9)


def test_each_bench_is_drawn_in_its_own_size() -> None:
    dragon = Dragon(body_spacing=[1.65, 2.5, 1.65], overhang=[0.2, 0.4, 0.1, 0.3], width=[0.2, 0.5, 0.3, 0.4])
    march = March(dragon, turns=6)
    picture, place = drawn(march, Film(size=600, until=1.0, gap=False), 0.0)
    pose, ground = march.at(0.0).poses[0], colour_at(picture, 5, 300)
    for length, width, (x, y, angle) in zip(dragon.lengths, dragon.width, pose, strict=True):
        along, left = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        for way, reach in ((along, length / 2), (-along, length / 2), (left, width / 2), (-left, width / 2)):
            inside, outside = place(np.array([[x, y] + (reach - 0.02) * way, [x, y] + (reach + 0.04) * way]))
            assert colour_at(picture, *inside) != ground
            # An end lies on the neighbour, and nowhere else is there anything but the curve.
            assert reach == length / 2 or colour_at(picture, *outside) in (ground, Palette().curve)


def test_a_dragon_of_head_and_tail_can_be_filmed(tmp_path: Path) -> None:
    march = March(Dragon(benches=2), turns=3)
    render(march, tmp_path / "film.gif", until=2, size=64, camera=Camera(follow="head"))
    assert (tmp_path / "film.gif").stat().st_size > 0


def test_a_march_gives_the_same_film_as_its_exact_run(march: March, tmp_path: Path) -> None:
    film = Film(size=96, start=0, until=6, speedup=10)
    write_film(march, tmp_path / "march.gif", film)
    write_film(Run.exact(march, film.timing([march]).times), tmp_path / "run.gif", film)
    assert (tmp_path / "march.gif").read_bytes() == (tmp_path / "run.gif").read_bytes()


def test_progress_is_told_after_every_frame(run: Run, tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    render(
        run, tmp_path / "film.gif", size=64, fps=10, speedup=20, progress=lambda done, total: told.append((done, total))
    )
    assert told == [(i, 6) for i in range(1, 7)]


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("fps", {"fps": 51}),
        ("fps", {"fps": 24.5}),
        ("fps", {"fps": 0}),
        ("fps", {"fps": "fast"}),
        ("fps", {"fps": True}),
        ("speedup", {"speedup": 0}),
        ("speedup", {"speedup": float("nan")}),
        ("speedup", {"speedup": 1e-5}),
        ("size", {"size": 63}),
        ("size", {"size": 5000}),
        ("size", {"size": (640, 0)}),
        ("size", {"size": (640, 640, 3)}),
        ("size", {"size": 640.5}),
        ("hold", {"hold": -1}),
        ("hold", {"hold": float("inf")}),
        ("start", {"start": -1}),
        ("start", {"start": float("nan")}),
        ("until", {"until": 11}),
        ("until", {"start": 5, "until": 4}),
    ],
)
def test_bad_options_get_one_line_that_names_them(run: Run, tmp_path: Path, name: str, options: dict[str, Any]) -> None:
    with pytest.raises(ParameterError) as caught:
        render(run, tmp_path / "film.gif", **options)
    assert caught.value.name == name
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("span", [0, -1, float("inf"), "wide"])
def test_a_camera_checks_its_span(span: Any) -> None:
    with pytest.raises(ParameterError, match="span"):
        Camera(span=span)


def test_a_camera_follows_only_what_it_knows() -> None:
    with pytest.raises(ParameterError, match="one of field, head"):
        Camera(follow="tail")


@pytest.mark.parametrize("colour", ["red", "#12345", "#12345g", "#1234567", None])
def test_a_palette_checks_its_colours(colour: Any) -> None:
    with pytest.raises(ParameterError, match="#rrggbb"):
        Palette(body=colour)


def test_a_march_without_an_end_is_bad_input(march: March, tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="until"):
        render(march, tmp_path / "film.gif")


def test_a_march_past_the_end_of_its_curve_is_bad_input(march: March, tmp_path: Path) -> None:
    with pytest.raises(DragonError):
        render(march, tmp_path / "film.gif", until=1000)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["film.avi", "film", "nowhere/film.gif"])
def test_a_place_where_no_film_can_be_is_bad_input(run: Run, tmp_path: Path, name: str) -> None:
    with pytest.raises(ParameterError, match="output"):
        render(run, tmp_path / name)


def test_a_still_is_the_picture_of_its_time(run: Run, tmp_path: Path) -> None:
    film = Film(size=120, camera=Camera(follow="head"))
    write_still(run, 4.0, tmp_path / "still.png", film)
    np.testing.assert_array_equal(iio.imread(tmp_path / "still.png"), drawn(run, film, 4.0)[0])


def test_a_still_outside_the_run_is_bad_input(run: Run, tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="time"):
        write_still(run, 11.0, tmp_path / "still.png")


@pytest.mark.parametrize("vision", ["normal", "deuteranope", "protanope"])
def test_no_two_bench_colours_look_alike_to_anyone(vision: str) -> None:
    # Machado, Oliveira and Fernandes 2009, severity 1, on linear light.
    matrices = {
        "normal": np.eye(3),
        "deuteranope": np.array([[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]]),
        "protanope": np.array([[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]]),
    }
    palette = Palette()
    names = ("head", "body", "tail", "contact", "background")
    linear = np.array([(palette.rgb(name) / 255) ** 2.2 for name in names])
    seen = 255 * np.clip(linear @ matrices[vision].T, 0, 1) ** (1 / 2.2)
    distances = np.linalg.norm(seen[:, None] - seen[None], axis=-1)[np.triu_indices(len(names), 1)]
    assert distances.min() > 60


def test_no_two_bench_colours_look_alike_in_grey() -> None:
    palette = Palette()
    names = ("head", "body", "tail", "contact", "background")
    greys = sorted(float(palette.rgb(name) @ (0.299, 0.587, 0.114)) for name in names)
    assert np.diff(greys).min() > 255 / 7


def test_the_defaults_film_the_seeds_march_in_3_megabytes(tmp_path: Path) -> None:
    render(March(), tmp_path / "march.gif", until=CONTACT_TIME)
    assert (tmp_path / "march.gif").stat().st_size <= 3_000_000


# Other marches than the paper's


def share_drawn(picture: NDArray[np.uint8], points: Any) -> float:
    """Share of points of a picture that have something beside bare ground within a pixel."""
    ground = np.all(picture == picture[5, -5], axis=-1)
    columns, rows = np.floor(points).astype(int).T
    return float(np.mean([not ground[y - 1 : y + 2, x - 1 : x + 2].all() for x, y in zip(columns, rows, strict=True)]))


def test_a_curve_without_ends_is_drawn_as_far_as_the_run_goes() -> None:
    run = Run.exact(U_TURN, np.arange(-20.0, 21.0))
    picture, place = drawn(run, Film(size=800, gap=False, camera=Camera(span=16)), -20.0)
    curve = U_TURN.curve
    # The head's overhang ends 0.3 m before it.
    assert share_drawn(picture, place(curve.point(np.linspace(-19.5, 19.9, 300)))) == 1
    assert share_drawn(picture, place(curve.point(np.linspace(20.2, 25, 100)))) == 0


@pytest.mark.parametrize(("march", "time"), [(TRACTOR, 20.0), (ARM, 8.0)], ids=["tractor", "arm"])
def test_a_curve_with_two_ends_is_drawn_whole(march: March, time: float) -> None:
    points = march.curve.point(np.linspace(0, march.curve.end_s, 400)[1:-1])
    span = 1.2 * float(np.ptp(points, axis=0).max())
    film = Film(size=800, gap=False, camera=Camera(span=span))
    run = Run.exact(march, np.linspace(0, march.end, 50))
    picture, place = drawn(run, film, time)
    assert share_drawn(picture, place(points)) > 0.99


def test_a_film_that_follows_the_head_shows_as_many_of_its_widths() -> None:
    for march, metres in ((March(SMALL, turns=4), 6.0), (TRACTOR, 36.0), (ARM, 1.0)):
        _, place = drawn(march, Film(size=600, until=1.0, camera=Camera(follow="head")), 0.5)
        (x0, _), (x1, _) = place([(0.0, 0.0), (1.0, 0.0)])
        assert 600 / (x1 - x0) == pytest.approx(metres)


def test_holes_lie_within_their_benches() -> None:
    assert hole_diameter(Dragon()) == 0.055
    for march in (TRACTOR, ARM):
        assert hole_diameter(march.dragon) < march.dragon.widths.min()
        assert hole_diameter(march.dragon) / 2 < march.dragon.overhangs.min()


@pytest.mark.parametrize(("metres", "words"), [(0.0009, "0.9 mm"), (0.0512, "51 mm"), (2.698, "2.70 m")])
def test_a_gap_is_told_in_a_unit_that_suits_it(metres: float, words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[str] = []
    monkeypatch.setattr("pymunk_dragon.drawing.scene.smallest_gap", lambda *_: Nearest(5, metres, (0.0, 0.0)))
    monkeypatch.setattr("pymunk_dragon.drawing.scene.Lettering.put", lambda self, _, *words, **__: told.extend(words))
    drawn(March(SMALL, turns=4), Film(until=1.0, gap=True), 0.0)
    assert f"gap {words} to bench 5" in told
