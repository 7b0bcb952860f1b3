"""A Pymunk space that is shown and touched: its bodies, joints and contacts, and what a hand may do to them."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pymunk

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import finite, positive, whole
from pymunk_dragon.errors import ParameterError

# Largest force of a hand, in N per kg of the body: that of Box2D's testbed.
HAND_FORCE = 1000.0
# Share of the distance to the pointer that is left after a second, as in Pymunk's examples.
HAND_BIAS = (1 - 0.15) ** 60
# m. Coordinates from outside are not larger.
MAX_COORDINATE = 1e6
# Obstacles at once.
MAX_OBSTACLES = 100
# Of an obstacle on a body.
OBSTACLE_FRICTION = 0.4
# m.
SMALLEST_FIELD = 1e-3
# Constraints whose anchors are called so.
ANCHORS = ("anchor_a", "anchor_b")
# What a session changes in a space and in its bodies.
SPACE_STATE = ("gravity", "damping", "iterations")
# The angle comes first: Pymunk finds the position of a body from that of its centre of mass, with the angle.
BODY_STATE = ("angle", "position", "velocity", "angular_velocity", "force", "torque")
# Layout of a frame's head, as `sessions/assets` reads it: generation, bodies, joints, contacts, exact bodies, flags;
# step, time, time of the march, achieved rate, time of a step in ms; held body, its point, and where the hand is.
HEAD = struct.Struct("<6I5d5f")
HELD = 1
LARGEST_FLOAT = float(np.finfo(np.float32).max)


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """A number that a slider changes.

    Attributes
    ----------
    name, label, unit : str
        Name in messages, name on the page, and unit of all values here.
    low, high : float
        Range.
    logarithmic, whole, rebuilds : bool
        Whether the slider is logarithmic, the number is whole, and the scene begins anew with it.
    """

    name: str
    label: str
    unit: str
    low: float
    high: float
    logarithmic: bool = False
    whole: bool = False
    rebuilds: bool = False

    def checked(self, value: float) -> float:
        """The value, if it is in the range, and whole if it has to be."""
        if self.whole:
            return whole(self.name, int(value) if value.is_integer() else value, int(self.low), int(self.high))
        return finite(self.name, value, self.low, self.high, self.unit)


class Scene:
    """Any Pymunk space.

    Parameters
    ----------
    space : pymunk.Space
        The space. It is stepped here, and gets a joint and shapes while somebody holds a body or puts obstacles.
    step : float
        Length of a step, s.
    field : (float, float, float, float), optional
        Centre, width and height of the area to show at first, m; by default that of all shapes and joints.

    Attributes
    ----------
    bodies, joints : list
        Those of the space when it was given, in its order.
    steps : int
        Number of steps so far.
    field : dict
        Centre and size of the area to show at first, m.
    obstacles : dict
        Obstacles by their numbers: kind, x, y, size in m.
    events : list of str
        What happened since the list was cleared.
    stops : bool
        Whether the last step asks to pause.
    """

    abilities: tuple[str, ...] = ("cut", "obstacles", "speed")

    def __init__(
        self, space: pymunk.Space, step: float = 1 / 60, field: tuple[float, float, float, float] | None = None
    ) -> None:
        self.space = space
        self.step_length = self._first_step = step
        self.bodies = list(space.bodies)
        self.joints = list(space.constraints)
        self._numbers = {body: number for number, body in enumerate(self.bodies)}
        x, y, width, height = self._extent() if field is None else field
        self.field = {"centre": [x, y], "size": [width, height]}
        self._gravity, self._gravity_share = space.gravity, 1.0
        self.steps = 0
        self.events: list[str] = []
        self.stops = False
        self.obstacles: dict[int, dict[str, Any]] = {}
        self._obstacle_shapes: dict[int, pymunk.Shape] = {}
        self._hand = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        self._held: pymunk.PivotJoint | None = None
        self.cuts: list[int] = []
        self._given = [
            (item, {name: getattr(item, name) for name in names})
            for items, names in (([space], SPACE_STATE), (self.bodies, BODY_STATE), (self.joints, ("max_force",)))
            for item in items
        ]

    # ---- time

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self.steps * self.step_length

    @property
    def march_time(self) -> float:
        """Time of the exact model that the scene follows, s; nan if there is none."""
        return math.nan

    def advance(self) -> None:
        """Make a step."""
        self.space.step(self.step_length)
        self.steps += 1

    # ---- what a slider changes

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The sliders."""
        step = 1e3 * self._first_step
        return (
            Parameter(name="step", label="Time step", unit="ms", low=step / 10, high=step * 10, logarithmic=True),
            Parameter(name="iterations", label="Iterations", unit="", low=1, high=200, logarithmic=True, whole=True),
            Parameter(name="damping", label="Velocity kept in 1 s", unit="", low=0.0, high=1.0),
            Parameter(name="gravity", label="Gravity", unit="times", low=-2.0, high=2.0),
        )

    @property
    def values(self) -> dict[str, float]:
        """Values of the parameters."""
        return {
            "step": 1e3 * self.step_length,
            "iterations": self.space.iterations,
            "damping": self.space.damping,
            "gravity": self._gravity_share,
        }

    def set(self, name: str, value: float) -> None:
        """Change a parameter that does not rebuild."""
        if name == "step":
            self.step_length = value / 1e3
        elif name == "iterations":
            self.space.iterations = int(value)
        elif name == "damping":
            self.space.damping = value
        elif name == "gravity":
            self._gravity_share = value
            self.space.gravity = self._gravity * value

    # ---- what a hand does

    def grab(self, body: int, x: float, y: float) -> None:
        """Hold a body at a point of the world, m."""
        self.drop()
        number = whole("body", body, 0, len(self.bodies) - 1)
        held = self.bodies[number]
        if held.body_type != pymunk.Body.DYNAMIC:
            raise ParameterError("body", body, "one that can be moved")
        self._hand.position = _point(x, y)
        self._held = pymunk.PivotJoint(self._hand, held, (0, 0), held.world_to_local(self._hand.position))
        self._held.max_force = HAND_FORCE * held.mass
        self._held.error_bias = HAND_BIAS
        self.space.add(self._held)

    def drag(self, x: float, y: float) -> None:
        """Move the hand."""
        self._hand.position = _point(x, y)

    def drop(self) -> None:
        """Let go of the body that is held."""
        if self._held is not None:
            self.space.remove(self._held)
            self._held = None

    def cut(self, joint: int) -> None:
        """Cut a joint: it transmits no force any more."""
        number = whole("joint", joint, 0, len(self.joints) - 1)
        if number not in self.cuts:
            # Not removed: bodies that a joint keeps from colliding may overlap, and would be thrown apart.
            self.joints[number].max_force = 0.0
            self.cuts.append(number)

    def obstacle(self, shape: str, x: float, y: float, size: float) -> None:
        """Put a round or square obstacle, `size` m in diameter or side, on the ground."""
        if len(self.obstacles) >= MAX_OBSTACLES:
            raise ParameterError("obstacle", shape, f"one of at most {MAX_OBSTACLES}")
        x, y = _point(x, y)
        half = positive("size", size, MAX_COORDINATE, "m") / 2
        ground = self.space.static_body
        found: pymunk.Shape
        if shape == "round":
            found = pymunk.Circle(ground, half, (x, y))
        elif shape == "square":
            corners = [(x - half, y - half), (x + half, y - half), (x + half, y + half), (x - half, y + half)]
            found = pymunk.Poly(ground, corners)
        else:
            raise ParameterError("shape", shape, "round or square")
        found.friction = OBSTACLE_FRICTION
        number = max(self.obstacles, default=0) + 1
        self.obstacles[number] = {"id": number, "shape": shape, "x": x, "y": y, "size": 2 * half}
        self._obstacle_shapes[number] = found
        self.space.add(found)

    def remove(self, obstacle: int) -> None:
        """Remove an obstacle."""
        if obstacle not in self.obstacles:
            raise ParameterError("obstacle", obstacle, "the number of an obstacle")
        del self.obstacles[obstacle]
        self.space.remove(self._obstacle_shapes.pop(obstacle))

    def restore(self) -> None:
        """Put the space back as it was when it was given."""
        self.drop()
        for number in tuple(self.obstacles):
            self.remove(number)
        for item, values in self._given:
            for name, value in values.items():
                setattr(item, name, value)
        for body in self.bodies:
            if body.space is self.space:
                self.space.reindex_shapes_for_body(body)

    # ---- what is shown

    def to_dict(self) -> dict[str, Any]:
        """Bodies, joints and shapes, as the page gets them once."""
        return {
            "step": self.step_length,
            "dragon": None,
            "bodies": [
                {"type": _TYPES[body.body_type], "shapes": [_shape(shape) for shape in _ordered(body)]}
                for body in self.bodies
            ],
            "static": [_shape(shape) for shape in _ordered(self.space.static_body)],
            "joints": [self._joint(joint) for joint in self.joints],
            "field": self.field,
            "parameters": [{**vars(each), "value": self.values[each.name]} for each in self.parameters],
            "abilities": list(self.abilities),
        }

    def state(self) -> dict[str, Any]:
        """What changes now and then."""
        return {
            "contacts": None,
            "free_from": None,
            "cuts": list(self.cuts),
            "obstacles": list(self.obstacles.values()),
            "values": self.values,
        }

    def poses(self) -> Array:
        """Poses (B, 3) of the bodies: m, m, rad."""
        return np.array([(*body.position, body.angle) for body in self.bodies]).reshape(-1, 3)

    def frame(self, generation: int, rate: float, step_seconds: float) -> bytes:
        """The present state in binary, as `HEAD` says."""
        contacts = np.array(list(self._contacts()), dtype="<f4").reshape(-1, 7)
        exact, errors = self._exact()
        poses = self.poses()
        held: Array = np.zeros(5)
        if self._held is not None:
            held[:] = self._numbers[self._held.b], *self._held.anchor_b, *self._hand.position
        head = HEAD.pack(
            *(generation, len(poses), len(self.joints), len(contacts), len(exact), HELD if self._held else 0),
            *(self.steps, self.time, self.march_time, rate, 1e3 * step_seconds),
            *np.clip(held, -LARGEST_FLOAT, LARGEST_FLOAT),
        )
        forces = np.array([joint.impulse for joint in self.joints]) / self.step_length
        parts = (poses, forces, exact, errors, contacts)
        with np.errstate(over="ignore"):
            return head + b"".join(part.astype("<f4").tobytes() for part in parts)

    def standing_joints(self) -> list[pymunk.Constraint]:
        """Joints that were not cut, and that of the hand."""
        held = [] if self._held is None else [self._held]
        return [joint for number, joint in enumerate(self.joints) if number not in self.cuts] + held

    def _exact(self) -> tuple[Array, Array]:
        """Poses (E, 3) of the exact bodies, and the position errors (E,), m; empty if there are none."""
        return np.empty((0, 3)), np.empty(0)

    def _contacts(self) -> Iterator[tuple[float, ...]]:
        """Of each contact: two bodies, point, normal, impulse in N s."""
        found: dict[tuple[pymunk.Shape, pymunk.Shape], tuple[float, ...]] = {}

        def note(arbiter: pymunk.Arbiter, data: Any) -> None:
            contact, impulse = arbiter.contact_point_set, arbiter.total_impulse.length
            if contact.points:
                found[arbiter.shapes] = self._contact(
                    arbiter.shapes, contact.points[0].point_a, contact.normal, impulse
                )

        for body in self.bodies:
            if body.body_type == pymunk.Body.DYNAMIC:
                body.each_arbiter(note, None)
        return iter(found.values())

    def _contact(self, shapes: Any, point: pymunk.Vec2d, normal: pymunk.Vec2d, impulse: float) -> tuple[float, ...]:
        first, second = (float(self._number(shape.body)) for shape in shapes)
        return first, second, *point, *normal, impulse

    def _joint(self, joint: pymunk.Constraint) -> dict[str, Any]:
        anchors = {name: list(getattr(joint, name, (0.0, 0.0))) for name in ANCHORS}
        return {"type": type(joint).__name__, "a": self._number(joint.a), "b": self._number(joint.b), **anchors}

    def _number(self, body: pymunk.Body | None) -> int:
        """Number of a body; -1 of the ground."""
        return -1 if body is None else self._numbers.get(body, -1)

    def _extent(self) -> tuple[float, float, float, float]:
        """Centre, width and height of all shapes, bodies and anchors in the world, m."""
        boxes = [shape.cache_bb() for shape in self.space.shapes]
        points = [body.position for body in self.bodies]
        points += [
            getattr(joint, "anchor_a", joint.a.position) for joint in self.joints if joint.a not in self._numbers
        ]
        xs = [x for box in boxes for x in (box.left, box.right)] + [x for x, _ in points] or [-1.0, 1.0]
        ys = [y for box in boxes for y in (box.bottom, box.top)] + [y for _, y in points] or [-1.0, 1.0]
        width, height = (max(max(values) - min(values), SMALLEST_FIELD) for values in (xs, ys))
        return (min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2, width, height


_TYPES = {pymunk.Body.DYNAMIC: "dynamic", pymunk.Body.KINEMATIC: "kinematic", pymunk.Body.STATIC: "static"}
Build = Callable[[dict[str, float]], Scene]


def _ordered(body: pymunk.Body) -> list[pymunk.Shape]:
    """Shapes of a body, which Pymunk keeps in a set, in an order that is always the same."""
    return sorted(body.shapes, key=lambda shape: str(_shape(shape)))


def _shape(shape: pymunk.Shape) -> dict[str, Any]:
    colour = getattr(shape, "color", None)
    more = {} if colour is None else {"color": list(colour)}
    if isinstance(shape, pymunk.Circle):
        return {"circle": [*shape.offset, shape.radius], **more}
    if isinstance(shape, pymunk.Segment):
        return {"segment": [*shape.a, *shape.b, shape.radius], **more}
    assert isinstance(shape, pymunk.Poly)  # Pymunk has no fourth kind of shape.
    return {"polygon": [x for vertex in shape.get_vertices() for x in vertex], "radius": shape.radius, **more}


def _point(x: object, y: object) -> tuple[float, float]:
    bound = -MAX_COORDINATE, MAX_COORDINATE
    return finite("x", x, *bound, "m"), finite("y", y, *bound, "m")
