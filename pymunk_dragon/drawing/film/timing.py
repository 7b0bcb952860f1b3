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
from pymunk_dragon.drawing.snapshots import Source, first_contact_until, march_of
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

# Frames per second of film, and those of a window that would take too long: all have whole centiseconds, as delays in
# a GIF have.
STANDARD_FPS, LONG_FPS = 20, (25, 50)
# Largest travel of the head per frame, in shortest spacings of the body: 0.66 m of the paper's 1.65 m. From half a
# spacing on, a bench is nearer to the previous position of the next bench than to its own: the dragon creeps backwards.
FIELD_ADVANCE = 0.4
# The same if the camera follows the head: 0.17 m, because the ground moves through a view of about 6 m.
HEAD_ADVANCE = 0.1
# s: length of a film whose start is chosen, without the hold of its last frame: 170 frames, or a GIF of 2.9 MB.
CHOSEN_LENGTH = 8.5
# Slowest rate far from events, if the limit on the head's travel does not demand less: half of real time.
SLOWEST = 0.5
# s: shortest film without hold, if `SLOWEST` allows it, and the longest. With the standard hold, 8 and 20 s.
SHORTEST, LONGEST = 5.5, 17.5
# s: a film of more than this begins at a whole second, which is easier to read.
ROUND_WINDOW = 10.0
# s of film that a near miss adds, that a contact adds (a film that ends with it has half), and all events at most.
NEAR_MISS_TIME, CONTACT_TIME, EVENTS_TIME = 1.0, 2.0, 6.0
# Half of the width of an event, in shortest spacings travelled: 0.7 m.
EVENT_WIDTH = 0.45
# Points at which the time of the film is computed. Between them it is linear.
POINTS = 20_001
# Frames: a remainder of the window below this is rounding error and gets no frame of its own.
ROUNDING = 1e-6
# s: shortest delay of a GIF frame that browsers respect.
MIN_DELAY = 0.02


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
    count = math.ceil((until - start) / step - ROUNDING)
    times: Array = np.minimum(start + step * np.arange(count + 1), until)
    shown = (times - times[0]) / speedup
    # The last frame but one is shorter if the window is not a whole number of frames long.
    shown[-1] = max(shown[-1], shown[max(0, count - 1)] + (MIN_DELAY if count else 0.0))
    return Timing(times, np.append(shown[1:], shown[-1] + max(1 / fps, hold)), fps)


def slowed(
    sources: Sequence[Source],
    window: tuple[float, float],
    *,
    choose_start: bool,
    fps: int | None,
    hold: float,
    advance: float,
) -> Timing:
    """Times of a film of a window (first and last time, s) that slows down towards events.

    If `choose_start`, it may begin after the window's first time. `fps` is None for 20, or more in a long film. In a
    frame the head travels at most `advance` shortest spacings of the body.
    """
    start, until = window
    if start == until:
        return constant(start, until, 1.0, fps or STANDARD_FPS, hold)
    step = min(advance * _step(march_of(source), window) for source in sources)
    events = events_of(sources, window)
    if choose_start:
        times, film = _film_times(start, until, step * (fps or STANDARD_FPS), events)
        start = float(np.interp(film[-1] - CHOSEN_LENGTH, film, times))
        if start > window[0] and until - start > ROUND_WINDOW:
            start = float(math.ceil(start))
    _, added = _film_times(start, until, math.inf, events)
    rate, fps = _rate(until - start, float(added[-1]), step, fps)
    times, film = _film_times(start, until, rate, events)
    count = max(1, round(film[-1] * fps))
    shown = np.interp(film[-1] * np.arange(count + 1) / count, film, times)
    shown[0], shown[-1] = start, until
    return Timing(shown, np.append(np.arange(1, count + 1), count + max(1.0, hold * fps)) / fps, fps)


def _step(march: March, window: tuple[float, float]) -> float:
    """Least time, s, in which the head travels the shortest spacing of the body."""
    # Without the head's spacing, if there is another.
    spacings = march.dragon.spacings[-max(1, march.dragon.benches - 1) :]
    return float(spacings.min()) / float(march.speed_profile.fastest(*window))


def _rate(duration: float, added: float, step: float, fps: int | None) -> tuple[float, int]:
    """Simulated seconds per second of film far from events, and frames per second.

    The film shows `duration` s, is longer by `added` s because of events, and shows at most `step` s per frame.
    """
    for chosen in (STANDARD_FPS, *LONG_FPS) if fps is None else (fps,):
        rate = step * chosen
        if added + duration / rate <= LONGEST:
            break
    else:
        rate = duration / (LONGEST - added)
    if added + duration / rate < SHORTEST:
        rate = max(duration / (SHORTEST - added), min(rate, SLOWEST))
    return rate, chosen


def _film_times(start: float, until: float, rate: float, events: Sequence[Event]) -> tuple[Array, Array]:
    """Simulated times (P,), s, and the times in the film at which they are shown, from 0 s on."""
    times = np.linspace(start, until, POINTS)
    film = (times - start) / rate
    for event in events:
        film += event.added / np.pi * np.arctan((times - event.time) / event.width)
    return times, film - film[0]


def events_of(sources: Sequence[Source], window: tuple[float, float]) -> list[Event]:
    """Near misses and first contacts of `sources` within a window (first and last time, s).

    Events of two sources that are closer than half a width are one.
    """
    found: dict[float, tuple[float, March]] = {}
    for source in sources:
        found |= _events(source, window)
    events: list[Event] = []
    for time, (added, march) in sorted(found.items(), key=lambda item: (-item[1][0], item[0])):
        # The time in which the head travels `EVENT_WIDTH` spacings.
        width = EVENT_WIDTH * float(march.dragon.spacings.min()) / float(march.speed_profile.at(time))
        apart = all(abs(time - other.time) > width / 2 for other in events)
        if apart and window[0] <= time <= window[1]:
            events.append(Event(time, added, width))
    share = min(1.0, EVENTS_TIME / max(1e-9, sum(event.added for event in events)))
    return sorted((replace(event, added=share * event.added) for event in events), key=lambda event: event.time)


def _events(source: Source, window: tuple[float, float]) -> dict[float, tuple[float, March]]:
    """Times of the events of a source, s, each with the time that it adds to the film, s, and the march."""
    march, (begin, end) = march_of(source), window
    found: dict[float, tuple[float, March]] = {}
    if isinstance(source, Run):
        begin, end = max(begin, float(source.times[0])), min(end, float(source.times[-1]))
        if source.first_contact is not None:
            found[source.first_contact.time] = (CONTACT_TIME, march)
        if source.guide == "none" or "live" in source.provenance:
            # Its near misses are not those of the exact model.
            return found
    if begin < end:
        exact = first_contact_until(march, begin, end)
        found |= {miss.time: (NEAR_MISS_TIME, march) for miss in exact.near_misses or ()}
        if isinstance(source, March) and exact.contact:
            found[exact.contact.time] = (CONTACT_TIME, march)
    return found
