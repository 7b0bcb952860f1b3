"""The engine where only the head pulls, against solutions that do not use it."""

from __future__ import annotations

import numpy as np
import pytest

from pymunk_dragon import Dragon, March, Run, SpeedTable, UTurn, World, simulate
from pymunk_dragon.errors import ParameterError

# s: first contact of the pulled chain in the exact dynamics, integrated in minimal coordinates.
PULLED_CONTACT = 10.892178138


def contact_error(**settings):
    """Error of the first contact of the reference march without a guide, s."""
    run = simulate(March(), guide="none", until=11.0, **settings)
    assert run.first_contact.benches == (1, 28)
    return run.first_contact.time - PULLED_CONTACT


def test_half_the_substep_leaves_a_quarter_of_the_error_where_only_the_head_pulls():
    errors = [contact_error(substep=substep, iterations=10) for substep in (0.02, 0.01, 0.005)]
    ratios = np.divide(errors[:-1], errors[1:])
    assert ratios == pytest.approx([4, 4], abs=1)


def test_pulled_contact_is_right_to_a_quarter_of_a_millisecond_at_the_default_settings():
    assert abs(contact_error()) < 0.25e-3


def test_order_1_leaves_half_of_the_error():
    errors = [contact_error(substep=substep, order=1) for substep in (0.02, 0.01)]
    assert errors[0] / errors[1] == pytest.approx(2, abs=0.2)


UNEQUAL = Dragon(body_spacing=[1.2, 2.4, 1.5, 2.0, 1.3], width=[0.1, 0.4, 0.2, 0.3, 0.15, 0.25])
TURN = {"start": 0.0, "until": 4.0}

# March, and settings of a run without a guide.
PULLED = {
    "turn of question 4": (March(Dragon(benches=12), UTurn(pitch=1.7, ratio=2.0)), TURN),
    "speeds": (March(Dragon(benches=12), speed=SpeedTable([0, 1, 3], [0.5, 1, 0.7])), {}),
    "unequal benches": (March(UNEQUAL, turns=6), {}),
    "ice": (March(Dragon(benches=12), turns=6), {"drag": 1e-6}),
    "mud": (March(Dragon(benches=12), turns=6), {"drag": 20.0}),
    "two benches": (March(Dragon(benches=2), turns=6), {}),
    "fast": (March(Dragon(benches=12), turns=6, speed=4.0), {"until": 1.0}),
}


def furthest(run, other):
    """Largest distance of a hole at the end of two runs, m."""
    holes = (np.array(run.march.dragon.holes(each.poses[-1])) for each in (run, other))
    return np.linalg.norm(np.subtract(*holes), axis=-1).max()


@pytest.mark.parametrize("name", PULLED)
def test_pulled_benches_are_at_most_a_fifth_as_far_off_as_with_pymunks_own_step(name):
    march, given = PULLED[name]
    given = {"guide": "none", "contacts": "report", "until": 3.0} | given
    stride = 0.02 / march.speed_profile.fastest(given.get("start", 0.0), given["until"])
    fine = simulate(march, **given, substep=stride / 16, iterations=100)
    first, second = (
        simulate(march, **given, substep=stride, iterations=30, order=order) for order in (1, 2)
    )
    assert furthest(second, fine) < furthest(first, fine) / 5


def steps_of(world, until, changes):
    """Play a world to a time, with substeps from `changes`, a mapping from numbers of steps."""
    time, number = world.start, 0
    while time < until - 1e-9:
        world.change(**changes.get(number, {}))
        time += world.substep
        world.prepare(world.march.at(time, handles=2))
        world.space.step(world.substep)
        world.read()
        number += 1
    return time


@pytest.mark.parametrize("substep", [0.005, 0.02])
def test_changes_of_the_substep_keep_the_order(substep):
    march = March(Dragon(benches=12), turns=6)
    options = {"contacts": "report", "iterations": 50, "until": 9.0}
    errors = []
    for scale in (1.0, 0.5):
        world = World(march, "none", substep=0.01 * scale, **options)
        time = steps_of(world, 3.0, {100: {"substep": substep * scale}})
        fine = simulate(
            march, guide="none", substep=time / 2400, iterations=50, until=time, contacts="report"
        )
        errors.append(np.abs(world.poses - fine.poses[-1])[:, :2].max())
    assert errors[0] < 1e-4
    assert errors[0] / errors[1] > 2.5


def test_dancers_let_go_come_back_and_let_go_again():
    """Where a bench is let go, the rules of second order begin with it."""
    march = March(Dragon(benches=20), turns=8)

    def play(order):
        world = World(march, contacts="resolve", order=order, until=20.0)
        poses = []
        for number in range(1400):
            if number in (100, 1000):
                world.release(6)
            if number == 300:
                world.hold()
            world.follow(0.02, 10.0)
            world.space.step(world.substep)
            world.read()
            if number in (299, 999, 1399):
                poses.append(world.poses)
        assert world.free_from == 6
        return poses

    first, second = play(1), play(2)
    for early, late in zip(first, second, strict=True):
        assert np.isfinite(late).all()
        assert np.abs(early - late).max() < 0.02


def test_order_is_one_or_two_and_a_run_file_has_it(tmp_path):
    with pytest.raises(ParameterError):
        simulate(March(Dragon(benches=4)), guide="none", order=3)
    for order in (1, 2):
        run = simulate(March(Dragon(benches=4)), guide="none", order=order, until=0.5)
        run.save(tmp_path / "run.npz")
        loaded = Run.load(tmp_path / "run.npz")
        assert loaded.settings.order == order
        again = simulate(
            loaded.march, guide=loaded.guide, settings=loaded.settings, until=0.5, start=run.start
        )
        assert again == loaded
