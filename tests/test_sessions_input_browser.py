"""Mouse, wheel and keys in a real browser: what they do to bodies and to pygame programs."""

from __future__ import annotations

import time
from contextlib import contextmanager

import numpy as np
import pymunk
import pytest
from browser import needs_browser, wait_until
from live_sessions import PATIENCE
from test_sessions_browser import PLACE, shown
from test_sessions_input import ball, keep_queries

from pymunk_dragon.physics.readings import body_at
from pymunk_dragon.sessions.controls import Button, Key, PygameEvents, Slider
from pymunk_dragon.sessions.live import source_of
from pymunk_dragon.sessions.scene import PlaySettings

pytestmark = [pytest.mark.thorough, needs_browser]

# The number of the shape that the page would take at each point, in the order of drawing; -1 for
# none.
TAKEN = """([points, slip]) => points.map((point) => {
  const { view, tools } = live;
  const found = tools.bodyAt(view.toScreen(...point), slip * view.scale);
  return found ? live.frame.calls.filter(({ outline }) => outline).indexOf(found.call) : -1;
})"""


def mixed():
    """Shapes of every kind, of bodies of every type, with sensors and filters, in a heap."""
    rng = np.random.default_rng(5)
    space = pymunk.Space()
    types = [pymunk.Body.DYNAMIC] * 5 + [pymunk.Body.KINEMATIC, pymunk.Body.STATIC]
    for i in range(60):
        body = pymunk.Body(1, 1, body_type=types[i % 7])
        body.position, body.angle = rng.uniform(-3, 3, 2).tolist(), float(i)
        shapes = [
            pymunk.Circle(body, 0.3, (0.1, 0)),
            pymunk.Poly.create_box(body, (0.8, 0.4)),
            pymunk.Poly.create_box(body, (0.5, 0.4), 0.15),
            pymunk.Segment(body, (-0.5, 0), (0.4, 0.2), 0.1),
        ]
        space.add(body, shapes[i % 4])
        shapes[i % 4].sensor = i % 11 == 3
        shapes[i % 4].filter = pymunk.ShapeFilter(mask=i % 3)
        if i % 5 == 0:
            zone = pymunk.Circle(body, 1.2)
            zone.sensor = True
            space.add(zone)
    return space


def test_page_and_engine_take_the_same_body_at_every_point(browser):
    with shown(browser, source_of(mixed, PlaySettings())) as (session, page):
        page.keyboard.press("Space")
        wait_until(page, "!live.state.running")
        scene = session.session.scene
        wait_until(page, f"live.frame.step === {scene.steps}")
        points = np.random.default_rng(1).uniform(-3.5, 3.5, (600, 2))
        with session.paused():
            shapes = scene.shapes()
        expected = []
        for x, y in points:
            try:
                expected.append(body_at(shapes, x, y, 0.1)[0])
            except ValueError:
                expected.append(None)
        got = [
            None if i < 0 else shapes[i].body for i in page.evaluate(TAKEN, [points.tolist(), 0.1])
        ]
        assert got == expected
        assert 20 < expected.count(None) < 500


def test_drag_on_empty_ground_inside_a_sensor_moves_the_view(browser):
    def guarded():
        space = pymunk.Space()
        guard = ball(space, (0, 0))
        zone = pymunk.Circle(guard, 3)
        zone.sensor = True
        space.add(zone)
        return space

    with shown(browser, source_of(guarded, PlaySettings())) as (_, page):
        for point, holds in (((2.0, 0.0), False), ((0.2, 0.0), True)):
            page.mouse.move(*page.evaluate(PLACE, list(point)))
            before = page.evaluate("[live.view.x, live.view.y]")
            page.mouse.down()
            page.mouse.move(*page.evaluate(PLACE, [point[0] + 0.5, point[1] + 0.5]), steps=5)
            if holds:
                wait_until(page, "live.frame.held !== null")
            assert (page.evaluate("[live.view.x, live.view.y]") == before) == holds
            page.mouse.up()
        wait_until(page, "live.frame.held === null")


@contextmanager
def playing(browser, monkeypatch, **options):
    """Page of a pygame program, 300 x 200 pixels; and pygame, whose events nobody takes."""
    pygame = pytest.importorskip("pygame", reason="pygame-ce is in the extra test")
    for name in ("SDL_VIDEODRIVER", "SDL_AUDIODRIVER"):
        monkeypatch.setenv(name, "dummy")
    keep_queries(pygame, monkeypatch)
    pygame.init()
    pygame.display.set_mode((300, 200))
    pygame.event.clear()
    play = PlaySettings(controls=[PygameEvents()], y_down=True, units="px")
    with shown(browser, source_of(pymunk.Space, play), **options) as (session, page):
        yield session, page, pygame
    pygame.quit()


def posted(session, pygame, wanted):
    """Wait until a page has posted so many events that are no motion; names, and their values.

    SDL has events of its own in the queue, as of a new audio device or of a window that gains the
    focus.
    """
    kinds = (
        pygame.KEYDOWN,
        pygame.KEYUP,
        pygame.MOUSEBUTTONDOWN,
        pygame.MOUSEBUTTONUP,
        pygame.MOUSEWHEEL,
    )
    found, end = [], time.monotonic() + PATIENCE
    while len(found) < wanted:
        assert time.monotonic() < end, found
        with session.paused():
            found += [event for event in pygame.event.get() if event.type in kinds]
    values = [vars(event) for event in found]
    detail = [
        value.get("button") or value.get("key") or (value["x"], value["y"]) for value in values
    ]
    return list(zip([pygame.event.event_name(event.type) for event in found], detail, strict=True))


def test_buttons_and_wheel_reach_a_pygame_program_and_no_menu_opens(browser, monkeypatch):
    with playing(browser, monkeypatch) as (session, page, pygame):
        page.evaluate("""() => document.addEventListener("contextmenu", (event) => {
          globalThis.menu = event.defaultPrevented;
        })""")
        page.mouse.move(*page.evaluate(PLACE, [120, 80]))
        for name, number in (("left", 1), ("middle", 2), ("right", 3)):
            page.mouse.down(button=name)
            assert posted(session, pygame, 1) == [("MouseButtonDown", number)]
            assert pygame.mouse.get_pos() == pytest.approx((120, 80), abs=1)
            assert pygame.mouse.get_pressed()[number - 1]
            page.mouse.up(button=name)
            assert posted(session, pygame, 1) == [("MouseButtonUp", number)]
        assert page.evaluate("globalThis.menu")
        # Two at once.
        page.mouse.down(button="left")
        page.mouse.down(button="right")
        page.mouse.up(button="left")
        names = posted(session, pygame, 3)
        assert names == [("MouseButtonDown", 1), ("MouseButtonDown", 3), ("MouseButtonUp", 1)]
        page.mouse.up(button="right")
        assert posted(session, pygame, 1) == [("MouseButtonUp", 3)]
        span = page.evaluate("live.view.span")
        page.mouse.wheel(0, 100)
        assert posted(session, pygame, 3) == [
            ("MouseButtonDown", 5),
            ("MouseButtonUp", 5),
            ("MouseWheel", (0, -1)),
        ]
        assert page.evaluate("live.view.span") == span
        # The other tools leave menu and wheel as they are.
        page.evaluate("live.tools.choose('drag')")
        page.mouse.wheel(0, -100)
        wait_until(page, f"live.view.span < {span}")
        page.mouse.click(*page.evaluate(PLACE, [120, 80]), button="right")
        assert not page.evaluate("globalThis.menu")
        page.keyboard.press("x")
        assert posted(session, pygame, 2) == [("KeyDown", pygame.K_x), ("KeyUp", pygame.K_x)]


def test_what_a_page_holds_of_a_pygame_program_is_released_when_it_is_left(browser, monkeypatch):
    leaving = {
        "window": "dispatchEvent(new Event('blur'))",
        "tab": """() => {
          Object.defineProperty(document, "hidden", { value: true, configurable: true });
          document.dispatchEvent(new Event("visibilitychange"));
          delete document.hidden;
        }""",
        "field": "document.getElementById('speed').focus()",
        "page": "live.connection.socket.close()",
    }
    with playing(browser, monkeypatch) as (session, page, pygame):
        for way, script in leaving.items():
            wait_until(page, "live.controls")
            page.evaluate("document.getElementById('field').focus()")
            page.mouse.move(*page.evaluate(PLACE, [120, 80]))
            page.keyboard.down("a")
            if way != "field":
                page.mouse.down(button="right")
            downs = posted(session, pygame, 1 if way == "field" else 2)
            page.evaluate(script)
            ups = posted(session, pygame, len(downs))
            assert sorted(ups) == sorted(
                (name.replace("Down", "Up"), detail) for name, detail in downs
            ), way
            assert not pygame.key.get_pressed()[pygame.K_a]
            page.keyboard.up("a")
            page.mouse.up(button="right")


def test_keys_with_shift_and_ctrl_reach_a_pygame_program_and_are_released(browser, monkeypatch):
    with playing(browser, monkeypatch) as (session, page, pygame):
        page.keyboard.down("KeyA")
        page.keyboard.down("Shift")
        page.keyboard.up("KeyA")
        page.keyboard.up("Shift")
        names = posted(session, pygame, 4)
        shift = pygame.K_LSHIFT
        assert names == [
            ("KeyDown", pygame.K_a),
            ("KeyDown", shift),
            ("KeyUp", pygame.K_a),
            ("KeyUp", shift),
        ]
        page.keyboard.down("Control")
        assert posted(session, pygame, 1) == [("KeyDown", pygame.K_LCTRL)]
        assert pygame.key.get_mods() & pygame.KMOD_CTRL
        page.keyboard.up("Control")
        assert posted(session, pygame, 1) == [("KeyUp", pygame.K_LCTRL)]


def test_key_whose_name_changes_with_shift_is_released(browser):
    told = []
    keys = [Key("w", lambda space: told.append("down"), lambda space: told.append("up"))]
    with shown(browser, source_of(pymunk.Space, PlaySettings(controls=keys))) as (_, page):
        page.keyboard.down("KeyW")
        page.keyboard.down("Shift")
        page.keyboard.up("KeyW")
        page.keyboard.press("Space")
        wait_until(page, "!live.state.running")
        # What was sent before has taken effect.
        assert told == ["down", "up"]


def test_slider_and_button_that_a_key_has_reached_keep_their_keys(browser):
    told = []
    controls = [
        Slider("pull", 0, 10, 5, action=lambda space, value: told.append("pull")),
        Button("Push", lambda space: told.append("push")),
        Key("ArrowRight", lambda space: told.append("right")),
        Key(" ", lambda space: told.append("space")),
    ]
    settings = PlaySettings(controls=controls)
    with shown(browser, source_of(pymunk.Space, settings)) as (_, page):
        page.keyboard.press("Tab")
        page.focus("#parameters input")
        page.keyboard.press("ArrowRight")
        page.focus("#actions button")
        page.keyboard.press("Space")
        page.focus("#field")
        page.keyboard.press("ArrowRight")
        page.keyboard.press("Space")
        page.click("#play")
        wait_until(page, "!live.state.running")
        # What was sent before has taken effect.
        assert told == ["pull", "push", "right", "space"]


def test_finger_is_the_left_button_and_two_move_the_view(browser, monkeypatch):
    with playing(browser, monkeypatch, has_touch=True) as (session, page, pygame):
        touch = page.context.new_cdp_session(page)

        def fingers(kind, *points):
            where = [page.evaluate(PLACE, list(point)) for point in points]
            touch.send(
                "Input.dispatchTouchEvent",
                {"type": kind, "touchPoints": [{"x": x, "y": y} for x, y in where]},
            )

        fingers("touchStart", (100, 50))
        assert posted(session, pygame, 1) == [("MouseButtonDown", 1)]
        fingers("touchMove", (120, 60))
        fingers("touchEnd")
        assert posted(session, pygame, 1) == [("MouseButtonUp", 1)]
        assert pygame.mouse.get_pos() == pytest.approx((120, 60), abs=1)
        span = page.evaluate("live.view.span")
        fingers("touchStart", (100, 50))
        fingers("touchStart", (100, 50), (150, 50))
        assert posted(session, pygame, 2) == [("MouseButtonDown", 1), ("MouseButtonUp", 1)]
        fingers("touchMove", (80, 50), (180, 50))
        fingers("touchEnd")
        wait_until(page, f"live.view.span < {span}")
