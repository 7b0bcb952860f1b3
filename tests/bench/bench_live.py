"""Live sessions: start, frame rate, delay of the mouse, many clients, memory, and WebAssembly.

`python tests/bench/bench_live.py [start browser delay soak pyodide page]`; `browser`, `delay` and
`page` need Chromium, `pyodide` and `page` what `tests/in_node.py` describes.
"""

from __future__ import annotations

import asyncio
import gzip
import json
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


def circles() -> pymunk.Space:
    """3,000 circles in a tub."""
    space = pymunk.Space()
    space.gravity = 0, -900
    for a, b in (((0, 0), (1000, 0)), ((0, 0), (0, 1500)), ((1000, 0), (1000, 1500))):
        space.add(pymunk.Segment(space.static_body, a, b, 5))
    for i in range(3000):
        body = pymunk.Body(1, 10)
        body.position = 20 + 16 * (i % 60), 20 + 16 * (i // 60)
        space.add(body, pymunk.Circle(body, 7))
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
    """Pictures a second in Chromium, contacts shown, and the rate of the physics."""
    pyramid = [Slider("rows", 2, 25, 25, rebuilds=True)]
    for name, what, count, options in (
        ("223 benches", "dragon", FRAMES, {}),
        ("325 boxes", _boxes, FRAMES // 3, {"controls": pyramid, "step": 1 / 120}),
        ("3,000 circles", circles, FRAMES // 3, {"units": "px"}),
    ):
        with page_of(what, **options) as page:
            wait_until(page, f"live.drawn > {FRAMES // 5}")
            drawn, begin = page.evaluate("live.drawn"), time.perf_counter()
            wait_until(page, f"live.drawn > {drawn + count}")
            pictures = (page.evaluate("live.drawn") - drawn) / (time.perf_counter() - begin)
            print(f"{name}: {pictures:.1f}, {page.inner_text('#achieved')}", flush=True)


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
    "soak": soak,
    "pyodide": pyodide,
    "page": page,
}

if __name__ == "__main__":
    try:
        run(BENCHMARKS)
    except in_node.CannotRunError as reason:
        print(f"left out: {reason}")
