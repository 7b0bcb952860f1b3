"""The package in WebAssembly, by Pyodide in node: it finds what it finds here.

With PYODIDE_TESTS=all nothing is skipped, and the tests that take long there run too.
"""

import json
import os

import in_node
import numpy as np
import PIL
import pyodide_facts
import pytest
from PIL import Image, ImageSequence
from sharing import shared

from pymunk_dragon import Run, render

pytestmark = pytest.mark.thorough

# Points, gaps and depths, m, and directions: sines of two C libraries differ in the last digit.
ROUNDING = 1e-14
# Times of near misses, s: a gap that has changed by the rounding is as small 1e-7 s later.
MINIMUM = 1e-6
# Poses in a scene after 500 steps, m and rad.
DEVIATION = 1e-7


def play(results):
    """Run all of it in one process, as the runtime takes three seconds to start."""
    results.mkdir()
    in_node.run("pyodide_side.py", results, in_node.libraries(results, tests=True))


@pytest.fixture(scope="module")
def results():
    """The folder of what Pyodide has written."""
    try:
        return shared("pyodide", play)
    except in_node.CannotRunError as error:
        if os.environ.get("PYODIDE_TESTS") == "all":
            raise
        pytest.skip(str(error))


def read(path):
    return json.loads(path.read_text())


def pictures(path):
    with Image.open(path) as film:
        return [np.asarray(frame.convert("RGB")) for frame in ImageSequence.Iterator(film)]


def test_first_contact_is_at_the_same_time_to_the_bit(results):
    theirs = read(results / "contact.json")
    ours = json.loads(json.dumps(pyodide_facts.contact()))
    for name in ("status", "time", "benches"):
        assert theirs[name] == ours[name]
    for name in ("point", "normal"):
        assert theirs[name] == pytest.approx(ours[name], abs=ROUNDING)


def test_near_misses_are_the_same(results):
    theirs = read(results / "contact.json")["near_misses"]
    ours = pyodide_facts.contact()["near_misses"]
    assert [miss["benches"] for miss in theirs] == [[0, 9], [0, 11]]
    for found, expected in zip(theirs, ours, strict=True):
        assert found["gap"] == pytest.approx(expected["gap"], abs=ROUNDING)
        assert found["time"] == pytest.approx(expected["time"], abs=MINIMUM)


def test_engine_has_the_same_contact_and_film(results, late_run, tmp_path):
    run = Run.load(results / "late.npz")
    theirs = run.first_contact
    ours = late_run.first_contact
    assert (theirs.time, theirs.raw_time) == (ours.time, ours.raw_time)
    assert theirs.benches == ours.benches
    for name in ("point", "normal", "depth"):
        assert getattr(theirs, name) == pytest.approx(getattr(ours, name), abs=ROUNDING)
    np.testing.assert_allclose(run.poses, late_run.poses, rtol=0, atol=DEVIATION)

    film = results / "late.gif"
    render(late_run, tmp_path / "late.gif")
    if read(results / "pillow.json") == PIL.__version__:
        assert film.read_bytes() == (tmp_path / "late.gif").read_bytes()
    else:
        np.testing.assert_array_equal(pictures(film), pictures(tmp_path / "late.gif"))


def test_every_scene_is_the_same_after_500_steps(results):
    theirs = read(results / "scenes.json")
    ours = pyodide_facts.scenes()
    assert theirs.keys() == ours.keys()
    for name, poses in ours.items():
        np.testing.assert_allclose(theirs[name], poses, rtol=0, atol=DEVIATION, err_msg=name)


def test_tests_of_model_and_collision_pass(results):
    found = read(results / "tests.json")
    assert (found["code"], found["failed"]) == (0, 0)
    assert found["passed"] > 100
