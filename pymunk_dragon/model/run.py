"""Runs, which the engine or the exact model produced, and their files.

A file of a run is a NumPy archive (.npz) of arrays and of notes as JSON, read without trust in its
contents.
"""

from __future__ import annotations

import io
import json
import math
import platform
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from types import NoneType
from typing import IO, Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon._arrays import Array, ArrayRecord, read_only
from pymunk_dragon._checks import MAX_COORDINATE, finite, instance, instances, numbers, whole, word
from pymunk_dragon._files import check_destination, reason, written_in_place
from pymunk_dragon._language import text
from pymunk_dragon.errors import DragonError, FileFormatError, ParameterError
from pymunk_dragon.model.contact import (
    Contact,
    ContactEvent,
    ContactLog,
    contact_text,
    read_contact,
)
from pymunk_dragon.model.dragon import Dragon, pose_step
from pymunk_dragon.model.march import March, check_march
from pymunk_dragon.model.scenario import Scenario
from pymunk_dragon.model.settings import EngineSettings
from pymunk_dragon.model.speed import MAX_TIME

# How a run ended: at a contact, without one, or where the head has no coordinate on the curve.
Outcome = Literal["contact", "clear", "unreachable"]

# The benches that the head meets: their drift decides whether the first contact is the true one.
HEAD_BENCHES = 12
# Types of a run's arrays. What needs no 16 digits has seven.
_KINDS: dict[str, Any] = {
    "times": np.float64,
    "poses": np.float64,
    "drift": np.float32,
    "pose_velocities": np.float32,
    "joint_forces": np.float32,
}
# s: the least time between frames whose difference is a velocity. A rounding error of a position,
# 1e-14 m, changes the velocity by 1e-7 m/s, as an acceleration of 1 m/s^2 does in this time.
_LEAST_DIFFERENCE = 1e-7
# Name of the format of files.
_FORMAT = "pymunk_dragon run"
# Version of the format, the only one that is read.
_FORMAT_VERSION = 3
# Bytes that any file may unpack to.
_MAX_UNPACKED = 512_000_000
# Times its size that a file may unpack to: packing makes callbacks ten times smaller.
_MAX_RATIO = 10


class _Origin:
    """What a run reads of its provenance."""

    player: str | None
    guide: str | None
    free_from: int | None
    settings: EngineSettings | None
    start: float
    substeps: int | None
    versions: Mapping[str, Any]


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Run(ArrayRecord, _Origin):
    """A dragon's run over F frames of N benches.

    Two runs are equal if everything but the seconds that playing took is equal, to the last bit.

    Parameters
    ----------
    march : March
        The motion that was played.
    times : ndarray, shape (F,)
        Times of the frames, s, rising. After a contact that ended the run, the last one is the
        contact's.
    poses : ndarray, shape (F, N, 3)
        Pose of every bench: centre in m, angle in rad.
    drift : ndarray, shape (F, N)
        Position error of each bench's worse hole, m; nan where the exact model has no state. Single
        precision, as the next two.
    pose_velocities : ndarray, shape (F, N, 3), optional
        Rates of change of `poses`: m/s, m/s, rad/s. By default differences of the poses; frames
        that are less than 1e-7 s apart have the same.
    joint_forces : ndarray, shape (F, N - 1), optional
        Force in pivot i, of benches i and i + 1, at the frame, N; in a run of the engine that of
        the substep that ended there, see `World.joint_forces`.
    events : ContactLog, optional
        Every collision callback.
    first_contact : Contact, optional
        First contact of benches that are not neighbours.
    outcome : {"contact", "clear", "unreachable"}
        Whether a contact came, none came until the end, or the curve ended first.
    provenance : mapping
        JSON values, of which these attributes are read, None if unknown: `player` ("pymunk" or
        "exact"), `guide`, `settings` (an `EngineSettings`), `start` in s, number of `substeps`,
        `versions` of Python and libraries; and `free_from`, the first of the benches that no guide
        holds on the path, None if all are held.
    wall_seconds : float, optional
        Duration of the stepping loop, s. It is not saved.
    step_seconds : float, optional
        Duration of the engine's steps in the loop, s. It is not saved.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March, simulate
    >>> run = simulate(March(Dragon(benches=16)), start=411)
    >>> run
    Run(16 benches, 16 frames from 411 s to 412.474 s, contact)
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
    joint_forces: Array | None = None
    events: ContactLog = field(default_factory=ContactLog)
    first_contact: Contact | None = None
    outcome: Outcome = "clear"
    provenance: Mapping[str, Any] = field(default_factory=dict)
    wall_seconds: float | None = field(default=None, compare=False)
    step_seconds: float | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        check_march(self.march)
        times = numbers("times", self.times)
        is_finite = times.size and np.isfinite(times).all()
        if times.ndim != 1 or not is_finite or (np.diff(times) <= 0).any():
            raise ParameterError("times", self.times, "finite and rising, one or more")
        # A film or a report of the run needs states of the march at these times.
        finite("times", float(times[-1]), -MAX_TIME, MAX_TIME, "s")
        self.march.motion_or_nan(times[:1])
        if self.pose_velocities is None:
            rates = _differences(times, numbers("poses", self.poses, 3))
            vars(self)["pose_velocities"] = rates
        for name in _KINDS:
            if getattr(self, name) is not None:
                vars(self)[name] = self._checked(name, times.size)

        events = instances("events", self.events, ContactEvent, "a sequence of ContactEvents")
        vars(self)["events"] = ContactLog(events)
        instance("first_contact", self.first_contact, Contact | NoneType, "a Contact or None")
        for name in ("wall_seconds", "step_seconds"):
            if getattr(self, name) is not None:
                finite(name, getattr(self, name), 0.0, math.inf, "s")
        word("outcome", self.outcome, get_args(Outcome))
        instance("provenance", self.provenance, Mapping, "a mapping of JSON values")
        try:
            # A copy, and lists for tuples, as in a file.
            provenance = json.loads(json.dumps(dict(self.provenance)))
        except (TypeError, ValueError) as error:
            bound = f"a mapping of JSON values ({error})"
            raise ParameterError("provenance", self.provenance, bound) from error
        attributes = _attributes(provenance, self.march, float(self.times[0]))
        vars(self).update(attributes, provenance=provenance)

    def _checked(self, name: str, frames: int) -> Array:
        """A read-only copy of an array of a run, whose caller may change the array."""
        benches = self.march.dragon.benches
        shapes = {
            "times": (frames,),
            "drift": (frames, benches),
            "joint_forces": (frames, benches - 1),
        }
        shape = shapes.get(name, (frames, benches, 3))
        array = numbers(name, getattr(self, name))
        if array.shape != shape:
            bound = f"{shape}, as its march has"
            raise ParameterError(f"the shape of a run's {name}", array.shape, bound)

        # The drift is a distance of two poses, or nan where the model has none.
        limits = {"poses": MAX_COORDINATE, "drift": 3 * MAX_COORDINATE}
        limit = limits.get(name, np.finfo(_KINDS[name]).max)
        right = np.abs(array) <= limit
        if name == "drift":
            right |= np.isnan(array)
        if not right.all():
            raise ParameterError(name, array, f"finite and within {limit:g}")
        return read_only(np.array(array, dtype=_KINDS[name]))

    def __repr__(self) -> str:
        frames = f"{len(self.times)} frames from {self.times[0]:g} s to {self.times[-1]:g} s"
        return f"Run({self.march.dragon.benches} benches, {frames}, {self.outcome})"

    def __str__(self) -> str:
        touch = self.first_contact
        _, until = self.interval
        if touch is not None:
            status = "overlapping" if touch.time <= self.start else self.outcome
            lines = [contact_text(status, touch.benches, touch.point, touch.time)]
        elif self.is_exact_march:
            line = text("exact model until t = {t:.6g} s, without a search for contacts")
            lines = [line.format(t=until)]
        else:
            lines = [contact_text(self.outcome, None, None, until)]

        if self.is_pulled:
            line = text("at most {largest:.3f} m from the march with all benches on the path")
            lines.append(line.format(largest=self.max_drift))
        elif self.player != "exact":
            drift = text(
                "drift {head:.3f} mm in the first twelve benches, {largest:.3f} mm anywhere"
            )
            lines.append(drift.format(head=1e3 * self.head_drift, largest=1e3 * self.max_drift))
            if speed := self.to_dict()["realtime_factor"]:
                lines.append(text("{speed:.1f} times as fast as real time", speed=speed))
        if self.settings is not None and self.settings.contacts != "stop":
            lines.append(str(self.events))
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Result of the run as JSON values in SI units, as `simulate --json` prints it.

        Unknown values are None.
        `driver_overhead` is the time of the stepping loop outside the engine over that inside.
        """
        wall, stepping = self.wall_seconds, self.step_seconds
        drift = {"head": self.head_drift, "max": self.max_drift}
        simulated = self.substeps * self.substep if self.substeps and self.substep else None
        return {
            "status": self.outcome,
            "first_contact": asdict(self.first_contact) if self.first_contact else None,
            # JSON has no nan.
            "drift": {name: None if math.isnan(value) else value for name, value in drift.items()},
            "start": self.start,
            "until": self.interval[1],
            "substep": self.substep,
            "substeps": self.substeps,
            "iterations": self.settings.iterations if self.settings else None,
            "events": len(self.events),
            "wall_seconds": wall,
            "realtime_factor": simulated / wall if simulated and wall else None,
            "driver_overhead": wall / stepping - 1 if wall and stepping else None,
        }

    @property
    def is_exact_march(self) -> bool:
        """Whether the exact model played, with all benches on the path."""
        return self.player == "exact" and self.free_from is None

    @property
    def interval(self) -> tuple[float, float]:
        """Times of the first and of the last frame, s."""
        begin, end = self.times[[0, -1]].tolist()
        return begin, end

    @property
    def is_pulled(self) -> bool:
        """Whether the run is one of `pull`: exact, with benches that are free."""
        return self.player == "exact" and self.free_from is not None

    @property
    def substep(self) -> float | None:
        """Length of the engine's steps, s; None where no engine played."""
        return self.settings.substep if self.settings else None

    @classmethod
    def exact(cls, march: March, times: ArrayLike) -> Run:
        """Run of the exact model with frames at `times` (F,), s, without a search for contacts."""
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
        """Largest drift of the first twelve benches in a frame, m."""
        return float(np.fmax.reduce(self.drift[:, :HEAD_BENCHES], axis=None, initial=np.nan))

    @property
    def max_drift(self) -> float:
        """Largest drift of any bench in a frame, m; between frames it may be larger."""
        return float(np.fmax.reduce(self.drift, axis=None, initial=np.nan))

    def poses_at(self, times: ArrayLike) -> Array:
        """Poses (T, N, 3) at any times, s: m, m, rad.

        Before and after the run, they are those of its first and last frame. Between two frames,
        they are cubic Hermite polynomials of time. But for an impact between them, their error is
        at most the interval to the fourth times the fourth derivative over 384: 0.02 um on a turn
        of 2.3 m radius.
        """
        return self._motion_at(times)[0]

    def pose_velocities_at(self, times: ArrayLike) -> Array:
        """Rates of change (T, N, 3) of `poses_at`: m/s, m/s, rad/s."""
        return self._motion_at(times)[1]

    def _motion_at(self, times: ArrayLike) -> tuple[Array, Array]:
        t = numbers("times", times).ravel()
        if np.isnan(t).any():
            raise ParameterError("times", math.nan, "numbers")
        times = self.times
        t = np.clip(t, times[0], times[-1])
        last = len(times) - 1
        after = np.clip(np.searchsorted(times, t), min(1, last), last)
        before = np.maximum(after - 1, 0)
        h = (times[after] - times[before])[:, None, None]
        # A run of one frame has no time between two.
        divisor = np.where(h > 0, h, 1.0)
        s = (t - times[before])[:, None, None] / divisor

        start = self.poses[before]
        step = pose_step(start, self.poses[after])
        v0 = self.pose_velocities[before]
        v1 = self.pose_velocities[after]
        bulge = h * s * (1 - s) * ((1 - s) * v0 - s * v1)
        poses = start + s * s * (3 - 2 * s) * step + bulge
        rates = 6 * s * (1 - s) * step / divisor
        rates = rates + (1 - s) * (1 - 3 * s) * v0
        return poses, rates + s * (3 * s - 2) * v1

    def save(self, path: str | Path | IO[bytes]) -> None:
        """Write the run to a path that ends in .npz, or an open file.

        An interrupted save leaves the old file or none.

        Examples
        --------
        >>> from pymunk_dragon import Dragon, March, Run
        >>> run = Run.exact(March(Dragon(benches=8)), [0.0, 1.0])
        >>> run.save("run.npz")
        >>> Run.load("run.npz") == run
        True
        """
        notes = {
            "format": _FORMAT,
            "format_version": _FORMAT_VERSION,
            "scenario": Scenario.of(self.march).to_dict(),
            "outcome": self.outcome,
            "first_contact": asdict(self.first_contact) if self.first_contact else None,
            "events": [asdict(event) for event in self.events],
            "provenance": dict(self.provenance),
        }

        arrays = {name: getattr(self, name) for name in _KINDS}
        contents = {name: array for name, array in arrays.items() if array is not None}
        contents["notes"] = np.frombuffer(json.dumps(notes).encode(), dtype=np.uint8)

        if isinstance(path, str | Path):
            destination = check_destination(path, [".npz"])
            with written_in_place(destination) as draft, draft.open("wb") as file:
                np.savez_compressed(file, **contents)
        elif hasattr(path, "write"):
            np.savez_compressed(path, **contents)
        else:
            raise ParameterError("output", path, "a path or an open file")

    @classmethod
    def load(cls, path: str | Path) -> Run:
        """Read a run that `save` wrote; a file that is no such run raises a FileFormatError."""
        with _opened(path) as (notes, stored):
            names = [name for name in _KINDS if name != "joint_forces" or name in stored]
            arrays: Any = {name: stored[name] for name in names}
            for name, array in arrays.items():
                if array.dtype != _KINDS[name]:
                    raise DragonError(f"its {name} are of the type {array.dtype}")
            march = Scenario.from_dict(notes["scenario"], files=False).march()
            benches = march.dragon.benches
            events = [read_contact(ContactEvent, event, benches) for event in notes["events"]]
            first = notes["first_contact"]
            return cls(
                march=march,
                **arrays,
                events=ContactLog(events),
                first_contact=first and read_contact(Contact, first, benches),
                outcome=notes["outcome"],
                provenance=dict(notes["provenance"]),
            )


@contextmanager
def _opened(path: str | Path) -> Iterator[tuple[dict[str, Any], Mapping[str, NDArray[Any]]]]:
    """Notes and arrays in a file that `Run.save` wrote; its contents cause all errors inside."""
    try:
        file = Path(path).open("rb")  # noqa: SIM115  # Closed below, also after an error.
    except (OSError, ValueError, TypeError) as error:
        raise ParameterError("run", str(path), f"a readable file ({reason(error)})") from error
    try:
        # Of a pipe, whose end may never come, no more than a run can hold.
        content = file if file.seekable() else io.BytesIO(file.read(_MAX_UNPACKED))
        with file, np.load(content, allow_pickle=False) as archive:
            size = content.seek(0, io.SEEK_END)
            unpacked = sum(member.file_size for member in archive.zip.infolist())
            if unpacked > max(_MAX_UNPACKED, _MAX_RATIO * size):
                raise DragonError(f"its {size} bytes unpack to {unpacked}, and no run does that")
            notes = json.loads(archive["notes"].tobytes())
            if (notes["format"], notes["format_version"]) != (_FORMAT, _FORMAT_VERSION):
                found = f"{notes['format']} {notes['format_version']}"
                known = f"{_FORMAT} {_FORMAT_VERSION}"
                raise DragonError(f"its format is {found}, and this version reads {known}")
            yield notes, archive
    except DragonError as error:
        raise FileFormatError(path, f"a damaged run: {error}") from error
    except Exception as error:
        # A damaged archive makes zipfile, its decompressors, NumPy and JSON raise nearly anything.
        raise FileFormatError(path, "no run of pymunk_dragon, or a damaged one") from error


def versions() -> dict[str, str]:
    """Versions of Python and of the libraries that decide a run's numbers."""
    # It imports what reads mail, which takes long in a page.
    from importlib.metadata import version

    names = ("pymunk-dragon", "pymunk", "numpy")
    return {"python": platform.python_version()} | {name: version(name) for name in names}


def _attributes(provenance: Mapping[str, Any], march: March, start: float) -> dict[str, Any]:
    """Attributes of a run from its `provenance`; `start` is the time of its first frame, s."""
    names = "player", "guide", "free_from", "substeps", "versions"
    given = {name: provenance.get(name) for name in names}
    for name in ("player", "guide"):
        instance(name, given[name], str | NoneType, "a text")
    instance("versions", given["versions"], Mapping | NoneType, "a mapping")
    ranges = {"substeps": (0, sys.maxsize), "free_from": (1, march.dragon.benches - 1)}
    for name, bounds in ranges.items():
        if given[name] is not None:
            whole(name, given[name], *bounds)

    known = provenance.keys() & {each.name for each in fields(EngineSettings)}
    settings = EngineSettings(**{name: provenance[name] for name in known}) if known else None
    start = finite("start", provenance.get("start", start), -math.inf, math.inf, "s")
    return given | {"versions": given["versions"] or {}, "settings": settings, "start": start}


def _differences(times: Array, poses: Array) -> Array:
    """Rates of change (F, N, 3) of `poses`, by differences of second order.

    Those of one interval are of first order. Frames that are near have the same.
    """
    if times.size < 2 or len(poses) != len(times):
        return np.zeros_like(poses)
    kept = [0]
    for frame, time in enumerate(times.tolist()):
        if time - times[kept[-1]] >= _LEAST_DIFFERENCE:
            kept.append(frame)
    if len(kept) == 1:
        # All of a very short run.
        kept.append(times.size - 1)

    poses = poses.copy()
    poses[..., 2] = np.unwrap(poses[..., 2], axis=0)
    order: Any = min(2, len(kept) - 1)
    rates: Array = np.gradient(poses[kept], times[kept], axis=0, edge_order=order)
    return rates[np.searchsorted(times[kept], times, side="right") - 1]


def position_errors(dragon: Dragon, poses: Array, exact: Array) -> Array:
    """Distances (..., N), m, of the worse hole of benches at `poses` (..., N, 3) from its handle.

    The `exact` handles are (..., N + 1, 2).
    """
    front, rear = dragon.holes(poses)
    ahead = np.linalg.norm(front - exact[..., :-1, :], axis=-1)
    behind = np.linalg.norm(rear - exact[..., 1:, :], axis=-1)
    return np.asarray(np.maximum(ahead, behind))
