"""The result of a search for the first contact."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

from pymunk_dragon._language import text
from pymunk_dragon.model._display import TextResult
from pymunk_dragon.model.contact import Contact, contact_text

Status = Literal["contact", "clear", "overlapping", "unreachable"]

# m. Resolution above which the text of a result names it.
_COARSE = 1e-8
# Decimals of a contact's time in the text of a result that is certified.
_CERTIFIED_DECIMALS = 9
# Decimals of a contact's time in the text of a result from samples.
_SAMPLED_DECIMALS = 6


@dataclass(frozen=True, kw_only=True)
class NearMiss:
    """A local minimum of the gap between two benches.

    Attributes
    ----------
    time : float
        s; accurate to a few microseconds only, because the gap is stationary there.
    benches : tuple of int
        The smaller number first.
    gap : float
        m.

    Examples
    --------
    >>> print(NearMiss(time=409.832, benches=(0, 11), gap=0.000865))
    near miss at t = 409.8320 s: benches 0 and 11, 0.865 mm apart
    """

    time: float
    benches: tuple[int, int]
    gap: float

    def __str__(self) -> str:
        i, j = self.benches
        line = text("near miss at t = {t:.4f} s: benches {i} and {j}, {gap:.3f} mm apart")
        return line.format(t=self.time, i=i, j=j, gap=1e3 * self.gap)


@dataclass(frozen=True, kw_only=True)
class FirstContact(TextResult):
    """Result of a search for the first contact of benches that are not neighbours.

    Attributes
    ----------
    status : {"contact", "clear", "overlapping", "unreachable"}
        "contact": two benches touch at `time`. "clear": no benches touch until the end.
        "overlapping": two benches overlap at the start. "unreachable": the chain has no state after
        `time`, and no benches touch before.
    time : float
        Of the contact, the end, the start or the last state, s.
    benches : tuple of int or None
        Benches that touch or overlap, the smaller number first.
    point : tuple of float or None
        Contact point, m.
    normal : tuple of float or None
        Unit vector from the first bench towards the second.
    near_misses : tuple of NearMiss or None
        Local minima of gaps below a thirtieth of the width before `time`, in the order of time. If
        all benches behind the head pass through the same poses, only those of benches 0 and 1. None
        if gaps were not measured.
    resolution : float or None
        Largest overlap before `time` that the certificate does not rule out, m: rounding, about a
        micrometre where a gap stays near zero for long, and 0.1 mm where the march ends because the
        chain has no state after it. None if nothing was certified.
    samples : int
        Number of times at which poses were computed.
    tests : int
        Number of pair tests at all of these times.

    Examples
    --------
    >>> from pymunk_dragon import March, first_contact
    >>> print(first_contact(March(), start=410))
    first contact at t = 412.473837682 s: benches 0 and 8 at (1.474395, 2.110665) m
    """

    status: Status
    time: float
    benches: tuple[int, int] | None
    point: tuple[float, float] | None
    normal: tuple[float, float] | None
    near_misses: tuple[NearMiss, ...] | None
    resolution: float | None
    samples: int
    tests: int

    def to_dict(self) -> dict[str, Any]:
        """Values in SI units that `contact --json` prints.

        `time` is None without a contact, and `until` is the last time.
        """
        time = None if self.benches is None else self.time
        return asdict(self) | {"time": time, "until": self.time}

    def __str__(self) -> str:
        decimals = _SAMPLED_DECIMALS if self.resolution is None else _CERTIFIED_DECIMALS
        first = contact_text(self.status, self.benches, self.point, self.time, decimals)
        lines = [first, *map(str, self.near_misses or ())]
        if self.resolution is not None and self.resolution > _COARSE:
            line = text("benches that overlap by less than {amount:.2g} micrometres count as apart")
            lines.append(line.format(amount=1e6 * self.resolution))
        return "\n".join(lines)

    @property
    def contact(self) -> Contact | None:
        """The result as a `Contact`, the class of `Run.first_contact`; None without a contact."""
        if self.status != "contact" or not (self.benches and self.point and self.normal):
            return None
        when: dict[str, float] = {"time": self.time, "raw_time": self.time, "depth": 0.0}
        return Contact(benches=self.benches, point=self.point, normal=self.normal, **when)
