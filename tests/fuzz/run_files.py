"""Run files (.npz): whole ones, ones with damaged bytes, and whole archives with damaged contents."""

from __future__ import annotations

import io
import json
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from damage import damaged, rarely
from harness import Case
from hypothesis import strategies as st

from pymunk_dragon.model.curves import Arc, Composite, Line, UTurn
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.physics import simulate

__all__ = ["cases", "whole_runs"]

COMMANDS = [
    ("report", "run.npz", "-o", "out.json"),
    ("report", "run.npz", "-o", "out.csv"),
    ("report", "run.npz", "-o", "out.md", "--json"),
    ("render", "run.npz", "-o", "out.png", "--size", "64"),
    ("render", "run.npz", "-o", "out.gif", "--size", "64", "--fps", "2", "--workers", "0"),
    ("render", "run.npz", "-o", "out.html"),
    ("render", "run.npz", "run.npz", "--exact", "-o", "out.png", "--size", "64x64"),
    ("figure", "drift", "run.npz", "-o", "out.png"),
]
FORMAT = ("format", "format_version")
# Values that JSON can hold, for any place in the notes of a run.
VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**20), 10**20)
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(["nan", "\x1b[2J", "a\nb", "path.csv", "/dev/zero", "../x.csv", 0, -1, 1e308, 10**400]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=6), inner, max_size=3),
    max_leaves=8,
)


@cache
def whole_runs() -> dict[str, bytes]:
    """Whole run files by name: of the engine up to a contact, of the exact model, and on a curve of pieces."""
    bend = Composite([Line(stop=(30, 0)), Arc(centre=(30, 3), radius=3, begin_angle=-np.pi / 2, sweep=3)])
    contact = March(Dragon(benches=10), turns=2.6, speed=2.0)
    runs = {
        "contact": simulate(contact, until=contact.end, frame_interval=0.5),
        "exact": Run.exact(March(Dragon(benches=4), UTurn(), speed=2), [-1.0, 0.0, 1.5]),
        "pieces": simulate(March(Dragon(benches=3), bend), until=0.2),
    }
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, run in runs.items():
            run.save(Path(folder) / "run.npz")
            found[name] = (Path(folder) / "run.npz").read_bytes()
    return found


@st.composite
def changed_notes(draw: st.DrawFn, notes: Any) -> Any:
    """Notes with one value in them replaced, left out or added."""
    if isinstance(notes, dict | list) and notes and not rarely(draw, 20):
        # Everything else is read only where the format is right.
        keys = [key for key in notes if key not in FORMAT] if isinstance(notes, dict) else list(range(len(notes)))
        key = draw(st.sampled_from(keys or list(notes)))
        changed = notes.copy()
        match draw(st.integers(0, 19)):
            case 3:
                del changed[key]
            case 4 if isinstance(changed, dict):
                changed[draw(st.text(max_size=6))] = draw(VALUES)
            case 5 if isinstance(changed, list):
                changed *= draw(st.integers(0, 5))
            case _:
                changed[key] = draw(changed_notes(notes[key]))
        return changed
    if isinstance(notes, int | float) and not rarely(draw, 5):
        return notes * draw(st.sampled_from([0, -1, 0.5, 2, 1.001])) + draw(st.sampled_from([0, 0, 1, -1, 1e-9, 1e9]))
    return draw(VALUES)


@st.composite
def changed_array(draw: st.DrawFn, array: np.ndarray) -> np.ndarray:
    """An array of another shape or type, or with other numbers in it."""
    match draw(st.integers(0, 6)):
        case 0:
            return array.astype(draw(st.sampled_from(["f4", "i8", "c16", "U5", "?", "M8[s]", "f2", ">f8"])))
        case 1:
            return array[: draw(st.integers(0, 2))]
        case 2:
            return array[..., None] if draw(st.booleans()) else array.ravel()
        case 3:
            return np.asfortranarray(array) * draw(st.floats())
        case 4:
            return np.repeat(array, draw(st.integers(2, 5)), axis=0)
        case 5:
            return array[::-1]
        case _:
            other = np.array(array)
            if other.size:
                other.flat[draw(st.integers(0, other.size - 1))] = draw(st.floats())
            return other


@st.composite
def changed_archive(draw: st.DrawFn, whole: bytes) -> bytes:
    """A whole archive with one to three of its contents damaged."""
    with np.load(io.BytesIO(whole)) as archive:
        arrays = dict(archive)
    notes = json.loads(arrays.pop("notes").tobytes())
    packed = None
    for _ in range(draw(st.sampled_from([1, 1, 1, 2, 3]))):
        match draw(st.integers(0, 9)):
            case 3 if arrays:
                del arrays[draw(st.sampled_from(sorted(arrays)))]
            case 4 | 5 if arrays:
                name = draw(st.sampled_from(sorted(arrays)))
                with np.errstate(all="ignore"):
                    arrays[name] = draw(changed_array(arrays[name]))
            case 6:
                packed = draw(damaged(json.dumps(notes).encode()))
            case _:
                notes = draw(changed_notes(notes))
    packed = packed if packed is not None else json.dumps(notes).encode()
    buffer = io.BytesIO()
    np.savez_compressed(buffer, notes=np.frombuffer(packed, dtype=np.uint8), **arrays)
    return buffer.getvalue()


@st.composite
def cases(draw: st.DrawFn) -> Case:
    """A command that reads a damaged run."""
    whole = draw(st.sampled_from(sorted(whole_runs().values())))
    content = draw(damaged(whole) if rarely(draw, 5) else changed_archive(whole))
    command = draw(st.sampled_from(COMMANDS))
    files = {"run.npz": content}
    if draw(st.booleans()):
        files[command[command.index("-o") + 1]] = b"what was there before"
    return Case(command, files)
