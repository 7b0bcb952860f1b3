"""Live sessions: start, pictures a second, delay from the mouse to the body, many clients, and memory.

python tests/bench/bench_live.py start clients memory    # a quarter of an hour
python tests/bench/bench_live.py browser delay           # with Chromium
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
from aiohttp import ClientSession
from measure import arguments, sized, spread

sys.path.insert(0, str(Path(__file__).parents[1]))
from browser import chromium, opened, wait_until

from pymunk_dragon.sessions import live

COMMAND = [sys.executable, "-m", "pymunk_dragon", "live", "--no-browser"]
CLIENTS = sized(20, 2)
# Frames that are awaited before a measurement, and measured.
FRAMES = sized(600, 30)
# s of real time, at 20 times: an hour of play; and drags for each frame, so that an hour's at 60 a second are sent.
PLAYED = sized(450.0, 1.0)
DRAGS = 8


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


def time_of(frame: bytes) -> float:
    """Simulated time in the header of a frame, s."""
    [length] = struct.unpack_from("<I", frame)
    found: float = json.loads(frame[4 : 4 + length])["time"]
    return found


def start() -> None:
    """Time from the start of the process to the first frame."""
    times = []
    for _ in range(sized(5, 1)):
        begin = time.perf_counter()
        with program() as (_, address):
            asyncio.run(_frames(address, 1))
            times.append(time.perf_counter() - begin)
    print(f"first frame of 223 benches: {spread(times, 2)} s after the start of the process")


async def _frames(address: str, count: int) -> None:
    async with ClientSession() as web, web.ws_connect(address.replace("/?", "/socket?")) as socket:
        while count:
            message = await socket.receive()
            count -= isinstance(message.data, bytes)


def clients() -> None:
    """Rate of the physics with one client and with many."""
    for number in sized((1, CLIENTS), (CLIENTS,)):
        with program() as (process, address):
            frames, rates = asyncio.run(_watch(address, number))
            used = psutil.Process(process.pid).cpu_percent(1.0)
        print(f"{number} clients: {frames:.0f} frames/s each, {rates:.3f} times real time, {used:.0f} % of a core")


async def _watch(address: str, number: int) -> tuple[float, float]:
    """Frames a second of each client, and simulated over real time, from the second `FRAMES` frames."""

    async def watch() -> tuple[float, float]:
        seen: list[tuple[float, float]] = []
        async with ClientSession() as web, web.ws_connect(address.replace("/?", "/socket?"), max_msg_size=0) as socket:
            async for message in socket:
                if isinstance(message.data, bytes):
                    seen.append((time.perf_counter(), time_of(message.data)))
                if len(seen) == 2 * FRAMES:
                    break
        (begin, first), (end, last) = seen[FRAMES - 1], seen[-1]
        return FRAMES / (end - begin), (last - first) / (end - begin)

    found = await asyncio.gather(*(watch() for _ in range(number)))
    return sum(frames for frames, _ in found) / number, found[0][1]


def memory() -> None:
    """Memory of the process while a client watches, and while it drags all the time; nothing is reset."""
    for drags in sized((False, True), (True,)):
        with program("pendulum") as (process, address):
            print(f"a client {'drags' if drags else 'watches'}: {asyncio.run(_play(address, process.pid, drags))}")


async def _play(address: str, pid: int, drags: bool) -> str:
    """Simulated time, number of inputs, and memory at both ends, after a quarter of the time to begin."""
    sizes: list[float] = []
    inputs, simulated, begin = 0, 0.0, time.perf_counter()
    async with ClientSession() as web, web.ws_connect(address.replace("/?", "/socket?"), max_msg_size=0) as socket:
        await socket.send_json({"do": "speed", "value": 20})
        await socket.send_json({"do": "grab", "x": 1.5, "y": 0, "slip": 5})
        async for message in socket:
            if isinstance(message.data, bytes):
                simulated = time_of(message.data)
            passed = time.perf_counter() - begin
            for _ in range(DRAGS if drags else 0):
                inputs += 1
                x, y = (float(f"{(time.perf_counter() - begin) % size:.6g}") for size in (3, 2))
                await socket.send_json({"do": "drag", "x": x, "y": y})
            if passed > PLAYED * (0.25, 1.0)[len(sizes)]:
                sizes.append(psutil.Process(pid).memory_info().rss / 1e6)
            if len(sizes) == 2:
                break
    return f"{simulated:.0f} s simulated, {inputs} inputs, {sizes[0]:.1f} and {sizes[1]:.1f} MB"


def browser() -> None:
    """Pictures a second in Chromium, and the rate of the physics."""
    with program() as (_, address), chromium() as started, opened(started, address) as found:
        page = found.page
        wait_until(page, f"live.drawn > {FRAMES}")
        drawn, begin = page.evaluate("live.drawn"), time.perf_counter()
        wait_until(page, f"live.drawn > {drawn + FRAMES}")
        pictures = (page.evaluate("live.drawn") - drawn) / (time.perf_counter() - begin)
        rate = page.evaluate("live.frame.rate")
        print(f"Chromium: {pictures:.1f} pictures a second of 223 benches, {rate:.3f} times real time")


def delay() -> None:
    """Time from a movement of the mouse to the first picture in which the body has moved."""
    with (
        live("boxes", browser=False) as session,
        chromium() as started,
        opened(started, session.address) as found,
    ):
        page = found.page
        wait_until(page, "live.drawn && live.frame.time > 2.5")
        x, y = page.evaluate(f"live.pixel(...{TOP})")
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
        times = page.evaluate("delays")
        print(f"from the mouse to the moved body: {median(times):.0f} ms ({min(times):.0f} to {max(times):.0f})")


# Where the uppermost box is.
TOP = """live.frame.calls.filter((call) => call.moves).map(({ points }) => [0, 1].map((axis) =>
  points.reduce((sum, point) => sum + point[axis] / points.length, 0))).sort((a, b) => b[1] - a[1])[0]"""
# The time of an event, and of the first picture afterwards in which the held body has moved by a millimetre.
WATCH = """() => {
  window.delays = [];
  document.querySelector("#field").addEventListener("pointermove", (event) => {
    const begin = performance.now(), from = live.frame.held[0], drawn = live.drawn;
    const look = () => {
      const now = live.frame.held[0];
      if (Math.abs(now - from) > 1e-3 && live.drawn > drawn) delays.push(performance.now() - begin);
      else requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
  });
}"""


PARTS = {"start": start, "clients": clients, "memory": memory, "browser": browser, "delay": delay}

if __name__ == "__main__":
    for name in arguments() or PARTS:
        PARTS[name]()
