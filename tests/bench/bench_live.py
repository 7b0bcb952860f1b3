"""Live sessions: start, frame rate, delay of the mouse, many clients, memory, and WebAssembly.

`python tests/bench/bench_live.py [start browser delay lessons soak pyodide page]`; `browser`,
`delay`, `lessons` and `page` need Chromium, `pyodide` and `page` what `tests/in_node.py` describes.
"""

from __future__ import annotations

import asyncio
import gzip
import json
import math
import re
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from io import StringIO
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import psutil
import pymunk
from measure import run, sized, spread
from playwright.sync_api import Page, Request

sys.path.insert(0, str(Path(__file__).parents[1]))
import in_node
from browser import CHROMIUM, chromium, opened, wait_until
from live_sessions import SocketClient, joined

from pymunk_dragon.lessons import LESSONS, write_lessons
from pymunk_dragon.publish.site import publish_program
from pymunk_dragon.sessions import Slider, live
from pymunk_dragon.sessions.scenes import _boxes

# Clients of the soak test.
CLIENTS = sized(20, 2)
# Length of the soak test, s.
SECONDS = sized(600.0, 6.0)
# Obstacles in the soak test.
OBSTACLES = 30
# Resets in the soak test.
RESETS = 20
# Frames before a measurement, and measured.
FRAMES = sized(600, 30)
# Where on the page the centre of a box is.
BOX = """() => {
  const { points } = live.frame.calls.filter(({ grip }) => grip > 0).at(-1);
  const { left, top } = document.getElementById("field").getBoundingClientRect();
  const mean = (k) => points.reduce((sum, one) => sum + one[k] / points.length, 0);
  const [x, y] = live.view.toScreen(mean(0), mean(1));
  return [left + x, top + y];
}"""
RESTS = "(([x, y, u, v]) => Math.hypot(x - u, y - v) < 0.01)(live.frame.held)"
# The time of an event, and of the first picture afterwards in which the held body has moved by 5
# mm.
WATCH = """() => {
  window.delays = [];
  document.querySelector("#field").addEventListener("pointermove", (event) => {
    const begin = performance.now(), from = live.frame.held[0], drawn = live.drawn;
    const look = () => {
      const now = live.frame.held[0];
      if (Math.abs(now - from) > 5e-3 && live.drawn > drawn) delays.push(performance.now() - begin);
      else requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
  });
}"""


@contextmanager
def program() -> Iterator[tuple[psutil.Process, str]]:
    """The program, and the address of its page."""
    command = [sys.executable, "-m", "pymunk_dragon", "live", "--no-browser"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as process:
        assert process.stdout is not None
        found = re.search(r"http\S+", process.stdout.readline())
        assert found is not None
        try:
            yield psutil.Process(process.pid), found[0]
        finally:
            process.terminate()


async def watch(address: str, seconds: float, acts: bool = False) -> list[float]:
    """Simulated times of the frames that a client gets in so many s, or of the first one."""
    times: list[float] = []
    begin = time.perf_counter()
    async with joined(address) as client:
        acting = asyncio.create_task(act(client)) if acts else None
        while not times or time.perf_counter() - begin <= seconds:
            times.append((await client.shown()).time)
        if acting is not None:
            acting.cancel()
    return times


async def act(client: SocketClient) -> None:
    """Put obstacles, drag all the time, and reset again and again."""
    for k in range(OBSTACLES):
        await client.send("obstacle", shape="round", x=2.0 * k, y=-20.0, size=0.5)
    for _ in range(RESETS):
        await client.send("grab", x=0.0, y=0.0, slip=1000.0)
        end = time.perf_counter() + SECONDS / (RESETS + 1)
        while time.perf_counter() < end:
            await client.send("drag", x=time.perf_counter() % 3, y=time.perf_counter() % 2)
            await asyncio.sleep(1 / 60)
        await client.send("reset")


def start() -> None:
    """Time from the start of the process to the first frame of 223 benches, s."""
    times = []
    for _ in range(sized(5, 1)):
        begin = time.perf_counter()
        with program() as (_, address):
            asyncio.run(watch(address, 0.0))
            times.append(time.perf_counter() - begin)
    print(spread(times, 2))


def soak() -> None:
    """Frames, rate and memory in 10 minutes with 20 clients, obstacles, resets and a drag."""

    async def clients(address: str, process: psutil.Process) -> list[list[float]]:
        watching = asyncio.gather(
            *(watch(address, SECONDS, acts=number == 0) for number in range(CLIENTS))
        )
        await asyncio.sleep(0.4 * SECONDS)
        print(f"{process.memory_info().rss / 1e6:.0f} MB after {0.4 * SECONDS:.0f} s")
        return await watching

    with program() as (process, address):
        times = asyncio.run(clients(address, process))
        frames = median(map(len, times)) / SECONDS
        simulated = np.diff(times[0]).clip(0).sum() / SECONDS
        print(f"{process.memory_info().rss / 1e6:.0f} MB at the end; ", end="")
        print(f"{frames:.1f} frames a second, {simulated:.3f} times real time")


def circles(count: int) -> pymunk.Space:
    """Circles that fall in a tub."""
    space = pymunk.Space()
    space.gravity = 0, -900
    columns = round(math.sqrt(1.2 * count))
    width = 16 * columns + 40
    height = 1.5 * width
    for a, b in (((0, 0), (width, 0)), ((0, 0), (0, height)), ((width, 0), (width, height))):
        space.add(pymunk.Segment(space.static_body, a, b, 5))
    for i in range(count):
        body = pymunk.Body(1, 10)
        body.position = 20 + 16 * (i % columns), 20 + 16 * (i // columns)
        space.add(body, pymunk.Circle(body, 7))
    return space


def pyramid(rows: int) -> pymunk.Space:
    """Boxes that sleep."""
    space = pymunk.Space()
    space.gravity = 0, -900
    space.sleep_time_threshold = 0.5
    space.add(pymunk.Segment(space.static_body, (-8 * rows, 0), (8 * rows, 0), 1))
    for row in range(rows):
        for k in range(rows - row):
            body = pymunk.Body(1, 10)
            body.position = 15 * (k - (rows - row - 1) / 2), 8 + 14 * row
            space.add(body, pymunk.Poly.create_box(body, (14, 14)))
    for body in space.bodies:
        body.sleep()
    return space


@contextmanager
def address_of(what: Any, **options: Any) -> Iterator[str]:
    """The address of the page of a session in this process."""
    # The address that is printed for a user is not a figure.
    with redirect_stderr(StringIO()):
        session = live(what, browser=False, **options)
    with session:
        yield session.address


@contextmanager
def page_of(what: Any, **options: Any) -> Iterator[Page]:
    """A session's page in Chromium."""
    with (
        address_of(what, **options) as address,
        chromium() as started,
        opened(started, address) as found,
    ):
        yield found.page


def browser() -> None:
    """Pictures a second in Chromium, the rate of the physics, and the time that a step takes."""
    slider = [Slider("rows", 2, 25, 25, rebuilds=True)]
    scenes: list[tuple[str, Any, int, dict[str, Any]]] = [
        ("223 benches", "dragon", FRAMES, {}),
        ("325 boxes", _boxes, FRAMES // 3, {"controls": slider, "step": 1 / 120}),
        ("3,000 circles that move", partial(circles, 3000), FRAMES // 10, {}),
        ("10,000 circles that move", partial(circles, 10_000), FRAMES // 10, {}),
        ("3,003 boxes that sleep", partial(pyramid, 77), FRAMES // 10, {}),
        ("10,011 boxes that sleep", partial(pyramid, 141), FRAMES // 10, {}),
    ]
    for name, what, count, options in scenes:
        with page_of(what, **options) as page:
            wait_until(page, f"live.drawn > {FRAMES // 60}")
            before = consumed()
            drawn, begin = page.evaluate("live.drawn"), time.perf_counter()
            wait_until(page, f"live.drawn > {drawn + count}", 600.0)
            made = page.evaluate("live.drawn") - drawn
            pictures = made / (time.perf_counter() - begin)
            print(f"{name}: {pictures:.1f}, {page.inner_text('#achieved')}", end=", ")
            print(f"{1e3 * page.evaluate('live.frame.step_time'):.1f} ms a step", end=", ")
            after = consumed()
            used = [1e3 * (after[k] - before[k]) / made for k in (0, 1)]
            print(f"{used[0]:.1f} and {used[1]:.1f} ms of processor time in process", end=" ")
            print(f"and page, {after[2] / 1e6:.0f} MB of the page", flush=True)


def consumed() -> tuple[float, float, float]:
    """Processor time of this process and of its page, s, and memory of the page, bytes."""
    me = psutil.Process()
    pages = [each for each in me.children(recursive=True) if "--type=renderer" in each.cmdline()]
    times = [sum(each.cpu_times()[:2]) for each in pages]
    return sum(me.cpu_times()[:2]), sum(times), max(each.memory_full_info().uss for each in pages)


def delay() -> None:
    """Time from a movement of the mouse to the first picture in which the body has moved, ms."""
    with page_of("boxes") as page:
        wait_until(page, "live.drawn && live.frame.time > 2.5")
        left, top = page.evaluate(BOX)
        page.mouse.move(left, top)
        page.mouse.down()
        wait_until(page, "live.frame.held")
        page.evaluate(WATCH)
        for k in range(sized(20, 2)):
            page.mouse.move(left + (15 if k % 2 == 0 else -15), top - 40)
            wait_until(page, f"delays.length > {k}")
            # Where the pointer is, the body comes to rest.
            wait_until(page, RESTS)
            page.wait_for_timeout(300)
        print(spread(page.evaluate("delays"), 0))


# Lessons that are recorded and opened.
COURSE = list(LESSONS.values())[: sized(15, 1)]
# Seconds from the click that opens a stage to its picture, and from the first touch of its last
# slider to the next picture.
TOUCHED = """async (name) => {
  const next = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
  const seconds = async (act) => {
    const begin = performance.now();
    act();
    await next();
    return (performance.now() - begin) / 1000;
  };
  const lesson = document.getElementById(name);
  const opened = await seconds(() => lesson.querySelector(".open-unguessed").click());
  const slider = [...lesson.querySelectorAll(".slider input")].at(-1);
  const touched = await seconds(() => {
    if (slider) slider.value = (Number(slider.min) + Number(slider.max)) / 2;
    slider?.dispatchEvent(new Event("input"));
  });
  return [opened, touched];
}"""


def lessons() -> None:
    """Words before each stage, and seconds until it has a picture and answers a touch."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "lessons.html"
        write_lessons(COURSE, file)
        with chromium() as started, opened(started, file.as_uri()) as found:
            for lesson in COURSE:
                words = re.findall(r"[^\s-]\S*", f"{lesson.texts['Question']} {lesson.guess()}")
                picture, touch = found.page.evaluate(TOUCHED, lesson.name)
                print(f"{lesson.name}: {len(words)} words, picture {picture:.2f} s", end="")
                print(f", touch {touch:.2f} s")


# Steps and frames in Pyodide.
STEPS = sized(500, 5)


def pyodide() -> None:
    """A session in WebAssembly, in node: bytes, processor time of each stage, and memory."""
    files = [in_node.RUNTIME / name for name in in_node.FILES]
    with tempfile.TemporaryDirectory() as folder:
        results = Path(folder)
        archives = in_node.libraries(results, tests=False)
        (results / "steps").write_text(str(STEPS))
        in_node.run("bench/pyodide_live.py", results, archives)
        usage = json.loads((results / "usage.json").read_text())
        times = json.loads((results / "times.json").read_text())
        contents = [path.read_bytes() for path in (*files, *archives)]

    whole = sum(map(len, contents)) / 1e6
    packed = sum(len(gzip.compress(content)) for content in contents) / 1e6
    print(f"{whole:.1f} MB, {packed:.1f} MB compressed, without the package")
    stages = {"runtime": usage["runtime"], "unpack libraries": usage["libraries"], **times}
    for name, seconds in stages.items():
        print(f"{name}: {1e3 * seconds:.2f} ms")
    print(f"memory: {usage['memory'] / 1e6:.0f} MB")


class Files(SimpleHTTPRequestHandler):
    """A server of files that prints nothing."""

    def log_message(self, *arguments: object) -> None:
        """Print nothing."""


@contextmanager
def published() -> Iterator[str]:
    """The address of a published page, whose engine is in the browser."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "dragon.py").write_text('from pymunk_dragon import live\n\nlive("dragon")\n')
        (folder / "pyodide").mkdir()
        runtime = in_node.copy_for_pages(folder / "pyodide")
        publish_program(folder / "dragon.py", folder / "site", runtime=runtime)
        handler = partial(Files, directory=str(folder / "site"))
        with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
            threading.Thread(target=server.serve_forever).start()
            try:
                yield f"http://127.0.0.1:{server.server_port}/"
            finally:
                server.shutdown()


def used() -> tuple[float, float]:
    """Processor time, s, and memory, MB, of the page and its worker in Chromium."""
    children = psutil.Process().children(recursive=True)
    pages = [each for each in children if "--type=renderer" in each.cmdline()]
    # Chromium keeps another one for the next page.
    busiest = max(pages, key=lambda each: each.cpu_times().user)
    times = busiest.cpu_times()
    return times.user + times.system, busiest.memory_full_info().uss / 1e6


def changes_of_scene(page: Page) -> list[float]:
    """Times from the choice of a scene to its first frame, s, of ten changes."""
    names = page.evaluate("live.scene.scenes.map(({ name }) => name)")
    times = []
    for k in range(1, sized(10, 2) + 1):
        name = names[k % len(names)]
        begin = time.perf_counter()
        page.select_option("#scene", name)
        wait_until(page, f"live.scene.name === '{name}' && live.frame?.time > 0")
        times.append(time.perf_counter() - begin)
    return times


def figures_of_page(name: str, address: str) -> None:
    """Print files, processor time, memory and changes of scene of a page."""
    requests: list[Request] = []
    with chromium() as started, opened(started, "about:blank") as found:
        page = found.page
        page.on("requestfinished", lambda each: requests.append(each))
        page.goto(address)
        if page.is_visible("#begin-play"):
            page.click("#begin-play")
        wait_until(page, "live.frame?.time > 0")
        seconds, first = used()
        size = sum(each.sizes()["responseBodySize"] for each in requests) / 1e6
        times = changes_of_scene(page)
        last = used()[1]
    changes = f"{spread(times, 2)} s | {last:.0f} MB"
    print(f"| {name} | {size:.2f} MB | {seconds:.1f} s | {first:.0f} MB | {changes} |", flush=True)


def page() -> None:
    """Files, processor time and memory at the first frame, a change of scene, memory after ten."""
    if reason := in_node.missing() if CHROMIUM else "no Chromium":
        raise in_node.CannotRunError(reason)
    for name, place in {"over a socket": address_of("dragon"), "published": published()}.items():
        with place as address:
            figures_of_page(name, address)


BENCHMARKS = {
    "start": start,
    "browser": browser,
    "delay": delay,
    "lessons": lessons,
    "soak": soak,
    "pyodide": pyodide,
    "page": page,
}

if __name__ == "__main__":
    try:
        run(BENCHMARKS)
    except in_node.CannotRunError as reason:
        print(f"left out: {reason}")
