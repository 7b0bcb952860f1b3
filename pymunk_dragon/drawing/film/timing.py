"""Times of a film's frames, at a constant speed or at one that falls towards near misses and contacts.

Without `speedup`, the time of the film is a smooth, rising function of the simulated time t: t / rate, and a sigmoid
(tanh) for every event, which adds a duration around the event. So the film plays at `rate` far from all events, and
slows down towards each of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon.collision import first_contact
from pymunk_dragon.drawing.snapshots import Source
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

# Frames per second of film, unless a given window would take too long.
STANDARD_FPS = 20
# Frames per second of long windows: all have whole centiseconds, as delays in a GIF have.
LONG_FPS = (25, 50)
# Largest travel of the head per frame, in shortest spacings of the body: 0.66 m of the paper's 1.65 m. From half a
# spacing on, a bench is nearer to the previous position of the next bench than to its own: the dragon creeps backwards.
FIELD_ADVANCE = 0.4
# The same if the camera follows the head: 0.17 m, because the ground moves through a view of about 6 m.
HEAD_ADVANCE = 0.1
# s: length of a film whose start is chosen, without the hold of its last frame: 170 frames, or a GIF of 2.9 MB.
CHOSEN_LENGTH = 8.5
# s: shortest film without hold, if that needs no slow motion. It is 8 s long with the standard hold.
SHORTEST = 5.5
# s: longest film without hold. It is 20 s long with the standard hold.
LONGEST = 17.5
# s of film that a near miss adds.
NEAR_MISS_TIME = 1.0
# s of film that a contact adds. A film that ends with the contact has half of it.
CONTACT_TIME = 2.0
# s of film that all events add at most.
EVENTS_TIME = 6.0
# Half of the width of an event, in shortest spacings of the body travelled: 1 m.
EVENT_WIDTH = 0.6
# Points at which the time of the film is computed. Between them it is linear.
POINTS = 20_001
# Frames: a remainder of the window below this is rounding error and gets no frame of its own.
ROUNDING = 1e-6
# s: shortest delay of a GIF frame that browsers respect.
MIN_DELAY = 0.02


@dataclass(frozen=True)
class Timing:
    """Times of the F frames of a film.

    Attributes
    ----------
    times : ndarray, shape (F,)
        Simulated times of the frames, s.
    ends : ndarray, shape (F,)
        Film times at which the frames end, s. The last frame is shown for the film's `hold`.
    fps : int
        Frames per second.
    """

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
    """Times of a film that slows down towards events.

    Parameters
    ----------
    sources : sequence of Run or March
        What the film shows.
    window : tuple of float
        First and last time, s.
    choose_start : bool
        Whether the film may begin after the window's first time, to be `CHOSEN_LENGTH` long.
    fps : int or None
        Frames per second; None for 20, or for 25 or 50 if the film would be longer than `LONGEST`.
    hold : float
        Duration of the last frame, s.
    advance : float
        Largest travel of the head per frame, in shortest spacings of the body.
    """
    start, until = window
    if start == until:
        return constant(start, until, 1.0, fps or STANDARD_FPS, hold)
    marches = [source.march if isinstance(source, Run) else source for source in sources]
    fastest = max(float(march.speed_profile.fastest(start, until)) for march in marches)
    # Simulated seconds per frame.
    step = advance * min(float(march.dragon.spacings[1:].min(initial=np.inf)) for march in marches) / fastest
    if not math.isfinite(step):
        # A dragon of a single bench.
        step = advance / fastest
    events = events_of(sources, window)
    rate = step * (fps or STANDARD_FPS)
    if choose_start:
        times, film = _film_times(start, until, rate, events)
        start = float(np.interp(film[-1] - (CHOSEN_LENGTH), film, times))
        if start > window[0]:
            # A whole second is easier to read.
            start = min(float(math.ceil(start)), until)
    times, film = _film_times(start, until, rate, events)
    slow = film[-1] - (until - start) / rate
    chosen_fps = fps or STANDARD_FPS
    if film[-1] < SHORTEST:
        # In slow motion only if the limit on the head's travel demands it.
        rate = max((until - start) / (SHORTEST - slow), min(rate, 1.0))
    elif film[-1] > LONGEST:
        for chosen_fps in (fps,) if fps else LONG_FPS:
            rate = step * chosen_fps
            if slow + (until - start) / rate <= LONGEST:
                break
        rate = max(rate, (until - start) / (LONGEST - slow))
    times, film = _film_times(start, until, rate, events)
    count = max(1, round(film[-1] * chosen_fps))
    shown = np.interp(film[-1] * np.arange(count + 1) / count, film, times)
    shown[0], shown[-1] = start, until
    ends = np.append(np.arange(1, count + 1), count + max(1.0, hold * chosen_fps)) / chosen_fps
    return Timing(shown, ends, chosen_fps)


def events_of(sources: Sequence[Source], window: tuple[float, float]) -> list[Event]:
    """Near misses and first contacts of `sources` within a window (first and last time, s)."""
    found: dict[float, tuple[float, March]] = {}
    searched: list[March] = []
    for source in sources:
        march = source.march if isinstance(source, Run) else source
        if isinstance(source, Run) and source.first_contact is not None:
            found[source.first_contact.time] = (CONTACT_TIME, march)
        if _follows_march(source) and march not in searched:
            searched.append(march)
            begin, end = _played(source, window)
            if begin < end:
                misses = first_contact(march, start=begin, until=end).near_misses
                found |= {miss.time: (NEAR_MISS_TIME, march) for miss in misses or ()}
    inside = {time: event for time, event in found.items() if window[0] <= time <= window[1]}
    share = min(1.0, EVENTS_TIME / max(1e-9, sum(added for added, _ in inside.values())))
    return [Event(time, share * added, _width(march, time)) for time, (added, march) in sorted(inside.items())]


def _follows_march(source: Source) -> bool:
    """Whether the near misses of the exact model are those of a source."""
    return isinstance(source, March) or (source.guide != "none" and "live" not in source.provenance)


def _played(source: Source, window: tuple[float, float]) -> tuple[float, float]:
    """The part of a window, s, that a source plays."""
    if isinstance(source, March):
        return window
    return max(window[0], float(source.times[0])), min(window[1], float(source.times[-1]))


def _width(march: March, time: float) -> float:
    """Width of an event, s: the time in which the head travels `EVENT_WIDTH` spacings."""
    return EVENT_WIDTH * float(march.dragon.spacings.min()) / float(march.speed_profile.at(time))


def _film_times(start: float, until: float, rate: float, events: Sequence[Event]) -> tuple[Array, Array]:
    """Simulated times (P,), s, and the times in the film at which they are shown, from 0 s on."""
    times = np.linspace(start, until, POINTS)
    film = (times - start) / rate
    for event in events:
        film += event.added / 2 * np.tanh((times - event.time) / event.width)
    return times, film - film[0]
