"""The page of all lessons in a real browser: wide, narrow, dark and on paper."""

from __future__ import annotations

import base64
import re

import pytest
from browser import needs_browser, opened, wait_until
from lesson_runs import played

from pymunk_dragon.cli import main
from pymunk_dragon.lessons import LANGUAGES, LESSONS, write_lessons
from pymunk_dragon.lessons._framework import PARTS, export, make_notebook, make_page, page
from pymunk_dragon.lessons._framework.notes import notes

ALL = list(LESSONS.values())
FILMS = [name for name, lesson in LESSONS.items() if '.file(".gif")' in lesson.source]


def in_all_languages(name):
    """The recordings of a lesson."""
    return [played(name, each) for each in LANGUAGES]


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    file = tmp_path_factory.mktemp("lessons") / "lessons.html"
    file.write_text(make_page(list(map(in_all_languages, LESSONS))), encoding="utf-8", newline="\n")
    return file.as_uri()


@pytest.fixture
def width():
    return 1280


@pytest.fixture
def media():
    return "screen"


@pytest.fixture
def seen(browser, address, width, media):
    with opened(browser, address, width, 900, is_mobile=width < 600) as found:
        found.page.emulate_media(media=media)
        yield found


# Pixels; A4 without its margins is 688 pixels wide.
views = pytest.mark.parametrize(("media", "width"), [("screen", 1280), ("screen", 390), ("print", 688)])
UNFOLD = "document.querySelectorAll('details').forEach((details) => details.open = true)"


@pytest.fixture
def unfolded(seen, language):
    seen.page.click(f".languages button[value={language}]")
    seen.page.evaluate(UNFOLD)
    return seen


def longest(text):
    """The longest part of a text without a formula, of which a browser's text is another one; without spaces."""
    parts = ["".join(part.split()) for part in re.split(r"\$[^$]*\$", text.replace("`", ""))]
    return max(parts, key=len)


@pytest.mark.thorough
@needs_browser
@views
@pytest.mark.parametrize("language", LANGUAGES)
def test_page_is_no_wider_than_the_window_and_requests_nothing(browser, address, media, width, language):
    with opened(browser, f"{address}?{language}", width, 900, is_mobile=width < 600) as seen:
        seen.page.emulate_media(media=media)
        seen.page.evaluate(UNFOLD)
        assert seen.page.evaluate("[innerWidth, document.documentElement.scrollWidth]") == [width, width]
        assert seen.complaints == []
        assert {url for url in seen.addresses if not url.startswith(("data:", "blob:"))} == {f"{address}?{language}"}


@pytest.mark.thorough
@needs_browser
@pytest.mark.parametrize("language", LANGUAGES)
def test_one_language_is_seen_at_a_time(unfolded, language):
    text = "".join("".join(unfolded.page.locator("header, .text").all_inner_texts()).split())
    for lesson in (lesson.in_language(each) for lesson in ALL for each in LANGUAGES):
        for part in PARTS:
            assert (longest(lesson.text(part)) in text) == (lesson.language == language), (lesson.name, part)
    for lesson in ALL:
        assert "".join(played(lesson.name, language).printed.split()) in text
    codes = unfolded.page.locator("code:visible").all_inner_texts()
    commands = [each for each in codes if re.match("pymunk-dragon (demo|live) ", each)]
    expected = [f"pymunk-dragon demo {lesson.name}" for lesson in ALL]
    expected += [f"pymunk-dragon live {lesson.live}" for lesson in ALL if lesson.live]
    assert sorted(commands) == sorted(each + {"en": "", "zh": " --lang zh"}[language] for each in expected)
    assert unfolded.page.title() == unfolded.page.inner_text("h1")


@pytest.mark.thorough
@needs_browser
def test_address_may_name_the_language_and_the_lesson(browser, address):
    with opened(browser, f"{address}?zh#chain") as seen:
        assert seen.page.evaluate("document.documentElement.lang") == "zh"
        top = seen.page.evaluate("document.querySelector('#chain').getBoundingClientRect().top")
        assert abs(top) < 60


@pytest.mark.thorough
@needs_browser
def test_address_remembers_the_language_that_was_chosen(browser, address):
    with opened(browser, f"{address}?zh#chain") as seen:
        seen.page.click(".languages button[value=en]")
        assert seen.page.url == f"{address}?en#chain"
        seen.page.reload()
        assert seen.page.evaluate("document.documentElement.lang") == "en"
        assert seen.complaints == []


@pytest.mark.thorough
@needs_browser
@pytest.mark.parametrize("language", LANGUAGES)
def test_screen_readers_get_one_language(seen, language):
    """What stands for a picture is in the language that is read; the buttons say in which their names are."""
    seen.page.click(f".languages button[value={language}]")
    images = f"[...document.querySelectorAll('section :is([lang={language}], div:not([lang])) > img:first-child')]"
    heard = seen.page.evaluate(f"{images}.map((image) => image.alt)")
    # Behind a number stands a space at which no line ends.
    assert [alt.replace("\u00a0", " ") for alt in heard] == [
        lesson.in_language(language).text("picture").replace("`", "") for lesson in ALL
    ]
    assert seen.page.evaluate("[...document.querySelectorAll('.languages button')].map((button) => button.lang)") == [
        *LANGUAGES
    ]


@pytest.mark.thorough
@needs_browser
def test_contents_lead_to_every_lesson(seen):
    links = seen.page.evaluate("[...document.querySelectorAll('.contents a')].map((a) => a.getAttribute('href'))")
    assert links == [f"#{name}" for name in (*LESSONS, "glossary", "references")]
    for link in links:
        assert seen.page.locator(link).count() == 1


@pytest.mark.thorough
@needs_browser
def test_answers_and_pictures_are_folded_at_first(seen):
    assert not seen.page.locator("section figure").first.is_visible()
    assert not seen.page.get_by_text(LESSONS["spiral"].text("answer").split("`")[0][:40]).first.is_visible()
    seen.page.click("#spiral .run summary")
    assert seen.page.locator("#spiral figure").is_visible()
    assert (
        seen.page.locator("#spiral .printed >> visible=true").inner_text().strip() == played("spiral").printed.strip()
    )
    seen.page.click("#spiral .answer summary")
    assert longest(LESSONS["spiral"].text("answer")) in "".join(seen.page.inner_text("#spiral .answer").split())


@pytest.mark.thorough
@needs_browser
@pytest.mark.parametrize("name", FILMS)
def test_film_plays_on_demand_and_from_its_beginning(seen, name):
    film = f"document.querySelector('#{name} .film')"
    assert not seen.page.evaluate(f"{film}.hasAttribute('src')")
    addresses = set()
    for _ in range(2):
        seen.page.click(f"#{name} .run summary")
        wait_until(seen.page, f"{film}.complete && {film}.naturalWidth > 0")
        addresses.add(seen.page.evaluate(f"{film}.src"))
        seen.page.click(f"#{name} .run summary")
        wait_until(seen.page, f"!{film}.hasAttribute('src')")
    # A new address each time: with the old one a browser would go on where it was.
    assert len(addresses) == 2
    assert seen.complaints == []


@pytest.mark.thorough
@needs_browser
def test_all_pictures_can_be_seen(seen):
    seen.page.evaluate(UNFOLD)
    wait_until(seen.page, "[...document.images].every((image) => image.complete && image.naturalWidth > 0)")
    assert seen.page.evaluate("[...document.querySelectorAll('section figure')].length") == len(LESSONS)


@pytest.mark.thorough
@needs_browser
def test_paper_shows_everything_and_the_end_of_films(seen):
    seen.page.emulate_media(media="print")
    seen.page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert seen.page.locator(".answer p").first.is_visible()
    for name in FILMS:
        assert seen.page.locator(f"#{name} .last-frame >> visible=true").count() == 1
        assert seen.page.locator(f"#{name} .film >> visible=true").count() == 0
    seen.page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert seen.page.evaluate("document.querySelectorAll('details[open]').length") == 0


@pytest.mark.thorough
@needs_browser
def test_without_script_films_and_text_are_there_all_the_same(browser, address):
    with opened(browser, address, java_script_enabled=False) as seen:
        seen.page.click(f"#{FILMS[0]} .run summary")
        film = seen.page.locator(f"#{FILMS[0]} .film >> visible=true")
        assert film.count() == 1
        assert film.get_attribute("src").startswith("data:image/gif;base64,")
        assert not seen.page.locator(".languages").is_visible()


@pytest.mark.thorough
@needs_browser
def test_programs_and_notebooks_can_be_taken_from_the_page(seen):
    for lesson in ALL:
        links = seen.page.locator(f"#{lesson.name} .files a")
        files = dict(links.evaluate_all("(all) => all.map((a) => [a.download + '|' + (a.lang || ''), a.href])"))
        content = {name: base64.b64decode(href.split(",", 1)[1]).decode() for name, href in files.items()}
        expected = {}
        for each in map(lesson.in_language, LANGUAGES):
            expected[f"{each.path.name}|{each.language}"] = each.source
            expected[f"{each.name}.ipynb|{each.language}"] = make_notebook(each)
        assert content == expected


@pytest.mark.thorough
@needs_browser
def test_page_shows_the_code_as_it_stands(browser, address):
    with opened(browser, address) as seen:
        assert seen.page.locator(".code pre >> visible=true").count() == 0
        seen.page.evaluate(UNFOLD)
        for lesson in ALL:
            assert seen.page.locator(f"#{lesson.name} .code pre >> visible=true").inner_text().strip() == lesson.code


@pytest.mark.thorough
@needs_browser
def test_guess_is_checked_with_the_keyboard_alone(seen):
    [guess] = LESSONS["spiral"].guesses
    verdict, choices = seen.page.locator("#spiral .verdict"), seen.page.locator("#spiral .guesses input")
    choices.first.focus()
    for right in (False, True, False):
        seen.page.keyboard.press("Space")
        assert not verdict.is_visible()
        seen.page.keyboard.press("Enter")
        words = "Right." if right else "The run shows otherwise."
        assert verdict.inner_text().split() == f"{words} {guess.result()}".split()
        seen.page.keyboard.press("ArrowDown")
    seen.page.reload()
    seen.page.click("#chain .guesses button")  # Without a choice there is no verdict.
    assert not seen.page.locator("#chain .verdict").first.is_visible()
    assert seen.complaints == []


@pytest.mark.thorough
@needs_browser
@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("one", [False, True])
@pytest.mark.parametrize("kind", ["class", "teacher"])
def test_sheets_for_the_class_have_no_answers_and_those_for_the_teacher_do(seen, kind, one, language):
    seen.page.click(f".languages button[value={language}]")
    seen.page.emulate_media(media="print")
    # What would be on paper when a button prints; a hidden button is clicked by the page itself.
    seen.page.evaluate(
        "window.print = () => { dispatchEvent(new Event('beforeprint'));"
        " window.paper = document.body.innerText; dispatchEvent(new Event('afterprint')); }"
    )
    seen.page.evaluate(f"document.querySelector('{'#grid' if one else 'header'} .sheets [value={kind}]').click()")
    paper = "".join(seen.page.evaluate("window.paper").split())
    for lesson in (each.in_language(language) for each in ALL):
        printed = not one or lesson.name == "grid"
        result, *_ = lesson.guesses
        assert (longest(lesson.text("question")) in paper) == (printed and kind == "class")
        assert (longest(lesson.code[:200]) in paper) == (printed and kind == "class")
        for part in ("picture", "answer", "check", "change"):
            assert (longest(lesson.text(part)) in paper) == (printed and kind == "teacher")
        assert (longest(result.result()) in paper) == (printed and kind == "teacher")
        assert (longest(notes(language).lessons[lesson.name].needs) in paper) == (printed and kind == "teacher")
    assert longest(notes(language).references["pymunk"]) not in paper
    # Afterwards the page is as it was.
    seen.page.emulate_media(media="screen")
    assert seen.page.locator("header").is_visible()
    assert seen.page.evaluate("document.querySelectorAll('details[open]').length") == 0


@pytest.mark.thorough
@needs_browser
def test_formulas_are_mathml_and_none_is_left_as_latex(seen):
    seen.page.evaluate(UNFOLD)
    assert "$" not in "".join(seen.page.locator("section p, section li, section dd").all_inner_texts())
    assert seen.page.locator("#spiral .answer [lang=en] msqrt").count() == 3


# Lines that begin with a stop, as the last words before it; and options of commands that are on two lines.
BAD_BREAKS = """() => {
  const found = [];
  const texts = document.createTreeWalker(document.querySelector("main"), NodeFilter.SHOW_TEXT);
  const range = document.createRange();
  for (let text = texts.nextNode(); text; text = texts.nextNode()) {
    const block = text.parentElement.closest("p, li, dd, legend, label");
    if (!block || !text.parentElement.checkVisibility()) continue;
    for (const { 0: stop, index } of text.data.matchAll(/[.,:;)。，：；、）](?=\\s|$|\\p{Script=Han})|--(?=lang)/gu)) {
      const box = (at) => {
        range.setStart(text, at);
        range.setEnd(text, at + 1);
        return range.getBoundingClientRect();
      };
      const edge = block.getBoundingClientRect().left + parseFloat(getComputedStyle(block).paddingLeft);
      const isBad = stop === "--" ? box(index).top !== box(index + 2).top : Math.abs(box(index).left - edge) < 1;
      if (isBad) found.push(block.textContent.trim().slice(-40));
    }
  }
  return found;
}"""


@pytest.mark.thorough
@needs_browser
@pytest.mark.parametrize("language", LANGUAGES)
def test_no_line_begins_with_a_stop_and_no_option_is_cut(unfolded, language):
    for width in range(320, 900, 20):
        unfolded.page.set_viewport_size({"width": width, "height": 900})
        assert unfolded.page.evaluate(BAD_BREAKS) == [], width


@pytest.mark.thorough
@needs_browser
@pytest.mark.parametrize("language", LANGUAGES)
def test_page_ends_with_glossary_and_references(seen, language):
    seen.page.click(f".languages button[value={language}]")
    text = "".join("".join(seen.page.locator("#glossary, #references").all_inner_texts()).split())
    found = notes(language)
    for each in [*(part for entry in found.glossary.values() for part in entry), *found.references.values()]:
        assert longest(each) in text


@pytest.mark.thorough
@needs_browser
@pytest.mark.parametrize("language", LANGUAGES)
def test_figures_are_in_the_language_of_the_page(unfolded, language):
    picture = unfolded.page.locator("#spiral figure img >> visible=true")
    assert picture.count() == 1
    found = base64.b64decode(picture.get_attribute("src").partition(",")[2])
    assert found == played("spiral", language).picture


def test_film_at_the_top_of_the_page_is_small_and_the_same_every_time():
    film = page._dragon("en")
    assert len(film) < 1_500_000
    page._dragon.cache_clear()
    assert page._dragon("en") == film


def test_page_is_written_with_progress_and_the_same_every_time(tmp_path):
    told = []
    write_lessons(
        [LESSONS["spiral"], LESSONS["chain"]], tmp_path / "two.html", progress=lambda *steps: told.append(steps)
    )
    assert told == [(1, 2), (2, 2)]
    assert (tmp_path / "two.html").read_text(encoding="utf-8") == make_page(
        [*map(in_all_languages, ("spiral", "chain"))]
    )


def test_interrupted_page_leaves_the_old_one(tmp_path, monkeypatch):
    def interrupted(lesson):
        raise KeyboardInterrupt

    monkeypatch.setattr(export, "record", interrupted)
    (tmp_path / "lessons.html").write_text("old")
    with pytest.raises(SystemExit) as stopped:
        main(["demo", "-o", str(tmp_path / "lessons.html")])
    assert stopped.value.code == 130
    assert [(file.name, file.read_text()) for file in tmp_path.iterdir()] == [("lessons.html", "old")]
