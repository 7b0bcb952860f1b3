"""Films in every format: what is in the file, how long it plays, and what stands side by side."""

from __future__ import annotations

import gc
import inspect
import subprocess
import sys
import weakref
from collections.abc import Iterator, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import imageio.v3 as iio
import imageio_ffmpeg
import matplotlib
import numpy as np
import pytest
from conftest import assert_says
from numpy.typing import NDArray
from PIL import Image

from pymunk_dragon.drawing import FILM_ENDINGS, Camera, Film, render, still, write_film
from pymunk_dragon.drawing.film.formats import WRITERS, Frames
from pymunk_dragon.drawing.film.layout import Canvas, lay_out
from pymunk_dragon.drawing.snapshots import sample, snapshots
from pymunk_dragon.errors import MissingExtraError, OutputError, ParameterError
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

Picture = NDArray[np.uint8]

MARCH = March(Dragon(benches=16), turns=4)
# Every pixel is stored as it was drawn, and a file says how long each frame stays.
LOSSLESS = [".gif", ".apng", ".webp"]
in_every_format = pytest.mark.parametrize("ending", FILM_ENDINGS)
in_every_lossless_format = pytest.mark.parametrize("ending", LOSSLESS)


@pytest.fixture(scope="module")
def run() -> Run:
    return Run.exact(MARCH, np.linspace(0, 10, 101))


def frames(path: Path) -> Iterator[tuple[Picture, float]]:
    """Every frame of a lossless film as RGB, and how long it stays in ms."""
    with Image.open(path) as film:
        for i in range(film.n_frames):
            film.seek(i)
            yield np.asarray(film.convert("RGB")), film.info["duration"]


def write_pictures(path: Path, pictures: Sequence[Image.Image], ends: Sequence[float], fps: int) -> None:
    size, colours = pictures[0].size, Film().palette.table
    WRITERS[path.suffix](path, Frames(pictures=iter(pictures), ends=ends, size=size, colours=colours, fps=fps))


def canvas_of(source: Run | March, film: Film, times: NDArray[np.float64]) -> Canvas:
    return lay_out([sample(source, times, film.show, extent=film.camera.follow == "field")], film)


def drawn(source: Any, film: Film) -> Iterator[Picture]:
    times = film.timing([source]).times
    canvas = canvas_of(source, film, times)
    for snapshot in snapshots(source, times, film.show):
        yield film.palette.table[np.asarray(canvas.draw([snapshot]))]


@in_every_lossless_format
@pytest.mark.parametrize("size", [(160, 120), (97, 131)])
def test_a_file_shows_exactly_what_was_drawn(run: Run, tmp_path: Path, ending: str, size: tuple[int, int]) -> None:
    path = tmp_path / f"film{ending}"
    film = Film(size=size, fps=10, speedup=5, camera=Camera(follow="head"), show=("velocities", "grid"))
    write_film(run, path, film)
    shown = list(frames(path))
    assert len(shown) == 21
    for (picture, _), frame in zip(shown, drawn(run, film), strict=True):
        np.testing.assert_array_equal(picture, frame)


@in_every_lossless_format
@pytest.mark.parametrize("fps", [1, 7, 24, 30, 50])
def test_a_film_is_as_long_as_its_time_over_the_speedup_and_the_hold(
    run: Run, tmp_path: Path, ending: str, fps: int
) -> None:
    path = tmp_path / f"film{ending}"
    render(run, path, fps=fps, speedup=4, hold=1.5, size=96)
    assert sum(ms for _, ms in frames(path)) == 10 / 4 * 1000 + 1500


@in_every_lossless_format
def test_a_film_plays_for_ever(run: Run, tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"film{ending}"
    render(run, path, until=1, size=96)
    with Image.open(path) as film:
        assert film.info["loop"] == 0


@in_every_lossless_format
def test_frames_alike_become_one_that_stays_as_long(tmp_path: Path, ending: str) -> None:
    first, second = Image.new("L", (32, 32), 55), Image.new("L", (32, 32), 55)
    second.paste(47, (11, 11, 12, 12))
    path = tmp_path / f"film{ending}"
    table = Film().palette.table
    pictures = (first, first.copy(), first.copy(), second, second.copy())
    write_pictures(path, pictures, [0.1 * i for i in range(1, 6)], fps=10)
    shown = list(frames(path))
    assert [ms for _, ms in shown] == [300, 200]
    for (picture, _), frame in zip(shown, (first, second), strict=True):
        np.testing.assert_array_equal(picture, table[np.asarray(frame)])


@in_every_lossless_format
def test_a_frame_that_stays_longer_than_the_format_can_say_is_shown_twice(tmp_path: Path, ending: str) -> None:
    first, second = Image.new("L", (32, 32), 47), Image.new("L", (32, 32), 55)
    path = tmp_path / f"film{ending}"
    # Two whole delays of GIF (655 s); what is less for the others is a long frame all the same.
    write_pictures(path, [first, *(second.copy() for _ in range(20))], range(1, 1260, 60), fps=1)
    shown = list(frames(path))
    assert sum(ms for _, ms in shown) == 1_201_000
    assert len(shown) < 25
    table = Film().palette.table
    for (picture, _), frame in zip(shown, [first, *[second] * 24], strict=False):
        np.testing.assert_array_equal(picture, table[np.asarray(frame)])


def test_render_takes_the_parameters_of_a_film_with_their_defaults() -> None:
    taken = {name: value.default for name, value in inspect.signature(render).parameters.items()}
    for parameter in fields(Film):
        assert taken[parameter.name] == parameter.default, parameter.name


def test_a_writer_of_another_format_needs_one_entry(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def write_ends(path: Path, frames: Frames) -> None:
        lines = [f"{end:g} {picture.size}" for picture, end in zip(frames.pictures, frames.ends, strict=True)]
        path.write_text("\n".join(lines))

    monkeypatch.setitem(WRITERS, ".txt", write_ends)
    render(run, tmp_path / "film.txt", fps=10, speedup=50, size=64, hold=0.5)
    assert (tmp_path / "film.txt").read_text() == "0.1 (64, 64)\n0.2 (64, 64)\n0.7 (64, 64)"


def test_an_apng_that_would_fill_the_memory_is_refused(run: Run, tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"must be at most 238 in an APNG of 2048 x 2048 pixels"):
        render(run, tmp_path / "film.apng", size=2048, speedup=0.4, legend=False)
    assert list(tmp_path.iterdir()) == []


def test_an_mp4_is_h264_that_every_player_takes(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    film = Film(size=(161, 121), fps=25, speedup=5, hold=2.0, camera=Camera(follow="head"), gap=False)
    write_film(run, path, film)
    about = iio.immeta(path, plugin="FFMPEG")
    assert about["codec"] == "h264"
    assert about["pix_fmt"] == "yuv420p(tv, bt709, progressive)"
    assert about["fps"] == 25
    # An odd number of pixels becomes even.
    assert about["size"] == (162, 122)
    assert about["duration"] == pytest.approx(10 / 5 + 2.0, abs=0.04)


def test_an_mp4_shows_the_frames_in_their_colours(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    film = Film(size=(320, 240), fps=10, speedup=5, hold=0, camera=Camera(follow="head"), gap=False, legend=False)
    write_film(run, path, film)
    expected = list(drawn(run, film))
    # FFmpeg itself: imageio's reader leaves its pipes open.
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-i", path, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    pixels = subprocess.run(command, check=True, capture_output=True).stdout
    shown = np.frombuffer(pixels, dtype=np.uint8).reshape(-1, 240, 320, 3)
    assert len(shown) == len(expected) == 21
    for picture, frame in zip(shown, expected, strict=True):
        error = np.abs(picture.astype(int) - frame)
        # Outlines lose half of their colour's resolution; areas keep their colours.
        assert np.median(error.max(axis=-1)) <= 2
        assert error.mean() < 3
        head = np.all(frame == film.palette.rgb("head"), axis=-1)
        assert np.abs(np.median(picture[head], axis=0) - film.palette.rgb("head")).max() <= 3


def test_an_mp4_without_ffmpeg_names_the_extra(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(MissingExtraError) as caught:
        render(run, tmp_path / "film.mp4")
    assert_says(caught.value, "pymunk-dragon[mp4]")
    assert list(tmp_path.iterdir()) == []


def test_a_gif_has_at_most_50_frames_a_second_and_others_60(run: Run, tmp_path: Path) -> None:
    render(run, tmp_path / "film.webp", fps=60, until=0.5, speedup=1, size=64)
    with pytest.raises(ParameterError, match=r"fps is 60, but must be at most 50 in a GIF"):
        render(run, tmp_path / "film.gif", fps=60, until=0.5, speedup=1, size=64)


@in_every_format
def test_the_same_film_twice_is_the_same_file(run: Run, tmp_path: Path, ending: str) -> None:
    for name in ("one", "two"):
        render(run, tmp_path / f"{name}{ending}", size=96)
    assert (tmp_path / f"one{ending}").read_bytes() == (tmp_path / f"two{ending}").read_bytes()


@in_every_format
def test_no_more_than_a_few_frames_are_alive_at_once(
    run: Run, tmp_path: Path, ending: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    alive: list[weakref.ref[Image.Image]] = []
    most = 0
    reduce = Image.Image.reduce

    def counted(image: Image.Image, factor: int) -> Image.Image:
        nonlocal most
        picture = reduce(image, factor)
        alive.append(weakref.ref(picture))
        gc.collect()
        most = max(most, sum(ref() is not None for ref in alive))
        return picture

    monkeypatch.setattr(Image.Image, "reduce", counted)
    render(run, tmp_path / f"film{ending}", size=64, fps=10, speedup=8)
    assert len(alive) == 14
    assert most <= 4


@in_every_format
@pytest.mark.parametrize("failure", [KeyboardInterrupt, RuntimeError])
def test_a_film_that_is_broken_off_leaves_the_old_one(
    run: Run, tmp_path: Path, ending: str, failure: type[BaseException]
) -> None:
    path = tmp_path / f"film{ending}"

    def stop(done: int, total: int) -> None:
        if done == 3:
            raise failure

    path.write_bytes(b"old")
    with pytest.raises(failure):
        render(run, path, size=64, progress=stop)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


@in_every_lossless_format
def test_a_full_disk_is_one_line(run: Run, tmp_path: Path, ending: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setitem(WRITERS, ending, full)
    with pytest.raises(OutputError, match="No space left"):
        render(run, tmp_path / f"film{ending}", size=64)
    assert list(tmp_path.iterdir()) == []


# Drawn by several processes


def long_film(path: Path, speed: Any = 1.0, **options: Any) -> None:
    march = March(Dragon(benches=3), turns=4, speed=speed)
    render(march, path, until=16, speedup=0.5, size=64, show=("grid",), title="In parts", **options)


@in_every_lossless_format
def test_several_processes_make_the_same_film(tmp_path: Path, ending: str) -> None:
    long_film(tmp_path / f"one{ending}")
    for workers in (1, 2):
        long_film(tmp_path / f"two{ending}", workers=workers)
        assert (tmp_path / f"one{ending}").read_bytes() == (tmp_path / f"two{ending}").read_bytes()


def test_a_march_that_cannot_be_handed_over_is_filmed_by_one_process(tmp_path: Path) -> None:
    for workers in (0, 2):
        long_film(tmp_path / f"{workers}.gif", speed=lambda t: 1 + 0 * t, workers=workers)
    assert (tmp_path / "0.gif").read_bytes() == (tmp_path / "2.gif").read_bytes()


def test_a_film_by_several_processes_can_be_broken_off(tmp_path: Path) -> None:
    def stop(done: int, total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        long_film(tmp_path / "film.gif", workers=2, progress=stop)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("workers", [-1, 1.5, "two", 1000])
def test_a_number_of_processes_that_is_none_is_bad_input(tmp_path: Path, workers: Any) -> None:
    with pytest.raises(ParameterError, match="workers"):
        long_film(tmp_path / "film.gif", workers=workers)


# Side by side


def test_two_stand_side_by_side_from_the_same_distance(run: Run) -> None:
    other = Run.exact(March(Dragon(benches=30), turns=4), np.linspace(0, 10, 11))
    film = Film(size=120, headings=("left", "right"))
    both = still([run, other], 4.0, film)
    height, width, _ = both.shape
    assert width == 2 * 120 + 2
    assert height > 120
    left, right = both[-120:, :120], both[-120:, -120:]
    # The wider field of the two is that of the second, which therefore looks as it does alone.
    np.testing.assert_array_equal(right, still(other, 4.0, Film(size=120)))
    assert not np.array_equal(left, still(run, 4.0, Film(size=120)))


def test_a_run_that_is_over_stays_as_it_ended(run: Run, tmp_path: Path) -> None:
    short = Run.exact(MARCH, np.linspace(0, 3, 31))
    film = Film(size=96, fps=10, speedup=10, camera=Camera(follow="head"))
    write_film([short, run], tmp_path / "film.gif", film)
    shown = [picture for picture, _ in frames(tmp_path / "film.gif")]
    assert len(shown) == len(film.timing([short, run]).times) == 11
    for picture in shown[3:]:
        np.testing.assert_array_equal(picture[:, :96], shown[3][:, :96])
    assert not np.array_equal(shown[3][:, -96:], shown[4][:, -96:])


def test_a_run_beside_its_exact_model_ends_when_the_run_does(run: Run) -> None:
    times = Film(speedup=10).timing([run, run.march]).times
    assert times[[0, -1]].tolist() == [0.0, 10.0]


def test_headings_say_who_played(run: Run) -> None:
    engine = replace(run, provenance={"player": "pymunk", "guide": "rails"})
    unguided = replace(run, provenance={"player": "pymunk", "guide": "none"})
    assert [sample(source, np.zeros(1)).model for source in (MARCH, run, engine, unguided)] == [
        "exact model",
        "exact model",
        "engine, rails",
        "engine, no guide",
    ]


def test_another_face_has_letters_that_the_usual_one_lacks(run: Run) -> None:
    face = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"
    with pytest.raises(ParameterError, match="lacks 'θ'"):
        still(run, 4.0, Film(size=200, title="θ"))
    titled = still(run, 4.0, Film(size=200, title="θ", font=face))
    assert len(titled) > 200


def test_a_word_too_long_for_a_line_goes_on_in_the_next(run: Run) -> None:
    short, long = (still(run, 4.0, Film(size=200, caption=word)) for word in ("w" * 5, "w" * 60))
    assert len(long) > len(short)
    assert np.all(long[200:, -3:] == Film().palette.rgb("background"))


@pytest.mark.parametrize("sources", [[], "run.npz", [1], [MARCH] * 5, None])
def test_what_is_no_run_and_no_march_is_bad_input(tmp_path: Path, sources: Any) -> None:
    with pytest.raises(ParameterError, match="source") as caught:
        render(sources, tmp_path / "film.gif", until=1)
    assert_says(caught.value)


# Words


def test_title_and_caption_stand_outside_the_picture(run: Run) -> None:
    plain = still(run, 4.0, Film(size=200))
    titled = still(run, 4.0, Film(size=200, title="A title", caption="A caption"))
    extra = len(titled) - len(plain)
    assert extra > 30
    places = [top for top in range(extra + 1) if np.array_equal(titled[top : top + 200], plain)]
    assert len(places) == 1
    top = places[0]
    for band in (titled[:top], titled[top + 200 :]):
        assert len(np.unique(band.reshape(-1, 3), axis=0)) > 5


def test_a_long_caption_takes_as_many_lines_as_it_needs(run: Run) -> None:
    heights = [len(still(run, 4.0, Film(size=200, caption="word " * n))) for n in (1, 20, 40)]
    assert heights[0] < heights[1] < heights[2]
    # All of it is there: no type touches the right edge.
    band = still(run, 4.0, Film(size=200, caption="word " * 40))[200:]
    assert np.all(band[:, -3:] == Film().palette.rgb("background"))


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("title", {"title": 3}),
        ("caption", {"caption": "x" * 501}),
        ("headings", {"headings": ("a", None)}),
        ("headings", {"headings": ("one", "too many")}),
        ("show", {"show": ("shadows",)}),
        ("show", {"show": "grid"}),
        ("camera", {"camera": "head"}),
        ("palette", {"palette": "red"}),
        ("title", {"title": "\u9f99"}),
        ("headings", {"headings": ("\u9f99",)}),
        ("font", {"title": "Dragon", "font": "nowhere.ttf"}),
        ("font", {"title": "Dragon", "font": __file__}),
        ("show", {"show": ("impulses",)}),
    ],
)
def test_bad_words_get_one_line_that_names_them(run: Run, tmp_path: Path, name: str, options: dict[str, Any]) -> None:
    with pytest.raises(ParameterError) as caught:
        render(run, tmp_path / "film.gif", **options)
    assert caught.value.name == name
    assert_says(caught.value)
    assert list(tmp_path.iterdir()) == []
