"""A page of lessons: one HTML file with stages, texts in all languages and programs."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from io import BytesIO
from os import cpu_count
from pathlib import Path
from typing import Any

import numpy as np

from pymunk_dragon._checks import function, instances, word
from pymunk_dragon._extras import library
from pymunk_dragon._files import check_destination, write_text
from pymunk_dragon._language import LANGUAGES, in_language, text
from pymunk_dragon.lessons._framework.lesson import Lesson, blocks
from pymunk_dragon.lessons._framework.notebook import make_notebook
from pymunk_dragon.lessons._framework.recording import Recording, record
from pymunk_dragon.model.run import Run
from pymunk_dragon.player.data import pack
from pymunk_dragon.web.html import asset, data_address, embedded_json, filled, policy
from pymunk_dragon.web.markup import html
from pymunk_dragon.web.page import colour_variables, scripts

PAGE = ".html"
NOTEBOOK = ".ipynb"
PROGRAM = ".py"
MEDIA_TYPES = {
    ".gif": "image/gif",
    ".png": "image/png",
    ".py": "text/x-python",
    ".ipynb": "application/x-ipynb+json",
}
# Frames of a run on a stage: a fifth of a second apart in 13 s.
_STAGE_FRAMES = 66
# m: step of positions there.
_STAGE_STEP = 1e-3
# s: what the picture of a scene in the list shows, and from one moment to the next.
_FILM_LENGTH = 3.0
_FILM_STEP = 0.1
# A page that stands alone.
_ALONE: Mapping[str, str] = {}
# Styles of the page.
STYLES = ("assets/lessons.css", "assets/lab.css")


def endings(lessons: Sequence[Lesson]) -> tuple[str, ...]:
    """Endings of files that `write_lessons` writes; only a page holds several lessons."""
    return (PAGE, NOTEBOOK, PROGRAM) if len(lessons) == 1 else (PAGE,)


def write_lessons(
    lessons: Sequence[Lesson],
    path: str | Path,
    *,
    language: str = "en",
    progress: Callable[[int, int], object] = lambda done, total: None,
) -> None:
    """Write one lesson as a notebook or as its program, or any number of lessons as one page.

    Parameters
    ----------
    lessons : sequence of Lesson
        The lessons; for a page each of them is run.
    path : path
        File to write, ending in .html, .ipynb or .py. An interrupted call leaves the old file or
        none.
    language : str
        "en" or "zh": that of the texts of a notebook, or in which a page opens. A program is
        English.
    progress : callable, optional
        Called with the number of lessons that were run, and of all, after each one.

    Raises
    ------
    ParameterError
        If the file cannot be written, or the language is unknown.
    OutputError
        If writing fails.
    MissingExtraError
        If a library is not installed.

    Examples
    --------
    >>> from pymunk_dragon.lessons import LESSONS, write_lessons
    >>> write_lessons([LESSONS["spiral"]], "lessons.html", language="zh")
    """
    lessons = instances("lessons", lessons, Lesson, "a sequence of lessons")
    word("language", language, LANGUAGES)
    function("progress", progress)
    destination = check_destination(path, endings(lessons))

    ending = destination.suffix.lower()
    if ending == PROGRAM:
        written = lessons[0].source
    elif ending == NOTEBOOK:
        written = make_notebook(lessons[0], language)
    else:
        written = run_page(lessons, language, progress)

    write_text(destination, written)


def run_page(
    lessons: Sequence[Lesson],
    language: str,
    progress: Callable[[int, int], object],
    *,
    site: Mapping[str, Any] | bool = False,
    pages: Mapping[str, str] = _ALONE,
) -> str:
    """Page of lessons that are run here; see `write_lessons` and `make_page`."""
    # Before the lessons are run.
    for name in ("pygments", "nbformat", "latex2mathml", "jinja2"):
        library(name)
    recordings = []
    with ThreadPoolExecutor(cpu_count()) as pool:
        for done, recording in enumerate(pool.map(record, lessons), start=1):
            recordings.append(recording)
            progress(done, len(lessons))
    return make_page(recordings, language, site=site, pages=pages)


def make_page(
    recordings: Sequence[Recording],
    language: str = "en",
    *,
    site: Mapping[str, Any] | bool = False,
    pages: Mapping[str, str] = _ALONE,
) -> str:
    """HTML of one page of lessons that were run.

    `site` is what the worker of a published page loads, or whether a live server has the page.
    `pages` are the addresses of other pages by their titles; the first one plays live scenes.
    """
    stages = [found.lesson.path.with_suffix(".js") for found in recordings]
    own = [stage.read_text("utf-8") for stage in stages if stage.exists()]
    rules = "; connect-src 'self'; worker-src 'self'" if site else ""
    script = "\n".join([*scripts("lab", "played"), *own, *scripts("lessons")])
    styles = (asset(__package__, name) for name in STYLES)
    style = "\n".join([colour_variables(), *styles])
    return filled(
        __package__,
        "assets/lessons.html.j2",
        language=language,
        languages={"en": "English", "zh": "中文"},
        words=words,
        blocks=blocks,
        html=html,
        spiral=_spiral(),
        lessons=[_values(recording) for recording in recordings],
        # Scripts have null where a server plays, and no address where nothing does.
        engine=embedded_json(None if site is True else site or {}),
        pages=pages,
        policy=policy(style, script) + rules,
        style=style,
        script=script,
    )


def words(english: str) -> dict[str, str]:
    """A text of the page in all languages."""
    found = {}
    for each in LANGUAGES:
        with in_language(each):
            found[each] = html(text(english))
    return found


def _values(recording: Recording) -> dict[str, Any]:
    """Values of a lesson in the template."""
    lesson = recording.lesson
    notebooks = {}
    for each in LANGUAGES:
        notebooks[each] = _address(make_notebook(lesson, each).encode(), NOTEBOOK)
    return {
        "file": lesson,
        "data": recording.data or packed_runs(recording.runs),
        "film": filmed(**lesson.scene()) if lesson.builds_scene else [],
        "printed": recording.printed.rstrip(),
        "pictures": {
            "en": _picture(recording.picture, recording.ending),
            "zh": _picture(recording.chinese or recording.picture, recording.ending),
        },
        "code": _highlighted("\n\n".join(lesson.cells)),
        "program": _address(lesson.source.encode(), PROGRAM),
        "notebooks": notebooks,
    }


def packed_runs(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Runs of a pulled dragon by the drag: handles at even times, and the first contact."""
    found = []
    for run in sorted(runs, key=lambda run: run.provenance["ground_drag"]):
        begin, end = run.interval
        times = np.linspace(begin, end, _STAGE_FRAMES)
        front, rear = run.march.dragon.holes(run.poses_at(times))
        shape, packed = pack(np.hstack([front, rear[:, -1:]]), _STAGE_STEP)
        hit = run.first_contact
        found.append(
            {
                "drag": run.provenance["ground_drag"],
                "until": end,
                "contact": hit and {"time": hit.time, "benches": hit.benches},
                "shape": shape,
                "text": packed,
            }
        )
    return found


def filmed(build: Any, step: float, **scene: Any) -> list[list[Any]]:
    """Corners of the bodies of a scene at moments of its first seconds, to centimetres."""
    space = build()
    act = scene.get("on_step", lambda space, time: None)
    film = []
    for number in range(round(_FILM_LENGTH / step)):
        space.step(step)
        act(space, number * step)
        if number % (round(_FILM_STEP / step) or 1):
            continue
        moment = []
        for body in space.bodies:
            points = [
                body.local_to_world(point) for shape in body.shapes for point in corners(shape)
            ]
            moment.append(np.round(points, 2).tolist())
        film.append(moment)
    return film


def corners(shape: Any) -> list[Any]:
    """Corners of a shape; none of one without."""
    return shape.get_vertices() if hasattr(shape, "get_vertices") else []


def _picture(content: bytes, ending: str) -> dict[str, Any]:
    """Address and size of a picture, so that the page does not move when it is unfolded."""
    with library("PIL.Image").open(BytesIO(content)) as opened:
        return {"address": _address(content, ending), "size": opened.size}


def _spiral() -> str:
    """Points of a spiral of 16 turns to draw on, in the coordinates of an SVG of 100 x 100."""
    angle = np.linspace(0, 32 * np.pi, 961)
    radius = 48 * angle / angle[-1]
    points = 50 + radius * [np.cos(angle), -np.sin(angle)]
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points.T)


def _highlighted(code: str) -> str:
    """Python code as HTML with a class for each kind of token."""
    formatter = library("pygments.formatters").HtmlFormatter(nowrap=True)
    lexer = library("pygments.lexers").PythonLexer()
    return str(library("pygments").highlight(code, lexer, formatter))


def _address(content: bytes, ending: str) -> str:
    return data_address(content, MEDIA_TYPES[ending])
