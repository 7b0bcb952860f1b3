"""What the lessons say and print, against formulas, many digits, Shapely, and plain Python."""

from __future__ import annotations

import csv
import math
import re
from pathlib import Path

import mpmath as mp
import numpy as np
import oracle
import pytest
import shapely
from exact_curves import DIGITS, s_turn, u_turn, walked_chain
from lesson_runs import numbers, played

from pymunk_dragon.lessons import LESSONS
from pymunk_dragon.model.dragon import Dragon

K = 0.55 / (2 * math.pi)
MARCH = {"head_spacing": 2.86, "body_spacing": 1.65, "pitch": 0.55, "turns": 16, "speed": 1}
SIZES = {
    "width": "0.3",
    "overhang": "0.275",
    "head_spacing": "2.86",
    "body_spacing": "1.65",
    "pitch": "0.55",
}


def printed(name):
    return played(name).printed.splitlines()


def said(name, part):
    return numbers(LESSONS[name].sections()[part])


def found_in(name, pattern):
    """The numbers in those printed lines in which `pattern` is found."""
    found = [numbers(line) for line in printed(name) if re.search(pattern, line)]
    assert found
    return found


def test_angular_rate_is_the_speed_over_the_root_and_the_speed_is_constant():
    table = found_in("spiral", "^t =")
    assert [row[0] for row in table] == [0, 100, 200, 300, 400]
    for time, r, walking, turning, a_round in table:
        angle = float(oracle.head_angle(time, mp.mpf("0.55"), 16, 1))
        rate = 1 / (K * math.hypot(angle, 1))
        assert r == pytest.approx(K * angle, abs=5.1e-4)
        assert turning == pytest.approx(rate, abs=5.1e-4)
        assert a_round == pytest.approx(2 * math.pi / rate, abs=0.051)
        assert walking == 1


def test_next_handle_is_the_one_in_many_digits_and_its_arc_is_longer():
    positions, _ = oracle.solve(300, **MARCH, benches=2, difference=False)
    (_, arc, r, x, y), *_ = (row for row in found_in("chain", "turns back") if 0 < row[0] < 0.5)
    expected = [float(part) for part in positions[1]]
    assert [x, y] == pytest.approx(expected, abs=5.1e-5)
    assert numbers(played("chain").printed.splitlines()[-1])[-2:] == pytest.approx(
        expected, abs=5.1e-5
    )
    before, after = (oracle.arc_length(mp.hypot(*place) / K, 0.55) for place in positions[:2])
    assert arc == pytest.approx(float(after - before), abs=5.1e-4)
    assert arc - 2.86 == pytest.approx(0.04, abs=0.001)
    # By hand.
    radius = (4.992 + 5.043) / 2
    assert round(2 * radius * math.asin(2.86 / (2 * radius)), 3) == arc == said("chain", "Check")[0]
    assert r == 5.043


@pytest.mark.thorough
def test_speeds_are_those_in_many_digits_and_the_papers():
    _, velocities = oracle.solve(300, **MARCH, benches=223)
    with (Path(__file__).parent / "data" / "table2.csv").open() as file:
        paper = {int(row["handle"]): float(row["300"]) for row in csv.DictReader(file)}
    table = found_in("velocity", "^handle")
    assert [int(handle) for handle, _ in table] == list(paper)
    for handle, speed in table:
        assert speed == pytest.approx(float(mp.hypot(*velocities[int(handle)])), abs=5.1e-7)
        assert math.floor(1000 * speed) / 1000 == paper[int(handle)]
    tail = table[-1][1]
    assert round(tail, 4) in said("velocity", "Answer")
    assert 1000 * (1 - tail) == pytest.approx(3.5, abs=0.05)


def test_speed_of_handle_1_is_the_ratio_of_the_cosines():
    positions, velocities = oracle.solve(300, **MARCH, benches=2)
    (x, y), (u, v) = positions[:2]
    bench = mp.atan2(y - v, x - u)
    angles = [abs(float(mp.degrees(mp.atan2(way[1], way[0]) - bench))) for way in velocities[:2]]
    front, rear, ratio = found_in("velocity", "^head bench")[0]
    assert [front, rear] == pytest.approx(angles, abs=5.1e-5)
    assert front > rear
    speed, front, rear = said("velocity", "Check")[1:4]
    assert speed == ratio == found_in("velocity", "^handle   1")[0][1]
    assert round(math.cos(math.radians(front)) / math.cos(math.radians(rear)), 6) == speed


def test_turn_has_the_length_and_the_angles_of_many_digits_whatever_the_ratio():
    rows = found_in("u-turn", "^radii")
    ratios = [first / second for first, second, *_ in rows]
    assert ratios == pytest.approx([0.5, 1, 1.5, 2, 4], rel=1e-3)
    for ratio, row in zip((0.5, 1, 1.5, 2, 4), rows, strict=True):
        with mp.workdps(DIGITS):
            radii, _, sweeps, _, length = s_turn(mp.mpf("1.7"), mp.mpf("4.5"), mp.mpf(ratio))
            exact = [*radii, *(mp.degrees(abs(sweep)) for sweep in sweeps), length]
        assert row[:2] == pytest.approx([float(part) for part in exact[:2]], abs=5.1e-4)
        assert row[2:4] == pytest.approx([float(part) for part in exact[2:4]], abs=0.051)
        assert row[4] == pytest.approx(float(exact[4]), abs=5.1e-5)
        assert [round(row[2], 1), round(row[4], 2)] == said("u-turn", "Answer")


def test_limit_is_the_one_in_many_digits():
    limit, ratio, speed = found_in("speed-limit", "largest speed")[0]
    time = found_in("speed-limit", "^t =")[0][0]
    with mp.workdps(DIGITS):
        truth = u_turn()
        tiny = mp.mpf("1e-15")
        spacings = Dragon().spacings[:8]
        way = mp.mpf(time) * mp.mpf(speed)
        before, after = (walked_chain(truth, way + sign * tiny, spacings) for sign in (-1, 1))
        ratios = [float((b - a) / (2 * tiny)) for a, b in zip(before, after, strict=True)]
    # Close to a top the ratio hardly depends on time and speed, which are rounded.
    assert ratios[3:8] == pytest.approx([ratio] * 5, abs=1e-4)
    assert max(ratios[:3] + ratios[8:]) < ratio - 0.01
    assert speed == pytest.approx(limit / ratio, abs=1e-4)
    assert [round(ratio, 3), round(speed, 3)] == said("speed-limit", "Answer")[2:4]


def sizes(**changed):
    return {name: mp.mpf(value) for name, value in (SIZES | changed).items()}


def gap(time, pair, **changed):
    """mm, in many digits."""
    with mp.workdps(oracle.DIGITS):
        return float(1000 * oracle.gap(mp.mpf(time), pair, sizes(**changed)))


def contact_time(time, pair, **changed):
    return float(oracle.touching(pair, time, sizes(**changed)))


def two_benches(degrees, aside=1.6, ahead=0.9):
    lying = shapely.box(-1.1, -0.15, 1.1, 0.15)
    turned = shapely.affinity.rotate(lying, degrees, origin=(0, 0))
    return lying, shapely.affinity.translate(turned, aside, ahead)


def shadow_gaps(degrees, aside=1.6, ahead=0.9):
    """On the axes of the lying bench and then of the turned one, in plain Python."""
    found = []
    for angle in (0, 90, degrees, degrees + 90):
        x, y = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        ends = []
        for shape in two_benches(degrees, aside, ahead):
            along = [x * u + y * v for u, v in shape.exterior.coords]
            ends.append((min(along), max(along)))
        (one, two), (three, four) = ends
        found.append(max(three - two, one - four))
    return found


def test_sat_prints_the_widest_shadow_gap_and_it_is_what_parts_the_benches():
    for line in printed("sat"):
        degrees, widest, found = numbers(line)
        first, second = two_benches(degrees)
        assert widest == pytest.approx(max(shadow_gaps(degrees)), abs=5.1e-5)
        if widest > 0:
            assert found == pytest.approx(first.distance(second), abs=5.1e-5)
        else:
            # Moved by as much and a little more it is free in some direction, by a little less in
            # none.
            ways = [(math.cos(math.radians(a)), math.sin(math.radians(a))) for a in range(360)]
            for more, parts in ((1e-4, True), (-1e-4, False)):
                far = more - found
                moved = [shapely.affinity.translate(second, far * x, far * y) for x, y in ways]
                assert any(first.distance(each) > 0 for each in moved) == parts


@pytest.mark.thorough
def test_near_misses_are_those_of_many_digits():
    for line, near in zip(printed("near-miss")[:2], (406.8, 409.8), strict=True):
        time, first, second, shown = numbers(line)
        pair = (int(first), int(second))
        least = min(gap(near + k / 1000, pair) for k in range(0, 100, 4))
        assert shown == pytest.approx(least, abs=5.1e-4)
        assert gap(time, pair) == pytest.approx(least, abs=1e-4)
        assert round(shown, 1) in said("near-miss", "Answer")
    assert (
        numbers(printed("near-miss")[2])[0] == round(contact_time(412.4738, (0, 8)), 3) == 412.474
    )
    assert printed("near-miss")[3].split()[3:] == printed("near-miss")[2].split()[1:]


WIDER = {"width": "0.301"}


@pytest.mark.thorough
def test_window_is_that_of_many_digits():
    begin = contact_time(409.7759, (0, 11), **WIDER)
    end = contact_time(409.8845, (0, 11), **WIDER)
    depth = -min(gap(409.82 + k / 1000, (0, 11), **WIDER) for k in range(20))
    seconds, certified, search, window = (numbers(line) for line in printed("missed-window"))
    assert certified[0] == search[0] == round(begin, 6)
    assert search[1] == round(begin, 5)
    assert window[:2] == [round(end - begin, 3), round(depth, 3)]
    # Bisection stops a microsecond behind it.
    assert seconds[0] == pytest.approx(contact_time(412.4422, (0, 8), **WIDER), abs=2e-6)
    assert {round(begin, 3), *window[:2]} <= set(said("missed-window", "Answer"))


def test_smallest_pitch_and_the_time_of_its_touch_are_those_of_many_digits():
    time, pitch = oracle.grazing((0, 19), 216.338, sizes(pitch="0.45033739"))
    shown = numbers(printed("pitch")[0])
    assert shown == [round(float(pitch), 6), 0, 19, round(float(time), 1)]
    assert round(shown[0], 5) == said("pitch", "Answer")[0]


@pytest.mark.thorough
def test_pitch_of_looks_each_second_is_where_one_of_them_sees_no_gap():
    with mp.workdps(oracle.DIGITS):
        ends = mp.mpf("0.4502"), mp.mpf("0.4503")
        pitch = mp.findroot(
            lambda p: oracle.gap(mp.mpf(216), (0, 19), sizes(pitch=p)), ends, tol=1e-30
        )
    seen, truth = (numbers(line) for line in printed("pitch")[2:])
    assert seen[-2] == truth[-2] == round(float(pitch), 6)
    deepest = min(gap(216.2 + k / 100, (0, 19), pitch=mp.nstr(pitch, 20)) for k in range(15))
    assert truth[-1] == round(deepest, 3)
    assert {round(seen[-2], 5), -truth[-1]} <= set(said("pitch", "Teacher"))


def test_half_the_step_leaves_a_half_or_a_quarter_of_the_error():
    errors = {}
    for line in printed("engine"):
        if found := re.match(r"order (\d) +(\d+) iterations", line):
            errors[found[1], found[2]] = [float(mm) for mm in re.findall(r"([\d.]+) mm", line)]
    assert len(errors) == 8
    for iterations in ("20", "80"):
        for order, share in (("1", 0.5), ("2", 0.25)):
            found = np.array(errors[order, iterations])
            assert np.all(abs(found[1:] / found[:-1] - share) < 0.07)
    # More iterations help the second rule, and the first one hardly.
    assert errors["1", "80"][3] > 0.85 * errors["1", "3"][3]
    assert errors["2", "80"][3] < errors["2", "3"][3] / 20


def test_stone_falls_less_in_steps_by_what_the_sum_says():
    for line in printed("engine"):
        if line.startswith("steps of"):
            step, fallen, missing = numbers(line)[:3]
            assert missing == pytest.approx(9.81 / 2 * step, abs=1e-4)
            assert fallen + missing == pytest.approx(9.81 / 2, abs=2e-4)


IMPULSE = r"step (\d+)   impulse ([\d.]+) N s   (\w+)"


def calls(lines):
    return [
        (int(step), float(impulse), name)
        for step, impulse, name in re.findall(IMPULSE, "\n".join(lines))
    ]


def flying(step):
    """The bench that flies, and its centre in the given step, if it has met nothing."""
    t = 0.02 * (step + 1)
    x, y = -2.4 + 2.5 * t, 1.7 - t
    turned = shapely.affinity.rotate(shapely.box(-1.1, -0.15, 1.1, 0.15), -0.6, use_radians=True)
    return shapely.affinity.translate(turned, x, y), np.array([x, y])


def test_callbacks_come_in_the_order_and_as_often_as_the_lesson_says():
    found = calls(printed("callbacks"))
    (first, *_), *between, (last, _, end) = found
    assert end == "separate"
    pairs = [(step, name) for step in range(first, last) for name in ("pre_solve", "post_solve")]
    assert [(step, name) for step, _, name in between] == pairs
    assert len(pairs) > 2


def test_the_impulse_is_that_of_two_bodies_that_bounce_with_a_quarter_of_their_speed():
    step = calls(printed("callbacks"))[0][0]
    bench, centre = flying(step)
    corner = min(bench.exterior.coords, key=lambda point: point[1])
    lever, other = corner[0] - centre[0], corner[0]
    # The push is upright; benches of 10 kg and 5 kg m² give way to it, and turn.
    impulse = (1 + 0.5 * 0.5) * 1.0 / (2 / 10 + (lever**2 + other**2) / 5)
    found = max(impulse for _, impulse, _ in calls(printed("callbacks")))
    assert found == pytest.approx(impulse, abs=0.0051) == said("callbacks", "Check")[0]


def test_an_error_in_begin_is_lost_and_one_in_simulate_is_raised():
    lines = printed("callbacks")
    assert lines.index("hook:    an error in begin") == 1
    assert "caught:  division by zero" in lines


def forces(lines, name):
    """Printed force by joint."""
    found = re.findall(
        r"joint +(\d+): +([\d.]+) N", "".join(line for line in lines if line.startswith(name))
    )
    return {int(joint): float(force) for joint, force in found}


def test_each_joint_carries_the_drag_of_all_benches_behind_it():
    drag = 10 * (1 - 0.5**0.01) / 0.01
    for joint, force in forces(printed("tension"), "on the ground").items():
        assert force == pytest.approx((24 - joint) * drag, abs=0.051)
    for joint, force in forces(printed("tension"), "with 12 dancers").items():
        alone = sum(1 for bench in range(joint + 1, 25) if bench % 2)
        assert force == pytest.approx(alone * drag, abs=0.051)
    assert set(forces(printed("tension"), "on ice").values()) == {0}
    # A speed that falls to a half in a second falls at the rate ln 2; in a step the engine takes a
    # little less.
    continuous = 10 * math.log(2)
    assert numbers(printed("tension")[0]) == pytest.approx([1, continuous, 0.01, drag], abs=5.1e-4)
    said_drag, _, said_sum = said("tension", "Check")[3:6]
    assert [said_drag, said_sum] == pytest.approx([continuous, 24 * continuous], abs=0.051)
    assert forces(printed("tension"), "on the ground")[0] in said("tension", "Check")
