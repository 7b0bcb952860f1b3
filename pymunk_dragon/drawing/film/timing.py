"""Times of a film's frames, at a constant speed or at one that falls towards near misses and contacts.

Without `speedup`, the time of the film is a smooth, rising function of the simulated time t: t /
rate, and a sigmoid (arctan) for every event, which adds a duration around the event. So the film
plays at `rate` far from all events, and slows down towards each of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon.drawing.film.settings import Film
from pymunk_dragon.drawing.film.take import Take
from pymunk_dragon.errors import ParameterError

# Largest travel of the head per frame, in shortest spacings of the body: 0.66 m of the paper's 1.65
# m. From half a spacing on, a bench is nearer to the previous position of the next bench than to
# its own: the dragon creeps backwards. If the camera follows the head, 0.17 m, because the ground
# moves through a view of about 6 m.
_ADVANCE = {"field": 0.4, "head": 0.1}
# s: length of a film whose start is chosen, without the hold of its last frame: 170 frames, or a
# GIF of 3.7 MB.
_CHOSEN_LENGTH = 8.5
# s: shortest film without hold, and the longest without events. A shorter one plays at half of real
# time far from events, or slower if the limit on the head's travel demands it; a longer one does
# not keep this limit.
_SHORTEST, _LONGEST, _SLOWEST = 5.5, 60.0, 0.5
# s of film that a near miss adds, and that a contact adds (a film that ends with it has half).
_NEAR_MISS_TIME, _CONTACT_TIME = 1.0, 2.0
# Half of the width of an event, in shortest spacings travelled: 0.7 m.
_EVENT_WIDTH = 0.45
# Frames: a quarter of an hour. A larger number is taken for a typing error.
_MAX_FRAMES = 20_000
# Points at which the time of the film is computed. Between them it is linear.
_POINTS = 20_001


@dataclass(frozen=True)
class Timing:
    """Simulated times (F,) of the frames of a film, s; frames per second; and how long the last frame stays, s.

    `size` is the width and height of the film in its file, pixels; None before it is written.
    `is_cropped` is whether the pictures lost a row or a column there.
    """

    times: Array
    fps: int
    hold: float
    size: tuple[int, int] | None = None
    is_cropped: bool = False

    @property
    def ends(self) -> Array:
        """Film times (F,) at which the frames end, s."""
        count = len(self.times)
        return np.append(np.arange(1, count), count - 1 + max(1.0, self.hold * self.fps)) / self.fps


@dataclass(frozen=True)
class _Event:
    """A near miss or a contact: simulated time, s, duration of film that it adds, s, and its width, s."""

    time: float
    added: float
    width: float


def frame_times(takes: Sequence[Take], film: Film) -> Timing:
    """Return the times of the frames of a film; a ParameterError if there are too many frames."""
    start, until = takes[0].window
    if film.speedup is None and start < until:
        return Timing(_slowed(takes, film), film.fps, film.hold)
    step = (film.speedup or 1.0) / film.fps
    # A remainder of rounding error gets no frame of its own; the last time is always there.
    count = math.ceil((until - start) / step - 1e-6)
    if count > _MAX_FRAMES:
        raise ParameterError(
            "speedup", film.speedup, f"such that the film has at most {_MAX_FRAMES} frames"
        )
    times = np.minimum(start + step * np.arange(count + 1), until)
    return Timing(times, film.fps, film.hold)


def _slowed(takes: Sequence[Take], film: Film) -> Array:
    """Times of a film that slows down towards events. Without `film.start` it may begin after the window's first time.

    In a frame the head travels at most so many shortest spacings of the body as `_ADVANCE` says.
    """
    start, until = window = takes[0].window
    # s: the least time in which the head travels so far. Without the head's spacing, if there is
    # another.
    marches = [take.march for take in takes]
    spacings = [
        float(march.dragon.spacings[-max(1, march.dragon.benches - 1) :].min()) for march in marches
    ]
    fastest = [march.speed_profile.fastest(start, until) for march in marches]
    least = min(spacing / speed for spacing, speed in zip(spacings, fastest, strict=True))
    rate = film.fps * _ADVANCE[film.camera.follow] * least
    events = _events_of(takes)
    if film.start is None:
        times, shown = _film_times(window, rate, events)
        start = float(np.interp(shown[-1] - _CHOSEN_LENGTH, shown, times))
    rate = max(rate, (until - start) / _LONGEST)
    _, added = _film_times((start, until), math.inf, events)
    if added[-1] + (until - start) / rate < _SHORTEST:
        rate = max((until - start) / (_SHORTEST - float(added[-1])), min(rate, _SLOWEST))
    times, shown = _film_times((start, until), rate, events)
    count = max(1, round(shown[-1] * film.fps))
    chosen: Array = np.interp(shown[-1] * np.arange(count + 1) / count, shown, times)
    chosen[0], chosen[-1] = start, until
    return chosen


def _film_times(
    window: tuple[float, float], rate: float, events: Sequence[_Event]
) -> tuple[Array, Array]:
    """Simulated times (P,), s, and the times in the film at which they are shown, from 0 s on."""
    times = np.linspace(*window, _POINTS)
    film = (times - times[0]) / rate
    for event in events:
        film += event.added / np.pi * np.arctan((times - event.time) / event.width)
    return times, film - film[0]


def _events_of(takes: Sequence[Take]) -> list[_Event]:
    """Near misses and first contacts in a film. Events of two takes that are closer than half a width are one."""
    found = [event for take in takes for event in _events(take)]
    events: list[_Event] = []
    for event in sorted(found, key=lambda event: (-event.added, event.time)):
        if all(abs(event.time - other.time) > event.width / 2 for other in events):
            events.append(event)
    return sorted(events, key=lambda event: event.time)


def _events(take: Take) -> list[_Event]:
    """Near misses and first contact of one take while it moves."""
    start, until = take.moving
    added = {miss.time: _NEAR_MISS_TIME for miss in take.near_misses}
    contact = take.contact
    if contact is not None and start <= contact.time <= until:
        added[contact.time] = _CONTACT_TIME

    # The time in which the head travels `_EVENT_WIDTH` spacings.
    width = _EVENT_WIDTH * float(take.march.dragon.spacings.min())
    speed = take.march.speed_profile.at
    return [_Event(time, each, width / float(speed(time))) for time, each in added.items()]
