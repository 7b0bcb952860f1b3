"""How the page of many bodies draws, in a real browser: pictures that stay, and copied circles."""

from __future__ import annotations

import pymunk
import pytest
from browser import needs_browser, opened, wait_until
from live_sessions import served

pytestmark = [pytest.mark.thorough, needs_browser]

# Count the pictures that are painted.
COUNT = """() => {
  const { painter } = live, draw = painter.draw;
  window.painted = 0;
  painter.draw = function (picture) { window.painted += 1; draw.call(painter, picture); };
}"""
# Numbers of circles that the page copies and draws, and the mean difference of the two pictures'
# colours, of 255, where they differ from the ground; with the ratio 100, no circle is small.
DIFFERENCE = """() => {
  const field = document.getElementById("field"), context = field.getContext("2d");
  const kind = CanvasRenderingContext2D.prototype, { getTransform, arc } = kind;
  let arcs = 0;
  kind.arc = function (...given) { arcs += 1; arc.apply(this, given); };
  const picture = () => {
    arcs = 0;
    live.painter.draw(live.picture);
    return [arcs, context.getImageData(0, 0, field.width, field.height).data];
  };
  const [few, one] = picture();
  kind.getTransform = () => ({ a: 100 });
  const [many, two] = picture();
  Object.assign(kind, { getTransform, arc });
  let sum = 0, count = 0;
  for (let k = 0; k < one.length; k++) {
    if (two[k] === two[k % 4]) continue;
    sum += Math.abs(one[k] - two[k]);
    count += 1;
  }
  return [few, many, sum / count];
}"""


def circles(count):
    """Circles at odd places, angles and sizes, some in a colour of their own, and a box on them."""
    space = pymunk.Space()
    for i in range(count):
        body = pymunk.Body(1, 1)
        body.position = i % 30 * 1.037, i // 30 * 1.019
        body.angle = i
        circle = pymunk.Circle(body, 0.4 + 0.013 * (i % 20))
        if i % 7 == 0:
            circle.color = (200, 80, 60, 255)
        space.add(body, circle)
    box = pymunk.Body(1, 1)
    box.position = 12, 5
    cover = pymunk.Poly.create_box(box, (5, 5))
    cover.color = (46, 204, 113, 160)
    space.add(box, cover)
    return space


def test_copied_circles_look_like_drawn_ones(browser):
    with served(circles(600)) as session, opened(browser, session.address) as found:
        found.page.click("#play")
        wait_until(found.page, "live.drawn > 5")
        few, many, difference = found.page.evaluate(DIFFERENCE)
        assert few == 0
        assert many == 1200
        # Centres are up to an eighth of a pixel off.
        assert difference < 4


def test_picture_that_stays_is_not_drawn_again_and_contacts_come_when_they_are_shown(browser):
    with served(circles(20)) as session, opened(browser, session.address) as found:
        page = found.page
        wait_until(page, "live.drawn > 5 && live.frame.contacts.length === 0")
        page.click("#play")
        wait_until(page, "!live.state.running")
        page.evaluate(COUNT)
        drawn = page.evaluate("live.drawn")
        wait_until(page, f"live.drawn > {drawn + 20}")
        before = page.evaluate("painted")
        assert before <= 2
        page.check("#show-contacts")
        wait_until(page, "live.frame.contacts.length > 0")
        page.click("#zoom-in")
        wait_until(page, f"painted > {before}")
        page.uncheck("#show-contacts")
        wait_until(page, "live.frame.contacts.length === 0")
