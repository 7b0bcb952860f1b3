"""What either player produced, and where it came from."""

from __future__ import annotations

import io
import json
import platform
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, fields
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon.checks import word
from pymunk_dragon.contact import PHASES, Contact, ContactEvent, ContactLog
from pymunk_dragon.display import Displayed
from pymunk_dragon.dragon import interpolated
from pymunk_dragon.errors import DragonError, FileFormatError, ParameterError
from pymunk_dragon.files import check_destination, written_in_place
from pymunk_dragon.march import March, check_march
from pymunk_dragon.scenario import Scenario

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
ARRAYS = ("times", "poses", "drift", "joint_impulses")
MAY_LACK = ("joint_impulses",)


@dataclass(frozen=True, kw_only=True)
class Run(Displayed):
    """A dragon's run over F frames of N benches.

    Attributes
    ----------
    march : March
        What was played.
    times : ndarray, shape (F,)
        Times of the frames, s, rising. After a contact that ended the run, the last one is the contact's.
    poses : ndarray, shape (F, N, 3)
        Pose of every bench: centre in m, angle in rad.
    drift : ndarray, shape (F, N)
        How far each bench's worse hole is from where the exact model has it, m; nan where that has no place for it.
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
    joint_impulses: Array | None = None
    events: ContactLog = field(default_factory=ContactLog)
    first_contact: Contact | None = None
    outcome: Outcome = "clear"
    provenance: Mapping[str, Any] = field(default_factory=dict)
    timing: Mapping[str, float] = field(default_factory=dict, compare=False)

    def __post_init__(self) -> None:
        check_march(self.march)
        frames, benches = len(self.times), self.march.dragon.benches
        shapes = {"times": (frames,), "poses": (frames, benches, 3), "drift": (frames, benches)}
        if self.joint_impulses is not None:
            shapes["joint_impulses"] = (frames, benches - 1)
        for name, shape in shapes.items():
            # A copy, because the giver's array is the giver's to change.
            array = np.array(getattr(self, name), dtype=float)
            if array.shape != shape:
                raise DragonError(f"a run's {name} have shape {array.shape}, but its march wants {shape}")
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        if not frames or not np.all(np.isfinite(self.times)) or np.any(np.diff(self.times) < 0):
            raise DragonError("a run's times are not finite and rising, or there are none")
        word("outcome", self.outcome, get_args(Outcome))

    @classmethod
    def exact(cls, march: March, times: ArrayLike) -> Run:
        """The exact model's run, frame by frame, without a look at contacts."""
        check_march(march)
        states = march.at(times)
        drift = np.zeros(states.poses.shape[:2])
        provenance = {"player": "exact", "versions": versions()}
        return cls(march=march, times=states.times, poses=states.poses, drift=drift, provenance=provenance)

    @property
    def head_drift(self) -> float:
        """Largest drift of the first twelve benches, m."""
        return _largest(self.drift[:, :HEAD_BENCHES])

    @property
    def max_drift(self) -> float:
        """Largest drift of any bench, m."""
        return _largest(self.drift)

    def poses_at(self, times: ArrayLike) -> Array:
        """Poses (T, N, 3) at any times within the run, interpolated linearly between frames.

        The error is at most a frame interval squared times the acceleration over 8: 0.5 mm for a head on a turn of
        2.3 m radius at 1 m/s and frames 0.1 s apart.
        """
        t = np.atleast_1d(np.asarray(times, dtype=float))
        after = np.clip(np.searchsorted(self.times, t), 1, max(len(self.times) - 1, 1))
        if len(self.times) == 1:
            return np.repeat(self.poses, t.size, axis=0)
        begin, end = self.times[after - 1], self.times[after]
        # Two frames may share a time: a contact that falls on a frame adds another.
        share = np.clip((t - begin) / np.where(end > begin, end - begin, 1.0), 0.0, 1.0)[:, None]
        return interpolated(self.poses[after - 1], self.poses[after], share)

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
            "scenario": Scenario.of(self.march).to_mapping(),
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
            content = Path(path).read_bytes()
        except (OSError, ValueError) as error:
            reason = (isinstance(error, OSError) and error.strerror) or error
            raise ParameterError("run", str(path), f"a readable file ({reason})") from error
        try:
            with np.load(io.BytesIO(content), allow_pickle=False) as archive:
                arrays = {name: archive[name] for name in ARRAYS if name in archive or name not in MAY_LACK}
                notes = json.loads(archive["notes"].tobytes())
            return cls._from_parts(arrays, notes)
        except DragonError as error:
            raise FileFormatError(path, f"a damaged run: {error}") from error
        except Exception as error:
            # A damaged archive makes zipfile, its decompressors, NumPy and JSON raise nearly anything; whatever it is,
            # the content is to blame.
            raise FileFormatError(path, "no run of pymunk_dragon, or a damaged one") from error

    @classmethod
    def _from_parts(cls, arrays: dict[str, Array], notes: dict[str, Any]) -> Run:
        if notes["format"] != FORMAT or notes["format_version"] != FORMAT_VERSION:
            found = f"{notes['format']} {notes['format_version']}"
            raise DragonError(f"its format is {found}, and this version reads {FORMAT} {FORMAT_VERSION}")
        for name, array in arrays.items():
            if array.dtype != np.float64 or not (name == "drift" or np.all(np.isfinite(array))):
                raise DragonError(f"its {name} are not finite numbers")
        first = notes["first_contact"]
        return cls(
            march=Scenario.from_mapping(notes["scenario"]).march(),
            times=arrays["times"],
            poses=arrays["poses"],
            drift=arrays["drift"],
            joint_impulses=arrays.get("joint_impulses"),
            events=ContactLog(tuple(_read(ContactEvent, event) for event in notes["events"])),
            first_contact=None if first is None else _read(Contact, first),
            outcome=notes["outcome"],
            provenance=dict(notes["provenance"]),
        )


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
