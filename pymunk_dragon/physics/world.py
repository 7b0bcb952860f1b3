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

from pymunk_dragon._arrays import Array
from pymunk_dragon.errors import UnreachableError
from pymunk_dragon.model.march import March, States, check_march
from pymunk_dragon.model.settings import EngineSettings, check_settings
from pymunk_dragon.physics.guides import GuidedChain, PathGuide, guide_of, parts_of_guide
from pymunk_dragon.physics.warm_start import balanced_impulses, set_impulses

# kg per cubic metre: pine and fir. All benches are of one wood, so the value scales impulses and nothing else.
WOOD_DENSITY = 500.0
# m: a plank.
BENCH_THICKNESS = 0.04
# Friction of wood on wood; it matters only where contacts are resolved.
FRICTION = 0.4

# Where dancers have let go: speed at which those who come back carry a bench, over the head's top speed, the rate at
# which they approach, per metre, and the position error at which a bench is back, in widths.
RETURN_SPEED = 4.0
RETURN_RATE = 20.0
RETURNED = 0.1
# Then the largest force on a bench, over the ground drag on it at the head's top speed, and torque at 1 m.
MAX_GUIDE_FORCE = 20.0

# Fields of all bodies that are read after a step or written before it; combined here, as that takes microseconds.
POSES = BodyFields.POSITION | BodyFields.ANGLE
VELOCITIES = BodyFields.VELOCITY | BodyFields.ANGULAR_VELOCITY
POSES_AND_FORCES = POSES | BodyFields.FORCE | BodyFields.TORQUE


def top_speed(march: March, start: float, until: float | None) -> float:
    """Highest speed of the head between two times, s, or until it reaches the end of the curve, m/s."""
    end = march.end
    return float(march.speed_profile.fastest(start, max(start, end if until is None else min(until, end))))


def bench_shape(body: pymunk.Body, length: float, width: float) -> pymunk.Poly:
    """Rectangle of a bench about its centre, without rounding."""
    x, y = length / 2, width / 2
    return pymunk.Poly(body, [(-x, -y), (x, -y), (x, y), (-x, y)])


class World:
    """A Pymunk space with a dragon at `start` on its march; its state is read and written for all bodies at once.

    Each step is `prepare`, ``space.step(world.substep)``, `read`. Between two steps settings may change, and where
    contacts are resolved, dancers may let go and come back, and joints may be cut.

    Parameters
    ----------
    march : March
        The motion to play. Only its state at `start` is used here, later only the head's pose.
    guide : str or PathGuide
        As in `simulate`.
    settings : EngineSettings, optional
        As in `simulate`. With contacts other than "resolve" the head is a kinematic body, which has its exact poses
        whatever it touches; otherwise a motor pulls it towards them.
    start, until : float
        Times of the first state and of the last step, s: the rates of drag and joint correction are proportional to
        the highest speed of the head between them. Without `until`: to the end of the curve.

    Attributes
    ----------
    settings : EngineSettings
        The settings with numbers for `substep`, `iterations` and, where contacts are resolved, for `head_force`.
    substep : float
        Length of a step, s.
    top_speed : float
        Highest speed of the head, m/s.
    space : pymunk.Space
        The space.
    bodies, shapes : list of pymunk.Body and of pymunk.Poly
        Those of the benches, in their order.
    poses, velocities : ndarray, shape (N, 3)
        State of the benches after the last step.
    collided_poses : ndarray, shape (N, 3)
        Poses at which the space found contacts and solved the joints in the last step.
    pivots : list of pymunk.PivotJoint
        The joints of the chain; number i joins benches i and i + 1.
    free_from : int or None
        First bench whose dancers have let go, as have those of all behind it.

    Notes
    -----
    Pymunk moves positions with the velocities of the step before and then solves the joints, which is Euler's method.
    Shifted by half a step times the last change of velocity before each step, the poses follow the second-order
    Adams-Bashforth method; shifted once more after it, by half a step times the change of that change, the
    Adams-Moulton method, with a fifth of the error. Where contacts are resolved, velocities jump at impacts, and the
    second shift is left out.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March
    >>> march = March(Dragon(benches=4))
    >>> world = World(march, until=10.0)
    >>> head = march.at(world.substep, handles=2)
    >>> world.prepare(head.poses[0, 0], head.pose_velocities[0, 0], head.velocities[0, 1])
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
    ) -> None:
        check_march(march)
        settings = EngineSettings() if settings is None else settings
        check_settings(settings)
        self.march, self.start = march, start
        self.top_speed = top_speed(march, start, until)
        self.guide = guide_of(guide)
        dragon = march.dragon
        sizes = list(zip(dragon.lengths.tolist(), dragon.widths.tolist(), strict=True))
        self._masses = [WOOD_DENSITY * BENCH_THICKNESS * length * width for length, width in sizes]
        moments = [pymunk.moment_for_box(mass, size) for mass, size in zip(self._masses, sizes, strict=True)]
        self.free_from: int | None = None
        self._carriers: list[pymunk.PivotJoint] = []
        # First bench that the guide does not push, and the largest forces and torques of the guide.
        self._unpushed, self._limits = dragon.benches, np.full((dragon.benches, 1), np.inf)
        self.space = pymunk.Space()
        # A contact is reported when the benches touch, not when they are a tenth of a metre deep.
        self.space.collision_slop = 0.0
        state = march.at(start)
        self._guided = GuidedChain(
            march=march,
            state=state,
            substep=0.0,
            drag_rate=0.0,
            masses=np.array(self._masses),
            moments=np.array(moments),
        )
        self._motors: tuple[pymunk.Constraint, ...] = ()
        self._given = settings
        self._apply_settings()
        self.guide.attach(self._guided)
        self.bodies = [pymunk.Body(mass, moment) for mass, moment in zip(self._masses, moments, strict=True)]
        # A kinematic body that has the exact poses of the head.
        self._control = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        # A step takes time for every body of its space, and anchors need no steps: theirs is never stepped.
        self._anchor_space = pymunk.Space()
        self._anchor_space.add(*parts_of_guide(self.guide, "anchors", self.guide.anchors, pymunk.Body))
        self._add_bodies()
        self._join()
        self._open_buffers()
        self._warm_start(state)
        self.shapes = [bench_shape(body, *size) for body, size in zip(self.bodies, sizes, strict=True)]
        for shape in self.shapes:
            shape.friction = FRICTION
        self.space.add(*self.shapes)

    @property
    def joint_impulses(self) -> list[float]:
        """Size of the impulse in each pivot during the last step, N s."""
        return [pivot.impulse for pivot in self.pivots]

    @property
    def head_lag(self) -> float:
        """Distance of the head's centre from its exact position, m."""
        return float(np.hypot(*(self._control.position - self.bodies[0].position)))

    def change(self, **changes: float) -> None:
        """Change `substep`, `iterations` or `drag` of the settings from the next step on."""
        changed: dict[str, Any] = changes
        self._given = replace(self._given, **changed)
        self._apply_settings()

    def _apply_settings(self) -> None:
        """Use the given settings from the next step on, with a head force for the drag that the head balances now."""
        self.settings = self._given.resolved(top_speed=self.top_speed, pulled_mass=self._pulled_mass)
        assert self.settings.substep is not None  # Set by `resolved`.
        assert self.settings.iterations is not None  # Set by `resolved`.
        self.substep = self._guided.substep = self.settings.substep
        self._guided.drag_rate = self.settings.drag * self.top_speed
        self.space.iterations = self.settings.iterations
        self.space.damping = math.exp(-self._guided.drag_rate)
        if self.settings.head_force is not None:
            # The motors turn the head with half its length times this force.
            arms = 1.0, float(self.march.dragon.lengths[0]) / 2
            for motor, arm in zip(self._motors, arms, strict=False):
                motor.max_force = arm * self.settings.head_force

    @property
    def _pulled_mass(self) -> float:
        """Mass of the benches on which the head balances the ground drag, kg."""
        if self.returning or not self.guide.balances_drag:
            return math.fsum(self._masses)
        return math.fsum(self._masses[:1] + ([] if self.free_from is None else self._masses[self.free_from :]))

    def _add_bodies(self) -> None:
        """Add the bodies: the head is the control body itself, or has motors of finite force to it."""
        if self.settings.head_force is None:
            self.bodies[0] = self._control
            self.space.add(*self.bodies)
            return
        self.space.add(*self.bodies, self._control)
        self._motors = (
            pymunk.PivotJoint(self._control, self.bodies[0], (0.0, 0.0), (0.0, 0.0)),
            pymunk.GearJoint(self._control, self.bodies[0], 0.0, 1.0),
        )
        self._apply_settings()
        self._add_joints(*self._motors)

    def _join(self) -> None:
        """Add the pivots and the guide's joints, from head to tail: the solver takes them in this order.

        On rails, all pivots before the guide leave half the error of pivots and guide in turn after few iterations.
        Where contact forces load the joints, the opposite order leaves less.
        """
        half = self.march.dragon.spacings / 2
        self.pivots: list[pymunk.PivotJoint] = []
        guiding: list[Sequence[pymunk.Constraint]] = []
        for bench, (before, body) in enumerate(pairwise(self.bodies), start=1):
            pivot = pymunk.PivotJoint(before, body, (-half[bench - 1], 0.0), (half[bench], 0.0))
            pivot.collide_bodies = False
            self.pivots.append(pivot)
            joints = self.guide.joints(bench, body)
            guiding.append(parts_of_guide(self.guide, "joints", joints, pymunk.Constraint))
        self._guiding = guiding
        if self.settings.contacts == "resolve":
            ordered = [joint for pivot, joints in zip(self.pivots, guiding, strict=True) for joint in (pivot, *joints)]
        else:
            ordered = [*self.pivots, *chain.from_iterable(guiding)]
        self._add_joints(*ordered)

    def _add_joints(self, *joints: pymunk.Constraint) -> None:
        """Add joints that correct errors at a rate per metre marched, as the drag: a faster march is the same march."""
        for joint in joints:
            joint.error_bias **= self.top_speed
        self.space.add(*joints)

    def _open_buffers(self) -> None:
        """Lay NumPy arrays over the memory that `pymunk.batch` reads and writes."""
        benches = len(self.bodies)
        moved = self.bodies if self._control is self.bodies[0] else [*self.bodies, self._control]
        # Pymunk adds its static body when it is first used, as for an obstacle; a row is written for each body.
        moved = [*moved, self.space.static_body]
        for space, bodies in ((self.space, moved), (self._anchor_space, self.guide.anchors)):
            ids = batch.Buffer()
            batch.get_space_bodies(space, BodyFields.BODY_ID, ids)
            if list(memoryview(ids.int_buf()).cast("P")) != [body.id for body in bodies]:
                raise RuntimeError("pymunk.batch lists the bodies in another order than they were added")
        # Velocities alternate between two inboxes, so that those of the step before are still there.
        self._poses_inbox, self._velocities_inbox, self._velocities_before = (batch.Buffer() for _ in range(3))
        self._outbox, self._anchor_outbox = batch.Buffer(), batch.Buffer()
        out = np.zeros((len(moved), 6))
        self._outbox.set_float_buf(out)
        self._out_poses, self._out_forces = out[:benches, :3], out[:benches, 3:]
        self._out_control = out[0 if self._control is self.bodies[0] else benches, :3]
        self._out_anchors = np.zeros((len(self.guide.anchors), 2))
        self._anchor_outbox.set_float_buf(self._out_anchors)
        self.poses, self.velocities, self.collided_poses = (np.zeros((benches, 3)) for _ in range(3))
        # Half a step times the change of velocity in the last step, and in the one before.
        self._shift, self._shift_before = (np.zeros((benches, 3)) for _ in range(2))
        # Scratch: the poses to which the space will move the benches before it solves the joints.
        self._coming = np.empty((benches, 3))

    def read(self) -> None:
        """Take `poses` and `velocities` from the space."""
        self._velocities_inbox, self._velocities_before = self._velocities_before, self._velocities_inbox
        poses, velocities = self._read(POSES, self._poses_inbox), self._read(VELOCITIES, self._velocities_inbox)
        shift, before = self._shift_before, self._shift
        np.subtract(velocities, self.velocities, out=shift)
        shift *= self.substep / 2
        self._shift, self._shift_before = shift, before
        self.velocities, self.collided_poses = velocities, poses
        if self.settings.contacts == "resolve":
            self.poses[:] = poses
        else:
            np.subtract(shift, before, out=self.poses)
            # The head has its exact pose.
            self.poses[0] = 0.0
            self.poses += poses

    def _read(self, fields: BodyFields, inbox: batch.Buffer) -> Array:
        """Three fields of the benches (N, 3). NumPy is slow on parts of rows, so more of them are read separately."""
        inbox.clear()
        batch.get_space_bodies(self.space, fields, inbox)
        return np.frombuffer(inbox.float_buf(), count=self.poses.size).reshape(-1, 3)

    def prepare(self, head_pose: Array, head_velocity: Array, hinge_velocity: Array) -> None:
        """Make the next step end with the head at a given pose.

        Pymunk will first move every body by its velocity and then solve the joints, so the poses given to it lie one
        such move before the ones at which the joints shall hold.

        Parameters
        ----------
        head_pose, head_velocity : ndarray, shape (3,)
            Pose of the head at the end of the step, m, m, rad, and its rate of change, m/s, m/s, rad/s.
        hinge_velocity : ndarray, shape (2,)
            Velocity of its rear hole then, m/s.
        """
        given = self.poses + self._shift
        np.multiply(self.velocities, self.substep, out=self._coming)
        self._coming += given
        self._out_poses[:] = given
        self._send(head_pose, head_velocity, hinge_velocity)

    def _send(self, head_pose: Array, head_velocity: Array, hinge_velocity: Array) -> None:
        """Write the head's pose, the guide's anchors and the forces for the next step to the space."""
        self.guide.update(self._coming, hinge_velocity, self._out_anchors, self._out_forces)
        if np.isfinite(self._limits[0, 0]):
            self._limit_forces()
        self._out_control[:] = head_pose - self.substep * head_velocity
        if self._control is not self.bodies[0]:
            # A gear joint counts whole turns: the control body's are those of the head.
            turns = (self._out_control[2] - self._out_poses[0, 2]) / (2 * math.pi)
            self._out_control[2] -= 2 * math.pi * round(turns)
        self._write(head_velocity)

    def _write(self, head_velocity: Array) -> None:
        """Write what `_send` has found to the spaces."""
        batch.set_space_bodies(self.space, POSES_AND_FORCES, self._outbox)
        batch.set_space_bodies(self._anchor_space, BodyFields.POSITION, self._anchor_outbox)
        vx, vy, spin = head_velocity.tolist()
        self._control.velocity = vx, vy
        self._control.angular_velocity = spin

    def _warm_start(self, state: States) -> None:
        """Set the benches to the exact `state` at the start, and the joints' impulses to those in balance there.

        The solver begins each step with the impulses of the step before. Without a warm start the drag would lengthen
        the chain in the first second by more than the drift of the whole march. Sweeps of the solver then find the
        impulses of joints that are not pivots or pins, and those of motors.
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
        self._coming[:] = poses
        self._out_poses[:] = poses - self.substep * before
        self._send(poses[0], velocities[0], state.velocities[0, 1])
        inertia = np.array([self._guided.masses, self._guided.masses, self._guided.moments]).T
        free = before * math.exp(-self._guided.drag_rate * self.substep) + self.substep * self._out_forces / inertia
        free[0], inertia[0] = velocities[0], np.inf
        pins = [[joint for joint in joints if isinstance(joint, pymunk.PinJoint)] for joints in self._guiding]
        impulses = balanced_impulses(self.pivots, pins, poses, free, 1 / inertia)
        set_impulses(self.space, self.substep, poses, self.pivots, pins, impulses)
        self._set_velocities(before)
        self._write(velocities[0])
        iterations, self.space.iterations = self.space.iterations, 2 * len(self.bodies)
        self.space.step(self.substep)
        self.space.iterations = iterations
        self._set_velocities(velocities)
        self.velocities[:] = before
        self.read()
        self.poses[:] = poses

    def _set_velocities(self, velocities: Array) -> None:
        for body, (vx, vy, spin) in zip(self.bodies, velocities.tolist(), strict=True):
            body.velocity = vx, vy
            body.angular_velocity = spin

    # ---- dancers who let go and come back

    def release(self, bench: int) -> None:
        """Let the dancers of `bench`, from 1 on, and of all behind it go."""
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
        self.pivots[joint].max_force = 0.0
        self._limit_guide(joint + 1)

    def hold(self) -> None:
        """Have the dancers come back: they carry the free benches, over all others, to their exact positions."""
        if self.returning or self.free_from is None:
            return
        half = self.march.dragon.spacings / 2
        for bench, body in enumerate(self.bodies[self.free_from :], start=self.free_from):
            carrier = pymunk.PivotJoint(self.space.static_body, body, body.position, (-half[bench], 0.0))
            carrier.max_bias = RETURN_SPEED * self.top_speed
            carrier.error_bias = math.exp(-RETURN_RATE * self.top_speed)
            carrier.max_force = float(self._limits[bench, 0])
            self._carriers.append(carrier)
        self.space.add(*self._carriers)
        self._apply_settings()

    def carry(self, states: States, share: float) -> None:
        """Carry benches to their positions in the exact `states` (one time), whose velocities apply by a `share`.

        When all have arrived, dancers guide them again. To be called before each step while benches are `returning`.
        """
        assert self.free_from is not None  # Benches return only if some were free.
        first = self.free_from + 1
        # A carrier follows a moving target with a delay of this time, so its target is as far ahead: otherwise it would
        # brake the chain, whose tension would tear it apart when the carriers let go.
        ahead = self.substep / (1 - math.exp(-RETURN_RATE * self.top_speed * self.substep))
        targets = states.positions[0, first:] + ahead * share * states.velocities[0, first:]
        for carrier, (x, y) in zip(self._carriers, targets.tolist(), strict=True):
            carrier.anchor_a = x, y
        distances = np.hypot(*(self.poses[:, :2] - states.poses[0, :, :2]).T)
        if distances.max() < RETURNED * self.march.dragon.widths.min():
            self._stop_carrying()
            self.guide.relocate(states.handles_s[0])
            for joint in chain.from_iterable(self._guiding[self.free_from - 1 :]):
                joint.max_force = math.inf
            self.free_from = None
            cut = (joint + 1 for joint, pivot in enumerate(self.pivots) if pivot.max_force == 0)
            self._unpushed = next(cut, len(self.bodies))
            self._apply_settings()

    @property
    def returning(self) -> bool:
        """Whether dancers carry benches back."""
        return bool(self._carriers)

    def _stop_carrying(self) -> None:
        self.space.remove(*self._carriers)
        self._carriers.clear()

    def _limit_guide(self, unpushed: int) -> None:
        """Let the guide push no bench from `unpushed` on, and the others with limited forces."""
        self._unpushed = min(self._unpushed, unpushed)
        self._limits = MAX_GUIDE_FORCE * self._guided.masses[:, None] * self.settings.drag * self.top_speed**2
        self._apply_settings()

    def _limit_forces(self) -> None:
        forces = self._out_forces
        forces[self._unpushed :] = 0.0
        # A bench that comes back across the path would get forces without limit.
        np.nan_to_num(forces, copy=False)
        np.clip(forces, -self._limits, self._limits, out=forces)
