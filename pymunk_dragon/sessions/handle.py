"""`live`: a session from Python, a notebook, or the command line."""

from __future__ import annotations

import sys
import webbrowser
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from functools import cached_property
from html import escape
from importlib.util import find_spec
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pymunk

from pymunk_dragon._arguments import finite
from pymunk_dragon._extras import library
from pymunk_dragon._files import check_destination
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.sessions.controls import Button, Key, PygameEvents, Slider
from pymunk_dragon.sessions.ready import Ready, dragon, program, ready
from pymunk_dragon.sessions.recording import RECORDING_ENDINGS, record
from pymunk_dragon.sessions.scene import Play
from pymunk_dragon.sessions.session import MAX_STEP, Session

if TYPE_CHECKING:
    from pymunk_dragon.sessions.server import Server

# What `reset` puts back in a space that no function builds. The angle comes first: Pymunk finds the position of a body
# from that of its centre of mass, with the angle.
_KEPT = ("angle", "position", "velocity", "angular_velocity", "force", "torque", "gravity", "damping", "iterations")


class Live(AbstractContextManager["Live"]):
    """A running session; `live` makes it.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March
    >>> with live(March(Dragon(benches=8)), browser=False) as session:
    ...     session.address.startswith("http://127.0.0.1:")
    True
    """

    def __init__(self, session: Session, path: Path | None = None, *, browser: bool = False, **options: Any) -> None:
        self._session, self._path, self._options = session, path, options
        # The server and the widgets, which end with the session.
        self._parts: list[Any] = []
        if not _has_widgets() and self.address and browser:
            webbrowser.open(self.address)
        session.start()

    @cached_property
    def _server(self) -> Server:
        """The server; where there are widgets, it starts when its address is read."""
        library("aiohttp")
        from pymunk_dragon.sessions.server import Server

        server = Server(self._session, **self._options)
        self._parts.append(server)
        return server

    @property
    def address(self) -> str:
        """Address of the page with which one controls the session."""
        return self._server.address

    @property
    def watch_address(self) -> str:
        """Address with which one only watches."""
        return self._server.watch_address

    def step(self, dt: float) -> None:
        """Make a step of `dt` s, in place of ``space.step(dt)``, in a program that makes the steps itself.

        The program waits here until the step is due: in real time, or while the page has paused it.
        """
        self._session.step(dt)

    def stop(self) -> None:
        """End the session and its server, and write the recording if there is to be one."""
        self._session.stop()
        for part in self._parts:
            part.stop()
        if self._path is not None:
            record(self._session, self._path)

    def paused(self) -> AbstractContextManager[bool]:
        """Return a context in which the space is not stepped, so that a program may change it."""
        return self._session.held

    def __exit__(self, *raised: object) -> None:
        self.stop()

    def _repr_mimebundle_(self, include: object = None, exclude: object = None) -> Any:
        """Return the page: a widget or, without anywidget, a frame."""
        if _has_widgets():
            from pymunk_dragon.sessions.widget import LiveWidget

            self._parts.append(LiveWidget(self._session))
            return self._parts[-1].shown()
        shape = 'width="100%" height="720" style="border: 0"'
        return {"text/html": f'<iframe src="{escape(self.address)}" title="A live session" {shape}></iframe>'}


def live(
    what: March | pymunk.Space | Callable[..., pymunk.Space] | str | None = None,
    *,
    step: float | None = 1 / 60,
    on_step: Callable[[pymunk.Space, float], object] | None = None,
    controls: Sequence[Slider | Button | Key | PygameEvents] = (),
    plots: Mapping[str, Callable[[pymunk.Space], float]] | None = None,
    events: list[str] | None = None,
    y_down: bool = False,
    units: str = "m",
    paused: bool = False,
    browser: bool = True,
    host: str = "127.0.0.1",
    port: int = 0,
    allow_hosts: Sequence[str] = (),
    record: str | Path | None = None,
) -> Live:
    """Step a march or any Pymunk space in real time, and show it in a browser, where it can be touched.

    Give a function that builds the space: it is called at the start and at each reset, which then repeats the run to
    the bit. The session that is returned steps the space in a thread of its own. Change the space in `on_step`, in the
    actions of controls and in Pymunk's callbacks, or from other threads in `Live.paused`.

    Parameters
    ----------
    what : March, pymunk.Space, callable or str, optional
        What to play: a march, a space, a function that returns a space, or the name of a ready scene; by default the
        dragon of the contest. Arguments of the function are the values of sliders.
    step : float, optional
        Length of a step of a space, s. None for a program with a loop of its own, which makes the steps by `Live.step`.
    on_step : callable, optional
        Function of the space and the time, s, that is called before each step.
    controls : sequence of Slider, Button, Key and PygameEvents
        What the page has in addition.
    plots : mapping of str to callable, optional
        Functions of the space whose values the page shows as charts, by their titles.
    events : list of str, optional
        List to which your functions append texts, which the page shows as events.
    y_down, units, paused : bool, str, bool
        Whether y points down on the page, unit of length, for example "px", and whether to begin paused.
    browser : bool
        Whether to open a browser; a notebook with anywidget shows the page itself.
    host, port, allow_hosts : str, int, sequence of str
        Address to listen on, by default for programs on this machine only; port, 0 for a free one; and names of hosts
        under which a proxy shows the page.
    record : path, optional
        File to write when the session is stopped: .json (inputs), or of a replay of them .npz (the run of a dragon).

    Raises
    ------
    ParameterError, MissingExtraError
        If a parameter is unusable, or the port is taken; if aiohttp is not installed.

    Examples
    --------
    >>> import pymunk
    >>> from pymunk_dragon import Button, Slider, live
    >>> def build(gravity=900.0, radius=10.0):
    ...     space = pymunk.Space()
    ...     space.gravity = 0, gravity
    ...     body = pymunk.Body(1, 10)
    ...     space.add(body, pymunk.Circle(body, radius))
    ...     return space
    >>> def kick(space):
    ...     next(iter(space.bodies)).apply_impulse_at_local_point((0, -500))
    >>> controls = [Slider("gravity", 0, 2000), Slider("radius", 5, 20, rebuilds=True), Button("Kick", kick)]
    >>> with live(build, controls=controls, y_down=True, units="px", browser=False) as session:
    ...     print(session.address.partition(":")[0])
    http
    """
    path = None if record is None else check_destination(record, RECORDING_ENDINGS)
    length = None if step is None else finite("step", step, 1e-6, MAX_STEP, "s")
    seen: Any = {"plots": plots or {}, "events": events, "y_down": y_down, "units": units}
    play = Play(step=length, on_step=on_step, controls=controls, **seen)
    session = Session(source_of(what, play), running=not paused)
    return Live(session, path, browser=browser, host=host, port=port, allow_hosts=allow_hosts)


def source_of(what: object, play: Play) -> Ready:
    """Return how the scene of a march, a space, a function or a name is made."""
    if what is None or isinstance(what, str):
        return ready(what or "dragon")
    if isinstance(what, March):
        return dragon(what)
    if isinstance(what, pymunk.Space):
        return program(_again(what), play)
    if not callable(what):
        raise ParameterError("what", what, "a March, a pymunk.Space, a function that returns one, or a scene's name")
    return program(what, play)


def _again(space: pymunk.Space) -> Callable[[], pymunk.Space]:
    """Return a function that returns a space, from the second time on as it is now."""
    items: list[pymunk.Body | pymunk.Shape | pymunk.Constraint] = [*space.bodies, *space.shapes, *space.constraints]
    before = [(part, name, getattr(part, name)) for part in (space, *items) for name in _KEPT if hasattr(part, name)]
    calls = count()

    def build() -> pymunk.Space:
        if next(calls):
            # All shapes are removed, as the space keeps contacts of shapes that stay.
            space.remove(*space.constraints, *space.shapes, *space.bodies)
            for part, name, value in before:
                setattr(part, name, value)
            space.add(*items)
        return space

    return build


def _has_widgets() -> bool:
    """Whether this runs in a notebook, for which anywidget is installed."""
    python = sys.modules.get("IPython")
    return getattr(python and python.get_ipython(), "kernel", None) is not None and find_spec("anywidget") is not None
