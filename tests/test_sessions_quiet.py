"""How sessions begin and end: addresses, waiting, notebooks; and what pages show at first."""

from __future__ import annotations

import os
import subprocess
import sys
import threading

import pymunk
import pytest
from conftest import refusal
from live_sessions import PATIENCE, greeting, notebook, played

from pymunk_dragon import Dragon, March, live
from pymunk_dragon.sessions.live import source_of
from pymunk_dragon.sessions.scene import PlaySettings

PROGRAM = """
import _thread
import sys
import threading
import traceback
import pymunk
from pymunk_dragon import live

def build():
    space = pymunk.Space()
    space.add(pymunk.Body(1, 1))
    return space

def on_step(space, time):
    if "ends" in sys.argv:
        sys.exit()
    if "interrupted" in sys.argv:
        main = sys._current_frames()[threading.main_thread().ident]
        if "goes_on" in [each.name for each in traceback.extract_stack(main)]:
            sys.argv.remove("interrupted")
            # As Ctrl-C does.
            _thread.interrupt_main()

session = live(build, on_step=on_step, browser=False)
if "waits" in sys.argv:
    session.wait()
print("done")
"""


def threads():
    """The threads of sessions and servers."""
    return [each for each in threading.enumerate() if each.name.startswith("pymunk-dragon")]


@pytest.mark.parametrize("opens", [True, False])
def test_address_is_printed_unless_a_browser_shows_it(opens, monkeypatch, capsys):
    shown = []
    monkeypatch.setattr("webbrowser.open", lambda address: shown.append(address) or opens)
    with live(pymunk.Space) as session:
        assert shown == [session.address]
        assert (session.address in capsys.readouterr().err) == (not opens)
    with live(pymunk.Space, browser=False) as session:
        assert session.address in capsys.readouterr().err


def program(*arguments):
    """A program with a session, as it begins."""
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )


def test_ctrl_c_ends_a_program_that_waits_as_it_ends_commands():
    with program("waits", "interrupted") as waiting:
        out, err = waiting.communicate(timeout=PATIENCE)
    address, line = err.splitlines()
    assert "http://127.0.0.1:" in address
    assert (waiting.returncode, out, line) == (130, "", "interrupted")


def test_program_waits_for_the_end_of_its_session_and_one_that_does_not_is_told_so():
    with program("waits", "ends") as waiting, program() as hasty:
        out, err = waiting.communicate(timeout=PATIENCE)
        assert (waiting.returncode, out, len(err.splitlines())) == (0, "done\n", 1)
        out, err = hasty.communicate(timeout=PATIENCE)
        assert (hasty.returncode, out) == (0, "done\n")
        [_, warning] = err.splitlines()
        assert "wait()" in warning


def test_program_with_its_own_loop_and_a_published_one_do_not_wait(monkeypatch):
    with live(pymunk.Space(), step=None, browser=False) as session:
        session.wait()
    # Where there are no threads, as in a page, the event loop makes the steps.
    monkeypatch.setattr("pymunk_dragon.sessions.session._WITHOUT_THREADS", True)
    monkeypatch.setattr("pymunk_dragon.sessions.session.Session._turn_later", lambda *_: None)
    with live(pymunk.Space, browser=False) as session:
        session.wait()


@pytest.mark.parametrize("cell", ["one", None])
def test_cell_that_runs_again_ends_the_sessions_that_it_showed_before(cell, monkeypatch):
    before = len(threads())
    running = []
    try:
        for run in range(8):
            python = notebook(run, cell, "live(build)")
            monkeypatch.setitem(sys.modules, "IPython", python)
            running += [live(pymunk.Space), live(pymunk.Space)]
            assert len(threads()) == before + 2
        # Another cell has a session of its own.
        other = notebook(8, cell and "two", "live(other)")
        monkeypatch.setitem(sys.modules, "IPython", other)
        running.append(live(pymunk.Space))
        assert len(threads()) == before + 3
    finally:
        for each in running:
            each.stop()
    assert len(threads()) == before


@pytest.mark.parametrize(
    ("what", "show", "expected"),
    [
        (pymunk.Space, None, []),
        (pymunk.Space(), ["forces"], ["forces"]),
        (March(Dragon(benches=3)), None, ["curve", "exact", "contacts"]),
        (March(Dragon(benches=3)), ("handles", "numbers"), ["handles", "numbers"]),
        (None, [], []),
        ("boxes", None, ["contacts"]),
    ],
)
def test_picture_of_a_users_space_has_no_overlays_unless_the_user_chooses_some(
    what, show, expected
):
    with played(source_of(what, PlaySettings(show=show))) as on:
        [scene] = [each for each in greeting(on) if each["kind"] == "scene"]
        assert [*scene["show"]] == expected


@pytest.mark.parametrize("show", ["forces", ["shadows"], [3], 3])
def test_overlays_that_do_not_exist_are_refused(show):
    assert refusal(live, pymunk.Space, show=show, browser=False).name == "show"


def test_overlays_are_what_a_user_may_choose_of_a_march():
    march = March(Dragon(benches=3))
    with live(march, show=["handles"], paused=True, browser=False):
        pass
    assert refusal(live, march, show=["handles"], plots={"a": len}, browser=False).name == "plots"


def test_users_charts_stand_first_also_in_place_of_the_spaces_own():
    plots = {"size": lambda space: 3, "Momentum": lambda space: 4}
    with played(source_of(pymunk.Space, PlaySettings(plots=plots))) as on:
        [scene] = [each for each in greeting(on) if each["kind"] == "scene"]
        titles = [title for title, _ in scene["plots"]]
        assert titles[:2] == ["size", "Momentum"]
        assert "Kinetic energy" in titles[2:]
        values = on.scene.plots()
        assert [*values] == titles
        assert [*values.values()][:2] == [3, 4]
