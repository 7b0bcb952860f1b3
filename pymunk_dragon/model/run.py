"""Runs: what the engine or the exact model produced."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import IO, Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array, ArrayRecord, frozen, read_only
from pymunk_dragon._checks import MAX_COORDINATE, numbers, word
from pymunk_dragon._display import Displayed
from pymunk_dragon._language import text
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.model.contact import Contact, ContactEvent, ContactLog, contact_text
from pymunk_dragon.model.dragon import pose_step
from pymunk_dragon.model.march import March, check_march
from pymunk_dragon.model.run_file import opened_archive, write_archive
from pymunk_dragon.model.scenario import Scenario
from pymunk_dragon.model.settings import EngineSettings, attributes_of, versions

# How a run ended: at a contact, without one, or where the head has no coordinate on the curve.
Outcome = Literal["contact", "clear", "unreachable"]

# The first twelve benches are the ones that the head meets: their drift decides whether the first contact is the true
# one.
HEAD_BENCHES = 12
# Types of a run's arrays. What needs no 16 digits has seven.
KINDS = {
    "times": np.float64,
    "poses": np.float64,
    "drift": np.float32,
    "pose_velocities": np.float32,
    "joint_impulses": np.float32,
}


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Run(ArrayRecord, Displayed):
    """A dragon's run over F frames of N benches.

    Two runs are equal if everything but the time that playing took is, every number to the last bit.

    Parameters
    ----------
    march : March
        The motion that was played.
    times : ndarray, shape (F,)
        Times of the frames, s, rising. After a contact that ended the run, the last one is the contact's.
    poses : ndarray, shape (F, N, 3)
        Pose of every bench: centre in m, angle in rad.
    drift : ndarray, shape (F, N)
        Position error of each bench's worse hole against the exact model, m; nan where the model has no state. This
        and the next two arrays have single precision.
    pose_velocities : ndarray, shape (F, N, 3), optional
        Rates of change of `poses`: m/s, m/s, rad/s. By default differences of the poses.
    joint_impulses : ndarray, shape (F, N - 1), optional
        Size of the impulse in each pivot, N s, in the substep that ended at the frame, impacts included; pivot i joins
        benches i and i + 1. None where no engine played.
    events : ContactLog
        Every collision callback.
    first_contact : Contact, optional
        The first contact of benches that are not neighbours.
    outcome : {"contact", "clear", "unreachable"}
        Whether a contact came, none came until the end, or the curve ended first.
    provenance : mapping
        Player, settings and versions, as JSON values: the attributes below are read from it. Other entries are kept.
    wall_seconds, step_seconds : float, optional
        Duration of the stepping loop, and of the engine's steps in it, s. Not saved, so that the same scenario gives
        the same file.

    Attributes
    ----------
    player : str or None
        "pymunk" or "exact"; None if unknown.
    guide, settings, substeps
        Name of the engine's guide, `EngineSettings` with the numbers that were used, and number of substeps; None where
        no engine played.
    start : float
        Time at which the run began, s.
    versions : mapping
        Versions of Python and of the libraries that decide the numbers.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March, simulate
    >>> run = simulate(March(Dragon(benches=16)), start=411)
    >>> run
    Run(16 benches, 16 frames from 411 s to 412.474 s, contact)
    >>> print(run)  # doctest: +ELLIPSIS
    first contact at t = 412.47... s: benches 0 and 8 at (...) m
    drift 0.00... mm in the first twelve benches, 0.00... mm anywhere
    ... times as fast as real time
    >>> run.player, run.guide, run.settings.iterations, run.substeps
    ('pymunk', 'rails', 10, 74)
    >>> run.poses_at([411.05, 411.15]).shape
    (2, 16, 3)
    """

    march: March
    times: Array
    poses: Array
    drift: Array
    pose_velocities: Array = None  # type: ignore[assignment]  # An array after `__post_init__`.
    joint_impulses: Array | None = None
    events: ContactLog = field(default_factory=ContactLog)
    first_contact: Contact | None = None
    outcome: Outcome = "clear"
    provenance: Mapping[str, Any] = field(default_factory=dict)
    wall_seconds: float | None = field(default=None, compare=False)
    step_seconds: float | None = field(default=None, compare=False)
    player: str | None = field(init=False, compare=False)
    guide: str | None = field(init=False, compare=False)
    settings: EngineSettings | None = field(init=False, compare=False)
    start: float = field(init=False, compare=False)
    substeps: int | None = field(init=False, compare=False)
    versions: Mapping[str, Any] = field(init=False, compare=False)

    def __post_init__(self) -> None:
        check_march(self.march)
        times = numbers("times", self.times)
        if times.ndim != 1 or not (times.size and np.isfinite(times).all() and np.all(np.diff(times) >= 0)):
            raise ParameterError("times", self.times, "finite and rising, one or more")
        if self.pose_velocities is None:
            object.__setattr__(self, "pose_velocities", _differences(times, numbers("poses", self.poses, 3)))
        for name, shape in _shapes(self.march, times.size).items():
            if name != "joint_impulses" or self.joint_impulses is not None:
                # A copy, because the caller may change the array.
                array = np.array(numbers(name, getattr(self, name)), dtype=KINDS[name])
                if array.shape != shape:
                    raise ParameterError(f"the shape of a run's {name}", array.shape, f"{shape}, as its march wants")
                object.__setattr__(self, name, read_only(array))
        if not (np.abs(self.poses) <= MAX_COORDINATE).all():
            raise ParameterError("poses", self.poses, f"finite and within {MAX_COORDINATE:g} m")
        word("outcome", self.outcome, get_args(Outcome))
        object.__setattr__(self, "provenance", frozen(self.provenance))
        for name, value in attributes_of(self.provenance, float(self.times[0])).items():
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        frames = f"{len(self.times)} frames from {self.times[0]:g} s to {self.times[-1]:g} s"
        return f"Run({self.march.dragon.benches} benches, {frames}, {self.outcome})"

    def __str__(self) -> str:
        """First contact, drift and speed of the engine, and contact windows if the run went on after contacts."""
        touch, until = self.first_contact, float(self.times[-1])
        if touch is not None:
            status = "overlapping" if touch.time <= self.start else self.outcome
            lines = [contact_text(status, touch.benches, touch.point, touch.time)]
        elif self.player == "exact":
            lines = [text("exact model until t = {t:.6g} s, without a search for contacts").format(t=until)]
        else:
            lines = [contact_text(self.outcome, None, None, until)]
        if self.player != "exact":
            head, largest, speed = 1e3 * self.head_drift, 1e3 * self.max_drift, self.to_dict()["realtime_factor"]
            drift = text("drift {head:.3f} mm in the first twelve benches, {largest:.3f} mm anywhere")
            lines.append(drift.format(head=head, largest=largest))
            if speed is not None:
                lines.append(text("{speed:.1f} times as fast as real time").format(speed=speed))
        if self.settings is not None and self.settings.contacts != "stop":
            lines.append(str(self.events))
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Result of the run as JSON values, as `simulate --json` prints it; None for what is unknown.

        Times are in s and drifts in m. `realtime_factor` is the simulated time over the wall time, `driver_overhead`
        the time of the stepping loop outside the engine over that inside.
        """
        wall, stepping = self.wall_seconds, self.step_seconds
        simulated = self.substeps * self.substep if self.substeps and self.substep else None
        return {
            "status": self.outcome,
            "first_contact": asdict(self.first_contact) if self.first_contact else None,
            "drift": {"head": _known(self.head_drift), "max": _known(self.max_drift)},
            "start": self.start,
            "until": float(self.times[-1]),
            "substep": self.substep,
            "substeps": self.substeps,
            "iterations": self.settings.iterations if self.settings else None,
            "events": len(self.events),
            "wall_seconds": wall,
            "realtime_factor": simulated / wall if simulated and wall else None,
            "driver_overhead": wall / stepping - 1 if wall and stepping else None,
        }

    @property
    def substep(self) -> float | None:
        """Length of the engine's steps, s; None where no engine played."""
        return self.settings.substep if self.settings else None

    @classmethod
    def exact(cls, march: March, times: ArrayLike) -> Run:
        """Run of the exact model with frames at `times` (F,), s, without a search for contacts.

        Examples
        --------
        >>> from pymunk_dragon import March
        >>> Run.exact(March(), [0, 60, 120])
        Run(223 benches, 3 frames from 0 s to 120 s, clear)
        """
        check_march(march)
        states = march.at(times)
        return cls(
            march=march,
            times=states.times,
            poses=states.poses,
            drift=np.zeros(states.poses.shape[:2]),
            pose_velocities=states.pose_velocities,
            provenance={"player": "exact", "versions": versions()},
        )

    @property
    def head_drift(self) -> float:
        """Largest drift of the first twelve benches, m."""
        return _largest(self.drift[:, :HEAD_BENCHES])

    @property
    def max_drift(self) -> float:
        """Largest drift of any bench, m."""
        return _largest(self.drift)

    def poses_at(self, times: ArrayLike) -> Array:
        """Poses (T, N, 3) at any times, s: m, m, rad. Before and after the run, those of its first and last frame.

        Between two frames, centres and angles are cubic Hermite polynomials of time. The error is at most the interval
        to the fourth times the fourth derivative over 384: 0.02 um for a head on a turn of 2.3 m radius at 1 m/s and
        frames 0.1 s apart. An impact between two frames is not represented.
        """
        return self._motion_at(times)[0]

    def pose_velocities_at(self, times: ArrayLike) -> Array:
        """Rates of change (T, N, 3) of `poses_at`: m/s, m/s, rad/s. Before and after the run, those of its ends."""
        return self._motion_at(times)[1]

    def _motion_at(self, times: ArrayLike) -> tuple[Array, Array]:
        t = numbers("times", times).ravel()
        last = len(self.times) - 1
        after = np.clip(np.searchsorted(self.times, t), min(1, last), last)
        before = np.maximum(after - 1, 0)
        h = (self.times[after] - self.times[before])[:, None, None]
        # Two frames may share a time: a contact that falls on a frame adds another.
        divisor = np.where(h > 0, h, 1.0)
        s = np.clip((t - self.times[before])[:, None, None] / divisor, 0.0, 1.0)
        start, step = self.poses[before], pose_step(self.poses[before], self.poses[after])
        v0, v1 = self.pose_velocities[before], self.pose_velocities[after]
        poses = start + s * s * (3 - 2 * s) * step + h * s * (1 - s) * ((1 - s) * v0 - s * v1)
        return poses, 6 * s * (1 - s) * step / divisor + (1 - s) * (1 - 3 * s) * v0 + s * (3 * s - 2) * v1

    def save(self, path: str | Path | IO[bytes]) -> None:
        """Write the run as a NumPy archive (.npz, no pickle); an interrupted save leaves the old file or none.

        Parameters
        ----------
        path : path or binary file
            File to write, or an open one.

        Raises
        ------
        ParameterError
            If the ending is not .npz, the folder cannot be written, or the march fails `check_saveable`.
        OutputError
            If writing fails.

        Examples
        --------
        >>> from pymunk_dragon import Dragon, March, Run
        >>> run = Run.exact(March(Dragon(benches=8)), [0.0, 1.0])
        >>> run.save("run.npz")
        >>> Run.load("run.npz") == run
        True
        """
        notes = {
            "scenario": Scenario.of(self.march).to_dict(),
            "outcome": self.outcome,
            "first_contact": asdict(self.first_contact) if self.first_contact else None,
            "events": [asdict(event) for event in self.events],
            "provenance": dict(self.provenance),
        }
        arrays = {name: getattr(self, name) for name in _shapes(self.march, len(self.times))}
        write_archive(path, notes, {name: array for name, array in arrays.items() if array is not None})

    @classmethod
    def load(cls, path: str | Path) -> Run:
        """Read a run that `save` wrote; a file that is damaged or of another format raises a FileFormatError."""
        with opened_archive(path) as (notes, stored):
            march = Scenario.from_dict(notes["scenario"], files=False).march()
            arrays: dict[str, Any] = {
                name: stored[name] for name in KINDS if name != "joint_impulses" or name in stored
            }
            for name, array in arrays.items():
                if array.dtype != KINDS[name] or not (name == "drift" or np.isfinite(array).all()):
                    raise DragonError(f"its {name} are not finite numbers of the type {KINDS[name].__name__}")
            events = ContactLog(tuple(ContactEvent._from_dict(event) for event in notes["events"]))
            first = None if notes["first_contact"] is None else Contact._from_dict(notes["first_contact"])
            last = max((item.benches[1] for item in (*events, first) if item is not None), default=0)
            if last >= march.dragon.benches:
                raise DragonError(f"it has a contact of bench {last}, but its scenario {march.dragon.benches} benches")
            return cls(
                march=march,
                **arrays,
                events=events,
                first_contact=first,
                outcome=notes["outcome"],
                provenance=dict(notes["provenance"]),
            )


def _shapes(march: March, frames: int) -> dict[str, tuple[int, ...]]:
    """Shapes of a run's arrays."""
    benches = march.dragon.benches
    return {
        "times": (frames,),
        "poses": (frames, benches, 3),
        "drift": (frames, benches),
        "pose_velocities": (frames, benches, 3),
        "joint_impulses": (frames, benches - 1),
    }


def check_saveable(march: March) -> None:
    """Check that a run of a march can be saved, before the run is made.

    Every curve of the package can be saved, and a class of your own that is a dataclass with a ``kind``.

    Examples
    --------
    >>> from pymunk_dragon import March
    >>> check_saveable(March())
    """
    Scenario.of(march)


def _differences(times: Array, poses: Array) -> Array:
    """Rates of change (F, N, 3) of `poses`, by differences of second order."""
    known, first, frames = np.unique(times, return_index=True, return_inverse=True)
    if known.size < 2 or len(poses) != len(times):
        return np.zeros_like(poses)
    poses = poses[first]
    poses[..., 2] = np.unwrap(poses[..., 2], axis=0)
    rates: Array = np.gradient(poses, known, axis=0, edge_order=2 if known.size > 2 else 1)[frames]
    return rates


def _largest(drift: Array) -> float:
    known = drift[np.isfinite(drift)]
    return float(known.max()) if known.size else float("nan")


def _known(value: float) -> float | None:
    """JSON has no nan."""
    return None if math.isnan(value) else value
