"""The dragon as Pymunk sees it: bodies, shapes, pivots, and a head that is kinematic or pulled by a motor."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
import pymunk
from numpy.typing import NDArray
from pymunk import batch
from pymunk.batch import BodyFields

from pymunk_dragon.errors import UnreachableError
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March, States, check_march

__all__ = ["DRAG", "PathGuide", "World", "bench_mass", "bench_shape"]

Array = NDArray[np.float64]

# kg per cubic metre: pine and fir. All benches are of one wood, so the value scales impulses and nothing else.
WOOD_DENSITY = 500.0
# m: a plank.
BENCH_THICKNESS = 0.04
# Friction of wood on wood; it matters only where contacts are resolved.
FRICTION = 0.4

# Ground drag, per metre marched (per second at 1 m/s). Pymunk corrects joint errors at a rate of 6.3 per second
# (its error_bias, 0.9 ** 60), as ordinary velocity; a chain whose solver has not converged turns that into growing
# oscillations unless the drag is faster than the correction. Where dancers make up for it, the drift is the same with
# any drag from 5 to 20 (tests/bench/bench_drift.py).
DRAG = 11.5

# Work, in benches times solver sweeps, that brings the joints into balance before the first step. A change travels
# along the chain by diffusion, so balance takes about 2 N**2 sweeps: half a second for 223 benches. The cap
# keeps a dragon of 1,000 benches at some 12 s, when the first seconds drift by a millimetre more.
MAX_WARM_START_WORK = 500_000_000
# Work in one call of the engine, some 25 ms: Ctrl-C takes effect between calls.
WARM_START_WORK_PER_STEP = 1_000_000

READ = BodyFields.POSITION | BodyFields.ANGLE | BodyFields.VELOCITY | BodyFields.ANGULAR_VELOCITY
WRITE = BodyFields.POSITION | BodyFields.ANGLE | BodyFields.FORCE | BodyFields.TORQUE


class PathGuide(Protocol):
    """Interface of a guide: joints that constrain benches to the path, and their update before each step."""

    @property
    def anchors(self) -> list[pymunk.Body]:
        """Kinematic bodies at the other ends of the guide's joints; the world adds and moves them."""
        ...

    def joints(self, bench: int, body: pymunk.Body) -> list[pymunk.Constraint]:
        """Joints between `bench` and the anchors."""
        ...

    def update(self, poses: Array, hinge_velocity: Array, anchors: Array, forces: Array) -> None:
        """Write the anchors' positions and the forces for benches that the next step begins at `poses` (N, 3).

        Parameters
        ----------
        poses : ndarray, shape (N, 3)
            m, m, rad.
        hinge_velocity : ndarray, shape (2,)
            Velocity of the head's rear hole, m/s.
        anchors : ndarray, shape (A, 2)
            Output: positions of the anchors, m.
        forces : ndarray, shape (N, 3)
            Output: forces in N and torques in N m on the benches.
        """
        ...


def bench_mass(length: float, width: float) -> float:
    """Mass of a wooden bench, kg."""
    return WOOD_DENSITY * BENCH_THICKNESS * length * width


def bench_shape(body: pymunk.Body, length: float, width: float) -> pymunk.Poly:
    """Rectangle of a bench about its centre, without rounding."""
    x, y = length / 2, width / 2
    return pymunk.Poly(body, [(-x, -y), (x, -y), (x, y), (-x, y)])


def _kinematic() -> pymunk.Body:
    return pymunk.Body(body_type=pymunk.Body.KINEMATIC)


class World:
    """A Pymunk space with a dragon at `start` on its march; its state is read and written for all bodies at once.

    Parameters
    ----------
    march : March
        What is played. Only its state at `start` is used here, later only the head's pose.
    guide : PathGuide
        What keeps the benches on the path.
    start : float
        Time of the first state, s.
    substep : float
        Length of a step, s.
    iterations : int
        Solver iterations per step.
    top_speed : float
        Largest speed of the head, m/s: the rates of drag and joint correction are proportional to it.
    head_force : float, optional
        Largest force of the motor that pulls the head towards its exact poses, N. Without it the head is a kinematic
        body, which has these poses whatever it touches.

    Attributes
    ----------
    poses, velocities : ndarray, shape (N, 3)
        State of the benches after the last step; both fit each other: the velocities fulfil the joints at these poses.
    pivots : list of pymunk.PivotJoint
        The joints of the chain; number i joins benches i and i + 1.

    Notes
    -----
    Pymunk integrates positions with the velocities of the step before and then solves the joints, which is Euler's
    method: a bench that turns by a in a step leaves its joint by a**2 / 2 of half its length, and the errors of 223
    benches add up. Before each step the poses are therefore shifted by half a step times the change of velocity, which
    makes it the second-order Adams-Bashforth method, from the engine's own velocities.
    """

    def __init__(
        self,
        march: March,
        guide: PathGuide,
        *,
        start: float,
        substep: float,
        iterations: int,
        top_speed: float = 1.0,
        head_force: float | None = None,
    ) -> None:
        check_march(march)
        self.march = march
        self.substep = substep
        self.space = pymunk.Space()
        self.space.iterations = iterations
        self.space.damping = float(np.exp(-DRAG * top_speed))
        # A contact is reported when the benches touch, not when they are a tenth of a metre deep.
        self.space.collision_slop = 0.0
        self._guide = guide

        state = march.at(start)
        self.bodies = [self._body(bench, head_force) for bench in range(march.dragon.benches)]
        # Kinematic bodies beside the benches. The head is one itself, or the last of these controls it.
        moved = [*guide.anchors] if head_force is None else [*guide.anchors, _kinematic()]
        self._control = self.bodies[0] if head_force is None else moved[-1]
        self.space.add(*self.bodies, *moved)
        if head_force is not None:
            self._drive(head_force, top_speed)
        self._join(top_speed)
        self._open_buffers(moved)
        self._warm_start(start, state)
        self.shapes = self._add_shapes()

    @property
    def joint_impulses(self) -> list[float]:
        """Size of the impulse in each pivot during the last step, N s."""
        return [pivot.impulse for pivot in self.pivots]

    def _body(self, bench: int, head_force: float | None) -> pymunk.Body:
        if bench == 0 and head_force is None:
            return _kinematic()
        size = (float(self.march.dragon.lengths[bench]), float(self.march.dragon.widths[bench]))
        mass = bench_mass(*size)
        return pymunk.Body(mass, pymunk.moment_for_box(mass, size))

    def _drive(self, force: float, top_speed: float) -> None:
        """Join the head to the control body by motors of `force` N, and half its length times that, at most."""
        head = self.bodies[0]
        pull = pymunk.PivotJoint(self._control, head, (0.0, 0.0), (0.0, 0.0))
        turn = pymunk.GearJoint(self._control, head, 0.0, 1.0)
        pull.max_force, turn.max_force = force, force * float(self.march.dragon.lengths[0]) / 2
        for motor in (pull, turn):
            motor.error_bias **= top_speed
        self.space.add(pull, turn)

    def _join(self, top_speed: float) -> None:
        """Add each bench's pivot and then its guide, from head to tail: the solver takes them in this order."""
        half = self.march.dragon.spacings / 2
        self.pivots: list[pymunk.PivotJoint] = []
        for bench in range(1, len(self.bodies)):
            before, body = self.bodies[bench - 1], self.bodies[bench]
            pivot = pymunk.PivotJoint(before, body, (-half[bench - 1], 0.0), (half[bench], 0.0))
            pivot.collide_bodies = False
            self.pivots.append(pivot)
            joints = [pivot, *self._guide.joints(bench, body)]
            for joint in joints:
                # The correction's rate is per metre marched, as the drag is: a faster march is the same march.
                joint.error_bias **= top_speed
            self.space.add(*joints)

    def _add_shapes(self) -> list[pymunk.Poly]:
        dragon: Dragon = self.march.dragon
        shapes = [bench_shape(body, dragon.lengths[i], dragon.widths[i]) for i, body in enumerate(self.bodies)]
        for shape in shapes:
            shape.friction = FRICTION
        self.space.add(*shapes)
        return shapes

    def _open_buffers(self, moved: list[pymunk.Body]) -> None:
        """Lay NumPy arrays over the memory that `pymunk.batch` reads and writes."""
        benches = len(self.bodies)
        ids = batch.Buffer()
        batch.get_space_bodies(self.space, BodyFields.BODY_ID, ids)
        order = [body.id for body in (*self.bodies, *moved)]
        if list(memoryview(ids.int_buf()).cast("P")) != order:
            raise RuntimeError("pymunk.batch lists the bodies in another order than they were added")
        self._inbox = batch.Buffer()
        self._outbox = batch.Buffer()
        out = np.zeros((benches + len(moved), 6))
        self._outbox.set_float_buf(out)
        self._out_poses, self._out_forces = out[:benches, :3], out[:benches, 3:]
        self._out_anchors = out[benches : benches + len(self._guide.anchors), :2]
        self._out_control = out[0 if self._control is self.bodies[0] else -1, :3]
        self.poses = np.empty((benches, 3))
        self.velocities = np.empty((benches, 3))
        self._velocities_before = np.empty((benches, 3))
        # Scratch: the poses given to the space, and those to which it moves the benches before it solves the joints.
        self._given = np.empty((benches, 3))
        self._coming = np.empty((benches, 3))

    @property
    def head_lag(self) -> float:
        """Distance of the head's centre from that of the control body, m."""
        return float(np.hypot(*(self._control.position - self.bodies[0].position)))

    def read(self) -> None:
        """Take `poses` and `velocities` from the space."""
        self.velocities, self._velocities_before = self._velocities_before, self.velocities
        self._inbox.clear()
        batch.get_space_bodies(self.space, READ, self._inbox)
        state = np.frombuffer(self._inbox.float_buf(), count=6 * len(self.poses)).reshape(-1, 6)
        self.poses[:] = state[:, :3]
        self.velocities[:] = state[:, 3:]

    def prepare(self, head_pose: Array, head_velocity: Array, hinge_velocity: Array) -> None:
        """Make the next step end with the head at `head_pose` (3,), moving at `head_velocity` (3,).

        Its rear hole then moves at `hinge_velocity` (2,).

        Pymunk will first move every body by its velocity and then solve the joints, so the poses given to it lie one
        such move before the ones at which the joints shall hold.
        """
        given, coming = self._given, self._coming
        np.subtract(self.velocities, self._velocities_before, out=given)
        given *= self.substep / 2
        given += self.poses
        np.multiply(self.velocities, self.substep, out=coming)
        coming += given
        self._send(head_pose, head_velocity, hinge_velocity)

    def _send(self, head_pose: Array, head_velocity: Array, hinge_velocity: Array) -> None:
        """Write the head's pose, the guide's anchors and the forces for the next step to the space."""
        self._guide.update(self._coming, hinge_velocity, self._out_anchors, self._out_forces)
        self._out_poses[:] = self._given
        self._out_control[:] = head_pose - self.substep * head_velocity
        if self._control is not self.bodies[0]:
            # A gear joint counts whole turns: the control body's are those of the head.
            turns = (self._out_control[2] - self._given[0, 2]) / (2 * math.pi)
            self._out_control[2] -= 2 * math.pi * round(turns)
        batch.set_space_bodies(self.space, WRITE, self._outbox)
        vx, vy, spin = head_velocity.tolist()
        self._control.velocity = vx, vy
        self._control.angular_velocity = spin

    def _warm_start(self, start: float, state: States) -> None:
        """Set the benches to the exact state at `start`, and warm-start the joints' impulses there.

        The solver begins each step with the impulses of the step before. Without a warm start the drag would stretch
        the chain in the first second by more than the drift of the whole march.
        """
        poses, velocities = state.poses[0], state.pose_velocities[0]
        try:
            earlier = self.march.at(start - self.substep)
        except UnreachableError:
            # The last hole is at the curve's begin.
            earlier = state
        before = earlier.pose_velocities[0]
        benches, iterations = len(self.bodies), self.space.iterations
        steps = math.ceil(min(2 * benches**3, MAX_WARM_START_WORK) / WARM_START_WORK_PER_STEP) + 1
        self.space.iterations = max(WARM_START_WORK_PER_STEP // benches, iterations)
        for _ in range(steps):
            for body, (vx, vy, spin) in zip(self.bodies, before.tolist(), strict=True):
                body.velocity = vx, vy
                body.angular_velocity = spin
            # The guide makes up for what changes from one step to the next.
            self._guide.update(earlier.poses[0], earlier.velocities[0, 1], self._out_anchors, self._out_forces)
            np.subtract(poses, self.substep * before, out=self._given)
            self._coming[:] = poses
            self._send(poses[0], velocities[0], state.velocities[0, 1])
            self.space.step(self.substep)
        self.space.iterations = iterations
        self.velocities[:] = before
        self.read()
