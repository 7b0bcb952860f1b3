"""Sources of scenes: marches, spaces, recordings, and the scenes of the command, by name."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from inspect import Parameter, getdoc, isroutine, signature
from typing import Any

import pymunk

from pymunk_dragon._checks import finite, word
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves import Line, Spiral
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.scenario import Scenario
from pymunk_dragon.sessions.controls import Slider
from pymunk_dragon.sessions.dragon import DragonScene, Values
from pymunk_dragon.sessions.scene import PlaySettings, Scene

# Properties of a space, and its step, that a slider without an action may have.
_PROPERTIES = ("step", "gravity", "damping", "iterations")


@dataclass(frozen=True, kw_only=True)
class SceneSource:
    """How a scene is made."""

    name: str
    title: str
    text: str
    lesson: str | None = None
    # Builds the scene with values of sliders.
    build: Callable[[Values], Scene]
    # What a recording keeps in order to build the scene again; None for a scene that cannot be
    # recorded.
    saved_as: Mapping[str, Any] | None = None
    # Whether `build` changes a space of the user's, and does not build one.
    given: bool = False
    # What the page shows at first, in place of `Scene.shown`.
    show: Sequence[str] | None = None


# The scenes of the command, in the order in which pages list them.
SCENES: dict[str, SceneSource] = {}


def named_scene(name: str) -> SceneSource:
    """The scene of the command that has a name."""
    return SCENES[word("scene", name, list(SCENES))]


def march_scene(march: March, start: float = 0.0) -> SceneSource:
    """The scene of a march that begins at `start`, s."""
    finite("start", start, unit="s")
    try:
        saved_as = {"scenario": Scenario.of(march).to_dict(), "start": start}
    except ParameterError:  # A curve or a speed of the user's own.
        saved_as = None
    return SceneSource(
        name="own",
        title="A march",
        text="Pull a bench, cut a joint, let the dancers go.",
        build=partial(DragonScene, march, start=start),
        saved_as=saved_as,
    )


def recorded_scene(saved_as: Mapping[str, Any]) -> SceneSource:
    """The scene of a recording, from its `SceneSource.saved_as`."""
    if "scene" in saved_as:
        return named_scene(saved_as["scene"])
    march = Scenario.from_dict(saved_as["scenario"], files=False).march()
    return march_scene(march, saved_as["start"])


def space_scene(build: Callable[..., pymunk.Space], settings: PlaySettings) -> SceneSource:
    """The scene of a function that builds a space.

    Sliders with the names of the function's arguments have their values.
    """
    arguments = signature(build).parameters
    controls = []
    own: dict[str, Slider] = {}
    for each in settings.controls:
        if isinstance(each, Slider):
            each = own[each.name] = _at_start(each, arguments)
        controls.append(each)
    settings = replace(settings, controls=controls)

    def make(values: Values) -> Scene:
        given = {}
        for name, slider in own.items():
            if name in arguments:
                given[name] = slider.checked(values.get(name, slider.value))
        space = build(**given)
        if not isinstance(space, pymunk.Space):
            raise ParameterError("build", space, "a function that returns a pymunk.Space")

        scene = Scene(space, settings)
        for name, slider in scene.parameters.items():
            if name in values:
                value = values[name]
                # The ranges of other sliders are those of the space that was built now.
                if name not in own:
                    value = min(max(value, slider.low), slider.high)
                scene.set(name, value)
        return scene

    title = settings.title or _heading(build)
    return SceneSource(name="space", title=title, text="Pull a body, cut a joint.", build=make)


def _heading(build: object) -> str:
    """First line of the docstring of a function; classes and objects have others' docstrings."""
    text = isroutine(build) and getdoc(build)
    return text.partition("\n")[0].rstrip(".") if text else "A space"


def _at_start(slider: Slider, arguments: Mapping[str, Parameter]) -> Slider:
    """A slider with its value at the start, unless that is the value of a property of the space."""
    value = slider.value
    whole = slider.whole or slider.name == "iterations"
    argument = arguments.get(slider.name)
    if argument is not None:
        value = argument.default if value is None else value
        whole = whole or isinstance(value, int)
    elif slider.rebuilds or not (slider.action or slider.name in _PROPERTIES):
        known = ", ".join(arguments) or "none"
        bound = f"an argument of the function that builds the space ({known})"
        raise ParameterError("controls", slider.name, bound)

    if value is not None:
        slider.checked(value)
    return replace(slider, value=value, whole=whole)


def add(
    build: Any,
    *,
    name: str,
    title: str,
    lesson: str | None = None,
    saved_as: Any = None,
    **settings: Any,
) -> Any:
    """Add a scene, whose text is the docstring of `build`; return `build`.

    With `PlaySettings`, `build` returns a space; without, it returns a scene from values of
    sliders.
    """
    make = space_scene(build, PlaySettings(**settings)).build if settings else build
    SCENES[name] = SceneSource(
        name=name,
        title=title,
        text=" ".join(build.__doc__.split()),
        lesson=lesson,
        build=make,
        saved_as=saved_as,
        show=["contacts"] if settings else None,
    )
    return build


def _scene(
    name: str, title: str, lesson: str | None = None, **settings: Any
) -> Callable[[Any], Any]:
    """A decorator that adds a scene, whose name stands in recordings."""
    saved_as = {"scene": name}
    return partial(add, name=name, title=title, lesson=lesson, saved_as=saved_as, **settings)


@_scene("dragon", "The dragon")
def _dragon(values: Values) -> Scene:
    """The dragon of the contest marches in. Pull a bench, cut a joint, let the dancers go."""
    return DragonScene(March(), values)


@_scene("unguided", "Without dancers", "unguided")
def _unguided(values: Values) -> Scene:
    """Which two benches touch first? Let all dancers go, and watch."""
    return DragonScene(March(), values, contacts="stop")


@_scene("sloppy-engine", "A coarse engine", "engine")
def _sloppy_engine(values: Values) -> Scene:
    """Long steps and two iterations: watch the position error, then raise the iterations."""
    coarse = {"step": 60.0, "iterations": 2, **values}
    return DragonScene(March(), coarse, contacts="report", start=380.0)


@_scene("near-miss", "Near misses", "near-miss")
def _near_miss(values: Values) -> Scene:
    """Which bench does the head touch first?

    It passes bench 9 with a gap of 3 mm and bench 11 with 0.9 mm.
    """  # noqa: D400  # The page shows the question.
    return DragonScene(March(), values, contacts="stop", start=404.0)


@_scene("jam", "A jam")
def _jam(values: Values) -> Scene:
    """The path is blocked. Remove the obstacle, or see which forces the joints bear."""
    path = Line(start=(-24.0, 0.0), stop=(8.0, 0.0))
    scene = DragonScene(March(Dragon(benches=12), path, start_s=24.0), values)
    scene.obstacle("square", 4.0, 0.1, 2.0)
    return scene


def _space() -> pymunk.Space:
    """An empty space with gravity."""
    space = pymunk.Space()
    space.gravity = (0, -9.81)
    space.iterations = 20
    return space


def _box(
    space: pymunk.Space, size: tuple[float, float], x: float, y: float, group: int = 0
) -> pymunk.Body:
    """A new box of 1 kg in a space; boxes of the same group but 0 pass through each other."""
    body = pymunk.Body(1.0, pymunk.moment_for_box(1.0, size))
    body.position = (x, y)
    shape = pymunk.Poly.create_box(body, size)
    shape.friction = 0.7
    shape.filter = pymunk.ShapeFilter(group=group)
    space.add(body, shape)
    return body


@_scene("robot-arm", "A robot's arm", "robot")
def _robot_arm(values: Values) -> Scene:
    """Links that go where the tip went before."""
    spacings = [0.10] * 6 + [0.13] * 5 + [0.16] * 4
    widths = [0.05] * 7 + [0.06] * 5 + [0.07] * 4
    arm = Dragon(head_spacing=0.14, body_spacing=spacings, overhang=0.02, width=widths)
    return DragonScene(March(arm, Spiral(pitch=0.3), turns=3, speed=0.2), values)


@_scene("pendulum", "A pendulum of three rods", step=1 / 240, view=(0.0, -1.0, 7.0, 5.0))
def _pendulum() -> pymunk.Space:
    """Pull it up and drop it. Then cut a joint."""
    space = _space()
    before = space.static_body
    for i in range(3):
        rod = _box(space, (1.0, 0.08), i + 0.5, 0.0, group=1)
        space.add(pymunk.PivotJoint(before, rod, (i, 0.0)))
        before = rod
    return space


@_scene("cradle", "Newton's cradle", "engine", step=1 / 600, view=(0.0, 0.9, 5.0, 3.0))
def _cradle() -> pymunk.Space:
    """One ball hits the others. How many fly off? Then take longer steps."""
    space = _space()
    for ball in range(5):
        body = pymunk.Body(1.0, pymunk.moment_for_circle(1.0, 0.0, 0.2))
        hook = pymunk.Vec2d(0.402 * (ball - 2), 2.0)
        # The first ball is pulled aside.
        angle = 0.9 if ball == 0 else 0.0
        body.position = hook.x - 2 * math.sin(angle), hook.y - 2 * math.cos(angle)
        shape = pymunk.Circle(body, 0.2)
        shape.elasticity = 1.0
        space.add(body, shape, pymunk.PinJoint(space.static_body, body, hook, (0.0, 0.0)))
    return space


@_scene(
    "boxes",
    "A stack of boxes",
    "engine",
    step=1 / 120,
    controls=[Slider("rows", 2, 25, label="Rows", rebuilds=True)],
)
def _boxes(rows: int = 8) -> pymunk.Space:
    """Pull a box out of the stack. Fewer iterations make it soft."""
    space = _space()
    reach = 0.3 * rows + 3.6
    ground = pymunk.Segment(space.static_body, (-reach, 0.0), (reach, 0.0), 0.05)
    ground.friction = 0.7
    space.add(ground)
    for row in range(rows):
        for column in range(rows - row):
            x = 0.55 * (column - (rows - 1 - row) / 2)
            _box(space, (0.5, 0.5), x, 0.3 + 0.5 * row)
    return space
