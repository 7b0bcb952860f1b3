"""What keeps the benches on the path: dancers who walk on it, or nothing."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
import pymunk
from numpy.typing import NDArray

from pymunk_dragon.checks import word
from pymunk_dragon.curves import foot
from pymunk_dragon.march import March
from pymunk_dragon.physics.world import DRAG, Joiner, bench_mass

__all__ = ["Free", "Guide", "Rails", "make_guide"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Guide = Literal["rails", "none"]

# m, from a hole to the point that its rail is pinned to. Any length does; one metre needs no scaling of the normal.
PIN_LENGTH = 1.0


def make_guide(name: Guide, march: March, *, start: float, substep: float, top_speed: float) -> Joiner:
    """The guide called `name`.

    Raises
    ------
    ParameterError
        If there is none of that name.
    """
    if word("guide", name, get_args(Guide)) == "none":
        return Free()
    return Rails(march, start=start, substep=substep, top_speed=top_speed)


class Free:
    """No guide: the head pulls, and the chain goes where it is pulled."""

    def __init__(self) -> None:
        self.carriers: list[pymunk.Body] = []

    def joints(self, bench: int, body: pymunk.Body) -> list[pymunk.Constraint]:
        """No joints."""
        return []

    def lead(self, poses: Array, hinge_velocity: Array, carriers: Array, efforts: Array) -> None:
        """Nobody pushes."""


class Rails:
    """Dancers who keep every hole on the curve and walk at the pace of the march.

    A rail is a `PinJoint` from a bench's rear hole to a point one metre beside the path, on the normal through the
    hole's own foot on the curve: at that moment the hole can move along the path and nowhere else. A kinematic body
    carries that point to the next foot before every step.

    Walking makes up for the ground drag. Each dancer pushes along the bench, and turns it, as much as keeps its pace
    and its turning against the drag if the bench were alone. The pace is the one that the bench before hands on: both
    holes of a rigid bench go equally fast along it. Rails and joints do the rest. When nobody walks, the head pulls the
    whole dragon; when nobody turns, the joints turn each bench, and that pulls as well. Then the tension that turns
    with the benches is what the solver cannot follow.

    The path, the pace and the engine's own positions are all that is used; where each hole is on the curve at a
    certain time is for the engine to find.
    """

    def __init__(self, march: March, *, start: float, substep: float, top_speed: float = 1.0) -> None:
        dragon = march.dragon
        self.carriers = [pymunk.Body(body_type=pymunk.Body.KINEMATIC) for _ in range(1, dragon.benches)]
        self._curve = march.curve
        self._half, self._over_spacings = dragon.spacings[1:] / 2, 1 / dragon.spacings[1:]
        state = march.at(start)
        # Places of the rear holes: they tell on which of the curve's turns each hole is, no more. And their speeds
        # along the path, negative where a jackknifed bench pushes them back.
        self._places = state.places[0, 2:].copy()
        self._paces = np.sum(state.velocities[0, 2:] * march.curve.tangent(self._places), axis=-1)
        sizes = list(zip(dragon.lengths[1:].tolist(), dragon.widths[1:].tolist(), strict=True))
        masses = [bench_mass(*size) for size in sizes]
        moments = [pymunk.moment_for_box(mass, size) for mass, size in zip(masses, sizes, strict=True)]
        # N for each m/s and N m for each rad/s that a bench shall gain, or the drag would take, in a substep.
        self._efforts = np.array([masses, moments]) / substep
        self._kept = np.exp(-DRAG * top_speed * substep)
        self._substep = substep
        self._headings = np.empty(dragon.benches - 1, dtype=complex)
        # m/s of the benches along themselves, and rad/s.
        self._motion: Array | None = None

    def joints(self, bench: int, body: pymunk.Body) -> list[pymunk.Constraint]:
        """The pin from the rear hole to its carrier."""
        pin = pymunk.PinJoint(body, self.carriers[bench - 1], (-float(self._half[bench - 1]), 0.0), (0.0, 0.0))
        pin.distance = PIN_LENGTH
        return [pin]

    def lead(self, poses: Array, hinge_velocity: Array, carriers: Array, efforts: Array) -> None:
        """Move every rail beside its hole, and let the dancers push and turn their benches."""
        headings = self._headings
        np.cos(poses[1:, 2], out=headings.real)
        np.sin(poses[1:, 2], out=headings.imag)
        rear_holes = _complex(poses[1:, :2]) - self._half * headings
        near = self._places + self._substep * self._paces
        self._places, feet, directions = foot(self._curve, rear_holes.view(float).reshape(-1, 2), near)
        tangents = _complex(directions)
        np.add(_complex(feet), 1j * PIN_LENGTH * tangents, out=_complex(carriers))
        motion = self._handed_on(hinge_velocity, tangents)
        before = motion if self._motion is None else self._motion
        push, efforts[1:, 2] = self._efforts * (motion - self._kept * before)
        np.multiply(push, headings, out=_complex(efforts[1:, :2]))
        self._motion = motion

    def _handed_on(self, hinge_velocity: Array, tangents: Complex) -> Array:
        """Speeds of the benches along themselves, m/s, and of their turning, rad/s, (2, N - 1).

        Each bench's front hole moves as the rear hole of the one before, the first one's as the head's, and its rear
        hole moves along the path.
        """
        facing = self._headings.conj()
        rear = tangents * facing
        front = np.empty_like(rear)
        front[0] = complex(*hinge_velocity) * facing[0]
        np.multiply(tangents[:-1], facing[1:], out=front[1:])
        np.cumprod(front.real / rear.real, out=self._paces)
        front[1:] *= self._paces[:-1]
        motion = np.empty((2, rear.size))
        motion[0] = front.real
        np.subtract(front.imag, self._paces * rear.imag, out=motion[1])
        motion[1] *= self._over_spacings
        return motion


def _complex(vectors: Array) -> Complex:
    """Vectors (N, 2) as complex numbers (N,), in the same memory: NumPy then calls once for both components."""
    return vectors.view(complex)[:, 0]
