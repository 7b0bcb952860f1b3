"""The page of all lessons, in a real browser: wide, narrow, and on paper."""

from __future__ import annotations

import base64
import re

import pytest
from browser import needs_browser, opened, wait_until
from lesson_runs import played
from sharing import shared

from pymunk_dragon.lessons import LANGUAGES, LESSONS, write_lessons
from pymunk_dragon.lessons._framework import PARTS, export, make_notebook, make_page
from pymunk_dragon.lessons._framework.notes import notes

ALL = list(LESSONS.values())
UNFOLD = "document.querySelectorAll('details').forEach((details) => details.open = true)"


@pytest.fixture(scope="module")
def address():
    def write(path):
        path.write_text(make_page(list(map(played, LESSONS))), encoding="utf-8", newline="\n")

    return shared("lessons.html", write).as_uri()


@pytest.fixture
def seen(browser, address):
    with opened(browser, address, 1280, 900) as found:
        yield found


def longest(text):
    """The longest part of a text without a formula, of which a browser's text is another one; without spaces."""
    parts = ["".join(part.split()) for part in re.split(r"\$[^$]*\$", text.replace("`", ""))]
    return max(parts, key=len)


def test_page_is_written_with_progress_the_same_every_time_or_not_at_all(tmp_path, monkeypatch):
    told, page = [], tmp_path / "two.html"
    chosen = [LESSONS["spiral"], LESSONS["chain"]]
    write_lessons(chosen, page, progress=lambda *steps: told.append(steps))
    assert told == [(1, 2), (2, 2)]
    written = page.read_text(encoding="utf-8")
    assert written == make_page([played("spiral"), played("chain")])
    # One picture serves both languages.
    assert written.count(base64.b64encode(played("chain").picture).decode()) == 1

    def interrupted(lesson):
        raise KeyboardInterrupt

    monkeypatch.setattr(export, "record", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_lessons(chosen, page)
    assert [(file.name, file.read_text(encoding="utf-8")) for file in tmp_path.iterdir()] == [("two.html", written)]


@pytest.mark.thorough
@needs_browser
def test_page_is_no_wider_than_the_window_requests_nothing_and_shows_all_pictures(browser, address):
    for media, width in (("screen", 1280), ("screen", 390), ("print", 688)):
        for language in LANGUAGES:
            with opened(browser, f"{address}?{language}", width, 900, is_mobile=width < 600) as seen:
                seen.page.emulate_media(media=media)
                seen.page.evaluate(UNFOLD)
                assert seen.page.evaluate("[innerWidth, document.documentElement.scrollWidth]") == [width, width]
                wait_until(seen.page, "[...document.images].every((image) => image.complete && image.naturalWidth > 0)")
                assert seen.complaints == []
                requested = {url for url in seen.addresses if not url.startswith(("data:", "blob:"))}
                assert requested == {f"{address}?{language}"}


@pytest.mark.thorough
@needs_browser
def test_one_language_is_seen_and_heard_at_a_time_with_the_same_programs(seen):
    for language in LANGUAGES:
        seen.page.click(f".languages button[value={language}]")
        seen.page.evaluate(UNFOLD)
        text = "".join("".join(seen.page.locator("header, section").all_inner_texts()).split())
        for lesson in ALL:
            for part in PARTS[1:]:  # A program, which is English, has the title.
                shown = longest(lesson.in_language(language).text(part))
                others = {longest(lesson.in_language(each).text(part)) for each in LANGUAGES} - {shown}
                assert [each in text for each in (shown, *others)] == [True, *(False for _ in others)], lesson.name
            assert "".join(played(lesson.name).printed.split()) in text, lesson.name
            assert seen.page.locator(f"#{lesson.name} .code pre").inner_text().strip() == lesson.code
        commands = [
            each for each in seen.page.locator("code:visible").all_inner_texts() if "pymunk-dragon demo" in each
        ]
        option = "" if language == "en" else f" --lang {language}"
        assert set(commands) >= {f"pymunk-dragon demo {lesson.name}{option}" for lesson in ALL}
        images = "[...document.querySelectorAll('section figure > img:first-child')].map((image) => image.alt)"
        heard = [alt.replace("\u00a0", " ") for alt in seen.page.evaluate(images)]
        assert heard == [lesson.in_language(language).text("picture").replace("`", "") for lesson in ALL]
        found = notes(language)
        for each in [*(part for entry in found.glossary.values() for part in entry), *found.references.values()]:
            assert longest(each) in text
        assert seen.page.title() == seen.page.inner_text("h1")
    assert "$" not in "".join(seen.page.locator("section p, section li, section dd").all_inner_texts())
    assert seen.page.locator("#spiral .answer [lang=en] msqrt").count() == 3


@pytest.mark.thorough
@needs_browser
def test_address_names_the_language_and_the_lesson_and_remembers_the_choice(browser, address):
    with opened(browser, f"{address}?zh#chain") as seen:
        assert seen.page.evaluate("document.documentElement.lang") == "zh"
        assert abs(seen.page.evaluate("document.querySelector('#chain').getBoundingClientRect().top")) < 60
        seen.page.click(".languages button[value=en]")
        assert seen.page.url == f"{address}?en#chain"
        seen.page.reload()
        assert seen.page.evaluate("document.documentElement.lang") == "en"
        links = seen.page.evaluate("[...document.querySelectorAll('.contents a')].map((a) => a.getAttribute('href'))")
        assert links == [f"#{name}" for name in (*LESSONS, "glossary", "references")]
        assert all(seen.page.locator(link).count() == 1 for link in links)
        assert seen.complaints == []


@pytest.mark.thorough
@needs_browser
def test_answers_are_folded_and_films_begin_anew_when_they_are_unfolded(seen):
    assert not seen.page.locator("section figure").first.is_visible()
    assert not seen.page.locator("#spiral .answer p").first.is_visible()
    seen.page.click("#spiral .answer summary")
    assert longest(LESSONS["spiral"].text("answer")) in "".join(seen.page.inner_text("#spiral .answer").split())
    film = "document.querySelector('#sat .film')"
    assert not seen.page.evaluate(f"{film}.hasAttribute('src')")
    addresses = set()
    for _ in range(2):
        seen.page.click("#sat .run summary")
        wait_until(seen.page, f"{film}.complete && {film}.naturalWidth > 0")
        addresses.add(seen.page.evaluate(f"{film}.src"))
        seen.page.click("#sat .run summary")
        wait_until(seen.page, f"!{film}.hasAttribute('src')")
    # A new address each time: with the old one a browser would go on where it was.
    assert len(addresses) == 2
    assert seen.complaints == []


@pytest.mark.thorough
@needs_browser
def test_without_script_films_and_text_are_there_all_the_same(browser, address):
    with opened(browser, address, java_script_enabled=False) as seen:
        seen.page.click("#sat .run summary")
        film = seen.page.locator("#sat .film >> visible=true")
        assert film.get_attribute("src").startswith("data:image/gif;base64,")
        assert not seen.page.locator(".languages").is_visible()


@pytest.mark.thorough
@needs_browser
def test_programs_and_notebooks_can_be_taken_from_the_page(seen):
    for lesson in ALL:
        links = seen.page.locator(f"#{lesson.name} .files a")
        files = links.evaluate_all("(all) => all.map((a) => [a.download, a.lang, a.href])")
        content = {(name, lang): base64.b64decode(href.split(",", 1)[1]).decode() for name, lang, href in files}
        notebooks = {(f"{lesson.name}.ipynb", each): make_notebook(lesson.in_language(each)) for each in LANGUAGES}
        assert content == {(lesson.path.name, ""): lesson.source} | notebooks


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
def test_sheets_for_the_class_have_no_answers_and_those_for_the_teacher_do(seen):
    # What would be on paper when a button prints; a hidden button is clicked by the page itself.
    seen.page.evaluate(
        "window.print = () => { dispatchEvent(new Event('beforeprint'));"
        " window.paper = document.body.innerText; dispatchEvent(new Event('afterprint')); }"
    )
    for language, kind, one in (("en", "class", True), ("en", "teacher", False), ("zh", "class", False)):
        seen.page.click(f".languages button[value={language}]")
        seen.page.emulate_media(media="print")
        seen.page.evaluate(f"document.querySelector('{'#grid' if one else 'header'} .sheets [value={kind}]').click()")
        paper = "".join(seen.page.evaluate("window.paper").split())
        for lesson in (each.in_language(language) for each in ALL):
            printed = not one or lesson.name == "grid"
            for part in ("question", "answer", "check", "change"):
                mine = kind == ("class" if part == "question" else "teacher")
                assert (longest(lesson.text(part)) in paper) == (printed and mine), (lesson.name, part)
        # Afterwards the page is as it was.
        seen.page.emulate_media(media="screen")
        assert seen.page.locator("header").is_visible()
        assert seen.page.evaluate("document.querySelectorAll('details[open]').length") == 0
