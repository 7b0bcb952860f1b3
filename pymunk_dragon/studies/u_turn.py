"""The turn of the contest's question 4, and the shortest turn that was found inside its circle.

Two arcs. Entry and exit are opposite to each other, 2 R apart, and their tangents are parallel, at
an angle a to the diameter between them. Any two arcs tangent to both and to each other turn by 2 a
each. Their chords, 2 r sin a each, lie on the diameter, one after the other, so (r1 + r2) sin a =
R, and the length is 2 a (r1 + r2) = 2 a R / sin a. It does not depend on the ratio of the radii.

Five arcs. The diameter, 2 R, is the only geometric limit, but the handles behind the head become
faster as the turn becomes shorter. So the search is for the shortest turn on which no handle goes
faster, relative to the head, than on the contest's own turn. It samples these speeds; the largest
one on the turn that it finds is certified, as by `max_speed`. The chord of an arc is at the mean
angle of the tangents at both ends. So the entry and its tangent, and the points at which arcs end,
determine these arcs. Two more arcs lead to the exit with its tangent if the angle between their
chords is half the angle that they turn by; the ratio of the chords is free. The unknowns are the
points at which the first three arcs end, as complex numbers in units of the entry, and the
logarithm of that ratio.

The method is sequential linear programming: the constraints are linearised by differences, and
`scipy.optimize.linprog` finds the best step inside a trust region. Speeds have kinks where a handle
passes from one arc to the next; they are sampled at fixed fractions of the time intervals between
kinks, where they depend smoothly on the unknowns. The problem is not convex, so the result is the
best turn near the start.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pymunk_dragon._arrays import Array, Complex, as_complex, as_vectors
from pymunk_dragon._checks import flag, function, silent
from pymunk_dragon._extras import library
from pymunk_dragon._language import text
from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.errors import DragonError, ParameterError, UnreachableError
from pymunk_dragon.model import chain
from pymunk_dragon.model.curves import Arc, Composite, UTurn
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.studies._study import Progress, Result, checked_dragon, labelled
from pymunk_dragon.studies.max_speed import largest_ratio

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# m travelled by the head after it enters the circle: at 1 m/s, the times in s that the contest's
# table requires.
_DISTANCES = np.arange(-100.0, 101.0)
# Unknowns at the start of the search: short, sharp arcs at both ends, and long ones between.
_START = (0.95, -0.1, 0.4, -0.2, -0.5, 0.2, -2.5)
# m. Least radius of an arc: smaller radii save centimetres, and slow down the certificate of first
# contact.
_MIN_RADIUS = 0.5
# m. Least length of an arc.
_MIN_ARC = 0.02
# m travelled by the head from one chain to the next in the search.
_SAMPLING = 0.02
# m travelled by the head beyond the turn while speeds are sampled.
_HEAD_MARGIN = 9.0
# m behind the circle up to which handles are included.
_CHAIN_MARGIN = 3.0
# Samples of the speeds from one kink to the next.
_SAMPLES = 8
# Positions of handles for the sampled ratio of a result.
_POSITIONS = 200_000
# Steps of a search, at most.
_STEPS = 80
# First size of the trust region, in units of the unknowns.
_FIRST_SIZE = 0.1
# Largest size of the trust region.
_MAX_SIZE = 0.2
# Size of the trust region at which the search ends.
_MIN_SIZE = 1e-5
# Factor on the size after a better turn.
_GROWTH = 1.6
# Factor on the size after any other.
_SHRINKAGE = 1 / 3
# Size of the trust region for each unknown: the last one may change by more.
_SCALES = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 5.0])
# m per unit of a violated constraint: several times the Lagrange multiplier of the speed.
_PENALTY = 4.0
# Violation by a bench that is pushed back or has no position.
_STUCK = 10.0
# Constraints closer to their limits than this are linearised.
_NEAR = 0.4
# Step of the differences.
_DIFFERENCE = 1e-7
# Relative excess of a certified ratio that its decimals do not show.
_SHARP = 1e-9
# Distance kept from the limits in the first search.
_MARGIN = 1e-4
# Searches, at most, each with a wider distance from the limits.
_REPAIRS = 4


# Largest ratio of a handle's speed to the head's, and its excess; None if the ratio is sampled.
_Peak = tuple[float, float | None]


@dataclass(frozen=True, kw_only=True)
class MarchedTurn:
    """A turn, its first contact and its largest ratio of speeds.

    Attributes
    ----------
    path : Composite
        The path between both spirals.
    march : March
        The march on the path; handle 0 enters the circle at t = 0.
    contact : FirstContact
        Certified first contact while the head travels from 100 m before the entry of the circle to
        100 m after it.
    ratio : float
        Largest ratio of a handle's speed to the head's.
    excess : float or None
        Relative amount by which the true ratio may be larger, as in `max_speed`. It is None where
        the benches behind the head differ: then the ratio is the largest of samples while the head
        goes through the turn, and the true one may be larger by any amount.
    """

    path: Composite
    march: March
    contact: FirstContact
    ratio: float
    excess: float | None

    @property
    def fastest(self) -> str:
        """A sentence about the largest ratio of speeds."""
        # To four decimals, on the side of the truth.
        low = math.floor(1e4 * self.ratio) / 1e4
        if self.excess is None:
            least = text("some handle is at least {low:.4f} times as fast as the head")
            return least.format(low=low)
        if self.excess > _SHARP:
            high = math.ceil(1e4 * self.ratio * (1 + self.excess)) / 1e4
            between = text(
                "the fastest handle is {low:.4f} to {high:.4f} times as fast as the head"
            )
            return between.format(low=low, high=high)
        exact = text("the fastest handle is {ratio:.4f} times as fast as the head")
        return exact.format(ratio=self.ratio)

    @property
    def length(self) -> float:
        """Length from the entry of the circle to its exit, m."""
        return self.path.joints[-1] - self.path.joints[0]

    def to_dict(self) -> dict[str, Any]:
        """Length, first contact, and largest ratio of speeds; no excess where it is sampled."""
        return {
            "length": self.length,
            "contact": self.contact.to_dict(),
            "peak_speed_ratio": self.ratio,
            "peak_speed_excess": self.excess,
        }

    def lines(self) -> list[str]:
        """Lines about the contact and the fastest handle."""
        first = str(self.contact).partition("\n")[0]
        if self.excess is None:
            return [labelled(text("certified:"), first), labelled(text("sampled:"), self.fastest)]
        return [labelled(text("certified:"), f"{first}\n{self.fastest}")]


@dataclass(frozen=True, kw_only=True, repr=False)
class TurnResult(Result):
    """The contest's turn and the shortest turn that was found.

    Attributes
    ----------
    turn : UTurn
        The contest's turn.
    times : tuple of float
        The 201 times of the contest's table, result4.xlsx, s: from -100 to 100 s at a head speed of
        1 m/s. At other speeds the head travels the same distances, from 100 m before the entry of
        the circle to 100 m after it.
    contests : MarchedTurn
        The contest's turn, marched.
    shortest : MarchedTurn or None
        The shortest turn that was found; None without the search.
    """

    turn: UTurn
    times: tuple[float, ...]
    contests: MarchedTurn
    shortest: MarchedTurn | None = None

    @property
    def march(self) -> March:
        """The march on the contest's turn."""
        return self.contests.march

    def to_dict(self) -> dict[str, Any]:
        """Values in SI units, as `study u-turn --json` prints them."""
        shortest = None
        if self.shortest is not None:
            arcs = [
                {"curvature": float(arc.curvature(0.0)), "length": arc.end_s}
                for arc in self.shortest.path.pieces[1:-1]
            ]
            shortest = {"proven": False, "arcs": arcs, **self.shortest.to_dict()}
        names = ("radii", "centres", "sweeps", "tangent_points")
        shape = {name: getattr(self.turn, name).tolist() for name in names}
        return {**self.contests.to_dict(), **shape, "shortest": shortest}

    def _lines(self) -> list[str]:
        arcs = text(
            "{length:.6f} m on arcs of {first:.6f} and {second:.6f} m,\n"
            "each of {angle:.6f} degrees,\nabout ({x:.6f}, {y:.6f}) and ({u:.6f}, {v:.6f}) m;\n"
            "as long with any other ratio of the radii"
        )
        first, second = self.turn.radii
        (x, y), (u, v) = self.turn.centres
        angle = math.degrees(abs(self.turn.sweeps[0]))
        arcs = arcs.format(
            length=self.turn.length, first=first, second=second, angle=angle, x=x, y=y, u=u, v=v
        )
        lines = [labelled(text("the turn:"), arcs), *self.contests.lines()]
        if self.shortest is None:
            return lines

        if self.shortest.path == self.turn:
            return [*lines, labelled(text("shorter:"), text("no turn on five arcs was found"))]
        best = text(
            "{length:.4f} m on {arcs} arcs with radii of at least {radius:g} m:\n"
            "best found, not proven to be the shortest"
        )
        count = len(self.shortest.path.pieces) - 2
        best = best.format(length=self.shortest.length, arcs=count, radius=_MIN_RADIUS)
        return [*lines, labelled(text("shorter:"), best), *self.shortest.lines()]

    def _draw(self) -> Figure:
        """Both paths in the circle."""
        from pymunk_dragon.drawing.figures import style

        title = text("The turn is {:.4f} m long on any two arcs", self.turn.length)
        figure, axes = style.slide(title, self.contests.fastest)
        angles = np.linspace(0, 2 * np.pi, 400)
        circle = self.turn.radius * np.array([np.cos(angles), np.sin(angles)])
        axes.plot(*circle, color=style.COLOURS.motion, ls="--")

        for marched, colour in ((self.contests, style.BLUE), (self.shortest, style.AMBER)):
            if marched is not None:
                path = marched.path
                name = text("{} arcs, {:.4f} m", len(path.pieces) - 2, marched.length)
                # With parts of both spirals.
                s = np.linspace(-4.0, path.joints[-1] + 4.0, 1200)
                axes.plot(*path.point(s).T, color=colour, label=name)
                axes.plot(*path.point(path.joints).T, "o", color=colour, ms=5)
        axes.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
        return figure


def u_turn(
    dragon: Dragon | None = None,
    *,
    pitch: float = 1.7,
    radius: float = 4.5,
    ratio: float = 2.0,
    speed: float = 1.0,
    search: bool = True,
    progress: Progress = silent,
) -> TurnResult:
    """The turn of question 4, its first contact, and the shortest turn on five arcs that is found.

    Parameters
    ----------
    dragon : Dragon, optional
        The dragon; by default the contest's.
    pitch : float
        Radial distance between turns of the spirals, m, as in `UTurn`.
    radius : float
        Radius of the circle, m, as in `UTurn`.
    ratio : float
        Ratio of the radii of the arcs, as in `UTurn`.
    speed : float
        Speed of the head, m/s, as in `March`.
    search : bool
        Whether to search for the shortest turn on which no handle goes faster, relative to the
        head, than on the contest's; this needs SciPy. No proof shows that there is no shorter one.
        Where none is found, it is the contest's. The largest speeds are certified, or sampled if
        the benches behind the head differ.
    progress : callable, optional
        Called with the part of the search that is done and the whole.

    Raises
    ------
    ParameterError
        If a value is out of range, or if the dragon does not get round the contest's turn.
    MissingExtraError
        If the search needs SciPy and it is not installed.

    Examples
    --------
    >>> found = u_turn(Dragon(benches=12), search=False)
    >>> print(f"{found.turn.length:.6f} m")
    13.621245 m
    """
    dragon = checked_dragon(dragon)
    function("progress", progress)
    flag("search", search)
    if search:
        # A missing library is named before the work, which takes a second and more.
        library("scipy.optimize")
    turn = UTurn(pitch=pitch, radius=radius, ratio=ratio)
    wide = "large enough for the dragon to get round the turn"
    too_small = ParameterError("radius", turn.radius, wide)
    try:
        peak = _largest_ratio(dragon, turn, turn)
    except UnreachableError as error:
        raise too_small from error
    if math.isinf(peak[0]):
        raise too_small
    times = tuple(March(dragon, turn, speed=speed).time(_DISTANCES).tolist())

    def marched(path: Composite, ratio: float, excess: float | None) -> MarchedTurn:
        march = March(dragon, path, speed=speed)
        contact = first_contact(march, start=times[0], until=times[-1])
        return MarchedTurn(path=path, march=march, contact=contact, ratio=ratio, excess=excess)

    shortest = marched(*_shortest_turn(turn, dragon, peak, progress)) if search else None
    return TurnResult(turn=turn, times=times, contests=marched(turn, *peak), shortest=shortest)


def _followed(turn: UTurn, dragon: Dragon) -> Array:
    """Spacings of the foremost benches, which are in the turn with the head."""
    ends = np.cumsum(dragon.spacings)
    last = int(np.searchsorted(ends, turn.length + _CHAIN_MARGIN))
    return dragon.spacings[: last + 1]


def _largest_ratio(dragon: Dragon, path: Composite, turn: UTurn) -> _Peak:
    """Largest ratio on a path, and its excess.

    If a handle is pushed back or has no position, a certified ratio raises `ParameterError` or
    `UnreachableError`, and a sampled one is inf.
    """
    if not dragon.has_equal_benches:
        return _sampled_ratio(path, _followed(turn, dragon)), None
    search, excess = largest_ratio(dragon, path, turn.radius)
    return search.ratio, excess


def _sampled_ratio(path: Composite, spacings: Array) -> float:
    """Largest sampled ratio, from 1; inf if a handle is pushed back or has no position."""
    count = _POSITIONS // (spacings.size + 1)
    heads = np.linspace(0.0, path.joints[-1] + _HEAD_MARGIN, count)
    ratios = chain.chain_motion(path, path.chain(heads, spacings), spacings).ratios
    return float(ratios.max()) if np.all(ratios > 0) else math.inf


def _shortest_turn(
    base: UTurn, dragon: Dragon, peak: _Peak, progress: Progress
) -> tuple[Composite, float, float | None]:
    """The shortest turn found, and its largest ratio, at most that of `base`, with the excess.

    The turn is `base` where no shorter one is found.
    """
    most, _ = peak
    spacings = _followed(base, dragon)
    limit = _sampled_ratio(base, spacings)
    search = _Search(base, spacings, limit)
    for _ in range(_REPAIRS):
        arcs = search.arcs(search.run(np.array(_START), progress))
        path = arcs.path(base)
        try:
            ratio, excess = _largest_ratio(dragon, path, base)
        except DragonError:
            ratio, excess = math.inf, None

        # The search only samples, so its turn may exceed a limit a little.
        faster = (ratio - most) / (limit - 1)
        violation = max(faster, arcs.violations(base.radius).max())
        if violation <= 0:
            return path, ratio, excess
        search.margin += min(violation, _MAX_SIZE) + _MARGIN
    return base, *peak


class _Arcs(NamedTuple):
    """Successive arcs that touch each other.

    `joints` (n + 1,) are complex numbers, m; `headings` (n + 1,) are the directions there, rad; and
    `lengths` (n,) are in m.
    """

    joints: Complex
    headings: Array
    lengths: Array

    @property
    def curvatures(self) -> Array:
        """Signed curvatures (n,), 1/m."""
        return np.diff(self.headings) / self.lengths

    @property
    def centres(self) -> Complex:
        """Centres (n,) as complex numbers, m."""
        normals = 1j * np.exp(1j * self.headings[:-1])
        return np.asarray(self.joints[:-1] + normals / self.curvatures)

    def path(self, base: UTurn) -> Composite:
        """The path with the spirals of another turn; an error if an arc vanishes or is straight."""
        radii = 1 / np.abs(self.curvatures)
        begins = self.headings[:-1] - np.copysign(np.pi / 2, self.curvatures)
        sweeps = np.diff(self.headings)
        arcs = [
            Arc(centre=centre, radius=radius, begin_angle=begin, sweep=sweep)
            for centre, radius, begin, sweep in zip(
                as_vectors(self.centres), radii, begins, sweeps, strict=True
            )
        ]
        return Composite((base.pieces[0], *arcs, base.pieces[-1]))

    def violations(self, radius: float) -> Array:
        """Violations of the limits: the circle of the radius, and an arc's radius and length."""
        centres = self.centres
        bends = np.abs(self.curvatures)
        # The farthest point of a full circle is on the ray from the origin through its centre.
        normals = np.angle(1j * centres * self.curvatures)
        signs = np.sign(self.curvatures)
        turned = (normals - self.headings[:-1]) * signs % (2 * np.pi)
        farthest = np.abs(centres) + 1 / bends
        summits = np.where(turned < bends * self.lengths, farthest, 0.0)
        distances = np.concatenate([np.abs(self.joints[1:-1]), summits])
        limits = distances / radius - 1, bends * _MIN_RADIUS - 1, _MIN_ARC - self.lengths
        return np.concatenate(limits)


class _Search:
    """The optimisation problem. `margin` is the distance that is kept from the limits."""

    def __init__(self, base: UTurn, spacings: Array, limit: float) -> None:
        self.margin = _MARGIN
        self._base = base
        self._spacings = spacings
        self._limit = limit
        entry, tangent = map(as_complex, base.frame(0.0))
        self._entry = complex(entry)
        self._heading = float(np.angle(tangent))
        self._optimize = library("scipy.optimize")

    def arcs(self, x: Array) -> _Arcs:
        """The arcs of unknowns (7,)."""
        headings = [self._heading]

        def follow(chord: complex) -> None:
            """Add the direction at the end of an arc: its chord is at the mean angle of both."""
            half = float(np.angle(chord * np.exp(-1j * headings[-1])))
            headings.append(headings[-1] + 2 * half)

        points = self._entry * np.append(1, x[:6].view(complex))
        chords = [*np.diff(points)]
        for chord in chords:
            follow(chord)

        # The chords of the last two arcs lead to the exit, whose tangent is that of the entry.
        rest = -2 * self._entry - sum(chords)
        chord = rest / (1 + np.exp(x[6] + 0.5j * (self._heading - headings[-1])))
        follow(chord)
        follow(rest - chord)
        chords += [chord, rest - chord]
        lengths = np.abs(chords) / np.sinc(np.diff(headings) / (2 * np.pi))
        joints = self._entry + np.cumsum([0, *chords])
        return _Arcs(joints, np.array(headings), lengths)

    def length(self, x: Array) -> float:
        """Length of the turn, m."""
        return float(self.arcs(x).lengths.sum())

    def violations(self, x: Array) -> Array:
        """Violations of all limits, with the margin: 0 at the limit.

        Violations by speeds are in units of `limit - 1`.
        """
        arcs = self.arcs(x)
        path = arcs.path(self._base)
        heads = np.arange(0.0, self._base.length + _HEAD_MARGIN, _SAMPLING)
        chains = path.chain(heads, self._spacings).T

        # Samples are at fixed fractions of the intervals between kinks.
        kinks = [np.interp(path.joints, handle, heads) for handle in chains]
        ends = np.sort(np.concatenate(kinks))
        fractions = np.arange(_SAMPLES * (ends.size - 1)) / _SAMPLES
        sampled = np.interp(fractions, np.arange(ends.size), ends)
        handles_s = np.stack([np.interp(sampled, heads, handle) for handle in chains], axis=1)

        motion = chain.chain_motion(path, handles_s, self._spacings)
        ratios = motion.ratios[:, 1:].ravel()
        faster = (ratios - self._limit) / (self._limit - 1)
        speeds = np.where(ratios > 0, faster, _STUCK)
        return np.concatenate([speeds, arcs.violations(self._base.radius)]) + self.margin

    def cost(self, x: Array) -> float:
        """Length with a penalty for violations, m; inf where an arc vanishes or is straight."""
        try:
            return self.length(x) + _PENALTY * max(0.0, float(self.violations(x).max()))
        except DragonError:
            return np.inf

    def run(self, x: Array, progress: Progress) -> Array:
        """The best unknowns found from a start."""
        size = _FIRST_SIZE
        cost = self.cost(x)
        linear = self._linearised(x)
        for step_number in range(_STEPS):
            progress(step_number, _STEPS)
            other = x + self._step(*linear, size)
            other_cost = self.cost(other)
            if other_cost < cost:
                x = other
                cost = other_cost
                linear = self._linearised(x)
                size = min(size * _GROWTH, _MAX_SIZE)
            else:
                size *= _SHRINKAGE
            if size < _MIN_SIZE:
                break
        progress(1, 1)
        return x

    def _linearised(self, x: Array) -> tuple[Array, Array, Array]:
        """Violations (K,) near their limits, their slopes (K, 7), and those of the length (7,)."""
        values = self.violations(x)
        near = values > -_NEAR
        derivatives = self._optimize.approx_fprime
        slopes = derivatives(x, lambda x: self.violations(x)[near], _DIFFERENCE)
        return values[near], slopes, derivatives(x, self.length, _DIFFERENCE)

    def _step(self, values: Array, slopes: Array, gradient: Array, size: float) -> Array:
        """The best change (7,) of the unknowns in a trust region, by linear programming."""
        # The last unknown is the largest violation.
        found = self._optimize.linprog(
            np.append(gradient, _PENALTY),
            A_ub=np.column_stack([slopes, np.full(len(slopes), -1.0)]),
            b_ub=-values,
            bounds=[*(size * np.outer(_SCALES, [-1, 1])), (0, None)],
        )
        return np.asarray(found.x[:-1])
