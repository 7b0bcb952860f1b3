"""A report in a real browser, wide, narrow and on paper."""

from __future__ import annotations

from dataclasses import replace

import pytest
from browser import needs_browser, opened

from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.physics import simulate
from pymunk_dragon.reports import report

pytestmark = [pytest.mark.thorough, needs_browser]

LABEL = "<img src=http://127.0.0.1:9/picture onerror=alert(1)><script>alert(2)</script>"

# Widths in pixels; A4 without its margins is 688 pixels wide.
views = pytest.mark.parametrize(("media", "width"), [("screen", 1280), ("screen", 390), ("print", 688)])


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    """A report on 16 benches that touch each other many times, with markup in a label."""
    run = simulate(March(Dragon(benches=16), turns=8), start=80.0, until=100.0, contacts="report")
    file = tmp_path_factory.mktemp("browser") / "report.html"
    report(replace(run, provenance={**run.provenance, LABEL: LABEL}), file)
    return file.as_uri()


@pytest.fixture
def media():
    return "screen"


@pytest.fixture
def width():
    return 1280


@pytest.fixture
def seen(browser, address, media, width):
    """The report in a window of its own, as on a screen or on paper."""
    with opened(browser, address, width, 900, is_mobile=width < 600) as found:
        found.page.emulate_media(media=media)
        yield found


@views
def test_report_is_no_wider_than_the_window(media, width, seen):
    assert seen.page.evaluate("innerWidth") == width
    assert seen.page.evaluate("document.documentElement.scrollWidth") <= width


@views
def test_report_asks_for_nothing_and_browser_has_nothing_to_complain_about(media, width, address, seen):
    assert seen.complaints == []
    assert address in seen.addresses
    assert {url for url in seen.addresses if not url.startswith("data:")} == {address}


@views
def test_pictures_are_there_and_charts_have_a_size(media, width, seen):
    sizes = seen.page.evaluate("[...document.images].map(image => [image.naturalWidth, image.width])")
    assert [natural for natural, _ in sizes] == [880, 880]
    assert all(150 < shown <= width for _, shown in sizes)
    bars = seen.page.evaluate("[...document.querySelectorAll('rect')].map(bar => bar.getBoundingClientRect().toJSON())")
    assert len(bars) > 5
    assert all(0 < bar["left"] < bar["right"] <= width for bar in bars)


def test_label_with_markup_is_shown_as_text(seen):
    assert LABEL in seen.page.evaluate("document.querySelector('#provenance').textContent")
    assert seen.page.evaluate("document.scripts.length") == 0
    assert seen.page.evaluate("document.images.length") == 2


@pytest.mark.parametrize("width", [390])
def test_tables_that_are_too_wide_for_a_phone_scroll_in_their_own_boxes(width, seen):
    boxes = seen.page.evaluate(
        "[...document.querySelectorAll('.table-box')].map(box => [box.clientWidth, box.scrollWidth])"
    )
    assert all(shown < 390 for shown, _ in boxes)
    assert any(whole > shown for shown, whole in boxes)
