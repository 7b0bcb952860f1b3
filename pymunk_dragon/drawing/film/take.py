"""Takes: each source of a film, with what the film shows of it.

Each march of a film is searched for its first contact here, at most once.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pymunk_dragon._checks import finite
from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.drawing.film.settings import Film
from pymunk_dragon.drawing.snapshots import Snapshots
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.contact import Contact
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.model.speed import MAX_TIME

# s: margin by which the search for a contact at the end of a film extends beyond the end.
_CONTACT_MARGIN = 1e-6
# s: duration shown of a march without a first contact, or on a curve without an end.
_DEFAULT_DURATION = 60.0

# First and last time, s.
Window = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Take(Snapshots):
    """A source of a film, and what the film shows of it.

    `window` has the first and the last time of the film, s, which are the same for all its takes.
    `beside` is the run that is shown beside its exact march. `search` is the result of the search
    for the first contact of the exact model, None if the film does not need it.
    """

    window: Window
    beside: Run | None = None
    search: FirstContact | None = None

    @property
    def contact(self) -> Contact | None:
        """First contact of the run, or of the exact march."""
        if self.run is not None:
            return self.run.first_contact
        return None if self.search is None else self.search.contact

    @property
    def moving(self) -> Window:
        """First and last time, s, of the motion in the window: an ended run does not move."""
        if self.run is None:
            return self.window
        start, until = np.clip(self.window, *self.run.interval).tolist()
        return start, until

    @property
    def keeps_to_march(self) -> bool:
        """Whether the benches move as in the exact model."""
        return self.run is None or self.run.free_from is None


def checked_sources(source: Any) -> tuple[Snapshots, ...]:
    """States of `source`, one run or march or a sequence of them."""
    sources = tuple(source) if isinstance(source, Sequence) else (source,)
    if not sources or not all(isinstance(each, Run | March) for each in sources):
        raise ParameterError("source", source, "a Run or a March, or a list of them")
    states = []
    for each in sources:
        if isinstance(each, Run):
            states.append(Snapshots(march=each.march, run=each))
        else:
            states.append(Snapshots(march=each))
    return tuple(states)


def shared_window(sources: Sequence[Snapshots]) -> Window:
    """Time interval, s, in which all sources can be shown.

    A run that has ended keeps its last frame.
    """
    intervals = [source.run.interval for source in sources if source.run is not None]
    if not intervals:
        return -MAX_TIME, min(MAX_TIME, *(source.march.end for source in sources))
    begins, ends = zip(*intervals, strict=True)
    return max(begins), max(ends)


def takes_of_film(
    sources: Sequence[Snapshots], film: Film, *, still: bool = False
) -> tuple[Take, ...]:
    """Takes of a film, or of a picture of its last time.

    A ParameterError is raised if the film's window does not fit the sources.
    """
    begin, end = shared_window(sources)
    has_run = any(source.run is not None for source in sources)
    start = film.start
    if start is None:
        start = begin if has_run else 0.0
    start = finite("start", start, begin, end, "s")

    search = None
    last = film.until
    if last is None and has_run:
        last = end
    elif last is None and len(sources) == 1:
        search, last = _default_end(sources[0].march, start)
    until = finite("until", last, start, end, "s")
    return takes_in((until if still else start, until), sources, film, search)


def takes_in(
    window: Window, sources: Sequence[Snapshots], film: Film, known: FirstContact | None = None
) -> tuple[Take, ...]:
    """Takes of a time window.

    `known` is the result of the search if it was made for the only source.
    """
    takes = []
    for each in sources:
        beside = _beside(each, sources)
        takes.append(Take(march=each.march, run=each.run, window=window, beside=beside))

    # A march and its runs share one search.
    searches: dict[int, FirstContact | None] = {}
    for key, march in {id(take.march): take.march for take in takes}.items():
        own = [take for take in takes if take.march is march]
        searches[key] = known or _search(march, own, film)
    return tuple(replace(take, search=searches[id(take.march)]) for take in takes)


def _default_end(march: March, start: float) -> tuple[FirstContact | None, float]:
    """Search for the default end of a film of a march, if one is needed, and this end, s.

    The end is the time of the first contact, or 60 s after `start` if there is none, or if the
    curve has no end.
    """
    search = None
    if start < march.end < math.inf:
        search = first_contact(march, start=start)
        if search.contact is not None:
            return search, search.time
    return search, min(start + _DEFAULT_DURATION, march.end)


def _beside(source: Snapshots, sources: Sequence[Snapshots]) -> Run | None:
    """Run that is shown beside its exact march, with its position errors.

    Benches that the head pulls exactly have none.
    """
    if source.run is not None:
        return None
    runs = (other.run for other in sources if other.march is source.march)
    return next((run for run in runs if run is not None and not run.is_pulled), None)


def _search(march: March, takes: Sequence[Take], film: Film) -> FirstContact | None:
    """Search for the first contact in the time for which a film needs it, if it does.

    The `takes` are those of one march.
    """
    begins = []
    ends = []
    for take in takes:
        # The first contact of a run is known, and near misses are not needed at a constant speed.
        if not take.keeps_to_march or (take.run is not None and film.speedup is not None):
            continue
        start, until = take.moving
        beside = take.beside
        if beside and beside.first_contact and beside.first_contact.time <= start:
            # A contact before the window is still shown in it.
            start, _ = beside.interval
        if start < until:
            begins.append(start)
            ends.append(until)
    if not begins:
        return None
    # A contact at the end is included.
    until = max(ends)
    end = min(until + _CONTACT_MARGIN, march.end)
    found = first_contact(march, start=min(begins), until=end)
    return replace(found, time=min(found.time, until))
