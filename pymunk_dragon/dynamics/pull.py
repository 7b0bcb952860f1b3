"""Runs of a dragon whose head pulls it, without a guide for the benches behind."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np

from pymunk_dragon._arrays import Array, Complex, as_vectors
from pymunk_dragon._checks import finite, whole
from pymunk_dragon._extras import library
from pymunk_dragon.dynamics.equations import DRAG, MAX_DRAG, PulledChain
from pymunk_dragon.dynamics.forces import guided_forces
from pymunk_dragon.dynamics.kinematics import cut_width, cuts
from pymunk_dragon.dynamics.leader import Leader
from pymunk_dragon.dynamics.search import Bodies, ContactSearch, Step
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.model.contact import Contact
from pymunk_dragon.model.march import March, checked_times, last_reachable
from pymunk_dragon.model.run import Outcome, Run, position_errors, versions

# Relative tolerances of the integrator. With a smaller one, rounding errors decide the steps.
_TOLERANCES = 1e-12, 1e-2
# rad: absolute tolerance of angles, as a share of the relative one; rad/s at 1 m/s for their rates.
# The integrator takes a mean over all benches, most of which move less than the first ones.
_ABSOLUTE = 0.35
# Tolerance from which on the method has order 5, and not 8: its steps are shorter, and between them
# it is as exact as at their ends.
_COARSE = 1e-7
# m: distance that the head travels between recorded frames, as in the engine.
_FRAME_STRIDE = 0.1
# Shortest spacings that the head travels in the longest step.
_LONGEST_STEP = 1.0
# m that the head travels from the end of a run to where a bench that is held has no state any more.
_BEFORE_LAST = 0.01
# Passes in which the time of a contact is corrected; two suffice.
_CORRECTIONS = 5
# s: a correction as small as this is the last.
_CORRECTED = 1e-12


def pull(
    march: March,
    *,
    start: float = 0.0,
    until: float | None = None,
    free_from: int = 1,
    drag: float = DRAG,
    tolerance: float = 1e-9,
) -> Run:
    """Exact run of a dragon that only its head pulls, over ground with viscous drag.

    Bench 0 has its exact motion, as in ``simulate(guide="none")``, and the others start as in the
    march. The run goes on through contacts.

    Parameters
    ----------
    march : March
        The motion of the head, and of all benches at `start`.
    start : float
        Time at which the run begins, s.
    until : float, optional
        Time at which it ends, s. By default where the curve ends, or becomes too narrow for the
        benches that are held.
    free_from : int
        The first bench that no dancer holds: those before it keep to the path. By default 1, so
        that only the head is guided.
    drag : float
        Ground drag on the benches, per metre marched, as in `EngineSettings`: velocities decay at
        this rate times the head's top speed. On ice it is 0.
    tolerance : float
        Relative tolerance of the integrator in a step, from 1e-12 to 0.01. With 1e-9 the positions
        of recorded frames are within 5 nm in the reference march until 11 s and in the turn of
        question 4, and with 1e-6 within 2 um.

    Returns
    -------
    Run
        With `drift` from the march, the forces in all joints, and the first contact, whose time is
        right to 1e-8 s at the default tolerance where the gap closes at centimetres per second.
        The search for it is not certified: it takes the rates at which pairs close from both ends
        of each step.

    Raises
    ------
    UnreachableError
        If the dragon has no state at `start`, or the benches that are held have none at `until`.

    Examples
    --------
    >>> from pymunk_dragon import March, pull
    >>> run = pull(March(), until=11)
    >>> run.first_contact.benches, round(run.first_contact.time, 8)
    ((1, 28), 10.89217814)
    """
    goes_on = until is None
    start, until = checked_times(march, start, until)
    if until > march.end:
        raise ParameterError("until", until, f"at most the end of the curve, {march.end:g} s")
    shortest = start + cut_width(march, start, until)
    if until < shortest:
        raise ParameterError("until", until, f"at least {shortest:.17g} s, with this start")
    free_from = whole("free_from", free_from, 1, march.dragon.benches - 1)
    drag = finite("drag", drag, 0.0, MAX_DRAG, "per metre")
    tolerance = finite("tolerance", tolerance, *_TOLERANCES, "")
    end = until
    if goes_on:
        until = _last_time(march, start, free_from + 1)
    top_speed = march.speed_profile.fastest(start, until)
    pulled = _Pulled(march, free_from, drag * top_speed, tolerance)

    recorder = _Recorder(pulled, _frame_times(start, until, top_speed))
    recorder.play(start, until)
    times, poses, rates, free_forces = recorder.frames()
    before = guided_forces(
        march, times, pulled.chain.drag_rate, free_forces[:, 0], benches=free_from
    )
    exact = as_vectors(march.motion_or_nan(times).points)
    origin = {
        "player": "exact",
        "guide": "none" if free_from == 1 else "rails",
        "free_from": free_from,
        "start": start,
        "until": until,
        "ground_drag": drag,
        "tolerance": tolerance,
        "versions": versions(),
    }
    ended: Outcome = "clear" if until == end else "unreachable"
    return Run(
        march=march,
        times=times,
        poses=poses,
        drift=position_errors(march.dragon, poses, exact),
        pose_velocities=rates,
        joint_forces=np.abs(np.hstack([before, free_forces])),
        first_contact=recorder.contact,
        outcome="contact" if recorder.contact else ended,
        provenance=origin,
    )


def _last_time(march: March, start: float, handles: int) -> float:
    """Last time, s, until which a march can be pulled: the end of the curve, or some before.

    Where the curve becomes too narrow for a bench, the speed of its rear handle has no limit.
    """
    march.motion(start, handles)
    reachable = last_reachable(march, start, march.end, handles, 0.0)
    if reachable == march.end:
        return reachable
    distance = float(march.distance(reachable)) - _BEFORE_LAST
    return max((start + reachable) / 2, float(march.time(distance)))


def _frame_times(start: float, until: float, top_speed: float) -> Array:
    """Times of a run's frames, s, without the one of the contact."""
    count = max(1, round((until - start) * top_speed / _FRAME_STRIDE))
    return np.linspace(start, until, count + 1)


class _Pulled:
    """A dragon whose benches from one on are free: its states are their angles and angular rates.

    A state is one array (2 M,) for M free benches, in rad and rad/s.
    """

    def __init__(self, march: March, free_from: int, drag_rate: float, tolerance: float) -> None:
        self.march = march
        self.free_from = free_from
        self.tolerance = tolerance
        dragon = march.dragon
        self._spacings = dragon.spacings[free_from:]
        sizes = self._spacings, dragon.masses[free_from:], dragon.moments[free_from:]
        self.chain = PulledChain(*sizes, drag_rate)

    def state(self, time: float) -> Array:
        """State (2 M,) of the march at a time, s, at which the benches are let go."""
        states = self.march.at(time)
        angles = states.poses[0, self.free_from :, 2]
        spins = states.pose_velocities[0, self.free_from :, 2]
        return np.concatenate([angles, spins])

    def lead(self, begin: float, end: float) -> None:
        """Take the handles that are held between two times, s, where no acceleration jumps."""
        handles = self.free_from + 1
        window = begin, end
        self.leader = Leader(self.march, handles, self.chain.drag_rate, window, self.tolerance)

    def solver(self, begin: float, state: Array, end: float) -> Any:
        """SciPy's integrator from a state at `begin` to `end`, s."""
        top_speed = self.march.speed_profile.fastest(begin, end)
        absolute = np.full(state.size, _ABSOLUTE * self.tolerance)
        absolute[state.size // 2 :] *= top_speed
        longest = _LONGEST_STEP * float(self.march.dragon.spacings.min()) / top_speed

        def rates(time: float, state: Array) -> Array:
            return self.chain.rates(state, self.leader.lead(time))

        method = "RK45" if self.tolerance >= _COARSE else "DOP853"
        tolerances = {"rtol": self.tolerance, "atol": absolute}
        integrator = getattr(library("scipy.integrate"), method)
        return integrator(rates, begin, state, end, max_step=longest, **tolerances)

    def bodies(self, times: Array, states: Array) -> Bodies:
        """Poses and rates (T, N, 3) of all benches for states (T, 2 M)."""
        held, moving = self.leader.handles(times)
        angles, spins = np.split(states, 2, axis=1)
        # Several times as fast as the exponential function of complex numbers.
        benches = self._spacings * (np.cos(angles) + 1j * np.sin(angles))
        points = _behind(held, benches)
        velocities = _behind(moving, 1j * spins * benches)
        along = held[:, :-1] - held[:, 1:]
        turning = ((moving[:, :-1] - moving[:, 1:]) / along).imag
        poses = _triples(points, np.hstack([np.angle(along), angles]))
        return Bodies(poses, _triples(velocities, np.hstack([turning, spins])))


def _behind(handles: Complex, benches: Complex) -> Complex:
    """Handles (T, H + M) from those that are held (T, H) and from the benches behind (T, M)."""
    behind = handles[:, -1:] - np.cumsum(benches, axis=1)
    return np.hstack([handles, behind])


def _triples(handles: Complex, angles: Array) -> Array:
    """Poses (T, N, 3), or their rates, from those of the handles (T, N + 1) and angles (T, N)."""
    centres = (handles[:, :-1] + handles[:, 1:]) / 2
    return np.stack([centres.real, centres.imag, angles], axis=-1)


class _Recorder:
    """Plays a pulled dragon, and keeps frames and the first contact."""

    def __init__(self, pulled: _Pulled, times: Array) -> None:
        self._pulled = pulled
        self._times = times
        self._search = ContactSearch(pulled.march.dragon)
        # Times (T,), bodies and forces (T, M) of the frames of each step.
        self._frames: list[tuple[Array, Bodies, Complex]] = []
        self.contact: Contact | None = None

    def frames(self) -> tuple[Array, Array, Array, Complex]:
        """Times (F,), poses and rates (F, N, 3), and forces (F, M) on the free benches, in order.

        The forces are those in the front holes.
        """
        times, bodies, forces = zip(*self._frames, strict=True)
        poses, rates = zip(*bodies, strict=True)
        # The contact may be in a frame, and stands before the frames of its step.
        known, order = np.unique(np.concatenate(times), return_index=True)
        recorded, moving, loads = (np.concatenate(part)[order] for part in (poses, rates, forces))
        return known, recorded, moving, loads

    def play(self, start: float, until: float) -> None:
        """Play from `start` to `until`, s."""
        march = self._pulled.march
        state = self._pulled.state(start)
        ends = cuts(march, start, until, self._pulled.free_from + 1)
        for begin, end in pairwise(ends):
            self._pulled.lead(begin, end)
            if begin == start:
                self._begin(start, state)
            solver = self._pulled.solver(begin, state, end)
            while solver.status == "running":
                message = solver.step()
                if solver.status == "failed":
                    raise DragonError(f"no motion after t = {solver.t:.6g} s: {message}")
                self._take(solver, state)
                state = solver.y

    def _begin(self, start: float, state: Array) -> None:
        """Keep the first frame, and a contact in it."""
        bodies = self._pulled.bodies(self._times[:1], state[None])
        self._keep(self._times[:1], state[None], bodies)
        pair = self._search.touching(bodies.part(0))
        if pair is not None:
            self.contact = self._contact(start, pair, bodies.part(0))

    def _take(self, solver: Any, before: Array) -> None:
        """Search a step, which began in the state `before`, and keep its frames."""
        begin = float(solver.t_old)
        end = float(solver.t)
        # Some methods evaluate the equations again for it, and few steps need it.
        interpolant = cache(solver.dense_output)

        def states(times: Array) -> Array:
            return np.asarray(interpolant()(times).T)

        def at(times: Array) -> Bodies:
            return self._pulled.bodies(times, states(times))

        frames = self._times[(begin < self._times) & (self._times <= end)]
        known = np.array([before, solver.y])
        if frames.size:
            known = np.concatenate([known, states(frames)])
        bodies = self._pulled.bodies(np.array([begin, end, *frames]), known)
        if self.contact is None:
            found = self._search.first_touch(Step(begin, end, bodies.part(slice(2)), at))
            if found is not None:
                self._confirm((begin, end), before, *found)
        if frames.size:
            self._keep(frames, known[2:], bodies.part(slice(2, None)))

    def _confirm(
        self,
        window: tuple[float, float],
        before: Array,
        time: float,
        pair: tuple[int, int],
    ) -> None:
        """Keep a contact in a step, at the time at which a step that ends there has no gap.

        The step's interpolant, in which the contact was found at `time`, is less exact than its
        ends.
        """
        begin, end = window
        for _ in range(_CORRECTIONS):
            state = before
            if time > begin:
                solver = self._pulled.solver(begin, before, time)
                while solver.status == "running":
                    solver.step()
                state = solver.y
            bodies = self._pulled.bodies(np.array([time]), state[None])
            contact = self._contact(time, pair, bodies.part(0))
            closing = _closing_rate(contact, bodies.part(0))
            correction = -contact.depth / closing if closing > 0 else 0.0
            if not _CORRECTED < abs(correction) < end - begin:
                break
            time = min(max(time + correction, begin), end)
        self.contact = replace(contact, depth=0.0)
        self._keep(np.array([contact.time]), state[None], bodies)

    def _keep(self, times: Array, states: Array, bodies: Bodies) -> None:
        """Keep frames of states (T, 2 M), and of their bodies (T, N, 3)."""
        forces = []
        for time, state in zip(times.tolist(), states, strict=True):
            angles, spins = state.reshape(2, -1)
            lead = self._pulled.leader.lead(time)
            forces.append(self._pulled.chain.forces(angles, spins, lead))
        self._frames.append((times, bodies, np.array(forces)))

    def _contact(self, time: float, pair: tuple[int, int], bodies: Bodies) -> Contact:
        """Contact of a pair of the bodies (N, 3); its depth is negative where they are apart."""
        found = self._search.separations(bodies, np.array(pair))
        return Contact(
            time=time,
            raw_time=time,
            benches=pair,
            point=tuple(found.point.tolist()),
            normal=tuple(found.normal.tolist()),
            depth=-float(found.distance),
        )


def _closing_rate(contact: Contact, bodies: Bodies) -> float:
    """Speed at which two bodies approach each other at their contact, m/s."""
    point = complex(*contact.point)
    normal = complex(*contact.normal)
    velocities = []
    for bench in contact.benches:
        x, y, _ = bodies.poses[bench].tolist()
        u, v, spin = bodies.rates[bench].tolist()
        velocities.append(complex(u, v) + 1j * spin * (point - complex(x, y)))
    first, second = velocities
    return float(((first - second) * normal.conjugate()).real)
