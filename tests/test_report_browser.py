"""A report in a real browser, wide, narrow and on paper."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from types import SimpleNamespace

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

from pymunk_dragon.dragon import Dragon
from pymunk_dragon.march import March
from pymunk_dragon.physics import simulate
from pymunk_dragon.report import report

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
pytestmark = pytest.mark.skipif(
    CHROMIUM is None or DRIVER is None,
    reason="no browser to open a report in: apt-get install chromium chromium-driver",
)

LABEL = "<img src=http://127.0.0.1:9/picture onerror=alert(1)><script>alert(2)</script>"

# Widths in pixels; A4 without its margins is 688 pixels wide.
views = pytest.mark.parametrize(("media", "width"), [("screen", 1280), ("screen", 390), ("print", 688)])


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """A report on 16 benches that touch each other many times, with markup in a label."""
    run = simulate(March(Dragon(benches=16), turns=8), start=80.0, until=100.0, contacts="report")
    file = tmp_path_factory.mktemp("browser") / "report.html"
    report(replace(run, provenance={**run.provenance, LABEL: LABEL}), file)
    return file.as_uri()


@pytest.fixture(scope="module")
def browser():
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for argument in ("--headless=new", "--no-sandbox", "--disable-background-networking", "--disable-dev-shm-usage"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(DRIVER))
    yield driver
    driver.quit()


@pytest.fixture
def opened(browser, page):
    """Open the report; gives what the browser complained about and which addresses it asked for."""

    def open_page(media, width):
        size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": media})
        for log in ("browser", "performance"):
            browser.get_log(log)
        browser.get(page)
        messages = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
        sent = [message["params"] for message in messages if message["method"] == "Network.requestWillBeSent"]
        addresses = [request["request"]["url"] for request in sent]
        return SimpleNamespace(complaints=browser.get_log("browser"), addresses=addresses)

    return open_page


@views
def test_report_is_no_wider_than_the_window(media, width, browser, opened):
    opened(media, width)
    assert browser.execute_script("return window.innerWidth") == width
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width


@views
def test_report_asks_for_nothing_and_browser_has_nothing_to_complain_about(media, width, page, opened):
    found = opened(media, width)
    assert found.complaints == []
    assert page in found.addresses
    assert {address for address in found.addresses if not address.startswith("data:")} == {page}


@views
def test_pictures_are_there_and_charts_have_a_size(media, width, browser, opened):
    opened(media, width)
    sizes = browser.execute_script("return [...document.images].map(image => [image.naturalWidth, image.width])")
    assert [natural for natural, _ in sizes] == [880, 880]
    assert all(150 < shown <= width for _, shown in sizes)
    bars = browser.execute_script(
        "return [...document.querySelectorAll('rect')].map(bar => bar.getBoundingClientRect())"
    )
    assert len(bars) > 5
    assert all(0 < bar["left"] < bar["right"] <= width for bar in bars)


def test_label_with_markup_is_shown_as_text(browser, opened):
    opened("screen", 1280)
    assert LABEL in browser.execute_script("return document.querySelector('#origin').textContent")
    assert browser.execute_script("return document.scripts.length") == 0
    assert browser.execute_script("return document.images.length") == 2


def test_tables_that_are_too_wide_for_a_phone_scroll_in_their_own_boxes(browser, opened):
    opened("screen", 390)
    boxes = browser.execute_script(
        "return [...document.querySelectorAll('.sheet')].map(box => [box.clientWidth, box.scrollWidth])"
    )
    assert all(shown < 390 for shown, _ in boxes)
    assert any(whole > shown for shown, whole in boxes)
