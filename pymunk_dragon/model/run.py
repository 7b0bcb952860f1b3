"""What either player produced, and where it came from."""

from __future__ import annotations

import io
import json
import math
import os
import platform
import stat
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon._checks import word
from pymunk_dragon._display import Displayed
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon._frozen import ArrayRecord, frozen, read_only
from pymunk_dragon.errors import DragonError, FileFormatError, ParameterError
from pymunk_dragon.model.contact import PHASES, Contact, ContactEvent, ContactLog
from pymunk_dragon.model.dragon import hermite
from pymunk_dragon.model.march import March, check_march
from pymunk_dragon.model.scenario import Scenario

__all__ = ["HEAD_BENCHES", "RUN_ENDINGS", "Outcome", "Run", "check_saveable", "versions"]

Array = NDArray[np.float64]
T = TypeVar("T", Contact, ContactEvent)
# How a run ended: at a contact, without one, or because the curve could no longer take the head.
Outcome = Literal["contact", "clear", "unreachable"]

# The first twelve benches are the ones that the head meets: their drift decides whether the first contact is the true
# one.
HEAD_BENCHES = 12
RUN_ENDINGS = (".npz",)
FORMAT = "pymunk_dragon run"
FORMAT_VERSION = 1
# What a file holds beside its notes, and what of it the runs of some players do not have.
ARRAYS = ("times", "poses", "drift", "pose_velocities", "joint_impulses")
MAY_LACK = ("pose_velocities", "joint_impulses")
# Bytes that a file may unpack to, and of its notes, which take up to 30 times as much as Python objects. Larger ones
# are accepted where the file is large: positions of moving benches hardly get smaller by packing, callbacks to a tenth.
MAX_UNPACKED, MAX_NOTES, MAX_RATIO = 512_000_000, 32_000_000, 10
# Frames nearer to each other than this share of the median interval count as one where velocities come from finite
# differences: the errors of their poses, divided by so short a time, would be velocities of their own.
LEAST_INTERVAL = 0.5
# Frames whose polynomial gives such a velocity: its error is then of a higher order than the cubic's own.
DIFFERENCE_POINTS = 5


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Run(ArrayRecord, Displayed):
    """A dragon's run over F frames of N benches.

    Two runs are equal if everything but their `timing` is, every number to the last bit.

    Attributes
    ----------
    march : March
        What was played.
    times : ndarray, shape (F,)
        Times of the frames, s, rising. After a contact that ended the run, the last one is the contact's.
    poses : ndarray, shape (F, N, 3)
        Pose of every bench: centre in m, angle in rad.
    drift : ndarray, shape (F, N)
        Position error of each bench's worse hole against the exact model, m; nan where the model has no state.
    pose_velocities : ndarray, shape (F, N, 3), or None
        Rates of change of `poses`: m/s, m/s, rad/s. None where they are unknown, as in files of older versions.
    joint_impulses : ndarray, shape (F, N - 1), or None
        Size of the impulse in each pivot, N s, in the substep that ended at the frame; pivot i joins benches i and
        i + 1. At a contact that ended the run it is the substep of the contact, blow included. None where no engine
        played.
    events : ContactLog
        Every collision callback.
    first_contact : Contact or None
        The first contact of benches that are not neighbours.
    outcome : {"contact", "clear", "unreachable"}
        Whether a contact came, none came until the end, or the curve ended first.
    provenance : mapping
        Player, settings and versions, as JSON values.
    timing : mapping
        How long playing took: `wall_seconds` of the stepping loop, and `step_seconds` of them inside the engine. Not
        saved, so that the same scenario gives the same file.
    """

    march: March
    times: Array
    poses: Array
    drift: Array
    pose_velocities: Array | None = None
    joint_impulses: Array | None = None
    events: ContactLog = field(default_factory=ContactLog)
    first_contact: Contact | None = None
    outcome: Outcome = "clear"
    provenance: Mapping[str, Any] = field(default_factory=dict)
    timing: Mapping[str, float] = field(default_factory=dict, compare=False)

    def __post_init__(self) -> None:
        check_march(self.march)
        frames = len(self.times)
        for name, shape in _shapes(self.march, frames).items():
            if name in MAY_LACK and getattr(self, name) is None:
                continue
            # A copy, because the giver's array is the giver's to change.
            array = np.array(getattr(self, name), dtype=float)
            if array.shape != shape:
                raise DragonError(f"a run's {name} have shape {array.shape}, but its march wants {shape}")
            object.__setattr__(self, name, read_only(array))
        for name in ("provenance", "timing"):
            object.__setattr__(self, name, frozen(getattr(self, name)))
        if not frames or not np.all(np.isfinite(self.times)) or np.any(np.diff(self.times) < 0):
            raise DragonError("a run's times are not finite and rising, or there are none")
        word("outcome", self.outcome, get_args(Outcome))

    def __repr__(self) -> str:
        frames = f"{len(self.times)} frames from {self.times[0]:g} s to {self.times[-1]:g} s"
        return f"Run({self.march.dragon.benches} benches, {frames}, {self.outcome})"

    @classmethod
    def exact(cls, march: March, times: ArrayLike) -> Run:
        """The exact model's run, frame by frame, without a search for contacts."""
        check_march(march)
        states = march.at(times)
        drift = np.zeros(states.poses.shape[:2])
        provenance = {"player": "exact", "versions": versions()}
        return cls(
            march=march,
            times=states.times,
            poses=states.poses,
            drift=drift,
            pose_velocities=states.pose_velocities,
            provenance=provenance,
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

        Notes
        -----
        Between two frames, centres and angles are cubic Hermite polynomials of time, with the poses and the
        `pose_velocities` of both frames. The error is at most the interval to the fourth times the fourth derivative
        over 384: 0.02 um for a head on a turn of 2.3 m radius at 1 m/s and frames 0.1 s apart. No polynomial knows of
        a blow between two frames.

        A run without `pose_velocities` gets them from its poses by finite differences of fourth order: the derivative
        of the polynomial through the five frames about each one. A frame that follows the one before by less than half
        the median interval is not among the five.
        """
        return self._motion_at(times)[0]

    def pose_velocities_at(self, times: ArrayLike) -> Array:
        """Rates of change (T, N, 3) of what `poses_at` gives: m/s, m/s, rad/s. Before and after the run, its ends'."""
        return self._motion_at(times)[1]

    def _motion_at(self, times: ArrayLike) -> tuple[Array, Array]:
        t = np.atleast_1d(np.asarray(times, dtype=float))
        last = len(self.times) - 1
        after = np.clip(np.searchsorted(self.times, t), min(1, last), last)
        before = np.maximum(after - 1, 0)
        interval = self.times[after] - self.times[before]
        # Two frames may share a time: a contact that falls on a frame adds another.
        share = np.clip((t - self.times[before]) / np.where(interval > 0, interval, 1.0), 0.0, 1.0)
        velocities = self.frame_velocities
        return hermite(
            (self.poses[before], self.poses[after]),
            (velocities[before], velocities[after]),
            interval[:, None],
            share[:, None],
        )

    @cached_property
    def frame_velocities(self) -> Array:
        """The `pose_velocities`; where they are unknown, those of `poses_at`, from finite differences: (F, N, 3)."""
        if self.pose_velocities is not None:
            return self.pose_velocities
        intervals = np.diff(self.times)
        apart = intervals[intervals > 0]
        kept = [0]
        for frame, time in enumerate(self.times):
            if apart.size and time - self.times[kept[-1]] >= LEAST_INTERVAL * np.median(apart):
                kept.append(frame)
        if len(kept) == 1:
            return read_only(np.zeros_like(self.poses))
        times, poses = self.times[kept], self.poses[kept]
        poses[..., 2] = np.unwrap(poses[..., 2], axis=0)
        points = min(DIFFERENCE_POINTS, len(kept))
        first = np.clip(np.searchsorted(times, self.times) - points // 2, 0, len(kept) - points)
        nodes = first[:, None] + np.arange(points)
        velocities = np.zeros_like(self.poses)
        for node, weight in zip(nodes.T, _derivative_weights(times[nodes], self.times).T, strict=True):
            velocities += weight[:, None, None] * poses[node]
        return read_only(velocities)

    def save(self, path: str | Path) -> None:
        """Write the run as a NumPy archive (.npz, no pickle); an interrupted save leaves the old file or none.

        Raises
        ------
        ParameterError
            If the ending is not .npz, the folder cannot be written, or the march has no scenario: see `check_saveable`.
        OutputError
            If writing fails.
        """
        notes = {
            "format": FORMAT,
            "format_version": FORMAT_VERSION,
            "scenario": Scenario.of(self.march).to_dict(),
            "outcome": self.outcome,
            "first_contact": asdict(self.first_contact) if self.first_contact else None,
            "events": [asdict(event) for event in self.events],
            "provenance": dict(self.provenance),
        }
        packed = np.frombuffer(json.dumps(notes).encode(), dtype=np.uint8)
        arrays = {name: getattr(self, name) for name in ARRAYS if getattr(self, name) is not None}
        with written_in_place(check_destination(path, RUN_ENDINGS)) as draft, draft.open("wb") as file:
            np.savez_compressed(file, notes=packed, **arrays)

    @classmethod
    def load(cls, path: str | Path) -> Run:
        """Read a run that `save` wrote.

        Raises
        ------
        ParameterError
            If there is no such file, or it cannot be read.
        FileFormatError
            If the file is damaged, cut off, of another program or of a newer format.
        """
        try:
            file = Path(path).open("rb")  # noqa: SIM115 (closed below, where what is wrong is the content)
        except (OSError, ValueError) as error:
            reason = (isinstance(error, OSError) and error.strerror) or error
            raise ParameterError("run", str(path), f"a readable file ({reason})") from error
        try:
            with file:
                # Of a pipe or a device, whose end may never come, no more than a run can hold.
                is_file = stat.S_ISREG(os.fstat(file.fileno()).st_mode)
                with zipfile.ZipFile(file if is_file else io.BytesIO(file.read(MAX_UNPACKED))) as archive:
                    return cls._from_archive(archive)
        except DragonError as error:
            raise FileFormatError(path, f"a damaged run: {error}") from error
        except Exception as error:
            # A damaged archive makes zipfile, its decompressors, NumPy and JSON raise nearly anything; whatever it is,
            # the content is to blame.
            raise FileFormatError(path, "no run of pymunk_dragon, or a damaged one") from error

    @classmethod
    def _from_archive(cls, archive: zipfile.ZipFile) -> Run:
        """The run in an archive; nothing is unpacked whose size is not known to be right."""
        _check_sizes(archive)
        notes = json.loads(_unpacked(archive, "notes", np.uint8).tobytes())
        if notes["format"] != FORMAT or notes["format_version"] != FORMAT_VERSION:
            found = f"{notes['format']} {notes['format_version']}"
            raise DragonError(f"its format is {found}, and this version reads {FORMAT} {FORMAT_VERSION}")
        march = Scenario.from_dict(notes["scenario"], files=False).march()
        shapes = _shapes(march, len(_unpacked(archive, "times", np.float64)))
        present = [name for name in ARRAYS if f"{name}.npy" in archive.namelist() or name not in MAY_LACK]
        arrays = {name: _unpacked(archive, name, np.float64, shapes[name]) for name in present}
        for name, array in arrays.items():
            if not (name == "drift" or np.all(np.isfinite(array))):
                raise DragonError(f"its {name} are not finite numbers")
        first = notes["first_contact"]
        return cls(
            march=march,
            times=arrays["times"],
            poses=arrays["poses"],
            drift=arrays["drift"],
            pose_velocities=arrays.get("pose_velocities"),
            joint_impulses=arrays.get("joint_impulses"),
            events=ContactLog(tuple(_read(ContactEvent, event) for event in notes["events"])),
            first_contact=None if first is None else _read(Contact, first),
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


def _check_sizes(archive: zipfile.ZipFile) -> None:
    """Refuse an archive that unpacks to more than a run of its size can hold."""
    assert archive.fp is not None
    size = archive.fp.seek(0, os.SEEK_END)
    for name, most in (("notes.npy", MAX_NOTES), (None, MAX_UNPACKED)):
        unpacked = sum(member.file_size for member in archive.infolist() if name in (None, member.filename))
        if unpacked > max(most, MAX_RATIO * size):
            raise DragonError(f"its {size} bytes unpack to {unpacked}, and no run does that")


def _unpacked(
    archive: zipfile.ZipFile, name: str, kind: type[np.generic], shape: tuple[int, ...] | None = None
) -> NDArray[Any]:
    """A member of a run's archive, of numbers of one kind; of any length where no shape is given."""
    member = archive.getinfo(f"{name}.npy")
    with archive.open(member) as file:
        np.lib.format.read_magic(file)
        found, _, dtype = np.lib.format.read_array_header_1_0(file)
        if dtype != kind:
            raise TypeError(f"{name} are of the type {dtype}")
        if found != (shape or found[:1]):
            raise DragonError(f"its {name} have the shape {found}, but its scenario and times want {shape}")
        # What is said twice must be the same: memory is taken for the shape.
        if file.tell() + math.prod(found) * dtype.itemsize != member.file_size:
            raise DragonError(f"its {name} are not as long as they say")
    with archive.open(member) as file:
        return np.lib.format.read_array(file, allow_pickle=False)


def check_saveable(march: March) -> None:
    """Check that a run of a march can be saved, before the run is made.

    Every curve and speed of the package can be saved. A curve of a class of your own and a speed that is a function
    cannot, because a file holds values and no code.

    Raises
    ------
    ParameterError
        If `Run.save` would refuse a run of this march: names the part that cannot be written down.

    Examples
    --------
    >>> from pymunk_dragon import March
    >>> check_saveable(March())
    >>> check_saveable(March(speed=lambda t: 1 + 0 * t))  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    pymunk_dragon.errors.ParameterError: speed is <function ...>, but must be a number or a table to be written down...
    """
    Scenario.of(march)


def versions() -> dict[str, str]:
    """Versions of what decides a run's numbers."""
    names = ("pymunk-dragon", "pymunk", "numpy")
    return {"python": platform.python_version()} | {name: version(name) for name in names}


def _derivative_weights(nodes: Array, times: Array) -> Array:
    """Weights (F, P) of values at `nodes` (F, P) in the derivative at `times` (F,) of the polynomial through them."""
    weights = np.zeros_like(nodes)
    every = range(nodes.shape[1])
    for j in every:
        for m in every:
            if m != j:
                product = 1 / (nodes[:, j] - nodes[:, m])
                for k in every:
                    if k not in (j, m):
                        product = product * (times - nodes[:, k]) / (nodes[:, j] - nodes[:, k])
                weights[:, j] += product
    return weights


def _largest(drift: Array) -> float:
    known = drift[np.isfinite(drift)]
    return float(known.max()) if known.size else float("nan")


def _real(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise DragonError(f"{value!r} is no number")
    return value


def _vector(value: Any) -> tuple[float, float]:
    x, y = value
    return _real(x), _real(y)


def _vectors(value: Any) -> tuple[tuple[float, float], ...]:
    return tuple(_vector(item) for item in value)


def _pair(value: Any) -> tuple[int, int]:
    first, second = value
    if not (type(first) is type(second) is int and 0 <= first < second):
        raise DragonError(f"{value!r} are no two benches")
    return first, second


def _phase(value: Any) -> str:
    if value not in PHASES:
        raise DragonError(f"{value!r} is no phase of a contact")
    return str(value)


# How each entry of a contact or an event is read back from JSON.
READERS: Mapping[str, Callable[[Any], Any]] = {
    "time": _real,
    "raw_time": _real,
    "phase": _phase,
    "benches": _pair,
    "point": _vector,
    "points": _vectors,
    "normal": _vector,
    "depth": _real,
    "relative_velocity": _vector,
    "impulse": _vector,
}


def _read(kind: type[T], values: dict[str, Any]) -> T:
    """A contact or an event as it was before `asdict` and JSON, which has lists for tuples."""
    absent = {f.name for f in fields(kind) if f.default is None}
    read: dict[str, Any] = {}
    for name, value in values.items():
        read[name] = None if value is None and name in absent else READERS[name](value)
    return kind(**read)
