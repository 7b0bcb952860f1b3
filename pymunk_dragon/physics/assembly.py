"""What a world holds: the dragon as Pymunk bodies, shapes and joints, and the engine's settings."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import chain, pairwise
from typing import Any

import pymunk

from pymunk_dragon._checks import finite, instance, instances, whole, word
from pymunk_dragon.model.march import March, check_march, checked_times
from pymunk_dragon.model.settings import EngineSettings
from pymunk_dragon.model.speed import MAX_TIME
from pymunk_dragon.physics.dancers import Dancers
from pymunk_dragon.physics.guide import NoGuide, PathGuide
from pymunk_dragon.physics.rails import Rails
from pymunk_dragon.physics.substep import next_length

# Guides that have a name, as in `simulate(guide=...)`.
GUIDES: dict[str, type[PathGuide]] = {"rails": Rails, "none": NoGuide}

# Coefficient of friction of wood on wood; it matters only where contacts are resolved.
_FRICTION = 0.4


def top_speed(march: March, start: float, until: float | None) -> float:
    """Highest speed of the head between two times, s, or until the end of the curve, m/s."""
    end = march.end if until is None else min(until, march.end)
    return march.speed_profile.fastest(start, max(start, end))


class Assembly:
    """A space with the benches of a dragon, which are at no pose yet; `World` explains the rest.

    The head is kinematic, or pulled by a motor of finite force.
    """

    def __init__(
        self,
        march: March,
        guide: str | PathGuide,
        settings: EngineSettings | None,
        start: float,
        until: float | None,
        **changes: Any,
    ) -> None:
        check_march(march)
        settings = EngineSettings() if settings is None else settings
        instance("settings", settings, EngineSettings, "an EngineSettings")
        self.start = finite("start", start, -MAX_TIME, MAX_TIME, "s")
        if until is not None:
            checked_times(march, start, until)

        self.march = march
        self.guide = _guide_of(guide)
        _check_free_from(self.guide, march)
        self.top_speed = top_speed(march, self.start, until)
        dragon = march.dragon
        self.masses = dragon.masses
        self.moments = dragon.moments

        self.space = pymunk.Space()
        # A contact is reported when the benches touch, not when they are a tenth of a metre deep.
        self.space.collision_slop = 0.0
        self._motors: tuple[pymunk.Constraint, ...] = ()
        self.pivots: list[pymunk.PivotJoint] = []
        self._dancers = Dancers(self.guide, self.space, self.pivots, dragon, self.top_speed)

        # In this order: a guide reads the settings when it is attached, and its anchors and joints
        # exist from then on.
        self._given = settings
        self.change(**changes)
        self.guide.attach(self)
        self.guide.relocate(march.at(self.start))
        _check_parts(self.guide, "anchors", self.guide.anchors, pymunk.Body)
        self._add_bodies()
        self._join()

    def change(self, **changes: Any) -> None:
        """Change `substep`, gradually, `iterations` or `drag` from the next step on.

        The default head force follows from the drag that the head balances now.
        """
        self._given = replace(self._given, **changes)
        pulled = self._dancers.pulled_mass()
        self.settings = self._given.resolved(
            top_speed=self.top_speed, pulled_mass=pulled, holds_all=self.guide.free_from is None
        )
        assert self.settings.iterations is not None  # Set by `resolved`.
        self._choose_substep()
        self.space.iterations = self.settings.iterations
        self.drag_rate = self.settings.drag * self.top_speed
        self.space.damping = math.exp(-self.drag_rate)
        if self._motors:
            pull, turn = self._motors
            pull.max_force = self.settings.head_force or 0.0
            # The torque is the force at half the length of the head.
            turn.max_force = float(self.march.dragon.lengths[0]) / 2 * pull.max_force

    def _choose_substep(self) -> None:
        """Set the length of the next step, which approaches that of the settings."""
        assert self.settings.substep is not None  # Set by `resolved`.
        self.substep = next_length(self.space.current_time_step, self.settings.substep)

    def _add_bodies(self) -> None:
        """Add the bodies: the head is the control body, or has motors of finite force to it."""
        self.bodies = list(map(pymunk.Body, self.masses.tolist(), self.moments.tolist()))
        # A kinematic body that has the exact poses of the head.
        self._control = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        if self.settings.head_force is None:
            self.bodies[0] = self._control
            self.space.add(*self.bodies)
        else:
            head = self.bodies[0]
            self.space.add(*self.bodies, self._control)
            pull = pymunk.PivotJoint(self._control, head, (0.0, 0.0), (0.0, 0.0))
            turn = pymunk.GearJoint(self._control, head, 0.0, 1.0)
            self._motors = pull, turn
            self.change()
            self._add_joints(*self._motors)

    def _join(self) -> None:
        """Add the pivots and the guide's joints; the package's docstring explains their order."""
        half = self.march.dragon.spacings / 2
        guiding = self._dancers.joints
        for bench, (before, body) in enumerate(pairwise(self.bodies), start=1):
            rear = (-half[bench - 1], 0.0)
            front = (half[bench], 0.0)
            pivot = pymunk.PivotJoint(before, body, rear, front)
            pivot.collide_bodies = False
            self.pivots.append(pivot)

            joints = self.guide.joints(bench, body)
            _check_parts(self.guide, "joints", joints, pymunk.Constraint)
            guiding.append(joints)

        if self.settings.contacts == "resolve":
            pairs = zip(self.pivots, guiding, strict=True)
            self._add_joints(*chain.from_iterable((pivot, *joints) for pivot, joints in pairs))
        else:
            self._add_joints(*self.pivots, *chain.from_iterable(guiding))

    def _add_joints(self, *joints: pymunk.Constraint) -> None:
        """Add joints, which correct errors at a rate per metre marched.

        The drag has such a rate too, so that a faster march has the same poses.
        """
        for joint in joints:
            joint.error_bias **= self.top_speed
        self.space.add(*joints)

    def _add_shapes(self) -> None:
        """Add the benches' rectangles."""
        dragon = self.march.dragon
        sizes = zip(self.bodies, dragon.lengths.tolist(), dragon.widths.tolist(), strict=True)
        self.shapes = [pymunk.Poly.create_box(body, (long, wide)) for body, long, wide in sizes]
        for shape in self.shapes:
            shape.friction = _FRICTION
        self.space.add(*self.shapes)

    @property
    def free_from(self) -> int | None:
        """First of the benches that nothing holds on the path; None if all are held."""
        return self._dancers.free_from

    @property
    def returning(self) -> bool:
        """Whether dancers carry benches back."""
        return self._dancers.returning

    def hold(self) -> None:
        """Have the dancers carry the free benches, over all others, to their exact positions."""
        self._dancers.hold(self.bodies)
        self.change()

    def cut(self, joint: int) -> None:
        """Cut the joint between the benches `joint` and `joint` + 1.

        Dancers behind it no longer walk. The two benches still pass over each other: they overlap,
        and would be thrown apart.
        """
        joint = whole("joint", joint, 0, len(self.pivots) - 1)
        self._dancers.cut(joint, self.settings.drag)
        self.change()


def _guide_of(guide: str | PathGuide) -> PathGuide:
    """The guide, or a new one of the given name."""
    if isinstance(guide, PathGuide):
        return guide
    return GUIDES[word("guide", guide, GUIDES)]()


def _check_free_from(guide: PathGuide, march: March) -> None:
    """Raise a ParameterError if the `free_from` of a guide is no bench behind the head."""
    if guide.free_from is not None:
        name = f"{type(guide).__name__}.free_from"
        whole(name, guide.free_from, 1, march.dragon.benches - 1)


def _check_parts(guide: PathGuide, member: str, value: object, kind: type) -> None:
    """Raise a ParameterError if a guide's `member` is no list or tuple of objects of the `kind`."""
    name = f"{type(guide).__name__}.{member}"
    instances(name, value, kind, f"a list or tuple of pymunk.{kind.__name__}")
