"""Contacts as Pymunk reports them: a log of all collision callbacks, and what these raise."""

from __future__ import annotations

import math
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from time import perf_counter
from typing import Any, get_args

import pymunk

from pymunk_dragon.model.contact import Contact, ContactEvent, Phase
from pymunk_dragon.physics.readings import impulse_of
from pymunk_dragon.physics.world import World

_Vector = tuple[float, float]

# Exceptions in callbacks of the present thread, while they are collected.
_CAUGHT = threading.local()

# The hook that was there before.
_BEFORE = [sys.__unraisablehook__]


@contextmanager
def callbacks_raise() -> Iterator[None]:
    """Context that raises the first exception in a callback of this thread at its end.

    Pymunk calls back from C, where Python would only print an exception.
    """
    if sys.unraisablehook is not _collect:
        # The hook stays, as other threads may be in this context too.
        _BEFORE[0] = sys.unraisablehook
        sys.unraisablehook = _collect
    errors: list[BaseException] = []
    _CAUGHT.errors = errors
    try:
        yield
        if errors:
            raise errors[0]
    finally:
        _CAUGHT.errors = None


def _collect(raised: Any) -> None:
    errors = getattr(_CAUGHT, "errors", None)
    if errors is None or raised.exc_value is None:
        _BEFORE[0](raised)
    else:
        errors.append(raised.exc_value)


class Recorder:
    """Log of every collision callback of a world's space, as `ContactEvent`.

    Where contacts are only reported, the engine does not act on them, and `post_solve` never comes.

    Pymunk 7.3.1 reports some rectangles in line as touching, metres deep or without a normal,
    although they are apart. So a contact is checked where it begins and where it is deeper than the
    narrowest bench. It is neither logged nor acted on while the benches are apart.
    """

    def __init__(
        self, world: World, on_event: Callable[[ContactEvent], None] | None = None
    ) -> None:
        self.events: list[ContactEvent] = []
        # Contacts that began in the last step, with the values at its end.
        self.begun: list[Contact] = []
        # Whether a step is being made.
        self.in_engine = False
        self._world = world
        self._on_event = on_event
        self._time = world.start
        self._benches: dict[pymunk.Shape, int] = {
            shape: bench for bench, shape in enumerate(world.shapes)
        }
        self._narrowest = float(world.march.dragon.widths.min())
        # Pairs whose contact has begun and not ended.
        self._touching: set[tuple[int, int]] = set()
        # Impulses of pairs at `pre_solve`, which belong to earlier steps.
        self._earlier: dict[tuple[int, int], pymunk.Vec2d] = {}
        callbacks: dict[str, Any] = {phase: partial(self._call, phase) for phase in get_args(Phase)}
        world.space.on_collision(**callbacks)

    def step(self, time: float) -> float:
        """Make a step of the world that ends at `time`; returns the seconds of the engine."""
        self._time = time
        before = len(self.events)
        self.begun.clear()
        begin = perf_counter()
        self.in_engine = True
        try:
            with callbacks_raise():
                self._world.space.step(self._world.substep)
        finally:
            self.in_engine = False
        seconds = perf_counter() - begin

        if self._on_event is not None:
            for event in self.events[before:]:
                self._on_event(event)
        return seconds

    def _call(self, phase: Phase, arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        # A space that is taken apart reports a last `separate` of everything that still touches.
        if self.in_engine:
            self._log(phase, arbiter)

    def _log(self, phase: Phase, arbiter: pymunk.Arbiter) -> None:
        first, second = (self._benches[shape] for shape in arbiter.shapes)
        swapped = first > second
        benches = (second, first) if swapped else (first, second)
        known = benches in self._touching

        if phase == "separate":
            # The end of a false contact is no event.
            self._touching.discard(benches)
            self._earlier.pop(benches, None)
            if known:
                self.events.append(ContactEvent(time=self._time, phase=phase, benches=benches))
            return

        points, normal, depth = _manifold(arbiter.contact_point_set, swapped)
        false = (not known or depth > self._narrowest) and self._apart(benches)
        if phase != "post_solve":
            arbiter.process_collision = not (false or self._world.settings.contacts == "report")
        if false:
            return

        impulse = None
        if phase == "pre_solve":
            self._earlier[benches] = arbiter.total_impulse
        elif phase == "post_solve":
            earlier = self._earlier.get(benches, pymunk.Vec2d.zero())
            impulse = _signed(impulse_of(arbiter, earlier, 1.0), not swapped)

        x, y = (math.fsum(each) / len(each) for each in zip(*points, strict=True))
        of_first, of_second = (
            self._world.bodies[bench].velocity_at_world_point((x, y)) for bench in (first, second)
        )
        event = ContactEvent(
            time=self._time,
            phase=phase,
            benches=benches,
            points=points,
            normal=normal,
            depth=depth,
            relative_velocity=_signed(of_second - of_first, swapped),
            impulse=impulse,
        )

        if not known:
            # A contact that was false when it began may become true in any phase.
            self._touching.add(benches)
            contact = Contact(
                time=self._time,
                raw_time=self._time,
                benches=benches,
                point=points[0],
                normal=normal,
                depth=depth,
            )
            self.begun.append(contact)
            if phase != "begin":
                self.events.append(replace(event, phase="begin"))
        self.events.append(event)

    def _apart(self, benches: tuple[int, int]) -> bool:
        """Whether two benches are apart."""
        outlines = []
        for bench in benches:
            body = self._world.bodies[bench]
            corners = self._world.shapes[bench].get_vertices()
            outlines.append(list(map(body.local_to_world, corners)))
        # Pages begin sooner without the search for contacts.
        from pymunk_dragon.collision.sat import separation

        return bool(separation(*outlines).distance > 0)


def _manifold(
    contact: pymunk.ContactPointSet, swapped: bool
) -> tuple[tuple[_Vector, ...], _Vector, float]:
    """Contact points, the deepest first, normal from the lower to the higher bench, and depth."""
    ordered = sorted(contact.points, key=lambda point: point.distance)
    points = []
    for point in ordered:
        x, y = (point.point_a + point.point_b) / 2
        points.append((x, y))
    return tuple(points), _signed(contact.normal, swapped), -ordered[0].distance


def _signed(vector: pymunk.Vec2d, swapped: bool) -> _Vector:
    return (-vector.x, -vector.y) if swapped else (vector.x, vector.y)
