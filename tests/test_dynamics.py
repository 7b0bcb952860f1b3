"""Exact dynamics: the pulled chain and the forces of guided marches."""

import json
import math
from importlib import import_module
from itertools import pairwise

import numpy as np
import pytest
from conftest import refusal
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipk

from pymunk_dragon import (
    Composite,
    Curve,
    Dragon,
    Film,
    Line,
    March,
    MissingExtraError,
    Reversed,
    Run,
    Section,
    SpeedTable,
    Spiral,
    UnreachableError,
    UTurn,
    joint_forces,
    pull,
    separation,
    simulate,
)
from pymunk_dragon._arrays import as_complex, as_vectors
from pymunk_dragon.collision.sat import deepest_overlap
from pymunk_dragon.drawing.figures import figure
from pymunk_dragon.drawing.film.layout import _model
from pymunk_dragon.drawing.film.take import checked_sources, takes_of_film
from pymunk_dragon.dynamics.equations import PulledChain
from pymunk_dragon.dynamics.kinematics import cuts, handle_motion
from pymunk_dragon.dynamics.leader import Leader
from pymunk_dragon.physics import Rails
from pymunk_dragon.player.data import player_data
from pymunk_dragon.reports import document, summarize

# m/s^2: a hole that accelerates upwards by this has a chain that swings as in this gravity.
GRAVITY = 9.81


@pytest.fixture(scope="module")
def pulled():
    """The reference march, pulled by its head until after the first contact."""
    return pull(March(), until=11)


def chain_of(count, drag_rate=0.0, seed=0):
    """A chain of unequal benches: its sizes, and its equations."""
    random = np.random.default_rng(seed)
    sizes = random.uniform(0.5, 3.0, (3, count))
    return sizes, PulledChain(*sizes, drag_rate)


def dense_rates(sizes, drag_rate, state, lead):
    """Rates of change from Lagrange's equations in the angles, with a dense mass matrix.

    A centre is at h - sum of d_j u_j over benches j before, - d_i / 2 u_i. With these factors in
    the matrix B, kinetic energy and generalised forces follow from v = V - i B diag(u) w.
    """
    spacings, masses, moments = sizes
    angles, spins = np.split(np.asarray(state), 2)
    count = angles.size
    reach = np.tril(np.tile(spacings, (count, 1)), -1) + np.diag(spacings / 2)
    along = np.exp(1j * angles)
    jacobian = -1j * reach * along
    weighted = jacobian.conj().T * masses
    mass = (weighted @ jacobian).real + np.diag(moments)
    # v' + c v = (lead) + J (w' + c w) + (sum of d_j w_j^2 u_j).
    rest = lead + (reach * along) @ spins**2
    decayed = np.linalg.solve(mass, -(weighted @ rest).real)
    return np.concatenate([spins, decayed - drag_rate * spins])


@pytest.mark.parametrize("count", [1, 2, 7, 60])
def test_rates_are_those_of_lagranges_equations(count):
    for seed in range(5):
        sizes, chain = chain_of(count, 11.5, seed)
        state = np.random.default_rng(seed).normal(size=2 * count)
        expected = dense_rates(sizes, 11.5, state, 3.0 - 2.0j)
        found = chain.rates(state, 3.0 - 2.0j)
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-9 * abs(expected).max())


def test_forces_move_the_centres():
    sizes, chain = chain_of(9)
    _, masses, _ = sizes
    state = np.random.default_rng(3).normal(size=18)
    angles, spins = np.split(state, 2)
    forces = chain.forces(angles, spins, 2.0 + 1.0j)
    changes = np.split(chain.rates(state, 2.0 + 1.0j), 2)[1]
    # Acceleration of the first centre from its hole.
    along = np.exp(1j * angles[0])
    centre = 2.0 + 1.0j - sizes[0][0] / 2 * (1j * changes[0] - spins[0] ** 2) * along
    assert (forces[0] - forces[1]) / masses[0] == pytest.approx(centre, rel=1e-12)
    # The force in the first hole moves all of them.
    turning = 1j * changes - spins**2
    moved = sizes[0] * turning * np.exp(1j * angles)
    centres = 2.0 + 1.0j - np.cumsum(moved) + moved / 2
    assert forces[0] == pytest.approx((masses * centres).sum(), rel=1e-11)


def test_rod_swings_with_the_elliptic_period():
    spacing, mass, moment = 1.65, 13.2, 5.0
    chain = PulledChain(*np.array([[spacing], [mass], [moment]]), 0.0)
    amplitude = 2.5
    inertia = moment + mass * (spacing / 2) ** 2
    quarter = ellipk(math.sin(amplitude / 2) ** 2)
    quarter *= math.sqrt(inertia / (mass * GRAVITY * spacing / 2))

    # The rear hole hangs down where the bench points up.
    def motion(time, state):
        return chain.rates(state, GRAVITY * 1j)

    begin = [math.pi / 2 + amplitude, 0.0]
    precise = {"rtol": 1e-12, "atol": 1e-12, "method": "DOP853"}
    angle, spin = solve_ivp(motion, (0, 4 * quarter), begin, **precise).y[:, -1]
    assert angle == pytest.approx(begin[0], abs=1e-9)
    assert spin == pytest.approx(0.0, abs=1e-8)
    lowest = solve_ivp(motion, (0, quarter), begin, **precise).y[0, -1]
    assert lowest == pytest.approx(math.pi / 2, abs=1e-9)


def double_pendulum(sizes):
    """Equations of motion of two rods in gravity, by hand from their Lagrangian.

    x and y are the angles from the vertical; the inertias are about the holes.
    """
    (first, second), (m, n), (i, j) = sizes
    a = i + m * first**2 / 4 + n * first**2
    b = j + n * second**2 / 4
    c = n * first * second / 2

    def motion(time, state):
        x, y, p, q = state
        cosine = c * math.cos(x - y)
        sine = c * math.sin(x - y)
        one = -sine * q**2 - GRAVITY * (m / 2 + n) * first * math.sin(x)
        two = sine * p**2 - GRAVITY * n * second / 2 * math.sin(y)
        divisor = a * b - cosine**2
        return [p, q, (b * one - cosine * two) / divisor, (a * two - cosine * one) / divisor]

    return motion


def test_two_benches_are_a_double_pendulum():
    sizes, chain = chain_of(2)
    begin = np.array([2.0, -1.0, 0.5, 0.3])
    precise = {"rtol": 1e-11, "atol": 1e-11}
    other = solve_ivp(double_pendulum(sizes), (0, 5), begin, method="LSODA", **precise)

    def motion(time, state):
        return chain.rates(state, GRAVITY * 1j)

    turned = begin + np.array([math.pi / 2, math.pi / 2, 0, 0])
    own = solve_ivp(motion, (0, 5), turned, method="DOP853", rtol=1e-12, atol=1e-12)
    assert own.y[:2, -1] - math.pi / 2 == pytest.approx(other.y[:2, -1], abs=1e-7)


def test_energy_stays_without_drag():
    sizes, chain = chain_of(8)
    spacings, masses, moments = sizes

    def energy(state):
        angles, spins = np.split(state, 2)
        steps = spacings * 1j * spins * np.exp(1j * angles)
        centres = -np.cumsum(steps) + steps / 2
        return (masses * abs(centres) ** 2 + moments * spins**2).sum() / 2

    begin = np.random.default_rng(1).normal(size=16)
    end = solve_ivp(
        lambda time, state: chain.rates(state, 0j),
        *((0, 3), begin),
        **{"rtol": 1e-12, "atol": 1e-12, "method": "DOP853"},
    ).y[:, -1]
    assert abs(end - begin).max() > 1
    assert energy(end) == pytest.approx(energy(begin), rel=1e-9)


def test_handles_have_the_accelerations_of_their_velocities():
    table = SpeedTable([0, 4, 9], [1.0, 1.6, 0.7])
    march = March(Dragon(benches=30), UTurn(), start_s=-0.7, speed=table)
    times = np.array([0.2, 1.3, 2.7, 3.5, 6.1, 8.3])
    found = handle_motion(march, times, 31)
    step = 1e-4
    ends = [as_complex(march.at(times + side * step).velocities) for side in (-1, 1)]
    expected = (ends[1] - ends[0]) / (2 * step)
    assert found.accelerations == pytest.approx(expected, abs=2e-6)
    assert as_vectors(found.velocities) == pytest.approx(march.at(times).velocities, abs=1e-12)


def test_motion_is_cut_where_a_handle_passes_a_jump_or_the_speed_has_a_corner():
    table = SpeedTable([-1, 2, 30], [1.0, 1.0, 2.0])
    march = March(Dragon(benches=30), UTurn(), start_s=-3.0, speed=table)
    jumps = march.curve.curvature_jumps
    assert jumps == pytest.approx([0.0, *np.cumsum(march.curve.radii * abs(march.curve.sweeps))])
    found = cuts(march, 0.0, 12.0, 3)
    assert (found[0], found[-1]) == (0.0, 12.0)
    assert 2.0 in found
    # 3 m to the turn, whose arcs are 9.08 and 4.54 m long, at 1 m/s and faster.
    handles_s = march.handles_s(found, 3)
    on_jump = np.abs(handles_s[:, :, None] - jumps).min(axis=(1, 2)) < 1e-9
    assert np.flatnonzero(~on_jump).tolist() == [0, found.index(2.0), len(found) - 1]
    passed = (handles_s[0, :, None] < jumps) & (handles_s[-1, :, None] > jumps)
    assert on_jump.sum() == passed.sum() > 3


def test_curves_made_of_curves_have_their_jumps():
    turn = UTurn()
    jumps = np.array(turn.curvature_jumps)
    assert Reversed(turn).curvature_jumps == pytest.approx(-jumps[::-1])
    part = Section(turn, -2.0, 10.0)
    assert part.curvature_jumps == pytest.approx(jumps)
    line = Line(start=turn.point(-2.0) - 5 * turn.tangent(-2.0), stop=turn.point(-2.0))
    path = Composite([line, part])
    assert path.curvature_jumps == pytest.approx([5, *(jumps[jumps < 10] + 7)])
    for jump in path.curvature_jumps:
        sides = path.curvature([jump - 1e-9, jump + 1e-9])
        assert abs(sides[1] - sides[0]) > 0.01


def independent_run(march, until, smooth, precise=1e-10):
    """State (2 M,) of the benches behind the head at `until`, by Lagrange's equations.

    The head's states are computed at each evaluation; between the times `smooth` they are smooth.
    """
    dragon = march.dragon
    sizes = dragon.spacings[1:], dragon.masses[1:], dragon.moments[1:]
    drag_rate = 11.5 * march.speed_profile.fastest(0.0, until)
    states = march.at(0.0)
    state = np.concatenate([states.poses[0, 1:, 2], states.pose_velocities[0, 1:, 2]])
    ends = [0.0, *smooth, until]
    for begin, end in pairwise(ends):

        def motion(time, state, within=(begin + 1e-9, end - 1e-9)):
            held = handle_motion(march, np.clip([time], *within), 2)
            lead = held.accelerations[0, 1] + drag_rate * held.velocities[0, 1]
            return dense_rates(sizes, drag_rate, state, lead)

        state = solve_ivp(motion, (begin, end), state, "DOP853", rtol=precise, atol=precise).y[
            :, -1
        ]
    return state


def test_pull_agrees_with_lagranges_equations_across_jumps_and_corners():
    table = SpeedTable([0, 1.5, 4], [1.0, 1.0, 1.4])
    march = March(Dragon(benches=6), UTurn(), start_s=-2.0, speed=table)

    def rear(time):
        return march.handles_s(time, 2)[0, 1]

    # The head travels 1.5 m in 1.5 s, then at 1 m/s and 0.16 m/s^2 more: it enters the turn at 2 m,
    # and its rear handle later.
    head_enters = 1.5 + (math.sqrt(1 + 2 * 0.16 * 0.5) - 1) / 0.16
    entries = [head_enters, brentq(rear, 4.01, 5, xtol=1e-14)]
    angles, spins = np.split(independent_run(march, 5.0, sorted([1.5, 4.0, *entries])), 2)
    run = pull(march, until=5.0, tolerance=1e-11)
    turned = np.exp(1j * (run.poses[-1, 1:, 2] - angles))
    assert turned == pytest.approx(1, abs=1e-9)
    assert run.pose_velocities[-1, 1:, 2] == pytest.approx(spins, abs=1e-6)
    assert run.poses[:, 0] == pytest.approx(march.at(run.times).poses[:, 0], abs=1e-11)
    front, rear = march.dragon.holes(run.poses)
    assert front[:, 1:] == pytest.approx(rear[:, :-1], abs=1e-12)


def test_contact_of_the_reference_march_is_right_to_ten_nanoseconds(pulled):
    touch = pulled.first_contact
    assert touch.benches == (1, 28)
    # An independent solution.
    assert touch.time == pytest.approx(10.892178138, abs=1e-8)
    finer = pull(March(), until=11, tolerance=1e-11).first_contact
    assert finer.time == pytest.approx(touch.time, abs=1e-8)
    found = separation(*(pulled.march.dragon.outlines(pulled.poses_at([touch.time]))[0, [1, 28]]))
    assert float(found.distance) == pytest.approx(0, abs=1e-12)
    assert touch.time in pulled.times
    assert pulled.times[-1] == 11


def test_benches_touch_nowhere_before_the_first_contact(pulled):
    near = np.array([(i, j) for i in range(60) for j in range(i + 2, 120)])
    times = np.linspace(0, pulled.first_contact.time, 200)[:-1]
    for outlines in pulled.march.dragon.outlines(pulled.poses_at(times)):
        assert deepest_overlap(outlines, near) is None


def drawn_march(random):
    """A march on one of several curves, and settings with which it is pulled."""
    benches = int(random.integers(3, 60))
    sizes = {"body_spacing": random.uniform(1, 2.5, benches - 1).tolist()}
    dragon = Dragon(benches=benches, width=float(random.uniform(0.1, 0.5)), **sizes)
    speed = SpeedTable([-5, 1, 3, 4.5, 9], random.uniform(0.3, 2, 5).tolist())
    if random.random() < 0.5:
        turns = float(random.uniform(5, 12))
        march = March(dragon, Spiral(pitch=0.6), turns=turns, speed=speed)
    else:
        march = March(dragon, UTurn(), start_s=float(random.uniform(-4, 10)), speed=speed)
    free_from = int(random.integers(1, min(benches, 8)))
    return march, {"free_from": free_from, "drag": float(random.choice([0, 0.1, 1, 11.5, 100]))}


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(15))
def test_search_misses_no_overlap_of_a_frame(seed, monkeypatch):
    monkeypatch.setattr(import_module("pymunk_dragon.dynamics.pull"), "_FRAME_STRIDE", 0.01)
    march, settings = drawn_march(np.random.default_rng(seed))
    run = pull(march, until=min(8.0, 0.99 * march.end), tolerance=1e-6, **settings)
    pairs = np.stack(np.triu_indices(march.dragon.benches, 2), axis=-1)
    touch = run.first_contact
    before = run.times < (touch.time - 1e-9 if touch else np.inf)
    for outlines in march.dragon.outlines(run.poses[before]):
        assert deepest_overlap(outlines, pairs) is None


def test_joint_of_the_head_carries_the_drag_of_the_dragon(pulled):
    forces = pulled.joint_forces[:, 0]
    # By an independent solution.
    assert forces[np.abs(pulled.times - 5).argmin()] == pytest.approx(1007.43, abs=0.01)
    assert forces.max() == pytest.approx(1105, abs=0.5)
    assert pulled.times[forces.argmax()] == pytest.approx(1.8, abs=0.06)


def test_on_ice_only_the_tail_swings_out():
    run = pull(March(), until=11.8, drag=0)
    assert run.first_contact.benches == (162, 206)
    assert run.first_contact.time == pytest.approx(11.731, abs=5e-4)
    # The tension m v^2 / l keeps a chain on any curve.
    assert run.drift[:, :100].max() < 0.01


def test_energy_is_balanced():
    march = March(Dragon(benches=40))
    dragon = march.dragon
    sizes = dragon.spacings[1:], dragon.masses[1:], dragon.moments[1:]
    chain = PulledChain(*sizes, 11.5)
    states = march.at(0.0)
    begin = np.concatenate([states.poses[0, 1:, 2], states.pose_velocities[0, 1:, 2]])

    def energies(time, state):
        """Kinetic energy, and the power of the pull."""
        held = handle_motion(march, np.array([time]), 2)
        angles, spins = np.split(state, 2)
        steps = sizes[0] * 1j * spins * np.exp(1j * angles)
        centres = held.velocities[0, 1] - np.cumsum(steps) + steps / 2
        lead = held.accelerations[0, 1] + 11.5 * held.velocities[0, 1]
        force = chain.forces(angles, spins, lead)[0]
        kinetic = (sizes[1] * abs(centres) ** 2 + sizes[2] * spins**2).sum() / 2
        return lead, kinetic, (force.conjugate() * held.velocities[0, 1]).real

    def motion(time, state):
        lead, kinetic, power = energies(time, state[:-1])
        return np.append(chain.rates(state[:-1], lead), power - 2 * 11.5 * kinetic)

    end = solve_ivp(motion, (0, 6), np.append(begin, 0.0), "DOP853", rtol=1e-11, atol=1e-11)
    kinetic = [energies(end.t[k], end.y[:-1, k])[1] for k in (0, -1)]
    assert kinetic[1] - kinetic[0] == pytest.approx(end.y[-1, -1], abs=1e-8)
    run = pull(march, until=6, tolerance=1e-11)
    turned = np.exp(1j * (run.poses[-1, 1:, 2] - end.y[:39, -1]))
    assert turned == pytest.approx(1, abs=1e-9)


@pytest.mark.parametrize("speed", [0.5, 2.0])
def test_drag_is_per_metre_as_in_the_engine(speed):
    march = March(Dragon(benches=40), speed=speed)
    exact = pull(march, until=5 / speed)
    errors = []
    for stride in (0.004, 0.002):
        run = simulate(march, guide="none", until=5 / speed, substep=stride / speed, iterations=60)
        apart = exact.poses_at(run.times) - run.poses
        errors.append(abs(apart[..., :2]).max())
    # The engine is of first order.
    assert errors[1] < 0.55 * errors[0] < 1e-3


def test_positions_converge_in_the_tolerance():
    march = March(Dragon(benches=30), UTurn(), start_s=-2.0)
    best = pull(march, until=12, tolerance=1e-12)
    limits = {1e-4: 3e-3, 1e-6: 1e-5, 1e-9: 5e-9, 1e-11: 5e-11}
    for tolerance, limit in limits.items():
        run = pull(march, until=12, tolerance=tolerance)
        common = np.intersect1d(run.times, best.times)
        assert common.size > 100
        apart = run.poses_at(common) - best.poses_at(common)
        assert abs(apart[..., :2]).max() < limit


class Undeclared(Curve):
    """The U-turn, as a curve that does not say where its curvature jumps."""

    turn = UTurn()
    begin_s, end_s = turn.begin_s, turn.end_s
    point, tangent = turn.point, turn.tangent
    curvature, max_curvature = turn.curvature, turn.max_curvature


def test_jumps_that_a_curve_does_not_declare_are_found_by_the_integrator():
    dragon = Dragon(benches=5)
    runs = [
        pull(March(dragon, curve, start_s=-1.0), until=1.5, tolerance=1e-8)
        for curve in (UTurn(), Undeclared())
    ]
    assert runs[1].poses[-1] == pytest.approx(runs[0].poses[-1], abs=1e-6)


class HeldFront(Rails):
    """Dancers who hold only the first benches."""

    free_from = 20

    def joints(self, bench, body):
        return super().joints(bench, body) if bench < self.free_from else ()

    def update(self, poses, hinge_velocity, anchors, forces):
        super().update(poses, hinge_velocity, anchors, forces)
        forces[self.free_from :] = 0.0


@pytest.mark.parametrize("drag_rate", [0.0, 11.5])
def test_steady_pull_along_a_line_is_interpolated(drag_rate):
    # Accelerations, and what is across the line, are nothing but rounding errors.
    line = Line(stop=(21, 34))
    march = March(Dragon(benches=3), line, start_s=20.0)
    leader = Leader(march, 2, drag_rate, (0.0, 3.0), 1e-9)
    assert leader._points is not None
    assert leader.lead(1.3) == pytest.approx(drag_rate * complex(*line.tangent(20.0)), abs=1e-9)


def test_benches_that_are_let_go_move_as_in_the_engine():
    march = March(Dragon(benches=50))
    exact = pull(march, until=1, free_from=20)
    assert exact.drift[:, :20].max() < 1e-12
    settings = {"guide": HeldFront(), "until": 1, "contacts": "report", "iterations": 60}
    errors = []
    for substep in (0.004, 0.002):
        run = simulate(march, substep=substep, **settings)
        apart = exact.poses_at(run.times) - run.poses
        errors.append(abs(apart[..., :2]).max())
        forces = exact.joint_forces[-1] / run.joint_forces[-1] - 1
        assert abs(forces[15:]).max() < 10 * substep
    assert errors[1] < 0.55 * errors[0] < 1e-3


def test_run_that_begins_with_an_overlap_goes_on():
    run = pull(March(Dragon(benches=16)), start=413, until=413.2)
    assert (run.first_contact.time, run.first_contact.benches) == (413, (0, 8))
    assert run.outcome == "contact"
    assert run.times[-1] == 413.2


def test_run_is_saved(pulled, tmp_path):
    pulled.save(tmp_path / "run.npz")
    run = Run.load(tmp_path / "run.npz")
    assert run == pulled
    assert (run.player, run.guide, run.free_from) == ("exact", "none", 1)


def test_guided_joints_carry_what_the_dancers_leave():
    march = March()
    times = [5, 100, 400]
    # By an independent solution.
    assert joint_forces(march, times)[:, 0] == pytest.approx([0.753, 0.851, 2.376], abs=6e-4)
    unpushed = joint_forces(march, times, push=False)
    assert unpushed[:, 0] == pytest.approx([33.7e3, 33.7e3, 34.0e3], abs=60)
    assert unpushed.shape == (3, 222)


def test_joints_on_a_straight_line_carry_the_drag_of_the_benches_behind():
    march = March(Dragon(benches=5), Line(stop=(40, 0)), start_s=20.0)
    masses = march.dragon.masses
    expected = 11.5 * np.cumsum(masses[:0:-1])[::-1]
    assert joint_forces(march, [1.0], push=False)[0] == pytest.approx(expected)
    assert joint_forces(march, [1.0])[0] == pytest.approx(0, abs=1e-9)
    assert pull(march, until=1).joint_forces[-1] == pytest.approx(expected, rel=1e-6)


def test_wrong_arguments_are_refused():
    march = March(Dragon(benches=4), Line(stop=(40, 0)), start_s=20.0)
    assert refusal(pull, march, until=21).name == "until"
    assert refusal(pull, march, until=-1).name == "until"
    wrong = {"free_from": (0, 4, 1.5), "drag": (-1, math.nan), "tolerance": (0, 1)}
    for name, values in wrong.items():
        for value in values:
            assert refusal(pull, march, until=1, **{name: value}).name == name
    assert refusal(joint_forces, march.dragon, [1]).name == "march"
    assert refusal(joint_forces, march, [1], drag=-1).name == "drag"
    refusal(pull, March(), until=441, start=438, error=UnreachableError)


def test_missing_scipy_is_named(monkeypatch):
    monkeypatch.setattr("pymunk_dragon._extras.is_installed", lambda name: False)
    error = refusal(pull, March(Dragon(benches=3)), until=1, error=MissingExtraError)
    assert "dynamics" in str(error)
    assert "studies" in str(error)


def test_documents_do_not_take_a_pulled_run_for_the_march(pulled):
    summary = summarize(pulled)
    assert summary.run == pulled
    assert summary.near_misses is None
    assert document.headline(summary) == "Benches 1 and 28 touch at 10.892178 s"
    assert "pulled without a guide" in document.subtitle(summary)
    first, *others = document.sections(summary)
    assert "No guide" in first.note
    assert "With all benches on the path: no contact until t = 11 s" in first.note
    names = [name for name, _ in first.tables[""].rows]
    assert not [name for name in names if "substep" in name]
    assert "near-misses" not in [section.key for section in others]
    [drift] = [section for section in others if section.key == "drift"]
    assert "march" in drift.title
    assert len(drift.tables[""].rows) == 2

    clear = pull(pulled.march, until=1)
    assert document.headline(summarize(clear)) == "No contact from 0.000 s to 1.000 s"
    assert str(clear).startswith("no contact until t = 1 s")
    assert "drift" not in str(clear)


def test_pictures_do_not_take_a_pulled_run_for_the_march(pulled):
    assert _model(pulled) == "exact model: only the head is guided"
    assert "from bench 5 on" in _model(pull(pulled.march, until=0.1, free_from=5))
    sources = checked_sources([pulled, pulled.march])
    assert [take.beside for take in takes_of_film(sources, Film())] == [None, None]
    payload, texts = player_data(summarize(pulled))
    assert payload["exact"] is None
    assert texts["exact"] == ""
    assert payload["near_misses"] == []
    assert payload["windows"][0]["begin"] == pulled.first_contact.time

    assert refusal(figure, "drift", pulled).name == "run"
    [axes] = figure("forces", pulled).axes
    drawn = max(line.get_ydata().max() for line in axes.lines)
    before = pulled.times < pulled.first_contact.time
    assert 900 < drawn <= pulled.joint_forces[before].max()


def test_command_solves_a_pulled_dragon_exactly(call, here):
    code, found, _ = call(
        "simulate", *["--guide", "none", "--exact", "--until", "11", "--json", "-o", "run.npz"]
    )
    assert code == 0
    assert json.loads(found)["first_contact"]["benches"] == [1, 28]
    assert Run.load("run.npz").is_pulled
    for wrong in (
        "--exact",
        "--guide none --exact --substep 0.01",
        "--guide none --exact --until 500",
    ):
        code, _, error = call("simulate", *wrong.split())
        assert code == 2
        assert error.count("\n") == 1


def test_run_without_an_end_goes_as_far_as_the_head_can():
    # The head bench follows the spiral until about turn 1.
    run = pull(March(Dragon(benches=4), turns=3))
    assert run.outcome in ("contact", "unreachable")
    last = float(run.times[-1])
    assert not np.isnan(run.march.motion_or_nan(last, 2).handles_s).any()
    assert np.isnan(run.march.motion_or_nan(last + 0.02, 2).handles_s).any()
    line = March(Dragon(benches=4), Line(stop=(40, 0)), start_s=38.0)
    assert pull(line).times[-1] == line.end == 2.0
    assert pull(line).outcome == "clear"


# Another program


def exudyn_centres(march, until, step):
    """Centres of the benches behind the head at the end, by exudyn's rigid bodies and joints.

    The coordinates of all bodies are unknowns, joints are constraints, and the ground is a damper
    for each coordinate.
    """
    exudyn = pytest.importorskip("exudyn", reason="exudyn has no wheels for this platform")
    import exudyn.utilities as parts

    dragon = march.dragon
    times = step * np.arange(round(until / step) + 1)
    hole = march.at(times, handles=2)
    system = exudyn.SystemContainer().AddSystem()
    ground = system.AddNode(parts.NodePointGround())
    fixed = system.AddMarker(parts.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))

    def coordinate(node, number):
        return system.AddMarker(parts.MarkerNodeCoordinate(nodeNumber=node, coordinate=number))

    def at(values, axis):
        return lambda mbs, time, number, offset: float(values[round(time / step), 1, axis])

    begin = hole.positions[0, 1]
    leader = system.AddNode(
        parts.NodePoint2D(referenceCoordinates=begin, initialVelocities=hole.velocities[0, 1])
    )
    system.AddObject(parts.ObjectMassPoint2D(nodeNumber=leader, mass=1.0))
    for axis in (0, 1):
        motion = at(hole.positions - begin, axis), at(hole.velocities, axis)
        system.AddObject(
            parts.ObjectConnectorCoordinate(
                markerNumbers=[fixed, coordinate(leader, axis)],
                offsetUserFunction=motion[0],
                offsetUserFunction_t=motion[1],
            )
        )
    before = system.AddMarker(parts.MarkerNodePosition(nodeNumber=leader))
    start = march.at(0.0)
    nodes = []
    for bench in range(1, dragon.benches):
        mass, moment = dragon.masses[bench], dragon.moments[bench]
        node = system.AddNode(
            parts.NodeRigidBody2D(
                referenceCoordinates=start.poses[0, bench],
                initialVelocities=start.pose_velocities[0, bench],
            )
        )
        body = system.AddObject(parts.ObjectRigidBody2D(nodeNumber=node, mass=mass, inertia=moment))
        for axis, inertia in enumerate((mass, mass, moment)):
            system.AddObject(
                parts.CoordinateSpringDamper(
                    markerNumbers=[fixed, coordinate(node, axis)], damping=11.5 * inertia
                )
            )
        half = dragon.spacings[bench] / 2
        ends = [
            system.AddMarker(parts.MarkerBodyPosition(bodyNumber=body, localPosition=[x, 0, 0]))
            for x in (half, -half)
        ]
        system.AddObject(parts.RevoluteJoint2D(markerNumbers=[before, ends[0]]))
        before = ends[1]
        nodes.append(node)

    system.Assemble()
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.numberOfSteps = len(times) - 1
    settings.timeIntegration.endTime = until
    # The trapezoidal rule.
    settings.timeIntegration.generalizedAlpha.spectralRadius = 1.0
    settings.timeIntegration.newton.relativeTolerance = 1e-10
    settings.solution.file.write = False
    system.SolveDynamic(settings)
    position = exudyn.OutputVariableType.Position
    return np.array([system.GetNodeOutput(node, position)[:2] for node in nodes])


@pytest.mark.thorough
def test_exudyn_moves_twenty_benches_to_the_same_places():
    march = March(Dragon(benches=20))
    exact = pull(march, until=1.0, tolerance=1e-11).poses[-1, 1:, :2]
    coarse, fine = (
        np.abs(exudyn_centres(march, 1.0, step) - exact).max() for step in (0.004, 0.002)
    )
    # exudyn's error falls with the square of its step, and nothing else is left.
    assert fine < 1e-6
    assert coarse / fine == pytest.approx(4, rel=0.1)
