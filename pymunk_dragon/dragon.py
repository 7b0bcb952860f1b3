"""What marches: benches, holes and sizes; poses from handles, outlines from poses (paper, eq. 16-19)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon.checks import finite, whole
from pymunk_dragon.errors import ParameterError

__all__ = ["Dragon", "bench_poses", "interpolated", "outlines"]

Array = NDArray[np.float64]

# A head and a tail are the shortest chain. Ten thousand benches are 16 km of dragon, 45 times the contest's, and
# still fit into memory; far more is a slip of the finger.
MIN_BENCHES, MAX_BENCHES = 2, 10_000
# Metres. No bench is longer; the bound catches centimetres and millimetres given as metres. The lower end keeps every
# length far above what a double resolves at the rim of the largest spiral.
MIN_LENGTH, MAX_LENGTH = 0.001, 100.0
# The paper's choice, beside the last handle: the head's two, and every fiftieth.
TABLE_HANDLES = (0, 1, 51, 101, 151, 201)


@dataclass(frozen=True, kw_only=True)
class Dragon:
    """A chain of wooden benches, each hinged to the next through a hole near its end.

    Parameters
    ----------
    benches : int
        Number of benches N: one head, N - 2 of the body, one tail.
    head_spacing, body_spacing : float
        Distance between the two holes of the head and of every other bench, m.
    overhang : float
        From a hole's centre to the bench end beside it, m.
    width : float
        Width of every bench, m.

    Raises
    ------
    ParameterError
        If a size is not a number from 0.001 to 100 m, `benches` is no whole number from 2 to 10,000, or the overhang
        is half the shortest spacing or more.

    Notes
    -----
    Handles are numbered 0 to N along the dragon: handle i is the front hole of bench i, handle N the rear hole of
    the tail. The defaults are the dragon of the contest (paper, section 2.1).
    """

    benches: int = 223
    head_spacing: float = 2.86
    body_spacing: float = 1.65
    overhang: float = 0.275
    width: float = 0.30

    def __post_init__(self) -> None:
        object.__setattr__(self, "benches", whole("benches", self.benches, MIN_BENCHES, MAX_BENCHES))
        for name in ("head_spacing", "body_spacing", "overhang", "width"):
            object.__setattr__(self, name, finite(name, getattr(self, name), MIN_LENGTH, MAX_LENGTH, "m"))
        shortest = min(self.head_spacing, self.body_spacing)
        if 2 * self.overhang >= shortest:
            # Otherwise the ends of the benches before and after the same bench would lie on each other for good.
            raise ParameterError("overhang", self.overhang, f"less than half the shortest spacing, {shortest / 2:g} m")

    @property
    def handles(self) -> int:
        """Number of handles H = N + 1."""
        return self.benches + 1

    @property
    def representatives(self) -> list[int]:
        """The handles that the paper's tables show, as far as this dragon has them, and its last one."""
        last = self.handles - 1
        return [*(handle for handle in TABLE_HANDLES if handle < last), last]

    @property
    def alike(self) -> bool:
        """Whether all benches but the head are the same."""
        return True

    @cached_property
    def spacings(self) -> Array:
        """Distance between the two holes of each bench, (N,), m."""
        spacings = np.full(self.benches, self.body_spacing)
        spacings[0] = self.head_spacing
        spacings.flags.writeable = False
        return spacings

    @cached_property
    def lengths(self) -> Array:
        """Length of each bench, (N,), m."""
        lengths = self.spacings + 2 * self.overhang
        lengths.flags.writeable = False
        return lengths

    def outlines(self, poses: ArrayLike) -> Array:
        """Corners (..., N, 4, 2) in m of the benches at `poses` (..., N, 3), counter-clockwise from the rear right."""
        return outlines(poses, self.lengths, self.width)

    def holes(self, poses: ArrayLike) -> tuple[Array, Array]:
        """Front and rear hole, each (..., N, 2) in m, of the benches at `poses` (..., N, 3)."""
        pose = np.asarray(poses, dtype=float)
        half = self.spacings[:, None] / 2 * _headings(pose)
        return pose[..., :2] + half, pose[..., :2] - half


def bench_poses(handles: ArrayLike) -> Array:
    """Poses (..., N, 3) as x, y in m and angle in rad, of the benches between `handles` (..., N + 1, 2).

    A bench's centre is midway between its holes, and its angle is the direction from its rear to its front hole.
    """
    holes = np.asarray(handles, dtype=float)
    front, rear = holes[..., :-1, :], holes[..., 1:, :]
    along = front - rear
    angle = np.arctan2(along[..., 1], along[..., 0])
    return np.concatenate([(front + rear) / 2, angle[..., None]], axis=-1)


def outlines(poses: ArrayLike, lengths: ArrayLike, width: float) -> Array:
    """Corners of benches as rectangles (paper, eq. 16-19).

    Parameters
    ----------
    poses : array_like, shape (..., N, 3)
        Centres in m and angles in rad.
    lengths : array_like, shape (N,)
        Length of each bench, m.
    width : float
        Width of every bench, m.

    Returns
    -------
    ndarray, shape (..., N, 4, 2)
        Corners in m, counter-clockwise: rear right, front right, front left, rear left.
    """
    pose = np.asarray(poses, dtype=float)
    along = _headings(pose) * np.asarray(lengths, dtype=float)[..., None] / 2
    left = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    left *= (width / np.asarray(lengths, dtype=float))[..., None]
    corners: Array = np.stack([-along - left, along - left, along + left, left - along], axis=-2)
    corners += pose[..., None, :2]
    return corners


def interpolated(before: Array, after: Array, share: ArrayLike) -> Array:
    """Poses (..., 3) at a `share` of the way from `before` to `after`, turning the shorter way round."""
    step = after - before
    step[..., 2] = (step[..., 2] + np.pi) % (2 * np.pi) - np.pi
    return before + np.asarray(share)[..., None] * step


def _headings(poses: Array) -> Array:
    return np.stack([np.cos(poses[..., 2]), np.sin(poses[..., 2])], axis=-1)
