"""Times of a film's frames.

The speed is constant, or falls towards near misses and contacts.

Without `speedup`, the time of the film is a smooth, rising function of the simulated time t: t /
rate, and a sigmoid (arctan) for every event, which adds a duration around the event. So the film
plays at `rate` far from all events, and slows down towards each of them.
"""

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
_ADVANCE = {"field": 0.4, "head": 0.1, "cut": 0.4}
# s: length of a film whose start is chosen, without the hold of its last frame: 170 frames, or a
# GIF of 3.7 MB.
_CHOSEN_LENGTH = 8.5
# s: shortest film without hold. A shorter one plays at `_SLOWEST` far from events, or slower if the
# limit on the head's travel demands it.
_SHORTEST = 5.5
# s: longest film without hold and without events. A longer one does not keep the limit on the
# head's travel.
_LONGEST = 60.0
# Simulated seconds per second of film: half of real time.
_SLOWEST = 0.5
# s of film that a near miss adds.
_NEAR_MISS_TIME = 1.0
# s of film that a contact adds; a film that ends with it has half.
_CONTACT_TIME = 2.0
# Half of the width of an event, in shortest spacings travelled: 0.7 m.
_EVENT_WIDTH = 0.45
# Half widths of an event before it, at which a camera cuts to the head: the film is still fast.
_CUT_BEFORE = 6.0
# Frames: a quarter of an hour. A larger number is taken for a typing error.
_MAX_FRAMES = 20_000
# Points at which the time of the film is computed. Between them it is linear.
_POINTS = 20_001


@dataclass(frozen=True)
class Timing:
    """Simulated times (F,) of the frames of a film, s, and frames per second.

    `hold` is how long the last frame stays, s. `size` is the width and height of the film in its
    file, pixels; None before it is written. `is_cropped` is whether the pictures lost a row or a
    column there.
    """

    times: Array
    fps: int
    hold: float
    size: tuple[int, int] | None = None
    is_cropped: bool = False

    @property
    def ends(self) -> Array:
        """Film times (F,) at which the frames end, s."""
        last = len(self.times) - 1
        ends = np.arange(1.0, last + 2)
        ends[-1] = last + max(1.0, self.hold * self.fps)
        return ends / self.fps


@dataclass(frozen=True)
class _Event:
    """A near miss or a contact: its simulated time, the film that it adds, and its width, all s."""

    time: float
    added: float
    width: float


def frame_times(takes: Sequence[Take], film: Film) -> Timing:
    """Times of the frames of a film; a ParameterError is raised if there are too many frames."""
    start, until = takes[0].window
    if film.speedup is None and start < until:
        return Timing(_slowed(takes, film), film.fps, film.hold)
    step = (film.speedup or 1.0) / film.fps
    # A remainder of rounding error gets no frame of its own; the last time is always there.
    count = math.ceil((until - start) / step - 1e-6)
    if count > _MAX_FRAMES:
        bound = f"such that the film has at most {_MAX_FRAMES} frames"
        raise ParameterError("speedup", film.speedup, bound)
    times = np.minimum(start + step * np.arange(count + 1), until)
    return Timing(times, film.fps, film.hold)


def cut_time(takes: Sequence[Take]) -> float:
    """Time, s, at which a camera cuts from the field to the head; inf if nothing is near."""
    events = _events_of(takes)
    return events[0].time - _CUT_BEFORE * events[0].width if events else math.inf


def _slowed(takes: Sequence[Take], film: Film) -> Array:
    """Times of a film that slows down towards events.

    Without `film.start` it may begin after the window's first time. In a frame the head travels at
    most so many shortest spacings of the body as `_ADVANCE` says.
    """
    start, until = window = takes[0].window
    events = _events_of(takes)
    # s: the least time in which the head travels a spacing of the body.
    least = math.inf
    for march in (take.march for take in takes):
        fastest = march.speed_profile.fastest(start, until)
        least = min(least, float(march.dragon.spacings[1:].min()) / fastest)
    rate = film.fps * _ADVANCE[film.camera.follow] * least
    if film.start is None:
        times, shown = _film_times(window, rate, events)
        start = float(np.interp(shown[-1] - _CHOSEN_LENGTH, shown, times))
    duration = until - start
    rate = max(rate, duration / _LONGEST)

    # A film that would be too short plays more slowly, but not below half of real time.
    _, added = _film_times((start, until), math.inf, events)
    if added[-1] + duration / rate < _SHORTEST:
        needed = duration / (_SHORTEST - float(added[-1]))
        rate = max(needed, min(rate, _SLOWEST))

    times, shown = _film_times((start, until), rate, events)
    count = max(1, round(shown[-1] * film.fps))
    even = shown[-1] * np.arange(count + 1) / count
    chosen: Array = np.interp(even, shown, times)
    chosen[0] = start
    chosen[-1] = until
    return chosen


def _film_times(
    window: tuple[float, float], rate: float, events: Sequence[_Event]
) -> tuple[Array, Array]:
    """Simulated times (P,), s, and the times in the film at which they are shown, from 0 s on."""
    times = np.linspace(*window, _POINTS)
    film = (times - times[0]) / rate
    for event in events:
        sigmoid = np.arctan((times - event.time) / event.width)
        film += event.added / np.pi * sigmoid
    return times, film - film[0]


def _events_of(takes: Sequence[Take]) -> list[_Event]:
    """Near misses and first contacts in a film, by time.

    Events of two takes that are closer than half a width are one, the one that adds most film.
    """
    found = [event for take in takes for event in _events(take)]
    events: list[_Event] = []
    for event in sorted(found, key=lambda event: (-event.added, event.time)):
        if all(abs(event.time - other.time) > event.width / 2 for other in events):
            events.append(event)
    return sorted(events, key=lambda event: event.time)


def _events(take: Take) -> list[_Event]:
    """Near misses and first contact of one take while it moves."""
    search = take.search
    added = {}
    if search is not None and take.keeps_to_march:
        # A run with free benches does not have the near misses of the exact model.
        added = {miss.time: _NEAR_MISS_TIME for miss in search.near_misses or ()}
    if take.contact is not None:
        added[take.contact.time] = _CONTACT_TIME

    # The time in which the head travels `_EVENT_WIDTH` spacings.
    width = _EVENT_WIDTH * float(take.march.dragon.spacings.min())
    speed = take.march.speed_profile.at
    start, until = take.moving
    events = []
    for time, film in added.items():
        if start <= time <= until:
            events.append(_Event(time, film, width / float(speed(time))))
    return events
