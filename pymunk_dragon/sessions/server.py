"""The server of a live session: a page, and a WebSocket for each client, with aiohttp in a thread of its own."""

from __future__ import annotations

import asyncio
import errno
import ipaddress
import json
import secrets
import socket
import threading
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from typing import Any
from urllib.parse import urlsplit

from aiohttp import WSMsgType, web
from aiohttp.typedefs import Handler

from pymunk_dragon._arguments import whole
from pymunk_dragon._language import language
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.sessions.page import live_page
from pymunk_dragon.sessions.recording import Log
from pymunk_dragon.sessions.session import Session

# Bytes of a message.
_MAX_BYTES = 16_384
# Messages of a client in a second: the others wait, and a client of which so many had to wait is disconnected.
_MOST_MESSAGES, _MOST_DELAYED = 500, 5000
# Texts that wait for a client; one that does not take them is disconnected.
_MAX_TEXTS = 1000
# Clients at once, and those of them who only watch: places are kept for those who control.
_MAX_CLIENTS, _MAX_WATCHERS = 220, 200
# s after which a client that does not answer is disconnected; in which inputs are saved; for the last bytes.
_HEARTBEAT, _SAVE_TIME, _STOP_TIME = 20.0, 10.0, 0.5
_LOOPBACK = ("localhost", "127.0.0.1", "::1")
_HEADERS = {"Cache-Control": "no-store", "Referrer-Policy": "no-referrer", "X-Content-Type-Options": "nosniff"}
_Action = Callable[[], object]
_Call = Callable[[_Action], object]


class _Client:
    """A browser: texts that it has to get, and the newest frame."""

    def __init__(self, connection: web.WebSocketResponse, controls: bool, drop: _Action, call: _Call) -> None:
        self.controls, self.drop, self._call = controls, drop, call
        self._connection, self._news = connection, asyncio.Event()
        self._texts: deque[str] = deque()
        self._frame: bytes | None = None
        self._due, self._delayed = 0.0, 0

    def tell(self, message: dict[str, Any]) -> None:
        """Send a text; a client that does not take them is disconnected."""
        role = {} if self.controls or message["kind"] != "scene" else {"role": "watch"}
        self._texts.append(json.dumps(message | role, allow_nan=False))
        self._call(self._news.set if len(self._texts) <= _MAX_TEXTS else self.drop)

    def show(self, frame: bytes) -> None:
        """Send a frame, unless a newer one comes before this client takes it."""
        self._frame = frame
        self._call(self._news.set)

    async def send(self) -> None:
        """Send what there is, as fast as the client takes it."""
        with suppress(ConnectionError):
            while await self._news.wait():
                self._news.clear()
                while self._texts:
                    await self._connection.send_str(self._texts.popleft())
                frame, self._frame = self._frame, None
                if frame is not None:
                    await self._connection.send_bytes(frame)

    async def slow_down(self) -> None:
        """Wait after a message too many: meanwhile, nothing is read from this client."""
        now = asyncio.get_running_loop().time()
        # A second's messages may come at once.
        self._due = max(self._due, now - 1) + 1 / _MOST_MESSAGES
        if self._due > now:
            self._delayed += 1
            if self._delayed > _MOST_DELAYED:
                self.drop()
            await asyncio.sleep(self._due - now)


class Server:
    """Serves a session to browsers, until `stop`; `front` is a page to show first, which may have the live page in it.

    With `address` one controls the session, with `watch_address` one only watches.
    """

    def __init__(
        self, session: Session, *, host: str, port: int, allow_hosts: Sequence[str] = (), front: str | None = None
    ) -> None:
        self._session, self._front = session, front
        self._proxies = {name.lower() for name in allow_hosts}
        self._known = {*_LOOPBACK, host.lower(), socket.gethostname().lower(), *self._proxies}
        self._any_address = host not in _LOOPBACK
        # Now, because the thread of the server does not have it.
        self._language = language()
        self._socket = _bound(host, port)
        self._tokens = [secrets.token_urlsafe(16) for _ in range(2)]
        name = "127.0.0.1" if host in ("0.0.0.0", "::") else f"[{host}]" if ":" in host else host
        page = f"http://{name}:{self._socket.getsockname()[1]}/?token="
        self.address, self.watch_address = (page + token for token in self._tokens)
        self._clients: set[_Client] = set()
        self._loop = asyncio.new_event_loop()
        application = web.Application(middlewares=[self._check])
        pages = {"/": self._page, "/live": self._page, "/socket": self._connect, "/inputs": self._inputs}
        application.add_routes([web.get(path, handler) for path, handler in pages.items()])
        application.on_response_prepare.append(_add_headers)
        options: dict[str, Any] = {"handle_signals": False, "print": None, "access_log": None}
        options |= {"sock": self._socket, "loop": self._loop, "shutdown_timeout": _STOP_TIME}
        serve = partial(web.run_app, application, **options)
        self._thread = threading.Thread(target=serve, name="pymunk-dragon live server", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the server; its thread is gone afterwards."""
        self._call(self._end)
        self._thread.join()
        self._socket.close()

    def _call(self, action: _Action) -> None:
        """Have something done in the server's thread."""
        with suppress(RuntimeError):  # The loop has ended.
            self._loop.call_soon_threadsafe(action)

    # ---- the server's thread

    def _end(self) -> None:
        for client in self._clients:
            client.drop()
        raise web.GracefulExit

    @web.middleware
    async def _check(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Refuse requests that come under another name or from another page, or have no token."""
        if self._is_foreign(request.headers.get("Host", ""), request.headers.get("Origin")):
            raise web.HTTPForbidden(text="This host or the page that requests it is not known. See --allow-host.\n")
        if not any(self._rights(request)):
            raise web.HTTPForbidden(text="The address needs the token that was printed.\n")
        return await handler(request)

    def _rights(self, request: web.Request) -> list[bool]:
        """Whether a request may control the session, and whether it may only watch."""
        given = request.query.get("token", "").encode()
        return [secrets.compare_digest(given, token.encode()) for token in self._tokens]

    def _is_foreign(self, host: str, origin: str | None) -> bool:
        """Whether a request is one of another page, or of a page whose name is rebound to this machine."""
        try:
            name, page = urlsplit(f"//{host}").hostname or "", urlsplit(f"//{host}" if origin is None else origin)
            # A proxy with an allowed name may replace the host, but not the origin.
            if page.netloc != host and page.hostname not in self._proxies:
                return True
            return name not in self._known and not (self._any_address and ipaddress.ip_address(name))
        except ValueError:  # It is no address.
            return True

    async def _page(self, request: web.Request) -> web.Response:
        if self._front is not None and request.path == "/":
            return web.Response(text=self._front, content_type="text/html")
        page, rules = live_page(self._session.source.title, self._language)
        return web.Response(text=page, content_type="text/html", headers={"Content-Security-Policy": rules})

    async def _inputs(self, request: web.Request) -> web.Response:
        """What was done so far, as JSON from which the session is played again."""
        found: Future[str] = Future()
        self._session.call(lambda: found.set_result(Log.of(self._session).to_json()))
        # The session may still take it later.
        text = await asyncio.wait_for(asyncio.shield(asyncio.wrap_future(found)), _SAVE_TIME)
        headers = {"Content-Disposition": 'attachment; filename="live.json"'}
        return web.Response(text=text, content_type="application/json", headers=headers)

    async def _connect(self, request: web.Request) -> web.StreamResponse:
        controls, _ = self._rights(request)
        watchers = sum(not client.controls for client in self._clients)
        if len(self._clients) >= _MAX_CLIENTS or (watchers >= _MAX_WATCHERS and not controls):
            raise web.HTTPServiceUnavailable(text="There are too many clients.\n")
        connection = web.WebSocketResponse(compress=False, heartbeat=_HEARTBEAT, max_msg_size=_MAX_BYTES)
        await connection.prepare(request)
        assert request.transport is not None  # The request is being answered.
        client = _Client(connection, controls, request.transport.abort, self._call)
        self._clients.add(client)
        self._session.join(client)
        sending = asyncio.create_task(client.send())
        try:
            async for message in connection:
                await client.slow_down()
                self._session.receive(client, message.data if message.type is WSMsgType.TEXT else "")
        finally:
            self._clients.discard(client)
            sending.cancel()
            self._session.leave(client)
        return connection


def _bound(host: str, port: int) -> socket.socket:
    """Return a socket that listens; port 0 is a free one."""
    whole("port", port, 0, 65535)
    try:
        return socket.create_server((host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET)
    except (OSError, UnicodeError) as error:
        is_taken = getattr(error, "errno", None) in (errno.EADDRINUSE, errno.EACCES)
        name, value = ("port", port) if is_taken else ("host", host)
        reason = getattr(error, "strerror", None) or error
        raise ParameterError(name, value, f"one that is free on this machine ({reason})") from error


async def _add_headers(request: web.Request, response: web.StreamResponse) -> None:
    """Add the headers that all answers have, also those of addresses and methods that do not exist."""
    response.headers.update(_HEADERS)
