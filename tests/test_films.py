"""Films in every format: what is in the file, how long it plays, which part it shows, and what stands side by side."""

from __future__ import annotations

import gc
import subprocess
import sys
import weakref
from dataclasses import replace
from pathlib import Path

import imageio.v3 as iio
import imageio_ffmpeg
import matplotlib
import numpy as np
import pytest
from conftest import assert_says
from PIL import Image

from pymunk_dragon import Camera, Contact, Dragon, March, Run, SpeedTable
from pymunk_dragon._language import in_language
from pymunk_dragon.drawing import FILM_ENDINGS, Film, render, still, write_film
from pymunk_dragon.drawing.film.formats import WRITERS, Frames
from pymunk_dragon.drawing.film.layout import lay_out
from pymunk_dragon.drawing.film.timing import events_of
from pymunk_dragon.drawing.snapshots import sample, snapshots
from pymunk_dragon.errors import DragonError, MissingExtraError, OutputError, ParameterError

MARCH = March(Dragon(benches=16), turns=4)
HEAD = Camera(follow="head")
# Every pixel is stored as it was drawn, and a file says how long each frame stays.
LOSSLESS = [".gif", ".apng", ".webp"]
NEAR_MISSES = (406.8466, 409.8320)
CONTACT = 412.4738


@pytest.fixture(scope="module")
def run():
    return Run.exact(MARCH, np.linspace(0, 10, 101))


@pytest.fixture(scope="module")
def reference():
    """The paper's march until its contact."""
    return with_contact(Run.exact(March(), np.append(np.arange(0, 412.0, 2.0), CONTACT)), CONTACT)


def with_contact(run, time):
    contact = Contact(time=time, raw_time=time, benches=(0, 8), point=(1.5, 2.1), normal=(0, 1), depth=0)
    return replace(run, first_contact=contact, outcome="contact")


def frames(path):
    """Every frame of a lossless film as RGB, and how long it stays in ms."""
    with Image.open(path) as film:
        assert film.info["loop"] == 0  # for ever
        for i in range(film.n_frames):
            film.seek(i)
            yield np.asarray(film.convert("RGB")), film.info["duration"]


def drawn(source, film):
    times = film.timing([source]).times
    canvas = lay_out([sample(source, times, film.show, extent=film.camera.follow == "field")], film)
    for snapshot in snapshots(source, times, film.show):
        yield film.palette.table[np.asarray(canvas.draw([snapshot]))]


def write_pictures(path, pictures, ends, fps):
    size, colours = pictures[0].size, Film().palette.table
    WRITERS[path.suffix](path, Frames(pictures=iter(pictures), ends=ends, size=size, colours=colours, fps=fps))


def test_file_shows_exactly_what_was_drawn_for_as_long_as_it_should(run, tmp_path):
    for ending in LOSSLESS:
        for size, fps in (((160, 120), 10), ((97, 131), 7), ((64, 64), 24)):
            path, told = tmp_path / f"film{ending}", []
            film = Film(size=size, fps=fps, speedup=5, hold=1.5, camera=HEAD, show=("velocities", "grid"))
            write_film(run, path, film, progress=lambda *step, told=told: told.append(step))
            shown, expected = list(frames(path)), list(drawn(run, film))
            assert sum(ms for _, ms in shown) == 10 / 5 * 1000 + 1500, (ending, fps)
            assert told == [(i + 1, len(expected)) for i in range(len(expected))]
            for (picture, _), frame in zip(shown, expected, strict=True):
                np.testing.assert_array_equal(picture, frame)


def test_same_film_twice_is_the_same_file(run, tmp_path):
    for ending in FILM_ENDINGS:
        for name in ("one", "two"):
            render(run, tmp_path / f"{name}{ending}", size=64, fps=10, speedup=5)
        assert (tmp_path / f"one{ending}").read_bytes() == (tmp_path / f"two{ending}").read_bytes()


def test_march_gives_the_same_film_as_its_exact_run(tmp_path):
    film = Film(size=96, start=0, until=6, speedup=10)
    write_film(MARCH, tmp_path / "march.gif", film)
    write_film(Run.exact(MARCH, film.timing([MARCH]).times), tmp_path / "run.gif", film)
    assert (tmp_path / "march.gif").read_bytes() == (tmp_path / "run.gif").read_bytes()


def test_equal_frames_become_one_and_a_very_long_one_is_shown_twice(tmp_path):
    first, second = Image.new("L", (32, 32), 55), Image.new("L", (32, 32), 55)
    second.paste(47, (11, 11, 12, 12))
    table = Film().palette.table
    for ending in LOSSLESS:
        path = tmp_path / f"film{ending}"
        write_pictures(path, (first, first, first, second, second), [0.1 * i for i in range(1, 6)], fps=10)
        shown = list(frames(path))
        assert [ms for _, ms in shown] == [300, 200]
        for (picture, _), frame in zip(shown, (first, second), strict=True):
            np.testing.assert_array_equal(picture, table[np.asarray(frame)])
        # Two whole delays of GIF (655 s).
        write_pictures(path, [first, *[second] * 20], range(1, 1260, 60), fps=1)
        shown = list(frames(path))
        assert sum(ms for _, ms in shown) == 1_201_000
        assert len(shown) < 25
        for (picture, _), frame in zip(shown, [first, *[second] * 24], strict=False):
            np.testing.assert_array_equal(picture, table[np.asarray(frame)])


def test_mp4_is_h264_and_shows_the_frames_in_their_colours(run, tmp_path):
    path = tmp_path / "film.mp4"
    film = Film(size=(319, 239), fps=10, speedup=5, hold=0.5, camera=HEAD, gap=False, legend=False)
    write_film(run, path, film)
    about = iio.immeta(path, plugin="FFMPEG")
    # An odd number of pixels becomes even.
    assert (about["codec"], about["fps"], about["size"]) == ("h264", 10, (320, 240))
    assert about["pix_fmt"] == "yuv420p(tv, bt709, progressive)"
    assert about["duration"] == pytest.approx(10 / 5 + 0.5, abs=0.1)
    expected = list(drawn(run, film))
    # FFmpeg itself: imageio's reader leaves its pipes open.
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-i", path, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    pixels = subprocess.run(command, check=True, capture_output=True).stdout
    shown = np.frombuffer(pixels, dtype=np.uint8).reshape(-1, 240, 320, 3)[:, :239, :319]
    assert len(shown) >= len(expected) == 21
    for picture, frame in zip(shown, expected, strict=False):
        error = np.abs(picture.astype(int) - frame)
        # Outlines lose half of their colour's resolution; areas keep their colours.
        assert np.median(error.max(axis=-1)) <= 2
        assert error.mean() < 3
        head = np.all(frame == film.palette.rgb("head"), axis=-1)
        assert np.abs(np.median(picture[head], axis=0) - film.palette.rgb("head")).max() <= 3


def test_no_more_than_a_few_frames_are_alive_at_once(run, tmp_path, monkeypatch):
    reduce, alive, most = Image.Image.reduce, [], []

    def counted(image, factor):
        picture = reduce(image, factor)
        alive.append(weakref.ref(picture))
        gc.collect()
        most.append(sum(ref() is not None for ref in alive))
        return picture

    monkeypatch.setattr(Image.Image, "reduce", counted)
    gc.freeze()  # What was there before needs no search.
    for ending in FILM_ENDINGS:
        render(run, tmp_path / f"film{ending}", size=64, fps=10, speedup=8)
    gc.unfreeze()
    assert len(alive) == 14 * len(FILM_ENDINGS)
    assert max(most) <= 4


@pytest.mark.thorough
def test_defaults_film_the_papers_march_in_3_megabytes(tmp_path):
    render(March(), tmp_path / "march.gif", until=CONTACT)
    assert (tmp_path / "march.gif").stat().st_size <= 3_000_000


def test_film_that_is_broken_off_leaves_the_old_one(run, tmp_path):
    for ending in FILM_ENDINGS:
        for failure in (KeyboardInterrupt, RuntimeError):
            path = tmp_path / f"film{ending}"
            path.write_bytes(b"old")

            def stop(done, total, failure=failure):
                if done == 3:
                    raise failure

            with pytest.raises(failure):
                render(run, path, size=64, progress=stop)
            assert path.read_bytes() == b"old"
            assert list(tmp_path.iterdir()) == [path]
            path.unlink()


def test_full_disk_and_missing_ffmpeg_are_told(run, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(MissingExtraError, match=r"pymunk-dragon\[mp4\]"):
        render(run, tmp_path / "film.mp4")
    for ending in LOSSLESS:
        monkeypatch.setitem(WRITERS, ending, full)
        with pytest.raises(OutputError, match="No space left"):
            render(run, tmp_path / f"film{ending}", size=64)
    assert list(tmp_path.iterdir()) == []


def test_bad_parameters_are_refused(run, tmp_path):
    cases = [("fps", value) for value in (51, 24.5, 0, "fast", True)]
    cases += [("speedup", value) for value in (0, float("nan"), 1e-5)]
    cases += [("size", value) for value in (63, 5000, (640, 0), (640, 640, 3), 640.5)]
    cases += [("hold", -1), ("hold", float("inf")), ("start", -1), ("start", float("nan")), ("until", 11)]
    cases += [("title", 3), ("title", "\u9f99"), ("caption", "x" * 501), ("camera", "head"), ("palette", "red")]
    cases += [("headings", value) for value in (("a", None), ("one", "too many"), ("\u9f99",))]
    cases += [("show", value) for value in (("shadows",), "grid", ("impulses",))]
    cases += [("workers", value) for value in (-1, 1.5, "two", 1000)]
    calls = [(name, run, "film.gif", {name: value}) for name, value in cases]
    calls += [("until", run, "film.gif", {"start": 5, "until": 4}), ("until", MARCH, "film.gif", {})]
    calls += [("font", run, "film.gif", {"title": "Dragon", "font": font}) for font in ("nowhere.ttf", __file__)]
    calls += [("output", run, name, {}) for name in ("film.avi", "film", "nowhere/film.gif")]
    calls += [("source", source, "film.gif", {"until": 1}) for source in ([], "run.npz", [1], [MARCH] * 5, None)]
    for name, source, file, options in calls:
        with pytest.raises(ParameterError) as caught:
            render(source, tmp_path / file, **options)
        assert caught.value.name == name, options
        assert_says(caught.value)
    with pytest.raises(DragonError):  # past the end of the curve
        render(MARCH, tmp_path / "film.gif", until=1000)
    # More than the memory holds.
    with pytest.raises(ParameterError, match="238 in an APNG of 2048 x 2048 pixels"):
        render(run, tmp_path / "film.apng", size=2048, speedup=0.4, legend=False)
    assert list(tmp_path.iterdir()) == []
    render(run, tmp_path / "film.webp", fps=60, until=0.5, speedup=1, size=64)


def long_film(path, speed=1.0, **options):
    march = March(Dragon(benches=3), turns=4, speed=speed)
    render(march, path, until=16, speedup=0.5, size=64, show=("grid",), title="In parts", **options)


@pytest.mark.thorough
def test_several_processes_make_the_same_film(tmp_path):
    for ending in LOSSLESS:
        with in_language("en" if ending == ".webp" else "zh"):
            for workers in (0, 2):
                long_film(tmp_path / f"{workers}{ending}", workers=workers)
        assert (tmp_path / f"0{ending}").read_bytes() == (tmp_path / f"2{ending}").read_bytes()
    # A march that cannot be handed over is filmed by one process.
    for workers in (0, 2):
        long_film(tmp_path / f"{workers}.gif", speed=lambda t: 1 + 0 * t, workers=workers)
    assert (tmp_path / "0.gif").read_bytes() == (tmp_path / "2.gif").read_bytes()


def test_film_by_several_processes_can_be_broken_off(tmp_path):
    def stop(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        long_film(tmp_path / "film.gif", workers=2, progress=stop)
    assert list(tmp_path.iterdir()) == []


def travel(timing):
    """Travel of the head per frame, m, at 1 m/s."""
    return np.diff(timing.times)


def test_film_of_the_paper_s_march_is_short_and_slows_down_towards_near_misses_and_contact(reference):
    timing = Film().timing([reference])
    assert 8 <= timing.ends[-1] <= 20
    assert timing.fps >= 20
    assert 0 < travel(timing).min() < travel(timing).max() <= 0.8
    assert timing.times[-1] == CONTACT
    np.testing.assert_allclose(np.diff(timing.ends[:-1]), 1 / timing.fps)
    assert timing.ends[-1] - timing.ends[-2] == pytest.approx(2.5)
    near = {time: travel(timing)[np.searchsorted(timing.times, time) - 2] for time in (*NEAR_MISSES, CONTACT)}
    assert max(near.values()) < travel(timing).max() / 4
    between = travel(timing)[np.searchsorted(timing.times, np.mean(NEAR_MISSES)) - 2]
    assert between > 1.5 * max(near[time] for time in NEAR_MISSES)
    assert np.abs(np.diff(travel(timing))).max() < travel(timing).max() / 8


def test_given_parameters_of_the_time_are_kept(reference, run):
    timing = Film(start=0).timing([reference])
    assert timing.times[0] == 0
    assert timing.ends[-1] <= 20
    assert 100 % timing.fps == 0  # Delays in a GIF are whole centiseconds.
    timing = Film(camera=HEAD).timing([reference])
    assert 8 <= timing.ends[-1] <= 20
    assert travel(timing).max() <= 0.2
    timing = Film(fps=10).timing([reference])
    assert timing.fps == 10
    assert travel(timing).max() <= 0.8
    timing = Film(speedup=20).timing([reference])
    assert timing.times[0] == 0
    np.testing.assert_allclose(np.diff(timing.times)[:-1], 1)
    assert Film(fps=10, speedup=3).timing([run]).times[-1] == run.times[-1]
    np.testing.assert_allclose(Film(fps=10, speedup=10, start=3, until=6).timing([run]).times, [3, 4, 5, 6])


def test_films_of_short_and_long_and_changing_marches_have_a_bearable_length(run):
    assert Film().timing([run]).ends[-1] == pytest.approx(8)
    # Half of real time, and the last frame.
    assert Film(until=1.0).timing([MARCH]).ends[-1] == pytest.approx(2 * 1.0 + 2.5)
    long = Film(start=0).timing([Run.exact(March(Dragon(benches=3), turns=80), np.linspace(0, 8000, 101))])
    assert (long.fps, long.ends[-1]) == (50, pytest.approx(20, abs=0.05))
    march = March(Dragon(benches=16), turns=16, speed=SpeedTable((0, 100, 200), (0.2, 2.0, 0.2)))
    changing = Film().timing([Run.exact(march, np.linspace(0, 200, 101))])
    assert np.diff(march.distance(changing.times)).max() <= 0.8
    small = Dragon(benches=16, head_spacing=0.286, body_spacing=0.165, overhang=0.0275, width=0.03)
    assert travel(Film(until=60).timing([March(small, turns=16)])).max() <= 0.08


def test_events_are_the_near_misses_and_contacts_of_each_run_once(reference):
    for source in (reference, March()):
        events = events_of([source], (400 * (source is reference), 412.4738376821))
        assert [event.time for event in events] == pytest.approx([*NEAR_MISSES, CONTACT], abs=1e-3)
    # An unguided run does not have those of the exact model.
    unguided = replace(reference, provenance={"player": "pymunk", "guide": "none"})
    assert [event.time for event in events_of([unguided], (400, 412.5))] == [CONTACT]
    later = with_contact(replace(reference, first_contact=None), CONTACT - 1e-4)
    assert events_of([reference, later, reference.march], (0, CONTACT)) == events_of([later], (0, CONTACT))


def test_delays_in_a_gif_are_those_of_the_film(tmp_path):
    assert write_film(MARCH, tmp_path / "one.gif", Film(size=64, start=3, until=3)).times.tolist() == [3]
    timing = write_film(MARCH, tmp_path / "film.gif", Film(size=64, until=18))
    delays = [ms for _, ms in frames(tmp_path / "film.gif")]
    assert sum(delays) == pytest.approx(1000 * timing.ends[-1])
    assert delays[-1] == 2500
    assert set(delays[:-1]) == {50}


def test_two_runs_stand_side_by_side_from_the_same_distance_until_both_are_over(run, tmp_path):
    other = Run.exact(March(Dragon(benches=30), turns=4), np.linspace(0, 10, 11))
    both = still([run, other], 4.0, Film(size=120, headings=("left", "right")))
    assert both.shape[1] == 2 * 120 + 2
    # The wider field of the two is that of the second, which therefore looks as it does alone.
    np.testing.assert_array_equal(both[-120:, -120:], still(other, 4.0, Film(size=120)))
    assert not np.array_equal(both[-120:, :120], still(run, 4.0, Film(size=120)))
    short = Run.exact(MARCH, np.linspace(0, 3, 31))
    write_film([short, run], tmp_path / "film.gif", Film(size=96, fps=10, speedup=10, camera=HEAD))
    shown = [picture for picture, _ in frames(tmp_path / "film.gif")]
    assert len(shown) == 11
    for picture in shown[3:]:
        np.testing.assert_array_equal(picture[:, :96], shown[3][:, :96])
    assert not np.array_equal(shown[3][:, -96:], shown[4][:, -96:])
    assert Film(speedup=10).timing([run, run.march]).times[[0, -1]].tolist() == [0.0, 10.0]


def test_title_and_caption_stand_outside_the_picture_in_as_many_lines_as_they_need(run):
    plain = still(run, 4.0, Film(size=200))
    titled = still(run, 4.0, Film(size=200, title="A title", caption="A caption"))
    extra = len(titled) - len(plain)
    assert sum(np.array_equal(titled[top : top + 200], plain) for top in range(1, extra)) > 0
    pictures = [still(run, 4.0, Film(size=200, caption=caption)) for caption in ("word ", "word " * 40, "w" * 60)]
    for picture in pictures[1:]:
        assert len(picture) > len(pictures[0])
        assert np.all(picture[200:, -3:] == Film().palette.rgb("background"))
    face = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"
    with pytest.raises(ParameterError, match="lacks '\N{GREEK SMALL LETTER THETA}'"):
        still(run, 4.0, Film(size=200, title="\N{GREEK SMALL LETTER THETA}"))
    assert len(still(run, 4.0, Film(size=200, title="\N{GREEK SMALL LETTER THETA}", font=face))) > 200
    with in_language("zh"):
        assert len(still(run, 4.0, Film(size=200, title="\u677f\u51f3\u9f99"))) > 200
