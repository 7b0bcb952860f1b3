"""Collision callbacks: all four phases, logged as they come, and no exception lost."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Literal

import pymunk

from pymunk_dragon._signals import signals_held
from pymunk_dragon.model.contact import ContactEvent, Phase

__all__ = ["Contacts", "Recorder", "manifold"]

# What to do about contacts: end the run, play on and record, or let the engine push the benches apart.
Contacts = Literal["stop", "report", "resolve"]

Vector = tuple[float, float]


class Recorder:
    """Logs every collision callback of a space as a `ContactEvent`.

    Pymunk calls back from C, where an exception would be printed and forgotten: it is kept here, and `stepping`
    raises it once the step is over.

    Parameters
    ----------
    space : pymunk.Space
        Whose collisions are logged.
    bodies, shapes : list of pymunk.Body and of pymunk.Poly
        The benches', in their order.
    resolve : bool
        Whether the engine may act on contacts; otherwise they are reports only, and `post_solve` never comes.
    on_event : callable, optional
        Called with each event.
    """

    def __init__(
        self,
        space: pymunk.Space,
        bodies: list[pymunk.Body],
        shapes: list[pymunk.Poly],
        *,
        resolve: bool,
        on_event: Callable[[ContactEvent], None] | None = None,
    ) -> None:
        self.time = 0.0
        self.events: list[ContactEvent] = []
        self.begun: list[tuple[int, int]] = []
        self._benches: dict[pymunk.Shape, tuple[int, pymunk.Body]] = {
            shape: (bench, body) for bench, (shape, body) in enumerate(zip(shapes, bodies, strict=True))
        }
        self._resolve = resolve
        self._on_event = on_event
        self._failure: BaseException | None = None
        self._closed = self._stepping = self._logging = False
        self._release: Callable[[], None] = lambda: None
        space.on_collision(
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
        """Have handlers of signals that come during the steps in here wait for the end of the step.

        Python runs them when C calls back, before the first line of a callback: what they raise there is lost.
        """
        with signals_held(lambda: self._stepping and not self._logging) as release:
            self._release = release
            yield

    @contextmanager
    def stepping(self) -> Iterator[None]:
        """Step the space in here; what waited, or was raised inside a callback, is raised at the end."""
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
        if phase != "separate" and not self._resolve:
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
        points, normal, depth = manifold(arbiter.contact_point_set, swapped)
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


def manifold(contact: pymunk.ContactPointSet, swapped: bool) -> tuple[tuple[Vector, ...], Vector, float]:
    """Contact points (m, the deepest first), normal from the lower to the higher bench, and depth (m)."""
    ordered = sorted(contact.points, key=lambda point: point.distance)
    middles = [(point.point_a + point.point_b) / 2 for point in ordered]
    points = tuple((float(middle.x), float(middle.y)) for middle in middles)
    return points, _signed(contact.normal, swapped), float(-ordered[0].distance)


def _signed(vector: pymunk.Vec2d, swapped: bool) -> Vector:
    return (-vector.x, -vector.y) if swapped else (vector.x, vector.y)
