"""Length of a substep, which changes gradually, and motion of the benches within it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from pymunk_dragon._arrays import Array
from pymunk_dragon.model.contact import Contact
from pymunk_dragon.model.dragon import Dragon, outlines

if TYPE_CHECKING:
    from pymunk_dragon.collision.sat import Separation

# Two steps in a row differ in length by this ratio at most. Pymunk's solver begins a step with the
# impulses of the step before. After a change by a ratio c, it begins the second step with impulses
# that are wrong by |c - 1|, and errors of several steps add up along a chain. With 1 % a step,
# forces of 30 benches that are pulled over the ground are within 2 %, and those of 100 within 10 %;
# where the step becomes a third at once, they are wrong by 113 and 194 %. The slider of a page goes
# from its middle to an end in 230 steps.
_STEP_RATIO = 1.01

# Halvings of a substep: a hundredth of a second becomes 1e-11 s, far below what the engine's poses
# are worth.
_BISECTIONS = 30


def next_length(before: float, chosen: float) -> float:
    """Length of the next step, s: the chosen one, or one between it and `before`, the last one.

    Any length may follow where no step was made yet, and `before` is 0.

    Examples
    --------
    >>> next_length(0.01, 0.02), next_length(0.01, 0.01005), next_length(0.0, 0.02)
    (0.0101, 0.01005, 0.02)
    """
    if before == 0:
        return chosen
    return min(max(chosen, before / _STEP_RATIO), before * _STEP_RATIO)


class Motion(NamedTuple):
    """Poses within a substep of even acceleration: before + share * first + share**2 * second."""

    before: Array
    first: Array
    second: Array

    def poses(self, share: float) -> Array:
        """Poses (N, 3) after a `share` of the substep, m, m, rad."""
        return self.before + share * (self.first + share * self.second)

    def rates(self, share: float) -> Array:
        """Rates of change of the poses by the share."""
        return self.first + 2 * share * self.second

    def refined(self, dragon: Dragon, contact: Contact, begin: float) -> Contact:
        """A contact of the substep that begins at `begin` s, when the benches began to touch.

        The time is the start of the substep if they touched there already, and its end if they
        touch there by rounding.
        """
        # Pages begin sooner without the search for contacts.
        from pymunk_dragon.collision.sat import separation

        pair = list(contact.benches)
        sizes = dragon.lengths[pair], dragon.widths[pair]

        def separated(share: float) -> Separation:
            return separation(*outlines(self.poses(share)[pair], *sizes))

        for touching in (0.0, 1.0):
            found = separated(touching)
            if found.distance <= 0:
                break
        else:
            return contact

        # Halve the interval between a share at which the benches are apart and one at which they
        # touch; it is empty if they touch at the start.
        apart = 0.0
        for _ in range(_BISECTIONS):
            middle = (apart + touching) / 2
            halfway = separated(middle)
            if halfway.distance <= 0:
                touching, found = middle, halfway
            else:
                apart = middle

        x, y = found.point.tolist()
        u, v = found.normal.tolist()
        time = begin + touching * (contact.raw_time - begin)
        return replace(contact, time=time, point=(x, y), normal=(u, v))
