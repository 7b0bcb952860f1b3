"""The server of a live session: a page, and a WebSocket for each client, with aiohttp in a thread of its own.

Starlette with Uvicorn and websockets would do the same: seven packages instead of eight, and they are imported in 0.2 s
as well. aiohttp is one project with one set of releases, and waits while a client does not take what is sent.
"""

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
from contextlib import suppress
from typing import Any
from urllib.parse import urlsplit

from aiohttp import WSMsgType, web

from pymunk_dragon._language import language
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.sessions.log import Log
from pymunk_dragon.sessions.messages import MAX_MESSAGE, parsed
from pymunk_dragon.sessions.page import live_page
from pymunk_dragon.sessions.session import Session

# Bytes of a message: a character takes up to four.
_MAX_BYTES = 4 * MAX_MESSAGE
# Messages of a client in a second: the others wait, and a client that sends more for so many seconds is disconnected.
_MOST_MESSAGES, _FLOOD_TIME = 500, 10
# Texts that wait for a client; one that does not take them is disconnected.
_MAX_TEXTS = 1000
# Clients at once, and those of them who only watch: places are kept for those who control.
_MAX_CLIENTS, _MAX_WATCHERS = 220, 200
# s after which a client that does not answer is disconnected.
_HEARTBEAT = 20.0
# s in which the server has to begin, and clients to take the last bytes.
_START_TIME = 10.0
_STOP_TIME = 0.5
# Errors for which a port is to blame.
_PORT_ERRORS = (errno.EADDRINUSE, errno.EACCES)
# Bytes of randomness in a token.
_TOKEN_BYTES = 16
_LOOPBACK = ("localhost", "127.0.0.1", "::1")
_HEADERS = {"Cache-Control": "no-store", "Referrer-Policy": "no-referrer", "X-Content-Type-Options": "nosniff"}


class _Client:
    """A browser: texts that it has to get, and the newest frame."""

    def __init__(self, connection: web.WebSocketResponse, controls: bool, drop: Callable[[], object]) -> None:
        self._drop = drop
        self.connection, self.controls = connection, controls
        self._texts: deque[str] = deque()
        self._frame: bytes | None = None
        self._news = asyncio.Event()
        self._second, self._messages, self._floods = 0.0, 0, 0

    def tell(self, message: dict[str, Any]) -> None:
        """Send a text; a client that does not take them is disconnected."""
        if len(self._texts) >= _MAX_TEXTS:
            self._drop()
            return
        self._texts.append(json.dumps(message, allow_nan=False))
        self._news.set()

    def show(self, frame: bytes) -> None:
        """Send a frame, unless a newer one comes before this client takes it."""
        self._frame = frame
        self._news.set()

    async def slow_down(self) -> None:
        """Count a message, and wait before one too many: meanwhile, nothing is read from this client."""
        now = asyncio.get_running_loop().time()
        if now - self._second >= 1:
            self._second, self._messages = now, 0
        self._messages += 1
        if self._messages > _MOST_MESSAGES:
            self._floods += 1
            if self._floods >= _FLOOD_TIME:
                self._drop()
            await asyncio.sleep(self._second + 1 - now)

    async def send(self) -> None:
        """Send what there is, as fast as the client takes it."""
        with suppress(ConnectionError):
            while not self.connection.closed:
                await self._news.wait()
                self._news.clear()
                while self._texts:
                    await self.connection.send_str(self._texts.popleft())
                frame, self._frame = self._frame, None
                if frame is not None:
                    await self.connection.send_bytes(frame)


class Server:
    """Serves a session to browsers."""

    def __init__(
        self,
        session: Session,
        *,
        host: str = "127.0.0.1",
        port: int = 0,
        allowed: Sequence[str] = (),
        front: tuple[str, str] | None = None,
    ) -> None:
        self.session, self.host, self.port = session, host, port
        # A page, and its content security policy, which is shown first; it may have the live page in a frame.
        self._front = front
        self.token, self.watch_token = secrets.token_urlsafe(_TOKEN_BYTES), secrets.token_urlsafe(_TOKEN_BYTES)
        self._proxies = {name.lower() for name in allowed}
        self._allowed = {*_LOOPBACK, host.lower(), *self._proxies}
        self._any_address = host not in _LOOPBACK
        if self._any_address:
            self._allowed.add(socket.gethostname().lower())
        # Now, because the thread of the server does not have it.
        self._language = language()
        self._clients: set[_Client] = set()
        self._holder: _Client | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._end: asyncio.Event | None = None
        self._begun = threading.Event()
        self._failure: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="pymunk-dragon live server", daemon=True)
        session.audience.append(self)

    # ---- from other threads

    @property
    def address(self) -> str:
        """Address of the page, with which one controls the session."""
        return self._address(self.token)

    @property
    def watch_address(self) -> str:
        """Address of the page, with which one only watches."""
        return self._address(self.watch_token)

    def start(self) -> None:
        """Begin to serve."""
        self._thread.start()
        if not self._begun.wait(_START_TIME):
            raise ParameterError("host", self.host, f"an address that is found within {_START_TIME:g} s")
        if self._failure is not None:
            reason = (isinstance(self._failure, OSError) and self._failure.strerror) or self._failure
            if isinstance(self._failure, OSError) and self._failure.errno in _PORT_ERRORS:
                bound = f"one that is free on {self.host} ({reason})"
                raise ParameterError("port", self.port, bound) from self._failure
            raise ParameterError("host", self.host, f"an address of this machine ({reason})") from self._failure

    def stop(self) -> None:
        """End the server; its thread is gone afterwards."""
        if self._loop is not None and self._end is not None:
            with suppress(RuntimeError):  # It has ended.
                self._loop.call_soon_threadsafe(self._end.set)
        if self._thread.is_alive():
            self._thread.join()

    def _address(self, token: str) -> str:
        host = "127.0.0.1" if self.host in ("0.0.0.0", "::") else self.host
        return f"http://{f'[{host}]' if ':' in host else host}:{self.port}/?token={token}"

    def tell(self, message: dict[str, Any]) -> None:
        """Send a text to all clients."""
        self._each(lambda client: client.tell(self._for(client, message)))

    def show(self, frame: bytes) -> None:
        """Send a frame to all clients."""
        self._each(lambda client: client.show(frame))

    def _each(self, action: Callable[[_Client], object]) -> None:
        def act() -> None:
            for client in self._clients:
                action(client)

        self._call(act)

    def _call(self, action: Callable[[], object]) -> None:
        """Have something done in the server's thread."""
        if self._loop is not None:
            with suppress(RuntimeError):  # The loop has ended.
                self._loop.call_soon_threadsafe(action)

    @staticmethod
    def _for(client: _Client, message: dict[str, Any]) -> dict[str, Any]:
        return message | {"role": "control" if client.controls else "watch"} if message["kind"] == "scene" else message

    # ---- the server's thread

    def _run(self) -> None:
        try:
            asyncio.run(self._serve())
        except BaseException as error:
            self._failure = error
        finally:
            self._begun.set()

    async def _serve(self) -> None:
        self._loop, self._end = asyncio.get_running_loop(), asyncio.Event()
        application = web.Application(middlewares=[self._check])
        application.router.add_get("/", self._page)
        application.router.add_get("/live", self._page)
        application.router.add_get("/socket", self._socket)
        application.router.add_get("/inputs", self._inputs)
        runner = web.AppRunner(application, access_log=None, shutdown_timeout=_STOP_TIME)
        await runner.setup()
        try:
            site = web.TCPSite(runner, self.host, self.port)
            await site.start()
            assert site._server is not None  # The site was started.
            self.port = site._server.sockets[0].getsockname()[1]  # type: ignore[attr-defined]  # asyncio's own server has it.
            self._begun.set()
            await self._end.wait()
            # All at once: a client that does not read would have the next one wait.
            closing = [asyncio.wait_for(client.connection.close(), _STOP_TIME) for client in self._clients]
            await asyncio.gather(*closing, return_exceptions=True)
        finally:
            await runner.cleanup()

    @web.middleware
    async def _check(self, request: web.Request, handler: Any) -> web.StreamResponse:
        """Refuse requests that come under another name or from another page, or have no token."""
        host, origin = request.headers.get("Host", ""), request.headers.get("Origin")
        if not self._is_known(_parts(f"//{host}")[0]):
            return web.Response(status=403, text="This host is not known. See --allow-host.\n", headers=_HEADERS)
        # A proxy with an allowed name may replace the host, but not the origin.
        if origin is not None and _parts(origin)[1] != host and _parts(origin)[0] not in self._proxies:
            return web.Response(status=403, text="Requests of other pages are refused.\n", headers=_HEADERS)
        if not (_has_token(request, self.token) or _has_token(request, self.watch_token)):
            return web.Response(status=403, text="The address needs the token that was printed.\n", headers=_HEADERS)
        try:
            response: web.StreamResponse = await handler(request)
        except web.HTTPException as error:  # Such as of an address that does not exist.
            return web.Response(status=error.status, text=f"{error.reason}\n", headers=_HEADERS)
        return response

    def _is_known(self, name: str | None) -> bool:
        """Whether a request may name this host; another name may be that of a page that rebinds it to this machine."""
        if name is None or name.lower() in self._allowed:
            return name is not None
        try:
            ipaddress.ip_address(name)
        except ValueError:
            return False
        return self._any_address

    async def _page(self, request: web.Request) -> web.Response:
        live = live_page(self.session.source.title, self._language)
        page, rules = (self._front or live) if request.path == "/" else live
        headers = {**_HEADERS, "Content-Security-Policy": rules}
        return web.Response(text=page, content_type="text/html", headers=headers)

    async def _inputs(self, request: web.Request) -> web.Response:
        """What was done so far, as JSON from which the session is played again."""
        found: asyncio.Future[Log] = asyncio.get_running_loop().create_future()

        def take() -> None:
            log = Log.of(self.session)
            self._call(lambda: None if found.done() else found.set_result(log))

        self.session.call(take)
        text = (await asyncio.wait_for(found, _START_TIME)).to_json()
        return _download(text.encode(), "live.json", "application/json")

    async def _socket(self, request: web.Request) -> web.StreamResponse:
        controls = _has_token(request, self.token)
        watchers = sum(not client.controls for client in self._clients)
        if len(self._clients) >= _MAX_CLIENTS or (watchers >= _MAX_WATCHERS and not controls):
            return web.Response(status=503, text="There are too many clients.\n", headers=_HEADERS)
        connection = web.WebSocketResponse(compress=False, heartbeat=_HEARTBEAT, max_msg_size=_MAX_BYTES)
        await connection.prepare(request)
        transport = request.transport
        assert transport is not None  # The request is being answered.
        client = _Client(connection, controls, transport.abort)
        for text in self.session.greeting():
            client.tell(self._for(client, text))
        self._clients.add(client)
        self._count(1)
        sending = asyncio.create_task(client.send())
        try:
            async for message in connection:
                await client.slow_down()
                if message.type is WSMsgType.TEXT:
                    self._receive(client, message.data)
                else:
                    client.tell({"kind": "error", "text": "message must be a text"})
        finally:
            self._clients.discard(client)
            sending.cancel()
            if self._holder is client:
                self.session.post({"do": "drop"}, always=True)
            self._count(-1)
        return connection

    def _count(self, more: int) -> None:
        self.session.clients += more
        self.session.touch()

    def _receive(self, client: _Client, text: str) -> None:
        def answer(reason: str) -> None:
            self._call(lambda: client.tell({"kind": "error", "text": reason}))

        try:
            message = parsed(text)
        except ParameterError as error:
            client.tell({"kind": "error", "text": str(error)[:MAX_MESSAGE]})
            return
        if message["do"] == "ping":
            client.tell({"kind": "pong", "id": message["id"]})
        elif not client.controls:
            client.tell({"kind": "error", "text": "this address only watches"})
        else:
            # One hand: who grabs another body takes it over.
            self._holder = {"grab": client, "drop": None}.get(message["do"], self._holder)
            self.session.post(message, answer)


def _download(content: bytes, name: str, kind: str) -> web.Response:
    headers = {**_HEADERS, "Content-Disposition": f'attachment; filename="{name}"'}
    return web.Response(body=content, content_type=kind, headers=headers)


def _has_token(request: web.Request, token: str) -> bool:
    return secrets.compare_digest(request.query.get("token", "").encode(), token.encode())


def _parts(address: str) -> tuple[str | None, str | None]:
    """Name of the host in an address, and the same with its port; None if there is none."""
    try:
        found = urlsplit(address)
        return found.hostname, found.netloc
    except ValueError:
        return None, None
