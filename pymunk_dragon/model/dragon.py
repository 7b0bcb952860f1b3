"""What marches: benches, holes and sizes; poses from handles, outlines from poses (paper, eq. 16-19)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array, Complex, Indices
from pymunk_dragon._checks import finite, whole
from pymunk_dragon.errors import ParameterError

__all__ = ["BENCHES", "Dragon", "Sizes", "bench_poses", "hermite", "interpolated", "outlines"]

# m: the same for all benches, or one for each.
Sizes = float | Sequence[float]

# The shortest chain: a head and a tail.
MIN_BENCHES = 2
# 16 km of dragon, 45 times the contest's, which still fit into memory; more is taken for a typing error.
MAX_BENCHES = 10_000
# m. Keeps every length far above the resolution of a double at the rim of the largest spiral.
MIN_LENGTH = 0.001
# m. No bench is longer; catches centimetres and millimetres given as metres.
MAX_LENGTH = 100.0
_ALLOWED = f"a number from {MIN_LENGTH:g} to {MAX_LENGTH:g} m"
# The paper's choice, beside the last handle: the head's two, and every fiftieth.
TABLE_HANDLES = (0, 1, 51, 101, 151, 201)


class _Contests(int):
    """Default bench count, overridden by the length of a per-bench sequence."""


BENCHES = _Contests(223)


@dataclass(frozen=True, kw_only=True)
class Dragon:
    """A chain of wooden benches, each hinged to the next through a hole near its end.

    Parameters
    ----------
    benches : int
        Number of benches N: one head, N - 2 of the body, one tail. Optional where a sequence defines it.
    head_spacing : float
        Distance between the two holes of the head, m.
    body_spacing : float or sequence of float
        Distance between the two holes of every other bench, m: of all, or of each, N - 1.
    overhang : float or sequence of float
        From a hole's centre to the bench end beside it, at both ends, m: of all benches, or of each, N.
    width : float or sequence of float
        Width, m: of all benches, or of each, N.

    Raises
    ------
    ParameterError
        If a size is not a number from 0.001 to 100 m, `benches` is no whole number from 2 to 10,000, a sequence is
        not as long as that, or a bench is so short that those before and after it would lie on each other.

    Notes
    -----
    Handles are numbered 0 to N along the dragon: handle i is the front hole of bench i, handle N the rear hole of
    the tail. The defaults are the dragon of the contest (paper, section 2.1).

    Examples
    --------
    >>> dragon = Dragon(body_spacing=[3.0, 2.0], width=0.5)
    >>> dragon.benches, dragon.spacings.tolist()
    (3, [2.86, 3.0, 2.0])
    """

    benches: int = BENCHES
    head_spacing: float = 2.86
    body_spacing: Sizes = 1.65
    overhang: Sizes = 0.275
    width: Sizes = 0.30

    def __post_init__(self) -> None:
        object.__setattr__(self, "benches", self._checked_benches())
        object.__setattr__(self, "head_spacing", _length("head_spacing", self.head_spacing))
        for name, count in (("body_spacing", self.benches - 1), ("overhang", self.benches), ("width", self.benches)):
            object.__setattr__(self, name, _sizes(name, getattr(self, name), count))
        self._check_overhangs()

    def _check_overhangs(self) -> None:
        """Refuse benches so short that those before and after them would lie on each other for good."""
        if isinstance(self.overhang, float):
            shortest = float(self.spacings.min())
            if 2 * self.overhang >= shortest:
                bound = f"less than half the shortest spacing, {shortest / 2:g} m"
                raise ParameterError("overhang", self.overhang, bound)
            return
        # At an end of the chain the bench replaces its missing neighbour.
        beside = np.pad(self.overhangs, 1, mode="edge")
        before, after = beside[:-2], beside[2:]
        short = np.flatnonzero(before + after >= self.spacings)
        if short.size:
            i = int(short[0])
            bound = f"together less than the spacing of bench {i} between them, {self.spacings[i]:g} m"
            raise ParameterError(f"overhang beside bench {i}", (before[i].item(), after[i].item()), bound)

    def _checked_benches(self) -> int:
        """The number of benches: the given one, that of a sequence, or the contest's."""
        if isinstance(self.benches, _Contests):
            for name, more in (("body_spacing", 1), ("overhang", 0), ("width", 0)):
                if _is_sequence(value := getattr(self, name)):
                    if not MIN_BENCHES <= len(value) + more <= MAX_BENCHES:
                        bound = f"{MIN_BENCHES - more} to {MAX_BENCHES - more} of them, one for each bench"
                        raise ParameterError(name, value, f"{_ALLOWED}, or {bound}")
                    return len(value) + more
        return whole("benches", self.benches, MIN_BENCHES, MAX_BENCHES)

    @property
    def handles(self) -> int:
        """Number of handles H = N + 1."""
        return self.benches + 1

    @property
    def representatives(self) -> list[int]:
        """The handles that the paper's tables show, as far as this dragon has them, and its last one."""
        last = self.handles - 1
        return [*(handle for handle in TABLE_HANDLES if handle < last), last]

    @cached_property
    def spacings(self) -> Array:
        """Distance between the two holes of each bench, (N,), m."""
        spacings = np.empty(self.benches)
        spacings[0], spacings[1:] = self.head_spacing, self.body_spacing
        spacings.flags.writeable = False
        return spacings

    @cached_property
    def overhangs(self) -> Array:
        """From the holes of each bench to its ends, (N,), m."""
        return self._of_each(self.overhang)

    @cached_property
    def widths(self) -> Array:
        """Width of each bench, (N,), m."""
        return self._of_each(self.width)

    @cached_property
    def lengths(self) -> Array:
        """Length of each bench, (N,), m."""
        lengths = self.spacings + 2 * self.overhangs
        lengths.flags.writeable = False
        return lengths

    @cached_property
    def alike(self) -> bool:
        """Whether all benches but the head have the same sizes: each then passes where the one before it passed."""
        sizes = np.stack([self.spacings, self.overhangs, self.widths])[:, 1:]
        return bool(np.all(sizes == sizes[:, :1]))

    def outlines(self, poses: ArrayLike) -> Array:
        """Corners (..., M, 4, 2) in m of the first M benches, at `poses` (..., M, 3); see the function `outlines`."""
        pose = np.asarray(poses, dtype=float)
        first = slice(pose.shape[-2])
        return outlines(pose, self.lengths[first], self.widths[first])

    def outlines_between(self, handles: Complex) -> Complex:
        """Corners (..., M, 4), in the order of `outlines`, of the first M benches, between `handles` (..., M + 1).

        Points of the plane are complex numbers, m.
        """
        return self.corners(handles[..., :-1], handles[..., 1:], np.arange(handles.shape[-1] - 1))

    def corners(self, fronts: Complex, rears: Complex, benches: Indices) -> Complex:
        """The same (..., 4) of `benches` (...), by their numbers, between their front and rear handles (...)."""
        along = fronts - rears
        centres = rears + along / 2
        along *= self.lengths[benches] / 2 / np.abs(along)
        left = along * (1j * self.widths[benches] / self.lengths[benches])
        corners: Complex = np.empty((*along.shape, 4), dtype=complex)
        for k, corner in enumerate((-along - left, along - left, along + left, left - along)):
            np.add(centres, corner, out=corners[..., k])
        return corners

    def holes(self, poses: ArrayLike) -> tuple[Array, Array]:
        """Front and rear hole, each (..., N, 2) in m, of the benches at `poses` (..., N, 3)."""
        pose = np.asarray(poses, dtype=float)
        half = self.spacings[:, None] / 2 * _headings(pose)
        return pose[..., :2] + half, pose[..., :2] - half

    def hole_velocities(self, poses: ArrayLike, velocities: ArrayLike) -> tuple[Array, Array]:
        """Velocities of the front and rear hole, each (..., N, 2) in m/s, of benches with rates of change (..., N, 3).

        The rates of change of `poses` (..., N, 3) are in m/s, m/s and rad/s.
        """
        rates = np.asarray(velocities, dtype=float)
        along = _headings(np.asarray(poses, dtype=float))
        across = np.stack([-along[..., 1], along[..., 0]], axis=-1)
        half = self.spacings[:, None] / 2 * rates[..., 2:] * across
        return rates[..., :2] + half, rates[..., :2] - half

    def _of_each(self, size: Sizes) -> Array:
        sizes = np.full(self.benches, size)
        sizes.flags.writeable = False
        return sizes


def bench_poses(handles: ArrayLike) -> Array:
    """Poses (..., N, 3) as x, y in m and angle in rad, of the benches between `handles` (..., N + 1, 2).

    A bench's centre is midway between its holes, and its angle is the direction from its rear to its front hole.
    """
    holes = np.asarray(handles, dtype=float)
    front, rear = holes[..., :-1, :], holes[..., 1:, :]
    along = front - rear
    angle = np.arctan2(along[..., 1], along[..., 0])
    return np.concatenate([(front + rear) / 2, angle[..., None]], axis=-1)


def outlines(poses: ArrayLike, lengths: ArrayLike, width: ArrayLike) -> Array:
    """Corners of benches as rectangles (paper, eq. 16-19).

    Parameters
    ----------
    poses : array_like, shape (..., N, 3)
        Centres in m and angles in rad.
    lengths : array_like, shape (N,)
        Length of each bench, m.
    width : float or array_like, shape (N,)
        Width of every bench, or of each, m.

    Returns
    -------
    ndarray, shape (..., N, 4, 2)
        Corners in m, counter-clockwise: rear right, front right, front left, rear left.

    Examples
    --------
    >>> outlines([[0, 0, 0]], [2.0], 1.0)[0].tolist()
    [[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]]
    """
    pose = np.asarray(poses, dtype=float)
    along = _headings(pose) * np.asarray(lengths, dtype=float)[..., None] / 2
    left = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    left *= (np.asarray(width, dtype=float) / np.asarray(lengths, dtype=float))[..., None]
    corners: Array = np.stack([-along - left, along - left, along + left, left - along], axis=-2)
    corners += pose[..., None, :2]
    return corners


def interpolated(before: Array, after: Array, share: ArrayLike) -> Array:
    """Poses (..., 3) at a `share` of the step from `before` to `after`, rotated by the smaller angle."""
    return before + np.asarray(share)[..., None] * _step(before, after)


def hermite(
    poses: tuple[Array, Array], velocities: tuple[Array, Array], interval: ArrayLike, share: ArrayLike
) -> tuple[Array, Array]:
    """Poses and their rates of change on the cubic Hermite polynomial between two times.

    Parameters
    ----------
    poses, velocities : tuple of two ndarray, shape (..., 3)
        Values at the first and at the second time: m, m, rad and m/s, m/s, rad/s. Benches rotate by the smaller angle.
    interval : array_like, shape (...)
        Time between the two, s. Where it is 0, `share` must be 0 or 1.
    share : array_like, shape (...)
        Share of the interval that has passed, 0 to 1.

    Returns
    -------
    tuple of ndarray, shape (..., 3)
        Poses and velocities. The error of the poses is at most interval**4 / 384 times the fourth derivative.
    """
    (before, after), (v0, v1) = poses, velocities
    h, s = np.asarray(interval, dtype=float)[..., None], np.asarray(share, dtype=float)[..., None]
    step = _step(before, after)
    found = before + s * s * (3 - 2 * s) * step + h * s * (1 - s) * ((1 - s) * v0 - s * v1)
    rates = 6 * s * (1 - s) * step / np.where(h > 0, h, 1.0) + (1 - s) * (1 - 3 * s) * v0 + s * (3 * s - 2) * v1
    return found, rates


def _step(before: Array, after: Array) -> Array:
    """Change (..., 3) from one pose to another, with the angle's from -pi to pi."""
    step = after - before
    step[..., 2] = (step[..., 2] + np.pi) % (2 * np.pi) - np.pi
    return step


def _length(name: str, value: object) -> float:
    return finite(name, value, MIN_LENGTH, MAX_LENGTH, "m")


def _is_sequence(value: object) -> bool:
    return np.ndim(value) == 1 if isinstance(value, np.ndarray) else isinstance(value, list | tuple)


def _sizes(name: str, value: Any, count: int) -> Sizes:
    """`value` as a float, or as a tuple of `count` floats."""
    if not _is_sequence(value):
        return _length(name, value)
    if len(value) != count:
        raise ParameterError(name, value, f"{_ALLOWED}, or {count} of them, one for each bench")
    return tuple(_length(f"{name}[{i}]", size) for i, size in enumerate(value))


def _headings(poses: Array) -> Array:
    return np.stack([np.cos(poses[..., 2]), np.sin(poses[..., 2])], axis=-1)
