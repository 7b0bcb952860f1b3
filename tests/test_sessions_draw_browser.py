"""What a program draws and hears in a real browser, with the mouse and with fingers."""

from __future__ import annotations

import pymunk
import pytest
from browser import needs_browser, wait_until
from test_sessions_browser import PLACE, shown
from test_sessions_input import ball

from pymunk_dragon.sessions.controls import Key
from pymunk_dragon.sessions.scene import PlaySettings
from pymunk_dragon.sessions.scenes import space_scene

pytestmark = [pytest.mark.thorough, needs_browser]

# Red, green and blue of the canvas at points of the world, after the next picture.
PIXELS = """async (points) => {
  const field = document.getElementById("field");
  const copy = new OffscreenCanvas(field.width, field.height);
  const context = copy.getContext("2d", { willReadFrequently: true });
  await new Promise(requestAnimationFrame);
  context.drawImage(field, 0, 0);
  const ratio = field.width / field.getBoundingClientRect().width;
  return points.map((point) => {
    const [x, y] = live.view.toScreen(...point).map((each) => Math.round(each * ratio));
    return [...context.getImageData(x, y, 1, 1).data.slice(0, 3)];
  });
}"""


def build():
    """A ball in the middle of a frame of 16 x 10."""
    space = pymunk.Space()
    space.ball = ball(space, (0, 0), 1)
    for x in (-8, 8):
        space.add(pymunk.Segment(space.static_body, (x, -5), (x, 5), 0.1))
    return space


def on_draw(space, draw):
    draw.circle((5, 0), 1, color="lime", fill="lime")
    draw.line((-6, -4), (-6, 0), (-2, 4), color=(255, 0, 0))
    draw.text((4, -3), "MMM", size=30, color="blue")
    draw.text((-4, -3), "\n", size=30)


class Program:
    """What a program has heard: clicks, and keys with the state of each."""

    def __init__(self):
        self.clicks = []
        self.keys = []
        self.settings = PlaySettings(
            on_draw=on_draw,
            on_click=lambda space, point, button: self.clicks.append((*point, button)),
            controls=[self.key("ArrowLeft"), self.key("ArrowRight"), self.key("x")],
        )

    def key(self, name):
        def note(sign):
            return lambda space: self.keys.append(sign + name)

        return Key(name, note("+"), note("-"))

    @property
    def source(self):
        return space_scene(build, self.settings)


def heard(page, found, count):
    """What a program has heard: so much, when all that was sent before has taken effect."""
    speed = page.evaluate("live.state.speed === 1 ? 2 : 1")
    page.evaluate(f"live.send({{ do: 'speed', value: {speed} }})")
    wait_until(page, f"live.state.speed === {speed}")
    assert len(found) == count, found
    return found[-1]


def test_what_a_program_draws_is_in_the_picture_over_the_shapes(browser):
    with shown(browser, Program().source) as (_, page):
        # The last two are on both sides of a corner.
        disc, *line = page.evaluate(PIXELS, [[5, 0.3], [-6, -2], [-4, 2]])
        assert disc == [0, 255, 0]
        for red, green, blue in line:
            assert red > 200
            assert max(green, blue) < 120
        # A text is as wide as its letters.
        row = page.evaluate(PIXELS, [[3 + 0.02 * i, -3] for i in range(100)])
        assert 10 < sum(blue > 200 and red + green < 100 for red, green, blue in row) < 90


def test_clicks_of_all_buttons_are_heard_and_drags_pull_a_body_or_the_view(browser):
    program = Program()
    with shown(browser, program.source) as (_, page):
        assert page.evaluate("live.tools.chosen") == "program"
        page.evaluate("""() => document.addEventListener("contextmenu", (event) => {
          globalThis.menu = !event.defaultPrevented;
        })""")
        # Also on a body, which a click does not touch.
        for number, (button, place) in enumerate(
            (("left", (3, 2)), ("middle", (-3, 2)), ("right", (3, -2)), ("left", (0.2, 0.3))), 1
        ):
            page.mouse.click(*page.evaluate(PLACE, list(place)), button=button)
            x, y, pressed = heard(page, program.clicks, number)
            assert (x, y) == pytest.approx(place, abs=0.05)
            assert pressed == {"left": 1, "middle": 2, "right": 3}[button]
        assert page.evaluate("globalThis.menu === false")
        assert page.evaluate("live.frame.held === null")
        page.mouse.move(*page.evaluate(PLACE, [0.2, 0.3]))
        page.mouse.down()
        page.mouse.move(*page.evaluate(PLACE, [1.5, 0.3]), steps=5)
        wait_until(page, "live.frame.held !== null")
        page.mouse.up()
        wait_until(page, "live.frame.held === null")
        before = page.evaluate("live.view.x")
        page.mouse.move(*page.evaluate(PLACE, [-4, -3]))
        page.mouse.down()
        page.mouse.move(*page.evaluate(PLACE, [-3, -3]), steps=5)
        page.mouse.up()
        assert page.evaluate("live.view.x") < before
        page.focus("#field")
        heard(page, program.clicks, 4)
        # With another tool a click is not the program's.
        page.evaluate("live.tools.choose('drag')")
        page.mouse.click(*page.evaluate(PLACE, [3, 2]))
        heard(page, program.clicks, 4)


def test_fingers_click_and_hold_two_keys_at_once(browser):
    program = Program()
    options = {"has_touch": True, "is_mobile": True, "width": 390, "height": 844}
    with shown(browser, program.source, **options) as (_, page):
        touch = page.context.new_cdp_session(page)

        def fingers(kind, *points):
            found = [{"x": x, "y": y, "id": number} for number, (x, y) in points]
            touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": found})

        def centre(number):
            box = page.locator("#held-keys button").nth(number).bounding_box()
            return number, (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)

        fingers("touchStart", (0, page.evaluate(PLACE, [3, 2])))
        fingers("touchEnd")
        assert heard(page, program.clicks, 1) == pytest.approx((3, 2, 1), abs=0.1)
        fingers("touchStart", centre(0))
        fingers("touchStart", centre(0), centre(2))
        heard(page, program.keys, 2)
        fingers("touchEnd", centre(2))
        heard(page, program.keys, 3)
        fingers("touchEnd")
        heard(page, program.keys, 4)
        assert program.keys == ["+ArrowLeft", "+x", "-x", "-ArrowLeft"]
        fingers("touchStart", centre(1))
        fingers("touchCancel")
        heard(page, program.keys, 6)
        assert program.keys[4:] == ["+ArrowRight", "-ArrowRight"]


def test_key_that_mouse_and_keyboard_hold_is_released_by_the_second(browser):
    program = Program()
    with shown(browser, program.source) as (_, page):
        left = page.locator("#held-keys button").nth(0)
        page.focus("#field")
        page.keyboard.down("ArrowLeft")
        left.hover()
        page.mouse.down()
        page.keyboard.up("ArrowLeft")
        heard(page, program.keys, 1)
        page.mouse.up()
        heard(page, program.keys, 2)
        # A pointer that leaves the button releases it.
        page.mouse.down()
        page.mouse.move(0, 0)
        heard(page, program.keys, 4)
        # A button that the tabulator has reached.
        page.keyboard.press("Tab")
        left.focus()
        page.keyboard.press("Enter")
        heard(page, program.keys, 6)
        assert program.keys == ["+ArrowLeft", "-ArrowLeft"] * 3
