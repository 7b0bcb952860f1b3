"""The server of a live session: a page, and a WebSocket for each client, by aiohttp in a thread."""

import asyncio
import errno
import ipaddress
import json
import secrets
import socket
import threading
from collections.abc import Awaitable, Callable, Sequence
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from typing import Any
from urllib.parse import urlsplit

from aiohttp import WSMsgType, web
from aiohttp.typedefs import Handler

from pymunk_dragon._language import language
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.sessions.client import Client
from pymunk_dragon.sessions.page import live_page
from pymunk_dragon.sessions.session import Session

# Messages that are taken of a client in a second: the others wait.
_MOST_MESSAGES = 500
# Messages of a client that had to wait, after which the client is disconnected.
_MOST_DELAYED = 5000
# Largest message of a client, bytes: more than any message of the page has.
_MAX_BYTES = 16_384
# Texts that may wait for a client: a client that does not take them is disconnected.
_MAX_WAITING = 1000
# Clients at once.
_MAX_CLIENTS = 220
# Clients at once that only watch: fewer, so that there is room for those that control.
_MAX_WATCHERS = 200
# Time after which a client that does not answer is disconnected, s.
_HEARTBEAT = 20.0
# Longest time for saving inputs, s.
_SAVE_TIME = 10.0
# Time for the last bytes when the server ends, s.
_STOP_TIME = 0.5
# Names of this machine that no other machine can reach.
_LOOPBACK = ("localhost", "127.0.0.1", "::1")
_HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
_Action = Callable[..., object]


class _Client(Client):
    """A browser, and what it has to get: texts, and the newest frame."""

    def __init__(
        self,
        session: Session,
        connection: web.WebSocketResponse,
        controls: bool,
        drop: _Action,
        call: _Action,
    ) -> None:
        self.session = session
        self.controls = controls
        self._connection = connection
        self._drop = drop
        # Has something done in the thread of the server.
        self._call = call

        self._news = asyncio.Event()
        self._waiting: dict[object, Callable[[], Awaitable[None]]] = {}

    def send_text(self, text: str) -> None:
        """Send a text."""
        self._call(self._put, object(), partial(self._connection.send_str, text))

    def show(self, frame: bytes, outlines: bytes) -> None:
        """Send a frame, unless a newer one comes before this client takes it."""
        if outlines not in (b"", self.outlines):
            self.outlines = outlines
            self._call(self._put, "outlines", partial(self._connection.send_bytes, outlines))
        self._call(self._put, "frame", partial(self._connection.send_bytes, frame))

    def stop(self) -> None:
        """Close the connection."""
        self._call(self._drop)

    def _put(self, key: object, send: Callable[[], Awaitable[None]]) -> None:
        self._waiting.pop(key, None)
        self._waiting[key] = send
        self._news.set()
        if len(self._waiting) > _MAX_WAITING:
            self.stop()

    async def send(self) -> None:
        """Send what there is, as fast as the client takes it."""
        with suppress(ConnectionError):
            while await self._news.wait():
                self._news.clear()
                while self._waiting:
                    await self._waiting.pop(next(iter(self._waiting)))()


class Server:
    """Serves a session to browsers, until `stop`.

    The page at `address` controls the session, the page at `watch_address` only watches. `front` is
    a page to show first, with the live page in it.
    """

    def __init__(
        self,
        session: Session,
        *,
        host: str,
        port: int,
        allow_hosts: Sequence[str] = (),
        front: str | None = None,
    ) -> None:
        self._session = session
        self._front = front
        # The caller's language, which the thread of the server does not have.
        self._language = language()

        self._proxies = {name.lower() for name in allow_hosts}
        self._known = {*_LOOPBACK, host.lower(), socket.gethostname().lower(), *self._proxies}
        self._any_address = host not in _LOOPBACK
        self._socket = _bound(host, port)

        name = host
        if host in ("0.0.0.0", "::"):
            name = "127.0.0.1"
        elif ":" in host:
            name = f"[{host}]"
        page = f"http://{name}:{self._socket.getsockname()[1]}/?token="
        self._control_token = secrets.token_urlsafe(16)
        self._watch_token = secrets.token_urlsafe(16)
        self.address = page + self._control_token
        self.watch_address = page + self._watch_token

        application = web.Application(middlewares=[self._check])
        application.router.add_get("/", self._page)
        application.router.add_get("/live", self._page)
        application.router.add_get("/socket", self._connect)
        application.router.add_get("/inputs", self._inputs)
        application.on_response_prepare.append(_add_headers)

        self._loop = asyncio.new_event_loop()
        quiet: Any = {"handle_signals": False, "print": None, "access_log": None}
        serve = partial(
            web.run_app,
            application,
            sock=self._socket,
            loop=self._loop,
            shutdown_timeout=_STOP_TIME,
            **quiet,
        )
        self._thread = threading.Thread(target=serve, name="pymunk-dragon live server", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the server; its thread is gone afterwards."""
        self._call(self._end)
        self._thread.join()
        self._socket.close()

    def _call(self, action: _Action, *arguments: Any) -> None:
        """Have something done in the server's thread."""
        with suppress(RuntimeError):  # The loop has ended.
            self._loop.call_soon_threadsafe(action, *arguments)

    # ---- the server's thread

    def _end(self) -> None:
        raise web.GracefulExit

    @web.middleware
    async def _check(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Refuse requests of another page, and those without a token.

        Another page is also one whose name is rebound to this machine.
        """
        has_token = _has(request, self._control_token) or _has(request, self._watch_token)
        if not (has_token and self._is_known(request)):
            message = "Open the address that was printed; behind a proxy, see --allow-host.\n"
            raise web.HTTPForbidden(text=message)
        return await handler(request)

    def _is_known(self, request: web.Request) -> bool:
        """Whether the host of a request is this server, and its origin a page of this server."""
        host = request.headers.get("Host", "")
        with suppress(ValueError):  # A text that is no address.
            page = urlsplit(request.headers.get("Origin", f"//{host}"))
            # A proxy with an allowed name may replace the host, but not the origin.
            if page.netloc == host or page.hostname in self._proxies:
                name = urlsplit(f"//{host}").hostname or ""
                return name in self._known or (
                    self._any_address and bool(ipaddress.ip_address(name))
                )
        return False

    async def _page(self, request: web.Request) -> web.Response:
        if self._front is not None and request.path == "/":
            return web.Response(text=self._front, content_type="text/html")
        page, rules = live_page(self._session.source.title, self._language)
        headers = {"Content-Security-Policy": rules}
        return web.Response(text=page, content_type="text/html", headers=headers)

    async def _inputs(self, request: web.Request) -> web.Response:
        """The inputs so far, as JSON from which the session is played again."""
        found: Future[str] = Future()
        self._session.call(lambda: found.set_result(json.dumps(self._session.log())))
        # After a timeout the session may still set the result, so the future is not cancelled.
        text = await asyncio.wait_for(asyncio.shield(asyncio.wrap_future(found)), _SAVE_TIME)
        headers = {"Content-Disposition": 'attachment; filename="live.json"'}
        return web.Response(text=text, content_type="application/json", headers=headers)

    async def _connect(self, request: web.Request) -> web.StreamResponse:
        controls = _has(request, self._control_token)
        others = [each.controls for each in self._session.clients]
        if len(others) >= _MAX_CLIENTS or (others.count(False) >= _MAX_WATCHERS and not controls):
            raise web.HTTPServiceUnavailable(text="There are too many clients.\n")

        connection = web.WebSocketResponse(
            compress=False, heartbeat=_HEARTBEAT, max_msg_size=_MAX_BYTES
        )
        await connection.prepare(request)
        assert request.transport is not None  # The request is being answered.
        client = _Client(self._session, connection, controls, request.transport.abort, self._call)
        self._session.join(client)
        sending = asyncio.create_task(client.send())

        due = 0.0
        delayed = 0
        try:
            async for message in connection:
                # A second's messages may come at once; then nothing is read from this client for a
                # while.
                due = max(due, self._loop.time() - 1) + 1 / _MOST_MESSAGES
                wait = due - self._loop.time()
                if wait > 0:
                    delayed += 1
                    await asyncio.sleep(wait)
                if delayed > _MOST_DELAYED:
                    client.stop()
                client.take(message.data if message.type is WSMsgType.TEXT else "")
        finally:
            sending.cancel()
            self._session.leave(client)
        return connection


def _has(request: web.Request, token: str) -> bool:
    """Whether a request has a token; the time that this takes reveals no token."""
    given = request.query.get("token", "")
    return secrets.compare_digest(given.encode(), token.encode())


def _bound(host: str, port: int) -> socket.socket:
    """A socket that listens; port 0 is a free one."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        return socket.create_server((host, port), family=family)
    except (OSError, UnicodeError) as error:
        is_taken = getattr(error, "errno", None) in (errno.EADDRINUSE, errno.EACCES)
        name, value = ("port", port) if is_taken else ("host", host)
        raise ParameterError(name, value, f"one that is free on this machine ({error})") from error


async def _add_headers(request: web.Request, response: web.StreamResponse) -> None:
    """Add the headers of all answers, also of those to paths and methods that do not exist."""
    response.headers.update(_HEADERS)
