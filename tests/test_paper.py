"""All five answers as one page: whole, in both languages, with the numbers of the studies."""

import json
import re
from dataclasses import replace

import pytest
from browser import needs_browser, opened
from study_answers import answer as shared_answer
from test_report import elements_of

from pymunk_dragon import Dragon, March, first_contact, max_speed, min_pitch, u_turn
from pymunk_dragon._language import in_language
from pymunk_dragon.reports import paper as pages
from pymunk_dragon.studies import STUDIES, Paper, Sensitivity, paper

SIZES = ("width", "overhang", "head_spacing", "body_spacing")
SLOPES = dict.fromkeys(SIZES, 0.25)


@pytest.fixture(scope="module")
def found():
    """All answers, with invented sensitivities, which take long."""
    march = March()
    smallest = shared_answer("min-pitch", min_pitch)
    return Paper(
        march=march,
        states=march.at([0.0, 300.0]),
        sensitivity=Sensitivity(
            contact=first_contact(march), smallest=smallest, times=SLOPES, pitches=SLOPES
        ),
        turn=u_turn(search=False),
        fastest=max_speed(),
        last_slopes=SLOPES,
        speed_slopes=SLOPES,
    )


@pytest.fixture
def without_figures(monkeypatch):
    """Pages with empty pictures in place of figures, which take long to draw."""
    names = ("spiral", "gap", "contact", "min-pitch", "u-turn", "max-speed")
    monkeypatch.setattr(pages, "_figures", lambda found: dict.fromkeys(names, "data:,"))


def test_page_is_whole_in_both_languages_with_the_same_formulas_and_numbers(
    found, without_figures, tmp_path
):
    seen = []
    for language in ("en", "zh"):
        with in_language(language):
            pages.write_paper(found, tmp_path / "answers.html")
        page = (tmp_path / "answers.html").read_text(encoding="utf-8")
        elements = elements_of(re.sub("<style>.*?</style>", "", page, flags=re.DOTALL))
        tags = [each.tag.rpartition("}")[2] for each in elements]
        assert "script" not in tags
        addresses = [each.get("src") or each.get("href") for each in elements]
        assert {address for address in addresses if address} == {"data:,"}
        text = " ".join(elements[0].itertext())
        assert len(re.findall("[\u4e00-\u9fff]", text)) > (1000 if language == "zh" else -1)
        # No mark of a formula, and no command of LaTeX is left.
        assert "$" not in text
        assert "\\" not in text
        blocks = [each for each in elements if each.get("display") == "block"]
        seen.append([len(blocks), sorted(re.findall(r"\d+\.\d+", text))])
    assert seen[0] == seen[1]
    assert seen[0][0] > 15
    numbers = set(seen[0][1])
    assert f"{found.contact.time:.9f}" in numbers
    assert f"{found.smallest.pitch:.12f}" in numbers
    assert f"{found.turn.turn.length:.6f}" in numbers
    assert f"{found.fastest.speed:.10f}" in numbers
    assert f"{found.states.speeds[-1, 223]:.6f}" in numbers


def test_errors_are_those_of_the_studies(found):
    holes, overlap, pitch, length, speed = found.errors
    assert 0 < holes < 1e-12
    assert overlap == found.contact.resolution
    assert pitch == pytest.approx(1e-9, rel=1e-4)
    assert 0 < length < 1e-14
    assert speed == pytest.approx(1.25e-11, rel=0.01)


def test_the_program_writes_the_page_and_values(
    call, found, without_figures, monkeypatch, tmp_path
):
    known = replace(STUDIES["paper"], run=lambda dragon, progress: found)
    monkeypatch.setitem(STUDIES, "paper", known)
    file = tmp_path / "answers.html"
    assert call("study", "paper", "--lang", "zh", "-o", file)[0] == 0
    assert '<html lang="zh">' in file.read_text(encoding="utf-8")
    values = json.loads(call("study", "paper", "--json")[1])
    assert values["contact"]["time"] == found.contact.time
    assert values["smallest_pitch"]["pitch"] == found.smallest.pitch
    assert values["slopes"] == [SLOPES, SLOPES, SLOPES, dict.fromkeys(SIZES, 0.0), SLOPES]


@pytest.mark.thorough
def test_sensitivities_are_those_of_longer_differences():
    dragon = Dragon(benches=25)
    answers = paper(dragon)
    assert answers.last_slopes["width"] == answers.speed_slopes["width"] == 0
    assert answers.last_slopes["overhang"] == answers.speed_slopes["overhang"] == 0
    step = 1e-4
    for name in ("head_spacing", "body_spacing"):
        more, less = (
            replace(dragon, **{name: getattr(dragon, name) + side}) for side in (step, -step)
        )
        way = (March(each).at(300.0).handles_s[0, -1] for each in (more, less))
        assert answers.last_slopes[name] == pytest.approx(
            -abs(next(way) - next(way)) / (2 * step), rel=1e-4
        )
        change = max_speed(more).speed - max_speed(less).speed
        assert answers.speed_slopes[name] == pytest.approx(change / (2 * step), rel=1e-3)


@pytest.mark.thorough
@needs_browser
def test_page_fits_the_window_and_requests_nothing(browser, found, tmp_path):
    for language in ("en", "zh"):
        file = tmp_path / f"{language}.html"
        with in_language(language):
            pages.write_paper(found, file)
        # A4 without its margins is 688 pixels wide.
        for media, width in (("screen", 1280), ("screen", 390), ("print", 688)):
            with opened(browser, file.as_uri(), width, 900, is_mobile=width < 600) as seen:
                seen.page.emulate_media(media=media)
                assert seen.page.evaluate("document.documentElement.scrollWidth") <= width
                assert seen.complaints == []
                requested = {url for url in seen.addresses if not url.startswith("data:")}
                assert requested == {file.as_uri()}
                sizes = seen.page.evaluate("[...document.images].map((each) => each.naturalWidth)")
                assert len(sizes) == 6
                assert min(sizes) > 300
