"""`live`: a session from Python, a notebook, or the command line."""

from __future__ import annotations

import os
import webbrowser
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from html import escape
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

import pymunk

from pymunk_dragon._checks import finite, whole
from pymunk_dragon._extras import library
from pymunk_dragon._files import check_destination
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.sessions.recording import RECORDING_ENDINGS, record
from pymunk_dragon.sessions.scenes import Ready, Scene, dragon, ready
from pymunk_dragon.sessions.session import Session

if TYPE_CHECKING:
    from pymunk_dragon.sessions.server import Server

# Pixels: height of the page in a notebook, which is as wide as the notebook.
FRAME_HEIGHT = 720
# s. Longest step of a space.
MAX_STEP = 10.0


class Live:
    """A running session; `live` makes it.

    Attributes
    ----------
    address : str
        Address of the page with which one controls the session.
    watch_address : str
        Address with which one only watches.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March
    >>> with live(March(Dragon(benches=8)), browser=False) as session:
    ...     session.address.startswith("http://127.0.0.1:")
    True
    """

    def __init__(self, session: Session, server: Server, path: Path | None) -> None:
        self._session, self._server, self._path = session, server, path

    @property
    def address(self) -> str:
        """Address of the page with which one controls the session."""
        return self._server.address

    @property
    def watch_address(self) -> str:
        """Address with which one only watches."""
        return self._server.watch_address

    def stop(self) -> None:
        """End the session and its server, and write the recording if there is to be one."""
        self._server.stop()
        if self._path is not None:
            record(self._session, self._path)

    @contextmanager
    def paused(self) -> Iterator[None]:
        """Context in which the space is not stepped, so that a program may change it."""
        with self._session.held():
            yield

    def __enter__(self) -> Live:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.stop()

    def __repr__(self) -> str:
        return f"Live({self.address})"

    def _repr_html_(self) -> str:
        """A frame with the page: from this machine or, on a JupyterHub, through its jupyter-server-proxy."""
        hub = os.environ.get("JUPYTERHUB_SERVICE_PREFIX")
        server = self._server
        address = self.address if hub is None else f"{hub}proxy/{server.port}/?token={server.token}"
        return (
            f'<iframe src="{escape(address)}" title="A live session" width="100%" height="{FRAME_HEIGHT}" '
            'style="border: 0"></iframe>'
        )


def live(
    what: March | pymunk.Space | str | None = None,
    *,
    step: float = 1 / 60,
    host: str = "127.0.0.1",
    port: int = 0,
    allow_hosts: Sequence[str] = (),
    browser: bool = True,
    record: str | Path | None = None,
) -> Live:
    """Step a march or any Pymunk space in real time, and show it in a browser, where it can be touched.

    Returns at once: the space is stepped in a thread of its own. Do not change it meanwhile, except in `Live.paused`.

    Parameters
    ----------
    what : March, pymunk.Space or str, optional
        What to play: a march, a space, or the name of a ready scene; by default the dragon of the contest.
    step : float
        Length of a step of a space, s.
    host : str
        Address to listen on. With the default, only programs on this machine can connect.
    port : int
        Port; 0 for a free one.
    allow_hosts : sequence of str
        Names of hosts under which a proxy shows the page.
    browser : bool
        Whether to open a browser.
    record : path, optional
        File to write when the session is stopped: .npz, .gif, .apng, .webp or .mp4.

    Returns
    -------
    Live
        The session; in a notebook it shows the page.

    Raises
    ------
    ParameterError
        If a parameter is unusable, or the port is taken.
    MissingExtraError
        If aiohttp is not installed.

    Examples
    --------
    >>> from pymunk_dragon import live
    >>> session = live("pendulum", browser=False)
    >>> session.stop()
    """
    library("aiohttp")
    path = None if record is None else check_destination(record, RECORDING_ENDINGS)
    return serve(
        Session(source_of(what, step), record=path is not None),
        host=host,
        port=port,
        allow_hosts=allow_hosts,
        browser=browser,
        path=path,
    )


def source_of(what: object, step: float = 1 / 60) -> Ready:
    """How the scene of a march, a space or a name is made."""
    if what is None or isinstance(what, str):
        return ready(what or "dragon")
    if isinstance(what, March):
        return dragon(what)
    if not isinstance(what, pymunk.Space):
        raise ParameterError("what", what, "a March, a pymunk.Space, or the name of a scene")
    length = finite("step", step, 1e-6, MAX_STEP, "s")
    return Ready(name="space", title="A space", text="Pull a body, cut a joint.", build=_again(what, length))


def _again(space: pymunk.Space, step: float) -> Callable[[Mapping[str, float]], Scene]:
    """Function that makes the scene of a space, and from the second time on puts the space back before."""
    made: list[Scene] = []

    def build(values: Mapping[str, float]) -> Scene:
        if made:
            made.pop().restore()
        made.append(Scene(space, step))
        return made[0]

    return build


def serve(
    session: Session, *, host: str, port: int, allow_hosts: Sequence[str], browser: bool, path: Path | None
) -> Live:
    """Start a session and its server."""
    whole("port", port, 0, 65535)
    from pymunk_dragon.sessions.server import Server

    server = Server(session, host=host, port=port, allowed=allow_hosts)
    server.start()
    if browser:
        webbrowser.open(server.address)
    return Live(session, server, path)
