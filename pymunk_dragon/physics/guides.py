"""Guides: path constraints for the benches (dancers on rails), or none."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import pymunk

from pymunk_dragon._arrays import Array, Complex
from pymunk_dragon._checks import did_you_mean
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March, States

Part = TypeVar("Part")

# m, from a hole to the point that its rail is pinned to. Any length does; one metre needs no scaling of the normal.
PIN_LENGTH = 1.0


@dataclass(kw_only=True)
class GuidedChain:
    """Data that a guide gets of a chain of N benches before the first step; a live session may change the rates.

    Attributes
    ----------
    march : March
        The dragon, its curve and its speed.
    state : States
        Exact state at the start.
    substep : float
        Length of a step, s.
    drag_rate : float
        Rate at which the ground drag reduces velocities, 1/s.
    masses, moments : ndarray, shape (N,)
        Masses of the benches, kg, and their moments of inertia about their centres, kg m^2.
    """

    march: March
    state: States
    substep: float
    drag_rate: float
    masses: Array
    moments: Array


class PathGuide:
    """Base class of guides, and the guide "none": without joints and forces.

    A guide constrains the benches to the path by joints, by forces, or by both. A subclass overrides what it needs; an
    instance of it is given to `simulate(guide=...)`. `GUIDES` holds those that have a name.

    Attributes
    ----------
    anchors : sequence of pymunk.Body
        Kinematic bodies at the other ends of the guide's joints; the world moves them, and keeps them in a space of
        their own, which is never stepped.
    balances_drag : bool
        Whether the guide's forces balance the ground drag, so that the head has to pull itself only.

    Examples
    --------
    Springs of 2 kN/m that pull the centre of each bench to a circle of 5 m radius about the origin; without them the
    chain is pulled straight:

    >>> import numpy as np
    >>> from pymunk_dragon import Arc, Dragon, March, simulate
    >>> class Springs(PathGuide):
    ...     def update(self, poses, hinge_velocity, anchors, forces):
    ...         distance = np.hypot(poses[:, 0], poses[:, 1])
    ...         forces[:, :2] = 2000 * (5 / distance - 1)[:, None] * poses[:, :2]
    >>> march = March(Dragon(benches=8), Arc(centre=(0, 0), radius=5, begin_angle=0, sweep=6))
    >>> [round(simulate(march, guide=guide, until=10).max_drift, 1) for guide in (Springs(), "none")]
    [0.1, 6.4]
    """

    anchors: Sequence[pymunk.Body] = ()
    balances_drag = False

    def attach(self, chain: GuidedChain) -> None:
        """Prepare for a run of `chain`; called once, before everything else."""

    def joints(self, bench: int, body: pymunk.Body) -> Sequence[pymunk.Constraint]:
        """Joints between the body of `bench`, from 1 on, and the anchors; none by default.

        The world raises their `error_bias` to the power of the head's top speed, as that of its own joints.
        """
        return ()

    def relocate(self, handles_s: Array) -> None:
        """Take other coordinates (H,) of the handles, m, near which the path is to be found."""

    def update(self, poses: Array, hinge_velocity: Array, anchors: Array, forces: Array) -> None:
        """Write the anchors' positions and the forces for the next step; called before each.

        Parameters
        ----------
        poses : ndarray, shape (N, 3)
            Poses of the benches at which the joints are solved in this step: m, m, rad.
        hinge_velocity : ndarray, shape (2,)
            Velocity of the head's rear hole, m/s.
        anchors : ndarray, shape (A, 2)
            Output: positions of the anchors, m.
        forces : ndarray, shape (N, 3)
            Output: forces in N and torques in N m on the benches.
        """


class Rails(PathGuide):
    """Path constraints for all rear holes, with forces of dancers that balance the ground drag.

    A rail is a `PinJoint` from a bench's rear hole to an anchor one metre beside the path, on the normal through the
    hole's foot on the curve. So the hole can move only along the path. The anchor moves to the next normal before
    every step. The dancers' force along each bench, and their torque, balance the drag on it at the speed and the
    angular rate that follow from bench to bench, from the head on. The guide uses the path, the head's speed and the
    engine's positions, but no exact positions of the chain: these are for the engine to find.
    """

    balances_drag = True

    def attach(self, chain: GuidedChain) -> None:
        """Create the anchors, and take sizes, masses and the holes' coordinates from `chain`."""
        dragon, state = chain.march.dragon, chain.state
        self.anchors = [pymunk.Body(body_type=pymunk.Body.KINEMATIC) for _ in range(1, dragon.benches)]
        self._curve = chain.march.curve
        self._over_spacings = 1 / dragon.spacings[1:]
        # From the rear hole to the centre, along the bench, m; complex, as NumPy converts real factors at every call.
        self._half = (dragon.spacings[1:] / 2).astype(complex)
        # Coordinates of the rear holes, only to identify the turn of the curve on which each hole is, and their speeds
        # along the path, negative where a jackknifed bench pushes them back.
        self._rear_s = state.handles_s[0, 2:].copy()
        self._rear_speeds = np.sum(state.velocities[0, 2:] * self._curve.tangent(self._rear_s), axis=-1)
        self._chain, self._inertia = chain, np.array([chain.masses[1:], chain.moments[1:]])
        benches = dragon.benches - 1
        # Scratch. Complex numbers are vectors: NumPy then calls once for both components.
        self._headings, self._holes, self._facing, self._front, self._rear = np.empty((5, benches), dtype=complex)
        self._change = np.empty((2, benches))
        # m/s of the benches along themselves, and rad/s: now, and what the drag leaves of those of the step before.
        self._motion, self._kept_motion = np.empty((2, 2, benches))
        self._is_moving = False

    def relocate(self, handles_s: Array) -> None:
        """Take other coordinates (H,) of the handles, m, near which the path is to be found."""
        self._rear_s = handles_s[2:].copy()
        self._rear_speeds[:] = 0.0
        self._is_moving = False

    def joints(self, bench: int, body: pymunk.Body) -> Sequence[pymunk.Constraint]:
        """Pin from the rear hole to its anchor."""
        pin = pymunk.PinJoint(body, self.anchors[bench - 1], (-float(self._half[bench - 1].real), 0.0), (0.0, 0.0))
        pin.distance = PIN_LENGTH
        return (pin,)

    def update(self, poses: Array, hinge_velocity: Array, anchors: Array, forces: Array) -> None:
        """Write the anchors beside the holes, and the dancers' forces and torques."""
        headings, holes = self._headings, self._holes
        angles = poses[1:, 2]
        np.cos(angles, out=headings.real)
        np.sin(angles, out=headings.imag)
        np.multiply(headings, self._half, out=holes)
        np.subtract(_complex(poses[1:, :2]), holes, out=holes)
        near = self._rear_speeds * self._chain.substep
        near += self._rear_s
        self._rear_s, feet, directions = self._curve.foot(holes.view(float).reshape(-1, 2), near)
        tangents, beside = _complex(directions), _complex(anchors)
        np.multiply(tangents, PIN_LENGTH * 1j, out=beside)
        beside += _complex(feet)
        self._find_motion(complex(*hinge_velocity), tangents)
        kept = math.exp(-self._chain.drag_rate * self._chain.substep)
        if not self._is_moving:
            self._is_moving = True
            np.multiply(self._motion, kept, out=self._kept_motion)
        push, torque = np.subtract(self._motion, self._kept_motion, out=self._change)
        # What a bench gains, or loses to the drag, in a substep.
        self._change *= self._inertia
        self._change /= self._chain.substep
        np.multiply(headings, push, out=_complex(forces[1:, :2]))
        forces[1:, 2] = torque
        np.multiply(self._motion, kept, out=self._kept_motion)

    def _find_motion(self, hinge_velocity: complex, tangents: Complex) -> None:
        """Find speeds of the benches along themselves, m/s, and their angular rates, rad/s.

        Each bench's front hole moves with the rear hole of the bench before, the first one's with the head's, and its
        rear hole moves along the path.
        """
        facing, front, rear = self._facing, self._front, self._rear
        np.conjugate(self._headings, out=facing)
        np.multiply(tangents, facing, out=rear)
        front[0] = hinge_velocity * facing[0]
        np.multiply(tangents[:-1], facing[1:], out=front[1:])
        speeds, rates = self._motion
        # As `velocity_ratios`, in place and times the head's speed.
        np.divide(front.real, rear.real, out=self._rear_speeds)
        np.multiply.accumulate(self._rear_speeds, out=self._rear_speeds)
        front[1:] *= self._rear_speeds[:-1]
        speeds[:] = front.real
        np.multiply(self._rear_speeds, rear.imag, out=rates)
        np.subtract(front.imag, rates, out=rates)
        rates *= self._over_spacings


# Guides that have a name, as in `simulate(guide=...)`.
GUIDES: dict[str, type[PathGuide]] = {"rails": Rails, "none": PathGuide}


def guide_of(guide: object) -> PathGuide:
    """The guide with a name, or the given one."""
    if isinstance(guide, PathGuide):
        return guide
    if not (isinstance(guide, str) and guide in GUIDES):
        more = did_you_mean(guide, GUIDES) if isinstance(guide, str) else ", or a PathGuide"
        raise ParameterError("guide", guide, f"one of {', '.join(GUIDES)}{more}")
    return GUIDES[guide]()


def parts_of_guide(guide: PathGuide, member: str, value: object, kind: type[Part]) -> Sequence[Part]:
    """`value` of a guide's `member`, checked to be a list or tuple of objects of the `kind`."""
    if isinstance(value, list | tuple) and all(isinstance(part, kind) for part in value):
        return value
    raise ParameterError(f"{type(guide).__name__}.{member}", value, f"a list or tuple of pymunk.{kind.__name__}")


def guide_name(guide: PathGuide) -> str:
    """Name under which a guide is registered, otherwise that of its class."""
    return next((name for name, kind in GUIDES.items() if kind is type(guide)), type(guide).__name__)


def _complex(vectors: Array) -> Complex:
    """Vectors (N, 2) as complex numbers (N,), in the same memory: NumPy then calls once for both components."""
    return vectors.view(complex)[:, 0]
