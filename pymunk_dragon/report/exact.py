"""What the exact model says about a run: the first contact, and the near misses on the way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.errors import ParameterError, UnreachableError
from pymunk_dragon.run import Run

__all__ = ["exact_impact", "with_exact_contact"]


def exact_impact(run: Run) -> FirstContact | None:
    """The exact model's first contact and near misses over the time of `run`; None where there is no time to look over.

    A contact of a dragon that is kept on its path is the exact model's own, a little early or late: there the exact
    model looks until it finds one, or for as long again where the curve has no end. Any other run is looked at until
    its end.
    """
    if not isinstance(run, Run):
        raise ParameterError("run", run, "a Run")
    start, end = float(run.times[0]), float(run.times[-1])
    until = end
    if run.first_contact and run.provenance.get("guide") != "none":
        until = min(run.march.end, max(end, 2 * end - start))
    try:
        return first_contact(run.march, start=start, until=until)
    except (ParameterError, UnreachableError):
        # A single moment, or times at which the dragon has no place, as a file that was changed by hand may hold.
        return None


def with_exact_contact(run: Run, impact: FirstContact | None) -> Run:
    """`run` as it is; but one of the exact player, who places benches and looks for nothing, with the exact contact.

    The moment of the contact is a frame of it.
    """
    contact = impact.contact if impact is not None else None
    if run.provenance.get("player") != "exact" or contact is None:
        return run
    place = int(np.searchsorted(run.times, contact.time))
    state = run.march.at([contact.time])
    velocities = run.pose_velocities
    return replace(
        run,
        times=np.insert(run.times, place, contact.time),
        poses=np.insert(run.poses, place, state.poses[0], axis=0),
        pose_velocities=None if velocities is None else np.insert(velocities, place, state.pose_velocities[0], axis=0),
        drift=np.insert(run.drift, place, 0.0, axis=0),
        first_contact=contact,
        outcome="contact",
    )
