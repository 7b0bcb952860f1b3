"""Speeds of a chain's handles on a turn: samples, maxima, and derivatives by curvatures and lengths of the arcs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._arrays import Array, Complex, Indices
from pymunk_dragon.model import chain
from pymunk_dragon.model.curves import Curve
from pymunk_dragon.studies._turns import ArcPath

# Newton steps for the coordinates of a chain, at most; the start is a solution of a similar path.
NEWTON_STEPS = 12
# m. Newton step at which the iteration ends: the error that is left is its square.
NEWTON_TOLERANCE = 1e-6
# m. Largest Newton step: a fraction of a bench.
MAX_NEWTON_STEP = 0.3
# Least cosine of an angle between a bench and the path: speeds are unbounded as it goes to zero.
MIN_COSINE = 0.02
# Points per bracket of a maximum in each refinement pass, which narrows the bracket eightfold.
POINTS = 17
# Refinement passes about a maximum.
PASSES = 4


@dataclass(frozen=True, eq=False)
class Constraints:
    """Constraints on speeds at instants at which an anchor handle has a given distance from an end of an arc.

    One row per constraint. `anchors`, `ends`, `offsets`: the anchor, the number of the end and the distance, m.
    `handles`: the handles whose speeds are constrained. `guesses`: initial coordinates of all handles for Newton's
    method, m.
    """

    anchors: Indices
    ends: Indices
    offsets: Array
    handles: Indices
    guesses: Array

    def __getitem__(self, rows: NDArray[np.bool_] | Indices) -> Constraints:
        return Constraints(*(part[rows] for part in vars(self).values()))

    def __add__(self, other: Constraints) -> Constraints:
        return Constraints(*map(np.concatenate, zip(vars(self).values(), vars(other).values(), strict=True)))


def constrained_speeds(path: ArcPath, spacings: Array, constraints: Constraints) -> tuple[Array, Array, Array] | None:
    """Coordinates (M, H) of the handles, logarithms (M,) of the constrained speed ratios and derivatives (M, 2 n).

    The velocity ratio of a bench's rear handle to its front handle is a / b, with the cosines a and b of the
    bench's angles to the path at the front and rear handle. None where the chain has no position on the path or is
    perpendicular to it.
    """
    # Several handles are constrained at the same instant.
    same = np.stack([constraints.anchors, constraints.ends, constraints.offsets])
    _, first, inverse = np.unique(same, axis=1, return_index=True, return_inverse=True)
    given, constraints = constraints, constraints[first]
    positions = _positions(path, spacings, constraints)
    if positions is None:
        return None
    s, points, tangents, curvatures = positions
    rows, benches = np.arange(len(s)), spacings.size
    facing = ((points[:, :-1] - points[:, 1:]) / spacings).conj()
    front, rear = facing * tangents[:, :-1], facing * tangents[:, 1:]
    logs = chain.log_velocity_ratios(front.real, rear.real)
    rates = np.exp(logs)[..., None]
    of_points, of_headings = path.partials(s, points, tangents, curvatures)
    # Derivatives of the coordinates, first for a fixed head from the constant length of each bench, and then for
    # the anchor at its distance from the end of an arc.
    moved = np.zeros_like(of_headings)
    for i in range(benches):
        along = (facing[:, i, None] * (of_points[:, i] - of_points[:, i + 1])).real
        moved[:, i + 1] = (along + front[:, i, None].real * moved[:, i]) / rear[:, i, None].real
    anchors = constraints.anchors
    ends = np.zeros((rows.size, of_headings.shape[-1]))
    ends[:, path.count :] = np.arange(path.count) < constraints.ends[:, None]
    head = (ends - moved[rows, anchors]) / rates[rows, anchors]
    moved += rates * head[:, None]
    of_points += tangents[..., None] * moved
    of_headings += curvatures[..., None] * moved
    turned = (facing[..., None] * (of_points[:, :-1] - of_points[:, 1:])).imag / spacings[:, None]
    change = (rear.imag / rear.real)[..., None] * (of_headings[:, 1:] - turned)
    change -= (front.imag / front.real)[..., None] * (of_headings[:, :-1] - turned)
    handles = given.handles
    return s[inverse], logs[inverse, handles], np.cumsum(change, axis=1)[inverse, handles - 1]


def _positions(
    path: ArcPath, spacings: Array, constraints: Constraints
) -> tuple[Array, Complex, Complex, Array] | None:
    """Coordinates (M, H), points, tangents and curvatures of the handles, by Newton's method; None without any."""
    s, rows = constraints.guesses.copy(), np.arange(len(constraints.guesses))
    goals = path.edges[constraints.ends] + constraints.offsets
    for _ in range(NEWTON_STEPS):
        points, tangents, curvatures = path.at(s)
        between = points[:, :-1] - points[:, 1:]
        distances = np.abs(between)
        facing = (between / distances).conj()
        front, rear = (facing * tangents[:, :-1]).real, (facing * tangents[:, 1:]).real
        if not min(front.min(), rear.min()) > MIN_COSINE:
            return None
        excess, steps = distances - spacings, np.zeros_like(s)
        steps[rows, constraints.anchors] = goals - s[rows, constraints.anchors]
        for i in range(spacings.size):
            behind = (front[:, i] * steps[:, i] + excess[:, i]) / rear[:, i]
            steps[:, i + 1] = np.where(constraints.anchors <= i, behind, steps[:, i + 1])
        for i in range(spacings.size - 1, -1, -1):
            ahead = (rear[:, i] * steps[:, i + 1] - excess[:, i]) / front[:, i]
            steps[:, i] = np.where(constraints.anchors > i, ahead, steps[:, i])
        steps = np.clip(steps, -MAX_NEWTON_STEP, MAX_NEWTON_STEP)
        s += steps
        if np.abs(steps).max() < NEWTON_TOLERANCE:
            # Points and tangents are advanced by the last step to first order; the error is its square.
            return s, points + steps * tangents, tangents * np.exp(1j * curvatures * steps), curvatures
    return None


def sampled_speeds(curve: Curve, spacings: Array, heads: Array) -> tuple[Array, Array] | None:
    """Coordinates of the handles and logarithms of their speed ratios, each (T, H), at coordinates `heads` of the head.

    None where a handle has no position or does not move forward.
    """
    s = curve.chain(heads, spacings)
    points, tangents = curve.frame(s)
    front, rear = (angle.real for angle in chain.angles(points, tangents, spacings))
    # A comparison with nan is false.
    return (s, chain.log_velocity_ratios(front, rear)) if np.all(front > 0) and np.all(rear > 0) else None


def speed_maxima(
    curve: Curve, spacings: Array, heads: Array, logs: Array, lower: float
) -> tuple[Array, Indices, Array] | None:
    """Local maxima above `lower` of the logarithms (T, H): coordinates of the head, handles, and values."""
    beside = np.pad(logs, ((1, 1), (0, 0)), constant_values=-np.inf)
    rows, handles = np.nonzero((logs >= beside[:-2]) & (logs >= beside[2:]) & (logs > lower))
    rows, handles = rows[handles > 0], handles[handles > 0]
    low, high = heads[np.maximum(rows - 1, 0)], heads[np.minimum(rows + 1, heads.size - 1)]
    chosen = np.arange(rows.size)
    for _ in range(PASSES):
        s = np.linspace(low, high, POINTS, axis=-1)
        found = sampled_speeds(curve, spacings, s.ravel())
        if found is None:
            return None
        own = found[1].reshape(*s.shape, -1)[chosen, :, handles]
        best = own.argmax(axis=1)
        low, high = s[chosen, np.maximum(best - 1, 0)], s[chosen, np.minimum(best + 1, POINTS - 1)]
    return s[chosen, best], handles, own[chosen, best]
