"""The page of all lessons, in a real browser: wide, narrow, and on paper."""

from __future__ import annotations

import base64
import re
from itertools import product

import pytest
from browser import framed, needs_browser, opened, wait_until
from lesson_runs import played
from sharing import shared

from pymunk_dragon.lessons import LESSONS
from pymunk_dragon.lessons._framework.lesson import blocks
from pymunk_dragon.lessons._framework.notebook import make_notebook
from pymunk_dragon.lessons._framework.page import make_page
from pymunk_dragon.sessions.live import Live
from pymunk_dragon.sessions.scenes import add, named_scene
from pymunk_dragon.sessions.session import Session

pytestmark = [pytest.mark.thorough, needs_browser]
ALL = list(LESSONS.values())
LANGUAGES = ("en", "zh")
UNFOLD = """for (const lesson of document.querySelectorAll('.lesson')) {
  lesson.querySelector('.cover .open-unguessed').click();
  lesson.querySelector('.show').click();
  lesson.querySelector('details').open = true;
}"""


@pytest.fixture(scope="module")
def address():
    def write(path):
        path.write_text(make_page(list(map(played, LESSONS))), encoding="utf-8", newline="\n")

    return shared("lessons.html", write).as_uri()


@pytest.fixture
def seen(browser, address):
    with opened(browser, address, 1280, 900) as found:
        yield found
        assert found.complaints == []


def longest(text):
    """The longest part of a text without a formula or bold letters, without spaces."""
    return max(
        ("".join(part.split()) for part in re.split(r"\$[^$]*\$|\*\*", text.replace("`", ""))),
        key=len,
    )


def texts(lesson, section, language):
    """What identifies the paragraphs and items of a section."""
    found = blocks(lesson.sections(language)[section])
    lines = [longest(line.split(": ")[-1]) for text, items in found for line in (text, *items)]
    return [line for line in lines if len(line) > 3]


def shown(seen, selector="body"):
    """The visible text of a part of the page, without spaces."""
    return "".join("".join(seen.page.locator(selector).all_inner_texts()).split())


def test_page_is_small_no_wider_than_the_window_requests_nothing_and_shows_all_pictures(
    browser, address
):
    for media, width, language in (
        ("screen", 390, "zh"),
        ("print", 688, "en"),
    ):
        own = f"{address}?{language}"
        with opened(browser, own, width, 900, is_mobile=width < 600) as seen:
            assert len(seen.page.content()) < 6_000_000
            seen.page.evaluate(UNFOLD)
            seen.page.emulate_media(media=media)
            widths = seen.page.evaluate("[innerWidth, document.documentElement.scrollWidth]")
            assert widths == [width, width]
            loaded = "(image) => image.complete && image.naturalWidth > 0"
            wait_until(seen.page, f"[...document.images].every({loaded})")
            assert seen.complaints == []
            assert {url for url in seen.addresses if not url.startswith("data:")} == {own}


def test_one_language_is_seen_at_a_time_with_the_same_programs(seen):
    seen.page.evaluate(UNFOLD)
    for language, other in (("en", "zh"), ("zh", "en")):
        seen.page.click(f".languages button[value={language}]")
        text = shown(seen)
        for lesson in ALL:
            for section in ("Question", "Answer", "Check", "Try", "Change"):
                assert all(each in text for each in texts(lesson, section, language)), (
                    lesson.name,
                    section,
                )
                # A translation is never a condition.
                if lesson.sections(other)[section] != lesson.sections(language)[section]:
                    assert longest(lesson.sections(other)[section]) not in text
            assert "".join(played(lesson.name).printed.split()) in text, lesson.name
        option = "" if language == "en" else " --lang zh"
        assert f"pymunk-dragon demo robot{option}" in seen.page.inner_text("#robot .files")
        assert seen.page.title() == seen.page.inner_text("h1")
    assert "$" not in "".join(seen.page.locator("section p, section li").all_inner_texts())
    assert seen.page.locator("#spiral .answer [lang=en] msqrt").count() == 3


def test_address_names_the_language_and_the_lesson_and_remembers_the_choice(browser, address):
    with opened(browser, f"{address}?zh#chain") as seen:
        assert seen.page.evaluate("document.documentElement.lang") == "zh"
        assert (
            abs(seen.page.evaluate("document.querySelector('#chain').getBoundingClientRect().top"))
            < 60
        )
        seen.page.click(".languages button[value=en]")
        assert seen.page.url == f"{address}?en#chain"
        seen.page.reload()
        assert seen.page.evaluate("document.documentElement.lang") == "en"
        links = seen.page.evaluate(
            "[...document.querySelectorAll('.contents a')].map((a) => a.getAttribute('href'))"
        )
        assert links == [f"#{name}" for name in (*LESSONS, "glossary")]
        assert all(seen.page.locator(link).count() == 1 for link in links)


def test_nothing_of_the_answer_is_seen_before_the_experiment_is_opened(seen):
    text = shown(seen)
    for lesson in ALL:
        assert all(each in text for each in texts(lesson, "Question", "en"))
        for section in ("Answer", "Check", "Try", "Change", "Teacher"):
            asked = [longest(guess.text) for guess in lesson.guesses()]
            assert not any(
                each in text for each in texts(lesson, section, "en") if each not in asked
            ), lesson.name
        assert (
            not seen.page.locator(f"#{lesson.name} :is(pre, img, canvas)")
            .locator("visible=true")
            .count()
        )


def test_course_with_the_keyboard_guess_experiment_answer_and_again(seen):
    lesson = seen.page.locator("#spiral")
    opens, answer = lesson.locator(".cover .main"), lesson.locator(".answer")
    opens.focus()
    seen.page.keyboard.press("Enter")
    assert lesson.get_attribute("data-state") == "guess"  # Without a choice it does not open.
    lesson.locator("input").first.focus()
    seen.page.keyboard.press("Space")
    opens.focus()
    seen.page.keyboard.press("Enter")
    assert lesson.get_attribute("data-state") == "open"
    assert lesson.locator("input[name^=spiral]").first.is_disabled()
    assert lesson.locator("canvas").is_visible()
    assert not answer.is_visible()
    lesson.locator(".show").press("Enter")
    [guess] = LESSONS["spiral"].guesses()
    sides = lesson.locator(".sides").inner_text().replace("\u00a0", " ").split("\n")
    assert " ".join(" ".join(sides).split()) == "Your guess: Still 55 s Result: About 17 s"
    assert lesson.locator("li.chosen").inner_text().replace("\u00a0", " ") == guess.items[0]
    assert lesson.locator("li.right").count() == 1
    lesson.locator(".again").press("Enter")
    assert lesson.get_attribute("data-state") == "guess"
    assert not lesson.locator("input[name^=spiral]:checked").count()
    lesson.locator(".cover .open-unguessed").press("Enter")
    assert lesson.get_attribute("data-state") == "open"
    assert lesson.locator("canvas").count() == 1


def test_key_that_opens_an_experiment_presses_no_button_of_it(seen):
    lesson = seen.page.locator("#engine")
    lesson.locator("input").first.press("Space")
    lesson.locator("input").first.press("Enter")
    settle(seen.page)
    assert lesson.locator(".actions button").first.inner_text() == "Let the force act in the middle"


# What a learner does on a stage, "play" or new values of sliders and dragged things, and the words
# that then tell the outcome of the guess. Where an engine plays, see the test on a live server.
OUTCOMES = {
    "spiral": (["play"], r"a round in 1[0-7]\.\d s"),
    "chain": (["play"], "on the circle: 22"),
    "velocity": (["play"], r" 3\.5\d\d mm/s slower"),
    "sat": ([{"walls": 4}], "of 4, up to"),
    "grid": (["play"], "546 of 24531 pairs"),
    "near-miss": (["play"], "overlaps bench 8"),
    "missed-window": (["play"], "Missed: bench 11"),
    "unguided": (["play"], "Benches 162 and 206 touch"),
    "engine": (["play", {"step": 1}, "play"], r"0\.[45]\d of the error"),
    "pitch": (["play"], "meets bench 19"),
    "u-turn": (["play"], r"= 13\.62 m, yours .* = 13\.62 m"),
    "speed-limit": (["play"], "In the whole turn: .* handle [3-7]"),
    "robot": (["play"], "Link 0 runs into link 13"),
}
# Seconds of the stage's own time until its readout has words.
SECONDS = """([name, actions, words]) => {
  const lab = openStage(document.querySelector(`#${name} .stage`));
  let seconds = 0;
  lab.tick(0);
  const said = () => new RegExp(words).test(lab.readout()[0]);
  for (const action of actions) {
    if (action !== "play") {
      for (const [thing, value] of Object.entries(action)) lab.kept.things.get(thing).set(value);
      lab.update?.();
      continue;
    }
    const row = lab.rows.find(({ play }) => play);
    row.button.click();
    for (; row.plays && !said(); seconds += 0.05) {
      lab.play(0.05);
      lab.update?.();
    }
  }
  return [said(), seconds];
}"""


def test_outcome_of_each_guess_is_seen_within_20_seconds_of_play(seen):
    played_by_an_engine = {name for name, each in LESSONS.items() if each.builds_scene}
    assert set(OUTCOMES) == set(LESSONS) - played_by_an_engine
    for name, (actions, words) in OUTCOMES.items():
        done, seconds = seen.page.evaluate(SECONDS, [name, actions, words])
        assert done, name
        assert seconds <= 20, name


WINDOWS = ((1280, 800), (390, 844))
# Sides of an open experiment, of which the canvas or the recorded run, what it says, and controls
# are parts.
SIDES = """(stage) => {
  const { left, top, right, bottom } = stage.getBoundingClientRect();
  return [left, top, innerWidth - right, innerHeight - bottom];
}"""
# Lessons with something of the page over their stage, wherever the page is scrolled to.
COVERED = """() => [...document.querySelectorAll(".lesson")].filter((lesson) => {
  const top = lesson.getBoundingClientRect().top + scrollY;
  const rests = [...document.querySelectorAll(":is(.sheets, .code)")];
  for (let y = top - innerHeight; y < top + lesson.offsetHeight; y += 50) {
    scrollTo(0, y);
    const stage = lesson.querySelector(".pinned").getBoundingClientRect();
    for (const rest of rests.filter((each) => each.checkVisibility())) {
      const box = rest.getBoundingClientRect();
      const apart = box.top >= stage.bottom || box.bottom <= stage.top;
      if (!apart && box.left < stage.right && box.right > stage.left) return true;
    }
  }
  return false;
}).map(({ id }) => id)"""


def test_all_of_a_stage_is_in_the_window_and_nothing_lies_over_it(browser, address):
    for width, height in (*WINDOWS, (1024, 768), (1366, 768)):
        with opened(browser, address, width, height, is_mobile=width < 600) as seen:
            assert seen.page.evaluate(COVERED) == []
            for lesson in ALL if (width, height) in WINDOWS else ALL[::4]:
                seen.page.evaluate(
                    f"document.querySelector('#{lesson.name} .open-unguessed').click()"
                )
                settle(seen.page)
                sides = seen.page.locator(f"#{lesson.name} .stage").evaluate(SIDES)
                assert min(sides) >= 0, (lesson.name, width, sides)
            assert seen.page.evaluate(COVERED) == []


def settle(page):
    """Wait for two pictures."""
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def test_guess_and_course_outlast_a_reload_and_the_address_opens_a_stage(seen):
    lesson, other = seen.page.locator("#grid"), seen.page.locator("#near-miss")
    lesson.locator("input").nth(1).check()
    lesson.locator(".cover .open").click()
    other.locator("input").nth(2).check()
    seen.page.reload()
    assert lesson.get_attribute("data-state") == "open"
    assert lesson.locator("input").nth(1).is_checked()
    assert lesson.locator("input").nth(1).is_disabled()
    assert other.get_attribute("data-state") == "guess"
    assert other.locator("input").nth(2).is_checked()
    lesson.locator(".show").click()
    lesson.locator("summary").click()
    settle(seen.page)
    seen.page.reload()
    assert lesson.get_attribute("data-state") == "answered"
    assert lesson.locator("details[open]").count() == 1
    assert "About 500" in lesson.locator(".mine").inner_text().replace("\u00a0", " ")
    seen.page.evaluate("location.hash = '#near-miss&time=409.85'")
    wait_until(seen.page, "document.querySelector('#near-miss canvas')")
    settle(seen.page)
    assert "409.85" in other.locator(".readout").inner_text()
    assert other.locator(".stage").evaluate(SIDES)[1] >= 0


def test_stage_in_the_address_is_in_sight_after_a_reload_however_long_the_page_was(
    browser, address
):
    with opened(browser, address, 390, 844, is_mobile=True) as seen:
        seen.page.evaluate(UNFOLD.replace(".lesson", "#velocity"))
        seen.page.click("#sat .open-unguessed")
        seen.page.locator("#sat .slider input").press("ArrowRight")
        wait_until(seen.page, "location.hash === '#sat&walls=2'")
        seen.page.reload()
        settle(seen.page)
        assert min(seen.page.locator("#sat .stage").evaluate(SIDES)) >= 0


def test_list_has_a_picture_of_each_stage_which_moves_while_it_has_the_focus(browser, address):
    with opened(browser, address, 1280, 2000) as seen:
        count = f"document.querySelectorAll('.card canvas').length === {len(ALL)}"
        wait_until(seen.page, count)
        settle(seen.page)
        picture = "document.querySelector('.card[href=\"#spiral\"] canvas').toDataURL()"
        still = seen.page.evaluate(picture)
        seen.page.focus(".card[href='#spiral']")
        wait_until(seen.page, f"{picture} !== {still!r}")
        seen.page.focus(".card[href='#chain']")
        wait_until(seen.page, f"{picture} === {still!r}")
        assert seen.page.get_by_role("img", name=re.compile("A bench dragon: a head")).is_visible()
        assert seen.page.url == address
        assert seen.complaints == []


def test_films_that_repeat_can_be_paused_with_the_keyboard(browser, address):
    for calm in (False, True):
        motion = "reduce" if calm else "no-preference"
        with opened(browser, address, reduced_motion=motion) as seen:
            seen.page.evaluate(UNFOLD.replace(".lesson", "#unguided"))
            film = seen.page.locator("#unguided details")
            assert film.locator("img").count() == (not calm)
            film.locator(".pause").press("Enter")
            assert film.locator("img").count() == calm
            assert film.get_by_role("img", name="What the program draws").is_visible()
            film.locator(".pause").press("Enter")
            assert film.locator("img").count() == (not calm)


@pytest.mark.parametrize("how", ["src", "srcdoc"])
def test_course_language_and_links_work_in_a_frame_that_allows_scripts_only(browser, how):
    page = make_page([played("spiral"), played("tension")])
    with framed(browser, page, how) as (_, frame):
        frame.click(".languages button[value=zh]")
        assert frame.evaluate("document.documentElement.lang") == "zh"
        frame.click(".languages button[value=en]")
        for name, opens in (("spiral", ".open"), ("tension", ".open-unguessed")):
            lesson = frame.locator(f"#{name}")
            frame.click(f".contents a[href='#{name}']")
            assert (
                abs(
                    frame.evaluate(f"document.querySelector('#{name}').getBoundingClientRect().top")
                )
                < 60
            )
            lesson.locator("input").first.check()
            lesson.locator(opens).click()
            lesson.locator(".stage :is(canvas, img)").wait_for()
            lesson.locator(".show").click()
            assert lesson.locator(".answer").is_visible()
            lesson.locator(".code summary").click()
            lesson.locator(".again").click()
            assert not lesson.locator("input:checked").count()
        lesson = frame.locator("#spiral")
        lesson.locator("input").first.press("Space")
        lesson.locator("input").first.press("Enter")
        assert lesson.get_attribute("data-state") == "open"
        # It cannot print, and says so.
        assert not frame.locator(".sheets button").locator("visible=true").count()
        assert frame.locator(".elsewhere").is_visible()


def test_lesson_of_the_engine_shows_its_film_or_how_it_begins_and_how_to_play_it_live(seen):
    # The chart that the program of the other one draws is the answer.
    for name, picture in (("callbacks", "img"), ("tension", "canvas")):
        lesson = seen.page.locator(f"#{name}")
        lesson.locator(".cover .open-unguessed").click()
        lesson.locator(f".stage[data-scene] {picture}").wait_for()
        assert lesson.locator(".stage :is(img, canvas)").count() == 1
        assert "pymunk-dragon demo --live" in lesson.locator(".stage").inner_text()


def test_without_script_all_texts_are_there(browser, address):
    with opened(browser, address, java_script_enabled=False) as seen:
        assert longest(LESSONS["spiral"].sections()["Check"]) in shown(seen)
        assert not seen.page.locator(".cover, .languages, .sides").locator("visible=true").count()


def test_programs_and_notebooks_can_be_taken_from_the_page(seen):
    for lesson in ALL:
        links = seen.page.locator(f"#{lesson.name} .files a")
        files = links.evaluate_all("(all) => all.map((a) => [a.download, a.lang, a.href])")
        content = {
            (name, lang): base64.b64decode(href.split(",", 1)[1]).decode()
            for name, lang, href in files
        }
        notebooks = {
            (f"{lesson.name}.ipynb", each): make_notebook(lesson, each) for each in LANGUAGES
        }
        assert content == {(lesson.path.name, ""): lesson.source} | notebooks


def test_sheets_for_the_class_have_no_answers_and_those_for_the_teacher_do(seen):
    # What would be on paper when a button prints; a hidden button is clicked by the page itself.
    seen.page.evaluate("window.print = () => { window.paper = document.body.innerText; }")
    for language, kind, one in (
        ("zh", "class", False),
        ("en", "teacher", False),
        ("en", "class", True),
    ):
        seen.page.click(f".languages button[value={language}]")
        seen.page.emulate_media(media="print")
        place = "#grid" if one else "header"
        seen.page.evaluate(f"document.querySelector('{place} .sheets [value={kind}]').click()")
        paper = "".join(seen.page.evaluate("window.paper").split())
        for lesson in ALL:
            printed = not one or lesson.name == "grid"
            for section in ("Question", "Try", "Check", "Teacher"):
                mine = kind == ("class" if section in ("Question", "Try") else "teacher")
                for text in texts(lesson, section, language):
                    assert (text in paper) == (printed and mine), (lesson.name, section)
        assert "importnumpy" not in paper
        seen.page.emulate_media(media="screen")
    seen.page.emulate_media(media="print")
    seen.page.evaluate("document.documentElement.dataset.print = 'class'")
    for size in ("A4", "Letter"):
        assert len(re.findall(rb"/Type /Page\b", seen.page.pdf(format=size))) == len(ALL), (
            "a sheet is two pages long"
        )


def test_experiments_with_pymunk_are_live_on_a_live_server(browser):
    page = make_page([played("callbacks"), played("tension")], site=True)
    for name in ("callbacks", "tension"):
        add(**LESSONS[name].scene())
    session = Session(named_scene("unguided"))
    with (
        Live(session, host="127.0.0.1", port=0, front=page) as running,
        opened(browser, f"{running.address}&zh") as seen,
    ):
        # The bench waits until it is thrown; then the calls of the contact are listed.
        seen.page.click("#callbacks .open-unguessed")
        wait_until(seen.page, "playedNow?.frame?.step === 0 && !playedNow.note")
        assert not seen.page.locator("#callbacks figure").count()
        # What rests follows the hand.
        seen.page.press("#callbacks .knob", "ArrowLeft")
        wait_until(seen.page, "playedNow.running && playedNow.frame.step > 0")
        seen.page.click("#callbacks .actions button >> nth=0")
        wait_until(seen.page, "playedNow.frame.step > 50")
        assert "separate" in seen.page.inner_text("#callbacks .readout")

        # The stage that is opened next has the engine, with the force of the drag on all benches.
        seen.page.click("#tension .open-unguessed")
        wait_until(seen.page, "playedNow.name === 'tension' && playedNow.frame?.step === 0")
        assert not re.search("[0-9.]+\\sN", seen.page.inner_text("#tension .readout"))
        seen.page.click("#tension .actions button >> nth=0")
        first = "Math.abs(playedNow.frame.joints[4] - {}) < 0.5"
        wait_until(seen.page, first.format(165.8))
        # A pull of 10 N with each key.
        seen.page.press("#tension .knob", "ArrowLeft")
        seen.page.press("#tension .knob", "ArrowLeft")
        wait_until(seen.page, first.format(165.8 + 20))
        # On ice nothing else is to be carried; behind a cut, not even this.
        seen.page.click("#tension .actions button >> nth=1")
        wait_until(seen.page, first.format(20))
        seen.page.click("#tension .actions button >> nth=2")
        wait_until(seen.page, f"playedNow.frame.joints.length === 23 * 6 && {first.format(0)}")

        # A button of the other stage begins anew there.
        seen.page.click("#callbacks .actions button >> nth=0")
        wait_until(seen.page, "playedNow.name === 'callbacks' && !playedNow.note")
        # All of a stage is in the window here too.
        for (width, height), name in product(WINDOWS, ("callbacks", "tension")):
            seen.page.set_viewport_size({"width": width, "height": height})
            stage = seen.page.locator(f"#{name} .pinned")
            stage.evaluate("(pinned) => pinned.scrollIntoView()")
            settle(seen.page)
            assert min(stage.locator(".stage").evaluate(SIDES)) >= 0, (name, width)

        # The live page by itself has a link to the lesson.
        seen.page.goto(running.address.replace("/?", "/live?"))
        seen.page.click("#lesson")
        seen.page.wait_for_url(f"{running.address}#callbacks")
        assert seen.complaints == []
