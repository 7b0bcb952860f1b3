"""A Pymunk space that is shown and touched: what is drawn, and what a hand may do."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pymunk
from pymunk import batch
from pymunk.batch import ArbiterFields

from pymunk_dragon._arguments import Array, positive, word
from pymunk_dragon.drawing.canvas import in_binary, packed
from pymunk_dragon.drawing.debug_draw import DrawCall, DrawRecorder, extent
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.sessions.controls import Button, Key, PygameEvents, Slider

# Largest acceleration by a hand, in m/s^2, as in Box2D's testbed: for scenes of this size; in larger ones, more.
_HAND_ACCELERATION, _HAND_SIZE = 1000.0, 10.0
# Share of the distance to the pointer that is left after a second, as in Pymunk's examples.
_HAND_BIAS = (1 - 0.15) ** 60
_MAX_OBSTACLES = 100
_OBSTACLE_FRICTION = 0.4
# Least width and height of the area that is shown.
_SMALLEST = 1e-3
# What the page gets of each pair in contact.
_CONTACT_FIELDS = ArbiterFields.TOTAL_IMPULSE | ArbiterFields.NORMAL | ArbiterFields.POINT_A_1 | ArbiterFields.POINT_A_2
_CONTACT_FIELDS |= ArbiterFields.BODY_A_ID | ArbiterFields.BODY_B_ID
_CONTACT_FIELDS |= ArbiterFields.IS_FIRST_CONTACT | ArbiterFields.CONTACT_COUNT
# Impulse in the row of a contact that has no arrow: that of its pair is in another row.
NO_ARROW = -1.0


@dataclass(frozen=True, kw_only=True)
class Play:
    """How a space is played: the keywords of `live`."""

    # s; None where a program makes the steps itself.
    step: float | None = 1 / 60
    on_step: Callable[[pymunk.Space, float], object] | None = None
    controls: Sequence[Slider | Button | Key | PygameEvents] = ()
    plots: Mapping[str, Callable[[pymunk.Space], float]] = field(default_factory=dict)
    y_down: bool = False
    units: str = "m"
    # Centre, width and height of the area to show at first; by default that of all shapes and joints.
    field: tuple[float, float, float, float] | None = None
    # What the page shows at first beside the usual: "forces", "handles", "labels", "centres".
    show: tuple[str, ...] = ()


class Scene:
    """Any Pymunk space, drawn as Pymunk's debug drawing draws it."""

    abilities: tuple[str, ...] = ("cut", "obstacles", "until_contact")
    # What pictures and the page show of Pymunk's debug drawing; contacts are sent apart.
    drawn = DrawRecorder.DRAW_SHAPES | DrawRecorder.DRAW_CONSTRAINTS

    def __init__(self, space: pymunk.Space, play: Play = Play(), values: Mapping[str, float] | None = None) -> None:
        self.space, self.play = space, play
        # A program makes its first step later.
        self.step_length = play.step or 1 / 60
        self.steps, self.time = 0, 0.0
        self.events: list[str] = []
        self.stops = self.waits_for_contact = False
        # Obstacles by number: what the page gets, and the shape.
        self._obstacles: dict[int, tuple[dict[str, Any], pymunk.Shape]] = {}
        self._hand = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        self._held: pymunk.PivotJoint | None = None
        self._recorder = DrawRecorder()
        self._recorder.flags = self.drawn
        # Kept, as Pymunk never frees the memory of a buffer.
        self._arbiters, self._bodies = batch.Buffer(), batch.Buffer()
        self.pygame = next((each for each in play.controls if isinstance(each, PygameEvents)), None)
        self._gravity = space.gravity
        # Sliders with their present values: those of the user's, and those that the scene has.
        known = {each.name: each for each in self._sliders()}
        given = {name: each.value for name, each in known.items()} | dict(values or {})
        own = [each for each in play.controls if isinstance(each, Slider)]
        self.parameters = {each.name: replace(each, value=given.get(each.name, each.low)) for each in own}
        self.parameters |= {name: each for name, each in known.items() if name not in self.parameters}
        self.fit()

    def fit(self) -> None:
        """Choose the area to show at first: that of `Play.field`, of pygame's window, or of what is drawn."""
        field = self.play.field or (self.pygame and self.pygame.field)
        if not field:
            box = extent(self.space)
            box = box if box.left <= box.right else pymunk.BB(-1, -1, 1, 1)
            field = *box.center(), max(box.right - box.left, _SMALLEST), max(box.top - box.bottom, _SMALLEST)
        self.field: dict[str, list[float]] = {"centre": list(field[:2]), "size": list(field[2:])}

    # ---- time

    def advance(self) -> None:
        """Make a step."""
        if self.play.on_step is not None:
            self.play.on_step(self.space, self.time)
        self.space.step(self.step_length)
        self.steps += 1
        self.time += self.step_length
        if self.waits_for_contact and self._pairs()[1][:, 2].any():
            self.stops, self.waits_for_contact = True, False
        self.check()

    def check(self) -> None:
        """Raise an error if a body has no finite position any more."""
        self._bodies.clear()
        batch.get_space_bodies(self.space, batch.BodyFields.POSITION, self._bodies)
        if not np.isfinite(np.frombuffer(self._bodies.float_buf())).all():
            raise DragonError("the bodies flew apart: reset, and take shorter steps")

    # ---- what controls change

    def _sliders(self) -> list[Slider]:
        """Return the sliders that any space has."""
        step, space, strength = self.play.step, self.space, self._gravity.length
        known = [
            Slider("iterations", 1, 200, space.iterations, label="Iterations", logarithmic=True, whole=True),
            Slider("damping", 0, 1, space.damping, label="Velocity kept in 1 s"),
        ]
        if step is not None:
            low, now, high = 1e2 * step, 1e3 * step, 1e4 * step
            known.insert(0, Slider("step", low, high, now, label="Time step", unit="ms", logarithmic=True))
        if strength > 0:
            unit = f"{self.play.units}/s²"
            known.append(Slider("gravity", 0, 3 * strength, strength, label="Gravity", unit=unit))
        return known

    @property
    def values(self) -> dict[str, float]:
        """Values of the sliders."""
        return {name: each.value for name, each in self.parameters.items() if each.value is not None}

    def set(self, name: str, value: float) -> None:
        """Change a value of a slider that does not rebuild."""
        slider = self.parameters[name]
        self.parameters[name] = replace(slider, value=value)
        if slider.action is not None:
            slider.action(self.space, value)
        else:
            self._change(name, value)

    def _change(self, name: str, value: float) -> None:
        """Change the length of a step, or a property of the space."""
        if name == "step":
            self.step_length = value / 1e3
        elif name == "gravity":
            direction = self._gravity.normalized() if self._gravity.length > 0 else pymunk.Vec2d(0, -1)
            self.space.gravity = value * direction
        else:
            setattr(self.space, name, value)

    def press(self, name: str, down: bool) -> None:
        """Call the action of a button or a key that is pressed, or that of a key that is released."""
        controls = [each for each in self.play.controls if isinstance(each, Button | Key) and each.name == name]
        if self.pygame is not None:
            self.pygame.key(name, down)
        elif not controls:
            raise ParameterError("name", name, "a button or a key of this scene")
        for control in controls[:1]:
            action = control.action if down else getattr(control, "up", None)
            if action is not None:
                action(self.space)

    def pointer(self, x: float, y: float, kind: str) -> None:
        """Hand the pointer on to a pygame program, whose window has its origin at the upper left."""
        if self.pygame is None:
            raise ParameterError("pointer", kind, "sent to a program with PygameEvents")
        self.pygame.pointer(
            x, y if self.play.y_down else self.field["size"][1] - y, word("kind", kind, ("down", "move", "up"))
        )

    # ---- what a hand does

    def grab(self, x: float, y: float, slip: float) -> None:
        """Hold the nearest body that can move and has a point within `slip` of a point of the world."""
        self.drop()
        self._hand.position = x, y
        found = self.space.point_query((x, y), slip, pymunk.ShapeFilter())
        bodies = [(each, each.shape.body) for each in found]
        near = [(each, body) for each, body in bodies if body and body.body_type == pymunk.Body.DYNAMIC]
        if not near:
            raise ParameterError("x, y", (x, y), "a point of a body that can be moved")
        nearest, body = min(near, key=lambda each: each[0].distance)
        anchor = body.world_to_local(nearest.point if nearest.distance > 0 else (x, y))
        self._held = pymunk.PivotJoint(self._hand, body, (0, 0), anchor)
        size = max(self.field["size"]) / _HAND_SIZE
        self._held.max_force = _HAND_ACCELERATION * max(1.0, size) * body.mass
        self._held.error_bias = _HAND_BIAS
        self.space.add(self._held)

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
        joint = self._joint_at(x, y, slip)
        self.space.remove(joint)
        if not joint.collide_bodies:
            # Bodies that the joint kept from colliding may overlap, and would be thrown apart.
            keeper = pymunk.RotaryLimitJoint(joint.a, joint.b, -math.inf, math.inf)
            keeper.collide_bodies, keeper.max_force = False, 0.0
            self.space.add(keeper)

    def obstacle(self, shape: str, x: float, y: float, size: float) -> None:
        """Put a round or square obstacle, `size` in diameter or side, on the ground."""
        if len(self._obstacles) >= _MAX_OBSTACLES:
            raise ParameterError("obstacle", shape, f"one of at most {_MAX_OBSTACLES}")
        half = positive("size", size, math.inf, self.play.units) / 2
        ground = self.space.static_body
        box = pymunk.BB(x - half, y - half, x + half, y + half)
        is_round = word("shape", shape, ("round", "square")) == "round"
        found = pymunk.Circle(ground, half, (x, y)) if is_round else pymunk.Poly.create_box_bb(ground, box)
        found.friction = _OBSTACLE_FRICTION
        number = max(self._obstacles, default=0) + 1
        self._obstacles[number] = {"id": number, "shape": shape, "x": x, "y": y, "size": 2 * half}, found
        self.space.add(found)

    def remove(self, obstacle: int) -> None:
        """Remove an obstacle."""
        if obstacle not in self._obstacles:
            raise ParameterError("obstacle", obstacle, "the number of an obstacle")
        self.space.remove(self._obstacles.pop(obstacle)[1])

    # ---- what is shown

    def to_dict(self) -> dict[str, Any]:
        """Return what the page gets once."""
        return {
            "step": self.step_length,
            "dragon": None,
            "field": self.field,
            "y_down": self.play.y_down,
            "units": self.play.units,
            "show": list(self.play.show),
            "parameters": [
                {name: part for name, part in vars(each).items() if name != "action"}
                for each in self.parameters.values()
            ],
            "buttons": [each.name for each in self.play.controls if isinstance(each, Button)],
            "keys": [each.name for each in self.play.controls if isinstance(each, Key)] + ["*"] * bool(self.pygame),
            "plots": list(self.plots()),
            "abilities": [*self.abilities, *["pointer"] * bool(self.pygame)],
        }

    def state(self) -> dict[str, Any]:
        """Return what changes now and then."""
        return {
            "contacts": None,
            "free_from": None,
            "cuts": [],
            "obstacles": [about for about, _ in self._obstacles.values()],
            "values": self.values,
            "waits_for_contact": self.waits_for_contact,
        }

    def poses(self) -> Array:
        """Return the poses (B, 3) of the bodies in the space now."""
        return np.array([(*body.position, body.angle) for body in self.space.bodies]).reshape(-1, 3)

    def calls(self) -> list[DrawCall]:
        """Return what Pymunk draws now, without contacts."""
        self.space.debug_draw(self._recorder)
        return self._recorder.calls

    def plots(self) -> dict[str, float]:
        """Return quantities for charts: energy, momentum, and those of the user's."""
        moving = [body for body in self.space.bodies if body.body_type == pymunk.Body.DYNAMIC]
        # Pymunk leaves out the half.
        kinetic = sum(body.kinetic_energy for body in moving) / 2
        potential = -sum(body.mass * body.position.dot(self.space.gravity) for body in moving)
        momentum = sum((body.mass * body.velocity for body in moving), pymunk.Vec2d.zero()).length
        found = {"Kinetic energy": kinetic, "Kinetic and potential energy": kinetic + potential, "Momentum": momentum}
        return found | {name: float(quantity(self.space)) for name, quantity in self.play.plots.items()}

    def frame(self, header: Mapping[str, Any]) -> bytes:
        """Return the present state as `in_binary` does, with the session's part of the header."""
        held = None
        if self._held is not None:
            held = [*self._held.b.local_to_world(self._held.anchor_b), *self._hand.position]
        more, arrays = self._parts()
        return in_binary({**header, "step": self.steps, "time": self.time, "held": held, **more}, arrays)

    # ---- parts of a frame

    def _parts(self) -> tuple[dict[str, Any], dict[str, Array]]:
        calls, colours = packed(self.calls())
        return {"colours": colours}, {"calls": calls, "joints": self._joints(), "contacts": self._contacts()}

    def _joints(self) -> Array:
        """Return two ends and the force of each joint that a user made."""
        rows = [(*_end(joint, "a"), *_end(joint, "b"), joint.impulse / self.step_length) for joint in self.joints()]
        return np.array(rows).reshape(-1, 5)

    def joints(self) -> list[pymunk.Constraint]:
        """Return the joints of the space, without that of the hand."""
        return [joint for joint in self.space.constraints if joint is not self._held]

    def _joint_at(self, x: float, y: float, slip: float) -> pymunk.Constraint:
        """Return the joint whose line passes within `slip` of a point."""
        joints, rows = self.joints(), self._joints()
        begin, along = rows[:, :2], rows[:, 2:4] - rows[:, :2]
        share = ((np.array((x, y)) - begin) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-12)
        distances = np.hypot(*(begin + share.clip(0, 1)[:, None] * along - (x, y)).T)
        if not (distances <= slip).any():
            raise ParameterError("x, y", (x, y), "a point of a joint")
        return joints[int(np.nanargmin(distances))]

    def _contacts(self) -> Array:
        """Return rows of point, normal and impulse of all contact points; the first of each pair has its impulse."""
        rows, flags = self._pairs()
        impulses, normals = np.hypot(rows[:, 0], rows[:, 1])[:, None], rows[:, 2:4]
        first = np.hstack([rows[:, 4:6], normals, impulses])[flags[:, 3] > 0]
        second = np.hstack([rows[:, 6:8], normals, np.full_like(impulses, NO_ARROW)])[flags[:, 3] > 1]
        return np.vstack([first, second])

    def _pairs(self) -> tuple[Array, Any]:
        """Return impulse, normal and two points of each pair in contact; and bodies, newness and number of points."""
        buffer = self._arbiters
        buffer.clear()
        batch.get_space_arbiters(self.space, _CONTACT_FIELDS, buffer)
        flags = np.frombuffer(buffer.int_buf(), np.uint64).reshape(-1, 4)
        rows = np.frombuffer(buffer.float_buf()).reshape(-1, 8)
        if len(rows) and math.isfinite(self.space.sleep_time_threshold):
            # Pymunk may list a pair that sleeps, and does not draw it.
            asleep = [body.id for body in self.space.bodies if body.is_sleeping]
            awake = ~np.isin(flags[:, :2], np.array(asleep, np.uint64)).any(axis=1)
            rows, flags = rows[awake], flags[awake]
        return rows, flags


def _end(joint: pymunk.Constraint, side: str) -> pymunk.Vec2d:
    """Return the end of a joint on body "a" or "b" in the world: an anchor, or the position of the body."""
    body: pymunk.Body = getattr(joint, side)
    return body.local_to_world(getattr(joint, f"anchor_{side}", getattr(joint, f"groove_{side}", (0.0, 0.0))))
