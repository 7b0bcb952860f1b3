"""Live sessions in a real browser: mouse and fingers reach the engine, and the page shows it."""

from __future__ import annotations

import re
import subprocess
from contextlib import contextmanager
from urllib.parse import urlsplit

import imageio_ffmpeg
import numpy as np
import pymunk
import pytest
from browser import english_words, framed, needs_browser, opened, wait_until
from live_sessions import PATIENCE, decoded, replayed, served

from pymunk_dragon._language import in_language, texts
from pymunk_dragon.lessons import LESSONS
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.sessions.controls import Button, Key
from pymunk_dragon.sessions.live import source_of
from pymunk_dragon.sessions.page import live_page
from pymunk_dragon.sessions.replay import load_log
from pymunk_dragon.sessions.scene import PlaySettings
from pymunk_dragon.sessions.scenes import SCENES, add, march_scene, space_scene

pytestmark = [pytest.mark.thorough, needs_browser]

PREFIX = "/user/x/proxy/8123/"
# Where on the page a point of the world is.
PLACE = """([x, y]) => {
  const { left, top } = document.getElementById("field").getBoundingClientRect();
  const [px, py] = live.view.toScreen(x, y);
  return [left + px, top + py];
}"""

# Whether the area of the scene is on the canvas, and neither behind the tools nor behind the
# buttons of the view.
IN_SIGHT = """() => {
  const { centre: [x, y], size: [width, height] } = live.scene.view;
  // The upper left corner and the lower right one: y points up in the scene, and down on the page.
  const [left, top] = live.view.toScreen(x - width / 2, y + height / 2);
  const [right, bottom] = live.view.toScreen(x + width / 2, y - height / 2);
  const box = (id) => document.getElementById(id).getBoundingClientRect();
  const field = box("field"), tools = box("toolbox"), zoom = box("zoom");
  return left >= 0 && right <= field.width
    && top >= tools.bottom - field.top && bottom <= field.height
    && (right <= zoom.left - field.left || bottom <= zoom.top - field.top);
}"""


@contextmanager
def visit(browser, address, **options):
    """Open a page and wait for its first picture; in the end nothing may have gone wrong in it."""
    with opened(browser, address, **options) as found:
        found.page.set_default_timeout(1000 * PATIENCE)
        wait_until(found.page, "globalThis.live?.frame != null && live.drawn > 0")
        yield found
        assert found.complaints == []
        assert found.boxes == []
        own = urlsplit(address).netloc
        assert {urlsplit(url).netloc for url in found.addresses if not url.startswith("data:")} == {
            own
        }


@contextmanager
def shown(browser, source, **options):
    """A session, and its page."""
    with served(source) as session, visit(browser, session.address, **options) as found:
        yield session, found.page


def poses(page):
    """Poses of the benches in the picture."""
    return np.array(page.evaluate("Array.from(live.frame.poses)")).reshape(-1, 3)


def poses_of(session):
    with session.paused():
        return session.session.scene.poses()


def place(page, x, y):
    return page.evaluate(PLACE, [float(x), float(y)])


def pause(page, session):
    """Pause with the space key, and wait until the page shows the last step."""
    page.keyboard.press("Space")
    wait_until(page, "!live.state.running")
    wait_until(page, f"live.frame.step === {session.session.scene.steps}")
    page.evaluate("new Promise(requestAnimationFrame)")


def wait_simulated(page, seconds):
    """Wait until so much simulated time has passed."""
    wait_until(page, f"live.frame.time > {page.evaluate('live.frame.time') + seconds}")


def wait_pulled(page, x, y):
    """Wait until the hand that holds a body is at a point, and then for 1.5 s of simulated time."""
    wait_until(page, f"Math.hypot(live.frame.held?.[2] - {x}, live.frame.held?.[3] - {y}) < 0.05")
    wait_simulated(page, 1.5)


def log_of(session):
    """The log of a session between two steps."""
    with session.paused():
        return session.session.log()


def assert_replays(session):
    log = log_of(session)
    assert log["steps"] > 0
    assert replayed(log)[0] == log["poses"]


def test_rod_follows_the_mouse_and_the_replay_of_saved_inputs_is_equal(browser, tmp_path):
    with shown(browser, "pendulum") as (session, page):
        pause(page, session)
        x, y, angle = poses_of(session)[2]
        page.mouse.move(*place(page, x + 0.4 * np.cos(angle), y + 0.4 * np.sin(angle)))
        page.mouse.down()
        wait_until(page, "live.frame.held !== null")
        page.keyboard.press("Space")
        goal = place(page, 1.0, -1.0)
        page.mouse.move(*goal, steps=8)
        wait_pulled(page, 1.0, -1.0)
        x, y, angle = poses_of(session)[2]
        end = place(page, x + 0.4 * np.cos(angle), y + 0.4 * np.sin(angle))
        assert np.hypot(*np.subtract(end, goal)) < 15
        page.mouse.up()
        wait_until(page, "live.frame.held === null")
        page.keyboard.press("Space")
        wait_until(page, "!live.state.running")
        with page.expect_download() as download:
            page.click("#save")
        download.value.save_as(tmp_path / "inputs.json")
        log = load_log(tmp_path / "inputs.json")
        assert {message["do"] for _, message in log["inputs"]} == {"grab", "drag", "drop"}
        assert replayed(log)[0] == log["poses"]


def test_page_shows_the_largest_error_and_its_tool_cuts_the_joint_that_is_clicked(browser):
    with shown(browser, march_scene(March(Dragon(benches=60)))) as (session, page):
        pause(page, session)
        errors = decoded(session.session.scene.frame({})).errors
        # The page draws charts ten times a second, so it may still show the value of an earlier
        # frame.
        ending = f"μm, bench {errors.argmax()}"
        text = "document.querySelector('#value-error').textContent"
        is_near = f"Math.abs(parseFloat({text}) - {1e6 * errors.max()}) < 1e-2"
        wait_until(page, f"{is_near} && {text}.endsWith({ending!r})")
        page.click("label:has(#tool-cut)")
        front, _ = session.session.scene.march.dragon.holes(poses(page))
        page.mouse.click(*place(page, *front[30]))
        wait_until(page, "live.state.cuts.length === 1")
        [cut] = page.evaluate("live.state.cuts")
        assert abs(cut - 29) <= 1
        assert_replays(session)


# Codec, width and height of a film, as FFmpeg says them.
VIDEO = r"Video: (\w+) .* (\d{2,})x(\d{2,})"
# Size of a film that the browser plays.
PLAYED = """async (address) => {
  const video = Object.assign(document.createElement("video"), { muted: true, src: address });
  await video.play();
  return [video.videoWidth, video.videoHeight];
}"""


def filmed(page, folder, meanwhile):
    """The file that the page films."""
    page.click("#record")
    wait_simulated(page, 1.0)
    meanwhile()
    wait_simulated(page, 1.0)
    with page.expect_download() as download:
        page.click("#record")
    film = folder / download.value.suggested_filename
    download.value.save_as(film)
    return film


def pictures_of(film):
    """Codec and pictures of an undamaged film, by FFmpeg: imageio leaves pipes open."""
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-err_detect", "explode", "-xerror", "-i", film]
    command += ["-fps_mode", "passthrough", "-f", "rawvideo", "-pix_fmt", "gray", "-"]
    done = subprocess.run(command, capture_output=True, check=True)
    codec, width, height = re.search(VIDEO, done.stderr.decode()).groups()
    assert "rror" not in done.stderr.decode()
    return codec, np.frombuffer(done.stdout, np.uint8).reshape(-1, int(height), int(width)).astype(
        float
    )


@pytest.mark.parametrize("later", [(1281, 803), (700, 900)])
def test_button_films_the_canvas_in_h264_also_while_its_size_changes(browser, tmp_path, later):
    with shown(browser, march_scene(March(Dragon(benches=30))), width=1281, height=803) as (
        _,
        page,
    ):
        sizes = np.array(
            page.evaluate(
                "['width', 'height'].map((side) => document.getElementById('field')[side])"
            )
        )
        wide, high = later
        film = filmed(
            page, tmp_path, lambda: page.set_viewport_size({"width": wide, "height": high})
        )
        known = page.evaluate("MediaRecorder.isTypeSupported('video/mp4;codecs=avc1')")
    codec, (first, *_, last) = pictures_of(film)
    assert (film.suffix, codec) == ((".mp4", "h264") if known else (".webm", codec))
    assert any(sizes % 2)
    assert first.shape == tuple(2 * (sizes // 2)[::-1])
    # The dragon moves in it.
    assert np.abs(first - last).max() > 100
    with opened(browser, film.as_uri()) as found:
        page = found.page
        assert page.evaluate(PLAYED, film.as_uri()) == list(2 * (sizes // 2))


def test_page_works_in_a_frame_that_allows_scripts_only(browser):
    # As in a notebook, without Python on the other side.
    page, _ = live_page("A scene", "en")
    with framed(browser, page, "srcdoc") as (_, frame):
        wait_until(frame, "globalThis.live != null")
        frame.click("#language")
        assert frame.evaluate("document.documentElement.lang") == "zh"
        frame.click("#help")
        assert frame.locator("#about").is_visible()
        frame.click("#close")
        before = frame.evaluate("live.view.span")
        frame.click("#zoom-in")
        assert frame.evaluate("live.view.span") < before


def test_finger_drags_a_box_on_a_phone(browser):
    options = {"width": 390, "height": 844, "has_touch": True, "is_mobile": True}
    with shown(browser, "boxes", **options) as (session, page):
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        x, y, _ = poses_of(session)[-1]
        begin, goal = place(page, x, y), place(page, x + 0.8, y + 0.8)
        touch = page.context.new_cdp_session(page)

        def point(kind, where):
            points = [] if where is None else [{"x": where[0], "y": where[1]}]
            touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

        point("touchStart", begin)
        for share in np.linspace(0, 1, 9)[1:]:
            point("touchMove", [a + share * (b - a) for a, b in zip(begin, goal, strict=True)])
        wait_pulled(page, x + 0.8, y + 0.8)
        later = poses_of(session)[-1]
        assert np.hypot(*(later[:2] - (x + 0.8, y + 0.8))) < 0.2
        point("touchEnd", None)
        wait_until(page, "live.frame.held === null")


@pytest.mark.parametrize(("width", "height"), [(1280, 800), (390, 844), (844, 390), (640, 400)])
def test_scene_is_in_sight_and_so_is_the_error_of_a_function(browser, width, height):
    def crash(space):
        raise ValueError("a reason")

    source = source_of(pymunk.Space, PlaySettings(controls=[Button("Crash", crash)]))
    with (
        served("robot-arm") as session,
        visit(browser, session.address, width=width, height=height) as found,
    ):
        assert found.page.evaluate(IN_SIGHT)
    with shown(browser, source, width=width, height=height) as (session, page):
        # Only what the program can play again is offered.
        assert page.is_hidden("#save")
        page.evaluate("document.getElementById('parameters-part').open = true")
        page.click("#actions button")
        page.wait_for_selector("#error:has-text('a reason'):has-text('in crash')")
        assert "test_sessions_browser.py" in page.inner_text("#error-place")
        box = page.locator("#error").bounding_box()
        assert 0 <= box["x"] <= width - box["width"]
        page.click("#error-close")
        assert page.is_hidden("#error")


def test_page_shows_keys_events_errors_and_charts_of_a_program(browser):
    pressed, events = [], []
    keys = [
        Key("ArrowUp", lambda space: pressed.append("down"), lambda space: pressed.append("up"))
    ]
    controls = [
        *keys,
        Button("Tell", lambda space: events.append("1 2 3 4 5")),
        Button("Crash", lambda space: 1 / 0),
    ]
    with shown(
        browser, source_of(pymunk.Space, PlaySettings(controls=controls, events=events))
    ) as (_, page):
        assert "↑" in page.inner_text("#held-keys")
        page.keyboard.down("ArrowUp")
        # Another window has the focus when the key is released.
        page.evaluate("dispatchEvent(new Event('blur'))")
        page.click("text=Tell")
        page.wait_for_selector("#events:has-text('1 2 3 4 5')")
        assert pressed == ["down", "up"]
        page.click("text=Crash")
        page.wait_for_selector("#error")
        # The key starts what is paused, and pauses what still runs.
        wait_until(page, "!live.state.running")
        page.keyboard.press("Space")
        page.wait_for_selector("#error", state="hidden")
        page.click("#reset")
        page.wait_for_selector("#no-events")
        ticks = page.evaluate("""() => {
          const [quantity] = live.charts.quantities, { chart } = quantity, shown = [];
          chart.samples = [[0, 19], [0, 20]];
          chart.text = (_, text) => shown.push(text);
          quantity.draw();
          return shown;
        }""")
        assert len(set(ticks)) == len(ticks) > 2
        page.click("#language")
        page.wait_for_selector("#charts-own:has-text('动能')")


def test_button_that_starts_again_says_in_both_languages_where_the_run_may_differ(browser):
    titles = []
    for what in (pymunk.Space, pymunk.Space()):
        with shown(browser, source_of(what, PlaySettings())) as (_, page):
            titles.append(page.get_attribute("#reset", "title"))
            page.click("#language")
            wait_until(page, "document.documentElement.lang === 'zh'")
            titles.append(page.get_attribute("#reset", "title"))
    assert len(set(titles)) == 4
    assert all(title.isascii() == (number % 2 == 0) for number, title in enumerate(titles))


def balance(gravity=9.81):
    """A tonne on a spring, and a lever that a motor holds."""
    space = pymunk.Space()
    space.gravity = 0, -gravity
    load, lever = pymunk.Body(1000, 1), pymunk.Body(1, 1)
    load.position = 0, -2
    lever.center_of_gravity = 1, 0
    lever.position = 3, 0
    spring = pymunk.DampedSpring(space.static_body, load, (0, 0), (0, 0), 1, 9810, 3000)
    pivot = pymunk.PivotJoint(space.static_body, lever, (3, 0))
    shapes = pymunk.Circle(load, 0.3), pymunk.Segment(lever, (0, 0), (2, 0), 0.1)
    space.add(load, lever, *shapes, spring, pivot, pymunk.SimpleMotor(space.static_body, lever, 0))
    return space


def test_page_shows_forces_and_torques_in_their_units_and_on_scales_of_their_own(browser):
    with shown(browser, space_scene(balance, PlaySettings())) as (_, page):
        wait_until(page, "document.querySelector('#value-force').textContent === '9.8 kN, joint 0'")
        wait_until(
            page, "document.querySelector('#value-torque').textContent === '9.81 N m, joint 2'"
        )
        assert page.evaluate("[live.scales.force.top, live.scales.torque.top]") == [
            4,
            1,
        ]
        assert page.text_content("#torque-name") == "Torque by joint (N m)"
        captions = page.eval_on_selector_all(
            "#charts-own select", "all => all.map((x) => x.selectedOptions[0].text)"
        )
        assert captions == [
            "Kinetic energy (J)",
            "Kinetic and potential energy (J)",
            "Momentum (N s)",
        ]
        label = page.evaluate("live.tools.labelOf({ joint: live.moment.joints[2] })")
        assert label == "joint 2: 9.81 N m"


def test_space_bar_pauses_after_a_click_on_a_switch_and_works_one_that_a_key_has_reached(browser):
    with shown(browser, "pendulum") as (session, page):
        page.click("label:has(#show-forces)")
        pause(page, session)
        assert page.is_checked("#show-forces")
        page.keyboard.press("Shift+Tab")
        page.keyboard.press("Space")
        assert not page.is_checked("#show-contacts")
        assert not page.evaluate("live.state.running")


def test_watching_page_has_no_controls(browser):
    with served("pendulum") as session, visit(browser, session.watch_address) as found:
        page = found.page
        assert page.evaluate(
            "[...document.querySelectorAll('.sends')].every((each) => each.disabled)"
        )
        for key in ("Space", "r", "l", "ArrowRight"):
            page.keyboard.press(key)
        wait_simulated(page, 0.3)
        assert log_of(session)["inputs"] == []
        assert session.session.clock.running


def test_page_behind_a_proxy_with_a_prefix_asks_for_addresses_with_the_prefix(browser):
    with served("pendulum") as session, opened(browser, "about:blank") as found:
        page, sockets = found.page, []
        page.route(
            "**/*", lambda route: route.continue_(url=route.request.url.replace(PREFIX, "/"))
        )
        page.route_web_socket("**/*", lambda socket: sockets.append(socket.url))
        own, token = session.address.split("/?")
        page.goto(f"{own}{PREFIX}?{token}")
        wait_until(page, "document.getElementById('save').href !== ''")
        assert (
            page.evaluate("document.getElementById('save').href") == f"{own}{PREFIX}inputs?{token}"
        )
        assert sockets[0] == f"{own.replace('http', 'ws')}{PREFIX}socket?{token}"


def test_page_switches_scenes_and_sets_parameters_without_complaints(browser):
    with shown(browser, march_scene(March(Dragon(benches=20)))) as (_, page):
        for name in page.evaluate("live.scene.scenes.map((each) => each.name)"):
            page.select_option("#scene", name)
            wait_until(
                page,
                f"live.scene.name === '{name}' && live.frame?.generation === live.scene.generation",
            )
            if name not in ("own", "jam", "pendulum"):
                # A change builds the scene anew; that takes a while with 223 benches.
                continue
            for box in page.query_selector_all("fieldset input[type=checkbox]"):
                if box.is_visible():
                    box.check()
            # At once: a scene that is built anew may replace its sliders, and a key without one
            # makes a single step.
            page.evaluate("""() => {
              for (const slider of document.querySelectorAll("#parameters input[type=range]")) {
                slider.stepUp();
                for (const kind of ["input", "change"]) slider.dispatchEvent(new Event(kind));
              }
            }""")
            drawn = page.evaluate("live.drawn")
            wait_until(page, f"live.drawn > {drawn} + 3")
        # The last scene has no joints. The chart of their forces comes back with those of another
        # one.
        for name, hidden in (("boxes", "true"), ("pendulum", "false")):
            page.select_option("#scene", name)
            wait_until(page, f"document.querySelector('#charts-force').hidden === {hidden}")


@pytest.mark.parametrize(("program", "link"), [("en", "&lang=zh"), ("zh", "")])
def test_page_is_chinese_if_the_program_or_the_address_is(browser, program, link):
    add(**LESSONS["tension"].scene())
    with (
        in_language(program),
        served("jam") as session,
        visit(browser, session.address + link) as found,
    ):
        page = found.page
        assert page.evaluate("document.documentElement.lang") == "zh"
        # Words of the commands of lessons, and titles without a translation.
        titles = " ".join(
            scene.title for scene in SCENES.values() if scene.title not in texts("zh")
        )
        allowed = {
            "CSV",
            "pymunk",
            "dragon",
            "demo",
            "live",
            "callbacks",
            "tension",
            "lang",
            *titles.split(),
        }
        assert english_words(page) <= allowed
        page.select_option("#scene", "tension")
        wait_until(
            page,
            "live.scene.name === 'tension' && live.frame?.generation === live.scene.generation",
        )
        wait_simulated(page, 0.3)
        assert english_words(page) <= allowed


def test_benches_touch_after_all_are_let_go_and_a_button_changes_the_language_there_and_back(
    browser,
):
    with shown(browser, march_scene(March(Dragon(benches=40)))) as (session, page):
        page.select_option("#contacts", "stop")
        page.click("#release")
        wait_until(page, "live.state.free_from === 1 && live.state.contacts === 'stop'")
        page.select_option("#speed", "20")
        # The state, the frame and the event come one after the other.
        wait_until(page, "!live.state.running && live.frame.contacts.length > 0")
        page.wait_for_selector("#events:has-text('touch')", state="attached")
        first, second = re.search(
            r"benches (\d+) and (\d+) touch", page.text_content("#events")
        ).groups()
        assert page.evaluate("live.frame.touching") == [int(first), int(second)]
        page.click("#language")
        wait_until(page, "document.documentElement.lang === 'zh'")
        assert f"{first} 号与 {second} 号板凳接触" in page.text_content("#events")
        wait_until(page, "document.getElementById('achieved').textContent === '已暂停'")
        page.reload()
        wait_until(page, "globalThis.live?.frame != null && live.drawn > 0")
        assert page.text_content("#title") == "一次行进"
        page.click("#language")
        wait_until(page, "document.getElementById('achieved').textContent === 'Paused'")
        assert page.text_content("#title") == "A march"
        assert_replays(session)
