"""Cases that gave wrong answers once."""

import math

import numpy as np
import pytest

from pymunk_dragon import Arc, Composite, Contact, Dragon, Line, March, Sampled, first_contact, max_speed, simulate
from pymunk_dragon.model.curves import sampled
from pymunk_dragon.physics.callbacks import Motion, refined_contact


def equal(benches, spacing, overhang, width=0.3):
    """A dragon of equal benches."""
    return Dragon(benches=benches, head_spacing=spacing, body_spacing=spacing, overhang=overhang, width=width)


# Benches in line, 0.279 mm apart, until the first ones reach the arc.
STRAIGHT = Line(start=(0, 0), stop=(6.951189646793137, -4.575222436887432))
BEND = Arc(
    centre=(5.750644158985496, -6.399225418265977),
    radius=2.1836429067897307,
    begin_angle=0.9886832665873433,
    sweep=-0.8897022307433354,
)
SHORT = equal(5, 1.3946210480004002, 0.6971710618954001, 0.9890491915732748)
ALIGNED = March(SHORT, Composite([STRAIGHT, BEND]), speed=0.3)


def test_contacts_that_pymunk_reports_of_benches_apart_are_ignored():
    """It reports one 5.6 m deep, and one without depth and normal."""
    run, exact = simulate(ALIGNED), first_contact(ALIGNED)
    assert run.first_contact.benches == exact.benches == (0, 2)
    assert run.first_contact.time == pytest.approx(exact.time, abs=1e-3)
    assert all(event.depth < 1e-3 for event in run.events)
    dragon = equal(5, 1.5647357088711662, 0.7286387054942967, 0.16926126905240985)
    angle = 2.480352102995642
    straight = Line(stop=(8.849066384190579 * math.cos(angle), 8.849066384190579 * math.sin(angle)))
    assert not simulate(March(dragon, straight)).events


def test_contact_by_rounding_only_is_at_the_end_of_the_substep():
    dragon = equal(3, 1.5, 0.5, 1.0)
    poses = np.array([[0.0, 0.0, 0.0], [9.0, 9.0, 0.0], [2.5 + 1e-15, 0.0, 0.0]])
    contact = Contact(time=1.1, raw_time=1.1, benches=(0, 2), point=(1.25, 0.0), normal=(1.0, 0.0), depth=0.0)
    assert refined_contact(dragon, contact, Motion(poses, 0 * poses, 0 * poses), 1.0) == contact


def test_constant_gap_is_no_near_miss():
    bend = Arc(centre=(0, 5), radius=5, begin_angle=-math.pi / 2, sweep=1.0)
    march = March(equal(20, 1.65, 0.82), Composite([Line(start=(-60, 0), stop=(0, 0)), bend]), start_s=40.0)
    for hit in (first_contact(march), first_contact(ALIGNED)):
        assert (hit.status, hit.benches, hit.near_misses) == ("contact", (0, 2), ())


@pytest.mark.thorough
def test_sharp_bends_and_unequal_benches_need_few_evaluations_of_the_curve(monkeypatch):
    calls = []
    solved = sampled._solved
    monkeypatch.setattr(sampled, "_solved", lambda *arguments: calls.append(0) or solved(*arguments))
    points = [(-30, 0), (-20, 0), (-10, 0), (-4, 0)]
    for i in range(6):
        points += [(4 * i, 2.5 * (-1) ** i), (4 * i + 2, 0)]
    spacings = [1.65 * (1 + 0.05 * math.sin(1.7 * i)) for i in range(9)]
    assert first_contact(March(Dragon(benches=10, body_spacing=spacings), Sampled(points))).status == "clear"
    assert len(calls) < 20_000


@pytest.mark.parametrize("radius", [4.5, 2.5])
def test_excess_of_a_long_dragon_of_equal_benches_is_as_documented(radius):
    found = max_speed(equal(100, 1.65, 0.275), radius=radius)
    end = found.curve.end_s if math.isfinite(found.curve.end_s) else found.curve.joints[-1]
    assert 1e-11 < found.excess <= 1 / math.sqrt(1 - (float(found.curve.curvature(end)) * 1.65 / 2) ** 2) - 1
