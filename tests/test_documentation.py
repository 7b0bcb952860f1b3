"""The site that `make docs` builds: complete, without a network, and without a broken link."""

import os
import re
import shlex
import subprocess
import sys
import tarfile
import tomllib
import venv
import zipfile
from itertools import pairwise
from urllib.parse import unquote, urlsplit

import documentation
import numpy as np
import pytest
import runnable
from browser import needs_browser, opened, wait_until
from bs4 import BeautifulSoup
from documents import DOCUMENTS, GUIDES, ROOT

import pymunk_dragon
from pymunk_dragon import Dragon, March, Run, write_player
from pymunk_dragon.lessons import LESSONS

RENDERS = ROOT / "renders"


def made(target, text):
    """Words of the command that `make` prints, but does not run, for `target` in a new clone."""
    # The tests may have been started by make, whose options are not for this one.
    alone = {
        name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "MFLAGS"))
    }
    command = ["make", "--dry-run", "--always-make", target]
    shown = subprocess.run(
        command, cwd=ROOT, env=alone, capture_output=True, text=True, check=True, timeout=60
    ).stdout
    [line] = [line for line in shown.splitlines() if text in line]
    return shlex.split(line)


def commands():
    """The arguments that the Makefile passes."""
    return dict(
        argument.split("=", 1)
        for argument in made("docs", "renders/documentation.py renders/docs")[3:]
    )


def test_run_of_a_figure_is_not_written_as_pictures():
    assert made("renders/figures/drift.png", "gallery.py renders/march.npz")[3] == ".npz"
    assert (
        made("renders/figures/drift.png", "gallery.py renders/figures/drift.png")[3] == ".png,.svg"
    )


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
        self.links = [
            each[name]
            for name in ("href", "src")
            for each in self.soup.find_all(attrs={name: True})
        ]
        self.anchors = {each["id"] for each in self.soup.find_all(id=True)}


@pytest.fixture(scope="module")
def pages(site):
    copies = {site / name for name in (*documentation.COPIES, "engine/live.html")}
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
            anchored = (
                not parts.fragment
                or target not in pages
                or unquote(parts.fragment) in pages[target].anchors
            )
            if not (target.is_file() and target.is_relative_to(site.resolve()) and anchored):
                broken.append((path.relative_to(site).as_posix(), link))
    assert broken == []


@pytest.mark.thorough
def test_every_public_name_has_its_place_on_a_page_with_an_example(site, pages):
    names = pages[site / "names.html"].links
    for name in pymunk_dragon.__all__:
        [link] = {link for link in names if link.endswith(f"#{name}")}
        section = pages[site / link.partition("#")[0]].soup.find("section", id=name)
        assert "Examples" in [each.text for each in section.find_all("h2")] or name.endswith(
            "Error"
        )


@pytest.mark.thorough
def test_links_have_names_headings_skip_no_level_and_what_scrolls_has_focus(pages):
    for path, page in pages.items():
        links = page.soup.find_all("a")
        names = [
            each.text.strip() or each.get("aria-label") or each.find("img", alt=True)
            for each in links
        ]
        assert all(names), path.name
        levels = [int(each.name[1]) for each in page.soup.main.find_all(re.compile("h[1-6]"))]
        assert all(after <= before + 1 for before, after in pairwise(levels)), path.name
        assert all(each.has_attr("tabindex") for each in page.soup.find_all(["pre", "table"])), (
            path.name
        )


def test_teachers_find_each_lesson_below_at_most_one_question():
    questions = GUIDES["teachers"].text.partition("## Which lesson")[2].partition("\n## ")[0]
    found = re.findall(r"`([a-z-]+)`", questions)
    assert found
    assert len(found) == len(set(found))
    # A new lesson may answer none of these questions.
    assert set(found) <= set(LESSONS)


def test_teachers_find_every_lesson_in_the_table_of_goals():
    _, _, *rows = documentation.lessons_text().splitlines()
    assert len(rows) == len(LESSONS)
    for name, row in zip(LESSONS, rows, strict=True):
        assert row.startswith(f"| [{name}]")


def test_every_committed_picture_is_described_in_a_text():
    texts = {each.name: each.text for each in DOCUMENTS}
    described = {picture for picture, _, _ in documentation.shown_pictures(texts)}
    # Not those that `make docs` copies.
    found = [*RENDERS.glob("*.[gp][in][fg]"), *RENDERS.glob("figures/*.[gp][in][fg]")]
    assert described == {path.relative_to(RENDERS).as_posix() for path in found}


def test_programs_that_show_something_run_in_the_page_where_it_has_their_libraries():
    found = {name: runnable.blocks(guide.text) for name, guide in GUIDES.items()}
    running = {
        name: [place for place, block in enumerate(blocks) if block.runs]
        for name, blocks in found.items()
    }
    # Not those with imageio or matplotlib, and not those that only define functions.
    expected = {
        "chains": [1, 2],
        "contacts": [0],
        "live": [0, 1],
        "pictures": [0, 3],
        "recursion": [0],
    }
    assert {name: places for name, places in running.items() if places} == expected
    assert [block.needs for block in found["chains"]] == [[], [0], [0]]
    assert runnable.marked(GUIDES["chains"].text).count('<div class="program"') == 3


@pytest.mark.thorough
@needs_browser
def test_pages_fit_the_window_and_request_only_files(browser, site, pages):
    # The narrow window for every second page, and the wide one for some.
    for path, width in [
        *((path, 390) for path in list(pages)[::2]),
        *((path, 1280) for path in list(pages)[:3]),
    ]:
        with opened(browser, path.as_uri(), width, 900, is_mobile=width < 600) as seen:
            assert seen.page.evaluate("document.documentElement.scrollWidth") == width, path.name
            assert seen.complaints == []
            assert all(address.startswith((site.as_uri(), "data:")) for address in seen.addresses)


@pytest.mark.thorough
@needs_browser
def test_search_finds_a_public_name_and_lists_guides_before_attributes(browser, site):
    with opened(browser, (site / "index.html").as_uri()) as seen:
        seen.page.fill("input[type=search]", "First contact")
        wait_until(
            seen.page, "document.querySelector('.search-result a')?.href.endsWith('#first_contact')"
        )
        seen.page.fill("input[type=search]", "chain")
        wait_until(
            seen.page,
            "document.querySelector('.search-result a')?.getAttribute('href') === 'chains.html'",
        )
        seen.page.fill("input[type=search]", "lesson")
        wait_until(
            seen.page, "document.querySelector('main').innerText.includes(\"results for 'lesson'\")"
        )
        assert not seen.page.query_selector_all("[href$='.md']")
        assert [text for text in seen.complaints if "Failed" in text] == []


# A release: both archives are complete, and work where nothing else is installed

VERSION = pymunk_dragon.__version__


def run(*command, **options):
    """Output of a command. pip takes most of the time; the second time it has the libraries."""
    done = subprocess.run(
        [*map(str, command)], capture_output=True, text=True, check=False, timeout=300, **options
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """The folder of programs of an empty environment."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=True)
    try:
        run(
            folder / "bin" / "pip",
            "download",
            "--quiet",
            "--no-deps",
            "--dest",
            folder / "downloads",
            "hatchling",
        )
    except AssertionError:
        pytest.skip(
            "no package index can be reached, from which pip takes hatchling and the libraries"
        )
    return folder / "bin"


@pytest.fixture(scope="module")
def archives(programs, tmp_path_factory):
    """The wheel and the source distribution."""
    folder = tmp_path_factory.mktemp("dist")
    run(sys.executable, "-m", "build", "--outdir", folder, ROOT)
    return (
        folder / f"pymunk_dragon-{VERSION}-py3-none-any.whl",
        folder / f"pymunk_dragon-{VERSION}.tar.gz",
    )


@pytest.mark.thorough
def test_archives_are_complete_and_an_index_would_accept_them(archives):
    assert run(sys.executable, "-m", "twine", "check", "--strict", *archives).count("PASSED") == 2
    package = [path for path in (ROOT / "pymunk_dragon").rglob("*") if path.is_file()]
    files = {
        path.relative_to(ROOT).as_posix() for path in package if "__pycache__" not in path.parts
    }
    assert {
        name for name in zipfile.ZipFile(archives[0]).namelist() if ".dist-info/" not in name
    } == files
    with tarfile.open(archives[1]) as archive:
        packed = {name.partition("/")[2] for name in archive.getnames()}
    read = "README.md README.zh.md LICENSE Makefile renders/documentation.py "
    read += "renders/guides/live.md tests/conftest.py"
    assert packed >= files.union(read.split())
    assert not any(name.startswith(("renders/docs", ".venv", "renders/march")) for name in packed)


@pytest.mark.thorough
def test_installed_archives_run_the_program_and_a_lesson(archives, programs, tmp_path):
    install = [programs / "pip", "install", "--quiet", "--no-compile"]
    run(*install, "--only-binary", ":all:", f"{archives[0]}[demos]")
    assert "benches 0 and 8" in run(programs / "pymunk-dragon", "contact", cwd=tmp_path)
    assert run(programs / "pymunk-dragon", "demo", "sat", "--save", tmp_path, cwd=tmp_path)
    assert list(tmp_path.iterdir())
    # The source distribution installs the same program.
    run(*install, "--no-deps", "--force-reinstall", archives[1])
    assert "benches 0 and 8" in run(
        programs / "pymunk-dragon", "simulate", "--from", "412", cwd=tmp_path
    )


def test_metadata_and_citation_name_what_users_look_for():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert {
        "authors",
        "classifiers",
        "description",
        "keywords",
        "license",
        "readme",
        "urls",
    } <= set(project)
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {VERSION}\n" in citation
    assert "Study On The Bench Dragon Problem" in citation
