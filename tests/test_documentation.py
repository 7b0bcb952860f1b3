"""The site that `make docs` builds: complete, without a network, and without a broken link."""

import os
import shlex
import subprocess
from urllib.parse import unquote, urlsplit

import documentation
import numpy as np
import pytest
from browser import needs_browser, opened, wait_until
from bs4 import BeautifulSoup
from documents import DOCUMENTS, ROOT

import pymunk_dragon
from pymunk_dragon import Dragon, March, Run, write_player

RENDERS = ROOT / "renders"


def commands():
    """The arguments that the Makefile passes, without making anything."""
    # The tests may have been started by make, whose options are not for this one.
    alone = {name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "MFLAGS"))}
    shown = subprocess.run(
        ["make", "--dry-run", "docs"], cwd=ROOT, env=alone, capture_output=True, text=True, check=True, timeout=60
    ).stdout
    [line] = [line for line in shown.splitlines() if "renders/documentation.py renders/docs" in line]
    return dict(argument.split("=", 1) for argument in shlex.split(line)[3:])


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("documentation")
    pages = folder / "pages"
    pages.mkdir()
    for name in documentation.COPIES:
        write_player(Run.exact(March(Dragon(benches=4)), np.arange(3.0)), pages / name)
    documentation.build(folder / "docs", commands(), pages)
    return folder / "docs"


class Page:
    """The addresses and the anchors of a page."""

    def __init__(self, path):
        self.soup = BeautifulSoup(path.read_text(encoding="utf-8"), "html.parser")
        self.links = [each[name] for name in ("href", "src") for each in self.soup.find_all(attrs={name: True})]
        self.anchors = {each["id"] for each in self.soup.find_all(id=True)}


@pytest.fixture(scope="module")
def pages(site):
    copies = {site / name for name in documentation.COPIES}
    return {path: Page(path) for path in site.rglob("*.html") if path not in copies}


@pytest.mark.thorough
def test_every_link_leads_somewhere(site, pages):
    broken = []
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme in ("http", "https", "data") or "${" in link:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            anchored = not parts.fragment or target not in pages or unquote(parts.fragment) in pages[target].anchors
            if not (target.is_file() and target.is_relative_to(site.resolve()) and anchored):
                broken.append((path.relative_to(site).as_posix(), link))
    assert broken == []


@pytest.mark.thorough
def test_every_public_name_has_its_place_on_a_page_with_an_example(site, pages):
    names = pages[site / "names.html"].links
    for name in pymunk_dragon.__all__:
        [link] = {link for link in names if link.endswith(f"#{name}")}
        section = pages[site / link.partition("#")[0]].soup.find("section", id=name)
        assert "Examples" in [each.text for each in section.find_all("h6")] or name.endswith("Error")


def test_every_committed_picture_is_described_in_a_text():
    texts = {each.name: each.text for each in DOCUMENTS}
    described = {picture for picture, _, _ in documentation.shown_pictures(texts)}
    # Not those that `make docs` copies.
    found = [*RENDERS.glob("*.[gp][in][fg]"), *RENDERS.glob("figures/*.[gp][in][fg]")]
    assert described == {path.relative_to(RENDERS).as_posix() for path in found}


@pytest.mark.thorough
@needs_browser
def test_pages_fit_the_window_and_request_only_files(browser, site, pages):
    # The narrow window for all, and the wide one for some.
    for path, width in [*((path, 390) for path in pages), *((path, 1280) for path in list(pages)[:3])]:
        with opened(browser, path.as_uri(), width, 900, is_mobile=width < 600) as seen:
            assert seen.page.evaluate("document.documentElement.scrollWidth") == width, path.name
            assert seen.complaints == []
            assert all(address.startswith((site.as_uri(), "data:")) for address in seen.addresses)


@pytest.mark.thorough
@needs_browser
def test_search_finds_a_public_name(browser, site):
    with opened(browser, (site / "index.html").as_uri()) as seen:
        seen.page.fill("input[type=search]", "first_contact")
        wait_until(seen.page, "document.querySelectorAll('main a[href*=\"#first_contact\"]').length > 0")
        seen.page.fill("input[type=search]", "gap")
        wait_until(seen.page, "document.querySelector('main').innerText.includes(\"results for 'gap'\")")
        assert [text for text in seen.complaints if "Failed" in text] == []
