"""Ready scenes by their names."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from inspect import Parameter, signature
from itertools import pairwise
from typing import Any

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

_Values = Mapping[str, float]
_Pair = tuple[float, float]
# Properties of a space that a slider without an action may have.
_PROPERTIES = ("gravity", "damping", "iterations")


@dataclass(frozen=True, kw_only=True)
class Ready:
    """How a scene is made."""

    name: str
    title: str
    text: str
    lesson: str | None = None
    build: Callable[[_Values], Scene]
    plan: Mapping[str, Any] | None = None


# The scenes of the command, in the order in which pages list them.
SCENES: dict[str, Ready] = {}


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
    """Return the scene of a function that builds a space; sliders with the names of its arguments have their values."""
    arguments = signature(build).parameters
    own = {each.name: _at_start(each, arguments) for each in play.controls if isinstance(each, Slider)}
    others = [each for each in play.controls if not isinstance(each, Slider)]
    if not all(isinstance(each, Button | Key | PygameEvents) for each in others):
        raise ParameterError("controls", others, "Slider, Button, Key and PygameEvents")
    play = replace(play, controls=[*own.values(), *others])

    def make(values: _Values) -> Scene:
        given = {name: each.checked(values.get(name, each.value)) for name, each in own.items() if name in arguments}
        space = build(**given)
        if not isinstance(space, pymunk.Space):
            raise ParameterError("build", space, "a function that returns a pymunk.Space")
        scene = Scene(space, play)
        for name in filter(values.__contains__, own):
            scene.set(name, own[name].checked(values[name]))
        return scene

    return Ready(name="space", title="A space", text="Pull a body, cut a joint.", build=make)


def _at_start(slider: Slider, arguments: Mapping[str, Parameter]) -> Slider:
    """Return a slider with its value at the start, if that is not the value of a property of the space."""
    name, value, argument = slider.name, slider.value, arguments.get(slider.name)
    of_space = name in _PROPERTIES and not slider.rebuilds
    if not (argument or of_space or (slider.action and not slider.rebuilds)):
        known = ", ".join(arguments) or "none"
        raise ParameterError("controls", name, f"an argument of the function that builds the space ({known})")
    if argument and value is None:
        value = argument.default
    if value is not None or not of_space:
        slider.checked(value)
    whole = slider.whole or name == "iterations" or (argument is not None and isinstance(value, int))
    return replace(slider, value=value, whole=whole)


def _scene(title: str, lesson: str | None = None, **play: Any) -> Callable[[Any], Any]:
    """Return a decorator that adds a scene: a function of values, or a program to `play`; its docstring is the text."""

    def add(build: Any) -> Any:
        name, make = build.__name__.strip("_").replace("_", "-"), program(build, Play(**play)).build if play else build
        plan = {"scene": name}
        SCENES[name] = Ready(name=name, title=title, text=build.__doc__, lesson=lesson, build=make, plan=plan)
        return build

    return add


@_scene("The dragon")
def _dragon(values: _Values) -> Scene:
    """The dragon of the contest marches in. Pull a bench, cut a joint, let the dancers go."""
    return DragonScene(March(), values)


@_scene("Without dancers", "unguided")
def _unguided(values: _Values) -> Scene:
    """Which two benches touch first? Let all dancers go, and watch."""
    return DragonScene(March(), values, contacts="stop")


@_scene("A coarse engine", "engine")
def _sloppy_engine(values: _Values) -> Scene:
    """Long steps and two iterations: watch the position error, then raise the iterations."""
    return DragonScene(March(), {"step": 60.0, "iterations": 2, **values}, contacts="report", start=380.0)


@_scene("Near misses", "near-miss")
def _near_miss(values: _Values) -> Scene:
    """Can this engine tell? The head passes bench 9 with a gap of 3 mm and bench 11 with 0.9 mm."""
    return DragonScene(March(), values, contacts="stop", start=404.0)


@_scene("A jam")
def _jam(values: _Values) -> Scene:
    """The path is blocked. Remove the obstacle, or see which forces the joints bear."""
    scene = DragonScene(March(Dragon(benches=12), Line(start=(-24.0, 0.0), stop=(8.0, 0.0)), start_s=24.0), values)
    scene.obstacle("square", 4.0, 0.1, 2.0)
    return scene


# m, kg: the benches of the lesson on forces; s: the step of a chain that is pulled.
_BENCH, _MASS, _TOW_STEP = (2.0, 0.3), 10.0, 1 / 240
_PHASES = "begin", "pre_solve", "post_solve", "separate"


def _space(*, gravity: float = 0.0, iterations: int = 10, damping: float = 1.0) -> pymunk.Space:
    """Return an empty space."""
    space = pymunk.Space()
    space.gravity, space.iterations, space.damping = (0, -gravity), iterations, damping
    return space


def _box(space: pymunk.Space, size: _Pair, position: _Pair, mass: float = 1.0) -> pymunk.Body:
    """Return a new box in a space."""
    body = pymunk.Body(mass, pymunk.moment_for_box(mass, size))
    body.position = position
    space.add(body, pymunk.Poly.create_box(body, size))
    return body


def _chain(space: pymunk.Space, size: _Pair, count: int, mass: float = 1.0) -> list[pymunk.Body]:
    """Return boxes in a row to the right of a fixed hook, each joined to the one before; to the left if `count` < 0."""
    half = math.copysign(size[0] / 2, count)
    links = [_box(space, size, ((2 * number + 1) * half, 0.0), mass) for number in range(abs(count))]
    space.add(pymunk.PivotJoint(space.static_body, links[0], (0.0, 0.0), (-half, 0.0)))
    space.add(*(pymunk.PivotJoint(*pair, (half, 0.0), (-half, 0.0)) for pair in pairwise(links)))
    for shape in space.shapes:
        shape.filter = pymunk.ShapeFilter(group=1)
    return links


def _brush(elasticity: float = 0.5) -> pymunk.Space:
    """Return a bench that flies at another one, as in the lesson."""
    space = _space()
    moving, lying = (_box(space, (2.2, 0.3), position, _MASS) for position in [(-2.4, 1.7), (0.0, 0.0)])
    moving.angle, moving.velocity, moving.moment, lying.moment = -0.6, (2.5, -1.0), 5.0, 5.0
    for shape in space.shapes:
        shape.elasticity = elasticity
    return space


@_scene("Callbacks of a contact", "callbacks")
def _callbacks(values: _Values) -> Scene:
    """Make benches touch, and read below "Events" which callbacks Pymunk calls."""
    bounce = Slider("elasticity", 0, 1, label="Elasticity", rebuilds=True)
    scene = program(_brush, Play(step=1 / 50, controls=[bounce], field=(0.0, 0.3, 7.0, 5.0))).build(values)

    def called(name: str, arbiter: pymunk.Arbiter, *_: object) -> None:
        scene.events.append(f"{name}, impulse {arbiter.total_impulse.length:.2f} N s")
        if name == "separate" and scene.space.damping == 1.0:  # Else the benches would leave the view.
            scene.set("damping", 0.3)

    callbacks: dict[str, Any] = {name: partial(called, name) for name in _PHASES}
    scene.space.on_collision(**callbacks)
    return scene


def _first_force(space: pymunk.Space) -> float:
    """Return the force in the joint at the hook, N."""
    return sum(joint.impulse for joint in space.constraints if joint.a is space.static_body) / _TOW_STEP


@_scene(
    "A chain that is pulled",
    "tension",
    step=_TOW_STEP,
    controls=[
        Slider("benches", 2, 24, label="Benches", rebuilds=True),
        Slider("drag", 0, 2, label="Drag of the ground", unit="1/s", rebuilds=True),
        Slider("dancers", 0, 24, label="Dancers", rebuilds=True),
    ],
    plots={"Force in the first joint (N)": _first_force},
    show=("forces",),
)
def _tension(benches: int = 12, drag: float = math.log(2), dancers: int = 0) -> pymunk.Space:
    """The ground goes back below the benches and drags at them. Pull, and cut a joint."""
    space = _space(iterations=60)
    for number, bench in enumerate(_chain(space, _BENCH, -benches, _MASS)):
        # m/s: to a bench that a dancer pushes, the ground seems to rest.
        ground = 1.0 - ((number + 1) * dancers // benches > number * dancers // benches)

        def move(body: pymunk.Body, gravity: Any, damping: float, dt: float, ground: float = ground) -> None:
            body.force -= _MASS * drag * (body.velocity + pymunk.Vec2d(ground, 0))
            pymunk.Body.update_velocity(body, gravity, damping, dt)

        bench.velocity_func = move
    return space


@_scene("A robot's arm", "robot")
def _robot_arm(values: _Values) -> Scene:
    """Links that go where the tip went before."""
    spacings, widths = [0.10] * 6 + [0.13] * 5 + [0.16] * 4, [0.05] * 7 + [0.06] * 5 + [0.07] * 4
    arm = Dragon(head_spacing=0.14, body_spacing=spacings, overhang=0.02, width=widths)
    return DragonScene(March(arm, Spiral(pitch=0.3), turns=3, speed=0.2), values)


@_scene("A pendulum of three rods", step=1 / 240, field=(0.0, -1.0, 7.0, 5.0))
def _pendulum() -> pymunk.Space:
    """Pull it up and drop it. Then cut a joint."""
    space = _space(gravity=9.81, iterations=20)
    _chain(space, (1.0, 0.08), 3)
    return space


@_scene("Newton's cradle", "engine", step=1 / 600, field=(0.0, 0.9, 5.0, 3.0))
def _cradle() -> pymunk.Space:
    """One ball hits the others. How many fly off? Then take longer steps."""
    space = _space(gravity=9.81, iterations=20)
    for ball in range(5):
        body = pymunk.Body(1.0, pymunk.moment_for_circle(1.0, 0.0, 0.2))
        hook, angle = (0.402 * (ball - 2), 2.0), 0.9 if ball == 0 else 0.0
        body.position = hook[0] - 2 * math.sin(angle), hook[1] - 2 * math.cos(angle)
        shape = pymunk.Circle(body, 0.2)
        shape.elasticity = 1.0
        space.add(body, shape, pymunk.PinJoint(space.static_body, body, hook, (0.0, 0.0)))
    return space


@_scene("A stack of boxes", "engine", step=1 / 120, controls=[Slider("rows", 2, 25, label="Rows", rebuilds=True)])
def _boxes(rows: int = 8) -> pymunk.Space:
    """Pull a box out of the stack. Fewer iterations make it soft."""
    space = _space(gravity=9.81, iterations=20)
    space.add(pymunk.Segment(space.static_body, (-0.3 * rows - 3.6, 0.0), (0.3 * rows + 3.6, 0.0), 0.05))
    for row in range(rows):
        for column in range(rows - row):
            _box(space, (0.5, 0.5), (0.55 * (column - (rows - 1 - row) / 2), 0.3 + 0.5 * row))
    for shape in space.shapes:
        shape.friction = 0.7
    return space
