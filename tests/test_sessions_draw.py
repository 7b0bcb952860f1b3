"""What a program draws on the picture of its space, and the clicks and keys that it hears."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from io import BytesIO

import numpy as np
import pymunk
import pytest
from conftest import assert_says
from live_sessions import KINDS, Listener, all_calls, decoded, played
from PIL import Image

from pymunk_dragon import Button, Key, ParameterError, PygameEvents, Slider, live
from pymunk_dragon.sessions.draw import MAX_CALLS, Draw
from pymunk_dragon.sessions.scene import PlaySettings, Scene
from pymunk_dragon.sessions.scenes import space_scene

RED = (255, 0, 0, 255)


class Viewer(Listener):
    """A client that keeps the newest frame."""

    frame = None

    def show(self, frame, outlines):
        """Decode a frame."""
        self.outlines = outlines
        self.frame = decoded(frame)


@contextmanager
def watched(build=pymunk.Space, **settings):
    """A session of a space, and a client that is shown its frames."""
    with played(space_scene(build, PlaySettings(**settings))) as on:
        viewer = Viewer(on.session, [])
        on.session.join(viewer)
        yield on, viewer


def shown(on, viewer):
    """The next frame that a client is shown: calls with colours and points, and texts."""
    viewer.frame = None
    while viewer.frame is None:
        on.settle()
    calls = []
    for kind, points, radius, _, fill, rim, grip in all_calls(viewer.frame, viewer.outlines):
        line = None if rim is None else tuple(rim)
        calls.append((KINDS.index(kind), points.tolist(), radius, tuple(fill), line, grip))
    return calls, viewer.frame.texts


def falling():
    """A ball that falls from the origin."""
    space = pymunk.Space()
    space.gravity = 0, -10
    body = space.ball = pymunk.Body(1, 1)
    space.add(body, pymunk.Circle(body, 0.5))
    return space


def draw_all(space, draw):
    draw.line((0, 0), (1, 2), pymunk.Vec2d(3, 4), color="red")
    draw.circle(np.array([1.0, 2.0]), 0.5, color=(0, 0, 255), fill="#00ff0080")
    draw.circle((0, 0), 3)
    draw.arrow((0, 0), (10, 0), color=pymunk.SpaceDebugDrawOptions().collision_point_color)
    draw.text((5, 6), "Score: 3\nLives: 2", size=20, color="red")


def test_lines_circles_arrows_and_texts_are_in_the_frame_as_they_were_drawn():
    with watched(on_draw=draw_all) as (on, viewer):
        [line, disc, ring, arrow], texts = shown(on, viewer)
    assert line == (3, [[0, 0], [1, 2], [3, 4]], 0, RED, None, 0)
    # A polygon of one corner is a disc.
    assert disc == (2, [[1, 2]], 0.5, (0, 255, 0, 128), (0, 0, 255, 255), 0)
    assert (ring[:3], ring[3][3]) == ((2, [[0, 0]], 3), 0)
    assert arrow[1][:2] == [[0, 0], [10, 0]]
    # The head is symmetric, and behind the tip.
    [left, tip, right] = arrow[1][2:]
    assert tip == [10, 0]
    assert left == pytest.approx([right[0], -right[1]])
    assert 0 < left[0] < 10
    assert left[1] != 0
    [text] = texts
    assert text == [5, 6, "Score: 3\nLives: 2", 20, [*RED]]


def test_drawing_comes_after_what_pymunk_draws_and_no_hand_takes_it():
    def mark(space, draw):
        draw.circle(space.ball.position, 2)

    with watched(falling, on_draw=mark) as (on, viewer):
        calls, _ = shown(on, viewer)
        assert [call[-1] for call in calls] == [2, 0]
        assert on.do("grab", x=1.5, y=0.0, slip=0.1) is not None


def trails(space, draw):
    ball = space.ball
    draw.trail(ball, 5)
    draw.trail(ball.local_to_world((1, 0)), 3)


def test_trail_keeps_the_last_points_and_waits_where_nothing_moves():
    with watched(falling, on_draw=trails) as (on, viewer):
        places = []
        for _ in range(8):
            places.append(on.scene.space.ball.position)
            shown(on, viewer)
            # Also a picture without a step.
            shown(on, viewer)
            on.step(1)
        places.append(on.scene.space.ball.position)
        calls, _ = shown(on, viewer)
        ball, tip = (np.array(call[1]) for call in calls[1:])
        np.testing.assert_allclose(ball, places[-5:], rtol=1e-6)
        np.testing.assert_allclose(tip, np.add(places[-3:], (1, 0)), rtol=1e-6)
        on.do("reset")
        calls, _ = shown(on, viewer)
        assert [call[1] for call in calls[1:]] == [[[0, 0]], [[1, 0]]]


def after(draw):
    """What draws on the next picture."""
    found = Draw()
    found.before = draw.trails
    return found


def test_trail_that_a_picture_leaves_out_begins_anew():
    space = falling()
    first = Draw()
    first.trail(space.ball)
    first.trail((1, 1))
    first.trail((2, 2))
    space.ball.position = 3, 3
    # Points are told apart by their order, bodies by themselves.
    second = after(first)
    second.trail((1, 2))
    second.trail(space.ball)
    assert [call.points for call in second.calls] == [((1, 1), (1, 2)), ((0, 0), (3, 3))]
    third = after(after(second))
    third.trail(space.ball)
    assert [call.points for call in third.calls] == [((3, 3),)]


def many(space, draw):
    for i in range(3 * MAX_CALLS):
        draw.line((i, 0), (i, 1))


def fail(space, draw):
    draw.line((0, 0), (1, 1))
    return 1 / 0


def wrong(space, draw):
    draw.circle((0, 0), -1)


def chatty(space, draw):
    return 3


@pytest.mark.parametrize("on_draw", [many, fail, wrong, chatty])
def test_error_in_on_draw_pauses_names_file_and_line_and_pictures_go_on(on_draw):
    with watched(falling, on_draw=on_draw) as (on, viewer):
        on.do("play")
        while on.session.clock.running or not on.errors:
            on.settle()
        calls, _ = shown(on, viewer)
        assert len(calls) == 1 + {many: MAX_CALLS, fail: 1}.get(on_draw, 0)
        # The same error follows the start, as the first picture had it already.
        error, *others = [message for message in on.told if message["kind"] == "error"]
        assert others in ([], [error])
        where = error["text"] if on_draw is chatty else error["place"]
        assert "test_sessions_draw.py, line " in where
        if on_draw is many:
            assert str(MAX_CALLS) in error["text"]
        if on_draw is wrong:
            assert_says(ValueError(error["text"]), "radius")


@pytest.mark.parametrize(
    ("name", "arguments", "changed"),
    [
        ("line", [(0, 0), (np.nan, 1)], {}),
        ("line", [(0, 0), 3], {}),
        ("line", [(0, 0), (1, 2, 3)], {}),
        ("line", [(0, 0), (1, 2)], {"color": "reddish"}),
        ("line", [(0, 0), (1, 2)], {"color": (0, 0)}),
        ("line", [(0, 0), (1, 2)], {"color": (0, 0, 0, 0, 0)}),
        ("line", [(0, 0), (1, 2)], {"color": (0, 0, 256)}),
        ("line", [(0, 0), (1, 2)], {"color": 3}),
        ("circle", [(0, 0), "1"], {}),
        ("arrow", [(0, 0), None], {}),
        ("trail", ["ball"], {}),
        ("trail", [(0, 0), 1.5], {}),
        ("text", [(0, 0), 3], {}),
        ("text", [(0, 0), "x"], {"size": 0}),
    ],
)
def test_wrong_arguments_of_drawing_are_refused(name, arguments, changed):
    with pytest.raises(ParameterError) as raised:
        getattr(Draw(), name)(*arguments, **changed)
    assert_says(raised.value)


# ---- clicks


def test_click_calls_the_program_in_the_sessions_thread_and_is_an_input_of_recordings():
    heard = []

    def on_click(space, point, button):
        heard.append((point, button, threading.current_thread()))
        body = pymunk.Body(1, 1)
        body.position = point
        space.add(body, pymunk.Circle(body, 0.1))

    with watched(on_click=on_click) as (on, _):
        assert on.scene.to_dict()["clicks"]
        on.step(2)
        assert on.do("click", x=3.0, y=4.0, button=3) is None
        [(point, button, thread)] = heard
        assert (point, button) == (pymunk.Vec2d(3, 4), 3)
        assert point.length == 5
        assert thread is not threading.current_thread()
        assert len(on.scene.space.bodies) == 1
        recorded = {"do": "click", "x": 3.0, "y": 4.0, "button": 3}
        assert on.session.log()["inputs"] == [[2, recorded]]
        assert_says(ValueError(on.do("click", x=3.0, y=4.0, button=4)), "button")


def test_click_is_refused_where_the_program_hears_none():
    with watched() as (on, _):
        assert not on.scene.to_dict()["clicks"]
        assert on.do("click", x=0.0, y=0.0, button=1) is not None


def test_exception_in_on_click_pauses_and_shows_its_line():
    with watched(on_click=lambda space, point, button: 1 / 0) as (on, _):
        on.do("play")
        on.do("click", x=0.0, y=0.0, button=1)
        assert not on.session.clock.running
        [error] = [message for message in on.told if message["kind"] == "error"]
        assert "1 / 0" in error["place"]


# ---- keys and names


def ignore(*_):
    """Do nothing."""


@pytest.mark.parametrize("name", ["ArrowLeft", " ", "a", "A", "é", "Enter", "F5", "Control"])
def test_names_of_keys_are_those_of_browsers(name):
    assert Key(name, ignore).name == name


@pytest.mark.parametrize("name", ["left", "space", "Space", "RETURN", "K_a", "", "ab", "\n"])
def test_other_names_of_keys_are_refused(name):
    with pytest.raises(ParameterError) as raised:
        Key(name, ignore)
    assert_says(raised.value, "ArrowLeft")


@pytest.mark.parametrize(
    "controls",
    [
        [Key("a", ignore), Key("a", ignore)],
        [Button("a", ignore), Key("a", ignore)],
        [Slider("a", 0, 1, action=ignore), Button("a", ignore)],
    ],
)
def test_two_controls_of_one_name_are_refused(controls):
    with pytest.raises(ParameterError) as raised:
        live(pymunk.Space, controls=controls, browser=False)
    assert_says(raised.value, "'a'")


def test_a_pygame_program_has_the_mouse_and_no_on_click():
    pytest.importorskip("pygame", reason="pygame-ce is in the extra test")
    events = PygameEvents.__new__(PygameEvents)
    with pytest.raises(ParameterError) as raised:
        live(pymunk.Space, controls=[events], on_click=ignore, browser=False)
    assert_says(raised.value, "on_click")


def test_picture_of_a_scene_has_what_is_drawn_up_to_an_error():
    def counts(on_draw):
        """Pixels that are more red, and those that are more green, than anything else."""
        scene = Scene(pymunk.Space(), PlaySettings(on_draw=on_draw, view=(0, 0, 12, 12)))
        with Image.open(BytesIO(scene.picture())) as image:
            red, green, blue = np.moveaxis(np.array(image, int), 2, 0)
        found = red - np.maximum(green, blue), green - np.maximum(red, blue)
        return [(each > 50).sum() for each in found]

    def failing(space, draw):
        draw_all(space, draw)
        return 1 / 0

    assert counts(None) == [0, 0]
    # The line and the arrow, and the disc; the field is 460 of 480 pixels high.
    red, green = counts(failing)
    assert red > 200
    assert green == pytest.approx(np.pi * (0.5 * 460 / 12) ** 2, rel=0.2)
