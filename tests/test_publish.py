"""Published pages: what a folder holds, what is refused, and the session in a page's worker."""

from __future__ import annotations

import asyncio
import builtins
import functools
import http.server
import io
import json
import re
import subprocess
import sys
import threading
import zipfile
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from types import ModuleType, SimpleNamespace

import documentation
import in_node
import pytest
from browser import needs_browser, opened, wait_until
from bs4 import BeautifulSoup
from conftest import assert_one_line

import pymunk_dragon
from pymunk_dragon.errors import DragonError
from pymunk_dragon.publish import runtime, worker
from pymunk_dragon.publish.site import publish_program, publish_site
from pymunk_dragon.sessions.live import Live

PROGRAM = '''"""A ball above a floor

Drop it.
"""

import pymunk
from helper import RADIUS

from pymunk_dragon import Button, Slider, live


def build(height=2.0):
    space = pymunk.Space()
    space.gravity = 0, -9.81
    body = pymunk.Body(1, 1)
    body.position = 0, height
    floor = pymunk.Segment(space.static_body, (-2, 0), (2, 0), 0.1)
    space.add(body, pymunk.Circle(body, RADIUS), floor)
    return space


def divide(space):
    return 1 / 0


def hang(space):
    while True:
        pass


controls = [Slider("height", 1, 3, rebuilds=True), Button("Divide", divide), Button("Hang", hang)]
with live(build, step=1 / 240, controls=controls) as session:
    input(f"{session.address} {session.watch_address} shows it; Enter ends it. ")
'''
# The name of a wheel for Pyodide.
TAG = "cp314-cp314-pyemscripten_2026_0_wasm32.whl"
PYMUNK = f"pymunk-{version('pymunk')}-{TAG}"


@pytest.fixture
def program(tmp_path):
    """A program in a file, with a module beside it."""
    file = tmp_path / "work" / "ball.py"
    file.parent.mkdir()
    file.write_text(PROGRAM)
    file.with_name("helper.py").write_text("RADIUS = 0.3\n")
    return file


@pytest.fixture
def copy(tmp_path):
    """A folder with files named as those of a copy of Pyodide; each holds its name."""
    folder = tmp_path / "copy"
    folder.mkdir()
    for name in (*in_node.FILES, PYMUNK, f"numpy-2-{TAG}", f"cffi-2-{TAG}", f"pillow-12-{TAG}"):
        (folder / name).write_text(name)
    return folder


def site_of(page):
    """What a page tells its worker."""
    return json.loads(BeautifulSoup(page.read_text("utf-8"), "html.parser").find(id="site").text)


# ---- the folder


def test_folder_has_all_that_its_page_loads(program, copy, tmp_path):
    folder = tmp_path / "site"
    publish_program(program, folder, include=[program.with_name("helper.py")], runtime=copy)
    site = site_of(folder / "index.html")
    assert (site["runtime"], site["program"]) == ("pyodide/", "ball.py")
    assert site["files"] == ["ball.py", "helper.py"]
    assert (folder / "files/ball.py").read_text() == PROGRAM
    # Some servers give .mjs a wrong type.
    for name in in_node.FILES:
        published = folder / "pyodide" / name.replace(".mjs", ".js")
        assert published.read_text() == name
    names = {Path(wheel).name.partition("-")[0] for wheel in site["wheels"]}
    assert names == {"numpy", "cffi", "pillow", "pymunk", "pymunk_dragon"}
    assert all((folder / wheel).is_file() for wheel in site["wheels"])
    assert (folder / "worker.js").is_file()


def test_page_has_the_title_and_the_text_of_the_program_and_keeps_to_its_own_server(
    program, copy, tmp_path
):
    publish_program(
        program, tmp_path / "site", include=[program.with_name("helper.py")], runtime=copy
    )
    page = BeautifulSoup((tmp_path / "site/index.html").read_text("utf-8"), "html.parser")
    assert (page.title.text, page.find(id="text").text) == ("A ball above a floor", "Drop it.")
    assert page.find("meta", {"name": "description"})["content"] == "Drop it."
    # The address of the page is not known.
    assert page.find(rel="canonical") is None
    picture = page.find("meta", property="og:image")["content"]
    assert (tmp_path / "site" / picture).read_bytes().startswith(b"\x89PNG")
    policy = page.find("meta", {"http-equiv": "Content-Security-Policy"})["content"]
    assert {"worker-src 'self'", "connect-src 'self'"} <= set(policy.split("; "))


def test_pages_at_a_known_address_say_where_they_and_their_pictures_are(
    program, copy, tmp_path, monkeypatch
):
    lesson = pymunk_dragon.lessons.LESSONS["spiral"]
    monkeypatch.setattr("pymunk_dragon.publish.site.LESSONS", {"spiral": lesson})
    for folder in ("https://example.org/dragon", "https://example.org/dragon/"):
        site = tmp_path / str(len(folder))
        publish_site(site, runtime=copy, address=folder)
        for name in ("index.html", "live.html", "player.html"):
            page = BeautifulSoup((site / name).read_text("utf-8"), "html.parser")
            said = {each["property"]: each["content"] for each in page.find_all(property=True)}
            here = f"https://example.org/dragon/{name}"
            assert page.find(rel="canonical")["href"] == said["og:url"] == here
            assert said["og:title"]
            picture = said["og:image"].removeprefix("https://example.org/dragon/")
            assert (site / picture).read_bytes().startswith(b"\x89PNG")
            assert page.find("meta", {"name": "description"})["content"]


@pytest.mark.parametrize(
    "address", ["", "example.org", "ftp://a/b", "https://a/b?c", "https://", 7]
)
def test_address_that_no_page_can_have_is_refused(program, copy, tmp_path, address):
    include = [program.with_name("helper.py")]
    folder = tmp_path / "site"
    with pytest.raises(DragonError, match="address"):
        publish_program(program, folder, include=include, runtime=copy, address=address)
    assert not folder.exists()


def test_folder_has_a_whole_wheel_of_this_package(program, copy, tmp_path):
    publish_program(
        program, tmp_path / "site", include=[program.with_name("helper.py")], runtime=copy
    )
    (wheel,) = (tmp_path / "site/wheels").glob("pymunk_dragon-*.whl")
    package = Path(pymunk_dragon.__file__).parent
    with zipfile.ZipFile(io.BytesIO(wheel.read_bytes())) as archive:
        names = archive.namelist()
        about = f"pymunk_dragon-{pymunk_dragon.__version__}.dist-info"
        assert (
            f"Version: {pymunk_dragon.__version__}\n" in archive.read(f"{about}/METADATA").decode()
        )
        record = archive.read(f"{about}/RECORD").decode().splitlines()
    assert sorted(line.partition(",")[0] for line in record) == sorted(names)
    files = [file for file in package.rglob("*") if file.is_file() and file.suffix != ".pyc"]
    assert {file.relative_to(package.parent).as_posix() for file in files} <= set(names)


def test_page_loads_pyodide_from_its_network_where_there_is_no_copy(program, tmp_path, monkeypatch):
    monkeypatch.setattr(runtime, "_download", lambda folder: (folder / PYMUNK).touch())
    publish_program(program, tmp_path / "site", include=[program.with_name("helper.py")])
    site = site_of(tmp_path / "site/index.html")
    assert site["runtime"] == runtime.CDN
    assert {"numpy", "pillow"} < set(site["packages"])
    assert not (tmp_path / "site/pyodide").exists()


# ---- what is refused: nothing of a folder is left


LOOP = "import pymunk\nfrom pymunk_dragon import live\nlive(pymunk.Space(), step=None)\n"


@pytest.mark.parametrize(
    ("source", "named"),
    [
        ("def f(:\n    pass\n", "line 1"),
        ("import pymunk\nspace = pymunk.Space()\n", "live"),
        ("def f():\n    live()\n", "live"),
        (LOOP, "step=None"),
        ("import pygame\nlive()\n", "pygame"),
        ("from pymunk import pygame_util\nlive()\n", "pymunk.pygame_util"),
        ("import os\nimport scipy.optimize\nlive()\n", "line 2 imports scipy.optimize"),
        ("import tkinter\nlive()\n", "tkinter"),
        ("import helper\nlive()\n", "helper"),
        ("from pymunk_dragon import live\nlive(1 / 0)\n", "ZeroDivisionError"),
        ("from pymunk_dragon import live\nlive('nowhere')\n", "nowhere"),
    ],
)
def test_program_that_a_page_cannot_play_is_refused(program, copy, tmp_path, source, named):
    program.write_text(source)
    with pytest.raises(DragonError, match=re.escape(named)) as refused:
        publish_program(program, tmp_path / "site", runtime=copy)
    assert "\n" not in str(refused.value)
    assert str(refused.value).count(program.name) == 1
    assert not (tmp_path / "site").exists()
    assert Live.made_by is None


def test_folders_and_files_that_cannot_be_used_are_refused(program, copy, tmp_path):
    full = tmp_path / "full"
    full.mkdir()
    (full / "notes.txt").write_text("mine")
    for folder in (full, full / "notes.txt", tmp_path / "no" / "parent"):
        with pytest.raises(DragonError):
            publish_program(program, folder, runtime=copy)
    assert [file.name for file in full.iterdir()] == ["notes.txt"]

    new = tmp_path / "site"
    with pytest.raises(DragonError, match=r"none\.png"):
        publish_program(
            program,
            new,
            include=[program.with_name("helper.py"), tmp_path / "none.png"],
            runtime=copy,
        )
    (copy / "pyodide.asm.wasm").unlink()
    with pytest.raises(DragonError, match=r"pyodide\.asm\.wasm"):
        publish_site(new, runtime=copy)
    assert not new.exists()


def test_wheel_that_pip_does_not_find_is_named(program, tmp_path, monkeypatch):
    failed = SimpleNamespace(returncode=1, stderr="WARNING: x\nERROR: no matching distribution\n")
    monkeypatch.setattr(runtime.subprocess, "run", lambda *given, **options: failed)
    with pytest.raises(DragonError, match="no matching distribution"):
        publish_program(program, tmp_path / "site", include=[program.with_name("helper.py")])
    assert not (tmp_path / "site").exists()


def test_command_writes_a_folder_and_says_how_to_serve_it(call, program, copy, tmp_path):
    folder = tmp_path / "my site"
    include = ("--include", program.with_name("helper.py"))
    code, out, err = call("publish", program, folder, *include, "--offline", copy)
    assert (code, err) == (0, "")
    assert f"-m http.server -d '{folder}'" in out
    for wrong in ([], ["a", "b", "c"], [tmp_path / "new", *include], [program, folder]):
        code, out, err = call("publish", *wrong, "--offline", copy)
        assert (code, out) == (2, "")
        assert_one_line(err)


# ---- the worker's part, without a page


class Posts:
    """What the worker posts."""

    def __init__(self):
        self.contents = []

    def __call__(self, content, *buffers):
        self.contents.append(content)

    @property
    def messages(self):
        return [json.loads(each["text"]) for each in self.contents if "text" in each]


@pytest.fixture
def post(monkeypatch):
    monkeypatch.setattr("pymunk_dragon.sessions.session._WITHOUT_THREADS", True)
    monkeypatch.setattr(Live, "made_by", None)
    monkeypatch.setattr(builtins, "input", input)
    monkeypatch.setattr(sys, "path", sys.path[:])
    return Posts()


def in_a_loop(play):
    """Run a coroutine function; the browser of other tests has a loop in this thread."""
    with ThreadPoolExecutor(1) as other:
        other.submit(lambda: asyncio.run(play())).result()


def test_worker_plays_a_program_that_has_ended(program, post):
    async def play():
        page = worker.begin(post, str(program), "")
        page.take_post(0)
        while not any("frame" in each for each in post.contents):
            await asyncio.sleep(0)
        page.take_post(json.dumps({"do": "press", "name": "Divide", "down": True}))
        while not errors():
            await asyncio.sleep(0)
        page.session.stop()

    def errors():
        return [each for each in post.messages if each["kind"] == "error"]

    in_a_loop(play)
    assert post.messages[0]["kind"] == "scene"
    assert errors()[0]["place"].startswith("ball.py, line 23")


@pytest.mark.parametrize(
    ("source", "place"), [("x = 1\n1 / 0\n", "ball.py, line 2"), ("input()\n", None)]
)
def test_worker_posts_why_a_program_cannot_begin(program, post, source, place):
    program.write_text(source)
    assert worker.begin(post, str(program), "") is None
    (posted,) = post.contents
    assert (posted["failure"].get("place") or "").startswith(place or "")


def test_worker_has_the_scenes_of_lessons(post, monkeypatch):
    monkeypatch.setattr("pymunk_dragon.sessions.scenes.SCENES", {})
    monkeypatch.setattr(worker, "SCENES", {})
    # Not for the tests that follow.
    for library in ("matplotlib", "matplotlib.pyplot"):
        monkeypatch.setitem(sys.modules, library, ModuleType(library))

    async def play():
        page = worker.begin(post, "", "tension")
        assert page.session.source.lesson == "tension"
        page.session.stop()

    in_a_loop(play)


def test_worker_runs_the_texts_of_a_program_and_posts_what_it_shows(post):
    define = "from PIL import Image\n\ndef double(x):\n    return 2 * x\n"
    draw = 'print(double(4))\nImage.new("RGB", (3, 2)).save("small.png")\ndouble()\n'
    worker.run(post, [define, draw])
    assert "".join(each.get("printed", "") for each in post.contents) == "8\n"
    [failure] = [each["failure"] for each in post.contents if "failure" in each]
    assert failure["place"] == "program_2.py, line 3: double()"
    assert post.contents[-2:] == [{"picture": "small.png"}, {"ended": True}]


# What the first picture of a page needs no part of: together 0.7 s of its 6 s of processor time.
BEGINS = """
import sys
from pymunk_dragon.publish import worker

assert worker.begin(lambda *posted: None, "", "dragon")
left_out = "PIL", "numpy.ma", "pymunk_dragon.collision", "pymunk_dragon.drawing", "webbrowser"
assert not sys.modules.keys() & set(left_out)
"""


def test_page_begins_without_modules_that_only_pictures_need():
    subprocess.run([sys.executable, "-c", BEGINS], check=True)


# ---- in Chromium


@pytest.fixture(scope="module")
def pyodide(tmp_path_factory):
    """A copy of Pyodide with its wheels, and Pymunk's."""
    try:
        return in_node.copy_for_pages(tmp_path_factory.mktemp("pyodide"))
    except in_node.CannotRunError as error:
        pytest.skip(str(error))


@contextmanager
def served(folder):
    """The address of a folder, whose server lets scripts compile WebAssembly and nothing else."""

    class Handler(http.server.SimpleHTTPRequestHandler):
        def end_headers(self):
            if self.path.endswith(".js"):
                rules = "script-src 'self' 'wasm-unsafe-eval'"
                self.send_header("Content-Security-Policy", rules)
            super().end_headers()

        def log_message(self, *arguments):
            """Print nothing."""

    handler = functools.partial(Handler, directory=folder)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}/"
        finally:
            server.shutdown()
            thread.join()


@pytest.mark.thorough
@needs_browser
def test_page_plays_a_program_shows_its_fault_and_stops_one_that_hangs(
    browser, program, pyodide, tmp_path
):
    publish_program(
        program, tmp_path / "site", include=[program.with_name("helper.py")], runtime=pyodide
    )
    with (
        served(tmp_path / "site") as address,
        opened(browser, address) as found,
    ):
        page = found.page
        page.click("#begin-play")
        wait_until(page, "live.frame?.time > 0.1")
        assert page.title() == "A ball above a floor"
        page.click("text=Divide")
        wait_until(page, "!document.getElementById('error').hidden")
        assert "ball.py, line 23: return 1 / 0" in page.inner_text("#error")

        first = page.evaluate("live.connection.socket.worker !== null && live.scene.generation")
        page.evaluate("globalThis.first = live.connection.socket")
        page.click("text=Hang")
        page.click("#stop")
        wait_until(page, "live.connection.socket !== first && live.connection.connected")
        assert page.evaluate("live.scene.generation") == first
        assert {
            each for each in found.addresses if not each.startswith((address, "data:"))
        } == set()
        assert found.complaints == []


@pytest.fixture(scope="module")
def site(pyodide, tmp_path_factory):
    """A site of three lessons: one without Pymunk, and two with scenes of it."""
    names = ("chain", "tension", "callbacks")
    lessons = {name: pymunk_dragon.lessons.LESSONS[name] for name in names}
    folder = tmp_path_factory.mktemp("site")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("pymunk_dragon.publish.site.LESSONS", lessons)
        publish_site(folder, runtime=pyodide)
    return folder


@pytest.mark.thorough
@needs_browser
def test_site_plays_a_scene_of_a_link(browser, site):
    with served(site) as address:
        link = f"{address}live.html#scene=boxes&set.rows=4&t=0.5"
        with opened(browser, link) as found:
            page = found.page
            # The picture of the page is that of another scene.
            assert page.is_hidden("#begin-picture")
            page.click("#begin-play")
            wait_until(page, "live.frame?.time >= 0.4999")
            assert page.evaluate("[live.state.running, live.state.values.rows]") == [False, 4]
            wait_until(page, "location.hash === '#scene=boxes&set.rows=4&t=0.500'")
            page.select_option("#scene", "dragon")
            wait_until(page, "live.scene.name === 'dragon' && live.frame?.time > 0")
            # This scene is of no lesson to which a link could lead.
            assert page.is_hidden("#lesson")
            assert found.complaints == []


def play_scenes_of_lessons(page, lessons):
    """Play the scenes of lessons one after the other, in one worker."""
    for name in ("tension", "callbacks"):
        lessons.click(f"#{name} .open-unguessed")
        wait_until(lessons, f"playedNow?.name === {name!r} && playedNow.frame && !playedNow.note")
        assert lessons.evaluate("playedNow.frame.generation === playedNow.generation")
        assert len(page.workers) == 1


@pytest.mark.thorough
@needs_browser
def test_one_worker_plays_one_experiment_after_the_other(browser, site):
    with served(site) as address, opened(browser, address) as found:
        play_scenes_of_lessons(found.page, found.page)
        assert found.complaints == []


@contextmanager
def boxed(browser, address, sandbox):
    """Open a page in a frame with a sandbox, on a page of the same server."""
    around = (
        f'<!doctype html><iframe sandbox="{sandbox}" width="1200" height="700" src="."></iframe>'
    )
    with opened(browser, "about:blank") as found:
        found.page.route(
            "**/around.html", lambda route: route.fulfill(body=around, content_type="text/html")
        )
        found.page.goto(f"{address}around.html")
        yield found, found.page.wait_for_selector("iframe").content_frame()


@pytest.mark.thorough
@needs_browser
def test_lessons_in_a_sandbox_play_what_it_allows(browser, site):
    with served(site) as address:
        with boxed(browser, address, "allow-scripts") as (found, lessons):
            lessons.click("#chain .open-unguessed")
            lessons.wait_for_selector("#chain .stage canvas")
            lessons.click("#tension .open-unguessed")
            lessons.wait_for_selector("#tension .stage canvas")
            # Where the frame opens no window, the address can be copied.
            link = f"{address}live.html#scene=tension"
            assert lessons.locator("#tension figure a").evaluate("each => each.href") == link
            assert link in lessons.inner_text("#tension figure a")
            assert found.complaints == []
        with boxed(browser, address, "allow-scripts allow-same-origin") as (found, lessons):
            play_scenes_of_lessons(found.page, lessons)


@pytest.mark.thorough
@needs_browser
def test_programs_of_guides_are_edited_and_run_in_one_worker_of_their_page(
    browser, pyodide, tmp_path
):
    documentation.build(tmp_path / "docs", {}, runtime=str(pyodide))
    with served(tmp_path / "docs") as address:
        with opened(browser, f"{address}contacts.html", 390, 844) as found:
            page = found.page
            page.click("button:text-is('Edit')")
            save = "from PIL import Image\nImage.new('RGB', (3, 2)).save('a.png')\n"
            page.fill("textarea", f"{save}print('hello')\n1 / 0\n")
            page.click("button:text-is('Run')")
            wait_until(page, "document.querySelector('.output img')?.naturalWidth === 3")
            assert page.inner_text(".output pre").splitlines() == [
                "hello",
                "program_1.py, line 4: 1 / 0",
                "ZeroDivisionError: division by zero",
            ]
            page.fill("textarea", "while True:\n    pass\n")
            page.click("button:text-is('Run')")
            page.click("button:text-is('Stop')")
            page.fill("textarea", "print('again')\n")
            page.click("button:text-is('Run')")
            wait_until(page, "document.querySelector('.output')?.textContent === 'again\\n'")
            assert len(page.workers) == 1
            assert page.evaluate("document.documentElement.scrollWidth") == 390
            assert all(each.startswith((address, "blob:")) for each in found.addresses)

        with opened(browser, f"{address}live.html") as found:
            page = found.page
            page.click("button:text-is('Run')")
            frame = page.wait_for_selector(".output iframe").content_frame()
            wait_until(frame, "globalThis.live?.frame?.time > 0")
            assert frame.locator("text=Kick a box").count() == 1
            assert len(page.workers) == 1
