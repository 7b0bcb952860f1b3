"""Guides: path constraints for the benches (dancers on rails), or none."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
import pymunk
from numpy.typing import NDArray

from pymunk_dragon._checks import word
from pymunk_dragon.model.march import March
from pymunk_dragon.physics.world import DRAG, PathGuide, bench_mass

__all__ = ["Free", "Guide", "Rails", "make_guide"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Guide = Literal["rails", "none"]

# m, from a hole to the point that its rail is pinned to. Any length does; one metre needs no scaling of the normal.
PIN_LENGTH = 1.0


def make_guide(name: Guide, march: March, *, start: float, substep: float, top_speed: float) -> PathGuide:
    """Guide with the given name.

    Raises
    ------
    ParameterError
        If there is no such guide.
    """
    if word("guide", name, get_args(Guide)) == "none":
        return Free()
    return Rails(march, start=start, substep=substep, top_speed=top_speed)


class Free:
    """No guide: only the joints between the benches constrain the chain."""

    def __init__(self) -> None:
        self.anchors: list[pymunk.Body] = []

    def joints(self, bench: int, body: pymunk.Body) -> list[pymunk.Constraint]:
        """No joints."""
        return []

    def update(self, poses: Array, hinge_velocity: Array, anchors: Array, forces: Array) -> None:
        """No forces."""


class Rails:
    """Path constraints for all rear holes, with forces of dancers that balance the ground drag.

    A rail is a `PinJoint` from a bench's rear hole to an anchor one metre beside the path, on the normal through the
    hole's foot on the curve. So the hole can move only along the path. The anchor is a kinematic body that moves to the
    next normal before every step.

    The dancers' force along each bench, and their torque, balance the drag on the bench at its speed and angular rate.
    These follow from bench to bench, from the head on: both holes of a rigid bench have the same velocity along it.
    Without these forces the head pulls the whole dragon, and without the torques the joints rotate each bench, which
    needs tension as well. The solver cannot follow a large tension whose direction rotates with the benches.

    The guide uses the path, the head's speed and the engine's positions, but no exact positions of the chain: these
    are for the engine to find.
    """

    def __init__(self, march: March, *, start: float, substep: float, top_speed: float = 1.0) -> None:
        dragon = march.dragon
        self.anchors = [pymunk.Body(body_type=pymunk.Body.KINEMATIC) for _ in range(1, dragon.benches)]
        self._curve = march.curve
        self._half, self._over_spacings = dragon.spacings[1:] / 2, 1 / dragon.spacings[1:]
        state = march.at(start)
        # Coordinates of the rear holes, only to identify the turn of the curve on which each hole is, and their speeds
        # along the path, negative where a jackknifed bench pushes them back.
        self._rear_s = state.handles_s[0, 2:].copy()
        self._rear_speeds = np.sum(state.velocities[0, 2:] * march.curve.tangent(self._rear_s), axis=-1)
        sizes = list(zip(dragon.lengths[1:].tolist(), dragon.widths[1:].tolist(), strict=True))
        masses = [bench_mass(*size) for size in sizes]
        moments = [pymunk.moment_for_box(mass, size) for mass, size in zip(masses, sizes, strict=True)]
        # Force per m/s and torque per rad/s that a bench gains, or loses to the drag, in a substep: N s/m, N m s.
        self._gains = np.array([masses, moments]) / substep
        self._kept = np.exp(-DRAG * top_speed * substep)
        self._substep = substep
        self._headings = np.empty(dragon.benches - 1, dtype=complex)
        # m/s of the benches along themselves, and rad/s.
        self._motion: Array | None = None

    def joints(self, bench: int, body: pymunk.Body) -> list[pymunk.Constraint]:
        """The pin from the rear hole to its anchor."""
        pin = pymunk.PinJoint(body, self.anchors[bench - 1], (-float(self._half[bench - 1]), 0.0), (0.0, 0.0))
        pin.distance = PIN_LENGTH
        return [pin]

    def update(self, poses: Array, hinge_velocity: Array, anchors: Array, forces: Array) -> None:
        """Write the anchors beside the holes, and the dancers' forces and torques."""
        headings = self._headings
        np.cos(poses[1:, 2], out=headings.real)
        np.sin(poses[1:, 2], out=headings.imag)
        rear_holes = _complex(poses[1:, :2]) - self._half * headings
        near = self._rear_s + self._substep * self._rear_speeds
        self._rear_s, feet, directions = self._curve.foot(rear_holes.view(float).reshape(-1, 2), near)
        tangents = _complex(directions)
        np.add(_complex(feet), 1j * PIN_LENGTH * tangents, out=_complex(anchors))
        motion = self._speeds(hinge_velocity, tangents)
        before = motion if self._motion is None else self._motion
        push, forces[1:, 2] = self._gains * (motion - self._kept * before)
        np.multiply(push, headings, out=_complex(forces[1:, :2]))
        self._motion = motion

    def _speeds(self, hinge_velocity: Array, tangents: Complex) -> Array:
        """Speeds of the benches along themselves, m/s, and their angular rates, rad/s, (2, N - 1).

        Each bench's front hole moves with the rear hole of the bench before, the first one's with the head's, and its
        rear hole moves along the path.
        """
        facing = self._headings.conj()
        rear = tangents * facing
        front = np.empty_like(rear)
        front[0] = complex(*hinge_velocity) * facing[0]
        np.multiply(tangents[:-1], facing[1:], out=front[1:])
        np.cumprod(front.real / rear.real, out=self._rear_speeds)
        front[1:] *= self._rear_speeds[:-1]
        motion = np.empty((2, rear.size))
        motion[0] = front.real
        np.subtract(front.imag, self._rear_speeds * rear.imag, out=motion[1])
        motion[1] *= self._over_spacings
        return motion


def _complex(vectors: Array) -> Complex:
    """Vectors (N, 2) as complex numbers (N,), in the same memory: NumPy then calls once for both components."""
    return vectors.view(complex)[:, 0]
