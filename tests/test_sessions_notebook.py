"""Live sessions in notebooks: the page as a widget, without a port."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from contextvars import ContextVar, copy_context
from importlib.metadata import version
from importlib.util import find_spec

import conftest
import nbformat
import pytest
from browser import needs_browser, opened, wait_until
from live_sessions import PATIENCE, decoded, notebook, played
from test_sessions_draw_browser import PIXELS

if find_spec("anywidget") is None:
    pytest.skip("no anywidget: pip install 'pymunk-dragon[notebook]'", allow_module_level=True)

from pymunk_dragon.errors import ParameterError
from pymunk_dragon.sessions import live
from pymunk_dragon.sessions import widget as widgets
from pymunk_dragon.sessions.client import MOST_FRAMES

PORTS = (
    "{each.laddr for each in psutil.Process().net_connections('tcp') if each.status == 'LISTEN'}"
)
CELLS = f"""
import psutil, pymunk
from pymunk_dragon import live

def build():
    space = pymunk.Space()
    space.damping = 0.1
    body = pymunk.Body(1, 1)
    floor = pymunk.Segment(space.static_body, (-2, -2), (4, -2), 0.1)
    space.add(body, pymunk.Circle(body, 0.5), floor)
    spaces.append(space)
    return space

def on_draw(space, draw):
    body = next(iter(space.bodies))
    draw.text((0, -1), f"x = {{body.position.x:.1f}}", size=30, color="red")

spaces, before = [], {PORTS}
session = live(build, on_draw=on_draw)
session
---
assert {PORTS} == before, "a port was opened"
x, y = next(iter(spaces[-1].bodies)).position
print(f"<{{x:.3f}} {{y:.3f}}>")
""".split("---")
BUILD = """
import time
import pymunk
from pymunk_dragon import Button, live

ended = []
def build():
    space = pymunk.Space()
    body = pymunk.Body(1, 1)
    space.add(body, pymunk.Circle(body, 0.5))
    return space

controls = [Button("End", ended.append)]
session = live(build, controls=controls)
session
"""
# Runs until a button of the page is pressed.
SLEEP = """
while not ended:
    time.sleep(0.01)
ended.clear()
print("<ended>")
"""
OWN = """
own = live(build(), step=None, controls=controls)
own
"""
# The same, with the steps of a program of its own.
STEPS = """
while not ended:
    own.step(1 / 60)
print("<ended>")
"""
CIRCLE = "live.frame.calls.find(({ kind }) => kind === 'circle').points[0]"


# ---- without a browser


@contextmanager
def watched(source="pendulum"):
    """A session stepped by hand, its widget, and what that sent: texts, and headers of frames."""
    with played(source) as on:
        widget = widgets.LiveWidget(on.session)
        widget.texts, widget.frames = [], []

        def send(content, buffers=()):
            widget.texts += [json.loads(content["text"])] if "text" in content else []
            if "frame" in content:
                widget.frames += [(content["frame"], decoded(bytes(each))) for each in buffers]

        widget.send = send
        yield on, widget


def receive(widget, content):
    """Have the widget get what its page posts: messages, or the number of frames drawn."""
    widget._handle_custom_msg(content if isinstance(content, int) else json.dumps(content), [])


def wait(go_on, condition):
    """Call `go_on`, which waits for the other side, until a condition holds."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        go_on()


def test_page_gets_its_answers_in_the_context_of_its_newest_message():
    with watched() as (on, widget):
        known, send = ContextVar("known", default=0), widget.send
        found = []

        def sent(content, buffers=()):
            found.append(known.get())
            send(content, buffers)

        def received(number, content):
            known.set(number)
            receive(widget, content)

        widget.send = sent
        copy_context().run(received, 1, 0)
        wait(on.settle, lambda: widget.frames)
        assert set(found) == {1}
        copy_context().run(received, 2, {"do": "ping", "id": 1})
        found.clear()
        widget.tell({"kind": "event"})
        assert set(found) == {2}


def test_page_is_sent_to_a_widget_that_requests_it_and_is_not_stored_with_each():
    with watched() as (on, widget):
        pages = []
        widget.send = lambda content, buffers=(): pages.append(content["page"])
        widget._handle_custom_msg("page", [])
        assert pages[0].startswith("<!doctype html>")
        stored = len(json.dumps(widget.get_state()))
        assert stored < len(pages[0]) / 10
        assert widget not in on.session.clients


def kinds(widget):
    return [each["kind"] for each in widget.texts]


def test_page_gets_scene_state_and_frames_and_its_messages_reach_the_engine():
    with watched() as (on, widget):
        receive(widget, 0)
        wait(on.settle, lambda: "state" in kinds(widget) and widget.frames)
        assert (widget.texts[0]["kind"], widget.texts[0]["role"]) == ("scene", "control")
        receive(widget, {"do": "step", "count": 7})
        receive(widget, {"do": "ping", "id": 3})
        on.settle()
        receive(widget, len(widget.frames))
        wait(
            on.settle,
            lambda: widget.frames[-1][1].step == 7 or receive(widget, widget.frames[-1][0]),
        )
        assert {"kind": "pong", "id": 3} in widget.texts
        before = kinds(widget).count("error")
        for bad in ({"do": "dance"}, {"do": "scene", "name": "nowhere"}, "no object"):
            receive(widget, bad)
        on.settle()
        assert kinds(widget).count("error") == before + 3


def test_frames_wait_for_the_page_to_draw_those_before():
    with watched() as (on, widget):
        receive(widget, 0)
        on.session.clock.play()
        wait(on.settle, lambda: on.scene.time > 0.5)
        numbers = [number for number, _ in widget.frames]
        assert numbers == list(range(1, MOST_FRAMES + 1))
        receive(widget, 1)
        wait(on.settle, lambda: len(widget.frames) == MOST_FRAMES + 1)
        # What was lost with an earlier page is not waited for.
        receive(widget, 0)
        wait(on.settle, lambda: len(widget.frames) > MOST_FRAMES + 1)


def test_nothing_is_sent_while_the_page_is_silent_and_it_goes_on_afterwards(monkeypatch):
    with watched() as (on, widget):
        on.settle()
        assert not widget.frames
        receive(widget, 0)
        assert widget in on.session.clients
        monkeypatch.setattr(widgets, "SILENCE", -1.0)
        wait(on.settle, lambda: widget not in on.session.clients)
        sent = len(widget.frames), len(widget.texts)
        on.step(10)
        assert (len(widget.frames), len(widget.texts)) == sent
        monkeypatch.undo()
        receive(widget, {"do": "ping", "id": 1})
        assert kinds(widget)[-2:] == ["scene", "pong"]
        assert widget in on.session.clients


def test_body_is_dropped_when_its_page_begins_anew():
    with watched() as (on, widget):
        receive(widget, 0)
        x, y, _ = on.scene.poses()[-1]
        receive(widget, {"do": "grab", "x": float(x), "y": float(y), "slip": 1.0})
        on.settle()
        assert on.frame().held is not None
        receive(widget, 0)
        on.settle()
        assert on.frame().held is None


def test_notebook_opens_a_port_only_for_the_address(monkeypatch, capsys):
    python = notebook()
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "IPython", python)
        patch.setattr(widgets, "display", lambda data, raw: shown.append(data))
        patch.setattr("webbrowser.open", lambda address: pytest.fail("a browser was opened"))
        shown = []
        with live("pendulum") as session, session.paused():
            data, _ = session._repr_mimebundle_()
            assert "application/vnd.jupyter.widget-view+json" in data
            [still] = shown
            assert "data:image/png;base64,iVBOR" in still["text/html"]
            assert "_server" not in vars(session)
            assert session.address.startswith("http://127.0.0.1:")
        patch.setitem(sys.modules, "anywidget", None)
        with live("pendulum", browser=False) as session:
            assert session.address in session._repr_mimebundle_()["text/html"]


def test_port_that_no_computer_has_is_refused_in_a_notebook_too(monkeypatch):
    monkeypatch.setitem(sys.modules, "IPython", notebook())
    for port in (65536, -1, "8000"):
        with pytest.raises(ParameterError, match="port"), live("pendulum", port=port):
            pytest.fail("a session was started")


# ---- in JupyterLab


@contextmanager
def lab(folder):
    """The address of a notebook in JupyterLab, which has its files in a folder."""
    own = {
        name: str(folder / name)
        for name in ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "IPYTHONDIR")
    }
    runtime = folder / "runtime"
    flags = [
        "--no-browser",
        "--allow-root",
        "--ip=127.0.0.1",
        "--port=0",
        f"--ServerApp.root_dir={folder}",
    ]
    flags += [
        "--LabApp.extension_manager=readonly",
        "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate",
    ]
    flags += ["--expose-app-in-browser"]
    command, null = [sys.executable, "-m", "jupyterlab", *flags], subprocess.DEVNULL
    environment = os.environ | own | {"JUPYTER_RUNTIME_DIR": str(runtime)}
    process = subprocess.Popen(command, env=environment, stdout=null, stderr=null)
    try:
        about = runtime / f"jpserver-{process.pid}.json"
        conftest.wait_until(
            process, lambda: about.exists() and about.read_text().rstrip().endswith("}")
        )
        found = json.loads(about.read_text())
        yield f"{found['url']}lab/tree/live.ipynb?token={found['token']}"
    finally:
        process.terminate()
        with suppress(
            subprocess.TimeoutExpired
        ):  # While a kernel starts; kernels end by themselves without one.
            process.wait(10)
        process.kill()
        process.wait()


# The manager of the widgets saves their states with the notebook.
SAVES_STATE = "lab/user-settings/@jupyter-widgets/jupyterlab-manager/plugin.jupyterlab-settings"


def write_notebook(folder, cells):
    """Write a notebook with these cells, and a setting of JupyterLab."""
    notebook = nbformat.v4.new_notebook(
        cells=[nbformat.v4.new_code_cell(cell.strip()) for cell in cells]
    )
    notebook.metadata.kernelspec = {
        "name": "python3",
        "display_name": "Python 3",
        "language": "python",
    }
    nbformat.write(notebook, folder / "live.ipynb")
    setting = folder / "JUPYTER_CONFIG_DIR" / SAVES_STATE
    setting.parent.mkdir(parents=True, exist_ok=True)
    setting.write_text('{"saveState": true}')


NOTEBOOK = "globalThis.jupyterapp?.shell.currentWidget"
RUN = """async (number) => {
  await jupyterapp.shell.currentWidget.sessionContext.ready;
  jupyterapp.shell.currentWidget.content.activeCellIndex = number;
  await jupyterapp.commands.execute("notebook:run-cell");
}"""


# The same, without waiting for its end.
START = f"(number) => {{ ({RUN})(number); }}"


def run_cell(page, number, how=RUN):
    """Run a cell by JupyterLab's own command: it ignores keys that come while it starts."""
    wait_until(page, f"{NOTEBOOK}?.content?.widgets?.length > {number}")
    page.evaluate(how, number)


def frame_of(page, number):
    """The frame of the widget that a cell shows, when it is connected."""
    frame = page.wait_for_selector(
        f".jp-CodeCell >> nth={number} >> iframe[srcdoc]"
    ).content_frame()
    wait_until(frame, "globalThis.live?.scene != null")
    return frame


def ends(page, number):
    """Whether the cell has printed its last line."""
    return page.locator(
        f".jp-CodeCell >> nth={number} >> .jp-OutputArea-output"
    ).all_inner_texts() == ["<ended>\n"]


def save(page, path):
    """Save the notebook, and return it as it is in its file."""
    page.evaluate("jupyterapp.commands.execute('docmanager:save')")
    wait(lambda: page.wait_for_timeout(20), lambda: "<img" in path.read_text())
    return path.read_text()


has_jupyterlab = pytest.mark.skipif(
    find_spec("jupyterlab") is None, reason="no JupyterLab: pip install jupyterlab"
)
has_threads = pytest.mark.skipif(
    int(version("ipykernel").split(".")[0]) < 7,
    reason="ipykernel takes no messages of widgets while a cell runs",
)


@pytest.mark.thorough
@needs_browser
@has_jupyterlab
def test_body_that_is_dragged_in_jupyterlab_moves_in_python_and_a_picture_remains(
    browser, tmp_path
):
    write_notebook(tmp_path, CELLS)
    with lab(tmp_path) as address, opened(browser, address, height=1600) as found:
        page = found.page
        run_cell(page, 0)
        frame = page.wait_for_selector("iframe[srcdoc]").content_frame()
        wait_until(frame, "globalThis.live?.drawn > 0")
        assert not page.is_visible("img[alt='A live session']")

        def place(x, y):
            box = frame.locator("#field").bounding_box()
            px, py = frame.evaluate("([x, y]) => live.view.toScreen(x, y)", [x, y])
            return box["x"] + px, box["y"] + py

        page.mouse.move(*place(0, 0))
        page.mouse.down()
        wait_until(frame, "live.frame.held !== null")
        page.mouse.move(*place(1.5, 1), steps=8)
        wait_until(frame, f"{CIRCLE}.every((value, k) => Math.abs(value - [1.5, 1][k]) < 0.05)")
        page.mouse.up()
        wait_until(frame, "live.frame.held === null")
        # What the program writes is in the picture, and follows the body.
        wait_until(frame, "live.frame.texts[0][2] === 'x = 1.5'")
        row = frame.evaluate(PIXELS, [[0.02 * i - 0.5, -1] for i in range(50)])
        assert any(red > 200 and green + blue < 100 for red, green, blue in row)
        run_cell(page, 1)
        text = page.wait_for_selector(".jp-CodeCell >> nth=1 >> .jp-OutputArea-output").inner_text()
        x, y = map(float, text.strip("<>\n ").split())
        assert (x, y) == pytest.approx((1.5, 1), abs=0.2)
        saved = save(page, tmp_path / "live.ipynb")
        assert "application/vnd.jupyter.widget-state+json" in saved
        assert "<!doctype html>" not in saved
        assert not [text for text in found.complaints if "Policy" in text or "Error" in text]
    with lab(tmp_path) as address, opened(browser, address, height=1600) as found:
        assert found.page.wait_for_selector("img[alt='A live session']").is_visible()


@pytest.mark.thorough
@needs_browser
@has_jupyterlab
@has_threads
def test_page_goes_on_while_a_cell_runs_and_its_inputs_take_effect(browser, tmp_path):
    write_notebook(tmp_path, [BUILD, SLEEP, OWN, STEPS])
    with lab(tmp_path) as address, opened(browser, address, height=2400) as found:
        page = found.page
        for shows, loops in ((0, 1), (2, 3)):
            run_cell(page, shows)
            frame = frame_of(page, shows)
            run_cell(page, loops, START)
            # More than are sent without an answer.
            wait_until(frame, f"live.frame?.step > 0 && live.drawn > {5 * MOST_FRAMES}")
            frame.click("#play")
            wait_until(frame, "!live.state.running")
            assert not ends(page, loops)
            step = frame.evaluate("live.frame.step")
            frame.click("#play")
            wait_until(frame, f"live.frame.step > {step}")
            box = frame.locator("#field").bounding_box()
            x, y = frame.evaluate(f"live.view.toScreen(...{CIRCLE})")
            page.mouse.move(box["x"] + x, box["y"] + y)
            page.mouse.down()
            wait_until(frame, "live.frame.held !== null")
            page.mouse.up()
            assert not ends(page, loops)
            # In a narrow frame its part of the page is folded.
            frame.eval_on_selector("#actions button", "(button) => button.click()")
            wait(lambda: page.wait_for_timeout(20), lambda loops=loops: ends(page, loops))


COUNT = "len([each for each in threading.enumerate() if 'pymunk-dragon' in each.name])"


@pytest.mark.thorough
def test_eight_runs_of_a_cell_leave_one_thread_in_a_kernel():
    kernels = pytest.importorskip("jupyter_client", reason="jupyter_client is in the extra test")
    with kernels.run_kernel() as client:

        def threads(cell, code):
            """Threads of sessions after a cell was run."""
            about = {"code": code, "user_expressions": {"count": COUNT}}
            message = client.session.msg("execute_request", about, metadata={"cellId": cell})
            client.shell_channel.send(message)
            while True:
                reply = client.get_shell_msg(timeout=PATIENCE)
                if reply["parent_header"]["msg_id"] == message["msg_id"]:
                    return int(reply["content"]["user_expressions"]["count"]["data"]["text/plain"])

        assert threads("one", "import threading; from pymunk_dragon import live") == 0
        for run in range(8):
            assert threads("two", f"session = live('pendulum')\nsession  # {run}") == 1
        assert threads("three", "session = live('cradle')") == 2
