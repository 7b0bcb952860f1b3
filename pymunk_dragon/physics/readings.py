"""State of any Pymunk space as numbers with units: joints, contacts, masses and energies.

Pymunk's own numbers need some care (7.3.1), which stands here once, for pages, charts and events.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
import pymunk
from pymunk import batch

# Chipmunk's own functions: the properties of Pymunk take five times as long.
from pymunk._chipmunk_cffi import ffi, lib
from pymunk.batch import ArbiterFields, BodyFields

from pymunk_dragon._arrays import Array, as_complex
from pymunk_dragon.errors import ParameterError

# Impulse in the row of a contact point that has no arrow: that of its pair is in another row.
NO_ARROW = -1.0

# Joints whose impulses are torques times the length of a step; those of all others are forces times
# the length.
_ROTARY = (
    pymunk.DampedRotarySpring,
    pymunk.GearJoint,
    pymunk.RatchetJoint,
    pymunk.RotaryLimitJoint,
    pymunk.SimpleMotor,
)

# Joints whose impulses the solver does not take over from the step before, and which have a sign.
_SPRINGS = pymunk.DampedSpring, pymunk.DampedRotarySpring

# What is read of each pair in contact: two vectors, four points, and four whole numbers.
_VECTORS = ArbiterFields.TOTAL_IMPULSE | ArbiterFields.NORMAL
_POINTS = (
    ArbiterFields.POINT_A_1
    | ArbiterFields.POINT_B_1
    | ArbiterFields.POINT_A_2
    | ArbiterFields.POINT_B_2
)
_BODIES = ArbiterFields.BODY_A_ID | ArbiterFields.BODY_B_ID
_FLAGS = ArbiterFields.IS_FIRST_CONTACT | ArbiterFields.CONTACT_COUNT
_PAIR = _VECTORS | _POINTS | _BODIES | _FLAGS

# What is kept of a pair after a step.
_EARLIER = ArbiterFields.TOTAL_IMPULSE | _BODIES | _FLAGS

# Pairs of shapes between the same two bodies that are told apart.
_MOST_PAIRS = 1024

# Quantities of any space by their titles in charts, and the kinds of their units.
QUANTITIES = {
    "Kinetic energy": "energy",
    "Kinetic and potential energy": "energy",
    "Momentum": "impulse",
}


def units(length: str) -> dict[str, str]:
    """Units of forces, torques, impulses and energies, of a space with a unit of length and kg."""
    if length == "m":
        return {"force": "N", "torque": "N m", "impulse": "N s", "energy": "J"}
    energy = f"kg {length}²/s²"
    return {
        "force": f"kg {length}/s²",
        "torque": energy,
        "impulse": f"kg {length}/s",
        "energy": energy,
    }


class Readings:
    """Readings of a space that is stepped: joints, contacts, and whether it is whole."""

    def __init__(self, space: pymunk.Space) -> None:
        self._space = space
        self._forces = JointForces(space)
        self._contacts = Contacts(space)
        # Kept, as Pymunk never frees the memory of a buffer.
        self._buffer = batch.Buffer()

    def before_step(self, length: float) -> None:
        """Read what the next step, which takes `length` s, overwrites."""
        self._forces.before_step(length)
        self._contacts.before_step(length)

    def joints(self, joints: Sequence[pymunk.Constraint]) -> Array:
        """Rows of some joints; see `JointForces`."""
        return self._forces.rows(joints)

    def contacts(self) -> Array:
        """Rows of all contact points; see `Contacts`."""
        return self._contacts.rows()

    def are_finite(self) -> bool:
        """Whether all bodies have finite positions."""
        self._buffer.clear()
        batch.get_space_bodies(self._space, BodyFields.POSITION, self._buffer)
        return bool(np.isfinite(np.frombuffer(self._buffer.float_buf())).all())


# ---- joints


class JointForces:
    """Forces and torques of the joints of a space in its last step.

    `Constraint.impulse` is a sum J, with which the solver goes on in the next step. In a step that
    is c times as long as the one before, Pymunk 7.3.1 begins with c times the impulse, and yet adds
    to J itself. So the impulse that a joint gives in step n is J_n + (c - 1) J_(n-1); it is J_n
    where c = 1. This needs J_(n-1), which `before_step` reads. Springs begin anew in each step.

    Pymunk tells the sizes of J_n and J_(n-1), not their directions. The forces are right if both
    have the same direction, which a force has that changes little from step to step. They are not
    after a change of the step in which the force turns round. Nor are they if steps alternate
    between two lengths, one of them more than 2.6 times as long as the other: then J changes its
    sign and grows without limit, because each error of J is multiplied by -(k - 1)²/k, where k is
    the ratio of the lengths.
    """

    def __init__(self, space: pymunk.Space) -> None:
        self._space = space
        self._length = space.current_time_step
        # What the impulses of joints lack, (c - 1) J_(n-1).
        self._missing: dict[pymunk.Constraint, float] = {}

    def before_step(self, length: float) -> None:
        """Read what the next step, which takes `length` s, overwrites.

        A step of 0 s does nothing in Pymunk.
        """
        before = self._space.current_time_step
        self._length = length
        if length in (0.0, before):
            # The impulses of a joint that sleeps are still those of an earlier step.
            for joint in list(self._missing):
                if not sleeps(joint):
                    del self._missing[joint]
        else:
            ratio = length / before if before else 0.0
            joints = self._space.constraints
            self._missing = {joint: self._missing_after(joint, ratio) for joint in joints}

    def _missing_after(self, joint: pymunk.Constraint, ratio: float) -> float:
        """What the impulse of a joint lacks after a step with a `ratio` to the length before."""
        impulse = joint.impulse
        if sleeps(joint):
            return ratio * (impulse + self._missing.get(joint, 0.0)) - impulse
        return 0.0 if isinstance(joint, _SPRINGS) else (ratio - 1) * impulse

    def sizes(self, joints: Sequence[pymunk.Constraint]) -> Array:
        """Forces (J,), or torques of rotary joints, in the last step; nan if it took 0 s."""
        impulses = [self._impulse(joint) for joint in joints]
        return np.abs(impulses) / (self._length or math.nan)

    def _impulse(self, joint: pymunk.Constraint) -> float:
        """Impulse of a joint in the last step."""
        missing = self._missing.get(joint, 0.0)
        if missing and joint.impulse == 0 and _is_loose(joint):
            # A joint that is within its limits begins with an impulse of 0.
            return 0.0
        return joint.impulse + missing

    def rows(self, joints: Sequence[pymunk.Constraint]) -> Array:
        """Rows (J, 6) of the two ends of joints, of the sizes, and of 1 where that is a torque."""
        rotary = [isinstance(joint, _ROTARY) for joint in joints]
        return np.column_stack([_ends(joints), self.sizes(joints), rotary])


def sleeps(joint: pymunk.Constraint) -> bool:
    """Whether a body of a joint sleeps: Pymunk neither solves nor draws the joint."""
    return joint.a.is_sleeping or joint.b.is_sleeping


def _is_loose(joint: pymunk.Constraint) -> bool:
    """Whether a joint is one with limits, and within them."""
    angle = joint.b.angle - joint.a.angle
    match joint:
        case pymunk.SlideJoint():
            return joint.min <= _end(joint, "a").get_distance(_end(joint, "b")) <= joint.max
        case pymunk.RotaryLimitJoint():
            return joint.min <= angle <= joint.max
        case pymunk.RatchetJoint():
            return (joint.angle - angle) * joint.ratchet <= 0
        case _:
            return False


def _ends(joints: Sequence[pymunk.Constraint]) -> Array:
    """Rows (J, 4) of the two ends of joints."""
    rows = [(*_end(joint, "a"), *_end(joint, "b")) for joint in joints]
    return np.array(rows).reshape(-1, 4)


def _end(joint: pymunk.Constraint, side: str) -> pymunk.Vec2d:
    """End of a joint on body "a" or "b" in the world: an anchor, or the position of the body."""
    body: pymunk.Body = getattr(joint, side)
    for kind in ("anchor", "groove"):
        point = getattr(joint, f"{kind}_{side}", None)
        if point is not None:
            return body.local_to_world(point)
    return body.position


def joint_at(
    joints: Sequence[pymunk.Constraint], x: float, y: float, slip: float
) -> pymunk.Constraint:
    """The joint whose line passes nearest to a point, if that is within `slip`."""
    point = complex(x, y)
    begin, end = as_complex(_ends(joints).reshape(-1, 2, 2)).T
    along = end - begin
    share = ((point - begin) / np.where(along == 0, 1, along)).real.clip(0, 1)
    distances = abs(begin + share * along - point)
    if not (distances <= slip).any():
        raise ParameterError("x, y", (x, y), "a point of a joint")
    return joints[int(np.nanargmin(distances))]


# ---- contacts


class Contacts:
    """Contact points of a space in its last step, with normals and impulses.

    Normals point from the older body of a pair to the younger one: the space's own static body is
    the oldest, and the others are as old as `Space.bodies` lists them. Pymunk's order of two shapes
    of one type changes from step to step.

    Impulses are corrected for a change of the step as those in `JointForces`, but as vectors. Where
    a pair touches again within `Space.collision_persistence` steps, Pymunk 7.3.1 counts its earlier
    impulse once more, which is subtracted. Pymunk tells only the sum over a pair's two points, and
    of pairs of shapes only the bodies: the impulse is not exact in a step of another length in
    which one of two points is lost, or one of several pairs of two bodies.
    """

    def __init__(self, space: pymunk.Space) -> None:
        self._space = space
        # Kept, as Pymunk never frees the memory of a buffer.
        self._buffer = batch.Buffer()
        # Length of the last step over that of the one before; 0 if it took no time.
        self._ratio = 1.0
        # Pairs after the steps before the last one, the latest at the end.
        self._before: deque[tuple[Array, Any]] = deque()
        # The bodies of the space by age, and numbers, which take long to read.
        self._bodies: list[pymunk.Body] = []
        self._ids = np.array([], np.uintp)

    def before_step(self, length: float) -> None:
        """Read what the next step, which takes `length` s, overwrites."""
        before = self._space.current_time_step
        # The first step of a space has no impulses to begin with.
        self._ratio = length / before if before else float(length > 0)
        if length > 0:
            self._before.append(self._read(_EARLIER))
        while len(self._before) > self._space.collision_persistence:
            self._before.popleft()

    def rows(self) -> Array:
        """Rows (C, 5) of point, normal and impulse of all contact points.

        The first point of a pair has the pair's impulse.
        """
        pairs, flags = self._awake(*self._read(_PAIR))
        impulses = self._impulses(pairs, flags)
        normals = pairs[:, 2:4] * self._signs(flags)[:, None]
        points = (pairs[:, 4:6] + pairs[:, 6:8]) / 2
        first = np.column_stack([points, normals, impulses])

        points = (pairs[:, 8:10] + pairs[:, 10:12]) / 2
        second = np.column_stack([points, normals, np.full_like(impulses, NO_ARROW)])
        has_second = flags[:, 3] > 1
        return np.vstack([first, second[has_second]])

    def push(self) -> bool:
        """Whether a pair that touches had an impulse in the last step."""
        pairs, _ = self._read(_EARLIER)
        return bool(pairs.any())

    def _read(self, fields: ArbiterFields) -> tuple[Array, Any]:
        """Numbers (P, K) and (P, 4) of all pairs that touch."""
        self._buffer.clear()
        batch.get_space_arbiters(self._space, fields, self._buffer)
        # Whole numbers have the size of a pointer.
        flags = np.frombuffer(self._buffer.int_buf(), np.uintp).reshape(-1, 4)
        numbers = np.frombuffer(self._buffer.float_buf())
        pairs = numbers.reshape(len(flags), -1 if len(flags) else 12)
        # Pymunk also lists pairs that touched before. The choice copies the memory, which is used
        # again.
        touching = flags[:, 3] > 0
        return pairs[touching], flags[touching]

    def _awake(self, pairs: Array, flags: Any) -> tuple[Array, Any]:
        """Pairs without those that sleep, which Pymunk may list, and does not draw."""
        if math.isinf(self._space.sleep_time_threshold):
            return pairs, flags
        asleep = self._numbers()[1:][[body.is_sleeping for body in self._bodies]]
        awake = ~np.isin(flags[:, :2], asleep).any(axis=1)
        return pairs[awake], flags[awake]

    def _numbers(self) -> Any:
        """Numbers (1 + B,) of the space's own body and the others, by age."""
        bodies = list(self._space.bodies)
        if bodies != self._bodies or not self._ids.size:
            self._bodies = bodies
            everybody = [self._space.static_body, *bodies]
            self._ids = np.array([body.id for body in everybody], np.uintp)
        return self._ids

    def _signs(self, flags: Any) -> Array:
        """1 for pairs (P,) whose first body is the older one, otherwise -1."""
        ids = self._numbers()
        order = np.argsort(ids)
        ages = order[np.searchsorted(ids[order], flags[:, :2])]
        return np.where(ages[:, 0] <= ages[:, 1], 1.0, -1.0)

    def _impulses(self, pairs: Array, flags: Any) -> Array:
        """Sizes (P,) of the impulses of pairs in the last step."""
        if self._ratio == 0:
            return np.full(len(pairs), NO_ARROW)
        begins = flags[:, 2] > 0
        # A pair that begins to touch gets none of its earlier impulse.
        shares = np.where(begins, 0.0, self._ratio)
        vectors = _vectors(pairs, flags)
        wanted = shares != 1
        for earlier, earlier_flags in reversed(self._before):
            if not wanted.any():
                break
            found, place = _common(flags, earlier_flags)
            known = wanted[found]
            found = found[known]
            before = _vectors(earlier, earlier_flags)[place[known]]
            vectors[found] += (shares[found, None] - 1) * before
            # Pairs that go on are those of the step before.
            wanted &= begins
            wanted[found] = False
        return np.asarray(np.hypot(*vectors.T))


def _vectors(pairs: Array, flags: Any) -> Array:
    """Impulses (P, 2) of pairs, on the body with the lower number."""
    signs: Array = np.where(flags[:, :1] < flags[:, 1:2], 1.0, -1.0)
    return signs * pairs[:, :2]


def _common(flags: Any, earlier: Any) -> tuple[Any, Any]:
    """Indices of the pairs that are among earlier ones, and where they are there."""
    # Numbers of bodies are pointers, of which no two fit into one number.
    bodies = np.sort(np.append(flags[:, :2], earlier[:, :2]))
    codes = _codes(flags, bodies)
    _, found, place = np.intersect1d(codes, _codes(earlier, bodies), return_indices=True)
    return found, place


def _codes(flags: Any, bodies: Any) -> Array:
    """Numbers (P,) of pairs, by their two bodies.

    Among pairs of the same two bodies, those that go on have the lower numbers.
    """
    low, high = np.sort(np.searchsorted(bodies, flags[:, :2])).T
    # Floats have 53 bits on every platform.
    codes: Array = (low * float(len(bodies)) + high) * _MOST_PAIRS
    order = np.lexsort((flags[:, 2], codes))
    ranks = np.arange(len(order)) - np.searchsorted(codes[order], codes[order])
    codes[order] += ranks
    return codes


def impulse_of(arbiter: pymunk.Arbiter, before: pymunk.Vec2d, ratio: float) -> pymunk.Vec2d:
    """Impulse on the first shape of a pair in this step, for `post_solve`; see `Contacts`.

    `before` is `Arbiter.total_impulse` in `pre_solve`, and `ratio` that of the step's length to
    that of the one before.
    """
    share = 0.0 if arbiter.is_first_contact else ratio
    return arbiter.total_impulse + (share - 1) * before


def arbiter_rows(arbiter: pymunk.Arbiter, swapped: bool, impulse: float) -> list[tuple[float, ...]]:
    """The rows of `Contacts` for a pair in a callback, `swapped` if its second body is older."""
    contact = arbiter.contact_point_set
    normal = contact.normal * (-1 if swapped else 1)
    rows: list[tuple[float, ...]] = []
    for point, size in zip(contact.points, (impulse, NO_ARROW), strict=False):
        middle = (point.point_a + point.point_b) / 2
        rows.append((*middle, *normal, size))
    return rows


class Touches:
    """Pairs of shapes that touch, to notice when one begins to.

    A pair touches if Pymunk calls `begin` for it: sensors do, and pairs that no solver moves, as a
    kinematic body on a static one, or one that `begin` has switched off. So it is found from the
    shapes; a callback would take the place of one of the user's. Two static shapes never touch, nor
    do shapes of one body, of bodies whose joint has `collide_bodies` switched off, or of which a
    filter rejects the other.
    """

    def __init__(self, space: pymunk.Space) -> None:
        self._space = space
        self._touching = _touching(space)

    def begin(self) -> bool:
        """Whether a pair touches that did not touch at the last call, or when this was made."""
        before = self._touching
        self._touching = _touching(self._space)
        return bool(self._touching - before)


def _touching(space: pymunk.Space) -> set[frozenset[pymunk.Shape]]:
    """Pairs of shapes that touch."""
    apart = {
        frozenset((joint.a, joint.b)) for joint in space.constraints if not joint.collide_bodies
    }

    found = set()
    for shape in space.shapes:
        body = shape.body
        if body is None or body.body_type == pymunk.Body.STATIC:
            continue
        for hit in space.shape_query(shape):
            bodies = frozenset((body, hit.shape.body))
            if len(bodies) == 2 and bodies not in apart:
                found.add(frozenset((shape, hit.shape)))
    return found


# ---- bodies


def grip(shape: pymunk.Shape) -> int:
    """How a hand holds a body by a shape: 2 if it can, 1 where it finds no other, 0 if it cannot.

    Only dynamic bodies are held. A sensor counts as empty ground, unless its body has only sensors.
    """
    body = shape.body
    if body is None or body.body_type != pymunk.Body.DYNAMIC:
        return 0
    if not shape.sensor:
        return 2
    return int(all(each.sensor for each in body.shapes))


def body_at(
    shapes: Sequence[pymunk.Shape],
    x: float,
    y: float,
    slip: float,
) -> tuple[pymunk.Body, pymunk.Vec2d]:
    """The body that a hand takes at a point, and its point that is nearest.

    Of `shapes`, in the order of drawing and with the best grip, that is the last that covers the
    point, or else the nearest within `slip`. What they collide with does not matter.
    """
    point = pymunk.Vec2d(x, y)
    near = []
    for shape in reversed(shapes):
        hold = grip(shape)
        body = shape.body
        if hold == 0 or body is None:
            continue
        found = shape.point_query(point)
        distance = max(found.distance, 0.0)
        if distance <= slip:
            # Pymunk (7.3.1) has NaN for a point on the edge of a polygon.
            nearest = found.point if distance > 0 else point
            near.append((-hold, distance, body, nearest))

    if not near:
        raise ParameterError("x, y", (x, y), "a point of a body that can be moved")
    _, _, taken, nearest = min(near, key=lambda each: each[:2])
    return taken, nearest


def energies(space: pymunk.Space) -> dict[str, float]:
    """Energy and momentum of all bodies that move, by their titles in `QUANTITIES`.

    A body's position is where its own origin is; its velocity and its moment are those of its
    centre of mass, and its gravity acts there. An infinite moment has no energy, as its rotation
    never changes. What sleeps is at rest.

    Potential energy is that of `Space.gravity` and of springs, up to the force that `max_force`
    allows them. It has no part of forces that the user's functions choose: `velocity_func`,
    `force_func` and `torque_func`.
    """
    bodies = [body._body for body in space.bodies]
    dynamic = [each for each in bodies if lib.cpBodyGetType(each) == pymunk.Body.DYNAMIC]
    moving = [each for each in dynamic if not lib.cpBodyIsSleeping(each)]
    masses = _numbers(lib.cpBodyGetMass, moving)
    moments = _numbers(lib.cpBodyGetMoment, moving)
    moments[np.isinf(moments)] = 0.0
    spins = _numbers(lib.cpBodyGetAngularVelocity, moving)
    velocities = vectors(map(lib.cpBodyGetVelocity, moving))
    squares = (velocities**2).sum(axis=1)
    kinetic = math.fsum(masses * squares + moments * spins**2) / 2
    momentum = math.hypot(*(masses @ velocities))

    own = map(lib.cpBodyGetCenterOfGravity, dynamic)
    heights = vectors(map(lib.cpBodyLocalToWorld, dynamic, own)) @ space.gravity
    potential = -math.fsum(_numbers(lib.cpBodyGetMass, dynamic) * heights)
    elastic = math.fsum(map(_elastic_energy, space.constraints))
    values = kinetic, kinetic + potential + elastic, momentum
    return dict(zip(QUANTITIES, values, strict=True))


def _numbers(read: Callable[[Any], float], parts: Sequence[Any]) -> Array:
    """Numbers (N,) that a function of Chipmunk's reads of parts of a space."""
    return np.array([*map(read, parts)], dtype=float)


def vectors(found: Iterable[Any]) -> Array:
    """Vectors (N, 2) of Chipmunk's as an array."""
    return np.frombuffer(ffi.buffer(ffi.new("cpVect[]", [*found]))).reshape(-1, 2)


def _elastic_energy(joint: pymunk.Constraint) -> float:
    """Energy that a joint stores; only springs do."""
    match joint:
        case pymunk.DampedSpring(force_func=pymunk.DampedSpring.spring_force):
            offset = _end(joint, "a").get_distance(_end(joint, "b")) - joint.rest_length
        case pymunk.DampedRotarySpring(torque_func=pymunk.DampedRotarySpring.spring_torque):
            offset = joint.a.angle - joint.b.angle - joint.rest_angle
        case _:
            return 0.0
    if joint.stiffness == 0:
        return 0.0

    # The force grows with the offset up to the largest one, and is constant from there on.
    force = min(joint.stiffness * abs(offset), joint.max_force)
    return force * abs(offset) - force**2 / (2 * joint.stiffness)
