"""The view of a live space: its first area, what it follows, its title, and how exact it is."""

from __future__ import annotations

import functools
import math
import time
from itertools import product

import numpy as np
import pymunk
import pytest
import test_publish
from browser import needs_browser, opened, wait_until
from conftest import assert_says, refusal
from live_sessions import PATIENCE, Listener, all_calls, decoded, drawn_in, greeting, played, served

from pymunk_dragon import live
from pymunk_dragon.publish.program import read_program
from pymunk_dragon.publish.site import publish_program
from pymunk_dragon.sessions.live import source_of
from pymunk_dragon.sessions.scene import PlaySettings, Scene

# A copy of Pyodide.
pyodide = test_publish.pyodide
# A place in zone 33 of the Universal Transverse Mercator grid, m.
UTM = (500_000.0, 4_649_776.0)


def build(at=(0.0, 0.0), size=1.0):
    """A box that slides to the right."""
    space = pymunk.Space()
    body = pymunk.Body(1.0, 1.0)
    body.position = at
    body.velocity = size, 0
    space.add(body, pymunk.Poly.create_box(body, (size, size)))
    return space


def box(space):
    return next(iter(space.bodies))


def scene_of(build, **settings):
    return source_of(build, PlaySettings(**settings)).build({})


def corners(scene):
    """Corners of the box, which is all that a frame has."""
    [(_, points, *_)], _ = drawn_in(scene)
    return points


@pytest.mark.parametrize(
    ("at", "size"),
    # A double at a distant place has no digits for the smallest size.
    [((0.0, 0.0), 5e-6), *product([(0.0, 0.0), UTM, (-1e8, 3e7)], [1.0, 1e7])],
)
def test_frame_has_corners_to_a_millionth_of_the_view_wherever_and_however_large(at, size):
    scene = scene_of(lambda: build(at, size))
    width, height = scene.view["size"]
    assert (width, height) == pytest.approx((size, size), rel=1e-6)
    assert scene.view["centre"] == pytest.approx(at, abs=1e-6 * size)
    [body] = scene.space.bodies
    [shape] = body.shapes
    expected = [body.local_to_world(corner) for corner in shape.get_vertices()]
    found = corners(scene)
    assert np.abs(found - expected).max() <= 1e-6 * width


def test_first_area_is_the_view_that_is_given_or_has_a_size_where_all_is_a_point_or_a_line():
    assert scene_of(build, view=(1, 2, 30, 4)).view == {"centre": [1, 2], "size": [30, 4]}
    space = pymunk.Space()
    assert min(Scene(space, PlaySettings()).view["size"]) > 0
    space.add(pymunk.Circle(space.static_body, 0, (3, 4)))
    scene = Scene(space, PlaySettings())
    assert (scene.view["centre"], min(scene.view["size"]) > 0) == ([3, 4], True)
    space.add(pymunk.Segment(space.static_body, (0, 4), (6e-6, 4), 0))
    space.remove(next(iter(space.shapes)))
    width, height = Scene(space, PlaySettings()).view["size"]
    assert 0 < height < width == pytest.approx(6e-6)


@pytest.mark.parametrize(
    "view",
    [
        (0, 0, 0, 1),
        (0, 0, 1, -1),
        (math.nan, 0, 1, 1),
        (0, 0, math.inf, 1),
        (0, 0),
        3,
        (0, 0, 1, "4"),
        "x",
    ],
)
def test_view_that_shows_nothing_is_refused(view):
    refused = refusal(live, build, view=view, browser=False)
    assert_says(refused, f"view is {view!r}", "width")


def test_view_may_be_an_array():
    with live(build, view=np.array([1.0, 2.0, 3.0, 4.0]), browser=False) as session:
        assert session._session.scene.view["size"] == [3, 4]


@pytest.mark.parametrize(
    "follow",
    [
        box,
        lambda space: box(space).position,
        lambda space: np.array(box(space).position),
    ],
)
def test_view_follows_a_body_or_a_point_while_it_moves(follow):
    with played(source_of(build, PlaySettings(follow=follow))) as on:
        on.step(60)
        on.session._show(0.0)
        x, y = on.scene.focus()
        assert (x, y) == pytest.approx((1.0, 0.0))
        assert greeting(on)[0]["follows"]
    assert Scene(build(), PlaySettings()).focus() is None


class Watcher(Listener):
    """A client that keeps frames."""

    def show(self, frame, outlines):
        self.told.append({"kind": "frame", "frame": decoded(frame), "outlines": outlines})


def failing(space):
    """Fail once the box has moved."""
    return box(space) if box(space).position.x < 0.1 else 1 / 0


def elsewhere(space):
    """Return no place once the box has moved."""
    return box(space) if box(space).position.x < 0.1 else (math.nan, "x")


@pytest.mark.parametrize(
    "follow", [failing, elsewhere, lambda space: None, lambda space: (1, 2, 3)]
)
def test_session_pauses_with_file_and_line_where_what_it_follows_is_no_place(follow):
    told = []
    with played(source_of(build, PlaySettings(follow=follow))) as on:
        on.session.join(Watcher(on.session, told))
        assert on.do("play") is None
        end = time.monotonic() + PATIENCE
        while on.session.clock.running:
            assert time.monotonic() < end
            on.settle()
        on.session.call(lambda: on.session._show(0.0))
        on.settle()
    *_, error = [each for each in told if each["kind"] == "error"]
    assert "test_sessions_view.py, line " in error.get("place", error["text"])
    # The picture is shown all the same.
    *_, before, last = [each for each in told if each["kind"] == "frame"]
    assert [each["frame"].focus for each in (before, last)] == [None, None]
    [(_, points, *_)] = all_calls(last["frame"], last["outlines"])
    assert len(points) == 4


class Builder:
    """A class whose text is no title."""

    def build(self):
        """Boxes on a belt.

        They slide.
        """
        return build()

    __call__ = build


UNTITLED = (pymunk.Space, pymunk.Space(), Builder(), functools.partial(build, size=2))
TITLES = [
    (build, None, "A box that slides to the right"),
    (build, "Mine", "Mine"),
    (Builder().build, None, "Boxes on a belt"),
    *[(what, None, "A space") for what in UNTITLED],
    *[(what, "Mine", "Mine") for what in UNTITLED],
]


@pytest.mark.parametrize(("what", "title", "expected"), TITLES)
def test_title_is_the_one_that_is_given_or_the_first_line_of_the_docstring(what, title, expected):
    with played(source_of(what, PlaySettings(title=title))) as on:
        scene = greeting(on)[0]
        assert scene["title"] == expected
        assert scene["scenes"][0]["title"] == expected


PROGRAM = '''"""A published box."""
import pymunk
from pymunk_dragon import live


def build():
    """A box."""
    space = pymunk.Space()
    body = pymunk.Body(1, 1)
    body.position = 50, 0
    space.add(body, pymunk.Poly.create_box(body, (1, 1)))
    return space


live(build, view=(0, 0, 4, 3), follow=lambda space: next(iter(space.bodies)){more})
'''


def test_published_page_has_the_title_and_a_picture_of_what_is_followed(tmp_path):
    path = tmp_path / "box.py"
    pictures = set()
    for more, title in (("", "A published box"), (", title='Mine'", "Mine")):
        path.write_text(PROGRAM.replace("{more}", more), "utf-8")
        program = read_program(path)
        assert program.title == title
        pictures.add(program.picture)
    path.write_text(
        PROGRAM.replace("follow=lambda space", "on_step=lambda space, t").replace("{more}", "")
    )
    # Without what is followed the box is not in the picture.
    assert len({*pictures, read_program(path).picture}) == 2


# Whether the view is centred on the box that is followed, and where that is.
CENTRED = "live.view.x === live.frame.focus?.[0] && live.view.y === live.frame.focus[1]"
FOCUS = "live.frame.focus[0]"
# The box and the post far away, in pixels of a canvas of a width and a height.
PLACES = """live.frame.calls.flatMap(({ points }) =>
  points.map((point) => live.view.toScreen(...point)))"""


def two():
    """A box and a post a kilometre away."""
    space = build(UTM)
    space.add(pymunk.Circle(space.static_body, 1.0, (UTM[0] + 1000, UTM[1])))
    return space


@pytest.mark.thorough
@needs_browser
@pytest.mark.parametrize(("width", "height"), [(1280, 800), (390, 844)])
def test_page_follows_until_the_view_is_moved_and_whole_field_shows_what_there_is(
    browser, width, height
):
    source = source_of(two, PlaySettings(view=(0, 0, 20, 10), follow=box, title="A title"))
    with (
        served(source) as session,
        opened(browser, session.address, width, height) as found,
    ):
        page = found.page
        wait_until(page, "globalThis.live?.frame?.time > 0 && live.drawn > 0")
        assert page.title() == page.text_content("#title") == "A title"
        assert page.evaluate("20 * live.view.scale") < width
        wait_until(page, CENTRED)
        before = page.evaluate(FOCUS)
        wait_until(page, f"{FOCUS} > {before} + 0.2 && {CENTRED}")
        # Corners are where they are to a millionth of the view.
        half = page.evaluate(f"Math.abs(live.frame.calls[0].points[0][0] - {FOCUS})")
        assert half == pytest.approx(0.5, abs=1e-8)
        # Zooming goes on following, also while the session is paused.
        page.keyboard.press("Space")
        wait_until(page, "!live.state.running")
        page.mouse.move(width / 3, 300)
        page.mouse.wheel(0, -300)
        page.keyboard.press("Space")
        wait_until(page, f"live.state.running && live.follow === 'head' && {CENTRED}")
        page.keyboard.press("d")
        wait_until(page, "live.follow === null")
        x = page.evaluate("live.view.x")
        before = page.evaluate(FOCUS)
        wait_until(page, f"{FOCUS} > {before} + 0.2")
        assert page.evaluate("live.view.x") == x
        page.click("#fit")
        wait_until(page, "live.view.span > 200")
        places = page.evaluate(PLACES)
        assert len(places) == 5
        assert all(0 < x < width and 0 < y < height for x, y in places)
        # Also when all begins again.
        generation = page.evaluate("live.scene.generation")
        page.click("#reset")
        wait_until(page, f"live.frame?.generation > {generation} && live.view.span > 200")
        page.keyboard.press("h")
        wait_until(page, CENTRED)
        assert page.get_attribute("#follow", "aria-pressed") == "true"
        for factor in (1e-9, 1e18):
            before = page.evaluate("live.view.scale")
            page.evaluate(f"live.zoom({factor})")
            assert page.evaluate("live.view.scale") == pytest.approx(before * factor)
        assert found.complaints == []


@pytest.mark.thorough
@needs_browser
def test_view_stays_while_the_body_that_it_follows_is_dragged(browser):
    # A view that goes on following would move the place where the pointer pulls the body, for ever.
    source = source_of(two, PlaySettings(view=(0, 0, 20, 10), follow=box))
    with served(source) as session, opened(browser, session.address) as found:
        page = found.page
        wait_until(page, f"globalThis.live?.frame?.time > 0 && {CENTRED}")
        field = page.locator("#field").bounding_box()
        x, y = page.evaluate("live.view.toScreen(...live.frame.focus)")
        page.mouse.move(field["x"] + x, field["y"] + y)
        page.mouse.down()
        page.mouse.move(field["x"] + x + 200, field["y"] + y, steps=5)
        wait_until(page, "Math.abs(live.frame.held?.[2] - live.frame.held?.[0]) < 0.1")
        assert page.evaluate(f"({FOCUS} - live.view.x) * live.view.scale") > 150
        page.mouse.up()
        wait_until(page, f"live.frame.held === null && {CENTRED}")
        assert found.complaints == []


@pytest.mark.thorough
@needs_browser
def test_published_page_follows(browser, pyodide, tmp_path):
    path = tmp_path / "box.py"
    path.write_text(PROGRAM.replace("{more}", ", title='Mine'"), "utf-8")
    publish_program(path, tmp_path / "site", runtime=pyodide)
    with (
        test_publish.served(tmp_path / "site") as address,
        opened(browser, address) as found,
    ):
        page = found.page
        page.click("#begin-play")
        wait_until(page, f"live.frame?.time > 0 && {CENTRED} && live.view.x === 50")
        assert page.title() == page.text_content("#title") == "Mine"
        assert found.complaints == []
