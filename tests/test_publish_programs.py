"""Published programs of Pymunk's kind, as users write them: what is read, and how they play."""

from __future__ import annotations

from pathlib import Path

import pytest
import test_publish
from browser import needs_browser, opened, wait_until
from test_publish import served

from pymunk_dragon.errors import DragonError
from pymunk_dragon.publish.program import read_program
from pymunk_dragon.publish.site import publish_program

DATA = Path(__file__).parent / "data/programs"
PROGRAMS = sorted(DATA.glob("*.py"))
# A copy of Pyodide, and a folder with the names of its files.
pyodide = test_publish.pyodide
copy = test_publish.copy


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_programs_have_all_that_their_pages_show(path):
    program = read_program(path)
    assert program.title
    # A title is no sentence.
    assert not program.title.endswith(".")
    assert program.picture.startswith(b"\x89PNG")


@pytest.mark.parametrize("content", [b"\xff\xfe", b"x = 1\0", None])
def test_file_that_is_no_program_is_named_once(tmp_path, monkeypatch, content):
    monkeypatch.chdir(tmp_path)
    path = Path("none.py")
    if content:
        path.write_bytes(content)
    with pytest.raises(DragonError) as refused:
        read_program(path)
    assert str(refused.value).count(str(path)) == 1
    assert "None" not in str(refused.value)


# Where bodies are that can be taken, in pixels of the page.
BODIES = """() => {
  const field = document.getElementById("field").getBoundingClientRect();
  const places = [];
  for (const { grip, points } of live.frame.calls) {
    const mean = (k) => points.reduce((sum, point) => sum + point[k], 0) / points.length;
    if (grip !== 2 || points.length === 0) continue;
    const [x, y] = live.view.toScreen(mean(0), mean(1));
    const place = [field.left + x, field.top + y];
    const isField = document.elementFromPoint(...place)?.id === "field";
    if (isField && live.tools.bodyAt([x, y], 1)) places.push(place);
  }
  return places;
}"""
FIRST_X = "live.frame.calls.find(({ grip }) => grip === 2).points[0][0]"


def begin(page):
    """Begin the engine of a page, and switch the network off."""
    page.click("#begin-play")
    wait_until(page, "live.frame?.time > 0")
    page.context.set_offline(True)
    wait_until(page, "live.frame.time > 0.2")


def drag_a_body(page):
    """Pause, take a body, and let go of it."""
    page.click("#play")
    wait_until(page, "!live.state.running")
    x, y = page.evaluate(BODIES)[0]
    page.mouse.move(x, y)
    page.mouse.down()
    wait_until(page, "live.frame.held !== null")
    page.mouse.move(x + 30, y - 30)
    page.mouse.up()
    wait_until(page, "live.frame.held === null")
    page.click("#play")
    wait_until(page, "live.state.running")


@pytest.mark.thorough
@needs_browser
@pytest.mark.parametrize(("name", "width", "height"), [("car", 1280, 800), ("cradle", 390, 844)])
def test_program_plays_on_without_a_network(browser, name, width, height, pyodide, tmp_path):
    publish_program(DATA / f"{name}.py", tmp_path / "site", runtime=pyodide)
    with (
        served(tmp_path / "site") as address,
        opened(browser, address, width, height) as found,
    ):
        page = found.page
        begin(page)
        drag_a_body(page)
        if name == "car":
            before = page.evaluate(FIRST_X)
            page.focus("#field")
            page.keyboard.down("ArrowRight")
            wait_until(page, f"{FIRST_X} > {before} + 1")
            page.keyboard.up("ArrowRight")
        else:
            page.click("#parameters-part summary")
            page.focus("#parameters input")
            page.keyboard.press("ArrowUp")
            wait_until(page, "live.state.values.balls === 6 && live.frame?.time > 0")
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        assert page.evaluate("document.getElementById('error').hidden")
        assert found.complaints == []


@pytest.mark.thorough
@needs_browser
def test_fault_in_the_first_step_is_shown_with_its_line(browser, pyodide, tmp_path):
    program = tmp_path / "fault.py"
    source = (DATA / "car.py").read_text("utf-8")
    program.write_text(source.replace("in space.constraints:", "in space.joints:"), "utf-8")
    publish_program(program, tmp_path / "site", runtime=pyodide)
    with (
        served(tmp_path / "site") as address,
        opened(browser, address) as found,
    ):
        found.page.click("#begin-play")
        wait_until(found.page, "!document.getElementById('error').hidden")
        shown = found.page.inner_text("#error")
        lines = source.splitlines()
        number = 1 + next(i for i, line in enumerate(lines) if "in space.constraints:" in line)
        assert "AttributeError" in shown
        assert f"fault.py, line {number}: for joint in space.joints:" in shown
        assert found.complaints == []


@pytest.mark.thorough
@needs_browser
def test_page_says_that_its_server_does_not_answer(browser, copy, tmp_path):
    publish_program(DATA / "cradle.py", tmp_path / "site", runtime=copy)
    with (
        served(tmp_path / "site") as address,
        opened(browser, address) as found,
    ):
        page = found.page
        page.context.set_offline(True)
        # No page but that of a dragon has these.
        assert not any(map(page.is_visible, ("#dancers", "#charts-error", "#show-exact")))
        page.click("#begin-play")
        wait_until(page, "document.getElementById('begin-text').textContent.includes('answer')")
        # One may try again.
        assert page.is_visible("#begin-play")
