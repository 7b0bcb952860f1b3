"""Contacts as Pymunk reports them: a log of all collision callbacks, and the time within a substep of the first one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import pymunk

from pymunk_dragon._arrays import Array
from pymunk_dragon._signals import signals_held
from pymunk_dragon.model.contact import Contact, ContactEvent, Phase
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.physics.world import World, bench_shape

Vector = tuple[float, float]

# Halvings of a substep: a hundredth of a second becomes 1e-11 s, far below what the engine's poses are worth.
BISECTIONS = 30


class Recorder:
    """Log of every collision callback of a world's space, as `ContactEvent`.

    Pymunk calls back from C, where an exception would be printed and forgotten: it is kept here, and raised at
    the end of `stepping`. Where contacts are only reported, the engine does not act on them, and
    `post_solve` never comes.

    Parameters
    ----------
    world : World
        The world whose collisions are logged.
    on_event : callable, optional
        Called with each event.

    Attributes
    ----------
    time : float
        Time of the next events, s.
    events : list of ContactEvent
        All events.
    begun : list of tuple of int
        Pairs of benches whose contact began since this list was cleared.
    """

    def __init__(self, world: World, on_event: Callable[[ContactEvent], None] | None = None) -> None:
        self.time = 0.0
        self.events: list[ContactEvent] = []
        self.begun: list[tuple[int, int]] = []
        self._benches: dict[pymunk.Shape, tuple[int, pymunk.Body]] = {
            shape: (bench, body) for bench, (shape, body) in enumerate(zip(world.shapes, world.bodies, strict=True))
        }
        self._report_only = world.settings.contacts == "report"
        self._on_event = on_event
        self._failure: BaseException | None = None
        self._closed = self._stepping = self._logging = False
        self._release: Callable[[], None] = lambda: None
        world.space.on_collision(
            begin=self._callback("begin"),
            pre_solve=self._callback("pre_solve"),
            post_solve=self._callback("post_solve"),
            separate=self._callback("separate"),
        )

    def close(self) -> None:
        """Stop logging: a space that is taken apart reports a last `separate` of everything that still touches."""
        self._closed = True

    @contextmanager
    def signals_held(self) -> Iterator[None]:
        """Context of all steps, in which handlers of signals that come during a step wait for its end.

        Python runs them when C calls back, before the first line of a callback: what they raise there is lost.
        """
        with signals_held(lambda: self._stepping and not self._logging) as release:
            self._release = release
            yield

    @contextmanager
    def stepping(self) -> Iterator[None]:
        """Context of one step; signals that waited and exceptions of callbacks are raised at its end."""
        self._stepping = True
        try:
            yield
        finally:
            self._stepping = False
        self._release()
        if self._failure is not None:
            failure, self._failure = self._failure, None
            raise failure

    def _callback(self, phase: Phase) -> Callable[[pymunk.Arbiter, pymunk.Space, Any], None]:
        def callback(arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
            if self._closed or self._failure is not None:
                return
            try:
                self._logging = True
                self._log(phase, arbiter)
            except BaseException as failure:  # Ctrl-C too arrives here, and must not be lost either.
                self._failure = failure
            finally:
                self._logging = False

        return callback

    def _log(self, phase: Phase, arbiter: pymunk.Arbiter) -> None:
        if phase != "separate" and self._report_only:
            arbiter.process_collision = False
        event = self._event(phase, arbiter)
        if phase == "begin":
            self.begun.append(event.benches)
        self.events.append(event)
        if self._on_event is not None:
            self._on_event(event)

    def _event(self, phase: Phase, arbiter: pymunk.Arbiter) -> ContactEvent:
        (first, first_body), (second, second_body) = (self._benches[shape] for shape in arbiter.shapes)
        swapped = first > second
        benches = (second, first) if swapped else (first, second)
        if phase == "separate":
            return ContactEvent(time=self.time, phase=phase, benches=benches)
        points, normal, depth = _manifold(arbiter.contact_point_set, swapped)
        x = sum(point[0] for point in points) / len(points)
        y = sum(point[1] for point in points) / len(points)
        relative = second_body.velocity_at_world_point((x, y)) - first_body.velocity_at_world_point((x, y))
        # total_impulse is what the arbiter's first shape received.
        impulse = _signed(arbiter.total_impulse, not swapped) if phase == "post_solve" else None
        return ContactEvent(
            time=self.time,
            phase=phase,
            benches=benches,
            points=points,
            normal=normal,
            depth=depth,
            relative_velocity=_signed(relative, swapped),
            impulse=impulse,
        )


class Motion(NamedTuple):
    """Poses of benches within a substep, with even acceleration: before + share * first + share**2 * second."""

    before: Array
    first: Array
    second: Array

    def poses(self, share: float) -> Array:
        """Poses (N, 3) after a `share` of the substep, m, m, rad."""
        return self.before + share * (self.first + share * self.second)

    def rates(self, share: float) -> Array:
        """Their rates of change by the share."""
        return self.first + 2 * share * self.second


def refined_contact(dragon: Dragon, benches: tuple[int, int], motion: Motion, times: tuple[float, float]) -> Contact:
    """Contact of two benches that touch at the end of a substep, at the time within it when they began to.

    Pymunk's own shape test tells whether they touch in between.

    Parameters
    ----------
    dragon : Dragon
        The dragon of the two benches.
    benches : tuple of int
        The two, the smaller number first.
    motion : Motion
        Motion of all benches in the substep.
    times : tuple of float
        Times at its ends, s.

    Returns
    -------
    Contact
        At the start of the substep if they touched there already.
    """
    pair = list(benches)
    # Shape.shapes_collide fails an assertion of its own where shapes are apart (Pymunk 7.3.1); a query does not.
    space = pymunk.Space()
    bodies = [pymunk.Body(body_type=pymunk.Body.KINEMATIC) for _ in pair]
    sizes = dragon.lengths[pair].tolist(), dragon.widths[pair].tolist()
    first, second = (bench_shape(body, *size) for body, size in zip(bodies, zip(*sizes, strict=True), strict=True))
    space.add(bodies[1], second)

    def touch(share: float) -> pymunk.ContactPointSet | None:
        for body, (x, y, angle) in zip(bodies, motion.poses(share)[pair].tolist(), strict=True):
            body.position = x, y
            body.angle = angle
        space.reindex_shapes_for_body(bodies[1])
        found = space.shape_query(first)
        return found[0].contact_point_set if found else None

    at_end = touch(1.0)
    assert at_end is not None, "the engine saw these shapes touch at these poses"
    apart, touching, at_touch = 0.0, 1.0, at_end
    if contact := touch(apart):
        touching, at_touch = apart, contact
    for _ in range(BISECTIONS):
        middle = (apart + touching) / 2
        if contact := touch(middle):
            touching, at_touch = middle, contact
        else:
            apart = middle
    points, normal, _ = _manifold(at_touch, swapped=False)
    *_, depth = _manifold(at_end, swapped=False)
    return Contact(
        time=times[0] + touching * (times[1] - times[0]),
        raw_time=times[1],
        benches=benches,
        point=points[0],
        normal=normal,
        depth=depth,
    )


def _manifold(contact: pymunk.ContactPointSet, swapped: bool) -> tuple[tuple[Vector, ...], Vector, float]:
    """Contact points (m, the deepest first), normal from the lower to the higher bench, and depth (m)."""
    ordered = sorted(contact.points, key=lambda point: point.distance)
    middles = [(point.point_a + point.point_b) / 2 for point in ordered]
    points = tuple((float(middle.x), float(middle.y)) for middle in middles)
    return points, _signed(contact.normal, swapped), float(-ordered[0].distance)


def _signed(vector: pymunk.Vec2d, swapped: bool) -> Vector:
    return (-vector.x, -vector.y) if swapped else (vector.x, vector.y)
