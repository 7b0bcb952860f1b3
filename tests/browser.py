"""A real browser for the tests that open a page in one, and what a page did there."""

from __future__ import annotations

import re
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from html import escape
from typing import Any

import pytest
from playwright.sync_api import Browser, Dialog, Frame, Page, Route, sync_playwright

CHROMIUM = shutil.which("chromium")
needs_browser = pytest.mark.skipif(
    CHROMIUM is None, reason="no browser to open a page in: apt-get install chromium"
)

# Texts, titles and names of elements, without what the reader types, commands, and what a run says
# of itself.
TEXTS = """() => {
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const texts = [document.title];
  while (walk.nextNode()) {
    const parent = walk.currentNode.parentElement;
    const left = parent.closest("script, style, kbd, code, noscript, #language, .from-run");
    if (!left) texts.push(walk.currentNode.data);
  }
  for (const each of document.querySelectorAll("[title], [aria-label]")) {
    texts.push(each.title, each.ariaLabel ?? "");
  }
  return texts;
}"""

ARGUMENTS = ("--no-sandbox", "--disable-background-networking", "--disable-dev-shm-usage")


@contextmanager
def chromium() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=CHROMIUM, args=ARGUMENTS, timeout=120_000
        )
        yield browser
        browser.close()


@dataclass
class Opened:
    """A page, the browser's complaints, addresses that were requested, and boxes that opened."""

    page: Page
    complaints: list[str] = field(default_factory=list)
    addresses: list[str] = field(default_factory=list)
    boxes: list[str] = field(default_factory=list)

    def dismiss(self, dialog: Dialog) -> None:
        """Note the text of a box that popped up, and close it."""
        self.boxes.append(dialog.message)
        dialog.dismiss()


@contextmanager
def opened(
    browser: Browser, address: str, width: int = 1280, height: int = 800, **options: Any
) -> Iterator[Opened]:
    """Open a page in a window of its own; `options` are Playwright's for a browser context."""
    context = browser.new_context(viewport={"width": width, "height": height}, **options)
    found = Opened(context.new_page())
    page = found.page
    page.set_default_timeout(120_000)
    page.on("console", lambda message: found.complaints.append(message.text))
    page.on("pageerror", lambda error: found.complaints.append(str(error)))
    page.on("request", lambda request: found.addresses.append(request.url))
    page.on("dialog", found.dismiss)
    page.goto(address)
    yield found
    context.close()


def english_words(page: Page) -> set[str]:
    """Words of at least three Latin letters in the page's own texts."""
    return {word for text in page.evaluate(TEXTS) for word in re.findall(r"[A-Za-z]{3,}", text)}


def wait_until(page: Page | Frame, expression: str, seconds: float = 120.0) -> None:
    """Wait until an expression is true; Playwright's own way needs `eval`, which pages forbid."""
    end = time.monotonic() + seconds
    while not page.evaluate(expression):
        assert time.monotonic() < end, f"still not true after {seconds:g} s: {expression}"
        page.wait_for_timeout(20)


@contextmanager
def framed(browser: Browser, content: str, how: str) -> Iterator[tuple[Opened, Frame]]:
    """Open a page, by `src` or `srcdoc`, in a frame that allows it scripts and nothing else."""
    value = {"src": "/page.html", "srcdoc": escape(content)}[how]
    allowed = f'sandbox="allow-scripts" width="1200" height="780" {how}="{value}"'
    around = f"<!doctype html><iframe {allowed}></iframe>"

    def answer(route: Route) -> None:
        found = content if route.request.url.endswith("/page.html") else around
        route.fulfill(body=found, content_type="text/html; charset=utf-8")

    with opened(browser, "about:blank") as found:
        found.page.route("http://frame.example/**", answer)
        found.page.goto("http://frame.example/")
        frame = found.page.wait_for_selector("iframe").content_frame()
        assert frame is not None
        yield found, frame
        assert found.complaints == [], found.complaints
        assert found.boxes == []
