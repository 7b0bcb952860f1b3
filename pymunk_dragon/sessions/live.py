"""`live` and `Live`: a session from Python, a notebook, or the command line."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any, ClassVar

import pymunk

from pymunk_dragon._checks import (
    finite,
    flag,
    function,
    instance,
    instances,
    label,
    numbers,
    whole,
    word,
)
from pymunk_dragon._extras import library
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.sessions import ends
from pymunk_dragon.sessions.controls import Button, Key, PygameEvents, Slider
from pymunk_dragon.sessions.draw import Draw
from pymunk_dragon.sessions.restore import FirstState
from pymunk_dragon.sessions.scene import PARTS, PlaySettings
from pymunk_dragon.sessions.scenes import SceneSource, march_scene, named_scene, space_scene
from pymunk_dragon.sessions.session import MAX_STEP, Session

if TYPE_CHECKING:
    from pymunk_dragon.sessions.server import Server

# Ports have 16 bits.
_MAX_PORT = 65_535
# Longest time that a program waits at once, s: on Windows, Ctrl-C takes effect only between waits.
_MAX_WAIT = 0.1
# Exit code of a program that Ctrl-C ended.
_INTERRUPTED = 130


class Live(AbstractContextManager["Live"]):
    """A running session; `live` makes it.

    Examples
    --------
    >>> with live("pendulum", browser=False) as session:
    ...     session.address.startswith("http://127.0.0.1:")
    True
    """

    # Makes the handle of a session: another one where a program is published.
    made_by: ClassVar[Callable[..., Live] | None] = None
    # Whether the session is shown, also to those who do not know its address.
    shown = True

    def __init__(self, session: Session, *, browser: bool = False, **options: Any) -> None:
        # Where there are widgets, the server may use the port much later.
        whole("port", options["port"], 0, _MAX_PORT)
        self._session = session
        self._options = options
        # The session of the cell's last run may have the port.
        ends.begin(self, session)
        if not ends.has_widgets():
            address = self.address
            # Published pages begin sooner without it.
            import webbrowser

            self.shown = browser and webbrowser.open(address)
        session.start()

    @cached_property
    def _server(self) -> Server:
        """The server; where there are widgets, it starts when its address is read."""
        library("aiohttp")
        from pymunk_dragon.sessions.server import Server

        return Server(self._session, **self._options)

    @property
    def address(self) -> str:
        """Address of the page with which one controls the session."""
        return self._server.address

    @property
    def watch_address(self) -> str:
        """Address with which one only watches."""
        return self._server.watch_address

    def step(self, dt: float) -> None:
        """Make a step of `dt` s: call it in place of ``space.step(dt)``.

        A program that makes the steps itself needs ``live(space, step=None)``. It waits here until
        the step is due: in real time, or while the page has paused it. An exception in a callback
        is raised here, and does not pause the session; one in a chart or a control is shown on the
        page.

        In a notebook, show the session in an earlier cell, and run the loop when the page is there:
        ipykernel 7.4 takes the first message of a page only between cells.
        """
        self._session.step(dt)

    def wait(self) -> None:
        """Keep the program running until the session ends.

        Ctrl-C ends the session, and the program with exit code 130. A published page goes on
        without its program, so there the program does not wait; nor does one that makes the steps
        itself.

        Examples
        --------
        >>> live(build).wait()  # doctest: +SKIP
        """
        try:
            while self._session.goes_on(_MAX_WAIT):
                pass
        except KeyboardInterrupt:
            self.stop()
            # One types commands, and goes on with that.
            if ends.is_interactive():
                raise
            ends.note("interrupted")
            sys.exit(_INTERRUPTED)

    def stop(self) -> None:
        """End the session and its server."""
        ends.forget(self)
        self._session.stop()
        if "_server" in vars(self):
            self._server.stop()

    def paused(self) -> AbstractContextManager[bool]:
        """A context in which the space is not stepped, so that a program may change it."""
        return self._session.held

    def __exit__(self, *raised: object) -> None:
        self.stop()

    def _repr_mimebundle_(self, include: object = None, exclude: object = None) -> Any:
        """The page: a widget or, without anywidget, a frame."""
        if ends.has_widgets():
            from pymunk_dragon.sessions.widget import LiveWidget

            return LiveWidget(self._session).shown()
        about = 'title="A live session" width="100%" height="720" style="border: 0"'
        return {"text/html": f'<iframe src="{escape(self.address)}" {about}></iframe>'}


def live(
    what: March | pymunk.Space | Callable[..., pymunk.Space] | str | None = None,
    *,
    step: float | None = 1 / 60,
    on_step: Callable[[pymunk.Space, float], object] | None = None,
    controls: Sequence[Slider | Button | Key | PygameEvents] = (),
    plots: Mapping[str, Callable[[pymunk.Space], float]] | None = None,
    events: list[str] | None = None,
    view: tuple[float, float, float, float] | None = None,
    follow: Callable[[pymunk.Space], pymunk.Body | tuple[float, float]] | None = None,
    title: str | None = None,
    show: Sequence[str] | None = None,
    on_draw: Callable[[pymunk.Space, Draw], object] | None = None,
    on_click: Callable[[pymunk.Space, pymunk.Vec2d, int], object] | None = None,
    y_down: bool = False,
    units: str = "m",
    paused: bool = False,
    browser: bool = True,
    host: str = "127.0.0.1",
    port: int = 0,
    allow_hosts: Sequence[str] = (),
) -> Live:
    """Step a march or any Pymunk space in real time, and show it in a browser to be touched.

    Give a function that builds the space: it is called at the start and at each reset, which then
    repeats the run to the bit. A space that is given gets back all that Pymunk lets a program
    change; where bodies touch, its run may then differ. The session that is returned steps the
    space in a thread of its own: `Live.wait` keeps a program running for it. In a notebook, a cell
    that runs again ends the sessions of its last run. Change the space in `on_step`, in the actions
    of controls and in Pymunk's callbacks, or from other threads in `Live.paused`.

    Parameters
    ----------
    what : March, pymunk.Space, callable or str, optional
        A march, a space, a function that returns one, with the values of sliders as arguments, or
        the name of a built-in scene.
    step : float, optional
        Length of a step of a space, s. None for a program with a loop of its own, which makes the
        steps by `Live.step`.
    on_step : callable, optional
        Function of the space and the time, s, that is called before each step.
    controls : sequence of Slider, Button, Key and PygameEvents
        What the page has in addition, each with a name of its own.
    plots : mapping of str to callable, optional
        Functions of the space whose values the page shows as charts, by their titles: over time, as
        histograms, or against each other.
    events : list of str, optional
        List to which your functions append texts, which the page shows as events.
    view : tuple of float, optional
        Centre x, y, width and height of the area to show at first; by default that of all shapes
        and joints. The button "whole field" of the page shows what there is then.
    follow : callable, optional
        Function of the space that returns a pymunk.Body or a point, on which the view stays centred
        until it is moved. The first view then only has the size of `view`.
    title : str, optional
        Title of the page; by default the first line of the docstring of a function that builds the
        space.
    show : sequence of str, optional
        What the picture has at first beside shapes and joints: "contacts", "forces", and of a
        dragon "curve", "exact", "handles" and "numbers". By default nothing for a space, and the
        curve and contacts for a dragon.
    on_draw : callable, optional
        Function of the space and a `Draw`, which draws lines, circles, arrows, trails and texts.
        It is called for each picture that a page is sent, also while the session is paused.
    on_click : callable, optional
        Function of the space, the point, and the button (1 left, 2 middle, 3 right), which is
        called between two steps for each click and tap with the tool "Program"; the page begins
        with this tool. It then still drags bodies.
    y_down : bool
        Whether y points down.
    units : str
        Unit of length, "m" or "px".
    paused : bool
        Whether to begin paused.
    browser : bool
        Whether to open a browser; if none opens, the address is printed on stderr.
    host : str
        Address to listen on.
    port : int
        Port to listen on; 0 is a free one.
    allow_hosts : sequence of str
        Names under which a proxy shows the page.

    Raises
    ------
    ParameterError
        If a parameter is unusable, or the port is taken.
    MissingExtraError
        If aiohttp is not installed.

    Examples
    --------
    >>> import pymunk
    >>> from pymunk_dragon import Slider, live
    >>> def build(gravity=900.0, radius=10.0):
    ...     space = pymunk.Space()
    ...     space.gravity = 0, gravity
    ...     body = pymunk.Body(1, 10)
    ...     space.add(body, pymunk.Circle(body, radius))
    ...     return space
    >>> controls = [Slider("gravity", 0, 2000), Slider("radius", 5, 20, rebuilds=True)]
    >>> with live(build, controls=controls, y_down=True, units="px", browser=False) as session:
    ...     print(session.address.partition(":")[0])
    http
    """
    if not label("host", host).isprintable():
        raise ParameterError("host", host, "a name or an address")
    if isinstance(allow_hosts, str):
        raise ParameterError("allow_hosts", allow_hosts, "a sequence of names")
    instances("allow_hosts", allow_hosts, str, "a sequence of names")
    flag("paused", paused)
    flag("browser", browser)

    settings = PlaySettings(
        step=step,
        on_step=on_step,
        controls=controls,
        plots={} if plots is None else plots,
        events=events,
        view=None if view is None else _checked_view(view),
        follow=follow,
        title=title,
        show=show,
        on_draw=on_draw,
        on_click=on_click,
        y_down=y_down,
        units=units,
    )
    _check_settings(settings)
    if what is None or isinstance(what, March | str):
        _check_unchanged(settings)
    session = Session(source_of(what, settings), running=not paused)
    make = Live.made_by or Live
    running = make(session, browser=browser, host=host, port=port, allow_hosts=allow_hosts)
    if not running.shown:
        ends.note(f"the session is shown at {running.address}")
    return running


def _check_settings(settings: PlaySettings) -> None:
    """Check how a space is to be played."""
    if settings.step is not None:
        finite("step", settings.step, 1e-6, MAX_STEP, "s")
    described = "a sequence of Slider, Button, Key and others"
    controls = instances("controls", settings.controls, Slider | Button | PygameEvents, described)
    names = [each.name for each in controls if not isinstance(each, PygameEvents)]
    for name in names:
        if names.count(name) > 1:
            raise ParameterError("controls", name, "the name of one control only")
    if settings.on_click is not None and len(names) < len(controls):
        bound = "left out beside PygameEvents, which get the mouse"
        raise ParameterError("on_click", settings.on_click, bound)

    plots = instance("plots", settings.plots, Mapping, "a mapping of titles to functions")
    for title, plot in plots.items():
        label("title of a plot", title)
        function(f"plots[{title!r}]", plot)
    if settings.events is not None:
        instance("events", settings.events, list, "a list, to which texts are appended")
        instances("events", settings.events, str, "a list of texts")
    for name in ("on_step", "follow", "on_draw", "on_click"):
        if (called := getattr(settings, name)) is not None:
            function(name, called)
    if settings.title is not None:
        label("title", settings.title)
    for part in instances("show", settings.show or (), str, "a sequence of words"):
        word("show", part, PARTS)
    flag("y_down", settings.y_down)
    label("units", settings.units)


def _checked_view(view: object) -> tuple[float, float, float, float]:
    """Centre, width and height of a view."""
    x, y, width, height = numbers("view", [view], 4)[0].tolist()
    if math.isfinite(x + y) and 0 < width < math.inf and 0 < height < math.inf:
        return x, y, width, height
    raise ParameterError("view", view, "finite: centre, and a width and a height above 0")


def _check_unchanged(settings: PlaySettings) -> None:
    """Refuse settings that a march and a named scene choose themselves."""
    usual = vars(PlaySettings())
    for name, value in vars(settings).items():
        # The controls may be an empty list, too.
        if name != "show" and value != usual[name] and value != []:
            raise ParameterError(name, value, "left out for a march and for a built-in scene")


def source_of(what: object, settings: PlaySettings) -> SceneSource:
    """How the scene of a march, a space, a function or a name is made, and what it shows."""
    source = _scene_of(what, settings)
    return source if settings.show is None else replace(source, show=settings.show)


def _scene_of(what: object, settings: PlaySettings) -> SceneSource:
    """How the scene of a march, a space, a function or a name is made."""
    if what is None or isinstance(what, str):
        return named_scene("dragon" if what is None else what)
    if isinstance(what, March):
        return march_scene(what)
    if isinstance(what, pymunk.Space):
        source = space_scene(FirstState(what).begin, settings)
        return replace(source, title=settings.title or "A space", given=True)
    if not callable(what):
        bound = "a March, a pymunk.Space, a function that returns one, or a scene's name"
        raise ParameterError("what", what, bound)
    return space_scene(what, settings)
