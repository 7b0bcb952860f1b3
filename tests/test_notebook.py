"""What a notebook shows of a run, a march and a figure."""

from __future__ import annotations

from html import unescape
from html.parser import HTMLParser
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from pymunk_dragon.collision import first_contact
from pymunk_dragon.drawing import Palette
from pymunk_dragon.drawing.figures import figure
from pymunk_dragon.model.contact import Contact
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.player import player_page

MARCH = March(Dragon(benches=16), turns=8)


@pytest.fixture(scope="module")
def run():
    return Run.exact(MARCH, np.linspace(70, 75, 51))


def opened(png):
    return Image.open(BytesIO(png)).convert("RGB")


def has(picture, colour):
    return np.any(np.all(np.asarray(picture) == colour, axis=-1))


class Frames(HTMLParser):
    """Attributes of every frame, and all other tags."""

    def __init__(self):
        super().__init__()
        self.frames, self.others = [], []

    def handle_starttag(self, tag, attrs):
        if tag == "iframe":
            self.frames.append(dict(attrs))
        else:
            self.others.append(tag)


def test_a_small_run_is_a_player_in_a_frame_of_its_own(run):
    found = Frames()
    found.feed(run._repr_html_())
    [frame] = found.frames
    assert frame["srcdoc"] == player_page(run)
    # Nothing of the run gets out of the frame into the notebook, which would run it as its own.
    assert found.others == []
    assert set(frame["sandbox"].split()) == {"allow-scripts", "allow-downloads"}


def test_markup_in_a_run_stays_inside_the_frame(run):
    evil = '"></iframe><script>alert(1)</script>'
    hostile = Run.exact(MARCH, [70.0, 71.0])
    object.__setattr__(hostile, "provenance", {"player": evil, evil: evil})
    found = Frames()
    text = hostile._repr_html_()
    found.feed(text)
    assert len(found.frames) == 1
    assert found.others == []
    assert unescape(text).count("</iframe>") >= 1


def test_a_run_too_large_for_a_notebook_is_a_picture(run):
    long = Run.exact(MARCH, np.linspace(0, 80, 15_000))
    assert long._repr_html_() is None
    assert opened(long._repr_png_()).size == opened(run._repr_png_()).size


def test_a_run_is_shown_as_it_ended(run):
    contact = Contact(time=75.0, raw_time=75.0, benches=(0, 8), point=(1.0, 2.0), normal=(0.0, 1.0), depth=0.0)
    red = Palette().rgb("contact")
    assert not has(opened(run._repr_png_()), red)
    touching = Run(
        march=run.march, times=run.times, poses=run.poses, drift=run.drift, first_contact=contact, outcome="contact"
    )
    assert has(opened(touching._repr_png_()), red)


def test_a_march_is_shown_as_it_begins():
    assert MARCH._repr_html_() is None
    picture = opened(MARCH._repr_png_())
    palette = Palette()
    assert all(has(picture, palette.rgb(name)) for name in ("head", "body", "tail"))


def test_a_figure_is_shown_without_pyplot():
    picture = opened(figure("speeds")._repr_png_())
    assert picture.width == 800
    assert has(picture, Palette().rgb("background"))


def test_a_march_and_a_run_have_a_figure(run):
    for shown in (MARCH, run):
        assert opened(shown.plot()._repr_png_()).width == 800


def test_a_first_contact_is_shown_as_its_text():
    found = first_contact(MARCH, until=1.0)
    assert unescape(found._repr_html_()) == f"<pre>{found}</pre>"
    assert str(found) == "no contact until t = 1 s"
