"""What a notebook shows of a run, a march and a figure."""

from dataclasses import replace
from html import unescape
from html.parser import HTMLParser
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from pymunk_dragon import Contact, Dragon, March, Run, first_contact, player_page
from pymunk_dragon.drawing import Palette

MARCH = March(Dragon(benches=16), turns=8)


@pytest.fixture(scope="module")
def run():
    return Run.exact(MARCH, np.linspace(70, 75, 51))


def opened(png):
    return Image.open(BytesIO(png)).convert("RGB")


def has(picture, part):
    return np.any(np.all(np.asarray(picture) == Palette().rgb(part), axis=-1))


class Tags(HTMLParser):
    """All tags with their attributes."""

    def __init__(self, text):
        super().__init__()
        self.found = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))


def test_small_run_is_a_player_in_a_frame_that_nothing_leaves(run):
    evil = '"></iframe><script>alert(1)</script>'
    for shown in (run, replace(run, provenance={"player": evil, evil: evil})):
        [(tag, frame)] = Tags(shown._repr_html_()).found
        assert (tag, frame["srcdoc"]) == ("iframe", player_page(shown))
        assert set(frame["sandbox"].split()) == {"allow-scripts", "allow-downloads"}


def test_run_too_large_for_a_notebook_is_a_picture_of_its_end(run):
    long = Run.exact(MARCH, np.linspace(0, 80, 15_000))
    assert long._repr_html_() is None
    assert opened(long._repr_png_()).size == opened(run._repr_png_()).size
    assert not has(opened(run._repr_png_()), "contact")
    contact = Contact(time=75.0, raw_time=75.0, benches=(0, 8), point=(1.0, 2.0), normal=(0.0, 1.0), depth=0.0)
    assert has(opened(replace(run, first_contact=contact, outcome="contact")._repr_png_()), "contact")


def test_march_is_a_picture_of_its_start_and_has_a_figure(run):
    assert MARCH._repr_html_() is None
    assert all(has(opened(MARCH._repr_png_()), part) for part in ("head", "body", "tail"))
    for shown in (MARCH, run):
        picture = opened(shown.plot()._repr_png_())
        assert picture.width == 800
        assert has(picture, "background")


def test_first_contact_is_its_text():
    found = first_contact(MARCH, until=1.0)
    assert unescape(found._repr_html_()) == f"<pre>{found}</pre>"
    assert str(found) == "no contact until t = 1 s"
