"""Live sessions: start, pictures a second, delay from the mouse to the body, many clients, and memory.

python tests/bench/bench_live.py start
python tests/bench/bench_live.py browser delay           # with Chromium
python tests/bench/bench_live.py soak --minutes 10       # many clients, obstacles and resets, and one that drags
"""

from __future__ import annotations

import asyncio
import json
import re
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median

import psutil
import pymunk
from aiohttp import ClientSession, ClientWebSocketResponse
from measure import arguments, sized, spread

sys.path.insert(0, str(Path(__file__).parents[1]))
from browser import chromium, opened, wait_until

from pymunk_dragon.sessions import Slider, live
from pymunk_dragon.sessions.ready import _boxes

COMMAND = [sys.executable, "-m", "pymunk_dragon", "live", "--no-browser"]
CLIENTS = sized(20, 2)
OBSTACLES, RESETS = 30, 20
# Frames before a measurement, and measured.
FRAMES = sized(600, 30)


@contextmanager
def program(*more: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """The program, and its address."""
    with subprocess.Popen([*COMMAND, *more], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        assert process.stdout is not None
        found = re.search(r"http\S+", process.stdout.readline())
        assert found is not None
        try:
            yield process, found[0]
        finally:
            process.terminate()


def start() -> None:
    """Time from the start of the process to the first frame."""
    times = []
    for _ in range(sized(5, 1)):
        begin = time.perf_counter()
        with program() as (_, address):
            asyncio.run(_frames(address, 1))
            times.append(time.perf_counter() - begin)
    print(f"first frame of 223 benches: {spread(times, 2)} s after the start of the process")


def _time(frame: bytes) -> float:
    """Simulated time in the header of a frame."""
    [length] = struct.unpack_from("<I", frame)
    return float(json.loads(frame[4 : 4 + length])["time"])


async def _frames(address: str, count: int) -> None:
    async with ClientSession() as web, web.ws_connect(address.replace("/?", "/socket?")) as socket:
        while count:
            message = await socket.receive()
            count -= isinstance(message.data, bytes)


def soak(minutes: float) -> None:
    """Frames, rate, memory and dropped clients, with obstacles, resets, and a client that drags."""
    with program() as (process, address):
        asyncio.run(_soak(address, psutil.Process(process.pid), 60 * minutes))


async def _soak(address: str, process: psutil.Process, seconds: float) -> None:
    counts, simulated, dropped = [0] * CLIENTS, [0.0, 0.0], []
    begin = time.perf_counter()

    async def watch(number: int) -> None:
        async with ClientSession() as web, web.ws_connect(address.replace("/?", "/socket?"), max_msg_size=0) as socket:
            acting = asyncio.create_task(_act(socket, seconds)) if number == 0 else None
            async for message in socket:
                if isinstance(message.data, bytes):
                    counts[number] += 1
                    if number == 0:
                        now = _time(message.data)
                        simulated[:] = now, simulated[1] + (now - simulated[0] if now >= simulated[0] else now)
                if time.perf_counter() - begin > seconds:
                    break
            else:
                dropped.append(number)
            if acting is not None:
                acting.cancel()

    sizes, used = [process.memory_info().rss / 1e6], sum(process.cpu_times()[:2])
    await asyncio.gather(*(watch(number) for number in range(CLIENTS)))
    passed = time.perf_counter() - begin
    sizes.append(process.memory_info().rss / 1e6)
    print(
        f"{CLIENTS} clients, {passed:.0f} s: {min(counts) / passed:.1f} frames/s (least), "
        f"{median(counts) / passed:.1f} (median), {simulated[1] / passed:.3f} times real time, "
        f"{100 * (sum(process.cpu_times()[:2]) - used) / passed:.0f} % of a core, "
        f"{sizes[0]:.1f} MB at the start and {sizes[1]:.1f} at the end, {len(dropped)} dropped"
    )


async def _act(socket: ClientWebSocketResponse, seconds: float) -> None:
    """Put obstacles, drag all the time, and reset again and again."""
    for k in range(OBSTACLES):
        await socket.send_json({"do": "obstacle", "shape": "round", "x": 2.0 * k, "y": -20.0, "size": 0.5})
    for _ in range(RESETS):
        await socket.send_json({"do": "grab", "x": 0.0, "y": 0.0, "slip": 1000.0})
        end = time.perf_counter() + seconds / (RESETS + 1)
        while time.perf_counter() < end:
            await socket.send_json({"do": "drag", "x": time.perf_counter() % 3, "y": time.perf_counter() % 2})
            await asyncio.sleep(1 / 60)
        await socket.send_json({"do": "reset"})


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


def browser() -> None:
    """Pictures a second in Chromium, contacts shown, and the rate of the physics."""
    pyramid = [Slider("rows", 2, 25, 25, rebuilds=True)]
    for name, what, options in (
        ("223 benches", "dragon", {}),
        ("325 boxes", _boxes, {"controls": pyramid, "step": 1 / 120}),
        ("3,000 circles", circles, {"units": "px"}),
    ):
        with (
            live(what, browser=False, **options) as session,
            chromium() as started,
            opened(started, session.address) as found,
        ):
            page = found.page
            count = FRAMES if what == "dragon" else FRAMES // 3
            wait_until(page, f"live.drawn > {FRAMES // 5}")
            drawn, begin = page.evaluate("live.drawn"), time.perf_counter()
            wait_until(page, f"live.drawn > {drawn + count}")
            pictures = (page.evaluate("live.drawn") - drawn) / (time.perf_counter() - begin)
            print(f"Chromium: {pictures:.1f} pictures a second of {name}, {page.inner_text('#achieved')}")


def delay() -> None:
    """Time from a movement of the mouse to the first picture in which the body has moved."""
    with (
        live("boxes", browser=False) as session,
        chromium() as started,
        opened(started, session.address) as found,
    ):
        page = found.page
        wait_until(page, "live.drawn && live.frame.time > 2.5")
        x, y = page.evaluate(BOX)
        box = page.locator("#field").bounding_box()
        assert box is not None
        left, top = box["x"] + x, box["y"] + y
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
        times = page.evaluate("delays")
        print(f"from the mouse to the moved body: {median(times):.0f} ms ({min(times):.0f} to {max(times):.0f})")


# Pixel of the centre of a box.
BOX = """() => {
  const { points } = live.frame.calls.filter(({ moves }) => moves).at(-1);
  return live.pixel(...[0, 1].map((k) => points.reduce((sum, point) => sum + point[k] / points.length, 0)));
}"""
RESTS = "(([x, y, u, v]) => Math.hypot(x - u, y - v) < 0.01)(live.frame.held)"
# The time of an event, and of the first picture afterwards in which the held body has moved by 5 mm.
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


PARTS = {"start": start, "browser": browser, "delay": delay}

if __name__ == "__main__":
    names = arguments()
    if names[:1] == ["soak"]:
        soak(float(names[2]) if names[1:2] == ["--minutes"] else sized(10.0, 0.1))
    else:
        for name in names or PARTS:
            PARTS[name]()
