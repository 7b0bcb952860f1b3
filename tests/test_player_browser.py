"""The player in a real browser: it plays, shows what the run and the exact model say, and asks nobody for anything."""

from __future__ import annotations

import csv
from contextlib import contextmanager
from dataclasses import replace
from html import escape

import numpy as np
import pytest
from browser import TEXTS, english_words, needs_browser, opened, wait_until
from marches import ARM, TRACTOR, U_TURN
from shapely import Polygon

from pymunk_dragon.collision import Grid
from pymunk_dragon.model.contact import ContactEvent, ContactLog
from pymunk_dragon.model.dragon import Dragon, bench_poses
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.physics import simulate
from pymunk_dragon.player import player_page, write_player
from pymunk_dragon.player.page import DARK, LIGHT

pytestmark = [pytest.mark.thorough, needs_browser]

LABEL = "</script><img src=http://127.0.0.1:9/picture onerror=alert(1)><script>alert(2)</script>"
# Half a count of a place, 0.2 micrometres at the usual width, and as much again between two frames, m.
RESOLUTION = 1.002 * 0.2e-6
CONTACT_TIME = 412.47383768

# Canvas pixel under a point of the floor, as #rrggbb.
COLOUR = """([x, y]) => dragon.then((player) => {
  player.draw();
  const canvas = document.getElementById("field");
  const ratio = canvas.width / canvas.getBoundingClientRect().width;
  const [px, py] = player.pixel(x, y).map((value) => Math.floor(value * ratio));
  const [r, g, b] = canvas.getContext("2d").getImageData(px, py, 1, 1).data;
  return "#" + [r, g, b].map((value) => value.toString(16).padStart(2, "0")).join("");
})"""
# Where on the page a point of the floor is.
PLACE = """([x, y]) => dragon.then((player) => {
  player.draw();
  const { left, top } = document.getElementById("field").getBoundingClientRect();
  const [px, py] = player.pixel(x, y);
  return [left + px, top + py];
})"""


@pytest.fixture(scope="module")
def seed():
    """The seed's last seconds in the exact model."""
    return Run.exact(March(), np.arange(4050, 4127) / 10)


@pytest.fixture(scope="module")
def bumpy():
    """16 benches that touch each other many times, with markup in a label."""
    run = simulate(March(Dragon(benches=16), turns=8), start=80.0, until=90.0, contacts="report")
    return replace(run, provenance={**run.provenance, LABEL: LABEL})


@pytest.fixture(scope="module")
def addresses(seed, bumpy, tmp_path_factory):
    folder = tmp_path_factory.mktemp("player")
    for name, run in {"seed": seed, "bumpy": bumpy}.items():
        write_player(run, folder / f"{name}.html")
    return {name: (folder / f"{name}.html").as_uri() for name in ("seed", "bumpy")}


def in_millimetres(length):
    """Three digits, and no more than three after the point."""
    decimals = min(3, max(0, 2 - int(np.floor(np.log10(1000 * length)))))
    return f"{1000 * length:.{decimals}f} mm"


@pytest.fixture
def visit(browser, addresses):
    """Open one of the pages, and wait until it shows its run."""

    @contextmanager
    def visited(link="", name="seed", **options):
        with opened(browser, addresses[name] + link, **options) as found:
            found.page.evaluate("dragon.then(() => null)")
            yield found

    return visited


def ask(page, what):
    """The value of an expression about `player`, what the page offers to others."""
    return page.evaluate(f"dragon.then((player) => {what})")


def shown(page, name):
    # Texts come with the next picture.
    ask(page, "player.draw()")
    return page.text_content(f"#{name}")


def settled(page, what):
    wait_until(page, f"dragon.then((player) => {what})")


def announced(page):
    """Wait for the text that screen readers are given a while after the last input."""
    wait_until(page, "document.getElementById('announcement').textContent !== ''")


@pytest.mark.parametrize("name", ["seed", "bumpy"])
def test_page_asks_for_nothing_and_browser_has_nothing_to_complain_about(visit, addresses, name):
    with visit(name=name) as found:
        found.page.keyboard.press("Space")
        found.page.wait_for_timeout(200)
        assert found.complaints == []
        assert {url for url in found.addresses if not url.startswith("data:")} == {addresses[name]}
        assert found.page.is_hidden("#failure")


def test_label_with_markup_is_shown_as_text(visit):
    with visit(name="bumpy") as found:
        found.page.click("#help")
        assert LABEL in shown(found.page, "about")
        assert found.page.evaluate("[document.scripts.length, document.images.length]") == [7, 0]
        assert found.boxes == []


def test_policy_stops_scripts_and_styles_that_are_not_the_pages_own(visit):
    with visit() as found:
        found.page.evaluate("""() => {
          document.body.append(Object.assign(document.createElement("script"), { textContent: "alert(3)" }));
          document.body.insertAdjacentHTML("beforeend", "<b id='b' onclick='alert(4)' style='color: red'>b</b>");
          document.getElementById("b").click();
        }""")
        assert found.boxes == []
        assert len(found.complaints) == 3
        assert all("Content Security Policy" in complaint for complaint in found.complaints)


def test_places_in_the_page_are_the_runs(visit, bumpy):
    front, rear = bumpy.march.dragon.holes(bumpy.poses)
    with visit(name="bumpy") as found:
        for frame in (0, 1, 57, len(bumpy.times) - 1):
            places = np.reshape(ask(found.page, f"player.handles({frame})"), (-1, 2))
            # Joints of the engine are up to some micrometres apart.
            joint = np.abs(rear[frame, :-1] - front[frame, 1:]).max() / 2
            np.testing.assert_allclose(places[:-1], front[frame], rtol=0, atol=RESOLUTION + joint)
            np.testing.assert_allclose(places[1:], rear[frame], rtol=0, atol=RESOLUTION + joint)


@pytest.mark.parametrize("time", [405.0, 405.05, 409.832, 412.43, CONTACT_TIME, 412.6])
def test_poses_between_frames_are_the_runs(visit, seed, time):
    with visit() as found:
        poses = np.array(ask(found.page, f"player.poses({time})"))
    # The page has one more frame, that of the contact.
    frames = np.sort([*seed.times, 412.4738376821])
    expected = Run.exact(seed.march, frames).poses_at([time])[0]
    np.testing.assert_allclose(poses[:, :2], expected[:, :2], rtol=0, atol=RESOLUTION)
    turn = (poses[:, 2] - expected[:, 2] + np.pi) % (2 * np.pi) - np.pi
    np.testing.assert_allclose(turn, 0, atol=4 * RESOLUTION / 1.65)


def test_it_plays_and_pauses(visit):
    with visit() as found:
        page = found.page
        assert shown(page, "clock") == "405.00"
        page.click("#play")
        assert page.get_attribute("#play", "aria-label") == "Pause"
        settled(page, "player.time > 405.2")
        page.click("#play")
        assert page.get_attribute("#play", "aria-label") == "Play"
        time = ask(page, "player.time")
        page.wait_for_timeout(150)
        assert ask(page, "player.time") == time
        assert float(shown(page, "clock")) == pytest.approx(time, abs=0.006)


@pytest.mark.parametrize("rate", [0.5, 5])
def test_speed_is_simulated_over_real_time(visit, rate):
    with visit(f"#t=405&speed={rate}&slow=off") as found:
        passed, gone = found.page.evaluate("""async () => {
          const player = await dragon;
          player.play();
          const frame = () => new Promise(requestAnimationFrame);
          await frame();
          let last = await frame(), passed = 0;
          const time = player.time;
          while (passed < 1) {
            const now = await frame();
            // A stalled machine does not make it jump.
            passed += Math.min((now - last) / 1000, 0.25);
            last = now;
          }
          return [passed, player.time - time];
        }""")
        # The player's own frame may come before or after the test's.
        assert gone == pytest.approx(rate * passed, rel=0.35)


RATES = """([begin, end]) => dragon.then((player) => Array.from({ length: 401 }, (_, k) => {
  player.seek(begin + (end - begin) * k / 400);
  return player.rate;
}))"""


@pytest.mark.parametrize("event", [406.8466, 409.8320, CONTACT_TIME])
def test_playing_slows_down_to_an_eighth_at_events(visit, event):
    with visit("#speed=10") as found:
        page = found.page
        begin, end = max(405.0, event - 2), min(412.6, event + 2)
        rates = np.array(page.evaluate(RATES, [begin, end]))
        assert rates.min() == pytest.approx(1 / 8)
        assert abs(np.linspace(begin, end, 401)[rates.argmin()] - event) < 0.07
        # So much playing time lies before the event; without slow motion it is 0.2 s.
        before = rates[np.linspace(begin, end, 401) < event]
        assert 1.5 < np.sum((end - begin) / 400 / before) < 4
        ask(page, f"player.seek({event})")
        assert shown(page, "reduced") == "1/8×"
        page.uncheck("#slow")
        assert set(page.evaluate(RATES, [begin, end])) == {10}
        assert shown(page, "reduced") == ""
        wait_until(page, "location.hash.includes('slow=off')")


def test_chosen_speed_below_the_slow_one_is_kept(visit):
    with visit("#t=409.832&speed=0.1") as found:
        assert ask(found.page, "player.rate") == 0.1
        assert shown(found.page, "reduced") == ""


def test_pile_up_slows_playing_down_at_its_beginning_only(browser, tmp_path, bumpy):
    begins = [82.0, 82.7, 83.4, 84.9, 88.0]
    phases = [(begin + after, phase) for begin in begins for after, phase in ((0.0, "begin"), (0.2, "separate"))]
    log = ContactLog(tuple(ContactEvent(time=time, phase=phase, benches=(1, 9)) for time, phase in phases))
    write_player(replace(bumpy, events=log, first_contact=None), tmp_path / "run.html")
    with opened(browser, (tmp_path / "run.html").as_uri() + "#speed=10") as found:
        rates = [ask(found.page, f"(player.seek({begin}), player.rate)") for begin in begins]
        misses = found.page.locator("#events option", has_text="Near miss").count()
    assert misses == 0
    assert rates == pytest.approx([1 / 8, 1.4, 2.8, 5.8, 1 / 8])


@pytest.mark.parametrize("press", [lambda page: page.click("#last"), lambda page: page.keyboard.press("l")])
def test_last_10_seconds_are_played_and_shown_on_the_timeline(browser, tmp_path, press):
    run = Run.exact(March(Dragon(benches=16), turns=8), np.arange(0, 30, 0.5))
    write_player(run, tmp_path / "run.html")
    with opened(browser, (tmp_path / "run.html").as_uri()) as found:
        ask(found.page, "player.time")
        press(found.page)
        settled(found.page, "player.playing && player.time > 19.5")
        assert ask(found.page, "player.time") < 21
        assert ask(found.page, "player.timeline") == [19.5, 29.5]
        found.page.keyboard.press("c")
        assert ask(found.page, "player.timeline") == [0, 29.5]


def test_timeline_zooms_around_the_time_with_buttons_and_keys(visit):
    with visit("#t=409.832") as found:
        page = found.page
        assert ask(page, "player.timeline") == [405, 412.6]
        assert page.is_disabled("#timeline-out")
        page.click("#timeline-in")
        page.keyboard.press("z")
        begin, end = ask(page, "player.timeline")
        assert end - begin == pytest.approx(7.6 / 4)
        assert (409.832 - begin) / (end - begin) == pytest.approx((409.832 - 405) / 7.6)
        assert [float(page.get_attribute("#time", name)) for name in ("min", "max")] == pytest.approx([begin, end])
        # The part follows the time.
        page.keyboard.press("n")
        ask(page, "player.draw()")
        begin, end = ask(page, "player.timeline")
        assert begin < CONTACT_TIME <= end
        page.keyboard.press("x")
        page.click("#timeline-out")
        assert ask(page, "player.timeline") == pytest.approx([405, 412.6])
        for _ in range(12):
            page.keyboard.press("z")
        begin, end = ask(page, "player.timeline")
        assert end - begin == pytest.approx(0.2)
        page.click("#timeline-all")
        wait_until(page, "document.getElementById('timeline-all').disabled")


@pytest.mark.parametrize("target", ["strip", "time"])
def test_wheel_over_the_timeline_zooms_around_the_pointer(visit, target):
    with visit() as found:
        page = found.page
        box = page.locator(f"#{target}").bounding_box()
        page.mouse.move(box["x"] + 8 + 0.8 * (box["width"] - 16), box["y"] + box["height"] / 2)
        ask(page, "player.seek(411)")
        page.mouse.wheel(0, -600)
        settled(page, "player.timeline[1] - player.timeline[0] < 5")
        begin, end = ask(page, "player.timeline")
        assert (405 + 0.8 * 7.6 - begin) / (end - begin) == pytest.approx(0.8, abs=0.01)
        assert ask(page, "player.time") == 411


def test_fingers_zoom_the_timeline_and_drag_it(visit):
    with visit("#t=409", width=390, height=844, has_touch=True, is_mobile=True) as found:
        page = found.page
        touch = page.context.new_cdp_session(page)
        top = page.locator("#strip").bounding_box()["y"] + 15

        def fingers(kind, *across):
            points = [{"x": x, "y": top, "id": i} for i, x in enumerate(across)]
            touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

        fingers("touchStart", 180)
        fingers("touchStart", 180, 220)
        for reach in (40, 60, 80):
            fingers("touchMove", 200 - reach, 200 + reach)
        fingers("touchEnd")
        settled(page, "player.timeline[1] - player.timeline[0] < 2.5")
        begin, end = ask(page, "player.timeline")
        fingers("touchStart", 200)
        for x in (190, 170, 150):
            fingers("touchMove", x)
        fingers("touchEnd")
        later, last = ask(page, "player.timeline")
        assert last - later == pytest.approx(end - begin)
        assert later > begin + 0.1
        assert ask(page, "player.time") == 409


@pytest.mark.parametrize("time", [80.0, 83.3, 86.05])
def test_exact_poses_and_position_errors_are_the_models(visit, bumpy, time):
    march = bumpy.march
    with visit(f"#t={time}", name="bumpy") as found:
        exact = np.array(ask(found.page, f"player.exactPoses({time})"))
        poses = march.at([time]).poses[0]
        largest = np.abs(np.array(ask(found.page, f"player.poses({time})"))[:, :2] - poses[:, :2]).max()
        # Between frames the offsets are linear in time.
        np.testing.assert_allclose(exact[:, :2], poses[:, :2], rtol=0, atol=2e-6 + (time % 0.1 > 0.01) * 0.5 * largest)
        for bench in (0, 7, 15):
            found.page.fill("#bench", str(bench))
            front, rear = (hole[0, bench] for hole in march.dragon.holes(bumpy.poses_at([time])))
            ends = march.at([time]).positions[0, bench : bench + 2]
            error = max(np.linalg.norm(front - ends[0]), np.linalg.norm(rear - ends[1]))
            text = shown(found.page, "error")
            number, unit = text.split()
            assert float(number) * {"mm": 1e-3, "μm": 1e-6}[unit] == pytest.approx(error, rel=0.05, abs=1e-6)


def test_exact_model_is_outlined_with_its_distance_magnified_as_the_legend_says(visit, bumpy):
    with visit("#t=86&follow=head&show=exact", name="bumpy", device_scale_factor=2) as found:
        page = found.page
        legend = shown(page, "legend-exact-text")
        factor = int(legend.removeprefix("Exact model, error × ").replace(",", ""))
        assert factor > 1
        poses, exact = (np.array(ask(page, f"player.{name}(86)")) for name in ("poses", "exactPoses"))
        magnified = poses + factor * (exact - poses)
        outline = bumpy.march.dragon.outlines(magnified)[1]
        middle = (outline[0] + outline[1]) / 2
        near = [middle + np.array([dx, dy]) for dx in (-0.02, 0, 0.02) for dy in (-0.02, 0, 0.02)]
        assert LIGHT.motion in {page.evaluate(COLOUR, point.tolist()) for point in near}
        # The largest error in the view is visible, and not larger than a bench is wide.
        pixels = factor * np.linalg.norm((exact - poses)[:, :2], axis=1).max() * ask(page, "player.view.scale")
        assert 2 < pixels < 60
        page.uncheck("#show-exact")
        ask(page, "player.draw()")
        assert page.is_hidden("#legend-exact")


def test_run_of_the_exact_model_has_nothing_to_compare(visit):
    with visit("#show=curve,exact") as found:
        assert all(found.page.locator(".exact-only").nth(i).is_hidden() for i in range(3))
        assert ask(found.page, "player.exactPoses(409)") is None


def test_legend_names_the_colours(visit):
    with visit(name="bumpy") as found:
        names = found.page.locator(".legend li:visible").all_inner_texts()
        assert names == ["Head", "Body", "Tail", "In contact"]
        colours = found.page.evaluate("""() => [...document.querySelectorAll(".legend li:not([hidden]) .swatch")]
          .map((swatch) => getComputedStyle(swatch).backgroundColor)""")
        expected = [LIGHT.head, LIGHT.body, LIGHT.tail, LIGHT.contact]
        assert colours[:4] == [f"rgb({', '.join(str(int(c[i : i + 2], 16)) for i in (1, 3, 5))})" for c in expected]


@pytest.mark.parametrize("language", ["", "?zh"])
@pytest.mark.parametrize(("width", "height"), [(844, 390), (640, 400), (320, 568)])
def test_legend_leaves_most_of_a_small_picture_free(visit, width, height, language):
    with visit(f"{language}#t=86&show=exact", name="bumpy", width=width, height=height) as found:
        page = found.page
        assert page.is_visible("#legend-exact")
        legend, field = (
            sum(
                box["width"] * box["height"] for box in (each.bounding_box() for each in page.query_selector_all(names))
            )
            for names in (".legend li:not([hidden])", "#field")
        )
        assert legend < field / 5


@pytest.mark.parametrize("link", ["?zh", "?lang=zh", "#lang=zh"])
def test_page_is_chinese_if_the_address_says_so(visit, link):
    with visit(link, name="bumpy", locale="en-GB") as found:
        page = found.page
        assert page.evaluate("document.documentElement.lang") == "zh"
        announced(page)
        # The title of the document is that of the run.
        assert english_words(page) - set(page.title().split()) <= {"CSV"}
        assert found.complaints == []


def test_page_is_english_without_a_choice_whatever_the_browser_prefers(visit):
    with visit(locale="zh-CN") as found:
        assert found.page.evaluate("document.documentElement.lang") == "en"
        assert found.page.inner_text("#help") == "Help"


def test_button_changes_the_language_there_and_back(visit):
    with visit("#t=409.832", name="seed") as found:
        page = found.page
        announced(page)
        page.evaluate(f"window.before = JSON.stringify(({TEXTS})())")
        page.click("#language")
        assert page.evaluate("document.documentElement.lang") == "zh"
        assert shown(page, "gap") == "0.865 mm，至 11 号"
        assert page.inner_text("#help") == "帮助"
        wait_until(page, "location.hash.includes('lang=zh')")
        page.click("#language")
        wait_until(page, "!location.hash.includes('lang')")
        wait_until(page, f"JSON.stringify(({TEXTS})()) === window.before")
        assert ask(page, "player.time") == 409.832


def test_a_run_that_is_over_stops_and_starts_again(visit):
    with visit("#t=412.55&speed=1") as found:
        found.page.keyboard.press("Space")
        settled(found.page, "!player.playing")
        assert ask(found.page, "player.time") == 412.6
        found.page.keyboard.press("Space")
        settled(found.page, "player.time < 406")


def test_keys_step_through_the_frames(visit):
    with visit("#t=409.85") as found:
        page = found.page

        def time_after(*keys):
            for key in keys:
                page.keyboard.press(key)
            return ask(page, "player.time")

        assert time_after("ArrowRight") == pytest.approx(409.9)
        assert time_after("ArrowRight") == pytest.approx(410.0)
        assert time_after("ArrowLeft", "ArrowLeft", "ArrowLeft") == pytest.approx(409.7)
        assert time_after("Shift+ArrowRight") == pytest.approx(410.7)
        assert time_after("Shift+ArrowLeft", "Shift+ArrowLeft") == pytest.approx(408.7)
        assert time_after("End") == 412.6
        # The contact's own frame lies between the others.
        assert time_after("ArrowLeft", "ArrowLeft") == pytest.approx(CONTACT_TIME, abs=1e-7)
        assert time_after("Home") == 405.0
        assert time_after("ArrowLeft") == 405.0


def test_frame_keys_work_on_the_slider_too(visit):
    with visit("#t=409") as found:
        found.page.focus("#time")
        found.page.keyboard.press("ArrowRight")
        assert ask(found.page, "player.time") == pytest.approx(409.1)
        found.page.fill("#time", "411.25")
        assert ask(found.page, "player.time") == pytest.approx(411.25)


def test_space_on_a_focused_button_presses_only_that_button(visit):
    with visit() as found:
        found.page.focus("#show-grid")
        found.page.keyboard.press("Space")
        assert found.page.is_checked("#show-grid")
        assert not ask(found.page, "player.playing")


def test_events_can_be_stepped_through_and_are_told(visit):
    with visit() as found:
        page = found.page
        times = []
        for _ in range(3):
            page.keyboard.press("n")
            times.append(ask(page, "player.time"))
        assert times == [pytest.approx(time, abs=1e-3) for time in (406.8466, 409.8320, CONTACT_TIME)]
        wait_until(page, "document.getElementById('announcement').textContent.includes('Contact: benches 0 and 8')")
        page.keyboard.press("p")
        wait_until(page, "document.getElementById('announcement').textContent.includes('benches 0 and 11, 0.865 mm')")
        assert "0 and 11" in page.get_attribute("#field", "aria-label")


def test_events_that_a_run_passes_are_told(visit):
    with visit("#t=409.7&speed=1") as found:
        found.page.keyboard.press("Space")
        announced = "document.getElementById('announcement').textContent"
        wait_until(found.page, f"{announced}.startsWith('Near miss: benches 0 and 11')")
        assert ask(found.page, "player.playing")


def test_strip_marks_the_events_and_a_click_near_one_goes_to_it(visit):
    with visit() as found:
        # Share of the strip's width at which each colour is first seen, thumbs of the slider aside.
        shares = found.page.evaluate("""() => {
          const strip = document.getElementById("strip");
          const { data } = strip.getContext("2d").getImageData(0, strip.height - 7, strip.width, 1);
          const names = {};
          for (let x = 0; x < strip.width; x++) {
            const colour = data.slice(4 * x, 4 * x + 4).join();
            (names[colour] ??= []).push((x - 8) / (strip.width - 16));
          }
          return names;
        }""")

        def places(colour):
            return shares[",".join(str(int(colour[i : i + 2], 16)) for i in (1, 3, 5)) + ",255"]

        span = 412.6 - 405
        assert min(places(LIGHT.contact)) == pytest.approx((CONTACT_TIME - 405) / span, abs=0.004)
        for time in (406.8466, 409.8320):
            assert min(abs(np.array(places(LIGHT.head)) - (time - 405) / span)) < 0.002
        box = found.page.locator("#strip").bounding_box()
        found.page.mouse.click(box["x"] + 8 + (box["width"] - 16) * (409.832 - 405) / span + 3, box["y"] + 7)
        assert ask(found.page, "player.time") == pytest.approx(409.8320, abs=1e-3)
        found.page.mouse.click(box["x"] + 8 + (box["width"] - 16) / 2, box["y"] + 7)
        assert ask(found.page, "player.time") == pytest.approx((405 + 412.6) / 2, abs=0.01)


def test_benches_in_contact_have_the_contact_colour_from_the_contact_on(visit, seed):
    with visit() as found:
        page = found.page
        page.uncheck("#show-contacts")
        page.select_option("#events", label="412.47 s: Contact: benches 0 and 8")
        assert shown(page, "clock") == "412.47"
        poses = seed.march.at([CONTACT_TIME]).poses[0]
        assert page.evaluate(COLOUR, poses[8, :2].tolist()) == LIGHT.contact
        assert page.evaluate(COLOUR, poses[9, :2].tolist()) == LIGHT.body
        # The head keeps its colour, and has a border in that of the contact.
        assert page.evaluate(COLOUR, poses[0, :2].tolist()) == LIGHT.head
        assert page.evaluate(COLOUR, middle_of_side(seed.march.dragon, poses)) == LIGHT.contact
        ask(page, f"player.seek({CONTACT_TIME} - 0.001)")
        assert page.evaluate(COLOUR, middle_of_side(seed.march.dragon, poses)) != LIGHT.contact
        assert page.evaluate(COLOUR, poses[8, :2].tolist()) == LIGHT.body


def middle_of_side(dragon, poses):
    """Middle of a long side of the head bench."""
    corners = dragon.outlines(poses)[0]
    return ((corners[0] + corners[1]) / 2).tolist()


def test_benches_lose_the_contact_colour_when_they_part(visit, bumpy):
    windows = [window for window in bumpy.events.windows() if window.end is not None and window.end < 89]
    window = max(windows, key=lambda window: window.end - window.begin)
    touching = [w for w in bumpy.events.windows() if w.benches != window.benches]
    with visit("#show=curve", name="bumpy") as found:
        for time, alone in ((window.begin + 1e-6, False), (window.end + 1e-6, True)):
            others = [w for w in touching if w.begin <= time and (w.end is None or w.end > time)]
            ask(found.page, f"player.seek({time})")
            for bench in set(window.benches) - {0}:
                if alone and any(bench in other.benches for other in others):
                    continue
                x, y, _ = ask(found.page, f"player.poses({time})[{bench}]")
                is_red = found.page.evaluate(COLOUR, [x, y]) == LIGHT.contact
                assert is_red is not alone


@pytest.mark.parametrize("bench", [0, 1, 11, 100, 222])
def test_hover_tells_the_exact_models_numbers(visit, seed, bench):
    time = 409.8
    states = seed.march.at([time])
    pose = states.poses[0, bench]
    shapes = [Polygon(corners) for corners in seed.march.dragon.outlines(states.poses[0])]
    gaps = {i: shapes[bench].distance(shapes[i]) for i in range(223) if abs(i - bench) > 1}
    nearest = min(gaps, key=gaps.get)
    with visit(f"#t={time}&show=curve") as found:
        page = found.page
        page.mouse.move(*page.evaluate(PLACE, pose[:2].tolist()))
        wait_until(page, f"document.getElementById('bench').value === '{bench}'")
        assert shown(page, "speed") == f"{states.speeds[0, bench]:.3f} m/s"
        degrees = f"{np.degrees(pose[2]):.1f}".replace("-", "−")
        assert shown(page, "angle") == f"{degrees}°"
        assert shown(page, "gap") == f"{in_millimetres(gaps[nearest])} to {nearest}"
        numbers = ask(page, f"player.numbers({bench})")
        assert numbers["gap"] == pytest.approx(gaps[nearest], abs=4 * RESOLUTION)
        assert numbers["speed"] == pytest.approx(states.speeds[0, bench], abs=1e-4)
        # Half a frame off, they would point 22 mm/s elsewhere.
        assert numbers["velocity"] == pytest.approx(states.velocities[0, bench].tolist(), abs=3e-4)


def test_frames_that_nearly_share_a_time_do_not_spoil_speeds(browser, tmp_path):
    march = March(Dragon(benches=16), turns=8)
    run = Run.exact(march, np.sort([*np.arange(10) / 10, 0.5 + 1e-7]))
    write_player(run, tmp_path / "run.html")
    with opened(browser, (tmp_path / "run.html").as_uri()) as found:
        for time in (0.45, 0.5, 0.5 + 1e-7, 0.55):
            speeds = ask(found.page, f"(player.seek({time}), [0, 7, 15].map((bench) => player.numbers(bench).speed))")
            assert speeds == pytest.approx(march.at([time]).speeds[0, [0, 7, 15]].tolist(), abs=1e-3)


def test_page_says_the_same_gap_of_a_near_miss_everywhere_though_it_lies_between_frames(visit, seed):
    outlines = seed.march.dragon.outlines(seed.march.at([409.832]).poses[0])
    assert in_millimetres(Polygon(outlines[0]).distance(Polygon(outlines[11]))) == "0.865 mm"
    with visit("#t=409.832") as found:
        assert shown(found.page, "gap") == "0.865 mm to 11"
        found.page.keyboard.press("n")
        found.page.keyboard.press("p")
        announced = "document.getElementById('announcement').textContent"
        wait_until(found.page, f"{announced}.includes('benches 0 and 11, 0.865 mm')")
        assert shown(found.page, "gap") == "0.865 mm to 11"


@pytest.mark.thorough
@pytest.mark.parametrize(("opening", "text"), [(2e-6, "0.87 mm"), (5e-5, "0.9 mm"), (4e-4, "1 mm")])
def test_gap_has_no_more_digits_than_the_joints_of_the_run_allow(browser, tmp_path, seed, opening, text):
    poses = seed.poses.copy()
    poses[:, 100, 0] += opening
    write_player(replace(seed, poses=poses), tmp_path / "run.html")
    with opened(browser, (tmp_path / "run.html").as_uri() + "#t=409.832") as found:
        assert shown(found.page, "gap") == f"{text} to 11"


def test_gap_between_frames_that_tell_too_little_has_no_digits_after_the_point(browser, tmp_path, seed_march):
    write_player(Run.exact(seed_march, [409.8, 409.9]), tmp_path / "run.html")
    with opened(browser, (tmp_path / "run.html").as_uri() + "#t=409.832") as found:
        assert shown(found.page, "gap") == "1 mm to 11"
        ask(found.page, "player.seek(409.8)")
        assert shown(found.page, "gap").startswith("0.")


@pytest.mark.thorough
@pytest.mark.parametrize("interval", [0.1, 0.4, 1.0])
def test_page_knows_how_far_off_it_is_between_frames(browser, tmp_path, interval, seed_march):
    """The error that digits are cut by is no less than a third of the true one, and no more than ten times that."""
    run = Run.exact(seed_march, np.arange(400.0, 412.0, interval))
    write_player(run, tmp_path / "run.html")
    times = run.times[3:8] + interval / 2
    true = np.linalg.norm(run.poses_at(times)[..., :2] - seed_march.at(times).poses[..., :2], axis=-1)
    with opened(browser, (tmp_path / "run.html").as_uri()) as found:
        for time, off in zip(times.tolist(), true, strict=True):
            errors = ask(found.page, f"(player.seek({time!r}), [0, 1, 5, 50].map((b) => player.numbers(b).error))")
            for bench, error in zip((0, 1, 5, 50), errors, strict=True):
                assert off[bench] / 3 < error < 10 * (off[bench] + 0.5e-6)


def test_bench_can_be_chosen_by_number(visit, seed):
    with visit("#t=410") as found:
        found.page.fill("#bench", "57")
        wait_until(found.page, "document.getElementById('part').textContent === 'body'")
        assert shown(found.page, "speed") == f"{seed.march.at([410.0]).speeds[0, 57]:.3f} m/s"
        wait_until(found.page, "location.hash.includes('bench=57')")


def test_click_keeps_a_benchs_numbers_in_sight_until_another_click(visit, seed):
    with visit("#t=410") as found:
        page = found.page
        places = seed.march.at([410.0]).poses[0, :, :2].tolist()
        page.mouse.click(*page.evaluate(PLACE, places[30]))
        page.mouse.move(*page.evaluate(PLACE, [0, 0]))
        page.wait_for_timeout(50)
        assert page.input_value("#bench") == "30"
        page.mouse.click(*page.evaluate(PLACE, [0, 0]))
        wait_until(page, "document.getElementById('bench').value === '0'")


@pytest.mark.parametrize("time", [405.0, 409.0, 412.3])
def test_shaded_cells_are_those_of_the_packages_grid(visit, seed, time):
    poses = seed.march.at([time]).poses[0]
    cells, owners = Grid.of(seed.march).file(seed.march.dragon.outlines(poses))
    with visit(f"#t={time}&show=grid") as found:
        shaded = ask(found.page, "Array.from({ length: 223 }, (_, bench) => player.cells(bench))")
    for bench in range(223):
        assert sorted(shaded[bench]) == sorted(cells[owners == bench].tolist())


def test_link_restores_moment_view_and_switches(visit):
    link = "#t=409.8&at=-2.5,-1&span=1.25&show=curve,grid,labels&bench=11&speed=0.25"
    with visit(link) as found:
        page = found.page
        assert ask(page, "player.time") == 409.8
        view = ask(page, "player.view")
        box = page.evaluate("document.getElementById('field').getBoundingClientRect().toJSON()")
        assert [view["x"], view["y"]] == [-2.5, -1]
        assert min(box["width"], box["height"]) / view["scale"] == pytest.approx(1.25)
        checked = "[...document.querySelectorAll('fieldset input:checked')].map(({ id }) => id)"
        assert page.evaluate(checked) == ["show-curve", "show-grid", "show-labels"]
        assert page.input_value("#bench") == "11"
        assert page.input_value("#rate") == "0.25"
        wait_until(page, "location.hash.includes('span=')")
        assert page.evaluate("location.hash") == link


def test_link_that_the_page_wrote_gives_the_same_picture(visit):
    with visit("#t=409.8") as found:
        page = found.page
        page.keyboard.press("h")
        page.keyboard.press("+")
        page.mouse.move(700, 300)
        page.mouse.wheel(0, -200)
        # The wheel ends that the head is followed.
        wait_until(page, "location.hash.includes('at=')")
        link, before = page.evaluate("location.hash"), ask(page, "player.view")
    with visit(link) as found:
        after = ask(found.page, "player.view")
    assert [after[name] for name in "xy"] == pytest.approx([before[name] for name in "xy"], abs=1e-4)
    assert after["scale"] == pytest.approx(before["scale"], rel=1e-3)


def test_link_to_the_moment_of_a_contact_shows_the_contact_though_its_time_is_rounded(visit, seed):
    place = seed.march.at([CONTACT_TIME]).poses[0, 8, :2].tolist()
    with visit(f"#t={int(1e6 * CONTACT_TIME) / 1e6}&show=") as found:
        assert ask(found.page, "player.time") < CONTACT_TIME
        assert found.page.evaluate(COLOUR, place) == LIGHT.contact


def test_link_that_changes_is_followed(visit):
    with visit() as found:
        found.page.evaluate("location.hash = '#t=410.5&follow=head'")
        settled(found.page, "player.time === 410.5 && player.view.follow === 'head'")
        head = ask(found.page, "player.poses(410.5)[0]")
        view = ask(found.page, "(player.draw(), player.view)")
        assert [view["x"], view["y"]] == pytest.approx(head[:2])


@pytest.mark.parametrize(
    "link",
    ["#", "#t=", "#t=soon&at=1&span=-3&show=all&bench=9999&speed=3", "#t=1e999&%", "#head", "#lang=toString"],
)
def test_link_that_makes_no_sense_is_no_harm(visit, link):
    with visit(link) as found:
        assert found.complaints == []
        assert ask(found.page, "player.time") == 405
        assert ask(found.page, "player.view.follow") == "field"
        assert found.page.evaluate("document.documentElement.lang") == "en"


def test_address_follows_the_run_but_not_all_too_often(visit):
    with visit() as found:
        found.page.evaluate("""() => {
          [window.writes, window.begin] = [0, performance.now()];
          const replaceState = history.replaceState.bind(history);
          history.replaceState = (...given) => { window.writes += 1; replaceState(...given); };
        }""")
        found.page.keyboard.press("Space")
        settled(found.page, "player.time > 406")
        found.page.keyboard.press("Space")
        time = ask(found.page, "player.time")
        wait_until(found.page, f"Math.abs(location.hash.slice(3) - {time}) < 1e-4")
        # At once, and then twice a second.
        assert found.page.evaluate("window.writes <= 2 + (performance.now() - window.begin) / 500")


def test_wheel_zooms_around_the_pointer(visit):
    with visit("#t=409") as found:
        page = found.page
        place = page.evaluate(PLACE, [3.0, 2.0])
        page.mouse.move(*place)
        before = ask(page, "player.view.scale")
        page.mouse.wheel(0, -300)
        settled(page, f"player.view.scale > 1.3 * {before}")
        assert page.evaluate(PLACE, [3.0, 2.0]) == pytest.approx(place, abs=1)


def test_drag_moves_the_floor_with_the_pointer(visit):
    with visit("#t=409&follow=head") as found:
        page = found.page
        x, y, _ = ask(page, "player.poses(409)[20]")
        begin = page.evaluate(PLACE, [x, y])
        page.mouse.move(600, 300)
        page.mouse.down()
        page.mouse.move(650, 340, steps=5)
        page.mouse.move(720, 350, steps=5)
        page.mouse.up()
        assert page.evaluate(PLACE, [x, y]) == pytest.approx([begin[0] + 120, begin[1] + 50], abs=1)
        assert page.get_attribute("#follow", "aria-pressed") == "false"
        page.keyboard.press("0")
        settled(page, "player.view.follow === 'field'")


def test_fingers_pinch_pan_and_tap(visit, seed):
    with visit("#t=409", width=390, height=844, has_touch=True, is_mobile=True) as found:
        page = found.page
        touch = page.context.new_cdp_session(page)

        def fingers(kind, *places):
            points = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(places)]
            touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

        before = ask(page, "player.view.scale")
        fingers("touchStart", (170, 300))
        fingers("touchStart", (170, 300), (210, 300))
        for reach in (30, 40, 50, 60):
            fingers("touchMove", (190 - reach, 300), (190 + reach, 300))
        fingers("touchEnd")
        settled(page, f"Math.abs(player.view.scale / {before} - 3) < 0.1")
        bench = seed.march.at([409.0]).poses[0, 60, :2].tolist()
        assert page.input_value("#bench") == "0"
        page.keyboard.press("0")
        page.touchscreen.tap(*page.evaluate(PLACE, bench))
        wait_until(page, "document.getElementById('bench').value === '60'")


@pytest.mark.parametrize("language", ["", "?zh"])
@pytest.mark.parametrize(
    ("width", "height"), [(1280, 800), (1024, 600), (844, 390), (640, 400), (390, 844), (320, 640), (320, 568)]
)
def test_page_fits_into_the_window_with_every_control_in_sight(visit, width, height, language):
    with visit(f"{language}#show=curve,exact", name="bumpy", width=width, height=height) as found:
        page = found.page
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        assert page.evaluate("document.documentElement.scrollHeight") <= height
        hidden = page.evaluate("""() => [...document.querySelectorAll("button, input, select")]
          .filter((control) => !control.closest("dialog, [popover]"))
          .filter((control) => {
            const { left, right, top, bottom } = control.getBoundingClientRect();
            const found = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
            return left < 0 || right > innerWidth || top < 0 || bottom > innerHeight
              || !(found && (control.contains(found) || found.contains(control)));
          }).map((control) => control.id)""")
        assert hidden == []
        # No text is wider than its button.
        cut = page.evaluate("""() => [...document.querySelectorAll("button, label, h1")]
          .filter((each) => each.scrollWidth > each.clientWidth + 1 && each.clientWidth > 0 && !each.closest("dialog"))
          .map((each) => each.textContent)""")
        assert cut == []
        assert page.evaluate("document.getElementById('field').getBoundingClientRect().height") > 150


def test_help_opens_with_its_key_and_closes_again(visit):
    with visit() as found:
        page = found.page
        for close in (lambda: page.keyboard.press("Escape"), lambda: page.click("#close")):
            page.keyboard.press("?")
            assert page.is_visible("#about")
            # Keys of the player do nothing behind it.
            page.keyboard.press("n")
            close()
            assert page.is_hidden("#about")
        assert ask(page, "player.time") == 405
        assert found.complaints == []


def test_every_control_has_a_name(visit):
    with visit() as found:
        nameless = found.page.evaluate("""() => [...document.querySelectorAll("button, input, select, canvas, dialog")]
          .filter((element) => !(element.ariaLabel || element.textContent.trim() || element.labels?.length
            || element.ariaHidden || element.getAttribute("aria-labelledby")))
          .map((element) => element.outerHTML)""")
        assert nameless == []


def test_tab_goes_through_the_controls_and_shows_where_it_is(visit):
    with visit() as found:
        page = found.page
        seen = []
        for _ in range(31):
            page.keyboard.press("Tab")
            seen.append(page.evaluate("document.activeElement.id"))
            if seen[-1]:
                assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"
        wanted = {"help", "field", "play", "next", "time", "rate", "events", "bench", "show-grid", "fit", "follow"}
        wanted |= {"language", "last", "timeline-in", "slow"}
        assert wanted <= set(seen)


@pytest.mark.parametrize(("scheme", "palette"), [("light", LIGHT), ("dark", DARK)])
def test_colours_are_those_of_the_readers_scheme(visit, scheme, palette):
    with visit("#t=409&show=curve", color_scheme=scheme) as found:
        places = [ask(found.page, f"player.poses(409)[{bench}]")[:2] for bench in (0, 50, 222)]
        colours = [found.page.evaluate(COLOUR, place) for place in (*places, [12.0, 0.0])]
        assert colours == [palette.head, palette.body, palette.tail, palette.background]


def test_colours_follow_a_scheme_that_changes(visit):
    with visit("#t=409", color_scheme="light") as found:
        found.page.emulate_media(color_scheme="dark")
        wait_until(found.page, f"({COLOUR})([12, 0]).then((colour) => colour === {DARK.background!r})")


@pytest.mark.parametrize(("motion", "plays"), [("no-preference", True), ("reduce", False)])
def test_link_starts_the_run_unless_the_reader_wants_less_motion(visit, motion, plays):
    with visit("#t=406&play", reduced_motion=motion) as found:
        assert ask(found.page, "player.playing") is plays


def test_picture_has_all_the_pixels_of_a_fine_screen(visit):
    with visit(device_scale_factor=2) as found:
        sizes = found.page.evaluate("""() => {
          const canvas = document.getElementById("field");
          const { width, height } = canvas.getBoundingClientRect();
          return [canvas.width, canvas.height, width, height];
        }""")
        assert sizes[:2] == pytest.approx([2 * sizes[2], 2 * sizes[3]], abs=0.51)


def test_moment_can_be_saved_as_a_table(visit, seed):
    with visit("#t=409.8") as found:
        found.page.click("text=Download")
        with found.page.expect_download() as waiting:
            found.page.click("#save-moment")
        assert waiting.value.suggested_filename == "dragon_409.80_s.csv"
        rows = list(csv.DictReader(waiting.value.path().read_text().splitlines()))
    states = seed.march.at([409.8])
    assert [int(row["handle"]) for row in rows] == list(range(224))
    assert {float(row["time_s"]) for row in rows} == {409.8}
    places = [(float(row["x_m"]), float(row["y_m"])) for row in rows]
    # The table has whole micrometres.
    np.testing.assert_allclose(places, states.positions[0], rtol=0, atol=0.5e-6 + RESOLUTION)
    np.testing.assert_allclose([float(row["speed_m_s"]) for row in rows], states.speeds[0], atol=2e-4)


def test_whole_run_can_be_saved_as_a_table(visit, bumpy):
    with visit(name="bumpy") as found:
        found.page.click("text=Download")
        with found.page.expect_download() as waiting:
            found.page.click("#save-run")
        rows = list(csv.DictReader(waiting.value.path().read_text().splitlines()))
    assert len(rows) == len(bumpy.times) * 17
    np.testing.assert_allclose([float(row["time_s"]) for row in rows[::17]], bumpy.times, rtol=1e-12)


@pytest.mark.parametrize("sandbox", ["", 'sandbox="allow-scripts allow-downloads"'])
def test_page_works_within_a_frame_of_another_one(browser, seed, tmp_path, sandbox):
    outer = tmp_path / "notebook.html"
    frame = f'<iframe width="900" height="600" {sandbox} srcdoc="{escape(player_page(seed))}"></iframe>'
    outer.write_text(f"<!doctype html><title>Notebook</title>{frame}", encoding="utf-8")
    with opened(browser, outer.as_uri()) as found:
        frame = found.page.frame_locator("iframe")
        frame.locator("#next").click()
        frame.locator("#clock:text-is('406.85')").wait_for()
        frame.locator("#help").click()
        frame.locator("#close").click()
        assert frame.locator("#about").is_hidden()
        frame.locator("text=Download").click()
        with found.page.expect_download():
            frame.locator("#save-moment").click()
        assert found.complaints == []


def test_benches_that_cross_touch_though_no_corner_is_inside(browser, tmp_path):
    march = March(Dragon(benches=3), turns=8)
    # The third bench lies across the middle of the first.
    handles = np.array([[0, 0], [2.86, 0], [1.43, 0.823], [1.43, -0.827]])
    run = Run(march=march, times=[0.0], poses=bench_poses(handles)[None], drift=np.zeros((1, 3)))
    write_player(run, tmp_path / "run.html")
    with opened(browser, (tmp_path / "run.html").as_uri()) as found:
        assert ask(found.page, "player.numbers(0).gap") == 0
        assert shown(found.page, "gap") == "touches 2"


def test_benches_of_their_own_sizes_are_shown_in_them(browser, tmp_path):
    dragon = Dragon(body_spacing=[1.65, 2.5, 1.65], overhang=[0.2, 0.4, 0.1, 0.3], width=[0.2, 0.5, 0.3, 0.4])
    march = March(dragon, turns=6)
    run = Run.exact(march, [0.0, 1.0])
    write_player(run, tmp_path / "run.html")
    outlines = [Polygon(corners) for corners in dragon.outlines(run.poses[0])]
    with opened(browser, (tmp_path / "run.html").as_uri()) as found:
        for bench, others in {0: (2, 3), 1: (3,), 3: (0, 1)}.items():
            gap = ask(found.page, f"player.numbers({bench}).gap")
            assert gap == pytest.approx(min(outlines[bench].distance(outlines[i]) for i in others), abs=2 * RESOLUTION)
        assert found.complaints == []


@pytest.mark.parametrize("march", [U_TURN, TRACTOR, ARM], ids=["u-turn", "tractor", "arm"])
def test_other_marches_are_shown_too(browser, tmp_path, march):
    times = np.linspace(-20, 20, 81) if march is U_TURN else np.linspace(0, march.end, 81)
    run = Run.exact(march, times)
    write_player(run, tmp_path / "run.html")
    resolution = float(march.dragon.widths.min()) / 1_500_000
    with opened(browser, (tmp_path / "run.html").as_uri()) as found:
        for name in ("show-velocities", "show-grid", "show-labels", "show-handles"):
            found.page.check(f"#{name}")
        for time in times[[0, 30, 80]].tolist():
            poses = np.array(ask(found.page, f"(player.seek({time!r}), player.draw(), player.poses({time!r}))"))
            np.testing.assert_allclose(poses[:, :2], run.poses_at([time])[0, :, :2], rtol=0, atol=resolution)
        corners = [Polygon(outline) for outline in march.dragon.outlines(run.poses_at([time])[0])]
        gap = min(corners[0].distance(other) for other in corners[2:])
        assert ask(found.page, "player.numbers(0).gap") == pytest.approx(gap, abs=4 * resolution)
        assert found.complaints == []


def chain(dragon, frames, reach, seed=0):
    """Poses of a chain of benches that jumps about, and how fast they change."""
    random = np.random.default_rng(seed)
    angles = random.uniform(-np.pi, np.pi, (frames, dragon.benches))
    rods = dragon.spacings[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    begin = random.uniform(-reach, reach, (frames, 1, 2))
    spins = random.uniform(-1, 1, angles.shape)
    turning = spins[..., None] * np.stack([-rods[..., 1], rods[..., 0]], axis=-1)
    velocities = np.concatenate([0 * begin, -np.cumsum(turning, axis=1)], axis=1)
    rates = np.concatenate([(velocities[:, :-1] + velocities[:, 1:]) / 2, spins[..., None]], axis=-1)
    return bench_poses(np.concatenate([begin, begin - np.cumsum(rods, axis=1)], axis=1)), rates


@pytest.mark.parametrize(
    ("benches", "times", "reach"),
    [
        (2, [0.0], 1.0),
        (2, [0.0, 0.1, 0.1, 7.0], 1.0),
        (3, [-5.0, 1.0], 0.0),
        (16, np.linspace(0, 1, 30) ** 3, 1e5),
        (1000, [0.0, 1.0, 2.0], 100.0),
    ],
    ids=["one-frame", "shared-time", "before-0", "far-jumps", "1000-benches"],
)
def test_odd_runs_are_shown_too(browser, tmp_path, benches, times, reach):
    march = March(Dragon(benches=benches), turns=60 if benches > 16 else 8)
    poses, rates = chain(march.dragon, len(times), reach)
    run = Run(march=march, times=times, poses=poses, drift=np.zeros(poses.shape[:2]), pose_velocities=rates)
    write_player(run, tmp_path / "run.html")
    resolution = max(RESOLUTION, 1.002 * 2 * (reach + 2 * benches) / 2**31)
    moments = [*run.times.tolist(), float(run.times[0] + run.times[-1]) / 2]
    with opened(browser, (tmp_path / "run.html").as_uri()) as found:
        for time in moments:
            shown_poses = np.array(ask(found.page, f"(player.seek({time!r}), player.draw(), player.poses({time!r}))"))
            expected = run.poses_at([time])[0]
            np.testing.assert_allclose(shown_poses[:, :2], expected[:, :2], rtol=0, atol=resolution)
            error = np.abs(np.exp(1j * shown_poses[:, 2]) - np.exp(1j * expected[:, 2]))
            assert error.max() < 4 * resolution / 1.65
        for name in ("show-velocities", "show-grid", "show-labels", "show-handles"):
            found.page.check(f"#{name}")
        for key in ("End", "ArrowLeft", "ArrowLeft", "ArrowLeft", "Home", "Space", "n", "h", "+"):
            found.page.keyboard.press(key)
        found.page.wait_for_timeout(50)
        assert found.complaints == []
