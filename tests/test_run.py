"""What a player produced: frames in between, and files that come back whole or not at all."""

from __future__ import annotations

import errno
import io
import json
import math
import os
import pickle
import tempfile
import tracemalloc
import warnings
import zipfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import FrozenInstanceError, asdict, replace
from pathlib import Path

import numpy as np
import pytest
from conftest import assert_says, examples
from hypothesis import given
from hypothesis import strategies as st
from shapely import Polygon

from pymunk_dragon.errors import DragonError, FileFormatError, OutputError, ParameterError
from pymunk_dragon.model.contact import Contact, ContactEvent, ContactLog
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.provenance import versions
from pymunk_dragon.model.run import Run
from pymunk_dragon.model.settings import EngineSettings

MARCH = March(Dragon(benches=4, width=0.29), Spiral(pitch=0.6), turns=9.5, speed=1.25)
EVENTS = ContactLog(
    (
        ContactEvent(
            time=0.1 + 0.2,
            phase="begin",
            benches=(0, 2),
            points=((0.1, -1e-300), (1 / 3, 2.0)),
            normal=(0.6, 0.8),
            depth=1e-9,
            relative_velocity=(-0.0, 5e-324),
        ),
        ContactEvent(time=0.4, phase="post_solve", benches=(0, 2), points=((0.0, 0.0),), impulse=(1.0, -2.0)),
        ContactEvent(time=0.5, phase="separate", benches=(0, 2)),
    )
)
CONTACT = Contact(
    time=0.3141592653589793, raw_time=0.32, benches=(0, 2), point=(1.5, 2.5), normal=(1.0, 0.0), depth=0.25e-3
)


def a_run():
    states = MARCH.at(np.linspace(0, 3, 7))
    drift = np.full((7, 4), 1 / 3)
    drift[-1, 0] = np.nan
    return Run(
        march=MARCH,
        times=states.times,
        poses=states.poses,
        drift=drift,
        pose_velocities=states.pose_velocities,
        joint_impulses=np.linspace(0, 1, 21).reshape(7, 3) / 7,
        events=EVENTS,
        first_contact=CONTACT,
        outcome="contact",
        provenance={"player": "test", "settings": {"list": [1, 2.5, None, True], "text": "äöü\n"}},
    )


def saved(run):
    """The bytes that `save` writes."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "run.npz"
        run.save(file)
        return file.read_bytes()


WHOLE = saved(a_run())


def load(content):
    """Load from bytes, as from a file, with every warning an error."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("error")
        file = Path(folder) / "run.npz"
        file.write_bytes(content)
        return Run.load(file)


def members(**changes):
    """An archive like that of `save`, with some arrays changed; None leaves one out."""
    with np.load(io.BytesIO(WHOLE)) as archive:
        arrays = dict(archive) | changes
    buffer = io.BytesIO()
    np.savez(buffer, **{name: array for name, array in arrays.items() if array is not None})
    return buffer.getvalue()


def notes(change):
    """An archive like that of `save`, with its notes put through `change`."""
    with np.load(io.BytesIO(WHOLE)) as archive:
        values = json.loads(archive["notes"].tobytes())
    changed = change(values)
    text = json.dumps(values if changed is None else changed).encode()
    return members(notes=np.frombuffer(text, dtype=np.uint8))


def assert_refused(content, *words):
    with pytest.raises(FileFormatError) as caught:
        load(content)
    assert str(caught.value).count("run.npz") == 1
    assert "\n" not in str(caught.value)
    for word in words or ["no run of pymunk_dragon, or a damaged one"]:
        assert word in str(caught.value)


# Round trip


def test_run_comes_back_exactly():
    run, back = a_run(), load(WHOLE)
    for name in ("times", "poses", "drift", "pose_velocities", "joint_impulses"):
        assert getattr(back, name).tobytes() == getattr(run, name).tobytes()
        assert getattr(back, name).shape == getattr(run, name).shape
    for name in ("march", "events", "first_contact", "outcome", "provenance"):
        assert getattr(back, name) == getattr(run, name)
    assert str(back.events[0].relative_velocity) == "(-0.0, 5e-324)"


def test_run_without_contact_comes_back_exactly():
    run = Run.exact(MARCH, [0, 1, 2])
    back = load(saved(run))
    assert back.events == run.events == ContactLog()
    assert back.first_contact is None
    assert back.joint_impulses is None
    assert back.outcome == "clear"
    assert back.provenance == {"player": "exact", "versions": versions()}


def test_run_saved_twice_is_the_same_file_and_so_is_a_loaded_one():
    assert saved(a_run()) == WHOLE == saved(load(WHOLE))


@given(st.lists(st.lists(st.floats(allow_nan=True), min_size=4, max_size=4), min_size=7, max_size=7))
@examples(30)
def test_any_drift_comes_back_bit_by_bit(drift):
    values = np.array(drift)
    run = Run(march=MARCH, times=np.arange(7.0), poses=np.zeros((7, 4, 3)), drift=values)
    assert load(saved(run)).drift.tobytes() == values.tobytes()


def test_numbers_of_a_narrower_kind_are_saved_as_doubles():
    run = Run(
        march=MARCH,
        times=np.arange(2),
        poses=np.ones((2, 4, 3), dtype=np.float32),
        drift=np.asfortranarray(np.zeros((2, 4))),
    )
    assert load(saved(run)).poses.tolist() == run.poses.tolist()


def test_scenario_of_numpy_scalars_is_saved():
    march = March(Dragon(benches=np.int64(3), width=np.float32(0.25)), turns=np.int32(12))
    assert load(saved(Run.exact(march, [0]))).march == march


# Damage


@given(st.integers(0, len(WHOLE) - 1))
@examples(200)
def test_truncated_run_is_refused(length):
    assert_refused(WHOLE[:length])


@given(st.binary(max_size=2000))
def test_random_bytes_are_refused(content):
    assert_refused(content)


@given(st.lists(st.tuples(st.integers(0, len(WHOLE) - 1), st.integers(1, 255)), min_size=1, max_size=4))
@examples(600)
def test_flipped_bytes_are_refused_or_do_no_harm(flips):
    content = bytearray(WHOLE)
    for place, change in flips:
        content[place] ^= change
    try:
        run = load(bytes(content))
    except FileFormatError as error:
        assert_says(error)
    else:
        assert run.poses.tobytes() == a_run().poses.tobytes()
        assert run.events == EVENTS


@pytest.mark.parametrize("name", ["times", "poses", "drift", "notes"])
@pytest.mark.parametrize("flips", [1, 7, 60])
def test_flipped_bytes_inside_an_array_that_the_archive_vouches_for_are_refused_or_harmless(name, flips):
    with np.load(io.BytesIO(WHOLE)) as archive:
        inner = io.BytesIO()
        np.save(inner, archive[name])
    random = np.random.default_rng(flips)
    for _ in range(40):
        content = bytearray(inner.getvalue())
        for place in random.integers(0, min(len(content), 400), flips):
            content[place] ^= int(random.integers(1, 256))
        buffer = io.BytesIO(WHOLE)
        out = io.BytesIO()
        with zipfile.ZipFile(buffer) as old, zipfile.ZipFile(out, "w") as new:
            for member in old.namelist():
                new.writestr(member, bytes(content) if member == f"{name}.npy" else old.read(member))
        try:
            run = load(out.getvalue())
        except FileFormatError as error:
            assert_says(error)
        else:
            assert np.all(np.isfinite(run.times))
            assert np.all(np.isfinite(run.poses))


def npy(array):
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def zipped(**contents):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in contents.items():
            archive.writestr(name, content)
    return buffer.getvalue()


def foreign():
    buffer = io.BytesIO()
    np.savez(buffer, a=np.arange(3), b=np.eye(2))
    return buffer.getvalue()


FOREIGN = {
    "empty": b"",
    "text": b"a dragon went by\n" * 30,
    "a single array": npy(np.arange(10.0)),
    "another archive of arrays": foreign(),
    "an archive of something else": zipped(readme="hello", data="1,2,3"),
    "an empty archive": zipped(),
    "arrays that are none": zipped(**{f"{name}.npy": b"hello" for name in ("times", "poses", "drift", "notes")}),
    "notes that are no JSON": members(notes=np.frombuffer(b"{hello", dtype=np.uint8)),
    "notes of another kind": members(notes=np.eye(3)),
    "notes nested without end": members(notes=np.frombuffer(b"[" * 100_000, dtype=np.uint8)),
    "no notes": members(notes=None),
    "no poses": members(poses=None),
    "a list for notes": notes(lambda values: [values]),
    "a number for notes": notes(lambda values: 3),
    "no scenario": notes(lambda values: values.pop("scenario") and None),
    "no events": notes(lambda values: values.pop("events") and None),
    "a number for events": notes(lambda values: values.update(events=3)),
    "a text for a scenario": notes(lambda values: values.update(scenario="hello")),
    "a number for provenance": notes(lambda values: values.update(provenance=3)),
}


@pytest.mark.parametrize("content", FOREIGN.values(), ids=FOREIGN.keys())
def test_foreign_file_is_refused(content):
    assert_refused(content)


class Bomb:
    """An object whose unpickling would leave a file."""

    def __init__(self, path):
        self.path = str(path)

    def __reduce__(self):
        return open, (self.path, "w")


@pytest.mark.parametrize("name", ["times", "poses", "drift", "notes"])
def test_pickled_objects_are_never_unpickled(tmp_path, name):
    file, trace = tmp_path / "run.npz", tmp_path / "trace"
    with np.load(io.BytesIO(WHOLE)) as archive:
        arrays = dict(archive)
    np.savez(file, **(arrays | {name: np.array([Bomb(trace)], dtype=object)}))
    with pytest.raises(FileFormatError):
        Run.load(file)
    assert not trace.exists()
    # The trap works: NumPy, told to trust the file, springs it.
    with np.load(file, allow_pickle=True) as archive:
        archive[name][0].close()
    assert trace.exists()


def test_bare_pickle_is_never_unpickled(tmp_path):
    file, trace = tmp_path / "run.npz", tmp_path / "trace"
    file.write_bytes(pickle.dumps(Bomb(trace)))
    with pytest.raises(FileFormatError):
        Run.load(file)
    assert not trace.exists()


MISFITS = {
    "poses of another dragon": members(poses=np.zeros((7, 5, 3))),
    "poses of another time": members(poses=np.zeros((6, 4, 3))),
    "velocities of another dragon": members(pose_velocities=np.zeros((7, 5, 3))),
    "infinite velocities": members(pose_velocities=np.full((7, 4, 3), np.inf)),
    "flat poses": members(poses=np.zeros((7, 4))),
    "times as a table": members(times=np.zeros((7, 1))),
    "one time": members(times=np.array(1.0)),
    "no frames": members(times=np.empty(0), poses=np.empty((0, 4, 3)), drift=np.empty((0, 4))),
    "drift of other handles": members(drift=np.zeros((7, 3))),
    "impulses of other joints": members(joint_impulses=np.zeros((7, 4))),
    "infinite impulses": members(joint_impulses=np.full((7, 3), np.inf)),
    "whole numbers for times": members(times=np.arange(7)),
    "halves for poses": members(poses=np.zeros((7, 4, 3), dtype=np.float16)),
    "texts for poses": members(poses=np.full((7, 4, 3), "a")),
    "falling times": members(times=np.arange(7.0)[::-1].copy()),
    "nan among times": members(times=np.array([0, 1, 2, np.nan, 4, 5, 6.0])),
    "infinite poses": members(poses=np.full((7, 4, 3), np.inf)),
}


@pytest.mark.parametrize("content", MISFITS.values(), ids=MISFITS.keys())
def test_arrays_that_do_not_fit_are_refused(content):
    with pytest.raises(FileFormatError) as caught:
        load(content)
    assert_says(caught.value)


def first_event(**changes):
    return lambda values: values["events"][0].update(changes)


def contact(**changes):
    return lambda values: values["first_contact"].update(changes)


WRONG_NOTES = {
    "another format": lambda values: values.update(format="a film"),
    "a newer format": lambda values: values.update(format_version=2),
    "an unknown outcome": lambda values: values.update(outcome="victory"),
    "a list for an outcome": lambda values: values.update(outcome=["clear"]),
    "an unknown parameter": lambda values: values["scenario"].update(colour="red"),
    "an impossible parameter": lambda values: values["scenario"].update(pitch=-1),
    "another number of benches": lambda values: values["scenario"].update(benches=5),
    "an event with another key": first_event(colour="red"),
    "an event with an unknown phase": first_event(phase="end"),
    "an event without a time": lambda values: values["events"][0].pop("time") and None,
    "an event at no time": first_event(time=None),
    "an event at a text": first_event(time="noon"),
    "an event of one bench": first_event(benches=[1]),
    "an event of benches in the wrong order": first_event(benches=[2, 0]),
    "an event of half a bench": first_event(benches=[0, 2.5]),
    "an event with a number for points": first_event(points=3),
    "an event with points in space": first_event(points=[[1, 2, 3]]),
    "an event with a true impulse": first_event(impulse=[True, 1.0]),
    "an event of a bench that is not there": first_event(benches=[0, 4]),
    "an event at the end of time": first_event(time=math.inf),
    "a contact of a bench that is not there": contact(benches=[3, 4]),
    "a number for an event": lambda values: values.update(events=[3]),
    "a contact with another key": contact(colour="red"),
    "a contact without a point": contact(point=None),
    "a contact with a text for a depth": contact(depth="deep"),
    "a false contact": lambda values: values.update(first_contact=False),
    "a contact without anything": lambda values: values.update(first_contact={}),
}


@pytest.mark.parametrize("change", WRONG_NOTES.values(), ids=WRONG_NOTES.keys())
def test_wrong_notes_are_refused(change):
    with pytest.raises(FileFormatError) as caught:
        load(notes(change))
    assert_says(caught.value)


ENGINE = {"player": "pymunk", "guide": "rails", "contacts": "resolve", "start": -0.5, "substep": 0.01, "substeps": 350}


def test_attributes_come_from_provenance():
    run = replace(a_run(), provenance=ENGINE | {"iterations": 7, "head_force": 300.0, "versions": {"numpy": "2"}})
    assert (run.player, run.guide, run.start, run.substep, run.substeps) == ("pymunk", "rails", -0.5, 0.01, 350)
    assert run.settings == EngineSettings(contacts="resolve", substep=0.01, iterations=7, head_force=300.0)
    assert run.versions == {"numpy": "2"}
    assert load(saved(run)).settings == run.settings
    exact = Run.exact(MARCH, [1.5, 2])
    assert (exact.player, exact.guide, exact.settings, exact.start, exact.substeps) == ("exact", None, None, 1.5, None)


IMPOSSIBLE = {
    "player": 3,
    "guide": ["rails"],
    "contacts": "ignore",
    "start": "noon",
    "substep": -0.01,
    "substeps": 2.5,
    "iterations": 0,
    "drag": True,
    "head_force": "much",
    "versions": "2",
}


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_impossible_provenance_is_refused_when_it_is_loaded(name):
    change = {**ENGINE, name: IMPOSSIBLE[name]}
    assert_refused(notes(lambda values: values.update(provenance=change)), f"a damaged run: {name} is")
    with pytest.raises(ParameterError):
        replace(a_run(), provenance=change)


def test_archive_that_is_packed_anew_loads():
    # The helper that the tests above change archives with does no damage of its own.
    assert load(notes(lambda values: None)).events == EVENTS


def test_file_of_a_newer_format_says_so():
    assert_refused(notes(lambda values: values.update(format_version=2)), "its format is pymunk_dragon run 2")


@pytest.mark.parametrize("name", ["none.npz", "none/run.npz", ".", "nul\0.npz"])
def test_file_that_cannot_be_read_is_a_bad_parameter(tmp_path, name):
    with pytest.raises(ParameterError, match="a readable file") as caught:
        Run.load(tmp_path / name)
    assert caught.value.name == "run"
    assert "\n" not in str(caught.value)


# Files that would take the memory, or open others


def header(shape):
    """An array's file that says it has a shape, and no more."""
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": shape})
    return file.getvalue()


def archive_of(**contents):
    """The archive of a saved run with other contents of some members."""
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(WHOLE)) as old, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            new.writestr(name, contents.get(name.removesuffix(".npy"), old.read(name)))
    return out.getvalue()


def refusal(content):
    """Message with which a file is refused, and the most memory that Python took for it, bytes."""
    tracemalloc.start()
    try:
        with pytest.raises(FileFormatError) as caught:
            load(content)
        return str(caught.value), tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(("name", "size"), [("poses", 600_000_000), ("notes", 40_000_000)])
def test_archive_that_unpacks_to_more_than_a_run_is_refused_before_it_is_unpacked(name, size):
    # The size of a member stands 22 bytes before its name in the directory at the end of an archive.
    content = bytearray(WHOLE)
    place = content.rindex(f"{name}.npy".encode()) - 22
    content[place : place + 4] = size.to_bytes(4, "little")
    message, memory = refusal(bytes(content))
    assert "and no run does that" in message
    assert memory < 10e6


@pytest.mark.thorough
def test_bomb_of_frames_that_fit_the_scenario_is_refused():
    out, zeros = io.BytesIO(), bytes(1_000_000)
    shapes = {"times": (10_000_000,), "poses": (10_000_000, 4, 3), "drift": (10_000_000, 4)}
    with zipfile.ZipFile(io.BytesIO(WHOLE)) as old, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new:
        new.writestr("notes.npy", old.read("notes.npy"))
        for name, shape in shapes.items():
            with new.open(f"{name}.npy", "w") as file:
                file.write(header(shape))
                for _ in range(8 * math.prod(shape) // len(zeros)):
                    file.write(zeros)
    assert out.tell() < 2e6
    message, memory = refusal(out.getvalue())
    assert "and no run does that" in message
    assert memory < 10e6


@pytest.mark.parametrize(
    ("name", "shape"),
    [("poses", (7, 4, 30_000_000)), ("poses", (10**12, 4, 3)), ("drift", (7, 10**9)), ("times", (10**9,))],
)
def test_size_that_an_array_claims_is_checked_before_memory_is_taken(name, shape):
    message, memory = refusal(archive_of(**{name: header(shape)}))
    assert f"its {name}" in message
    assert memory < 10e6


def test_device_without_end_is_no_run():
    with pytest.raises(FileFormatError, match="/dev/zero: no run"):
        Run.load("/dev/zero")


def test_run_is_read_from_a_pipe(tmp_path):
    os.mkfifo(tmp_path / "run.npz")
    with ThreadPoolExecutor(1) as pool:
        pool.submit((tmp_path / "run.npz").write_bytes, WHOLE)
        assert Run.load(tmp_path / "run.npz").events == EVENTS


@pytest.mark.parametrize("name", ["curve", "speed"])
def test_loaded_run_opens_no_other_file(tmp_path, monkeypatch, name):
    (tmp_path / "other.csv").write_text("0,1\n10,1\n20,2\n30,1\n")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(FileFormatError) as caught:
        load(notes(lambda values: values["scenario"].update({name: "other.csv"})))
    assert_says(caught.value, name, "'other.csv'", "something else than the name of another file")


def test_text_of_a_file_reaches_no_terminal_as_it_is():
    with pytest.raises(FileFormatError) as caught:
        load(notes(lambda values: values.update(format="\x1b]0;owned\x07\u202e\x9b31m")))
    assert str(caught.value).isprintable()
    assert r"\x1b]0;owned\x07\u202e\x9b31m" in str(caught.value)


# Saving


@pytest.mark.parametrize(
    "interruption", [KeyboardInterrupt(), OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))], ids=repr
)
def test_save_cut_short_leaves_the_old_file_and_no_litter(tmp_path, monkeypatch, interruption):
    file = tmp_path / "run.npz"
    file.write_bytes(b"old")

    def half(stream, **_):
        stream.write(WHOLE[:100])
        stream.flush()
        raise interruption

    monkeypatch.setattr(np, "savez_compressed", half)
    with pytest.raises((KeyboardInterrupt, OutputError)) as caught:
        a_run().save(file)
    assert isinstance(interruption, KeyboardInterrupt) or str(caught.value).endswith("No space left on device")
    assert file.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize("name", ["run", "run.zip", "none/run.npz"])
def test_save_to_an_impossible_place_is_refused_and_leaves_nothing(tmp_path, name):
    with pytest.raises(ParameterError, match="output is"):
        a_run().save(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_provenance_that_is_no_json_leaves_nothing(tmp_path):
    run = Run(march=MARCH, times=[0], poses=np.zeros((1, 4, 3)), drift=np.zeros((1, 4)), provenance={"what": object()})
    with pytest.raises(TypeError):
        run.save(tmp_path / "run.npz")
    assert list(tmp_path.iterdir()) == []


# The run itself


def test_run_cannot_be_changed_and_leaves_the_givers_arrays_alone():
    times, poses, drift = np.arange(2.0), np.zeros((2, 4, 3)), np.zeros((2, 4))
    run = Run(march=MARCH, times=times, poses=poses, drift=drift)
    poses[0] = 7
    assert run.poses.max() == 0
    with pytest.raises(ValueError, match="read-only"):
        run.poses[0, 0, 0] = 1
    with pytest.raises(FrozenInstanceError):
        run.outcome = "contact"


@pytest.mark.parametrize(
    "changes",
    [
        {"times": np.empty(0), "poses": np.empty((0, 4, 3)), "drift": np.empty((0, 4))},
        {"times": np.array([1.0, 0.0])},
        {"times": np.array([0.0, np.nan])},
        {"poses": np.zeros((2, 3, 3))},
        {"drift": np.zeros((2, 5))},
        {"pose_velocities": np.zeros((2, 4, 2))},
        {"outcome": "victory"},
    ],
    ids=lambda changes: ", ".join(changes),
)
def test_frames_that_fit_no_march_are_refused(changes):
    given_frames = {"times": np.arange(2.0), "poses": np.zeros((2, 4, 3)), "drift": np.zeros((2, 4))} | changes
    with pytest.raises(DragonError, match=r"a run's|outcome is") as caught:
        Run(march=MARCH, **given_frames)
    assert_says(caught.value)


def test_exact_run_is_the_march_without_drift():
    run = Run.exact(MARCH, [0, 1.5])
    assert np.array_equal(run.poses, MARCH.at([0, 1.5]).poses)
    assert (run.head_drift, run.max_drift) == (0, 0)
    assert asdict(run.march.dragon) == asdict(MARCH.dragon)


def test_drift_of_the_head_looks_at_the_first_twelve_benches_and_past_what_is_unknown():
    march = March(Dragon(benches=20))
    drift = np.zeros((2, 20))
    drift[0, 11], drift[1, 12], drift[1, 0] = 1e-4, 2e-3, np.nan
    run = Run(march=march, times=[0, 1], poses=np.zeros((2, 20, 3)), drift=drift)
    assert (run.head_drift, run.max_drift) == (1e-4, 2e-3)
    unknown = Run(march=march, times=[0], poses=np.zeros((1, 20, 3)), drift=np.full((1, 20), np.nan))
    assert np.isnan(unknown.head_drift)
    assert np.isnan(unknown.max_drift)


def test_poses_at_the_frames_are_the_frames():
    run = a_run()
    back = run.poses_at(run.times)
    assert back[..., :2] == pytest.approx(run.poses[..., :2], abs=1e-15)
    assert np.cos(back[..., 2] - run.poses[..., 2]) == pytest.approx(np.ones((7, 4)), abs=1e-15)


def without_velocities(run):
    return replace(run, pose_velocities=None)


def gap_in(run, time, pair):
    """Distance of two benches of a run, by Shapely, m."""
    first, second = (Polygon(run.march.dragon.outlines(run.poses_at(time)[0])[bench]) for bench in pair)
    return first.distance(second)


# The gap of the exact model at the near miss, found by Shapely; with straight lines between frames it is 0.795 mm.
@pytest.mark.parametrize("known", [True, False], ids=["known velocities", "finite differences"])
def test_gap_of_the_near_miss_between_frames_is_the_exact_one(seed_march, known):
    run = Run.exact(seed_march, np.arange(4050, 4127) / 10)
    exact = Run.exact(seed_march, [409.832])
    assert gap_in(exact, 409.832, (0, 11)) == pytest.approx(0.865235e-3, abs=1e-9)
    run = run if known else without_velocities(run)
    assert gap_in(run, 409.832, (0, 11)) == pytest.approx(0.865235e-3, abs=1e-7)


# The docstring's bound, with the largest fourth derivative of any bench's pose: by finite differences of the model.
@pytest.mark.parametrize("known", [True, False], ids=["known velocities", "finite differences"])
def test_poses_between_frames_are_as_near_as_the_docstring_says(seed_march, known):
    times = np.arange(4080, 4120) / 10
    run = Run.exact(seed_march, times)
    run = run if known else without_velocities(run)
    at = np.arange(408.5, 411, 0.013)
    off = np.linalg.norm((run.poses_at(at) - seed_march.at(at).poses)[..., :2], axis=-1)
    h = 0.02
    around = [seed_march.at(at + k * h).poses[..., :2] for k in (-2, -1, 0, 1, 2)]
    fourth = np.linalg.norm(sum(w * p for w, p in zip((1, -4, 6, -4, 1), around, strict=True)), axis=-1) / h**4
    bound = 0.1**4 / 384 * fourth.max()
    assert 0.5 * bound < off.max() < 1.5 * bound
    assert bound < 0.05e-6


def moving(times, coefficients):
    """Poses and their rates of change where x, y and angle of each of 4 benches are polynomials of time."""
    polynomial = np.polynomial.Polynomial
    tracks = [[polynomial(track) for track in bench] for bench in coefficients]
    values = [[[track(t) for track in bench] for bench in tracks] for t in times]
    rates = [[[track.deriv()(t) for track in bench] for bench in tracks] for t in times]
    return np.array(values), np.array(rates)


@pytest.mark.parametrize("known", [True, False], ids=["known velocities", "finite differences"])
def test_cubic_motion_is_met_exactly(known):
    coefficients = np.random.default_rng(0).uniform(-1, 1, (4, 3, 4))
    # One frame stands so near to another that it takes no part in the differences.
    times = np.array([0, 0.1, 0.3, 0.3 + 1e-9, 0.45, 0.6, 0.62])
    poses, rates = moving(times, coefficients)
    run = Run(march=MARCH, times=times, poses=poses, drift=np.zeros((7, 4)), pose_velocities=rates if known else None)
    at = np.linspace(0, 0.62, 50)
    wanted, wanted_rates = moving(at, coefficients)
    np.testing.assert_allclose(run.poses_at(at), wanted, atol=1e-12)
    np.testing.assert_allclose(run.pose_velocities_at(at), wanted_rates, atol=1e-6)
    np.testing.assert_allclose(run.pose_velocities_at(times[[0, 4, 6]]), rates[[0, 4, 6]], atol=1e-11)
    np.testing.assert_allclose(run.pose_velocities_at([-1, 9]), rates[[0, -1]], atol=1e-11)


def test_frames_that_nearly_share_a_time_do_not_spoil_what_is_between_the_others():
    states = MARCH.at(np.array([0, 0.1, 0.2, 0.2 + 1e-7, 0.3, 0.4]))
    poses = states.poses + 1e-6 * np.random.default_rng(0).standard_normal(states.poses.shape)
    run = Run(march=MARCH, times=states.times, poses=poses, drift=np.zeros((6, 4)))
    times = np.linspace(0, 0.4, 41)
    assert np.abs(run.poses_at(times) - MARCH.at(times).poses).max() < 5e-6


def test_velocities_without_known_ones_are_those_of_the_march():
    run = without_velocities(Run.exact(MARCH, np.arange(30) / 10))
    times = np.linspace(0, 2.9, 57)
    np.testing.assert_allclose(run.pose_velocities_at(times), MARCH.at(times).pose_velocities, atol=1e-3)
    assert not without_velocities(Run.exact(MARCH, [1.0])).pose_velocities_at(1.0).any()


def test_file_of_an_older_version_has_no_velocities_and_is_read():
    old, run = load(members(pose_velocities=None)), a_run()
    assert old.pose_velocities is None
    assert old.poses.tobytes() == run.poses.tobytes()
    times = np.linspace(0, 3, 40)
    assert np.abs(old.poses_at(times) - run.poses_at(times)).max() < 0.01


def test_poses_turn_the_shorter_way_between_frames():
    poses = np.zeros((2, 4, 3))
    poses[0, :, 2], poses[1, :, 2] = 3.0, -3.0
    run = Run(march=MARCH, times=[0, 1], poses=poses, drift=np.zeros((2, 4)))
    assert np.abs(np.remainder(run.poses_at(0.5)[0, :, 2], 2 * np.pi) - np.pi) == pytest.approx(np.zeros(4), abs=1e-12)


def test_poses_before_and_after_the_run_are_its_ends():
    run = a_run()
    ends = run.poses_at([-5, 99])
    assert ends[..., :2] == pytest.approx(run.poses[[0, -1]][..., :2], abs=1e-15)


def test_poses_of_a_single_frame_are_that_frame():
    run = Run.exact(MARCH, [2.0])
    assert np.array_equal(run.poses_at([0, 2, 5]), np.repeat(run.poses, 3, axis=0))


def test_poses_are_known_where_two_frames_share_a_time():
    poses = np.arange(3.0)[:, None, None] * np.ones((3, 4, 3)) / 10
    for times in ([0, 0, 1], [0, 1, 1]):
        run = Run(march=MARCH, times=times, poses=poses, drift=np.zeros((3, 4)))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert np.all(np.isfinite(run.poses_at([0, 0.5, 1])))


# Values that stay as they are, are equal or not, and show themselves in a line


def changed(array):
    """A copy of an array whose first number is the next larger double."""
    other = array.copy()
    other.flat[0] = np.nextafter(other.flat[0], np.inf)
    return other


def test_run_is_equal_to_one_with_the_same_numbers_and_to_no_other():
    run = a_run()
    for same in (a_run(), load(WHOLE), replace(run, wall_seconds=3.0)):
        assert run == same
        assert hash(run) == hash(same)
    others = [replace(run, **{name: changed(getattr(run, name))}) for name in ("times", "poses", "drift")]
    others += [
        replace(run, pose_velocities=None),
        replace(run, joint_impulses=None),
        replace(run, first_contact=None),
        replace(run, events=ContactLog()),
        replace(run, outcome="clear"),
        replace(run, provenance={}),
        replace(run, march=replace(MARCH, speed=1.3)),
    ]
    for other in others:
        assert run != other
    assert run != "run"
    assert len({run, a_run(), *others}) == 1 + len(others)


def test_states_are_equal_to_those_with_the_same_numbers_and_to_no_other():
    states = MARCH.at([0, 1.5])
    assert states == MARCH.at([0, 1.5])
    assert hash(states) == hash(MARCH.at([0, 1.5]))
    assert states != MARCH.at([0, 1.6])
    assert states != replace(states, speeds=changed(states.speeds))


@pytest.mark.parametrize(
    "name", ["times", "handles_s", "positions", "velocities", "speeds", "poses", "pose_velocities"]
)
def test_states_cannot_be_changed(name):
    states = MARCH.at([0, 1.5])
    with pytest.raises(ValueError, match="read-only"):
        getattr(states, name)[...] = 0


CHANGES = {
    "set": lambda it: it.update(player="else"),
    "item": lambda it: it.__setitem__("player", "else"),
    "delete": lambda it: it.__delitem__("player"),
    "pop": lambda it: it.pop("player"),
    "popitem": lambda it: it.popitem(),
    "clear": lambda it: it.clear(),
    "default": lambda it: it.setdefault("new", 1),
    "union": lambda it: it.__ior__({"new": 1}),
    "inner": lambda it: it["settings"].update(text=""),
    "list": lambda it: it["settings"]["list"].__setitem__(0, 9),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES.keys())
def test_provenance_cannot_be_changed_and_is_a_copy(change):
    given_provenance = {"player": "test", "settings": {"list": [1, 2], "text": "a"}}
    run = replace(a_run(), provenance=given_provenance)
    before = json.dumps(run.provenance)
    with pytest.raises((TypeError, AttributeError)):
        change(run.provenance)
    given_provenance["settings"]["list"].append(3)
    assert json.dumps(run.provenance) == before
    assert pickle.loads(pickle.dumps(run)) == run


def test_velocities_of_a_run_cannot_be_changed():
    run = without_velocities(a_run())
    with pytest.raises(ValueError, match="read-only"):
        run.frame_velocities[0] = 1


def test_results_show_themselves_in_a_line(seed_march):
    assert repr(a_run()) == "Run(4 benches, 7 frames from 0 s to 3 s, contact)"
    assert repr(MARCH.at([0.5, 2])) == "States(5 handles at 2 times from 0.5 s to 2 s)"
    assert repr(MARCH.at([])) == "States(5 handles at 0 times)"
    assert len(repr(Run.exact(seed_march, [0, 412.4738376]))) < 80


def test_text_and_values_of_a_run_leave_out_what_is_unknown():
    run = a_run()
    assert str(run).splitlines() == [
        "first contact at t = 0.314159 s: benches 0 and 2 at (1.500000, 2.500000) m",
        "drift 333.333 mm in the first twelve benches, 333.333 mm anywhere",
    ]
    assert run.to_dict()["first_contact"]["time"] == CONTACT.time
    timed = replace(run, provenance=ENGINE, wall_seconds=0.7, step_seconds=0.5)
    assert str(timed).splitlines()[2] == "5.0 times as fast as real time"
    assert timed.to_dict()["driver_overhead"] == pytest.approx(0.4)
    assert str(timed).splitlines()[3:] == str(EVENTS).splitlines()
    exact = Run.exact(MARCH, [0, 2])
    assert str(exact) == "exact model until t = 2 s, without a search for contacts"
    unknown = ("first_contact", "substep", "substeps", "iterations", "wall_seconds", "realtime_factor")
    assert all(exact.to_dict()[name] is None for name in unknown)
    assert json.loads(json.dumps(exact.to_dict(), allow_nan=False))["until"] == 2.0
