"""Forces in the joints of an engine's run, against the equations of motion of the exact model."""

from __future__ import annotations

import numpy as np
import pytest

from pymunk_dragon import (
    Dragon,
    Line,
    March,
    PathGuide,
    Spiral,
    World,
    joint_forces,
    pull,
    simulate,
)

# s: step of the central differences whose error is a rounding error and 1e-12 of the force.
_STEP = 1e-3

DRAG = 11.5


def exact_forces(march, time):
    """Forces (N - 1,) in the joints of a guided march: dense equations of motion, all at once.

    Unknowns are two components of the force in each joint and the force of each rail.
    """
    states = march.at(time + _STEP * np.arange(-2, 3))
    rates = states.pose_velocities
    accelerations = (rates[0] - 8 * rates[1] + 8 * rates[3] - rates[4]) / (12 * _STEP)
    poses, velocities = states.poses[2], rates[2]
    dragon = march.dragon
    masses = 20 * dragon.lengths * dragon.widths
    tangents = march.curve.tangent(states.handles_s[2, 2:])

    count = dragon.benches - 1
    matrix, wanted = np.zeros((3 * count, 3 * count)), np.zeros(3 * count)
    for row in range(count):
        bench = row + 1
        angle, half = poses[bench, 2], dragon.spacings[bench] / 2
        along = np.array([np.cos(angle), np.sin(angle)])
        across = np.array([-along[1], along[0]])
        normal = np.array([-tangents[row, 1], tangents[row, 0]])
        first = 3 * row
        matrix[first : first + 2, first : first + 2] = np.eye(2)
        matrix[first + 2, first : first + 2] = half * across
        matrix[first : first + 2, first + 2] = normal
        matrix[first + 2, first + 2] = -half * across @ normal
        if row + 1 < count:
            matrix[first : first + 2, first + 3 : first + 5] = -np.eye(2)
            matrix[first + 2, first + 3 : first + 5] = half * across

        # The dancers' push is the change of the speed along the bench, and the drag on it. Their
        # torque is all that the bench needs.
        velocity, spin = velocities[bench, :2], velocities[bench, 2]
        acceleration = accelerations[bench, :2]
        push = acceleration @ along + spin * velocity @ across + DRAG * velocity @ along
        force = acceleration + DRAG * velocity - push * along
        wanted[first : first + 2] = masses[bench] * force
    solved = np.linalg.solve(matrix, wanted).reshape(-1, 3)
    return np.hypot(*solved.T[:2])


@pytest.mark.parametrize(("time", "first"), [(5.0, 0.753), (100.0, 0.851), (400.0, 2.376)])
def test_guided_joints_have_the_forces_of_the_exact_motion(time, first):
    march = March()
    exact = exact_forces(march, time)
    assert exact[0] == pytest.approx(first, abs=5e-4)
    run = simulate(march, start=time - 1, until=time)
    assert run.times[-1] == pytest.approx(time)
    np.testing.assert_allclose(run.joint_forces[-1], exact, atol=1e-3 * exact.max())
    # The first frame has them too.
    earlier = exact_forces(march, time - 1)
    np.testing.assert_allclose(run.joint_forces[0], earlier, atol=1e-3 * earlier.max())


def test_frame_of_the_contact_has_the_forces_before_the_impact():
    march = March()
    guided = simulate(march, start=411.0)
    pulled = simulate(march, guide="none", until=11.0)
    for run, exact in (
        (guided, joint_forces(march, guided.times[-1:])[0]),
        (pulled, pull(march, until=pulled.times[-1]).joint_forces[-1]),
    ):
        assert run.first_contact.time == run.times[-1]
        np.testing.assert_allclose(run.joint_forces[-1], exact, atol=0.01 * exact.max())


def test_guided_unequal_benches_have_them_too_where_contacts_are_resolved():
    dragon = Dragon(body_spacing=[1.2, 2.4, 1.5, 1.3], width=[0.1, 0.4, 0.2, 0.3, 0.15])
    march = March(dragon, Spiral(pitch=0.55), turns=6)
    exact = exact_forces(march, 2.0)
    run = simulate(march, until=2.0, contacts="resolve")
    np.testing.assert_allclose(run.joint_forces[-1], exact, atol=1e-3 * exact.max())


@pytest.mark.parametrize(("time", "force"), [(1.8, 1105.2), (5.0, 1007.43)])
def test_head_that_only_pulls_has_the_tension_of_the_exact_dynamics(time, force):
    """The figures are those of an integration of the exact dynamics."""
    run = simulate(March(), guide="none", until=time)
    assert run.joint_forces[-1, 0] == pytest.approx(force, rel=1e-3)


def test_forces_of_a_guide_that_does_not_know_them_come_from_impulses():
    """On a line each joint carries the drag and the wind on all benches behind it."""

    class Wind(PathGuide):
        free_from = 1

        def update(self, poses, hinge_velocity, anchors, forces):
            forces[:, 0] = -10.0

    march = March(Dragon(benches=6), Line(stop=(100, 0)), start_s=20.0)
    run = simulate(march, guide=Wind(), until=3.0)
    dragon = march.dragon
    drags = DRAG * 20 * dragon.lengths * dragon.widths
    tensions = np.cumsum((drags + 10.0)[:0:-1])[::-1]
    np.testing.assert_allclose(run.joint_forces[-1], tensions, rtol=1e-3)


def test_forces_go_over_to_impulses_where_contacts_act():
    """Before its first contact a dragon needs few newtons, and in a pile many more."""
    world = World(March(), contacts="resolve", start=411.5, until=420.0)
    forces = []
    for _ in range(500):
        world.follow(1 / 300, 20.0)
        world.space.step(world.substep)
        world.read()
        forces.append(world.joint_forces.max())
    assert max(forces[:150]) < 10
    assert max(forces[250:]) > 50
