"""Times of a film's frames, at a constant speed or at one that falls towards near misses and contacts.

Without `speedup`, the time of the film is a smooth, rising function of the simulated time t: t / rate, and a sigmoid
(arctan) for every event, which adds a duration around the event. So the film plays at `rate` far from all events, and
slows down towards each of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon.collision import NearMiss
from pymunk_dragon.drawing.snapshots import Source, first_contact_until, march_of
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

# Frames per second of film, and those of a window that would take too long: all have whole centiseconds, as delays in
# a GIF have.
STANDARD_FPS, _LONG_FPS = 20, (25, 50)
# Largest travel of the head per frame, in shortest spacings of the body: 0.66 m of the paper's 1.65 m. From half a
# spacing on, a bench is nearer to the previous position of the next bench than to its own: the dragon creeps backwards.
# If the camera follows the head, 0.17 m, because the ground moves through a view of about 6 m.
ADVANCE = {"field": 0.4, "head": 0.1}
# s: length of a film whose start is chosen, without the hold of its last frame: 170 frames, or a GIF of 2.9 MB. It
# begins at a whole second, which is easier to read, if more than the second number of simulated s is shown.
_CHOSEN_LENGTH, _ROUND_WINDOW = 8.5, 10.0
# s: shortest film without hold, and the longest. With the standard hold, 8 and 20 s. A shorter one plays at half of
# real time far from events, or slower if the limit on the head's travel demands it.
_SHORTEST, _LONGEST, _SLOWEST = 5.5, 17.5, 0.5
# s of film that a near miss adds, that a contact adds (a film that ends with it has half), and all events at most.
_NEAR_MISS_TIME, _CONTACT_TIME, _EVENTS_TIME = 1.0, 2.0, 6.0
# Half of the width of an event, in shortest spacings travelled: 0.7 m.
_EVENT_WIDTH = 0.45
# Points at which the time of the film is computed. Between them it is linear.
_POINTS = 20_001
# Frames: a remainder of the window below this is rounding error and gets no frame of its own.
_ROUNDING = 1e-6
# s: shortest delay of a GIF frame that browsers respect.
_MIN_DELAY = 0.02


@dataclass(frozen=True)
class Timing:
    """Simulated times (F,) of the frames of a film, s; film times at which they end, s; and frames per second."""

    times: Array
    ends: Array
    fps: int


@dataclass(frozen=True)
class Event:
    """A near miss or a contact: simulated time, s, duration of film that it adds, s, and its width, s."""

    time: float
    added: float
    width: float


def constant(start: float, until: float, speedup: float, fps: int, hold: float) -> Timing:
    """Times of a film at a constant speed. The last time is always `until`."""
    step = speedup / fps
    count = math.ceil((until - start) / step - _ROUNDING)
    times: Array = np.minimum(start + step * np.arange(count + 1), until)
    shown = (times - times[0]) / speedup
    # The last frame but one is shorter if the window is not a whole number of frames long.
    shown[-1] = max(shown[-1], shown[max(0, count - 1)] + min(count, 1) * _MIN_DELAY)
    return Timing(times, np.append(shown[1:], shown[-1] + max(1 / fps, hold)), fps)


def slowed(
    sources: Sequence[Source], window: tuple[float, float], advance: float, fps: int | None, hold: float, *, late: bool
) -> Timing:
    """Times of a film of a window (first and last time, s) that slows down towards events.

    In a frame the head travels at most `advance` shortest spacings of the body. `fps` is None for 20, or more in a long
    film. If `late`, the film may begin after the window's first time.
    """
    start, until = window
    if start == until:
        return constant(start, until, 1.0, fps or STANDARD_FPS, hold)
    step = min(advance * _step(march_of(source), window) for source in sources)
    events = events_of(sources, window)
    if late:
        start = _late_start(window, step * (fps or STANDARD_FPS), events)
    _, added = _film_times(start, until, math.inf, events)
    rate, fps = _rate(until - start, float(added[-1]), step, (fps,) if fps else (STANDARD_FPS, *_LONG_FPS))
    times, film = _film_times(start, until, rate, events)
    count = max(1, round(film[-1] * fps))
    shown = np.interp(film[-1] * np.arange(count + 1) / count, film, times)
    shown[0], shown[-1] = start, until
    return Timing(shown, np.append(np.arange(1, count + 1), count + max(1.0, hold * fps)) / fps, fps)


def _step(march: March, window: tuple[float, float]) -> float:
    """Least time, s, in which the head travels the shortest spacing of the body."""
    # Without the head's spacing, if there is another.
    spacings = march.dragon.spacings[-max(1, march.dragon.benches - 1) :]
    return float(spacings.min()) / march.speed_profile.fastest(*window)


def _late_start(window: tuple[float, float], rate: float, events: Sequence[Event]) -> float:
    """First time, s, such that the rest of the window has the chosen length at `rate`, or that of the window."""
    times, film = _film_times(*window, rate, events)
    start = float(np.interp(film[-1] - _CHOSEN_LENGTH, film, times))
    return float(math.ceil(start)) if start > window[0] and window[1] - start > _ROUND_WINDOW else start


def _rate(duration: float, added: float, step: float, choices: Sequence[int]) -> tuple[float, int]:
    """Simulated seconds per second of film far from events, and frames per second, one of the `choices`.

    The film shows `duration` s, is longer by `added` s because of events, and shows at most `step` s per frame.
    """
    fps = next((fps for fps in choices if added + duration / (step * fps) <= _LONGEST), choices[-1])
    rate = max(step * fps, duration / (_LONGEST - added))
    if added + duration / rate < _SHORTEST:
        rate = max(duration / (_SHORTEST - added), min(rate, _SLOWEST))
    return rate, fps


def _film_times(start: float, until: float, rate: float, events: Sequence[Event]) -> tuple[Array, Array]:
    """Simulated times (P,), s, and the times in the film at which they are shown, from 0 s on."""
    times = np.linspace(start, until, _POINTS)
    film = (times - start) / rate
    for event in events:
        film += event.added / np.pi * np.arctan((times - event.time) / event.width)
    return times, film - film[0]


def events_of(sources: Sequence[Source], window: tuple[float, float]) -> list[Event]:
    """Near misses and first contacts of `sources` within a window (first and last time, s).

    Events of two sources that are closer than half a width are one.
    """
    found = [event for source in sources for event in _events(source, *window)]
    events: list[Event] = []
    for event in sorted(found, key=lambda event: (-event.added, event.time)):
        if all(abs(event.time - other.time) > event.width / 2 for other in events):
            events.append(event)
    share = _EVENTS_TIME / max(_EVENTS_TIME, sum(event.added for event in events))
    return sorted((replace(event, added=share * event.added) for event in events), key=lambda event: event.time)


def _events(source: Source, start: float, until: float) -> list[Event]:
    """Near misses and first contact of one source between two times, s."""
    march = march_of(source)
    if isinstance(source, Run):
        misses, contact = _near_misses(source, start, until), source.first_contact
    else:
        exact = first_contact_until(source, start, until)
        misses, contact = exact.near_misses or (), exact.contact
    times = {miss.time: _NEAR_MISS_TIME for miss in misses}
    if contact is not None and start <= contact.time <= until:
        times[contact.time] = _CONTACT_TIME
    # The time in which the head travels `_EVENT_WIDTH` spacings.
    width = _EVENT_WIDTH * float(march.dragon.spacings.min())
    return [Event(time, added, width / float(march.speed_profile.at(time))) for time, added in times.items()]


def _near_misses(run: Run, start: float, until: float) -> Sequence[NearMiss]:
    """Near misses of the exact model during a run, if they are those of the run."""
    start, until = np.clip((start, until), *run.times[[0, -1]]).tolist()
    if run.guide == "none" or "live" in run.provenance or start == until:
        return ()
    return first_contact_until(run.march, start, until).near_misses or ()
