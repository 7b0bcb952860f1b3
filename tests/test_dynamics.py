"""Exact dynamics: the pulled chain and the forces of guided marches."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from pymunk_dragon import Composite, Dragon, Line, March, Reversed, Section, SpeedTable, UTurn
from pymunk_dragon._arrays import as_complex, as_vectors
from pymunk_dragon.dynamics.equations import PulledChain
from pymunk_dragon.dynamics.kinematics import cuts, handle_motion

# m/s^2: a hole that accelerates upwards by this has a chain that swings as in this gravity.
GRAVITY = 9.81


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
