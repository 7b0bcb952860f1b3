"""What keeps the benches on the path: dancers who walk on it, or nothing."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
import pymunk
from numpy.typing import NDArray

from pymunk_dragon.curves import foot
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.march import March
from pymunk_dragon.physics.world import DRAG, Joiner, bench_mass

__all__ = ["Free", "Guide", "Rails", "make_guide"]

Array = NDArray[np.float64]
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
    if name == "rails":
        return Rails(march, start=start, substep=substep, top_speed=top_speed)
    if name == "none":
        return Free()
    raise ParameterError("guide", name, "one of " + ", ".join(get_args(Guide)))


class Free:
    """No guide: the head pulls, and the chain goes where it is pulled."""

    def __init__(self) -> None:
        self.carriers: list[pymunk.Body] = []

    def joints(self, bench: int, body: pymunk.Body) -> list[pymunk.Constraint]:
        """No joints."""
        return []

    def lead(self, poses: Array, hinge_velocity: Array, carriers: Array, forces: Array) -> None:
        """Nobody pushes."""


class Rails:
    """Dancers who keep every hole on the curve and walk at the pace of the march.

    A rail is a `PinJoint` from a bench's rear hole to a point one metre beside the path, on the normal through the
    hole's own foot on the curve: at that moment the hole can move along the path and nowhere else. A kinematic body
    carries that point to the next foot before every step.

    Walking makes up for the ground drag. Each dancer pushes along the bench with the force that would hold its pace
    against the drag if the bench were alone, and the pace is the one that the bench before hands on: both holes of a
    rigid bench go equally fast along it. The chain corrects what is left. When nobody walks, the head pulls the whole
    dragon, and the tension that turns with the benches is what the solver cannot follow.

    The path, the pace and the engine's own positions are all that is used; where each hole is on the curve at a
    certain time is for the engine to find.
    """

    def __init__(self, march: March, *, start: float, substep: float, top_speed: float) -> None:
        dragon = march.dragon
        self.carriers = [pymunk.Body(body_type=pymunk.Body.KINEMATIC) for _ in range(1, dragon.benches)]
        self._curve = march.curve
        self._half = dragon.spacings[1:, None] / 2
        # Places of the rear holes at the start: they tell on which of the curve's turns each hole is, no more.
        self._places = march.parameters(start)[0, 2:]
        masses = np.array([bench_mass(*size) for size in zip(dragon.lengths[1:], dragon.widths[1:], strict=True)])
        # N for each m/s that a bench shall be faster, or that the drag would take from it in a substep.
        self._efforts = masses / substep
        self._kept = np.exp(-DRAG * top_speed * substep)
        self._substep = substep
        self._headings = np.empty((dragon.benches - 1, 2))
        # m/s, of the rear holes along the curve, and of the benches along themselves.
        self._paces = march.at(start).speeds[0, 2:].copy()
        self._along: Array | None = None

    def joints(self, bench: int, body: pymunk.Body) -> list[pymunk.Constraint]:
        """The pin from the rear hole to its carrier."""
        pin = pymunk.PinJoint(body, self.carriers[bench - 1], (-float(self._half[bench - 1, 0]), 0.0), (0.0, 0.0))
        pin.distance = PIN_LENGTH
        return [pin]

    def lead(self, poses: Array, hinge_velocity: Array, carriers: Array, forces: Array) -> None:
        """Move every rail beside its hole, and let the dancers push along their benches."""
        angles, headings = poses[1:, 2], self._headings
        np.cos(angles, out=headings[:, 0])
        np.sin(angles, out=headings[:, 1])
        rear_holes = self._half * headings
        np.subtract(poses[1:, :2], rear_holes, out=rear_holes)
        near = self._places + self._substep * self._paces
        self._places, feet, tangents = foot(self._curve, rear_holes, near)
        carriers[:, 0] = feet[:, 0] - PIN_LENGTH * tangents[:, 1]
        carriers[:, 1] = feet[:, 1] + PIN_LENGTH * tangents[:, 0]
        rear = np.einsum("ij,ij->i", tangents, headings)
        front = np.einsum("ij,ij->i", tangents[:-1], headings[1:])
        along = np.empty(rear.shape)
        along[0] = hinge_velocity @ headings[0]
        np.divide(front, rear[:-1], out=along[1:])
        np.cumprod(along, out=along)
        np.divide(along, rear, out=self._paces)
        before = along if self._along is None else self._along
        pushes = self._efforts * (along - self._kept * before)
        self._along = along
        np.multiply(pushes[:, None], headings, out=forces[1:])
