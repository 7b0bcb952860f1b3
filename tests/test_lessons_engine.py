"""What the lessons about the engine say, held against formulas, Shapely and models of the tests' own."""

from __future__ import annotations

import math
import re
from functools import cache
from itertools import pairwise

import numpy as np
import oracle
import pytest
import shapely
from lesson_runs import numbers, played
from scipy.interpolate import CubicSpline

from pymunk_dragon.lessons import LESSONS


def printed(name):
    return played(name).printed.splitlines()


def row(lines, head):
    """The numbers that follow `head` in the only line that begins with it."""
    (line,) = (line for line in lines if line.startswith(head))
    return numbers(line.removeprefix(head))


def rectangle(x, y, angle, length, width):
    return shapely.affinity.translate(
        shapely.affinity.rotate(shapely.box(-length / 2, -width / 2, length / 2, width / 2), angle, use_radians=True),
        x,
        y,
    )


# unguided

SPACINGS = np.array([2.86] + [1.65] * 79)
# 1/s: the drag at which the engine's dragon is played.
DRAG = 11.5


@cache
def pulled_chain(until, step=0.01):
    """Holes (81, 2) of 80 benches that hang on a head on the spiral and are dragged at, `until` s after the start.

    A pendulum of many links in the angles of its benches, whose joints hold by construction, by Runge and Kutta's
    method. Benches behind the 80th are left out: what is pulled there has not moved at all.
    """
    spacings, masses = SPACINGS[1:], np.ones(79)
    inertia = masses * (2.2**2 + 0.3**2) / 12
    # How far the centre of bench i goes for a turn of bench j, for one of 1 m.
    arms = np.tril(np.tile(spacings, (79, 1)), -1) + np.diag(spacings / 2)
    weights = arms.T @ (masses[:, None] * arms)
    pull = arms.T @ masses
    k = 0.55 / (2 * math.pi)
    start = oracle.angles(0, spacings=SPACINGS.tolist(), pitch=0.55, turns=16, speed=1)
    theta = np.array([float(angle) for angle in start])
    # Outward from the place 8.8 m out; the head walks in, so angles of the spiral fall.
    begin = k * theta[:, None] * np.stack([np.cos(theta), np.sin(theta)], axis=-1)

    def head(t):
        """Hinge of the head, and its velocity and acceleration, by differences."""
        places = []
        for when in (t - 1e-4, t, t + 1e-4):
            length = 0.5 * k * (theta[0] * math.hypot(theta[0], 1) + math.asinh(theta[0])) - when
            angle = math.sqrt(2 * length / k)
            for _ in range(6):
                angle -= (0.5 * k * (angle * math.hypot(angle, 1) + math.asinh(angle)) - length) / (
                    k * math.hypot(angle, 1)
                )
            rear = angle + SPACINGS[0] / (k * angle)
            for _ in range(20):
                front, back = k * angle * np.exp(1j * angle), k * rear * np.exp(1j * rear)
                slope = ((back - front).conjugate() * k * (1 + 1j * rear) * np.exp(1j * rear)).real / abs(back - front)
                rear -= (abs(back - front) - SPACINGS[0]) / slope
            places.append(k * rear * np.exp(1j * rear))
        before, now, after = places
        return now, (after - before) / 2e-4, (after - 2 * now + before) / 1e-8

    def rates(t, state):
        angles, turning = state
        _, velocity, acceleration = head(t)
        ahead = np.exp(1j * angles)
        across = 1j * ahead
        cosines = (ahead[:, None] * ahead.conj()).real
        sines = (ahead[:, None] * ahead.conj()).imag
        matrix = weights * cosines + np.diag(inertia)
        moving = matrix @ turning - pull * (across.conj() * velocity).real
        forces = pull * (across.conj() * acceleration).real - (weights * sines) @ turning**2 - DRAG * moving
        return np.array([turning, np.linalg.solve(matrix, forces)])

    first = begin[1:-1] - begin[2:]
    angles = np.arctan2(first[:, 1], first[:, 0])
    # The dancers let go while they walk: every bench turns as it does on the spiral.
    state = np.array([angles, -1 / np.hypot(*begin[1:-1].T)])
    for number in range(round(until / step)):
        t = number * step
        one = rates(t, state)
        two = rates(t + step / 2, state + step / 2 * one)
        three = rates(t + step / 2, state + step / 2 * two)
        four = rates(t + step, state + step * three)
        state = state + step / 6 * (one + 2 * two + 2 * three + four)
    hinge, _, _ = head(until)
    behind = hinge - np.cumsum(spacings * np.exp(1j * state[0]))
    holes = np.concatenate([[hinge], behind])
    return np.stack([holes.real, holes.imag], axis=-1)


@pytest.mark.thorough
def test_without_dancers_bench_1_meets_bench_28_when_it_does_in_that_pendulum():
    time, first, second = row(printed("unguided"), "without dancers: t =")
    assert (first, second) == (1, 28)
    assert numbers(LESSONS["unguided"].text("answer"))[:3] == [round(time, 1), 1, 28]

    def touching(until):
        holes = pulled_chain(until)
        benches = [
            rectangle(*(front + rear) / 2, math.atan2(*(front - rear)[::-1]), 2.2, 0.3)
            for front, rear in pairwise(holes)
        ]
        tree = shapely.STRtree(benches)
        pairs = tree.query(benches, predicate="intersects").T + 1
        return {(int(i), int(j)) for i, j in pairs if j > i + 1}

    assert touching(round(time - 0.08, 2)) == set()
    assert touching(round(time + 0.08, 2)) == {(1, 28)}


# engine


def drifts():
    """Printed drifts in µm, by number of tries, from long steps to short ones."""
    lines = [line for line in printed("engine") if " tries" in line]
    found = {int(line.split()[0]): [float(d) for d in re.findall(r"([\d.]+) µm", line)] for line in lines}
    assert list(found) == [5, 15, 60, 240]
    return found


def test_each_halving_of_the_steps_leaves_about_a_quarter_of_the_error():
    found = np.array(list(drifts().values()))
    assert np.all(abs(found[:, 1:] / found[:, :-1] - 0.25) < 0.06)


def test_more_tries_help_up_to_sixty():
    found = np.array(list(drifts().values()))
    assert np.all(found[1:3] < found[:2] / 2)
    assert np.all(found[3] > found[2] / 2)
    # Both lines begin at the same point of the picture.
    assert found[3, 0] == pytest.approx(found[2, 0], rel=0.05)


def test_the_groove_keeps_its_part_of_what_would_stop_the_hole():
    # Velocity that an impulse gives to a hole at (1, 1) of a body of 1 kg and 1 kg m²: of the centre, and by turning.
    response = np.eye(2) + np.outer([-1, 1], [-1, 1])
    _, kept = np.linalg.solve(response, [-1, 0])
    (kick,) = re.findall(r"GrooveJoint.*?(-[\d.]+) m/s", played("engine").printed)
    assert float(kick) == pytest.approx(kept, abs=0.0005)
    assert kick in LESSONS["engine"].text("check")


# callbacks

IMPULSE = r"step (\d+)   impulse ([\d.]+) N s   (\w+)"


def calls(lines):
    return [(int(step), float(impulse), name) for step, impulse, name in re.findall(IMPULSE, "\n".join(lines))]


def flying(step):
    """The bench that flies, and where its centre is, in the given step, as long as it has met nothing."""
    t = 0.02 * (step + 1)
    x, y = -2.4 + 2.5 * t, 1.7 - t
    return rectangle(x, y, -0.6, 2.2, 0.3), np.array([x, y])


def test_begin_comes_in_the_first_step_in_which_the_rectangles_overlap():
    lying = rectangle(0, 0, 0, 2.2, 0.3)
    first = next(step for step in range(80) if flying(step)[0].intersects(lying))
    assert calls(printed("callbacks"))[0] == (first, 0, "begin")


def test_callbacks_come_in_the_order_and_as_often_as_the_lesson_says():
    found = calls(printed("callbacks"))
    (first, *_), *between, (last, _, end) = found
    assert end == "separate"
    pairs = [(step, name) for step in range(first, last) for name in ("pre_solve", "post_solve")]
    assert [(step, name) for step, _, name in between] == pairs
    assert len(pairs) > 2


def test_before_post_solve_one_reads_the_impulse_of_the_step_before():
    found = {(step, name): impulse for step, impulse, name in calls(printed("callbacks"))}
    for (step, name), impulse in found.items():
        if name == "pre_solve":
            assert impulse == found.get((step - 1, "post_solve"), 0)


def test_the_impulse_is_that_of_two_bodies_that_bounce_with_a_quarter_of_their_speed():
    step = calls(printed("callbacks"))[0][0]
    bench, centre = flying(step)
    corner = min(bench.exterior.coords, key=lambda point: point[1])
    lever, other = corner[0] - centre[0], corner[0]
    # The push is upright; benches of 10 kg and 5 kg m² give way to it, and turn.
    impulse = (1 + 0.5 * 0.5) * 1.0 / (2 / 10 + (lever**2 + other**2) / 5)
    found = max(impulse for _, impulse, _ in calls(printed("callbacks")))
    assert found == pytest.approx(impulse, rel=1e-3)
    assert numbers(LESSONS["callbacks"].text("check"))[0] == found


def test_an_error_in_begin_is_lost_and_one_in_simulate_is_raised():
    lines = printed("callbacks")
    assert lines.index("hook:    an error in begin") == 1
    assert "caught:  division by zero" in lines


# tension


def forces(lines, name):
    """Printed force by joint."""
    return {
        int(joint): float(force)
        for joint, force in re.findall(
            r"joint +(\d+): +([\d.]+) N", "".join(line for line in lines if line.startswith(name))
        )
    }


def test_each_joint_carries_the_drag_of_all_benches_behind_it():
    drag = 10 * (1 - 0.5**0.01) / 0.01
    for joint, force in forces(printed("tension"), "on the ground").items():
        assert force == pytest.approx((24 - joint) * drag, abs=0.001)
    for joint, force in forces(printed("tension"), "with 12 dancers").items():
        alone = sum(1 for bench in range(joint + 1, 25) if bench % 2)
        assert force == pytest.approx(alone * drag, abs=0.001)
    assert set(forces(printed("tension"), "on ice").values()) == {0}
    assert numbers(LESSONS["tension"].text("check"))[0] == forces(printed("tension"), "on the ground")[0]


# robot

LINKS = np.array([0.14] + [0.10] * 6 + [0.13] * 5 + [0.16] * 4)
WIDTHS = np.array([0.05] * 7 + [0.06] * 5 + [0.07] * 4)
POINTS = [
    (-1.9, 0), (-1.6, 0), (-1.3, 0), (-1, 0), (-0.75, 0.08), (-0.5, 0.25), (-0.25, 0.3), (-0.03, 0.15), (0.1, -0.1),
    (0.32, -0.25), (0.55, -0.15), (0.6, 0.1), (0.42, 0.28), (0.2, 0.22), (0.05, 0.05), (-0.1, -0.1),
]  # fmt: skip


class Way:
    """The curve through points as a line of very many short straight pieces, and the arm on it by looking along it."""

    def __init__(self, points):
        knots = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        self.line = CubicSpline(knots, points)(np.linspace(0, knots[-1], 200_001))
        self.ways = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(self.line, axis=0).T))])
        self.start = 0.0
        for link in LINKS[::-1]:
            self.start = self.next(self.start, link, +1)

    def at(self, way):
        return np.array([np.interp(way, self.ways, column) for column in self.line.T])

    def next(self, way, link, side):
        """The nearest place on the line before (-1) or behind (+1) `way` that is a link's length away."""
        here = self.at(way)
        begin = np.searchsorted(self.ways, way)
        piece = self.line[begin:] if side > 0 else self.line[begin - 1 :: -1]
        places = self.ways[begin:] if side > 0 else self.ways[begin - 1 :: -1]
        far = np.hypot(*(piece - here).T)
        beyond = int(np.argmax(far >= link))
        share = (link - far[beyond - 1]) / (far[beyond] - far[beyond - 1])
        return places[beyond - 1] + share * (places[beyond] - places[beyond - 1])

    def joints(self, time):
        ways = [self.start + 0.2 * time]
        for link in LINKS:
            ways.append(self.next(ways[-1], link, -1))
        return np.array([self.at(way) for way in ways])

    def closest(self, time):
        """Smallest gap between two links that are not neighbours, and which."""
        joints = self.joints(time)
        links = [
            rectangle(*(front + rear) / 2, math.atan2(*(front - rear)[::-1]), link + 0.04, width)
            for front, rear, link, width in zip(joints, joints[1:], LINKS, WIDTHS, strict=False)
        ]
        pairs = [(links[i].distance(links[j]), (i, j)) for i in range(16) for j in range(i + 2, 16)]
        return min(pairs)


@pytest.fixture(scope="module")
def way():
    return Way(np.array(POINTS))


@pytest.mark.thorough
def test_the_arm_meets_itself_when_its_rectangles_do(way):
    gap, pair = way.closest(8.60)
    assert gap > 0
    apart, touching = 8.60, 8.70
    while touching - apart > 1e-5:
        middle = (apart + touching) / 2
        apart, touching = (middle, touching) if way.closest(middle)[0] > 0 else (apart, middle)
    assert all(way.closest(time)[0] > 0 for time in np.arange(0, 8.6, 0.2))
    for head, tolerance in [("exact    t =", 1e-4), ("engine   t =", 2e-3)]:
        time, *links = row(printed("robot"), head)
        assert time == pytest.approx(touching, abs=tolerance)
        assert tuple(links) == pair == (0, 13)
    assert f"after {touching:.3f} s the tip runs into link 13" in LESSONS["robot"].text("answer")


@pytest.mark.thorough
def test_the_speeds_of_the_joints_are_how_far_they_get(way):
    lines = printed("robot")
    for head in ("fastest", "slowest"):
        joint, time, speed = row(lines, f"{head}  joint")
        before, after = (way.joints(time + side * 0.01)[int(joint)] for side in (-1, 1))
        assert np.hypot(*(after - before)) / 0.02 == pytest.approx(speed, abs=0.0006)
    # Nobody is faster or slower than that, but for what happens between two looks.
    moments = np.array([[way.joints(time + side * 0.01) for side in (-1, 1)] for time in np.arange(0.1, 8.6, 0.25)])
    speeds = np.hypot(*np.moveaxis(moments[:, 1] - moments[:, 0], -1, 0)) / 0.02
    assert np.abs(speeds / 0.2 - 1).max() == pytest.approx(0.03, abs=0.005)
    assert "some 3 %" in LESSONS["robot"].text("answer")
