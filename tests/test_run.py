"""Runs of a player: contacts, frames, poses in between, and files that are whole or not there."""

import io
import json
import math
import os
import pickle
import warnings
import zipfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from conftest import assert_says, examples, linux_only, refusal
from hypothesis import given
from hypothesis import strategies as st

from pymunk_dragon import (
    Contact,
    ContactEvent,
    ContactLog,
    Dragon,
    EngineSettings,
    March,
    Run,
    Spiral,
)
from pymunk_dragon.errors import DragonError, FileFormatError
from pymunk_dragon.model.contact import ContactWindow
from pymunk_dragon.model.run import versions

MARCH = March(Dragon(benches=4, width=0.29), Spiral(pitch=0.6), turns=9.5, speed=1.25)
TOUCH = {
    "points": ((0.1, -1e-300), (1 / 3, 2.0)),
    "normal": (0.6, 0.8),
    "depth": 1e-9,
    "relative_velocity": (-0.0, 5e-324),
}
EVENTS = ContactLog(
    [
        ContactEvent(time=0.1 + 0.2, phase="begin", benches=(0, 2), **TOUCH),
        ContactEvent(
            time=0.4, phase="post_solve", benches=(0, 2), points=((0.0, 0.0),), impulse=(1.0, -2.0)
        ),
        ContactEvent(time=0.5, phase="separate", benches=(0, 2)),
    ]
)
CONTACT = Contact(
    time=0.3141592653589793,
    raw_time=0.32,
    benches=(0, 2),
    point=(1.5, 2.5),
    normal=(1.0, 0.0),
    depth=0.25e-3,
)
ENGINE = {
    "player": "pymunk",
    "guide": "rails",
    "contacts": "resolve",
    "start": -0.5,
    "substep": 0.01,
    "substeps": 350,
}
ARRAYS = ("times", "poses", "drift", "pose_velocities", "joint_forces")


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
        joint_forces=np.linspace(0, 1, 21).reshape(7, 3) / 7,
        events=EVENTS,
        first_contact=CONTACT,
        outcome="contact",
        provenance={"player": "test", "settings": {"list": [1, 2.5, None, True], "text": "äöü\n"}},
    )


def saved(run):
    """The bytes that `save` writes."""
    file = io.BytesIO()
    run.save(file)
    return file.getvalue()


def test_velocities_of_frames_that_are_very_near_are_those_of_the_march():
    steady = np.linspace(0, 2, 41)
    for near in ([], [2 + 1e-13], [1e-12], [1 + 1e-13, 1 + 2e-13, 1 + 1e-9], [1 + 3e-7, 2 + 1e-10]):
        states = MARCH.at(np.sort([*steady, *near]))
        drift = np.zeros(states.poses.shape[:2])
        run = Run(march=MARCH, times=states.times, poses=states.poses, drift=drift)
        np.testing.assert_allclose(run.pose_velocities, states.pose_velocities, atol=2e-3)


WHOLE = saved(a_run())
with np.load(io.BytesIO(WHOLE)) as ARCHIVE:
    CONTENTS = dict(ARCHIVE)


@pytest.fixture(scope="module")
def load(tmp_path_factory):
    """Load from bytes, as from a file, with every warning an error."""
    file = tmp_path_factory.mktemp("run") / "run.npz"

    def load(content):
        file.write_bytes(content)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return Run.load(file)

    return load


def members(**changes):
    """An archive like that of `save`, with some arrays changed; None leaves one out."""
    buffer = io.BytesIO()
    np.savez(
        buffer, **{name: array for name, array in (CONTENTS | changes).items() if array is not None}
    )
    return buffer.getvalue()


def notes(change):
    """An archive like that of `save`, with its notes changed."""
    values = json.loads(CONTENTS["notes"].tobytes())
    change(values)
    return members(notes=np.frombuffer(json.dumps(values).encode(), dtype=np.uint8))


def archive_of(**contents):
    """The archive of a saved run with other bytes as some members."""
    out = io.BytesIO()
    with (
        zipfile.ZipFile(io.BytesIO(WHOLE)) as old,
        zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new,
    ):
        for name in old.namelist():
            new.writestr(name, contents.get(name.removesuffix(".npy"), old.read(name)))
    return out.getvalue()


def test_log_of_contacts_has_windows_of_each_pair():
    rows = (
        (1.0, "begin", 0),
        (1.5, "begin", 1),
        (1.6, "pre_solve", 0),
        (2.0, "separate", 0),
        (3.0, "begin", 0),
    )
    rows += ((3.0, "separate", 0), (4.0, "separate", 5))
    log = ContactLog(
        ContactEvent(time=time, phase=phase, benches=(i, i + 8)) for time, phase, i in rows
    )
    assert log.windows() == [
        ContactWindow(benches=(0, 8), begin=1.0, end=2.0),
        ContactWindow(benches=(1, 9), begin=1.5, end=None),
        ContactWindow(benches=(0, 8), begin=3.0, end=3.0),
    ]


def test_run_comes_back_exactly_and_its_file_is_the_same_again(load):
    run, back = a_run(), load(WHOLE)
    for name in ARRAYS:
        assert getattr(back, name).tobytes() == getattr(run, name).tobytes()
        assert getattr(back, name).dtype == (
            np.float64 if name in ("times", "poses") else np.float32
        )
    for name in ("march", "events", "first_contact", "outcome", "provenance"):
        assert getattr(back, name) == getattr(run, name)
    assert str(back.events[0].relative_velocity) == "(-0.0, 5e-324)"
    assert saved(a_run()) == WHOLE == saved(back)
    narrow = replace(run, poses=np.ones((7, 4, 3), dtype=np.float32))
    assert load(saved(narrow)) == narrow
    # The archive that the tests change is read.
    assert load(notes(lambda values: None)).events == EVENTS


@given(st.integers(0, len(WHOLE) - 1), st.binary(max_size=2000))
@examples(200)
def test_part_of_a_file_and_random_bytes_are_refused(load, length, content):
    for damaged in (WHOLE[:length], content):
        assert_says(refusal(load, damaged, error=FileFormatError), "run.npz")


@given(
    st.lists(st.tuples(st.integers(0, len(WHOLE) - 1), st.integers(1, 255)), min_size=1, max_size=4)
)
@examples(600)
def test_flipped_bytes_are_refused_or_do_no_harm(load, flips):
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


def test_foreign_files_and_arrays_that_do_not_fit_are_refused(load):
    contents = [b"a dragon went by\n" * 30, archive_of(poses=b"hello"), archive_of(notes=b"hello")]
    contents += [
        members(notes=np.frombuffer(text, dtype=np.uint8)) for text in (b"{hello", b"[" * 100_000)
    ]
    contents += [members(**{name: None}) for name in ("notes", "poses", "pose_velocities")]
    contents += [members(notes=np.eye(3)), notes(lambda values: values.update(format_version=1))]
    for name, array in (
        ("poses", np.zeros((7, 5, 3))),
        ("poses", np.zeros((6, 4, 3))),
        ("poses", np.zeros((7, 4, 3), dtype=np.float32)),
        ("poses", np.full((7, 4, 3), "a")),
        ("poses", np.full((7, 4, 3), np.inf)),
        ("times", np.zeros((7, 1))),
        ("times", np.arange(7)),
        ("times", np.arange(7.0)[::-1].copy()),
        ("times", np.array([0, 1, 2, np.nan, 4, 5, 6.0])),
        ("drift", np.zeros((7, 3), dtype=np.float32)),
        ("pose_velocities", np.full((7, 4, 3), np.inf, dtype=np.float32)),
        ("joint_forces", np.zeros((7, 4), dtype=np.float32)),
        # Python objects, which NumPy would unpickle.
        *((name, np.array([EVENTS[0]], dtype=object)) for name in ("times", "poses", "notes")),
    ):
        contents.append(members(**{name: array}))
    empty = {
        "times": np.empty(0),
        "poses": np.empty((0, 4, 3)),
        "drift": np.empty((0, 4), dtype=np.float32),
    }
    for content in (*contents, members(**empty)):
        assert_says(refusal(load, content, error=FileFormatError), "run.npz")
    # As without a file.
    assert np.isnan(replace(a_run(), drift=np.full((7, 4), np.nan)).drift).all()
    for drift in (np.inf, -np.inf, 1e30):
        assert refusal(replace, a_run(), drift=np.full((7, 4), drift)).name == "drift"
    for changes in (
        empty,
        {"drift": np.zeros((7, 3))},
        {"poses": np.full((7, 4, 3), 1e10)},
        {"outcome": "victory"},
    ):
        refusal(replace, a_run(), **changes, error=DragonError)


def test_wrong_notes_are_refused(load, tmp_path, monkeypatch):
    (tmp_path / "other.csv").write_text("0,1\n10,1\n20,2\n30,1\n")
    monkeypatch.chdir(tmp_path)
    for part, changes in (
        (
            lambda notes: notes,
            ({"format": "a film"}, {"outcome": "victory"}, {"outcome": ["clear"]}),
        ),
        (
            lambda notes: notes,
            ({"events": 3}, {"events": [3]}, {"scenario": "hello"}, {"provenance": 3}),
        ),
        (
            lambda notes: notes,
            ({"first_contact": False}, {"first_contact": {}}, {"scenario": None}),
        ),
        (lambda notes: notes["scenario"], ({"colour": "red"}, {"pitch": -1}, {"benches": 5})),
        # A loaded run opens no other file.
        (lambda notes: notes["scenario"], ({"curve": "other.csv"}, {"speed": "other.csv"})),
        (lambda notes: notes["events"][0], ({"colour": "red"}, {"phase": "end"}, {"time": "noon"})),
        (
            lambda notes: notes["events"][0],
            ({"time": math.inf}, {"benches": [1]}, {"benches": [2, 0]}),
        ),
        (
            lambda notes: notes["events"][0],
            ({"benches": [0, 4]}, {"points": [[1, 2, 3]]}, {"impulse": ["1", 1.0]}),
        ),
        (
            lambda notes: notes["first_contact"],
            ({"benches": [3, 4]}, {"point": None}, {"depth": "deep"}),
        ),
        # Where no picture could draw it.
        (
            lambda notes: notes["first_contact"],
            ({"point": [1e308, 0]}, {"normal": [0, 1e308]}, {"depth": 1e308}),
        ),
        (lambda notes: notes["events"][0], ({"points": [[0, -1e308]]}, {"time": 1e308})),
    ):
        for change in changes:
            damaged = notes(lambda values, part=part, change=change: part(values).update(change))
            refusal(load, damaged, error=FileFormatError)
    # Text of a file reaches no terminal as it is.
    odd = notes(lambda values: values.update(format="\x1b]0;owned\u202e"))
    assert str(refusal(load, odd, error=FileFormatError)).isprintable()


def test_attributes_come_from_provenance_and_impossible_ones_are_refused(load):
    run = replace(
        a_run(),
        provenance=ENGINE | {"iterations": 7, "head_force": 300.0, "versions": {"numpy": "2"}},
    )
    assert run.player == "pymunk"
    assert run.guide == "rails"
    assert run.start == -0.5
    assert run.substep == 0.01
    assert run.substeps == 350
    assert run.settings == EngineSettings(
        contacts="resolve", substep=0.01, iterations=7, head_force=300.0
    )
    assert run.versions == {"numpy": "2"}
    assert load(saved(run)).settings == run.settings
    exact = Run.exact(MARCH, [1.5, 2])
    assert exact.provenance == {"player": "exact", "versions": versions()}
    assert exact.player == "exact"
    assert exact.guide is None
    assert exact.settings is None
    assert exact.start == 1.5
    assert exact.substeps is None
    wrong = {
        "player": 3,
        "guide": ["rails"],
        "contacts": "ignore",
        "start": "noon",
        "substep": -0.01,
        "substeps": 2.5,
    }
    wrong |= {"free_from": 4}
    for name, value in (
        wrong | {"iterations": 0, "drag": True, "head_force": "much", "versions": "2"}
    ).items():
        change = {**ENGINE, name: value}
        damaged = notes(lambda values, change=change: values.update(provenance=change))
        assert_says(refusal(load, damaged, error=FileFormatError), f"{name} is")
        refusal(replace, a_run(), provenance=change)


def test_sizes_that_a_file_claims_are_bounded(load):
    # The size of a member stands 22 bytes before its name in the directory at the end of an
    # archive.
    content = bytearray(WHOLE)
    place = content.rindex(b"poses.npy") - 22
    content[place : place + 4] = (600_000_000).to_bytes(4, "little")
    assert_says(refusal(load, bytes(content), error=FileFormatError), "no run does that")
    for name, shape in (("poses", (7, 4, 30_000_000)), ("drift", (7, 10**9)), ("times", (10**12,))):
        file = io.BytesIO()
        np.lib.format.write_array_header_1_0(
            file, {"descr": "<f8", "fortran_order": False, "shape": shape}
        )
        refusal(load, archive_of(**{name: file.getvalue()}), error=FileFormatError)


@linux_only
def test_files_that_are_none_are_refused_and_a_pipe_is_read(tmp_path):
    for name in ("none.npz", "none/run.npz", ".", "nul\0.npz"):
        assert refusal(Run.load, tmp_path / name).name == "run"
    refusal(Run.load, "/dev/zero", error=FileFormatError)
    os.mkfifo(tmp_path / "run.npz")
    with ThreadPoolExecutor(1) as pool:
        pool.submit((tmp_path / "run.npz").write_bytes, WHOLE)
        assert Run.load(tmp_path / "run.npz").events == EVENTS


def test_save_that_is_impossible_leaves_nothing(tmp_path):
    for name in ("run", "run.zip", "none/run.npz"):
        assert refusal(a_run().save, tmp_path / name).name == "output"
    for provenance in ({"what": object()}, None, 3, "text", [1.0]):
        assert refusal(replace, a_run(), provenance=provenance).name == "provenance"
    assert list(tmp_path.iterdir()) == []


def changed(record, name):
    """The record with the next larger number as the first one of an array."""
    array = getattr(record, name).copy()
    array.flat[0] = np.nextafter(array.flat[0], array.dtype.type(np.inf))
    return replace(record, **{name: array})


def test_runs_and_states_are_equal_to_those_with_the_same_numbers_and_to_no_other():
    run, states = a_run(), MARCH.at([0, 1.5])
    for same in (a_run(), replace(run, wall_seconds=3.0), pickle.loads(pickle.dumps(run))):
        assert (run, hash(run)) == (same, hash(same))
    others = [changed(run, name) for name in ARRAYS]
    others += [replace(run, **{name: None}) for name in ("joint_forces", "first_contact")]
    others += [
        replace(run, events=ContactLog()),
        replace(run, outcome="clear"),
        replace(run, provenance={}),
    ]
    others += [replace(run, march=replace(MARCH, speed=1.3)), "run"]
    assert all(run != other for other in others)
    assert (states, hash(states)) == (MARCH.at([0, 1.5]), hash(MARCH.at([0, 1.5])))
    assert states not in (MARCH.at([0, 1.6]), changed(states, "speeds"))


def test_run_and_states_cannot_be_changed_and_leave_the_givers_arrays_alone():
    poses = np.zeros((2, 4, 3))
    provenance = {"player": "test", "settings": {"list": [1, 2], "text": "a"}}
    run = Run(
        march=MARCH,
        times=np.arange(2.0),
        poses=poses,
        drift=np.zeros((2, 4)),
        provenance=provenance,
    )
    states, before = MARCH.at([0, 1.5]), json.dumps(run.provenance)
    poses[0] = 7
    provenance["settings"]["list"].append(3)
    for record in (run, CONTACT, EVENTS[0]):
        with pytest.raises(FrozenInstanceError):
            record.march = record.time = None
    names = ("times", "handles_s", "positions", "velocities", "speeds", "poses", "pose_velocities")
    for array in (
        run.poses,
        run.times,
        run.drift,
        run.pose_velocities,
        *(getattr(states, name) for name in names),
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    assert run.poses.max() == 0
    assert json.dumps(run.provenance) == before


def test_drift_of_the_head_is_that_of_the_first_twelve_benches_without_what_is_unknown():
    march = March(Dragon(benches=20))
    drift = np.zeros((2, 20))
    drift[0, 11] = 1e-4
    drift[1, 12] = 2e-3
    drift[1, 0] = np.nan
    run = Run(march=march, times=[0, 1], poses=np.zeros((2, 20, 3)), drift=drift)
    assert (run.head_drift, run.max_drift) == pytest.approx((1e-4, 2e-3), rel=1e-7)
    unknown = replace(run, drift=np.full((2, 20), np.nan))
    assert np.isnan([unknown.head_drift, unknown.max_drift]).all()


# The docstring's bound, with the largest fourth derivative of any bench's pose: by finite
# differences of the model.
def test_poses_between_frames_are_as_near_as_the_docstring_says(seed_march):
    at, h = np.arange(408.5, 411, 0.013), 0.02
    around = [seed_march.at(at + k * h).poses[..., :2] for k in (-2, -1, 0, 1, 2)]
    fourth = (
        np.linalg.norm(sum(w * p for w, p in zip((1, -4, 6, -4, 1), around, strict=True)), axis=-1)
        / h**4
    )
    bound = 0.1**4 / 384 * fourth.max()
    assert bound < 0.05e-6
    run = Run.exact(seed_march, np.arange(4080, 4120) / 10)
    off = np.linalg.norm((run.poses_at(at) - seed_march.at(at).poses)[..., :2], axis=-1)
    assert 0.5 * bound < off.max() < 1.5 * bound
    # Velocities that are not given are differences of the poses.
    differences = replace(run, pose_velocities=None).pose_velocities
    np.testing.assert_allclose(differences, run.pose_velocities, rtol=0, atol=5e-3)


def test_poses_turn_the_shorter_way_between_frames_and_stay_beyond_the_ends():
    poses = np.array([[[0, 0, 3.0]] * 4, [[0, 0, -3.0]] * 4])
    turning = Run(march=MARCH, times=[0, 1], poses=poses, drift=np.zeros((2, 4)))
    angles = turning.poses_at(0.5)[0, :, 2]
    assert np.abs(np.remainder(angles, 2 * np.pi) - np.pi) == pytest.approx(np.zeros(4), abs=1e-12)
    run = a_run()
    for times, frames in ((run.times, slice(None)), ([-5, 99], [0, -1])):
        back, poses = run.poses_at(times), run.poses[frames]
        assert back[..., :2] == pytest.approx(poses[..., :2], abs=1e-15)
        assert np.cos(back[..., 2] - poses[..., 2]) == pytest.approx(
            np.ones(poses.shape[:2]), abs=1e-15
        )
        np.testing.assert_allclose(
            run.pose_velocities_at(times), run.pose_velocities[frames], atol=1e-6
        )
    single = Run.exact(MARCH, [2.0])
    assert np.array_equal(single.poses_at([0, 2, 5]), np.repeat(single.poses, 3, axis=0))


def test_text_and_values_of_a_run_leave_out_what_is_unknown(seed_march):
    run = a_run()
    assert run.to_dict()["first_contact"]["time"] == CONTACT.time
    timed = replace(run, provenance=ENGINE, wall_seconds=0.7, step_seconds=0.5)
    assert "5.0 times as fast as real time" in str(timed)
    assert timed.to_dict()["driver_overhead"] == pytest.approx(0.4)
    exact = Run.exact(MARCH, [0, 2])
    unknown = (
        "first_contact",
        "substep",
        "substeps",
        "iterations",
        "wall_seconds",
        "realtime_factor",
    )
    assert all(exact.to_dict()[name] is None for name in unknown)
    assert json.loads(json.dumps(exact.to_dict(), allow_nan=False))["until"] == 2.0
    for result in (run, MARCH.at([0.5, 2]), MARCH.at([]), Run.exact(seed_march, [0, 412.4738376])):
        assert len(repr(result)) < 80


@pytest.mark.parametrize("times", [[-1e10, 0.0], [0.0, 1e10]])
def test_run_has_no_frame_before_or_after_every_time_of_its_march(times):
    arrays = {"poses": np.zeros((2, 4, 3)), "drift": np.zeros((2, 4))}
    assert refusal(Run, march=MARCH, times=times, **arrays).name == "times"
