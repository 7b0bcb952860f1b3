"""Films without options: how long they are, which part they show, and where they slow down."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from pymunk_dragon import Camera, Contact, Dragon, March, Run, SpeedTable
from pymunk_dragon.drawing import Film, write_film
from pymunk_dragon.drawing.film.timing import events_of

NEAR_MISSES = (406.8466, 409.8320)
CONTACT = 412.4738
SMALL = March(Dragon(benches=16), turns=4)


def with_contact(run, time):
    contact = Contact(time=time, raw_time=time, benches=(0, 8), point=(1.5, 2.1), normal=(0, 1), depth=0)
    return replace(run, first_contact=contact, outcome="contact")


@pytest.fixture(scope="module")
def reference():
    """The reference march until its contact."""
    return with_contact(Run.exact(March(), np.append(np.arange(0, 412.0, 2.0), CONTACT)), CONTACT)


def travel(timing):
    """Travel of the head per frame, m, at 1 m/s."""
    return np.diff(timing.times)


def travel_near(timing, time):
    return travel(timing)[np.searchsorted(timing.times, time) - 2]


def test_film_of_the_reference_march_is_short_and_smooth(reference):
    timing = Film().timing([reference])
    assert 8 <= timing.ends[-1] <= 20
    assert timing.fps >= 20
    assert travel(timing).max() <= 0.8
    assert travel(timing).min() > 0
    assert timing.ends[-1] - timing.ends[-2] == pytest.approx(2.5)
    assert timing.times[-1] == CONTACT


def test_film_slows_down_towards_near_misses_and_contact(reference):
    timing = Film().timing([reference])
    for time in (*NEAR_MISSES, CONTACT):
        assert travel_near(timing, time) < travel(timing).max() / 4
    # Faster between them than at them.
    between = travel_near(timing, np.mean(NEAR_MISSES))
    assert between > 1.5 * max(travel_near(timing, time) for time in NEAR_MISSES)


def test_speed_of_the_film_changes_smoothly(reference):
    timing = Film().timing([reference])
    assert np.abs(np.diff(travel(timing))).max() < travel(timing).max() / 8


def test_frames_follow_each_other_at_equal_intervals(reference):
    timing = Film().timing([reference])
    np.testing.assert_allclose(np.diff(timing.ends[:-1]), 1 / timing.fps)


def test_given_start_shows_the_whole_march_in_20_seconds(reference):
    timing = Film(start=0).timing([reference])
    assert timing.times[0] == 0
    assert timing.ends[-1] <= 20
    assert travel(timing).max() <= 0.8
    # Delays in a GIF are whole centiseconds.
    assert 100 % timing.fps == 0


def test_camera_that_follows_the_head_sees_less_travel_per_frame(reference):
    timing = Film(camera=Camera(follow="head")).timing([reference])
    assert 8 <= timing.ends[-1] <= 20
    assert travel(timing).max() <= 0.2


def test_short_march_takes_8_seconds():
    run = Run.exact(SMALL, np.linspace(0, 18, 19))
    timing = Film().timing([run])
    assert timing.times[[0, -1]].tolist() == [0, 18]
    assert timing.ends[-1] == pytest.approx(8)


def test_very_short_march_is_shown_at_half_of_real_time():
    timing = Film(until=1.0).timing([SMALL])
    assert timing.ends[-1] == pytest.approx(2 * 1.0 + 2.5)


def test_number_of_frames_per_second_can_be_given(reference):
    timing = Film(fps=10).timing([reference])
    assert timing.fps == 10
    assert travel(timing).max() <= 0.8


def test_very_long_march_is_faster_instead_of_longer():
    run = Run.exact(March(Dragon(benches=3), turns=80), np.linspace(0, 8000, 101))
    timing = Film(start=0).timing([run])
    assert timing.fps == 50
    assert timing.ends[-1] == pytest.approx(20, abs=0.05)


def test_limit_holds_at_the_highest_speed_of_the_march():
    march = March(Dragon(benches=16), turns=16, speed=SpeedTable((0, 100, 200), (0.2, 2.0, 0.2)))
    timing = Film().timing([Run.exact(march, np.linspace(0, 200, 101))])
    assert np.diff(march.distance(timing.times)).max() <= 0.8


def test_smaller_benches_travel_less_per_frame():
    dragon = Dragon(benches=16, head_spacing=0.286, body_spacing=0.165, overhang=0.0275, width=0.03)
    timing = Film(until=60).timing([March(dragon, turns=16)])
    assert travel(timing).max() <= 0.08


def test_given_speedup_is_constant_and_shows_the_whole_run(reference):
    timing = Film(speedup=20).timing([reference])
    assert timing.times[0] == 0
    np.testing.assert_allclose(np.diff(timing.times)[:-1], 1)


def test_near_misses_of_the_exact_model_are_no_events_of_an_unguided_run(reference):
    times = [event.time for event in events_of([reference], (400, 412.5))]
    assert times == pytest.approx([*NEAR_MISSES, CONTACT], abs=1e-3)
    unguided = replace(reference, provenance={"player": "pymunk", "guide": "none"})
    assert [event.time for event in events_of([unguided], (400, 412.5))] == [CONTACT]


def test_contacts_of_two_runs_at_nearly_the_same_time_are_one_event(reference):
    later = with_contact(replace(reference, first_contact=None), CONTACT - 1e-4)
    assert events_of([reference, later, reference.march], (0, CONTACT)) == events_of([later], (0, CONTACT))


def test_film_of_a_march_slows_down_towards_its_contact():
    events = events_of([March()], (0, 412.4738376821))
    assert [event.time for event in events] == pytest.approx([*NEAR_MISSES, CONTACT], abs=1e-3)
    assert events[-1].added == 2 * events[0].added


def test_many_events_do_not_make_the_film_long():
    runs = [with_contact(Run.exact(March(Dragon(benches=60)), [0, 412]), time) for time in (100, 200, 300, 350)]
    events = events_of(runs, (0, 412))
    assert len(events) == 6
    assert sum(event.added for event in events) == pytest.approx(6)


def test_film_of_one_frame(tmp_path):
    timing = write_film(SMALL, tmp_path / "film.gif", Film(size=64, start=3, until=3))
    assert timing.times.tolist() == [3]


def test_gif_of_the_film_has_its_frames_and_delays(tmp_path):
    timing = write_film(SMALL, tmp_path / "film.gif", Film(size=64, until=18))
    with Image.open(tmp_path / "film.gif") as film:
        delays = []
        for frame in range(film.n_frames):
            film.seek(frame)
            delays.append(film.info["duration"])
    assert sum(delays) == pytest.approx(1000 * timing.ends[-1])
    assert delays[-1] == 2500
    assert set(delays[:-1]) == {50}
