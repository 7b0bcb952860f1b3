"""The player in a real browser: it plays, agrees with the exact model, and uses no network."""

import re
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from browser import TEXTS, english_words, framed, needs_browser, opened, wait_until
from marches import TRACTOR
from shapely import Polygon

from pymunk_dragon import Dragon, March, Run, player_page, write_player
from pymunk_dragon.drawing.palette import COLOURS, Palette
from pymunk_dragon.model.dragon import bench_poses
from pymunk_dragon.web.page import colour_variables

pytestmark = [pytest.mark.thorough, needs_browser]

LABEL = "</script><img src=http://127.0.0.1:9/picture onerror=alert(1)><script>alert(2)</script>"
# Half a count of a place, 0.2 micrometres at the usual width, and as much again between two frames,
# m.
RESOLUTION = 1.002 * 0.2e-6
CONTACT_TIME = 412.47383768
# Two near misses, and the contact.
EVENTS = (406.8466, 409.8320, CONTACT_TIME)

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
RATES = """([begin, end]) => dragon.then((player) => Array.from({ length: 401 }, (_, k) => {
  player.seek(begin + (end - begin) * k / 400);
  return player.rate;
}))"""
# Controls that are out of sight, and texts that are wider than their buttons.
OUT_OF_SIGHT = """() => [...document.querySelectorAll("button, input, select")]
  .filter((control) => !control.closest("dialog, [popover]"))
  .filter((control) => {
    const { left, right, top, bottom } = control.getBoundingClientRect();
    const found = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
    return left < 0 || right > innerWidth || top < 0 || bottom > innerHeight
      || !(found && (control.contains(found) || found.contains(control)));
  }).map((control) => control.id)"""
CUT = """() => [...document.querySelectorAll("button, label, h1")]
  .filter((each) => !each.closest("dialog"))
  .filter((each) => each.scrollWidth > each.clientWidth + 1 && each.clientWidth > 0)
  .map((each) => each.textContent)"""
NAMELESS = """() => [...document.querySelectorAll("button, input, select, canvas, dialog")]
  .filter((element) => !(element.ariaLabel || element.textContent.trim() || element.labels?.length
    || element.ariaHidden || element.getAttribute("aria-labelledby")))
  .map((element) => element.outerHTML)"""
ANNOUNCED = "document.getElementById('announcement').textContent"


@pytest.fixture(scope="module")
def seed(seed_march):
    """The seed's last seconds in the exact model."""
    return Run.exact(seed_march, np.arange(4050, 4127) / 10)


@pytest.fixture(scope="module")
def bumpy(small_run):
    """16 benches that touch each other many times, with markup in a label."""
    return replace(small_run, provenance={**small_run.provenance, LABEL: LABEL})


@pytest.fixture
def visit(browser, seed, bumpy, tmp_path):
    """Open the page of a run, and wait until it shows the run."""

    @contextmanager
    def visited(link="", run=seed, **options):
        write_player(run, tmp_path / "run.html")
        with opened(browser, (tmp_path / "run.html").as_uri() + link, **options) as found:
            found.page.evaluate("dragon.then(() => null)")
            yield found.page
            # Chromium advises on how to read pixels, which only these tests do.
            assert [text for text in found.complaints if "getImageData" not in text] == []

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


def test_page_asks_for_nothing_and_runs_only_its_own_script(browser, bumpy, tmp_path):
    write_player(bumpy, tmp_path / "run.html")
    with opened(browser, (tmp_path / "run.html").as_uri()) as found:
        page = found.page
        settled(page, "true")
        page.keyboard.press("Space")
        settled(page, "player.time > 77.6")
        assert [url for url in found.addresses if not url.startswith("data:")] == [
            page.url.partition("#")[0]
        ]
        assert page.is_hidden("#failure")
        page.click("#help")
        assert LABEL in shown(page, "about")
        assert page.evaluate("[document.scripts.length, document.images.length]") == [7, 0]
        page.evaluate("""() => {
          const script = document.createElement("script");
          script.textContent = "alert(3)";
          document.body.append(script);
          const clickable = "<b id='b' onclick='alert(4)' style='color: red'>b</b>";
          document.body.insertAdjacentHTML("beforeend", clickable);
          document.getElementById("b").click();
        }""")
        assert found.boxes == []
        assert len(found.complaints) == 3
        for complaint in found.complaints:
            assert "Content Security Policy" in complaint


def test_poses_at_and_between_frames_are_the_runs(visit, seed, bumpy):
    front, rear = bumpy.march.dragon.holes(bumpy.poses)
    with visit(run=bumpy) as page:
        for frame in (0, 57, len(bumpy.times) - 1):
            places = np.reshape(ask(page, f"player.handles({frame})"), (-1, 2))
            # Joints of the engine are up to some micrometres apart.
            joint = np.abs(rear[frame, :-1] - front[frame, 1:]).max() / 2
            np.testing.assert_allclose(places[:-1], front[frame], rtol=0, atol=RESOLUTION + joint)
            np.testing.assert_allclose(places[1:], rear[frame], rtol=0, atol=RESOLUTION + joint)
    # The page has one more frame, that of the contact.
    frames = np.sort([*seed.times, 412.4738376821])
    times = [405.0, 405.05, 409.832, 412.43, CONTACT_TIME, 412.6]
    expected = Run.exact(seed.march, frames).poses_at(times)
    with visit() as page:
        poses = np.array([ask(page, f"player.poses({time})") for time in times])
    np.testing.assert_allclose(poses[..., :2], expected[..., :2], rtol=0, atol=RESOLUTION)
    turn = (poses[..., 2] - expected[..., 2] + np.pi) % (2 * np.pi) - np.pi
    np.testing.assert_allclose(turn, 0, atol=4 * RESOLUTION / 1.65)


def test_it_plays_pauses_and_starts_again_at_the_end(visit):
    with visit() as page:
        assert shown(page, "clock") == "405.00"
        for label, until in (("Pause", "player.time > 405.2"), ("Play", "!player.playing")):
            page.click("#play")
            assert page.get_attribute("#play", "aria-label") == label
            settled(page, until)
        assert float(shown(page, "clock")) == pytest.approx(ask(page, "player.time"), abs=0.006)
        ask(page, "player.seek(412.55)")
        page.keyboard.press("Space")
        settled(page, "!player.playing && player.time === 412.6")
        page.keyboard.press("Space")
        settled(page, "player.time < 411")
    with visit("#t=406&play", reduced_motion="reduce") as page:
        assert ask(page, "player.playing") is False


def test_playing_slows_down_to_an_eighth_at_near_misses_and_contacts(visit):
    with visit("#speed=10") as page:
        for event in EVENTS:
            begin, end = max(405.0, event - 2), min(412.6, event + 2)
            rates = np.array(page.evaluate(RATES, [begin, end]))
            assert rates.min() == pytest.approx(1 / 8)
            assert abs(np.linspace(begin, end, 401)[rates.argmin()] - event) < 0.07
            ask(page, f"player.seek({event})")
            assert shown(page, "reduced") == "1/8×"
        page.uncheck("#slow")
        assert set(page.evaluate(RATES, [begin, end])) == {10}


def test_keys_step_through_frames_and_events(visit):
    with visit("#t=409.85") as page:
        for key, time in {
            "ArrowRight": 409.9,
            "ArrowLeft": 409.8,
            "End": 412.6,
            "Home": 405.0,
        }.items():
            page.keyboard.press(key)
            assert ask(page, "player.time") == pytest.approx(time), key
        page.fill("#time", "406.25")
        assert ask(page, "player.time") == pytest.approx(406.25)
        for time in EVENTS:
            page.keyboard.press("n")
            assert ask(page, "player.time") == pytest.approx(time, abs=1e-3)
        wait_until(page, f"{ANNOUNCED}.includes('Contact: benches 0 and 8')")
        page.keyboard.press("p")
        wait_until(page, f"{ANNOUNCED}.includes('benches 0 and 11, 0.865 mm')")
        assert shown(page, "gap") == "0.865 mm to 11"
        # The timeline zooms around the time.
        page.click("#timeline-in")
        begin, end = ask(page, "player.timeline")
        assert end - begin == pytest.approx(7.6 / 2)
        assert (409.832 - begin) / (end - begin) == pytest.approx((409.832 - 405) / 7.6, abs=1e-3)
        page.click("#last")
        settled(page, "player.playing")


def test_wheel_over_the_timeline_zooms_around_the_pointer(visit):
    # The timeline always has the present time.
    with visit("#t=408.8") as page:
        strip = page.locator("#strip").bounding_box()
        begin, end = ask(page, "player.timeline")
        page.mouse.move(strip["x"] + strip["width"] / 2, strip["y"] + strip["height"] / 2)
        page.mouse.wheel(0, -300)
        settled(page, f"player.timeline[1] - player.timeline[0] < {end - begin}")
        nearer = ask(page, "player.timeline")
        assert sum(nearer) / 2 == pytest.approx((begin + end) / 2, abs=0.05)


def test_benches_in_contact_have_the_contact_colour_from_the_contact_on(visit, seed):
    with visit("#show=curve") as page:
        page.select_option("#events", label="412.47 s: Contact: benches 0 and 8")
        assert shown(page, "clock") == "412.47"
        poses = seed.march.at([CONTACT_TIME]).poses[0]
        corners = seed.march.dragon.outlines(poses)[0]
        side = ((corners[0] + corners[1]) / 2).tolist()
        assert page.evaluate(COLOUR, poses[8, :2].tolist()) == COLOURS.contact
        assert page.evaluate(COLOUR, poses[9, :2].tolist()) == COLOURS.body
        # The head keeps its colour, and has a border in that of the contact.
        assert page.evaluate(COLOUR, poses[0, :2].tolist()) == COLOURS.head
        assert page.evaluate(COLOUR, side) == COLOURS.contact
        ask(page, f"player.seek({CONTACT_TIME} - 0.001)")
        assert page.evaluate(COLOUR, side) != COLOURS.contact
        assert page.evaluate(COLOUR, poses[8, :2].tolist()) == COLOURS.body


def test_hover_tells_the_exact_models_numbers(visit, seed):
    states = seed.march.at([409.8])
    shapes = [Polygon(corners) for corners in seed.march.dragon.outlines(states.poses[0])]
    with visit("#t=409.8&show=curve") as page:
        for bench in (0, 11, 222):
            x, y, angle = states.poses[0, bench].tolist()
            gaps = {i: shapes[bench].distance(shapes[i]) for i in range(223) if abs(i - bench) > 1}
            nearest = min(gaps, key=gaps.get)
            page.mouse.move(*page.evaluate(PLACE, [x, y]))
            wait_until(page, f"document.getElementById('bench').value === '{bench}'")
            assert shown(page, "speed") == f"{states.speeds[0, bench]:.3f} m/s"
            assert shown(page, "angle") == f"{np.degrees(angle):.1f}°".replace("-", "−")
            assert shown(page, "gap").endswith(f"mm to {nearest}")
            numbers = ask(page, f"player.numbers({bench})")
            assert numbers["gap"] == pytest.approx(gaps[nearest], abs=4 * RESOLUTION)
            assert numbers["velocity"] == pytest.approx(
                states.velocities[0, bench].tolist(), abs=3e-4
            )


def test_exact_poses_and_position_errors_are_the_models(visit, bumpy):
    march, time = bumpy.march, 80.0
    with visit(f"#t={time}&follow=head&show=exact", run=bumpy) as page:
        exact = np.array(ask(page, f"player.exactPoses({time})"))
        np.testing.assert_allclose(
            exact[:, :2], march.at([time]).poses[0, :, :2], rtol=0, atol=2e-6
        )
        assert (
            int(
                shown(page, "legend-exact-text")
                .removeprefix("Exact model, error × ")
                .replace(",", "")
            )
            > 1
        )
        for bench in (0, 7, 15):
            page.fill("#bench", str(bench))
            front, rear = (hole[0, bench] for hole in march.dragon.holes(bumpy.poses_at([time])))
            ends = march.at([time]).positions[0, bench : bench + 2]
            error = max(np.linalg.norm(front - ends[0]), np.linalg.norm(rear - ends[1]))
            number, unit = shown(page, "error").split()
            assert float(number) * {"mm": 1e-3, "μm": 1e-6}[unit] == pytest.approx(
                error, rel=0.05, abs=1e-6
            )
    # A run of the exact model has nothing to compare.
    with visit("#show=exact") as page:
        assert ask(page, "player.exactPoses(409)") is None
        assert page.locator(".exact-only").first.is_hidden()


def test_link_restores_moment_view_and_switches(visit):
    link = "#t=409.8&at=-2.5,-1&span=1.25&show=curve,grid,labels&bench=11&speed=0.25"
    with visit(link) as page:
        assert ask(page, "player.time") == 409.8
        view = ask(page, "player.view")
        box = page.locator("#field").bounding_box()
        assert [view["x"], view["y"]] == [-2.5, -1]
        assert min(box["width"], box["height"]) / view["scale"] == pytest.approx(1.25)
        checked = "[...document.querySelectorAll('fieldset input:checked')].map(({ id }) => id)"
        assert page.evaluate(checked) == ["show-curve", "show-grid", "show-labels"]
        assert [page.input_value("#bench"), page.input_value("#rate")] == ["11", "0.25"]
        wait_until(page, "location.hash.includes('span=')")
        assert page.evaluate("location.hash") == link
        # A link that changes is followed, and so is the head.
        page.evaluate("location.hash = '#t=410.5&follow=head'")
        settled(page, "player.time === 410.5 && player.view.follow === 'head'")
        head = ask(page, "player.poses(410.5)[0]")
        view = ask(page, "(player.draw(), player.view)")
        assert [view["x"], view["y"]] == pytest.approx(head[:2])
    for link in (
        "#t=soon&at=1&span=-3&show=all&bench=9999&speed=3",
        "#t=1e999&%",
        "#lang=toString",
    ):
        with visit(link) as page:
            assert ask(page, "[player.time, player.view.follow]") == [405, "field"]


def test_page_fits_into_the_window_with_every_control_in_sight(visit, bumpy):
    for width, height, language in (
        (1280, 800, ""),
        (844, 390, "?zh"),
        (390, 844, ""),
        (320, 568, "?zh"),
    ):
        with visit(f"{language}#show=curve,exact", run=bumpy, width=width, height=height) as page:
            root = "document.documentElement"
            assert page.evaluate(
                f"{root}.scrollWidth <= {width} && {root}.scrollHeight <= {height}"
            )
            assert [page.evaluate(script) for script in (OUT_OF_SIGHT, CUT, NAMELESS)] == [
                [],
                [],
                [],
            ]
            assert page.locator("#field").bounding_box()["height"] > 150


def test_page_is_in_the_chosen_language_only(visit, bumpy):
    with visit("?zh", run=bumpy, locale="en-GB") as page:
        assert page.evaluate("document.documentElement.lang") == "zh"
        wait_until(page, f"{ANNOUNCED} !== ''")
        # The title of the document is that of the run.
        assert english_words(page) <= set(page.title().split())
    with visit("#t=409.832", locale="zh-CN") as page:
        wait_until(page, f"{ANNOUNCED} !== ''")
        page.evaluate(f"window.before = JSON.stringify(({TEXTS})())")
        assert not page.evaluate(r"/[\u4e00-\u9fff]/.test(window.before)")
        page.click("#language")
        assert shown(page, "gap") == "0.865 mm，至 11 号"
        wait_until(page, "location.hash.includes('lang=zh')")
        page.click("#language")
        wait_until(page, f"JSON.stringify(({TEXTS})()) === window.before")
        assert page.evaluate("document.documentElement.lang") == "en"


def test_colours_are_those_of_the_readers_scheme(visit):
    with visit("#t=409&show=curve", color_scheme="light") as page:
        places = [ask(page, f"player.poses(409)[{bench}]")[:2] for bench in (0, 50, 222)]
        dark = Palette(**dict(re.findall(r"--dark-(\w+): (#\w+);", colour_variables())))
        assert dark != COLOURS
        for palette, scheme in ((COLOURS, "light"), (dark, "dark")):
            page.emulate_media(color_scheme=scheme)
            wait_until(
                page, f"({COLOUR})([12, 0]).then((colour) => colour === {palette.background!r})"
            )
            colours = [page.evaluate(COLOUR, place) for place in places]
            assert colours == [palette.head, palette.body, palette.tail]


def test_other_marches_and_odd_runs_are_shown(visit):
    chain = np.array([[0, 0], [2.86, 0], [1.43, 0.823], [1.43, -0.827]])
    march = March(Dragon(benches=3), turns=8)
    crossed = Run(march=march, times=[0.0], poses=bench_poses(chain)[None], drift=np.zeros((1, 3)))
    with visit(run=crossed) as page:
        # The third bench lies across the middle of the first.
        assert shown(page, "gap") == "touches 2"
    run = Run.exact(TRACTOR, np.linspace(0, TRACTOR.end, 81))
    resolution = float(TRACTOR.dragon.widths.min()) / 1_500_000
    with visit(run=run) as page:
        for name in ("show-velocities", "show-grid", "show-labels", "show-handles"):
            page.check(f"#{name}")
        for time in run.times[[0, 30, 80]].tolist():
            poses = np.array(
                ask(page, f"(player.seek({time!r}), player.draw(), player.poses({time!r}))")
            )
            np.testing.assert_allclose(
                poses[:, :2], run.poses_at([time])[0, :, :2], rtol=0, atol=resolution
            )
        corners = [Polygon(outline) for outline in TRACTOR.dragon.outlines(run.poses_at([time])[0])]
        gap = min(corners[0].distance(other) for other in corners[2:])
        assert ask(page, "player.numbers(0).gap") == pytest.approx(gap, abs=4 * resolution)


@pytest.mark.parametrize("how", ["src", "srcdoc"])
def test_player_works_in_a_frame_that_allows_scripts_only(browser, bumpy, how):
    with framed(browser, player_page(bumpy), how) as (_, frame):
        settled(frame, "player.time > 0")
        frame.click("#language")
        assert frame.evaluate("document.documentElement.lang") == "zh"
        frame.click("#help")
        frame.click("#close")
        for name in (
            "next",
            "forward",
            "back",
            "previous",
            "zoom-in",
            "follow",
            "fit",
            "timeline-in",
            "timeline-all",
        ):
            frame.click(f"#{name}")
        frame.check("#show-handles")
        frame.fill("#bench", "3")
        assert shown(frame, "speed").endswith(" m/s")
        frame.click("#last")
        settled(frame, "player.playing")
        frame.locator("#field").press("Space")
        settled(frame, "!player.playing")
