"""The dragon as Pymunk bodies, shapes and joints, with a head that is kinematic or pulled by a motor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain, pairwise

import numpy as np
import pymunk
from pymunk import batch
from pymunk.batch import BodyFields

from pymunk_dragon._arrays import Array
from pymunk_dragon.errors import UnreachableError
from pymunk_dragon.model.march import March, States, check_march
from pymunk_dragon.model.settings import EngineSettings, check_settings
from pymunk_dragon.physics.guides import GuidedChain, PathGuide, guide_of, parts_of_guide

# kg per cubic metre: pine and fir. All benches are of one wood, so the value scales impulses and nothing else.
WOOD_DENSITY = 500.0
# m: a plank.
BENCH_THICKNESS = 0.04
# Friction of wood on wood; it matters only where contacts are resolved.
FRICTION = 0.4

# Work, in benches times solver sweeps, that brings the joints into balance before the first step. A change travels
# along the chain by diffusion, so balance takes about 2 N**2 sweeps: half a second for 223 benches. The cap
# keeps a dragon of 1,000 benches at some 12 s, when the first seconds drift by a millimetre more.
MAX_WARM_START_WORK = 500_000_000
# Work in one call of the engine, some 25 ms: Ctrl-C takes effect between calls.
WARM_START_WORK_PER_STEP = 1_000_000

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

    Each step is `prepare`, ``space.step(world.substep)``, `read`.

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

    Raises
    ------
    ParameterError
        If the substep is out of its range for the speed of the march, or there is no such guide.
    UnreachableError
        If the dragon has no state at `start`.

    Notes
    -----
    Pymunk integrates positions with the velocities of the step before and then solves the joints, which is Euler's
    method: a bench that turns by a in a step leaves its joint by a**2 / 2 of half its length, and the errors of 223
    benches add up. Before each step the poses are therefore shifted by half a step times the change of velocity, which
    makes it the second-order Adams-Bashforth method, from the engine's own velocities. After the step they are shifted
    once more, by half a step times the change of that change: the Adams-Moulton method, the trapezoidal rule, has a
    fifth of the error, and where the path's curvature jumps and the prediction is wrong by the whole jump, it is not.
    This correction is left out where contacts are resolved, because velocities jump at impacts.

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
        self._sizes = list(zip(dragon.lengths.tolist(), dragon.widths.tolist(), strict=True))
        self._masses = masses = [WOOD_DENSITY * BENCH_THICKNESS * length * width for length, width in self._sizes]
        moments = [pymunk.moment_for_box(mass, size) for mass, size in zip(masses, self._sizes, strict=True)]
        pulled = masses[:1] if self.guide.balances_drag else masses
        self.settings = settings.resolved(top_speed=self.top_speed, pulled_mass=sum(pulled))
        assert self.settings.substep is not None  # Set by `resolved`.
        assert self.settings.iterations is not None  # Set by `resolved`.
        self.substep = self.settings.substep
        drag_rate = self.settings.drag * self.top_speed
        self.space = pymunk.Space()
        self.space.iterations = self.settings.iterations
        self.space.damping = math.exp(-drag_rate)
        # A contact is reported when the benches touch, not when they are a tenth of a metre deep.
        self.space.collision_slop = 0.0

        state = march.at(start)
        self.guide.attach(
            GuidedChain(
                march=march,
                state=state,
                substep=self.substep,
                drag_rate=drag_rate,
                masses=np.array(masses),
                moments=np.array(moments),
            )
        )
        self.bodies = [pymunk.Body(mass, moment) for mass, moment in zip(masses, moments, strict=True)]
        # A kinematic body that has the exact poses of the head: the head itself, or one that controls it by motors.
        self._control = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        # A step takes time for every body of its space, and anchors need no steps: theirs is never stepped.
        self._anchor_space = pymunk.Space()
        self._anchor_space.add(*parts_of_guide(self.guide, "anchors", self.guide.anchors, pymunk.Body))
        force = self.settings.head_force
        if force is None:
            self.bodies[0] = self._control
        self.space.add(*self.bodies)
        if force is not None:
            self.space.add(self._control)
            self._drive(force)
        self._join()
        self._open_buffers()
        self._warm_start(state)
        self.shapes = self._add_shapes()

    @property
    def joint_impulses(self) -> list[float]:
        """Size of the impulse in each pivot during the last step, N s."""
        return [pivot.impulse for pivot in self.pivots]

    @property
    def head_lag(self) -> float:
        """Distance of the head's centre from its exact position, m."""
        return float(np.hypot(*(self._control.position - self.bodies[0].position)))

    def _drive(self, force: float) -> None:
        """Join the head to the control body by motors of `force` N, and half its length times that, at most."""
        head = self.bodies[0]
        pull = pymunk.PivotJoint(self._control, head, (0.0, 0.0), (0.0, 0.0))
        turn = pymunk.GearJoint(self._control, head, 0.0, 1.0)
        self._motors = pull, turn
        self._set_head_force(force)
        self._add_joints(pull, turn)

    def _set_head_force(self, force: float) -> None:
        pull, turn = self._motors
        pull.max_force, turn.max_force = force, force * float(self.march.dragon.lengths[0]) / 2

    def _join(self) -> None:
        """Add the pivots and the guide's joints, from head to tail: the solver takes them in this order.

        On rails, all pivots before the guide leave half the error of pivots and guide in turn after few iterations.
        Where contact forces load the joints, the opposite order leaves less.
        """
        half = self.march.dragon.spacings / 2
        self.pivots: list[pymunk.PivotJoint] = []
        guiding: list[Sequence[pymunk.Constraint]] = []
        self._guiding = guiding
        for bench, (before, body) in enumerate(pairwise(self.bodies), start=1):
            pivot = pymunk.PivotJoint(before, body, (-half[bench - 1], 0.0), (half[bench], 0.0))
            pivot.collide_bodies = False
            self.pivots.append(pivot)
            joints = self.guide.joints(bench, body)
            guiding.append(parts_of_guide(self.guide, "joints", joints, pymunk.Constraint))
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

    def _add_shapes(self) -> list[pymunk.Poly]:
        shapes = [bench_shape(body, *size) for body, size in zip(self.bodies, self._sizes, strict=True)]
        for shape in shapes:
            shape.friction = FRICTION
        self.space.add(*shapes)
        return shapes

    def _open_buffers(self) -> None:
        """Lay NumPy arrays over the memory that `pymunk.batch` reads and writes."""
        benches = len(self.bodies)
        moved = self.bodies if self._control is self.bodies[0] else [*self.bodies, self._control]
        moved = [*moved, *self._fixed_bodies()]
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

    def _fixed_bodies(self) -> list[pymunk.Body]:
        """Bodies of the space at the origin that never move: what is written to the space has a row for each body."""
        return []

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
        self._limit_forces()
        self._out_control[:] = head_pose - self.substep * head_velocity
        if self._control is not self.bodies[0]:
            # A gear joint counts whole turns: the control body's are those of the head.
            turns = (self._out_control[2] - self._out_poses[0, 2]) / (2 * math.pi)
            self._out_control[2] -= 2 * math.pi * round(turns)
        batch.set_space_bodies(self.space, POSES_AND_FORCES, self._outbox)
        batch.set_space_bodies(self._anchor_space, BodyFields.POSITION, self._anchor_outbox)
        vx, vy, spin = head_velocity.tolist()
        self._control.velocity = vx, vy
        self._control.angular_velocity = spin

    def _limit_forces(self) -> None:
        """Change the guide's forces; for worlds in which it does not always act on all benches."""

    def _warm_start(self, state: States) -> None:
        """Set the benches to the exact `state` at the start, and warm-start the joints' impulses there.

        The solver begins each step with the impulses of the step before. Without a warm start the drag would lengthen
        the chain in the first second by more than the drift of the whole march.
        """
        poses, velocities = state.poses[0], state.pose_velocities[0]
        try:
            earlier = self.march.at(self.start - self.substep)
        except UnreachableError:
            # The last hole is at the curve's begin.
            earlier = state
        before = earlier.pose_velocities[0]
        benches, iterations = len(self.bodies), self.space.iterations
        steps = math.ceil(min(2 * benches**3, MAX_WARM_START_WORK) / WARM_START_WORK_PER_STEP) + 1
        self.space.iterations = max(WARM_START_WORK_PER_STEP // benches, iterations)
        for _ in range(steps):
            self._set_velocities(before)
            # The guide balances the change from one step to the next: it is updated for the earlier state first.
            self.guide.update(earlier.poses[0], earlier.velocities[0, 1], self._out_anchors, self._out_forces)
            np.subtract(poses, self.substep * before, out=self._out_poses)
            self._coming[:] = poses
            self._send(poses[0], velocities[0], state.velocities[0, 1])
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
