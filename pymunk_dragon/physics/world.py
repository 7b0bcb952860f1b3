"""A dragon in a Pymunk space, and the order of what happens in one of its steps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pymunk

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import finite, flag, instance, whole
from pymunk_dragon.errors import UnreachableError
from pymunk_dragon.model.march import March, States
from pymunk_dragon.model.settings import EngineSettings
from pymunk_dragon.physics.assembly import Assembly
from pymunk_dragon.physics.buffers import POSES, VELOCITIES, Buffers
from pymunk_dragon.physics.guide import PathGuide
from pymunk_dragon.physics.mid_torque import MidTorque
from pymunk_dragon.physics.readings import Contacts, JointForces
from pymunk_dragon.physics.warm_start import set_impulses

# 1/s: rate at which the time of a march that stands approaches the time of the head's position.
_RECOVERY_RATE = 5.0

# Ratio of the rates at which a march loses its speed and regains it.
_BRAKING_RATIO = 10

# Largest factor on the speed of the march; more is taken for a typing error.
_MAX_SPEEDUP = 1e3

# Per metre: largest share of its speed that a march loses; more is taken for a typing error.
_MAX_BRAKING = 1e6

# Sweeps of the solver in the warm start, per bench.
_WARM_START_SWEEPS = 2


class World(Assembly):
    """A Pymunk space with a dragon at `start` on its march.

    Its state is read and written for all bodies at once. Each step is `prepare` or `follow`,
    ``space.step(world.substep)``, `read`. Between two steps settings may change, and where contacts
    are resolved, dancers may let go and come back, and joints may be cut.

    Parameters
    ----------
    march : March
        The motion to play. Only its state at `start` is used here, later only the head's.
    guide : {"rails", "none"} or PathGuide
        Whether dancers keep every hole on the curve, or the head only pulls; or a guide of your
        own.
    settings : EngineSettings, optional
        Settings of the engine. With contacts other than "resolve" the head is a kinematic body,
        which has its exact poses whatever it touches; otherwise a motor pulls it towards them.
    start : float
        Time of the first state, s.
    until : float, optional
        Time of the last step, s, by default at the end of the curve. The rates of drag and joint
        correction are proportional to the highest speed of the head from `start` to `until`.
    **changes
        Other values of settings, as in ``contacts="report"``.

    Attributes
    ----------
    settings : EngineSettings
        The settings with numbers where defaults depend on the march.
    substep : float
        Length of the next step, s. After a change of its setting, it approaches the new one by 1 %
        a step.
    drag_rate : float
        Rate at which the ground drag reduces velocities, 1/s.
    top_speed : float
        Highest speed of the head, m/s.
    space : pymunk.Space
        The space.
    bodies, shapes : list
        Body and shape of each bench.
    pivots : list of pymunk.PivotJoint
        Joints between the benches: pivot i joins benches i and i + 1.
    masses : ndarray, shape (N,)
        Masses of the benches, kg.
    moments : ndarray, shape (N,)
        Moments of inertia of the benches about their centres, kg m^2.
    poses, velocities : ndarray, shape (N, 3)
        State of the benches after the last step: m, m, rad and per s.
    collided_poses : ndarray, shape (N, 3)
        Poses at which the space found contacts and solved the joints in the last step.
    time : float
        Time of a march that `follow` plays, s.
    share : float
        Share of its speed that this march has.
    free_from : int or None
        First of the benches that nothing holds on the path: 1 with the guide "none"; otherwise the
        first one whose dancers have let go. None if all are held.

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

    velocities: Array

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
        super().__init__(march, guide, settings, start, until, **changes)
        self.time = self.start
        self.share = 1.0
        self._forces = JointForces(self.space)
        self._contacts = Contacts(self.space)
        self._joints = len(self.space.constraints)
        self._buffers = Buffers(self.space, self.bodies, self._control, self.guide.anchors)
        # Length of the next step over that of the last one, and the shift of its poses.
        self._ratio = 1.0
        self._predicted = np.zeros((len(self.bodies), 3))
        # The guide's forces in the last step, N, N, N m.
        self._pushes = np.zeros((len(self.bodies), 3))
        self._forget_forces()
        # It needs all joints, and makes steps in which benches must not touch.
        self._warm_start(march.at(self.start))
        self._add_shapes()

    def _forget_forces(self) -> None:
        """Take the joints to carry nothing, so that the next step is one of first order."""
        self._mid_torque = MidTorque(self.march.dragon)

    @property
    def joint_forces(self) -> Array:
        """Force (N - 1,) in each pivot in the last step, N.

        Where a guide knows them, these are the forces that the motion of the benches needs.
        Elsewhere they come from the impulses. The drag reduces what a force adds to a velocity
        within the step already, so an impulse is smaller than force times length, by the share
        (1 - exp(-x)) / x for x = drag rate times length: by 10.7 % in 20 ms at 1 m/s.
        """
        length = self.space.current_time_step
        if not self._is_disturbed():
            accelerations = 2 / length**2 * self._shift
            forces = self.guide.joint_forces(self.poses, self.velocities, accelerations)
            if forces is not None:
                return forces
        decay = self.drag_rate * length
        return self._forces.sizes(self.pivots) * (decay / -math.expm1(-decay))

    def _is_disturbed(self) -> bool:
        """Whether not all benches are guided, or contacts or joints of others act on them."""
        return self.free_from is not None or not self._dancers.push_all or self._others_act()

    def _others_act(self) -> bool:
        """Whether contacts or joints of others had forces on the benches in the last step."""
        if self.settings.contacts != "resolve":
            return False
        return len(self.space.constraints) > self._joints or self._contacts.push()

    def read(self) -> None:
        """Take `poses` and `velocities` from the space."""
        self.collided_poses = self._buffers.read(POSES)
        velocities = self._buffers.read(VELOCITIES)
        # Half a step times the change of velocity.
        self._shift = self.substep / 2 * (velocities - self.velocities)
        first = self._pulled
        if first is not None:
            self._mid_torque.after_step(velocities, self._buffers.forces)
            if self._others_act():
                # Their forces are part of what is taken for those in the joints.
                self._forget_forces()
        self.velocities = velocities
        self.poses = self.collided_poses
        if self.settings.contacts != "resolve":
            correction = self._shift - self._predicted
            # The head has its exact pose.
            correction[0] = 0.0
            if first is not None:
                correction[first:] *= _moulton(self._ratio)
            self.poses = self.collided_poses + correction
        self._choose_substep()

    @property
    def _pulled_from(self) -> int | None:
        """First of the benches that move by the rules of second order; None if no bench does.

        Dancers who carry benches back pull them at other points than the joints.
        """
        if self.settings.order == 1 or self.returning:
            return None
        return self.free_from

    def prepare(self, states: States, row: int = 0, share: float = 1.0) -> None:
        """Make the next step end with the head in the state at time number `row` of `states`.

        Its velocities apply by a `share`, for a march that waits. Pymunk will first move every body
        by its velocity and then solve the joints, so the poses given to it lie one such move before
        the ones at which the joints shall hold.
        """
        instance("states", states, States, "the States of a march")
        row = whole("row", row, 0, len(states.times) - 1)
        share = finite("share", share, 0.0, _MAX_SPEEDUP, "")
        # After a step of another length, the change of velocity in the next one is another.
        self._ratio = self.substep / self.space.current_time_step
        self._predicted = self._shift if self._ratio == 1 else self._ratio**2 * self._shift
        given = self.poses + self._predicted
        self._buffers.poses[:] = given
        self._send(given + self.substep * self.velocities, states, row, share)

    def follow(
        self, lag: float, braking: float, speed: float = 1.0, *, recovers: bool = False
    ) -> bool:
        """Prepare a step of a march that waits while the head cannot follow.

        Parameters
        ----------
        lag : float
            Distance of the head from its exact pose at which it counts as blocked, widths.
        braking : float
            Share of its speed that the march then loses in a metre at full speed. It regains its
            speed ten times more slowly.
        speed : float
            Factor on the speed.
        recovers : bool
            Whether the time of a march that stands approaches that of the head's position.

        Returns
        -------
        bool
            Whether the curve goes on so far.
        """
        lag = finite("lag", lag, 0.0, math.inf, "widths")
        braking = finite("braking", braking, 0.0, _MAX_BRAKING, "per metre")
        speed = finite("speed", speed, 0.0, _MAX_SPEEDUP, "")
        recovers = flag("recovers", recovers)

        head = self.bodies[0].position
        distance = self._control.position.get_distance(head) / self.march.dragon.widths.min()
        change = -braking if distance > lag else braking / _BRAKING_RATIO
        changed = self.share + change * self.top_speed * self.substep
        self.share = min(max(changed, 0.0), 1.0)
        share = self.share * speed

        goes_on = True
        try:
            states = self.march.at(self.time + share * self.substep, handles=2)
            self.time += share * self.substep
        except UnreachableError:
            states = self.march.at(self.time, handles=2)
            share = 0.0
            goes_on = False

        if share == 0 and recovers:
            # A motor alone would push a long chain back along its path for minutes.
            x, y, angle = states.poses[0, 0].tolist()
            forward = pymunk.Vec2d.from_polar(1, angle)
            ahead = (head - (x, y)).dot(forward) / self.top_speed
            recovered = self.time + _RECOVERY_RATE * self.substep * ahead
            self.time = min(max(recovered, self.start), self.march.end)

        if self.returning:
            exact = self.march.at(self.time)
            if self._dancers.carry(exact, share, self.poses, self.substep):
                self.change()
        self.prepare(states, share=share)
        return goes_on

    def _send(self, coming: Array, states: States, row: int, share: float) -> None:
        """Write the head's pose, and anchors and forces for the poses `coming`, to the spaces."""
        buffers = self._buffers
        hinge_velocity = share * states.velocities[row, 1]
        self.guide.update(coming, hinge_velocity, buffers.anchors, self._pushes)
        self._dancers.limit(self._pushes)
        buffers.forces[:] = self._pushes
        # First of the benches that move by the rules of second order in this step.
        self._pulled = self._pulled_from
        if self._pulled is not None:
            turns = coming[:, 2] - self.poses[:, 2]
            decay = self.drag_rate * self.substep
            self._mid_torque.before_step(
                buffers.forces, self._pulled, self.velocities, coming, turns, self.substep, decay
            )

        velocity = share * states.pose_velocities[row, 0]
        buffers.control[:] = states.poses[row, 0] - self.substep * velocity
        if self._control is not self.bodies[0]:
            # A gear joint counts whole turns: the control body's are those of the head.
            turns = (buffers.control[2] - buffers.poses[0, 2]) / (2 * math.pi)
            buffers.control[2] -= 2 * math.pi * round(turns)
        self._write(velocity)

    def _write(self, head_velocity: Array) -> None:
        """Write what `_send` has found to the spaces, and read what the step overwrites."""
        self._forces.before_step(self.substep)
        self._buffers.write()
        _set_velocities([self._control], head_velocity[None])

    def _warm_start(self, state: States) -> None:
        """Set the benches to the exact `state` at the start, and the joints' impulses to balance.

        Sweeps of the solver then find the impulses of motors and of joints that are neither pivots
        nor pins.
        """
        buffers = self._buffers
        poses = state.poses[0]
        velocities = state.pose_velocities[0]
        try:
            earlier = self.march.at(self.start - self.substep)
        except UnreachableError:
            # The last hole is at the curve's begin.
            earlier = state
        before = earlier.pose_velocities[0]
        # The guide balances the change from one step to the next: it is updated for the earlier
        # state first.
        hinge_velocity = earlier.velocities[0, 1]
        self.guide.update(earlier.poses[0], hinge_velocity, buffers.anchors, self._pushes)
        self.poses = poses
        self.velocities = before
        buffers.poses[:] = poses - self.substep * before
        self._send(poses, state, 0, 1.0)

        inertia = np.array([self.masses, self.masses, self.moments]).T
        kept = math.exp(-self.drag_rate * self.substep)
        free = before * kept + self.substep * buffers.forces / inertia
        free[0] = velocities[0]
        inertia[0] = np.inf
        pins = [
            [joint for joint in joints if isinstance(joint, pymunk.PinJoint)]
            for joints in self._dancers.joints
        ]
        joints = list(zip(self.pivots, pins, strict=True))
        set_impulses(self.space, self.substep, joints, poses, free, 1 / inertia)

        _set_velocities(self.bodies, before)
        self._write(velocities[0])
        iterations = self.space.iterations
        self.space.iterations = _WARM_START_SWEEPS * len(self.bodies)
        self.space.step(self.substep)
        self.space.iterations = iterations

        free = self._buffers.read(VELOCITIES)
        _set_velocities(self.bodies, velocities)
        self.read()
        self.poses = poses
        first = self._pulled
        if first is not None:
            # Benches that were held on the path until now begin to be pulled: their acceleration
            # changes at once.
            self._mid_torque.after_step(free, buffers.forces)
            self._shift[first:] = self.substep / 2 * (free - before)[first:]

    def release(self, bench: int) -> None:
        """Let the dancers of `bench`, from 1 on, and of all behind it go."""
        bench = whole("bench", bench, 1, len(self.pivots))
        if self._pulled_from is None:
            # Forces of an earlier time without dancers are no longer true.
            self._forget_forces()
        self._dancers.release(bench, self.settings.drag)
        self.change()


def _moulton(ratio: float) -> float:
    """Factor on a trapezoidal rule's correction that makes it the Adams-Moulton rule of order 3.

    The step is `ratio` times as long as the one before. Where both are equal, the factor is 5/6.
    """
    return 1 - ratio / (3 + 3 * ratio)


def _set_velocities(bodies: Sequence[pymunk.Body], velocities: Array) -> None:
    for body, (vx, vy, spin) in zip(bodies, velocities.tolist(), strict=True):
        body.velocity = vx, vy
        body.angular_velocity = spin
