"""A Pymunk space that is shown and touched: what is drawn, and what a hand may do."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
import pymunk

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import number, word
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.physics.draw_calls import DrawCall, DrawRecorder, area
from pymunk_dragon.physics.readings import (
    QUANTITIES,
    Readings,
    Touches,
    body_at,
    energies,
    grip,
    joint_at,
    units,
)
from pymunk_dragon.physics.substep import next_length
from pymunk_dragon.sessions.controls import Button, Key, PygameEvents, Slider, slider_around
from pymunk_dragon.sessions.draw import Draw
from pymunk_dragon.sessions.joints import joint_calls, joint_numbers
from pymunk_dragon.sessions.outlines import Outlines
from pymunk_dragon.web.frames import in_binary, packed

# Largest acceleration of a body by the hand, m/s^2, as in Box2D's testbed.
_HAND_ACCELERATION = 1000.0
# Size of a scene, m, from which on the hand is stronger, in proportion to the size.
_HAND_SIZE = 10.0
# Share of the distance to the pointer that is left after a second, as in Pymunk's examples.
_HAND_BIAS = (1 - 0.15) ** 60
# Coefficient of friction of obstacles: benches slide along them.
_OBSTACLE_FRICTION = 0.4
# Parts of the picture that can be shown or hidden.
PARTS = ("contacts", "forces", "curve", "exact", "handles", "numbers")


@dataclass(frozen=True, kw_only=True)
class PlaySettings:
    """How a space is played: the keywords of `live`."""

    # Length of a step, s; None where a program makes the steps itself.
    step: float | None = 1 / 60
    on_step: Callable[[pymunk.Space, float], object] | None = None
    controls: Sequence[Slider | Button | Key | PygameEvents] = ()
    plots: Mapping[str, Callable[[pymunk.Space], float]] = field(default_factory=dict)
    events: list[str] | None = None
    y_down: bool = False
    units: str = "m"
    # Centre, width and height of the area to show at first; by default that of all shapes and
    # joints.
    view: tuple[float, float, float, float] | None = None
    # Function that returns the body or point at the centre of the view.
    follow: Callable[[pymunk.Space], pymunk.Body | tuple[float, float]] | None = None
    title: str | None = None
    # Parts of the picture that are shown at first: words of `PARTS`.
    show: Sequence[str] | None = None
    on_draw: Callable[[pymunk.Space, Draw], object] | None = None
    on_click: Callable[[pymunk.Space, pymunk.Vec2d, int], object] | None = None


class Scene:
    """Any Pymunk space, drawn as Pymunk's debug drawing draws it."""

    # Whether joints are drawn.
    draws_joints = True
    # Words of `PARTS` that the page shows at first, unless the user chooses others.
    shown: Sequence[str] = ()
    # Whether frames have the contacts, which take long to read.
    shows_contacts = True

    def __init__(self, space: pymunk.Space, settings: PlaySettings) -> None:
        self.space = space
        self.settings = settings
        # Whether a program makes the steps itself, by `Live.step`.
        self.manual = settings.step is None
        # Before the first step of such a program, its length is not known.
        self.step_length = self._chosen_length = settings.step or 1 / 60
        self.steps = 0
        self.time = 0.0

        self.events: list[str] = [] if settings.events is None else settings.events
        self.stops = False
        self.waits_for_contact = False
        # What touches, while the scene waits for a contact.
        self._touches: Touches | None = None

        # Obstacles by number: what the page gets, and the shape.
        self._obstacles: dict[int, tuple[dict[str, Any], pymunk.Shape]] = {}
        self._hand = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        self._held: pymunk.PivotJoint | None = None
        self._recorder = DrawRecorder()
        self._recorder.flags = DrawRecorder.DRAW_SHAPES
        self._outlines = Outlines(space)
        # The shapes of the last frame, as a page gets them before; none of a dragon.
        self.outlines = b""
        self._readings = Readings(space)
        # What `on_draw` drew last.
        self._drawing = Draw()

        controls = settings.controls
        self.pygame = next((each for each in controls if isinstance(each, PygameEvents)), None)
        self._pressed = {each.name: each for each in controls if isinstance(each, Button)}
        down = pymunk.Vec2d(0, 1 if settings.y_down else -1)
        self._down = space.gravity.normalized() if space.gravity.length > 0 else down

        # The user's sliders come first, and replace those of the scene that have the same names.
        known = list(self._sliders())
        own = [each for each in controls if isinstance(each, Slider)]
        self.parameters = {each.name: each for each in [*own, *known, *own]}
        # A slider without a value begins with that of the space, or with its lowest one.
        self.values: dict[str, float] = {each.name: each.low for each in own}
        for each in [*known, *own]:
            if each.value is not None:
                self.values[each.name] = each.value

        self.fit()

    def fit(self) -> None:
        """Choose the area to show at first.

        It is that of `PlaySettings.view`, of pygame's window, or of what is drawn.
        """
        view = self.settings.view or (self.pygame and self.pygame.view) or area(self.space)
        self.view: dict[str, list[float]] = {"centre": list(view[:2]), "size": list(view[2:])}

    def focus(self) -> list[float] | None:
        """The point that the view follows, if it follows one."""
        follow = self.settings.follow
        if follow is None:
            return None
        found = follow(self.space)
        try:
            x, y = map(number, getattr(found, "position", found))
        except (TypeError, ValueError):
            x = y = math.nan
        if math.isfinite(x + y):
            return [x, y]
        raise ParameterError("follow", found, f"a pymunk.Body or a point{_written_at(follow)}")

    def picture(self) -> bytes:
        """PNG of what the page shows at first, without texts."""
        view = dict(self.view)
        # The page shows an error of the user's function.
        with suppress(Exception):
            view["centre"] = self.focus() or view["centre"]
        with suppress(Exception):
            self.draw()
        # Pages need no picture, and begin sooner without Pillow.
        from pymunk_dragon.drawing.debug_draw import still

        more = [*self._drawn_joints(), *self._drawing.calls]
        return still(self.space, view, y_down=self.settings.y_down, more=more)

    def _drawn_joints(self) -> Iterator[DrawCall]:
        """What the page draws of joints."""
        if not self.draws_joints:
            return
        ends = self._readings.joints([*self.space.constraints])[:, :4]
        colour = self._recorder.constraint_color
        for kind, radius, points in joint_calls(self.space, ends, self.settings.units):
            for each in points.tolist():
                yield DrawCall(kind, tuple(pymunk.Vec2d(*point) for point in each), radius, colour)

    def advance(self) -> None:
        """Make a step; an error is raised if a body has no finite position after it."""
        if self.waits_for_contact and self._touches is None:
            self._touches = Touches(self.space)
        self.step_length = self._next_length()
        if self.settings.on_step is not None:
            self.settings.on_step(self.space, self.time)

        self._readings.before_step(self.step_length)
        self.space.step(self.step_length)
        self.steps += 1
        self.time += self.step_length

        if self._touches is not None and self._touches.begin():
            self.stops = True
            self.waits_for_contact = False
            self._touches = None
        if not self._readings.are_finite():
            raise DragonError("the bodies flew apart: reset, and take shorter steps")

    def _next_length(self) -> float:
        """Length of the next step, s: near the last one, on the way to the chosen one."""
        if self.manual:
            return self.step_length
        before = self.step_length if self.steps else 0.0
        return next_length(before, self._chosen_length)

    def _sliders(self) -> Iterator[Slider]:
        """The sliders that any space has."""
        # A program that makes the steps itself chooses their length.
        if not self.manual:
            ms = 1e3 * self.step_length
            low = ms / 10
            yield slider_around("step", low, 10 * ms, ms, "Time step", unit="ms", logarithmic=True)

        count = self.space.iterations
        scale: dict[str, Any] = {"logarithmic": True, "whole": True}
        yield slider_around("iterations", 1, 200, count, "Iterations", **scale)
        yield slider_around("damping", 0, 1, self.space.damping, "Velocity kept in 1 s")

        g = self.space.gravity.length
        if g != 0:
            unit = f"{self.settings.units}/s²"
            yield slider_around("gravity", 0, 3 * g, g, "Gravity", unit=unit)

    def rebuilds(self, name: str) -> bool:
        """Whether a change of a slider builds the scene again."""
        slider = self.parameters.get(name)
        return slider is not None and slider.rebuilds

    def set(self, name: str, value: float) -> None:
        """Change a value: by the action of its slider, as a property, or for the next scene."""
        slider = self.parameters[word("name", name, self.parameters)]
        value = slider.checked(value)
        self.values[name] = value

        if slider.action is not None:
            slider.action(self.space, value)
        elif name == "step":
            self._chosen_length = value / 1e3
        elif not slider.rebuilds:
            setattr(self.space, name, value * self._down if name == "gravity" else value)
        self._wake()

    def press(self, name: str, down: bool) -> None:
        """Call the action of a button or key that is pressed, or of a key that is released."""
        control = self._pressed.get(name)
        if self.pygame is not None:
            self.pygame.key(name, down)
        elif control is None:
            raise ParameterError("name", name, "a button or a key of this scene")
        if action := getattr(control, "action" if down else "up", None):
            action(self.space)
            self._wake()

    def pointer(self, x: float, y: float, kind: str, button: int) -> None:
        """Pass the pointer to a pygame program, whose window has its origin at the upper left."""
        down = y if self.settings.y_down else self.view["size"][1] - y
        self.pygame_events().pointer(x, down, kind, button)

    def click(self, x: float, y: float, button: int) -> None:
        """Call the function for clicks."""
        if self.settings.on_click is None:
            raise ParameterError("message", "click", "an action that this scene has")
        self.settings.on_click(self.space, pymunk.Vec2d(x, y), button)
        self._wake()

    def pygame_events(self) -> PygameEvents:
        """The keys and the mouse of a pygame program; an error is raised in other scenes."""
        if self.pygame is None:
            raise ParameterError("pointer", None, "sent to a program with PygameEvents")
        return self.pygame

    def grab(self, x: float, y: float, slip: float) -> None:
        """Hold the body that is drawn on top at a point, or the nearest one within `slip`."""
        self.drop()
        self._hand.position = x, y
        body, point = body_at(self.shapes(), x, y, slip)

        anchor = body.world_to_local(point)
        held = self._held = pymunk.PivotJoint(self._hand, body, (0, 0), anchor)
        size = max(self.view["size"])
        acceleration = _HAND_ACCELERATION * max(1.0, size / _HAND_SIZE)
        held.max_force = acceleration * body.mass
        held.error_bias = _HAND_BIAS
        self.space.add(held)

    def drag(self, x: float, y: float) -> None:
        """Move the hand."""
        self._hand.position = x, y

    def drop(self) -> None:
        """Let go of the body that is held."""
        if self._held is not None and self._held in self.space.constraints:
            self.space.remove(self._held)
        self._held = None

    def cut(self, x: float, y: float, slip: float) -> None:
        """Remove the joint whose line passes within `slip` of a point of the world."""
        joint = joint_at(self.joints(), x, y, slip)
        self.space.remove(joint)
        if not joint.collide_bodies:
            # Bodies that the joint kept from colliding may overlap, and would be thrown apart.
            keeper = pymunk.RotaryLimitJoint(joint.a, joint.b, -math.inf, math.inf)
            keeper.collide_bodies = False
            keeper.max_force = 0.0
            self.space.add(keeper)

    def shapes(self) -> list[pymunk.Shape]:
        """The shapes in the order in which the page draws them."""
        self.space.debug_draw(self._recorder)
        return [call.shape for call in self._recorder.calls if call.shape is not None]

    def joints(self) -> list[pymunk.Constraint]:
        """The joints of the space that have forces, without that of the hand."""
        joints = self.space.constraints
        return [each for each in joints if each is not self._held and each.max_force > 0]

    def obstacle(self, shape: str, x: float, y: float, size: float) -> None:
        """Put a round or square obstacle, `size` in diameter or side, on the ground."""
        ground = self.space.static_body
        found: pymunk.Shape
        if shape == "round":
            found = pymunk.Circle(ground, size / 2, (x, y))
        else:
            box = pymunk.BB.newForCircle((x, y), size / 2)
            found = pymunk.Poly.create_box_bb(ground, box)
        found.friction = _OBSTACLE_FRICTION

        key = max(self._obstacles, default=0) + 1
        about = {"id": key, "shape": shape, "x": x, "y": y, "size": size}
        self._obstacles[key] = about, found
        self.space.add(found)
        # A new static shape wakes no body.
        self._wake([each.shape.body for each in self.space.shape_query(found)])

    def remove(self, obstacle: int) -> None:
        """Remove an obstacle."""
        if obstacle not in self._obstacles:
            raise ParameterError("obstacle", obstacle, "the number of an obstacle")
        _, shape = self._obstacles.pop(obstacle)
        # A function of the user's may have removed it.
        if shape in self.space.shapes:
            self.space.remove(shape)
            # Otherwise the ground would list it for ever.
            shape.body = None

    def _wake(self, bodies: Iterable[pymunk.Body | None] | None = None) -> None:
        """Wake bodies, or all of the space.

        Pymunk 7.3.1 wakes bodies if the gravity changes, but not if another property of the space
        or a static shape does.
        """
        for body in self.space.bodies if bodies is None else bodies:
            if body is not None and body.is_sleeping:
                body.activate()

    def to_dict(self) -> dict[str, Any]:
        """What the page gets once."""
        parameters = []
        for name, slider in self.parameters.items():
            parameters.append(vars(slider) | {"action": None, "value": self.values[name]})

        keys = [each.name for each in self._pressed.values() if isinstance(each, Key)]
        buttons = [name for name in self._pressed if name not in keys]

        unit_of = units(self.settings.units)
        # The user's quantities come first, and have their units in their titles.
        own = dict.fromkeys(self.settings.plots, "")
        plots = own | {title: unit_of[kind] for title, kind in QUANTITIES.items()} | own

        return {
            "parameters": parameters,
            "buttons": buttons,
            "keys": ["*"] if self.pygame else keys,
            "clicks": self.settings.on_click is not None,
            "dragon": None,
            "step": self.step_length,
            "y_down": self.settings.y_down,
            "units": self.settings.units,
            "view": self.view,
            "follows": self.settings.follow is not None,
            "unit_of": unit_of,
            "plots": list(plots.items()),
        }

    def state(self) -> dict[str, Any]:
        """What changes now and then."""
        return {
            "obstacles": [about for about, _ in self._obstacles.values()],
            "values": dict(self.values),
            "waits_for_contact": self.waits_for_contact,
            "contacts": None,
            "free_from": None,
            "cuts": [],
        }

    def poses(self) -> Array:
        """The poses (B, 3) of the bodies in the space now."""
        return np.array([(*body.position, body.angle) for body in self.space.bodies]).reshape(-1, 3)

    def plots(self) -> dict[str, float]:
        """Quantities for charts: those of the user's, energy, and momentum."""
        plots = self.settings.plots
        own = {title: self._plotted(title, plot) for title, plot in plots.items()}
        return own | energies(self.space) | own

    def _plotted(self, title: str, plot: Callable[[pymunk.Space], float]) -> float:
        """The value of a chart of the user's; an error names the chart."""
        try:
            value = plot(self.space)
        except Exception as error:
            error.add_note(f"in the chart {title!r}")
            raise
        if not isinstance(value, Real | np.bool_):
            raise ParameterError(f"the value of the chart {title!r}", value, "a number")
        return number(float(value) if isinstance(value, bool | np.bool_) else value)

    def draw(self) -> None:
        """Draw what the user's function draws on the next frame, up to an error in it."""
        on_draw = self.settings.on_draw
        if on_draw is None:
            return
        before = self._drawing.trails
        self._drawing = Draw()
        self._drawing.before = before
        result = on_draw(self.space, self._drawing)
        if result is not None:
            raise ParameterError("the value of on_draw", result, f"None{_written_at(on_draw)}")

    def frame(self, header: Mapping[str, Any]) -> bytes:
        """The present state in the format of `in_binary`; `header` is the session's part of it."""
        pull = self._held
        held = None
        # A function of the user's may have removed the body.
        if pull is not None and pull.b.space is not None:
            held = [*pull.b.local_to_world(pull.anchor_b), *self._hand.position]
        state = {"step": self.steps, "time": self.time, "held": held}
        more, arrays = self._parts()
        return in_binary({**header, **state, **more}, arrays)

    def _parts(self) -> tuple[dict[str, Any], dict[str, Array]]:
        """Parts of the header and arrays of a frame."""
        poses = self._outlines.poses()
        self.outlines = self._outlines.frame

        drawn = [*self.space.constraints]
        rows = self._readings.joints(drawn)
        of_joints = joint_numbers(joint_calls(self.space, rows[:, :4], self.settings.units))
        calls, colours = packed(self._drawing.calls, grip, self._recorder.constraint_color)

        with_forces = set(self.joints())
        arrays = {
            "bodies": poses,
            "calls": np.concatenate([of_joints, calls]),
            "joints": rows[np.array([each in with_forces for each in drawn], bool)],
            "contacts": self._readings.contacts() if self.shows_contacts else np.empty(0),
        }
        return {"colours": colours, "texts": self._drawing.texts}, arrays


def _written_at(function: Callable[..., object]) -> str:
    """Where a function of the user's is, in words; empty for a callable object."""
    code = getattr(function, "__code__", None)
    return f" ({Path(code.co_filename).name}, line {code.co_firstlineno})" if code else ""
