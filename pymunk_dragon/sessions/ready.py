"""Ready scenes by their names."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from inspect import Parameter, signature
from itertools import pairwise
from typing import Any

import numpy as np
import pymunk

from pymunk_dragon._arguments import finite, word
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves import Line, Spiral
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.scenario import Scenario
from pymunk_dragon.sessions.controls import Button, Key, PygameEvents, Slider
from pymunk_dragon.sessions.dragon import DragonScene
from pymunk_dragon.sessions.scene import Play, Scene

Values = Mapping[str, float]
# Properties of a space that a slider without an action may have.
_PROPERTIES = ("gravity", "damping", "iterations")


@dataclass(frozen=True, kw_only=True)
class Ready:
    """How a scene is made."""

    name: str
    title: str
    text: str
    lesson: str | None = None
    build: Callable[[Values], Scene]
    plan: Mapping[str, Any] | None = None


def ready(name: str) -> Ready:
    """The ready scene of a name."""
    return SCENES[word("scene", name, list(SCENES))]


def dragon(march: March, start: float = 0.0) -> Ready:
    """The scene of a march that begins at `start`, s."""
    finite("start", start, -math.inf, math.inf, "s")
    try:
        plan = {"scenario": Scenario.of(march).to_dict(), "start": start}
    except ParameterError:  # A curve or a speed of the user's own.
        plan = None
    text = "Pull a bench, cut a joint, let the dancers go."
    return Ready(name="own", title="A march", text=text, build=partial(DragonScene, march, start=start), plan=plan)


def planned(plan: Mapping[str, Any]) -> Ready:
    """The scene of a plan."""
    if "scene" in plan:
        return ready(plan["scene"])
    return dragon(Scenario.from_dict(plan["scenario"], files=False).march(), plan["start"])


def program(build: Callable[..., pymunk.Space], play: Play) -> Ready:
    """Return the scene of a function that builds a space; sliders that rebuild are its arguments."""
    arguments = signature(build).parameters
    play = replace(play, controls=[_known(each, arguments) for each in play.controls])
    sliders = {each.name: each for each in play.controls if isinstance(each, Slider)}

    def make(values: Values) -> Scene:
        given = {name: each.value for name, each in sliders.items() if each.value is not None}
        given |= {name: value for name, value in values.items() if name in sliders}
        space = build(**{name: sliders[name].checked(given[name]) for name in sliders if name in arguments})
        if not isinstance(space, pymunk.Space):
            raise ParameterError("build", space, "a function that returns a pymunk.Space")
        return Scene(space, play, given)

    return Ready(name="space", title="A space", text="Pull a body, cut a joint.", build=make)


def _known(control: Any, arguments: Mapping[str, Parameter]) -> Any:
    """Return a control with the value that it has at the start."""
    if not isinstance(control, Slider | Button | Key | PygameEvents):
        raise ParameterError("controls", control, "Slider, Button, Key and PygameEvents")
    if not isinstance(control, Slider):
        return control
    name, argument, value = control.name, arguments.get(control.name), control.value
    if argument is None and (control.rebuilds or not (control.action or name in _PROPERTIES)):
        known = ", ".join(arguments) or "none"
        raise ParameterError("controls", name, f"an argument of the function that builds the space ({known})")
    if value is None and argument is not None and argument.default is not Parameter.empty:
        value = argument.default
    if value is None and name in _PROPERTIES:
        return control
    control = replace(control, value=value, whole=control.whole or (argument is not None and isinstance(value, int)))
    control.checked(math.nan if value is None else value)
    return control


# The scenes of the command, in the order in which pages list them.
SCENES: dict[str, Ready] = {}


def _scene(title: str, text: str, lesson: str | None = None, **play: Any) -> Callable[[Any], Any]:
    """Return a decorator that makes a scene of a function, of its name: one of values, or a program to `play`."""

    def add(build: Any) -> Any:
        name, make = build.__name__.strip("_").replace("_", "-"), program(build, Play(**play)).build if play else build
        SCENES[name] = Ready(name=name, title=title, text=text, lesson=lesson, build=make, plan={"scene": name})
        return build

    return add


@_scene("The dragon", "The dragon of the contest marches in. Pull a bench, cut a joint, let the dancers go.")
def _dragon(values: Values) -> Scene:
    return DragonScene(March(), values)


@_scene("Without dancers", "Let all dancers go, and watch: which two benches touch first?", "unguided")
def _unguided(values: Values) -> Scene:
    return DragonScene(March(), values, contacts="stop")


@_scene(
    "A coarse engine", "Long steps and one iteration: watch the position error, then raise the iterations.", "engine"
)
def _sloppy_engine(values: Values) -> Scene:
    return DragonScene(March(), {"step": 60.0, "iterations": 2} | dict(values), contacts="report", start=380.0)


@_scene(
    "Near misses",
    "The head passes bench 9 with a gap of 3 mm and bench 11 with 0.9 mm. Can this engine tell?",
    "near-miss",
)
def _near_miss(values: Values) -> Scene:
    return DragonScene(March(), values, contacts="stop", start=404.0)


@_scene("A jam", "The path is blocked. Remove the obstacle, or see which forces the joints bear.")
def _jam(values: Values) -> Scene:
    """A short dragon that walks against a wall."""
    march = March(Dragon(benches=12), Line(start=(-24.0, 0.0), stop=(8.0, 0.0)), start_s=24.0)
    scene = DragonScene(march, values)
    scene.obstacle("square", 4.0, 0.1, 2.0)
    return scene


# m, kg, m/s: the benches of the lessons on forces and on callbacks, and the ground below a chain that is pulled.
_BENCH, _MASS, _GROUND_SPEED = (2.0, 0.3), 10.0, 1.0
# s: step of that chain.
_TOW_STEP = 1 / 240


def _box(
    space: pymunk.Space, size: tuple[float, float], position: tuple[float, float], mass: float = 1.0, angle: float = 0.0
) -> pymunk.Body:
    """Return a new box in a space."""
    body = pymunk.Body(mass, pymunk.moment_for_box(mass, size))
    body.position, body.angle = position, angle
    space.add(body, pymunk.Poly.create_box(body, size))
    return body


def _chain(space: pymunk.Space, size: tuple[float, float], count: int, mass: float = 1.0) -> list[pymunk.Body]:
    """Return boxes in a row to the right of a fixed hook, each joined to the one before; to the left if `count` < 0."""
    half = math.copysign(size[0] / 2, count)
    links = [_box(space, size, ((2 * number + 1) * half, 0.0), mass) for number in range(abs(count))]
    space.add(pymunk.PivotJoint(space.static_body, links[0], (0.0, 0.0), (-half, 0.0)))
    space.add(*(pymunk.PivotJoint(*pair, (half, 0.0), (-half, 0.0)) for pair in pairwise(links)))
    for shape in space.shapes:
        shape.filter = pymunk.ShapeFilter(group=1)
    return links


def _brush(elasticity: float = 0.5) -> pymunk.Space:
    """Return a bench that brushes another one."""
    space = pymunk.Space()
    space.damping = 0.7
    moving = _box(space, _BENCH, (-2.4, 1.7), _MASS, -0.6)
    moving.velocity = 2.5, -1.0
    _box(space, _BENCH, (0.0, 0.0), _MASS)
    for shape in space.shapes:
        shape.elasticity, shape.friction = elasticity, 0.4
    return space


@_scene(
    "Callbacks of a contact", 'Make benches touch, and read below "Events" which callbacks Pymunk calls.', "callbacks"
)
def _callbacks(values: Values) -> Scene:
    """Return the scene of `_brush`, with each call of a callback as an event."""
    bounce = Slider("elasticity", 0, 1, label="Elasticity", rebuilds=True)
    scene = program(_brush, Play(step=1 / 50, controls=[bounce], field=(0.0, 0.3, 7.0, 5.0))).build(values)

    def called(arbiter: pymunk.Arbiter, space: pymunk.Space, name: Any) -> None:
        scene.events.append(f"{name}, impulse {arbiter.total_impulse.length:.2f} N s")

    for name in ("begin", "pre_solve", "post_solve", "separate"):
        callback: dict[str, Any] = {name: called}
        scene.space.on_collision(**callback, data=name)
    return scene


def _first_force(space: pymunk.Space) -> float:
    """Return the force in the joint at the hook, N."""
    at_hook = [joint for joint in space.constraints if joint.a is space.static_body]
    return max((joint.impulse for joint in at_hook), default=0.0) / _TOW_STEP


@_scene(
    "A chain that is pulled",
    "The ground goes back below the benches and drags at them. Pull, and cut a joint.",
    "tension",
    step=_TOW_STEP,
    controls=[
        Slider("benches", 2, 24, label="Benches", rebuilds=True),
        Slider("drag", 0, 2, label="Drag of the ground", unit="1/s", rebuilds=True),
        Slider("dancers", 0, 24, label="Dancers", rebuilds=True),
    ],
    plots={"Force in the first joint (N)": _first_force},
    field=(-12.0, 0.0, 27.0, 8.0),
    show=("forces",),
)
def _tension(benches: int = 12, drag: float = math.log(2), dancers: int = 0) -> pymunk.Space:
    """Return benches behind a fixed hook, above ground that goes back and drags at those without a dancer."""
    space = pymunk.Space()
    space.iterations = 60
    for number, bench in enumerate(_chain(space, _BENCH, -benches, _MASS)):
        pushed = (number + 1) * dancers // benches > number * dancers // benches

        def move(body: pymunk.Body, gravity: Any, damping: float, dt: float, ground: float = float(not pushed)) -> None:
            body.force -= _MASS * drag * (body.velocity + pymunk.Vec2d(ground * _GROUND_SPEED, 0))
            pymunk.Body.update_velocity(body, gravity, damping, dt)

        bench.velocity_func = move
    return space


@_scene("A robot's arm", "Links that go where the tip went before.", "robot")
def _robot_arm(values: Values) -> Scene:
    """The arm of the lesson, on a spiral instead of a curve drawn by hand."""
    arm = Dragon(
        head_spacing=0.14,
        body_spacing=[0.10] * 6 + [0.13] * 5 + [0.16] * 4,
        overhang=0.02,
        width=[0.05] * 7 + [0.06] * 5 + [0.07] * 4,
    )
    return DragonScene(March(arm, Spiral(pitch=0.3), turns=3, speed=0.2), values)


def _space() -> pymunk.Space:
    space = pymunk.Space()
    space.gravity, space.iterations = (0, -9.81), 20
    return space


@_scene(
    "A pendulum of three rods", "Pull it up and drop it. Then cut a joint.", step=1 / 240, field=(0.0, -1.0, 7.0, 5.0)
)
def _pendulum() -> pymunk.Space:
    """Return three rods below a hook."""
    space = _space()
    _chain(space, (1.0, 0.08), 3)
    return space


@_scene(
    "Newton's cradle",
    "One ball hits the others. How many fly off? Then take longer steps.",
    "engine",
    step=1 / 600,
    field=(0.0, 0.9, 5.0, 3.0),
)
def _cradle() -> pymunk.Space:
    """Return five balls on strings."""
    space = _space()
    for ball in range(5):
        body = pymunk.Body(1.0, pymunk.moment_for_circle(1.0, 0.0, 0.2))
        hook = 0.402 * (ball - 2), 2.0
        body.position = hook[0], 0.0
        if ball == 0:
            body.position = hook[0] - 2 * np.sin(0.9), 2 - 2 * np.cos(0.9)
        shape = pymunk.Circle(body, 0.2)
        shape.elasticity = 1.0
        space.add(body, shape, pymunk.PinJoint(space.static_body, body, hook, (0.0, 0.0)))
    return space


@_scene(
    "A stack of boxes",
    "Pull a box out of the stack. Fewer iterations make it soft.",
    "engine",
    step=1 / 120,
    controls=[Slider("rows", 2, 25, label="Rows", rebuilds=True)],
)
def _boxes(rows: int = 8) -> pymunk.Space:
    """Return a wall of boxes on the ground."""
    space = _space()
    space.add(pymunk.Segment(space.static_body, (-0.3 * rows - 3.6, 0.0), (0.3 * rows + 3.6, 0.0), 0.05))
    for row in range(rows):
        for column in range(rows - row):
            _box(space, (0.5, 0.5), (0.55 * (column - (rows - 1 - row) / 2), 0.3 + 0.5 * row))
    for shape in space.shapes:
        shape.friction = 0.7
    return space
