"""What the page of a user's own space shows, in a real browser."""

from __future__ import annotations

import pymunk
import pytest
from browser import needs_browser, opened, wait_until
from live_sessions import served

from pymunk_dragon import Dragon, March
from pymunk_dragon.sessions.live import source_of
from pymunk_dragon.sessions.scene import PlaySettings

pytestmark = [pytest.mark.thorough, needs_browser]

SWITCHES = """() => [...document.querySelectorAll("fieldset input")]
  .filter((each) => each.checkVisibility() && each.checked).map(({ id }) => id)"""
CAPTIONS = """() => [...document.querySelectorAll("#charts figure")]
  .filter((each) => each.checkVisibility())
  .map((each) => each.querySelector("figcaption > :first-child"))
  .map((each) => each.selectedOptions?.[0].text ?? each.textContent)"""
# What a chart draws of rows: corners of bars, or points of a line.
DRAWN = """([name, other, view]) => {
  const find = (title) => live.charts.quantities.find((each) => each.title === title);
  const quantity = find(name), drawn = [];
  quantity.rows = [5, 3, 3, 7, null, 3].map((value, k) => [k, value]);
  find(other).rows = [0, 1, 2, 3, 4, 5].map((value, k) => [k, value]);
  quantity.select.value = view;
  quantity.select.dispatchEvent(new Event("change"));
  const fill = quantity.chart.fill, track = quantity.chart.track;
  quantity.chart.fill = (corners) => drawn.push(corners);
  quantity.chart.track = (points) => drawn.push(...points.filter(([, y]) => Number.isFinite(y)));
  quantity.draw();
  Object.assign(quantity.chart, { fill, track });
  return drawn;
}"""
# Whether red marks ten steps a second of 1/60 s, which take so many s each. The loop of a program
# may make few steps; a session that makes the steps itself, and can start again, may not.
IS_SLOW = """([resets, step_time]) => {
  live.scene.resets = resets;
  live.state = { ...live.state, running: true, speed: 1 };
  live.ticks = [];
  for (let step = 0; step <= 10; step += 1) {
    live.newest = null;
    live.frame = { ...live.frame, step, clock: step / 10, time: step / 60, step_time };
    live.tick(performance.now());
  }
  return document.getElementById("achieved").classList.contains("slow");
}"""


def build():
    """A ball that falls on a floor."""
    space = pymunk.Space()
    space.gravity = 0, -9.81
    body = pymunk.Body(1, 1)
    body.position = 0, 1
    floor = pymunk.Segment(space.static_body, (-2, 0), (2, 0), 0.1)
    space.add(body, pymunk.Circle(body, 0.2), floor)
    return space


def height(space):
    return next(iter(space.bodies)).position.y


def test_page_of_a_space_has_the_users_overlays_and_charts_first_and_its_own_help(browser):
    plots = {"height (m)": height, "double": lambda space: 2 * height(space)}
    settings = PlaySettings(plots=plots, show=["forces"])
    with (
        served(source_of(build, settings)) as session,
        opened(browser, session.address) as found,
    ):
        page = found.page
        wait_until(page, "globalThis.live?.charts.quantities[0]?.rows.length > 2")
        assert page.evaluate(SWITCHES) == ["show-forces"]
        assert page.evaluate(CAPTIONS)[:2] == list(plots)

        page.evaluate("live.send({ do: 'pause' })")
        wait_until(page, "!live.state.running")
        bars = page.evaluate(DRAWN, ["height (m)", "double", "histogram"])
        counts = {(left + right) / 2: top for (left, _), (_, top), _, (right, _) in bars}
        assert counts == {3: 3, 5: 1, 7: 1}
        points = page.evaluate(DRAWN, ["height (m)", "double", "double"])
        assert points == [[0, 5], [1, 3], [2, 3], [3, 7], [5, 3]]

        # The choice outlasts a new start.
        page.click("#reset")
        wait_until(page, "live.scene.generation > 1")
        assert page.evaluate("live.charts.quantities[0].select.value") == "double"

        page.click("#help")
        assert page.is_visible("#about")
        assert "bench" not in page.inner_text("#about")
        assert "dancers" not in page.inner_text("#about")
        assert found.complaints == []
    with (
        served(March(Dragon(benches=5))) as session,
        opened(browser, session.address) as found,
    ):
        wait_until(found.page, "globalThis.live?.frame != null")
        shown = ["show-curve", "show-contacts", "show-exact"]
        assert found.page.evaluate(SWITCHES) == shown
        found.page.click("#help")
        assert "bench" in found.page.inner_text("#about")

        assert not found.page.evaluate(IS_SLOW, [False, 0.001])
        assert found.page.evaluate(IS_SLOW, [False, 0.099])
        assert found.page.evaluate(IS_SLOW, [True, 0.001])
