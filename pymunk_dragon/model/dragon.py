"""Benches, holes and sizes; poses from handles, outlines from poses (paper, eq. 16-19)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array, Complex, as_complex, as_vectors, read_only
from pymunk_dragon._checks import MAX_COORDINATE, finite, fitting, numbers, whole, within
from pymunk_dragon.errors import ParameterError

# m: the same for all benches, or one for each.
_Sizes = float | Sequence[float]

# kg/m^2: planks of pine, 4 cm thick. All benches have it, so it only scales forces.
_AREA_DENSITY = 20.0

# Benches of the contest's dragon.
_BENCHES = 223
# A head and a tail.
_MIN_BENCHES = 2
# 16 km of dragon, which still fit into memory: more is taken for a typing error.
_MAX_BENCHES = 10_000
# m. Centimetres and millimetres given as metres are longer than the longest bench.
_LENGTHS = 0.001, 100.0
# m: sides of rectangles of any kind. The products of shorter sides would be zero.
_SIDES = 1e-150, MAX_COORDINATE
# m: diameter of a hole in the paper. Only pictures depend on it.
_HOLE_DIAMETER = 0.055
# Largest diameter of a hole as a fraction of a bench's width and twice its overhang, so that the
# holes of a small bench stay inside its outline.
_MAX_HOLE_FRACTION = 0.4
# Handles in the paper's tables, beside the last one.
_TABLE_HANDLES = (0, 1, 51, 101, 151, 201)


@dataclass(frozen=True, kw_only=True)
class Dragon:
    """A chain of benches, each hinged to the next through a hole near its end.

    By default it is the contest's (section 2.1).
    Handle i, from 0 to N, is the front hole of bench i; handle N is the rear hole of the tail.

    Parameters
    ----------
    benches : int
        Number of benches N, from 2 to 10,000, the head and the tail included. By default 223, or
        the number for which a sequence has sizes.
    head_spacing : float
        Distance between the two holes of the head, m, as all sizes from 0.001 to 100.
    body_spacing : float or sequence of float
        Distance between the two holes of every other bench, m: of all, or of each, N - 1.
    overhang : float or sequence of float
        From a hole's centre to the bench end beside it, m: of all benches, or of each, N. The
        overhangs of the benches before and after another one are together shorter than its spacing.
    width : float or sequence of float
        Width, m: of all benches, or of each, N.

    Examples
    --------
    >>> dragon = Dragon(body_spacing=[3.0, 2.0], width=0.5)
    >>> dragon.benches, dragon.spacings.tolist()
    (3, [2.86, 3.0, 2.0])
    """

    benches: int = None  # type: ignore[assignment]  # A number after `__post_init__`.
    head_spacing: float = 2.86
    body_spacing: _Sizes = 1.65
    overhang: _Sizes = 0.275
    width: _Sizes = 0.30

    def __post_init__(self) -> None:
        # How many more benches there are than a sequence has sizes.
        more = {"body_spacing": 1, "overhang": 0, "width": 0}
        name, benches = "benches", self.benches
        if benches is None:
            benches = _BENCHES
            for each in more:
                if _is_sequence(sizes := getattr(self, each)):
                    name, benches = f"number of benches by {each}", len(sizes) + more[each]
                    break
        benches = whole(name, benches, _MIN_BENCHES, _MAX_BENCHES)
        head_spacing = finite("head_spacing", self.head_spacing, *_LENGTHS, "m")
        vars(self).update(benches=benches, head_spacing=head_spacing)
        for name, extra in more.items():
            vars(self)[name] = _sizes(name, getattr(self, name), benches - extra)

        # At an end of the chain the bench replaces its missing neighbour.
        beside = np.pad(self.overhangs, 1, mode="edge")
        room = self.spacings - beside[:-2] - beside[2:]
        if room.min() <= 0:
            i = int(np.argmin(room))
            spacing = self.spacings[i]
            if isinstance(self.overhang, float):
                bound = f"less than half the shortest spacing, {spacing / 2:g} m"
                raise ParameterError("overhang", self.overhang, bound)
            bound = f"together less than the spacing of bench {i} between them, {spacing:g} m"
            raise ParameterError(f"overhang beside bench {i}", beside[[i, i + 2]].tolist(), bound)

    @property
    def handles(self) -> int:
        """Number of handles H = N + 1."""
        return self.benches + 1

    @property
    def representatives(self) -> list[int]:
        """The handles of the paper's tables that this dragon has, and its last one."""
        known = [handle for handle in _TABLE_HANDLES if handle < self.benches]
        return [*known, self.benches]

    @cached_property
    def spacings(self) -> Array:
        """Distance between the two holes of each bench, (N,), m."""
        body = np.full(self.benches - 1, self.body_spacing)
        return read_only(np.append(self.head_spacing, body))

    @cached_property
    def overhangs(self) -> Array:
        """From the holes of each bench to its ends, (N,), m."""
        return read_only(np.full(self.benches, self.overhang))

    @cached_property
    def widths(self) -> Array:
        """Width of each bench, (N,), m."""
        return read_only(np.full(self.benches, self.width))

    @cached_property
    def lengths(self) -> Array:
        """Length of each bench, (N,), m."""
        return read_only(self.spacings + 2 * self.overhangs)

    @cached_property
    def masses(self) -> Array:
        """Mass of each bench, (N,), kg: planks of 20 kg/m^2."""
        return read_only(_AREA_DENSITY * self.lengths * self.widths)

    @cached_property
    def moments(self) -> Array:
        """Moment of inertia of each bench about its centre, (N,), kg m^2."""
        return read_only(self.masses * (self.lengths**2 + self.widths**2) / 12)

    @cached_property
    def has_equal_benches(self) -> bool:
        """Whether all benches but the head have the same sizes.

        Each then passes where the one before it passed.
        """
        sizes = np.stack([self.spacings, self.overhangs, self.widths])
        return bool(np.all(sizes[:, 1:] == sizes[:, 1:2]))

    def outlines(self, poses: ArrayLike) -> Array:
        """Corners (..., M, 4, 2) in m of the first M benches at `poses` (..., M, 3).

        The function `outlines` has their order.
        """
        pose = self._poses("poses", poses)
        benches = pose.shape[-2]
        return rectangles(pose, self.lengths[:benches], self.widths[:benches])

    def outlines_between(self, handles: Complex) -> Complex:
        """Corners (..., M, 4) of benches between `handles` (..., M + 1), as complex numbers."""
        points = np.atleast_1d(numbers("handles", handles, kind=complex))
        benches = whole("number of handles", points.shape[-1], 1, self.handles) - 1
        along = points[..., :-1] - points[..., 1:]
        centres = points[..., 1:] + along / 2
        lengths = self.lengths[:benches]
        along = along * (lengths / 2 / np.abs(along))
        left = along * (1j * self.widths[:benches] / lengths)
        return _rectangles(centres, along, left)

    def holes(self, poses: ArrayLike) -> tuple[Array, Array]:
        """Front and rear hole, each (..., N, 2) in m, of the benches at `poses` (..., N, 3)."""
        pose = self._poses("poses", poses, self.benches)
        centres = as_complex(pose[..., :2])
        half = self.spacings / 2 * headings(pose)
        return as_vectors(centres + half), as_vectors(centres - half)

    def hole_velocities(self, poses: ArrayLike, velocities: ArrayLike) -> tuple[Array, Array]:
        """Velocities of both holes, each (..., N, 2) in m/s, for rates (..., N, 3) of `poses`."""
        rates = self._poses("velocities", velocities, self.benches)
        pose = self._poses("poses", poses, self.benches)
        fitting("poses and velocities", pose.shape, rates.shape)
        half = self.spacings / 2 * headings(pose)
        centres = as_complex(rates[..., :2])
        turning = 1j * rates[..., 2] * half
        return as_vectors(centres + turning), as_vectors(centres - turning)

    def _poses(self, name: str, value: ArrayLike, benches: int | None = None) -> Array:
        """Poses (..., N, 3) of so many benches, or of not more than there are."""
        poses = numbers(name, value, 3)
        count = poses.shape[-2] if poses.ndim > 1 else self.benches + 1
        if count > self.benches or benches not in (None, count):
            number = "at most " * (benches is None) + f"{self.benches}"
            bound = f"(..., N, 3) of {number} benches"
            raise ParameterError(f"the shape of {name}", poses.shape, bound)
        return poses


def bench_poses(handles: ArrayLike) -> Array:
    """Poses (..., N, 3) of benches from rear to front between `handles` (..., N + 1, 2).

    They are centres in m and angles in rad.
    """
    holes = np.atleast_2d(numbers("handles", handles, 2))
    front = holes[..., :-1, :]
    rear = holes[..., 1:, :]
    along = front - rear
    angle = np.arctan2(along[..., 1], along[..., 0])
    return np.concatenate([(front + rear) / 2, angle[..., None]], axis=-1)


def outlines(poses: ArrayLike, lengths: ArrayLike, width: ArrayLike) -> Array:
    """Corners (..., N, 4, 2) of benches as rectangles, m (paper, eq. 16-19).

    They are counter-clockwise from the rear right one.

    Parameters
    ----------
    poses : array_like, shape (..., N, 3)
        Centres in m and angles in rad.
    lengths : array_like, shape (N,)
        Length of each bench, m.
    width : float or array_like, shape (N,)
        Width of all benches, or of each, m.

    Examples
    --------
    >>> outlines([[0, 0, 0]], [2.0], 1.0)[0].tolist()
    [[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]]
    """
    pose = numbers("poses", poses, 3)
    length = within("lengths", numbers("lengths", lengths), *_SIDES, "m")
    across = within("width", numbers("width", width), 0.0, MAX_COORDINATE, "m")
    fitting("poses, lengths and width", pose.shape[:-1], length.shape, across.shape)
    return rectangles(pose, length, across)


def rectangles(poses: Array, lengths: Array, widths: Array) -> Array:
    """Corners as `outlines` has them, without checks: a short side may be negative."""
    along = headings(poses) * lengths / 2
    left = along * (1j * widths / lengths)
    return as_vectors(_rectangles(as_complex(poses[..., :2]), along, left))


def hole_diameter(dragon: Dragon) -> float:
    """Diameter of a dragon's holes in pictures, m."""
    smallest = np.minimum(dragon.widths, 2 * dragon.overhangs).min()
    return min(_HOLE_DIAMETER, _MAX_HOLE_FRACTION * float(smallest))


def pose_step(before: Array, after: Array) -> Array:
    """Change (..., 3) from one pose to another, with the angle's from -pi to pi."""
    step = after - before
    step[..., 2] = (step[..., 2] + np.pi) % (2 * np.pi) - np.pi
    return step


def _is_sequence(value: object) -> bool:
    if isinstance(value, np.ndarray):
        return value.ndim == 1
    return isinstance(value, list | tuple)


def _sizes(name: str, value: Any, count: int) -> _Sizes:
    """`value` as a float, or as a tuple of `count` floats."""
    if not _is_sequence(value):
        return finite(name, value, *_LENGTHS, "m")
    if len(value) != count:
        low, high = _LENGTHS
        bound = f"a number from {low:g} to {high:g} m, or {count} of them, one for each bench"
        raise ParameterError(name, value, bound)
    sizes = enumerate(value)
    return tuple(finite(f"{name}[{i}]", size, *_LENGTHS, "m") for i, size in sizes)


def headings(poses: Array) -> Complex:
    """Unit vectors (...) along the benches at poses (..., 3)."""
    return np.cos(poses[..., 2]) + 1j * np.sin(poses[..., 2])


def _rectangles(centres: Complex, along: Complex, left: Complex) -> Complex:
    """Corners (..., 4) of rectangles from their centres and half their sides (...)."""
    offsets = (-along - left, along - left, along + left, left - along)
    return np.stack([centres + offset for offset in offsets], axis=-1)
