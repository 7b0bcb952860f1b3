"""Films in each format: contents, duration, the part that is shown, and films side by side."""

import subprocess
import textwrap
from dataclasses import replace

import imageio.v3 as iio
import imageio_ffmpeg
import numpy as np
import psutil
import pytest
from conftest import refusal
from marches import ARM, TRACTOR
from PIL import Image, ImageFont, features
from PIL.ImageColor import getrgb

from pymunk_dragon import (
    Camera,
    Dragon,
    Film,
    March,
    OutputError,
    Run,
    SpeedTable,
    UTurn,
    first_contact,
    render,
)
from pymunk_dragon._language import in_language
from pymunk_dragon.drawing import FILM_ENDINGS, lettering, still_png
from pymunk_dragon.drawing.film.formats import WRITERS, Frames
from pymunk_dragon.drawing.film.layout import Layout
from pymunk_dragon.drawing.film.take import checked_sources, takes_in, takes_of_film
from pymunk_dragon.drawing.film.timing import frame_times
from pymunk_dragon.drawing.palette import BLOCK, COLOURS, colour_table
from pymunk_dragon.errors import DragonError

MARCH = March(Dragon(benches=16), turns=4)
HEAD = Camera(follow="head")
NEAR_MISSES = (406.8466, 409.8320)
CONTACT = 412.4738
# A letter of Devanagari, which no font of films has.
UNKNOWN = "\u0915"


@pytest.fixture(scope="module")
def run():
    return Run.exact(MARCH, np.linspace(0, 10, 1001))


@pytest.fixture(scope="module")
def seed():
    """The paper's march until its contact."""
    run = Run.exact(March(), np.append(np.arange(0, 412.4, 0.2), CONTACT))
    contact = replace(first_contact(run.march, start=405).contact, time=CONTACT)
    return replace(run, first_contact=contact, outcome="contact")


def still(source, time, film=None):
    return iio.imread(still_png(source, time, film))


def frames(path):
    """Every frame of a GIF or WebP as RGB, and how long it stays in ms."""
    with Image.open(path) as film:
        assert film.info["loop"] == 0  # for ever
        for i in range(film.n_frames):
            film.seek(i)
            yield np.asarray(film.convert("RGB")), film.info["duration"]


def timing_of(source, film):
    """Times of the frames of a film of a run or march, or of several."""
    return frame_times(takes_of_film(checked_sources(source), film), film)


def layout_of(source, times, film):
    """Layout of the frames of a film at given times."""
    return Layout(takes_in((times[0], times[-1]), checked_sources(source), film), times, film)


def drawn(source, film):
    layout = layout_of(source, timing_of(source, film).times, film)
    return [np.asarray(picture).astype(int) for picture in layout.frames()]


@pytest.mark.parametrize("ending", [".gif", ".webp"])
def test_file_shows_exactly_what_was_drawn_for_as_long_as_it_should(run, tmp_path, ending):
    for size, fps in (((160, 120), 10), ((97, 131), 7), ((64, 64), 24)):
        path, told = tmp_path / f"film{ending}", []
        film = Film(
            size=size, fps=fps, speedup=5, hold=1.5, camera=HEAD, show=("velocities", "grid")
        )
        render(run, path, film, progress=lambda *step, told=told: told.append(step))
        shown, expected = list(frames(path)), drawn(run, film)
        assert sum(ms for _, ms in shown) == 10 / 5 * 1000 + 1500, fps
        assert told == [(i + 1, len(expected)) for i in range(len(expected))]
        for (picture, _), frame in zip(shown, expected, strict=True):
            # But for mixtures of colours that are not in the table.
            error = np.abs(picture - frame)
            assert error.max() <= 32
            assert error.mean() < 1


def test_same_film_twice_is_the_same_file(run, tmp_path):
    for ending in FILM_ENDINGS:
        for name in ("one", "two"):
            render(run, tmp_path / f"{name}{ending}", size=64, fps=10, speedup=5)
        assert (tmp_path / f"one{ending}").read_bytes() == (tmp_path / f"two{ending}").read_bytes()


@pytest.mark.parametrize("ending", [".gif", ".webp"])
def test_equal_frames_stay_as_long_as_they_should(tmp_path, ending):
    first = Image.new("P", (32, 32), 3)
    first.putpalette(colour_table().tobytes())
    second = first.copy()
    second.paste(5, (11, 11, 12, 12))
    drawn = [first, first, first, second, second]
    path = tmp_path / f"film{ending}"
    ends = [0.1, 0.2, 0.3, 0.4, 0.5]
    WRITERS[ending](path, Frames(pictures=iter(drawn), ends=ends, size=first.size, fps=10))

    def milliseconds(picture):
        pixels = np.asarray(picture.convert("RGB"))
        return sum(ms for frame, ms in frames(path) if np.array_equal(frame, pixels))

    assert milliseconds(first) == 300
    assert milliseconds(second) == 200


def decoded(path, pixel_format):
    """Bytes of all frames of an MP4 in a pixel format."""
    # FFmpeg itself: imageio's reader leaves its pipes open.
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-i", path]
    command += ["-f", "rawvideo", "-pix_fmt", pixel_format, "-"]
    pixels = subprocess.run(command, check=True, capture_output=True).stdout
    return np.frombuffer(pixels, dtype=np.uint8)


def test_mp4_is_h264_and_shows_the_frames_in_their_colours(run, tmp_path):
    path = tmp_path / "film.mp4"
    film = Film(size=(319, 239), fps=10, speedup=5, hold=0.5, camera=HEAD, legend=False)
    render(run, path, film)
    about = iio.immeta(path, plugin="FFMPEG")
    # An odd number of pixels becomes even.
    assert about["codec"] == "h264"
    assert about["fps"] == 10
    assert about["size"] == (318, 238)
    assert about["pix_fmt"] == "yuv420p(tv, bt709, progressive)"
    assert about["duration"] == pytest.approx(10 / 5 + 0.5, abs=0.1)
    shown = decoded(path, "rgb24").reshape(-1, 238, 318, 3)
    expected = [frame[:238, :318] for frame in drawn(run, film)]
    assert len(shown) >= len(expected) == 21
    for picture, frame in zip(shown, expected, strict=False):
        # Outlines lose half of their colour's resolution; areas keep their colours.
        error = np.abs(picture - frame)
        assert (np.median(error.max(axis=-1)) <= 3, error.mean() < 3) == (True, True)


def test_colours_of_an_mp4_are_encoded_by_bt_709(tmp_path):
    # A column of 16 pixels of each colour of the table.
    table = colour_table()
    row = np.arange(len(table), dtype=np.uint8).repeat(16)
    picture = Image.fromarray(np.tile(row, (32, 1)), "P")
    picture.putpalette(table.tobytes())
    path, size = tmp_path / "film.mp4", picture.size
    WRITERS[".mp4"](path, Frames(pictures=iter([picture]), ends=[0.1], size=size, fps=10))
    planes = decoded(path, "yuv420p")
    luma, blue, red = np.split(planes, [size[0] * 32, size[0] * 40])
    found = [luma.reshape(32, -1)[16, 8::16]]
    found += [plane.reshape(16, -1)[8, 4::8] for plane in (blue, red)]
    # ITU-R BT.709-6, table 3: luma and differences of colour, in the limited range of 8 bits.
    r, g, b = table.reshape(-1, 3).T / 255
    y = 0.2126 * r + 0.7152 * g + 0.0722 * b
    expected = [16 + 219 * y, 128 + 224 * (b - y) / 1.8556, 128 + 224 * (r - y) / 1.5748]
    # The luma of BT.601 is off by up to 13.
    np.testing.assert_allclose(found, expected, atol=4)


def test_mp4_has_as_many_frames_and_is_as_long_as_it_should(run, tmp_path):
    for fps, hold in ((7, 1.5), (20, 0), (60, 0.25)):
        path = tmp_path / "film.mp4"
        timing = render(run, path, size=64, fps=fps, speedup=5, hold=hold)
        frames, seconds = imageio_ffmpeg.count_frames_and_secs(path)
        assert frames == round(timing.ends[-1] * fps)
        assert seconds == pytest.approx(frames / fps, abs=0.01)


def test_film_that_is_broken_off_leaves_the_old_one(run, tmp_path):
    def stop(done, total):
        if done == 3:
            raise KeyboardInterrupt

    for path in [tmp_path / f"film{ending}" for ending in FILM_ENDINGS]:
        path.write_bytes(b"old")
        with pytest.raises(KeyboardInterrupt):
            render(run, path, size=64, progress=stop)
        assert path.read_bytes() == b"old"
    assert len(list(tmp_path.iterdir())) == len(FILM_ENDINGS)


def test_error_of_the_users_own_code_is_raised_as_it_is_and_leaves_nothing(tmp_path):
    def stop(done, total):
        if done == 3:
            raise error

    for path in [tmp_path / f"film{ending}" for ending in FILM_ENDINGS]:
        path.write_bytes(b"old")
        for error in (
            RuntimeError("my own"),
            OSError(5, "my own"),
            OutputError("mine", "my own"),
            OverflowError("mine"),
        ):
            assert (
                refusal(render, MARCH, path, size=64, until=9, progress=stop, error=type(error))
                is error
            )
        assert path.read_bytes() == b"old"
    assert len(list(tmp_path.iterdir())) == len(FILM_ENDINGS)
    assert [child for child in psutil.Process().children() if "ffmpeg" in child.name()] == []


def test_size_that_is_returned_is_that_of_the_file(run, tmp_path):
    for ending in (*FILM_ENDINGS, ".png"):
        path = tmp_path / f"film{ending}"
        returned = render(run, path, size=(121, 77), fps=10, speedup=5).size
        size = iio.immeta(path)["size"] if ending == ".mp4" else iio.improps(path).shape[-2:-4:-1]
        assert returned == size == ((120, 76) if ending == ".mp4" else (121, 77))


def test_bad_parameters_are_refused(run, tmp_path):
    cases = [("fps", value) for value in (51, 24.5, 0, "fast", True)]
    cases += [("speedup", value) for value in (0, float("nan"), 1e-5)]
    cases += [("size", value) for value in (63, 5000, (640, 0), (640, 640, 3), 640.5)]
    cases += [
        ("hold", -1),
        ("hold", float("inf")),
        ("start", -1),
        ("start", float("nan")),
        ("until", 11),
    ]
    cases += [("title", 3), ("title", UNKNOWN), ("caption", "w" * 10_001), ("camera", "head")]
    cases += [("headings", value) for value in (("a", None), ("one", "too many"), (UNKNOWN,))]
    cases += [("show", value) for value in (("shadows",), "grid", ("forces",))]
    calls = [(name, run, "film.gif", {name: value}) for name, value in cases]
    # Too many frames for the memory of a WebP, and too wide for one.
    calls += [
        ("size", run, "film.webp", {"size": 2048, "speedup": 0.5}),
        ("size", [run] * 9, "film.webp", {"size": 2048}),
    ]
    calls += [
        ("until", run, "film.gif", {"start": 5, "until": 4}),
        ("until", [MARCH, MARCH], "film.gif", {}),
    ]
    calls += [("output", run, name, {}) for name in ("film.avi", "film", "nowhere/film.gif")]
    calls += [("source", source, "film.gif", {"until": 1}) for source in ([], "run.npz", [1], None)]
    for name, source, file, options in calls:
        assert refusal(render, source, tmp_path / file, **options).name == name, options
    refusal(
        render, MARCH, tmp_path / "film.gif", until=1000, error=DragonError
    )  # past the end of the curve
    assert list(tmp_path.iterdir()) == []
    render(run, tmp_path / "film.mp4", fps=60, until=0.5, speedup=1, size=64)


def test_film_of_the_paper_s_march_is_short_and_slows_down_towards_near_misses_and_contact(seed):
    timing = timing_of(seed, Film())
    assert 8 <= timing.ends[-1] <= 20
    assert timing.fps >= 20
    travel = np.diff(timing.times)  # of the head per frame, m, at 1 m/s
    assert 0 < travel.min() < travel.max() <= 0.8
    assert timing.times[-1] == CONTACT
    np.testing.assert_allclose(np.diff(timing.ends[:-1]), 1 / timing.fps)
    assert timing.ends[-1] - timing.ends[-2] == pytest.approx(2.5)
    near = {
        time: travel[np.searchsorted(timing.times, time) - 2] for time in (*NEAR_MISSES, CONTACT)
    }
    assert max(near.values()) < travel.max() / 4
    between = travel[np.searchsorted(timing.times, np.mean(NEAR_MISSES)) - 2]
    assert between > 1.5 * max(near[time] for time in NEAR_MISSES)
    assert np.abs(np.diff(travel)).max() < travel.max() / 8


def test_given_parameters_of_the_time_are_kept(seed, run):
    timing = timing_of(seed, Film(start=0))
    assert timing.times[0] == 0
    assert np.diff(timing.times).max() <= 0.8
    assert np.diff(timing_of(seed, Film(camera=HEAD)).times).max() <= 0.2
    assert timing_of(seed, Film(fps=10)).fps == 10
    np.testing.assert_allclose(np.diff(timing_of(seed, Film(speedup=20)).times)[:-1], 1)
    np.testing.assert_allclose(
        timing_of(run, Film(fps=10, speedup=10, start=3, until=6)).times, [3, 4, 5, 6]
    )


def test_films_of_short_and_long_and_changing_marches_have_a_bearable_length(run):
    assert timing_of(run, Film()).ends[-1] == pytest.approx(8)
    # Half of real time, and the last frame.
    assert timing_of(MARCH, Film(until=1.0)).ends[-1] == pytest.approx(2 * 1.0 + 2.5)
    long = timing_of(
        Run.exact(March(Dragon(benches=3), turns=80), np.linspace(0, 8000, 101)), Film(start=0)
    )
    assert long.ends[-1] == pytest.approx(62.5, abs=0.05)
    march = March(Dragon(benches=16), turns=16, speed=SpeedTable((0, 100, 200), (0.2, 2.0, 0.2)))
    changing = timing_of(Run.exact(march, np.linspace(0, 200, 101)), Film())
    assert np.diff(march.distance(changing.times)).max() <= 0.8
    small = Dragon(benches=16, head_spacing=0.286, body_spacing=0.165, overhang=0.0275, width=0.03)
    assert np.diff(timing_of(March(small, turns=16), Film(until=60)).times).max() <= 0.08


def test_first_contact_is_searched_for_once_in_a_film(seed, tmp_path, monkeypatch, call):
    starts = []

    def counted(march, *, start=0.0, **options):
        starts.append(start)
        return first_contact(march, start=start, **options)

    monkeypatch.setattr("pymunk_dragon.drawing.film.take.first_contact", counted)
    march = March(Dragon(benches=16), turns=5)
    calls = [
        (march, {}),
        (march, {"until": 20.0}),
        (march, {"until": 20.0, "speedup": 4.0}),
        (seed, {"start": 411.0}),
        ([seed, seed.march], {"start": 411.0}),
        ([seed, seed.march], {"start": 411.0, "speedup": 4.0}),
    ]
    for source, parameters in calls:
        starts.clear()
        render(source, tmp_path / "film.gif", size=64, fps=1, **parameters)
        assert starts == [parameters.get("start", 0.0)], parameters
    # The contact of a run is known.
    starts.clear()
    render(seed, tmp_path / "film.gif", size=64, fps=1, start=411.0, speedup=4.0)
    assert starts == []
    for options in ([], ["--until", "20"]):
        starts.clear()
        arguments = ["render", "--benches", "16", "--turns", "5", "--size", "64", *options]
        assert call(*arguments, "-o", str(tmp_path / "film.gif"))[0] == 0
        assert starts == [0.0]


def test_march_is_shown_until_its_first_contact_or_for_a_minute(tmp_path):
    options = {"size": 64, "fps": 1, "speedup": 20.0}
    march = March(Dragon(benches=16), turns=5)
    hit = first_contact(march)
    assert hit.status == "contact"
    assert render(march, tmp_path / "film.gif", **options).times[-1] == hit.time
    endless = March(Dragon(benches=16), UTurn())
    assert render(endless, tmp_path / "film.gif", start=-10.0, **options).times[-1] == 50.0


def test_film_slows_down_once_for_the_events_of_all_its_sources(seed):
    film = Film(start=300)
    played = timing_of(seed, film).times
    exact = timing_of(March(), replace(film, until=412.4739)).times
    np.testing.assert_allclose(played, exact, atol=1e-3)
    # An unguided run does not have the near misses of the exact model.
    unguided = replace(seed, provenance={"player": "pymunk", "guide": "none", "free_from": 1})
    fewer = len(played) - len(timing_of(unguided, film).times)
    assert fewer == pytest.approx(2 * film.fps, rel=0.1)
    later = replace(seed, first_contact=replace(seed.first_contact, time=CONTACT - 1e-4))
    assert np.array_equal(
        timing_of([seed, later, seed.march], film).times, timing_of(later, film).times
    )


def test_two_runs_stand_side_by_side_from_the_same_distance_until_both_are_over(run, tmp_path):
    other = Run.exact(March(Dragon(benches=30), turns=4), np.linspace(0, 10, 11))
    both = still([run, other], 4.0, Film(size=120, headings=("left", "right")))
    # The wider field of the two is that of the second, which therefore looks as it does alone.
    np.testing.assert_array_equal(both[-120:, -120:], still(other, 4.0, Film(size=120)))
    assert not np.array_equal(both[-120:, :120], still(run, 4.0, Film(size=120)))
    short = Run.exact(MARCH, np.linspace(0, 3, 31))
    render([short, run], tmp_path / "film.gif", Film(size=96, fps=10, speedup=10, camera=HEAD))
    shown = [picture for picture, _ in frames(tmp_path / "film.gif")]
    assert len(shown) == 11
    assert all(np.array_equal(picture[:, :96], shown[3][:, :96]) for picture in shown[3:])
    assert not np.array_equal(shown[3][:, -96:], shown[4][:, -96:])


def test_picture_of_a_march_that_ends_with_its_first_contact_shows_the_contact():
    (take,) = takes_of_film(checked_sources(March(Dragon(benches=16))), Film(), still=True)
    assert take.contact is not None
    assert take.window == (take.contact.time, take.contact.time)


def test_title_and_caption_stand_outside_the_picture_in_as_many_lines_as_they_need(run):
    plain = still(run, 4.0, Film(size=200))
    titled = still(run, 4.0, Film(size=200, title="A title", caption="A caption"))
    assert any(
        np.array_equal(titled[top : top + 200], plain) for top in range(1, len(titled) - 200)
    )
    heights = [
        len(still(run, 4.0, Film(size=200, caption=text)))
        for text in ("word ", "word " * 40, "w" * 60)
    ]
    assert heights[0] < min(heights[1:])
    assert UNKNOWN in str(refusal(still, run, 4.0, Film(title=UNKNOWN)))


def brute_force(text, height, width):
    """Lines with the most characters with which all are narrow enough, found one by one."""
    for columns in range(max(1, len(text)), 0, -1):
        lines = [lettering.line(part, height) for part in textwrap.wrap(text, columns)]
        if all(each.width <= width for each in lines):
            break
    return lines


def test_title_has_the_longest_lines_that_fit():
    for text in (
        "",
        "A title",
        "Benches, in contact " * 3,
        "w" * 50,
        "well-known co-operation i W " * 2 + "x" * 30,
    ):
        for height, width in ((15, 64), (20, 150), (31, 400)):
            found, expected = (
                wrap(text, height, width) for wrap in (lettering.wrapped, brute_force)
            )
            assert list(map(np.array_equal, found, expected)) == [True] * len(expected), (
                text,
                height,
                width,
            )


def test_work_for_a_title_of_one_word_grows_with_its_length_only(monkeypatch):
    measured = []
    getbbox = ImageFont.FreeTypeFont.getbbox

    def counted(font, text, *more):
        measured.append(len(text))
        return getbbox(font, text, *more)

    monkeypatch.setattr(ImageFont.FreeTypeFont, "getbbox", counted)
    sums = []
    for length in (500, 4000):
        measured.clear()
        assert len(lettering.wrapped("m" * length, 20, 440)) > 10
        sums.append(sum(measured))
    assert sums[1] < 12 * sums[0]


def test_title_that_no_film_can_hold_is_refused(run):
    assert refusal(still, run, 4.0, Film(size=64, title="m" * 5000)).name == "title"
    assert len(still(run, 4.0, Film(size=64, caption="m" * 500))) > 4000


def test_chinese_title_needs_the_font_and_not_the_language(run, monkeypatch):
    chinese = "\u677f\u51f3\u9f99 3"
    shown = still(run, 4.0, Film(size=200, title=chinese))
    with in_language("zh"):
        expected = still(run, 4.0, Film(size=200, title=chinese))
    np.testing.assert_array_equal(shown[:-200], expected[:-200])
    monkeypatch.setattr("pymunk_dragon._language.find_spec", lambda name: None)
    refused = refusal(still, run, 4.0, Film(size=200, title=chinese))
    assert refused.name == "title"
    assert "pymunk-dragon[chinese]" in str(refused)


# Pictures of the dragon: colours, sizes, texts, marks, and other marches than the paper's


@pytest.fixture
def texts(monkeypatch):
    """Lines that are written into pictures."""
    written = []
    line = lettering.line
    monkeypatch.setattr(
        lettering, "line", lambda text, height: written.append(text) or line(text, height)
    )
    return written


def displaced(run):
    """A run with position errors that grow towards the tail."""
    poses = run.poses.copy()
    poses[..., 0] += np.linspace(0, 20e-6, poses.shape[1])
    drift = np.abs(poses[..., 0] - run.poses[..., 0])
    return replace(run, poses=poses, drift=drift, provenance={"player": "pymunk", "guide": "rails"})


def shown(source, time, film):
    """A picture, and where points of the ground lie on it."""
    [scene] = layout_of(source, np.array([time]), film).scenes
    [state] = scene.source.at(np.array([time]))
    layer = scene.layer(*state)
    return still(source, time, film), lambda points: layer.pixels(points) / BLOCK


def count(picture, name):
    """How many pixels of a picture have a colour of the palette."""
    return int(np.all(picture == getrgb(getattr(COLOURS, name)), axis=-1).sum())


def near(picture, xy, size=1):
    """Pixels at `xy` and beside it."""
    x, y = (int(v) for v in xy)
    return picture[max(y - size, 0) : y + size + 1, max(x - size, 0) : x + size + 1]


def test_table_of_films_has_every_colour_of_pictures(seed):
    assert len(colour_table()) <= 255
    table = colour_table().astype(int)
    for camera in (Camera(), HEAD):
        pixels = still(seed, CONTACT, Film(camera=camera)).reshape(-1, 3)
        colours, counts = np.unique(pixels, axis=0, return_counts=True)
        off = np.abs(colours[:, None] - table).max(axis=-1).min(axis=-1)
        # But for rare mixtures of three colours.
        assert (off.max() <= 32, counts[off > 16].sum() < len(pixels) / 1000) == (True, True)


def test_each_colour_of_the_table_is_written_as_it_is(run, monkeypatch):
    layout = layout_of(run, np.zeros(1), Film(size=64))
    table = Image.fromarray(colour_table()[None])
    monkeypatch.setattr(layout, "frames", lambda: iter([table]))
    [picture] = layout.pictures(None)
    np.testing.assert_array_equal(np.asarray(picture)[0], np.arange(len(colour_table())))
    np.testing.assert_array_equal(np.asarray(picture.convert("RGB")), np.asarray(table))


def test_no_two_bench_colours_look_alike_to_anyone_or_in_grey():
    # Machado, Oliveira and Fernandes 2009, severity 1, on linear light.
    visions = {
        "normal": np.eye(3),
        "deuteranope": np.array(
            [[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]]
        ),
        "protanope": np.array(
            [[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]]
        ),
    }
    colours = np.array(
        [
            getrgb(getattr(COLOURS, name))
            for name in ("head", "body", "tail", "contact", "background")
        ]
    )
    for vision, matrix in visions.items():
        seen = 255 * np.clip((colours / 255) ** 2.2 @ matrix.T, 0, 1) ** (1 / 2.2)
        distances = np.linalg.norm(seen[:, None] - seen[None], axis=-1)[
            np.triu_indices(len(seen), 1)
        ]
        assert distances.min() > 60, vision
    assert np.diff(np.sort(colours @ (0.299, 0.587, 0.114))).min() > 255 / 7


def test_bad_cameras_marks_and_times_are_refused(run, tmp_path):
    cases = [
        (name, Camera, {name: value})
        for name, value in [("span", 0), ("span", float("inf")), ("follow", "tail")]
    ]
    cases += [("time", still, {"source": run, "time": 11.0})]
    cases += [("until", render, {"source": run, "until": 11.0, "path": tmp_path / "still.png"})]
    for mark in ("contacts", "forces"):
        cases += [("show", still, {"source": MARCH, "time": 1.0, "film": Film(show=(mark,))})]
    for name, call, arguments in cases:
        assert refusal(call, **arguments).name == name
    render(run, tmp_path / "still.png", size=120, until=4.0)
    np.testing.assert_array_equal(
        iio.imread(tmp_path / "still.png"), still(run, 4.0, Film(size=120))
    )


def test_camera_stays_above_the_head_or_shows_every_bench(run):
    for time in (0.0, 3.3, 10.0):
        picture, _ = shown(run, time, Film(size=200, camera=HEAD))
        np.testing.assert_array_equal(picture[100, 100], getrgb(COLOURS.head))
        _, place = shown(run, time, Film(size=(300, 200)))
        corners = place(MARCH.dragon.outlines(run.poses_at([time])[0])).reshape(-1, 2)
        assert np.all((corners > 0) & (corners < (300, 200)))
    for march, metres in ((MARCH, 6.0), (TRACTOR, 36.0), (ARM, 1.0)):
        _, place = shown(march, 0.5, Film(size=600, camera=HEAD))
        (x0, _), (x1, _) = place([(0.0, 0.0), (1.0, 0.0)])
        assert 600 / (x1 - x0) == pytest.approx(metres)


def test_legend_and_scale_bar_are_below_the_picture(texts):
    film = Film(size=480, camera=Camera(follow="head", span=6.0))
    with_legend, without = still(MARCH, 1.0, film), still(MARCH, 1.0, replace(film, legend=False))
    assert without.shape == still(MARCH, 1.0, Film(size=480, legend=False)).shape == (480, 480, 3)
    np.testing.assert_array_equal(with_legend[:480], without)
    assert [count(with_legend[480:], name) > 50 for name in ("head", "body", "tail")] == [
        True,
        True,
        False,
    ]
    assert {"head", "body", "1 m", "head 1.00 m/s"} <= set(texts)
    assert not {"in contact", "tail"} & set(texts)  # neither is in view
    # The longest horizontal line of the strip, with its ends, is as long as it says.
    strip = np.all(with_legend[480:] == getrgb(COLOURS.ink), axis=-1)
    longest = max(
        len(run) for row in strip for run in "".join(" x"[int(pixel)] for pixel in row).split()
    )
    assert longest - 1 == round(480 / 6.0)
    assert still(MARCH, 1.0, Film(size=200)).shape == (200, 200, 3)  # too narrow for a legend


def test_contact_and_near_misses_are_named(seed, texts):
    still(seed, CONTACT, Film(size=400))
    assert {"in contact", "contact: benches 0 and 8"} <= set(texts)
    run = replace(seed, first_contact=None)
    for time, bench, gap in ((406.8466, 9, 3.0), (409.8320, 11, 0.9)):
        still(run, time, Film(size=440, legend=False))
        assert f"gap {gap} mm to bench {bench}" in texts


def test_exact_model_beside_a_run_shows_the_position_errors_of_the_run(run, texts):
    for camera, factor in ((Camera(), "80,000"), (HEAD, "20,000")):
        picture = still([displaced(run), MARCH], 5.0, Film(size=300, camera=camera))
        assert f"position error x {factor}" in texts
        assert count(picture[:260, :300], "motion") == 0
        assert count(picture[:260, 302:], "motion") > 100


def test_pictures_look_as_they_did(seed, golden):
    films = {
        "field": (seed, Film(size=330, show=("velocities", "grid"))),
        "contact": (seed, Film(size=330, camera=HEAD, show=("grid", "contacts"))),
        "u-turn": (
            March(Dragon(benches=40), UTurn()),
            Film(size=(330, 200), title="A turn", camera=Camera(span=20.0)),
        ),
    }
    for name, (source, film) in films.items():
        time = CONTACT if source is seed else 20.0
        golden(Image.fromarray(still(source, time, film)), f"films/{name}")
    if features.check("raqm"):  # Without FriBidi on the system, Pillow spaces Chinese otherwise.
        with in_language("zh"):
            film = Film(size=330, camera=HEAD, title="\u677f\u51f3\u9f99")
            golden(
                Image.fromarray(still([displaced(seed), seed.march], 410.0, film)), "films/errors"
            )


def test_contacts_are_shown_while_benches_touch(seed, small_run):
    [window] = [window for window in small_run.events.windows() if window.end is not None]
    film = Film(size=200, camera=HEAD, show=("contacts",))
    middle = (window.begin + window.end) / 2
    for time, touching in (
        (window.begin - 0.05, False),
        (middle, True),
        (window.end + 0.05, False),
    ):
        assert (count(still(small_run, time, film), "force") > 0) is touching
    # Where nothing is logged, the refined first contact is shown.
    picture, place = shown(seed, CONTACT, film)
    assert count(near(picture, place([seed.first_contact.point])[0]), "force") == 9


def test_area_of_a_disc_is_in_proportion_to_the_force_of_the_frame_before(run):
    sizes = np.full((len(run.times), 15), 1.0)
    sizes[:, 0] = 4.0
    film = Film(size=1200, camera=Camera(follow="head", span=8.0), show=("forces",))
    picture, place = shown(replace(run, joint_forces=sizes), 5.0, film)
    _, rear = MARCH.dragon.holes(run.poses_at([5.0])[0])
    areas = [count(near(picture, xy, 40), "force") for xy in place(rear[:2])]
    assert areas[0] / areas[1] == pytest.approx(4.0, rel=0.1)
    pulled = replace(run, joint_forces=np.where(run.times >= 5, 1.0, 0.0)[:, None] * np.ones(15))
    assert [count(still(pulled, time, film), "force") > 1000 for time in (4.999, 5.0)] == [
        False,
        True,
    ]
