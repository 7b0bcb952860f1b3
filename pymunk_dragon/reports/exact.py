"""First contact and near misses of the exact model, over the time of a run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.errors import ParameterError, UnreachableError
from pymunk_dragon.model.run import Run

__all__ = ["exact_first_contact", "with_exact_contact"]


def exact_first_contact(run: Run) -> FirstContact | None:
    """First contact and near misses of the exact model over the time of `run`; None if the search is not possible.

    The contact of a guided run may be slightly before or after the exact one. If a guided run has a contact, the search
    continues after its end, for at most the duration of the run. All other searches stop at the end of the run.
    """
    if not isinstance(run, Run):
        raise ParameterError("run", run, "a Run")
    start, end = float(run.times[0]), float(run.times[-1])
    until = end
    if run.first_contact and run.guide != "none":
        until = min(run.march.end, max(end, 2 * end - start))
    try:
        return first_contact(run.march, start=start, until=until)
    except (ParameterError, UnreachableError):
        # A run of a single frame, or times beyond the end of the curve, as in an edited file.
        return None


def with_exact_contact(run: Run, result: FirstContact | None) -> Run:
    """A run of the exact player with the first contact and a frame at its time; any other run unchanged.

    The exact player only computes poses and does not detect contacts.
    """
    contact = result.contact if result is not None else None
    if run.player != "exact" or contact is None:
        return run
    index = int(np.searchsorted(run.times, contact.time))
    state = run.march.at([contact.time])
    velocities = run.pose_velocities
    return replace(
        run,
        times=np.insert(run.times, index, contact.time),
        poses=np.insert(run.poses, index, state.poses[0], axis=0),
        pose_velocities=None if velocities is None else np.insert(velocities, index, state.pose_velocities[0], axis=0),
        drift=np.insert(run.drift, index, 0.0, axis=0),
        first_contact=contact,
        outcome="contact",
    )
