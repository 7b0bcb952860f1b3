"""Sessions that are stepped as fast as they go, replays of them, and clients of their server."""

from __future__ import annotations

import asyncio
import json
import struct
import threading
import time
from collections.abc import Callable
from contextlib import asynccontextmanager, contextmanager
from types import SimpleNamespace

import aiohttp
import numpy as np

from pymunk_dragon.sessions.client import Client
from pymunk_dragon.sessions.live import Live, source_of
from pymunk_dragon.sessions.replay import Log
from pymunk_dragon.sessions.scene import PlaySettings
from pymunk_dragon.sessions.scenes import recorded_scene
from pymunk_dragon.sessions.session import Session

# s that anything may take on a busy machine.
PATIENCE = 60.0
# Names of the kinds of calls in a frame.
KINDS = ("circle", "segment", "polygon", "line", "dot")


class Listener(Client):
    """A client of a session in the same process; `told` gets its messages."""

    def __init__(self, session, told):
        self.session = session
        self.told = told

    def tell(self, message):
        self.told.append(message)

    def show(self, frame, outlines):
        """Have no use for pictures."""

    def stop(self):
        """Have nothing to end."""

    def do(self, action, **arguments):
        """Send a message as a page does."""
        self.take(json.dumps({"do": action, **arguments}))


def notebook(run=1, cell="one", text=""):
    """The module IPython in a run of a cell of a notebook, which may have an identifier."""
    kernel = SimpleNamespace(get_parent=lambda: {"metadata": {"cellId": cell} if cell else {}})
    names = {"In": ["", text]}
    shell = SimpleNamespace(kernel=kernel, execution_count=run, user_ns=names)
    return SimpleNamespace(get_ipython=lambda: shell)


class Played:
    """A paused session without a server: `do` sends a message, `step` makes steps at once."""

    def __init__(self, source, **options):
        source = source if hasattr(source, "build") else source_of(source, PlaySettings())
        self.session = Session(source, running=False, **options)
        self.threads = set(threading.enumerate())
        self.told = []
        self.session.join(Listener(self.session, self.told))
        self.session.start()

    @property
    def scene(self):
        return self.session.scene

    def settle(self):
        """Wait until everything that was sent before has been taken."""
        for _ in range(2):
            taken = threading.Event()
            self.session.call(taken.set)
            assert taken.wait(PATIENCE), "the session's thread does not answer"

    def do(self, action, **arguments):
        """Send a message; the error that it is answered with."""
        answers = []
        Listener(self.session, answers).do(action, **arguments)
        self.settle()
        return answers[0]["text"] if answers else None

    def step(self, count):
        """Make up to `count` steps; how many were made before the session paused."""
        begin = self.scene.steps
        assert self.do("step", count=count) is None
        end = time.monotonic() + 10 * PATIENCE
        while self.session.clock.single_steps:
            assert time.monotonic() < end, "the session does not step"
            self.settle()
        self.settle()
        return self.scene.steps - begin

    def wait_for_end(self):
        """Stop, and wait for the thread, which may be in a function of the test's."""
        self.session.stop()
        for thread in set(threading.enumerate()) - self.threads:
            thread.join(PATIENCE)

    def run(self, seconds):
        return self.step(round(seconds / self.scene.step_length))

    @property
    def errors(self):
        return [message["text"] for message in self.told if message["kind"] == "error"]

    @property
    def events(self):
        return [message["text"] for message in self.told if message["kind"] == "event"]

    def frame(self):
        """What a client would be shown now."""
        found = []
        self.session.call(
            lambda: found.append(self.scene.frame({"generation": self.session.generation}))
        )
        self.settle()
        return decoded(found[0])


def greeting(on: Played):
    """What a client is sent when it connects."""
    told: list[object] = []
    on.session.join(Listener(on.session, told))
    return told[:]


@contextmanager
def played(source: object, **options: object):
    """A `Played` session, which is stopped in the end."""
    found = Played(source, **options)
    try:
        yield found
    finally:
        found.session.stop()


def replay_session(log: Log, before: Callable[[Session], object] = lambda session: None):
    """A session in a replay without pauses, and what it sends; `before` gets it first."""
    session, told = Session(recorded_scene(log["plan"]), log=log), []
    session.join(Listener(session, told))
    before(session)
    session.start()
    return session, told


def replayed(log: Log):
    """The last poses of a replay and its session."""
    session = Session(recorded_scene(log["plan"]), log=log)
    session.clock.speed = np.inf
    session.start()
    assert session.wait_for_replay() is not None
    session.stop()
    return session.scene.poses().tolist(), session


def decoded(frame: bytes):
    """A frame's header and arrays."""
    [length] = struct.unpack_from("<I", frame)
    header = json.loads(frame[4 : 4 + length])
    sizes = header["sizes"]
    rest = np.frombuffer(frame, "<f8", offset=4 + length)
    assert len(rest) == sum(sizes.values())
    parts = dict(zip(sizes, np.split(rest, np.cumsum(list(sizes.values()))[:-1]), strict=True))
    for name, columns in {"poses": 3, "exact": 3, "contacts": 5, "joints": 6}.items():
        if name in parts:
            parts[name] = parts[name].reshape(-1, columns)
    return SimpleNamespace(**header, **parts)


def drawn_in(scene):
    """What a page draws of a scene, as `calls_of` has it, and the frame."""
    frame = decoded(scene.frame({}))
    return all_calls(frame, scene.outlines), frame


def all_calls(frame, outlines):
    """What a page draws in a frame with the shapes that came before it."""
    shapes = decoded(outlines)
    poses = frame.bodies.reshape(-1, 3)
    placed = []
    for call, (x, y, angle) in zip(calls_of(shapes), poses[shapes.owners.astype(int)], strict=True):
        kind, points, radius, own, *rest = call
        cos, sin = np.cos(angle), np.sin(angle)
        moved = points @ [[cos, sin], [-sin, cos]] + (x, y)
        turned = own + angle if kind == "circle" else 0.0
        placed.append((kind, moved, radius, turned, *rest))
    return placed + calls_of(frame)


def calls_of(part):
    """Kind, points, radius, angle, colours and grip of the calls in a frame or of its shapes."""
    numbers, found = part.calls.tolist(), []
    while numbers:
        kind, count, radius, angle, fill, outline, held = numbers[:7]
        points = np.reshape(numbers[7 : 7 + 2 * int(count)], (-1, 2))
        rim = part.colours[int(outline)] if outline >= 0 else None
        found.append((KINDS[int(kind)], points, radius, angle, part.colours[int(fill)], rim, held))
        del numbers[: 7 + 2 * int(count)]
    return found


class Served(Live):
    """What `live` returns, for a session that a test can read."""

    def __init__(self, session: Session, **options: object):
        self.session = session
        super().__init__(session, **options)


@contextmanager
def served(source: object = "pendulum", **options: object):
    """A session with a server, without a browser."""
    session = Session(source if hasattr(source, "build") else source_of(source, PlaySettings()))
    found = Served(session, **{"host": "127.0.0.1", "port": 0} | options)
    try:
        yield found
    finally:
        found.stop()


class SocketClient:
    """One end of a WebSocket."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse):
        self.socket = socket
        self.errors = 0

    async def send(self, action: str, **arguments: object):
        await self.socket.send_str(json.dumps({"do": action, **arguments}))

    async def get(self, wanted: Callable[[object], bool]):
        """The next message that is wanted: a dict, or a frame."""
        async with asyncio.timeout(PATIENCE):
            while True:
                message = await self.socket.receive()
                if message.type is aiohttp.WSMsgType.TEXT:
                    found: object = json.loads(message.data)
                    self.errors += found["kind"] == "error"
                elif message.type is aiohttp.WSMsgType.BINARY:
                    found = decoded(message.data)
                    if "owners" in found.sizes:
                        # Shapes, which come before the frames.
                        continue
                else:
                    raise ConnectionError(f"closed with {message.data}")
                if wanted(found):
                    return found

    async def told(self, kind: str, **values: object):
        """The next text of a kind with these values."""
        return await self.get(
            lambda found: (
                isinstance(found, dict)
                and found["kind"] == kind
                and values.items() <= found.items()
            )
        )

    async def shown(self, wanted: Callable[[SimpleNamespace], bool] = lambda frame: True):
        """The next frame that is wanted."""
        return await self.get(lambda found: isinstance(found, SimpleNamespace) and wanted(found))


@asynccontextmanager
async def joined(address: str, **options: object):
    """A client of the session at the address of a page."""
    page, _, query = address.partition("?")
    async with (
        aiohttp.ClientSession() as http,
        http.ws_connect(f"{page}socket?{query}", max_msg_size=0, **options) as socket,
    ):
        yield SocketClient(socket)
