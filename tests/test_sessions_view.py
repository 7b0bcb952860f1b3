"""The view of a live space: its first area, what it follows, its title, and how exact it is."""

from __future__ import annotations

import functools
import math
import time

import numpy as np
import pymunk
import pytest
from conftest import refusal
from live_sessions import PATIENCE, Listener, decoded, greeting, played

from pymunk_dragon import live
from pymunk_dragon.publish.program import read_program
from pymunk_dragon.sessions.live import source_of
from pymunk_dragon.sessions.scene import PlaySettings, Scene

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


def corners(frame):
    """Corners of the box, which is all that the frame has."""
    return frame.calls[7:].reshape(-1, 2)


@pytest.mark.parametrize("at", [(0.0, 0.0), UTM, (-1e8, 3e7)])
@pytest.mark.parametrize("size", [5e-6, 1.0, 1e7])
def test_frame_has_corners_to_a_millionth_of_the_view_wherever_and_however_large(at, size):
    if size < 1 < abs(at[0]):
        pytest.skip("a double has no such places")
    scene = scene_of(lambda: build(at, size))
    width, height = scene.view["size"]
    assert (width, height) == pytest.approx((size, size), rel=1e-6)
    assert scene.view["centre"] == pytest.approx(at, abs=1e-6 * size)
    [body] = scene.space.bodies
    [shape] = body.shapes
    expected = [body.local_to_world(corner) for corner in shape.get_vertices()]
    found = corners(decoded(scene.frame({})))
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
    "view", [(0, 0, 0, 1), (0, 0, 1, -1), (math.nan, 0, 1, 1), (0, 0, math.inf, 1), (0, 0), 3, "x"]
)
def test_view_that_shows_nothing_is_refused(view):
    assert refusal(live, build, view=view, browser=False).name == "view"


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

    def show(self, frame):
        self.told.append({"kind": "frame", "frame": decoded(frame)})


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
    frames = [each["frame"] for each in told if each["kind"] == "frame"]
    assert [each.focus for each in frames[-2:]] == [None, None]
    assert len(corners(frames[-1])) == 4


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
