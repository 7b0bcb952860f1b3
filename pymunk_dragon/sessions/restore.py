"""The state of a space at first, and how the space gets it back."""

import inspect
import math
from collections.abc import Iterable, Sequence
from contextlib import suppress
from functools import cache
from typing import Any, get_args

import pymunk

from pymunk_dragon.model.contact import Phase

# Properties of a body that are set before the others, in this order: the type changes mass and
# moment, and Pymunk finds the position from that of the centre of gravity, with the angle.
_FIRST = ("body_type", "mass", "moment", "center_of_gravity", "angle", "position")

Part = pymunk.Space | pymunk.Body | pymunk.Shape | pymunk.Constraint
# The two collision types of a handler; None stands for all types.
Types = tuple[int | None, int | None]
# Functions of the handlers of a space, with their data, by phases.
Callbacks = dict[Types, dict[Phase, tuple[Any, Any]]]


class FirstState:
    """The state of a space and its parts, in so far as Pymunk lets a user change it.

    `restore` changes the same objects and makes no copies, since functions of the user's hold them.

    The run is not repeated to the bit where bodies touch. Pymunk 7.3.1 gives shapes new numbers
    when they are added again, finds contacts in another order, and starts contacts without the
    impulses that they had. Nor can one read the neighbours of segments, the groups in which bodies
    sleep, and callbacks that wait for the end of a step.
    """

    def __init__(self, space: pymunk.Space) -> None:
        self.space = space
        self._has_begun = False
        self._callbacks = callbacks(space)
        self._added = list(space.bodies)
        self._arguments = {joint: _arguments(joint) for joint in space.constraints}
        # Bodies of joints need not be in the space.
        ends = [body for joint in self._arguments for body in (joint.a, joint.b)]
        self._bodies = list(dict.fromkeys([space.static_body, *self._added, *ends]))
        self._asleep = [body for body in self._added if body.is_sleeping]

        self._outlines = {shape: _outline(shape) for shape in space.shapes}
        parts: list[Part] = [space, *self._bodies, *self._outlines, *self._arguments]
        self._properties = {part: _properties(part) for part in parts}
        # Attributes of the user's own.
        self._own = {part: _own_attributes(part) for part in parts}
        self._attached = {shape for body in self._bodies for shape in body.shapes}

    def begin(self) -> pymunk.Space:
        """The space; from the second time on, in its first state."""
        if self._has_begun:
            self.restore()
        self._has_begun = True
        return self.space

    def restore(self) -> None:
        """Give the space its first state back; no collision callback is called meanwhile."""
        space = self.space
        silence(space, callbacks(space))
        _empty(space)

        # Parts get their properties back while they are not in the space.
        self._set_back([space])
        self._make_dynamic()
        self._detach()
        for shape, (radius, points) in self._outlines.items():
            _set_outline(shape, radius, points)
        self._set_back(list(self._outlines))
        self._set_back(self._bodies)
        for joint, arguments in self._arguments.items():
            # A joint keeps its impulse, and nan, for ever, unless its constructor is called again.
            _kind(joint).__init__(joint, *arguments)
        self._set_back(list(self._arguments))

        space.add(*self._added, *self._outlines, *self._arguments)
        # A shape with a mass changes that of its body where it is added.
        self._set_back(self._bodies)
        self._restore_own_attributes()
        self._put_to_sleep()

        for types, phases in self._callbacks.items():
            for phase, (function, data) in phases.items():
                callback: dict[str, Any] = {phase: function}
                space.on_collision(*types, **callback, data=data)

    def _set_back(self, parts: Sequence[Part]) -> None:
        """Set properties that have changed; the others stay, as setting a mass has effects."""
        for part in parts:
            for name, value in self._properties[part].items():
                if getattr(part, name) != value:
                    setattr(part, name, value)

    def _make_dynamic(self) -> None:
        """Make bodies dynamic whose type has changed, as one body of a joint always has to be."""
        for body in self._bodies:
            if body.body_type != self._properties[body]["body_type"]:
                body.body_type = pymunk.Body.DYNAMIC

    def _detach(self) -> None:
        """Take shapes that were made since off the bodies, which would list them for ever."""
        for shape in [shape for body in self._bodies for shape in body.shapes]:
            if shape not in self._attached:
                shape.body = None

    def _restore_own_attributes(self) -> None:
        for part, before in self._own.items():
            for name in _own_attributes(part).keys() - before.keys():
                delattr(part, name)
            for name, value in before.items():
                setattr(part, name, value)

    def _put_to_sleep(self) -> None:
        """Put bodies to sleep: those with joints together, as joints join no groups."""
        if not math.isfinite(self.space.sleep_time_threshold):
            return
        joined = [body for body in self._asleep if body.constraints]
        for body in self._asleep:
            if body in joined[1:]:
                body.sleep_with_group(joined[0])
            else:
                body.sleep()


def callbacks(space: pymunk.Space) -> Callbacks:
    """The callbacks of a space, which Pymunk 7.3.1 shows in the state for `pickle` only.

    Reading them takes long where shapes touch: 2 ms for each contact in a space of 3,000 bodies.
    """
    handlers = dict(space.__getstate__()["special"])["_handlers"]
    return {types: _phases(kept) for types, kept in handlers}


def silence(space: pymunk.Space, handlers: Iterable[Types]) -> None:
    """Empty handlers: Pymunk calls `separate` also while a shape is removed or a space is freed."""
    empty: dict[str, Any] = dict.fromkeys(get_args(Phase), pymunk.empty_callback)
    for types in handlers:
        space.on_collision(*types, **empty)


def discard(space: pymunk.Space, handlers: Iterable[Types]) -> None:
    """Prepare a space that was built for being freed: empty its handlers, and wake its bodies.

    Pymunk 7.3.1 reads memory that was freed if a body with a joint sleeps in a space that is freed.
    """
    silence(space, handlers)
    for body in space.bodies:
        if body.is_sleeping:
            body.activate()


def _phases(handler: dict[str, Any]) -> dict[Phase, tuple[Any, Any]]:
    """The functions of a handler, and the data of each."""
    found: dict[Phase, tuple[Any, Any]] = {}
    for phase in get_args(Phase):
        function = handler[f"_{phase}"]
        if function is not None:
            found[phase] = function, handler["_data"][phase]
    return found


def _empty(space: pymunk.Space) -> None:
    """Remove all from a space; shapes that stayed would keep their contacts.

    Where a function of the user's removes or adds what is not there, or is there, Pymunk 7.3.1
    raises an error, and tries to remove or add the rest in the next steps.
    """
    for _ in range(2):
        while _removals_fail(space):
            pass
        space.remove(*space.constraints, *space.shapes, *space.bodies)
        # Additions that wait are made in an empty space, and removed again.
        with suppress(AssertionError):
            space.step(0)


def _removals_fail(space: pymunk.Space) -> bool:
    """Whether a removal that waited failed, and does not wait any more."""
    try:
        space.remove()
    except AssertionError:
        return True
    return False


def _properties(part: Part) -> dict[str, Any]:
    return {name: getattr(part, name) for name in _settable(_kind(part))}


@cache
def _settable(kind: type) -> list[str]:
    """The names of the properties that a user can set, in the order to set them."""
    members = inspect.getmembers(kind, lambda member: isinstance(member, property))
    names = [name for name, member in members if member.fset and not name.startswith("_")]
    last = len(_FIRST)
    return sorted(names, key=lambda name: _FIRST.index(name) if name in _FIRST else last)


def _kind(part: Part) -> Any:
    """The class of Pymunk's to which a part belongs, whose own class may be the user's."""
    return next(kind for kind in type(part).__mro__ if kind.__module__.startswith("pymunk."))


def _arguments(joint: pymunk.Constraint) -> list[Any]:
    """The arguments of the constructor that makes a joint."""
    return [value for _, value in joint.__getstate__()["init"]]


def _own_attributes(part: Part) -> dict[str, Any]:
    return {name: value for name, value in vars(part).items() if not name.startswith("_")}


def _outline(shape: Any) -> tuple[float, list[Any]]:
    """The radius of a shape, and its points in coordinates of the body."""
    match shape:
        case pymunk.Circle():
            return shape.radius, [shape.offset]
        case pymunk.Segment():
            return shape.radius, [shape.a, shape.b]
        case _:
            return shape.radius, [shape.get_vertices()]


def _set_outline(shape: Any, radius: float, points: Sequence[Any]) -> None:
    """Set radius and points of a shape if they have changed.

    In Pymunk 7.3.1 new points turn the normal of a segment round. They come last, since the area of
    a polygon is computed with its radius where its points are set.
    """
    present_radius, present_points = _outline(shape)
    if present_radius != radius:
        shape.unsafe_set_radius(radius)
    if present_points == points:
        return
    match shape:
        case pymunk.Circle():
            shape.unsafe_set_offset(*points)
        case pymunk.Segment():
            shape.unsafe_set_endpoints(*points)
        case _:
            shape.unsafe_set_vertices(*points)
