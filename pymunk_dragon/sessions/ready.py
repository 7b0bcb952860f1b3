"""Ready scenes by their names."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from inspect import Parameter, signature
from typing import Any

import numpy as np
import pymunk

from pymunk_dragon._checks import finite, word
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


def dragon(march: March, *, contacts: str = "resolve", free_from: int | None = None, start: float = 0.0) -> Ready:
    """The scene of a march; `contacts`, `free_from` and `start` are those of `DragonScene`."""
    finite("start", start, -math.inf, math.inf, "s")
    options = {"contacts": contacts, "free_from": free_from, "start": start}
    try:
        plan = {"scenario": Scenario.of(march).to_dict(), **options}
    except ParameterError:  # A curve or a speed of the user's own.
        plan = None
    return Ready(
        name="own",
        title="A march",
        text="Pull a bench, cut a joint, let the dancers go.",
        build=lambda values: DragonScene(march, values, contacts=contacts, free_from=free_from, start=start),
        plan=plan,
    )


def planned(plan: Mapping[str, Any]) -> Ready:
    """The scene of a plan."""
    if "scene" in plan:
        return ready(plan["scene"])
    options = {name: value for name, value in plan.items() if name != "scenario"}
    return dragon(Scenario.from_dict(plan["scenario"], files=False).march(), **options)


def program(build: Callable[..., pymunk.Space], play: Play) -> Ready:
    """Return the scene of a function that builds a space; sliders that rebuild are its arguments."""
    play = replace(play, controls=[_known(each, build) for each in play.controls])
    sliders = {each.name: each for each in play.controls if isinstance(each, Slider)}
    first = {name: float(each.value) for name, each in sliders.items() if each.value is not None}
    arguments = [name for name in sliders if name in signature(build).parameters]

    def make(values: Values) -> Scene:
        values = first | dict(values)
        space = build(**{name: sliders[name].checked(values[name]) for name in arguments})
        if not isinstance(space, pymunk.Space):
            raise ParameterError("build", space, "a function that returns a pymunk.Space")
        return Scene(space, play, {name: value for name, value in values.items() if name in sliders})

    return Ready(name="space", title="A space", text="Pull a body, cut a joint.", build=make)


def _known(control: object, build: Callable[..., object]) -> Slider | Button | Key | PygameEvents:
    """Return a control with the value that it has at the start."""
    if not isinstance(control, Slider):
        if not isinstance(control, Button | Key | PygameEvents):
            raise ParameterError("controls", control, "Slider, Button, Key and PygameEvents")
        return control
    parameter = signature(build).parameters.get(control.name)
    if parameter is None and (control.rebuilds or not (control.action or control.name in _PROPERTIES)):
        known = ", ".join(signature(build).parameters) or "none"
        raise ParameterError("controls", control.name, f"an argument of the function that builds the space ({known})")
    value = control.value
    if value is None and parameter is not None and parameter.default is not Parameter.empty:
        value = parameter.default
    if value is None and control.name not in _PROPERTIES:
        raise ParameterError("controls", control.name, "a slider with a value at the start")
    is_whole = control.whole or (isinstance(value, int) and parameter is not None)
    known_control = replace(control, value=value, whole=is_whole)
    if value is not None:
        known_control.checked(value)
    return known_control


def _space(gravity: float = -9.81) -> pymunk.Space:
    space = pymunk.Space()
    space.gravity = 0, gravity
    space.iterations = 20
    return space


def _pendulum() -> pymunk.Space:
    """Return three rods below a hook."""
    space = _space()
    before, anchor = space.static_body, (0.0, 0.0)
    for link in range(3):
        rod = pymunk.Body(1.0, pymunk.moment_for_box(1.0, (1.0, 0.08)))
        rod.position = link + 0.5, 0.0
        shape = pymunk.Poly.create_box(rod, (1.0, 0.08))
        shape.filter = pymunk.ShapeFilter(group=1)
        space.add(rod, shape, pymunk.PivotJoint(before, rod, anchor, (-0.5, 0.0)))
        before, anchor = rod, (0.5, 0.0)
    return space


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


def _boxes(rows: int = 8) -> pymunk.Space:
    """Return a wall of boxes on the ground."""
    space = _space()
    ground = pymunk.Segment(space.static_body, (-0.3 * rows - 3.6, 0.0), (0.3 * rows + 3.6, 0.0), 0.05)
    ground.friction = 0.8
    space.add(ground)
    for row in range(rows):
        for column in range(rows - row):
            box = pymunk.Body(1.0, pymunk.moment_for_box(1.0, (0.5, 0.5)))
            box.position = 0.55 * (column - (rows - 1 - row) / 2), 0.3 + 0.5 * row
            shape = pymunk.Poly.create_box(box, (0.5, 0.5))
            shape.friction = 0.6
            space.add(box, shape)
    return space


# m, kg, m/s: the benches of the lessons on forces and on callbacks, and the ground below a chain that is pulled.
_LENGTH, _WIDTH, _MASS, _GROUND_SPEED = 2.0, 0.3, 10.0, 1.0
# s: step of that chain.
_TOW_STEP = 1 / 240


def _bench(space: pymunk.Space, position: tuple[float, float], angle: float = 0.0) -> pymunk.Body:
    """Return a bench in a space."""
    body = pymunk.Body(_MASS, pymunk.moment_for_box(_MASS, (_LENGTH, _WIDTH)))
    body.position, body.angle = position, angle
    space.add(body, pymunk.Poly.create_box(body, (0.96 * _LENGTH, _WIDTH)))
    return body


def _tow(benches: int = 12, drag: float = math.log(2), dancers: int = 0) -> pymunk.Space:
    """Return benches behind a fixed hook, above ground that goes back and drags at those without a dancer."""
    space = pymunk.Space()
    space.iterations = 60
    before, anchor = space.static_body, (0.0, 0.0)
    for number in range(benches):
        pushed = (number + 1) * dancers // benches > number * dancers // benches

        def move(body: pymunk.Body, gravity: Any, damping: float, dt: float, ground: float = float(not pushed)) -> None:
            body.force -= _MASS * drag * (body.velocity + pymunk.Vec2d(ground * _GROUND_SPEED, 0))
            pymunk.Body.update_velocity(body, gravity, damping, dt)

        bench = _bench(space, (-_LENGTH * (number + 0.5), 0.0))
        bench.velocity_func = move
        for shape in bench.shapes:
            shape.filter = pymunk.ShapeFilter(group=1)
        space.add(pymunk.PivotJoint(before, bench, anchor, (_LENGTH / 2, 0.0)))
        before, anchor = bench, (-_LENGTH / 2, 0.0)
    return space


def _first_force(space: pymunk.Space) -> float:
    """Return the force in the joint at the hook, N."""
    at_hook = [joint for joint in space.constraints if joint.a is space.static_body]
    return max((joint.impulse for joint in at_hook), default=0.0) / _TOW_STEP


def _brush(elasticity: float = 0.5) -> pymunk.Space:
    """Return a bench that brushes another one."""
    space = pymunk.Space()
    space.damping = 0.7
    moving = _bench(space, (-2.4, 1.7), -0.6)
    moving.velocity = 2.5, -1.0
    _bench(space, (0.0, 0.0))
    for shape in space.shapes:
        shape.elasticity, shape.friction = elasticity, 0.4
    return space


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


def _arm(values: Values) -> Scene:
    """The arm of the lesson, on a spiral instead of a curve drawn by hand."""
    arm = Dragon(
        head_spacing=0.14,
        body_spacing=[0.10] * 6 + [0.13] * 5 + [0.16] * 4,
        overhang=0.02,
        width=[0.05] * 7 + [0.06] * 5 + [0.07] * 4,
    )
    return DragonScene(March(arm, Spiral(pitch=0.3), turns=3, speed=0.2), values)


def _jam(values: Values) -> Scene:
    """A short dragon that walks against a wall."""
    march = March(Dragon(benches=12), Line(start=(-24.0, 0.0), stop=(8.0, 0.0)), start_s=24.0)
    scene = DragonScene(march, values)
    scene.obstacle("square", 4.0, 0.1, 2.0)
    return scene


_READY = (
    Ready(
        name="dragon",
        title="The dragon",
        text="The dragon of the contest marches in. Pull a bench, cut a joint, let the dancers go.",
        build=lambda values: DragonScene(March(), values),
    ),
    Ready(
        name="unguided",
        title="Without dancers",
        text="Let all dancers go, and watch: which two benches touch first?",
        lesson="unguided",
        build=lambda values: DragonScene(March(), values, contacts="stop"),
    ),
    Ready(
        name="sloppy-engine",
        title="A coarse engine",
        text="Long steps and one iteration: watch the position error, then raise the iterations.",
        lesson="engine",
        build=lambda values: DragonScene(
            March(), {"step": 60.0, "iterations": 2} | dict(values), contacts="report", start=380.0
        ),
    ),
    Ready(
        name="near-miss",
        title="Near misses",
        text="The head passes bench 9 with a gap of 3 mm and bench 11 with 0.9 mm. Can this engine tell?",
        lesson="near-miss",
        build=lambda values: DragonScene(March(), values, contacts="stop", start=404.0),
    ),
    Ready(
        name="jam",
        title="A jam",
        text="The path is blocked. Remove the obstacle, or see which forces the joints bear.",
        build=_jam,
    ),
    Ready(
        name="callbacks",
        title="Callbacks of a contact",
        text='Make benches touch, and read below "Events" which callbacks Pymunk calls.',
        lesson="callbacks",
        build=_callbacks,
    ),
    Ready(
        name="tension",
        title="A chain that is pulled",
        text="The ground goes back below the benches and drags at them. Pull, and cut a joint.",
        lesson="tension",
        build=program(
            _tow,
            Play(
                step=_TOW_STEP,
                controls=[
                    Slider("benches", 2, 24, label="Benches", rebuilds=True),
                    Slider("drag", 0, 2, label="Drag of the ground", unit="1/s", rebuilds=True),
                    Slider("dancers", 0, 24, label="Dancers", rebuilds=True),
                ],
                plots={"Force in the first joint (N)": _first_force},
                field=(-12.0, 0.0, 27.0, 8.0),
                show=("forces",),
            ),
        ).build,
    ),
    Ready(
        name="robot-arm",
        title="A robot's arm",
        text="Links that go where the tip went before.",
        lesson="robot",
        build=_arm,
    ),
    Ready(
        name="pendulum",
        title="A pendulum of three rods",
        text="Pull it up and drop it. Then cut a joint.",
        build=program(_pendulum, Play(step=1 / 240, field=(0.0, -1.0, 7.0, 5.0))).build,
    ),
    Ready(
        name="cradle",
        title="Newton's cradle",
        text="One ball hits the others. How many fly off? Then take longer steps.",
        lesson="engine",
        build=program(_cradle, Play(step=1 / 600, field=(0.0, 0.9, 5.0, 3.0))).build,
    ),
    Ready(
        name="boxes",
        title="A stack of boxes",
        text="Pull a box out of the stack. Fewer iterations make it soft.",
        lesson="engine",
        build=program(_boxes, Play(step=1 / 120, controls=[Slider("rows", 2, 25, label="Rows", rebuilds=True)])).build,
    ),
)
SCENES: dict[str, Ready] = {each.name: replace(each, plan={"scene": each.name}) for each in _READY}
