"""The dragon as Pymunk bodies, shapes and joints, with a head that is kinematic or pulled by a motor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain, pairwise
from typing import Any

import numpy as np
import pymunk
from pymunk import batch
from pymunk.batch import BodyFields

from pymunk_dragon._arguments import Array, finite, flag, instance, whole, word
from pymunk_dragon.errors import ParameterError, UnreachableError
from pymunk_dragon.model.march import March, States, check_march
from pymunk_dragon.model.settings import EngineSettings
from pymunk_dragon.physics.guides import GUIDES, PathGuide
from pymunk_dragon.physics.readings import JointForces
from pymunk_dragon.physics.substep import next_length
from pymunk_dragon.physics.warm_start import set_impulses

# kg per square metre: planks of pine, 4 cm thick. It is the same for all benches, so it only scales impulses.
_AREA_DENSITY = 20.0
# Friction of wood on wood; it matters only where contacts are resolved.
_FRICTION = 0.4
# Times further than this from any march, s, lose their milliseconds to rounding.
_MAX_TIME = 1e9

# Where dancers have let go: speed at which those who come back carry a bench, over the head's top speed, the rate at
# which they approach, per metre, and the position error at which a bench is back, in widths.
_RETURN_SPEED, _RETURN_RATE, _RETURNED = 4.0, 20.0, 0.1
# 1/s: rate at which the time of a march that stands goes to where the head is.
_RECOVERING = 5.0
# Then the largest force on a bench, over the ground drag on it at the head's top speed, and torque at 1 m.
_MAX_GUIDE_FORCE = 20.0

# Factor on the speed of the march, and per metre: more is taken for a typing error.
_MAX_SPEEDUP, _MAX_BRAKING = 1e3, 1e6

# Fields of all bodies that are read after a step or written before it; combined here, as that takes microseconds.
_POSES = BodyFields.POSITION | BodyFields.ANGLE
_VELOCITIES = BodyFields.VELOCITY | BodyFields.ANGULAR_VELOCITY
_POSES_AND_FORCES = _POSES | BodyFields.FORCE | BodyFields.TORQUE


def top_speed(march: March, start: float, until: float | None) -> float:
    """Highest speed of the head between two times, s, or until it reaches the end of the curve, m/s."""
    end = march.end
    return march.speed_profile.fastest(start, max(start, end if until is None else min(until, end)))


class World:
    """A Pymunk space with a dragon at `start` on its march; its state is read and written for all bodies at once.

    Each step is `prepare` or `follow`, ``space.step(world.substep)``, `read`. Between two steps settings may change,
    and where contacts are resolved, dancers may let go and come back, and joints may be cut.

    Parameters
    ----------
    march : March
        The motion to play. Only its state at `start` is used here, later only the head's.
    guide, settings, **changes
        As in `simulate`. With contacts other than "resolve" the head is a kinematic body, which has its exact poses
        whatever it touches; otherwise a motor pulls it towards them.
    start, until : float
        Times of the first state and of the last step, s, by default at the end of the curve. The rates of drag and
        joint correction are proportional to the highest speed of the head between them.

    Attributes
    ----------
    settings : EngineSettings
        The settings with numbers where defaults depend on the march.
    substep, drag_rate, top_speed : float
        Length of the next step, s, rate at which the ground drag reduces velocities, 1/s, highest speed of the head,
        m/s. After a change of its setting, the length of a step approaches the new one by 1 % a step.
    space, bodies, shapes, pivots
        The space, and lists of the benches' bodies, shapes and pivots. Pivot i joins benches i and i + 1.
    masses, moments : ndarray, shape (N,)
        Masses of the benches, kg, and their moments of inertia about their centres, kg m^2.
    poses, velocities, collided_poses : ndarray, shape (N, 3)
        State of the benches after the last step, and poses at which the space found contacts and solved the joints in
        it: m, m, rad and per s.
    time, share : float
        Time, s, of a march that `follow` plays, and the share of its speed that it has.
    free_from : int or None
        First bench whose dancers have let go, as have those of all behind it.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March
    >>> march = March(Dragon(benches=4))
    >>> world = World(march, until=10.0)
    >>> world.prepare(march.at(world.substep, handles=2))
    >>> world.space.step(world.substep)
    >>> world.read()
    >>> bool(abs(world.poses - march.at(world.substep).poses[0]).max() < 1e-5)
    True
    """

    def __init__(
        self,
        march: March,
        guide: str | PathGuide = "rails",
        settings: EngineSettings | None = None,
        *,
        start: float = 0.0,
        until: float | None = None,
        **changes: Any,
    ) -> None:
        check_march(march)
        settings = EngineSettings() if settings is None else settings
        instance("settings", settings, EngineSettings, "an EngineSettings")
        start = finite("start", start, -_MAX_TIME, _MAX_TIME, "s")
        if until is not None and finite("until", until, -_MAX_TIME, _MAX_TIME, "s") <= start:
            raise ParameterError("until", until, f"later than the start, {start:g} s")
        self.march, self.start, self.time, self.share = march, start, start, 1.0
        self.guide = guide if isinstance(guide, PathGuide) else GUIDES[word("guide", guide, GUIDES)]()
        self.top_speed = top_speed(march, start, until)
        dragon = march.dragon
        self.masses = _AREA_DENSITY * dragon.lengths * dragon.widths
        sizes = list(zip(dragon.lengths.tolist(), dragon.widths.tolist(), strict=True))
        moments = [pymunk.moment_for_box(mass, size) for mass, size in zip(self.masses, sizes, strict=True)]
        self.moments = np.array(moments)
        self.free_from: int | None = None
        self._return_joints: list[pymunk.PivotJoint] = []
        # First bench that the guide does not push, and the largest forces and torques of the guide.
        self._unpushed, self._limits = dragon.benches, np.full((dragon.benches, 1), np.inf)
        self.space = pymunk.Space()
        self._forces = JointForces(self.space)
        # A contact is reported when the benches touch, not when they are a tenth of a metre deep.
        self.space.collision_slop = 0.0
        self._motors: tuple[pymunk.Constraint, ...] = ()
        self._given = settings
        self.change(**changes)
        state = march.at(start)
        self.guide.attach(self)
        self.guide.relocate(state)
        self._add_bodies()
        self._join()
        self._open_buffers()
        self._warm_start(state)
        self.shapes = [pymunk.Poly.create_box(body, size) for body, size in zip(self.bodies, sizes, strict=True)]
        for shape in self.shapes:
            shape.friction = _FRICTION
        self.space.add(*self.shapes)

    @property
    def joint_forces(self) -> Array:
        """Mean force (N - 1,) in each pivot during the last step, N; see `JointForces`."""
        return self._forces.sizes(self.pivots)

    def change(self, **changes: Any) -> None:
        """Change `substep`, `iterations` or `drag` of the settings from the next step on, `substep` gradually."""
        self._given = replace(self._given, **changes)
        self._apply_settings()

    def _apply_settings(self) -> None:
        """Use the given settings from the next step on, with a head force for the drag that the head balances now."""
        pulled = self.masses
        if self.guide.balances_drag and not self.returning:
            pulled = np.append(pulled[:1], pulled[self.free_from or len(pulled) :])
        self.settings = self._given.resolved(top_speed=self.top_speed, pulled_mass=math.fsum(pulled))
        assert self.settings.substep is not None  # Set by `resolved`.
        assert self.settings.iterations is not None  # Set by `resolved`.
        self.substep = next_length(self.space.current_time_step, self.settings.substep)
        self.space.iterations = self.settings.iterations
        self.drag_rate = self.settings.drag * self.top_speed
        self.space.damping = math.exp(-self.drag_rate)
        # The motors turn the head with half its length times this force.
        for motor, arm in zip(self._motors, (1.0, float(self.march.dragon.lengths[0]) / 2), strict=False):
            motor.max_force = arm * (self.settings.head_force or 0.0)

    def _add_bodies(self) -> None:
        """Add the bodies: the head is the control body itself, or has motors of finite force to it."""
        pairs = zip(self.masses.tolist(), self.moments.tolist(), strict=True)
        self.bodies = [pymunk.Body(mass, moment) for mass, moment in pairs]
        # A kinematic body that has the exact poses of the head.
        self._control = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        if self.settings.head_force is None:
            self.bodies[0] = self._control
            self.space.add(*self.bodies)
        else:
            self.space.add(*self.bodies, self._control)
            self._motors = (
                pymunk.PivotJoint(self._control, self.bodies[0], (0.0, 0.0), (0.0, 0.0)),
                pymunk.GearJoint(self._control, self.bodies[0], 0.0, 1.0),
            )
            self._apply_settings()
            self._add_joints(*self._motors)
        # A step takes time for every body of its space, and anchors need no steps: theirs is never stepped.
        self._anchor_space = pymunk.Space()
        _check_parts(self.guide, "anchors", self.guide.anchors, pymunk.Body)
        self._anchor_space.add(*self.guide.anchors)

    def _join(self) -> None:
        """Add the pivots and the guide's joints, in the order for the solver that the package's docstring explains."""
        half = self.march.dragon.spacings / 2
        self.pivots: list[pymunk.PivotJoint] = []
        self._guiding: list[Sequence[pymunk.Constraint]] = []
        for bench, (before, body) in enumerate(pairwise(self.bodies), start=1):
            pivot = pymunk.PivotJoint(before, body, (-half[bench - 1], 0.0), (half[bench], 0.0))
            pivot.collide_bodies = False
            self.pivots.append(pivot)
            self._guiding.append(self.guide.joints(bench, body))
            _check_parts(self.guide, "joints", self._guiding[-1], pymunk.Constraint)
        if self.settings.contacts == "resolve":
            pairs = zip(self.pivots, self._guiding, strict=True)
            self._add_joints(*chain.from_iterable((pivot, *joints) for pivot, joints in pairs))
        else:
            self._add_joints(*self.pivots, *chain.from_iterable(self._guiding))

    def _add_joints(self, *joints: pymunk.Constraint) -> None:
        """Add joints that correct errors at a rate per metre marched, as the drag: a faster march is the same march."""
        for joint in joints:
            joint.error_bias **= self.top_speed
        self.space.add(*joints)

    def _open_buffers(self) -> None:
        """Lay NumPy arrays over the memory that `pymunk.batch` reads and writes."""
        # Pymunk adds its static body when it is first used, as for an obstacle; a row is written for each body.
        moved = list(dict.fromkeys([*self.bodies, self._control, self.space.static_body]))
        for space, bodies in ((self.space, moved), (self._anchor_space, self.guide.anchors)):
            ids = batch.Buffer()
            batch.get_space_bodies(space, BodyFields.BODY_ID, ids)
            if list(memoryview(ids.int_buf()).cast("P")) != [body.id for body in bodies]:
                raise RuntimeError("pymunk.batch lists the bodies in another order than they were added")
        self._inbox, self._outbox, self._anchor_outbox = (batch.Buffer() for _ in range(3))
        out = np.zeros((len(moved), 6))
        self._outbox.set_float_buf(out)
        self._out_poses, self._out_forces = out[: len(self.bodies), :3], out[: len(self.bodies), 3:]
        self._out_control = out[moved.index(self._control), :3]
        self._out_anchors = np.zeros((len(self.guide.anchors), 2))
        self._anchor_outbox.set_float_buf(self._out_anchors)
        # The shift is half a step times the change of velocity in the last step.
        self.poses, self.velocities, self.collided_poses, self._shift = np.zeros((4, len(self.bodies), 3))

    def read(self) -> None:
        """Take `poses` and `velocities` from the space."""
        self.collided_poses, velocities = self._read(_POSES), self._read(_VELOCITIES)
        before = self._shift
        self._shift = self.substep / 2 * (velocities - self.velocities)
        self.poses, self.velocities = self.collided_poses, velocities
        if self.settings.contacts != "resolve":
            correction = self._shift - before
            # The head has its exact pose.
            correction[0] = 0.0
            self.poses = self.collided_poses + correction
        assert self.settings.substep is not None  # Set by `resolved`.
        self.substep = next_length(self.space.current_time_step, self.settings.substep)

    def _read(self, fields: BodyFields) -> Array:
        """Three fields of the benches (N, 3). NumPy is slow on parts of rows, so more of them are read separately."""
        self._inbox.clear()
        batch.get_space_bodies(self.space, fields, self._inbox)
        return np.frombuffer(self._inbox.float_buf(), count=3 * len(self.bodies)).reshape(-1, 3).copy()

    def prepare(self, states: States, row: int = 0, share: float = 1.0) -> None:
        """Make the next step end with the head in the state at time number `row` of `states`.

        Its velocities apply by a `share`, for a march that waits. Pymunk will first move every body by its velocity and
        then solve the joints, so the poses given to it lie one such move before the ones at which the joints shall
        hold.
        """
        instance("states", states, States, "the States of a march")
        row = whole("row", row, 0, len(states.times) - 1)
        share = finite("share", share, 0.0, _MAX_SPEEDUP, "")
        given = self.poses + self._shift
        self._out_poses[:] = given
        self._send(given + self.substep * self.velocities, states, row, share)

    def follow(self, lag: float, braking: float, speed: float = 1.0, *, recovers: bool = False) -> bool:
        """Prepare a step of a march that waits while the head cannot follow; whether the curve goes on so far.

        Where the head is `lag` widths off, the march loses a share `braking` of its speed in a metre at full speed, and
        regains it ten times more slowly. `speed` is a factor, and `recovers` whether one that stands goes to the head.
        """
        lag = finite("lag", lag, 0.0, math.inf, "widths")
        braking = finite("braking", braking, 0.0, _MAX_BRAKING, "per metre")
        speed = finite("speed", speed, 0.0, _MAX_SPEEDUP, "")
        recovers = flag("recovers", recovers)
        distance = self._control.position.get_distance(self.bodies[0].position) / self.march.dragon.widths.min()
        change = -braking if distance > lag else braking / 10
        self.share = min(max(self.share + change * self.top_speed * self.substep, 0.0), 1.0)
        share, goes_on = self.share * speed, True
        try:
            states = self.march.at(self.time + share * self.substep, handles=2)
            self.time += share * self.substep
        except UnreachableError:
            states, share, goes_on = self.march.at(self.time, handles=2), 0.0, False
        if share == 0 and recovers:
            # A motor alone would push a long chain back along its path for minutes.
            x, y, angle = states.poses[0, 0].tolist()
            ahead = (self.bodies[0].position - (x, y)).dot(pymunk.Vec2d.from_polar(1, angle)) / self.top_speed
            self.time = min(max(self.time + _RECOVERING * self.substep * ahead, self.start), self.march.end)
        if self._return_joints:
            self._carry(self.march.at(self.time), share)
        self.prepare(states, share=share)
        return goes_on

    def _send(self, coming: Array, states: States, row: int, share: float) -> None:
        """Write the head's pose, and anchors and forces for benches that get the poses `coming`, to the spaces."""
        forces = self._out_forces
        self.guide.update(coming, share * states.velocities[row, 1], self._out_anchors, forces)
        if np.isfinite(self._limits[0, 0]):
            forces[self._unpushed :] = 0.0
            # A bench that comes back across the path would get forces without limit.
            np.clip(np.nan_to_num(forces), -self._limits, self._limits, out=forces)
        velocity = share * states.pose_velocities[row, 0]
        self._out_control[:] = states.poses[row, 0] - self.substep * velocity
        if self._control is not self.bodies[0]:
            # A gear joint counts whole turns: the control body's are those of the head.
            turns = (self._out_control[2] - self._out_poses[0, 2]) / (2 * math.pi)
            self._out_control[2] -= 2 * math.pi * round(turns)
        self._write(velocity)

    def _write(self, head_velocity: Array) -> None:
        """Write what `_send` has found to the spaces, and read what the step overwrites."""
        self._forces.before_step(self.substep)
        batch.set_space_bodies(self.space, _POSES_AND_FORCES, self._outbox)
        batch.set_space_bodies(self._anchor_space, BodyFields.POSITION, self._anchor_outbox)
        _set_velocities([self._control], head_velocity[None])

    def _warm_start(self, state: States) -> None:
        """Set the benches to the exact `state` at the start, and the joints' impulses to those in balance there.

        Sweeps of the solver then find the impulses of joints that are not pivots or pins, and those of motors.
        """
        poses, velocities = state.poses[0], state.pose_velocities[0]
        try:
            earlier = self.march.at(self.start - self.substep)
        except UnreachableError:
            # The last hole is at the curve's begin.
            earlier = state
        before = earlier.pose_velocities[0]
        # The guide balances the change from one step to the next: it is updated for the earlier state first.
        self.guide.update(earlier.poses[0], earlier.velocities[0, 1], self._out_anchors, self._out_forces)
        self._out_poses[:] = poses - self.substep * before
        self._send(poses, state, 0, 1.0)
        inertia = np.array([self.masses, self.masses, self.moments]).T
        free = before * math.exp(-self.drag_rate * self.substep) + self.substep * self._out_forces / inertia
        free[0], inertia[0] = velocities[0], np.inf
        pins = [[joint for joint in joints if isinstance(joint, pymunk.PinJoint)] for joints in self._guiding]
        pairs = list(zip(self.pivots, pins, strict=True))
        set_impulses(self.space, self.substep, pairs, poses, free, 1 / inertia)
        _set_velocities(self.bodies, before)
        self._write(velocities[0])
        iterations, self.space.iterations = self.space.iterations, 2 * len(self.bodies)
        self.space.step(self.substep)
        self.space.iterations = iterations
        _set_velocities(self.bodies, velocities)
        self.velocities = before
        self.read()
        self.poses = poses

    # ---- dancers who let go and come back

    @property
    def returning(self) -> bool:
        """Whether dancers carry benches back."""
        return bool(self._return_joints)

    def release(self, bench: int) -> None:
        """Let the dancers of `bench`, from 1 on, and of all behind it go."""
        bench = whole("bench", bench, 1, len(self.pivots))
        self._stop_carrying()
        # Removed and added again, joints would be solved in another order, which converges more slowly.
        for joint in chain.from_iterable(self._guiding[bench - 1 :]):
            joint.max_force = 0.0
        self.free_from = bench if self.free_from is None else min(bench, self.free_from)
        self._limit_guide(self.free_from)

    def cut(self, joint: int) -> None:
        """Cut the joint between the benches `joint` and `joint` + 1; dancers behind it no longer walk.

        The benches still pass over each other there: they overlap, and would be thrown apart.
        """
        self.pivots[whole("joint", joint, 0, len(self.pivots) - 1)].max_force = 0.0
        self._limit_guide(joint + 1)

    def _limit_guide(self, unpushed: int) -> None:
        """Let the guide push no bench from `unpushed` on, and the others with limited forces."""
        self._unpushed = min(self._unpushed, unpushed)
        self._limits = _MAX_GUIDE_FORCE * self.masses[:, None] * self.settings.drag * self.top_speed**2
        self._apply_settings()

    def hold(self) -> None:
        """Have the dancers come back: they carry the free benches, over all others, to their exact positions."""
        if self.returning or self.free_from is None:
            return
        half = self.march.dragon.spacings / 2
        for bench, body in enumerate(self.bodies[self.free_from :], start=self.free_from):
            joint = pymunk.PivotJoint(self.space.static_body, body, body.position, (-half[bench], 0.0))
            joint.max_bias = _RETURN_SPEED * self.top_speed
            joint.error_bias = math.exp(-_RETURN_RATE * self.top_speed)
            joint.max_force = float(self._limits[bench, 0])
            self._return_joints.append(joint)
        self.space.add(*self._return_joints)
        self._apply_settings()

    def _carry(self, states: States, share: float) -> None:
        """Carry benches to their exact positions, from which dancers guide them again when all have arrived."""
        assert self.free_from is not None  # Benches return only if some were free.
        first = self.free_from + 1
        # A joint follows a moving target with a delay of this time, so its target is as far ahead: otherwise it would
        # brake the chain, whose tension would tear it apart when these joints are removed.
        ahead = self.substep / (1 - math.exp(-_RETURN_RATE * self.top_speed * self.substep))
        targets = states.positions[0, first:] + ahead * share * states.velocities[0, first:]
        for pivot, (x, y) in zip(self._return_joints, targets.tolist(), strict=True):
            pivot.anchor_a = x, y
        distances = np.hypot(*(self.poses[:, :2] - states.poses[0, :, :2]).T)
        if distances.max() < _RETURNED * self.march.dragon.widths.min():
            self._stop_carrying()
            self.guide.relocate(states)
            for joint in chain.from_iterable(self._guiding[self.free_from - 1 :]):
                joint.max_force = math.inf
            self.free_from = None
            cut = (joint + 1 for joint, pivot in enumerate(self.pivots) if pivot.max_force == 0)
            self._unpushed = next(cut, len(self.bodies))
            self._apply_settings()

    def _stop_carrying(self) -> None:
        self.space.remove(*self._return_joints)
        self._return_joints.clear()


def _set_velocities(bodies: Sequence[pymunk.Body], velocities: Array) -> None:
    for body, (vx, vy, spin) in zip(bodies, velocities.tolist(), strict=True):
        body.velocity = vx, vy
        body.angular_velocity = spin


def _check_parts(guide: PathGuide, member: str, value: object, kind: type) -> None:
    """Raise a ParameterError if `value` of a guide's `member` is no list or tuple of objects of the `kind`."""
    if not (isinstance(value, list | tuple) and all(isinstance(part, kind) for part in value)):
        raise ParameterError(f"{type(guide).__name__}.{member}", value, f"a list or tuple of pymunk.{kind.__name__}")
